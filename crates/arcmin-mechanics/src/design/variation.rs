//! Variation of values: ranges, factors, distributions and lists, as `[unknowns]` of a design and `[vary]` of a
//! study write them.
//!
//! * `{ low = 2, high = 12 }`: evenly between the two; with `distribution = "log-uniform"` evenly in the
//!   logarithm;
//! * `{ factor = 3 }`: from a third of the nominal value to three times it, evenly in the logarithm; with
//!   `distribution = "uniform"` evenly in the value;
//! * `{ mean = 8.75, deviation = 0.05 }`: normal, cut at three standard deviations; with `mean` left out about
//!   the nominal value;
//! * `[2, 3]`: one of these, each as likely as the others.

use std::ops::Range;

use super::error::{DesignError, DesignErrorKind};
use super::field::{Choice, FieldValue, Result, SectionValue, Table, join};
use super::hint::plain;
use super::schema::{Key, Kind, optional, section};
use super::tree::{Item, Node};
use super::value::Value;

section! {
    /// Variation of one value, written behind its path. A list such as `[2, 3]` instead of the table: one of
    /// these.
    pub struct VariationTable {
        /// Least value.
        low: Option<f64> => optional(f64::NEG_INFINITY, f64::INFINITY),
        /// Largest value.
        high: Option<f64> => optional(f64::NEG_INFINITY, f64::INFINITY),
        /// From the nominal value divided by this to the nominal value times this.
        factor: Option<f64> => optional(1.0, 1e9),
        /// Mean of a normal distribution. Left out, the nominal value.
        mean: Option<f64> => optional(f64::NEG_INFINITY, f64::INFINITY),
        /// Standard deviation of a normal distribution, which is cut at three of them.
        deviation: Option<f64> => optional(0.0, f64::INFINITY),
        /// Distribution. Left out, it is `"uniform"` between `low` and `high`, `"log-uniform"` with `factor`
        /// and `"normal"` with `deviation`.
        distribution: Option<DistributionName> => optional(0.0, 0.0),
    }
}

/// Distributions by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DistributionName {
    /// All values between two bounds are equally likely.
    Uniform,
    /// All logarithms between those of two bounds are equally likely.
    LogUniform,
    /// Gaussian, cut at three standard deviations.
    Normal,
}

impl Choice for DistributionName {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("uniform", "evenly in the value"),
        ("log-uniform", "evenly in its logarithm"),
        ("normal", "about `mean` with `deviation`"),
    ];
    const VALUES: &'static [DistributionName] =
        &[DistributionName::Uniform, DistributionName::LogUniform, DistributionName::Normal];
}

/// Variation of a value, as written.
#[derive(Debug, Clone, PartialEq)]
pub enum Variation {
    /// Between two bounds.
    Between {
        /// Lower bound in the unit of the key.
        low: f64,
        /// Upper bound in the unit of the key.
        high: f64,
        /// Whether logarithms are equally likely rather than values.
        logarithmic: bool,
    },
    /// From nominal/factor to nominal × factor, for positive nominal values.
    Factor {
        /// Ratio of either bound to the nominal value, above 1.
        factor: f64,
        /// Whether logarithms are equally likely rather than values.
        logarithmic: bool,
    },
    /// Gaussian, cut at three standard deviations.
    Normal {
        /// Mean in the unit of the key; `None` for the nominal value.
        mean: Option<f64>,
        /// Standard deviation in the unit of the key.
        deviation: f64,
    },
    /// Each of the values is as likely as the others.
    OneOf(Vec<Value>),
}

