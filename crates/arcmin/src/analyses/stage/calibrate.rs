//! Wear coefficient of a drive of eccentrics from readings of real drives, with their remaining hours.

use std::ops::Deref;

use super::findings::ring_of;
use super::keys::main_of;
use super::made::{Made, MadeOptions};
use super::meshing::{WearingRing, for_evaluation};
use super::wear::physics;
use super::{AnyDesign, EccentricDrive, StageBodies, StageJoints, life, not_for};
use crate::analyses::calibrate::{self, CalibratedDrive, Calibration, ReadingOptions};
use crate::analyses::life::LifeVerdict;
use crate::analyses::{AnalysisError, Attachment, Host, OnlyResults, Outcome, TextBlock};
use crate::design::{Stated, default_word, options};
use crate::fidelity::{DiscBodies, ErrorSource};
use crate::life::{GrowingRings, StageFollower, WholeDrive, WornState};
use crate::machine::{Limits, PartWearLaws, Wear};
use crate::report::Page;
use crate::results::{DeclaredTable, Summary, SummaryOf, Table};
use crate::wear::{Exposure, Fit, FitPlan, Growth, Readings, follow_and_fit};

pub(crate) const ABOUT: &str = calibrate::ABOUT;

options! {
    /// Options of `calibrate` for a single stage.
    pub struct Options {
        [readings: ReadingOptions]
        /// Model of the cycloid discs. Left out: elastic, where the drive has a model of elastic discs and they leave room for a
        /// mesh.
        discs: Stated<DiscBodies> => default_word("elastic"),
        /// Joints.
        joints: StageJoints => default_word("bearings"),
        /// Bodies.
        bodies: StageBodies => default_word("rigid"),
    }
}

/// A fitted coefficient. Depths are those of the ring whose keys have no prefix; lost motion is that of the drive, with output
/// pins and holes worn by the same coefficient.
#[derive(Debug, Clone)]
pub struct StageCalibrated(Calibration);

impl Deref for StageCalibrated {
    type Target = Calibration;

    fn deref(&self) -> &Calibration {
        &self.0
    }
}

pub(crate) const SUMMARY: SummaryOf<StageCalibrated> =
    SummaryOf { entries: calibrate::entries::<StageCalibrated> };

pub(crate) fn tables() -> Vec<DeclaredTable> {
    calibrate::tables()
}

/// A drive with the value of the selected limit, and the drive of the file.
struct Asked<'a, D> {
    design: &'a D,
    made: Made<D>,
    discs: Stated<DiscBodies>,
    limits: Limits,
}

/// Fits the coefficient.
///
/// # Errors
/// As [`calibrate::run`]; [`AnalysisError::Usage`] where the design gives no wear.
pub fn run<D: EccentricDrive>(
    design: &D,
    options: &Options,
    host: &dyn Host,
) -> Result<StageCalibrated, AnalysisError> {
    let limits = match options.readings.change()? {
        Some((key, value)) => design.any().with(key, value)?.limits(),
        None => design.limits(),
    };
    let discs = options.discs;
    // The readings are those of real drives, not of the one whose errors the design gives.
    let nominal = MadeOptions { discs, errors: Some(ErrorSource::None), ..MadeOptions::default() };
    let made = design.as_made(&nominal, host)?;
    let calibration = calibrate::of_drive(&Asked { design, made, discs, limits }, &options.readings, host)?;
    Ok(StageCalibrated(calibration))
}

impl<D: EccentricDrive> Asked<'_, D> {
    /// Rings with new bearings: their wear has a coefficient of its own.
    fn rings(&self) -> Result<Vec<WearingRing>, AnalysisError> {
        let mut rings = self.made.design.wearing_rings(&self.made.discs)?;
        rings.iter_mut().for_each(|ring| ring.case.wear.parts = PartWearLaws::default());
        Ok(rings)
    }
}

