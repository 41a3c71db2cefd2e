//! The rigid model against closed forms, published values and an independent integrator.

use arcmin::contact::ContactLaw;
use arcmin::dynamics::*;
use arcmin::geometry::Relief;
use arcmin::load::ShareLoad;
use arcmin::machine::Machine;
use arcmin::progress::Silent;
use arcmin::units::{ARCMIN, RPM, UM};

const LINEAR: ContactLaw = ContactLaw::Linear { stiffness: 2.85e8 };

/// The reference machine with the linear contact of the published figures: 2.85e8 N/m per pin.
fn linear() -> Machine {
    arcmin::templates::tao2024().with_contact_law(LINEAR).unwrap()
}

fn speed_law() -> Drive {
    Drive::SpeedLaw { speed: 1500.0 * RPM, rise_time: 0.1 }
}

fn simulate(machine: &Machine, wear_um: f64, load: OutputLoad, drag: f64, plan: RunPlan) -> RunResult {
    simulate_rigid(machine, &Relief::uniform(wear_um * UM), &speed_law(), &load, drag, plan).unwrap()
}

fn statistics(result: &RunResult) -> ErrorStatistics {
    result.statistics.unwrap()
}

const RATED: OutputLoad = OutputLoad::Constant { torque: 412.0 };
const SINE: OutputLoad = OutputLoad::Sine { amplitude: 412.0, period: 0.3 };

/// The play is ±0.6536' at 10 µm and ±3.9218' at 60 µm (means over the cycle, computed by two programs);
/// impacts add a penetration below 0.03'.
#[test]
fn val_unloaded_error_floats_within_the_play() {
    for (wear, play) in [(10.0, 0.6536), (60.0, 3.9218)] {
        let te = statistics(&simulate(&linear(), wear, OutputLoad::None, 0.0, RunPlan::default()));
        let reach = te.max_abs / ARCMIN;
        assert!(reach < play + 0.03, "{wear}: {reach}");
        // The play is used: the run reaches both flanks.
        assert!(te.lowest / ARCMIN < -0.9 * play && te.highest / ARCMIN > 0.9 * play, "{wear}: {te:?}");
    }
}

/// −0.825' and −4.205': play and Hertzian wind-up under the rated torque (±0.5 %), conservation of energy to
/// 1e-6 of the energy turned over, ratio 81 to 1e-6.
#[test]
fn val_constant_load() {
    for (wear, mean) in [(10.0, -0.825), (60.0, -4.205)] {
        let result = simulate(&linear(), wear, RATED, 0.0, RunPlan::default());
        let te = statistics(&result);
        assert!((te.mean / ARCMIN / mean - 1.0).abs() < 5e-3, "{wear}: {}", te.mean / ARCMIN);
        assert!(result.energy.residual() < 1e-6, "{wear}: {:e}", result.energy.residual());
    }
    // Whole periods of the pattern: the output turns one pin pitch of the disc, 2π/40 of the crank relative
    // to it, every 2.025 ms; 300 of them.
    let period = 60.0 / (1500.0 * 40.0 / 81.0 * 40.0);
    let plan = RunPlan { end: 0.15 + 300.0 * period, window_start: 0.15, ..RunPlan::default() };
    let result = simulate(&linear(), 10.0, RATED, 0.0, plan);
    let ratio = result.mean_ratio.unwrap();
    assert!((ratio / 81.0 - 1.0).abs() < 1e-6, "{ratio}");
}

#[test]
fn val_sinusoidal_load() {
    for (wear, reach) in [(10.0, 0.83), (60.0, 4.25)] {
        let result = simulate(&linear(), wear, SINE, 0.0, RunPlan::default());
        let te = statistics(&result);
        for excursion in [te.highest, -te.lowest] {
            assert!((excursion / ARCMIN / reach - 1.0).abs() < 0.02, "{wear}: {}", excursion / ARCMIN);
        }
        assert!(result.energy.residual() < 1e-6, "{wear}: {:e}", result.energy.residual());
    }
}

#[test]
fn val_unworn_and_unloaded_there_is_no_error() {
    let te =
        statistics(&simulate(&arcmin::templates::tao2024(), 0.0, OutputLoad::None, 0.0, RunPlan::default()));
    assert!(te.max_abs / ARCMIN < 1e-3, "{}", te.max_abs / ARCMIN);
}

/// With a steady drag the mean is well defined: results with a tenth of the tolerance agree to 0.1 %. Under
/// load half the tolerance changes no statistic by more.
#[test]
fn statistics_are_converged() {
    let with = |load: &OutputLoad, drag: f64, tolerance: f64| {
        let control = StepControl { tolerance, ..StepControl::default() };
        statistics(&simulate(&linear(), 10.0, load.clone(), drag, RunPlan { control, ..RunPlan::default() }))
    };
    let tolerance = StepControl::default().tolerance;
    let (coarse, fine) =
        (with(&OutputLoad::None, 5.0, tolerance), with(&OutputLoad::None, 5.0, 0.1 * tolerance));
    assert!((coarse.mean / fine.mean - 1.0).abs() < 1e-3, "{} {}", coarse.mean / ARCMIN, fine.mean / ARCMIN);
    for load in [RATED, SINE] {
        let (coarse, fine) = (with(&load, 0.0, tolerance), with(&load, 0.0, 0.5 * tolerance));
        let scale = fine.rms;
        let values: [fn(&ErrorStatistics) -> f64; 4] = [|s| s.mean, |s| s.mean_abs, |s| s.max_abs, |s| s.rms];
        for value in values {
            assert!((value(&coarse) - value(&fine)).abs() < 1e-3 * scale, "{load:?}: {coarse:?} {fine:?}");
        }
    }
}

