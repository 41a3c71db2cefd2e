//! The page as HTML text.

use std::fmt::Write;

use serde::Serialize;

use super::plot::{Tone, Width};
use super::text::{capitalised, escaped, push_escaped, push_inline, slug};
use super::{Block, Page, Reference, Section, Shares, Table, Verdict};
use crate::scene;

const STYLE: &[&str] = &[include_str!("assets/page.css"), include_str!("assets/figures.css")];
/// In this order: later files use definitions of earlier ones.
const SCRIPT: &[&str] = &[
    include_str!("assets/axes.js"),
    include_str!("assets/download.js"),
    include_str!("assets/plot.js"),
    include_str!("assets/reading.js"),
    include_str!("assets/heatmap.js"),
    include_str!("assets/mechanism.js"),
    include_str!("assets/solids.js"),
    include_str!("assets/mesh.js"),
    include_str!("assets/arm.js"),
    include_str!("assets/samples.js"),
    include_str!("assets/page.js"),
];
/// Names of the scripts of a scene that the scripts above use.
const OF_SCENE: &str = include_str!("assets/solid.js");
/// The page loads no resources: it is self-contained.
const CONTENT_POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; \
     script-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'";
/// Longer code is folded initially.
const CODE_LINES_SHOWN: usize = 12;

pub(super) fn render(page: &Page) -> String {
    let keys: Vec<&str> = page
        .sections
        .iter()
        .flat_map(|section| &section.blocks)
        .filter_map(|block| match block {
            Block::References(references) => Some(references),
            _ => None,
        })
        .flatten()
        .map(|reference| reference.key.as_str())
        .collect();
    let mut writer =
        Writer { out: String::with_capacity(1 << 18), reference_keys: keys, figures: 0, tables: 0 };
    writer.page(page);
    writer.out
}

struct Writer<'a> {
    out: String,
    reference_keys: Vec<&'a str>,
    figures: usize,
    tables: usize,
}

/// Largest number of columns of a table side by side on a phone.
const MANY_COLUMNS: usize = 4;
/// Largest number of rows of a wide table that are shown as blocks there.
const FEW_ROWS: usize = 24;

