//! Forces of ring pins, output pins and eccentric bearings over a turn of the input.

use std::f64::consts::TAU;

use super::made::{Made, MadeOptions};
use super::{Rests, StageBodies, StageJoints, peak_to_peak};
use crate::analyses::{AnalysisError, Host, Outcome, Said, TextTable};
use crate::design::{Choice, StageDesign, default, default_word, optional, options};
use crate::report::{Axis, Block, KeyFigure, Page, Plot, Provenance, Section, Series, Tone, Verdict};
use crate::results::{
    DeclaredTable, Summary, SummaryOf, Table, TableOf, Value, decimals, digits, quantities as q, quantity,
};
use crate::units::{ARCMIN, DEG, MPA, UM};

pub const ABOUT: &str = "Compute force and pressure of every pin over one turn of the input";

options! {
    /// Options of `contact` for a single stage.
    pub struct Options {
        [made: MadeOptions]
        /// Joints.
        joints: StageJoints => default_word("bearings"),
        /// Bodies.
        bodies: StageBodies => default_word("rigid"),
        /// Hours of service after which the drive is asked, with its wear until then.
        hours: f64 => default(0.0, 0.0, 1e7),
        /// Output torque; positive torque opposes positive output motion. Left out: the rated torque.
        torque_nm: Option<f64> => optional(-1e7, 1e7),
        /// Positions per turn of the input.
        positions: usize => default(360.0, 8.0, 36_000.0),
    }
}

impl Options {
    /// The new drive at rated torque.
    pub fn of_positions(positions: usize) -> Options {
        let (joints, bodies) = (StageJoints::Bearings, StageBodies::Rigid);
        Options { made: MadeOptions::default(), joints, bodies, hours: 0.0, torque_nm: None, positions }
    }
}

/// One ring pin on one disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingContact {
    /// Input angle against the ring in rad.
    pub crank_angle: f64,
    pub disc: usize,
    pub pin: usize,
    pub meshing_angle: f64,
    /// N, Pa, m.
    pub force: f64,
    pub pressure: f64,
    pub gap: f64,
}

/// One output pin in its hole of one disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputContact {
    pub crank_angle: f64,
    pub disc: usize,
    pub pin: usize,
    /// N, Pa, m.
    pub force: f64,
    pub pressure: f64,
    pub gap: f64,
}

/// The drive at one position of the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct At {
    /// Input angle against the ring in rad.
    pub crank_angle: f64,
    /// rad.
    pub output_error: f64,
    /// Largest forces of all discs in N: of a ring pin, of an output pin, of an eccentric bearing.
    pub ring_force: f64,
    pub output_force: f64,
    pub eccentric_force: f64,
}

/// Load sharing over a turn of the input.
#[derive(Debug, Clone)]
pub struct Contact {
    /// N·m.
    pub torque: f64,
    pub ring: Vec<RingContact>,
    pub output: Vec<OutputContact>,
    pub turn: Vec<At>,
    made: Made,
}

const CONTACT: TableOf<RingContact> = TableOf {
    name: "contact",
    what: "One ring pin that carries on one disc at one position of the input a row",
    columns: || {
        vec![
            q::CRANK_ANGLE.of(|c: &RingContact| (c.crank_angle / DEG).into()),
            q::DISC.of(|c| c.disc.into()),
            q::PIN.of(|c| c.pin.into()),
            q::MESHING_ANGLE.of(|c| (c.meshing_angle / DEG).into()),
            q::FORCE.of(|c| c.force.into()),
            q::PRESSURE.of(|c| (c.pressure / MPA).into()),
            quantity(
                "gap_um",
                decimals(3),
                "Gap between pin and flank; negative where they press into each other.",
            )
            .of(|c| (c.gap / UM).into()),
        ]
    },
};

const OUTPUT_PINS: TableOf<OutputContact> = TableOf {
    name: "output_pins",
    what: "One output pin in its hole of one disc at one position of the input a row",
    columns: || {
        vec![
            q::CRANK_ANGLE.of(|c: &OutputContact| (c.crank_angle / DEG).into()),
            q::DISC.of(|c| c.disc.into()),
            quantity("pin", digits(3), "Output pin, counted from 0.").of(|c| c.pin.into()),
            quantity("force_n", decimals(2), "Force of the pin on the disc.").of(|c| c.force.into()),
            quantity("pressure_mpa", decimals(1), "Largest Hertz pressure between pin or roller and hole.")
                .of(|c| (c.pressure / MPA).into()),
            quantity("gap_um", decimals(3), "Gap between pin or roller and hole; negative where they press.")
                .of(|c| (c.gap / UM).into()),
        ]
    },
};

