//! The handbook's method.

use super::AnalysisError;
use crate::load::closed_form::{self, ClosedForm};
use crate::machine::{Machine, OutputAngle};
use crate::units::{DEG, UM};

/// One pair of pin and flank, the same on every disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    pub disc: usize,
    pub pin: usize,
    /// rad, signed.
    pub meshing_angle: f64,
    /// N, Pa, m, m.
    pub force: f64,
    pub pressure: f64,
    pub half_width: f64,
    pub gap: f64,
}

/// Load sharing by the handbook.
#[derive(Debug, Clone)]
pub struct Handbook {
    pub solution: ClosedForm,
    pub pairs: Vec<Pair>,
    /// N: before the first iteration.
    pub first_guess: f64,
    /// Play from the geometry of the equilibrium model; the closed form has none.
    pub play: OutputAngle,
}

/// All discs carry the same; the loaded flank has the sign of the torque's meshing angles.
pub(super) fn solve(machine: &Machine, torque: f64, wear: f64) -> Result<Handbook, AnalysisError> {
    let solution = closed_form::solve(machine, torque.abs(), wear)
        .map_err(AnalysisError::compute("share the load in closed form"))?;
    let profile = machine.profile();
    let contact = machine.line_contact();
    let side = if torque < 0.0 { 1.0 } else { -1.0 };
    let mut pairs = Vec::new();
    for disc in 0..machine.disc_count {
        for (index, pair) in solution.pairs.iter().enumerate() {
            let radius = 1.0 / profile.relative_curvature(pair.meshing_angle.cos(), machine.ring.pin_radius);
            // Pins are counted around the ring from the eccentric, towards the loaded side.
            let pin = if side > 0.0 { index + 1 } else { machine.ring.pin_count - 1 - index };
            pairs.push(Pair {
                disc,
                pin,
                meshing_angle: side * pair.meshing_angle,
                force: pair.force,
                pressure: contact.pressure(pair.force, radius),
                half_width: contact.half_width(pair.force, radius),
                gap: pair.initial_gap,
            });
        }
    }
    let meshing = machine.meshing(&crate::geometry::Relief::uniform(wear));
    let cycle = meshing.cycle(torque, 36).map_err(AnalysisError::compute("find the play"))?;
    let first_guess = closed_form::first_max_force(machine, torque.abs());
    Ok(Handbook { first_guess, play: cycle.mean_play(), solution, pairs })
}

impl Handbook {
    pub(super) fn largest_pair(&self) -> f64 {
        self.pairs.iter().map(|pair| pair.force).fold(0.0, f64::max)
    }

    pub(super) fn max_pressure(&self) -> f64 {
        self.pairs.iter().map(|pair| pair.pressure).fold(0.0, f64::max)
    }

    pub(super) fn sentence(&self) -> String {
        format!(
            "closed form: F_max {:.2} N at the largest lever arm, largest pair {:.2} N, {} loaded pairs, \
             largest pressure {:.0} MPa, approach {:.2} µm",
            self.solution.max_force,
            self.largest_pair(),
            self.solution.loaded_pairs(),
            self.max_pressure() / crate::units::MPA,
            self.solution.max_approach / UM
        )
    }

    pub(super) fn degrees(&self) -> impl Iterator<Item = (f64, f64)> {
        self.pairs.iter().filter(|pair| pair.disc == 0).map(|pair| (pair.meshing_angle / DEG, pair.force))
    }
}
