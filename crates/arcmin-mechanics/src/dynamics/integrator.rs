use super::{Balance, DenseLinearisation, DynamicsError, System, Weights};

mod coefficients;
mod control;
mod secants;
mod state;

use coefficients::Coefficients;
pub use control::StepControl;
use secants::Secants;
use state::MatrixPlace;
pub(crate) use state::hermite;
pub use state::{EnergyAccount, IntegratorState, Node, StepCounts};

/// Implicit integration of M q̈ = Q(q, q̇, t) with error-controlled step.
///
/// Generalised-α, second order, unconditionally stable; Newton's method with the system's own linearisation. A
/// [large](DenseLinearisation::is_large) factorised matrix is reused from step to step, with Broyden's updates,
/// as long as corrections converge fast; for a small one the factorisation costs less than additional
/// iterations. The local error of the velocity is estimated from the difference between the corrected and an
/// extrapolated (Adams–Bashforth) velocity, that of the position from the change of acceleration. The
/// extrapolation does not include a contact that closes within a step; such a step has a large error and is
/// repeated with a smaller size. The step is kept below the time in which an open contact can close
/// ([`Balance::onset_rate`]), so that no contact closes and opens within one step.
#[derive(Debug, Clone)]
pub struct Integrator<S: System> {
    system: S,
    control: StepControl,
    coefficients: Coefficients,
    state: IntegratorState,
    lin: DenseLinearisation,
    /// Whether `lin` is the matrix described by the state.
    has_matrix: bool,
    trial: Node,
    force: Vec<f64>,
    correction: Vec<f64>,
    auxiliary: Vec<f64>,
    predicted_velocity: Vec<f64>,
    scaled_auxiliary: Vec<f64>,
    secants: Secants,
}

/// Newton's iterations end when the last correction is below this fraction of the tolerance or, with a reused
/// matrix, when the estimated sum of the remaining corrections is…
const NEWTON_SHARE: f64 = 1e-3;
/// …and the last correction is below this fraction: torque and powers are those before it.
const LAST_SHARE: f64 = 1e-2;
const LARGEST_NEWTON_COUNT: usize = 12;
/// If corrections shrink by less than this factor, the matrix of the present iterate is formed: it costs as
/// much as several evaluations of the forces.
const SLOW: f64 = 0.1;
/// If the step could grow by less than this factor, it is not changed, so that the matrix can be reused.
const WORTHWHILE: f64 = 1.2;

enum Attempt {
    /// Converged, with the error over the tolerance.
    Converged(f64),
    /// Newton's method did not converge; the largest residual.
    Failed(f64),
}

impl<S: System> Integrator<S> {
    /// Starts at the given state.
    ///
    /// # Errors
    /// A step control without meaning, or a state with forces that are not finite.
    pub fn new(
        system: S,
        control: StepControl,
        time: f64,
        position: &[f64],
        velocity: &[f64],
    ) -> Result<Self, DynamicsError> {
        control.validate()?;
        let n = system.size();
        let node = Node {
            time,
            position: position.to_vec(),
            velocity: velocity.to_vec(),
            acceleration: vec![0.0; n],
            balance: Balance::default(),
        };
        let state = IntegratorState {
            current: node.clone(),
            previous: node,
            auxiliary: vec![0.0; n],
            jerk: vec![0.0; n],
            matrix: None,
            last_step: 0.0,
            next_step: control.fixed_step.unwrap_or(control.first_step),
            energy: EnergyAccount::default(),
            counts: StepCounts::default(),
        };
        let mut integrator = Integrator::resume(system, control, state)?;
        integrator.restart()?;
        let energy = integrator.total_energy();
        integrator.state.energy =
            EnergyAccount { initial: energy, current: energy, ..EnergyAccount::default() };
        integrator.state.previous = integrator.state.current.clone();
        Ok(integrator)
    }

