//! The reducer as a map model: torsion curve, hysteresis, waves and losses of the joint, with the inertia of
//! the output flange.

mod mixed;

use serde::{Deserialize, Serialize};

use mixed::{mix, mixed_hysteresis, mixed_losses, mixed_pins, mixed_waves};

use super::{LoadFlange, PinLoadAt};
use crate::exchange::ExchangeError;
use crate::exchange::joint::{FLANGE_DAMPING_RATIO, Hysteresis, JointExport, SlipElement, TransmissionWaves};
use crate::rig::LossLine;

/// Longest step in s within a communication step. The natural frequency of the flange alone on the gear's
/// stiffness is about 10 krad/s; its product with the step, 0.2 rad, has an error of 0.3 %.
const LONGEST_STEP: f64 = 2e-5;
/// Largest product of natural frequency, while all slip elements stick, and step for a lighter flange, rad.
const LARGEST_TURN: f64 = 1.0 / 3.0;
/// Speed of the input in rad/s below which friction is regularised.
const CREEP: f64 = 0.5;
/// Iterations of one equilibrium: a bracket of one turn is reduced to rounding.
const ITERATIONS: usize = 80;

/// Input values over a step: at its beginning, and their rates.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct MapInputs {
    /// Motor angle, speed and acceleration: rad, rad/s, rad/s².
    pub motor: [f64; 3],
    /// Load torque in N·m along positive motion and its rate in N·m/s, or …
    pub load_torque: [f64; 2],
    /// … angle, speed and acceleration of the load flange: rad, rad/s, rad/s².
    pub load_motion: [f64; 3],
}

impl MapInputs {
    fn require_finite(&self) -> Result<(), ExchangeError> {
        let all = self.motor.iter().chain(&self.load_torque).chain(&self.load_motion);
        match all.copied().find(|value| !value.is_finite()) {
            Some(value) => {
                Err(ExchangeError::Option { what: "an input", value, low: f64::MIN, high: f64::MAX })
            }
            None => Ok(()),
        }
    }
}

/// Complete state: everything that the further motion depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MapState {
    /// Time since the start, s.
    pub time: f64,
    /// Angle, speed and acceleration of the load flange: rad, rad/s, rad/s².
    pub flange: [f64; 3],
    /// The same of the motor flange.
    motor: [f64; 3],
    slips: Vec<f64>,
    /// Wind-up in rad and torque of the gear on the flange in N·m.
    wind_up: f64,
    torque: f64,
    /// Torque at the motor and on the load flange in N·m.
    motor_torque: f64,
    load_torque: f64,
    loss: f64,
    /// Energy supplied and energy dissipated in J, and the sums of their magnitudes.
    work: f64,
    lost: f64,
    turnover: f64,
    /// Stored energy in J at the start.
    stored_at_start: f64,
}

/// Outputs of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapOutputs {
    /// Torque at the motor flange, N·m.
    pub motor_torque: f64,
    /// Torque on the load flange in N·m along positive motion.
    pub load_torque: f64,
    /// Angle, speed and acceleration of the load flange: rad, rad/s, rad/s².
    pub flange: [f64; 3],
    /// θ_out − θ_in/i in rad, including wind-up.
    pub transmission_error: f64,
    /// Angle on the torsion curve, rad.
    pub wind_up: f64,
    /// Largest force of a pin at this torque, N.
    pub pin_force: f64,
    /// Largest Hertz pressure of a pin at this torque, Pa.
    pub pin_pressure: f64,
    /// Power lost by friction, W.
    pub loss: f64,
    /// Residual of the energy balance relative to the transmitted energy.
    pub balance: f64,
}

/// The map of one age.
#[derive(Debug, Clone, PartialEq)]
pub struct MapModel {
    ratio: f64,
    rated: f64,
    /// Moments of inertia in kg·m²: of the flange at the output; of all parts driven by the motor, at the
    /// input.
    flange_inertia: f64,
    input_inertia: f64,
    hysteresis: Hysteresis,
    waves: Vec<TransmissionWaves>,
    losses: Vec<LossLine>,
    pins: Vec<PinLoadAt>,
    load: LoadFlange,
    friction: bool,
    damping: f64,
    /// Longest step, s.
    longest_step: f64,
}

