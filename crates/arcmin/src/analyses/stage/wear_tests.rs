//! Wear and life of single stages.

use super::meshing::WearingRing;
use super::tests::{bench, design, number};
use super::*;
use crate::analyses::NoHost;
use crate::analyses::propose::{Demand, Process, propose};
use crate::dynamics::StageMeshing;
use crate::geometry::Relief;
use crate::load::ShareLoad;
use crate::machine::StageFriction;
use crate::progress::Silent;
use crate::templates::NEMA17_19;
use crate::units::HOUR;
use crate::units::UM;
use crate::wear::CoupledOptions;
use std::f64::consts::TAU;

fn worn(design: &StageDesign, options: &str) -> wear::StageWear {
    wear::run(design, &wear::Options::parse(options, "test").unwrap(), &NoHost).unwrap()
}

/// A drive of other teeth, material and gaps: discs of PLA, proposed for 15 : 1 and 8 N·m in 80 mm, with a coefficient.
fn printed(coefficient: f64) -> StageDesign {
    let demand = Demand {
        ratio: 15.0,
        tooth_difference: 1,
        torque: 8.0,
        outer_diameter_mm: 80.0,
        process: Process::PrintedFdm,
        speed_rpm: 300.0,
    };
    let design = StageDesign::parse(&propose(demand, &NoHost).unwrap().text, "printed.toml").unwrap();
    design.with_all([("wear.coupled.coefficient_per_pa", coefficient)]).unwrap()
}

/// Metal lost per time is k Σ F |v| of all contacts: forces from static equilibria, sliding speeds from the difference of
/// neighbouring ones.
#[test]
#[ignore = "long"]
fn metal_lost_is_the_work_of_sliding() {
    for (design, coefficient) in [(design(&[]), 1e-18), (printed(1e-15), 1e-15)] {
        let share = loss_over_work_of_sliding(&design, coefficient, 0);
        assert!((share - 1.0).abs() < 1e-3, "{share}");
    }
}

/// Volume lost by the flanks in one ring.
pub(super) fn loss_over_work_of_sliding<D: EccentricDrive>(
    design: &D,
    coefficient: f64,
    number: usize,
) -> f64 {
    // So little wear that forces are constant, with positions at all places of the period: 15
    // positions leave 4 of 19 out.
    let options = CoupledOptions { crank_positions: 38, depth_increment: 1e-9, ..CoupledOptions::default() };
    let mut courses = super::meshing::courses(design, &[], options).unwrap();
    courses.advance_to(1e-3, &Silent).unwrap();
    let hours = 0.03e-6 / courses.states()[number].deepest() * 1e-3;
    courses.advance_to(hours, &Silent).unwrap();
    assert!(courses.rings()[number].updates() > 20, "{}", courses.rings()[number].updates());
    let WearingRing { case, mut meshing, .. } = design.wearing_rings(&[]).unwrap().swap_remove(number);
    let state = courses.states().swap_remove(number);
    let (profile, flanks) = (&case.profile, &state.surfaces.flanks);
    let section = |flank: &Relief| -> f64 {
        let arc = crate::wear::FlankArc::new(profile, flank.samples().len());
        flank.samples().iter().enumerate().map(|(cell, depth)| depth * arc.cell_width(cell)).sum()
    };
    // One flank for all discs, or one for each.
    let section = flanks.iter().map(section).sum::<f64>() / flanks.len() as f64;
    let lost = section * profile.lobe_count() as f64 * case.disc_width * case.disc_count as f64;
    let unit = StageFriction { ring: 1.0, output: 0.0, pin_over_roller: 0.0, bearing: 0.0 };
    // Period of all contacts: for a single stage z_c pin pitches, in which the output turns by one pitch.
    let period = meshing.pattern_period() * meshing.pitches() as f64;
    let (stage, stages) = (meshing.number(), meshing.joints().stages().len());
    let (positions, step) = (720, 1e-3);
    let (mut work, mut friction) = (0.0, 0.0);
    for index in 0..positions {
        let angle = period * index as f64 / positions as f64;
        let [behind, here, ahead] =
            [-step, 0.0, step].map(|way| meshing.rest(angle + way, case.rated_torque, None).unwrap().0);
        let motion: Vec<f64> = behind.iter().zip(&ahead).map(|(a, b)| (b - a) / (2.0 * step)).collect();
        work += meshing.joints().sliding_power(stage, &here, &motion) / positions as f64;
        friction += meshing.joints().losses(&here, &vec![unit; stages])[stage].ring / positions as f64;
    }
    // With errors the speed of the disc deviates slightly from the nominal one, in both directions.
    let within = if design.is_even() { 1e-4 } else { 1e-3 };
    // Pins that reach or leave the corner of a tip change their direction of sliding within a step of the difference.
    let within = if profile.tip().is_some() { 5.0 * within } else { within };
    assert!((friction / work - 1.0).abs() < within, "{friction} {work}");
    let expected = coefficient * work * case.duty[0].input_speed.abs() * hours * HOUR;
    lost / expected
}

