//! Wear of machines with manufacturing errors, with bearing joints.

use super::coupled::{CoupledOptions, CoupledWear, WearSnapshot};
use crate::dynamics::{BearingMeshing, JointSettings};
use crate::geometry::Relief;
use crate::load::ShareLoad;
use crate::machine::{Machine, ManufacturingErrors, PinError, RunOut, Tolerances};
use crate::units::{HOUR, UM};

fn meshing(machine: &Machine, errors: &ManufacturingErrors) -> BearingMeshing {
    BearingMeshing::new(machine, &JointSettings { errors: errors.clone(), ..JointSettings::default() })
        .unwrap()
}

/// Coarser steps than the default, the same in all compared computations.
const COARSE: CoupledOptions = CoupledOptions {
    flank_points: 720,
    pin_points: 1440,
    crank_positions: 15,
    depth_increment: 0.2e-6,
    increment_share: 0.01,
    tolerance: 0.01e-6,
    few_places: [0.08 * UM, 0.02],
    approach_share: 0.15,
};

fn worn(
    machine: &Machine,
    errors: &ManufacturingErrors,
    options: CoupledOptions,
    hours: f64,
) -> WearSnapshot {
    let exposure = machine.coupled_exposure(options).unwrap();
    let mut wear = CoupledWear::with(machine, meshing(machine, errors), options);
    wear.advance_to(exposure.at(hours * HOUR)).unwrap();
    wear.state().clone()
}

