//! Effects of the uncertain inputs of a drive of eccentrics, for the bands of `life`.

use super::bearings::{FEW_POSITIONS, lives_by_stage};
use super::made::{Made, MadeOptions};
use super::meshing::for_evaluation;
use super::{AnyDesign, EccentricDrive};
use crate::analyses::life::{BandResults, Inputs, LOADED, states_of};
use crate::analyses::{AnalysisError, Host};
use crate::design::Value;
use crate::life::{Prediction, WholeDrive, WornState};
use crate::machine::WearCoefficient;
use crate::units::{ARCMIN, MPA};
use crate::wear::{CoupledOptions, CoupledWear};

/// Effects of the inputs of a drive on all quantities with limits; `predictions` are given ring by ring.
///
/// # Errors
/// As [`Inputs::evaluate`].
pub(super) fn inputs_of<D: EccentricDrive>(
    made: &Made<D>,
    options: &MadeOptions,
    predictions: &[Prediction],
    host: &dyn Host,
) -> Result<Inputs, AnalysisError> {
    let by_ring: Vec<Vec<&WornState>> = predictions.iter().map(states_of).collect();
    let stations: Vec<f64> = by_ring[0].iter().map(|state| state.hours).collect();
    // A ring whose wear ran away has fewer states.
    let times = by_ring.iter().map(Vec::len).min().unwrap_or(0);
    let states: Vec<Vec<WornState>> =
        (0..times).map(|time| by_ring.iter().map(|states| states[time].clone()).collect()).collect();
    let any = made.design.any();
    // A separate finding reports ranges that exclude the value of the design.
    let free = any.with("unknowns", Value::LeftOut).unwrap_or_else(|_| any.clone());
    let results_of = |moved: &AnyDesign| match D::of_any(moved) {
        Some(moved) => at(&made.like(moved, options, host)?, &states).map(Some),
        None => Ok(None),
    };
    Inputs::evaluate(any.unknowns(), (&free, &at(made, &states)?), stations, results_of, host)
}