/// A distribution of numbers with its bounds.
#[derive(Debug, Clone, PartialEq)]
pub enum Distribution {
    /// All values between the bounds are equally likely.
    Uniform {
        /// Lower bound in the unit of the key.
        low: f64,
        /// Upper bound in the unit of the key.
        high: f64,
    },
    /// All logarithms between those of the bounds are equally likely.
    LogUniform {
        /// Lower bound in the unit of the key, positive.
        low: f64,
        /// Upper bound in the unit of the key.
        high: f64,
    },
    /// Cut at three standard deviations.
    Normal {
        /// Mean in the unit of the key.
        mean: f64,
        /// Standard deviation in the unit of the key.
        deviation: f64,
    },
    /// Each as likely as the others.
    OneOf(Vec<f64>),
}

/// Standard deviations at which a normal distribution is cut, as that of tolerances.
pub const NORMAL_CUT: f64 = 3.0;

impl Variation {
    /// The distribution about a nominal value.
    ///
    /// # Errors The reason why there is no distribution, in a sentence: a factor on zero or on a negative
    /// value, a list of words.
    pub fn about(&self, nominal: f64) -> std::result::Result<Distribution, String> {
        Ok(match *self {
            Variation::Between { low, high, logarithmic: true } => Distribution::LogUniform { low, high },
            Variation::Between { low, high, logarithmic: false } => Distribution::Uniform { low, high },
            Variation::Factor { factor, logarithmic } => {
                if !(nominal > 0.0) {
                    return Err(format!(
                        "a factor on {} is not a range: give `low` and `high`",
                        plain(nominal)
                    ));
                }
                let (low, high) = (nominal / factor, nominal * factor);
                if logarithmic {
                    Distribution::LogUniform { low, high }
                } else {
                    Distribution::Uniform { low, high }
                }
            }
            Variation::Normal { mean, deviation } => {
                Distribution::Normal { mean: mean.unwrap_or(nominal), deviation }
            }
            Variation::OneOf(ref values) => {
                let numbers: Option<Vec<f64>> = values.iter().map(Value::as_number).collect();
                Distribution::OneOf(numbers.ok_or("words have no distribution of numbers".to_owned())?)
            }
        })
    }
}

