//! Orders of the transmission error caused by single manufacturing errors.
//!
//! With a fixed housing the crankshafts turn z_c times per output turn relative to the ring of pins and z_p
//! times relative to the carrier. A machine whose only errors are fixed to the housing therefore repeats after
//! 1/z_c of an output turn, one whose errors all rotate with carrier, discs and shafts after 1/z_p: their
//! transmission errors contain only multiples of z_c and of z_p. Combinations of both kinds give sums and
//! differences, with 1 among them. There are two exceptions: the stiffness of the bearings rotates with the
//! carrier and modulates errors of the ring by 2 z_p, and cages turn at other ratios.

use super::*;
use crate::dynamics::{JointSettings, order_spectrum};
use crate::geometry::{FlankDirection, FlankError, FlankHarmonic};
use crate::machine::{BoreError, DiscError, EccentricError, Machine, ManufacturingErrors, PinError, RunOut};
use crate::units::{ARCSEC, UM};

/// Amplitudes (rad) by order of one forward turn at rated torque, relative to the machine without errors.
fn orders(machine: &Machine, errors: &ManufacturingErrors) -> Vec<f64> {
    let curve = |errors: &ManufacturingErrors| {
        let settings = JointSettings { errors: errors.clone(), ..JointSettings::default() };
        let test = TransmissionSettings { positions: 1024, ..TransmissionSettings::new(machine) };
        error_curve(machine, &settings, test.positions, 1.0, machine.rated.torque).unwrap()
    };
    let (with, without) = (curve(errors), curve(&ManufacturingErrors::default()));
    let difference: Vec<(f64, f64)> =
        with.points.iter().zip(&without.points).map(|(a, b)| (a.0, a.1 - b.1)).collect();
    order_spectrum(&difference).unwrap().iter().map(|line| line.amplitude).collect()
}

fn machine() -> Machine {
    crate::templates::tao2024()
}

/// The strongest order, its amplitude, and the largest amplitude among the orders that are not multiples of
/// `base`.
fn strongest(orders: &[f64], base: usize) -> (usize, f64, f64) {
    let top = (1..400).max_by(|a, b| orders[*a].total_cmp(&orders[*b])).unwrap();
    let stray = (1..400_usize)
        .filter(|order| !order.is_multiple_of(base))
        .map(|order| orders[order])
        .fold(0.0, f64::max);
    (top, orders[top], stray)
}

/// Errors, the order with the largest amplitude, and the base of all of their orders.
fn check(name: &str, errors: &ManufacturingErrors, order: usize, base: usize, blur: f64) {
    let found = orders(&machine(), errors);
    let (top, amplitude, stray) = strongest(&found, base);
    assert_eq!(top, order, "{name}: {amplitude:e}, order {order} has {:e}", found[order]);
    assert!(stray < blur * amplitude, "{name}: {stray:e} against {amplitude:e}");
}

/// 80 − 78 = 2 and 80 + 78 = 158 reach 12 % of order 78.
const BY_BEARINGS: f64 = 0.15;
/// Rolling elements under a load that the error distributes differently: 1 % was found.
const BY_CAGES: f64 = 0.02;

fn one<T: Default + Clone>(error: T) -> Vec<T> {
    vec![error]
}

fn flank(order: usize, direction: FlankDirection) -> ManufacturingErrors {
    let harmonics = vec![FlankHarmonic { order, amplitude: 3.0 * UM, phase: 0.2, direction }];
    ManufacturingErrors {
        discs: one(DiscError { flank: FlankError { harmonics, measured: None }, bores: Vec::new() }),
        ..Default::default()
    }
}

