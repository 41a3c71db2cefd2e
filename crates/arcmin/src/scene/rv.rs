//! RV reducers.

use super::shapes::{around, cylinder, gear, lobes, prism, ring, rolling_elements, sector};
use super::{Body, Flank, Kind, Motion, Ring, Scene, Shape, arm, cage_rate, take_apart};
use crate::geometry::unit;
use crate::machine::{FixedMember, Kinematics, Machine, RollerBearing};
use crate::units::{DEG, MM};

/// The solids of an RV reducer. The input end of the carrier lies at z = 0, the gears before it.
pub fn of_machine(machine: &Machine) -> Scene {
    let kinematics = machine.kinematics();
    let output_rate = -1.0 / kinematics.lobe_count;
    let stage = &machine.gear_stage;
    let planets_per_sun = kinematics.planet_teeth / kinematics.sun_teeth;
    let input_rate = output_rate - planets_per_sun * (1.0 - output_rate);
    let solids = &machine.solids;
    let (carrier, housing) = (&solids.carrier, &solids.housing);
    let width = machine.disc.width / MM;
    let (plate, gap) = (carrier.plate_thickness / MM, carrier.gap / MM);
    let faces: Vec<[f64; 2]> = (0..machine.disc_count)
        .map(|j| {
            let low = plate + (0.1 + 1.1 * j as f64) * width;
            [low, low + width]
        })
        .collect();
    let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
    let gears = [-(stage.face_width / MM) - 0.1 * width, -0.1 * width];
    let circle = stage.centre_distance();
    let cranks = &machine.crankshafts;
    let places: Vec<f64> = (0..cranks.count)
        .map(|k| Kinematics::crankshaft_angle(cranks.first_angle, k, cranks.count))
        .collect();
    let mut bodies = vec![
        Body::new(
            "housing",
            "Housing",
            Kind::Housing,
            &["housing"],
            Motion::default(),
            vec![
                ring(
                    housing.body_radius,
                    machine.ring.pin_circle_radius + machine.ring.pin_radius,
                    &[],
                    [plate, plate + gap],
                ),
                ring(housing.body_radius, housing.seat_radius, &[], [0.0, plate]),
                ring(housing.body_radius, housing.seat_radius, &[], [plate + gap, 2.0 * plate + gap]),
            ],
        ),
        Body::new(
            "pins",
            "Pins of the ring",
            Kind::Pins,
            &["ring"],
            Motion::default(),
            vec![Shape::Cylinders {
                at: around(machine.ring.pin_count, machine.ring.pin_circle_radius),
                radius: machine.ring.pin_radius / MM,
                z: [plate, plate + gap],
            }],
        )
        .of(0, None),
    ];
    let bores = machine.disc_bores();
    for (j, face) in faces.iter().enumerate() {
        let mounting = kinematics.mounting_angle(j);
        // The flank is cut at the mounting angle relative to the carrier; bores and windows are aligned with the carrier.
        bodies.push(
            Body::new(
                format!("disc-{j}"),
                format!("Disc {}", j + 1),
                Kind::Disc,
                &["disc"],
                Motion {
                    arms: vec![arm(cranks.eccentricity, kinematics.phases[j], 1.0)],
                    turn_deg: mounting / DEG,
                    turn_rate: output_rate,
                },
                vec![lobes(0, &machine.profile(), &bores, &machine.disc.windows, -mounting, *face)],
            )
            .of(0, Some(j))
            .with_output(),
        );
    }
    let arm_bearing = &machine.bearings.turning_arm;
    let bore = machine.disc.crank_bore_radius;
    let raceway = bore - arm_bearing.roller_diameter - 0.5 * arm_bearing.clearance;
    // A design may leave the bearing out; the eccentric then fills the bore.
    let eccentric = if raceway > 0.0 { raceway } else { bore };
    let on_place = |k: usize| arm(circle, places[k], output_rate);
    for k in 0..cranks.count {
        let shaft = 0.5 * cranks.shaft_diameter;
        let mut shapes = vec![
            cylinder(0.0 * unit(0.0), shaft, [gears[0], 2.0 * plate + gap]),
            // A tooth of the sun points towards the planet: one of the planet's gaps must be there.
            gear(stage, stage.planet_teeth, planet_tooth(&kinematics, places[0], places[k]), shaft, gears),
        ];
        for (j, face) in faces.iter().enumerate() {
            shapes.push(cylinder(cranks.eccentricity * unit(kinematics.phases[j]), eccentric, *face));
        }
        bodies.push(Body::new(
            format!("crankshaft-{k}"),
            format!("Crankshaft {} with its planet gear", k + 1),
            Kind::Shaft,
            &["crankshafts", "gear_stage"],
            Motion { arms: vec![on_place(k)], turn_deg: 0.0, turn_rate: 1.0 },
            shapes,
        ));
        for (j, face) in faces.iter().enumerate().filter(|_| arm_bearing.roller_count > 0) {
            bodies.push(
                Body::new(
                    format!("arm-rollers-{k}-{j}"),
                    format!(
                        "Rolling elements of the turning-arm bearing, crankshaft {}, disc {}",
                        k + 1,
                        j + 1
                    ),
                    Kind::Rollers,
                    &["bearings.turning_arm"],
                    Motion {
                        arms: vec![on_place(k), arm(cranks.eccentricity, kinematics.phases[j], 1.0)],
                        turn_deg: 0.0,
                        turn_rate: rate(arm_bearing, 1.0, output_rate),
                    },
                    vec![rolling_elements(arm_bearing, middle(*face))],
                )
                .of(0, Some(j))
                .on(k),
            );
        }
        let support = &machine.bearings.crank_support;
        bodies.push(Body::new(
            format!("support-rollers-{k}"),
            format!("Rolling elements of the crank supports, crankshaft {}", k + 1),
            Kind::Rollers,
            &["bearings.crank_support"],
            Motion { arms: vec![on_place(k)], turn_deg: 0.0, turn_rate: rate(support, 1.0, output_rate) },
            [0.5 * plate, 1.5 * plate + gap].map(|z| rolling_elements(support, z)).into(),
        ));
    }
    let seats: Vec<[f64; 3]> = places
        .iter()
        .map(|angle| {
            let at = circle * unit(*angle);
            [at.x / MM, at.y / MM, carrier.crank_seat_radius / MM]
        })
        .collect();
    let face = |z| ring(carrier.plate_radius, carrier.centre_bore_radius, &seats, z);
    let pillars = carrier.pillars.iter().filter(|pillar| pillar.is_sound());
    bodies.push(
        Body::new(
            "carrier",
            "Carrier with pillars",
            Kind::Carrier,
            &["carrier"],
            Motion::turning(output_rate),
            [face([0.0, plate]), face([plate + gap, 2.0 * plate + gap])]
                .into_iter()
                .chain(pillars.map(|pillar| prism(sector(pillar), [plate, plate + gap])))
                .collect(),
        )
        .with_output(),
    );
    let row = &solids.main_rows.row;
    bodies.push(Body::new(
        "main-rollers",
        "Rolling elements of the main bearings",
        Kind::Rollers,
        &["bearings.main"],
        Motion::turning(rate(row, output_rate, 0.0)),
        [0.5 * plate, 1.5 * plate + gap].map(|z| rolling_elements(row, z)).into(),
    ));
    bodies.push(Body::new(
        "sun",
        "Sun gear",
        Kind::Gear,
        &["gear_stage"],
        Motion::turning(input_rate),
        vec![gear(stage, stage.sun_teeth, places.first().copied().unwrap_or(0.0), 0.0, gears)],
    ));
    let flank = |(j, face): (usize, &[f64; 2])| Flank {
        body: format!("disc-{j}"),
        phase_deg: kinematics.phases[j] / DEG,
        row_deg: 0.0,
        middle_mm: middle(*face),
    };
    let length_mm = 2.0 * plate + gap;
    take_apart(&mut bodies, length_mm, faces.len(), 0.0);
    Scene {
        bodies,
        rings: vec![Ring {
            name: "",
            key: "",
            one_piece: false,
            pin_count: machine.ring.pin_count,
            tooth_difference: 1,
            pin_circle_radius_mm: machine.ring.pin_circle_radius / MM,
            pin_radius_mm: machine.ring.pin_radius / MM,
            eccentricity_mm: cranks.eccentricity / MM,
            rate: 0.0,
            eccentric_rate: 1.0,
            flanks: faces.iter().enumerate().map(flank).collect(),
        }],
        angle_name: "Crank angle",
        turns: 1,
        frame_rate: match machine.fixed_member {
            FixedMember::Housing => 0.0,
            FixedMember::Carrier => -output_rate,
        },
        input_rate,
        output_rate,
        length_mm,
        radius_mm: housing.body_radius / MM,
        assumed: "Positions along the axis, teeth of the gears and sizes that the design does not give (carrier, housing, main \
                  bearings) are drawn by the rules of the elastic bodies."
            .to_owned(),
    }
}

fn rate(bearing: &RollerBearing, inner: f64, outer: f64) -> f64 {
    cage_rate(bearing.pitch_diameter, bearing.roller_diameter, inner, outer)
}

/// Angle of a tooth of the planet at `place`, such that one of its gaps meets the tooth of the sun on the line
/// of centres; the first tooth of the sun points to the first planet.
fn planet_tooth(kinematics: &Kinematics, first: f64, place: f64) -> f64 {
    let (sun, planet) =
        (std::f64::consts::TAU / kinematics.sun_teeth, std::f64::consts::TAU / kinematics.planet_teeth);
    // Distance of the nearest tooth of the sun from the line of centres, in teeth.
    let teeth = (place - first) / sun;
    let past = teeth - teeth.round();
    place + std::f64::consts::PI + planet * (0.5 + past)
}
