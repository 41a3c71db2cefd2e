//! The summary of a robot.

use super::{DIRECTIONS, DISTANCE, ORIENTATION, PATH, POSITION, REPEATABILITY};
use crate::design::Choice;
use crate::results::{PLAIN, SummaryOf, Value, decimals, quantity};
use crate::robot::answers::{Overhaul, ToolLimit};
use crate::robot::figures::{Figure, Figures};
use crate::robot::run::{JointAnswer, Robot};
use crate::robot::tool::CAUSES;
use crate::units::{DEG, MM};

/// The figures of a robot.
pub const SUMMARY: SummaryOf<Robot> = SummaryOf {
    entries: || {
        vec![
            POSITION.named("tool.position_error_mm").of(|r: &Robot| r.last().map(|f| f.position / MM).into()),
            ORIENTATION
                .named("tool.orientation_error_deg")
                .of(|r| r.last().map(|f| f.orientation / DEG).into()),
            REPEATABILITY
                .named("tool.repeatability_mm")
                .of(|r| r.last().map(|f| f.repeatability / MM).into()),
            DIRECTIONS
                .named("tool.directional_variation_mm")
                .of(|r| r.last().map(|f| f.directions / MM).into()),
            DISTANCE.named("tool.distance_error_mm").of(|r| r.last().map(|f| f.distance / MM).into()),
            PATH.named("tool.path_error_mm").of(|r| r.last().map(|f| f.path / MM).into()),
            quantity("new.position_error_mm", decimals(3), "Pose accuracy of the new robot.")
                .of(|r| r.first().map(|f| f.position / MM).into()),
            quantity("new.repeatability_mm", decimals(3), "Repeatability of the new robot.")
                .of(|r| r.first().map(|f| f.repeatability / MM).into()),
            quantity("new.path_error_mm", decimals(3), "Path accuracy of the new robot.")
                .of(|r| r.first().map(|f| f.path / MM).into()),
            quantity("planned_hours", decimals(0), "Planned hours of the robot.")
                .of(|r| r.planned.into()),
            quantity(
                "hours_to_limit",
                decimals(0),
                "Hours until the first limit at the tool is exceeded; absent if none is within the planned hours.",
            )
            .of(|r| r.hours_to_limit().into()),
            quantity("limited_by", PLAIN, "Joint with the largest share in the figure at that time.")
                .of(|r| r.end.map(|end| r.joints[end.axis].axis.clone()).into()),
            quantity("verdict.ok", PLAIN, "Whether the tool keeps all limits over the planned hours.")
                .of(|r| r.tool.as_ref().map(|_| r.end.is_none()).into()),
            quantity("verdict.limited_by", PLAIN, "Figure that exceeds its limit first.")
                .of(|r| r.end.map(|end| end.limit.figure.word()).into()),
            quantity(
                "verdict.limits",
                PLAIN,
                "Every limit with its value at the planned hours: `{limit, value, \
                 allowed, hours}`, in mm, orientation in °.",
            )
            .of(Robot::judged),
            quantity("limited_by_cause", PLAIN, "Cause with the largest share of that joint.")
                .of(|r| r.end.map(|end| CAUSES[end.cause]).into()),
            quantity(
                "limit",
                PLAIN,
                "Figure that exceeds its limit first: position, orientation, repeatability, path.",
            )
            .of(|r| r.end.map(|end| end.limit.figure.word()).into()),
            quantity(
                "plan.overhauls",
                PLAIN,
                "Number of overhauls of the plan that keeps all limits over the planned hours; absent without a \
                     plan or limit.",
            )
            .of(|r| r.plan().map(|(plan, _)| plan.len()).into()),
            quantity(
                "plan.fewest",
                PLAIN,
                "Whether no plan with fewer overhauls exists, provided that reducers only get worse.",
            )
            .of(|r| r.plan().map(|(_, fewest)| *fewest).into()),
            quantity("overhaul_first", PLAIN, "Joint that the plan overhauls first.").of(|r| {
                r.plan().and_then(|(plan, _)| plan.first()).map(|one| r.joints[one.axis].axis.clone()).into()
            }),
            quantity(
                "bearing_l10_h",
                decimals(0),
                "Shortest L10 of the bearings, in hours of the robot.",
            )
            .of(|r| r.shortest_bearing().map(|(_, _, hours)| hours).into()),
            quantity("bearing_joint", PLAIN, "Joint of that bearing.")
                .of(|r| r.shortest_bearing().map(|(axis, _, _)| axis).into()),
            quantity(
                "population.position_error_mm",
                PLAIN,
                "Pose accuracy at the planned hours: 5 %, 50 % and 95 % quantile of the drawn robots.",
            )
            .of(|r| r.band(|f| f.position / MM)),
            quantity("population.repeatability_mm", PLAIN, "The same for repeatability.")
                .of(|r| r.band(|f| f.repeatability / MM)),
            quantity("compensates", PLAIN, "Compensation by the controller.")
                .of(|r| r.compensates.word().into()),
            quantity("notes", PLAIN, "Inputs beyond the measured range.")
                .of(|r| Value::list(r.notes.iter().cloned())),
            quantity("stages", PLAIN, "Wall seconds of the stages.")
                .of(|r| Value::Record(r.stages.iter().map(|(name, s)| (*name, (*s).into())).collect())),
        ]
    },
};

impl Robot {
    pub(in crate::robot) fn first(&self) -> Option<Figures> {
        Some(self.tool.as_ref()?.figures.first()?.1)
    }

    pub(in crate::robot) fn last(&self) -> Option<Figures> {
        Some(self.tool.as_ref()?.figures.last()?.1)
    }

    pub(in crate::robot) fn plan(&self) -> Option<&(Vec<Overhaul>, bool)> {
        self.tool.as_ref()?.plan.as_ref().filter(|_| !self.limits.is_empty())
    }

    /// Joint, bearing and hours.
    pub(in crate::robot) fn shortest_bearing(&self) -> Option<(String, String, f64)> {
        let of = |joint: &JointAnswer| {
            joint.bearing.as_ref().map(|(name, hours)| (joint.axis.clone(), name.clone(), *hours))
        };
        self.joints.iter().filter_map(of).min_by(|a, b| a.2.total_cmp(&b.2))
    }

    fn judged(&self) -> Value {
        let Some(tool) = &self.tool else { return Value::Absent };
        let (mapped, ages) = (tool.mapped(), vec![self.planned; self.joints.len()]);
        let one = |limit: &ToolLimit| {
            let unit = if limit.figure == Figure::Orientation { DEG } else { MM };
            let end = mapped.end(&[*limit], &[], (0.0, self.planned));
            Value::Record(vec![
                ("limit", limit.figure.word().into()),
                ("value", (mapped.figure(limit.figure, &ages) / unit).into()),
                ("allowed", (limit.allowed / unit).into()),
                ("hours", end.map(|end| end.hours).into()),
            ])
        };
        Value::List(self.limits.iter().map(one).collect())
    }

    fn band(&self, of: fn(&Figures) -> f64) -> Value {
        match self.tool.as_ref().and_then(|tool| tool.population.as_ref()) {
            Some(population) => Value::list([0.05, 0.5, 0.95].map(|share| population.quantile(1, share, of))),
            None => Value::Absent,
        }
    }
}
