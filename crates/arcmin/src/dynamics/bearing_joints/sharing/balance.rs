//! Balances of the whole machine: which starts are tried, by Newton's method and by descent in energy.

use std::collections::HashMap;

use super::{BearingMeshing, ZERO_SHARE};
use crate::dynamics::bearing_joints::JUMP;
use crate::dynamics::bearing_joints::running::Running;
use crate::dynamics::{DynamicsError, EquilibriumControl, solve_equilibrium};
use crate::load::LoadError;
use crate::machine::CrankAngle;
use crate::units::ARCMIN;

/// Balances kept.
const MOST_KNOWN: usize = 32_768;
/// As on the test bench: 1e-7 of an arcmin at the output, and the rounding of places times the stiffness of
/// all contacts.
pub(super) const TOLERANCE: f64 = 1e-7;
/// Of the balances that surfaces wear under: a hundredth of this moves the hours of drawn machines by 1e-5 of them at most.
pub(super) const WEAR_TOLERANCE: f64 = 1e-3;
const FORCE_TOLERANCE: f64 = 1e-6;
/// Share of the load that a jump may leave unbalanced besides [`JUMP`].
const JUMP_OF_LOAD: f64 = 1e-2;
/// The same at no load in a machine that errors have made so tight that its pins jump from flank to flank
/// under some 100 N.
const TIGHT_JUMP: f64 = 2e-3;

/// Coordinates of a balance and the largest force left.
type Balance = (Vec<f64>, f64);

/// What was found before, by crank angle and torque: where the search of a machine that has worn a little since
/// starts.
#[derive(Debug, Clone)]
pub(in super::super) struct Known<T>(HashMap<[u64; 2], T>);

/// Deviations of the balances at one place under one torque: with the surfaces of a state of wear, and with those of
/// the state before it.
#[derive(Debug, Clone)]
pub(in super::super) struct Deviations {
    state: usize,
    now: Vec<f64>,
    before: Option<Vec<f64>>,
}

impl Deviations {
    /// Where the balance may be in a state: as far on from the last one as that from the one before. Without load
    /// there may be several balances, and the search stays with the one it knows.
    fn ahead(&self, state: usize, torque: f64) -> Vec<f64> {
        match &self.before {
            Some(before) if state != self.state && torque != 0.0 => {
                self.now.iter().zip(before).map(|(now, before)| 2.0 * now - before).collect()
            }
            _ => self.now.clone(),
        }
    }

    /// With the balance found in a state.
    fn followed_by(known: Option<Deviations>, state: usize, now: Vec<f64>) -> Deviations {
        let before =
            known.and_then(|known| if known.state == state { known.before } else { Some(known.now) });
        Deviations { state, now, before }
    }
}

/// Crank angle and torque to the last bit: the same place asked for again.
fn key(crank: CrankAngle, torque: f64) -> [u64; 2] {
    [crank.radians().to_bits(), torque.to_bits()]
}

impl<T> Known<T> {
    pub(in super::super) fn nothing() -> Known<T> {
        Known(HashMap::new())
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
    /// Balance under an output torque (N·m, positive against positive motion): all coordinates, and the
    /// largest force left. `start` is the deviation of an earlier one from the nominal machine, seen from its
    /// carrier.
    ///
    /// # Errors
    /// [`LoadError`] where no balance is found.
    pub fn balance(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&[f64]>,
    ) -> Result<(Vec<f64>, f64), LoadError> {
        self.balance_within(self.usual_jump(), true, crank, torque, start)
    }

    /// Contact forces of a machine without errors do not jump, but for flanks worn so deep that a pin has several
    /// closest points.
    fn usual_jump(&self) -> f64 {
        if self.has_errors { JUMP } else { 0.0 }
    }

    /// `jump` is the share of the rated torque that a jump of the contact forces may leave; `descent` as in
    /// [`EquilibriumControl`].
    fn balance_within(
        &mut self,
        jump: f64,
        descent: bool,
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
            jump_tolerance: if jump > 0.0 {
                (JUMP_OF_LOAD * torque.abs() + jump * self.model.rated) * ARCMIN
            } else {
                0.0
            },
            // At the ends of the travel the start, from before the last wear, touches nothing on the worn side, and
            // the short way gives up after all its steps: the careful one begins at once.
            haste: torque == 0.0 || torque.abs() > 2.0 * ZERO_SHARE * self.model.rated,
            descent,
            ..EquilibriumControl::default()
        };
        let found = match self.running {
            None => solve_equilibrium(&self.model, 0.0, &place, control),
            Some(speed) => {
                self.model.hold_sun(sun, speed);
                solve_equilibrium(&Running::new(&self.model, sun, speed), 0.0, &place, control)
            }
        };
        match found {
            Ok(found) => Ok((found.position, found.residual)),
            Err(DynamicsError::NoEquilibrium { residual, iterations, .. }) => Err(LoadError::NotConverged {
                crank_angle_deg: crank.degrees(),
                torque,
                residual,
                iterations,
            }),
            // The static solver has no other way to fail.
            Err(_) => Err(LoadError::NotConverged {
                crank_angle_deg: crank.degrees(),
                torque,
                residual: f64::NAN,
                iterations: 0,
            }),
        }
    }

