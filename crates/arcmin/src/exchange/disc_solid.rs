//! A disc as a STEP solid: flank, bores, holes, windows.

use std::f64::consts::PI;

use super::ExchangeError;
use super::profile::ProfileExport;
use super::solid::{Loop, Vertex, number, real, references};
use super::spline::CubicSpline;
use super::step::Step;
use crate::geometry::{Outline, Segment, Vec2, quarter_turn, unit};

/// Bounds of the two end faces: outer loop first.
struct Sides {
    below: Vec<Loop>,
    above: Vec<Loop>,
}

fn reversed(edges: &Loop) -> Loop {
    edges.iter().rev().map(|(edge, along)| (*edge, !along)).collect()
}

impl ProfileExport {
    /// Disc between z = 0 and its width, in the frame of its flank.
    pub(super) fn disc(&self, step: &mut Step, disc: usize, name: &str) -> usize {
        let width = self.width();
        let mut faces = Vec::new();
        let (lower, upper) = self.flank_faces(step, &mut faces);
        let mut sides = Sides { below: vec![reversed(&lower)], above: vec![upper] };
        let openings = self.openings(disc);
        let named = [("bore", &openings.bores), ("hole", &openings.holes)];
        for (kind, hole) in named.into_iter().flat_map(|(kind, all)| all.iter().map(move |hole| (kind, hole)))
        {
            let angles = [(0.0, None), (PI, None)];
            let low = step.rim(hole.centre, hole.radius, 0.0, &angles);
            let high = step.rim(hole.centre, hole.radius, width, &angles);
            faces.extend(step.wall(kind, &low, &high, 0.0, [0.0, PI], false));
            sides.below.push(low.all(true));
            sides.above.push(high.all(false));
        }
        for window in &openings.windows {
            step.window(window, width, &mut faces, &mut sides);
        }
        for (z, loops) in [(0.0, sides.below), (width, sides.above)] {
            let plane = step.level(z, z > 0.0);
            faces.push(step.face("side", plane, &loops, true));
        }
        step.solid(name, &faces)
    }

    /// The ring of one piece, with the height of the stack of discs, about its own centre.
    ///
    /// # Errors
    /// [`ExchangeError::NoPart`] if it consists of pins.
    pub(super) fn ring_solid(&self, step: &mut Step) -> Result<usize, ExchangeError> {
        let (ring, width) = (self.contour()?, self.pin_length());
        let angles = [(0.0, None), (PI, None)];
        let [low, high] = [0.0, width].map(|z| step.rim(Vec2::zeros(), ring.outer_radius, z, &angles));
        let mut faces = step.wall("outside", &low, &high, 0.0, [0.0, PI], true);
        let mut sides = Sides { below: vec![low.all(false)], above: vec![high.all(true)] };
        step.window(&ring.opening, width, &mut faces, &mut sides);
        for (z, loops) in [(0.0, sides.below), (width, sides.above)] {
            let plane = step.level(z, z > 0.0);
            faces.push(step.face("side", plane, &loops, true));
        }
        Ok(step.solid("ring", &faces))
    }

    /// Faces of the flank, and its lower and upper edges counter-clockwise.
    fn flank_faces(&self, step: &mut Step, faces: &mut Vec<usize>) -> (Loop, Loop) {
        let width = self.width();
        let lobe = || self.flanks.iter().flat_map(|flank| &flank.parts);
        let splines: Vec<CubicSpline> = (0..self.outline.lobe_count())
            .flat_map(|k| {
                let turn = unit(self.outline.lobe_pitch() * k as f64);
                lobe().map(move |part| part.turned(turn))
            })
            .collect();
        let corners: Vec<(Vertex, Vertex)> = splines
            .iter()
            .map(|spline| {
                let place = spline.control[0];
                (step.vertex([place.x, place.y, 0.0]), step.vertex([place.x, place.y, width]))
            })
            .collect();
        let ups: Vec<usize> = corners.iter().map(|(low, high)| step.upright(*low, *high)).collect();
        let (mut lower, mut upper) = (Loop::new(), Loop::new());
        for (index, spline) in splines.iter().enumerate() {
            let next = (index + 1) % splines.len();
            let rows = [0.0, width].map(|z| {
                let points: Vec<usize> = spline.control.iter().map(|p| step.point([p.x, p.y, z])).collect();
                points
            });
            let (multiplicities, knots) = knot_lists(spline);
            let [low, high] = [0, 1].map(|side| {
                let curve = step.add(&format!(
                    "B_SPLINE_CURVE_WITH_KNOTS('',3,({}),.UNSPECIFIED.,.F.,.F.,({multiplicities}),({knots}),.UNSPECIFIED.)",
                    references(&rows[side])
                ));
                let pick = |pair: (Vertex, Vertex)| if side == 0 { pair.0 } else { pair.1 };
                step.edge(pick(corners[index]), pick(corners[next]), curve)
            });
            let net: Vec<String> =
                rows[0].iter().zip(&rows[1]).map(|(low, high)| format!("(#{low},#{high})")).collect();
            let surface = step.add(&format!(
                "B_SPLINE_SURFACE_WITH_KNOTS('',3,1,({}),.UNSPECIFIED.,.F.,.F.,.F.,({multiplicities}),(2,2),\
                 ({knots}),(0.,{}),.UNSPECIFIED.)",
                net.join(","),
                real(width)
            ));
            let edges = vec![(low, true), (ups[next], true), (high, false), (ups[index], false)];
            faces.push(step.face(&format!("flank {}", index + 1), surface, &[edges], true));
            lower.push((low, true));
            upper.push((high, true));
        }
        (lower, upper)
    }
}

