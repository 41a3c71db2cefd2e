//! Single stages, and two of them in series.

use super::shapes::{around, cylinder, lobes, one_piece_ring, ring, rolling_elements, teeth};
use super::{Body, Flank, Kind, Motion, Ring, Scene, Shape, arm, cage_rate, take_apart};
use crate::design::{DiscSection, OutputPinsSection, StageDesign, TwoStageDesign};
use crate::geometry::unit;
use crate::machine::SingleStage;
use crate::units::{DEG, MM};

/// Parts of a stage for its picture.
struct StageParts<'a> {
    stage: &'a SingleStage,
    disc: &'a DiscSection,
    output_pins: &'a OutputPinsSection,
    /// Number and name of its ring; the name is the prefix of its results.
    ring: usize,
    name: &'static str,
    key: &'static str,
    /// Sections of the design: ring, disc, eccentric, its bearing, output pins.
    keys: [&'static str; 5],
    shaft: &'static str,
    plate: &'static str,
    /// Turns of its shaft per turn of the crank angle.
    rate: f64,
    /// First face of its first disc along the axis, mm.
    begin: f64,
    /// Length of the shaft before its ring, mm.
    shaft_before: f64,
    is_output: bool,
}

/// The solids of a stage, as far as they go along the axis.
struct StageSolids {
    bodies: Vec<Body>,
    ring: Ring,
    ends: [f64; 2],
    radius: f64,
}

/// Thickness of the plate of the output in widths of a disc.
const PLATE: f64 = 0.6;

impl StageParts<'_> {
    fn solids(&self) -> StageSolids {
        let (stage, rate) = (self.stage, self.rate);
        let output_rate = rate / stage.ratio();
        let width = *self.disc.width_mm;
        let face =
            |j: usize| [1.1 * width * j as f64, (1.1 * j as f64 + 1.0) * width].map(|z| self.begin + z);
        let faces: Vec<[f64; 2]> = (0..stage.phases.len()).map(face).collect();
        let ends = [self.begin - 0.1 * width, faces.last().map_or(0.0, |face| face[1]) + 0.1 * width];
        let thickness = PLATE * width;
        let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
        let (ring_radius, pin_radius) = (stage.ring_circle_radius, stage.ring_pin_radius);
        let outer = ring_radius + 3.0 * pin_radius;
        let pins = &stage.output_pins;
        let e = stage.profile.eccentricity;
        let bearing = &stage.eccentric;
        let [of_ring, of_disc, of_eccentric, of_bearing, of_pins] = self.keys;
        let (id, name) = (
            |id: &str| format!("{}{id}", self.key.replace('_', "-")),
            |name: String| if self.name.is_empty() { name } else { format!("{name}, {}", self.name) },
        );
        let own = |id_of: &str, of: &str, kind, keys: &[&'static str], motion, shapes| {
            Body::new(id(id_of), name(of.to_owned()), kind, keys, motion, shapes).of(self.ring, None)
        };
        let pins_of_ring = teeth(&stage.mesh, ends);
        let contour = one_piece_ring(&stage.mesh, 0.0, ends);
        let one_piece = contour.is_some();
        let named = if one_piece { "Teeth of the ring" } else { "Pins of the ring" };
        let solid = contour.unwrap_or_else(|| ring(outer, ring_radius + 0.5 * pin_radius, &[], ends));
        let mut bodies = vec![
            own("housing", "Ring", Kind::Housing, &[of_ring], Motion::default(), vec![solid]),
            own("pins", named, Kind::Pins, &[of_ring], Motion::default(), vec![pins_of_ring]),
        ];
        for (j, face) in faces.iter().enumerate() {
            let mounting = stage.mounting(j);
            let of = |body: Body| Body { disc: Some(j), with_output: false, ..body };
            let moved = |turn_deg: f64, turn_rate: f64| Motion {
                arms: vec![arm(e, stage.phases[j], rate)],
                turn_deg,
                turn_rate,
            };
            // The flank is cut at the mounting angle relative to the output; the holes are aligned with the output pins.
            let shapes = vec![lobes(self.ring, &stage.profile, &stage.openings, &[], -mounting, *face)];
            let motion = moved(mounting / DEG, output_rate);
            let disc =
                own(&format!("disc-{j}"), &format!("Disc {}", j + 1), Kind::Disc, &[of_disc], motion, shapes);
            bodies.push(Body { with_output: self.is_output, ..of(disc) });
            let cage = cage_rate(bearing.pitch_diameter, bearing.roller_diameter, rate, output_rate);
            bodies.push(of(own(
                &format!("eccentric-rollers-{j}"),
                &format!("Rolling elements of the eccentric bearing, disc {}", j + 1),
                Kind::Rollers,
                &[of_bearing],
                moved(0.0, cage),
                vec![rolling_elements(bearing, middle(*face))],
            )));
        }
        let inner = 0.5 * (bearing.pitch_diameter - bearing.roller_diameter);
        let shaft = (0.7 * (inner - e)).max(0.3 * inner);
        let eccentrics =
            faces.iter().zip(&stage.phases).map(|(face, phase)| cylinder(e * unit(*phase), inner, *face));
        let along = cylinder(0.0 * unit(0.0), shaft, [ends[0] - self.shaft_before, ends[1]]);
        let shapes = std::iter::once(along).chain(eccentrics).collect();
        bodies.push(own("input", self.shaft, Kind::Shaft, &[of_eccentric], Motion::turning(rate), shapes));
        let radius = *self.output_pins.pin_radius_mm;
        let at = around(pins.count, pins.circle_radius);
        let mut shapes = vec![Shape::Cylinders { at: at.clone(), radius, z: [ends[0], ends[1] + thickness] }];
        if pins.radius > radius * MM {
            shapes.extend(faces.iter().map(|face| Shape::Cylinders {
                at: at.clone(),
                radius: pins.radius / MM,
                z: *face,
            }));
        }
        let plate = ring(pins.circle_radius + 2.0 * pins.radius, 0.0, &[], [ends[1], ends[1] + thickness]);
        for (id, name, kind, shapes) in [
            ("output-pins", "Output pins", Kind::OutputPins, shapes),
            ("output", self.plate, Kind::Carrier, vec![plate]),
        ] {
            let body = own(id, name, kind, &[of_pins], Motion::turning(output_rate), shapes);
            bodies.push(Body { with_output: self.is_output, ..body });
        }
        let flank = |(j, face): (usize, &[f64; 2])| Flank {
            body: id(&format!("disc-{j}")),
            phase_deg: stage.phases[j] / DEG,
            row_deg: 0.0,
            middle_mm: middle(*face),
        };
        StageSolids {
            bodies,
            ring: Ring {
                name: self.name,
                key: self.key,
                one_piece,
                pin_count: stage.profile.pin_count,
                tooth_difference: stage.profile.tooth_difference,
                pin_circle_radius_mm: ring_radius / MM,
                pin_radius_mm: pin_radius / MM,
                eccentricity_mm: e / MM,
                rate: 0.0,
                eccentric_rate: rate,
                flanks: faces.iter().enumerate().map(flank).collect(),
            },
            ends: [ends[0], ends[1] + thickness],
            radius: outer / MM,
        }
    }
}