const ERROR: TableOf<At> = TableOf {
    name: "error",
    what: "One position of the input a row",
    columns: || {
        vec![
            q::CRANK_ANGLE.of(|at: &At| (at.crank_angle / DEG).into()),
            q::TE_LOADED.of(|at| (at.output_error / ARCMIN).into()),
            quantity("eccentric_bearing_force_n", decimals(1), "Largest force of an eccentric bearing.")
                .of(|at| at.eccentric_force.into()),
        ]
    },
};

pub const SUMMARY: SummaryOf<Contact> = SummaryOf {
    entries: || {
        vec![
            q::TORQUE.of(|o: &Contact| o.torque.into()),
            q::RATIO.of(|o| o.made.design.ratio().into()),
            q::MAX_FORCE.of(|o| largest(&o.turn, |at| at.ring_force).into()),
            q::MAX_PRESSURE.of(|o| (largest(&o.ring, |c| c.pressure) / MPA).into()),
            quantity("max_output_pin_force_n", decimals(1), "Largest force of an output pin on a disc.")
                .of(|o| largest(&o.turn, |at| at.output_force).into()),
            quantity(
                "max_output_pin_pressure_mpa",
                decimals(0),
                "Largest Hertz pressure between an output pin or its roller and a hole.",
            )
            .of(|o| (largest(&o.output, |c| c.pressure) / MPA).into()),
            quantity("eccentric_bearing_force_n", decimals(1), "Largest force of an eccentric bearing.")
                .of(|o| largest(&o.turn, |at| at.eccentric_force).into()),
            q::TE_LOADED_PEAK_TO_PEAK
                .of(|o| (peak_to_peak(o.turn.iter().map(|at| at.output_error)) / ARCMIN).into()),
            quantity(
                "closed_form.ring_pin_force_n",
                decimals(1),
                "Largest force of a ring pin if all of one side carry as equal springs, 4T/(K1 z_c R) with the torque T of a disc.",
            )
            .of(|o| o.made.design.stage().ring_force(o.seen_torque()).into()),
            quantity(
                "closed_form.output_pin_force_n",
                decimals(1),
                "Largest force of an output pin if half of them carry as equal springs, 4T/(z_w R_w).",
            )
            .of(|o| o.made.design.stage().output_pin_force(o.seen_torque()).into()),
            quantity(
                "closed_form.eccentric_bearing_force_n",
                decimals(1),
                "Force of an eccentric bearing with equal springs: T/(e z_c) across the eccentric, 4T/(π R_w) less the radial \
                 force of the ring along it.",
            )
            .of(|o| o.made.design.stage().eccentric_force(o.seen_torque()).into()),
            q::ERRORS_SOURCE.of(|o| o.made.source.word().into()),
            q::ERRORS_SEED.of(|o| Value::from(o.made.seed)),
        ]
    },
};

pub fn tables() -> Vec<DeclaredTable> {
    vec![CONTACT.into(), OUTPUT_PINS.into(), ERROR.into()]
}

fn largest<T>(all: &[T], of: fn(&T) -> f64) -> f64 {
    all.iter().map(of).fold(0.0, f64::max)
}

/// Shares the load over one turn of the input against the ring.
///
/// # Errors
/// [`AnalysisError`] where a state of rest is not found.
pub fn run(design: &StageDesign, options: &Options, host: &dyn Host) -> Result<Contact, AnalysisError> {
    let torque = options.torque_nm.unwrap_or(design.rated().torque);
    let stage = design.stage();
    let radius = stage.output_pins.equivalent_radius(stage.profile.eccentricity);
    let made = Made::of(design, &options.made, options.hours)?;
    let mut rests = Rests::new(&made.design, options.hours, host)?;
    let (mut ring, mut output, mut turn) = (Vec::new(), Vec::new(), Vec::new());
    for step in 0..options.positions {
        host.report("load sharing", step as f64 / options.positions as f64);
        let crank_angle = TAU * step as f64 / options.positions as f64;
        let place = rests.at(crank_angle, torque)?;
        let mut at = At {
            crank_angle,
            output_error: rests.output_error(&place),
            ring_force: 0.0,
            output_force: 0.0,
            eccentric_force: 0.0,
        };
        for disc in 0..stage.phases.len() {
            at.eccentric_force = at.eccentric_force.max(rests.joints().eccentric_force(disc, &place));
            for c in rests.joints().pin_contacts(disc, &place).into_iter().filter(|c| c.force > 0.0) {
                at.ring_force = at.ring_force.max(c.force);
                ring.push(RingContact {
                    crank_angle,
                    disc,
                    pin: c.pin,
                    meshing_angle: c.meshing_angle,
                    force: c.force,
                    pressure: stage.contact.pressure(c.force, 1.0 / c.relative_curvature),
                    gap: c.gap,
                });
            }
            let loads = rests.joints().output_pin_loads(disc, &place);
            for (pin, (force, _, gap)) in loads.into_iter().enumerate() {
                at.output_force = at.output_force.max(force);
                output.push(OutputContact {
                    crank_angle,
                    disc,
                    pin,
                    force,
                    pressure: stage.output_contact.pressure(force, radius),
                    gap,
                });
            }
        }
        turn.push(at);
    }
    Ok(Contact { torque, ring, output, turn, made })
}

