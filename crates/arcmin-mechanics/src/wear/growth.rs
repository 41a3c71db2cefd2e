//! Growth of a machine's wear depth and lost motion, computed once for all coefficients.

use super::calibrate::LOST_MOTION_POSITIONS;
use super::coupled::{CoupledOptions, CoupledWear};
use super::{Exposure, WearCase, WearError};
use crate::load::{ShareLoad, lost_motion};
use crate::progress::Progress;
use crate::units::{ARCMIN, UM};

/// A drive whose wear is integrated in steps of exposure.
pub trait GrowingDrive {
    /// Advances by one update of the flank.
    ///
    /// # Errors
    /// [`WearError`].
    fn step(&mut self) -> Result<(), WearError>;

    /// Exposure reached in s/Pa; `f64::MAX` if the wear of a law with a threshold has ended before.
    fn exposure(&self) -> f64;

    /// Largest wear depth (m) of the flank that is measured.
    fn depth(&self) -> f64;

    /// Present lost motion (rad) of the drive.
    ///
    /// # Errors
    /// [`WearError::Load`] if the equilibrium is not found.
    fn lost_motion(&mut self) -> Result<f64, WearError>;

    /// Updates of the flank so far.
    fn updates(&self) -> usize;

    /// Words for the ring whose wear has run away, if the drive has several.
    fn ran_away(&self) -> String {
        String::new()
    }
}

/// A drive with one ring in which only flanks and ring pins wear.
pub struct GrowingRing<S: ShareLoad>(CoupledWear<S>);

impl<S: ShareLoad> GrowingRing<S> {
    /// The new drive, with a clock if the law depends on time.
    pub fn new(case: impl Into<WearCase>, meshing: S, clock: &Exposure) -> GrowingRing<S> {
        let options = CoupledOptions::default().for_curves();
        GrowingRing(CoupledWear::with(case, meshing, options).on_clock(clock))
    }
}

impl<S: ShareLoad> GrowingDrive for GrowingRing<S> {
    fn step(&mut self) -> Result<(), WearError> {
        self.0.advance_until(f64::MAX, |_| true)
    }

    fn exposure(&self) -> f64 {
        self.0.state().exposure
    }

    fn depth(&self) -> f64 {
        self.0.state().flank().deepest().0
    }

    fn lost_motion(&mut self) -> Result<f64, WearError> {
        let torque = self.0.case().rated_torque;
        Ok(lost_motion(self.0.meshing_mut(), torque, LOST_MOTION_POSITIONS)?.radians())
    }

    fn updates(&self) -> usize {
        self.0.updates()
    }
}

/// Depth and increase of the lost motion against exposure.
#[derive(Debug, Clone)]
pub struct Growth {
    exposures: Vec<f64>,
    depths: Vec<f64>,
    increases: Vec<f64>,
    /// Exposure at which each target alone is reached, in the order of the targets.
    alone: Vec<f64>,
}

/// Quantities that grow with wear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grown {
    /// Largest wear depth of the flank.
    Depth,
    /// Lost motion.
    LostMotion,
}

/// Growth of a quantity between two times (s), in m or rad, as given by one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Quantity that has grown: depth (m) or lost motion (rad).
    pub grown: Grown,
    /// Beginning of the growth, s of running time.
    pub since: f64,
    /// Its end, s of running time.
    pub time: f64,
    /// Growth between the two, m or rad.
    pub value: f64,
}

/// Ratio of the computed growth to that of the last reading, as a margin for the upper end of a band.
const ROOM: f64 = 2.0;
/// Number of updates after which a target counts as not reachable.
const UPDATES: usize = 100_000;

/// Range of the growth beyond its targets.
#[derive(Debug, Clone, PartialEq)]
pub struct Beyond {
    /// Time in s of the last reading, including those that are not used in the fit.
    pub latest: f64,
    /// Times in s with the further growth of the lost motion allowed from there on (rad): the ends of lives.
    pub ends: Vec<(f64, f64)>,
    /// For these ends the growth is computed up to this time in s at the largest coefficient that any single
    /// target requires.
    pub time: f64,
}

impl Growth {
    /// Integrates the coupled prediction until every target alone is reached, with a margin for a band, and
    /// then on to the points [`Beyond`] them; if these cannot be reached, the growth ends without an error.
    ///
    /// # Errors
    /// [`WearError`]; `TargetNotReached` where a target exceeds all wear that can occur, `ReadingsBeyond` where it exceeds
    /// what the model covers, `Stopped` when `progress` was cancelled.
    pub fn follow(
        drive: &mut impl GrowingDrive,
        targets: &[Target],
        beyond: &Beyond,
        progress: &dyn Progress,
    ) -> Result<Growth, WearError> {
        let new = drive.lost_motion()?;
        let mut growth =
            Growth { exposures: vec![0.0], depths: vec![0.0], increases: vec![0.0], alone: Vec::new() };
        let mut met: Vec<Option<f64>> = vec![None; targets.len()];
        loop {
            if progress.is_cancelled() {
                return Err(WearError::Stopped);
            }
            let fastest = fastest(&met, targets);
            let increase = drive.step().and_then(|()| {
                if drive.exposure() == f64::MAX { Ok(None) } else { drive.lost_motion().map(Some) }
            });
            let latest = targets.iter().map(|target| target.time).fold(0.0, f64::max);
            let covered = fastest.is_some_and(|per_time| growth.last() >= per_time * latest);
            let increase = match increase {
                Ok(Some(increase)) => increase - new,
                // Beyond the readings a failure only ends the growth.
                Ok(None) | Err(WearError::Load(_) | WearError::RunsAway { .. }) if covered => break,
                // The wear of a law with a threshold has ended before.
                Ok(None) => return Err(growth.out_of_reach()),
                Err(WearError::RunsAway { depth_um, .. }) => {
                    let grown_arcmin = growth.increases[growth.increases.len() - 1] / ARCMIN;
                    return Err(WearError::ReadingsBeyond {
                        place: drive.ran_away(),
                        depth_um,
                        grown_arcmin,
                    });
                }
                Err(error) => return Err(error),
            };
            growth.exposures.push(drive.exposure());
            growth.depths.push(drive.depth());
            growth.increases.push(increase);
            let mut share = 1.0_f64;
            for (met, target) in met.iter_mut().zip(targets) {
                let value = growth.alone_value(target);
                if met.is_none() && value >= target.value {
                    *met = Some(growth.last());
                }
                share = share.min(if met.is_some() { 1.0 } else { value / target.value });
            }
            progress.report("calibration", 0.9 * share.max(0.0));
            if let Some(per_time) = self::fastest(&met, targets)
                && growth.last() >= ROOM * per_time * latest.max(beyond.latest)
                && growth.reaches(beyond, per_time)
            {
                break;
            }
            if drive.updates() > UPDATES {
                return Err(growth.out_of_reach());
            }
        }
        growth.alone = met.into_iter().flatten().collect();
        Ok(growth)
    }

