//! The short way to a state of rest, from a start that is nearly one.

use super::equilibrium::{Equilibrium, EquilibriumControl, mass_term};
use super::foresight::{Foresight, Here};
use super::system::LARGE;
use super::{Linearisation, System, Weights};

/// Steps after which the start was not so good.
const STEPS: usize = 16;
/// A step this short, in units of the system's scale, may be the last by what the one before it tells.
const SHORT: f64 = 1e-3;
/// Work against a step over that along it from which on the step is blocked; two such steps are enough.
const BLOCKED: f64 = 100.0;
/// After a step longer than this, in units of the system's scale, the tangent is taken anew; in a small system, whose
/// tangent comes nearly for nothing with the forces, after every step.
const FAR: f64 = 1e-3;
/// A step that is this much shorter than the one before it, and the next after which would be this share of the
/// tolerance, ends the search.
const SURE: f64 = 1e-2;
/// From this share of the step before on, steps shrink too slowly for an old tangent.
const SLOW: f64 = 0.2;
/// Steps by an old tangent shrink by shares, where Newton's leave far less than they promise: they must be this much
/// shorter for as good an end.
const SHARPER: f64 = 0.1;
/// A step longer than this, in units of the system's scale, may meet contacts that the tangent does not know.
const BLIND: f64 = 0.1;
/// What holds back bodies that hang loose, as a share of the mass term that moves them by a unit of scale: at first and
/// at most, and its growth where a step that minded the contacts went too far.
const INERTIA: (f64, f64) = (1e-2, 10.0);
const GROWTH: f64 = 10.0;

/// Newton's method without a safety net: `None` where it does not converge within some steps from `start`.
///
/// From a balance of neighbouring loads or surfaces it takes fewer steps than a search that looks after itself.
/// Contacts that close on the way stiffen the machine, so a step may go far past the balance; where the work
/// against it exceeds the work along it, it is cut where the straight line between both vanishes.
///
/// Near the balance the tangent changes little from step to step, and in a large system to take and factorise it is
/// most of the work. There steps go on with the last factors and with what the steps since have told of the change:
/// Broyden's first update (1965), kept as the steps themselves (Kelley, Iterative Methods for Linear and Nonlinear
/// Equations, 1995, ch. 7).
///
/// Where the start is from afar, steps mind the contacts on their way ([`Foresight`]).
///
/// Steps near the balance shrink faster and faster: one that is shorter than the one before it by so much that the next
/// would be lost in the tolerance is the last, and nobody looks at the forces behind it.
///
/// The step after one of length s is about s² over the one before it, and shorter than what the forces left along s
/// tell; where that is less than a tenth of the tolerance a step is the last.
pub(super) fn hasten<S: System>(
    system: &S,
    time: f64,
    start: &[f64],
    control: EquilibriumControl,
) -> Option<Equilibrium> {
    let mut search = Search::new(system, time, start, control);
    let (mut step, mut trial) = (vec![0.0; start.len()], vec![0.0; start.len()]);
    let far = if start.len() < LARGE { 0.0 } else { FAR };
    search.take_tangent();
    let mut before = 0.0;
    let mut blocked = false;
    let mut was_cut = false;
    for iterations in 0..STEPS {
        let residual = search.residual();
        if residual <= control.force_tolerance {
            return Some(Equilibrium { residual, position: search.position, iterations });
        }
        let mut told = search.next_step(&mut step);
        if search.is_old() && !(told.is_some() && search.length(&step) <= SLOW * before) {
            search.take_tangent();
            told = search.next_step(&mut step);
        }
        let mut minded = None;
        if control.from_afar && !search.is_old() {
            // What hangs loose has no step that the tangent could tell.
            if told.is_none() {
                step.fill(0.0);
            }
            if told.is_none() || was_cut || search.length(&step) > BLIND {
                minded = search.mind_contacts(&mut step);
            }
        }
        if told.is_none() && minded.is_none() {
            return None;
        }
        let length = search.length(&step);
        let tolerance = if search.is_old() { SHARPER * control.tolerance } else { control.tolerance };
        let first = minded.unwrap_or_else(|| dot(&search.force, &step));
        if !length.is_finite() || first <= 0.0 {
            return None;
        }
        let shortening = (control.trust / length).min(1.0);
        step.iter_mut().for_each(|x| *x *= shortening);
        let first = shortening * first;
        trial.iter_mut().zip(search.position.iter().zip(&step)).for_each(|(t, (q, x))| *t = q + x);
        std::mem::swap(&mut search.position, &mut trial);
        let next = length * length / before;
        if minded.is_none() && length <= SURE * before && length <= SHORT && next <= SURE * tolerance {
            let residual = residual * next / length;
            let position = search.position;
            return Some(Equilibrium { residual, position, iterations: iterations + 1 });
        }
        if length > far {
            search.take_tangent();
        } else {
            search.keep_tangent(&step);
        }
        let along = dot(&search.force, &step);
        if !along.is_finite() {
            return None;
        }
        let left = (length * along / first).abs();
        let shrinks = length <= SHORT && next.max(left) <= 0.1 * tolerance;
        if length <= tolerance || shrinks {
            let residual = search.residual();
            let position = search.position;
            return Some(Equilibrium { residual, position, iterations: iterations + 1 });
        }
        before = length;
        // The secant leaves next to nothing of a step that runs into a contact on its way, and of the next.
        if along < -BLOCKED * first {
            if blocked {
                return None;
            }
            blocked = true;
        }
        was_cut = along < -first;
        if minded.is_some() {
            let inertia = search.inertia * if was_cut { GROWTH } else { 1.0 / GROWTH };
            search.inertia = inertia.clamp(INERTIA.0, INERTIA.1);
        }
        if was_cut {
            let share = first / (first - along);
            search
                .position
                .iter_mut()
                .zip(trial.iter().zip(&step))
                .for_each(|(t, (q, x))| *t = q + share * x);
            search.take_tangent();
            // What follows a cut step says nothing about convergence.
            before = 0.0;
        }
    }
    None
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A place with its forces, the tangent taken last, and the whole steps made with it since.
struct Search<'a, S: System> {
    system: &'a S,
    time: f64,
    control: EquilibriumControl,
    rest: Vec<f64>,
    position: Vec<f64>,
    force: Vec<f64>,
    /// Factorised by the first step with it.
    tangent: S::Linearisation,
    /// Made where it is first asked.
    foresight: Option<Foresight<S::Linearisation>>,
    /// As [`INERTIA`] has it.
    inertia: f64,
    /// Steps since, each with its square, coordinates in units of the system's scale.
    steps: Vec<(Vec<f64>, f64)>,
}