const ASSUMED: &str = "Places along the axis, the outside of the rings, shafts and plates of the output are not part of the \
                       design and drawn schematically.";

/// The solids of a single stage. The first disc begins at z = 0.
pub fn of_stage(design: &StageDesign) -> Scene {
    let stage = design.drive();
    let parts = StageParts {
        stage,
        disc: &design.disc,
        output_pins: &design.output_pins,
        ring: 0,
        name: "",
        key: "",
        keys: ["ring", "disc", "eccentric", "bearings.eccentric", "output_pins"],
        shaft: "Input shaft with its eccentrics",
        plate: "Plate of the output",
        rate: 1.0,
        begin: 0.0,
        shaft_before: 2.0 * PLATE * *design.disc.width_mm,
        is_output: true,
    };
    let StageSolids { mut bodies, ring, ends, radius } = parts.solids();
    let (output_rate, length_mm) = (1.0 / stage.ratio(), ends[1] - ends[0]);
    take_apart(&mut bodies, length_mm, stage.phases.len(), 0.0);
    Scene {
        bodies,
        rings: vec![ring],
        angle_name: "Eccentric angle",
        turns: 1,
        frame_rate: if design.is_driven_housing() { -output_rate } else { 0.0 },
        input_rate: 1.0,
        output_rate,
        length_mm,
        radius_mm: radius,
        assumed: ASSUMED.to_owned(),
    }
}

/// The solids of two stages in series. The first disc of the first begins at z = 0; the plate of its output carries the shaft
/// with the eccentrics of the second.
pub fn of_two_stages(design: &TwoStageDesign) -> Scene {
    let drive = design.drive();
    let parts = &design.first_stage;
    let width = *parts.disc.width_mm;
    let first = StageParts {
        stage: &drive.first,
        disc: &parts.disc,
        output_pins: &parts.output_pins,
        ring: 0,
        name: "first stage",
        key: "first_stage_",
        keys: [
            "first_stage.ring",
            "first_stage.disc",
            "first_stage.eccentric",
            "first_stage.bearings.eccentric",
            "first_stage.output_pins",
        ],
        shaft: "Input shaft with its eccentrics",
        plate: "Plate of the output pins",
        rate: 1.0,
        begin: 0.0,
        shaft_before: 2.0 * PLATE * width,
        is_output: false,
    }
    .solids();
    let wide = *design.disc.width_mm;
    let gap = 0.5 * wide;
    let second = StageParts {
        stage: &drive.second,
        disc: &design.disc,
        output_pins: &design.output_pins,
        ring: 1,
        name: "second stage",
        key: "",
        keys: ["ring", "disc", "eccentric", "bearings.eccentric", "output_pins"],
        shaft: "Shaft between the stages with its eccentrics",
        plate: "Plate of the output",
        rate: 1.0 / drive.first.ratio(),
        begin: first.ends[1] + gap + 0.1 * wide,
        shaft_before: gap,
        is_output: true,
    }
    .solids();
    // In the exploded view the stages are separated by the displacements of the plate of the first and of the
    // shaft of the second.
    let lengths = [&first, &second].map(|stage| stage.ends[1] - stage.ends[0]);
    let discs = [&drive.first, &drive.second].map(|stage| stage.phases.len());
    let away = [-lengths[0] * Kind::Carrier.apart(None), -lengths[1] * Kind::Shaft.apart(None)];
    let (mut bodies, mut others) = (first.bodies, second.bodies);
    take_apart(&mut bodies, lengths[0], discs[0], away[0]);
    take_apart(&mut others, lengths[1], discs[1], away[1]);
    bodies.append(&mut others);
    Scene {
        bodies,
        rings: vec![first.ring, second.ring],
        angle_name: "Eccentric angle",
        turns: drive.first.turns_to_repeat(),
        frame_rate: 0.0,
        input_rate: 1.0,
        output_rate: 1.0 / drive.ratio(),
        length_mm: second.ends[1] - first.ends[0],
        radius_mm: first.radius.max(second.radius),
        assumed: ASSUMED.to_owned(),
    }
}
