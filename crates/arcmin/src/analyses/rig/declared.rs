//! Tables and figures of the bench.

use super::Rig;
use crate::analyses::causes;
use crate::analyses::errors_table;
use crate::analyses::simulate::orders_value;
use crate::dynamics::{Part, SpectrumLine};
use crate::fidelity::Fidelity;
use crate::results::{
    Column, DeclaredTable, PLAIN, Quantity, SummaryOf, Table, TableOf, Value, decimals, digits,
    quantities as q, quantity,
};
use crate::rig::{
    BearingLoad, EfficiencyMap, ErrorCurve, HeatBalance, LoopFigures, LoopPoint, MeasuredCurve,
    MeasuredOnBench, NamedOrder, PinLoads, RigState, RunningTorques, Steady,
};
use crate::units::{ARCMIN, DEG, MPA, RPM, UM};

const LOOP: TableOf<(usize, LoopPoint)> = TableOf {
    name: "hysteresis",
    what: "One row per point of a hysteresis loop",
    columns: || {
        vec![
            q::TORQUE.of(|(_, p): &(usize, LoopPoint)| p.torque.into()),
            quantity("angle_arcmin", decimals(4), "Angle of the output, input locked.")
                .of(|(_, p)| (p.angle / ARCMIN).into()),
            quantity("branch", PLAIN, "falling or rising torque.").of(|(_, p)| p.branch.word().into()),
            quantity("position", PLAIN, "Crank position of the loop, counted from 0.")
                .of(|(i, _)| (*i).into()),
        ]
    },
};

const SPECTRUM: TableOf<SpectrumLine> = TableOf {
    name: "spectrum",
    what: "One row per spectral line of the transmission error at rated torque, forward",
    columns: || {
        vec![
            q::ORDER.of(|line: &SpectrumLine| line.order.into()),
            q::AMPLITUDE.of(|line| (line.amplitude / ARCMIN).into()),
        ]
    },
};

/// Direction, torque, angle and error.
type ErrorPoint = (f64, f64, (f64, f64));

const ERRORS: TableOf<ErrorPoint> = TableOf {
    name: "te",
    what: "One row per position of the output: transmission error",
    columns: || {
        vec![
            quantity("output_angle_deg", decimals(3), "Angle of the output.")
                .of(|(_, _, (angle, _)): &ErrorPoint| (angle / DEG).into()),
            q::TE.of(|(_, _, (_, error))| (error / ARCMIN).into()),
            quantity("direction", PLAIN, "1 forward, −1 backward.")
                .of(|(direction, _, _)| (*direction).into()),
            q::TORQUE.of(|(_, torque, _)| (*torque).into()),
        ]
    },
};

/// A part with its compliance in rad/(N·m) and the whole.
type Compliance = (Part, f64, f64);

const STIFFNESS: TableOf<Compliance> = TableOf {
    name: "stiffness",
    what: "One row per part of the torsional compliance at rated torque",
    columns: || {
        vec![
            q::PART.of(|(part, _, _): &Compliance| part.name().into()),
            quantity("compliance_arcmin_per_n_m", digits(4), "Part of the output's wind-up per torque.")
                .of(|(_, compliance, _)| (compliance / ARCMIN).into()),
            quantity("share", decimals(4), "Share of the whole compliance.")
                .of(|(_, compliance, whole)| (compliance / whole).into()),
        ]
    },
};

const BEARINGS: TableOf<BearingLoad> = TableOf {
    name: "bearings",
    what: "One row per bearing, at rated torque and speed",
    columns: || {
        vec![
            q::BEARING.of(|b: &BearingLoad| b.name.as_str().into()),
            quantity("mean_radial_force_n", decimals(0), "Mean radial force over a crank turn.")
                .of(|b| b.mean_force().into()),
            quantity("largest_element_force_n", decimals(0), "Largest force on one rolling element.")
                .of(|b| b.largest_element.into()),
            quantity(
                "axial_force_n",
                decimals(0),
                "Largest axial force between the tapered supports of a crankshaft; 0 for all other bearings.",
            )
            .of(|b| b.axial.into()),
            quantity(
                "equivalent_load_n",
                decimals(0),
                "Equivalent dynamic load P over a crank turn (ISO 281).",
            )
            .of(|b| b.equivalent.into()),
            quantity("rating_n", decimals(0), "Basic dynamic load rating C, given or by ISO 281.")
                .of(|b| b.rating.into()),
            quantity("l10_h", decimals(0), "Basic rating life L10 at rated torque and speed.")
                .of(|b| b.life_h().into()),
        ]
    },
};

