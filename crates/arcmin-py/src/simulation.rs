//! A machine in motion, driven step by step.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use arcmin::analyses::AnalysisError;
use arcmin::design::OptionSet;
use arcmin::dynamics::{
    Drive, DynamicsError, GivenMotion, GivenTorque, LoadInput, Model, MotorInput, OutputLoad, Outputs,
    Reducer, SimulationState, StepControl,
};
use arcmin::fidelity::{Fidelity, FidelityOptions};
use arcmin::life::{WornState, worn_after};
use arcmin::progress::Progress;
use arcmin::units::{ARCMIN, MPA, UM};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::design::Design;
use crate::host::{ORIGIN, PyHost};
use crate::{errors, inputs, work};

/// A machine in motion with inputs from outside, for example motor torque or speed in, output angle out.
///
/// ``motor`` is "motion" (its speed or angle is prescribed) or "torque" (a torque on the inertia of motor and
/// sun). The machine starts at rest, in static equilibrium with the load at the output ``load_torque_n_m``. The
/// wear depth of the flanks is ``wear_um`` everywhere or that after ``hours`` of the duty. Further keywords
/// determine the fidelity (joints, discs, errors, seed, …), as in :func:`simulate`. Steps are adaptive; results
/// are independent, bit by bit, of the step of the caller.
#[pyclass(module = "arcmin", frozen)]
pub struct Simulation {
    inner: Mutex<arcmin::dynamics::Simulation>,
    design: Py<Design>,
    arguments: Py<PyDict>,
}

/// State of the machine at one instant. Angles and torques are counter-clockwise positive.
#[pyclass(module = "arcmin", frozen, get_all, name = "State")]
pub struct State {
    time_s: f64,
    /// Angle of the sun, or of the motor behind an elastic shaft, rad.
    input_angle_rad: f64,
    input_speed_rad_s: f64,
    output_angle_rad: f64,
    output_speed_rad_s: f64,
    /// Output angle less input angle over ratio, arcmin; negative if the output lags a positive motion.
    transmission_error_arcmin: f64,
    /// Input angle less ratio times output angle, rad: backlash and elastic twist as seen at the motor.
    wind_up_rad: f64,
    /// Torque of the motor on the input, N·m.
    input_torque_n_m: f64,
    /// Torque of the output on its load, N·m, positive against positive motion.
    output_torque_n_m: f64,
    /// Largest force on a pin of any disc, N.
    max_pin_force_n: f64,
    /// Largest Hertz pressure of a pin of any disc, MPa.
    max_pin_pressure_mpa: f64,
    /// Number of loaded pins, over all discs.
    loaded_pins: usize,
    kinetic_energy_j: f64,
    elastic_energy_j: f64,
    /// Present loss in friction and dampers, W.
    dissipation_w: f64,
}

impl State {
    fn of(o: &Outputs) -> State {
        State {
            time_s: o.time,
            input_angle_rad: o.input_angle,
            input_speed_rad_s: o.input_speed,
            output_angle_rad: o.output_angle,
            output_speed_rad_s: o.output_speed,
            transmission_error_arcmin: o.transmission_error / ARCMIN,
            wind_up_rad: o.wind_up,
            input_torque_n_m: o.input_torque,
            output_torque_n_m: o.output_torque,
            max_pin_force_n: o.forces.largest_pin_force,
            max_pin_pressure_mpa: o.forces.largest_pin_pressure / MPA,
            loaded_pins: o.forces.loaded_pins,
            kinetic_energy_j: o.kinetic_energy,
            elastic_energy_j: o.balance.stored,
            dissipation_w: o.balance.dissipation,
        }
    }
}

#[pymethods]
impl State {
    fn __repr__(&self) -> String {
        format!(
            "<State t = {:.6} s, input {:.4} rad, output {:.6} rad, error {:.4} arcmin>",
            self.time_s, self.input_angle_rad, self.output_angle_rad, self.transmission_error_arcmin
        )
    }
}

/// Checks for Ctrl-C on the calling thread during steps of the simulation.
struct Signals {
    started: Instant,
    next_ms: AtomicU64,
    raised: Mutex<Option<PyErr>>,
}

