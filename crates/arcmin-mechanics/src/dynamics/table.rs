use serde::{Deserialize, Serialize};

use super::DynamicsError;

/// A quantity at increasing times, linearly interpolated, and constant beyond the ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimeTable {
    times: Vec<f64>,
    values: Vec<f64>,
    /// Integral from the first time.
    integrals: Vec<f64>,
}

impl TimeTable {
    /// From rows (time in s, value).
    ///
    /// # Errors
    /// [`DynamicsError::TableRunsBackwards`] with the row; [`DynamicsError::BadTable`] for an empty table or
    /// values that are not finite.
    pub fn new(name: &'static str, rows: &[(f64, f64)]) -> Result<TimeTable, DynamicsError> {
        TimeTable::checked(name, rows, |rows, row| rows[row].0 > rows[row - 1].0)
    }

    /// From rows of which two may have the same time: there the value jumps from the first to the second.
    ///
    /// # Errors
    /// As [`TimeTable::new`]; three rows at one time are an error.
    pub fn with_jumps(name: &'static str, rows: &[(f64, f64)]) -> Result<TimeTable, DynamicsError> {
        TimeTable::checked(name, rows, |rows, row| {
            rows[row].0 >= rows[row - 1].0 && (row < 2 || rows[row].0 > rows[row - 2].0)
        })
    }

    fn checked(
        name: &'static str,
        rows: &[(f64, f64)],
        follows: fn(&[(f64, f64)], usize) -> bool,
    ) -> Result<TimeTable, DynamicsError> {
        if rows.is_empty() {
            return Err(DynamicsError::BadTable { table: name, message: "it has no rows" });
        }
        if rows.iter().any(|(t, x)| !t.is_finite() || !x.is_finite()) {
            return Err(DynamicsError::BadTable {
                table: name,
                message: "a time or value is not a finite number",
            });
        }
        for (index, pair) in rows.windows(2).enumerate() {
            let ((previous, _), (time, _)) = (pair[0], pair[1]);
            if !follows(rows, index + 1) {
                // Rows are counted from 1, as an editor shows them under one header row.
                return Err(DynamicsError::TableRunsBackwards {
                    table: name,
                    row: index + 2,
                    time,
                    previous,
                });
            }
        }
        let mut integrals = vec![0.0];
        for pair in rows.windows(2) {
            let last = integrals[integrals.len() - 1];
            integrals.push(last + 0.5 * (pair[1].0 - pair[0].0) * (pair[0].1 + pair[1].1));
        }
        Ok(TimeTable {
            times: rows.iter().map(|r| r.0).collect(),
            values: rows.iter().map(|r| r.1).collect(),
            integrals,
        })
    }

    /// Value at `time` (s).
    pub fn value(&self, time: f64) -> f64 {
        self.sample(time).0
    }

    /// Integral of the value from time 0 to `time` (s).
    pub fn integral(&self, time: f64) -> f64 {
        self.sample(time).1 - self.sample(0.0).1
    }

    /// First jump after `time` (s).
    pub fn next_jump(&self, time: f64) -> Option<f64> {
        let after = self.times.partition_point(|t| *t <= time);
        self.times[after..].windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0])
    }

    fn sample(&self, time: f64) -> (f64, f64) {
        let right = self.times.partition_point(|t| *t <= time);
        let last = self.times.len() - 1;
        if right == 0 {
            return (self.values[0], (time - self.times[0]) * self.values[0]);
        }
        let left = right - 1;
        let x = time - self.times[left];
        if left == last {
            return (self.values[last], self.integrals[last] + x * self.values[last]);
        }
        let slope = (self.values[right] - self.values[left]) / (self.times[right] - self.times[left]);
        (self.values[left] + slope * x, self.integrals[left] + x * (self.values[left] + 0.5 * slope * x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_lines_and_their_integral() {
        let table = TimeTable::new("speed", &[(0.0, 0.0), (0.1, 10.0), (0.3, 10.0), (0.4, -10.0)]).unwrap();
        assert!(
            (table.value(0.05) - 5.0).abs() < 1e-12 && table.value(-1.0) == 0.0 && table.value(9.0) == -10.0
        );
        assert!((table.integral(0.1) - 0.5).abs() < 1e-12);
        assert!((table.integral(0.3) - 2.5).abs() < 1e-12);
        assert!((table.integral(0.35) - 2.75).abs() < 1e-12);
        assert!((table.integral(0.5) - 1.5).abs() < 1e-12);
    }

    /// Two rows at one time are a step: linear on either side, with the second value at the time itself.
    #[test]
    fn two_rows_at_one_time_are_a_step() {
        let rows = [(0.0, 0.0), (0.1, 10.0), (0.1, -10.0), (0.3, -10.0), (0.3, 4.0)];
        assert!(TimeTable::new("load table", &rows).is_err());
        let table = TimeTable::with_jumps("load table", &rows).unwrap();
        assert!((table.value(0.1 - 1e-9) - 10.0).abs() < 1e-6);
        assert_eq!(
            (table.value(0.1), table.value(0.2), table.value(0.3), table.value(9.0)),
            (-10.0, -10.0, 4.0, 4.0)
        );
        assert_eq!(
            (table.next_jump(0.0), table.next_jump(0.1), table.next_jump(0.3)),
            (Some(0.1), Some(0.3), None)
        );
        assert!((table.integral(0.3) - (0.5 - 2.0)).abs() < 1e-12);
        assert!(
            TimeTable::with_jumps("load table", &[(0.0, 0.0), (0.1, 1.0), (0.1, 2.0), (0.1, 3.0)]).is_err()
        );
    }

    #[test]
    fn a_table_that_runs_backwards_names_the_row() {
        let error = TimeTable::new("load table", &[(0.0, 0.0), (0.2, 1.0), (0.1, 2.0)]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "load table: time 0.1 s in row 3 is not later than 0.2 s in the row before"
        );
        assert!(TimeTable::new("load table", &[]).is_err());
        assert!(TimeTable::new("load table", &[(0.0, f64::NAN)]).is_err());
    }
}