/// Place over a crank turn, bearing, force.
type BearingForce = (f64, String, f64);

const BEARING_FORCES: TableOf<BearingForce> = TableOf {
    name: "bearing_forces",
    what: "One row per bearing and crank angle: radial force",
    columns: || {
        vec![
            q::CRANK_ANGLE.of(|(angle, _, _): &BearingForce| (*angle).into()),
            q::BEARING.of(|(_, name, _)| name.clone().into()),
            quantity("radial_force_n", decimals(1), "Radial force of the bearing.")
                .of(|(_, _, force)| (*force).into()),
        ]
    },
};

/// Speed in rad/s, torque, efficiency.
type EfficiencyAt = (f64, f64, f64);

const EFFICIENCY: TableOf<EfficiencyAt> = TableOf {
    name: "efficiency",
    what: "One row per input speed and output torque: efficiency",
    columns: || {
        vec![
            quantity("input_speed_rpm", decimals(0), "Speed of the input.")
                .of(|(speed, _, _): &EfficiencyAt| (speed / RPM).into()),
            q::TORQUE.of(|(_, torque, _)| (*torque).into()),
            q::EFFICIENCY.of(|(_, _, efficiency)| (*efficiency).into()),
        ]
    },
};

const NO_LOAD: Quantity =
    quantity("no_load_running_torque_n_m", digits(3), "Torque at the input that turns the machine unloaded.");
const NO_LOAD_AT_OUTPUT: Quantity = quantity(
    "no_load_at_output_n_m",
    digits(3),
    "Running torque of the unloaded machine at the input, times the ratio, as in catalogues.",
);

/// Input speed in rad/s, torque at the input, and the ratio.
type NoLoadAt = (f64, f64, f64);

const RUNNING_TORQUES: TableOf<NoLoadAt> = TableOf {
    name: "running_torques",
    what: "One row per speed: torque of the unloaded machine",
    columns: || {
        vec![
            quantity("input_speed_rpm", decimals(0), "Speed of the input.")
                .of(|(speed, _, _): &NoLoadAt| (speed / RPM).into()),
            quantity("output_speed_rpm", decimals(2), "Speed of the output.")
                .of(|(speed, _, ratio)| (speed / RPM / ratio).into()),
            NO_LOAD.of(|(_, torque, _)| (*torque).into()),
            NO_LOAD_AT_OUTPUT.of(|(_, torque, ratio)| (torque * ratio).into()),
        ]
    },
};

pub(crate) fn tables() -> Vec<DeclaredTable> {
    vec![
        LOOP.into(),
        SPECTRUM.into(),
        ERRORS.into(),
        STIFFNESS.into(),
        BEARINGS.into(),
        BEARING_FORCES.into(),
        EFFICIENCY.into(),
        RUNNING_TORQUES.into(),
        causes::TABLE.into(),
        errors_table::TABLE.into(),
    ]
}

pub(super) fn fill(rig: &Rig) -> Vec<Table> {
    let state = rig.state();
    let loops: Vec<(usize, LoopPoint)> = state
        .loops
        .iter()
        .enumerate()
        .flat_map(|(position, points)| points.iter().map(move |point| (position, *point)))
        .collect();
    let errors: Vec<ErrorPoint> = state
        .curves
        .iter()
        .flat_map(|curve| curve.points.iter().map(|point| (curve.direction, curve.torque, *point)))
        .collect();
    let split: Vec<Compliance> =
        state.split.parts.iter().map(|(part, c)| (*part, *c, state.split.whole)).collect();
    let forces: Vec<BearingForce> = state
        .bearings
        .iter()
        .flat_map(|b| {
            let angle = |i: usize| 360.0 * i as f64 / b.forces.len() as f64;
            b.forces.iter().enumerate().map(move |(i, force)| (angle(i), b.name.clone(), *force))
        })
        .collect();
    let row = |map: &EfficiencyMap| -> Vec<EfficiencyAt> {
        let rows = map.speeds.iter().zip(&map.efficiency);
        rows.flat_map(|(speed, row)| {
            map.torques.iter().zip(row).map(move |(torque, e)| (*speed, *torque, *e))
        })
        .collect()
    };
    let efficiency = state.efficiency.as_ref().map_or_else(Vec::new, row);
    let ratio = rig.machine.kinematics().ratio().abs();
    let over_speed = |torques: &RunningTorques| -> Vec<NoLoadAt> {
        torques.over_speed.iter().map(|(speed, torque)| (*speed, *torque, ratio)).collect()
    };
    let no_load = state.torques.as_ref().map_or_else(Vec::new, over_speed);
    let mut tables = vec![
        LOOP.fill(&loops),
        SPECTRUM.fill(&state.spectrum),
        ERRORS.fill(&errors),
        STIFFNESS.fill(&split),
        BEARINGS.fill(&state.bearings),
        BEARING_FORCES.fill(&forces),
        EFFICIENCY.fill(&efficiency),
        RUNNING_TORQUES.fill(&no_load),
        causes::TABLE.fill(&rig.causes_at()),
    ];
    tables.extend(errors_table::table(&rig.fidelity));
    tables
}