    /// [`BearingMeshing::balance_nearby`], and where it finds nothing, by descent in energy.
    pub(in super::super) fn balance_from_afar(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&[f64]>,
    ) -> Result<Balance, LoadError> {
        self.balance_nearby(crank, torque, start)
            .or_else(|on_the_way| self.balance_by_descent(crank, torque, start, on_the_way.as_deref()))
    }

    /// [`BearingMeshing::balance`] by Newton's method alone; where it does not find it from a place that was
    /// right for other pins, again from the nominal place, and then by way of larger torques, under which more
    /// contacts hold the bodies. Else the deviation reached on that way.
    fn balance_nearby(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&[f64]>,
    ) -> Result<Balance, Option<Vec<f64>>> {
        if let Ok(found) = self.balance_by_newton(crank, torque, start) {
            return Ok(found);
        }
        if start.is_some()
            && let Ok(found) = self.balance_by_newton(crank, torque, None)
        {
            return Ok(found);
        }
        let least = torque.abs().max(ZERO_SHARE * self.model.rated);
        let mut step = self.model.rated.max(3.0 * torque.abs()).copysign(torque);
        let mut place: Option<Vec<f64>> = None;
        while step.abs() > least {
            let Ok((position, _)) = self.balance_by_newton(crank, step, place.as_deref()) else {
                return Err(place);
            };
            place = Some(self.deviation(crank, &position));
            step /= 3.0;
        }
        self.balance_by_newton(crank, torque, place.as_deref()).map_err(|_| place)
    }

    fn balance_by_newton(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&[f64]>,
    ) -> Result<Balance, LoadError> {
        self.balance_within(self.usual_jump(), false, crank, torque, start)
    }

    /// Newton's method with something left to a jump, and with descent in energy where it fails: from `start`, from
    /// the nominal place, and from the place reached by way of larger torques. The error is that of the first.
    fn balance_by_descent(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&[f64]>,
        on_the_way: Option<&[f64]>,
    ) -> Result<Balance, LoadError> {
        // What is left may be a jump that nobody expects without errors.
        let more = if self.has_errors { TIGHT_JUMP } else { JUMP };
        if !self.has_errors
            && let Ok(found) = self.balance_within(more, false, crank, torque, start)
        {
            return Ok(found);
        }
        let failure = match self.balance(crank, torque, start) {
            Ok(found) => return Ok(found),
            Err(failure) => failure,
        };
        if start.is_some()
            && let Ok(found) = self.balance(crank, torque, None)
        {
            return Ok(found);
        }
        if let Ok(found) = self.balance(crank, torque, on_the_way) {
            return Ok(found);
        }
        self.balance_within(more, true, crank, torque, start).map_err(|_| failure)
    }

    /// What is known of the balances at a place under a torque, and where the next may be.
    fn foretell(&mut self, crank: CrankAngle, torque: f64) -> (Option<Deviations>, Option<Vec<f64>>) {
        let known = self.known.take(crank, torque);
        let foretold = known.as_ref().map(|known| known.ahead(self.state, torque));
        (known, foretold)
    }

    /// Keeps the balance found beside what was known before it.
    fn keep_found(&mut self, crank: CrankAngle, torque: f64, known: Option<Deviations>, position: &[f64]) {
        let now = self.deviation(crank, position);
        self.known.keep(crank, torque, Deviations::followed_by(known, self.state, now));
    }

    /// [`BearingMeshing::balance_from_afar`] from the balance that was found last at the same place under the
    /// same torque, or from `start` where there is none.
    pub(in super::super) fn balance_again(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&[f64]>,
    ) -> Result<Balance, LoadError> {
        let (known, foretold) = self.foretell(crank, torque);
        let found = self.balance_from_afar(crank, torque, foretold.as_deref().or(start))?;
        self.keep_found(crank, torque, known, &found.0);
        Ok(found)
    }

    /// Whether a balance was found at this place under this torque before.
    pub(in super::super) fn knows(&self, crank: CrankAngle, torque: f64) -> bool {
        self.known.has(crank, torque)
    }

    /// Balance under the small torque at which play is read, from the last one at this place or from `start`.
    /// Pins that press without load may jump under it: then the balance under ten times as much, and with what
    /// the jump leaves, if need be.
    pub(super) fn end_of_travel(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&[f64]>,
    ) -> Result<Balance, LoadError> {
        if !self.has_errors {
            return self.balance_again(crank, torque, start);
        }
        let (known, foretold) = self.foretell(crank, torque);
        let start = foretold.as_deref().or(start);
        let found = match self.balance_nearby(crank, torque, start) {
            Ok(found) => found,
            Err(on_the_way) => self
                .balance_nearby(crank, 10.0 * torque, start)
                .or_else(|_| self.balance_within(TIGHT_JUMP, true, crank, 10.0 * torque, None))
                .or_else(|_| self.balance_by_descent(crank, torque, start, on_the_way.as_deref()))?,
        };
        self.keep_found(crank, torque, known, &found.0);
        Ok(found)
    }
}
