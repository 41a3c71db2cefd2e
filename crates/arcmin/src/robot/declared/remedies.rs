//! Tables of the remedies: overhauls, corrections for the controller, changes of the program.

use super::{JOINT, PATH, POSITION, REPEATABILITY, ROBOT_HOURS};
use crate::design::Choice;
use crate::results::{PLAIN, Table, TableOf, decimals, digits, quantity};
use crate::robot::answers::OverhaulGain;
use crate::robot::compensation::{self, Entry, Remaining, WaveEntry};
use crate::robot::figures::Figures;
use crate::robot::levers::Lever;
use crate::robot::run::{Robot, ToolAnswer};
use crate::robot::variants::VariantAnswer;
use crate::units::{ARCMIN, DEG, MM};

pub(super) struct OverhaulRow(String, OverhaulGain, Option<f64>);

pub(super) const OVERHAULS: TableOf<OverhaulRow> = TableOf {
    name: "overhauls",
    what: "Gain by the overhaul of one reducer",
    columns: || {
        vec![
            JOINT.of(|r: &OverhaulRow| r.0.clone().into()),
            quantity(
                "overhaul_h",
                decimals(0),
                "Hours of the robot at the overhaul: those of `overhaul_h`. By default the hours at which the first \
                     limit is reached, or half of the planned hours if none is reached.",
            )
            .of(|r| r.1.overhaul.hours.into()),
            quantity(
                "hours_to_limit",
                decimals(0),
                "Hours at which a limit is then exceeded; empty if none is within the planned hours.",
            )
            .of(|r| r.1.end.into()),
            quantity("gained_h", decimals(0), "Hours gained, up to the planned hours.")
                .of(|r| r.2.into()),
            quantity("position_error_mm", decimals(3), "Pose accuracy at the planned hours with this overhaul.")
                .of(|r| (r.1.position / MM).into()),
            quantity("repeatability_mm", decimals(3), "Repeatability at the planned hours with this overhaul.")
                .of(|r| (r.1.repeatability / MM).into()),
        ]
    },
};

pub(super) const PLAN: TableOf<(String, f64)> = TableOf {
    name: "plan",
    what: "Plan with the fewest overhauls that keeps all limits over the planned hours",
    columns: || {
        vec![
            quantity("overhaul_h", decimals(0), "Hours of the robot.").of(|r: &(String, f64)| r.1.into()),
            JOINT.of(|r| r.0.clone().into()),
        ]
    },
};

pub(super) struct LeverRow(String, Lever);

pub(super) const LEVERS: TableOf<LeverRow> = TableOf {
    name: "levers",
    what: "Displacement of the tool by an arc-minute of every joint",
    columns: || {
        vec![
            JOINT.of(|r: &LeverRow| r.0.clone().into()),
            quantity("lever_mm", decimals(1), "Largest distance of the tool from the axis at a test pose.")
                .of(|r| (r.1.lever / MM).into()),
            quantity("lever_mm_per_arcmin", decimals(4), "The same for each arc-minute.")
                .of(|r| (r.1.lever * ARCMIN / MM).into()),
            quantity(
                "position_gain_mm_per_arcmin",
                decimals(4),
                "Gain of the pose accuracy at the planned hours for each arc-minute by which the error of the joint \
                     is reduced.",
            )
            .of(|r| (r.1.position * ARCMIN / MM).into()),
            quantity(
                "repeatability_gain_mm_per_arcmin",
                decimals(4),
                "Repeatability with this joint alone for each arc-minute of its scatter.",
            )
            .of(|r| (r.1.repeatability * ARCMIN / MM).into()),
        ]
    },
};

pub(super) const COMPENSATION: TableOf<Entry> = TableOf {
    name: "compensation",
    what: "Mean error of every joint over load and direction, for a controller",
    columns: || {
        vec![
            JOINT.of(|r: &Entry| r.joint.clone().into()),
            ROBOT_HOURS.of(|r| r.hours.into()),
            quantity(
                "outer_torque_n_m",
                decimals(1),
                "External torque on the output: the reaction of the torque on the link.",
            )
            .of(|r| r.torque.into()),
            quantity("torque_is", PLAIN, "Whether the torque was `rising` or `falling`.")
                .of(|r| if r.rises { "rising" } else { "falling" }.into()),
            quantity(
                "error_arcmin",
                decimals(4),
                "Output angle less motor angle / ratio; subtract it from the commanded angle.",
            )
            .of(|r| (r.error / ARCMIN).into()),
        ]
    },
};

pub(super) const WAVES: TableOf<WaveEntry> = TableOf {
    name: "compensation_waves",
    what: "Transmission error of every joint over its angle, as waves, for a controller",
    columns: || {
        vec![
            JOINT.of(|r: &WaveEntry| r.joint.clone().into()),
            ROBOT_HOURS.of(|r| r.hours.into()),
            quantity("outer_torque_n_m", decimals(1), "External torque on the output.")
                .of(|r| r.torque.into()),
            quantity("order", PLAIN, "Waves per turn of the joint.").of(|r| r.order.into()),
            quantity("amplitude_arcmin", digits(4), "Of cos(order × joint angle + phase).")
                .of(|r| (r.amplitude / ARCMIN).into()),
            quantity("phase_deg", decimals(2), "Phase at joint angle 0.").of(|r| (r.phase / DEG).into()),
        ]
    },
};

