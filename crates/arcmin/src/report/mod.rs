//! Rendering of a study as one self-contained HTML page.
//!
//! This module only turns data into text: it uses no files and no clock, so the same page gives the same bytes. The
//! result needs no network: styles, script and data are inside the page, and a content security policy in it forbids
//! the browser to load anything else.
//!
//! # How to use it
//!
//! Fill a [`Page`] with [`Section`]s of [`Block`]s and call [`Page::render`]. Plots take numbers in the
//! unit that their [`Axis`] names; a value that is not finite becomes a gap, never a wrong point.
//!
//! ```
//! use arcmin::report::{Axis, Block, Page, Plot, Provenance, Section, Series, Tone, Verdict};
//!
//! let mut plot = Plot::new(
//!     "Play over life",
//!     Axis::new("Running time", "h"),
//!     Axis::new("Play at the output", "arcmin").from_zero(),
//! );
//! plot.series.push(Series::line("coupled wear", [(0.0, 0.0), (3750.0, 0.24), (7500.0, 0.36)]));
//! plot.limit_at(1.0, "limit of the design file");
//!
//! let page = Page {
//!     title: "RV-40E-81".into(),
//!     subtitle: "Accuracy over life".into(),
//!     provenance: Provenance::default(),
//!     verdict: Verdict::new(Tone::Good, "Stays below 1 arcmin for 7500 h."),
//!     sections: vec![Section::new("life", "Accuracy over life", vec![Block::Plot(plot)])],
//! };
//! let html = page.render();
//! assert!(html.starts_with("<!doctype html>"));
//! ```
//!
//! Text blocks are plain text: everything is escaped. A word in square brackets that is the key of an
//! entry in [`Block::References`], such as `[Tao2024]`, becomes a link to that entry, and text between
//! backticks is set as code.
//!
//! The script in `assets/` reads the serialised form of [`Plot`], [`HeatMap`], [`Mechanism`], [`Solids`],
//! [`ArmPicture`] and [`MeshPicture`]; field names are the same on both sides.

mod arm;
mod causes;
mod drawing;
pub mod elastic;
mod html;
mod literature;
mod mechanism;
mod plot;
pub mod rig;
mod samples;
mod solids;
#[cfg(test)]
mod tests;
mod text;
mod traces;

pub use arm::{ArmPicture, ArmProgram, ArmState};
pub use causes::lost_motion_causes;
pub use drawing::{
    CrankshaftDrawing, ForceState, GearStageDrawing, Hole, Mechanism, MeshField, MeshPicture, mesh_picture,
};
pub use literature::literature;
pub use mechanism::{findings_table, mechanism};
pub use plot::{Annotation, Axis, Colour, HeatMap, Plot, Points, Scale, Series, Style, Tone, Width};
pub use samples::{DesignTemplate, SampleColumn, Samples};
pub use solids::{Position, SolidState, Solids, depths, positions};
pub use text::{capitalised, compact, in_decimals, is_hidden, printable, significant};
pub use traces::{envelope, thinned};

/// A whole report.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// Name of the design or study, in the head of the page.
    pub title: String,
    /// Topic of the page, such as "Virtual test bench".
    pub subtitle: String,
    /// Version, design, command and seeds.
    pub provenance: Provenance,
    /// Top of the page.
    pub verdict: Verdict,
    /// Parts of the page from top to bottom, which its contents list.
    pub sections: Vec<Section>,
}

/// Provenance of the numbers of a page, sufficient to produce the page again.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Provenance {
    /// Version of the program.
    pub version: String,
    /// Hash of the design file's content.
    pub design_hash: String,
    /// The command line as typed.
    pub command: String,
    /// Seeds of all random draws; empty if nothing is random.
    pub seeds: Vec<u64>,
}

/// The head of the page: the main results at a glance.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Judgement, shown as colour, word and shape.
    pub tone: Tone,
    /// One sentence.
    pub headline: String,
    /// Three to five large figures.
    pub figures: Vec<KeyFigure>,
    /// Question and answer, for instance ("What limits it", "Wear of the disc flank at 61°").
    pub answers: Vec<(String, String)>,
    /// Plain text behind the button "Copy summary"; no button when empty.
    pub summary: String,
}

