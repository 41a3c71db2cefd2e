//! Forces of ring pins, output pins and eccentric bearings over the input's turns.

use std::f64::consts::TAU;

use super::drive::EccentricDrive;
use super::keys::{ECCENTRIC, OUTPUT, OfParts, PartKeys, RING, StageKeys};
use super::made::{HasStageFidelity, Made, MadeOptions, StageFidelity, fidelity_entries};
use super::{Facts, Rests, StageBodies, StageJoints, parts, peak_to_peak};
use crate::analyses::{AnalysisError, Host, Outcome, TextBlock, TextTable};
use crate::design::{default, default_word, optional, options};
use crate::dynamics::HolePinLoad;
use crate::report::{
    Axis, Block, KeyFigure, Page, Plot, Provenance, Section, Series, Tone, Verdict, capitalised,
};
use crate::results::{
    Column, DeclaredTable, Summary, SummaryOf, Table, TableOf, decimals, digits, quantities as q, quantity,
};
use crate::units::{ARCMIN, DEG, MPA, UM};

pub(crate) const ABOUT: &str = "Compute force and pressure of every pin over one turn of the input";

options! {
    /// Options of `contact` for a single stage.
    pub struct Options {
        [made: MadeOptions]
        /// Joints.
        joints: StageJoints => default_word("bearings"),
        /// Bodies.
        bodies: StageBodies => default_word("rigid"),
        /// Age of the drive in hours of its duty: flanks, pins and bearings are worn accordingly.
        hours: f64 => default(0.0, 0.0, 1e7),
        /// Output torque; positive torque opposes positive output motion. Left out: the rated torque.
        torque_nm: Option<f64> => optional(-1e7, 1e7),
        /// Positions over a turn of the input; for two stages over a turn of the eccentrics of the second. The number
        /// is increased slightly if the first ring would be computed in a few equal positions only.
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
    /// Disc, counted from 0.
    pub disc: usize,
    /// Pin of the ring, counted from 0.
    pub pin: usize,
    /// Meshing angle in rad.
    pub meshing_angle: f64,
    /// N.
    pub force: f64,
    /// Hertz pressure in Pa.
    pub pressure: f64,
    /// m; negative is penetration.
    pub gap: f64,
}

/// One output pin in its hole of one disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputContact {
    /// Input angle against the ring in rad.
    pub crank_angle: f64,
    /// Disc, counted from 0.
    pub disc: usize,
    /// Output pin, counted from 0.
    pub pin: usize,
    /// N.
    pub force: f64,
    /// Hertz pressure in Pa.
    pub pressure: f64,
    /// m; negative is penetration.
    pub gap: f64,
    /// Direction of the force of the pin on the hole, rad.
    pub direction: f64,
    /// The same against the direction of the pin on its circle, rad.
    pub around: f64,
}

/// One loaded rolling element of an eccentric bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollerContact {
    /// Input angle against the ring in rad.
    pub crank_angle: f64,
    /// Disc, counted from 0.
    pub disc: usize,
    /// Rolling element, counted from 0.
    pub roller: usize,
    /// Direction from the middle of the eccentric in the frame of the ring, rad.
    pub direction: f64,
    /// Radial force on the disc, N.
    pub force: f64,
}

/// The drive at one position of the input.
#[derive(Debug, Clone, PartialEq)]
pub struct At {
    /// Input angle against the ring in rad.
    pub crank_angle: f64,
    /// rad.
    pub output_error: f64,
    /// Largest forces of all discs in N, stage by stage: of a ring pin, of an output pin, of an eccentric bearing.
    pub forces: Vec<OfParts>,
}

/// Pins and rolling elements of one stage.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StageContacts {
    /// Ring pins at all positions.
    pub ring: Vec<RingContact>,
    /// Output pins at all positions.
    pub output: Vec<OutputContact>,
    /// Rolling elements at all positions.
    pub rollers: Vec<RollerContact>,
}

/// Load sharing over a turn of all eccentrics.
#[derive(Debug, Clone)]
pub struct Contact {
    /// N·m.
    pub torque: f64,
    /// Stage by stage from the input.
    pub stages: Vec<StageContacts>,
    /// Output error and largest forces, position by position.
    pub turn: Vec<At>,
    /// Largest forces with equal springs, as [`At::forces`].
    closed_forms: Vec<OfParts>,
    facts: Facts,
    declared: (SummaryOf<Contact>, TableOf<At>),
    made: StageFidelity,
}

