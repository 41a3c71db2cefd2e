/// A result to be minimised or maximised.
#[derive(Debug, Clone, PartialEq)]
pub struct Goal {
    /// Key of the result.
    pub key: String,
    /// Whether it is to be large.
    pub largest: bool,
    /// Quantile: share of machines whose value is at least as good; 0.95 for lives is the life that 95 % of machines
    /// reach. `None`: the mean.
    pub share: Option<f64>,
}

/// Condition that a share of machines must keep.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// Key of the result.
    pub key: String,
    /// Least value allowed, in the unit of the key.
    pub low: Option<f64>,
    /// Largest value allowed, in the unit of the key.
    pub high: Option<f64>,
    /// Share of the machines that must keep it, between 0 and 1.
    pub share: f64,
}

/// The value that at least `share` of the values do not exceed: the ⌈share n⌉-th smallest; infinite for none.
pub fn reached(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    // 0.95 × 20 must be 19 in spite of rounding.
    let index = ((share * sorted.len() as f64 - 1e-9).ceil() as usize).max(1) - 1;
    sorted.get(index).copied().unwrap_or(f64::INFINITY)
}

impl Goal {
    /// Value to be minimised, from the values of all machines of a design.
    pub(super) fn of(&self, values: &[f64]) -> f64 {
        let sign = if self.largest { -1.0 } else { 1.0 };
        let signed: Vec<f64> = values.iter().map(|value| sign * value).collect();
        match self.share {
            Some(share) => reached(&signed, share),
            None => signed.iter().sum::<f64>() / signed.len() as f64,
        }
    }

    /// The value from the one to be minimised.
    pub fn value(&self, small: f64) -> f64 {
        if self.largest { -small } else { small }
    }

    /// In words, such as "95 % of machines have at least"; empty where machines do not differ.
    pub fn words(&self, machines: u64) -> String {
        match self.share {
            _ if machines == 1 => String::new(),
            Some(share) => {
                let percent = crate::report::compact(100.0 * share, 3);
                let end = if self.largest { "at least" } else { "at most" };
                format!("{percent} % of machines have {end}")
            }
            None => "mean".to_owned(),
        }
    }
}

impl Bound {
    /// By how much each end is exceeded, as a share of its size; `values` are those for the low and the high
    /// end.
    pub(super) fn exceeded(&self, [for_low, for_high]: [&[f64]; 2]) -> Vec<f64> {
        let scale = |limit: f64| if limit == 0.0 { 1.0 } else { limit.abs() };
        let mut all = Vec::new();
        if let Some(low) = self.low {
            let negative: Vec<f64> = for_low.iter().map(|value| -value).collect();
            all.push((low + reached(&negative, self.share)) / scale(low));
        }
        if let Some(high) = self.high {
            all.push((reached(for_high, self.share) - high) / scale(high));
        }
        all
    }

    /// The decisive value at each bounded end.
    pub fn deciding(&self, values: &[f64]) -> Vec<f64> {
        let negative: Vec<f64> = values.iter().map(|value| -value).collect();
        let low = self.low.map(|_| -reached(&negative, self.share));
        low.into_iter().chain(self.high.map(|_| reached(values, self.share))).collect()
    }
}