/// A depth h removed from the whole flank increases the play by 2 h/(e z_c); the contact forces do not change.
#[test]
#[ignore = "long"]
fn an_even_depth_opens_the_play_by_its_closed_form() {
    // Printed: a tenth of the eccentricity.
    let deep = 0.1 * printed(1e-15).drive().profile.eccentricity;
    for (design, depth) in [(design(&[]), 5e-6), (printed(1e-15), 50e-6), (printed(1e-15), deep)] {
        let tight = ["output_pins.hole_clearance_um", "bearings.eccentric.clearance_um"];
        let design = design.with_all(tight.map(|key| (key, 0.0))).unwrap();
        let (stage, torque) = (design.drive(), design.rated().torque);
        let mut meshing = StageMeshing::new(stage, None, torque, 1.0).unwrap();
        let mut free = |relief: f64| {
            meshing.set_relief(stage.relief.plus(&Relief::uniform(relief)));
            meshing.free_cycle(torque, 36).unwrap().mean_free_travel().radians()
        };
        let grown = free(depth) - free(0.0);
        let closed = 2.0 * depth / (stage.profile.eccentricity * stage.profile.lobe_count() as f64);
        assert!((grown / closed - 1.0).abs() < 0.05, "{grown} {closed}");
    }
}

/// Flanks of a printed drive lose a tenth of the eccentricity and more; the life is computed to its end.
#[test]
#[ignore = "long"]
fn a_printed_drive_wears_deep() {
    let design = printed(3e-15);
    let life = life::run(&design, &life::Options::parse("points = 4", "test").unwrap(), &NoHost).unwrap();
    let depth = life.last().accuracy.max_depth;
    assert!(life.prediction.runs_away.is_none() && life.prediction.points.len() == 5);
    assert!(depth > 0.08 * design.drive().profile.eccentricity, "{depth:e}");
    let lost: Vec<f64> = life.prediction.points.iter().map(|point| point.lost_motion.arcmin()).collect();
    assert!(lost.windows(2).all(|pair| pair[1] > pair[0]), "{lost:?}");
}

