//! Play of many drives drawn from their tolerances: jam rate, tolerances to tighten first, parts selected by size.

use rayon::prelude::*;

use super::{Drawn, SectionOfWidths, drawn};
use crate::analyses::stage::EccentricDrive;
use crate::analyses::stage::findings::ring_of;
use crate::analyses::stage::keys::has_output_pins;
use crate::analyses::{TextBlock, TextTable};
use crate::checks::{Finding, Severity, severity_if};
use crate::design::StageWidth;
use crate::machine::{
    Overlap, OverlapPlace, PartCounts, PinMounting, RingPartner, StageErrors, StageOffsets, StageTolerances,
};
use crate::report::{Block, Column as Head, Table as PageTable, significant};
use crate::results::{TableOf, decimals, quantity};
use crate::units::{ARCMIN, UM};

/// Play of many drives drawn from their tolerances.
#[derive(Debug, Clone)]
pub struct MadePlay {
    /// Play of the drive without errors, by the gaps of all contacts, rad.
    pub nominal: Option<f64>,
    /// The same with the systematic deviations of the processes, if there are any; inner `None` if it jams.
    pub systematic: Option<Option<f64>>,
    /// Play of the drawn drives.
    pub drawn: Plays,
    /// Effect of each tolerance.
    pub tolerances: Vec<ToleranceShare>,
    /// Effect of selecting parts by size, one entry per step.
    pub matched: Vec<Matched>,
    /// Overlaps of the drawn drives that jam.
    pub overlaps: Overlaps,
    /// Ring partner (pins or teeth) of the discs.
    pub ring: RingPartner,
}

/// Overlap of the jammed drives of a series.
#[derive(Debug, Clone, Default)]
pub struct Overlaps {
    /// Depths in m, rising.
    sorted: Vec<f64>,
    /// Number of drives for each of [`OverlapPlace::ALL`].
    counts: [usize; 3],
}

impl Overlaps {
    fn of(overlaps: &[Overlap]) -> Overlaps {
        let mut sorted: Vec<f64> = overlaps.iter().map(|overlap| overlap.depth).collect();
        sorted.sort_by(f64::total_cmp);
        let count = |place| overlaps.iter().filter(|overlap| overlap.place == place).count();
        Overlaps { sorted, counts: OverlapPlace::ALL.map(count) }
    }

    /// Quantile of the depth in m; `None` if no drive jams.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        quantile(&self.sorted, share)
    }

    /// The most frequent place of the overlap, and its share of the drives.
    pub fn place(&self) -> Option<(OverlapPlace, f64)> {
        let most = OverlapPlace::ALL.into_iter().zip(self.counts).max_by_key(|(_, count)| *count);
        most.filter(|(_, count)| *count > 0)
            .map(|(place, count)| (place, count as f64 / self.sorted.len() as f64))
    }

    /// For the terminal and the finding; `None` where none jams.
    fn words(&self, ring: RingPartner) -> Option<String> {
        let um = |share: f64| self.quantile(share).map(|depth| significant(depth / UM, 2));
        let (median, high, (place, share)) = (um(0.5)?, um(0.95)?, self.place()?);
        Some(format!(
            "half of the jammed drives overlap by more than {median} µm, one of twenty by more than {high} µm, \
                 {:.0} % of them at the \
             {}",
            100.0 * share,
            place.words(ring)
        ))
    }
}

/// Least play over a turn of the output of drives of a series.
#[derive(Debug, Clone, Default)]
pub struct Plays {
    /// Play of the drives that do not jam, rising, rad.
    sorted: Vec<f64>,
    /// Seeds of the others, and their share.
    jammed: Vec<u64>,
    /// Share of the drives that jam.
    pub jam_rate: f64,
}

/// Quantile of rising values.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = share * last as f64;
    let (low, part) = (place.floor() as usize, place.fract());
    Some(sorted[low] + part * (sorted[(low + 1).min(last)] - sorted[low]))
}

/// Effect of a tolerance on the play.
#[derive(Debug, Clone)]
pub struct ToleranceShare {
    /// Path of its section in the design file.
    pub section: &'static str,
    /// Key in the section, with its unit at the end.
    pub key: &'static str,
    /// In the unit of its key.
    pub width: f64,
    /// Reduction of the variance if this tolerance alone is zero, as a share.
    pub variance_share: f64,
    /// Share of jammed drives with this tolerance.
    pub jam_rate: f64,
    /// Share of jammed drives without this tolerance.
    pub jam_rate_without: f64,
}

impl ToleranceShare {
    /// Path of its key in the design file.
    pub fn path(&self) -> String {
        format!("{}.{}", self.section, self.key)
    }
}

