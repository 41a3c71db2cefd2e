use super::labels::{CRANK_BENDING, CRANK_SUPPORT, INPUT_SHAFT, TURNING_ARM};
use super::*;
use crate::contact::ContactLaw;
use crate::dynamics::{
    EquilibriumControl, IdealJoints, Model, Part, Reducer, Run, RunPlan, RunResult, StepControl, System,
    solve_equilibrium,
};
use crate::fem::DiscShape;
use crate::machine::{FixedMember, RunOut};
use crate::progress::Silent;
use crate::random_designs::sound_design;
use crate::units::ARCMIN;

pub(super) fn machine() -> Machine {
    let mut machine = crate::templates::tao2024();
    machine.contact_law = ContactLaw::Linear { stiffness: 2.85e8 };
    machine
}

/// Compliance of one part, 0 if it has none.
pub(super) fn of(parts: &[(Part, f64)], part: Part) -> f64 {
    parts.iter().filter(|(own, _)| *own == part).map(|(_, compliance)| compliance).sum()
}

pub(super) fn settle(model: &BearingJoints, sun: f64) -> Vec<f64> {
    let control = EquilibriumControl { tolerance: 1e-9, ..EquilibriumControl::default() };
    solve_equilibrium(&**model, 0.0, &model.nominal_position_at(sun), control).unwrap().position
}

/// Every force compared with the numerical derivative of the stored energy, every tangent with that of the
/// forces.
#[test]
fn forces_and_tangents_derive_from_the_energy() {
    for fixed_member in [FixedMember::Housing, FixedMember::Carrier] {
        forces_and_tangents(Machine { fixed_member, ..machine() }, None);
    }
    let (linear, hertz) = (machine().contact_law, ContactLaw::LineHertz);
    for (contact_law, fixed_member) in
        [(linear, FixedMember::Housing), (hertz, FixedMember::Housing), (hertz, FixedMember::Carrier)]
    {
        let machine = Machine { contact_law, fixed_member, ..machine() };
        let options = crate::dynamics::FlexibleOptions::default();
        let discs =
            ElasticDiscs::free(&DiscShape::all(&machine), crate::fem::tests::discs(&machine), options)
                .unwrap();
        forces_and_tangents(machine, Some(discs));
    }
}

fn forces_and_tangents(mut machine: Machine, discs: Option<ElasticDiscs>) {
    // Run-outs make all arms nonzero.
    let run_out = RunOut { amplitude: 3e-6, phase: 0.4 };
    let errors = ManufacturingErrors {
        carrier: run_out,
        sun: run_out,
        journals: vec![run_out; 2],
        ..ManufacturingErrors::default()
    };
    machine.carrier.torsional_stiffness = 5e6;
    machine.ring.seat_compliance = 1e-9;
    // Tangents of an elastic disc do not contain the curvature of its deformed flank.
    let tolerance = if discs.is_some() { 2e-3 } else { 1e-3 };
    let mut model = BearingJoints::held(
        &machine,
        &JointSettings { damped: false, errors, discs, ..JointSettings::default() },
    )
    .unwrap();
    let sun = 2.0;
    model.hold_sun(sun, 0.0);
    model.set_load(412.0);
    let q = settle(&model, sun);
    let n = q.len();
    let rest = vec![0.0; n];
    let (mut f, mut lin) = (vec![0.0; n], model.linearisation());
    let mut scratch = model.linearisation();
    model.evaluate(0.0, &q, &rest, &mut f, &mut lin);
    let scale = model.scale().to_vec();
    for i in 0..n {
        let h = 1e-4 * scale[i];
        let (mut up, mut down) = (q.clone(), q.clone());
        up[i] += h;
        down[i] -= h;
        let (mut fu, mut fd) = (vec![0.0; n], vec![0.0; n]);
        let bu = model.evaluate(0.0, &up, &rest, &mut fu, &mut scratch);
        let bd = model.evaluate(0.0, &down, &rest, &mut fd, &mut scratch);
        let load = if i == model.output_index() { 412.0 } else { 0.0 };
        let force = -(bu.stored - bd.stored) / (2.0 * h) - load;
        let size = lin.stiffness(i, i) * scale[i];
        assert!((force - f[i]).abs() < 2e-4 * size, "force {i}: {force} {} of {size}", f[i]);
        for j in 0..n {
            let k = -(fu[j] - fd[j]) / (2.0 * h);
            let size = (lin.stiffness(i, i) * lin.stiffness(j, j)).abs().sqrt();
            assert!(
                (k - lin.stiffness(j, i)).abs() < tolerance * size,
                "stiffness {j} {i}: {k} {}",
                lin.stiffness(j, i)
            );
        }
    }
}