/// The same equations by the variable-order BDF of the diffsol crate over the first 0.15 s of a loaded run:
/// to 1e-4' at a fifth of the default tolerance (measured 2.8e-5'), and ten times closer at a tenth of that
/// (measured 6.7e-6').
#[test]
fn val_independent_bdf_solver_agrees() {
    use diffsol::{NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverMethod, Vector};
    let model = IdealJoints::new(&linear(), &Relief::uniform(10.0 * UM), speed_law(), RATED, 0.0).unwrap();
    let rest = solve_equilibrium(&model, 0.0, &model.nominal_position(), EquilibriumControl::default())
        .unwrap()
        .position;
    let evaluate = |t: f64, y: &[f64]| {
        let mut lin = model.linearisation();
        let mut force = [0.0; 2];
        model.evaluate(t, &y[..2], &y[2..], &mut force, &mut lin);
        (force, lin)
    };
    let mass = model.mass();
    let mut problem = OdeBuilder::<NalgebraMat<f64>>::new()
        .rtol(1e-9)
        .atol(vec![1e-11, 1e-12, 1e-7, 1e-8])
        .h0(1e-8)
        .rhs_implicit(
            |x, _p, t, y| {
                let force = evaluate(t, x).0;
                y.copy_from_slice(&[x[2], x[3], force[0] / mass[0], force[1] / mass[1]]);
            },
            |x, _p, t, v, y| {
                let lin = evaluate(t, x).1;
                let slope = |i: usize| {
                    -(0..2).map(|j| lin.stiffness(i, j) * v[j] + lin.damping(i, j) * v[2 + j]).sum::<f64>()
                        / mass[i]
                };
                y.copy_from_slice(&[v[2], v[3], slope(0), slope(1)]);
            },
        )
        .init(|_p, _t, y| y.copy_from_slice(&[rest[0], rest[1], 0.0, 0.0]), 4)
        .build()
        .unwrap();
    // Every contact of a pin that opens or closes costs one or two failures of Newton's iteration, and the
    // default allows fifty in total.
    problem.ode_options.max_nonlinear_solver_failures = 100_000;
    problem.ode_options.max_error_test_failures = 100_000;
    let mut solver = problem.bdf::<NalgebraLU<f64>>().unwrap();
    let series = [1e-5, 1e-6].map(|tolerance| {
        let control = StepControl { tolerance, ..StepControl::default() };
        let mut run = Run::from_state(
            model.clone(),
            RunPlan { end: 0.15, control, ..RunPlan::default() },
            &rest,
            &[0.0, 0.0],
        )
        .unwrap();
        run.finish(&Silent).unwrap();
        run.result().series
    });
    let mut worst = [0.0_f64; 2];
    for (row, sample) in series[0].iter().enumerate() {
        while solver.state().t < sample.time {
            solver.step().unwrap();
        }
        let y = solver.interpolate(sample.time).unwrap();
        let error = y.get_index(1) - speed_law().motion(sample.time).angle / 81.0;
        for (worst, series) in worst.iter_mut().zip(&series) {
            *worst = worst.max((error - series[row].transmission_error).abs() / ARCMIN);
        }
    }
    assert!(worst[0] < 1e-4 && worst[1] < 2e-5, "{worst:?}'");
}

