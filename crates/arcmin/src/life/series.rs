//! Machines of one series: what tolerances make of the accuracy over life.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::{LifeOptions, PartsFollower, advance, search_limit};
use crate::dynamics::BearingMeshing;
use crate::machine::{Machine, PartWear};
use crate::progress::Progress;
use crate::units::HOUR;
use crate::wear::calibrate::coupled_exposure;
use crate::wear::{CoupledWear, Exposure, WearError};

/// One machine over its service life.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineLife {
    /// Lost motion in rad at the hours of the series.
    pub lost_motion: Vec<f64>,
    /// Until it reaches the design's limit; `None` if it does not within `searched_hours`.
    pub hours_to_limit: Option<f64>,
    pub searched_hours: f64,
    /// Largest depth lost by a flank at the end of the service life, m.
    pub max_depth: f64,
    pub wear: PartWear,
}

/// A series of machines of one design, each with its own errors, and the machine without.
#[derive(Debug, Clone)]
pub struct Series {
    /// Equidistant from new to the end of the service life.
    pub hours: Vec<f64>,
    pub nominal: MachineLife,
    /// In the order given; a machine whose load cannot be shared some time says why.
    pub machines: Vec<Result<MachineLife, WearError>>,
}

/// Least, 10 %, middle, 90 %, largest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantiles(pub [f64; 5]);

impl Quantiles {
    /// Of values in any order, between them by straight lines; infinite ones (never) are larger than all.
    /// `None` of nothing.
    pub fn of(values: impl Iterator<Item = f64>) -> Option<Quantiles> {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        Some(Quantiles([0.0, 0.1, 0.5, 0.9, 1.0].map(|share| {
            let place = share * last as f64;
            let below = place.floor() as usize;
            let (a, b, t) = (sorted[below], sorted[(below + 1).min(last)], place - below as f64);
            // Between a time and never there is no time.
            if t == 0.0 || a == b { a } else { a + t * (b - a) }
        })))
    }
}

impl Series {
    /// Machines that could be followed.
    pub fn followed(&self) -> impl Iterator<Item = &MachineLife> {
        self.machines.iter().flatten()
    }

    /// Lost motion (rad) of the machines at hour number `index`.
    pub fn lost_motion(&self, index: usize) -> Option<Quantiles> {
        Quantiles::of(self.followed().map(|life| life.lost_motion[index]))
    }

    /// Hours until the limit; infinite for those that were not seen to reach it.
    pub fn hours_to_limit(&self) -> Option<Quantiles> {
        Quantiles::of(self.followed().map(|life| life.hours_to_limit.unwrap_or(f64::INFINITY)))
    }
}

/// Follows machines of one design over their service life and on to their limit, side by side; each as
/// [`predict_made`](super::predict_made) does. The wear coefficient is one for all: where it is to be
/// calibrated, the `nominal` machine is.
///
/// # Errors
/// [`WearError`] of the nominal machine; `Stopped` when `progress` was cancelled.
pub fn predict_series(
    machine: &Machine,
    nominal: BearingMeshing,
    made: &[BearingMeshing],
    options: LifeOptions,
    progress: &dyn Progress,
) -> Result<Series, WearError> {
    let exposure = coupled_exposure(machine, nominal.clone(), options.wear)?;
    let done = AtomicUsize::new(0);
    let one = |joints: &BearingMeshing| {
        let life = follow(machine, joints.clone(), &exposure, options, progress);
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        progress.report("machines of the series", count as f64 / (made.len() + 1) as f64);
        life
    };
    let all: Vec<&BearingMeshing> = std::iter::once(&nominal).chain(made).collect();
    let mut lives = all.into_par_iter().map(one).collect::<Vec<_>>().into_iter();
    if progress.is_cancelled() {
        return Err(WearError::Stopped);
    }
    let Some(nominal) = lives.next() else { unreachable!("the nominal machine is one of them") };
    let service_hours = machine.limits.service_life / HOUR;
    let hours = (0..=options.intervals)
        .map(|interval| service_hours * interval as f64 / options.intervals as f64)
        .collect();
    Ok(Series { hours, nominal: nominal?, machines: lives.collect() })
}

