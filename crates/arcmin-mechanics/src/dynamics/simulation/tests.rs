use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use crate::dynamics::{
    BearingJoints, EquilibriumControl, IdealJoints, JointSettings, RunPlan, solve_equilibrium,
    spread_over_starts,
};
use crate::dynamics::{GivenMotion, GivenTorque, LoadInput, MotorInput};
use crate::geometry::Relief;
use crate::machine::Machine;
use crate::progress::Silent;
use crate::units::{ARCMIN, RPM};

fn machine() -> Machine {
    crate::templates::tao2024()
}

fn law() -> Drive {
    Drive::SpeedLaw { speed: 1500.0 * RPM, rise_time: 0.02 }
}

fn ideal(drive: Drive, load: OutputLoad) -> Model {
    IdealJoints::new(&machine(), &Relief::uniform(10e-6), drive, load, 5.0).unwrap().into()
}

fn bearings(drive: Drive, load: OutputLoad) -> Model {
    BearingJoints::new(&machine(), &JointSettings::default(), drive, load, 5.0).unwrap().into()
}

fn start(model: Model) -> Simulation {
    Simulation::from_rest(model, StepControl::default(), &Silent).unwrap()
}

fn given(torque: f64) -> OutputLoad {
    OutputLoad::GivenTorque(GivenTorque::constant(torque))
}

/// Advances in steps of `interval`, setting the load by `load` before each.
fn drive(simulation: &mut Simulation, end: f64, interval: f64, load: impl Fn(f64) -> f64) {
    let from = simulation.time();
    let count = ((end - from) / interval).round() as usize;
    for i in 0..count {
        let torque = load(simulation.time());
        simulation.set_load(LoadInput::Torque { torque, rate: 0.0 }).unwrap();
        simulation.advance_to(from + (i + 1) as f64 * (end - from) / count as f64, &Silent).unwrap();
    }
}

#[test]
fn simulations_own_their_data() {
    fn movable<T: Send + 'static>() {}
    movable::<Simulation>();
    movable::<crate::dynamics::Run>();
    movable::<Model>();
}

/// The same steps and bits, whether the torque is a function of the model or set every 0.1 ms.
#[test]
fn a_constant_input_from_outside_equals_the_function_of_time() {
    type Build = fn(Drive, OutputLoad) -> Model;
    for (build, end) in [(ideal as Build, 0.03), (bearings as Build, 0.004)] {
        let mut inside = start(build(law(), OutputLoad::Constant { torque: 412.0 }));
        inside.advance_to(end, &Silent).unwrap();
        let mut outside = start(build(law(), given(412.0)));
        drive(&mut outside, end, 1e-4, |_| 412.0);
        assert_eq!(inside.outputs().unwrap(), outside.outputs().unwrap());
        assert_eq!(inside.counts(), outside.counts());
    }
}

/// Jumps set from outside, which are not known in advance as those of a function of time; a linear change of
/// the motor's speed in two parts, compared with the table.
#[test]
fn jumps_and_ramps_from_outside_equal_the_functions_of_time() {
    let steps = vec![(0.0, 100.0), (0.012, 412.0), (0.02, -200.0)];
    let table =
        crate::dynamics::TimeTable::new("speed", &[(0.0, 0.0), (0.012, 150.0), (0.03, 120.0)]).unwrap();
    let mut inside = start(ideal(Drive::SpeedTable(table), OutputLoad::Stepped(steps)));
    inside.advance_to(0.03, &Silent).unwrap();
    let mut outside = start(ideal(Drive::GivenMotion(GivenMotion::default()), given(100.0)));
    outside.set_motor(MotorInput::Speed { speed: 0.0, acceleration: 150.0 / 0.012 }).unwrap();
    outside.advance_to(0.012, &Silent).unwrap();
    outside.set_load(LoadInput::Torque { torque: 412.0, rate: 0.0 }).unwrap();
    outside.set_motor(MotorInput::Speed { speed: 150.0, acceleration: -30.0 / 0.018 }).unwrap();
    outside.advance_to(0.02, &Silent).unwrap();
    outside.set_load(LoadInput::Torque { torque: -200.0, rate: 0.0 }).unwrap();
    outside.advance_to(0.03, &Silent).unwrap();
    let (a, b) = (inside.outputs().unwrap(), outside.outputs().unwrap());
    assert!((a.input_angle - b.input_angle).abs() < 1e-12, "{} {}", a.input_angle, b.input_angle);
    let difference = (a.transmission_error - b.transmission_error).abs() / ARCMIN;
    assert!(difference < 2e-4, "{difference}'");
    assert!(b.energy.residual() < 1e-5, "{:e}", b.energy.residual());
}

