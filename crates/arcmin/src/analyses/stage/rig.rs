//! The test bench of drives of eccentrics: play, lost motion, stiffness, transmission error.

use std::f64::consts::TAU;

mod elastic;

use super::drive::{EccentricDrive, Efficiency};
use super::keys::PartKeys;
use super::made::{HasStageFidelity, Made, MadeOptions, StageFidelity, fidelity_entries};
use super::{
    Facts, HasPlay, Play, Rests, StageBodies, StageJoints, parts, peak_to_peak, play_entries, play_sentence,
    play_table,
};
use crate::analyses::{AnalysisError, Host, Outcome, TextBlock};
use crate::design::{default, default_word, optional, options};
use crate::dynamics::StageLosses;
use crate::machine::Overlap;
use crate::report::rig::{Loops, hysteresis, loop_figures};
use crate::report::{
    Axis, Block, KeyFigure, Page, Plot, Provenance, Section, Series, Tone, Verdict, capitalised, literature,
    significant,
};
use crate::results::{
    Column, DeclaredTable, PLAIN, Summary, SummaryOf, Table, TableOf, Value, decimals, digits,
    quantities as q, quantity,
};
use crate::rig::{LoopFigures, LoopPoint, evaluate_loop};
use crate::units::{ARCMIN, DEG, UM};

use elastic::WithElasticDiscs;

pub(crate) const ABOUT: &str =
    "Compute play, lost motion, stiffness and transmission error as on a test bench";

options! {
    /// Options of `rig` for a single stage.
    pub struct Options {
        [made: MadeOptions, discs = "elastic"]
        /// Joints.
        joints: StageJoints => default_word("bearings"),
        /// Bodies.
        bodies: StageBodies => default_word("rigid"),
        /// Age of the drive in hours of its duty: flanks, pins and bearings are worn accordingly.
        hours: f64 => default(0.0, 0.0, 1e7),
        /// Positions of the input at which the torque is cycled, over a turn of all eccentrics; with errors of single
        /// pins or discs over a turn of the output.
        positions: usize => default(5.0, 1.0, 360.0),
        /// Positions of the transmission error over a turn of the input; for two stages over a turn of the eccentrics
        /// of the second. The number is increased slightly if the first ring would be computed in a few equal
        /// positions only. With errors of single pins or discs this number for every turn of the input over a turn of
        /// the output.
        te_positions: usize => default(180.0, 8.0, 36_000.0),
        /// Without friction. Otherwise coefficients are assumed if the design gives none.
        frictionless: bool => optional(0.0, 0.0),
    }
}

/// Share of the rated torque under which the play is read: only gaps close.
const NO_LOAD: f64 = 1e-4;

/// A drive on the bench.
#[derive(Debug, Clone)]
pub struct Rig {
    /// N·m.
    rated: f64,
    /// One hysteresis loop per position of the input.
    pub loops: Vec<Vec<LoopPoint>>,
    /// Results of each loop.
    pub each: Vec<LoopFigures>,
    /// Mean over the positions.
    pub figures: LoopFigures,
    /// Least and largest play over the positions in rad.
    pub play: [f64; 2],
    /// Input angle against the ring and error of the output under rated torque, rad.
    pub errors: Vec<[f64; 2]>,
    /// Mean over a turn of all eccentrics under rated torque, stage by stage from the input.
    pub losses: Vec<StageLosses>,
    /// At rated torque.
    pub efficiency: Efficiency,
    /// Whether the coefficients of friction are assumed.
    assumed_friction: bool,
    /// Whether friction was left out.
    frictionless: bool,
    chain: Play,
    facts: Facts,
    declared: SummaryOf<Rig>,
    /// Least play over a turn of the output by the gaps of all contacts, rad; `None` where the drive jams.
    pub gap_play: Option<f64>,
    /// Overlap, if the drive jams.
    pub overlap: Option<Overlap>,
    made: StageFidelity,
    elastic: WithElasticDiscs,
}