    /// Continues from a saved state; the continuation is bit-identical to an uninterrupted run.
    ///
    /// # Errors
    /// [`DynamicsError::ForeignCheckpoint`] if the number of coordinates differs.
    pub fn resume(system: S, control: StepControl, state: IntegratorState) -> Result<Self, DynamicsError> {
        control.validate()?;
        let n = system.size();
        state.check_size(n)?;
        Ok(Integrator {
            lin: system.linearisation(),
            has_matrix: false,
            system,
            control,
            coefficients: Coefficients::new(control.spectral_radius),
            trial: state.current.clone(),
            force: vec![0.0; n],
            correction: vec![0.0; n],
            auxiliary: vec![0.0; n],
            predicted_velocity: vec![0.0; n],
            scaled_auxiliary: vec![0.0; n],
            secants: Secants::default(),
            state,
        })
    }

    /// State at both ends of the last accepted step.
    pub fn state(&self) -> &IntegratorState {
        &self.state
    }

    /// State to resume from.
    pub fn into_state(self) -> IntegratorState {
        self.state
    }

    /// Time at the end of the last accepted step, s.
    pub fn time(&self) -> f64 {
        self.state.current.time
    }

    /// State at the end of the last step.
    pub fn current(&self) -> &Node {
        &self.state.current
    }

    /// State at the beginning of the last step.
    pub fn previous(&self) -> &Node {
        &self.state.previous
    }

    /// System whose equations of motion are integrated.
    pub fn system(&self) -> &S {
        &self.system
    }

    /// The system, to change inputs or loads; call [`Integrator::restart`] afterwards.
    pub fn system_mut(&mut self) -> &mut S {
        &mut self.system
    }

    /// Tolerances and limits of the step size.
    pub fn control(&self) -> StepControl {
        self.control
    }

    /// Returns, or advances, to a saved state of this system.
    ///
    /// # Errors
    /// [`DynamicsError::ForeignCheckpoint`] if the number of coordinates differs.
    pub fn set_state(&mut self, state: &IntegratorState) -> Result<(), DynamicsError> {
        state.check_size(self.force.len())?;
        self.state.copy_from(state);
        self.has_matrix = false;
        Ok(())
    }

    /// Sets one coordinate, for a prescribed motion that jumps.
    pub(super) fn displace(&mut self, coordinate: usize, position: f64, velocity: f64) {
        self.state.current.position[coordinate] = position;
        self.state.current.velocity[coordinate] = velocity;
    }

    /// Adds work (J) done at an instant, such as that of a prescribed motion that jumps.
    pub(super) fn book(&mut self, input: f64, load: f64) {
        let energy = &mut self.state.energy;
        energy.input += input;
        energy.load += load;
        energy.turnover += input.abs() + load.abs();
    }

    /// Recomputes balance, accelerations and energy at the current state, after a jump of force.
    ///
    /// # Errors
    /// [`DynamicsError::StepFailed`] for forces that are not finite.
    pub fn restart(&mut self) -> Result<(), DynamicsError> {
        let node = &mut self.state.current;
        node.balance =
            self.system.evaluate(node.time, &node.position, &node.velocity, &mut self.force, &mut self.lin);
        self.state.counts.evaluations += 1;
        for (a, (f, m)) in node.acceleration.iter_mut().zip(self.force.iter().zip(self.system.mass())) {
            *a = f / m;
        }
        if !node.acceleration.iter().all(|a| a.is_finite()) {
            let largest = self.force.iter().fold(0.0, |m: f64, f| if f.abs() <= m { m } else { f.abs() });
            return Err(self.failure(0.0, if largest.is_nan() { f64::INFINITY } else { largest }));
        }
        self.state.auxiliary.copy_from_slice(&self.state.current.acceleration);
        self.state.jerk.fill(0.0);
        self.state.matrix = None;
        self.state.last_step = 0.0;
        if self.control.fixed_step.is_none() {
            self.state.next_step = self.state.next_step.min(self.control.first_step);
        }
        self.state.energy.current = self.total_energy();
        Ok(())
    }