/// Contribution of friction of bearings and gears to the tangent, compared with the derivative of their forces.
#[test]
fn friction_follows_the_loads_in_the_tangent() {
    let mut machine = machine();
    (machine.friction.flank, machine.friction.pin_seat) = (0.0, 0.0);
    machine.friction.bearing = 0.01;
    machine.friction.gear_mesh = 0.05;
    let model = |share: f64| {
        let settings = JointSettings { damped: false, ..JointSettings::default() };
        let mut model = BearingJoints::held(&machine, &settings).unwrap();
        model.hold_sun(2.0, 0.0);
        model.set_load(412.0);
        model.with_friction(share)
    };
    let (rough, smooth) = (model(1.0), model(0.0));
    let q = settle(&smooth, 2.0);
    let ahead = smooth.nominal_position_at(2.01);
    let v: Vec<f64> =
        ahead.iter().zip(smooth.nominal_position_at(2.0)).map(|(b, a)| (b - a) / 1e-4).collect();
    let n = q.len();
    let forces = |model: &BearingJoints, q: &[f64]| {
        let (mut force, mut linearisation) = (vec![0.0; n], model.linearisation());
        model.evaluate(0.0, q, &v, &mut force, &mut linearisation);
        (force, linearisation)
    };
    let of_friction = |q: &[f64]| -> Vec<f64> {
        forces(&rough, q).0.iter().zip(forces(&smooth, q).0).map(|(r, s)| r - s).collect()
    };
    let (rough_tangent, smooth_tangent) = (forces(&rough, &q).1, forces(&smooth, &q).1);
    let scale = rough.scale();
    let (mut largest, mut worst) = (0.0_f64, 0.0_f64);
    for j in 0..n {
        let h = 1e-4 * scale[j];
        let moved = |sign: f64| {
            let mut place = q.clone();
            place[j] += sign * h;
            of_friction(&place)
        };
        let (up, down) = (moved(1.0), moved(-1.0));
        for i in 0..n {
            let unit = scale[i] * scale[j];
            let slope = -(up[i] - down[i]) / (2.0 * h) * unit;
            let added = (rough_tangent.stiffness(i, j) - smooth_tangent.stiffness(i, j)) * unit;
            largest = largest.max(slope.abs());
            worst = worst.max((slope - added).abs());
        }
    }
    assert!(largest > 0.0 && worst < 1e-3 * largest, "{worst:e} of {largest:e}");
}

/// Bearings, shafts and supports a million times stiffer, without clearance: the transmission error of ideal
/// joints.
#[test]
fn val_stiff_bearings_are_ideal_joints() {
    let mut machine = machine();
    machine.bearings.turning_arm.clearance = 0.0;
    let settings = JointSettings { stiffness_scale: 1e6, damped: false, ..JointSettings::default() };
    for sun in [0.0, 1.3, 7.7] {
        for torque in [412.0, -206.0] {
            let mut model = BearingJoints::held(&machine, &settings).unwrap();
            model.hold_sun(sun, 0.0);
            model.set_load(torque);
            let q = settle(&model, sun);
            let bearings = model.output_error(&q) / ARCMIN;
            // The sun is rotated to its angle and at rest there, because a moving sun would cause damping in
            // the mesh.
            let drive = Drive::SpeedTable(
                crate::dynamics::TimeTable::new("speed", &[(0.0, 2.0 * sun), (1.0, 0.0)]).unwrap(),
            );
            let ideal = IdealJoints::new(
                &machine,
                &Relief::uniform(0.0),
                drive,
                OutputLoad::Constant { torque },
                0.0,
            )
            .unwrap();
            let output = sun / 81.0;
            let rest =
                solve_equilibrium(&ideal, 1.0, &[-39.0 * output, output], EquilibriumControl::default())
                    .unwrap();
            let expected = ideal.transmission_error(1.0, &rest.position, &[0.0, 0.0]) / ARCMIN;
            assert!((bearings - expected).abs() < 1e-4, "{sun} {torque}: {bearings} {expected}");
        }
    }
}

#[test]
fn split_adds_up_to_the_tangent_compliance() {
    let machine = crate::templates::tao2024();
    let mut model =
        BearingJoints::held(&machine, &JointSettings { damped: false, ..JointSettings::default() }).unwrap();
    model.set_load(412.0);
    let q = settle(&model, 0.0);
    let n = q.len();
    let (mut f, mut lin) = (vec![0.0; n], model.linearisation());
    model.evaluate(0.0, &q, &vec![0.0; n], &mut f, &mut lin);
    let mut motion = vec![0.0; n];
    motion[model.output_index()] = 1.0;
    let weights = crate::dynamics::Weights { mass: 0.0, damping: 0.0, stiffness: 1.0 };
    lin.solve(&vec![0.0; n], weights, &mut motion).unwrap();
    let parts = model.split(&q, &motion);
    let whole = motion[model.output_index()];
    let sum: f64 = parts.iter().map(|part| part.1).sum();
    assert!((sum / whole - 1.0).abs() < 1e-9, "{sum} {whole}");
    // Bearings and shafts have nearly all of the compliance; no part is negative except for rounding.
    assert!(parts.iter().all(|(_, part)| *part > -1e-12 * whole));
    let share = |part: Part| of(&parts, part) / whole;
    assert!(share(TURNING_ARM.part) + share(CRANK_SUPPORT.part) + share(CRANK_BENDING) > 0.9);
}