const LOOP: TableOf<(usize, LoopPoint)> = TableOf {
    name: "hysteresis",
    what: "One row per point of a hysteresis loop",
    columns: || {
        vec![
            q::TORQUE.of(|(_, p): &(usize, LoopPoint)| p.torque.into()),
            quantity("angle_arcmin", decimals(4), "Angle of the output, input held.")
                .of(|(_, p)| (p.angle / ARCMIN).into()),
            quantity("branch", PLAIN, "falling or rising torque.").of(|(_, p)| p.branch.word().into()),
            quantity("position", PLAIN, "Position of the input, counted from 0.").of(|(i, _)| (*i).into()),
        ]
    },
};

const ERRORS: TableOf<[f64; 2]> = TableOf {
    name: "te",
    what: "One row per position of the input: transmission error at rated torque",
    columns: || {
        vec![
            q::CRANK_ANGLE.of(|[angle, _]: &[f64; 2]| (angle / DEG).into()),
            q::TE.of(|[_, error]| (error / ARCMIN).into()),
        ]
    },
};

pub(crate) fn summary<D: EccentricDrive>() -> SummaryOf<Rig> {
    SummaryOf {
        entries: || {
            let mut entries = vec![
                q::RATIO.of(|o: &Rig| o.facts.ratio.into()),
                q::LOST_MOTION.of(|o| (o.figures.lost_motion / ARCMIN).into()),
                q::BACKLASH.of(|o| (o.figures.backlash / ARCMIN).into()),
                q::STIFFNESS.with(digits(4)).of(|o| (o.figures.stiffness * ARCMIN).into()),
                q::MIDDLE_STIFFNESS.with(digits(4)).of(|o| (o.figures.middle_stiffness * ARCMIN).into()),
                q::SOFT_STIFFNESS.with(digits(4)).of(|o| (o.figures.soft_stiffness * ARCMIN).into()),
                quantity(
                    "play_arcmin",
                    decimals(3),
                    "Two-sided travel of the output at no load, input held, without friction: the largest over the \
                         positions, from equilibria.",
                )
                .of(|o| (o.play[1] / ARCMIN).into()),
                quantity("least_play_arcmin", decimals(3), "The least over the positions.")
                    .of(|o| (o.play[0] / ARCMIN).into()),
                quantity(
                    "te_rated_peak_to_peak_arcmin",
                    decimals(4),
                    "Transmission error under rated torque, peak to peak over a turn of all eccentrics; with errors \
                         of single pins or discs over a turn of the output.",
                )
                .of(|o| (o.peak_to_peak() / ARCMIN).into()),
                quantity(
                    "hysteresis_loss_j",
                    digits(3),
                    "Friction work in a torque cycle to ± rated torque and back, mean over the positions.",
                )
                .of(|o| o.figures.work.abs().into()),
                quantity("friction_assumed", PLAIN, "Whether the design gives no friction and some was assumed.")
                    .of(|o| o.assumed_friction.into()),
                q::EFFICIENCY.of(|o| o.efficiency.forward.into()),
                quantity(
                    "backward_efficiency",
                    decimals(3),
                    "Efficiency with the output driving, 2 − 1/η of every stage, for equal losses. At zero or below \
                         the drive is self-locking.",
                )
                .of(|o| o.efficiency.backward.into()),
            ];
            entries.extend(parts(D::STAGES).map(|(number, part)| {
                Column::numbered(part.loss, number, |o: &Rig, number| o.loss_share(number).into())
            }));
            entries.extend(play_entries::<Rig, D>());
            entries.extend([
                quantity(
                    "gap_play_arcmin",
                    decimals(3),
                    "Two-sided play of this drive when new from the gaps of all contacts, the least over a turn of \
                         the output. Empty if it jams.",
                )
                .of(|o: &Rig| Value::from(o.gap_play.map(|play| play / ARCMIN))),
                quantity(
                    "jams",
                    PLAIN,
                    "1 if the drive jams: at some position of the input no position of the discs leaves all gaps \
                         open; else 0.",
                )
                .of(|o| usize::from(o.gap_play.is_none()).into()),
                quantity(
                    "overlap_um",
                    decimals(2),
                    "Depth to be removed equally from all flanks and walls of holes so that the jammed drive is \
                         free. Empty if it does not jam.",
                )
                .of(|o| Value::from(o.overlap.map(|overlap| overlap.depth / UM))),
            ]);
            entries.extend(elastic::entries());
            entries.extend(fidelity_entries::<Rig>());
            entries
        },
    }
}

