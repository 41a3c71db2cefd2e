//! Which orders an elastic ring of pins brings into the transmission error.

use std::f64::consts::TAU;

use super::super::settle::creep;
use super::*;
use crate::dynamics::{ElasticDiscs, ElasticHousing, FlexibleOptions};
use crate::templates::rv_40e_81;
use crate::units::ARCMIN;

/// A housing whose ring gives way by radial `mean` + cos 2(β − β₀) and tangential −½ sin 2(β − β₀), for every
/// β₀ given, and by nothing else.
fn ovalising(machine: &Machine, softness: f64, mean: f64, axes: &[f64]) -> ElasticHousing {
    let (discs, pins) = (machine.disc_count, machine.ring.pin_count);
    let size = 2 * discs * pins;
    let wave = |axis: f64, i: usize| {
        let two = 2.0 * (TAU * (i / 2 % pins) as f64 / pins as f64 - axis);
        if i.is_multiple_of(2) { mean + two.cos() } else { -0.5 * two.sin() }
    };
    let at = |i: usize, j: usize| axes.iter().map(|axis| softness * wave(*axis, i) * wave(*axis, j)).sum();
    let values = (0..size * size).map(|k| at(k / size, k % size)).collect();
    ElasticHousing::new(machine, &Compliance { count: size, values }).unwrap()
}

/// Amplitudes in arcmin of the orders of the output turn at a torque.
fn amplitudes(machine: &Machine, housing: Option<ElasticHousing>, torque: f64, orders: &[usize]) -> Vec<f64> {
    const POSITIONS: usize = 400;
    let discs = ElasticDiscs::free(machine, crate::fem::tests::discs(machine), FlexibleOptions::default());
    let settings =
        JointSettings { discs: Some(discs.unwrap()), housing, damped: false, ..JointSettings::default() };
    let mut model = BearingJoints::held(machine, &settings).unwrap();
    model.set_load(torque);
    let errors: Vec<f64> = (0..POSITIONS)
        .map(|i| {
            let sun = TAU * machine.kinematics().ratio() * i as f64 / POSITIONS as f64;
            model.hold_sun(sun, 0.0);
            let q = creep(&model, 1e-3, &model.nominal_position_at(sun)).unwrap();
            model.output_error(&q) / ARCMIN
        })
        .collect();
    let line = |order: &usize| {
        let (mut re, mut im) = (0.0, 0.0);
        for (i, error) in errors.iter().enumerate() {
            let (sin, cos) = (TAU * (i * order) as f64 / POSITIONS as f64).sin_cos();
            re += error * cos;
            im += error * sin;
        }
        2.0 * f64::hypot(re, im) / POSITIONS as f64
    };
    orders.iter().map(line).collect()
}

/// The load of the discs goes round z_c times per turn of the output. A ring that gives way alike in all
/// directions only adds a constant. One that ovalises about one axis alone is the same after a quarter turn and
/// brings 4 z_c; one that opens on two opposite sides (as two cut-outs let it) is the same after half a turn and
/// brings 2 z_c. Lines grow with torque and vanish with a stiff ring.
#[test]
fn an_uneven_ring_brings_its_own_orders() {
    let machine = rv_40e_81();
    let lobes = machine.ring.pin_count - 1;
    let (orders, torque) = ([2 * lobes, 4 * lobes], machine.rated.torque);
    let softness = 2e-10;
    let at = |housing: Option<ElasticHousing>, torque: f64| amplitudes(&machine, housing, torque, &orders);
    let rigid = at(None, torque);
    // Two axes 45° apart are alike in all directions.
    let even = at(Some(ovalising(&machine, softness, 0.0, &[0.0, 0.125 * TAU])), torque);
    let one_axis = at(Some(ovalising(&machine, softness, 0.0, &[0.0])), torque);
    let opening = ovalising(&machine, softness, 1.0, &[0.0]);
    let open = at(Some(opening.clone()), torque);
    let half = at(Some(opening.clone()), 0.5 * torque);
    let stiff = at(Some(opening.stiffened(1e3).unwrap()), torque);
    println!("2 z_c, 4 z_c: rigid {rigid:?}, even {even:?}, one axis {one_axis:?}, open {open:?} {half:?}");
    let (twice, fourfold) = (open[0] - rigid[0], one_axis[1] - rigid[1]);
    assert!(twice > 20.0 * rigid[0] && fourfold > 5.0 * rigid[1], "{open:?} {one_axis:?} {rigid:?}");
    assert!(
        (even[0] - rigid[0]).abs() < 0.05 * twice && (even[1] - rigid[1]).abs() < 0.2 * fourfold,
        "{even:?}"
    );
    assert!((one_axis[0] - rigid[0]).abs() < 0.05 * twice, "{one_axis:?}");
    assert!((stiff[0] - rigid[0]).abs() < 0.01 * twice, "{stiff:?}");
    assert!(half[0] / open[0] > 0.3 && half[0] / open[0] < 0.7, "{half:?} {open:?}");
}