impl<D: EccentricDrive> CalibratedDrive for Asked<'_, D> {
    fn name(&self) -> String {
        self.design.name().to_owned()
    }

    fn limits(&self) -> Limits {
        self.limits
    }

    fn wear(&self) -> Result<Wear, AnalysisError> {
        let mut rings = self.made.design.wearing_rings(&self.made.discs)?;
        Ok(rings.swap_remove(main_of(D::STAGES)).case.wear)
    }

    fn physics(&self) -> String {
        physics(D::STAGES, ring_of(self.design), &self.made.fidelity)
    }

    fn new_lost_motion(&self) -> Result<f64, AnalysisError> {
        let mut whole = for_evaluation(self.rings()?);
        let new = vec![WornState::new(); whole.cases.len()];
        whole.lost_motion(&new).map_err(AnalysisError::wear("find the lost motion of the new drive"))
    }

    fn fit(
        &self,
        readings: &Readings,
        plan: &FitPlan,
        host: &dyn Host,
    ) -> Result<(Growth, Fit), AnalysisError> {
        let exposures = Exposure { coefficient: 1.0, running_in: None };
        let rings = self.rings()?;
        let parts = |ring: &WearingRing| {
            let (parts, case, meshing) = (ring.parts.clone(), ring.case.clone(), ring.meshing.clone());
            (parts, case, meshing)
        };
        let parts: Vec<_> = rings.iter().map(parts).collect();
        let whole = for_evaluation(rings);
        let new_on = |clock: &Exposure| {
            let followers = parts.iter().cloned();
            let followers =
                followers.map(|(parts, case, meshing)| StageFollower::new(parts, case, meshing, exposures));
            GrowingRings::new(whole.clone(), followers.collect(), main_of(D::STAGES), clock)
        };
        follow_and_fit(&self.wear()?, new_on, readings, plan, host)
            .map_err(AnalysisError::wear(calibrate::FIT))
    }

    fn design(&self) -> AnyDesign {
        self.design.any()
    }

    fn verdict(&self, design: &AnyDesign, host: &dyn Host) -> Result<LifeVerdict, AnalysisError> {
        let mut options = life::Options::parse("points = 12", "calibrate")?;
        options.made.discs = self.discs;
        let host = &OnlyResults { host, results: &["verdict"] };
        let design = D::of_any(design).ok_or_else(|| not_for("calibrate", design.family(), &[]))?;
        Ok(life::run(design, &options, host)?.verdict.clone())
    }
}

impl Outcome for StageCalibrated {
    fn summary(&self) -> Summary {
        SUMMARY.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        calibrate::fill(self)
    }

    fn text_blocks(&self) -> Vec<TextBlock> {
        calibrate::text_blocks(self)
    }

    fn page(&self) -> Page {
        calibrate::page(self)
    }