/// Results of a drive in states of wear of all its rings. The lost motion grows by the mean rate of wear of the flanks
/// over the largest lever arm of the pins.
fn at<D: EccentricDrive>(
    Made { design, discs, .. }: &Made<D>,
    states: &[Vec<WornState>],
) -> Result<BandResults, AnalysisError> {
    let failed = || AnalysisError::wear("compute the effects of the uncertain inputs on the life");
    let mut whole = for_evaluation(design.wearing_rings(discs)?);
    let mut results = BandResults::of_rings(whole.cases.len());
    let with_travel = design.limits().backlash.is_some();
    for states in states {
        results.lost_motion.push(whole.lost_motion(states).map_err(failed())? / ARCMIN);
        let found = whole.evaluate(states, LOADED, with_travel).map_err(failed())?;
        for (pressures, (accuracy, _)) in results.pressure.iter_mut().zip(&found) {
            pressures.push(accuracy.max_pressure / MPA);
        }
        // Errors and travel are those of the drive in every ring.
        if let Some((accuracy, travel)) = found.first() {
            results.transmission_error.push(accuracy.loaded_peak_to_peak.arcmin());
            results.backlash.extend(travel.map(|travel| travel.free_travel.arcmin()));
        }
    }
    let middle = &states[states.len() / 2];
    let rings = whole.cases.iter().zip(&whole.meshings).zip(whole.factors.iter().zip(middle));
    let mut wear = 0.0;
    for ((case, meshing), (of_ring, state)) in rings {
        // A calibrated coefficient gives the same wear for any other inputs.
        if let WearCoefficient::Given(coefficient) = case.wear.coupled {
            let rate = CoupledWear::with(case.clone(), meshing.clone(), CoupledOptions::default())
                .mean_rate(&state.surfaces)
                .map_err(failed())?;
            wear += coefficient * rate * of_ring.error.abs() / case.profile.largest_lever_arm();
        }
    }
    results.wear = wear;
    let lives = lives_by_stage(design, discs, FEW_POSITIONS)?;
    let worst = lives.iter().flatten().map(|life| life.life_h).fold(f64::INFINITY, f64::min);
    if worst.is_finite() {
        results.bearing = worst;
    }
    Ok(results)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyses::NoHost;
    use crate::analyses::life::LimitKind;
    use crate::analyses::stage::life::{Options, StageLife, run};
    use crate::design::{StageDesign, TwoRingDesign, TwoStageDesign};

    /// As for RV reducers: with one input at either end of its range the hours are those of a complete life of this drive.
    /// Wear is a multiple of that of the template, so that the limit of lost motion is reached.
    fn bands_are_those_of_whole_lives<D: EccentricDrive>(
        (text, coefficient): (&str, &str),
        inputs: &[(&str, f64, f64, f64)],
    ) {
        let text =
            &text.replace("coefficient_per_pa = 1e-18", &format!("coefficient_per_pa = {coefficient}"));
        let options = Options::parse("points = 6\ndiscs = \"rigid\"", "test").unwrap();
        let life = |any: &AnyDesign| run(D::of_any(any).unwrap(), &options, &NoHost).unwrap();
        let free = AnyDesign::parse(text, "test").unwrap();
        let plain = life(&free);
        assert!(
            plain.verdict.band.is_none() && plain.verdict.limits.iter().all(|limit| limit.band.is_none())
        );
        for (key, low, high, tolerance) in inputs {
            let one = format!("{text}\n[unknowns]\n\"{key}\" = {{ low = {low:e}, high = {high:e} }}\n");
            let found = life(&AnyDesign::parse(&one, "test").unwrap());
            let ends = [low, high].map(|value| life(&free.with(key, *value).unwrap()));
            for kind in [LimitKind::LostMotion, LimitKind::BearingLife] {
                let hours = |life: &StageLife| life.verdict.limit(kind).unwrap().hours;
                let band = found.verdict.limit(kind).unwrap().band.clone().unwrap();
                let (a, b) = (hours(&ends[0]).unwrap(), hours(&ends[1]).unwrap());
                let (least, most) = (a.min(b), a.max(b));
                println!("{key} {kind:?}: {least:.1} {most:.1} {band:?}");
                // The band covers nine tenths of the range: its ends are slightly inside those of the range.
                let inside = 1.0 + 0.12 * (most / least - 1.0);
                let (low, high) = (band.low.unwrap(), band.high.unwrap());
                assert!(
                    low > least * (1.0 - tolerance) && low < least * inside * (1.0 + tolerance),
                    "{key} {kind:?}"
                );
                assert!(
                    high < most * (1.0 + tolerance) && high > most / inside * (1.0 - tolerance),
                    "{key} {kind:?}"
                );
                assert_eq!(band.hangs_on.is_some(), most / least > 1.012, "{key} {kind:?}: {band:?}");
            }
        }
    }

    #[test]
    #[ignore = "long"]
    fn bands_of_a_single_stage_are_those_of_whole_lives() {
        let text = crate::templates::find_drive("nema17-19").unwrap().text;
        bands_are_those_of_whole_lives::<StageDesign>(
            (text, "2e-17"),
            &[
                ("bearings.eccentric.clearance_um", 5.5, 6.4, 0.08),
                ("wear.coupled.coefficient_per_pa", 1e-17, 4e-17, 0.03),
            ],
        );
    }

    /// A coefficient that both stages have, and an input of the first stage alone.
    #[test]
    #[ignore = "long"]
    fn bands_of_two_stages_are_those_of_whole_lives() {
        let text = crate::templates::find_drive("two-stage-500").unwrap().text;
        bands_are_those_of_whole_lives::<TwoStageDesign>(
            (text, "1e-16"),
            &[
                ("wear.coupled.coefficient_per_pa", 5e-17, 2e-16, 0.03),
                ("bearings.eccentric.clearance_um", 4.0, 12.0, 0.08),
            ],
        );
    }

    /// A coefficient that both rings have, and the clearance of the only bearing.
    #[test]
    #[ignore = "long"]
    fn bands_of_two_rings_are_those_of_whole_lives() {
        let text = crate::templates::find_drive("two-ring-225").unwrap().text;
        bands_are_those_of_whole_lives::<TwoRingDesign>(
            (text, "2e-18"),
            &[
                ("wear.coupled.coefficient_per_pa", 1e-18, 4e-18, 0.03),
                ("bearings.eccentric.clearance_um", 6.0, 10.0, 0.08),
            ],
        );
    }
}
