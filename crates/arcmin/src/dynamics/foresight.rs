//! Steps that mind which contacts open and close on their way.

use std::ops::Range;

use super::{Gap, Linearisation, System, Weights};

/// Gaps this near (m) are looked at.
const REACH: f64 = 15e-6;
/// Changes of the contacts that press after which their last guess is taken.
const ROUNDS: usize = 12;

/// Where a search stands.
pub(super) struct Here<'a, L> {
    pub time: f64,
    pub position: &'a [f64],
    pub force: &'a [f64],
    pub tangent: &'a L,
    /// μ: the bodies' masses hold a step back with μ M.
    pub inertia: f64,
    /// A coordinate that does not move.
    pub held: Option<usize>,
}

/// Newton's method on the machine with its forces and gaps to first order, each contact a spring that only pushes.
///
/// The tangent knows the contacts that press here. A step by it alone runs into others, or is held back by some that
/// would open. Here (μ M + K) x = Q is solved anew with a spring k g gᵀ and its force for every gap that the last x
/// closed, and without those that it opened, until x changes none any more. Where bodies hang loose in their joints,
/// the mass term lets them go as far as the next contact.
pub(super) struct Foresight<L> {
    tangent: L,
    gaps: Gaps,
    force: Vec<f64>,
    trial: Vec<f64>,
}

impl<L: Linearisation> Foresight<L> {
    pub fn new<S: System<Linearisation = L>>(system: &S) -> Foresight<L> {
        Foresight {
            tangent: system.linearisation_at_rest(),
            gaps: Gaps::default(),
            force: Vec::new(),
            trial: Vec::new(),
        }
    }

    /// Makes `step`, which the tangent alone tells, one that minds the contacts, and returns the work of the springs
    /// along it, in J, against which what is left of the forces at its end is judged. `None` where the system shows no
    /// gaps or no such step is found: then `step` is as it was.
    pub fn mind<S: System<Linearisation = L>>(
        &mut self,
        system: &S,
        here: &Here<'_, L>,
        step: &mut [f64],
    ) -> Option<f64> {
        self.gaps.clear();
        system.gaps(here.time, here.position, REACH, &mut |gap| self.gaps.push(gap, here.held));
        if self.gaps.is_empty() {
            return None;
        }
        let weights = Weights { mass: here.inertia, damping: 0.0, stiffness: 1.0 };
        self.tangent.copy_stiffness(here.tangent);
        self.force.clear();
        self.force.extend_from_slice(here.force);
        self.trial.clear();
        self.trial.extend_from_slice(step);
        let mut work = None;
        for _ in 0..ROUNDS {
            let is_changed = self.gaps.follow(&self.trial, &mut self.tangent, &mut self.force);
            if !is_changed && work.is_some() {
                break;
            }
            self.trial.copy_from_slice(&self.force);
            self.tangent.solve(system.mass(), weights, &mut self.trial).ok()?;
            work = Some(self.force.iter().zip(&self.trial).map(|(f, x)| f * x).sum());
        }
        step.copy_from_slice(&self.trial);
        work
    }
}

/// Gaps at one place.
#[derive(Default)]
struct Gaps {
    index: Vec<usize>,
    gradient: Vec<f64>,
    list: Vec<Listed>,
}

struct Listed {
    /// Its part of the coordinates and gradients.
    range: Range<usize>,
    width: f64,
    force: f64,
    stiffness: f64,
    /// Whether it is taken to be open where it presses, or to press where it is open.
    is_changed: bool,
}

impl Gaps {
    fn clear(&mut self) {
        self.index.clear();
        self.gradient.clear();
        self.list.clear();
    }

    fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    fn push(&mut self, gap: &Gap<'_>, held: Option<usize>) {
        let &Gap { index, gradient, width, force, stiffness } = gap;
        // Between bodies that overlap without a force another gap presses in its place.
        if width < 0.0 && !(force > 0.0) {
            return;
        }
        let start = self.index.len();
        self.index.extend_from_slice(index);
        let moves = |i: &usize| if Some(*i) == held { 0.0 } else { 1.0 };
        self.gradient.extend(index.iter().zip(gradient).map(|(i, g)| moves(i) * g));
        let range = start..self.index.len();
        self.list.push(Listed { range, width, force, stiffness, is_changed: false });
    }

