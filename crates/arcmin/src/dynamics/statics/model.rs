//! The machine about one place: gaps to first order, force laws exact, everything else by its tangent.

use std::ops::Range;

use crate::contact::{ContactSpring, Pressed};
use crate::dynamics::{Linearisation, System, Weights};

/// Contacts wider open than this multiple of the reach cannot close within it: a gap moves by the displacements of
/// two bodies.
const NEAR: f64 = 2.0;
/// Newton steps on one model. A model with n contacts that open or close needs fewer than n.
const NEWTON_STEPS: usize = 60;
/// How exactly the model is solved, as a share of the forces at its place: the next place changes them by more.
const EXACTNESS: f64 = 1e-3;
/// A line search ends when the slope along the step has fallen to this share; between 0.01 and 0.9 it makes no difference.
const SLOPE_LEFT: f64 = 0.5;
/// The proximal term against the largest work of the forces along one unit of scale: it matters for bodies that hang
/// loose alone, and lets these go a hundred thousand units of scale under the load.
const PROXIMAL: f64 = 1e-5;
/// The least of it against the largest stiffness: the rounding of the factors.
const ROUNDING: f64 = 1e-13;
/// Growth of the proximal term where the model is not convex, and how often.
const GROWTH: (f64, usize) = (30.0, 12);
/// Stiffness of the fence at the reach, against the largest work of the forces along one unit of scale.
const FENCE: f64 = 1e2;

/// Forces left after a step d from a place: R(d) = Q − K_s d + Σ G (F(−g − G d) − F(−g)) − P d.
pub(super) struct Model<L> {
    held: Option<usize>,
    /// K_s.
    smooth: L,
    matrix: L,
    /// Q.
    force: Vec<f64>,
    index: Vec<usize>,
    gradient: Vec<f64>,
    contacts: Vec<Linearised>,
    /// R without the proximal term and the fence, and with them.
    bare: Vec<f64>,
    left: Vec<f64>,
}

/// One contact with its part of the gradients.
struct Linearised {
    range: Range<usize>,
    gap: f64,
    spring: ContactSpring,
    /// At d = 0, and at the last step.
    begin: Pressed,
    now: Pressed,
}

/// What holds steps back: a stiffness on every coordinate, and beyond the reach another.
struct Bounds<'a> {
    scale: &'a [f64],
    proximal: f64,
    reach: f64,
    fence: f64,
}

