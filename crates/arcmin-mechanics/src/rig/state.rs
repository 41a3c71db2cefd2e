//! Results of all tests of the bench for one machine.

use rayon::prelude::*;

use super::transmission::{Curves, error_curves_with_progress};
use super::{
    BearingLoad, EfficiencyMap, ErrorCurve, HeatBalance, LoopFigures, LoopPoint, NamedOrder, RigError,
    RunningTorques, StiffnessSplit, TransmissionSettings, bearing_loads, efficiency_map, evaluate_loop,
    heat_balance, hysteresis_loop, name_orders, running_torques, stiffness_split,
};
use crate::dynamics::{JointSettings, SpectrumLine, order_spectrum};
use crate::machine::Machine;
use crate::progress::{Counter, Progress};

/// All results of the bench for one state of the machine.
#[derive(Debug, Clone)]
pub struct RigState {
    /// Running time of the state in h, 0 when new.
    pub hours: f64,
    /// One loop per crank position.
    pub loops: Vec<Vec<LoopPoint>>,
    /// Figures of the loops in the same order.
    pub figures: Vec<LoopFigures>,
    /// Parts of the compliance between 50 % and 100 % of rated torque.
    pub split: StiffnessSplit,
    /// Curves of the transmission error selected by [`Curves`], in its order.
    pub curves: Vec<ErrorCurve>,
    /// Spectrum at rated torque, forward.
    pub spectrum: Vec<SpectrumLine>,
    /// Strongest orders with their causes.
    pub orders: Vec<NamedOrder>,
    /// Efficiency of the running machine; `None` if not chosen.
    pub efficiency: Option<EfficiencyMap>,
    /// No-load running, starting and back-driving torques; `None` if not chosen.
    pub torques: Option<RunningTorques>,
    /// Heat balance; `None` without a temperature in the design.
    pub heat: Option<HeatBalance>,
    /// Loads and lives of the bearings; empty if not chosen.
    pub bearings: Vec<BearingLoad>,
}

impl RigState {
    fn mean(&self, of: fn(&LoopFigures) -> f64) -> f64 {
        self.figures.iter().map(of).sum::<f64>() / self.figures.len().max(1) as f64
    }

    /// Mean lost motion over the crank positions, rad.
    pub fn lost_motion(&self) -> f64 {
        self.mean(|f| f.lost_motion)
    }

    /// Mean backlash over the crank positions, rad.
    pub fn backlash(&self) -> f64 {
        self.mean(|f| f.backlash)
    }

    /// Mean stiffness from 50 % to 100 % of rated torque, N·m/rad.
    pub fn stiffness(&self) -> f64 {
        self.mean(|f| f.stiffness)
    }

    /// Mean stiffness from 3 % to 15 % of rated torque, N·m/rad.
    pub fn soft_stiffness(&self) -> f64 {
        self.mean(|f| f.soft_stiffness)
    }

    /// Mean stiffness from 15 % to 50 % of rated torque, N·m/rad.
    pub fn middle_stiffness(&self) -> f64 {
        self.mean(|f| f.middle_stiffness)
    }

    /// The transmission error forward at rated torque.
    pub fn forward_at_rated(&self) -> Option<&ErrorCurve> {
        forward_at_rated(&self.curves)
    }

    /// The transmission error forward at light load.
    pub fn forward_held(&self) -> Option<&ErrorCurve> {
        let rated = self.forward_at_rated()?.torque;
        self.curves.iter().find(|curve| curve.direction > 0.0 && curve.torque < rated)
    }
}

fn forward_at_rated(curves: &[ErrorCurve]) -> Option<&ErrorCurve> {
    curves.iter().rfind(|curve| curve.direction > 0.0)
}

/// Resolution and scope of the tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RigPlan {
    /// Crank positions of the hysteresis loop.
    pub loop_positions: usize,
    /// Positions over the output turn of the transmission error.
    pub error_positions: usize,
    /// Torques and directions of the transmission error.
    pub curves: Curves,
    /// Whether the loads of the pins are evaluated, forward at rated torque.
    pub pins: bool,
    /// Whether the running machine is tested: efficiency, torques, heat, bearings.
    pub running: bool,
}

/// Crank positions of the bearing loads.
const BEARING_POSITIONS: usize = 72;

impl RigState {
    /// Runs all tests on one state of the machine; `None` when `progress` was cancelled.
    ///
    /// # Errors
    /// [`RigError`] of the first test that fails.
    pub fn measure(
        machine: &Machine,
        settings: &JointSettings,
        hours: f64,
        plan: RigPlan,
        progress: &dyn Progress,
    ) -> Result<Option<RigState>, RigError> {
        let ratio = machine.kinematics().housing_fixed_ratio();
        let turn = std::f64::consts::TAU * ratio / (machine.ring.pin_count as f64 - 1.0);
        let suns: Vec<f64> =
            (0..plan.loop_positions).map(|i| turn * i as f64 / plan.loop_positions as f64).collect();
        let rated = machine.rated.torque.abs();
        let done = Counter::new("hysteresis loops", suns.len(), progress);
        let loops = suns
            .par_iter()
            .map(|sun| {
                if progress.is_cancelled() {
                    Ok(None)
                } else {
                    done.after(|| hysteresis_loop(machine, settings, *sun)).map(Some)
                }
            })
            .collect::<Result<Option<Vec<_>>, _>>()?;
        let Some(loops) = loops else { return Ok(None) };
        let figures =
            loops.iter().map(|points| evaluate_loop(points, rated)).collect::<Result<Vec<_>, _>>()?;
        // Discs with windows have a compliance that depends on the crank position.
        let places = if settings.housing.is_some() { &suns[..] } else { &suns[..suns.len().min(1)] };
        let splits = places
            .par_iter()
            .map(|sun| stiffness_split(machine, settings, *sun))
            .collect::<Result<Vec<_>, _>>()?;
        let split = StiffnessSplit::mean(&splits)
            .ok_or(RigError::BadLoop("a bench needs one crank position at least"))?;
        if progress.is_cancelled() {
            return Ok(None);
        }
        let test =
            TransmissionSettings { positions: plan.error_positions, ..TransmissionSettings::new(machine) };
        let Some(curves) =
            error_curves_with_progress(machine, settings, test, (plan.curves, plan.pins), progress)?
        else {
            return Ok(None);
        };
        let spectrum =
            forward_at_rated(&curves).and_then(|curve| order_spectrum(&curve.points)).unwrap_or_default();
        progress.report("efficiency", 0.0);
        if progress.is_cancelled() {
            return Ok(None);
        }
        let (mut efficiency, mut torques, mut heat, mut bearings) = (None, None, None, Vec::new());
        if plan.running {
            efficiency = Some(efficiency_map(machine, settings)?);
            torques = Some(running_torques(machine, settings)?);
            heat = heat_balance(machine, settings)?;
            bearings = bearing_loads(machine, settings, BEARING_POSITIONS)?;
        }
        Ok(Some(RigState {
            efficiency,
            torques,
            heat,
            bearings,
            orders: name_orders(&spectrum, machine, test.positions, 8),
            hours,
            loops,
            figures,
            split,
            curves,
            spectrum,
        }))
    }
}
