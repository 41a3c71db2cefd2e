use std::f64::consts::TAU;

use super::*;
use crate::design::{StageDesign, TwoRingDesign, TwoStageDesign};
use crate::machine::Kinematics;
use crate::templates::{NEMA17_19, TWO_RING_225, TWO_STAGE_500, tao2024};
use crate::units::MM;

const CRANKS: [f64; 4] = [0.0, 0.7, 3.1, -20.3];

fn circles(body: &Body) -> Vec<[f64; 3]> {
    match &body.shapes[0] {
        Shape::Lobes { circles, .. } => circles.clone(),
        other => panic!("{other:?}"),
    }
}

/// A place (mm) of a body in the ring, mm.
fn placed(body: &Body, [x, y]: [f64; 2], crank: f64) -> crate::geometry::Vec2 {
    let pose = body.motion.at(crank);
    let (sin, cos) = pose.angle.sin_cos();
    pose.centre / MM + crate::geometry::Vec2::new(cos * x - sin * y, sin * x + cos * y)
}

fn find<'a>(scene: &'a Scene, id: &str) -> &'a Body {
    scene.bodies.iter().find(|body| body.id == id).unwrap_or_else(|| panic!("no {id}"))
}

/// Discs move as the solvers move them, and their bores stay around the eccentrics.
#[test]
fn the_picture_of_a_reducer_moves_as_its_mechanism() {
    for machine in [tao2024(), crate::templates::design("rv-40e-81").unwrap().machine()] {
        let scene = of_machine(&machine);
        let kinematics: Kinematics = machine.kinematics();
        assert!(
            (scene.input_rate / scene.output_rate / kinematics.housing_fixed_ratio() - 1.0).abs() < 1e-12
        );
        for crank in CRANKS {
            for disc in 0..machine.disc_count() {
                let body = find(&scene, &format!("disc-{disc}"));
                let pose = kinematics.disc_pose(disc, crank, kinematics.nominal_output_angle(crank));
                let drawn = body.motion.at(crank);
                assert!(
                    (drawn.centre - pose.centre).norm() < 1e-12 && (drawn.angle - pose.angle).abs() < 1e-12
                );
                for (k, [x, y, _]) in circles(body).into_iter().take(machine.crankshafts().count).enumerate()
                {
                    let shaft = find(&scene, &format!("crankshaft-{k}"));
                    let Shape::Cylinders { at, .. } = &shaft.shapes[2 + disc] else { panic!("an eccentric") };
                    let apart = placed(body, [x, y], crank) - placed(shaft, at[0], crank);
                    assert!(apart.norm() < 1e-9, "crank {crank}, disc {disc}, shaft {k}: {apart}");
                }
            }
        }
    }
}

/// Holes stay around the output pins, an eccentricity apart, and flanks touch the pins they roll on.
#[test]
fn the_picture_of_a_single_stage_moves_as_its_mechanism() {
    let design = StageDesign::parse(NEMA17_19.text, "nema17-19.toml").unwrap();
    let (scene, stage) = (of_stage(&design), design.drive());
    let output = find(&scene, "output-pins");
    let Shape::Cylinders { at, .. } = &output.shapes[0] else { panic!("pins") };
    for crank in CRANKS {
        for disc in 0..stage.phases.len() {
            let body = find(&scene, &format!("disc-{disc}"));
            let holes = circles(body);
            for (pin, hole) in at.iter().zip(&holes[1..]) {
                let apart = placed(body, [hole[0], hole[1]], crank) - placed(output, *pin, crank);
                assert!((apart.norm() - scene.rings[0].eccentricity_mm).abs() < 1e-9, "{apart}");
            }
        }
    }
}

/// The shipped drive of two rings with so many stepped discs.
fn with_stepped_discs(discs: usize) -> TwoRingDesign {
    let text = TWO_RING_225.text.replace("\ncount = 1\n", &format!("\ncount = {discs}\n"));
    assert!(discs == 1 || text != TWO_RING_225.text);
    TwoRingDesign::parse(&text, "two-ring.toml").unwrap()
}

/// Scenes of all families, of two stepped discs too.
fn of_all_families() -> Vec<Scene> {
    let two_rings = TwoRingDesign::parse(TWO_RING_225.text, "two-ring.toml").unwrap();
    let two_stages = TwoStageDesign::parse(TWO_STAGE_500.text, "two-stage.toml").unwrap();
    // Two teeth of difference in a single stage, and in both rings of two.
    let [single, rings] = [
        (
            NEMA17_19.text,
            [("pin_count = 20 ", "pin_count = 22\ntooth_difference = 2 "), ("= 0.5\n", "= 0.9\n")],
        ),
        (
            TWO_RING_225.text,
            [
                ("pin_count = 16 ", "pin_count = 32\ntooth_difference = 2 "),
                ("pin_count = 15 ", "pin_count = 30\ntooth_difference = 2 "),
            ],
        ),
    ]
    .map(|(text, changes)| {
        let text = changes.into_iter().fold(text.to_owned(), |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replace(from, to)
        });
        text.replace("pin_radius_mm = 4 ", "pin_radius_mm = 2 ")
            .replace("pin_radius_mm = 4\n", "pin_radius_mm = 2\n")
    });
    vec![
        of_stage(&StageDesign::parse(&single, "single.toml").unwrap()),
        of_two_rings(&TwoRingDesign::parse(&rings, "rings.toml").unwrap()),
        of_machine(&crate::templates::design("rv-40e-81").unwrap().machine()),
        of_stage(&StageDesign::parse(NEMA17_19.text, "nema17-19.toml").unwrap()),
        of_two_rings(&two_rings),
        of_two_rings(&with_stepped_discs(2)),
        of_two_stages(&two_stages),
    ]
}

