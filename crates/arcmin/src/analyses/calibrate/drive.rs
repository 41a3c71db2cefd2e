//! Trait of drives of any family that can be calibrated.

use crate::analyses::life::{self, LifeVerdict};
use crate::analyses::stage::AnyDesign;
use crate::analyses::{AnalysisError, Host, OnlyResults};
use crate::design::Design;
use crate::fidelity::{Fidelity, FidelityOptions};
use crate::life::{WornState, lost_motion_causes};
use crate::machine::{Limits, Machine, Wear};
use crate::wear::{Fit, FitPlan, GrowingRing, Growth, Readings, follow_and_fit};

/// A drive whose wear coefficient is fitted to readings.
pub(in crate::analyses) trait CalibratedDrive {
    fn name(&self) -> String;

    /// With the value of the selected limit.
    fn limits(&self) -> Limits;

    /// Laws of wear; the coefficient in them is not used.
    ///
    /// # Errors
    /// [`AnalysisError::Usage`] where the design gives none.
    fn wear(&self) -> Result<Wear, AnalysisError>;

    /// Sentence about the models used.
    fn physics(&self) -> String;

    /// Lost motion (rad) of the new drive by its design.
    ///
    /// # Errors
    /// [`AnalysisError`] where no balance is found.
    fn new_lost_motion(&self) -> Result<f64, AnalysisError>;

    /// Computes the growth and fits it to the readings.
    ///
    /// # Errors
    /// [`AnalysisError`]; `Stopped` when `host` was cancelled.
    fn fit(
        &self,
        readings: &Readings,
        plan: &FitPlan,
        host: &dyn Host,
    ) -> Result<(Growth, Fit), AnalysisError>;

    /// The design as its file gives it.
    fn design(&self) -> AnyDesign;

    /// Result of `life` of this design of the same family.
    ///
    /// # Errors
    /// [`AnalysisError`] of the prediction.
    fn verdict(&self, design: &AnyDesign, host: &dyn Host) -> Result<LifeVerdict, AnalysisError>;
}

pub(in crate::analyses) const FIT: &str = "fit the wear coefficient";

/// An RV reducer.
pub(super) struct Reducer<'a> {
    pub design: &'a Design,
    /// With the value of the selected limit.
    pub machine: Machine,
    pub fidelity: Fidelity,
    pub options: &'a FidelityOptions,
}

impl CalibratedDrive for Reducer<'_> {
    fn name(&self) -> String {
        self.machine.name.clone()
    }

    fn limits(&self) -> Limits {
        self.machine.limits
    }

    fn wear(&self) -> Result<Wear, AnalysisError> {
        Ok(self.machine.wear.clone())
    }

    fn physics(&self) -> String {
        self.fidelity.sentence()
    }

    fn new_lost_motion(&self) -> Result<f64, AnalysisError> {
        let in_bearings = self.fidelity.in_bearings(&self.machine)?;
        let causes = lost_motion_causes(&self.machine, in_bearings, &WornState::new())
            .map_err(AnalysisError::wear("find the lost motion of the new machine"))?;
        Ok(causes.lost_motion.whole)
    }

    fn fit(
        &self,
        readings: &Readings,
        plan: &FitPlan,
        host: &dyn Host,
    ) -> Result<(Growth, Fit), AnalysisError> {
        let meshing = self.fidelity.meshing(&self.machine)?;
        let new_on = |clock: &crate::wear::Exposure| GrowingRing::new(&self.machine, meshing.clone(), clock);
        follow_and_fit(&self.machine.wear, new_on, readings, plan, host).map_err(AnalysisError::wear(FIT))
    }

    fn design(&self) -> AnyDesign {
        AnyDesign::from(self.design.clone())
    }

    fn verdict(&self, design: &AnyDesign, host: &dyn Host) -> Result<LifeVerdict, AnalysisError> {
        let options = life::Options {
            fidelity: self.options.clone(),
            ..life::Options::parse("quasi_static = true\npoints = 12", "calibrate")?
        };
        let design = design.rv("calibrate")?;
        Ok(life::run(design, &options, &OnlyResults { host, results: &["verdict"] })?.drive.verdict)
    }
}
