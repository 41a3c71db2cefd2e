//! Accuracy over life: the coupled prediction, and beside it the paper's study of uniform depths.

mod parts;
mod series;

use parts::lost_motion_positions;
pub use parts::{PartsFollower, PartsPoint, lost_motion_causes, worn_settings};
pub use series::{MachineLife, Quantiles, Series, predict_series};

use rayon::prelude::*;

use crate::dynamics::{BearingMeshing, JointSettings};
use crate::geometry::Relief;
use crate::load::{Cycle, FlankForce, PinLoad, ShareLoad, lost_motion};
use crate::machine::{Machine, OutputAngle, PartWear};
use crate::progress::Progress;
use crate::units::{HOUR, UM};
use crate::wear::calibrate::coupled_exposure;
use crate::wear::paper::PaperWear;
use crate::wear::{CoupledOptions, CoupledWear, Exposure, WearError, WearSnapshot};

/// Accuracy and loads of the machine after some hours.
#[derive(Debug, Clone)]
pub struct LifePoint {
    pub hours: f64,
    /// Largest depth lost by a flank in m, and the meshing angle there in rad.
    pub max_depth: f64,
    pub max_depth_at: f64,
    /// One-sided play at the output, input locked, no load; mean over the cycle.
    pub play: OutputAngle,
    /// Both sides together.
    pub free_travel: OutputAngle,
    /// Mean output error under vanishing rated-side torque: the play, signed.
    pub no_load_error: OutputAngle,
    /// Mean output error under rated torque.
    pub loaded_error: OutputAngle,
    /// Peak-to-peak output error under rated torque over the cycle.
    pub loaded_peak_to_peak: OutputAngle,
    /// Between −3 % and +3 % of rated torque: of the contacts alone with ideal joints, of the machine with
    /// bearings.
    pub lost_motion: OutputAngle,
    /// N, Pa, pairs of one disc.
    pub max_force: f64,
    pub max_pressure: f64,
    pub loaded_pairs: f64,
    /// Load sharing at rated torque over one pin pitch of crank angle.
    pub cycle: Cycle,
    /// Forces on the flank by meshing angle: of all discs, or per disc the mean of all pins over everything
    /// that repeats.
    pub flank_forces: Vec<Vec<FlankForce>>,
    /// The largest of all pins and discs.
    pub flank_peaks: Vec<FlankForce>,
    /// What every pin bears over everything that repeats; empty where all bear the same.
    pub pin_loads: Vec<PinLoad>,
    /// Worn surfaces.
    pub flank: Relief,
    /// Lost motion of the machine with bearings by cause; only in a prediction of a machine that is modelled
    /// with bearings.
    pub parts: Option<PartsPoint>,
}

impl LifePoint {
    /// What a user of the machine feels and its limit is about: with the bearings where they are modelled,
    /// else of the contacts alone.
    pub fn machine_lost_motion(&self) -> OutputAngle {
        self.parts
            .as_ref()
            .map_or(self.lost_motion, |parts| OutputAngle::from_radians(parts.lost_motion.whole))
    }
}

/// The coupled prediction.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// At equidistant hours from new to the end of the service life.
    pub points: Vec<LifePoint>,
    /// Worn surfaces at these points.
    pub surfaces: Vec<WearSnapshot>,
    pub exposure: Exposure,
    /// Updates of the flank over the service life.
    pub updates: usize,
    /// Hours until the lost motion of the whole machine ([`LifePoint::machine_lost_motion`]) reaches the
    /// design's limit; `None` if it does not within [`Prediction::searched_hours`].
    pub hours_to_limit: Option<f64>,
    /// How far the limit was looked for.
    pub searched_hours: f64,
}

/// The paper's study: uniform depths with the hours of its wear model.
#[derive(Debug, Clone)]
pub struct PaperStudy {
    pub points: Vec<LifePoint>,
    pub wear: PaperWear,
    pub hours_to_limit: Option<f64>,
}

/// Numerical choices of a life computation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LifeOptions {
    pub wear: CoupledOptions,
    /// Intervals of the service life at which accuracy is evaluated.
    pub intervals: usize,
    /// Crank positions of each evaluation.
    pub crank_positions: usize,
    /// The limit is looked for up to this multiple of the service life.
    pub search_factor: f64,
}

impl Default for LifeOptions {
    fn default() -> LifeOptions {
        LifeOptions {
            wear: CoupledOptions::default(),
            intervals: 30,
            crank_positions: 36,
            search_factor: 4.0,
        }
    }
}

