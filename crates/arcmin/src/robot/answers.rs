//! Hours until the tool exceeds its limits, gain by an overhaul, and the plan with the fewest overhauls.

use rayon::prelude::*;

use super::figures::{Figure, Sorted, Tool};

/// A limit of the tool, in m or rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolLimit {
    /// Figure that is limited.
    pub figure: Figure,
    /// Largest value allowed: m, or rad for the orientation.
    pub allowed: f64,
}

/// Time at which the first limit is exceeded, with the limit and the axis and cause of the largest
/// contribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Hours of the robot.
    pub hours: f64,
    /// Limit that is exceeded.
    pub limit: ToolLimit,
    /// Axis with the largest contribution, counted from 0 at the base.
    pub axis: usize,
    /// Its cause: 0 lost motion, 1 wind-up, 2 transmission error, 3 tilt.
    pub cause: usize,
}

/// Overhaul of a reducer, which is as new afterwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overhaul {
    /// Axis, counted from 0 at the base.
    pub axis: usize,
    /// Hours of the robot at the overhaul.
    pub hours: f64,
}

/// Gain by an overhaul of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverhaulGain {
    pub overhaul: Overhaul,
    /// Hours at which a limit is then exceeded; `None` within the planned hours.
    pub end: Option<f64>,
    /// Pose accuracy and repeatability at the planned hours, m.
    pub position: f64,
    pub repeatability: f64,
}

/// Number of steps of the planned hours in the search for a crossing; fewer in the search for a plan.
const STEPS: usize = 60;
const PLAN_STEPS: usize = 8;
/// Number of plans of each length that are kept (beam search): those with the latest crossings.
const BEAM: usize = 32;
/// Largest number of overhauls of a plan.
pub const MOST_OVERHAULS: usize = 8;
/// Number of positions along the paths that are evaluated in the search for a plan: those with the largest
/// errors, new and at the planned hours.
const PLAN_PLACES: usize = 200;

/// Hours of each axis since its reducer was new.
pub fn ages(axes: usize, hours: f64, overhauls: &[Overhaul]) -> Vec<f64> {
    let mut ages = vec![hours; axes];
    for overhaul in overhauls.iter().filter(|overhaul| overhaul.hours <= hours) {
        ages[overhaul.axis] = hours - overhaul.hours;
    }
    ages
}

/// Gains by the overhaul of each axis at the given hours, or, if there are none, when the first limit is
/// reached.
pub(super) fn overhauls(
    tool: &Tool<'_>,
    limits: &[ToolLimit],
    (planned, end): (f64, Option<End>),
    asked: &[f64],
) -> Vec<OverhaulGain> {
    let until = end.map(|end| end.hours);
    let hours = if asked.is_empty() { vec![until.unwrap_or(0.5 * planned)] } else { asked.to_vec() };
    let each =
        hours.iter().flat_map(|hours| (0..tool.field.axes()).map(|axis| Overhaul { axis, hours: *hours }));
    each.map(|overhaul| {
        let then = ages(tool.field.axes(), planned, &[overhaul]);
        // An overhaul after the limit is exceeded is too late.
        let late = until.filter(|until| *until < overhaul.hours);
        let after = || tool.end(limits, &[overhaul], (overhaul.hours, planned)).map(|end| end.hours);
        OverhaulGain {
            overhaul,
            end: late.or_else(after),
            position: tool.figure(Figure::Position, &then),
            repeatability: tool.figure(Figure::Repeatability, &then),
        }
    })
    .collect()
}