pub(crate) fn tables() -> Vec<DeclaredTable> {
    vec![LOOP.into(), ERRORS.into()]
}

/// Angles (rad) of the input at which the torque is cycled: distributed over the full period, by whole turns of the
/// input.
pub(super) fn cycle_angles(design: &impl EccentricDrive, positions: usize) -> Vec<f64> {
    let turns = design.turns();
    let angle = |position: usize| {
        let share = position as f64 / positions as f64;
        TAU * (share + (position * turns / positions) as f64)
    };
    (0..positions).map(angle).collect()
}

/// Runs a drive on the bench. Play and transmission error are computed without friction.
///
/// # Errors
/// [`AnalysisError`] where a static equilibrium is not found.
pub fn run<D: EccentricDrive>(of_file: &D, options: &Options, host: &dyn Host) -> Result<Rig, AnalysisError> {
    let Made { design, discs, fidelity: made } = &of_file.as_made(&options.made, host)?;
    let rated = design.rated().torque.abs();
    let mut rests = Rests::new(design, discs, options.hours, host)?;
    let (mut friction, mut assumed_friction) = design.friction();
    if options.frictionless {
        friction.iter_mut().for_each(|friction| *friction = friction.none());
        assumed_friction = false;
    }
    let mut loops = Vec::new();
    let (mut play, mut each) = ([f64::INFINITY, 0.0_f64], Vec::new());
    for (position, angle) in cycle_angles(design, options.positions).into_iter().enumerate() {
        host.report("torque cycle", position as f64 / options.positions as f64);
        let cycle = rests.cycle(angle, &friction)?;
        each.push(evaluate_loop(&cycle, rated).map_err(AnalysisError::compute("read the torque cycle"))?);
        loops.push(cycle);
        let ends = [-NO_LOAD, NO_LOAD]
            .map(|share| rests.at(angle, share * rated).map(|place| rests.output_error(&place)));
        let [up, down] = ends;
        let travel = up? - down?;
        play = [play[0].min(travel), play[1].max(travel)];
    }
    let mut losses = vec![StageLosses::default(); friction.len()];
    let mut errors = Vec::new();
    let angles = design.angles(options.te_positions);
    let part = 1.0 / angles.len() as f64;
    for (step, angle) in angles.iter().copied().enumerate() {
        host.report("transmission error", step as f64 * part);
        let place = rests.at(angle, design.rated().torque)?;
        errors.push([angle, rests.output_error(&place)]);
        for (mean, here) in losses.iter_mut().zip(rests.joints().losses(&place, &friction)) {
            mean.add(part, &here);
        }
    }
    let (chain, gaps) = (design.gap_chain(), design.errors());
    Ok(Rig {
        efficiency: design.efficiency(rated, &losses),
        losses,
        assumed_friction,
        frictionless: options.frictionless,
        rated,
        loops,
        figures: LoopFigures::mean(&each),
        each,
        play,
        errors,
        chain: Play::of(design),
        facts: Facts::of(design),
        declared: summary::<D>(),
        overlap: chain.overlap(&gaps),
        gap_play: chain.least(&gaps),
        made: made.clone(),
        elastic: WithElasticDiscs::of(of_file, options, &friction, host)?,
    })
}

impl HasStageFidelity for Rig {
    fn fidelity(&self) -> &StageFidelity {
        &self.made
    }
}