const CONTACT: TableOf<RingContact> = TableOf {
    name: "contact",
    what: "One row per loaded ring pin, disc and position of the input",
    columns: || {
        vec![
            q::CRANK_ANGLE.of(|c: &RingContact| (c.crank_angle / DEG).into()),
            q::DISC.of(|c| c.disc.into()),
            q::PIN.of(|c| c.pin.into()),
            q::MESHING_ANGLE.of(|c| (c.meshing_angle / DEG).into()),
            q::FORCE.of(|c| c.force.into()),
            q::PRESSURE.of(|c| (c.pressure / MPA).into()),
            quantity("gap_um", decimals(3), "Gap between pin and flank; negative is penetration.")
                .of(|c| (c.gap / UM).into()),
        ]
    },
};

const OUTPUT_PINS: TableOf<OutputContact> = TableOf {
    name: "output_pins",
    what: "One row per output pin, disc and position of the input",
    columns: || {
        vec![
            q::CRANK_ANGLE.of(|c: &OutputContact| (c.crank_angle / DEG).into()),
            q::DISC.of(|c| c.disc.into()),
            quantity("pin", digits(3), "Output pin, counted from 0.").of(|c| c.pin.into()),
            quantity("force_n", decimals(2), "Force of the pin on the disc.").of(|c| c.force.into()),
            quantity("pressure_mpa", decimals(1), "Largest Hertz pressure between pin or roller and hole.")
                .of(|c| (c.pressure / MPA).into()),
            quantity("gap_um", decimals(3), "Gap between pin or roller and hole; negative is penetration.")
                .of(|c| (c.gap / UM).into()),
        ]
    },
};

const ROLLERS: TableOf<RollerContact> = TableOf {
    name: "eccentric_rollers",
    what: "One row per loaded rolling element of an eccentric bearing, disc and position of the input",
    columns: || {
        vec![
            q::CRANK_ANGLE.of(|c: &RollerContact| (c.crank_angle / DEG).into()),
            q::DISC.of(|c| c.disc.into()),
            q::ROLLER.of(|c| c.roller.into()),
            q::ROLLER_DIRECTION.of(|c| (c.direction.rem_euclid(TAU) / DEG).into()),
            q::ROLLER_FORCE.of(|c| c.force.into()),
        ]
    },
};

/// One row per position of the input.
fn error<D: EccentricDrive>() -> TableOf<At> {
    TableOf {
        name: "error",
        what: "One row per position of the input",
        columns: || {
            let mut columns = vec![
                q::CRANK_ANGLE.of(|at: &At| (at.crank_angle / DEG).into()),
                q::TE_LOADED.of(|at| (at.output_error / ARCMIN).into()),
            ];
            for (number, part) in parts(D::STAGES) {
                if part.pressure.is_none() {
                    let force = |at: &At, number: usize| at.forces[number / 3][number % 3].into();
                    columns.push(Column::numbered(part.force, number, force));
                }
            }
            columns
        },
    }
}

fn entries<D: EccentricDrive>() -> Vec<Column<Contact>> {
    let mut entries =
        vec![q::TORQUE.of(|o: &Contact| o.torque.into()), q::RATIO.of(|o| o.facts.ratio.into())];
    for (number, part) in parts(D::STAGES) {
        entries.push(Column::numbered(part.force, number, |o, number| o.largest_force(number).into()));
        if let Some(pressure) = part.pressure {
            let largest = |o: &Contact, number: usize| (o.largest_pressure(number) / MPA).into();
            entries.push(Column::numbered(pressure, number, largest));
        }
    }
    entries.push(
        q::TE_LOADED_PEAK_TO_PEAK
            .of(|o| (peak_to_peak(o.turn.iter().map(|at| at.output_error)) / ARCMIN).into()),
    );
    entries.extend(parts(D::STAGES).map(|(number, part)| {
        Column::numbered(part.closed_form, number, |o: &Contact, number| {
            o.closed_forms[number / 3][number % 3].into()
        })
    }));
    entries.extend(fidelity_entries::<Contact>());
    entries
}

pub(crate) fn summary<D: EccentricDrive>() -> SummaryOf<Contact> {
    SummaryOf { entries: entries::<D> }
}

/// The tables of a stage: ring pins, output pins and rolling elements of its eccentric bearings, as far as it has them.
fn tables_of(
    stage: &StageKeys,
) -> (TableOf<RingContact>, Option<TableOf<OutputContact>>, Option<TableOf<RollerContact>>) {
    (
        TableOf { name: stage.contact, ..CONTACT },
        stage.parts[OUTPUT].is_some().then_some(TableOf { name: stage.output_pins, ..OUTPUT_PINS }),
        stage.parts[ECCENTRIC].is_some().then_some(TableOf { name: stage.eccentric_rollers, ..ROLLERS }),
    )
}

pub(crate) fn tables<D: EccentricDrive>() -> Vec<DeclaredTable> {
    let of_stages = D::STAGES.iter().map(tables_of).flat_map(|(ring, output, rollers)| {
        [Some(ring.into()), output.map(DeclaredTable::from), rollers.map(DeclaredTable::from)]
    });
    of_stages.flatten().chain([error::<D>().into()]).collect()
}

