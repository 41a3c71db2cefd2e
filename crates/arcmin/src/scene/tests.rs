use super::*;
use crate::design::StageDesign;
use crate::machine::Kinematics;
use crate::templates::{NEMA17_19, tao2024};
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
    let (scene, stage) = (of_stage(&design), design.stage());
    let output = find(&scene, "output-pins");
    let Shape::Cylinders { at, .. } = &output.shapes[0] else { panic!("pins") };
    for crank in CRANKS {
        for disc in 0..stage.phases.len() {
            let body = find(&scene, &format!("disc-{disc}"));
            let holes = circles(body);
            for (pin, hole) in at.iter().zip(&holes[1..]) {
                let apart = placed(body, [hole[0], hole[1]], crank) - placed(output, *pin, crank);
                assert!((apart.norm() - scene.teeth.eccentricity_mm).abs() < 1e-9, "{apart}");
            }
        }
    }
}

/// No point of a drawn flank lies inside of a pin by more than chords and cut account for.
#[test]
fn drawn_flanks_stay_outside_of_the_pins() {
    let machine = crate::templates::design("rv-40e-81").unwrap().machine();
    let scene = of_machine(&machine);
    let body = find(&scene, "disc-1");
    let Shape::Lobes { lobe, count, .. } = &body.shapes[0] else { panic!("lobes") };
    let teeth = &scene.teeth;
    let mut nearest = f64::INFINITY;
    for crank in CRANKS {
        for k in 0..*count {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / *count as f64).sin_cos();
            for [x, y] in lobe {
                let point = placed(body, [cos * x - sin * y, sin * x + cos * y], crank);
                let pin = (point.y.atan2(point.x) / std::f64::consts::TAU * teeth.pin_count as f64).round();
                let centre =
                    teeth.pin_circle_radius_mm * unit(std::f64::consts::TAU * pin / teeth.pin_count as f64);
                nearest = nearest.min((point - centre).norm() - teeth.pin_radius_mm);
            }
        }
    }
    assert!(nearest > 0.0 && nearest < 0.1, "{nearest} mm");
}

#[test]
fn a_cage_between_equal_rings_turns_with_them_and_rolls_between_opposite_ones() {
    assert_eq!(cage_rate(40.0, 5.0, 0.3, 0.3), 0.3);
    // Inner ring alone: (d_m − d)/(2 d_m).
    assert!((cage_rate(40.0, 5.0, 1.0, 0.0) - 35.0 / 80.0).abs() < 1e-15);
}