/// Times as many crank positions where it takes the whole ring to repeat (a test shows what is left).
const RING_POSITIONS: usize = 4;
/// Steps of the meshing angle for forces that differ from pin to pin.
const FLANK_CELLS: usize = 72;

/// The largest force of all discs in each cell.
fn highest(discs: &[Vec<FlankForce>]) -> Vec<FlankForce> {
    let mut all: Vec<FlankForce> = discs.iter().flatten().copied().collect();
    all.sort_by(|a, b| a.meshing_angle.total_cmp(&b.meshing_angle));
    let cell =
        |force: &FlankForce| (force.meshing_angle / std::f64::consts::TAU * FLANK_CELLS as f64).floor();
    all.chunk_by(|a, b| cell(a) == cell(b))
        .filter_map(|cell| cell.iter().copied().max_by(|a, b| a.force.total_cmp(&b.force)))
        .collect()
}

/// Accuracy of one state of wear.
///
/// # Errors
/// [`WearError::Load`] when a load sharing fails.
pub fn accuracy<S: ShareLoad>(
    machine: &Machine,
    meshing: &mut S,
    flank: &Relief,
    hours: f64,
    crank_positions: usize,
) -> Result<LifePoint, WearError> {
    let alike = meshing.discs_alike();
    let cycle = meshing.whole_cycle(
        machine.rated.torque,
        if alike { crank_positions } else { RING_POSITIONS * crank_positions },
    )?;
    let pitch = if meshing.pitches() == 1 {
        cycle.clone()
    } else {
        meshing.pitch_cycle(machine.rated.torque, crank_positions)?
    };
    let (flank_forces, flank_peaks) = if alike {
        (vec![pitch.flank_forces()], pitch.flank_forces())
    } else {
        let (means, peaks): (Vec<_>, Vec<_>) =
            (0..machine.disc_count).map(|disc| cycle.flank_cells(disc, FLANK_CELLS)).unzip();
        (means, highest(&peaks))
    };
    let pin_loads = if alike { Vec::new() } else { cycle.pin_loads() };
    let (max_depth, max_depth_at) = flank.deepest();
    let play = cycle.mean_play();
    let sign = if machine.rated.torque < 0.0 { 1.0 } else { -1.0 };
    Ok(LifePoint {
        hours,
        max_depth,
        max_depth_at,
        play,
        free_travel: cycle.mean_free_travel(),
        no_load_error: OutputAngle::from_radians(sign * play.radians()),
        loaded_error: cycle.mean_error(),
        loaded_peak_to_peak: cycle.peak_to_peak_error(),
        lost_motion: lost_motion(meshing, machine.rated.torque, lost_motion_positions(meshing))?,
        max_force: cycle.max_force(),
        max_pressure: cycle.max_pressure(meshing.contacts().contact()),
        loaded_pairs: cycle.loaded_pairs(),
        flank: flank.clone(),
        parts: None,
        cycle: pitch,
        flank_forces,
        flank_peaks,
        pin_loads,
    })
}

/// Follows the coupled wear with ideal joints over the service life and on until the limit of the lost motion
/// is reached or `search_factor` service lives are over.
///
/// # Errors
/// [`WearError`]; `Stopped` when `progress` was cancelled.
pub fn predict(
    machine: &Machine,
    options: LifeOptions,
    progress: &dyn Progress,
) -> Result<Prediction, WearError> {
    predict_with(
        machine,
        machine.meshing(&Relief::uniform(0.0)),
        &JointSettings::default(),
        options,
        progress,
    )
}

/// [`predict`] with the joints of `meshing`; `whole` gives the model with bearings, which lost motion by
/// cause and the wear of bearings and gears come from, its errors and elastic discs.
///
/// # Errors
/// As [`predict`].
pub fn predict_with<S: ShareLoad + Clone + Send + Sync>(
    machine: &Machine,
    meshing: S,
    whole: &JointSettings,
    options: LifeOptions,
    progress: &dyn Progress,
) -> Result<Prediction, WearError> {
    let exposure = coupled_exposure(machine, meshing.clone(), options.wear)?;
    Course { machine, parts: PartsFollower::new(machine, whole), exposure, options, progress }
        .predict(meshing)
}

/// [`predict`] of one real machine in its bearings. The wear coefficient belongs to the design: where it is
/// to be calibrated, the `nominal` machine is.
///
/// # Errors
/// As [`predict`].
pub fn predict_made(
    machine: &Machine,
    nominal: BearingMeshing,
    made: BearingMeshing,
    options: LifeOptions,
    progress: &dyn Progress,
) -> Result<Prediction, WearError> {
    let exposure = coupled_exposure(machine, nominal, options.wear)?;
    Course { machine, parts: Some(PartsFollower::with(machine, made.clone())), exposure, options, progress }
        .predict(made)
}

