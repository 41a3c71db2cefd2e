//! Drives of two rings.

use super::shapes::{cylinder, lobes, one_piece_ring, ring, rolling_elements, teeth};
use super::{Body, Flank, Kind, Motion, Ring, Scene, Shape, arm, cage_rate, take_apart};
use crate::design::TwoRingDesign;
use crate::geometry::unit;
use crate::machine::PinMounting;
use crate::units::{DEG, MM};

/// The solids of a drive of two rings. The first stepped disc begins at z = 0; each is mirrored against its neighbour, so that
/// steps of the same ring lie side by side, and the last step is that of the output.
pub fn of_two_rings(design: &TwoRingDesign) -> Scene {
    let drive = design.drive();
    let output_rate = 1.0 / drive.ratio();
    let [first, second] = &drive.meshes;
    let count = drive.phases.len();
    let widths = drive.widths.map(|width| width / MM);
    let gap = 0.05 * (widths[0] + widths[1]);
    // Faces of both steps of each disc.
    let faces = |j: usize| {
        let begin = j as f64 * (widths[0] + widths[1] + gap);
        if (count - j) % 2 == 1 {
            [[begin, begin + widths[0]], [begin + widths[0], begin + widths[0] + widths[1]]]
        } else {
            [[begin + widths[1], begin + widths[1] + widths[0]], [begin, begin + widths[1]]]
        }
    };
    let length = count as f64 * (widths[0] + widths[1] + gap) - gap;
    let thickness = 0.6 * widths[1];
    let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
    let outer = drive.meshes.each_ref().map(|mesh| mesh.ring_circle_radius + 3.0 * mesh.ring_pin_radius);
    let solid = |k: usize| {
        let mesh = &drive.meshes[k];
        let inner = mesh.ring_circle_radius + 0.5 * mesh.ring_pin_radius;
        let at = move |j: usize| {
            let (turn, face) = (if k == 0 { drive.row(j) } else { 0.0 }, faces(j)[k]);
            one_piece_ring(mesh, turn, face).unwrap_or_else(|| ring(outer[k], inner, &[], face))
        };
        (0..count).map(at)
    };
    let pins = |k: usize, j: usize| teeth(&drive.meshes[k], faces(j)[k]);
    let turning = Motion::turning(output_rate);
    let plate = ring(outer[1], 0.0, &[], [length, length + thickness]);
    let output: Vec<Shape> = solid(1).chain([plate]).collect();
    let mut bodies = vec![
        Body::new("housing", "First ring", Kind::Housing, &["ring"], Motion::default(), solid(0).collect())
            .of(0, None),
        Body::new(
            "output",
            "Second ring, the output",
            Kind::OutputRing,
            &["second_ring"],
            turning.clone(),
            output,
        )
        .of(1, None)
        .with_output(),
    ];
    let bearing = &drive.eccentric;
    let disc_rate = -1.0 / first.profile.lobes_per_turn();
    let e = first.profile.eccentricity;
    let inner = 0.5 * (bearing.pitch_diameter - bearing.roller_diameter);
    let mut eccentrics = Vec::new();
    for (j, phase) in drive.phases.iter().enumerate() {
        let [one, other] = faces(j);
        let row = Motion { turn_deg: drive.row(j) / DEG, ..Motion::default() };
        let of_disc = format!(", disc {}", j + 1);
        let pins_of = |k: usize, name: &str| {
            let (key, motion) = [("ring", row.clone()), ("second_ring", turning.clone())][k].clone();
            let id = format!("{}-pins-{j}", ["first", "second"][k]);
            let one_piece = drive.meshes[k].mounting == PinMounting::OnePiece;
            let named = if one_piece { "Teeth" } else { "Pins" };
            let name = format!("{named} of the {name} ring{}", if count > 1 { of_disc.as_str() } else { "" });
            Body::new(id, name, Kind::Pins, &[key], motion, vec![pins(k, j)]).of(k, Some(j))
        };
        bodies.push(pins_of(0, "first"));
        bodies.push(pins_of(1, "second").with_output());
        let arms = vec![arm(e, *phase, 1.0)];
        // By the second ring, whose pins all discs share.
        let turn_deg = -phase / second.profile.lobes_per_turn() / DEG;
        let step = |k: usize, face| lobes(k, &drive.meshes[k].profile, &drive.openings, &[], 0.0, face);
        bodies.push(
            Body::new(
                format!("disc-{j}"),
                format!("Stepped disc {}", j + 1),
                Kind::Disc,
                &["disc", "second_disc"],
                Motion { arms: arms.clone(), turn_deg, turn_rate: disc_rate },
                vec![step(0, one), step(1, other)],
            )
            .of(0, Some(j)),
        );
        let turn_rate = cage_rate(bearing.pitch_diameter, bearing.roller_diameter, 1.0, disc_rate);
        let both = [one[0].min(other[0]), one[1].max(other[1])];
        bodies.push(
            Body::new(
                format!("eccentric-rollers-{j}"),
                format!("Rolling elements of the eccentric bearing{of_disc}"),
                Kind::Rollers,
                &["bearings.eccentric"],
                Motion { arms, turn_deg: 0.0, turn_rate },
                vec![rolling_elements(bearing, middle(both))],
            )
            .of(0, Some(j)),
        );
        eccentrics.push(cylinder(e * unit(*phase), inner, both));
    }
    let shaft = cylinder(0.0 * unit(0.0), (0.7 * (inner - e)).max(0.3 * inner), [-2.0 * thickness, length]);
    let shapes = std::iter::once(shaft).chain(eccentrics).collect();
    let input = "Input shaft with its eccentrics";
    bodies.push(Body::new("input", input, Kind::Shaft, &["eccentric"], Motion::turning(1.0), shapes));
    let length_mm = length + thickness;
    take_apart(&mut bodies, length_mm, count, 0.0);
    for pins in bodies.iter_mut().filter(|body| body.kind == Kind::Pins && body.ring == Some(1)) {
        pins.apart_mm = length_mm * Kind::OutputRing.apart(None);
    }
    let ring_of = |k: usize| Ring {
        name: ["first ring", "second ring"][k],
        key: ["", "second_"][k],
        one_piece: drive.meshes[k].mounting == PinMounting::OnePiece,
        pin_count: drive.meshes[k].profile.pin_count,
        tooth_difference: drive.meshes[k].profile.tooth_difference,
        pin_circle_radius_mm: drive.meshes[k].ring_circle_radius / MM,
        pin_radius_mm: drive.meshes[k].ring_pin_radius / MM,
        eccentricity_mm: e / MM,
        rate: [0.0, output_rate][k],
        eccentric_rate: 1.0,
        flanks: (0..count)
            .map(|j| Flank {
                body: format!("disc-{j}"),
                phase_deg: drive.phases[j] / DEG,
                row_deg: if k == 0 { drive.row(j) / DEG } else { 0.0 },
                middle_mm: middle(faces(j)[k]),
            })
            .collect(),
    };
    Scene {
        bodies,
        rings: vec![ring_of(0), ring_of(1)],
        angle_name: "Eccentric angle",
        turns: 1,
        frame_rate: 0.0,
        input_rate: 1.0,
        output_rate,
        length_mm,
        radius_mm: outer[0].max(outer[1]) / MM,
        assumed: "Places along the axis, the outside of the rings, the shaft and the plate of the output are not part of the \
                  design and drawn schematically."
            .to_owned(),
    }
}