impl HasPlay for Rig {
    fn play(&self) -> Option<&Play> {
        Some(&self.chain)
    }
}

impl Rig {
    /// Share of a part in the losses, by its number; `None` without losses.
    fn loss_share(&self, number: usize) -> Option<f64> {
        let total: f64 = self.losses.iter().map(StageLosses::total).sum();
        let StageLosses { ring, output, eccentric } = self.losses[number / 3];
        (total > 0.0).then(|| [ring, output, eccentric][number % 3] / total)
    }

    /// Peak to peak of the transmission error, rad.
    pub(super) fn peak_to_peak(&self) -> f64 {
        peak_to_peak(self.errors.iter().map(|[_, error]| *error))
    }

    fn losses_sentence(&self) -> String {
        if self.frictionless {
            return "without friction: no losses, efficiency 1".to_owned();
        }
        let Efficiency { forward, backward } = self.efficiency;
        let share = |(number, part): (usize, &'static PartKeys)| {
            format!("{} {:.0} %", part.short, 100.0 * self.loss_share(number).unwrap_or(0.0))
        };
        let shares: Vec<String> = parts(self.facts.stages).map(share).collect();
        let assumed = if self.assumed_friction { ", friction assumed: the design gives none" } else { "" };
        let back = match backward > 0.0 {
            true => format!("{backward:.2} with the output driving"),
            false => "the output cannot drive it".to_owned(),
        };
        format!("efficiency at rated torque {forward:.3}, {back}{assumed}; losses: {}", shares.join(", "))
    }

    fn sentence(&self) -> String {
        format!(
            "Lost motion {:.2}′, backlash {:.2}′, play {:.2} to {:.2}′, stiffness {} N·m/arcmin from 50 to 100 % of the rated torque.",
            self.figures.lost_motion / ARCMIN,
            self.figures.backlash / ARCMIN,
            self.play[0] / ARCMIN,
            self.play[1] / ARCMIN,
            significant(self.figures.stiffness * ARCMIN, 4)
        )
    }
}

impl Rig {
    /// Joints and bodies of the model.
    fn model(&self) -> String {
        self.made.model(self.facts.stages)
    }
}

impl Outcome for Rig {
    fn summary(&self) -> Summary {
        self.declared.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        let loops = self.loops.iter().enumerate();
        let points: Vec<(usize, LoopPoint)> =
            loops.flat_map(|(position, points)| points.iter().map(move |point| (position, *point))).collect();
        vec![LOOP.fill(&points), ERRORS.fill(&self.errors)]
    }

    fn text_blocks(&self) -> Vec<TextBlock> {
        let keys = [
            "lost_motion_arcmin",
            "backlash_arcmin",
            "stiffness_n_m_per_arcmin",
            "middle_stiffness_n_m_per_arcmin",
            "soft_stiffness_n_m_per_arcmin",
            "te_rated_peak_to_peak_arcmin",
        ];
        let gaps = match self.gap_play {
            Some(play) => {
                let least = play / ARCMIN;
                format!(
                    "least play of the new drive over a turn of the output, by the gaps of all contacts: {least:.2}′"
                )
            }
            None => {
                let by = self.overlap.map_or(String::new(), |Overlap { depth, place }| {
                    format!(
                        ": {} µm too much at the {}",
                        significant(depth / UM, 2),
                        place.words(self.facts.ring)
                    )
                });
                format!(
                    "it jams: at some position of the input no position of the discs leaves all gaps open{by}"
                )
            }
        };
        let model = TextBlock::line(format!("{}: {}", self.facts.name, self.model()));
        let mut blocks: Vec<TextBlock> = std::iter::once(model).chain(self.made.text_blocks()).collect();
        blocks.push(TextBlock::line(self.sentence()));
        blocks.extend(self.elastic.sentence(&self.figures).map(TextBlock::line));
        blocks.push(TextBlock::figures(&self.summary(), &keys));
        blocks.extend([
            TextBlock::line(gaps),
            TextBlock::line(play_sentence(&self.chain)),
            TextBlock::line(self.losses_sentence()),
        ]);
        if !self.frictionless {
            blocks.push(TextBlock::line(format!(
                "work lost in a torque cycle to ± rated: {} J",
                significant(self.figures.work.abs(), 3)
            )));
        }
        blocks
    }

