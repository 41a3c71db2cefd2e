use sha2::{Digest, Sha256};

use super::distribution::{Distribution, Value};
use super::sampling::{Layout, Point, Sampling};
use super::{StudyError, part};

/// A value that a row gives to a key of the design.
#[derive(Debug, Clone, PartialEq)]
pub enum Setting {
    /// Number in the unit of the key.
    Number(f64),
    /// Word of a choice, or name of a material.
    Word(String),
    /// `true` or `false`.
    Flag(bool),
    /// Seed of a machine drawn from its tolerances.
    Seed(u64),
}

/// One varied quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Factor {
    /// Path of the key, or `seed` for a drawn machine.
    pub path: String,
    /// Its unit, empty for none.
    pub unit: String,
    /// How its values are distributed.
    pub distribution: Distribution,
    /// Settings that a [`Distribution::List`] chooses from; empty otherwise.
    pub entries: Vec<Setting>,
    /// Whether it is a count: numbers are rounded to whole ones.
    pub whole: bool,
    /// Cost of tightening by one unit, if known.
    pub cost: Option<f64>,
}

impl Factor {
    /// A number by its path, from a distribution.
    pub fn number(path: impl Into<String>, unit: impl Into<String>, distribution: Distribution) -> Factor {
        Factor {
            path: path.into(),
            unit: unit.into(),
            distribution,
            entries: Vec::new(),
            whole: false,
            cost: None,
        }
    }

    /// A machine drawn from its tolerances.
    pub fn drawn() -> Factor {
        Factor::number("seed", "", Distribution::Drawn)
    }

    /// One of several values.
    pub fn one_of(path: impl Into<String>, entries: Vec<Setting>) -> Factor {
        let distribution = Distribution::List { count: entries.len() };
        Factor { entries, ..Factor::number(path, "", distribution) }
    }

    fn setting(&self, value: Value) -> Setting {
        match value {
            Value::Number(number) if self.whole => Setting::Number(number.round()),
            Value::Number(number) => Setting::Number(number),
            Value::Seed(seed) => Setting::Seed(seed),
            // A validated list has as many entries as its distribution counts.
            Value::Entry(index) => self.entries.get(index).cloned().unwrap_or(Setting::Flag(false)),
        }
    }

    fn kind(&self) -> Kind {
        let word = |setting: &Setting| matches!(setting, Setting::Word(_) | Setting::Flag(_));
        if self.entries.iter().any(word) { Kind::Word } else { Kind::Number }
    }
}

/// Contents of a column of rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Numbers.
    Number,
    /// Words.
    Word,
    /// A list of numbers in every row: a result at several hours.
    Curve,
}

/// A result kept in the rows, by its key in the summary of the analysis; a dot is nesting.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// Key in the summary of the analysis.
    pub key: String,
    /// Type of its values.
    pub kind: Kind,
}

/// One row of a study, to be computed.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its number, from 0.
    pub number: u64,
    /// In the order of the plan's factors.
    pub settings: Vec<Setting>,
    /// Point of the unit cube from which the settings follow.
    pub point: Point,
}

/// Everything on which rows depend, except the computation itself.
#[derive(Debug, Clone)]
pub struct Plan {
    factors: Vec<Factor>,
    sampling: Sampling,
    kept: Vec<Kept>,
    identity: String,
    rows_per_part: u64,
    /// Prefix of the names of parts.
    name: String,
}

/// Default number of samples in a part; shards consist of parts.
const SAMPLES_PER_PART: u64 = 8;
/// Largest recommended number of parts in a directory.
const MANY_PARTS: u64 = 2048;