    /// Whether every end of a life is reached, or is beyond the largest time.
    fn reaches(&self, beyond: &Beyond, per_time: f64) -> bool {
        let grown = self.increases[self.increases.len() - 1];
        self.last() >= per_time * beyond.time
            || beyond.ends.iter().all(|(time, left)| grown >= left + self.increase(per_time * time))
    }

    /// Growth of a target if the present exposure is reached at the target's own time.
    fn alone_value(&self, target: &Target) -> f64 {
        let here = self.last();
        self.grown(target.grown, here) - self.grown(target.grown, here * target.since / target.time)
    }

    fn out_of_reach(&self) -> WearError {
        let reached_um = self.depths[self.depths.len() - 1] / UM;
        WearError::TargetNotReached { reached_um, exposure: self.last() }
    }

    /// Largest exposure in s/Pa.
    pub fn last(&self) -> f64 {
        self.exposures[self.exposures.len() - 1]
    }

    /// Exposures in s/Pa at which the targets alone are reached.
    pub(super) fn alone(&self) -> &[f64] {
        &self.alone
    }

    fn read(&self, values: &[f64], exposure: f64) -> f64 {
        let right = self.exposures.partition_point(|x| *x < exposure).clamp(1, self.exposures.len() - 1);
        let (a, b) = (self.exposures[right - 1], self.exposures[right]);
        let t = ((exposure - a) / (b - a)).min(1.0);
        values[right - 1] + t * (values[right] - values[right - 1])
    }

    /// Whether the growth was computed up to an exposure; beyond it the last values are returned.
    pub fn covers(&self, exposure: f64) -> bool {
        exposure <= self.last() * (1.0 + 1e-9)
    }

    /// Largest depth of a flank in m; beyond the last exposure the value there, see [`Growth::covers`].
    pub fn depth(&self, exposure: f64) -> f64 {
        self.read(&self.depths, exposure)
    }

    /// Increase of the lost motion since new in rad; beyond the last exposure the value there, see
    /// [`Growth::covers`].
    pub fn increase(&self, exposure: f64) -> f64 {
        self.read(&self.increases, exposure)
    }

    /// Either of the two, in m or rad.
    pub fn grown(&self, grown: Grown, exposure: f64) -> f64 {
        match grown {
            Grown::Depth => self.depth(exposure),
            Grown::LostMotion => self.increase(exposure),
        }
    }

    /// Exposure (s/Pa) at which the lost motion has increased by this value (rad); `None` if this is not
    /// reached within the computed growth.
    pub fn exposure_at(&self, increase: f64) -> Option<f64> {
        if increase <= 0.0 {
            return Some(0.0);
        }
        let right = self.increases.iter().position(|value| *value >= increase)?;
        let (a, b) = (self.increases[right - 1], self.increases[right]);
        let t = (increase - a) / (b - a);
        Some(self.exposures[right - 1] + t * (self.exposures[right] - self.exposures[right - 1]))
    }

    /// A growth given by points (exposure, depth, increase), for tests with known results.
    #[cfg(test)]
    pub(super) fn of(points: &[(f64, f64, f64)], targets: &[Target]) -> Growth {
        let column = |of: fn(&(f64, f64, f64)) -> f64| points.iter().map(of).collect::<Vec<f64>>();
        let mut growth = Growth {
            exposures: column(|p| p.0),
            depths: column(|p| p.1),
            increases: column(|p| p.2),
            alone: Vec::new(),
        };
        growth.alone = targets
            .iter()
            .map(|target| {
                let met = |x: &&f64| {
                    let before = growth.grown(target.grown, **x * target.since / target.time);
                    growth.grown(target.grown, **x) - before >= target.value
                };
                *growth.exposures.iter().skip(1).find(met).unwrap_or(&growth.last())
            })
            .collect();
        growth
    }
}

/// The largest exposure per time that any single target requires; `None` while some target is not reached.
fn fastest(met: &[Option<f64>], targets: &[Target]) -> Option<f64> {
    met.iter()
        .zip(targets)
        .try_fold(0.0_f64, |fastest, (met, target)| Some(fastest.max((*met)? / target.time)))
}
