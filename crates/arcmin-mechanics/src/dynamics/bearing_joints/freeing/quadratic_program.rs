//! Quadratic program with linear constraints, each with a quadratic penalty.

/// Constraints a·x ≥ b; the first `bonds` of them are equations, a·x = b.
#[derive(Debug)]
pub(super) struct Limits {
    pub width: usize,
    pub bonds: usize,
    /// All a, row by row.
    pub rows: Vec<f64>,
    pub bounds: Vec<f64>,
}

/// Penalties.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Penalties {
    /// ρ: ½ ρ |x|² for a displacement x.
    pub step: f64,
    /// κ: ½ κ s² for a constraint violated by s.
    pub limit: f64,
}

/// Tolerance of inactive constraints, in the unit of the bounds.
const SLACK: f64 = 1e-8;

impl Limits {
    pub fn row(&self, number: usize) -> &[f64] {
        &self.rows[number * self.width..(number + 1) * self.width]
    }

    fn count(&self) -> usize {
        self.bounds.len()
    }

    /// Slack a·x − b.
    pub fn room(&self, number: usize, x: &[f64]) -> f64 {
        dot(self.row(number), x) - self.bounds[number]
    }

    /// Cost of the constraints violated by these slacks.
    pub fn cost(&self, rooms: impl Iterator<Item = f64>, penalty: f64) -> f64 {
        let broken = rooms.enumerate().filter(|(i, room)| *i < self.bonds || *room < 0.0);
        0.5 * penalty * broken.map(|(_, room)| room * room).sum::<f64>()
    }

    /// The x that maximises c·x − ½ ρ |x|² − ½ κ Σ s²; `None` after too many changes of the active set.
    ///
    /// Dual active-set method of Goldfarb and Idnani (Math. Programming 27 (1983) 1): from the unconstrained
    /// optimum, one violated constraint after another is added along the shortest direction that keeps the
    /// active ones, and one is dropped if its multiplier would become negative. Because every constraint has a
    /// penalty instead of being exact, they cannot contradict each other. If ρ is small compared with the
    /// multipliers, the solution is the smallest of those without it: bodies without a reason to move remain in
    /// place.
    pub fn best(&self, c: &[f64], penalties: Penalties) -> Option<Vec<f64>> {
        let mut search = Search {
            limits: self,
            give: penalties.step / penalties.limit,
            x: c.iter().map(|c| c / penalties.step).collect(),
            held: Vec::new(),
            multipliers: Vec::new(),
            factor: Vec::new(),
        };
        for bond in 0..self.bonds {
            search.add_constraint(bond);
        }
        for _ in 0..4 * (self.count() + self.width) {
            let Some(broken) = search.most_broken() else { return Some(search.x) };
            search.add_constraint(broken);
        }
        None
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

struct Search<'a> {
    limits: &'a Limits,
    /// ρ/κ.
    give: f64,
    x: Vec<f64>,
    /// Active constraints, and their multipliers divided by ρ.
    held: Vec<usize>,
    multipliers: Vec<f64>,
    /// R of RᵀR = N Nᵀ + (ρ/κ) I, with N the active normals: column k has k + 1 entries.
    factor: Vec<Vec<f64>>,
}

impl Search<'_> {
    fn most_broken(&self) -> Option<usize> {
        let free = (self.limits.bonds..self.limits.count()).filter(|i| !self.held.contains(i));
        let (least, room) =
            free.map(|i| (i, self.limits.room(i, &self.x))).min_by(|a, b| a.1.total_cmp(&b.1))?;
        (room < -SLACK).then_some(least)
    }

    /// Adds a constraint to the active set; drops others whose multipliers would become negative.
    fn add_constraint(&mut self, limit: usize) {
        let normal = self.limits.row(limit);
        let mut multiplier = 0.0;
        loop {
            let column = self.column(normal);
            let change = self.solved(&column);
            let free = (dot(normal, normal) + self.give - dot(&column, &column)).max(self.give);
            let room = self.limits.room(limit, &self.x) + self.give * multiplier;
            let sense = if room > 0.0 { -1.0 } else { 1.0 };
            let whole = room.abs() / free;
            let blocking = (0..self.held.len())
                .filter(|k| self.held[*k] >= self.limits.bonds && sense * change[*k] > 0.0)
                .map(|k| (self.multipliers[k] / (sense * change[k]), k))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .filter(|(length, _)| *length < whole);
            let length = sense * blocking.map_or(whole, |(length, _)| length);
            multiplier += length;
            self.x.iter_mut().zip(normal).for_each(|(x, a)| *x += length * a);
            for (k, by) in change.iter().enumerate() {
                self.multipliers[k] -= length * by;
                let row = self.limits.row(self.held[k]);
                self.x.iter_mut().zip(row).for_each(|(x, a)| *x -= length * by * a);
            }
            match blocking {
                Some((_, k)) => self.remove_constraint(k),
                None => {
                    let mut column = column;
                    column.push(free.sqrt());
                    self.factor.push(column);
                    self.held.push(limit);
                    return self.multipliers.push(multiplier);
                }
            }
        }
    }