impl Step {
    /// The walls of a window from z = 0 to `width`, and its edges as inner bounds of both sides.
    fn window(&mut self, outline: &Outline, width: f64, faces: &mut Vec<usize>, sides: &mut Sides) {
        let corners: Vec<[Vertex; 2]> = outline
            .segments
            .iter()
            .map(|segment| {
                let place = segment.point(0.0);
                [0.0, width].map(|z| self.vertex([place.x, place.y, z]))
            })
            .collect();
        let ups: Vec<usize> = corners.iter().map(|[low, high]| self.upright(*low, *high)).collect();
        let (mut below, mut above) = (Loop::new(), Loop::new());
        for (index, segment) in outline.segments.iter().enumerate() {
            let next = (index + 1) % corners.len();
            let [low, high] = [0, 1].map(|side| {
                let curve = self.segment_curve(segment, [0.0, width][side]);
                self.edge(corners[index][side], corners[next][side], curve)
            });
            // The material is outside of the window: the normal of its face points inwards, to the left of the
            // outline. A cylinder's own normal points away from its axis, to the left of an arc with positive
            // sweep.
            let (surface, same) = match segment {
                Segment::Line { from, to } => (self.plane(*from, (to - from).normalize()), true),
                Segment::Arc { centre, radius, sweep, .. } => {
                    (self.cylinder(*centre, *radius, 0.0), *sweep < 0.0)
                }
            };
            let edges = vec![(low, true), (ups[next], true), (high, false), (ups[index], false)];
            faces.push(self.face("window", surface, &[reversed(&edges)], same));
            below.push((low, true));
            above.push((high, true));
        }
        sides.below.push(below);
        sides.above.push(reversed(&above));
    }

    /// The line or circle of a segment at a height.
    fn segment_curve(&mut self, segment: &Segment, z: f64) -> usize {
        match segment {
            Segment::Line { from, to } => {
                let along = (to - from).normalize();
                let (point, along) =
                    (self.point([from.x, from.y, z]), self.direction([along.x, along.y, 0.0]));
                let vector = self.add(&format!("VECTOR('',#{along},1.)"));
                self.add(&format!("LINE('',#{point},#{vector})"))
            }
            Segment::Arc { centre, radius, sweep, .. } => {
                let axis =
                    self.placement([centre.x, centre.y, z], [0.0, 0.0, sweep.signum()], [1.0, 0.0, 0.0]);
                self.add(&format!("CIRCLE('',#{axis},{})", real(*radius)))
            }
        }
    }

    /// A vertical plane through a point along a direction; its normal points to the left.
    fn plane(&mut self, place: Vec2, along: Vec2) -> usize {
        let normal = quarter_turn(along);
        let axis =
            self.placement([place.x, place.y, 0.0], [normal.x, normal.y, 0.0], [along.x, along.y, 0.0]);
        self.add(&format!("PLANE('',#{axis})"))
    }
}

/// Lists of multiplicities and of knots (in mm, as the arc length).
fn knot_lists(spline: &CubicSpline) -> (String, String) {
    let multiplicities: Vec<String> = spline.knots.iter().map(|(_, m)| m.to_string()).collect();
    let knots: Vec<String> = spline.knots.iter().map(|(t, _)| number(t * 1e3, 12)).collect();
    (multiplicities.join(","), knots.join(","))
}
