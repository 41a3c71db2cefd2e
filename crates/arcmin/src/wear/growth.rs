//! What a machine loses with its wear, followed once; every coefficient reads from it.

use super::WearError;
use super::calibrate::LOST_MOTION_POSITIONS;
use super::coupled::{CoupledOptions, CoupledWear};
use super::{Exposure, Reading};
use crate::load::{ShareLoad, lost_motion};
use crate::machine::Machine;
use crate::progress::Progress;
use crate::units::UM;
use crate::wear::readings::Measured;

/// Depth and increase of the lost motion against exposure.
#[derive(Debug, Clone)]
pub struct Growth {
    exposures: Vec<f64>,
    depths: Vec<f64>,
    increases: Vec<f64>,
    /// Exposure at which each reading alone is met, in the order of the readings.
    alone: Vec<f64>,
}

/// How much further than the readings the growth is followed: room for the upper end of a band.
const ROOM: f64 = 1.6;
/// Updates after which a reading counts as out of reach.
const UPDATES: usize = 100_000;

/// How far a growth is to be followed beyond its readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beyond {
    /// Increase of the lost motion in rad that ends the life.
    pub increase: f64,
    /// But no further than this time in s at the highest coefficient that any reading alone asks for.
    pub time: f64,
}

impl Growth {
    /// Follows the coupled prediction until every reading alone is met, with room for a band, and then on to
    /// what lies [`Beyond`] them; a state out of reach there ends it without an error.
    ///
    /// # Errors
    /// [`WearError`]; `TargetNotReached` where a reading asks for more wear than there ever is, `Stopped` when
    /// `progress` was cancelled.
    pub fn follow<S: ShareLoad>(
        machine: &Machine,
        meshing: S,
        clock: &Exposure,
        readings: &[Reading],
        beyond: Beyond,
        progress: &dyn Progress,
    ) -> Result<Growth, WearError> {
        let mut wear =
            CoupledWear::with(machine, meshing, CoupledOptions::default().for_curves()).on_clock(clock);
        let torque = machine.rated.torque;
        let lost = |wear: &mut CoupledWear<'_, S>| -> Result<f64, WearError> {
            Ok(lost_motion(wear.meshing_mut(), torque, LOST_MOTION_POSITIONS)?.radians())
        };
        let new = lost(&mut wear)?;
        let mut growth =
            Growth { exposures: vec![0.0], depths: vec![0.0], increases: vec![0.0], alone: Vec::new() };
        let mut met: Vec<Option<f64>> = vec![None; readings.len()];
        let latest = readings.iter().map(|reading| reading.time).fold(0.0, f64::max);
        loop {
            if progress.is_cancelled() {
                return Err(WearError::Stopped);
            }
            let needed = growth.needed(&met, readings, latest);
            let increase = wear.advance_until(f64::MAX, |_| true).and_then(|()| {
                if wear.state().exposure == f64::MAX { Ok(None) } else { lost(&mut wear).map(Some) }
            });
            let covered = needed.is_some_and(|(exposure, _)| growth.last() >= exposure);
            let increase = match increase {
                Ok(Some(increase)) => increase - new,
                // Beyond the readings nothing has to be there.
                Ok(None) | Err(WearError::Load(_)) if covered => break,
                // A law with a threshold has come to rest before.
                Ok(None) => return Err(growth.out_of_reach()),
                Err(error) => return Err(error),
            };
            growth.exposures.push(wear.state().exposure);
            growth.depths.push(wear.state().flank().deepest().0);
            growth.increases.push(increase);
            let mut share = 1.0_f64;
            for (met, reading) in met.iter_mut().zip(readings) {
                let value = growth.alone_value(reading);
                if met.is_none() && value >= reading.value {
                    *met = Some(growth.last());
                }
                share = share.min(if met.is_some() { 1.0 } else { value / reading.value });
            }
            progress.report("calibration", 0.9 * share.max(0.0));
            if let Some((exposure, per_time)) = growth.needed(&met, readings, latest)
                && growth.last() >= exposure
                && (increase >= beyond.increase || growth.last() >= per_time * beyond.time)
            {
                break;
            }
            if wear.updates() > UPDATES {
                return Err(growth.out_of_reach());
            }
        }
        growth.alone = met.into_iter().flatten().collect();
        Ok(growth)
    }

    /// Exposure up to which the readings need the growth, and the highest exposure per time that one alone asks
    /// for; `None` while there are some that are not met.
    fn needed(&self, met: &[Option<f64>], readings: &[Reading], latest: f64) -> Option<(f64, f64)> {
        let mut per_time = 0.0_f64;
        for (met, reading) in met.iter().zip(readings) {
            per_time = per_time.max((*met)? / reading.time);
        }
        Some((ROOM * per_time * latest, per_time))
    }

    /// What a reading would be if its own time had brought the present exposure.
    fn alone_value(&self, reading: &Reading) -> f64 {
        let here = self.last();
        match reading.measured {
            Measured::Depth => self.depth(here),
            Measured::Increase => self.increase(here),
            Measured::Since(first) => self.increase(here) - self.increase(here * first / reading.time),
        }
    }

    fn out_of_reach(&self) -> WearError {
        let reached_um = self.depths[self.depths.len() - 1] / UM;
        WearError::TargetNotReached { reached_um, exposure: self.last() }
    }

    /// Furthest exposure in s/Pa.
    pub fn last(&self) -> f64 {
        self.exposures[self.exposures.len() - 1]
    }

    /// Exposures at which the readings alone are met.
    pub(super) fn alone(&self) -> &[f64] {
        &self.alone
    }

    fn read(&self, values: &[f64], exposure: f64) -> f64 {
        let right = self.exposures.partition_point(|x| *x < exposure).clamp(1, self.exposures.len() - 1);
        let (a, b) = (self.exposures[right - 1], self.exposures[right]);
        let t = ((exposure - a) / (b - a)).min(1.0);
        values[right - 1] + t * (values[right] - values[right - 1])
    }

    /// Largest depth of a flank in m; beyond the end that of the end.
    pub fn depth(&self, exposure: f64) -> f64 {
        self.read(&self.depths, exposure)
    }

    /// Increase of the lost motion since new in rad; beyond the end that of the end.
    pub fn increase(&self, exposure: f64) -> f64 {
        self.read(&self.increases, exposure)
    }

    /// What a reading would be by a coefficient over time.
    pub fn value(&self, reading: &Reading, law: &Exposure) -> f64 {
        let here = law.at(reading.time);
        match reading.measured {
            Measured::Depth => self.depth(here),
            Measured::Increase => self.increase(here),
            Measured::Since(first) => self.increase(here) - self.increase(law.at(first)),
        }
    }

    /// Exposure at which the lost motion has grown so far (rad); `None` where that is never, or beyond what was
    /// followed.
    pub fn exposure_at(&self, increase: f64) -> Option<f64> {
        if increase <= 0.0 {
            return Some(0.0);
        }
        let right = self.increases.iter().position(|value| *value >= increase)?;
        let (a, b) = (self.increases[right - 1], self.increases[right]);
        let t = (increase - a) / (b - a);
        Some(self.exposures[right - 1] + t * (self.exposures[right] - self.exposures[right - 1]))
    }

    /// A growth given by points (exposure, depth, increase): how tests know the answer.
    #[cfg(test)]
    pub(super) fn of(points: &[(f64, f64, f64)], readings: &[Reading]) -> Growth {
        let column = |of: fn(&(f64, f64, f64)) -> f64| points.iter().map(of).collect::<Vec<f64>>();
        let mut growth = Growth {
            exposures: column(|p| p.0),
            depths: column(|p| p.1),
            increases: column(|p| p.2),
            alone: Vec::new(),
        };
        growth.alone = readings
            .iter()
            .map(|reading| {
                let met = |x: &&f64| {
                    let law = Exposure { coefficient: **x / reading.time, running_in: None };
                    growth.value(reading, &law) >= reading.value
                };
                *growth.exposures.iter().find(met).unwrap_or(&growth.last())
            })
            .collect();
        growth
    }
}