    /// Takes all gaps to be open or closed as they are after a step, in tangent and forces; whether any changed.
    fn follow<L: Linearisation>(&mut self, step: &[f64], tangent: &mut L, force: &mut [f64]) -> bool {
        let mut any = false;
        for gap in &mut self.list {
            let (index, gradient) = (&self.index[gap.range.clone()], &self.gradient[gap.range.clone()]);
            let terms = index.iter().zip(gradient);
            let wider: f64 = terms.clone().map(|(i, g)| step.get(*i).map_or(0.0, |x| x * g)).sum();
            let presses = gap.force > 0.0;
            let is_changed =
                if presses { gap.stiffness * wider > gap.force } else { gap.width + wider < 0.0 };
            if is_changed == gap.is_changed {
                continue;
            }
            any = true;
            gap.is_changed = is_changed;
            // Without the spring of one that presses, with one where none was; and back.
            let (spring, push) = match presses {
                true => (-gap.stiffness, -gap.force),
                false => (gap.stiffness, -gap.stiffness * gap.width),
            };
            let sense = if is_changed { 1.0 } else { -1.0 };
            tangent.add_spring(index, gradient, sense * spring);
            for (i, g) in terms {
                if let Some(force) = force.get_mut(*i) {
                    *force += sense * push * g;
                }
            }
        }
        any
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{Balance, DenseLinearisation};

    /// A bead of 1 kg in the plane, pulled by a force, held by a soft spring at the origin and by walls n·q ≤ w that
    /// give way by a spring each.
    struct Bead {
        pull: [f64; 2],
        soft: f64,
        walls: Vec<([f64; 2], f64)>,
    }

    const WALL: f64 = 1e8;

    impl System for Bead {
        type Linearisation = DenseLinearisation;

        fn linearisation(&self) -> DenseLinearisation {
            DenseLinearisation::new(2)
        }

        fn mass(&self) -> &[f64] {
            &[1.0, 1.0]
        }

        fn scale(&self) -> &[f64] {
            &[1e-5, 1e-5]
        }

        fn evaluate(
            &self,
            _: f64,
            q: &[f64],
            _: &[f64],
            force: &mut [f64],
            linearisation: &mut DenseLinearisation,
        ) -> Balance {
            linearisation.clear();
            for i in 0..2 {
                force[i] = self.pull[i] - self.soft * q[i];
                linearisation.add_stiffness(i, i, self.soft);
            }
            self.gaps(0.0, q, f64::INFINITY, &mut |gap| {
                force.iter_mut().zip(gap.gradient).for_each(|(sum, g)| *sum += gap.force * g);
                if gap.force > 0.0 {
                    linearisation.add_spring(gap.index, gap.gradient, gap.stiffness);
                }
            });
            Balance::default()
        }

        fn gaps(&self, _: f64, q: &[f64], reach: f64, see: &mut dyn FnMut(&Gap<'_>)) {
            for (normal, place) in &self.walls {
                let width = place - normal[0] * q[0] - normal[1] * q[1];
                let (gradient, force) = (normal.map(|n| -n), WALL * (-width).max(0.0));
                if width < reach {
                    see(&Gap { index: &[0, 1], gradient: &gradient, width, force, stiffness: WALL });
                }
            }
        }

        fn crank_angle(&self, _: &[f64]) -> f64 {
            0.0
        }
    }

    /// The place that one minded step from a start leads to, with the forces that are left there, in N.
    fn minded(bead: &Bead, start: [f64; 2], inertia: f64) -> ([f64; 2], f64) {
        let mut tangent = bead.linearisation_at_rest();
        let mut force = [0.0; 2];
        bead.evaluate(0.0, &start, &[0.0; 2], &mut force, &mut tangent);
        let here =
            Here { time: 0.0, position: &start, force: &force, tangent: &tangent, inertia, held: None };
        let mut step = [0.0; 2];
        let work = Foresight::new(bead).mind(bead, &here, &mut step).unwrap();
        assert!(work > 0.0, "{work}");
        let end = [start[0] + step[0], start[1] + step[1]];
        bead.evaluate(0.0, &end, &[0.0; 2], &mut force, &mut tangent);
        (end, force[0].hypot(force[1]))
    }

    /// Where all springs are linear, one step ends at the balance: against walls that it meets, away from one that
    /// presses at the start, past one that it only seems to meet.
    #[test]
    fn a_step_ends_at_the_balance_of_linear_contacts() {
        let slanted = [0.6, 0.8];
        let walls = vec![([1.0, 0.0], 2e-6), (slanted, 3e-6), ([-1.0, 0.0], 1e-6), ([0.0, 1.0], 8e-6)];
        let bead = Bead { pull: [300.0, 200.0], soft: 1e7, walls };
        let (end, left) = minded(&bead, [-2e-6, 0.0], 0.0);
        assert!(left < 1e-9, "{end:?}: {left}");
        // Without walls it would go 30 µm.
        assert!(end[0] > 2e-6 && end[0] < 4e-6, "{end:?}");
        assert!(0.6 * end[0] + 0.8 * end[1] > 3e-6, "{end:?}");
    }

    /// A bead that nothing holds goes to the corner that stops it; the mass term leaves what it costs.
    #[test]
    fn what_hangs_loose_goes_to_what_stops_it() {
        let walls = vec![([1.0, 0.0], 2e-6), ([0.0, 1.0], 1e-6)];
        let bead = Bead { pull: [3.0, 1.0], soft: 0.0, walls };
        let inertia = 1e3;
        let (end, left) = minded(&bead, [0.0; 2], inertia);
        assert!((end[0] - 2e-6 - 3.0 / WALL).abs() < 1e-10 && (end[1] - 1e-6 - 1.0 / WALL).abs() < 1e-10);
        assert!(left < 2.0 * inertia * 2e-6, "{left}");
    }
}
