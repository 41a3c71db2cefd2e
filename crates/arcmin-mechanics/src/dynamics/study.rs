use rayon::prelude::*;

use super::{
    Drive, DynamicsError, ErrorStatistics, FlexibleJoints, FlexibleOptions, IdealJoints, Model, OutputLoad,
    Reducer, Run, RunPlan, RunResult,
};
use crate::fem::FlexibleDiscs;
use crate::geometry::Relief;
use crate::machine::Machine;
use crate::progress::{Counter, Progress, Silent, Unseen};
use crate::units::ARCMIN;

/// Static and dynamic transmission error of one model over a list of wear states.
#[derive(Debug, Clone, PartialEq)]
pub struct TransmissionErrorStudy {
    /// Results of the wear states in the order given.
    pub points: Vec<StudyPoint>,
}

/// One wear state of a [`TransmissionErrorStudy`].
#[derive(Debug, Clone, PartialEq)]
pub struct StudyPoint {
    /// Results without load (STE).
    pub no_load: RunResult,
    /// Results under load (DTE).
    pub loaded: RunResult,
    /// Spread of the no-load result over perturbed starts; `None` if not requested.
    pub spread: Option<StartSpread>,
}

/// Dependence of a result on the initial position within the backlash. Unloaded motion rattles in the clearance
/// and is chaotic without drag: then the mean is not meaningful, only the band and the RMS are.
#[derive(Debug, Clone, PartialEq)]
pub struct StartSpread {
    /// Statistics of every start.
    pub runs: Vec<ErrorStatistics>,
    /// Largest minus smallest mean in rad.
    pub mean: f64,
    /// Largest minus smallest RMS in rad.
    pub rms: f64,
    /// Largest magnitude of the error over all starts in rad.
    pub band: f64,
}

impl StartSpread {
    /// Whether the mean varies by more than a tenth of the band over perturbed starts.
    pub fn is_chaotic(&self) -> bool {
        self.mean > 0.1 * self.band
    }
}

/// Settings of the runs at every wear state.
#[derive(Debug, Clone, PartialEq)]
pub struct StudySettings {
    /// Motion of the input in all runs.
    pub drive: Drive,
    /// Load of the DTE; the STE is without load.
    pub load: OutputLoad,
    /// Steady drag at the output in N·m, for both.
    pub drag: f64,
    /// Length, window and intervals of all runs.
    pub plan: RunPlan,
    /// Perturbed starts for each wear state, for the spread of the no-load result; 0 for none.
    pub perturbed_starts: usize,
}

impl StudySettings {
    /// The study of Tao2024: speed law to the rated input speed within 0.1 s, 0.8 s, sinusoidal load of the
    /// rated torque with 0.3 s period, no drag.
    pub fn tao2024(machine: &Machine) -> StudySettings {
        StudySettings {
            drive: Drive::SpeedLaw { speed: machine.rated.input_speed, rise_time: 0.1 },
            load: OutputLoad::Sine { amplitude: machine.rated.torque, period: 0.3 },
            drag: 0.0,
            plan: RunPlan::default(),
            perturbed_starts: 4,
        }
    }
}

/// One run of the ideal-joint model from its static equilibrium at time 0 to the end.
///
/// # Errors
/// As [`IdealJoints::new`] and [`Run`].
pub fn simulate_rigid(
    machine: &Machine,
    wear: &Relief,
    drive: &Drive,
    load: &OutputLoad,
    drag: f64,
    plan: RunPlan,
) -> Result<RunResult, DynamicsError> {
    let model = IdealJoints::new(machine, wear, drive.clone(), load.clone(), drag)?;
    let mut run = Run::new(model, plan, &Silent)?;
    run.finish(&Silent)?;
    Ok(run.result())
}