impl MapModel {
    /// The map at an age (h) within the range of the computed ones.
    ///
    /// # Errors
    /// [`ExchangeError::Option`] for an age outside of this range.
    pub fn at(
        joint: &JointExport,
        pins: &[Vec<PinLoadAt>],
        hours: f64,
        load: LoadFlange,
        friction: bool,
    ) -> Result<MapModel, ExchangeError> {
        let low = joint.states.first().map_or(0.0, |state| state.hours);
        let high = joint.states.last().map_or(0.0, |state| state.hours);
        let index = joint.states.iter().rposition(|state| state.hours <= hours);
        let (Some(index), true) = (index, hours <= high) else {
            return Err(ExchangeError::Option { what: "an age in hours", value: hours, low, high });
        };
        let next = (index + 1).min(joint.states.len() - 1);
        let (a, b) = (&joint.states[index], &joint.states[next]);
        let share = if next > index { (hours - a.hours) / (b.hours - a.hours) } else { 0.0 };
        let none = Vec::new();
        let of = |index: usize| pins.get(index).unwrap_or(&none);
        let hysteresis = mixed_hysteresis(&a.hysteresis, &b.hysteresis, share);
        let stiffness = hysteresis.stiffest();
        let longest_step = match load {
            LoadFlange::Torque => {
                let stuck = hysteresis.stuck_stiffness(joint.rated_torque_n_m);
                LONGEST_STEP.min(LARGEST_TURN * (joint.inertia.output_kg_m2 / stuck).sqrt())
            }
            LoadFlange::Motion => LONGEST_STEP,
        };
        Ok(MapModel {
            longest_step,
            ratio: joint.ratio,
            rated: joint.rated_torque_n_m,
            flange_inertia: joint.inertia.output_kg_m2,
            // The motor is not part of the unit.
            input_inertia: joint.inertia.sun_kg_m2 + joint.inertia.gear_kg_m2,
            damping: 2.0 * FLANGE_DAMPING_RATIO * (stiffness * joint.inertia.output_kg_m2).sqrt(),
            hysteresis,
            waves: a
                .transmission_error
                .iter()
                .zip(&b.transmission_error)
                .map(|(a, b)| mixed_waves(a, b, share))
                .collect(),
            losses: a.losses.iter().zip(&b.losses).map(|(a, b)| mixed_losses(a, b, share)).collect(),
            pins: of(index).iter().zip(of(next)).map(|(a, b)| mixed_pins(a, b, share)).collect(),
            load,
            friction,
        })
    }

    /// Waves of the transmission error in rad at an output angle (rad) for a torque (N·m) of the gear on its
    /// flange: those computed with this torque against the motion, so that its sign determines the loaded
    /// flanks.
    fn waves(&self, angle: f64, torque: f64) -> f64 {
        let at = |waves: &TransmissionWaves| waves.direction * waves.torque_n_m;
        let by = |a: &&TransmissionWaves, b: &&TransmissionWaves| at(a).total_cmp(&at(b));
        let below = self.waves.iter().filter(|waves| at(waves) <= torque).max_by(by);
        let above = self.waves.iter().filter(|waves| at(waves) > torque).min_by(by);
        match (below, above) {
            (Some(a), Some(b)) => mix(a.at(angle), b.at(angle), (torque - at(a)) / (at(b) - at(a))),
            (Some(one), None) | (None, Some(one)) => one.at(angle),
            (None, None) => 0.0,
        }
    }

    /// Wind-up in rad for the angles of motor and load.
    fn wind_up(&self, motor: [f64; 3], flange: f64, torque: f64) -> f64 {
        let nominal = motor[0] / self.ratio;
        nominal + self.waves(nominal, torque) - flange
    }