const INTERVAL_MS: u64 = 50;

impl Signals {
    fn new() -> Signals {
        Signals { started: Instant::now(), next_ms: AtomicU64::new(INTERVAL_MS), raised: Mutex::new(None) }
    }

    fn raised(&self) -> MutexGuard<'_, Option<PyErr>> {
        self.raised.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress for Signals {
    fn report(&self, _: &str, _: f64) {}

    fn is_cancelled(&self) -> bool {
        let now = self.started.elapsed().as_millis() as u64;
        if now < self.next_ms.load(Ordering::Relaxed) {
            return false;
        }
        self.next_ms.store(now + INTERVAL_MS, Ordering::Relaxed);
        match Python::attach(|py| py.check_signals()) {
            Ok(()) => false,
            Err(error) => {
                *self.raised() = Some(error);
                true
            }
        }
    }
}

/// Arguments of the constructor in addition to the fidelity.
struct Start {
    free_motor: bool,
    load_torque: f64,
    wear: Option<f64>,
    hours: Option<f64>,
    drag: f64,
    tolerance: f64,
}

fn start(
    design: &arcmin::design::Design,
    options: &str,
    with: Start,
    host: &PyHost,
) -> Result<arcmin::dynamics::Simulation, AnalysisError> {
    let options = FidelityOptions::parse(options, ORIGIN)?;
    let machine = design.machine();
    let worn = match (with.wear, with.hours) {
        (Some(_), Some(_)) => {
            return Err(AnalysisError::usage(
                "uniform wear (wear_um) and wear by the duty (hours) exclude each other",
                "leave one of them out",
            ));
        }
        (wear, None) => WornState::uniform(wear.unwrap_or(0.0) * UM),
        (None, Some(hours)) => {
            let fidelity = Fidelity::resolve(design, &options, host)?;
            worn_after(&machine, &fidelity, hours, host)?
        }
    };
    let drive = match with.free_motor {
        true => Drive::GivenTorque(GivenTorque::constant(0.0)),
        false => Drive::GivenMotion(GivenMotion::default()),
    };
    let load = OutputLoad::GivenTorque(GivenTorque::constant(with.load_torque));
    let fidelity = Fidelity::resolve(design, &options, host)?;
    let model: Model = fidelity.model(&machine, &worn, drive, load, with.drag, None)?;
    let control = StepControl { tolerance: with.tolerance, ..StepControl::default() };
    arcmin::dynamics::Simulation::from_rest(model, control, host).map_err(|error| match error {
        DynamicsError::Cancelled { .. } => AnalysisError::Stopped,
        error => AnalysisError::compute("start the simulation")(error),
    })
}

fn within(py: Python<'_>, name: &str, value: Option<f64>, low: f64, high: f64) -> PyResult<()> {
    match value {
        Some(value) if !(low..=high).contains(&value) => {
            Err(errors::value(py, name, &format!("`{name}` lies from {low} to {high}, not at {value}"), true))
        }
        _ => Ok(()),
    }
}

impl Simulation {
    fn inner(&self) -> MutexGuard<'_, arcmin::dynamics::Simulation> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Uses the simulation without the interpreter lock; Ctrl-C ends the work.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        what: impl FnOnce(&mut arcmin::dynamics::Simulation, &Signals) -> Result<T, DynamicsError> + Send,
    ) -> PyResult<T> {
        let signals = Signals::new();
        let done = py.detach(|| what(&mut self.inner(), &signals));
        done.map_err(|error| signals.raised().take().unwrap_or_else(|| errors::dynamics(py, &error)))
    }
}

