//! `life --band`: lives of machines drawn from the ranges in `[unknowns]`.

use std::path::Path;

use arcmin::analyses::Quiet;
use arcmin::analyses::stage::AnyDesign;
use arcmin::study::band::{Band, study};
use arcmin::study::judge::Judged;
use arcmin::study::{Rows, Shard, Study, Watch, collect, run};

use super::broken;
use crate::failure::Failure;
use crate::run::{Parts, SampleBar, Terminal};

/// The study of the unknowns with its rows.
pub struct Lives {
    study: Study,
    rows: Rows,
    judged: Judged,
}

impl Lives {
    /// Computes the missing rows; they are stored in `out`/band.
    pub fn compute(
        design: &AnyDesign,
        options: &str,
        machines: u64,
        host: &Terminal,
        out: &Path,
        quiet: bool,
    ) -> Result<Lives, Failure> {
        let failure = |error| Failure::Analysis { error, options: None, finding: None };
        let study = study(design, options, machines, 1, host).map_err(failure)?;
        let parts = Parts::new(&out.join("band"));
        let bar = SampleBar::new("lives", study.plan.rows(), quiet);
        let compute = |row: &arcmin::study::Row| study.compute(row, &Quiet(host));
        let begun = |found: u64| bar.found(found);
        let watch = Watch { begun: &begun, finished: &|_| bar.one_more() };
        let done = run(&study.plan, Shard::WHOLE, &parts, &compute, &watch).map_err(broken)?;
        if done.cancelled {
            let reason =
                "the lives of the band were stopped; repeat the command to continue from there".to_owned();
            return Err(Failure::Unfinished { reason });
        }
        let rows = collect(&study.plan, &parts).map_err(broken)?;
        let judged = study.judge(&rows).map_err(broken)?;
        Ok(Lives { study, rows, judged })
    }

    pub fn band(&self) -> Band<'_> {
        Band::new(&self.study, &self.rows, &self.judged)
    }

    /// band.csv
    pub fn csv(&self) -> String {
        self.rows.to_csv(&self.study.plan)
    }
}