/// A figure of the loop: quantity, its value in a state, and in a measured loop with its uncertainty.
pub(super) struct Figure {
    pub quantity: Quantity,
    pub new: Quantity,
    pub measured: Quantity,
    pub uncertainty: Quantity,
    pub of: fn(&RigState) -> f64,
    pub of_loop: fn(&LoopFigures) -> f64,
}

/// Figures for the comparison of new, worn and measured machines.
pub(super) const FIGURES: &[Figure] = &[
    Figure {
        quantity: q::LOST_MOTION,
        new: q::LOST_MOTION.named("new.lost_motion_arcmin"),
        measured: q::LOST_MOTION.named("measured.lost_motion_arcmin"),
        uncertainty: uncertain("measured.lost_motion_uncertainty_arcmin"),
        of: |s| s.lost_motion() / ARCMIN,
        of_loop: |f| f.lost_motion / ARCMIN,
    },
    Figure {
        quantity: q::BACKLASH,
        new: q::BACKLASH.named("new.backlash_arcmin"),
        measured: q::BACKLASH.named("measured.backlash_arcmin"),
        uncertainty: uncertain("measured.backlash_uncertainty_arcmin"),
        of: |s| s.backlash() / ARCMIN,
        of_loop: |f| f.backlash / ARCMIN,
    },
    Figure {
        quantity: q::STIFFNESS,
        new: q::STIFFNESS.named("new.stiffness_n_m_per_arcmin"),
        measured: q::STIFFNESS.named("measured.stiffness_n_m_per_arcmin"),
        uncertainty: uncertain("measured.stiffness_uncertainty_n_m_per_arcmin"),
        of: |s| s.stiffness() * ARCMIN,
        of_loop: |f| f.stiffness * ARCMIN,
    },
    Figure {
        quantity: q::SOFT_STIFFNESS,
        new: q::SOFT_STIFFNESS.named("new.soft_stiffness_n_m_per_arcmin"),
        measured: q::SOFT_STIFFNESS.named("measured.soft_stiffness_n_m_per_arcmin"),
        uncertainty: uncertain("measured.soft_stiffness_uncertainty_n_m_per_arcmin"),
        of: |s| s.soft_stiffness() * ARCMIN,
        of_loop: |f| f.soft_stiffness * ARCMIN,
    },
    Figure {
        quantity: q::MIDDLE_STIFFNESS,
        new: q::MIDDLE_STIFFNESS.named("new.middle_stiffness_n_m_per_arcmin"),
        measured: q::MIDDLE_STIFFNESS.named("measured.middle_stiffness_n_m_per_arcmin"),
        uncertainty: uncertain("measured.middle_stiffness_uncertainty_n_m_per_arcmin"),
        of: |s| s.middle_stiffness() * ARCMIN,
        of_loop: |f| f.middle_stiffness * ARCMIN,
    },
];

const fn uncertain(key: &'static str) -> Quantity {
    quantity(key, digits(2), "Half width of the 95 % interval of the measured value.")
}

/// A figure over the measured loops, and the half width of its 95 % interval.
pub(super) fn measured(rig: &Rig, index: usize) -> Option<(f64, f64)> {
    rig.measured.as_ref()?.figure(FIGURES[index].of_loop)
}

fn measured_curves(curves: &[MeasuredCurve]) -> Value {
    let one = |c: &MeasuredCurve| {
        Value::Record(vec![
            ("direction", c.curve.direction.into()),
            ("torque_n_m", c.curve.torque.into()),
            ("mean_arcmin", (c.curve.mean() / ARCMIN).into()),
            ("mean_uncertainty_arcmin", (c.mean_uncertainty / ARCMIN).into()),
            ("peak_to_peak_arcmin", (c.peak_to_peak / ARCMIN).into()),
            ("peak_to_peak_uncertainty_arcmin", (c.peak_to_peak_uncertainty / ARCMIN).into()),
        ])
    };
    Value::List(curves.iter().map(one).collect())
}