    /// Torque in N·m of the gear on its flange at a wind-up, and the states of the slip elements there.
    fn gear(&self, state: &MapState, wind_up: f64) -> (f64, Vec<f64>) {
        let elastic = self.hysteresis.elastic(wind_up);
        if !self.friction {
            return (elastic, state.slips.clone());
        }
        let mut slips = state.slips.clone();
        self.hysteresis.follow(&mut slips, wind_up - state.wind_up);
        (elastic + self.hysteresis.slip_torque(elastic, &slips), slips)
    }

    /// Lost torque at the input in N·m at a speed (rad/s) for a torque (N·m) at the output.
    fn loss_torque(&self, speed: f64, torque: f64) -> f64 {
        if !self.friction || self.losses.is_empty() {
            return 0.0;
        }
        let size = speed.abs();
        let next = self.losses.iter().position(|line| line.input_speed_rad_per_s > size);
        let line = match next {
            Some(0) => self.losses[0],
            None => self.losses[self.losses.len() - 1],
            Some(next) => {
                let (a, b) = (&self.losses[next - 1], &self.losses[next]);
                let share =
                    (size - a.input_speed_rad_per_s) / (b.input_speed_rad_per_s - a.input_speed_rad_per_s);
                mixed_losses(a, b, share)
            }
        };
        let at_input = (torque / self.ratio).abs();
        let driving = torque * speed * self.ratio.signum() >= 0.0;
        let size = if driving {
            at_input * (1.0 / line.efficiency[0] - 1.0) + line.friction_n_m[0]
        } else {
            at_input * (1.0 - line.efficiency[1]) + line.friction_n_m[1]
        };
        size.max(0.0) * (speed / CREEP).tanh()
    }

    /// The machine at rest at the start: the gear supports the load, with slip elements in their initial state.
    ///
    /// # Errors
    /// [`ExchangeError::Option`] for inputs that are not finite.
    pub fn start(&self, inputs: &MapInputs) -> Result<MapState, ExchangeError> {
        inputs.require_finite()?;
        let mut state = MapState {
            time: 0.0,
            flange: [inputs.motor[0] / self.ratio, inputs.motor[1] / self.ratio, 0.0],
            motor: inputs.motor,
            slips: vec![0.0; self.hysteresis.elements.len()],
            wind_up: 0.0,
            torque: 0.0,
            motor_torque: 0.0,
            load_torque: 0.0,
            loss: 0.0,
            work: 0.0,
            lost: 0.0,
            turnover: 0.0,
            stored_at_start: 0.0,
        };
        match self.load {
            LoadFlange::Torque => {
                let needed = -inputs.load_torque[0];
                // The gear supports the load: wind-up at which it has that torque.
                let reach = self.hysteresis.reach(needed.abs() + 1.0);
                let (mut low, mut high) = (-reach, reach);
                for _ in 0..ITERATIONS {
                    let middle = 0.5 * (low + high);
                    if self.gear(&state, middle).0 < needed { low = middle } else { high = middle }
                }
                let wind_up = 0.5 * (low + high);
                let (torque, slips) = self.gear(&state, wind_up);
                let flange = self.wind_up(inputs.motor, 0.0, torque) - wind_up;
                (state.wind_up, state.torque, state.slips) = (wind_up, torque, slips);
                state.flange = [flange, inputs.motor[1] / self.ratio, 0.0];
                state.load_torque = inputs.load_torque[0];
            }
            LoadFlange::Motion => {
                state.flange = inputs.load_motion;
                state.wind_up = self.wind_up(inputs.motor, inputs.load_motion[0], 0.0);
                let at_rest = MapState { wind_up: 0.0, ..state.clone() };
                (state.torque, state.slips) = self.gear(&at_rest, state.wind_up);
                state.load_torque = self.flange_inertia * inputs.load_motion[2] - state.torque;
            }
        }
        self.update_motor(&mut state);
        state.stored_at_start = self.stored(&state);
        Ok(state)
    }

