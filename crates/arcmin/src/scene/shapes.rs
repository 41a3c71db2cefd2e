//! Solids along the axis, in mm.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::geometry::{Profile, Sector, Vec2, turned, unit};
use crate::machine::{Bore, GearStage, RingMesh, RollerBearing, RollerKind};
use crate::units::{DEG, MM};

/// A solid from one height to another, in the coordinates of its body.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Shape {
    /// An outline with holes.
    Plate {
        /// Corners of the outline, mm, counter-clockwise.
        outline: Vec<[f64; 2]>,
        /// Corners of every hole, mm.
        holes: Vec<Vec<[f64; 2]>>,
        /// Round holes: x, y, radius in mm.
        circles: Vec<[f64; 3]>,
        /// First and last height, mm.
        z: [f64; 2],
    },
    /// A cycloid disc in a ring of this number: the points of one lobe with their meshing angles and outward normals, repeated
    /// all around.
    Lobes {
        /// Number of the ring.
        ring: usize,
        /// Points of one lobe, mm.
        lobe: Vec<[f64; 2]>,
        /// Outward unit normals at these points.
        normals: Vec<[f64; 2]>,
        /// Meshing angles at these points.
        meshing_angle_deg: Vec<f64>,
        /// Lobes of the disc.
        count: usize,
        /// Corners of every hole, mm.
        holes: Vec<Vec<[f64; 2]>>,
        /// Round holes: x, y, radius in mm.
        circles: Vec<[f64; 3]>,
        /// First and last height, mm.
        z: [f64; 2],
    },
    /// Equal cylinders.
    Cylinders {
        /// Places of the axes, mm.
        at: Vec<[f64; 2]>,
        /// mm.
        radius: f64,
        /// First and last height, mm.
        z: [f64; 2],
    },
    /// Equal faces of cylinders, each up to this angle on either side of its place nearest to the axis.
    Arcs {
        /// Places of the axes, mm.
        at: Vec<[f64; 2]>,
        /// mm.
        radius: f64,
        /// Half the angle of a face.
        half_angle_deg: f64,
        /// First and last height, mm.
        z: [f64; 2],
    },
    /// Equal balls.
    Balls {
        /// Places of the middles, mm.
        at: Vec<[f64; 2]>,
        /// mm.
        radius: f64,
        /// Height of the middles, mm.
        z: f64,
    },
}

/// Points per lobe: chords stay within 10 µm of the flank of the sizes in use.
const LOBE_POINTS: usize = 30;
const CIRCLE_POINTS: usize = 120;

/// Distance of the points of a contour over the radius of its arcs.
const CONTOUR_STEP: f64 = 0.15;

fn mm(point: Vec2) -> [f64; 2] {
    [point.x / MM, point.y / MM]
}

pub(super) fn lobes(
    ring: usize,
    profile: &Profile,
    openings: &[Bore],
    windows: &[Sector],
    turn: f64,
    z: [f64; 2],
) -> Shape {
    let places = profile.around_lobe(LOBE_POINTS);
    let along = |of: &dyn Fn(f64) -> Vec2| places.iter().map(|tau| of(*tau)).collect::<Vec<_>>();
    Shape::Lobes {
        ring,
        lobe: along(&|tau| profile.flank_point(tau)).into_iter().map(mm).collect(),
        normals: along(&|tau| profile.outward_normal(tau)).into_iter().map(|n| [n.x, n.y]).collect(),
        meshing_angle_deg: places.iter().map(|tau| profile.meshing_angle(*tau) / DEG).collect(),
        count: profile.lobe_count(),
        holes: windows.iter().map(|window| sector(&window.turned(turn))).collect(),
        circles: openings
            .iter()
            .map(|hole| {
                let [x, y] = mm(hole.centre_radius * unit(hole.centre_angle + turn));
                [x, y, hole.radius / MM]
            })
            .collect(),
        z,
    }
}

pub(super) fn sector(sector: &Sector) -> Vec<[f64; 2]> {
    const POINTS: usize = 64;
    let outline = sector.outline();
    let count = outline.segments.len() as f64;
    (0..POINTS).map(|i| mm(outline.point(count * i as f64 / POINTS as f64))).collect()
}

