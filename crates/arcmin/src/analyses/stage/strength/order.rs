//! The torque at which each part reaches its limit.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use super::{Bearing, Borne, Strength, loads};
use crate::analyses::stage::EccentricDrive;
use crate::checks::{Finding, Severity};
use crate::report::significant;
use crate::results::{Column, PLAIN, TableOf, Value, digits, quantity};
use crate::units::MPA;

/// Torques at which the loads are computed: the largest of rating and duty times powers of two with these exponents.
const EXPONENTS: RangeInclusive<i32> = -6..=7;

/// Torque (N·m) at which each part reaches its limit, from static equilibria at torques a factor of two apart and powers of the
/// torque between them; `None` beyond those torques, and where no static equilibrium is found.
pub(super) fn torques(design: &impl EccentricDrive, torque: f64, at_torque: &[Borne]) -> Vec<Option<f64>> {
    let mut shares: BTreeMap<i32, Option<Vec<f64>>> = BTreeMap::new();
    shares.insert(0, Some(at_torque.iter().map(Borne::share).collect()));
    let mut share = |exponent: i32, part: usize| -> Option<f64> {
        let all = shares.entry(exponent).or_insert_with(|| {
            let found = loads(design, torque * 2.0_f64.powi(exponent)).ok()?;
            Some(found.borne.iter().map(Borne::share).collect())
        });
        all.as_ref().map(|all| all[part])
    };
    let mut torque_of = |part: usize| {
        let mut here = (0, share(0, part)?);
        let step = if here.1 < 1.0 { 1 } else { -1 };
        loop {
            let exponent = here.0 + step;
            if !EXPONENTS.contains(&exponent) {
                return None;
            }
            let next = (exponent, share(exponent, part)?);
            if (next.1 < 1.0) != (step > 0) {
                return Some(torque * 2.0_f64.powf(crossing(here, next)));
            }
            here = next;
        }
    };
    (0..at_torque.len()).map(&mut torque_of).collect()
}

/// Exponent at which a share that follows a power between two exponents is 1.
fn crossing((low, at_low): (i32, f64), (high, at_high): (i32, f64)) -> f64 {
    f64::from(low) - f64::from(high - low) * at_low.ln() / (at_high.ln() - at_low.ln())
}

/// A part with the torque at which it reaches its limit.
#[derive(Debug, Clone)]
pub struct Failure {
    stage: &'static str,
    pub borne: Borne,
    /// N·m; `None` beyond the computed torques.
    pub torque: Option<f64>,
}

/// A part a row, the first that reaches its limit first.
pub const FAILURES: TableOf<Failure> = TableOf {
    name: "strength",
    what: "One row per part, in the order in which the parts reach their limits as the torque rises",
    columns,
};

fn columns() -> Vec<Column<Failure>> {
    vec![
        quantity("stage", PLAIN, "Stage or ring of the part.").of(|f: &Failure| f.stage.into()),
        quantity("part", PLAIN, "Which part bears.").of(|f| f.borne.bearing.words(f.borne.ring)[0].into()),
        quantity("load", PLAIN, "contact, bending or shear.").of(|f| f.borne.bearing.words(f.borne.ring)[1].into()),
        quantity("stress_mpa", digits(4), "Largest stress under the largest torque of rating and duty.")
            .of(|f| (f.borne.stress / MPA).into()),
        quantity(
            "limit_mpa",
            digits(4),
            "Stress at which the material yields: the yield strength; 1/√3 of it in shear; 1.67 times of it in \
                 contact.",
        )
        .of(|f| (f.borne.limit / MPA).into()),
        quantity("material", PLAIN, "Material of the part, of contacts the softer one.")
            .of(|f| f.borne.material.clone().into()),
        quantity(
            "torque_at_limit_n_m",
            digits(4),
            "Output torque at which the stress reaches its limit; empty beyond 128 times the largest torque of the \
                 design.",
        )
        .of(|f| Value::from(f.torque)),
    ]
}

impl Strength {
    /// Parts in the order in which they reach their limits; empty if no torques were computed.
    pub fn order(&self) -> Vec<Failure> {
        let failure = |(borne, torque): (&Borne, &Option<f64>)| Failure {
            stage: self.stages[borne.stage].name,
            borne: borne.clone(),
            torque: *torque,
        };
        let mut order: Vec<Failure> = self.borne().iter().zip(&self.torques).map(failure).collect();
        let by = |failure: &Failure| failure.torque.unwrap_or(f64::INFINITY);
        order.sort_by(|a, b| by(a).total_cmp(&by(b)).then(b.borne.share().total_cmp(&a.borne.share())));
        order
    }

    /// The same as records with the columns of [`FAILURES`].
    pub fn order_value(&self) -> Value {
        let columns = columns();
        let record = |failure: &Failure| {
            Value::Record(columns.iter().map(|c| (c.quantity.key, c.value(failure))).collect())
        };
        Value::List(self.order().iter().map(record).collect())
    }

    /// Order in which parts yield.
    pub(super) fn order_finding(&self) -> Option<Finding> {
        let order = self.order();
        let first = order.first()?;
        // For each kind of part only the load that reaches its limit first.
        let mut listed: Vec<(usize, &str)> = Vec::new();
        let (mut sequence, mut beyond) = (Vec::new(), 0);
        for Failure { borne, torque, .. } in &order {
            let [part, load] = borne.bearing.words(borne.ring);
            if listed.contains(&(borne.stage, part)) {
                continue;
            }
            listed.push((borne.stage, part));
            let is_contact = matches!(borne.bearing, Bearing::RingContact | Bearing::OutputContact);
            let load = if is_contact { String::new() } else { format!(" in {load}") };
            match torque {
                Some(torque) => {
                    let at = significant(*torque, 3);
                    sequence.push(format!("{}{part}{load} at {at} N·m", self.place(borne)));
                }
                None => beyond += 1,
            }
        }
        if beyond > 0 {
            sequence.push(format!("others beyond {} N·m", significant(self.farthest(), 3)));
        }
        Some(Finding {
            code: "failure-order",
            severity: Severity::Info,
            message: format!("as the torque rises, parts yield in this order: {}", sequence.join(", ")),
            value: first.torque.unwrap_or(self.farthest()),
            limit: self.torque,
            unit: "N·m",
            why: "the part that yields first limits the torque: strengthening any other part has no effect",
            change: "no change is needed if the first torque includes the required safety factor",
        })
    }

    /// Largest torque at which the loads are computed, N·m.
    fn farthest(&self) -> f64 {
        self.torque * 2.0_f64.powi(*EXPONENTS.end())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A share proportional to a power of the torque reaches 1 at the torque of the closed form, from below and from above.
    #[test]
    fn powers_cross_one_where_they_must() {
        for power in [0.5, 1.0, 1.7] {
            let share = |exponent: i32| 0.3 * 2.0_f64.powi(exponent).powf(power);
            let exact = (1.0_f64 / 0.3).log2() / power;
            let low = exact.floor() as i32;
            assert!((crossing((low, share(low)), (low + 1, share(low + 1))) - exact).abs() < 1e-12);
            assert!((crossing((low + 1, share(low + 1)), (low, share(low))) - exact).abs() < 1e-12);
        }
    }
}
