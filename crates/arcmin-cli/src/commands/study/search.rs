//! A study with a search: rows generation by generation.

use arcmin::study::Shard;
use arcmin::study::search::{Search, Standing};

use super::{Job, broken};
use crate::failure::Failure;
use crate::run::{Results, print_line, terminal_text};

impl Job {
    pub(super) fn standing(&self, search: &Search) -> Result<Standing, Failure> {
        search.standing(&self.parts()).map_err(broken)
    }

    /// Computes all generations; returns whether it was cancelled.
    pub(super) fn search(&self, search: &Search) -> Result<bool, Failure> {
        loop {
            let standing = self.standing(search)?;
            let Some((stage, _)) = &standing.next else { return Ok(false) };
            if self.compute(&stage.plan, &stage.stage.name(), Shard::WHOLE)? {
                return Ok(true);
            }
        }
    }

    /// Computes a shard of the present generation; returns whether it was cancelled.
    pub(super) fn search_stage(&self, search: &Search, shard: Shard) -> Result<bool, Failure> {
        let standing = self.standing(search)?;
        let Some((stage, there)) = &standing.next else {
            if !self.quiet {
                print_line("the search is complete")?;
            }
            return Ok(false);
        };
        let cancelled = self.compute(&stage.plan, &stage.stage.name(), shard)?;
        if !self.quiet {
            print_line(&format!(
                "{} of the search: {} of {} rows were computed before",
                stage.stage.name(),
                there.records.len(),
                stage.plan.rows()
            ))?;
        }
        Ok(cancelled)
    }

    /// Writes the present results of the search.
    pub(super) fn report_search(&self, search: &Search, mut results: Results) -> Result<(), Failure> {
        let standing = self.standing(search)?;
        for (name, reason) in &standing.unusable {
            crate::failure::warn(&format!("parts/{name} is left out: {reason}"));
        }
        let report = match self.study.search_report(&standing) {
            Some(report) => report.map_err(broken)?,
            None => unreachable!("this study searches"),
        };
        if report.rows.records.is_empty() {
            return Err(self.nothing());
        }
        results.file("samples.csv", report.rows.to_csv(&report.plan).as_bytes())?;
        results.file("generations.csv", report.generations_csv().as_bytes())?;
        for (name, design) in
            report.designs().map_err(|error| Failure::design(error, self.study.design.text()))?
        {
            results.file(&format!("{name}.toml"), design.text().as_bytes())?;
        }
        self.page(&mut results, report.page().map_err(broken)?)?;
        self.publish(results, report.to_json(), &terminal_text(&report.text_blocks()))
    }
}
