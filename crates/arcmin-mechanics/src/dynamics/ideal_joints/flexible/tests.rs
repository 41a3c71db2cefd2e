use super::*;
use crate::contact::ContactLaw;
use crate::dynamics::{Model, Run, RunPlan, RunResult, StepControl};
use crate::fem::DiscShape;
use crate::fem::{FemError, FlexibleSettings, ReducedDisc};
use crate::machine::CrankAngle;
use crate::progress::Silent;
use crate::units::ARCMIN;
use std::sync::OnceLock;

/// Contact stiffness of one pin in the published comparison.
fn machine() -> Machine {
    Machine { contact_law: ContactLaw::Linear { stiffness: 2.85e8 }, ..crate::templates::tao2024() }
}

fn reduced() -> &'static ReducedDisc {
    static REDUCED: OnceLock<ReducedDisc> = OnceLock::new();
    REDUCED.get_or_init(|| {
        let shape = crate::fem::DiscShape::of(&machine(), 0);
        let fine = FlexibleSettings::plane_stress(&shape);
        let sizes = crate::fem::MeshSizes { flank: 1.5 * fine.sizes.flank, flank_rows: 2, ..fine.sizes };
        crate::fem::DiscModel::new(shape, FlexibleSettings { sizes, ..fine }).unwrap().reduce().unwrap().0
    })
}

fn discs(reduced: &ReducedDisc) -> FlexibleDiscs {
    FlexibleDiscs::with(DiscShape::all(&machine()), |_| Ok::<_, FemError>(reduced.clone())).unwrap()
}

fn speed_law() -> Drive {
    Drive::SpeedLaw { speed: machine().rated.input_speed, rise_time: 0.02 }
}

fn run<M: Clone + Into<Model>>(model: &M) -> RunResult {
    // A tenth of the default tolerance, so that differences between models exceed the integration error.
    let control = StepControl { tolerance: 0.1 * StepControl::default().tolerance, ..StepControl::default() };
    let plan = RunPlan { end: 0.04, window_start: 0.02, control, ..RunPlan::default() };
    let mut run = Run::new(model.clone(), plan, &Silent).unwrap();
    run.finish(&Silent).unwrap();
    run.result()
}

fn flexible(reduced: &ReducedDisc, mode_frequency: f64) -> FlexibleJoints {
    let options = FlexibleOptions { mode_frequency, ..FlexibleOptions::default() };
    let load = OutputLoad::Constant { torque: 412.0 };
    FlexibleJoints::new(&machine(), discs(reduced), &Relief::uniform(10e-6), speed_law(), load, 0.0, options)
        .unwrap()
}

fn rigid() -> IdealJoints {
    IdealJoints::new(
        &machine(),
        &Relief::uniform(10e-6),
        speed_law(),
        OutputLoad::Constant { torque: 412.0 },
        0.0,
    )
    .unwrap()
}

#[test]
fn discs_ten_thousand_times_stiffer_move_like_rigid_ones() {
    let stiff = reduced().stiffened(1e4);
    let (elastic, rigid) = (run(&flexible(&stiff, 20e3)), run(&rigid()));
    for (a, b) in elastic.series.iter().zip(&rigid.series) {
        let difference = (a.transmission_error - b.transmission_error) / ARCMIN;
        assert!(difference.abs() < 1e-4, "{} s: {difference}'", a.time);
    }
}

#[test]
fn excess_over_rigid_discs_is_the_static_compliance() {
    let (elastic, rigid) = (run(&flexible(reduced(), 20e3)), run(&rigid()));
    let relief = Relief::uniform(10e-6);
    let meshing = machine().flexible_meshing(&relief, discs(reduced()));
    let k = meshing.rigid().kinematics();
    let (mut dynamic, mut fixed) = (0.0, 0.0);
    for (a, b) in elastic.series.iter().zip(&rigid.series).filter(|(a, _)| a.time > 0.02).step_by(4) {
        dynamic += b.transmission_error - a.transmission_error;
        let crank = CrankAngle::from_radians(-k.lobe_count * a.input_angle / k.ratio());
        let error = |sharing: crate::load::LoadSharing| sharing.output_error.radians();
        fixed += error(meshing.rigid().load_sharing(crank, 412.0).unwrap())
            - error(meshing.load_sharing(crank, 412.0).unwrap());
    }
    assert!(dynamic > 0.0);
    assert!((dynamic / fixed - 1.0).abs() < 0.03, "{}", dynamic / fixed);
}

