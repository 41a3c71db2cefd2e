//! A drawing of a drive in SVG with the keys of its design as dimensions.

mod families;
#[cfg(test)]
mod tests;

pub use families::DimensionedDesign;

use std::fmt::Write as _;

use super::drawing::escaped;
use crate::geometry::Vec2;
use crate::units::MM;

/// Line styles: classes of the style sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stroke {
    /// Outlines of discs, and their openings.
    Disc,
    Opening,
    /// Ring pins, output pins, shafts, plates.
    Pin,
    /// Circles of centres and axes.
    Axis,
}

impl Stroke {
    fn class(self) -> &'static str {
        match self {
            Stroke::Disc => "disc",
            Stroke::Opening => "opening",
            Stroke::Pin => "pin",
            Stroke::Axis => "axis",
        }
    }
}

/// A shape, coordinates in m.
#[derive(Debug, Clone)]
enum Shape {
    Circle(Vec2, f64, Stroke),
    Polygon(Vec<Vec2>, Stroke),
    /// Axis through a point, with half the length of its arms.
    Cross(Vec2, f64),
}

/// A dimension with its key.
#[derive(Debug, Clone)]
struct Dimension {
    /// Path of the key, and text after it.
    key: String,
    value: String,
    /// Text after the section of the key; may be empty.
    note: String,
    /// Points (m) between which it is measured; for counts and offsets the same point twice. The label is
    /// connected to the second.
    ends: [Vec2; 2],
    /// Whether the label is on the left.
    is_left: bool,
}

/// Shapes with their dimensions.
#[derive(Debug, Clone)]
struct View {
    title: String,
    /// Half of the width and of the height of the shapes in m.
    half: [f64; 2],
    shapes: Vec<Shape>,
    dimensions: Vec<Dimension>,
}

/// Lengths in units of the drawing: half of the width of a view, width of a column of labels, margins.
const HALF_WIDTH: f64 = 100.0;
const COLUMN: f64 = 112.0;
const MARGIN: f64 = 6.0;
/// Height of a line of text, of a label of two lines, of a title.
const LINE: f64 = 7.0;
const LABEL: f64 = 2.0 * LINE + 3.0;
const TITLE: f64 = 14.0;

/// Thin dark lines on white paper, and the reverse for a dark colour scheme.
const STYLE: &str = "svg{background:#fff}\
text{font:6px sans-serif;fill:#222}.title{font-size:8px;font-weight:bold}.key{fill:#555}.value{font-weight:bold}\
.disc,.opening,.pin,.axis,.line,.leader{fill:none;vector-effect:non-scaling-stroke}\
.disc{stroke:#0072b2;stroke-width:1.4px;fill:#0072b2;fill-opacity:.07}.opening{stroke:#0072b2;stroke-width:1.4px;fill:#fff}.pin{stroke:#555;stroke-width:1.2px}\
.axis{stroke:#999;stroke-width:.8px;stroke-dasharray:6 2 1 2}.line{stroke:#c2410c;stroke-width:1.2px}\
.leader{stroke:#c2410c;stroke-width:.7px}.arrow{fill:#c2410c}\
@media (prefers-color-scheme:dark){svg{background:#16181d}text{fill:#e8e8e8}.key{fill:#aaa}.disc{stroke:#56b4e9;fill:#56b4e9}.opening{stroke:#56b4e9;fill:#16181d}\
.pin{stroke:#bbb}.axis{stroke:#777}.line,.leader{stroke:#fb923c}.arrow{fill:#fb923c}}\
@media print{svg{background:none}}";

impl View {
    /// Drawing units per m.
    fn scale(&self) -> f64 {
        HALF_WIDTH / self.half[0]
    }

    /// Height of shapes or labels, whichever is larger.
    fn height(&self) -> f64 {
        let count = |left: bool| self.dimensions.iter().filter(|d| d.is_left == left).count() as f64;
        let labels = LABEL * count(true).max(count(false));
        TITLE + labels.max(2.0 * self.half[1] * self.scale()) + 2.0 * MARGIN
    }

    /// Writes the view below a vertical position.
    fn write(&self, text: &mut String, top: f64) {
        let middle = [COLUMN + MARGIN + HALF_WIDTH, top + TITLE + 0.5 * (self.height() - TITLE)];
        let scale = self.scale();
        let at = |p: Vec2| [middle[0] + scale * p.x, middle[1] - scale * p.y];
        let _ = writeln!(
            text,
            "<text class=\"title\" x=\"{}\" y=\"{}\">{}</text>",
            number(MARGIN),
            number(top + 0.7 * TITLE),
            escaped(&self.title)
        );
        for shape in &self.shapes {
            match shape {
                Shape::Circle(centre, radius, stroke) => {
                    let [x, y] = at(*centre).map(number);
                    let (class, r) = (stroke.class(), number(scale * radius));
                    let _ = writeln!(text, "<circle class=\"{class}\" cx=\"{x}\" cy=\"{y}\" r=\"{r}\"/>");
                }
                Shape::Polygon(corners, stroke) => {
                    let places = corners.iter().map(|corner| at(*corner).map(number).join(" "));
                    let path = places.collect::<Vec<_>>().join("L");
                    let _ = writeln!(text, "<path class=\"{}\" d=\"M{path}Z\"/>", stroke.class());
                }
                Shape::Cross(centre, arm) => {
                    let [x, y] = at(*centre);
                    let arm = scale * arm;
                    let [left, right, up, down] = [x - arm, x + arm, y - arm, y + arm].map(number);
                    let (x, y) = (number(x), number(y));
                    let _ = writeln!(
                        text,
                        "<path class=\"axis\" d=\"M{left} {y}L{right} {y}M{x} {up}L{x} {down}\"/>"
                    );
                }
            }
        }
        for is_left in [true, false] {
            let mut side: Vec<&Dimension> =
                self.dimensions.iter().filter(|dimension| dimension.is_left == is_left).collect();
            side.sort_by(|a, b| b.ends[1].y.total_cmp(&a.ends[1].y));
            let wanted: Vec<f64> = side.iter().map(|dimension| at(dimension.ends[1])[1]).collect();
            let rows = rows(&wanted, [top + TITLE, top + self.height() - MARGIN]);
            for (dimension, y) in side.iter().zip(rows) {
                let ends = dimension.ends.map(at);
                write_dimension(text, dimension, ends, (is_left, y), scale);
            }
        }
    }
}