/// Drives with ring pins and output rollers selected by size.
#[derive(Debug, Clone)]
pub struct Matched {
    /// Step of the diameter between two sizes, m.
    pub step: f64,
    /// Play of these drives.
    pub plays: Plays,
    /// Share of the variance that goes.
    pub variance_share: f64,
}

/// Drives of a series.
pub(in crate::analyses) const DRIVES: u64 = 1000;
/// Number of drives that are drawn again without each tolerance, the first of the series.
const COMPARED: u64 = 250;
/// Groups of needle rollers differ by 2 µm (ISO 3096), gauge pins by 10 µm; 50 µm is a usual step for prints.
const STEPS_UM: [f64; 3] = [2.0, 10.0, 50.0];
/// Share of drives that jam above which a check warns, an assumption.
const FEW: f64 = 0.01;

impl Plays {
    fn of(drives: u64, play: impl Fn(u64) -> Option<f64> + Sync + Send) -> Plays {
        let all: Vec<Option<f64>> = (1..=drives).into_par_iter().map(play).collect();
        let mut sorted: Vec<f64> = all.iter().flatten().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let jammed: Vec<u64> =
            (1..=drives).zip(&all).filter(|(_, play)| play.is_none()).map(|(seed, _)| seed).collect();
        let jam_rate = jammed.len() as f64 / all.len() as f64;
        Plays { sorted, jammed, jam_rate }
    }

    /// `None` where all jam.
    pub fn mean(&self) -> Option<f64> {
        let count = self.sorted.len() as f64;
        (count > 0.0).then(|| self.sorted.iter().sum::<f64>() / count)
    }

    /// Quantile of the play.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        quantile(&self.sorted, share)
    }

    fn variance(&self) -> f64 {
        let mean = self.mean().unwrap_or(0.0);
        let squares: f64 = self.sorted.iter().map(|play| (play - mean).powi(2)).sum();
        squares / self.sorted.len().max(1) as f64
    }

    /// Reduction of the variance relative to other plays; 0 without variance.
    fn less_than(&self, others: &Plays) -> f64 {
        let whole = others.variance();
        if whole > 0.0 { 1.0 - self.variance() / whole } else { 0.0 }
    }

    fn words(&self) -> String {
        let arcmin =
            |play: Option<f64>| play.map_or("–".to_owned(), |play| format!("{:.2}′", play / ARCMIN));
        format!(
            "{}, nine of ten {} to {}",
            arcmin(self.mean()),
            arcmin(self.quantile(0.05)),
            arcmin(self.quantile(0.95))
        )
    }
}

impl MadePlay {
    /// `None` where the design gives no tolerances.
    pub fn of<D: EccentricDrive>(design: &D) -> Option<MadePlay> {
        let (all, chain) = (drawn(design)?, design.gap_chain());
        let play = |errors: &[StageErrors]| chain.least(errors);
        let draw = |from: &Drawn, seed: u64| StageErrors::draw(from, seed, None);
        let series = |drives: u64, from: &Drawn| Plays::of(drives, |seed| play(&draw(from, seed)));
        let compared = series(COMPARED, &all);
        let widths = D::TOLERANCES.iter().flat_map(|one| one.widths.iter().map(move |width| (one, width)));
        let mut shares: Vec<ToleranceShare> = widths
            .filter_map(|(SectionOfWidths { section, stage, .. }, StageWidth { key, unit, of })| {
                let mut without = all.clone();
                let width = std::mem::take(of(&mut without[*stage].1));
                (width > 0.0).then(|| {
                    let rest = series(COMPARED, &without);
                    ToleranceShare {
                        section,
                        key,
                        width: width / unit,
                        variance_share: rest.less_than(&compared),
                        jam_rate: compared.jam_rate,
                        jam_rate_without: rest.jam_rate,
                    }
                })
            })
            .collect();
        shares.sort_by(|a, b| b.variance_share.total_cmp(&a.variance_share));
        // Arcs of a ring of one piece are not chosen one by one.
        let has_pins: Vec<bool> =
            design.meshes().iter().map(|mesh| mesh.mounting != PinMounting::OnePiece).collect();
        let has_choice = has_pins.contains(&true) || has_output_pins(D::STAGES);
        let matched = STEPS_UM.into_iter().filter(|_| has_choice).map(|step_um| {
            let step = step_um * UM;
            let plays = Plays::of(COMPARED, |seed| {
                let mut errors = draw(&all, seed);
                // Radii come in halves of the step.
                let chosen = |gap: f64| (gap / (0.5 * step)).round() * 0.5 * step;
                let gaps = chain.mean_gaps(&errors);
                for ((errors, [ring, output]), has_pins) in errors.iter_mut().zip(gaps).zip(&has_pins) {
                    errors.output_pin_radius = chosen(output);
                    if *has_pins {
                        errors.pin_radius = chosen(ring);
                    }
                }
                play(&errors)
            });
            Matched { step, variance_share: plays.less_than(&compared), plays }
        });
        let drawn = series(DRIVES, &all);
        let overlaps: Vec<Overlap> =
            drawn.jammed.par_iter().filter_map(|seed| chain.overlap(&draw(&all, *seed))).collect();
        Some(MadePlay {
            nominal: play(&vec![StageErrors::default(); D::STAGES.len()]),
            systematic: all.iter().any(|(_, t)| t.offsets != StageOffsets::default()).then(|| {
                let of_stage = |(counts, t): &(PartCounts, StageTolerances)| {
                    StageErrors::systematic(*counts, &t.offsets)
                };
                play(&all.iter().map(of_stage).collect::<Vec<_>>())
            }),
            drawn,
            overlaps: Overlaps::of(&overlaps),
            ring: ring_of(design),
            tolerances: shares,
            matched: matched.collect(),
        })
    }