    /// Takes one accepted step that ends at `until` or before.
    ///
    /// # Errors
    /// [`DynamicsError::StepFailed`] with time, crank angle and residual; the state remains that of the last
    /// accepted step.
    pub fn advance(&mut self, until: f64) -> Result<(), DynamicsError> {
        let start = self.time();
        // Steps end just before a jump, so that the values before it are valid up to the end of the step.
        let breakpoint = self.system.next_breakpoint(start).filter(|t| *t <= until);
        let limit = breakpoint.map_or(until, f64::next_down);
        if let Some(jump) = breakpoint
            && start >= limit
        {
            self.state.current.time = jump;
            return self.restart();
        }
        let mut wish = self.state.next_step;
        let onset = self.state.current.balance.onset_rate;
        if self.control.fixed_step.is_none() {
            wish = wish.min(self.control.largest_step);
            if onset > 0.0 {
                wish = wish.min((1.0 / onset).max(self.control.first_step));
            }
        }
        loop {
            let remaining = limit - start;
            // The last steps before the limit are equal parts of the remainder.
            let step = if wish >= remaining {
                remaining
            } else if 2.0 * wish > remaining && self.control.fixed_step.is_none() {
                0.5 * remaining
            } else {
                wish
            };
            let end = if step == remaining { limit } else { start + step };
            let failed = match self.attempt(step, end) {
                Attempt::Converged(error) => {
                    if self.control.fixed_step.is_some() || error <= 1.0 {
                        self.accept(step, wish, error);
                        return Ok(());
                    }
                    // Third-order local error.
                    wish = step * (0.9 * error.powf(-1.0 / 3.0)).clamp(0.1, 0.8);
                    None
                }
                Attempt::Failed(residual) => {
                    wish = 0.25 * step;
                    Some(residual)
                }
            };
            self.state.counts.rejected += 1;
            let hopeless = self.control.fixed_step.is_some() && failed.is_some();
            if wish < self.control.smallest_step || hopeless {
                return Err(self.failure(step, failed.unwrap_or(0.0)));
            }
        }
    }

    fn failure(&self, step: f64, residual: f64) -> DynamicsError {
        let node = &self.state.current;
        DynamicsError::StepFailed {
            time: node.time,
            crank_angle_deg: self.system.crank_angle(&node.position) / crate::units::DEG,
            step,
            residual,
            steps: self.state.counts.accepted,
        }
    }

    /// Factorises the matrix described by the state, with these weights unless its own are close; after
    /// [`Integrator::resume`] and [`Integrator::set_state`] it is evaluated again. `false` if there is none to
    /// use.
    fn restore_matrix(&mut self, weights: Weights) -> bool {
        let Some(matrix) = &mut self.state.matrix else { return false };
        // Corrections converge with the relative difference of the weights of the mass.
        let is_close = (matrix.weights.mass / weights.mass - 1.0).abs() <= SLOW;
        if self.has_matrix && is_close {
            return true;
        }
        if !is_close {
            matrix.weights = weights;
        }
        if !self.has_matrix {
            let MatrixPlace { time, position, velocity, .. } = &*matrix;
            self.system.evaluate(*time, position, velocity, &mut self.force, &mut self.lin);
            self.has_matrix = true;
        }
        self.correction.fill(0.0);
        let is_regular = self.lin.solve(self.system.mass(), matrix.weights, &mut self.correction).is_ok();
        if !is_regular {
            self.state.matrix = None;
        }
        is_regular
    }

