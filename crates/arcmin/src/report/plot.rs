//! Plots as data: axes, series, annotations, heat maps.

use serde::{Serialize, Serializer};

/// Judgement, shown by a word and a shape as well as by colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Default)]
#[serde(rename_all = "snake_case")]
pub enum Tone {
    /// Information without judgement.
    #[default]
    Neutral,
    /// Within limits.
    Good,
    /// Near a limit, or to be checked by the reader.
    Caution,
    /// Beyond a limit.
    Bad,
}

/// Division of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Default)]
#[serde(rename_all = "snake_case")]
pub enum Scale {
    /// Equal steps for equal differences.
    #[default]
    Linear,
    /// Decadic logarithm; values that are not positive become gaps.
    Log,
}

/// An axis with quantity, unit and range.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Name of the quantity.
    pub label: String,
    /// Empty for a pure number.
    pub unit: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// Shown before zooming; the data's own range when absent.
    pub range: Option<[f64; 2]>,
    /// The data's own range, extended to include zero.
    pub include_zero: bool,
    /// Whether the quantity is a count (whole numbers only).
    pub counted: bool,
}

impl Axis {
    /// A linear axis over the range of its data.
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            unit: unit.into(),
            scale: Scale::Linear,
            range: None,
            include_zero: false,
            counted: false,
        }
    }
    /// Name and unit, as in a sentence.
    fn quantity(&self) -> String {
        if self.unit.is_empty() { self.label.clone() } else { format!("{} ({})", self.label, self.unit) }
    }
    /// Shows this range before zooming; without effect unless it is finite and rises.
    pub fn between(mut self, from: f64, to: f64) -> Self {
        self.range = (from.is_finite() && to.is_finite() && from < to).then_some([from, to]);
        self
    }
    /// Extends the range to include zero.
    pub fn from_zero(mut self) -> Self {
        self.include_zero = true;
        self
    }
    /// Marks whole numbers only.
    pub fn counted(mut self) -> Self {
        self.counted = true;
        self
    }
    /// Divides the axis by decades.
    pub fn logarithmic(mut self) -> Self {
        self.scale = Scale::Log;
        self
    }
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Style {
    /// A full line.
    Line,
    /// A dashed line.
    Dashed,
    /// Marks alone.
    Markers,
    /// A full line with marks.
    LineMarkers,
    /// A line that holds each value up to the next place.
    Step,
    /// Thin bars from zero, for spectra.
    Bars,
    /// The area between [`Points::low`] and [`Points::y`].
    Band,
}

/// Colour of a series. All choices are distinguishable for colour-blind readers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Colour {
    /// The next colour of the palette that no other series uses.
    Auto,
    /// A fixed place in the palette, to give one quantity one colour on all plots.
    Palette(u8),
    /// For ordered sets (wear levels, hours): 0 is the first, 1 the last.
    Ordered(f64),
    /// Neutral colour, for published values and references.
    Reference,
}

/// Coordinates of a series. Equal lengths; a `None` is a gap.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct Points {
    /// Places along the horizontal axis, in its unit.
    #[serde(serialize_with = "rounded")]
    pub x: Vec<f64>,
    /// Values, in the unit of the vertical axis.
    #[serde(serialize_with = "rounded_gaps")]
    pub y: Vec<Option<f64>>,
    /// Lower edge, only for [`Style::Band`].
    #[serde(serialize_with = "rounded_gaps", skip_serializing_if = "Vec::is_empty")]
    pub low: Vec<Option<f64>>,
}

/// One curve of a plot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Kind of line or marks.
    pub style: Style,
    /// Colour by its part in the palette.
    pub colour: Colour,
    /// Drawn heavier than its neighbours.
    pub strong: bool,
    /// Starts hidden; the legend shows it on demand.
    pub hidden: bool,
    /// Coordinates in the units of the axes.
    pub points: Points,
}

impl Series {
    /// A series of any style from (x, y); points whose x is not finite are dropped, a y that is not
    /// finite becomes a gap.
    pub fn new(name: impl Into<String>, style: Style, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut coordinates = Points::default();
        for (x, y) in points {
            if x.is_finite() {
                coordinates.x.push(x);
                coordinates.y.push(y.is_finite().then_some(y));
            }
        }
        Self {
            name: name.into(),
            style,
            colour: Colour::Auto,
            strong: false,
            hidden: false,
            points: coordinates,
        }
    }
    /// A full line through (x, y).
    pub fn line(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::new(name, Style::Line, points)
    }
    /// Marks at (x, y).
    pub fn markers(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::new(name, Style::Markers, points)
    }
    /// A band from (x, low, high).
    pub fn band(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64, f64)>) -> Self {
        let mut series = Self::new(name, Style::Band, []);
        for (x, low, high) in points {
            if x.is_finite() {
                let known = low.is_finite() && high.is_finite();
                series.points.x.push(x);
                series.points.low.push(known.then_some(low));
                series.points.y.push(known.then_some(high));
            }
        }
        series
    }
    /// Draws in another colour.
    pub fn coloured(mut self, colour: Colour) -> Self {
        self.colour = colour;
        self
    }
    /// Draws heavier than its neighbours.
    pub fn strong(mut self) -> Self {
        self.strong = true;
        self
    }
    /// Hides the series until the legend is clicked.
    pub fn hidden(mut self) -> Self {
        self.hidden = true;
        self
    }
}