/// Shares the load over a turn of all eccentrics.
///
/// # Errors
/// [`AnalysisError`] where a static equilibrium is not found.
pub fn run<D: EccentricDrive>(
    design: &D,
    options: &Options,
    host: &dyn Host,
) -> Result<Contact, AnalysisError> {
    let torque = options.torque_nm.unwrap_or(design.rated().torque);
    let Made { design, discs, fidelity: made } = &design.as_made(&options.made, host)?;
    let made = made.clone();
    let (meshes, output_laws) = (design.meshes(), design.output_laws());
    let mut rests = Rests::new(design, discs, options.hours, host)?;
    let numbers = rests.joints().stages().to_vec();
    let mut stages = vec![StageContacts::default(); numbers.len()];
    let mut turn = Vec::new();
    let angles = design.angles(options.positions);
    for (step, crank_angle) in angles.iter().copied().enumerate() {
        host.report("load sharing", step as f64 / angles.len() as f64);
        let place = rests.at(crank_angle, torque)?;
        let output_error = rests.output_error(&place);
        let mut forces = vec![[0.0_f64; 3]; numbers.len()];
        for (k, numbers) in numbers.iter().enumerate() {
            let StageContacts { ring, output, rollers } = &mut stages[k];
            let [most_ring, most_output, most_eccentric] = &mut forces[k];
            for (disc, number) in numbers.eccentrics.clone().enumerate() {
                *most_eccentric = most_eccentric.max(rests.joints().eccentric_force(number, &place));
                let elements = rests.joints().eccentric_roller_forces(number, &place).into_iter().enumerate();
                rollers.extend(elements.filter(|(_, (_, force))| *force > 0.0).map(
                    |(roller, (direction, force))| RollerContact {
                        crank_angle,
                        disc,
                        roller,
                        direction,
                        force,
                    },
                ));
            }
            for (disc, number) in numbers.rings.clone().enumerate() {
                let contacts = rests.joints().pin_contacts(number, &place).into_iter();
                for c in contacts.filter(|c| c.force > 0.0) {
                    *most_ring = most_ring.max(c.force);
                    ring.push(RingContact {
                        crank_angle,
                        disc,
                        pin: c.pin,
                        meshing_angle: c.meshing_angle,
                        force: c.force,
                        pressure: meshes[k].contact.pressure(c.force, 1.0 / c.relative_curvature),
                        gap: c.gap,
                    });
                }
            }
            for (disc, number) in numbers.output_pins.clone().enumerate() {
                let loads = rests.joints().output_pin_loads(number, &place);
                for (pin, HolePinLoad { force, gap, direction, around }) in loads.into_iter().enumerate() {
                    *most_output = most_output.max(force);
                    let pressure = output_laws[k].map_or(0.0, |(law, radius)| law.pressure(force, radius));
                    output.push(OutputContact {
                        crank_angle,
                        disc,
                        pin,
                        force,
                        pressure,
                        gap,
                        direction,
                        around,
                    });
                }
            }
        }
        turn.push(At { crank_angle, output_error, forces });
    }
    Ok(Contact {
        torque,
        stages,
        turn,
        made,
        closed_forms: design.closed_forms(torque),
        facts: Facts::of(design),
        declared: (summary::<D>(), error::<D>()),
    })
}

impl HasStageFidelity for Contact {
    fn fidelity(&self) -> &StageFidelity {
        &self.made
    }
}

impl Contact {
    fn largest_force(&self, number: usize) -> f64 {
        self.turn.iter().map(|at| at.forces[number / 3][number % 3]).fold(0.0, f64::max)
    }

    fn largest_pressure(&self, number: usize) -> f64 {
        let stage = &self.stages[number / 3];
        match number % 3 {
            RING => stage.ring.iter().map(|c| c.pressure).fold(0.0, f64::max),
            _ => stage.output.iter().map(|c| c.pressure).fold(0.0, f64::max),
        }
    }

    fn parts(&self) -> impl Iterator<Item = (usize, &'static PartKeys)> {
        parts(self.facts.stages)
    }

    fn sentence(&self) -> String {
        let mut sentence = format!("At {} N·m the largest force", self.torque);
        for (index, (number, part)) in self.parts().enumerate() {
            let (comma, is) = if index == 0 { ("", " is") } else { (",", "") };
            let name = self.facts.name_of(number, part);
            let article = if name.starts_with(['e', 'o']) { "an" } else { "a" };
            let force = self.largest_force(number);
            sentence.push_str(&format!("{comma} of {article} {name}{is} {force:.0} N"));
            if part.pressure.is_some() {
                sentence.push_str(&format!(" ({:.0} MPa)", self.largest_pressure(number) / MPA));
            }
        }
        sentence + "."
    }
}

