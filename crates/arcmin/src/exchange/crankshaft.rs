//! A crankshaft as a stack of cylinders.

use std::f64::consts::{PI, TAU};

use super::solid::{Loop, Rim, SolidFigures, Vertex};
use super::step::Step;
use crate::geometry::{Vec2, unit};
use crate::machine::Machine;
use crate::units::UM;

/// A cylinder of the stack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slice {
    pub centre: Vec2,
    pub radius: f64,
    pub from: f64,
    pub to: f64,
}

/// Heights along the machine's axis, 0 in the middle between the crank supports, m: (lower side of each disc,
/// both ends of a crankshaft).
///
/// The distance between discs is a tenth of their width, less if there is not enough space between the
/// supports, as in the model of the crankshaft's bending; they never overlap.
pub(super) fn heights(machine: &Machine) -> (Vec<f64>, [f64; 2]) {
    let (count, width, span) =
        (machine.disc_count as f64, machine.disc.width, machine.bearings.crank_support_span);
    let pitch = (1.1 * width).min(span / (count + 1.0)).max(width);
    let discs: Vec<f64> =
        (0..machine.disc_count).map(|j| (j as f64 - 0.5 * (count - 1.0)) * pitch - 0.5 * width).collect();
    let half = (0.5 * span).max(0.5 * (count - 1.0) * pitch + 0.6 * width);
    (discs, [-half, half])
}

/// Cylinders of a crankshaft about its own axis at the crank angle 0.
///
/// Eccentrics have the diameter of the turning-arm bearing's inner raceway and the width of the discs. If the
/// shaft would touch an eccentric's circle from inside within a micrometre, which is not a valid solid, it is
/// drawn 2 µm thinner.
pub(super) fn slices(machine: &Machine) -> Vec<Slice> {
    let (discs, [low, high]) = heights(machine);
    let bearing = &machine.bearings.turning_arm;
    let eccentric = 0.5 * (bearing.pitch_diameter - bearing.roller_diameter);
    let shaft = 0.5 * machine.crankshafts.shaft_diameter;
    let eccentricity = machine.crankshafts.eccentricity;
    let touching = ((eccentric - shaft).abs() - eccentricity).abs() < UM;
    let shaft = if touching { shaft - 2.0 * UM } else { shaft };
    let kinematics = machine.kinematics();
    let mut slices = Vec::new();
    let mut z = low;
    for (disc, from) in discs.iter().enumerate() {
        if from - z > UM {
            slices.push(Slice { centre: Vec2::zeros(), radius: shaft, from: z, to: *from });
        }
        let centre = kinematics.disc_pose(disc, 0.0, 0.0).centre;
        z = from + machine.disc.width;
        slices.push(Slice { centre, radius: eccentric, from: *from, to: z });
    }
    slices.push(Slice { centre: Vec2::zeros(), radius: shaft, from: z, to: high });
    slices
}

/// Relative position of two circles.
enum Mutual {
    FirstInside,
    SecondInside,
    /// Angles of both intersections on the first and on the second circle, rad.
    Crossing([f64; 2], [f64; 2]),
}

fn mutual(a: &Slice, b: &Slice) -> Mutual {
    let between = b.centre - a.centre;
    let d = between.norm();
    if d + a.radius <= b.radius {
        return Mutual::FirstInside;
    }
    if d + b.radius <= a.radius {
        return Mutual::SecondInside;
    }
    let towards = between.y.atan2(between.x);
    let on = |r: f64, other: f64| ((d * d + r * r - other * other) / (2.0 * d * r)).clamp(-1.0, 1.0).acos();
    let (first, second) = (on(a.radius, b.radius), on(b.radius, a.radius));
    Mutual::Crossing([towards - first, towards + first], [towards + PI + second, towards + PI - second])
}

/// Common area of two circles, m².
fn lens(a: &Slice, b: &Slice) -> f64 {
    match mutual(a, b) {
        Mutual::FirstInside => PI * a.radius * a.radius,
        Mutual::SecondInside => PI * b.radius * b.radius,
        Mutual::Crossing(first, second) => {
            let segment = |r: f64, half: f64| r * r * (half - half.sin() * half.cos());
            segment(a.radius, 0.5 * (first[1] - first[0])) + segment(b.radius, 0.5 * (second[0] - second[1]))
        }
    }
}

/// Volume and surface of the stack.
pub(super) fn figures(name: &str, slices: &[Slice]) -> SolidFigures {
    let area = |s: &Slice| PI * s.radius * s.radius;
    let mut surface = area(&slices[0]) + area(&slices[slices.len() - 1]);
    surface += slices.iter().map(|s| TAU * s.radius * (s.to - s.from)).sum::<f64>();
    surface += slices.windows(2).map(|p| area(&p[0]) + area(&p[1]) - 2.0 * lens(&p[0], &p[1])).sum::<f64>();
    let volume = slices.iter().map(|s| area(s) * (s.to - s.from)).sum();
    SolidFigures { name: name.to_owned(), volume, surface }
}