impl Distribution {
    /// Least and largest value.
    pub fn bounds(&self) -> [f64; 2] {
        match self {
            Distribution::Uniform { low, high } | Distribution::LogUniform { low, high } => [*low, *high],
            Distribution::Normal { mean, deviation } => {
                [mean - NORMAL_CUT * deviation, mean + NORMAL_CUT * deviation]
            }
            Distribution::OneOf(values) => values
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)]),
        }
    }

    /// The value below which the part `share` (0 to 1) of the distribution lies: maps evenly spread numbers,
    /// random or of a space-filling design, to values.
    pub fn quantile(&self, share: f64) -> f64 {
        let share = share.clamp(0.0, 1.0);
        match self {
            Distribution::Uniform { low, high } => low + share * (high - low),
            Distribution::LogUniform { low, high } => {
                (low.ln() + share * (high / low).ln()).exp().clamp(*low, *high)
            }
            Distribution::Normal { mean, deviation } => {
                let cut = statrs::function::erf::erf(NORMAL_CUT / std::f64::consts::SQRT_2);
                let inside = statrs::function::erf::erf_inv(cut * (2.0 * share - 1.0));
                mean + deviation * (std::f64::consts::SQRT_2 * inside).clamp(-NORMAL_CUT, NORMAL_CUT)
            }
            Distribution::OneOf(values) => {
                let index = (share * values.len() as f64) as usize;
                values.get(index.min(values.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
            }
        }
    }
}

/// Paths of keys, each with how its value varies.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Variations(pub Vec<Varied>);

/// One key that varies.
#[derive(Debug, Clone, PartialEq)]
pub struct Varied {
    /// Path of the key.
    pub path: String,
    /// Variation as the file gives it.
    pub variation: Variation,
    /// Bytes of the path in the text.
    pub path_span: Range<usize>,
    /// Bytes of the variation in the text.
    pub span: Range<usize>,
}

impl FieldValue for Variations {
    fn kind() -> Kind {
        Kind::Variations(VariationTable::schema())
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<Self> {
        let Node::Table(branch) = &item.node else {
            return Err(table.wrong_type(
                key,
                format!("a section, [{}]", join(&table.path(), key.name)),
                item,
            ));
        };
        let section = table.sub_table(key.name, branch, item.span.clone());
        let varied = |entry: &super::tree::Entry| {
            Ok(Varied {
                path: entry.key.to_string(),
                variation: variation(&entry.key, &entry.item, &section)?,
                path_span: entry.key_span.clone(),
                span: entry.item.span.clone(),
            })
        };
        branch.entries.iter().map(varied).collect::<Result<_>>().map(Variations)
    }

    fn absent(_: &Key, _: &Table<'_>) -> Result<Self> {
        Ok(Variations::default())
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        let mut lines: Vec<String> = self
            .0
            .iter()
            .map(|varied| format!("{path}.{:?} = {:?}", varied.path, varied.variation))
            .collect();
        lines.sort();
        out.extend(lines);
    }
}

const FORMS: &str =
    "write { low = …, high = … }, { factor = … }, { mean = …, deviation = … } or a list of values";

fn variation(path: &str, item: &Item, section: &Table<'_>) -> Result<Variation> {
    let wrong = |message: String| -> Box<DesignError> {
        let kind = DesignErrorKind::Contradiction { message };
        section.source.error(kind, item.span.clone(), Some(FORMS.to_owned()))
    };
    let inner = match &item.node {
        Node::List(rows) if !rows.is_empty() => {
            let values = rows.iter().map(|row| match &row.node {
                Node::Number(number) if number.is_finite() => Some(Value::Number(*number)),
                Node::Text(text) => Some(Value::Text(text.to_string())),
                Node::Flag(flag) => Some(Value::Flag(*flag)),
                _ => None,
            });
            let values: Option<Vec<Value>> = values.collect();
            return values
                .map(Variation::OneOf)
                .ok_or_else(|| wrong(format!("the list of `{path}` contains an entry that is not a value")));
        }
        Node::Table(inner) => inner,
        _ => return Err(wrong(format!("the variation of `{path}` is missing"))),
    };
    let table = VariationTable::from_table(&section.sub_table(path, inner, item.span.clone()))?;
    let name = *table.distribution;
    let logarithmic = |default: bool| match name {
        None => Ok(default),
        Some(DistributionName::LogUniform) => Ok(true),
        Some(DistributionName::Uniform) => Ok(false),
        Some(DistributionName::Normal) => {
            Err(wrong(format!("the normal distribution of `{path}` needs `deviation`")))
        }
    };
    match (*table.low, *table.high, *table.factor, *table.mean, *table.deviation) {
        (Some(low), Some(high), None, None, None) => {
            let logarithmic = logarithmic(false)?;
            if !(low < high) {
                Err(wrong(format!(
                    "`{path}` varies from {} to {}, which is not a range",
                    plain(low),
                    plain(high)
                )))
            } else if logarithmic && !(low > 0.0) {
                Err(wrong(format!("`{path}` cannot vary logarithmically from {}", plain(low))))
            } else {
                Ok(Variation::Between { low, high, logarithmic })
            }
        }
        (None, None, Some(factor), None, None) => {
            if !(factor > 1.0) {
                return Err(wrong(format!("a factor of {} leaves `{path}` unchanged", plain(factor))));
            }
            Ok(Variation::Factor { factor, logarithmic: logarithmic(true)? })
        }
        (None, None, None, mean, Some(deviation)) if deviation > 0.0 => match name {
            None | Some(DistributionName::Normal) => Ok(Variation::Normal { mean, deviation }),
            Some(_) => {
                Err(wrong(format!("`deviation` makes `{path}` normal, but its `distribution` is another")))
            }
        },
        _ => Err(wrong(format!("the variation of `{path}` has none of the allowed forms"))),
    }
}
