//! `life --machines N`: what a series of drawn machines makes of the accuracy over life.

use arcmin::dynamics::{BearingMeshing, ElasticDiscs};
use arcmin::life::{LifeOptions, MachineLife, Quantiles, Series, predict_series};
use arcmin::machine::{Machine, ManufacturingErrors};
use arcmin::report::Section;
use arcmin::report::life::series_section;
use arcmin::units::{ARCMIN, UM};
use serde_json::{Value, json};

use super::super::joints::bearing_meshing;
use crate::failure::Failure;
use crate::run::{Cell, Run, Table};

pub struct Spread {
    series: Series,
    seeds: Vec<u64>,
}

const QUANTILES: [&str; 5] = ["min", "p10", "median", "p90", "max"];

impl Spread {
    pub fn compute(
        run: &Run,
        machine: &Machine,
        nominal: BearingMeshing,
        discs: Option<&ElasticDiscs>,
        drawn: &[(u64, ManufacturingErrors)],
        options: LifeOptions,
    ) -> Result<Spread, Failure> {
        let made = drawn
            .iter()
            .map(|(_, errors)| bearing_meshing(machine, errors, discs.cloned()))
            .collect::<Result<Vec<_>, _>>()?;
        let series =
            predict_series(machine, nominal, &made, options, run.progress()).map_err(super::wear_failure)?;
        Ok(Spread { series, seeds: drawn.iter().map(|(seed, _)| *seed).collect() })
    }

    pub fn section(&self, limit_arcmin: f64) -> Section {
        series_section(&self.series, &self.seeds, limit_arcmin)
    }

    /// series.csv and machines.csv.
    pub fn tables(&self, run: &mut Run) -> Result<(), Failure> {
        let mut band = Table::new(&[
            "hours",
            "lost_motion_without_errors_arcmin",
            "lost_motion_min_arcmin",
            "lost_motion_p10_arcmin",
            "lost_motion_median_arcmin",
            "lost_motion_p90_arcmin",
            "lost_motion_max_arcmin",
        ]);
        for (index, hours) in self.series.hours.iter().enumerate() {
            let mut cells =
                vec![Cell::Number(*hours), (self.series.nominal.lost_motion[index] / ARCMIN).into()];
            match self.series.lost_motion(index) {
                Some(Quantiles(values)) => cells.extend(values.map(|lost| Cell::Number(lost / ARCMIN))),
                None => cells.extend([const { Cell::Empty }; 5]),
            }
            band.row(&cells);
        }
        run.table("series.csv", band)?;
        let mut machines = Table::new(&[
            "seed",
            "hours_to_limit",
            "searched_hours",
            "lost_motion_new_arcmin",
            "lost_motion_end_arcmin",
            "max_depth_um",
            "failure",
        ]);
        for (seed, life) in self.seeds.iter().zip(&self.series.machines) {
            let seed = Cell::Number(*seed as f64);
            match life {
                Ok(life) => {
                    let [new, end] = ends(life);
                    machines.row(&[
                        seed,
                        life.hours_to_limit.into(),
                        life.searched_hours.into(),
                        new.into(),
                        end.into(),
                        (life.max_depth / UM).into(),
                        Cell::Empty,
                    ]);
                }
                Err(error) => {
                    let reason = error.to_string().replace(',', ";");
                    machines.row(&[
                        seed,
                        Cell::Empty,
                        Cell::Empty,
                        Cell::Empty,
                        Cell::Empty,
                        Cell::Empty,
                        Cell::Word(&reason),
                    ]);
                }
            }
        }
        run.table("machines.csv", machines)
    }

    pub fn terminal(&self, limit_arcmin: f64) -> String {
        let count = self.series.followed().count();
        let mut text = format!(
            "\nseries of {count} machines          min     10 %   median     90 %      max   without errors"
        );
        let mut line = |name: &str, values: [String; 5], nominal: String| {
            text.push_str(&format!("\n  {name:24}"));
            values.iter().for_each(|value| text.push_str(&format!(" {value:>8}")));
            text.push_str(&format!(" {nominal:>16}"));
        };
        let last = self.series.hours.len() - 1;
        for (name, index) in [("lost motion, new", 0), ("lost motion, worn", last)] {
            if let Some(Quantiles(values)) = self.series.lost_motion(index) {
                let nominal = self.series.nominal.lost_motion[index] / ARCMIN;
                line(name, values.map(|lost| format!("{:.3}'", lost / ARCMIN)), format!("{nominal:.3}'"));
            }
        }
        if let Some(Quantiles(values)) = self.series.hours_to_limit() {
            let name = format!("hours to {limit_arcmin:.2}'");
            let word =
                |hours: f64| if hours.is_finite() { format!("{hours:.0}") } else { "never".to_owned() };
            line(&name, values.map(word), word(self.series.nominal.hours_to_limit.unwrap_or(f64::INFINITY)));
            if values[4].is_infinite() {
                let searched =
                    self.series.followed().map(|life| life.searched_hours).fold(f64::INFINITY, f64::min);
                text.push_str(&format!("\n  (never: not within the {searched:.0} h that were computed)"));
            }
        }
        for (seed, life) in self.seeds.iter().zip(&self.series.machines) {
            if let Err(error) = life {
                text.push_str(&format!("\n  seed {seed} left out: {error}"));
            }
        }
        text
    }

    pub fn summary(&self) -> Value {
        let named = |quantiles: Option<Quantiles>, unit: f64| {
            quantiles.map(|Quantiles(values)| {
                let pairs = QUANTILES.iter().zip(values).map(|(name, value)| {
                    ((*name).to_owned(), json!(value.is_finite().then_some(value / unit)))
                });
                Value::Object(pairs.collect())
            })
        };
        let last = self.series.hours.len() - 1;
        json!({
            "machines": self.seeds.len(),
            "followed": self.series.followed().count(),
            "seeds": self.seeds,
            "reached_limit": self.series.followed().filter(|life| life.hours_to_limit.is_some()).count(),
            "hours_to_limit": named(self.series.hours_to_limit(), 1.0),
            "hours_to_limit_without_errors": self.series.nominal.hours_to_limit,
            "lost_motion_new_arcmin": named(self.series.lost_motion(0), ARCMIN),
            "lost_motion_end_arcmin": named(self.series.lost_motion(last), ARCMIN),
        })
    }
}

fn ends(life: &MachineLife) -> [f64; 2] {
    [life.lost_motion.first(), life.lost_motion.last()].map(|lost| lost.copied().unwrap_or(f64::NAN) / ARCMIN)
}