    /// R⁻ᵀ N a.
    fn column(&self, normal: &[f64]) -> Vec<f64> {
        let mut column: Vec<f64> = Vec::with_capacity(self.held.len() + 1);
        for (held, factor) in self.held.iter().zip(&self.factor) {
            let k = column.len();
            let product = dot(self.limits.row(*held), normal) - dot(&column, &factor[..k]);
            column.push(product / factor[k]);
        }
        column
    }

    /// R⁻¹ w.
    fn solved(&self, column: &[f64]) -> Vec<f64> {
        let mut out = column.to_vec();
        for (k, factor) in self.factor.iter().enumerate().rev() {
            out[k] /= factor[k];
            let last = out[k];
            out[..k].iter_mut().zip(factor).for_each(|(x, r)| *x -= last * r);
        }
        out
    }

    /// Removes a constraint; rotations of rows restore the triangular form of R.
    fn remove_constraint(&mut self, at: usize) {
        self.held.remove(at);
        self.multipliers.remove(at);
        self.factor.remove(at);
        for k in at..self.factor.len() {
            let (a, b) = (self.factor[k][k], self.factor[k][k + 1]);
            let size = a.hypot(b);
            let (cos, sin) = (a / size, b / size);
            for column in &mut self.factor[k..] {
                let (a, b) = (column[k], column[k + 1]);
                (column[k], column[k + 1]) = (cos * a + sin * b, cos * b - sin * a);
            }
            self.factor[k].truncate(k + 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PENALTIES: Penalties = Penalties { step: 1e-4, limit: 1e8 };

    fn limits(width: usize, bonds: usize, rows: &[&[f64]], bounds: &[f64]) -> Limits {
        Limits { width, bonds, rows: rows.concat(), bounds: bounds.to_vec() }
    }

    /// Maximum of x + 2 y for x, y ≥ 0, x + y ≤ 4, x + 3 y ≤ 6: the corner (3, 1).
    #[test]
    fn a_corner_of_a_known_program() {
        let limits =
            limits(2, 0, &[&[1.0, 0.0], &[0.0, 1.0], &[-1.0, -1.0], &[-1.0, -3.0]], &[0.0, 0.0, -4.0, -6.0]);
        let x = limits.best(&[1.0, 2.0], PENALTIES).unwrap();
        assert!((x[0] - 3.0).abs() < 1e-7 && (x[1] - 1.0).abs() < 1e-7, "{x:?}");
    }

    /// Contradictory constraints are violated by equal parts.
    #[test]
    fn contradictory_constraints_are_violated_equally() {
        let apart = limits(1, 0, &[&[1.0], &[-1.0]], &[1.0, 0.0]);
        assert!((apart.best(&[0.0], PENALTIES).unwrap()[0] - 0.5).abs() < 1e-6);
        let bonds = limits(2, 2, &[&[1.0, 1.0], &[1.0, 1.0]], &[1.0, 3.0]);
        let x = bonds.best(&[0.0, 0.0], PENALTIES).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-6 && (x[1] - 1.0).abs() < 1e-6, "{x:?}");
    }

    proptest! {
        /// At the solution the gradient of the total cost, which has one minimum, vanishes.
        #[test]
        fn the_gradient_vanishes_at_the_solution(
            rows in prop::collection::vec(prop::collection::vec(-1.0..1.0_f64, 5), 1..60),
            bounds in prop::collection::vec(-1.0..0.5_f64, 60),
            c in prop::collection::vec(-1.0..1.0_f64, 5),
            bonds in 0..4_usize,
        ) {
            let bounds = bounds[..rows.len()].to_vec();
            let limits = Limits { width: 5, bonds: bonds.min(rows.len()), rows: rows.concat(), bounds };
            let penalties = Penalties { step: 1e-3, limit: 1e3 };
            let x = limits.best(&c, penalties).unwrap();
            for i in 0..5 {
                let gradient = (0..rows.len()).fold(c[i] - penalties.step * x[i], |gradient, row| {
                    let room = limits.room(row, &x);
                    let presses = row < limits.bonds || room < 0.0;
                    if presses { gradient - penalties.limit * room * rows[row][i] } else { gradient }
                });
                prop_assert!(gradient.abs() < 1e-3, "{i}: {gradient}");
            }
        }
    }
}
