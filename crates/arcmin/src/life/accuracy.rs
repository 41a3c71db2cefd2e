//! Accuracy and loads of one state of wear.

use super::extremes::{Extremes, extremes};
use crate::geometry::Relief;
use crate::load::{CycleContact, FlankForce, LoadError, PinLoad, ShareLoad};
use crate::machine::{DutyPoint, OutputAngle};
use crate::wear::{WearCase, WearError};

/// Errors under load, forces and pressures at a state of wear.
#[derive(Debug, Clone)]
pub struct Accuracy {
    /// Running hours since new.
    pub hours: f64,
    /// Largest depth lost by a flank in m.
    pub max_depth: f64,
    /// Meshing angle there in rad; `None` where no flank has lost metal.
    pub max_depth_at: Option<f64>,
    /// Mean output error under rated torque.
    pub loaded_error: OutputAngle,
    /// Peak-to-peak output error under rated torque over the cycle.
    pub loaded_peak_to_peak: OutputAngle,
    /// Largest force of a pin in N at the largest torque of rating and duty.
    pub max_force: f64,
    /// Largest Hertz pressure between pin and flank in Pa at the same torque.
    pub max_pressure: f64,
    /// Standard deviation of single values about the largest pressure, in Pa.
    pub pressure_scatter: f64,
    /// Place of the largest force.
    pub largest_force_at: CycleContact,
    /// Place of the largest pressure, which may be at another pin.
    pub largest_pressure_at: CycleContact,
    /// Mean number of loaded pairs of one disc at rated torque.
    pub loaded_pairs: f64,
    /// Forces on the flank by meshing angle over one full period: of all discs, or per disc the mean
    /// of all pins.
    pub flank_forces: Vec<Vec<FlankForce>>,
    /// The largest of all pins and discs.
    pub flank_peaks: Vec<FlankForce>,
    /// Loads of every pin over one full period; empty if all have the same load.
    pub pin_loads: Vec<PinLoad>,
    /// The flank with the deepest wear.
    pub flank: Relief,
}

/// Free travel of the machine without load, means over one full period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// One-sided play at the output, input locked.
    pub play: OutputAngle,
    /// Both sides together.
    pub free_travel: OutputAngle,
    /// Output error in rad as the rated torque tends to zero: the signed play.
    pub no_load_error: OutputAngle,
    /// Largest force of a pin in N, 0 where there is play.
    pub preload: f64,
    /// Friction torque at the output in N·m that the preload causes with the flank friction of the machine.
    pub preload_friction: f64,
}

/// Factor on the number of crank positions where the full period is the whole ring (a test shows the remaining
/// error).
const RING_POSITIONS: usize = 4;
/// Steps of the meshing angle for forces that differ from pin to pin, and for forces that depend on the crank angle
/// alone.
const PIN_CELLS: usize = 72;
const CRANK_CELLS: usize = 144;

/// The largest force of all discs in each cell.
fn highest(discs: &[Vec<FlankForce>], cells: usize) -> Vec<FlankForce> {
    let mut all: Vec<FlankForce> = discs.iter().flatten().copied().collect();
    all.sort_by(|a, b| a.meshing_angle.total_cmp(&b.meshing_angle));
    let cell = |force: &FlankForce| (force.meshing_angle / std::f64::consts::TAU * cells as f64).floor();
    all.chunk_by(|a, b| cell(a) == cell(b))
        .filter_map(|cell| cell.iter().copied().max_by(|a, b| a.force.total_cmp(&b.force)))
        .collect()
}

/// Crank positions of a mean over one full period.
fn positions<S: ShareLoad>(meshing: &S, crank_positions: usize) -> usize {
    if meshing.discs_alike() { crank_positions } else { RING_POSITIONS * crank_positions }
}

/// Free travel in one state of wear; `meshing` has the surfaces of this state.
///
/// # Errors
/// [`WearError::Load`] when no load-free balance is found.
pub fn travel<S: ShareLoad>(
    case: &WearCase,
    meshing: &mut S,
    crank_positions: usize,
) -> Result<Travel, WearError> {
    let torque = case.rated_torque;
    let cycle = meshing.free_cycle(torque, positions(meshing, crank_positions))?;
    let play = cycle.mean_play();
    let sign = if torque < 0.0 { 1.0 } else { -1.0 };
    Ok(Travel {
        play,
        free_travel: cycle.mean_free_travel(),
        no_load_error: OutputAngle::from_radians(sign * play.radians()),
        preload: cycle.max_preload(),
        preload_friction: cycle.preload_friction_torque(case.flank_friction),
    })
}

/// The most heavily loaded contacts under a torque, with the surfaces of `meshing`.
///
/// # Errors
/// [`LoadError`] when a load sharing fails.
pub(crate) fn most_loaded<S: ShareLoad>(
    meshing: &mut S,
    torque: f64,
    crank_positions: usize,
) -> Result<Extremes, LoadError> {
    let cycle = meshing.loaded_cycle(torque, positions(meshing, crank_positions))?;
    Ok(extremes(meshing, torque, &cycle))
}

/// Accuracy in one state of wear; `meshing` has the surfaces of this state.
///
/// # Errors
/// [`WearError::Load`] when a load sharing fails.
pub fn accuracy<S: ShareLoad>(
    case: &WearCase,
    meshing: &mut S,
    flank: &Relief,
    hours: f64,
    crank_positions: usize,
) -> Result<Accuracy, WearError> {
    let alike = meshing.discs_alike();
    let count = positions(meshing, crank_positions);
    let cycle = meshing.loaded_cycle(case.rated_torque, count)?;
    let extremes = match DutyPoint::largest_signed_torque(case.rated_torque, &case.duty) {
        torque if torque == case.rated_torque => extremes(meshing, torque, &cycle),
        torque => most_loaded(meshing, torque, crank_positions)?,
    };
    let (flank_forces, flank_peaks) = if meshing.pitches() == 1 {
        (vec![cycle.flank_forces()], cycle.flank_forces())
    } else {
        let (discs, cells) = if alike { (1, CRANK_CELLS) } else { (case.disc_count, PIN_CELLS) };
        let (means, peaks): (Vec<_>, Vec<_>) = (0..discs).map(|disc| cycle.flank_cells(disc, cells)).unzip();
        (means, highest(&peaks, cells))
    };
    let pin_loads = if alike { Vec::new() } else { cycle.pin_loads() };
    let (max_depth, at) = flank.deepest();
    let max_depth_at = (max_depth > 0.0).then_some(at);
    Ok(Accuracy {
        hours,
        max_depth,
        max_depth_at,
        loaded_error: cycle.mean_error(),
        loaded_peak_to_peak: cycle.peak_to_peak_error(),
        max_force: extremes.largest_force.force,
        max_pressure: extremes.largest_pressure.pressure,
        pressure_scatter: extremes.scatter,
        largest_force_at: extremes.largest_force,
        largest_pressure_at: extremes.largest_pressure,
        loaded_pairs: cycle.loaded_pairs(),
        flank: flank.clone(),
        flank_forces,
        flank_peaks,
        pin_loads,
    })
}