pub(super) struct RemainsRow(&'static str, f64, Figures);

pub(super) const REMAINS: TableOf<RemainsRow> = TableOf {
    name: "remains",
    what: "Remaining errors under each kind of compensation",
    columns: || {
        vec![
            quantity(
                "compensates",
                PLAIN,
                "Compensation by the controller: `none`, `stiffness`, or the whole \
                 `table` of the new joints.",
            )
            .of(|r: &RemainsRow| r.0.into()),
            ROBOT_HOURS.of(|r| r.1.into()),
            POSITION.of(|r| (r.2.position / MM).into()),
            REPEATABILITY.of(|r| (r.2.repeatability / MM).into()),
            PATH.of(|r| (r.2.path / MM).into()),
        ]
    },
};

pub(super) struct VariantRow(VariantAnswer, Option<String>);

pub(super) const VARIANTS: TableOf<VariantRow> = TableOf {
    name: "variants",
    what: "Effect of changes of the program; hours of the joints are scaled from those of the unchanged robot",
    columns: || {
        vec![
            quantity("variant", PLAIN, "Name of the variant.").of(|r: &VariantRow| r.0.name.clone().into()),
            quantity("cycles_share", digits(3), "Cycles an hour as a share of those given.")
                .of(|r| r.0.cycles.into()),
            quantity(
                "torque_share",
                digits(3),
                "Largest torque relative to the unchanged robot, of the axis with the largest increase.",
            )
            .of(|r| r.0.hardest.1.into()),
            POSITION.of(|r| (r.0.figures.position / MM).into()),
            REPEATABILITY.of(|r| (r.0.figures.repeatability / MM).into()),
            PATH.of(|r| (r.0.figures.path / MM).into()),
            quantity(
                "hours_to_limit",
                decimals(0),
                "Hours until the first limit is exceeded; empty if none is.",
            )
            .of(|r| r.0.end.map(|end| end.hours).into()),
            quantity("limited_by", PLAIN, "Axis with the largest share in the error at that time.")
                .of(|r| r.1.clone().into()),
        ]
    },
};

impl Robot {
    fn axis_name(&self, axis: usize) -> String {
        self.joints[axis].axis.clone()
    }

    /// Hours in motion of every joint for each hour of the robot.
    fn moving(&self) -> Vec<f64> {
        self.joints.iter().map(|joint| joint.duty.moving).collect()
    }

    pub(super) fn overhaul_table(&self, tool: &ToolAnswer) -> Table {
        let until = self.hours_to_limit();
        let row = |gain: &OverhaulGain| {
            let gained = until.map(|until| gain.end.unwrap_or(self.planned) - until);
            OverhaulRow(self.axis_name(gain.overhaul.axis), *gain, gained)
        };
        OVERHAULS.fill(tool.overhauls.iter().map(row).collect::<Vec<_>>().iter())
    }

    pub(super) fn lever_table(&self, tool: &ToolAnswer) -> Table {
        let levers = tool.levers.iter().enumerate();
        let rows: Vec<LeverRow> =
            levers.map(|(axis, lever)| LeverRow(self.axis_name(axis), *lever)).collect();
        LEVERS.fill(rows.iter())
    }

    pub(super) fn compensation_table(&self, tool: &ToolAnswer) -> Table {
        COMPENSATION.fill(compensation::table(&tool.joints, &self.moving()).iter())
    }

    pub(super) fn wave_table(&self, tool: &ToolAnswer) -> Table {
        WAVES.fill(compensation::waves(&tool.joints, &self.moving()).iter())
    }

    pub(super) fn remains_table(&self, tool: &ToolAnswer) -> Table {
        let rows = |kind: &Remaining| {
            let word = kind.compensates.word();
            [RemainsRow(word, 0.0, kind.new), RemainsRow(word, self.planned, kind.end)]
        };
        REMAINS.fill(tool.remaining.iter().flat_map(rows).collect::<Vec<_>>().iter())
    }

    /// None without a plan or a limit.
    pub(super) fn plan_table(&self) -> Option<Table> {
        let (plan, _) = self.plan()?;
        let rows: Vec<(String, f64)> = plan.iter().map(|one| (self.axis_name(one.axis), one.hours)).collect();
        Some(PLAN.fill(rows.iter()))
    }

    /// None without variants.
    pub(super) fn variant_table(&self, tool: &ToolAnswer) -> Option<Table> {
        let row = |variant: &VariantAnswer| {
            VariantRow(variant.clone(), variant.end.map(|end| self.axis_name(end.axis)))
        };
        let rows: Vec<VariantRow> = tool.variants.iter().map(row).collect();
        (!rows.is_empty()).then(|| VARIANTS.fill(rows.iter()))
    }
}
