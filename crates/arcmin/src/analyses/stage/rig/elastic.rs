//! Stiffness and lost motion with elastic discs, where rigid ones were chosen: the error of that choice.

use super::{Options, Rests, Rig, cycle_angles};
use crate::analyses::stage::EccentricDrive;
use crate::analyses::{AnalysisError, Host};
use crate::fidelity::DiscBodies;
use crate::machine::StageFriction;
use crate::report::significant;
use crate::results::{Column, Value, decimals, digits, quantity};
use crate::rig::{LoopFigures, evaluate_loop};
use crate::units::ARCMIN;

/// Keys of the results.
const KEYS: [&str; 2] = ["elastic_discs.lost_motion_arcmin", "elastic_discs.stiffness_n_m_per_arcmin"];

/// The torque cycles of the same drive with elastic discs.
#[derive(Debug, Clone)]
pub(super) enum WithElasticDiscs {
    /// The discs are elastic or have no such model, or no result needs them.
    NotAsked,
    /// The discs could not be reduced, or a static equilibrium was not found; the reason.
    NotFound(String),
    /// Mean over the positions.
    Found(LoopFigures),
}

impl WithElasticDiscs {
    /// # Errors
    /// [`AnalysisError::Stopped`] where the host stops the run; the results with rigid discs do not depend on this one.
    pub fn of<D: EccentricDrive>(
        design: &D,
        options: &Options,
        friction: &[StageFriction],
        host: &dyn Host,
    ) -> Result<WithElasticDiscs, AnalysisError> {
        if !options.made.rigid_by_choice::<D>() || !KEYS.iter().any(|key| host.needs(key)) {
            return Ok(WithElasticDiscs::NotAsked);
        }
        match cycles(design, options, friction, host) {
            Ok(figures) => Ok(WithElasticDiscs::Found(figures)),
            Err(AnalysisError::Stopped) => Err(AnalysisError::Stopped),
            Err(error) => Ok(WithElasticDiscs::NotFound(error.to_string())),
        }
    }

    pub fn found(&self) -> Option<&LoopFigures> {
        match self {
            WithElasticDiscs::Found(figures) => Some(figures),
            WithElasticDiscs::NotAsked | WithElasticDiscs::NotFound(_) => None,
        }
    }

    /// "With elastic discs: …", or the reason if there is no such result.
    pub fn sentence(&self, rigid: &LoopFigures) -> Option<String> {
        match self {
            WithElasticDiscs::NotAsked => None,
            WithElasticDiscs::NotFound(error) => Some(format!("No result with elastic discs: {error}.")),
            WithElasticDiscs::Found(soft) => Some(format!(
                "With elastic discs: lost motion {:.2}′, stiffness {} N·m/arcmin, {:.2} times that with rigid discs. \
                 Real discs are elastic; without --discs all results are those with elastic discs.",
                soft.lost_motion / ARCMIN,
                significant(soft.stiffness * ARCMIN, 4),
                soft.stiffness / rigid.stiffness
            )),
        }
    }
}

fn cycles<D: EccentricDrive>(
    design: &D,
    options: &Options,
    friction: &[StageFriction],
    host: &dyn Host,
) -> Result<LoopFigures, AnalysisError> {
    let made = design.as_made(&options.made.with_discs(DiscBodies::Elastic), host)?;
    let rests = Rests::new(&made.design, &made.discs, options.hours, host)?;
    let rated = design.rated().torque.abs();
    let each = cycle_angles(&made.design, options.positions).into_iter().enumerate();
    let each = each.map(|(position, angle)| {
        host.report("torque cycle with elastic discs", position as f64 / options.positions as f64);
        let cycle = rests.cycle(angle, friction)?;
        evaluate_loop(&cycle, rated).map_err(AnalysisError::compute("read the torque cycle"))
    });
    Ok(LoopFigures::mean(&each.collect::<Result<Vec<_>, _>>()?))
}

/// The entries of the summary.
pub(super) fn entries() -> Vec<Column<Rig>> {
    fn of(rig: &Rig, of: fn(&LoopFigures) -> f64) -> Value {
        Value::from(rig.elastic.found().map(of))
    }
    let [lost_motion, stiffness] = KEYS;
    vec![
        quantity(
            lost_motion,
            decimals(3),
            "Lost motion of the same drive with elastic discs, if rigid ones were chosen. Else empty.",
        )
        .of(|o| of(o, |figures| figures.lost_motion / ARCMIN)),
        quantity(stiffness, digits(4), "The same: stiffness from 50 to 100 % of rated torque.")
            .of(|o| of(o, |figures| figures.stiffness * ARCMIN)),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::run;
    use super::*;
    use crate::analyses::{NoHost, Outcome};
    use crate::design::StageDesign;
    use crate::templates::NEMA17_19;

    /// A bench with rigid discs adds the results of a bench with elastic ones, which are the default.
    #[test]
    #[ignore = "long"]
    fn elastic_results_are_those_of_their_own_bench() {
        let design = StageDesign::parse(NEMA17_19.text, "test").unwrap();
        let bench = |discs: &str| {
            let options = Options::parse(&format!("positions = 2\nte_positions = 8\n{discs}"), "test");
            run(&design, &options.unwrap(), &NoHost).unwrap().summary()
        };
        let [default, rigid, elastic] = ["", "discs = \"rigid\"", "discs = \"elastic\""].map(bench);
        for key in KEYS {
            let plain = key.strip_prefix("elastic_discs.").unwrap();
            assert_eq!(rigid.number(key), elastic.number(plain), "{key}");
            assert_eq!(default.number(plain), elastic.number(plain), "{key}");
            assert_eq!((default.number(key), elastic.number(key)), (None, None), "{key}");
        }
        assert!(rigid.number(KEYS[1]) < rigid.number("stiffness_n_m_per_arcmin"));
    }
}
