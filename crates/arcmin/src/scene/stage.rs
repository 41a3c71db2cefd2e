//! Single stages.

use super::shapes::{around, cylinder, lobes, ring, rolling_elements};
use super::{Body, Kind, Motion, Scene, Shape, Teeth, arm, cage_rate};
use crate::design::StageDesign;
use crate::geometry::unit;
use crate::units::{DEG, MM};

/// The solids of a single stage. The first disc begins at z = 0.
pub fn of_stage(design: &StageDesign) -> Scene {
    let stage = design.stage();
    let output_rate = 1.0 / stage.ratio();
    let width = *design.disc.width_mm;
    let faces: Vec<[f64; 2]> =
        (0..stage.phases.len()).map(|j| [1.1 * width * j as f64, (1.1 * j as f64 + 1.0) * width]).collect();
    let ends = [-0.1 * width, faces.last().map_or(0.0, |face| face[1]) + 0.1 * width];
    let thickness = 0.6 * width;
    let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
    let (ring_radius, pin_radius) = (stage.ring_circle_radius, stage.ring_pin_radius);
    let outer = ring_radius + 3.0 * pin_radius;
    let pins = &stage.output_pins;
    let e = stage.profile.eccentricity;
    let bearing = &stage.eccentric;
    let body = |id: &str, name: &str, kind, keys, motion, shapes| Body {
        id: id.to_owned(),
        name: name.to_owned(),
        kind,
        disc: None,
        keys,
        motion,
        shapes,
    };
    let mut bodies = vec![
        body(
            "housing",
            "Ring",
            Kind::Housing,
            vec!["ring"],
            Motion::default(),
            vec![ring(outer, ring_radius + 0.5 * pin_radius, &[], ends)],
        ),
        body(
            "pins",
            "Pins of the ring",
            Kind::Pins,
            vec!["ring"],
            Motion::default(),
            vec![Shape::Cylinders {
                at: around(stage.profile.pin_count, ring_radius),
                radius: pin_radius / MM,
                z: ends,
            }],
        ),
    ];
    for (j, face) in faces.iter().enumerate() {
        let mounting = stage.mounting(j);
        let motion = Motion {
            arms: vec![arm(e, stage.phases[j], 1.0)],
            turn_deg: mounting / DEG,
            turn_rate: output_rate,
        };
        // Cut against the output by the mounting angle: the holes keep to the pins of the output.
        let shapes = vec![lobes(&stage.profile, &stage.openings, &[], -mounting, *face)];
        bodies.push(Body {
            disc: Some(j),
            ..body(&format!("disc-{j}"), &format!("Disc {}", j + 1), Kind::Disc, vec!["disc"], motion, shapes)
        });
        let motion = Motion {
            arms: vec![arm(e, stage.phases[j], 1.0)],
            turn_deg: 0.0,
            turn_rate: cage_rate(bearing.pitch_diameter, bearing.roller_diameter, 1.0, output_rate),
        };
        bodies.push(Body {
            disc: Some(j),
            ..body(
                &format!("eccentric-rollers-{j}"),
                &format!("Rolling elements of the eccentric bearing, disc {}", j + 1),
                Kind::Rollers,
                vec!["bearings.eccentric"],
                motion,
                vec![rolling_elements(bearing, middle(*face))],
            )
        });
    }
    let inner = 0.5 * (bearing.pitch_diameter - bearing.roller_diameter);
    let shaft = (0.7 * (inner - e)).max(0.3 * inner);
    let eccentrics =
        faces.iter().zip(&stage.phases).map(|(face, phase)| cylinder(e * unit(*phase), inner, *face));
    bodies.push(body(
        "input",
        "Input shaft with its eccentrics",
        Kind::Shaft,
        vec!["eccentric"],
        Motion::turning(1.0),
        std::iter::once(cylinder(0.0 * unit(0.0), shaft, [ends[0] - 2.0 * thickness, ends[1]]))
            .chain(eccentrics)
            .collect(),
    ));
    let radius = *design.output_pins.pin_radius_mm;
    let at = around(pins.count, pins.circle_radius);
    let mut shapes = vec![Shape::Cylinders { at: at.clone(), radius, z: [ends[0], ends[1] + thickness] }];
    if pins.radius > radius * MM {
        shapes.extend(faces.iter().map(|face| Shape::Cylinders {
            at: at.clone(),
            radius: pins.radius / MM,
            z: *face,
        }));
    }
    bodies.push(body(
        "output-pins",
        "Output pins",
        Kind::OutputPins,
        vec!["output_pins"],
        Motion::turning(output_rate),
        shapes,
    ));
    bodies.push(body(
        "output",
        "Plate of the output",
        Kind::Carrier,
        vec!["output_pins"],
        Motion::turning(output_rate),
        vec![ring(pins.circle_radius + 2.0 * pins.radius, 0.0, &[], [ends[1], ends[1] + thickness])],
    ));
    Scene {
        bodies,
        teeth: Teeth {
            pin_count: stage.profile.pin_count,
            pin_circle_radius_mm: ring_radius / MM,
            pin_radius_mm: pin_radius / MM,
            eccentricity_mm: e / MM,
            phases_deg: stage.phases.iter().map(|phase| phase / DEG).collect(),
            middles_mm: faces.iter().copied().map(middle).collect(),
        },
        frame_rate: if design.is_driven_housing() { -output_rate } else { 0.0 },
        input_rate: 1.0,
        output_rate,
        length_mm: ends[1] + thickness - ends[0],
        radius_mm: outer / MM,
        assumed: "Places along the axis, the outside of the ring, the shaft and the plate of the output are not part of the \
                  design and drawn for the eye."
            .to_owned(),
    }
}