impl Outcome for Contact {
    fn summary(&self) -> Summary {
        self.declared.0.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        let mut tables = Vec::new();
        for (keys, contacts) in self.facts.stages.iter().zip(&self.stages) {
            let (ring, output, rollers) = tables_of(keys);
            tables.push(ring.fill(&contacts.ring));
            tables.extend(output.map(|output| output.fill(&contacts.output)));
            tables.extend(rollers.map(|rollers| rollers.fill(&contacts.rollers)));
        }
        tables.push(self.declared.1.fill(&self.turn));
        tables
    }

    fn text_blocks(&self) -> Vec<TextBlock> {
        let row = |(number, part): (usize, &PartKeys)| {
            let closed = self.closed_forms[number / 3][number % 3];
            vec![
                self.facts.name_of(number, part).to_owned(),
                format!("{:.1}", self.largest_force(number)),
                format!("{closed:.1}"),
            ]
        };
        let forces = TextTable {
            header: ["largest force N", "computed", "closed form, equal springs"].map(str::to_owned).into(),
            rows: self.parts().map(row).collect(),
        };
        let mut blocks: Vec<TextBlock> = self.made.text_blocks().into_iter().collect();
        blocks.extend([
            TextBlock::line(self.sentence()),
            TextBlock::Table(forces),
            TextBlock::figures(&self.summary(), &["te_loaded_peak_to_peak_arcmin"]),
        ]);
        blocks
    }

    fn page(&self) -> Page {
        let angle = || Axis::new("Angle of the input", "°");
        let over = |number: usize| {
            self.turn.iter().map(move |at| (at.crank_angle / DEG, at.forces[number / 3][number % 3]))
        };
        let mut forces =
            Plot::new("Largest forces", angle(), Axis::new("Force", "N").from_zero()).noted(format!(
                "Largest force in N of each kind of part among all {} and discs, over the angle of the input.",
                self.facts.ring.several()
            ));
        for (number, part) in self.parts() {
            forces = forces.with(Series::line(self.facts.name_of(number, part), over(number)));
        }
        let mut blocks = vec![Block::Plot(forces)];
        for (keys, stage) in self.facts.stages.iter().zip(&self.stages) {
            let Some(part) = &keys.parts[OUTPUT] else { continue };
            let count = stage.output.iter().map(|c| c.pin + 1).max().unwrap_or(0);
            let title = format!("Force of each {} on the first disc", part.name);
            let mut pins = Plot::new(title, angle(), Axis::new("Force", "N").from_zero())
                .noted("Force in N of each output pin over the angle of the input. An output pin carries load while it is on the loaded side of the eccentric.");
            for pin in 0..count {
                let one = stage.output.iter().filter(move |c| c.disc == 0 && c.pin == pin);
                let one = one.map(|c| (c.crank_angle / DEG, c.force));
                pins = pins.with(Series::line(format!("output pin {pin}"), one));
            }
            blocks.push(Block::Plot(pins));
        }
        let error = self.turn.iter().map(|at| (at.crank_angle / DEG, at.output_error / ARCMIN));
        blocks.push(Block::Plot(
            Plot::new("Transmission error under load", angle(), Axis::new("Error", "arcmin"))
                .noted("Output angle less input angle over the ratio in arcmin under load, including play and wind-up. A negative error is a lag.")
                .with(Series::line("error", error)),
        ));
        let limit = self.facts.limits.contact_pressure / MPA;
        let pressure = |number: usize| self.largest_pressure(number) / MPA;
        let is_kept = |number: usize| pressure(number) <= limit;
        let kept = (0..self.stages.len()).all(|k| is_kept(3 * k + RING));
        let mut verdict = Verdict::new(if kept { Tone::Good } else { Tone::Bad }, self.sentence());
        let model = capitalised(&self.made.model(self.facts.stages));
        verdict.answers.push(("Which physics".to_owned(), format!("{model}.")));
        for (number, part) in self.parts() {
            let force = format!("{:.0}", self.largest_force(number));
            verdict.figures.push(KeyFigure::new(
                self.facts.name_of(number, part),
                force,
                "N",
                "largest force",
            ));
            if number % 3 == RING {
                let note = format!("of a {}; limit {limit:.0} MPa", self.facts.name_of(number, part));
                let figure = KeyFigure::new("Pressure", format!("{:.0}", pressure(number)), "MPa", note);
                verdict.figures.push(figure.kept(is_kept(number)));
            }
        }
        Page {
            title: self.facts.name.clone(),
            subtitle: format!("Load sharing of a {}", self.facts.family.drive()),
            provenance: Provenance::default(),
            verdict,
            sections: vec![Section::new("forces", "Forces", blocks)],
        }
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