    /// Torque at the motor and lost power of the present state.
    fn update_motor(&self, state: &mut MapState) {
        let lost = self.loss_torque(state.motor[1], state.torque);
        state.motor_torque = state.torque / self.ratio + lost + self.input_inertia * state.motor[2];
        state.loss = lost * state.motor[1];
    }

    /// Elastic and kinetic energy in J; the energy of a sticking element is half its torque times its
    /// displacement.
    fn stored(&self, state: &MapState) -> f64 {
        let elements = self.hysteresis.elements.iter().zip(&state.slips);
        let elastic = self.hysteresis.elastic(state.wind_up).abs();
        let sliders: f64 = if self.friction {
            elements.map(|(e, z)| 0.5 * e.torque(elastic) * e.slip_rad * z * z).sum()
        } else {
            0.0
        };
        self.hysteresis.energy(state.wind_up)
            + sliders
            + 0.5 * self.flange_inertia * state.flange[1].powi(2)
            + 0.5 * self.input_inertia * state.motor[1].powi(2)
    }

    /// Advances to `time` (s) under inputs that are given at the state's time.
    ///
    /// # Errors
    /// [`ExchangeError::Option`] for a time in the past, and inputs that are not finite.
    pub fn advance(&self, state: &mut MapState, inputs: &MapInputs, time: f64) -> Result<(), ExchangeError> {
        let length = time - state.time;
        if !(length >= 0.0 && length.is_finite()) {
            let (low, high) = (state.time, f64::MAX);
            return Err(ExchangeError::Option { what: "a time to reach", value: time, low, high });
        }
        inputs.require_finite()?;
        // A whole number of steps; a small excess by rounding is ignored.
        let steps = (length / self.longest_step - 1e-6).ceil().max(1.0);
        if length == 0.0 {
            return Ok(());
        }
        let h = length / steps;
        let start = state.time;
        for step in 1..=steps as u64 {
            let x = h * step as f64;
            let at = |given: [f64; 3]| {
                [given[0] + x * (given[1] + 0.5 * x * given[2]), given[1] + x * given[2], given[2]]
            };
            let load = inputs.load_torque[0] + x * inputs.load_torque[1];
            self.step(state, h, at(inputs.motor), load, at(inputs.load_motion));
            state.time = start + x;
        }
        state.time = time;
        Ok(())
    }

    fn step(&self, state: &mut MapState, h: f64, motor: [f64; 3], load: f64, motion: [f64; 3]) {
        let before = state.clone();
        let flange = match self.load {
            LoadFlange::Motion => motion,
            LoadFlange::Torque => self.flange_after(state, h, motor, load),
        };
        let wind_up = self.wind_up(motor, flange[0], before.torque);
        let (torque, slips) = self.gear(state, wind_up);
        state.motor = motor;
        state.flange = flange;
        (state.wind_up, state.torque, state.slips) = (wind_up, torque, slips);
        let slip = motor[1] / self.ratio - flange[1];
        state.load_torque = match self.load {
            LoadFlange::Torque => load,
            LoadFlange::Motion => self.flange_inertia * flange[2] - torque,
        };
        self.update_motor(state);
        // Work by the trapezoidal rule; the loss of the slip elements is their work less the change of their
        // stored energy.
        let mean = |a: f64, b: f64| 0.5 * h * (a + b);
        let power = |s: &MapState| [s.motor_torque * s.motor[1], s.load_torque * s.flange[1]];
        let [motor_power, load_power] = power(state);
        let [motor_before, load_before] = power(&before);
        state.work += mean(motor_power, motor_before) + mean(load_power, load_before);
        let viscous = match self.load {
            LoadFlange::Torque => self.damping * slip * slip * h,
            LoadFlange::Motion => 0.0,
        };
        let sliding = if self.friction { self.slid(&before, state) } else { 0.0 };
        let lost = mean(state.loss, before.loss) + viscous + sliding;
        state.lost += lost;
        state.turnover += mean(motor_power.abs(), motor_before.abs())
            + mean(load_power.abs(), load_before.abs())
            + lost.abs();
        state.loss = lost / h;
    }

