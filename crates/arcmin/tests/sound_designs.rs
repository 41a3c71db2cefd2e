//! Designs that pass the checks are solved: some random ones, and those with earlier failures.

// The survey uses the other items.
#[allow(dead_code)]
#[path = "support/run.rs"]
mod run;
mod support;

use arcmin::design::Design;
use arcmin::dynamics::{BearingMeshing, JointSettings};
use arcmin::fidelity::{Fidelity, Joints};
use arcmin::geometry::Relief;
use arcmin::life::{LifeOptions, predict};
use arcmin::load::ShareLoad;
use arcmin::machine::{CrankAngle, Machine};
use arcmin::progress::Silent;
use arcmin::rig;
use arcmin::wear::calibrate::coupled_exposure;
use arcmin::wear::paper::PaperWear;
use arcmin::wear::{CoupledOptions, CoupledWear};
use run::{Analysis, Outcome, run};

fn design(name: &str) -> Design {
    let path = format!("{}/tests/designs/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    Design::parse(&std::fs::read_to_string(path).unwrap(), name).unwrap()
}

/// The RV-40E with another equidistant offset in µm.
fn rv_40e_with_offset(offset_um: f64) -> Machine {
    let design = arcmin::templates::design("tao2024").unwrap();
    design.with("disc.modification.equidistant_offset_um", offset_um).unwrap().machine()
}

/// Load sharing with ideal joints and with bearings. `examples/survey.rs` runs any number of designs through
/// all analyses.
#[test]
fn random_sound_designs_share_their_load() {
    for seed in 1..=6 {
        let (design, _) = support::sound_design(seed);
        assert_eq!(run(&design, Analysis::Contact), Outcome::Result, "seed {seed}");
    }
}

#[test]
fn hard_designs_share_their_load() {
    for name in [
        "one_disc_radial_interference",
        "both_offsets_interfere_at_the_tips",
        "small_ring_with_a_wide_gap",
        "ten_pins_four_discs",
    ] {
        assert_eq!(run(&design(name), Analysis::Contact), Outcome::Result, "{name}");
    }
}

/// With any coefficient a duty without speed causes no wear: a constant life curve, no error.
#[test]
fn a_duty_without_speed_wears_nothing() {
    let machine = design("duty_without_speed").machine();
    let meshing = machine.meshing(&Relief::uniform(0.0));
    let exposure = coupled_exposure(&machine, meshing.clone(), CoupledOptions::default()).unwrap();
    let mut wear = CoupledWear::with(&machine, meshing, CoupledOptions::default());
    wear.advance_to(exposure.at(machine.limits().service_life)).unwrap();
    assert!(wear.state().flank().is_zero());
    let paper = PaperWear::deep_enough(&machine, 7500.0).unwrap();
    assert_eq!(paper.depth_at(7500.0), 0.0);
}

/// Coefficients ten thousand times too large: a defined outcome, with the state before it kept.
#[test]
fn wear_that_runs_away_is_reported() {
    let machine = design("runs_away").machine();
    let wear = PaperWear::deep_enough(&machine, 7500.0).unwrap();
    let (hours, depth) = wear.runs_away.expect("it does not run away");
    assert!(hours > 0.0 && hours < 7500.0 && depth > 100e-6, "{hours} {depth}");
    assert!((wear.depth_at(hours) / depth - 1.0).abs() < 1e-9);
    assert_eq!(wear.depth_at(0.0), 0.0);
}

/// The preload of a machine with bearings that are rigid except for the teeth equals that of ideal joints; the
/// clearance of real bearings takes up a part of it.
#[test]
fn val_bearings_and_ideal_joints_agree_on_interference() {
    let machine = rv_40e_with_offset(-8.0);
    let ideal = machine.meshing(&Relief::uniform(0.0)).cycle(412.0, 6).unwrap().mean_play().arcmin();
    let mut bearings = BearingMeshing::new(&machine, &JointSettings::default()).unwrap();
    let real = bearings.whole_cycle(412.0, 6).unwrap();
    assert!(real.mean_play().arcmin() < 0.0 && real.max_preload() > 1000.0);
    assert!((real.mean_play().arcmin() / ideal - 1.0).abs() < 0.02, "{} {ideal}", real.mean_play().arcmin());
}

/// The bench from a twentieth of a micrometre of interference to the same gap, by either offset: the lost
/// motion increases without a jump; half a micrometre of interference takes up the clearance of the bearings.
#[test]
fn lost_motion_on_the_bench_passes_through_zero_without_a_jump() {
    // Smallest reduction by half a micrometre of interference: for the RV-80E the play 2 Δ/(e z_c) = 0.06′
    // itself.
    for (template, least) in [("tao2024", 0.1), ("rv-80e", 0.06)] {
        let design = arcmin::templates::design(template).unwrap();
        // Compared with flanks without modification.
        let design = design.with("disc.modification.equidistant_offset_um", 0.0).unwrap();
        let design = design.with("disc.modification.radial_offset_um", 0.0).unwrap();
        for (key, sign) in [("equidistant_offset_um", 1.0), ("radial_offset_um", -1.0)] {
            let lost_motion = |gap_um: f64| {
                let key = format!("disc.modification.{key}");
                let machine = design.with(&key, sign * gap_um).unwrap().machine();
                let machine = machine.with_friction(rig::assumed_friction(&machine)).unwrap();
                let points = rig::hysteresis_loop(&machine, &JointSettings::default(), 0.0).unwrap();
                let figures = rig::evaluate_loop(&points, machine.rated().torque.abs()).unwrap();
                figures.lost_motion * 180.0 * 60.0 / std::f64::consts::PI
            };
            let all: Vec<f64> = [-0.5, -0.05, 0.0, 0.05].map(lost_motion).to_vec();
            assert!(all[0] < all[1] - least, "{template} {key}: {all:?}");
            for pair in all[1..].windows(2) {
                assert!(pair[1] > pair[0] && pair[1] - pair[0] < 0.012, "{template} {key}: {all:?}");
            }
        }
    }
}

/// Pins with worn grooves beside an edge that no contact reaches: equilibria are found at all steps, and
/// finally over a turn of the crankshafts with a residual of 1e-6 of the torque.
#[test]
fn deep_grooves_of_the_pins_leave_every_balance() {
    let machine = design("four_discs_wearing_pins").machine();
    let options = CoupledOptions { depth_increment: 0.8e-6, ..CoupledOptions::default() };
    let joints = BearingMeshing::new(&machine, &JointSettings::default()).unwrap();
    let exposure = coupled_exposure(&machine, joints.clone(), options).unwrap();
    let mut wear = CoupledWear::with(&machine, joints, options);
    wear.advance_to(exposure.at(machine.limits().service_life)).unwrap();
    assert!(wear.state().pin().deepest().0 > 10e-6, "{:?}", wear.state().pin().deepest());
    // The flank does not reach the whole depth of the groove.
    assert!(wear.state().effective_pin().deepest().0 < wear.state().pin().deepest().0);
    let cycle = wear.meshing_mut().whole_cycle(machine.rated().torque, 24).unwrap();
    let left = cycle.positions.iter().map(|position| position.residual.abs()).fold(0.0, f64::max);
    assert!(left < 1e-6 * machine.rated().torque, "{left}");
}

/// A hysteresis loop of designs with bodies within their clearances, with friction.
#[test]
fn hard_designs_run_on_the_test_bench() {
    for name in [
        "one_disc_loose_in_its_bearings",
        "four_crankshafts_wide_clearance",
        "carrier_at_rest_with_clearances",
        "ten_pins_four_discs",
    ] {
        let machine = design(name).machine();
        let kinematics = machine.kinematics();
        // Four positions of the crankshafts on one of their turns relative to the ring.
        let turn = std::f64::consts::TAU * kinematics.housing_fixed_ratio() / kinematics.lobe_count;
        for quarter in 0..4 {
            let points =
                rig::hysteresis_loop(&machine, &JointSettings::default(), 0.25 * f64::from(quarter) * turn)
                    .unwrap_or_else(|error| panic!("{name} {quarter}: {error}"));
            let figures = rig::evaluate_loop(&points, machine.rated().torque.abs()).unwrap();
            assert!(figures.stiffness > 0.0 && figures.lost_motion > 0.0, "{name} {quarter}: {figures:?}");
            assert!(figures.work > -1e-9, "{name} {quarter}: {figures:?}");
        }
    }
}

/// Flanks that turn back have hollows beside the root, in which a pin has two contacts: the whole bench with
/// friction, also near zero load.
#[test]
fn pins_in_hollows_leave_every_balance_on_the_bench() {
    assert_eq!(run(&design("one_disc_flanks_turned_back"), Analysis::Rig), Outcome::Result);
}

/// A drawn machine whose discs have a very small rotational stiffness: small terms that the tangents of
/// equilibria neglect (the slope of flank errors) decide whether the output has a stiffness.
#[test]
fn weakly_supported_discs_have_a_stiffness() {
    assert_eq!(run(&design("three_discs_hardly_held"), Analysis::Drawn), Outcome::Result);
}

/// Flanks worn into waves of the size of their grid, with a gap beside the seam in an earlier version, so that
/// forces jumped.
#[test]
#[ignore = "long"]
fn causes_add_up_on_wavy_flanks() {
    assert_eq!(run(&design("flanks_worn_in_waves"), Analysis::Life), Outcome::Result);
}

/// Flanks worn into the shape of worn pins: the normal turns fast with the disc, and the relief of the pin must
/// not follow it.
#[test]
#[ignore = "long"]
fn causes_add_up_where_flanks_fit_worn_pins() {
    let machine = design("flanks_that_fit_worn_pins").machine();
    let fidelity = Fidelity { joints: Joints::Bearings, ..Fidelity::ideal() };
    // The steps that lead to its surfaces.
    let wear = CoupledOptions { approach_share: f64::INFINITY, ..CoupledOptions::default() };
    let options = LifeOptions { wear, ..LifeOptions::default() };
    let prediction = predict(&machine, &fidelity, options, &Silent, |_| ()).unwrap();
    for point in &prediction.points {
        let split = point.causes.unwrap().lost_motion;
        assert!(split.residual().abs() <= 1e-3 * split.whole, "{} h: {split:?}", point.hours());
    }
}

/// Load sharing with friction is the equilibrium from which the bench computes the efficiency: its input
/// torques give the same efficiency.
#[test]
fn val_friction_in_load_sharing_is_that_of_the_bench() {
    let machine = arcmin::templates::tao2024();
    let machine = machine.with_friction(rig::assumed_friction(&machine)).unwrap();
    let settings = JointSettings::default();
    let mut running = BearingMeshing::running(&machine, &settings).unwrap();
    let (ratio, speed) = (machine.kinematics().ratio(), machine.rated().input_speed);
    let mut sum = 0.0;
    for i in 0..8 {
        let crank = -std::f64::consts::TAU * f64::from(i) / 8.0;
        let (q, _) = running.balance(CrankAngle::from_radians(crank), machine.rated().torque, None).unwrap();
        let model = running.model();
        let velocity = model.nominal_velocity_at(ratio * -crank / machine.kinematics().lobe_count, speed);
        let mut force = vec![0.0; q.len()];
        sum += model.evaluate_with_input(0.0, &q, &velocity, &mut force, None).1;
    }
    let efficiency = machine.rated().torque / (ratio * sum / 8.0);
    let bench = rig::efficiency_map(&machine, &settings).unwrap().rated;
    assert!((efficiency - bench).abs() < 1e-6 && efficiency < 0.97, "{efficiency} {bench}");
    // The play is read without friction, where both branches coincide.
    let mut smooth = BearingMeshing::new(&machine, &settings).unwrap();
    let crank = CrankAngle::from_radians(0.4);
    assert_eq!(running.travel(crank).unwrap(), smooth.travel(crank).unwrap());
    let rough = running.share(crank, 412.0, None).unwrap().0;
    let smooth = smooth.share(crank, 412.0, None).unwrap().0;
    assert!((rough.max_force() / smooth.max_force() - 1.0).abs() > 1e-3);
}

/// A light preload wears off: the play increases from negative values through zero, preload and lost motion
/// have no jump, and the causes of lost motion add up at all steps.
#[test]
fn preload_wears_off_without_a_jump() {
    let machine = rv_40e_with_offset(-2.0);
    let options =
        LifeOptions { intervals: 10, crank_positions: 6, search_factor: 1.0, ..LifeOptions::default() };
    let life = predict(&machine, &Fidelity::ideal(), options, &Silent, |_| ()).unwrap();
    let travel: Vec<_> = life.points.iter().map(|point| point.travel.unwrap()).collect();
    let (new, worn) = (travel[0], travel[10]);
    assert!(new.play.arcmin() < 0.0 && new.preload > 100.0);
    // Flanks are not loaded at roots and tips and do not wear there: at some crank positions the preload
    // remains after the mean play over all positions has become positive.
    assert!(worn.play.arcmin() > 0.0 && worn.preload < new.preload, "{} {}", worn.preload, new.preload);
    for (pair, travel) in life.points.windows(2).zip(travel.windows(2)) {
        let (before, after) = (travel[0], travel[1]);
        let rise = after.play.arcmin() - before.play.arcmin();
        // A micrometre of relief is some 0.065 arcmin of play.
        let worn = (pair[1].accuracy.max_depth - pair[0].accuracy.max_depth) * 1e6;
        assert!(rise > 0.0 && rise < 0.1 * worn + 1e-3, "{rise} {worn}");
        // The pins that remain preloaded take over the load of those that become free: the largest force first
        // rises slightly.
        assert!(after.preload < 1.1 * before.preload, "{} {}", after.preload, before.preload);
        let change = pair[1].lost_motion.arcmin() - pair[0].lost_motion.arcmin();
        assert!(change.abs() < 0.1, "{change}");
    }
    for point in &life.points {
        let split = point.causes.unwrap().lost_motion;
        assert!(split.residual().abs() < 1e-4 * split.whole, "{} of {}", split.residual(), split.whole);
    }
}
