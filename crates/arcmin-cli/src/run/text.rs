//! Text for the terminal.

use std::io::{IsTerminal, Write};

use arcmin::analyses::{TextBlock, TextTable};
use arcmin::report::is_hidden;
use comfy_table::{CellAlignment, presets};

use crate::failure::Failure;

/// Prints a line. A closed pipe (`arcmin … | head`) is not an error; a full disk is.
pub fn print_line(line: &str) -> Result<(), Failure> {
    print_bytes(format!("{}\n", visible(line)).as_bytes())
}

/// Prints findings, with coloured severity on a terminal if wanted.
pub fn print_findings(text: &str) -> Result<(), Failure> {
    let text = visible(text);
    let needs_colour = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let text = if needs_colour && std::io::stdout().is_terminal() { coloured(&text) } else { text };
    print_bytes(format!("{text}\n").as_bytes())
}

fn coloured(text: &str) -> String {
    let line = |line: &str| {
        let colours = [("ERROR", "1;31"), ("WARNING", "1;33"), ("ok", "32")];
        match colours.iter().find(|(word, _)| line.split(' ').next() == Some(word)) {
            Some((word, code)) => format!("\u{1b}[{code}m{word}\u{1b}[0m{}", &line[word.len()..]),
            None => line.to_owned(),
        }
    };
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

/// Prints bytes as they are.
pub fn print_bytes(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(cause) if cause.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Write { path: "standard output".into(), cause })
        }
        _ => Ok(()),
    }
}

/// Removes control characters, which names in a file could send to the terminal.
pub fn visible(text: &str) -> String {
    text.chars().map(|c| if is_hidden(c) && c != '\n' && c != '\t' { '\u{fffd}' } else { c }).collect()
}

/// Lines and tables as a single text.
pub fn terminal_text(blocks: &[TextBlock]) -> String {
    let one = |block: &TextBlock| match block {
        TextBlock::Line(line) => line.clone(),
        TextBlock::Table(table) => table_text(table),
    };
    blocks.iter().map(one).collect::<Vec<_>>().join("\n")
}

fn table_text(content: &TextTable) -> String {
    let mut table = comfy_table::Table::new();
    table.load_style(presets::NOTHING);
    if !content.header.is_empty() {
        table.set_header(&content.header);
    }
    for row in &content.rows {
        table.add_row(row);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.lines().map(|line| line.trim_end().to_owned()).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_severity_is_coloured() {
        assert_eq!(
            coloured("ERROR    undercut: ERROR\n           why: ok\nok       fine"),
            "\u{1b}[1;31mERROR\u{1b}[0m    undercut: ERROR\n           why: ok\n\u{1b}[32mok\u{1b}[0m       fine"
        );
    }

    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        assert_eq!(visible("a\u{1b}[31mb\nc\td\u{7}"), "a\u{fffd}[31mb\nc\td\u{fffd}");
    }
}