fn measured_orders(bench: &MeasuredOnBench) -> Value {
    let one = |(named, uncertainty): &(NamedOrder, f64)| {
        Value::Record(vec![
            ("order", named.order.into()),
            ("amplitude_arcmin", (named.amplitude / ARCMIN).into()),
            ("uncertainty_arcmin", (uncertainty / ARCMIN).into()),
            ("cause", Value::from(named.cause.clone())),
        ])
    };
    Value::List(bench.orders.iter().map(one).collect())
}

fn curves_value(curves: &[ErrorCurve]) -> Value {
    let one = |c: &ErrorCurve| {
        Value::Record(vec![
            ("direction", c.direction.into()),
            ("torque_n_m", c.torque.into()),
            ("mean_arcmin", (c.mean() / ARCMIN).into()),
            ("peak_to_peak_arcmin", (c.peak_to_peak() / ARCMIN).into()),
        ])
    };
    Value::List(curves.iter().map(one).collect())
}

fn torque(rig: &Rig, of: fn(&RunningTorques) -> f64) -> Value {
    Value::from(rig.state().torques.as_ref().map(of))
}

/// Loads of the pins over one turn of the output (the full period) at rated torque, forward.
fn pins(rig: &Rig, of: fn(&PinLoads) -> f64) -> Value {
    Value::from(rig.state().forward_at_rated().and_then(|curve| curve.pins.as_ref()).map(of))
}

fn heat(rig: &Rig, of: fn(&HeatBalance) -> f64) -> Value {
    Value::from(rig.state().heat.as_ref().map(of))
}

/// Absent if there is no steady temperature.
fn steady(rig: &Rig, of: fn(&Steady) -> f64) -> Value {
    Value::from(rig.state().heat.as_ref().and_then(|heat| heat.steady.as_ref()).map(of))
}