/// What a prediction follows, whatever the joints.
struct Course<'a> {
    machine: &'a Machine,
    parts: Option<PartsFollower<'a>>,
    exposure: Exposure,
    options: LifeOptions,
    progress: &'a dyn Progress,
}

impl Course<'_> {
    fn predict<S: ShareLoad + Clone + Send + Sync>(self, meshing: S) -> Result<Prediction, WearError> {
        let Course { machine, mut parts, exposure, options, progress } = self;
        let mut wear = CoupledWear::with(machine, meshing, options.wear);
        let service_hours = machine.limits.service_life / HOUR;
        let hours_of = |interval: usize| service_hours * interval as f64 / options.intervals as f64;
        let mut surfaces = Vec::with_capacity(options.intervals + 1);
        let mut part_wear = Vec::with_capacity(options.intervals + 1);
        for interval in 0..=options.intervals {
            if let Some(parts) = parts.as_mut().filter(|_| interval > 0) {
                parts.advance(service_hours * HOUR / options.intervals as f64)?;
                wear.set_part_wear(parts.wear());
            }
            advance(&mut wear, exposure.at(hours_of(interval) * HOUR), progress)?;
            if let Some(parts) = &mut parts {
                parts.see(wear.state());
            }
            part_wear.push(parts.as_ref().map_or_else(PartWear::default, |parts| *parts.wear()));
            surfaces.push(wear.state().clone());
            progress.report("wear", interval as f64 / options.intervals as f64);
        }
        let (joints, designed) = (wear.meshing_mut().clone(), machine.designed_relief());
        let points = surfaces
            .par_iter()
            .zip(&part_wear)
            .enumerate()
            .map(|(interval, (worn, part_wear))| {
                if progress.is_cancelled() {
                    return Err(WearError::Stopped);
                }
                let mut joints = joints.clone();
                worn.put_on(&designed, &mut joints);
                joints.set_part_wear(part_wear);
                let mut point = accuracy(
                    machine,
                    &mut joints,
                    worn.flank(),
                    hours_of(interval),
                    options.crank_positions,
                )?;
                point.parts =
                    parts.as_ref().map(|parts| parts.lost_motion_causes(worn, *part_wear)).transpose()?;
                Ok(point)
            })
            .collect::<Result<Vec<LifePoint>, WearError>>()?;
        let updates = wear.updates();
        let history =
            points.iter().map(|point| (point.hours, point.machine_lost_motion().radians())).collect();
        let (hours_to_limit, searched_hours) =
            search_limit(machine, &mut wear, &mut parts, &exposure, options, history, progress)?;
        Ok(Prediction { points, surfaces, exposure, updates, hours_to_limit, searched_hours })
    }
}

/// Goes on beyond the service life until the lost motion reaches its limit: hours to there, and how far was
/// looked. `history` holds (h, rad) over the service life.
fn search_limit<S: ShareLoad>(
    machine: &Machine,
    wear: &mut CoupledWear<'_, S>,
    parts: &mut Option<PartsFollower<'_>>,
    exposure: &Exposure,
    options: LifeOptions,
    mut history: Vec<(f64, f64)>,
    progress: &dyn Progress,
) -> Result<(Option<f64>, f64), WearError> {
    let service_hours = machine.limits.service_life / HOUR;
    let limit = machine.limits.lost_motion;
    let furthest = options.search_factor.max(1.0) * service_hours;
    let mut hours_to_limit = crossing(&history, limit);
    let mut searched_hours = service_hours;
    while hours_to_limit.is_none() && searched_hours < furthest {
        let hours = (searched_hours + service_hours / 4.0).min(furthest);
        if let Some(parts) = parts {
            parts.see(wear.state());
            parts.advance((hours - searched_hours) * HOUR)?;
            wear.set_part_wear(parts.wear());
        }
        let lost = advance(wear, exposure.at(hours * HOUR), progress).and_then(|()| match &parts {
            Some(parts) => Ok(parts.lost_motion_causes(wear.state(), *parts.wear())?.lost_motion.whole),
            None => {
                let meshing = wear.meshing_mut();
                Ok(lost_motion(meshing, machine.rated.torque, lost_motion_positions(meshing))?.radians())
            }
        });
        match lost {
            Ok(lost) => history.push((hours, lost)),
            // Far beyond the service life a flank may be worn out of the model's reach; the search ends where
            // it still held.
            Err(WearError::Load(_)) => break,
            Err(error) => return Err(error),
        }
        searched_hours = hours;
        hours_to_limit = crossing(&history, limit);
    }
    Ok((hours_to_limit, searched_hours))
}