/// Discs and output of drives of eccentrics have the positions of the mechanism from which the solvers start.
#[test]
fn pictures_of_eccentrics_move_as_their_mechanisms() {
    let two_rings = TwoRingDesign::parse(TWO_RING_225.text, "two-ring.toml").unwrap();
    let three = with_stepped_discs(3);
    let two_stages = TwoStageDesign::parse(TWO_STAGE_500.text, "two-stage.toml").unwrap();
    for (scene, joints) in [
        (of_two_rings(&two_rings), two_rings.drive().joints().unwrap()),
        (of_two_rings(&three), three.drive().joints().unwrap()),
        (of_two_stages(&two_stages), two_stages.drive().joints().unwrap()),
    ] {
        let mut bodies: Vec<&str> =
            scene.rings.iter().flat_map(|ring| ring.flanks.iter().map(|flank| flank.body.as_str())).collect();
        bodies.dedup();
        if scene.rings[1].rate != 0.0 {
            bodies.truncate(scene.rings[0].flanks.len());
        }
        // After the discs, of two stages the shaft between them, and the output.
        let between = (scene.rings[1].rate == 0.0).then_some("input");
        for crank in CRANKS {
            let position = joints.nominal_position_at(crank);
            for (body, at) in bodies.iter().chain(&between).chain(&["output"]).zip(position.chunks(3)) {
                let pose = find(&scene, body).motion.at(crank);
                let apart = (pose.centre - crate::geometry::Vec2::new(at[0], at[1])).norm();
                assert!(apart < 1e-12 && (pose.angle - at[2]).abs() < 1e-12, "{body} {pose:?} {at:?}");
            }
        }
    }
}

/// In every ring of every family no point of a drawn flank is inside of a pin by more than the error of the chords and the depth of the cut.
#[test]
fn drawn_flanks_stay_outside_of_the_pins() {
    for scene in of_all_families() {
        for (number, ring) in scene.rings.iter().enumerate() {
            for (disc, flank) in ring.flanks.iter().enumerate() {
                let body = find(&scene, &flank.body);
                let is_own = |shape: &&Shape| matches!(shape, Shape::Lobes { ring, .. } if *ring == number);
                let Some(Shape::Lobes { lobe, count, .. }) = body.shapes.iter().find(is_own) else {
                    panic!("no flank of {}", flank.body)
                };
                let pitch = TAU / ring.pin_count as f64;
                let mut nearest = f64::INFINITY;
                for crank in CRANKS.map(|crank| crank / ring.eccentric_rate) {
                    let ahead = flank.row_deg * DEG + ring.rate * crank;
                    for k in 0..*count {
                        let (sin, cos) = (TAU * k as f64 / *count as f64).sin_cos();
                        for [x, y] in lobe {
                            let point = placed(body, [cos * x - sin * y, sin * x + cos * y], crank);
                            let pin = ((point.y.atan2(point.x) - ahead) / pitch).round();
                            let centre = ring.pin_circle_radius_mm * unit(pin * pitch + ahead);
                            nearest = nearest.min((point - centre).norm() - ring.pin_radius_mm);
                        }
                    }
                }
                assert!(nearest > 0.0 && nearest < 0.1, "{} disc {disc}: {nearest} mm", ring.name);
                // Positions of the pins as drawn.
                let of_disc = |body: &&Body| {
                    body.kind == Kind::Pins
                        && body.ring == Some(number)
                        && body.disc.is_none_or(|own| own == disc)
                };
                let pins = scene.bodies.iter().find(of_disc).expect("pins");
                let Shape::Cylinders { at, .. } = &pins.shapes[0] else { panic!("pins") };
                let crank = 3.1;
                let drawn = placed(pins, at[1], crank);
                let meant = ring.pin_circle_radius_mm * unit(pitch + flank.row_deg * DEG + ring.rate * crank);
                assert!((drawn - meant).norm() < 1e-9, "{} {drawn} {meant}", ring.name);
            }
        }
    }
}

/// In the exploded view the bodies of a family are separate, in the order of the power flow.
#[test]
fn a_drive_is_taken_apart_along_its_axis() {
    for scene in of_all_families() {
        let apart =
            |kind: Kind| scene.bodies.iter().filter(move |body| body.kind == kind).map(|body| body.apart_mm);
        let [first, last] = [f64::min, f64::max].map(|of| apart(Kind::Disc).reduce(of).unwrap());
        assert!(apart(Kind::Gear).chain(apart(Kind::Shaft)).any(|shaft| shaft < first));
        assert!(apart(Kind::Carrier).chain(apart(Kind::OutputRing)).any(|output| output > last));
    }
}

#[test]
fn a_cage_between_equal_rings_turns_with_them_and_rolls_between_opposite_ones() {
    assert_eq!(cage_rate(40.0, 5.0, 0.3, 0.3), 0.3);
    // Inner ring alone: (d_m − d)/(2 d_m).
    assert!((cage_rate(40.0, 5.0, 1.0, 0.0) - 35.0 / 80.0).abs() < 1e-15);
}