impl<'a, S: System> Search<'a, S> {
    fn new(system: &'a S, time: f64, start: &[f64], control: EquilibriumControl) -> Search<'a, S> {
        Search {
            system,
            time,
            control,
            rest: vec![0.0; start.len()],
            position: start.to_vec(),
            force: vec![0.0; start.len()],
            tangent: system.linearisation_at_rest(),
            foresight: None,
            inertia: INERTIA.0,
            steps: Vec::new(),
        }
    }

    /// Largest force that is left, in N or N·m.
    fn residual(&self) -> f64 {
        self.force.iter().fold(0.0, |most: f64, x| if x.abs() <= most { most } else { x.abs() })
    }

    fn length(&self, step: &[f64]) -> f64 {
        step.iter().zip(self.system.scale()).fold(0.0, |most: f64, (x, scale)| most.max(x.abs() / scale))
    }

    /// Whether the tangent is that of another place.
    fn is_old(&self) -> bool {
        !self.steps.is_empty()
    }

    /// Forces and tangent here.
    fn take_tangent(&mut self) {
        self.steps.clear();
        let Search { system, time, position, rest, .. } = self;
        system.evaluate(*time, position, rest, &mut self.force, &mut self.tangent);
        if let Some(held) = self.control.held {
            self.force[held] = 0.0;
            self.tangent.hold(held);
        }
    }

    /// Forces here, a step from where they were known.
    fn keep_tangent(&mut self, step: &[f64]) {
        let scaled: Vec<f64> = step.iter().zip(self.system.scale()).map(|(x, scale)| x / scale).collect();
        let square = dot(&scaled, &scaled);
        self.steps.push((scaled, square));
        self.system.evaluate_forces(self.time, &self.position, &self.rest, &mut self.force);
        if let Some(held) = self.control.held {
            self.force[held] = 0.0;
        }
    }

    /// Makes a step from here one that minds the contacts on its way; the work that it should do.
    fn mind_contacts(&mut self, step: &mut [f64]) -> Option<f64> {
        let Search { system, time, control, position, force, tangent, .. } = self;
        let inertia = self.inertia * mass_term(*system, force);
        let here = Here { time: *time, position, force, tangent, inertia, held: control.held };
        self.foresight.get_or_insert_with(|| Foresight::new(*system)).mind(*system, &here, step)
    }

    /// The next step from here.
    fn next_step(&mut self, step: &mut [f64]) -> Option<()> {
        step.copy_from_slice(&self.force);
        let Some((made, square)) = self.steps.last() else {
            let weights = Weights { mass: 0.0, damping: 0.0, stiffness: 1.0 };
            return self.tangent.solve(self.system.mass(), weights, step).ok();
        };
        self.tangent.solve_again(step).ok()?;
        let scale = self.system.scale();
        step.iter_mut().zip(scale).for_each(|(x, scale)| *x /= scale);
        for pair in self.steps.windows(2) {
            let [(earlier, square), (next, _)] = pair else { break };
            let share = dot(earlier, step) / square;
            step.iter_mut().zip(next).for_each(|(x, next)| *x += share * next);
        }
        let grown = 1.0 - dot(made, step) / square;
        step.iter_mut().zip(scale).for_each(|(x, scale)| *x *= scale / grown);
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{BearingJoints, JointSettings, solve_equilibrium};
    use crate::machine::ManufacturingErrors;

    /// From the balance under a tenth less load the short way ends where the long one from the nominal place
    /// does, within the tolerance; from a start that is no good it gives up.
    #[test]
    fn the_short_way_ends_where_the_long_one_does() {
        let machine = crate::templates::tao2024();
        let mut model = BearingJoints::held(&machine, &JointSettings::default()).unwrap();
        let control = EquilibriumControl { tolerance: 1e-7, force_tolerance: 1e-6, ..Default::default() };
        for sun in [0.0, 3.3, 17.0] {
            model.hold_sun(sun, 0.0);
            model.set_load(0.9 * machine.rated.torque);
            let near = solve_equilibrium(&model, 0.0, &model.nominal_position_at(sun), control).unwrap();
            model.set_load(machine.rated.torque);
            let short = hasten(&model, 0.0, &near.position, control).unwrap();
            let exact = EquilibriumControl { tolerance: 1e-11, ..control };
            let long = solve_equilibrium(&model, 0.0, &near.position, exact).unwrap();
            assert!(short.iterations <= 6, "{}", short.iterations);
            for ((a, b), scale) in short.position.iter().zip(&long.position).zip(model.scale()) {
                assert!((a - b).abs() < 1e-7 * scale, "{sun}: {a} {b}");
            }
        }
        // Every body turned by a degree: nothing can be read from the forces there.
        let lost: Vec<f64> = model.nominal_position_at(0.0).iter().map(|q| q + 0.02).collect();
        assert!(hasten(&model, 0.0, &lost, control).is_none());
    }
    /// Places of a turn that follow each other, held lightly, on drawn machines: steps that mind the contacts end
    /// where those that do not end, and end at far more of the places.
    #[test]
    fn steps_from_afar_end_at_the_same_balance() {
        let tolerances = crate::templates::design("tao2024").unwrap().drawing_tolerances().unwrap();
        let machines = [
            crate::templates::tao2024(),
            crate::templates::design("rv-80e").unwrap().machine(),
            crate::random_designs::sound_design(6).0.machine(),
            crate::random_designs::sound_design(11).0.machine(),
        ];
        let (mut near, mut far) = (0, 0);
        for machine in machines {
            let errors = ManufacturingErrors::draw(&machine, &tolerances, 2);
            let settings = JointSettings { errors, damped: false, ..JointSettings::default() };
            let mut model = BearingJoints::held(&machine, &settings).unwrap();
            model.set_load(0.01 * machine.rated.torque);
            let control = EquilibriumControl { tolerance: 1e-7, force_tolerance: 1e-6, ..Default::default() };
            let mut deviation = vec![0.0; model.mass().len()];
            for i in 0..40 {
                let sun = model.kinematics().ratio() * std::f64::consts::TAU * f64::from(i) / 512.0;
                model.hold_sun(sun, 0.0);
                let nominal = model.nominal_position_at(sun);
                let start: Vec<f64> = nominal.iter().zip(&deviation).map(|(q, d)| q + d).collect();
                let blind = hasten(&model, 0.0, &start, control);
                let minding = EquilibriumControl { from_afar: true, ..control };
                let minded = hasten(&model, 0.0, &start, minding);
                near += usize::from(blind.is_some());
                far += usize::from(minded.is_some());
                if let (Some(one), Some(other)) = (&blind, &minded) {
                    let [a, b] = [one, other].map(|found| model.output_error(&found.position));
                    assert!((a - b).abs() < 1e-5 * crate::units::ARCMIN, "{} {i}: {a} {b}", machine.name);
                }
                let Ok(found) = solve_equilibrium(&model, 0.0, &start, control) else { continue };
                deviation = found.position.iter().zip(&nominal).map(|(q, n)| q - n).collect();
            }
        }
        assert!(far > 130 && 10 * far > 13 * near, "{far} of 160 places, {near} without looking");
    }
}