/// A pin meshes with each of the two discs once per turn of the crankshafts relative to the ring: order 2 z_c,
/// as the discs are offset by half a turn.
#[test]
fn errors_of_the_ring_lie_at_multiples_of_the_lobe_count() {
    let mut pins = vec![PinError::default(); 40];
    pins[7].radial = 3.0 * UM;
    check(
        "one pin out of place",
        &ManufacturingErrors { pins: pins.clone(), ..Default::default() },
        78,
        39,
        BY_BEARINGS,
    );
    pins[7] = PinError { radius: -3.0 * UM, ..PinError::default() };
    check("one thin pin", &ManufacturingErrors { pins, ..Default::default() }, 78, 39, BY_BEARINGS);
    // Pitch of the pins in two waves around the ring: once per half turn of the crankshafts, in phase on both
    // discs.
    let wave = |i: usize| PinError {
        tangential: 3.0 * UM * (2.0 * std::f64::consts::TAU * i as f64 / 40.0).cos(),
        ..PinError::default()
    };
    check(
        "pitch of the pins in two waves",
        &ManufacturingErrors { pins: (0..40).map(wave).collect(), ..Default::default() },
        78,
        39,
        BY_BEARINGS,
    );
}

#[test]
fn errors_that_go_round_lie_at_multiples_of_the_pin_count() {
    check("radial run-out of a flank", &flank(1, FlankDirection::Inwards), 40, 40, BY_CAGES);
    check("pitch of a flank in one wave", &flank(1, FlankDirection::Around), 40, 40, BY_CAGES);
    check("pitch of a flank in three waves", &flank(3, FlankDirection::Around), 120, 40, BY_CAGES);
    let eccentric = EccentricError { eccentricity: 2.0 * UM, phase: 0.0 };
    check(
        "one eccentric",
        &ManufacturingErrors { eccentrics: vec![one(eccentric)], ..Default::default() },
        40,
        40,
        BY_CAGES,
    );
    check(
        "a journal",
        &ManufacturingErrors {
            journals: one(RunOut { amplitude: 2.0 * UM, phase: 0.3 }),
            ..Default::default()
        },
        40,
        40,
        BY_CAGES,
    );
    check(
        "a planet",
        &ManufacturingErrors { planets: one(RunOut { amplitude: UM, phase: 0.3 }), ..Default::default() },
        40,
        40,
        BY_CAGES,
    );
}

/// Errors common to all lobes or pins change the mean; their ripple has the order of one pin passing one lobe,
/// z_c z_p = 1560.
#[test]
fn common_errors_move_the_mean() {
    for (name, errors) in [
        ("pin circle", ManufacturingErrors { pin_circle_radius: UM, ..Default::default() }),
        ("pin radius", ManufacturingErrors { pin_radius: -UM, ..Default::default() }),
        ("profile common to all lobes", flank(39, FlankDirection::Normal)),
    ] {
        let found = orders(&machine(), &errors);
        let (top, amplitude, _) = strongest(&found, 1);
        // The remainder, mostly at 80, is due to the changed load sharing.
        assert!(found[0] > 8.0 * amplitude, "{name}: mean {:e}, order {top} {amplitude:e}", found[0]);
    }
}

/// The load acts on a disc perpendicular to the direction of its eccentric, so that an error common to all
/// eccentricities has little effect.
#[test]
fn a_common_eccentricity_error_has_little_effect() {
    let eccentric = EccentricError { eccentricity: UM, phase: 0.0 };
    let found = orders(
        &machine(),
        &ManufacturingErrors { eccentrics: vec![vec![eccentric; 2]; 2], ..Default::default() },
    );
    let (_, amplitude, _) = strongest(&found, 1);
    let one =
        orders(&machine(), &ManufacturingErrors { eccentrics: vec![vec![eccentric]], ..Default::default() });
    assert!(
        amplitude < 0.25 * one[40] && found[0] < 0.25 * one[40],
        "{amplitude:e} {:e} {:e}",
        found[0],
        one[40]
    );
}

