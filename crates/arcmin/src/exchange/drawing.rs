//! SVG in millimetres.

use std::fmt::Write as _;

use super::millimetres;
use super::profile::ProfileExport;
use crate::geometry::{Outline, Segment, Vec2};

impl ProfileExport {
    /// Drawing in SVG, one user unit per millimetre, y upwards: the polyline of the flank as a path; bores,
    /// holes and windows of every disc and the pins, or the ring of one piece, in groups with the names of the
    /// layers of [`ProfileExport::dxf`].
    pub fn svg(&self) -> String {
        let reach = self.reach();
        let (low, size) = (millimetres(-reach), millimetres(2.0 * reach));
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{size}mm\" height=\"{size}mm\" \
             viewBox=\"{low} {low} {size} {size}\">\n<title>{}</title>\n<desc>{}</desc>\n\
             <g transform=\"scale(1,-1)\" fill=\"none\" stroke-width=\"0.1\">\n",
            escaped(&self.stamp.design_name),
            escaped(&self.stamps().join(". "))
        );
        let circle = |text: &mut String, centre: Vec2, radius: f64| {
            let (x, y, r) = (millimetres(centre.x), millimetres(centre.y), millimetres(radius));
            let _ = writeln!(text, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"/>");
        };
        let outline = |text: &mut String, outline: &Outline| {
            let place = |p: Vec2| format!("{} {}", millimetres(p.x), millimetres(p.y));
            let _ = write!(text, "<path d=\"M{}", place(outline.point(0.0)));
            for segment in &outline.segments {
                let end = place(segment.point(1.0));
                match segment {
                    Segment::Line { .. } => text.push_str(&format!("L{end}")),
                    Segment::Arc { radius, sweep, .. } => {
                        let r = millimetres(*radius);
                        let (large, along) = (sweep.abs() > std::f64::consts::PI, *sweep > 0.0);
                        text.push_str(&format!("A{r} {r} 0 {} {} {end}", u8::from(large), u8::from(along)));
                    }
                }
            }
            text.push_str("Z\"/>\n");
        };
        let corners = self.polyline();
        text.push_str("<path id=\"FLANK_POLYLINE\" stroke=\"#000\" d=\"M");
        for (index, corner) in corners.iter().enumerate() {
            let gap = if index == 0 { "" } else { "L" };
            let _ = write!(text, "{gap}{} {}", millimetres(corner.x), millimetres(corner.y));
        }
        text.push_str("Z\"/>\n");
        let colours = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"];
        for disc in self.discs() {
            let openings = self.openings(disc);
            let colour = colours[disc % colours.len()];
            for (kind, holes) in [("BORES", &openings.bores), ("HOLES", &openings.holes)] {
                let _ = writeln!(text, "<g id=\"DISC_{}_{kind}\" stroke=\"{colour}\">", disc + 1);
                holes.iter().for_each(|hole| circle(&mut text, hole.centre, hole.radius));
                text.push_str("</g>\n");
            }
            let _ = writeln!(text, "<g id=\"DISC_{}_WINDOWS\" stroke=\"{colour}\">", disc + 1);
            openings.windows.iter().for_each(|window| outline(&mut text, window));
            text.push_str("</g>\n");
        }
        match self.contour() {
            Ok(ring) => {
                text.push_str("<g id=\"RING\" stroke=\"#777\">\n");
                outline(&mut text, &ring.opening);
                circle(&mut text, Vec2::zeros(), ring.outer_radius);
            }
            Err(_) => {
                text.push_str("<g id=\"PIN_RING\" stroke=\"#777\">\n");
                self.pins().into_iter().for_each(|(centre, radius)| circle(&mut text, centre, radius));
            }
        }
        text.push_str("</g>\n</g>\n</svg>\n");
        text
    }
}

/// Escapes text for XML elements and attributes.
pub(super) fn escaped(words: &str) -> String {
    let mut text = String::new();
    for c in words.chars().filter(|c| !c.is_control()) {
        match c {
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '&' => text.push_str("&amp;"),
            '"' => text.push_str("&quot;"),
            _ => text.push(c),
        }
    }
    text
}