    /// Newton's method for the state at `end`; the result is in `trial`.
    fn attempt(&mut self, h: f64, end: f64) -> Attempt {
        let Coefficients { alpha_m, alpha_f, beta, gamma, .. } = self.coefficients;
        let n = self.force.len();
        let from_position = 1.0 / (beta * h * h);
        let weights = Weights {
            mass: (1.0 - alpha_m) / (1.0 - alpha_f) * from_position,
            damping: gamma / (beta * h),
            stiffness: 1.0,
        };
        let is_restored = self.restore_matrix(weights);
        let mut needs_tangent = !is_restored;
        let old = &self.state.current;
        let (mass, scale) = (self.system.mass(), self.system.scale());
        // a_n belongs to the step in which it was computed; a change of the step size moves the instant that it
        // approximates (Brüls & Arnold 2008).
        let stretch = if self.state.last_step > 0.0 { h / self.state.last_step } else { 1.0 };
        for i in 0..n {
            let (v, a, jerk) = (old.velocity[i], old.acceleration[i], self.state.jerk[i]);
            self.scaled_auxiliary[i] = a + stretch * (self.state.auxiliary[i] - a);
            self.trial.position[i] = old.position[i] + h * (v + h * (0.5 * a + h / 6.0 * jerk));
            self.predicted_velocity[i] = v + h * (a + 0.5 * h * jerk);
        }
        self.trial.time = end;
        let (mut last_length, mut has_own) = (None, false);
        self.secants.clear();
        for _ in 0..LARGEST_NEWTON_COUNT {
            for i in 0..n {
                let (v, a) = (old.velocity[i], self.scaled_auxiliary[i]);
                let auxiliary = (self.trial.position[i] - old.position[i] - h * v) * from_position
                    - (0.5 - beta) / beta * a;
                self.auxiliary[i] = auxiliary;
                self.trial.velocity[i] = v + h * ((1.0 - gamma) * a + gamma * auxiliary);
                self.trial.acceleration[i] = ((1.0 - alpha_m) * auxiliary + alpha_m * a
                    - alpha_f * old.acceleration[i])
                    / (1.0 - alpha_f);
            }
            let Node { position, velocity, .. } = &self.trial;
            self.trial.balance = if needs_tangent {
                self.system.evaluate(end, position, velocity, &mut self.force, &mut self.lin)
            } else {
                self.system.evaluate_forces(end, position, velocity, &mut self.force)
            };
            self.state.counts.evaluations += 1;
            for i in 0..n {
                self.correction[i] = self.force[i] - mass[i] * self.trial.acceleration[i];
            }
            let solved = if needs_tangent {
                self.state.counts.tangents += 1;
                if self.lin.is_large() {
                    let matrix = self.state.matrix.get_or_insert_default();
                    matrix.set(end, &self.trial.position, &self.trial.velocity, weights);
                    self.has_matrix = true;
                }
                self.lin.solve(mass, weights, &mut self.correction)
            } else {
                self.lin.solve_again(&mut self.correction)
            };
            if solved.is_err() {
                return self.retry_or_fail(is_restored && !has_own, h, end);
            }
            if needs_tangent {
                self.secants.clear();
            }
            if self.lin.is_large() {
                self.secants.improve(&mut self.correction, scale);
            }
            let mut length: f64 = 0.0;
            for i in 0..n {
                let x = self.correction[i];
                length = length.max(x.abs() / scale[i]);
                self.trial.position[i] += x;
                self.auxiliary[i] += from_position * x;
                self.trial.velocity[i] += weights.damping * x;
                self.trial.acceleration[i] += weights.mass * x;
            }
            let rate = last_length.map_or(1.0, |last: f64| length / last);
            // The remaining corrections, each θ times the one before, add up to θ/(1 − θ) of the last one.
            let is_near = self.lin.is_large() && rate < 0.5 && length <= LAST_SHARE * self.control.tolerance;
            let to_come = if is_near { rate / (1.0 - rate) } else { 1.0 };
            if to_come * length <= NEWTON_SHARE * self.control.tolerance {
                return Attempt::Converged(self.error(h));
            }
            if !(rate < 4.0) {
                return self.retry_or_fail(is_restored && !has_own, h, end);
            }
            needs_tangent = last_length.is_some() && rate > SLOW;
            has_own |= needs_tangent;
            last_length = Some(length);
        }
        self.retry_or_fail(false, h, end)
    }