impl Tool<'_> {
    /// The limit with the largest ratio of figure to limit at these ages, and that ratio.
    fn used(&self, limits: &[ToolLimit], ages: &[f64]) -> Option<(f64, ToolLimit)> {
        let each = limits.iter().map(|limit| (self.figure(limit.figure, ages) / limit.allowed, *limit));
        each.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The first time from `from` to `planned` at which a limit is exceeded.
    pub fn end(
        &self,
        limits: &[ToolLimit],
        overhauls: &[Overhaul],
        (from, planned): (f64, f64),
    ) -> Option<End> {
        self.end_in_steps(limits, overhauls, (from, planned), STEPS)
    }

    fn end_in_steps(
        &self,
        limits: &[ToolLimit],
        overhauls: &[Overhaul],
        (from, planned): (f64, f64),
        steps: usize,
    ) -> Option<End> {
        let axes = self.field.axes();
        let at = |hours: f64| self.used(limits, &ages(axes, hours, overhauls));
        let step = planned / steps as f64;
        let mut before = from;
        let mut now = from;
        loop {
            if at(now)?.0 > 1.0 {
                break;
            }
            if now >= planned {
                return None;
            }
            before = now;
            now = (((now / step) + 1e-9).floor() * step + step).min(planned);
        }
        // Bisection to a ten-thousandth of the planned hours.
        while now - before > 1e-4 * planned {
            let middle = 0.5 * (before + now);
            if at(middle)?.0 > 1.0 { now = middle } else { before = middle }
        }
        let (_, limit) = at(now)?;
        let (axis, cause) = self.culprit(limit.figure, &ages(axes, now, overhauls));
        Some(End { hours: before, limit, axis, cause })
    }

    /// The fewest overhauls found by which all limits are fulfilled over the planned hours, and whether it is
    /// certain that no plan with fewer exists among plans with overhauls at the times when a limit is reached;
    /// `None` if new reducers exceed the limits or no plan is short enough. Waiting until a limit is reached is
    /// never a disadvantage: after a later overhaul reducers are younger at all later times.
    pub fn plan(&self, limits: &[ToolLimit], planned: f64) -> Option<(Vec<Overhaul>, bool)> {
        let axes = self.field.axes();
        if self.used(limits, &vec![0.0; axes])?.0 > 1.0 {
            return None;
        }
        let Some(first) = self.end(limits, &[], (0.0, planned)) else { return Some((Vec::new(), true)) };
        let sorted = self.farthest(planned);
        let quick = Tool { sorted: &sorted, ..*self };
        let mut open: Vec<(Vec<Overhaul>, f64)> = vec![(Vec::new(), first.hours)];
        let mut complete = true;
        for _ in 0..MOST_OVERHAULS {
            let tries: Vec<Vec<Overhaul>> = open
                .iter()
                .flat_map(|(done, hours)| {
                    // Two overhauls at one time are a set without order.
                    let after =
                        done.last().filter(|last| last.hours == *hours).map_or(0, |last| last.axis + 1);
                    (after..axes).map(move |axis| [&done[..], &[Overhaul { axis, hours: *hours }]].concat())
                })
                .collect();
            let reached: Vec<Option<f64>> = tries
                .par_iter()
                .map(|plan| {
                    let from = plan.last().map_or(0.0, |last| last.hours);
                    quick.end_in_steps(limits, plan, (from, planned), PLAN_STEPS).map(|end| end.hours)
                })
                .collect();
            let mut next: Vec<(Vec<Overhaul>, f64)> = Vec::with_capacity(tries.len());
            for (plan, end) in tries.into_iter().zip(reached) {
                // Plans that fulfil the limits at the positions with the largest errors are checked at all
                // positions.
                match end.or_else(|| Some(self.end(limits, &plan, (0.0, planned))?.hours)) {
                    Some(end) => next.push((plan, end)),
                    None => return Some((plan, complete)),
                }
            }
            next.sort_by(|a, b| b.1.total_cmp(&a.1));
            if next.len() > BEAM {
                complete = false;
                next.truncate(BEAM);
            }
            open = next;
        }
        None
    }

    /// The same positions, with those along the paths that have the largest errors.
    fn farthest(&self, planned: f64) -> Sorted {
        let mut paths = Vec::new();
        for hours in [0.0, planned] {
            let ages = vec![hours; self.field.axes()];
            let mut each: Vec<(usize, f64)> =
                self.sorted.paths.iter().map(|place| (*place, self.off_the_path(&ages, *place))).collect();
            each.sort_by(|a, b| b.1.total_cmp(&a.1));
            paths.extend(each.into_iter().take(PLAN_PLACES).map(|(place, _)| place));
        }
        paths.sort_unstable();
        paths.dedup();
        Sorted { visits: self.sorted.visits.clone(), approaches: self.sorted.approaches.clone(), paths }
    }
}
