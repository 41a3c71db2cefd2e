//! What an import found, as a page to look at.

use super::{DutyImport, FlankImport};
use crate::report::{
    Block, Column, KeyFigure, Page, Provenance, Section, Table, Tone, Verdict, compact, significant,
};
use crate::units::{DEG, MM, RPM, UM};

fn figure(label: &str, value: String, unit: &str, note: &str) -> KeyFigure {
    KeyFigure { label: label.into(), value, unit: unit.into(), note: note.into(), tone: Tone::Neutral }
}

/// Without digits that no gauge sees.
fn rounded(value: f64, step: f64) -> String {
    compact((value / step).round() * step + 0.0, 6)
}

/// The design's keys, ready to be copied.
fn keys(toml: &str) -> Block {
    Block::Code { title: "Keys of the design".into(), text: toml.trim_end().to_owned() }
}

impl DutyImport {
    /// The log over torque and speed, the rows that stand for it, and how far they are off. `file` is the name of
    /// the log.
    pub fn page(&self, design: &str, file: &str) -> Page {
        let r = &self.reduction;
        let percent = |share: f64| format!("{} %", rounded(100.0 * share, 1e-2));
        let mut verdict = Verdict::new(
            Tone::Neutral,
            format!("{} readings of {file} became {} rows of duty", r.samples, self.rows.len()),
        );
        verdict.figures = vec![
            figure("Recorded", significant(self.duration / 3600.0, 3), "h", "gaps of the recording left out"),
            figure(
                "At rest",
                significant(100.0 * self.at_rest / self.duration, 3),
                "%",
                "of the time recorded",
            ),
            figure("Peak torque", significant(self.peak_torque.0, 4), "N·m", "at the output"),
            figure("Peak speed", significant(self.peak_speed.0 / RPM, 4), "rpm", "at the output"),
            figure("Starts", self.starts.to_string(), "", "from rest"),
        ];
        verdict.answers = vec![
            (
                "How far are the rows off?".into(),
                format!(
                    "Against the whole log: wear {}, equivalent bearing load {}, bearing life {}.",
                    percent(r.wear_error),
                    percent(r.bearing_load_error),
                    percent(r.life_error)
                ),
            ),
            (
                "What did the joint do?".into(),
                format!(
                    "{} turns of the output, {} reversals; at rest it held {} N·m at most.",
                    significant(self.output_turns, 4),
                    self.reversals,
                    significant(self.holding_torque, 4)
                ),
            ),
        ];
        let rows = self.rows.iter().map(|row| {
            vec![compact(row.torque, 3), compact(row.input_speed / RPM, 2), significant(100.0 * row.share, 3)]
        });
        let table = Table {
            columns: vec![
                Column::number("Torque at the output", "N·m"),
                Column::number("Input speed", "rpm"),
                Column::number("Share of the time in motion", "%"),
            ],
            rows: rows.collect(),
            ..Table::default()
        };
        let blocks = vec![Block::HeatMap(self.picture.clone()), Block::Table(table), keys(&self.toml)];
        Page {
            title: design.to_owned(),
            subtitle: "Duty from a log".into(),
            provenance: Provenance::default(),
            verdict,
            sections: vec![Section::new("duty", "Duty", blocks)],
        }
    }
}

impl FlankImport {
    /// Where the measured points lie, how far they are off the flank, and what that splits into. `file` is the name
    /// of the points.
    pub fn page(&self, design: &str, file: &str) -> Page {
        let fit = &self.fit;
        let (pitch, single, run_out) = self.split.pitch_and_run_out();
        let mut verdict = Verdict::new(
            if fit.outliers.is_empty() { Tone::Neutral } else { Tone::Caution },
            format!(
                "{} points of {file} lie {} µm off the flank (standard deviation), {} outliers",
                self.points.points.len(),
                rounded(fit.deviation / UM, 1e-3),
                fit.outliers.len()
            ),
        );
        let micrometres = |length: f64| rounded(length / UM, 1e-3);
        verdict.figures = vec![
            figure("Offset", micrometres(fit.offset), "µm", "of the whole flank, outwards"),
            figure("Radial run-out F_r", micrometres(run_out), "µm", "over all lobes"),
            figure("Cumulative pitch F_p", micrometres(pitch), "µm", "over all lobes"),
            figure("Single pitch f_p", micrometres(single), "µm", "the largest"),
            figure(
                "Left over",
                micrometres(self.split.rest),
                "µm",
                "standard deviation of what none explains",
            ),
        ];
        verdict.answers = vec![(
            "Where does it lie?".into(),
            format!(
                "Turned by {}°, centre at ({}, {}) mm of the file.",
                rounded(fit.rotation / DEG, 1e-4),
                rounded(fit.centre.x / MM, 1e-4),
                rounded(fit.centre.y / MM, 1e-4)
            ),
        )];
        let mut blocks: Vec<Block> = self.plots.iter().cloned().map(Block::Plot).collect();
        if !fit.outliers.is_empty() {
            let rows = fit.outliers.iter().map(|o| vec![o.line.to_string(), micrometres(o.distance)]);
            blocks.push(Block::Table(Table {
                columns: vec![Column::number("Line", ""), Column::number("Off the flank", "µm")],
                rows: rows.collect(),
                note: "Points that the fit leaves out.".into(),
                ..Table::default()
            }));
        }
        blocks.push(keys(&self.toml));
        Page {
            title: design.to_owned(),
            subtitle: "Measured flank".into(),
            provenance: Provenance::default(),
            verdict,
            sections: vec![Section::new("flank", "Deviations", blocks)],
        }
    }
}
