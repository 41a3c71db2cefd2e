//! Static equilibria of the whole machine, and the starts of their searches.

use std::collections::HashMap;

use super::BearingMeshing;
use crate::dynamics::mechanism::{Motion, QuasiStatic};
use crate::dynamics::statics::continue_from_larger_loads;
use crate::dynamics::{EquilibriumControl, solve_equilibrium};
use crate::load::LoadError;
use crate::machine::CrankAngle;

/// Largest number of stored equilibria.
const MOST_KNOWN: usize = 32_768;
/// As on the test bench: 1e-7 of an arcmin at the output, and the rounding of positions times the stiffness of
/// all contacts.
pub(super) const TOLERANCE: f64 = 1e-7;
const FORCE_TOLERANCE: f64 = 1e-6;

/// Coordinates of an equilibrium, and its largest residual.
type Balance = (Vec<f64>, f64);

/// Equilibria found before, by crank angle and torque: starts for a machine that has worn slightly since.
#[derive(Debug, Clone)]
pub(in super::super) struct KnownPositions<T>(HashMap<[u64; 2], T>);

/// Deviations of the equilibria at one position under one torque, with the surfaces of two successive states of
/// wear.
#[derive(Debug, Clone)]
pub(in super::super) struct Deviations {
    state: usize,
    now: Vec<f64>,
    before: Option<Vec<f64>>,
}

impl Deviations {
    /// Prediction for a state by linear extrapolation from the last two. Without load there may be several
    /// equilibria, so that the search starts at the known one.
    fn ahead(&self, state: usize, torque: f64) -> Vec<f64> {
        match &self.before {
            Some(before) if state != self.state && torque != 0.0 => {
                self.now.iter().zip(before).map(|(now, before)| 2.0 * now - before).collect()
            }
            _ => self.now.clone(),
        }
    }

    /// With the equilibrium found in a state.
    fn followed_by(known: Option<Deviations>, state: usize, now: Vec<f64>) -> Deviations {
        let before =
            known.and_then(|known| if known.state == state { known.before } else { Some(known.now) });
        Deviations { state, now, before }
    }
}

/// Error of the last prediction, in one state of wear under one torque. Wear displaces the machine similarly at
/// other positions, so that this error corrects their predictions.
#[derive(Debug, Clone)]
pub(in super::super) struct PredictionError {
    state: usize,
    torque: f64,
    by: Vec<f64>,
}

impl PredictionError {
    fn is_of(&self, state: usize, torque: f64) -> bool {
        self.state == state && self.torque == torque
    }
}

/// Crank angle and torque to the last bit, to recognise a repeated position.
fn key(crank: CrankAngle, torque: f64) -> [u64; 2] {
    [crank.radians().to_bits(), torque.to_bits()]
}

impl<T> KnownPositions<T> {
    pub(in super::super) fn new() -> KnownPositions<T> {
        KnownPositions(HashMap::new())
    }

    pub(in super::super) fn take(&mut self, crank: CrankAngle, torque: f64) -> Option<T> {
        self.0.remove(&key(crank, torque))
    }

    pub(in super::super) fn keep(&mut self, crank: CrankAngle, torque: f64, found: T) {
        if self.0.len() < MOST_KNOWN {
            self.0.insert(key(crank, torque), found);
        }
    }

    fn has(&self, crank: CrankAngle, torque: f64) -> bool {
        self.0.contains_key(&key(crank, torque))
    }
}

impl BearingMeshing {
    /// Equilibrium under an output torque (N·m, positive against positive motion): all coordinates, and the
    /// largest residual. `start` is the deviation of an earlier one from the nominal machine, in the frame of
    /// its carrier.
    ///
    /// # Errors
    /// [`LoadError`] if no equilibrium is found.
    pub fn balance(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&[f64]>,
    ) -> Result<Balance, LoadError> {
        if !torque.is_finite() {
            return Err(LoadError::BadTorque(torque));
        }
        let sun = self.sun(crank);
        self.model.hold_sun(sun, 0.0);
        self.model.set_load(torque);
        let place = match start {
            Some(start) => self.place(crank, start),
            None => self.model.nominal_position_at(sun),
        };
        let control = EquilibriumControl {
            tolerance: self.tolerance,
            force_tolerance: FORCE_TOLERANCE,
            ..EquilibriumControl::default()
        };
        let found = match self.running {
            None => solve_equilibrium(&*self.model, 0.0, &place, control),
            Some(speed) => {
                self.model.hold_sun(sun, speed);
                let motion = Motion::Running(self.model.nominal_velocity_at(sun, speed));
                let running = QuasiStatic { mechanism: &self.model, motion };
                solve_equilibrium(&running, 0.0, &place, control)
            }
        };
        let found = found.map_err(|error| error.of_load_sharing(crank, torque))?;
        Ok((found.position, found.residual))
    }

    /// [`BearingMeshing::balance`], with a continuation from larger torques if the search from the start fails.
    pub(in super::super) fn balance_from_afar(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&[f64]>,
    ) -> Result<Balance, LoadError> {
        if let Ok(found) = self.balance(crank, torque, start) {
            return Ok(found);
        }
        let mut residual = 0.0;
        let position = continue_from_larger_loads(torque, self.model.rated, |torque, place| {
            let start = place.map(|place| self.deviation(crank, place));
            let found = self.balance(crank, torque, start.as_deref())?;
            residual = found.1;
            Ok(found.0)
        })?;
        Ok((position, residual))
    }

    /// [`BearingMeshing::balance_from_afar`] from the last equilibrium at the same position under the same
    /// torque, or from `start` if there is none. The error of a prediction corrects the next one.
    pub(in super::super) fn balance_from_last(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&[f64]>,
    ) -> Result<Balance, LoadError> {
        let known = self.known.take(crank, torque);
        let predicted = known.as_ref().map(|known| known.ahead(self.state, torque));
        let is_worn_since = known.as_ref().is_some_and(|known| known.state != self.state) && torque != 0.0;
        let last_error = self
            .prediction_error
            .take()
            .filter(|last_error| is_worn_since && last_error.is_of(self.state, torque));
        let corrected = predicted.as_ref().zip(last_error.as_ref()).map(|(predicted, last_error)| {
            predicted.iter().zip(&last_error.by).map(|(place, by)| place + by).collect::<Vec<f64>>()
        });
        let start = corrected.as_deref().or(predicted.as_deref()).or(start);
        let found = self.balance_from_afar(crank, torque, start)?;
        let now = self.deviation(crank, &found.0);
        self.prediction_error = predicted.filter(|_| is_worn_since).map(|predicted| PredictionError {
            state: self.state,
            torque,
            by: now.iter().zip(&predicted).map(|(now, predicted)| now - predicted).collect(),
        });
        self.known.keep(crank, torque, Deviations::followed_by(known, self.state, now));
        Ok(found)
    }

    /// Whether an equilibrium was found at this position under this torque before.
    pub(in super::super) fn has_equilibrium(&self, crank: CrankAngle, torque: f64) -> bool {
        self.known.has(crank, torque)
    }
}