#[test]
fn the_result_does_not_depend_on_the_number_of_modes() {
    let mean = |frequency: f64| run(&flexible(reduced(), frequency)).statistics.unwrap().mean;
    let (few, more) = (mean(20e3), mean(40e3));
    assert!((few / more - 1.0).abs() < 0.01, "{few} {more}");
}

#[test]
fn energy_balances() {
    for law in [ContactLaw::Linear { stiffness: 2.85e8 }, ContactLaw::LineHertz] {
        let machine = Machine { contact_law: law, ..machine() };
        let load = OutputLoad::Constant { torque: 412.0 };
        let options = FlexibleOptions::default();
        let model = FlexibleJoints::new(
            &machine,
            discs(reduced()),
            &Relief::uniform(10e-6),
            speed_law(),
            load,
            0.0,
            options,
        )
        .unwrap();
        let residual = run(&model).energy.residual();
        assert!(residual < 1e-6, "{law:?} {residual:e}");
    }
}

/// Generalised forces are minus the gradient of the stored energy in every coordinate, for a law with and one
/// without radius.
#[test]
fn forces_are_the_gradient_of_the_stored_energy() {
    for (law, wear) in [
        (ContactLaw::Linear { stiffness: 2.85e8 }, Relief::uniform(10e-6)),
        (ContactLaw::LineHertz, Relief::uniform(10e-6)),
        (
            ContactLaw::LineHertz,
            Relief::from_samples(
                Relief::grid(720).map(|phi| 10e-6 * (1.0 + 0.2 * (2.0 * phi).cos())).collect(),
            ),
        ),
    ] {
        let mut machine = Machine { contact_law: law, ..machine() };
        machine.contact_damping.coefficient = 0.0;
        let options = FlexibleOptions { damping_ratio: 0.0, ..FlexibleOptions::default() };
        let held = Drive::SpeedLaw { speed: 0.0, rise_time: 1.0 };
        let model =
            FlexibleJoints::new(&machine, discs(reduced()), &wear, held, OutputLoad::None, 0.0, options)
                .unwrap();
        let n = model.size();
        for crank in [0.0, 0.7, 2.0] {
            // Twisted by about the rated torque, with the modes slightly off their static values.
            let mut state = vec![3e-8; n];
            state[0] = crank + 2e-4;
            state[IdealJoints::OUTPUT] = -crank / 39.0 - 1.1 * ARCMIN;
            let rest = vec![0.0; n];
            let mut lin = model.linearisation();
            let mut force = vec![0.0; n];
            // Modes relative to the carrier's angle: q = p − c θ.
            for disc in 0..2 {
                for m in 0..model.discs.mode_count(disc) {
                    state[model.first_mode(disc) + m] +=
                        model.turning_share(disc, m) * state[IdealJoints::OUTPUT];
                }
            }
            model.evaluate(0.0, &state, &rest, &mut force, &mut lin);
            let energy = |i: usize, h: f64| {
                let mut moved = state.clone();
                moved[i] += h;
                model.evaluate(0.0, &moved, &rest, &mut vec![0.0; n], &mut model.linearisation()).stored
            };
            let size = (0..n).map(|i| (force[i] * model.scale[i]).abs()).fold(0.0, f64::max);
            for i in 0..n {
                let h = 1e-3 * model.scale[i];
                let slope = -(8.0 * (energy(i, h) - energy(i, -h)) - energy(i, 2.0 * h)
                    + energy(i, -2.0 * h))
                    / (12.0 * h);
                let difference = (slope - force[i]) * model.scale[i] / size;
                // Kinks of the tabulated arc length: 1e-3 of the slope of the deformed flank, which itself
                // contributes 1e-3 of the force.
                assert!(difference.abs() < 2e-6, "{law:?} {crank} {i}: {slope} {}", force[i]);
            }
        }
    }
}