fn follow(
    machine: &Machine,
    joints: BearingMeshing,
    exposure: &Exposure,
    options: LifeOptions,
    progress: &dyn Progress,
) -> Result<MachineLife, WearError> {
    let mut parts = Some(PartsFollower::with(machine, joints.clone()));
    let mut wear = CoupledWear::with(machine, joints, options.wear);
    let service_hours = machine.limits.service_life / HOUR;
    let mut history = Vec::with_capacity(options.intervals + 1);
    for interval in 0..=options.intervals {
        let hours = service_hours * interval as f64 / options.intervals as f64;
        let Some(parts) = &mut parts else { unreachable!("set above") };
        if interval > 0 {
            parts.advance(service_hours * HOUR / options.intervals as f64)?;
            wear.set_part_wear(parts.wear());
        }
        advance(&mut wear, exposure.at(hours * HOUR), progress)?;
        parts.see(wear.state());
        history.push((hours, parts.lost_motion_causes(wear.state(), *parts.wear())?.lost_motion.whole));
    }
    let lost_motion = history.iter().map(|(_, lost)| *lost).collect();
    let max_depth = wear.state().flank().deepest().0;
    let worn = parts.as_ref().map_or_else(PartWear::default, |parts| *parts.wear());
    let (hours_to_limit, searched_hours) =
        search_limit(machine, &mut wear, &mut parts, exposure, options, history, progress)?;
    Ok(MachineLife { lost_motion, hours_to_limit, searched_hours, max_depth, wear: worn })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::JointSettings;
    use crate::life::predict_made;
    use crate::machine::{ManufacturingErrors, Tolerances};
    use crate::progress::Silent;
    use crate::units::UM;

    #[test]
    fn quantiles_by_hand() {
        assert_eq!(Quantiles::of([3.0, 1.0, 2.0].into_iter()).unwrap(), Quantiles([1.0, 1.2, 2.0, 2.8, 3.0]));
        assert_eq!(Quantiles::of([7.0].into_iter()).unwrap(), Quantiles([7.0; 5]));
        assert_eq!(Quantiles::of([f64::INFINITY; 3].into_iter()).unwrap(), Quantiles([f64::INFINITY; 5]));
        let some = Quantiles::of([1.0, f64::INFINITY, 2.0, f64::INFINITY].into_iter()).unwrap();
        assert!(
            some.0[1] > 1.0 && some.0[1] < 2.0 && some.0[2..].iter().all(|x| *x == f64::INFINITY),
            "{some:?}"
        );
        assert!(Quantiles::of([].into_iter()).is_none());
    }

    /// A machine of the series is the machine followed alone, to the last digit; and on any number of
    /// threads.
    #[test]
    fn a_machine_of_a_series_is_that_machine() {
        let mut machine = crate::templates::rv_40e_81();
        machine.limits.service_life = 300.0 * HOUR;
        // Reached soon after, so that the search is part of the comparison.
        machine.limits.lost_motion = 0.75 * crate::units::ARCMIN;
        let tolerances = Tolerances {
            pin_position: 3.0 * UM,
            eccentricity: 2.0 * UM,
            bore_position: 3.0 * UM,
            ..Tolerances::default()
        };
        let joints = |seed: u64| {
            let errors = ManufacturingErrors::draw(&machine, &tolerances, seed);
            BearingMeshing::new(&machine, &JointSettings { errors, ..JointSettings::default() }).unwrap()
        };
        let nominal = BearingMeshing::new(&machine, &JointSettings::default()).unwrap();
        let mut options =
            LifeOptions { intervals: 2, crank_positions: 6, search_factor: 4.0, ..LifeOptions::default() };
        options.wear.depth_increment = 0.3 * UM;
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                predict_series(&machine, nominal.clone(), &[joints(1), joints(2)], options, &Silent).unwrap()
            })
        };
        let (one, two) = (on(1), on(2));
        assert_eq!((&one.machines, &one.nominal), (&two.machines, &two.nominal));
        let alone = predict_made(&machine, nominal.clone(), joints(2), options, &Silent).unwrap();
        let member = one.machines[1].as_ref().unwrap();
        let lost: Vec<f64> = alone.points.iter().map(|point| point.machine_lost_motion().radians()).collect();
        assert_eq!((&lost, alone.hours_to_limit), (&member.lost_motion, member.hours_to_limit));
        assert_ne!(one.machines[0], one.machines[1]);
        assert!(one.lost_motion(2).unwrap().0[0] > one.lost_motion(0).unwrap().0[0]);
    }
}