/// Vertical positions of labels near the required, increasing ones, at least one label apart, within a range of
/// sufficient size.
fn rows(wanted: &[f64], [low, high]: [f64; 2]) -> Vec<f64> {
    let mut rows = wanted.to_vec();
    let mut least = low + 0.5 * LABEL;
    for row in &mut rows {
        *row = row.max(least);
        least = *row + LABEL;
    }
    let mut most = high - 0.5 * LABEL;
    for row in rows.iter_mut().rev() {
        *row = row.min(most);
        most = *row - LABEL;
    }
    rows
}

/// Line with arrows, leader and label.
fn write_dimension(
    text: &mut String,
    dimension: &Dimension,
    [from, to]: [[f64; 2]; 2],
    (is_left, y): (bool, f64),
    scale: f64,
) {
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    let edge = COLUMN + if is_left { 0.0 } else { 2.0 * (MARGIN + HALF_WIDTH) };
    let [[x1, y1], [x2, y2]] = [from, to].map(|end| end.map(number));
    let key = escaped(&dimension.key);
    if length > 0.0 {
        let mm = number(length / scale / MM);
        let _ = writeln!(
            text,
            "<line class=\"line\" data-key=\"{key}\" data-mm=\"{mm}\" x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\"/>"
        );
        for (tip, tail) in [(from, to), (to, from)] {
            write_arrow(text, tip, tail, length);
        }
    } else {
        let _ = writeln!(text, "<circle class=\"arrow\" cx=\"{x2}\" cy=\"{y2}\" r=\"1.1\"/>");
    }
    // Horizontally to the label, from the edge of the column of shapes.
    let bend = edge + if is_left { MARGIN } else { -MARGIN };
    let _ = writeln!(
        text,
        "<path class=\"leader\" d=\"M{x2} {y2}L{} {}L{} {}\"/>",
        number(bend),
        number(y),
        number(edge),
        number(y)
    );
    let (x, anchor) = if is_left { (edge - 1.5, "end") } else { (edge + 1.5, "start") };
    let (section, name) = dimension.key.rsplit_once('.').unwrap_or(("", &dimension.key));
    let section_dot = format!("{section}.");
    let _ = writeln!(
        text,
        "<text text-anchor=\"{anchor}\"><tspan class=\"key\" x=\"{x}\" y=\"{}\">{}</tspan><tspan x=\"{x}\" y=\"{}\">{} \
         </tspan><tspan class=\"value\">{}</tspan></text>",
        number(y - 0.8),
        escaped(&[if section.is_empty() { "" } else { &section_dot }, &dimension.note].concat()),
        number(y + LINE - 0.8),
        escaped(name),
        escaped(&dimension.value),
        x = number(x)
    );
}

/// An arrow at a tip; outside of lines that are too short for two arrows.
fn write_arrow(text: &mut String, tip: [f64; 2], tail: [f64; 2], length: f64) {
    let (size, half) = (3.2, 0.9);
    let inward = if length > 2.5 * size { 1.0 } else { -1.0 };
    let along = [(tail[0] - tip[0]) / length * inward, (tail[1] - tip[1]) / length * inward];
    let base = [tip[0] + size * along[0], tip[1] + size * along[1]];
    let corners = [
        tip,
        [base[0] - half * along[1], base[1] + half * along[0]],
        [base[0] + half * along[1], base[1] - half * along[0]],
    ];
    let path = corners.map(|corner| corner.map(number).join(" ")).join("L");
    let _ = writeln!(text, "<path class=\"arrow\" d=\"M{path}Z\"/>");
}

/// At most three decimals, without a minus sign before zero.
fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// The views below each other, with a title.
fn sheet(title: &str, stamp: &str, views: &[View]) -> String {
    let width = 2.0 * (COLUMN + MARGIN + HALF_WIDTH);
    let height = TITLE + views.iter().map(View::height).sum::<f64>() + LINE;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\">\n<title>{}</title>\n<desc>{}</desc>\n\
         <style>{STYLE}</style>\n\
         <text class=\"title\" x=\"{}\" y=\"{}\">{}</text>\n",
        number(width),
        number(height),
        escaped(title),
        escaped(stamp),
        number(MARGIN),
        number(0.8 * TITLE),
        escaped(title)
    );
    let mut top = TITLE;
    for view in views {
        view.write(&mut text, top);
        top += view.height();
    }
    text.push_str("</svg>\n");
    text
}