impl Plan {
    /// `what` is the identity of the computation: of design, analysis, options, content of input files and version of
    /// the program. Parts of another identity are not used. A study with more samples has the same identity, except
    /// for Latin hypercubes, whose points depend on their number.
    ///
    /// # Errors
    /// [`StudyError`] of the layout; factors or results that share a name, a list without its entries.
    pub fn new(
        what: &str,
        factors: Vec<Factor>,
        layout: Layout,
        samples: u64,
        seed: u64,
        kept: Vec<Kept>,
    ) -> Result<Plan, StudyError> {
        let names: Vec<&str> = factors
            .iter()
            .map(|factor| factor.path.as_str())
            .chain(kept.iter().map(|kept| kept.key.as_str()))
            .chain(["sample", "failed"])
            .collect();
        if let Some((_, twice)) = names.iter().enumerate().find(|(k, name)| names[..*k].contains(name)) {
            return Err(StudyError::Sampling {
                reason: format!("`{twice}` would be the name of two columns"),
            });
        }
        if let Some(factor) = factors.iter().find(
            |factor| matches!(factor.distribution, Distribution::List { count } if count != factor.entries.len()),
        ) {
            let reason = format!("the list of `{}` does not have the stated number of entries", factor.path);
            return Err(StudyError::Sampling { reason });
        }
        let mut hash = Sha256::new();
        let all_together = matches!(layout, Layout::LatinHypercube).then_some(samples);
        for text in [
            what,
            &format!("{factors:?}"),
            &format!("{layout:?} {seed} {all_together:?}"),
            &format!("{kept:?}"),
            part::FORMAT,
        ] {
            hash.update((text.len() as u64).to_le_bytes());
            hash.update(text.as_bytes());
        }
        let identity = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        let distributions = factors.iter().map(|factor| factor.distribution).collect();
        let sampling = Sampling::new(layout, distributions, samples, seed)?;
        let least = SAMPLES_PER_PART.max((sampling.rows() / MANY_PARTS).next_power_of_two());
        let rows_per_part = least.div_ceil(sampling.rows_per_sample()).max(1) * sampling.rows_per_sample();
        Ok(Plan { factors, sampling, kept, identity, rows_per_part, name: "rows".to_owned() })
    }

    /// Another number of samples in a part.
    pub fn with_samples_per_part(mut self, samples: u64) -> Plan {
        self.rows_per_part = samples.max(1) * self.sampling.rows_per_sample();
        self
    }

    /// Another prefix of the names of its parts, for several plans in one directory.
    pub fn named(mut self, name: String) -> Plan {
        self.name = name;
        self
    }

    /// Factors in the order of the columns.
    pub fn factors(&self) -> &[Factor] {
        &self.factors
    }

    /// Points of the rows.
    pub fn sampling(&self) -> &Sampling {
        &self.sampling
    }

    /// Results that every row keeps.
    pub fn kept(&self) -> &[Kept] {
        &self.kept
    }

    /// SHA-256 of everything on which rows depend.
    pub fn identity(&self) -> &str {
        &self.identity
    }

    /// Rows in all.
    pub fn rows(&self) -> u64 {
        self.sampling.rows()
    }

    /// Parts in all.
    pub fn parts(&self) -> u64 {
        self.rows().div_ceil(self.rows_per_part)
    }

    /// Numbers of the rows of a part.
    pub fn rows_of(&self, part: u64) -> std::ops::Range<u64> {
        let first = part * self.rows_per_part;
        first..(first + self.rows_per_part).min(self.rows())
    }

    /// Name of the file of a part; it contains the size of parts, so that parts of different sizes are distinct.
    pub fn part_name(&self, part: u64) -> String {
        format!("{}-{:09}-{}.parquet", self.name, part * self.rows_per_part, self.rows_per_part)
    }

    /// The row of a number.
    pub fn row(&self, number: u64) -> Row {
        let point = self.sampling.point(number);
        let values = self.sampling.values(&point);
        let settings = self.factors.iter().zip(values).map(|(factor, value)| factor.setting(value)).collect();
        Row { number, settings, point }
    }

    /// Names and kinds of the columns of a table of rows, between `sample` and `failed`.
    pub fn columns(&self) -> Vec<(&str, Kind)> {
        let factors = self.factors.iter().map(|factor| (factor.path.as_str(), factor.kind()));
        factors.chain(self.kept.iter().map(|kept| (kept.key.as_str(), kept.kind))).collect()
    }
}
