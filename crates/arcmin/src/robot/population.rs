//! Robots whose reducers are drawn from the tolerances of their designs.

use rayon::prelude::*;

use super::figures::{Figures, Sorted, Tool};
use super::joint::JointModel;
use super::life::{Measured, live};
use super::read::RobotFile;
use super::run::{Before, Robot, ages_of, measured, of_joint};
use super::tool::{Field, Places};
use crate::analyses::{AnalysisError, Host};
use crate::design::{Design, OptionSet};
use crate::fidelity::FidelityOptions;
use crate::progress::Counter;

/// All robots, new and at the planned hours.
#[derive(Debug, Clone)]
pub struct Population {
    pub seed: u64,
    pub robots: Vec<[Figures; 2]>,
    /// Axes whose design gives no tolerances, or whose table none: the same in every robot.
    pub alike: Vec<String>,
}

/// A drawn joint is measured at fewer places: its figures are taken from twenty of them.
const POSITIONS: usize = 3;
const ERROR_POSITIONS: usize = 256;

/// Draws all robots; `None` where none were asked for. Joints that are finished are kept in the host's cache, so that a
/// run that was stopped goes on.
///
/// # Errors
/// As for the nominal joints.
pub(super) fn population(
    file: &RobotFile,
    before: &[Before<'_>],
    models: &[JointModel],
    (places, sorted, moving): (&Places, &Sorted, &[f64]),
    robot: &Robot,
    host: &dyn Host,
) -> Result<Option<Population>, AnalysisError> {
    let Some(section) = &*file.population else { return Ok(None) };
    let (count, seed) = (*section.robots, *section.seed as u64);
    let axes = models.len();
    let drawn = |axis: usize| before[axis].design().filter(|design| design.drawing_tolerances().is_some());
    let jobs: Vec<(usize, usize, &Design)> = (0..count)
        .flat_map(|number| (0..axes).map(move |axis| (number, axis)))
        .filter_map(|(number, axis)| Some((number, axis, drawn(axis)?)))
        .collect();
    let done = Counter::new("drawn joints", jobs.len(), host);
    let found: Vec<((usize, usize), JointModel)> = jobs
        .par_iter()
        .map(|(number, axis, design)| {
            let joint = &before[*axis];
            let on = joint.on_duty(design, robot.planned, *file.model.moments_in_wear)?;
            let words = measured(file)?.fidelity.canonical();
            let kept: Vec<&str> = words
                .lines()
                .filter(|line| !line.starts_with("errors") && !line.starts_with("seed"))
                .collect();
            let drawing = format!(
                "{}\nerrors = \"drawn\"\nseed = {}\n",
                kept.join("\n"),
                (seed + (number * axes + axis) as u64) % 9_007_199_254_740_991
            );
            let measured = Measured {
                fidelity: FidelityOptions::parse(&drawing, "the section [population]")?,
                ages: 2,
                positions: POSITIONS,
                error_positions: ERROR_POSITIONS,
            };
            let name = &robot.joints[*axis].axis;
            let life = live(&on, &measured, joint.duty.rows.is_empty(), host)
                .map_err(|error| of_joint(name, error))?;
            let ages = ages_of(name, &life.export)?;
            Ok(done.after(|| ((*number, *axis), JointModel { ages, ..models[*axis].clone() })))
        })
        .collect::<Result<_, AnalysisError>>()?;
    let mut found = found.into_iter().peekable();
    let mut robots = Vec::with_capacity(count);
    for number in 0..count {
        let mut joints = models.to_vec();
        while let Some((place, joint)) = found.next_if(|((of, _), _)| *of == number) {
            joints[place.1] = joint;
        }
        let field = Field::of(places, &joints, moving, robot.compensates);
        let tool = Tool { places, sorted, field: &field };
        robots.push([0.0, robot.planned].map(|hours| tool.figures(&vec![hours; axes])));
    }
    let alike = (0..axes).filter(|axis| drawn(*axis).is_none()).map(|axis| robot.joints[axis].axis.clone());
    Ok(Some(Population { seed, robots, alike: alike.collect() }))
}

impl Population {
    /// Share `share` of the robots is below this.
    pub fn quantile(&self, age: usize, share: f64, of: fn(&Figures) -> f64) -> f64 {
        let mut values: Vec<f64> = self.robots.iter().map(|robot| of(&robot[age])).collect();
        values.sort_by(f64::total_cmp);
        let at = share * (values.len() - 1) as f64;
        let (low, part) = (at.floor() as usize, at.fract());
        let high = (low + 1).min(values.len() - 1);
        values[low] + part * (values[high] - values[low])
    }
}