/// A position error of a bore displaces the disc in a direction that rotates with the carrier, and turns it:
/// order z_p, and a change of the mean. The same error of both bores only turns the disc; errors of carrier
/// bores move gear stage and discs together.
#[test]
fn bores_lie_at_the_pin_count_or_move_the_mean() {
    let bore = BoreError { tangential: 3.0 * UM, ..BoreError::default() };
    let discs = |count: usize| ManufacturingErrors {
        discs: one(DiscError { bores: vec![bore; count], ..DiscError::default() }),
        ..Default::default()
    };
    check("one bore of a disc", &discs(1), 40, 40, BY_CAGES);
    for (name, errors) in [
        ("both bores of a disc", discs(2)),
        ("carrier", ManufacturingErrors { carrier_bores: one(bore), ..Default::default() }),
    ] {
        let found = orders(&machine(), &errors);
        let (_, amplitude, stray) = strongest(&found, 40);
        assert!(found[0] > 8.0 * amplitude, "{name}: {:e} {amplitude:e}", found[0]);
        assert!(stray < 0.02 * found[0], "{name}: {stray:e}");
    }
}

/// Order 1 needs both kinds: neither a run-out of the carrier nor a displaced pin circle causes it, both
/// together do, in proportion to each.
#[test]
fn order_one_is_the_difference_of_ring_and_carrier() {
    let machine = machine();
    let first = |carrier: f64, ring: f64| {
        let errors = ManufacturingErrors {
            carrier: RunOut { amplitude: carrier * UM, phase: 0.0 },
            pin_circle_offset: RunOut { amplitude: ring * UM, phase: 0.5 },
            ..Default::default()
        };
        orders(&machine, &errors)[1]
    };
    let both = first(5.0, 5.0);
    assert!(both > 0.05 * ARCSEC, "{both:e}");
    assert!(first(5.0, 0.0) < 0.02 * both && first(0.0, 5.0) < 0.02 * both);
    // The effect is bilinear for small errors.
    let half = first(2.5, 5.0) / both;
    assert!((half - 0.5).abs() < 0.1, "{half}");
}

/// The sun turns i − 1 times relative to the carrier. Its run-out has opposite signs at two opposite planets,
/// so that only unequal load sharing transmits it: i − 1 and its sums and differences with the turn of the
/// crankshafts.
#[test]
fn run_out_of_the_sun_has_the_order_of_its_relative_turn() {
    let errors =
        ManufacturingErrors { sun: RunOut { amplitude: 2.0 * UM, phase: 0.3 }, ..Default::default() };
    let found = orders(&machine(), &errors);
    let (top, amplitude, _) = strongest(&found, 1);
    assert!([40, 80, 120, 160].contains(&top), "{top} {amplitude:e}");
    // Less than a fiftieth of the run-out, as an angle at the output.
    assert!(amplitude < 0.02 * 2.0 * UM / machine().gear_stage.sun_base_radius());
    assert!(found[81] < 0.05 * amplitude, "{:e} {amplitude:e}", found[81]);
}

/// Three crankshafts pass an error fixed to the housing three times a turn. A displaced pin circle causes no
/// order 1 or 2, but 3.
#[test]
fn three_crankshafts_give_order_three_for_a_fixed_error() {
    let mut machine = machine();
    machine.crankshafts.count = 3;
    let errors = ManufacturingErrors {
        pin_circle_offset: RunOut { amplitude: 10.0 * UM, phase: 0.5 },
        ..Default::default()
    };
    let found = orders(&machine, &errors);
    let low = |order: usize| found[order];
    assert!(low(3) > 5.0 * low(1).max(low(2)), "{:e} {:e} {:e}", low(1), low(2), low(3));
    // A position error of one crankshaft removes the symmetry: order 1 appears.
    let bore = BoreError { tangential: 5.0 * UM, ..BoreError::default() };
    let found = orders(&machine, &ManufacturingErrors { carrier_bores: one(bore), ..errors });
    assert!(found[1] > 5.0 * low(1), "{:e} {:e}", found[1], low(1));
}
