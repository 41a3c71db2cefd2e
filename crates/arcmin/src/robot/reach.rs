//! Repeatability over the reach of the arm.

use super::arm::Arm;
use super::figures::{Sorted, Tool};
use super::file::Compensation;
use super::joint::JointModel;
use super::read::Program;
use super::tool::{Field, Places};

/// Postures over the range of the second and third axis, with the others at their means in the programs.
#[derive(Debug, Clone, Default)]
pub struct Reach {
    pub points: Vec<ReachPoint>,
}

/// One posture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReachPoint {
    /// Distance of the tool from the first axis and height above the base, m.
    pub radius: f64,
    pub height: f64,
    /// Repeatability new and at the planned hours, m.
    pub repeatability: [f64; 2],
}

/// Steps over the range of each of the two axes.
const STEPS: usize = 13;
/// Range shown for an axis without limits, rad.
const UNLIMITED: f64 = std::f64::consts::PI;

pub fn reach(
    arm: &Arm,
    joints: &[JointModel],
    moving: &[f64],
    (compensates, approach): (Compensation, f64),
    planned: f64,
    programs: &[Program],
) -> Reach {
    if arm.count() < 3 {
        return Reach::default();
    }
    let mean = |axis: usize| {
        let all = programs.iter().flat_map(|program| &program.motion.angle[axis]);
        let (sum, count) = all.fold((0.0, 0), |(sum, count), angle| (sum + angle, count + 1));
        if count > 0 { sum / f64::from(count) } else { 0.0 }
    };
    let usual: Vec<f64> = (0..arm.count()).map(mean).collect();
    let at = |axis: usize, step: usize| {
        let (low, high) = (arm.axes[axis].lower.max(-UNLIMITED), arm.axes[axis].upper.min(UNLIMITED));
        low + (high - low) * step as f64 / (STEPS - 1) as f64
    };
    let mut postures = Vec::with_capacity(STEPS * STEPS);
    for second in 0..STEPS {
        for third in 0..STEPS {
            let mut angles = usual.clone();
            (angles[1], angles[2]) = (at(1, second), at(2, third));
            postures.push(angles);
        }
    }
    let places = Places::at_rest(arm, &postures, approach);
    let sorted = Sorted::of(&places);
    // Only two ages are needed: new, and those around the planned hours.
    let joints: Vec<JointModel> = joints
        .iter()
        .zip(moving)
        .map(|(joint, moving)| {
            let hours = planned * moving * (1.0 - 1e-9);
            let after = joint.ages.partition_point(|age| age.hours < hours).min(joint.ages.len() - 1);
            let kept = (0..joint.ages.len()).filter(|age| *age == 0 || *age == after || *age + 1 == after);
            JointModel { ages: kept.map(|age| joint.ages[age].clone()).collect(), ..joint.clone() }
        })
        .collect();
    let field = Field::of(&places, &joints, moving, compensates);
    let tool = Tool { places: &places, sorted: &sorted, field: &field };
    let scatter = |pose: usize, hours: f64| {
        let hours = vec![hours; arm.count()];
        tool.repeatability_of(pose, |place| field.tool(&places, &hours, place)[0])
    };
    let points = postures
        .iter()
        .enumerate()
        .map(|(pose, angles)| {
            let posture = arm.posture(angles);
            let (origin, z) = (posture.links[0].position, posture.axes[0]);
            let from = posture.tool.position - origin;
            let height = posture.tool.position.dot(&z);
            ReachPoint {
                radius: (from - from.dot(&z) * z).norm(),
                height,
                repeatability: [scatter(pose, 0.0), scatter(pose, planned)],
            }
        })
        .collect();
    Reach { points }
}