/// A ring or, with an inner radius of 0, a round plate; with round holes.
pub(super) fn ring(outer: f64, inner: f64, holes: &[[f64; 3]], z: [f64; 2]) -> Shape {
    let circle =
        (0..CIRCLE_POINTS).map(|i| mm(outer * unit(TAU * i as f64 / CIRCLE_POINTS as f64))).collect();
    let bore = (inner > 0.0).then_some([0.0, 0.0, inner / MM]);
    Shape::Plate {
        outline: circle,
        holes: Vec::new(),
        circles: holes.iter().copied().chain(bore).collect(),
        z,
    }
}

/// Pins of a ring, or the arcs of a ring of one piece.
pub(super) fn teeth(mesh: &RingMesh, z: [f64; 2]) -> Shape {
    let at = around(mesh.profile.pin_count, mesh.ring_circle_radius);
    let radius = mesh.ring_pin_radius / MM;
    match mesh.ring_profile() {
        Some(profile) => Shape::Arcs { at, radius, half_angle_deg: profile.arc / DEG, z },
        None => Shape::Cylinders { at, radius, z },
    }
}

/// A ring of one piece with its contour turned by an angle in rad; `None` of separate pins.
pub(super) fn one_piece_ring(mesh: &RingMesh, turn: f64, z: [f64; 2]) -> Option<Shape> {
    let profile = mesh.ring_profile()?;
    let places = profile.opening.sample(CONTOUR_STEP * mesh.ring_pin_radius);
    let direction = unit(turn);
    let contour =
        places.into_iter().map(|place| mm(turned(profile.opening.point(place), direction))).collect();
    match ring(profile.outer_radius, 0.0, &[], z) {
        Shape::Plate { outline, circles, z, .. } => {
            Some(Shape::Plate { outline, holes: vec![contour], circles, z })
        }
        _ => None,
    }
}

pub(super) fn prism(outline: Vec<[f64; 2]>, z: [f64; 2]) -> Shape {
    Shape::Plate { outline, holes: Vec::new(), circles: Vec::new(), z }
}

/// Places evenly around a circle, in mm.
pub(super) fn around(count: usize, radius: f64) -> Vec<[f64; 2]> {
    (0..count).map(|i| mm(radius * unit(TAU * i as f64 / count as f64))).collect()
}

pub(super) fn cylinder(at: Vec2, radius: f64, z: [f64; 2]) -> Shape {
    Shape::Cylinders { at: vec![mm(at)], radius: radius / MM, z }
}

/// The rolling elements of a bearing around their cage's middle.
pub(super) fn rolling_elements(bearing: &RollerBearing, middle_mm: f64) -> Shape {
    let at = around(bearing.roller_count, 0.5 * bearing.pitch_diameter);
    let radius = 0.5 * bearing.roller_diameter / MM;
    match bearing.kind {
        RollerKind::Ball => Shape::Balls { at, radius, z: middle_mm },
        _ => {
            let half = 0.5 * bearing.roller_length / MM;
            Shape::Cylinders { at, radius, z: [middle_mm - half, middle_mm + half] }
        }
    }
}

/// A spur gear with involute flanks, addendum of one and dedendum of 1.25 modules; the first tooth is at `angle`.
pub(super) fn gear(stage: &GearStage, teeth: usize, angle: f64, bore: f64, z: [f64; 2]) -> Shape {
    const FLANK_POINTS: usize = 5;
    let pitch_radius = 0.5 * stage.module * teeth as f64;
    let base = pitch_radius * stage.pressure_angle.cos();
    let (root, tip) = (pitch_radius - 1.25 * stage.module, pitch_radius + stage.module);
    let involute = |radius: f64| {
        let pressure = (base / radius).min(1.0).acos();
        pressure.tan() - pressure
    };
    let half = TAU / 4.0 / teeth as f64 + involute(pitch_radius);
    let start = base.max(root);
    let flank: Vec<[f64; 2]> = std::iter::once([root, half - involute(start)])
        .chain((0..=FLANK_POINTS).map(|i| {
            let radius = start + (tip - start) * i as f64 / FLANK_POINTS as f64;
            [radius, (half - involute(radius)).max(0.0)]
        }))
        .collect();
    let tooth = |k: usize| {
        let middle = angle + TAU * k as f64 / teeth as f64;
        let rising = flank.iter().map(move |[radius, side]| mm(*radius * unit(middle - side)));
        rising.chain(flank.iter().rev().map(move |[radius, side]| mm(*radius * unit(middle + side))))
    };
    Shape::Plate {
        outline: (0..teeth).flat_map(tooth).collect(),
        holes: Vec::new(),
        circles: if bore > 0.0 { vec![[0.0, 0.0, bore / MM]] } else { Vec::new() },
        z,
    }
}
