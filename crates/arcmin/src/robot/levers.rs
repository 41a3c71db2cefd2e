//! Displacement of the tool by each axis, and gains of its figures by a better joint.

use super::figures::Tool;

/// Effect of an axis on the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lever {
    /// Largest distance of the tool from the axis over the test poses, m.
    pub lever: f64,
    /// Decrease of pose accuracy and repeatability at the planned hours per rad by which the error of the axis,
    /// or its lost motion, is reduced: m/rad.
    pub position: f64,
    pub repeatability: f64,
}

/// By differences: decrease of the figure without the axis, divided by the mean error of the axis in rad.
pub(super) fn levers(tool: &Tool<'_>, planned: f64) -> Vec<Lever> {
    let hours = vec![planned; tool.field.axes()];
    let (visit, size) = tool.worst_visit(&hours);
    let moved = tool.field.tool(tool.places, &hours, visit)[0];
    let along = if size > 0.0 { moved / size } else { moved };
    let alone = tool.repeatability_by_axis(&hours);
    let (pose, _) = tool.worst_pose(&hours);
    (0..tool.field.axes())
        .map(|axis| {
            let at = |place: usize| {
                let posture = &tool.places.places[place].posture;
                posture.moved_by(axis, &posture.axes[axis], 0.0)[0]
            };
            let lever = tool.sorted.visits.iter().map(|(place, _)| at(*place).norm()).fold(0.0, f64::max);
            let approaches = &tool.sorted.approaches[pose];
            let turns: Vec<f64> = approaches
                .iter()
                .map(|place| tool.field.at(axis, planned, *place).about.iter().sum::<f64>())
                .collect();
            let spread = turns.iter().copied().fold(f64::NEG_INFINITY, f64::max)
                - turns.iter().copied().fold(f64::INFINITY, f64::min);
            Lever {
                lever,
                position: at(visit).dot(&along).abs(),
                repeatability: if spread > 0.0 { alone[axis] / spread } else { 0.0 },
            }
        })
        .collect()
}