    fn page(&self) -> Page {
        let loops = [Loops { name: "drive".to_owned(), loops: &self.loops, figures: &self.each }];
        let mut cycle = hysteresis(self.rated, &loops, None);
        cycle.push(loop_figures(&loops, None));
        let error = Plot::new(
            "Transmission error under rated torque",
            Axis::new("Angle of the input", "°"),
            Axis::new("Error", "arcmin"),
        )
        .noted("Output angle less input angle over the ratio in arcmin at rated torque. The mean contains play and wind-up. A negative error is a lag.")
        .with(Series::line("error", self.errors.iter().map(|[angle, error]| (angle / DEG, error / ARCMIN))));
        let limits = &self.facts.limits;
        let limit = limits.lost_motion;
        let is_within = |value: f64, limit: Option<f64>| limit.is_none_or(|limit| value <= limit);
        let plays = is_within(self.play[1], limits.backlash);
        let kept = self.figures.lost_motion <= limit
            && plays
            && is_within(self.peak_to_peak(), limits.transmission_error);
        let mut verdict = Verdict::new(if kept { Tone::Good } else { Tone::Bad }, self.sentence());
        verdict.figures = vec![
            KeyFigure::new(
                "Lost motion",
                format!("{:.2}", self.figures.lost_motion / ARCMIN),
                "arcmin",
                format!("at ±3 % of the rated torque; limit {:.2} arcmin", limit / ARCMIN),
            )
            .kept(self.figures.lost_motion <= limit),
            KeyFigure::new(
                "Backlash",
                format!("{:.2}", self.figures.backlash / ARCMIN),
                "arcmin",
                "width of the loop at zero torque",
            ),
            KeyFigure::new(
                "Play",
                format!("{:.2}", self.play[1] / ARCMIN),
                "arcmin",
                "largest over the positions",
            )
            .kept(plays),
            KeyFigure::new(
                "Transmission error",
                format!("{:.3}", self.peak_to_peak() / ARCMIN),
                "arcmin",
                "under rated torque, peak to peak over a turn of all eccentrics",
            )
            .kept(is_within(self.peak_to_peak(), limits.transmission_error)),
            KeyFigure::new(
                "Stiffness",
                significant(self.figures.stiffness * ARCMIN, 4),
                "N·m/arcmin",
                match self.elastic.found() {
                    Some(soft) => format!(
                        "from 50 to 100 % of the rated torque; {} with elastic discs",
                        significant(soft.stiffness * ARCMIN, 4)
                    ),
                    None => "from 50 to 100 % of the rated torque".to_owned(),
                },
            ),
            KeyFigure::new(
                "Efficiency",
                format!("{:.3}", self.efficiency.forward),
                "",
                "at rated torque, the input driving",
            ),
        ];
        verdict.answers = vec![
            ("Which physics".to_owned(), format!("{}.", capitalised(&self.model()))),
            ("Efficiency and losses".to_owned(), format!("{}.", capitalised(&self.losses_sentence()))),
        ];
        let elastic = self.elastic.sentence(&self.figures);
        verdict.answers.extend(elastic.map(|sentence| ("Elastic discs".to_owned(), sentence)));
        Page {
            title: self.facts.name.clone(),
            subtitle: format!("A {} on the test bench", self.facts.family.drive()),
            provenance: Provenance::default(),
            verdict,
            sections: vec![
                Section::new("cycle", "Torque cycle", cycle),
                Section::new("play", "Play", vec![play_table(&self.chain)]),
                Section::new("error", "Transmission error", vec![Block::Plot(error)]),
                literature(&["Johnson1985", "Harris2006", "GBT35089"]),
            ],
        }
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