/// At most one of these may be given.
fn one_of<T>(py: Python<'_>, what: &str, given: Vec<Option<T>>) -> PyResult<Option<T>> {
    let mut given: Vec<T> = given.into_iter().flatten().collect();
    if given.len() > 1 {
        let message = format!("the {what} takes one of torque, speed and angle at a time");
        return Err(errors::value(py, what, &message, true));
    }
    Ok(given.pop())
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (
        design, *, motor = "motion", load_torque_n_m = 0.0, wear_um = None, hours = None, drag_n_m = 0.0,
        tolerance_arcmin = 5e-5, **fidelity
    ))]
    fn new(
        py: Python<'_>,
        design: Py<Design>,
        motor: &str,
        load_torque_n_m: f64,
        wear_um: Option<f64>,
        hours: Option<f64>,
        drag_n_m: f64,
        tolerance_arcmin: f64,
        fidelity: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Simulation> {
        let free_motor = match motor {
            "motion" => false,
            "torque" => true,
            other => {
                let message = format!("`motor` is \"motion\" or \"torque\", not \"{other}\"");
                return Err(errors::value(py, "motor", &message, true));
            }
        };
        within(py, "load_torque_n_m", Some(load_torque_n_m), -1e7, 1e7)?;
        within(py, "wear_um", wear_um, 0.0, 1000.0)?;
        within(py, "hours", hours, 0.0, 1e7)?;
        within(py, "drag_n_m", Some(drag_n_m), 0.0, 1e6)?;
        within(py, "tolerance_arcmin", Some(tolerance_arcmin), 1e-10, 1.0)?;
        let arguments = PyDict::new(py);
        arguments.set_item("motor", motor)?;
        arguments.set_item("load_torque_n_m", load_torque_n_m)?;
        arguments.set_item("wear_um", wear_um)?;
        arguments.set_item("hours", hours)?;
        arguments.set_item("drag_n_m", drag_n_m)?;
        arguments.set_item("tolerance_arcmin", tolerance_arcmin)?;
        let mut options = String::new();
        if let Some(given) = fidelity {
            options = inputs::options_text(FidelityOptions::schema(), given)?;
            arguments.update(given.as_mapping())?;
        }
        let now = design.get().now();
        let host = Arc::new(PyHost::new(design.get().directory(), HashMap::new()));
        let with = Start {
            free_motor,
            load_torque: load_torque_n_m,
            wear: wear_um,
            hours,
            drag: drag_n_m,
            tolerance: tolerance_arcmin,
        };
        let (asked, hears) = (now.clone(), host.clone());
        let inner = work::wait_for(py, &host, None, None, move || {
            start(asked.rv("Simulation")?, &options, with, &hears)
        })?
        .map_err(|error| errors::analysis(py, &error, Some(&now)))?;
        // Later changes of the caller's design do not affect this machine.
        let design = Py::new(py, design.get().copied())?;
        Ok(Simulation { inner: Mutex::new(inner), design, arguments: arguments.unbind() })
    }

    #[staticmethod]
    fn _restored(
        py: Python<'_>,
        design: &Bound<'_, PyAny>,
        arguments: &Bound<'_, PyDict>,
        state: &[u8],
    ) -> PyResult<Py<PyAny>> {
        let simulation = py.get_type::<Simulation>().call((design,), Some(arguments))?;
        simulation.call_method1("restore", (PyBytes::new(py, state),))?;
        Ok(simulation.unbind())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let make = py.get_type::<Simulation>().getattr("_restored")?;
        let arguments = (self.design.bind(py), self.arguments.bind(py), self.save(py)?).into_pyobject(py)?;
        Ok((make, arguments.into_any()))
    }

    /// Ratio of input to output angle.
    #[getter]
    fn ratio(&self) -> f64 {
        self.inner().model().ratio()
    }

    /// Present time in s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.inner().time()
    }

    /// Present state of the machine.
    #[getter]
    fn state(&self, py: Python<'_>) -> PyResult<State> {
        self.with(py, |simulation, _| Ok(State::of(&simulation.outputs()?)))
    }

    /// Sets the motor from the present time: one of torque_n_m (with rate_n_m_s), speed_rad_s or angle_rad
    /// (with acceleration_rad_s2; an angle may have a speed).
    #[pyo3(signature = (
        *, torque_n_m = None, rate_n_m_s = 0.0, speed_rad_s = None, angle_rad = None,
        acceleration_rad_s2 = 0.0
    ))]
    fn set_motor(
        &self,
        py: Python<'_>,
        torque_n_m: Option<f64>,
        rate_n_m_s: f64,
        speed_rad_s: Option<f64>,
        angle_rad: Option<f64>,
        acceleration_rad_s2: f64,
    ) -> PyResult<()> {
        let acceleration = acceleration_rad_s2;
        let motion = match (angle_rad, speed_rad_s) {
            (Some(angle), speed) => {
                Some(MotorInput::Angle { angle, speed: speed.unwrap_or(0.0), acceleration })
            }
            (None, Some(speed)) => Some(MotorInput::Speed { speed, acceleration }),
            (None, None) => None,
        };
        let torque = torque_n_m.map(|torque| MotorInput::Torque { torque, rate: rate_n_m_s });
        match one_of(py, "motor", vec![motion, torque])? {
            Some(input) => self.with(py, |simulation, _| simulation.set_motor(input)),
            None => Ok(()),
        }
    }

    /// Sets the load at the output from the present time: one of torque_n_m (positive against positive motion,
    /// with rate_n_m_s), speed_rad_s or angle_rad (with acceleration_rad_s2; an angle may have a speed).
    #[pyo3(signature = (
        *, torque_n_m = None, rate_n_m_s = 0.0, speed_rad_s = None, angle_rad = None,
        acceleration_rad_s2 = 0.0
    ))]
    fn set_load(
        &self,
        py: Python<'_>,
        torque_n_m: Option<f64>,
        rate_n_m_s: f64,
        speed_rad_s: Option<f64>,
        angle_rad: Option<f64>,
        acceleration_rad_s2: f64,
    ) -> PyResult<()> {
        let acceleration = acceleration_rad_s2;
        let motion = match (angle_rad, speed_rad_s) {
            (Some(angle), speed) => {
                Some(LoadInput::Angle { angle, speed: speed.unwrap_or(0.0), acceleration })
            }
            (None, Some(speed)) => Some(LoadInput::Speed { speed, acceleration }),
            (None, None) => None,
        };
        let torque = torque_n_m.map(|torque| LoadInput::Torque { torque, rate: rate_n_m_s });
        match one_of(py, "output", vec![motion, torque])? {
            Some(input) => self.with(py, |simulation, _| simulation.set_load(input)),
            None => Ok(()),
        }
    }

    /// Advances by dt_s seconds and returns the new state. Inputs given here are valid from the present time.
    #[pyo3(signature = (
        dt_s, *, motor_torque_n_m = None, motor_speed_rad_s = None, load_torque_n_m = None,
        output_speed_rad_s = None
    ))]
    fn advance(
        &self,
        py: Python<'_>,
        dt_s: f64,
        motor_torque_n_m: Option<f64>,
        motor_speed_rad_s: Option<f64>,
        load_torque_n_m: Option<f64>,
        output_speed_rad_s: Option<f64>,
    ) -> PyResult<State> {
        within(py, "dt_s", Some(dt_s), 0.0, 1e6)?;
        let motor = vec![
            motor_torque_n_m.map(|torque| MotorInput::Torque { torque, rate: 0.0 }),
            motor_speed_rad_s.map(|speed| MotorInput::Speed { speed, acceleration: 0.0 }),
        ];
        let load = vec![
            load_torque_n_m.map(|torque| LoadInput::Torque { torque, rate: 0.0 }),
            output_speed_rad_s.map(|speed| LoadInput::Speed { speed, acceleration: 0.0 }),
        ];
        let (motor, load) = (one_of(py, "motor", motor)?, one_of(py, "output", load)?);
        self.with(py, |simulation, signals| {
            if let Some(input) = motor {
                simulation.set_motor(input)?;
            }
            if let Some(input) = load {
                simulation.set_load(input)?;
            }
            simulation.advance_to(simulation.time() + dt_s, signals)?;
            Ok(State::of(&simulation.outputs()?))
        })
    }

    /// Complete state, from which the simulation can be continued, without the model itself.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = self.with(py, |simulation, _| simulation.save().to_bytes())?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Returns, or advances, to a state saved from the same machine, without loss of precision.
    fn restore(&self, py: Python<'_>, state: &[u8]) -> PyResult<()> {
        self.with(py, |simulation, _| simulation.restore(&SimulationState::from_bytes(state)?))
    }

    fn __repr__(&self) -> String {
        format!("<Simulation at t = {:.6} s>", self.time_s())
    }
}