#[test]
fn results_do_not_depend_on_the_communication_step() {
    let jump = |time: f64| if time < 0.01 { 100.0 } else { 412.0 };
    let run = |interval: f64| {
        let mut simulation = start(ideal(law(), given(100.0)));
        drive(&mut simulation, 0.01, interval, jump);
        drive(&mut simulation, 0.025, interval, jump);
        simulation.outputs().unwrap()
    };
    let whole = run(5e-3);
    assert_eq!(whole, run(1e-3));
    assert_eq!(whole, run(2.5e-6));
}

/// Through bytes, in the middle of a step that ends beyond the requested time.
#[test]
fn a_restored_simulation_continues_bit_by_bit() {
    for build in [ideal as fn(Drive, OutputLoad) -> Model, bearings] {
        let free = Drive::GivenTorque(GivenTorque::constant(2.0));
        let mut first = start(build(free.clone(), given(100.0)));
        first.advance_to(0.0017, &Silent).unwrap();
        assert!(first.integrator.time() > first.time());
        let bytes = first.save().to_bytes().unwrap();
        let saved = SimulationState::from_bytes(&bytes).unwrap();
        assert_eq!(saved, first.save());
        let mut second = start(build(free, given(0.0)));
        second.restore(&saved).unwrap();
        let go_on = |simulation: &mut Simulation| {
            simulation.set_motor(MotorInput::Torque { torque: 4.0, rate: 10.0 }).unwrap();
            simulation.advance_to(0.003, &Silent).unwrap();
            simulation.outputs().unwrap()
        };
        let expected = go_on(&mut first);
        assert_eq!(expected, go_on(&mut second));
        // Restored to an earlier time repeatedly.
        second.restore(&saved).unwrap();
        assert_eq!(expected, go_on(&mut second));
    }
    let ideal_state = start(ideal(law(), given(0.0))).save();
    assert!(start(bearings(law(), given(0.0))).restore(&ideal_state).is_err());
    assert!(SimulationState::from_bytes(&[1, 2, 3]).is_err());
}

/// An output held at the angle to which a torque twists it transmits that torque, in statics and in time.
#[test]
fn a_prescribed_output_transmits_the_torque_of_its_twist() {
    for build in [ideal as fn(Drive, OutputLoad) -> Model, bearings] {
        let still = || Drive::GivenMotion(GivenMotion::default());
        let loaded = build(still(), OutputLoad::Constant { torque: 412.0 });
        let rest = solve_equilibrium(&loaded, 0.0, &loaded.nominal_position(), EquilibriumControl::default());
        let angle = rest.unwrap().position[loaded.output_index()];
        let motion = GivenMotion { angle, ..GivenMotion::default() };
        let mut simulation = start(build(still(), OutputLoad::GivenMotion(motion)));
        let torque = simulation.outputs().unwrap().output_torque;
        assert!((torque / 412.0 - 1.0).abs() < 1e-6, "{torque}");
        simulation.advance_to(1e-3, &Silent).unwrap();
        let torque = simulation.outputs().unwrap().output_torque;
        assert!((torque / 412.0 - 1.0).abs() < 1e-6, "{torque}");
        // Both flanges at the nominal ratio: output and input power differ by the losses; the energy balance is
        // fulfilled.
        simulation.set_motor(MotorInput::Speed { speed: 0.0, acceleration: 5e3 }).unwrap();
        simulation.set_load(LoadInput::Speed { speed: 0.0, acceleration: 5e3 / 81.0 }).unwrap();
        simulation.advance_to(5e-3, &Silent).unwrap();
        let outputs = simulation.outputs().unwrap();
        let expected = angle + 0.5 * 5e3 / 81.0 * 4e-3 * 4e-3;
        assert!((outputs.output_angle - expected).abs() < 1e-12);
        assert!((outputs.transmission_error - angle).abs() < 1e-12);
        assert!(outputs.energy.residual() < 1e-5, "{:e}", outputs.energy.residual());
        assert!(outputs.output_torque > 300.0 && outputs.output_torque < 520.0, "{outputs:?}");
    }
}