fn difference(a: &Relief, b: &Relief) -> f64 {
    a.samples().iter().zip(b.samples()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A ring 2 µm larger with a nominal disc is equivalent to a disc cut on a circle 2 µm smaller in a larger
/// ring: the contacts are the same, so the wear is the same, except for the width over which contacts average,
/// which follows the nominal ring (3e-5 of its radius).
#[test]
fn val_a_larger_pin_circle_wears_as_a_radial_offset() {
    let machine = crate::templates::tao2024();
    let errors = ManufacturingErrors { pin_circle_radius: 2.0 * UM, ..ManufacturingErrors::default() };
    let mut modified = machine.clone();
    modified.ring.pin_circle_radius += 2.0 * UM;
    modified.disc.modification.radial_offset -= 2.0 * UM;
    let (made, cut) = (
        worn(&machine, &errors, COARSE, 600.0),
        worn(&modified, &ManufacturingErrors::default(), COARSE, 600.0),
    );
    let depth = cut.flank().deepest().0;
    assert_eq!(made.flanks.len(), 1);
    assert!(
        difference(made.flank(), cut.flank()) < 1e-3 * depth,
        "{:e} of {depth:e}",
        difference(made.flank(), cut.flank())
    );
    // It differs from that of the machine without errors.
    let nominal = worn(&machine, &ManufacturingErrors::default(), COARSE, 600.0);
    assert!(
        difference(nominal.flank(), cut.flank()) > 0.02 * depth,
        "{:e} of {depth:e}",
        difference(nominal.flank(), cut.flank())
    );
}

/// One flank for each disc and one surface for each pin, for a machine whose discs differ by a negligible
/// error: each agrees with the common one, except for the difference between the crank positions of one disc
/// and of both.
#[test]
fn a_flank_per_disc_agrees_with_the_common_one() {
    let mut machine = crate::templates::tao2024();
    machine.wear.pin_ratio = 0.5;
    let nothing = ManufacturingErrors {
        carrier: RunOut { amplitude: 1e-15, phase: 0.0 },
        ..ManufacturingErrors::default()
    };
    let (each, common) = (
        worn(&machine, &nothing, COARSE, 300.0),
        worn(&machine, &ManufacturingErrors::default(), COARSE, 300.0),
    );
    assert_eq!((each.flanks.len(), each.pins.len(), common.flanks.len(), common.pins.len()), (2, 80, 1, 1));
    let depth = common.flank().deepest().0;
    for flank in &each.flanks {
        assert!(
            difference(flank, common.flank()) < 0.04 * depth,
            "{:e} of {depth:e}",
            difference(flank, common.flank())
        );
    }
    // Total removal from all pins: the mean of the single ones equals the common one.
    let metal = |pin: &Relief| pin.samples().iter().sum::<f64>();
    let mean = each.pins.iter().map(metal).sum::<f64>() / 80.0;
    assert!((mean / metal(common.pin()) - 1.0).abs() < 0.02, "{mean:e} {:e}", metal(common.pin()));
}

/// The initial rate of a displaced pin is k ∫ F |v_s| dt/B of its own contacts, summed here over 720 positions
/// around the ring; it is more than twice that of the others.
#[test]
fn val_a_displaced_pin_wears_by_its_own_load() {
    let mut machine = crate::templates::tao2024();
    machine.wear.pin_ratio = 1.0;
    let mut pins = vec![PinError::default(); 8];
    pins[7].radial = -3.0 * UM;
    let errors = ManufacturingErrors { pins, ..ManufacturingErrors::default() };
    let options = CoupledOptions { crank_positions: 240, ..COARSE };
    let mut wear = CoupledWear::with(&machine, meshing(&machine, &errors), options);
    let exposure = machine.coupled_exposure(options).unwrap().at(0.5 * HOUR);
    wear.advance_to(exposure).unwrap();
    let cell = std::f64::consts::TAU * machine.ring.pin_radius / options.pin_points as f64;
    let metal =
        |disc: usize, pin: usize| wear.state().pins[40 * disc + pin].samples().iter().sum::<f64>() * cell;
    let ring = meshing(&machine, &errors);
    let ring = ring.contacts();
    let speed = machine.kinematics().speeds(machine.rated.input_speed).0.abs();
    let cycle = meshing(&machine, &errors).whole_cycle(machine.rated.torque, 720).unwrap();
    for disc in 0..2 {
        let contacts = cycle
            .positions
            .iter()
            .flat_map(|position| &position.discs[disc])
            .filter(|contact| contact.pin == 7);
        let power: f64 = contacts.map(|c| c.force * ring.sliding_way(c) * speed).sum::<f64>() / 720.0;
        let expected = exposure * power / machine.disc.width;
        assert!(
            (metal(disc, 7) / expected - 1.0).abs() < 0.05,
            "disc {disc}: {:e} {expected:e}",
            metal(disc, 7)
        );
        let others = (0..40).filter(|pin| *pin != 7).map(|pin| metal(disc, pin)).sum::<f64>() / 39.0;
        assert!(metal(disc, 7) > 2.0 * others, "{:e} {others:e}", metal(disc, 7));
    }
}

/// Four times as many crank positions per update change the flank of a drawn machine by some per cent of its
/// largest depth.
#[test]
fn few_positions_per_update_are_sufficient_with_errors() {
    let machine = crate::templates::tao2024();
    let tolerances = Tolerances {
        pin_position: 3.0 * UM,
        pin_radius: UM,
        pin_circle_offset: 4.0 * UM,
        eccentricity: 2.0 * UM,
        ..Tolerances::default()
    };
    let errors = ManufacturingErrors::draw(&machine, &tolerances, 5);
    let of = |crank_positions: usize| {
        worn(&machine, &errors, CoupledOptions { crank_positions, ..CoupledOptions::default() }, 600.0)
    };
    let (few, many) = (of(15), of(60));
    for (few, many) in few.flanks.iter().zip(&many.flanks) {
        let (depth, difference) = (many.deepest().0, difference(few, many));
        assert!(difference < 0.1 * depth, "{difference:e} of {depth:e}");
        let metal = |flank: &Relief| flank.samples().iter().sum::<f64>();
        assert!((metal(few) / metal(many) - 1.0).abs() < 0.02, "{:e} {:e}", metal(few), metal(many));
    }
}