fn advance<S: ShareLoad>(
    wear: &mut CoupledWear<'_, S>,
    target: f64,
    progress: &dyn Progress,
) -> Result<(), WearError> {
    let mut stopped = false;
    wear.advance_until(target, |_| {
        stopped = progress.is_cancelled();
        stopped
    })?;
    if stopped { Err(WearError::Stopped) } else { Ok(()) }
}

/// First abscissa at which the values reach `limit`, by linear interpolation.
fn crossing(history: &[(f64, f64)], limit: f64) -> Option<f64> {
    if history.first().is_some_and(|(_, value)| *value >= limit) {
        return Some(history[0].0);
    }
    history.windows(2).find(|pair| pair[1].1 >= limit).map(|pair| {
        let ((h0, v0), (h1, v1)) = (pair[0], pair[1]);
        h0 + (h1 - h0) * (limit - v0) / (v1 - v0)
    })
}

/// Uniform depths in m, as in Tao2024: 0, 10, …, 60 µm.
pub fn paper_depths() -> [f64; 7] {
    std::array::from_fn(|level| 10.0 * UM * level as f64)
}

/// The paper's study at the given uniform depths (m).
///
/// # Errors
/// [`WearError`] when closed form or load sharing fail.
pub fn paper_study(machine: &Machine, depths: &[f64], options: LifeOptions) -> Result<PaperStudy, WearError> {
    let deepest = depths.iter().copied().fold(0.0, f64::max);
    let wear = PaperWear::new(machine, deepest)?;
    let mut points = Vec::with_capacity(depths.len());
    for depth in depths {
        let flank = Relief::uniform(*depth);
        points.push(accuracy(
            machine,
            &mut machine.meshing(&flank),
            &flank,
            wear.hours_at(*depth),
            options.crank_positions,
        )?);
    }
    let history: Vec<(f64, f64)> =
        points.iter().map(|point| (point.hours, point.lost_motion.radians())).collect();
    Ok(PaperStudy { hours_to_limit: crossing(&history, machine.limits.lost_motion), points, wear })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn life_starts_new_and_loses_accuracy_monotonically() {
        let machine = crate::templates::rv_40e_81();
        let options = LifeOptions { intervals: 5, crank_positions: 6, ..LifeOptions::default() };
        let prediction = predict(&machine, options, &Silent).unwrap();
        assert_eq!(prediction.points.len(), 6);
        assert_eq!(prediction.points[0].max_depth, 0.0);
        assert!(prediction.points[0].play.arcmin().abs() < 1e-9);
        assert!(
            prediction
                .points
                .windows(2)
                .all(|p| p[1].lost_motion > p[0].lost_motion && p[1].max_depth > p[0].max_depth)
        );
        assert!(prediction.updates >= 100);
    }

    #[test]
    fn a_limit_already_exceeded_is_reached_at_zero_hours() {
        assert_eq!(crossing(&[(0.0, 2.0), (10.0, 3.0)], 1.0), Some(0.0));
        assert_eq!(crossing(&[(0.0, 0.0), (10.0, 4.0)], 1.0), Some(2.5));
        assert_eq!(crossing(&[(0.0, 0.0), (10.0, 4.0)], 5.0), None);
    }

    #[test]
    fn a_cancelled_prediction_says_so() {
        struct Cancelled;
        impl Progress for Cancelled {
            fn report(&self, _: &str, _: f64) {}
            fn is_cancelled(&self) -> bool {
                true
            }
        }
        let machine = crate::templates::rv_40e_81();
        assert_eq!(predict(&machine, LifeOptions::default(), &Cancelled).unwrap_err(), WearError::Stopped);
    }

    /// The study reproduces the play of the uniformly worn disc and the paper's hours.
    #[test]
    fn val_study_at_ten_and_sixty_micrometres() {
        let machine = crate::templates::rv_40e_81();
        let study = paper_study(
            &machine,
            &paper_depths(),
            LifeOptions { crank_positions: 72, ..LifeOptions::default() },
        )
        .unwrap();
        assert!((study.points[1].play.arcmin() - 0.6536).abs() < 1e-4);
        assert!((study.points[6].play.arcmin() - 3.9218).abs() < 1e-4);
        assert!((study.points[6].hours - 7500.0).abs() < 1e-6);
        assert!((study.points[5].hours / 6442.0 - 1.0).abs() < 0.01);
    }
}