    /// Energy in J dissipated by slip elements between two states: torque times displacement in excess of the
    /// elastic one.
    fn slid(&self, before: &MapState, after: &MapState) -> f64 {
        let change = after.wind_up - before.wind_up;
        let size = |state: &MapState| self.hysteresis.elastic(state.wind_up).abs();
        let elastic = 0.5 * (size(after) + size(before));
        let one = |(index, element): (usize, &SlipElement)| {
            let bent = (after.slips[index] - before.slips[index]) * element.slip_rad;
            (element.torque(elastic) * after.slips[index] * (change - bent)).max(0.0)
        };
        self.hysteresis.elements.iter().enumerate().map(one).sum()
    }

    /// The flange after a step by the trapezoidal rule: J (w₁ − w₀)/h = ½ (M₀ + M₁) with the torques of gear,
    /// damper and load. The residual increases with w₁, so that Newton's method within a bracket converges.
    fn flange_after(&self, state: &MapState, h: f64, motor: [f64; 3], load: f64) -> [f64; 3] {
        let (angle, speed) = (state.flange[0], state.flange[1]);
        let before = state.torque + state.load_torque + self.damping * (state.motor[1] / self.ratio - speed);
        let place = |w: f64| angle + 0.5 * h * (speed + w);
        let residual = |w: f64| {
            let wind_up = self.wind_up(motor, place(w), state.torque);
            let gear = self.gear(state, wind_up).0;
            let after = gear + load + self.damping * (motor[1] / self.ratio - w);
            self.flange_inertia * (w - speed) / h - 0.5 * (before + after)
        };
        let stiffest = self.hysteresis.stiffest();
        let slope = self.flange_inertia / h + 0.5 * self.damping + 0.25 * h * stiffest;
        // The slope of the residual is at least J/h, so that its root is within this distance of the start.
        let reach = residual(speed).abs() / (self.flange_inertia / h) * 1.001 + 1e-12;
        let (mut low, mut high) = (speed - reach, speed + reach);
        let mut w = speed - residual(speed) / slope;
        for _ in 0..ITERATIONS {
            if !(w > low && w < high) {
                w = 0.5 * (low + high);
            }
            let left = residual(w);
            if left > 0.0 {
                high = w
            } else {
                low = w
            }
            let next = w - left / slope;
            if (next - w).abs() <= 1e-14 * (1.0 + w.abs()) || high - low <= 1e-15 * (1.0 + w.abs()) {
                break;
            }
            w = next;
        }
        [place(w), w, (w - speed) / h]
    }

    /// Outputs of the map at a state.
    pub fn outputs(&self, state: &MapState) -> MapOutputs {
        let torque = state.torque.abs();
        let pin = |of: fn(&PinLoadAt) -> f64| {
            let next = self.pins.iter().position(|pin| pin.torque_n_m >= torque);
            match next {
                _ if self.pins.is_empty() => 0.0,
                Some(0) => of(&self.pins[0]) * torque / self.pins[0].torque_n_m,
                Some(next) => {
                    let (a, b) = (&self.pins[next - 1], &self.pins[next]);
                    mix(of(a), of(b), (torque - a.torque_n_m) / (b.torque_n_m - a.torque_n_m))
                }
                // Beyond the last one proportional to the torque.
                None => {
                    let last = &self.pins[self.pins.len() - 1];
                    of(last) * torque / last.torque_n_m
                }
            }
        };
        let left = state.work - state.lost - (self.stored(state) - state.stored_at_start);
        MapOutputs {
            motor_torque: state.motor_torque,
            load_torque: state.load_torque,
            flange: state.flange,
            transmission_error: state.flange[0] - state.motor[0] / self.ratio,
            wind_up: state.wind_up,
            pin_force: pin(|pin| pin.force_n),
            pin_pressure: pin(|pin| pin.pressure_pa),
            loss: state.loss,
            balance: left / state.turnover.max(1e-9 * self.rated),
        }
    }
}