/// Tangent compliance of the output by differences of the forces, compared with equilibria under slightly
/// larger and smaller torques: the RV-40E and random machines with drawn errors. The tangent of the equilibrium
/// search omits small terms. (Only the output is compared: without friction the position of a shaft without
/// load is arbitrary.)
#[test]
fn tangent_by_differences_is_that_of_equilibria() {
    let tolerances = crate::templates::design("tao2024").unwrap().drawing_tolerances().unwrap();
    let random = (1..=12).map(|seed| (seed, sound_design(seed).0.machine()));
    for (seed, machine) in std::iter::once((0, machine())).chain(random) {
        let errors = ManufacturingErrors::draw(&machine, &tolerances, seed);
        let settings = JointSettings { damped: false, errors, ..JointSettings::default() };
        let mut model = BearingJoints::held(&machine, &settings).unwrap().with_friction(0.0);
        model.hold_sun(2.0, 0.0);
        let (rated, output) = (machine.rated.torque, model.output_index());
        let mut balance = |share: f64, start: &[f64]| {
            model.set_load(share * rated);
            let control = EquilibriumControl { tolerance: 1e-11, ..EquilibriumControl::default() };
            solve_equilibrium(&*model, 0.0, start, control).unwrap().position
        };
        let q = balance(1.0, &BearingJoints::held(&machine, &settings).unwrap().nominal_position_at(2.0));
        let [less, more] = [1.0 - 1e-4, 1.0 + 1e-4].map(|share| balance(share, &q)[output]);
        let expected = (less - more) / (2e-4 * rated);
        let mut known = model.linearisation();
        model.forces_at_rest(&q, &mut known);
        let by_differences = model.motion_by(&mut model.tangent_by_differences(&q, known)).unwrap()[output];
        let usual = model.motion_per_torque(&q).unwrap()[output];
        assert!((by_differences / expected - 1.0).abs() < 1e-4, "{seed}: {by_differences:e} {expected:e}");
        assert!((usual / expected - 1.0).abs() < 3e-3, "{seed}: {usual:e} {expected:e}");
        assert!(by_differences != usual);
    }
}

/// With stiff parts, a free rotation φ of a disc appears at the output as φ/(1 + (z_1 + z_2)/(z_2 z_c)) if the
/// sun is fixed to the housing, because the crankshafts rotate with the output. With carrier and sun fixed the
/// disc does not move, and the ring rotates about its own centre, where forces through the pitch point have the
/// lever arm a z_p sin φ/S instead of a z_c sin φ/S: the free rotation is φ z_c/z_p.
#[test]
fn play_with_the_carrier_at_rest_is_that_of_the_disc() {
    let play = |fixed_member: FixedMember| {
        let mut machine = Machine { fixed_member, ..machine() };
        machine.bearings.turning_arm.clearance = 0.0;
        let settings = JointSettings {
            stiffness_scale: 1e6,
            damped: false,
            flank_wear: vec![Relief::uniform(10e-6)],
            ..JointSettings::default()
        };
        let mut model = BearingJoints::held(&machine, &settings).unwrap();
        model.hold_sun(0.7, 0.0);
        let mut at = |torque: f64| {
            model.set_load(torque);
            let q = settle(&model, 0.7);
            model.output_error(&q)
        };
        // Extrapolated linearly to zero load from 4 and 8 N·m.
        let mut flank = |side: f64| 2.0 * at(-4.0 * side) - at(-8.0 * side);
        flank(1.0) - flank(-1.0)
    };
    let (housing, carrier) = (play(FixedMember::Housing), play(FixedMember::Carrier));
    let factor = machine().kinematics().locked_play_factor() * 40.0 / 39.0;
    assert!((housing / carrier / factor - 1.0).abs() < 2e-3, "{housing:e} {carrier:e} {factor}");
    assert!((housing / ARCMIN / (2.0 * 0.6536) - 1.0).abs() < 0.02, "{}", housing / ARCMIN);
}

/// Time series of a run with bearings, with the error of the output in arcmin and the energy residual.
fn run<M: Clone + Into<Model>>(model: &M, end: f64, tolerance: f64) -> RunResult {
    let control =
        StepControl { tolerance: tolerance * StepControl::default().tolerance, ..StepControl::default() };
    let plan = RunPlan { end, window_start: 0.5 * end, control, ..RunPlan::default() };
    let mut run = Run::new(model.clone(), plan, &Silent).unwrap();
    run.finish(&Silent).unwrap();
    run.result()
}