/// Runs in parallel from `count` starts distributed over ±0.05' of the output around the nominal pose; the
/// result is the same for any number of threads.
///
/// # Errors
/// As [`Run`]; [`DynamicsError::Cancelled`] if `progress` says so.
pub fn spread_over_starts(
    model: &Model,
    plan: RunPlan,
    count: usize,
    progress: &dyn Progress,
) -> Result<StartSpread, DynamicsError> {
    let done = Counter::new("perturbed starts", count, progress);
    let runs = (0..count)
        .into_par_iter()
        .map(|i| {
            let mut start = model.nominal_position();
            // Irrational steps, so that no two starts are symmetric to each other.
            let place = ((i as f64 + 1.0) * 0.618_033_988_749_894_9).fract() - 0.5;
            start[model.output_index()] += 0.1 * ARCMIN * place;
            let mut run = Run::from_state(model.clone(), plan, &start, &vec![0.0; start.len()])?;
            run.finish(progress)?;
            done.one_more();
            Ok(run.result().statistics)
        })
        .collect::<Result<Vec<_>, DynamicsError>>()?;
    let runs: Vec<ErrorStatistics> = runs.into_iter().flatten().collect();
    let span = |f: fn(&ErrorStatistics) -> f64| {
        let (low, high) =
            runs.iter().map(f).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        if runs.is_empty() { 0.0 } else { high - low }
    };
    let (mean, rms) = (span(|s| s.mean), span(|s| s.rms));
    let band = runs.iter().map(|s| s.max_abs).fold(0.0, f64::max);
    Ok(StartSpread { mean, rms, band, runs })
}

/// STE and DTE at every wear state, with all runs in parallel; order and values are identical for any number of
/// threads.
///
/// # Errors
/// The first error in the order of the wear states; [`DynamicsError::Cancelled`] if `progress` says so.
pub fn transmission_error_study(
    machine: &Machine,
    wear: &[Relief],
    settings: &StudySettings,
    progress: &dyn Progress,
) -> Result<TransmissionErrorStudy, DynamicsError> {
    study(wear, settings, progress, |wear, load| {
        IdealJoints::new(machine, wear, settings.drive.clone(), load, settings.drag)
    })
}

/// [`transmission_error_study`] with elastic discs.
///
/// # Errors
/// As there, and of [`FlexibleJoints::new`].
pub fn flexible_transmission_error_study(
    machine: &Machine,
    discs: &FlexibleDiscs,
    options: FlexibleOptions,
    wear: &[Relief],
    settings: &StudySettings,
    progress: &dyn Progress,
) -> Result<TransmissionErrorStudy, DynamicsError> {
    study(wear, settings, progress, |wear, load| {
        FlexibleJoints::new(
            machine,
            discs.clone(),
            wear,
            settings.drive.clone(),
            load,
            settings.drag,
            options,
        )
    })
}

/// Two runs of a model at every wear state.
fn study<M: Into<Model>>(
    wear: &[Relief],
    settings: &StudySettings,
    progress: &dyn Progress,
    model: impl Fn(&Relief, OutputLoad) -> Result<M, DynamicsError> + Sync,
) -> Result<TransmissionErrorStudy, DynamicsError> {
    let done = Counter::new("simulation", 2 * wear.len(), progress);
    let jobs: Vec<(usize, bool)> = (0..wear.len()).flat_map(|i| [(i, false), (i, true)]).collect();
    let mut results = jobs
        .into_par_iter()
        .map(|(i, loaded)| {
            let model = model(&wear[i], if loaded { settings.load.clone() } else { OutputLoad::None })?;
            let mut run = Run::new(model, settings.plan, progress)?;
            run.finish(progress)?;
            let spread = if !loaded && settings.perturbed_starts > 0 {
                let unseen = Unseen(progress);
                Some(spread_over_starts(run.model(), settings.plan, settings.perturbed_starts, &unseen)?)
            } else {
                None
            };
            done.one_more();
            Ok((run.result(), spread))
        })
        .collect::<Result<Vec<_>, DynamicsError>>()?
        .into_iter();
    let mut points = Vec::with_capacity(wear.len());
    while let (Some((no_load, spread)), Some((loaded, _))) = (results.next(), results.next()) {
        points.push(StudyPoint { no_load, loaded, spread });
    }
    Ok(TransmissionErrorStudy { points })
}
