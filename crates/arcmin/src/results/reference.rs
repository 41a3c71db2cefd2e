//! Reference of all results, from their declarations.

use super::Quantity;

/// Results of an analysis, for the reference.
#[derive(Debug, Clone)]
pub struct Declared {
    /// Name of the command.
    pub analysis: &'static str,
    /// Purpose of the command in one sentence.
    pub about: &'static str,
    /// Tables that it writes.
    pub tables: Vec<DeclaredTable>,
    /// Figures of its `summary.json`.
    pub summary: Vec<Quantity>,
}

/// A table and its columns.
#[derive(Debug, Clone)]
pub struct DeclaredTable {
    /// File name without ending.
    pub name: &'static str,
    /// Meaning of a row.
    pub what: &'static str,
    /// Columns in the order of the file.
    pub columns: Vec<Quantity>,
}

impl<R> From<super::TableOf<R>> for DeclaredTable {
    fn from(table: super::TableOf<R>) -> DeclaredTable {
        DeclaredTable { name: table.name, what: table.what, columns: table.quantities() }
    }
}

/// The reference in Markdown: one section per analysis, one table per file.
pub fn markdown(all: &[Declared]) -> String {
    let mut text =
        "# Results\n\nThis chapter lists the results of every analysis: the columns of its tables and the keys of its \
        `summary.json`. A dot in a key is nesting. `arcmin keys --results` prints this chapter.\n\n"
            .to_owned();
    for declared in all {
        text.push_str(&format!("## `arcmin {}`\n\n{}.\n\n", declared.analysis, declared.about));
        for table in &declared.tables {
            text.push_str(&format!("### `{}.csv`\n\n{}.\n\n", table.name, table.what.trim_end_matches('.')));
            rows(&mut text, "column", &table.columns);
        }
        text.push_str("### `summary.json`\n\n");
        rows(&mut text, "key", &declared.summary);
    }
    text
}

fn rows(text: &mut String, head: &str, quantities: &[Quantity]) {
    text.push_str(&format!("| {head} | unit | meaning |\n|---|---|---|\n"));
    for quantity in quantities {
        let what = quantity.what.replace('|', "\\|");
        text.push_str(&format!("| `{}` | {} | {what} |\n", quantity.key, quantity.unit()));
    }
    text.push('\n');
}