    /// After corrections that did not converge: another attempt, if the matrix was that of an earlier step.
    fn retry_or_fail(&mut self, is_outdated: bool, h: f64, end: f64) -> Attempt {
        self.state.matrix = None;
        if is_outdated {
            return self.attempt(h, end);
        }
        let imbalances = self.force.iter().zip(self.system.mass()).zip(&self.trial.acceleration);
        let residual = imbalances
            .map(|((force, mass), acceleration)| (force - mass * acceleration).abs())
            .fold(0.0, |m: f64, x| if x <= m { m } else { x });
        Attempt::Failed(residual)
    }

    /// Ratio of the local error of the trial step to the tolerance.
    fn error(&self, h: f64) -> f64 {
        let scale = self.system.scale();
        let old = &self.state.current;
        let Coefficients { position_error, velocity_error, .. } = self.coefficients;
        // Error constant of the extrapolated velocity; without a history (first step) that of Euler's method,
        // which is larger.
        let extrapolation =
            if self.state.last_step > 0.0 { 1.0 / 6.0 + 0.25 * self.state.last_step / h } else { 0.0 };
        let milne = velocity_error / (extrapolation + velocity_error);
        let mut worst: f64 = 0.0;
        for i in 0..scale.len() {
            let velocity = milne
                * (self.trial.velocity[i] - self.predicted_velocity[i]).abs()
                * h.max(self.control.velocity_time);
            let position = position_error * (self.trial.acceleration[i] - old.acceleration[i]).abs() * h * h;
            let error = velocity.max(position) / scale[i];
            // NaN counts as failure.
            worst = if error <= worst { worst } else { error };
        }
        worst / self.control.tolerance
    }

    fn accept(&mut self, h: f64, wish: f64, error: f64) {
        let state = &mut self.state;
        std::mem::swap(&mut state.previous, &mut state.current);
        std::mem::swap(&mut state.current, &mut self.trial);
        std::mem::swap(&mut state.auxiliary, &mut self.auxiliary);
        let (old, new) = (&state.previous, &state.current);
        for i in 0..state.jerk.len() {
            state.jerk[i] = (new.acceleration[i] - old.acceleration[i]) / h;
        }
        // Trapezoidal rule: at the kinks of contacts a parabola through three points is not more accurate.
        let integral = |f: fn(&Balance) -> f64| 0.5 * h * (f(&old.balance) + f(&new.balance));
        let energy = &mut state.energy;
        energy.input += integral(|balance| balance.input_power);
        energy.load += integral(|balance| balance.load_power);
        energy.dissipated += integral(|balance| balance.dissipation);
        energy.turnover +=
            integral(|balance| balance.input_power.abs() + balance.load_power.abs() + balance.dissipation);
        state.last_step = h;
        state.counts.accepted += 1;
        if self.control.fixed_step.is_none() {
            let factor = (0.9 * error.max(1e-6).powf(-1.0 / 3.0)).clamp(0.3, 2.0);
            // A step shortened by a limit does not limit the next one.
            let keeps_matrix = state.matrix.is_some() && (1.0..WORTHWHILE).contains(&factor);
            let next = if keeps_matrix { h } else { h * factor };
            state.next_step =
                if h < wish { next.max(wish.min(h * 8.0)) } else { next }.min(self.control.largest_step);
        }
        let energy = self.total_energy();
        self.state.energy.current = energy;
    }

    fn total_energy(&self) -> f64 {
        let node = &self.state.current;
        let kinetic: f64 = node.velocity.iter().zip(self.system.mass()).map(|(v, m)| 0.5 * m * v * v).sum();
        kinetic + node.balance.stored
    }

    /// Position and velocity of one coordinate within the last step, by Hermite's cubic.
    pub fn interpolate(&self, index: usize, time: f64) -> (f64, f64) {
        let (old, new) = (&self.state.previous, &self.state.current);
        let h = new.time - old.time;
        if h <= 0.0 {
            return (new.position[index], new.velocity[index]);
        }
        hermite(
            h,
            (time - old.time) / h,
            old.position[index],
            new.position[index],
            old.velocity[index],
            new.velocity[index],
        )
    }
}

#[cfg(test)]
mod tests;