/// The hours after which a printed drive that runs in has lost a tenth of its eccentricity, by bisection: contact and bench have
/// results there, and the play has increased by less than for the same depth on the whole flank, 2 h/(e z_c). A drive that
/// runs in wears like one without running-in after the longer time t + (f − 1) T (1 − e^(−t/T)).
#[test]
#[ignore = "long"]
fn wear_of_a_tenth_of_the_eccentricity_has_results() {
    let running_in = [("wear.running_in.factor", 5.0), ("wear.running_in.duration_h", 40.0)];
    let steady = printed(3e-15);
    let design = steady.with_all(running_in).unwrap();
    let profile = &design.drive().profile;
    let depth_after = |design: &StageDesign, hours: f64| {
        let found = worn(design, &format!("hours = {hours}\npoints = 1"));
        number(&found, "max_depth_um") * UM
    };
    let wanted = 0.1 * profile.eccentricity;
    let (mut low, mut high) = (1.0_f64, 20_000.0_f64);
    while high / low > 1.01 {
        let middle = (low * high).sqrt();
        if depth_after(&design, middle) < wanted { low = middle } else { high = middle }
    }
    let depth = depth_after(&design, low);
    assert!((depth / wanted - 1.0).abs() < 0.02, "{depth:e} after {low} h");
    let equivalent = low + 4.0 * 40.0 * (1.0 - (-low / 40.0).exp());
    let same = depth_after(&steady, equivalent);
    assert!((depth / same - 1.0).abs() < 0.01, "{depth:e} {same:e}");
    let rig = |hours: f64| {
        let options = format!("hours = {hours}\npositions = 2\nte_positions = 8");
        rig::run(&design, &rig::Options::parse(&options, "test").unwrap(), &NoHost).unwrap()
    };
    let opened = rig(low).play[1] - rig(0.0).play[1];
    let closed = 2.0 * depth / (profile.eccentricity * profile.lobe_count() as f64);
    assert!(opened < 1.05 * closed && opened > 0.3 * closed, "{opened} {closed}");
    let options = format!("hours = {low}\npositions = 12");
    let loaded = contact::run(&design, &contact::Options::parse(&options, "test").unwrap(), &NoHost).unwrap();
    assert!(number(&loaded, "max_force_n") > 0.0);
}

/// With the output at rest and 20/19 of torque and speed, pins and flanks have the same forces and sliding distances.
#[test]
fn a_driven_housing_has_the_wear_of_its_ring() {
    let at_rest = design(&[]);
    let torque = format!("rated_torque_n_m = {}", 3.0 * 20.0 / 19.0);
    let speed = format!("input_speed_rpm = {}", 600.0 * 20.0 / 19.0);
    let driven = design(&[
        ("fixed_member = \"ring\" ", "fixed_member = \"output\" "),
        ("rated_torque_n_m = 3", torque.as_str()),
        ("input_speed_rpm = 600", speed.as_str()),
    ]);
    let depth = |design: &StageDesign| {
        worn(design, "discs = \"rigid\"\nhours = 200\npoints = 1").last().accuracy.max_depth
    };
    let (one, other) = (depth(&at_rest), depth(&driven));
    assert!(one > 0.1e-6 && (other / one - 1.0).abs() < 1e-6, "{one:e} {other:e}");
}

/// The new drive of the life is that of the bench; the bearing lasts longer than under the closed form of its force, which takes
/// all pins as equal springs.
#[test]
#[ignore = "long"]
fn a_life_begins_with_the_lost_motion_of_the_bench() {
    let design = design(&[]);
    let options = life::Options::parse("points = 4", "test").unwrap();
    let life = life::run(&design, &options, &NoHost).unwrap();
    let (new, bench) = (life.first().lost_motion.arcmin(), number(&bench(&design), "lost_motion_arcmin"));
    assert!((new / bench - 1.0).abs() < 0.02, "{new} {bench}");
    assert!(life.verdict.ok() && life.last().lost_motion > life.first().lost_motion);
    let (stage, rated) = (design.drive(), design.rated());
    let turns = rated.input_speed / TAU * design.eccentric_turns();
    let closed = crate::rig::rating_life(&stage.eccentric, stage.eccentric_force(rated.torque), turns) / HOUR;
    let found = life.bearings.worst().unwrap().life_h;
    assert!(found > closed && found < 2.5 * closed, "{found} {closed}");
    // Twice the speed takes half the hours.
    let faster = StageDesign::parse(&NEMA17_19.text.replace("rpm = 600", "rpm = 1200"), "test.toml").unwrap();
    let faster = life::run(&faster, &options, &NoHost).unwrap();
    assert!((found / faster.bearings.worst().unwrap().life_h / 2.0 - 1.0).abs() < 1e-9);
}

#[test]
fn a_missing_wear_coefficient_is_an_error() {
    let design = design(&[("[wear.coupled]\ncoefficient_per_pa = 1e-18 ", "# ")]);
    let error = life::run(&design, &life::Options::parse("", "test").unwrap(), &NoHost).unwrap_err();
    assert!(error.to_string().contains("no wear coefficient"), "{error}");
}