/// The pair of opposite angles with the largest distance from all vertices of a slice's rims.
fn seams(avoided: &[f64]) -> [f64; 2] {
    let clearance = |seam: f64| {
        let off = |angle: &f64| {
            let x = (angle - seam).rem_euclid(PI);
            x.min(PI - x)
        };
        avoided.iter().map(off).fold(f64::INFINITY, f64::min)
    };
    let best =
        (0..24).map(|i| PI * f64::from(i) / 24.0).max_by(|a, b| clearance(*a).total_cmp(&clearance(*b)));
    let seam = best.unwrap_or(0.0);
    [seam, seam + PI]
}

/// Writes the stack as one solid.
pub(super) fn solid(step: &mut Step, name: &str, slices: &[Slice]) -> usize {
    let meetings: Vec<Mutual> = slices.windows(2).map(|pair| mutual(&pair[0], &pair[1])).collect();
    // Angles on the lower and the upper rim of each slice.
    let crossing = |index: usize, upper: bool| -> Vec<f64> {
        let meeting =
            if upper { meetings.get(index) } else { index.checked_sub(1).and_then(|i| meetings.get(i)) };
        match meeting {
            Some(Mutual::Crossing(first, second)) => if upper { *first } else { *second }.to_vec(),
            _ => Vec::new(),
        }
    };
    let mut faces = Vec::new();
    let mut below: Option<Rim> = None;
    for (index, slice) in slices.iter().enumerate() {
        let avoided: Vec<f64> = [crossing(index, false), crossing(index, true)].concat();
        let seams = seams(&avoided);
        let rim = |step: &mut Step, upper: bool, shared: Option<&Rim>| {
            let z = if upper { slice.to } else { slice.from };
            let mut angles: Vec<(f64, Option<Vertex>)> =
                seams.iter().map(|a| (a.rem_euclid(TAU), None)).collect();
            for angle in crossing(index, upper) {
                let place = slice.centre + slice.radius * unit(angle);
                // At the intersection of circles both have the same vertex.
                let known = shared.and_then(|rim| {
                    let off = |v: &Vertex| (Vec2::new(v.place[0], v.place[1]) - place).norm();
                    rim.vertices.iter().map(|v| v.1).find(|v| off(v) < 1e-9)
                });
                angles.push((angle.rem_euclid(TAU), known));
            }
            angles.sort_by(|a, b| a.0.total_cmp(&b.0));
            step.rim(slice.centre, slice.radius, z, &angles)
        };
        let low = rim(step, false, below.as_ref());
        let high = rim(step, true, None);
        match &below {
            None => {
                let plane = step.level(slice.from, false);
                faces.push(step.face("end", plane, &[low.all(false)], true));
            }
            Some(under) => shoulder(step, slice.from, under, &low, &meetings[index - 1], &mut faces),
        }
        faces.extend(step.wall("cylinder", &low, &high, slice.from, seams, true));
        below = Some(high);
    }
    if let (Some(top), Some(last)) = (&below, slices.last()) {
        let plane = step.level(last.to, true);
        faces.push(step.face("end", plane, &[top.all(true)], true));
    }
    step.solid(name, &faces)
}

/// The faces between a slice and the one above it.
fn shoulder(step: &mut Step, z: f64, under: &Rim, above: &Rim, meeting: &Mutual, faces: &mut Vec<usize>) {
    let along = |edges: Vec<usize>| edges.into_iter().map(|edge| (edge, true)).collect::<Loop>();
    let back = |edges: Vec<usize>| edges.into_iter().rev().map(|edge| (edge, false)).collect::<Loop>();
    match meeting {
        Mutual::FirstInside => {
            let plane = step.level(z, false);
            faces.push(step.face("shoulder", plane, &[above.all(false), under.all(true)], true));
        }
        Mutual::SecondInside => {
            let plane = step.level(z, true);
            faces.push(step.face("shoulder", plane, &[under.all(true), above.all(false)], true));
        }
        Mutual::Crossing(..) => {
            let up = step.level(z, true);
            let facing_up = [along(under.run(above, false)), back(above.run(under, true))].concat();
            faces.push(step.face("shoulder", up, &[facing_up], true));
            let down = step.level(z, false);
            let facing_down = [along(under.run(above, true)), back(above.run(under, false))].concat();
            faces.push(step.face("shoulder", down, &[facing_down], true));
        }
    }
}