    /// Finding about drives of the series that jam.
    pub fn finding(&self) -> Finding {
        let rate = self.drawn.jam_rate;
        let worst = self.tolerances.iter().min_by(|a, b| a.jam_rate_without.total_cmp(&b.jam_rate_without));
        let most = worst.filter(|one| one.jam_rate_without < one.jam_rate).map_or(String::new(), |one| {
            format!("; without {} {:.1} %", one.path(), 100.0 * one.jam_rate_without)
        });
        let by = self.overlaps.words(self.ring).map_or(String::new(), |words| format!("; {words}"));
        Finding {
            code: "jam-rate",
            severity: severity_if(rate > FEW, Severity::Warning),
            message: format!(
                "{:.1} % of {DRIVES} drives drawn from the tolerances go together by force only{by}{most}",
                100.0 * rate
            ),
            value: 100.0 * rate,
            limit: 100.0 * FEW,
            unit: "%",
            why: "at some position of the input ring and flanks or output pins and holes overlap for every position \
                 of the discs: the drive is stiff to turn \
                  or cannot be put together",
            change: match self.ring {
                RingPartner::Teeth => {
                    "larger gaps, a smaller value of the named tolerance, or output pins and rollers selected by size"
                }
                _ => {
                    "larger gaps, a smaller value of the named tolerance, or pins and rollers selected by size"
                }
            },
        }
    }