/// Output by the housing, in motion: with stiff bearings the same motion as with ideal joints of equal
/// inertias, whose reduced equations contain no position of the housing.
#[test]
fn val_stiff_bearings_with_the_carrier_at_rest() {
    let mut machine = Machine { fixed_member: FixedMember::Carrier, ..machine() };
    machine.bearings.turning_arm.clearance = 0.0;
    let settings = JointSettings { stiffness_scale: 1e4, ..JointSettings::default() };
    let load = OutputLoad::Constant { torque: 412.0 };
    let drive = Drive::SpeedLaw { speed: machine.rated.input_speed, rise_time: 0.01 };
    let bearings =
        run(&BearingJoints::new(&machine, &settings, drive.clone(), load.clone(), 0.0).unwrap(), 0.03, 1.0);
    let ideal = run(&IdealJoints::new(&machine, &Relief::uniform(0.0), drive, load, 0.0).unwrap(), 0.03, 1.0);
    let (a, b) = (bearings.statistics.unwrap().mean / ARCMIN, ideal.statistics.unwrap().mean / ARCMIN);
    // Bearings ten thousand times stiffer cause some ten-thousandths of the 1.7' of normal ones; with a factor
    // of a thousand, 3.0e-3' remain.
    assert!((a - b).abs() < 4e-4, "{a} {b}");
    assert!((bearings.mean_ratio.unwrap() / -80.0 - 1.0).abs() < 1e-3);
    assert!(bearings.energy.residual() < 1e-6, "{:e}", bearings.energy.residual());
}

/// A shaft of stiffness k before the sun increases the output rotation by T/(i² k), and the split contains this
/// part.
#[test]
fn input_shaft_contributes_its_own_compliance() {
    let rigid = machine();
    let mut soft = rigid.clone();
    soft.gear_stage.input_torsional_stiffness = 400.0;
    let error = |machine: &Machine, torque: f64| {
        let mut model =
            BearingJoints::held(machine, &JointSettings { damped: false, ..JointSettings::default() })
                .unwrap();
        model.set_load(torque);
        let q = settle(&model, 0.0);
        let mut motion = vec![0.0; q.len()];
        motion[model.output_index()] = 1.0;
        let mut lin = model.linearisation();
        model.evaluate(0.0, &q, &vec![0.0; q.len()], &mut vec![0.0; q.len()], &mut lin);
        lin.solve(
            &vec![0.0; q.len()],
            crate::dynamics::Weights { mass: 0.0, damping: 0.0, stiffness: 1.0 },
            &mut motion,
        )
        .unwrap();
        (model.output_error(&q), of(&model.split(&q, &motion), INPUT_SHAFT))
    };
    let ((stiff, none), (elastic, share)) = (error(&rigid, 412.0), error(&soft, 412.0));
    let expected = 1.0 / (81.0 * 81.0 * 400.0);
    // The sun's torque is T/81, except for the rotation of the crankshafts with their clearance: 1e-3.
    assert!(
        ((stiff - elastic) / (412.0 * expected) - 1.0).abs() < 2e-3,
        "{} {expected}",
        (stiff - elastic) / 412.0
    );
    assert!(none == 0.0 && (share / expected - 1.0).abs() < 5e-3, "{share} {expected}");
}

/// A motor behind an elastic input shaft: sun and motor oscillate against each other, and the energy balance is
/// fulfilled.
#[test]
fn motor_behind_an_elastic_shaft() {
    let mut machine = machine();
    machine.gear_stage.input_torsional_stiffness = 400.0;
    let drive = Drive::Governed { speed: machine.rated.input_speed, rise_time: 0.01, gain: 0.05 };
    let load = OutputLoad::Constant { torque: 412.0 };
    let build = |machine: &Machine, drive: &Drive| {
        BearingJoints::new(machine, &JointSettings::default(), drive.clone(), load.clone(), 0.0)
    };
    machine.gear_stage.motor_inertia = 0.0;
    assert!(build(&machine, &drive).is_err(), "a motor without inertia has no motion of its own");
    machine.gear_stage.motor_inertia = 2e-4;
    // Acceleration to full speed within 10 ms causes rattling, with short steps at every impact; the error of
    // the energy balance is proportional to the tolerance.
    for drive in [drive, Drive::SpeedLaw { speed: machine.rated.input_speed, rise_time: 0.01 }] {
        let residual =
            |tolerance: f64| run(&build(&machine, &drive).unwrap(), 0.03, tolerance).energy.residual();
        let (coarse, fine) = (residual(1.0), residual(0.1));
        assert!(coarse < 1e-5 && fine < 0.5 * coarse, "{coarse:e} {fine:e}");
    }
}