impl Verdict {
    /// A verdict without figures, answers and summary.
    pub fn new(tone: Tone, headline: impl Into<String>) -> Self {
        Self {
            tone,
            headline: headline.into(),
            figures: Vec::new(),
            answers: Vec::new(),
            summary: String::new(),
        }
    }
}

/// One key figure with its unit and a sentence of description.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyFigure {
    /// Name of the quantity.
    pub label: String,
    /// Number as shown, rounded for readers.
    pub value: String,
    /// Unit as a reader writes it; empty for none.
    pub unit: String,
    /// Sentence below the number.
    pub note: String,
    /// Judgement against the limit; neutral where there is none.
    pub tone: Tone,
}

impl KeyFigure {
    /// A key figure without judgement.
    pub fn new(
        label: impl Into<String>,
        value: impl Into<String>,
        unit: impl Into<String>,
        note: impl Into<String>,
    ) -> Self {
        Self {
            label: label.into(),
            value: value.into(),
            unit: unit.into(),
            note: note.into(),
            tone: Tone::Neutral,
        }
    }

    /// Bad unless `kept`.
    pub fn kept(self, kept: bool) -> Self {
        Self { tone: if kept { Tone::Neutral } else { Tone::Bad }, ..self }
    }
}

/// A titled part of the page; `id` is its anchor (letters, digits, hyphens).
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Anchor, unique on the page.
    pub id: String,
    /// Heading, also in the contents.
    pub title: String,
    /// Content from top to bottom.
    pub blocks: Vec<Block>,
}

impl Section {
    /// A part of the page from its anchor, heading and content.
    pub fn new(id: impl Into<String>, title: impl Into<String>, blocks: Vec<Block>) -> Self {
        Self { id: id.into(), title: title.into(), blocks }
    }
}

/// One piece of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// A smaller heading inside the section.
    Heading(String),
    /// A separate remark: assumptions, effects that are not modelled, reasons for a difference.
    Note(Tone, String),
    /// A table of texts.
    Table(Table),
    /// Parts of a whole as bars.
    Shares(Shares),
    /// Curves over two axes.
    Plot(Plot),
    /// A quantity over two others as colours.
    HeatMap(HeatMap),
    /// The drive in a view along its axis.
    Mechanism(Mechanism),
    /// A drive in three dimensions.
    Solids(Solids),
    /// A finite element mesh.
    Mesh(MeshPicture),
    /// An arm in three dimensions.
    Arm(ArmPicture),
    /// Samples of a study.
    Samples(Samples),
    /// Text shown as written (the design file), folded when long.
    Code {
        /// Heading above the text.
        title: String,
        /// Text as written.
        text: String,
    },
    /// List of the literature.
    References(Vec<Reference>),
}

/// A table of text cells. Cells of a numeric column are set right-aligned.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Heading of the table.
    pub title: String,
    /// Heads of the columns.
    pub columns: Vec<Column>,
    /// Cells row by row, as many as there are columns.
    pub rows: Vec<Vec<String>>,
    /// Text below the table.
    pub note: String,
}

/// Head of a table column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name of the quantity.
    pub label: String,
    /// Empty for text columns and for numbers without unit.
    pub unit: String,
    /// Whether cells are numbers, set right-aligned.
    pub numeric: bool,
}

impl Column {
    /// A column of texts.
    pub fn text(label: impl Into<String>) -> Self {
        Self { label: label.into(), unit: String::new(), numeric: false }
    }
    /// A column of numbers.
    pub fn number(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into(), numeric: true }
    }
}

/// Parts of a whole as labelled horizontal bars: compliance per part, lost motion per cause.
#[derive(Debug, Clone, PartialEq)]
pub struct Shares {
    /// Heading of the figure.
    pub title: String,
    /// Unit of the values.
    pub unit: String,
    /// Label, value in `unit`, remark. Values are not negative.
    pub rows: Vec<(String, f64, String)>,
    /// Text below the figure.
    pub note: String,
}

/// One entry of the literature list.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Short key as cited in text, such as `Tao2024`.
    pub key: String,
    /// Authors, title, journal, year.
    pub citation: String,
    /// Without resolver prefix, such as `10.3390/machines12080511`.
    pub doi: Option<String>,
    /// Model or number of this page that is based on it.
    pub used_for: String,
}

impl Page {
    /// The page as one HTML document.
    pub fn render(&self) -> String {
        html::render(self)
    }
}