    /// Words for the parts selected by size.
    fn chosen(&self) -> &'static str {
        match self.ring {
            RingPartner::Teeth => "output pins and rollers",
            _ => "pins and rollers",
        }
    }

    /// For the terminal.
    pub fn text_blocks(&self) -> Vec<TextBlock> {
        let nominal = self.nominal.map_or("–".to_owned(), |play| format!("{:.2}′", play / ARCMIN));
        let mut blocks = vec![TextBlock::line(format!(
            "play as made, the least over a turn of the output by the gaps of all contacts: {} ({DRIVES} drives \
             drawn from the tolerances, of which {:.1} % jam); nominal {nominal}",
            self.drawn.words(),
            100.0 * self.drawn.jam_rate
        ))];
        blocks.extend(self.overlaps.words(self.ring).map(TextBlock::line));
        let percent = |share: f64| format!("{:.0}", (100.0 * share).round() + 0.0);
        let header = ["to tighten first", "±", "% of the variance", "% jam without it, of"];
        let rows = self.tolerances.iter().take(SHOWN).map(|one| {
            vec![
                one.path().trim_start_matches("tolerances.").to_owned(),
                format!("{}", one.width),
                percent(one.variance_share),
                format!("{:.1} of {:.1}", 100.0 * one.jam_rate_without, 100.0 * one.jam_rate),
            ]
        });
        blocks.push(TextBlock::Table(TextTable {
            header: header.map(str::to_owned).into(),
            rows: rows.collect(),
        }));
        for one in &self.matched {
            blocks.push(TextBlock::line(format!(
                "{} selected by size in steps of {:.0} µm of diameter: play {}, {:.1} % jam; {} % less variance",
                self.chosen(),
                one.step / UM,
                one.plays.words(),
                100.0 * one.plays.jam_rate,
                percent(one.variance_share)
            )));
        }
        blocks
    }

    /// For the report.
    pub fn blocks(&self) -> Vec<Block> {
        let arcmin =
            |play: Option<f64>| play.map_or("–".to_owned(), |play| format!("{:.2}", play / ARCMIN));
        // Rounded first, so that no share is −0.
        let percent = |share: f64| format!("{:.1}", (1000.0 * share).round() / 10.0 + 0.0);
        let row = |name: String, plays: &Plays, less: String| {
            vec![
                name,
                arcmin(plays.mean()),
                arcmin(plays.quantile(0.05)),
                arcmin(plays.quantile(0.95)),
                percent(plays.jam_rate),
                less,
            ]
        };
        let mut rows = vec![row("as drawn".to_owned(), &self.drawn, String::new())];
        rows.extend(self.matched.iter().map(|one| {
            let name = format!("{} chosen in steps of {:.0} µm", self.chosen(), one.step / UM);
            row(name, &one.plays, percent(one.variance_share))
        }));
        let plays = PageTable {
            title: "Play as made".to_owned(),
            columns: vec![
                Head::text("Drives"),
                Head::number("Mean", "arcmin"),
                Head::number("5 %", "arcmin"),
                Head::number("95 %", "arcmin"),
                Head::number("Jam", "%"),
                Head::number("Less variance", "%"),
            ],
            rows,
            note: format!(
                "Least two-sided play over a turn of the output by the gaps of all contacts, input held; nominal {} arcmin. {DRIVES} \
                 drives drawn from the tolerances, {COMPARED} of them with parts selected by size. Drives that jam have no play{}.",
                arcmin(self.nominal),
                self.overlaps.words(self.ring).map_or(String::new(), |words| format!("; {words}"))
            ),
        };
        let row = |one: &ToleranceShare| {
            vec![
                one.path(),
                format!("{}", one.width),
                percent(one.variance_share),
                percent(one.jam_rate_without),
            ]
        };
        let tolerances = PageTable {
            title: "Which tolerance to tighten first".to_owned(),
            columns: vec![
                Head::text("Tolerance"),
                Head::number("Width ±", ""),
                Head::number("Share of the variance", "%"),
                Head::number("Jam without it", "%"),
            ],
            rows: self.tolerances.iter().map(row).collect(),
            note: format!(
                "Reduction of the variance of the play if this tolerance alone is zero, from the same {COMPARED} \
                     drives \
                 with and without it; shares need not add up to 100 %."
            ),
        };
        vec![Block::Table(plays), Block::Table(tolerances)]
    }
}

/// Tolerances that the terminal shows.
const SHOWN: usize = 5;

pub(in crate::analyses) const TOLERANCES: TableOf<ToleranceShare> = TableOf {
    name: "tolerances",
    what: "One row per tolerance, the one to tighten first at the top",
    columns: || {
        vec![
            quantity("key", crate::results::PLAIN, "Its key in its section.")
                .of(|one: &ToleranceShare| one.key.into()),
            quantity("section", crate::results::PLAIN, "Its section of the design file.")
                .of(|one| one.section.into()),
            quantity("width", decimals(3), "Its width, ±, in the unit of the key.")
                .of(|one| one.width.into()),
            quantity(
                "variance_share",
                decimals(3),
                "Reduction of the variance of the play if this tolerance alone is zero, as a share.",
            )
            .of(|one| one.variance_share.into()),
            quantity("jam_rate", decimals(4), "Share of the compared drives that go together by force only.")
                .of(|one| one.jam_rate.into()),
            quantity("jam_rate_without", decimals(4), "The same where this tolerance alone is zero.")
                .of(|one| one.jam_rate_without.into()),
        ]
    },
};

pub(in crate::analyses) const MATCHED: TableOf<Matched> = TableOf {
    name: "matched",
    what: "One row per step of sizes: drives with ring pins and output rollers selected by size",
    columns: || {
        vec![
            quantity("step_um", decimals(0), "Step of the diameters for selection.")
                .of(|one: &Matched| (one.step / UM).into()),
            quantity("mean_arcmin", decimals(3), "Mean of the least play over a turn of the output.")
                .of(|one| in_arcmin(one.plays.mean())),
            quantity("low_arcmin", decimals(3), "5 % of the drives have less.")
                .of(|one| in_arcmin(one.plays.quantile(0.05))),
            quantity("high_arcmin", decimals(3), "5 % of the drives have more.")
                .of(|one| in_arcmin(one.plays.quantile(0.95))),
            quantity("jam_rate", decimals(4), "Share of drives that jam.")
                .of(|one| one.plays.jam_rate.into()),
            quantity("variance_share", decimals(3), "Reduction of the variance by selection, as a share.")
                .of(|one| one.variance_share.into()),
        ]
    },
};

pub(in crate::analyses) fn in_arcmin(play: Option<f64>) -> crate::results::Value {
    crate::results::Value::from(play.map(|play| play / ARCMIN))
}
