//! Pressures of a proposal with elastic discs.

use super::{Check, Demand, Fitted, POSITIONS, Proposal, fit, widened};
use crate::analyses::stage::contact;
use crate::analyses::{AnalysisError, Host, Outcome};
use crate::design::StageDesign;
use crate::fidelity::DiscBodies;
use crate::units::MPA;

/// Largest pressures in Pa and forces in N over a turn of the input, at rated torque.
pub(super) struct Loads {
    /// Pressure of ring pins on flanks.
    pub flank: f64,
    /// Pressure of output pins in their holes.
    pub hole: f64,
    /// Largest force of an output pin.
    pub output_pin_force: f64,
}

impl Loads {
    /// # Errors
    /// [`AnalysisError`] where a static equilibrium is not found, or the discs have no elastic model.
    pub fn of(design: &StageDesign, discs: DiscBodies, host: &dyn Host) -> Result<Loads, AnalysisError> {
        let plain = contact::Options::of_positions(POSITIONS);
        let options = contact::Options { made: plain.made.with_discs(discs), ..plain };
        let summary = contact::run(design, &options, host)?.summary();
        let number = |key: &str| summary.number(key).unwrap_or(f64::NAN);
        Ok(Loads {
            flank: number("max_pressure_mpa") * MPA,
            hole: number("max_output_pin_pressure_mpa") * MPA,
            output_pin_force: number("max_output_pin_force_n"),
        })
    }

    pub fn pressure(&self) -> f64 {
        self.flank.max(self.hole)
    }
}

/// Number of times that other sizes are selected.
const ROUNDS: usize = 3;

/// Widens the discs of a proposal until the pressures with elastic discs are permitted too, and describes these pressures. If
/// the widest discs do not suffice, sizes are those for a larger torque. If these do not suffice either, the last proposal that
/// keeps all other checks remains and the sentence says so.
///
/// # Errors
/// [`AnalysisError`] as of [`widened`].
pub(super) fn judged(mut fitted: Fitted, host: &dyn Host) -> Result<(Fitted, String), AnalysisError> {
    let (demand, limit) = (fitted.proposal.demand, fitted.proposal.pressure());
    let (mut torque, mut rounds) = (demand.torque, 0);
    loop {
        let text = fitted.proposal.text(fitted.width_mm, &[]);
        let design = StageDesign::parse(&text, "the proposed design")?;
        let loads = match Loads::of(&design, DiscBodies::Elastic, host) {
            Ok(loads) => loads,
            Err(AnalysisError::Stopped) => return Err(AnalysisError::Stopped),
            Err(error) => return Ok((fitted, format!("Not judged with elastic discs: {error}."))),
        };
        let share = loads.pressure() / limit;
        let words = format!(
            "ring pins press with {:.0} MPa and output pins with {:.0} MPa of {:.0} MPa",
            loads.flank / MPA,
            loads.hole / MPA,
            limit / MPA
        );
        if share <= 1.0 {
            let nearest = format!(
                "pressure with elastic discs of {} mm, {:.0} MPa of {:.0} MPa",
                fitted.width_mm,
                loads.pressure() / MPA,
                limit / MPA
            );
            fitted.checks.push(Check { share, words: nearest });
            return Ok((fitted, format!("With elastic discs, {words}.")));
        }
        // p² is proportional to F/B if the load sharing does not change.
        let excess = share * share;
        let width_mm = (fitted.width_mm * excess).max(fitted.width_mm + 0.5);
        let wider = Proposal { width_mm, ..fitted.proposal.clone() };
        let shortfall = match widened(wider, host)? {
            Ok(next) => {
                fitted = Fitted { jam_rate: fitted.jam_rate, ..next };
                continue;
            }
            Err(shortfall) => shortfall,
        };
        rounds += 1;
        torque *= excess;
        let other = if rounds <= ROUNDS { fit(&Demand { torque, ..demand }, host)?.ok() } else { None };
        let other = match other {
            Some(Fitted { proposal, width_mm, jam_rate, .. }) => {
                let fitted = widened(Proposal { width_mm, demand, ..proposal }, host)?.ok();
                fitted.map(|fitted| Fitted { jam_rate, ..fitted })
            }
            None => None,
        };
        match other {
            Some(other) => fitted = other,
            None => {
                let message = shortfall.message;
                return Ok((fitted, format!("Over its limit with elastic discs: {words}; {message}.")));
            }
        }
    }
}