/// The largest pressure is that of its pin with its R_eq.
#[test]
fn largest_pin_pressure_is_that_of_the_model() {
    let model = IdealJoints::new(&machine(), &Relief::uniform(10e-6), law(), given(412.0), 0.0).unwrap();
    let mut simulation = start(model.clone().into());
    simulation.advance_to(0.01, &Silent).unwrap();
    let (forces, state) = (simulation.outputs().unwrap().forces, simulation.node());
    let contacts: Vec<_> = (0..2)
        .flat_map(|disc| model.pin_contacts(disc, 0.01, &state.position, &state.velocity))
        .filter(|contact| contact.force > 0.0)
        .collect();
    // p0 = √(F E*/(π B R)).
    let machine = machine();
    let line = machine.line_contact();
    let pressure = contacts
        .iter()
        .map(|c| {
            (c.force * line.effective_modulus * c.relative_curvature / (std::f64::consts::PI * line.width))
                .sqrt()
        })
        .fold(0.0, f64::max);
    assert!((forces.largest_pin_pressure / pressure - 1.0).abs() < 1e-12);
    assert_eq!(forces.loaded_pins, contacts.len());
    assert_eq!(forces.largest_pin_force, contacts.iter().map(|c| c.force).fold(0.0, f64::max));
}

/// Cancels after a number of calls.
struct Stopping(AtomicUsize);

impl Progress for Stopping {
    fn report(&self, _: &str, _: f64) {}

    fn is_cancelled(&self) -> bool {
        let left = self.0.load(Ordering::Relaxed);
        self.0.store(left.saturating_sub(1), Ordering::Relaxed);
        left == 0
    }
}

#[test]
fn every_step_and_iteration_can_be_cancelled() {
    let stop = |after: usize| Stopping(AtomicUsize::new(after));
    let model = bearings(law(), OutputLoad::Constant { torque: 412.0 });
    let cancelled = |error: DynamicsError| matches!(error, DynamicsError::Cancelled { .. });
    let control = StepControl::default();
    // During the search for static equilibrium.
    assert!(cancelled(Simulation::from_rest(model.clone(), control, &stop(2)).unwrap_err()));
    let mut simulation = start(model.clone());
    let mut other = simulation.clone();
    assert!(cancelled(simulation.advance_to(1e-3, &stop(5)).unwrap_err()));
    assert_eq!(simulation.counts().accepted, 5);
    // The simulation can be continued afterwards.
    simulation.advance_to(1e-3, &Silent).unwrap();
    other.advance_to(1e-3, &Silent).unwrap();
    assert_eq!(simulation.outputs().unwrap(), other.outputs().unwrap());
    let plan = RunPlan::default();
    assert!(cancelled(spread_over_starts(&model, plan, 2, &stop(30)).unwrap_err()));
}

#[test]
fn invalid_inputs_for_a_model_are_refused() {
    let mut simulation = start(ideal(law(), given(0.0)));
    assert!(simulation.set_motor(MotorInput::Torque { torque: 1.0, rate: 0.0 }).is_err());
    assert!(simulation.set_motor(MotorInput::Speed { speed: f64::NAN, acceleration: 0.0 }).is_err());
    assert!(simulation.set_load(LoadInput::Torque { torque: f64::INFINITY, rate: 0.0 }).is_err());
    assert!(simulation.advance_to(-1.0, &Silent).is_err());
    let mut free = start(ideal(Drive::GivenTorque(GivenTorque::default()), given(0.0)));
    assert!(free.set_motor(MotorInput::Speed { speed: 1.0, acceleration: 0.0 }).is_err());
    let far = OutputLoad::GivenMotion(GivenMotion { angle: 0.5, ..GivenMotion::default() });
    let model = ideal(Drive::GivenMotion(GivenMotion::default()), far);
    assert!(Simulation::from_rest(model, StepControl::default(), &Silent).is_err());
}