    fn attachments(&self) -> Result<Vec<Attachment>, AnalysisError> {
        Ok(self.calibrated_design())
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyses::NoHost;
    use crate::design::{StageDesign, TwoRingDesign, TwoStageDesign};
    use crate::templates::{NEMA17_19, TWO_RING_225, TWO_STAGE_500};
    use crate::units::{ARCMIN, UM};

    /// Output pins without rollers, which wear their holes by the same coefficient.
    fn sliding(coefficient: f64) -> StageDesign {
        let design = StageDesign::parse(NEMA17_19.text, "test.toml").unwrap();
        design
            .with_all([
                ("output_pins.roller_radius_mm", 2.0),
                ("output_pins.pin_radius_mm", 2.0),
                ("wear.pin_ratio", 0.3),
                ("wear.coupled.coefficient_per_pa", coefficient),
            ])
            .unwrap()
    }

    /// Readings of lost motion and depth are computed by `life` with a known coefficient. The fit gives this coefficient within
    /// its band, the hours to the limit are those of the life, and the attachment is the design with the coefficient.
    fn gives_back<D: EccentricDrive>(design: &D, known: f64) {
        let other = design.any().with("wear.coupled.coefficient_per_pa", 20.0 * known).unwrap();
        let other = D::of_any(&other).unwrap();
        let life = life::run(design, &life::Options::parse("points = 4", "test").unwrap(), &NoHost).unwrap();
        let points = &life.prediction.points;
        let lost: Vec<String> = points[1..]
            .iter()
            .map(|point| format!("\"{}h={:.6}arcmin\"", point.hours(), point.lost_motion.arcmin()))
            .collect();
        let depth: Vec<String> = points[1..]
            .iter()
            .map(|point| format!("\"{}h={:.6}um\"", point.hours(), point.accuracy.max_depth / UM))
            .collect();
        let new = points[0].lost_motion.arcmin();
        let limit = 0.5 * (points[2].lost_motion.arcmin() + points[3].lost_motion.arcmin());
        let asked = format!("limit = \"lost_motion={limit:.6}\"\nreading_error_percent = 5");
        for readings in [
            format!("reading = [{}]\nnew_arcmin = {new:.6}\n{asked}", lost.join(", ")),
            format!("reading = [{}]\n{asked}", depth.join(", ")),
        ] {
            let found = run(other, &Options::parse(&readings, "test").unwrap(), &NoHost).unwrap();
            let summary = found.summary();
            let number = |key: &str| summary.number(key).unwrap_or_else(|| panic!("{key}: {readings}"));
            let k = number("wear_coefficient_per_pa");
            println!("{} {k:e} of {known:e}, rms {}", design.name(), number("relative_rms"));
            assert!((k / known - 1.0).abs() < 0.03, "{k:e} {known:e}\n{readings}");
            let [low, high] = ["low", "high"].map(|end| number(&format!("wear_coefficient_{end}_per_pa")));
            assert!(low < known && known < high && high < 1.5 * low, "{low:e} {high:e}");
            assert!((found.lives[0].new / ARCMIN / new - 1.0).abs() < 1e-3, "{new} {:?}", found.lives[0]);
            let hours = found.headline_machine().hours.unwrap();
            let [before, after] = [2, 3].map(|number| points[number].hours());
            assert!(0.97 * before < hours && hours < 1.03 * after, "{before} {hours} {after}");
            let kinds: Vec<&str> = found.limits.iter().map(|limit| limit.kind.key()).collect();
            assert!(kinds.contains(&"contact_pressure") && kinds.contains(&"bearing_life"), "{kinds:?}");
            let text = String::from_utf8(found.attachments().unwrap().swap_remove(0).bytes).unwrap();
            let pasted = AnyDesign::parse(&text, "pasted.toml").unwrap();
            let pasted = D::of_any(&pasted).unwrap().wear().unwrap().coupled;
            assert!(
                matches!(pasted, crate::machine::WearCoefficient::Given(value) if (value / k - 1.0).abs() < 1e-4)
            );
        }
    }

    /// Flanks of the first stage that have worn by tenths of a millimetre into the shape of its pins: a reading in this
    /// range is fitted, and a life with the fitted coefficient reproduces it. A reading beyond the model is an error.
    #[test]
    #[ignore = "long"]
    fn readings_of_deep_wear_are_fitted_or_refused_with_the_place() {
        let design = TwoStageDesign::parse(TWO_STAGE_500.text, "test.toml").unwrap();
        let rigid = "discs = \"rigid\"";
        let asked =
            |reading: &str| Options::parse(&format!("reading = [\"{reading}\"]\n{rigid}"), "test").unwrap();
        let found = run(&design, &asked("500h=20arcmin"), &NoHost).unwrap().summary();
        let k = found.number("wear_coefficient_per_pa").unwrap();
        let fitted = design
            .with_all([("wear.coupled.coefficient_per_pa", k), ("limits.service_life_h", 500.0)])
            .unwrap();
        let life = life::run(
            &fitted,
            &life::Options::parse(&format!("points = 4\n{rigid}"), "test").unwrap(),
            &NoHost,
        )
        .unwrap();
        let lost = life.last().lost_motion.arcmin();
        assert!((lost / 20.0 - 1.0).abs() < 0.02, "{k:e}: {lost}");
        let error = run(&design, &asked("500h=90arcmin"), &NoHost).unwrap_err().to_string();
        assert!(error.contains("of ring 1 of 2 from the input have lost 5"), "{error}");
    }

    #[test]
    #[ignore = "long"]
    fn a_known_coefficient_of_a_single_stage_comes_back() {
        gives_back(&sliding(2e-18), 2e-18);
    }

    #[test]
    #[ignore = "long"]
    fn a_known_coefficient_of_two_rings_comes_back() {
        let design = TwoRingDesign::parse(TWO_RING_225.text, "test.toml").unwrap();
        gives_back(&design, 1e-18);
    }

    #[test]
    #[ignore = "long"]
    fn a_known_coefficient_of_two_stages_comes_back() {
        let design = TwoStageDesign::parse(TWO_STAGE_500.text, "test.toml").unwrap();
        gives_back(&design, 1e-18);
    }

    /// Holes wear with the flanks: without their wear the same lost motion would need another coefficient.
    #[test]
    #[ignore = "long"]
    fn holes_have_a_part_in_the_growth() {
        let design = sliding(2e-18);
        let reading = "reading = [\"1500h=+3arcmin\"]";
        let options = Options::parse(reading, "test").unwrap();
        let with = run(&design, &options, &NoHost).unwrap().fit.law.coefficient;
        let rolling = design.with_all([("output_pins.pin_radius_mm", 1.5), ("wear.pin_ratio", 0.0)]).unwrap();
        let without = run(&rolling, &options, &NoHost).unwrap().fit.law.coefficient;
        assert!(without > 1.1 * with, "{with:e} {without:e}");
    }

    #[test]
    fn readings_that_cannot_be_used_are_refused() {
        let design = sliding(2e-18);
        for (options, words) in [
            ("", "there is no reading to fit"),
            ("reading = [\"1500h=1e-3arcmin\"]", "there is no wear to fit"),
            ("reading = [\"1500h=3\"]", "has no unit"),
            ("reading = [\"1500h=+3arcmin\"]\nlimit = \"lostmotion\"", "no limit is called"),
        ] {
            let error = run(&design, &Options::parse(options, "test").unwrap(), &NoHost).unwrap_err();
            assert!(error.to_string().contains(words), "{options}: {error}");
        }
        let text = NEMA17_19.text.replace("[wear.coupled]\ncoefficient_per_pa = 1e-18 ", "# ");
        let bare = StageDesign::parse(&text, "test.toml").unwrap();
        let options = Options::parse("reading = [\"1500h=+3arcmin\"]", "test").unwrap();
        let error = run(&bare, &options, &NoHost).unwrap_err();
        assert!(error.to_string().contains("no wear coefficient"), "{error}");
    }
}