pub(crate) const SUMMARY: SummaryOf<Rig> = SummaryOf {
    entries: || {
        let mut entries: Vec<Column<Rig>> = Vec::new();
        for (index, figure) in FIGURES.iter().enumerate() {
            entries.push(Column::numbered(figure.quantity, index, |o: &Rig, i| {
                (FIGURES[i].of)(o.state()).into()
            }));
            entries.push(Column::numbered(figure.new, index, |o: &Rig, i| (FIGURES[i].of)(&o.new).into()));
            entries.push(Column::numbered(figure.measured, index, |o: &Rig, i| {
                measured(o, i).map(|(value, _)| value).into()
            }));
            entries.push(Column::numbered(figure.uncertainty, index, |o: &Rig, i| {
                measured(o, i).map(|(_, uncertainty)| uncertainty).into()
            }));
        }
        entries.extend([
            q::HOURS.of(|o: &Rig| o.state().hours.into()),
            q::EFFICIENCY.of(|o| Value::from(o.state().efficiency.as_ref().map(|map| map.rated))),
            q::EFFICIENCY.named("new.efficiency").of(|o| Value::from(o.new.efficiency.as_ref().map(|map| map.rated))),
            quantity("friction_assumed", PLAIN, "Whether the design gives no friction and some was assumed.")
                .of(|o| o.friction_assumed.into()),
            NO_LOAD
            .of(|o| torque(o, |torques| torques.no_load)),
            NO_LOAD_AT_OUTPUT
            .of(|o| {
                let ratio = o.machine.kinematics().ratio().abs();
                Value::from(o.state().torques.as_ref().map(|torques| torques.no_load * ratio))
            }),
            quantity(
                "starting_torque_n_m",
                digits(3),
                "Starting torque of the unloaded machine at the input.",
            )
            .of(|o| torque(o, |torques| torques.starting)),
            quantity(
                "back_driving_torque_n_m",
                digits(3),
                "Back-driving torque at the output.",
            )
            .of(|o| torque(o, |torques| torques.back_driving)),
            quantity(
                "te_rated_peak_to_peak_arcmin",
                decimals(3),
                "Peak to peak of the transmission error at rated torque, forward.",
            )
            .of(|o| Value::from(o.state().forward_at_rated().map(|curve| curve.peak_to_peak() / ARCMIN))),
            quantity(
                "te_held_peak_to_peak_arcmin",
                decimals(3),
                "Peak to peak of the transmission error forward, held by 1 % of rated torque.",
            )
            .of(|o| Value::from(o.state().forward_held().map(|curve| curve.peak_to_peak() / ARCMIN))),
            q::MAX_FORCE.of(|o| pins(o, |pins| pins.force)),
            q::MAX_PRESSURE.of(|o| pins(o, |pins| pins.pressure / MPA)),
            quantity("transmission_error", PLAIN, "Mean and peak to peak of every transmission error.")
                .of(|o| curves_value(&o.state().curves)),
            quantity(
                "measured.transmission_error",
                PLAIN,
                "The same for measured curves, with the half widths of the 95 % intervals.",
            )
            .of(|o| o.measured.as_ref().map_or(Value::Absent, |bench| measured_curves(&bench.curves))),
            q::ORDERS.of(|o| orders_value(&o.state().orders)),
            quantity(
                "measured.orders",
                PLAIN,
                "Largest lines of the measured transmission error, with the half widths of the 95 % intervals.",
            )
            .of(|o| o.measured.as_ref().map_or(Value::Absent, measured_orders)),
            quantity(
                "measured.remarks",
                PLAIN,
                "Corrections of the rows of the files: file, lines and a sentence.",
            )
            .of(|o| {
                let remarks = |bench: &MeasuredOnBench| {
                    Value::List(bench.remarks.iter().map(|remark| Value::from(remark.clone())).collect())
                };
                o.measured.as_ref().map_or(Value::Absent, remarks)
            }),
            quantity("shortest_bearing_life_h", decimals(0), "Least basic rating life L10 of all bearings.")
                .of(|o| {
                    Value::from(o.state().bearings.iter().map(BearingLoad::life_h).reduce(f64::min))
                }),
            quantity(
                "main_bearings.moment_stiffness_n_m_per_arcmin",
                digits(4),
                "Moment per tilt of the main bearings under the external forces.",
            )
            .of(|o| (o.main_bearings.moment_stiffness[1] * ARCMIN).into()),
            quantity(
                "main_bearings.axial_stiffness_n_per_um",
                digits(4),
                "Axial force per displacement of the main bearings without external forces.",
            )
            .of(|o| (o.main_bearings.axial_stiffness * UM).into()),
            quantity("main_bearings.tilt_arcmin", decimals(4), "Tilt of the output by forces from outside.")
                .of(|o| (o.main_bearings.tilt / ARCMIN).into()),
            quantity(
                "main_bearings.largest_element_force_n",
                decimals(1),
                "Largest force on one rolling element of the main bearings.",
            )
            .of(|o| o.main_bearings.largest_element.into()),
            quantity(
                "main_bearings.l10_h",
                decimals(0),
                "Basic rating life L10 of the main bearings under preload and external forces (ISO/TS 16281).",
            )
            .of(|o| o.main_bearings.life_h().into()),
            quantity("thermal.viscosity_mpa_s", digits(4), "Viscosity of the oil at the temperature given.")
                .of(|o| heat(o, |heat| heat.viscosity * 1e3)),
            quantity(
                "thermal.film_ratio",
                digits(3),
                "Film ratio at rated torque and speed, mean of all contacts of the loaded half, weighted with their \
                     loads.",
            )
                .of(|o| heat(o, |heat| heat.film_ratio)),
            quantity("thermal.flank_friction", digits(3), "Friction coefficient of the flanks with that film.")
                .of(|o| heat(o, |heat| heat.flank_friction)),
            quantity("thermal.loss_w", digits(4), "Loss at rated torque and speed.")
                .of(|o| heat(o, |heat| heat.loss)),
            quantity(
                "thermal.steady_c",
                decimals(1),
                "Steady temperature at rated torque and speed, at which cooling equals the loss.",
            )
            .of(|o| steady(o, |steady| steady.temperature)),
            quantity("thermal.steady_loss_w", digits(4), "Loss at the steady temperature.")
                .of(|o| steady(o, |steady| steady.loss)),
            quantity("thermal.convection_w", digits(4), "Heat that the surface gives off at the steady temperature.")
                .of(|o| steady(o, |steady| steady.convection)),
            quantity("thermal.conduction_w", digits(4), "Heat into the mounting at the steady temperature.")
                .of(|o| steady(o, |steady| steady.conduction)),
            quantity("wall_s", decimals(2), "Seconds of computation.").of(|o| o.wall.into()),
        ]);
        entries.extend(causes::entries());
        entries.extend(Fidelity::entries());
        entries
    },
};