impl Bounds<'_> {
    fn force(&self, i: usize, d: f64) -> f64 {
        let beyond = (d.abs() - self.reach * self.scale[i]).max(0.0);
        (self.proximal * d + self.fence * beyond.copysign(d)) / (self.scale[i] * self.scale[i])
    }

    fn stiffness(&self, i: usize, d: f64) -> f64 {
        let fence = if d.abs() > self.reach * self.scale[i] { self.fence } else { 0.0 };
        (self.proximal + fence) / (self.scale[i] * self.scale[i])
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl<L: Linearisation> Model<L> {
    pub fn new<S: System<Linearisation = L>>(system: &S, held: Option<usize>) -> Model<L> {
        let n = system.size();
        Model {
            held,
            smooth: system.linearisation_at_rest(),
            matrix: system.linearisation_at_rest(),
            force: vec![0.0; n],
            index: Vec::new(),
            gradient: Vec::new(),
            contacts: Vec::new(),
            bare: vec![0.0; n],
            left: vec![0.0; n],
        }
    }

    /// Moves to a place with its forces and their tangent.
    pub fn take<S: System<Linearisation = L>>(
        &mut self,
        system: &S,
        time: f64,
        position: &[f64],
        force: &[f64],
        tangent: &L,
        reach: f64,
    ) {
        let n = system.size();
        self.smooth.copy_stiffness(tangent);
        self.force.copy_from_slice(force);
        self.index.clear();
        self.gradient.clear();
        self.contacts.clear();
        let Model { index, gradient, contacts, smooth, held, .. } = self;
        let unit = system.scale().iter().copied().fold(f64::INFINITY, f64::min);
        system.contacts(time, position, NEAR * reach * unit, &mut |contact| {
            let begin = contact.spring.at(-contact.gap);
            let start = index.len();
            for (i, g) in contact.index.iter().zip(contact.gradient) {
                if *i < n && Some(*i) != *held {
                    index.push(*i);
                    gradient.push(*g);
                }
            }
            if begin.stiffness > 0.0 {
                smooth.add_spring(&index[start..], &gradient[start..], -begin.stiffness);
            }
            let (range, gap, spring) = (start..index.len(), contact.gap, contact.spring);
            contacts.push(Linearised { range, gap, spring, begin, now: begin });
        });
        if let Some(held) = self.held {
            self.smooth.hold(held);
        }
    }

    /// Forces left after a step, and how the contacts press there.
    fn evaluate(&mut self, step: &[f64], bounds: &Bounds<'_>) {
        self.smooth.multiply(step, &mut self.bare);
        self.bare.iter_mut().zip(&self.force).for_each(|(left, force)| *left = force - *left);
        for contact in &mut self.contacts {
            let terms = self.index[contact.range.clone()].iter().zip(&self.gradient[contact.range.clone()]);
            let wider: f64 = terms.clone().map(|(i, g)| g * step[*i]).sum();
            contact.now = contact.spring.at(-(contact.gap + wider));
            let push = contact.now.force - contact.begin.force;
            if push != 0.0 {
                terms.for_each(|(i, g)| self.bare[*i] += push * g);
            }
        }
        if let Some(held) = self.held {
            self.bare[held] = 0.0;
        }
        for (i, left) in self.left.iter_mut().enumerate() {
            *left = self.bare[i] - bounds.force(i, step[i]);
        }
    }

    /// What the model leaves out along the step that it was solved for: the forces that it has there less the true
    /// ones, with their work along the step. `None` where the machine is softer than the model.
    pub fn misfit(&self, step: &[f64], force: &[f64]) -> Option<(Vec<f64>, f64)> {
        let misfit: Vec<f64> = self.bare.iter().zip(force).map(|(left, force)| left - force).collect();
        let work = dot(&misfit, step);
        (work > 0.0).then_some((misfit, work))
    }

    /// Symmetric rank-one update K_s + e eᵀ/(e·d): a model at the place of the misfit e then leaves along d what was
    /// found behind it.
    pub fn correct(&mut self, misfit: &[f64], work: f64) {
        let all: Vec<usize> = (0..misfit.len()).collect();
        self.smooth.add_spring(&all, misfit, 1.0 / work);
        if let Some(held) = self.held {
            self.smooth.hold(held);
        }
    }

    /// Fills `step` with the minimum of the model within the reach; whether it is that of the model without the fence
    /// and with the least proximal term. `None` where no proximal term makes the model convex.
    pub fn solve<S: System<Linearisation = L>>(
        &mut self,
        system: &S,
        reach: f64,
        step: &mut [f64],
    ) -> Option<bool> {
        let scale = system.scale();
        let unit_work = work(&self.force, scale);
        let stiffest =
            scale.iter().enumerate().fold(0.0, |m: f64, (i, s)| m.max(self.smooth.diagonal(i) * s * s));
        let least = PROXIMAL * unit_work + ROUNDING * stiffest;
        let mut bounds = Bounds { scale, proximal: least, reach, fence: FENCE * unit_work };
        for _ in 0..GROWTH.1 {
            step.fill(0.0);
            if self.minimise(step, &bounds, unit_work).is_some() {
                let inside = step.iter().zip(scale).all(|(d, s)| d.abs() <= reach * s);
                return Some(inside && bounds.proximal == least);
            }
            bounds.proximal *= GROWTH.0;
        }
        None
    }

    /// Semismooth Newton method with an exact line search: the slope along a step falls steadily where the model is
    /// convex, so that its zero lies in a bracket. `None` where a Newton step leads uphill.
    fn minimise(&mut self, step: &mut [f64], bounds: &Bounds<'_>, unit_work: f64) -> Option<()> {
        self.evaluate(step, bounds);
        let (mut newton, mut trial) = (step.to_vec(), step.to_vec());
        for _ in 0..NEWTON_STEPS {
            if work(&self.left, bounds.scale) <= EXACTNESS * unit_work {
                break;
            }
            self.matrix.copy_stiffness(&self.smooth);
            for contact in self.contacts.iter().filter(|contact| contact.now.stiffness > 0.0) {
                let range = contact.range.clone();
                self.matrix.add_spring(
                    &self.index[range.clone()],
                    &self.gradient[range],
                    contact.now.stiffness,
                );
            }
            let held: Vec<f64> = step.iter().enumerate().map(|(i, d)| bounds.stiffness(i, *d)).collect();
            newton.copy_from_slice(&self.left);
            let weights = Weights { mass: 1.0, damping: 0.0, stiffness: 1.0 };
            self.matrix.solve(&held, weights, &mut newton).ok()?;
            let first = dot(&self.left, &newton);
            if !(first > 0.0) {
                return None;
            }
            let (mut low, mut high, mut share) = (0.0, f64::INFINITY, 1.0_f64);
            // Doubled or halved until rounding.
            for _ in 0..f64::MANTISSA_DIGITS {
                trial.iter_mut().zip(step.iter().zip(&newton)).for_each(|(t, (d, x))| *t = d + share * x);
                self.evaluate(&trial, bounds);
                let along = dot(&self.left, &newton);
                if along.abs() <= SLOPE_LEFT * first {
                    break;
                }
                *(if along > 0.0 { &mut low } else { &mut high }) = share;
                share = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * share };
            }
            step.copy_from_slice(&trial);
        }
        Some(())
    }
}

/// Largest work of forces along one unit of scale.
fn work(force: &[f64], scale: &[f64]) -> f64 {
    force.iter().zip(scale).fold(0.0, |m: f64, (f, s)| m.max((f * s).abs()))
}