/// A mark on a plot that is not a series.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Annotation {
    /// Across the plot at y.
    Horizontal {
        /// Height on the vertical axis.
        at: f64,
        /// Text beside the line.
        label: String,
        /// Judgement that colours the line.
        tone: Tone,
    },
    /// Up the plot at x.
    Vertical {
        /// Place on the horizontal axis.
        at: f64,
        /// Text beside the line.
        label: String,
        /// Judgement that colours the line.
        tone: Tone,
    },
    /// A shaded range of x.
    Span {
        /// Beginning on the horizontal axis.
        from: f64,
        /// End on the horizontal axis.
        to: f64,
        /// Text in the range.
        label: String,
    },
    /// A named point.
    Point {
        /// Place on the horizontal axis.
        x: f64,
        /// Place on the vertical axis.
        y: f64,
        /// Text beside the point.
        label: String,
    },
}

/// Width of a figure on a wide screen; on a narrow one every figure takes the full width.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Default)]
#[serde(rename_all = "snake_case")]
pub enum Width {
    /// All of the column of text.
    #[default]
    Full,
    /// Half of it, two figures side by side.
    Half,
}

/// An interactive x–y plot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plot {
    /// Heading of the figure.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Curves in the order of the legend.
    pub series: Vec<Series>,
    /// Limits, ranges and named points.
    pub annotations: Vec<Annotation>,
    /// Caption below the plot: quantity, unit, condition, source. Left empty, the caption names the axes.
    #[serde(skip)]
    pub note: String,
    /// Width on a wide screen.
    pub width: Width,
    /// One millimetre in x is as long as in y (outlines).
    pub equal_scales: bool,
}

impl Plot {
    /// An empty plot over all of the width.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            series: Vec::new(),
            annotations: Vec::new(),
            note: String::new(),
            width: Width::Full,
            equal_scales: false,
        }
    }
    /// Takes half of the width.
    pub fn half(mut self) -> Self {
        self.width = Width::Half;
        self
    }
    /// Sets the text below the plot.
    pub fn noted(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }
    /// Adds a curve.
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }
    /// The text below the plot: its note, else the quantities of its axes.
    pub fn caption(&self) -> String {
        if self.note.is_empty() {
            format!("{} over {}.", self.y.quantity(), self.x.quantity())
        } else {
            self.note.clone()
        }
    }
    /// Draws a limit across the plot; ignored if it is not finite.
    pub fn limit_at(&mut self, y: f64, label: impl Into<String>) {
        if y.is_finite() {
            self.annotations.push(Annotation::Horizontal { at: y, label: label.into(), tone: Tone::Bad });
        }
    }
}

/// A quantity over two others, one coloured cell per pair of grid values.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeatMap {
    /// Heading of the figure.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// The quantity shown as colour.
    pub value: Axis,
    /// Places of the columns of cells along x.
    #[serde(serialize_with = "rounded")]
    pub x_values: Vec<f64>,
    /// Places of the rows of cells along y.
    #[serde(serialize_with = "rounded")]
    pub y_values: Vec<f64>,
    /// Row by row: `cells[iy * x_values.len() + ix]`; `None` without a value.
    #[serde(serialize_with = "rounded_gaps")]
    pub cells: Vec<Option<f64>>,
    /// Caption below the figure. Left empty, the caption names the axes.
    #[serde(skip)]
    pub note: String,
    /// Width on a wide screen.
    pub width: Width,
}

impl HeatMap {
    /// The text below the map: its note, else the quantities of colour and axes.
    pub fn caption(&self) -> String {
        if self.note.is_empty() {
            let [value, x, y] = [&self.value, &self.x, &self.y].map(Axis::quantity);
            format!("{value} over {x} and {y}.")
        } else {
            self.note.clone()
        }
    }
}

/// Digits kept in the page. Seven significant digits suffice for plots and for tables made from them, and halve the
/// size of the page.
pub(super) const EMBEDDED_DIGITS: i32 = 7;

pub(super) fn round_to_digits(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return 0.0;
    }
    let decimals = EMBEDDED_DIGITS - 1 - value.abs().log10().floor() as i32;
    // Through the decimal text, because value * 10^n / 10^n leaves digits such as 0.30000000000000004.
    if decimals > 0 {
        format!("{value:.*}", decimals as usize).parse().unwrap_or(value)
    } else {
        let unit = 10.0_f64.powi(-decimals);
        (value / unit).round() * unit
    }
}

pub(super) fn rounded<S: Serializer>(values: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(values.iter().map(|value| Number(*value)))
}

pub(super) fn rounded_gaps<S: Serializer>(values: &[Option<f64>], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(values.iter().map(|value| value.map(Number)))
}

/// Written short: whole numbers without a decimal point, others with seven significant digits.
pub(super) struct Number(pub f64);

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if !self.0.is_finite() {
            return serializer.serialize_none();
        }
        let value = round_to_digits(self.0);
        if value.fract() == 0.0 && value.abs() < 1e15 {
            serializer.serialize_i64(value as i64)
        } else {
            serializer.serialize_f64(value)
        }
    }
}