impl Contact {
    /// Torque in N·m of the drive seen from its ring.
    fn seen_torque(&self) -> f64 {
        self.torque * self.made.design.seen_from_ring()
    }

    fn sentence(&self) -> String {
        let summary = self.summary();
        let figure = |key: &str| summary.number(key).unwrap_or(f64::NAN);
        format!(
            "At {} N·m the largest force of a ring pin is {:.0} N ({:.0} MPa), of an output pin {:.0} N ({:.0} MPa), of an \
             eccentric bearing {:.0} N.",
            self.torque,
            figure("max_force_n"),
            figure("max_pressure_mpa"),
            figure("max_output_pin_force_n"),
            figure("max_output_pin_pressure_mpa"),
            figure("eccentric_bearing_force_n"),
        )
    }
}

impl Outcome for Contact {
    fn summary(&self) -> Summary {
        SUMMARY.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        vec![CONTACT.fill(&self.ring), OUTPUT_PINS.fill(&self.output), ERROR.fill(&self.turn)]
    }

    fn said(&self) -> Vec<Said> {
        let summary = self.summary();
        let newton = |key: &str| summary.number(key).map_or(String::new(), |force| format!("{force:.1}"));
        let row =
            |name: &str, found: &str, closed: &str| vec![name.to_owned(), newton(found), newton(closed)];
        let forces = TextTable {
            header: ["largest force N", "computed", "closed form, equal springs"].map(str::to_owned).into(),
            rows: vec![
                row("ring pin", "max_force_n", "closed_form.ring_pin_force_n"),
                row("output pin", "max_output_pin_force_n", "closed_form.output_pin_force_n"),
                row(
                    "eccentric bearing",
                    "eccentric_bearing_force_n",
                    "closed_form.eccentric_bearing_force_n",
                ),
            ],
        };
        let mut said: Vec<Said> = self.made.said().into_iter().collect();
        said.extend([
            Said::line(self.sentence()),
            Said::Table(forces),
            Said::figures(&summary, &["te_loaded_peak_to_peak_arcmin"]),
        ]);
        said
    }

    fn page(&self) -> Page {
        let summary = self.summary();
        let figure = |label: &str, key: &str, unit: &str, note: &str| {
            let value = summary.number(key).map_or(String::new(), |value| format!("{value:.0}"));
            KeyFigure::new(label, value, unit, note)
        };
        let angle = || Axis::new("Angle of the input", "°");
        let over = |of: fn(&At) -> f64| self.turn.iter().map(move |at| (at.crank_angle / DEG, of(at)));
        let forces = Plot::new("Largest forces", angle(), Axis::new("Force", "N").from_zero())
            .with(Series::line("ring pin", over(|at| at.ring_force)))
            .with(Series::line("output pin", over(|at| at.output_force)))
            .with(Series::line("eccentric bearing", over(|at| at.eccentric_force)))
            .noted("Of all pins and discs, against the ring.");
        let one = |disc: usize, pin: usize| {
            self.output
                .iter()
                .filter(move |c| c.disc == disc && c.pin == pin)
                .map(|c| (c.crank_angle / DEG, c.force))
        };
        let mut pins =
            Plot::new("Output pins on the first disc", angle(), Axis::new("Force", "N").from_zero())
                .noted("Each pin carries while it stands on the loaded side of the eccentric.");
        for pin in 0..self.made.design.stage().output_pins.count {
            pins = pins.with(Series::line(format!("pin {pin}"), one(0, pin)));
        }
        let error = Plot::new("Transmission error under load", angle(), Axis::new("Error", "arcmin"))
            .with(Series::line("error", over(|at| at.output_error / ARCMIN)));
        let limit = self.made.design.limits().contact_pressure / MPA;
        let kept = summary.number("max_pressure_mpa").is_some_and(|pressure| pressure <= limit);
        let mut verdict = Verdict::new(if kept { Tone::Good } else { Tone::Bad }, self.sentence());
        verdict.figures = vec![
            figure("Ring pin", "max_force_n", "N", "largest force"),
            figure("Pressure", "max_pressure_mpa", "MPa", &format!("of ring pins; limit {limit:.0} MPa"))
                .kept(kept),
            figure("Output pin", "max_output_pin_force_n", "N", "largest force on a disc"),
            figure("Eccentric bearing", "eccentric_bearing_force_n", "N", "largest force"),
        ];
        Page {
            title: self.made.design.name.value.clone(),
            subtitle: "Load sharing of a single stage".to_owned(),
            provenance: Provenance::default(),
            verdict,
            sections: vec![Section::new(
                "forces",
                "Forces",
                vec![Block::Plot(forces), Block::Plot(pins), Block::Plot(error)],
            )],
        }
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
