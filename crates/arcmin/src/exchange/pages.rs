//! Results of an import as a report page.

use super::{DutyImport, FlankImport, trimmed};
use crate::report::{
    Block, Column, KeyFigure, Page, Provenance, Section, Table, Tone, Verdict, compact, significant,
};
use crate::units::{DEG, MM, RPM, UM};

/// The design's keys, to be copied.
fn keys(toml: &str) -> Block {
    Block::Code { title: "Keys of the design".into(), text: toml.trim_end().to_owned() }
}

impl DutyImport {
    /// The log as a function of torque and speed, the rows that represent it, and their deviations. `file` is
    /// the name of the log.
    pub fn page(&self, design: &str, file: &str) -> Page {
        let r = &self.reduction;
        let percent = |share: f64| format!("{} %", trimmed(100.0 * share, 2));
        let mut verdict = Verdict::new(
            Tone::Neutral,
            format!("{} readings of {file} became {} rows of duty", r.samples, self.rows.len()),
        );
        verdict.figures = vec![
            KeyFigure::new(
                "Recorded",
                significant(self.duration / 3600.0, 3),
                "h",
                "gaps of the recording left out",
            ),
            KeyFigure::new(
                "At rest",
                significant(self.at_rest / 3600.0, 3),
                "h",
                format!("{} % of the time recorded", significant(100.0 * self.at_rest / self.duration, 3)),
            ),
            KeyFigure::new("Peak torque", significant(self.peak_torque.0, 4), "N·m", "at the output"),
            KeyFigure::new("Peak speed", significant(self.peak_speed.0 / RPM, 4), "rpm", "at the output"),
            KeyFigure::new("Starts", self.starts.to_string(), "", "from rest"),
        ];
        verdict.answers = vec![
            (
                "Deviation of the rows from the log".into(),
                format!(
                    "Against the whole log: wear {}, equivalent bearing load {}, bearing life {}.",
                    percent(r.wear_error),
                    percent(r.bearing_load_error),
                    percent(r.life_error)
                ),
            ),
            (
                "Operation of the joint in the log".into(),
                format!(
                    "{} turns of the output, {} reversals; at rest (below {} rpm) it held {} N·m at most. 1000 h in \
                     motion, as the program counts, are {} h by the clock.",
                    significant(self.output_turns, 4),
                    self.reversals,
                    compact(self.rest_speed / RPM, 3),
                    significant(self.holding_torque, 4),
                    self.clock_hours()
                ),
            ),
        ];
        if !self.notes.is_empty() {
            verdict.answers.push(("What is assumed?".into(), self.notes.join(". ") + "."));
        }
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
    /// Pose and deviations of the measured points, and their decomposition. `file` is the name of the points'
    /// file.
    pub fn page(&self, design: &str, file: &str) -> Page {
        let fit = &self.fit;
        let (pitch, single, run_out) = self.split.pitch_and_run_out();
        let mut verdict = Verdict::new(
            if fit.outliers.is_empty() { Tone::Neutral } else { Tone::Caution },
            format!(
                "{} points of {file} lie {} µm off the flank (standard deviation), {} outliers",
                self.points.points.len(),
                trimmed(fit.deviation / UM, 3),
                fit.outliers.len()
            ),
        );
        let micrometres = |length: f64| trimmed(length / UM, 3);
        verdict.figures = vec![
            KeyFigure::new("Offset", micrometres(fit.offset), "µm", "of the whole flank, outwards"),
            KeyFigure::new("Radial run-out F_r", micrometres(run_out), "µm", "over all lobes"),
            KeyFigure::new("Cumulative pitch F_p", micrometres(pitch), "µm", "over all lobes"),
            KeyFigure::new("Single pitch f_p", micrometres(single), "µm", "the largest"),
            KeyFigure::new(
                "Left over",
                micrometres(self.split.rest),
                "µm",
                "standard deviation of the residuals",
            ),
        ];
        verdict.answers = vec![(
            "Pose of the measured points".into(),
            format!(
                "Turned by {}°, centre at ({}, {}) mm of the file.",
                trimmed(fit.rotation / DEG, 4),
                trimmed(fit.centre.x / MM, 4),
                trimmed(fit.centre.y / MM, 4)
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