/// The same relative motion, seen from the carrier: the error of the housing is that of the carrier with the
/// other sign, over −80 instead of 81.
#[test]
fn val_fixed_carrier() {
    let design = arcmin::templates::design("tao2024").unwrap().with("fixed_member", "carrier").unwrap();
    let machine = design.machine().with_contact_law(LINEAR).unwrap();
    let result = simulate(&machine, 10.0, RATED, 0.0, RunPlan::default());
    assert!((result.mean_ratio.unwrap() / -80.0 - 1.0).abs() < 1e-4);
    let te = statistics(&result).mean / ARCMIN;
    // With locked input the disc's play shows at the housing by z_c/z_p instead of 1/(1 + (z_1+z_2)/(z_2
    // z_c)) = 0.96296: 1.0125 times as much, and the wind-up by the square of that: 0.6536' and 0.1720'
    // become 0.838' (the mesh's 0.003' of it aside).
    assert!((te / -0.838 - 1.0).abs() < 5e-3, "{te}");
    // Load sharing without inertia, another solver: the gear mesh's 0.003' aside the same error, play and
    // share of each disc.
    let mut meshing = machine.meshing(&Relief::uniform(10.0 * UM));
    let cycle = meshing.whole_cycle(412.0, 12).unwrap();
    assert!((cycle.mean_error().arcmin() / te - 1.0).abs() < 5e-3, "{} {te}", cycle.mean_error().arcmin());
    let factor = 39.0 / 40.0 * (1.0 + 1.5 / 39.0);
    let usual = linear().meshing(&Relief::uniform(10.0 * UM)).whole_cycle(412.0, 12).unwrap();
    assert!((cycle.disc_share(0) - 39.0 / 80.0).abs() < 1e-4, "{}", cycle.disc_share(0));
    let play = |cycle: &arcmin::load::Cycle| cycle.play.iter().map(|play| play.radians()).sum::<f64>();
    assert!(
        (play(&cycle) / play(&usual) / factor - 1.0).abs() < 1e-3,
        "{} {factor}",
        play(&cycle) / play(&usual)
    );
    // Positive torque loads the other flank: the discs lead the ring.
    let loaded = |sharing: &arcmin::load::LoadSharing| -> Vec<f64> {
        sharing
            .contacts()
            .filter(|contact| contact.force > 1.0)
            .map(|contact| contact.meshing_angle)
            .collect()
    };
    let angles: Vec<f64> = cycle.positions.iter().flat_map(loaded).collect();
    assert!(angles.len() > 100 && angles.iter().all(|angle| *angle > 0.0), "{angles:?}");
    assert!(result.energy.residual() < 1e-6, "{:e}", result.energy.residual());
}

/// A motor with inertia under a governor reaches its speed and drives the rated load; the energy balance
/// includes the work of the motor.
#[test]
fn governed_motor_reaches_its_speed() {
    let machine = linear();
    let drive = Drive::Governed { speed: 1500.0 * RPM, rise_time: 0.1, gain: 0.5 };
    let result =
        simulate_rigid(&machine, &Relief::uniform(10.0 * UM), &drive, &RATED, 0.0, RunPlan::default())
            .unwrap();
    let last = result.series.last().unwrap();
    // Droop: torque at the sun 412/81 N·m over the gain.
    let expected = 1500.0 * RPM - 412.0 / 81.0 / 0.5;
    assert!((last.input_speed / expected - 1.0).abs() < 1e-3, "{} {expected}", last.input_speed);
    assert!((statistics(&result).mean / ARCMIN / -0.825 - 1.0).abs() < 0.02);
    assert!(result.energy.residual() < 1e-6, "{:e}", result.energy.residual());
}

#[test]
fn every_contact_law_runs_and_keeps_energy() {
    let laws = [
        ContactLaw::LineHertz,
        ContactLaw::Palmgren,
        ContactLaw::Tao2024,
        ContactLaw::Impact { stiffness: 3e8 * 1e-6_f64.powf(-0.1), exponent: 1.1 },
    ];
    let plan = RunPlan { end: 0.2, ..RunPlan::default() };
    for contact_law in laws {
        let machine = arcmin::templates::tao2024().with_contact_law(contact_law).unwrap();
        let result = simulate(&machine, 10.0, RATED, 0.0, plan);
        let te = statistics(&result).mean / ARCMIN;
        assert!((-0.95..-0.7).contains(&te), "{contact_law:?}: {te}");
        assert!(result.energy.residual() < 1e-6, "{contact_law:?}: {:e}", result.energy.residual());
    }
}

#[test]
fn interrupted_run_continues_bit_by_bit() {
    let model = IdealJoints::new(&linear(), &Relief::uniform(10.0 * UM), speed_law(), SINE, 0.0).unwrap();
    let plan = RunPlan { end: 0.12, ..RunPlan::default() };
    let mut whole = Run::new(model.clone(), plan, &Silent).unwrap();
    whole.finish(&Silent).unwrap();
    let mut first = Run::new(model.clone(), plan, &Silent).unwrap();
    first.proceed(777, &Silent).unwrap();
    let mut second = Run::resume(model, first.checkpoint()).unwrap();
    second.finish(&Silent).unwrap();
    assert_eq!(whole.result(), second.result());
    // Perturbed starts and studies do not depend on the number of threads.
    let study = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let settings = StudySettings { plan, perturbed_starts: 2, ..StudySettings::tao2024(&linear()) };
        let wear = [Relief::uniform(10.0 * UM), Relief::uniform(20.0 * UM)];
        pool.install(|| transmission_error_study(&linear(), &wear, &settings, &Silent).unwrap())
    };
    assert_eq!(study(1), study(3));
}

/// An overflowing load stops the run with time, angle and residual; the results before it are kept.
#[test]
fn a_failed_run_keeps_its_results() {
    let model = IdealJoints::new(
        &linear(),
        &Relief::uniform(10.0 * UM),
        speed_law(),
        OutputLoad::Stepped(vec![(0.05, 1e308)]),
        0.0,
    )
    .unwrap();
    let mut run = Run::new(model, RunPlan { end: 0.1, ..RunPlan::default() }, &Silent).unwrap();
    let error = run.finish(&Silent).unwrap_err();
    assert!(error.to_string().starts_with("the step at t = 0.05"), "{error}");
    assert!(error.to_string().contains("crank angle") && error.to_string().contains("residual"), "{error}");
    assert!(run.result().series.len() > 200);
}
