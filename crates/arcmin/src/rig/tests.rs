use super::*;
use crate::dynamics::{JointSettings, SpectrumLine};
use crate::machine::Machine;
use crate::units::ARCMIN;

fn machine() -> Machine {
    let mut machine = crate::templates::rv_40e_81();
    machine.friction = Friction { regularisation_speed: machine.friction.regularisation_speed, ..ASSUMED_FRICTION };
    machine
}

/// A loop made by hand: straight branches of 100 N·m/arcmin, 0.2′ apart.
#[test]
fn figures_of_a_loop_made_by_hand() {
    let rated = 400.0;
    let point = |torque: f64, branch, shift: f64| LoopPoint { torque, angle: (torque / 100.0 + shift) * ARCMIN, branch };
    let torques: Vec<f64> = (0..=400).map(|step| -rated + 2.0 * f64::from(step)).collect();
    let falling = torques.iter().rev().map(|t| point(*t, Branch::Falling, 0.1));
    let rising = torques.iter().map(|t| point(*t, Branch::Rising, -0.1));
    let points: Vec<LoopPoint> = falling.chain(rising).collect();
    let figures = evaluate_loop(&points, rated).unwrap();
    assert!((figures.stiffness * ARCMIN / 100.0 - 1.0).abs() < 1e-9);
    assert!((figures.backlash / ARCMIN - 0.2).abs() < 1e-9);
    // Mid-points at ±12 N·m: 0.24′ apart.
    assert!((figures.lost_motion / ARCMIN - 0.24).abs() < 1e-9);
}

/// Published order for an RV-40E: lost motion below 1′, about 108 N·m/arcmin; 60 to 250 is believable for assumed bearings.
#[test]
fn val_lost_motion_and_stiffness_are_of_the_catalogues_order() {
    let machine = machine();
    let points = hysteresis_loop(&machine, &JointSettings::default(), 0.0).unwrap();
    let figures = evaluate_loop(&points, machine.rated.torque).unwrap();
    assert!(figures.lost_motion / ARCMIN > 0.05 && figures.lost_motion / ARCMIN < 1.0, "{}", figures.lost_motion / ARCMIN);
    assert!((60.0..250.0).contains(&(figures.stiffness * ARCMIN)), "{}", figures.stiffness * ARCMIN);
    assert!(figures.soft_stiffness < figures.stiffness);
}

#[test]
fn parts_of_the_compliance_add_up_to_the_whole() {
    let split = stiffness_split(&machine(), &JointSettings::default(), 0.0).unwrap();
    let sum: f64 = split.parts.iter().map(|(_, compliance)| compliance).sum();
    assert!((sum / split.whole - 1.0).abs() < 0.02, "{sum:e} {:e}", split.whole);
    assert!(split.parts.iter().all(|(_, compliance)| *compliance >= 0.0));
}

#[test]
fn efficiency_stays_below_one_and_falls_at_low_torque() {
    let map = efficiency_map(&machine(), &JointSettings::default()).unwrap();
    assert!(map.efficiency.iter().flatten().all(|value| (0.0..1.0).contains(value)));
    assert!((0.7..0.97).contains(&map.rated), "{}", map.rated);
}

#[test]
fn orders_are_named_by_their_causes() {
    let machine = machine();
    let named = |order: usize| name_orders(&[SpectrumLine { order, amplitude: 1e-6 }], &machine, 1)[0].cause.clone();
    assert!(named(1).contains("carrier"));
    assert!(named(39).contains("disc"));
    assert!(named(40).contains("pins"));
    assert!(named(80).contains("sun") && named(80).contains("2 × 40"));
}