impl Writer<'_> {
    fn page(&mut self, page: &Page) {
        let title = escaped(&format!("{} – {}", page.title, page.subtitle));
        let _ = writeln!(
            self.out,
            "<!doctype html>\n<html lang=\"en\" data-theme=\"auto\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{CONTENT_POLICY}\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"generator\" content=\"arcmin {version}\">\n<title>{title}</title>\n<style>",
            version = escaped(&page.provenance.version),
        );
        for css in STYLE {
            self.out.push_str(css);
        }
        self.out.push_str("</style>\n<script>document.documentElement.classList.add('starting')</script>\n</head>\n<body>\n<a class=\"skip\" href=\"#main\">Skip to content</a>\n");
        let _ = writeln!(
            self.out,
            "<header class=\"masthead\"><div><h1>{}</h1><p>{}</p></div><div class=\"controls\">\
             <button type=\"button\" id=\"theme\" aria-label=\"Switch between light and dark\">Dark</button>\
             <button type=\"button\" id=\"print\">Print</button></div></header>\n<div class=\"layout\">",
            escaped(&page.title),
            escaped(&page.subtitle)
        );
        self.contents(&page.sections);
        self.out.push_str("<main id=\"main\">\n");
        self.verdict(&page.verdict);
        for section in &page.sections {
            self.section(section);
        }
        self.provenance(page);
        self.out.push_str("</main>\n</div>\n");
        let mut blocks = page.sections.iter().flat_map(|section| &section.blocks);
        let has_solids = blocks.any(|block| matches!(block, Block::Solids(_) | Block::Arm(_)));
        if has_solids {
            let _ = writeln!(self.out, "<script>\n{}</script>", scene::three());
        }
        self.out.push_str("<script>\n(() => {\n'use strict';\n");
        if has_solids {
            // In a separate scope, since both use the same short names.
            self.out.push_str("const Solid = (() => {\n");
            for script in [scene::MOTION, scene::SPACE, scene::VIEW, scene::KINEMATICS, scene::ARM_VIEW] {
                self.out.push_str(script);
            }
            self.out.push_str(OF_SCENE);
            self.out.push_str("})();\n");
        }
        for script in SCRIPT {
            self.out.push_str(script);
        }
        self.out.push_str("})();\n</script>\n</body>\n</html>\n");
    }

    fn contents(&mut self, sections: &[Section]) {
        self.out.push_str(
            "<nav class=\"contents\" aria-label=\"Contents\"><ol><li><a href=\"#verdict\">Verdict</a></li>",
        );
        for section in sections {
            let _ = write!(
                self.out,
                "<li><a href=\"#{}\">{}</a></li>",
                slug(&section.id),
                escaped(&section.title)
            );
        }
        self.out.push_str("</ol></nav>\n");
    }

    fn verdict(&mut self, verdict: &Verdict) {
        let _ = write!(
            self.out,
            "<section id=\"verdict\" class=\"verdict\" aria-labelledby=\"verdict-head\">\
             <h2 id=\"verdict-head\" class=\"tone-{}\">",
            tone_name(verdict.tone)
        );
        self.inline(&verdict.headline);
        self.out.push_str("</h2>\n");
        if !verdict.figures.is_empty() {
            self.out.push_str("<div class=\"key-figures\">\n");
        }
        for figure in &verdict.figures {
            let _ = write!(
                self.out,
                "<div class=\"key-figure tone-{}\"><h3>{}</h3><p class=\"value\"><b>{}</b> <span>{}</span></p><p>",
                tone_name(figure.tone),
                escaped(&capitalised(&figure.label)),
                escaped(&figure.value),
                escaped(&figure.unit)
            );
            self.inline(&figure.note);
            self.out.push_str("</p></div>\n");
        }
        if !verdict.figures.is_empty() {
            self.out.push_str("</div>\n");
        }
        if !verdict.answers.is_empty() {
            self.out.push_str("<dl class=\"answers\">\n");
        }
        for (question, answer) in &verdict.answers {
            let _ = write!(self.out, "<div><dt>{}</dt><dd>", escaped(question));
            self.inline(&sentence(answer));
            self.out.push_str("</dd></div>\n");
        }
        if !verdict.answers.is_empty() {
            self.out.push_str("</dl>\n");
        }
        if !verdict.summary.is_empty() {
            let _ = writeln!(
                self.out,
                "<div class=\"summary\"><button type=\"button\" id=\"copy-summary\">Copy summary</button>\
                 <span id=\"copy-done\" role=\"status\"></span>\
                 <details><summary>Show the text</summary><pre id=\"summary-text\">{}</pre></details></div>",
                escaped(&verdict.summary)
            );
        }
        self.out.push_str("</section>\n");
    }

    fn section(&mut self, section: &Section) {
        let id = slug(&section.id);
        let _ = writeln!(
            self.out,
            "<section id=\"{id}\" aria-labelledby=\"{id}-head\"><h2 id=\"{id}-head\">{}</h2>\n<div class=\"blocks\">",
            escaped(&section.title)
        );
        // A half-width figure without a neighbour is drawn with full width.
        let mut alone = vec![false; section.blocks.len()];
        let mut start = 0;
        for run in section.blocks.chunk_by(|a, b| is_half(a) == is_half(b)) {
            let end = start + run.len();
            alone[end - 1] =
                is_half(&run[0]) && run.len() % 2 == 1 && matches!(run[run.len() - 1], Block::Plot(_));
            start = end;
        }
        for (block, alone) in section.blocks.iter().zip(alone) {
            match block {
                Block::Plot(plot) if alone => {
                    self.figure("plot", &plot.title, &plot.note, Width::Full, plot);
                }
                block => self.block(block),
            }
        }
        self.out.push_str("</div>\n</section>\n");
    }

    fn block(&mut self, block: &Block) {
        match block {
            Block::Text(text) => {
                self.out.push_str("<p class=\"text\">");
                self.inline(text);
                self.out.push_str("</p>\n");
            }
            Block::Heading(text) => {
                let _ = writeln!(self.out, "<h3 class=\"heading\">{}</h3>", escaped(text));
            }
            Block::Note(tone, text) => {
                let _ = write!(self.out, "<p class=\"note tone-{}\">", tone_name(*tone));
                self.inline(text);
                self.out.push_str("</p>\n");
            }
            Block::Table(table) => self.table(table),
            Block::Shares(shares) => self.shares(shares),
            Block::Plot(plot) => {
                self.figure("plot", &plot.title, &plot.caption(), plot.width, plot);
            }
            Block::HeatMap(map) => self.figure("heatmap", &map.title, &map.caption(), map.width, map),
            Block::Mechanism(drawing) => {
                self.figure("mechanism", &drawing.title, &drawing.note, Width::Full, drawing);
            }
            Block::Solids(solids) => {
                self.figure("solids", &solids.title, &solids.note, Width::Full, solids);
            }
            Block::Mesh(mesh) => {
                self.figure("mesh", &mesh.title, &mesh.note, Width::Full, mesh);
            }
            Block::Arm(arm) => self.figure("arm", &arm.title, &arm.note, Width::Full, arm),
            Block::Samples(samples) => {
                self.figure("samples", &samples.title, &samples.note, Width::Full, samples);
            }
            Block::Code { title, text } => self.code(title, text),
            Block::References(references) => self.references(references),
        }
    }

    /// A place of fixed height that the script fills, and the data beside it.
    fn figure<T: Serialize>(&mut self, kind: &str, title: &str, note: &str, width: Width, data: &T) {
        self.figures += 1;
        let number = self.figures;
        let width = match width {
            Width::Full => "full",
            Width::Half => "half",
        };
        let _ = write!(
            self.out,
            "<figure class=\"figure {kind} {width}\" id=\"fig-{number}\" data-kind=\"{kind}\" data-file=\"{}\">\
             <div class=\"figure-head\"><h3>{}</h3><div class=\"tools\"></div></div>\
             <div class=\"legend\"></div><div class=\"stage\"><noscript>This figure needs JavaScript.</noscript></div>\
             <figcaption><b>Figure {number}.</b> ",
            slug(title),
            escaped(title)
        );
        // The title is above the figure.
        self.inline(note);
        self.out.push_str("</figcaption>\n<script type=\"application/json\">");
        self.data(data);
        self.out.push_str("</script></figure>\n");
    }

    /// JSON inside a script element: `<` is the only character that could end it or open a comment.
    fn data<T: Serialize>(&mut self, data: &T) {
        // The types hold only numbers, text and lists; serde_json cannot fail on them.
        let json = serde_json::to_string(data).unwrap_or_else(|_| "null".into());
        for (index, part) in json.split('<').enumerate() {
            if index > 0 {
                self.out.push_str("\\u003c");
            }
            self.out.push_str(part);
        }
    }

    fn table(&mut self, table: &Table) {
        self.tables += 1;
        // On a phone tables of sentences and of many columns are shown as one block per row with named fields. Long
        // tables of numbers are scrolled sideways instead.
        let of_text = table.columns.iter().all(|column| !column.numeric);
        let is_wide = table.columns.len() > MANY_COLUMNS && table.rows.len() <= FEW_ROWS;
        let words = if of_text || is_wide { " words" } else { "" };
        let _ = write!(
            self.out,
            "<div class=\"table{words}\" data-file=\"{}\"><div class=\"figure-head\"><h3 id=\"table-{1}\">{2}</h3>\
             <div class=\"tools\"></div></div><div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-labelledby=\"table-{1}\"><table><thead><tr>",
            slug(&table.title),
            self.tables,
            escaped(&table.title)
        );
        for column in &table.columns {
            let class = if column.numeric { " class=\"number\"" } else { "" };
            let _ = write!(self.out, "<th scope=\"col\"{class}>{}", escaped(&column.label));
            if !column.unit.is_empty() {
                let _ = write!(self.out, " <span class=\"unit\">{}</span>", escaped(&column.unit));
            }
            self.out.push_str("</th>");
        }
        self.out.push_str("</tr></thead><tbody>\n");
        for row in &table.rows {
            self.out.push_str("<tr>");
            for (index, cell) in row.iter().enumerate() {
                let column = table.columns.get(index);
                let numeric = column.is_some_and(|column| column.numeric);
                self.out.push_str(if numeric { "<td class=\"number\"" } else { "<td" });
                if let Some(column) = column.filter(|_| !words.is_empty()) {
                    let head = format!("{} {}", column.label, column.unit);
                    let _ = write!(self.out, " data-head=\"{}\"", escaped(head.trim_end()));
                }
                self.out.push('>');
                self.inline(cell);
                self.out.push_str("</td>");
            }
            self.out.push_str("</tr>\n");
        }
        self.out.push_str("</tbody></table></div>");
        self.below(&table.note);
        self.out.push_str("</div>\n");
    }

    fn shares(&mut self, shares: &Shares) {
        let amount = |value: f64| if value.is_finite() { value } else { 0.0 };
        // Parts that reduce the whole count against it: the shares add up to 100 % with their signs.
        let total: f64 = shares.rows.iter().map(|row| amount(row.1)).sum();
        let largest = shares.rows.iter().map(|row| amount(row.1).abs()).fold(0.0, f64::max);
        let of = |value: f64, whole: f64| if whole > 0.0 { 100.0 * amount(value) / whole } else { 0.0 };
        let _ = writeln!(
            self.out,
            "<div class=\"table shares\" data-file=\"{}\"><div class=\"figure-head\"><h3>{}</h3><div class=\"tools\"></div></div>\
             <table><thead><tr><th scope=\"col\">Part</th><th scope=\"col\" class=\"number\"><span class=\"unit\">{}</span></th>\
             <th scope=\"col\" class=\"number\">share</th><th aria-hidden=\"true\"></th></tr></thead><tbody>",
            slug(&shares.title),
            escaped(&shares.title),
            escaped(&shares.unit)
        );
        for (label, value, remark) in &shares.rows {
            self.out.push_str("<tr><th scope=\"row\">");
            self.inline(label);
            if !remark.is_empty() {
                self.out.push_str(" <small>");
                self.inline(remark);
                self.out.push_str("</small>");
            }
            let _ = writeln!(
                self.out,
                "</th><td class=\"number\">{}</td><td class=\"number\">{:.1} %</td><td class=\"bar\" aria-hidden=\"true\">\
                 <i{} style=\"width:{:.2}%\"></i></td></tr>",
                super::significant(*value, 3),
                of(*value, total),
                if amount(*value) < 0.0 { " class=\"less\"" } else { "" },
                of(value.abs(), largest)
            );
        }
        self.out.push_str("</tbody></table>");
        self.below(&shares.note);
        self.out.push_str("</div>\n");
    }

    fn below(&mut self, note: &str) {
        if !note.is_empty() {
            self.out.push_str("<p class=\"below\">");
            self.inline(note);
            self.out.push_str("</p>");
        }
    }

    fn code(&mut self, title: &str, text: &str) {
        let lines = text.lines().count();
        let open = if lines <= CODE_LINES_SHOWN { " open" } else { "" };
        let _ = writeln!(
            self.out,
            "<details class=\"code\"{open}><summary>{} <span class=\"unit\">{lines} lines</span></summary>\
             <button type=\"button\" class=\"copy-code\">Copy</button><pre>{}</pre></details>",
            escaped(title),
            escaped(text)
        );
    }

    fn references(&mut self, references: &[Reference]) {
        self.out.push_str("<ul class=\"references\">\n");
        for reference in references {
            let _ = write!(self.out, "<li id=\"ref-{0}\"><b>{0}</b> <span>", escaped(&reference.key));
            push_escaped(&mut self.out, &reference.citation);
            if let Some(doi) = &reference.doi {
                // Only a link: the page loads no resource from it.
                let _ = write!(
                    self.out,
                    " <a rel=\"noreferrer\" href=\"https://doi.org/{0}\">doi:{0}</a>",
                    escaped(doi)
                );
            }
            self.out.push_str("<em>");
            push_escaped(&mut self.out, &reference.used_for);
            self.out.push_str("</em></span></li>\n");
        }
        self.out.push_str("</ul>\n");
    }

    fn provenance(&mut self, page: &Page) {
        let source = &page.provenance;
        let seeds = if source.seeds.is_empty() {
            "none (nothing random in this run)".to_string()
        } else {
            source.seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")
        };
        self.out.push_str("<footer class=\"provenance\"><h2>Provenance</h2><dl>\n");
        for (label, value) in [
            ("Program", format!("arcmin {}", source.version)),
            ("Design hash", source.design_hash.clone()),
            ("Command", source.command.clone()),
            ("Random seeds", seeds),
        ] {
            let _ = writeln!(self.out, "<div><dt>{label}</dt><dd>{}</dd></div>", escaped(&value));
        }
        self.out.push_str("</dl></footer>\n");
    }

    fn inline(&mut self, text: &str) {
        push_inline(&mut self.out, text, &self.reference_keys);
    }
}

fn is_half(block: &Block) -> bool {
    match block {
        Block::Plot(plot) => plot.width == Width::Half,
        Block::HeatMap(map) => map.width == Width::Half,
        // On a wide screen a note is placed beside a half-width figure.
        Block::Note(..) => true,
        _ => false,
    }
}

/// With a capital, and a full stop unless it has its own end.
fn sentence(text: &str) -> String {
    let ended = text.ends_with(['.', '!', '?', ':']);
    format!("{}{}", capitalised(text), if ended || text.is_empty() { "" } else { "." })
}

fn tone_name(tone: Tone) -> &'static str {
    match tone {
        Tone::Neutral => "neutral",
        Tone::Good => "good",
        Tone::Caution => "caution",
        Tone::Bad => "bad",
    }
}
