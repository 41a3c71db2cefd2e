//! Which orders an elastic ring of pins brings into the transmission error.

use crate::fem::DiscShape;
use std::f64::consts::TAU;

use super::super::settle::creep;
use super::*;
use crate::dynamics::{ElasticDiscs, ElasticHousing, FlexibleOptions};
use crate::templates::tao2024;
use crate::units::ARCMIN;

/// A housing whose ring has only the compliance of the modes with the radial displacement `mean` + cos 2(β −
/// β₀) and the tangential one −½ sin 2(β − β₀), for every β₀ given.
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
    let discs = ElasticDiscs::free(
        &DiscShape::all(machine),
        crate::fem::tests::discs(machine),
        FlexibleOptions::default(),
    );
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

/// The load of the discs rotates z_c times per turn of the output. A ring with the same compliance in all
/// directions only adds a constant. One that becomes oval about one axis only repeats after a quarter turn and
/// causes order 4 z_c; one that opens on two opposite sides (as with two cut-outs) repeats after half a turn
/// and causes 2 z_c. The amplitudes grow with the torque and vanish with a stiff ring.
#[test]
#[ignore = "long"]
fn an_uneven_ring_brings_its_own_orders() {
    let machine = tao2024();
    let lobes = machine.ring.pin_count - 1;
    let (orders, torque) = ([2 * lobes, 4 * lobes], machine.rated.torque);
    let softness = 2e-10;
    let at = |housing: Option<ElasticHousing>, torque: f64| amplitudes(&machine, housing, torque, &orders);
    let rigid = at(None, torque);
    // Two axes 45° apart give the same compliance in all directions.
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

/// Compliance of the shipped housing on some bolts under the pin forces of two opposite discs with the
/// eccentrics at an angle, as harmonics over a turn of them relative to its mean: harmonic m has the order m
/// z_c of the output. The forces grow with the lever arm about the pitch point and pass through it. Each disc
/// loads its own share of the pins' length, or (`alike`) both discs load all of it.
fn lines_of_bolts(count: usize, alike: bool) -> Vec<f64> {
    const ANGLES: usize = 240;
    let machine = tao2024();
    let mut shape = crate::fem::HousingShape::of(&machine);
    shape.solid.bolt_count = count;
    shape.sizes = [1.2 * shape.sizes[0], 1.3 * shape.sizes[1]];
    let compliance = shape.compliance().unwrap();
    let pitch_radius = machine.crankshafts.eccentricity * shape.pin_count as f64;
    let at = |k: usize| {
        let mut forces = vec![0.0; compliance.count];
        for disc in 0..shape.disc_count {
            let turn = TAU * (k as f64 / ANGLES as f64 + disc as f64 / shape.disc_count as f64);
            let pitch_point = pitch_radius * crate::geometry::unit(turn);
            for pin in 0..shape.pin_count {
                let place = TAU * pin as f64 / shape.pin_count as f64;
                let out = crate::geometry::unit(place);
                let way = (shape.pin_circle_radius * out - pitch_point).normalize();
                let force = (place - turn).sin().max(0.0) * way;
                let planes = if alike { 0..shape.disc_count } else { disc..disc + 1 };
                let share = 1.0 / planes.len() as f64;
                for plane in planes {
                    forces[shape.pin(plane, pin)] += share * force.dot(&out);
                    forces[shape.pin(plane, pin) + 1] +=
                        share * force.dot(&crate::geometry::quarter_turn(out));
                }
            }
        }
        2.0 * compliance.energy(&forces)
    };
    let values: Vec<f64> = (0..ANGLES).map(at).collect();
    let mean = values.iter().sum::<f64>() / ANGLES as f64;
    let line = |order: usize| {
        let (mut re, mut im) = (0.0, 0.0);
        for (k, value) in values.iter().enumerate() {
            let (sin, cos) = (TAU * (k * order) as f64 / ANGLES as f64).sin_cos();
            (re, im) = (re + value * cos, im + value * sin);
        }
        2.0 * f64::hypot(re, im) / ANGLES as f64 / mean
    };
    (0..=20).map(line).collect()
}

/// Two bolts cause 2 z_c, four 4 z_c, sixteen almost nothing. Three would cause 6 z_c only (three-fold, even
/// for two opposite discs) if the housing were the same for both discs; but the flange is fixed on one side, so
/// that the planes of the discs differ, and 3 z_c also occurs.
#[test]
#[ignore = "long"]
fn bolts_bring_the_orders_of_their_number() {
    let largest = |lines: &[f64]| (1..lines.len()).max_by(|a, b| lines[*a].total_cmp(&lines[*b])).unwrap();
    for (bolts, order) in [(2, 2), (4, 4)] {
        let lines = lines_of_bolts(bolts, false);
        assert_eq!(largest(&lines), order, "{bolts}: {lines:?}");
        assert!(lines[order] > 0.2, "{bolts}: {lines:?}");
        let foreign = (1..=20).filter(|m| m % bolts != 0).map(|m| lines[m]).fold(0.0, f64::max);
        assert!(foreign < 1e-9, "{bolts}: {lines:?}");
    }
    let (apart, alike) = (lines_of_bolts(3, false), lines_of_bolts(3, true));
    assert_eq!((largest(&apart), largest(&alike)), (3, 6), "{apart:?} {alike:?}");
    // Orders that are not multiples of six come from the mesh, which with forty pins has no three-fold
    // symmetry.
    let foreign = (1..=20).filter(|m| m % 6 != 0).map(|m| alike[m]).fold(0.0, f64::max);
    assert!(foreign < 0.1 * alike[6], "{alike:?}");
    let even = lines_of_bolts(16, false);
    assert!(even[1..].iter().all(|line| *line < 1e-3), "{even:?}");
}
