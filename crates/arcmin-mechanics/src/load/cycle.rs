use std::f64::consts::TAU;

use super::{FreeTravel, LoadError, LoadSharing, Meshing, Preload};
use crate::contact::{LineContact, PinContact};
use crate::machine::{CrankAngle, OutputAngle};

/// Load sharing at equidistant crank angles over one period of the pattern, with the values derived from it.
#[derive(Debug, Clone)]
pub struct Cycle {
    /// Solutions at equidistant crank angles in [0, pattern period).
    pub positions: Vec<LoadSharing>,
    /// One-sided play of the output at no load with the input locked, towards the flank of the torque, for the
    /// positions at which it is computed. Negative with interference: minus the uniform relief that would just
    /// free the mechanism, as an angle at the output ([`FreeTravel`]).
    pub play: Vec<OutputAngle>,
    /// Total free travel of the output at the same positions, negative with interference.
    pub free_travel: Vec<OutputAngle>,
    /// Preload of the pins without load, at the same positions.
    pub preload: Vec<Preload>,
    /// Crank angle over which the pattern repeats, in rad.
    pub period: f64,
}

/// Force at one point of the flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankForce {
    /// Meshing angle in rad, signed.
    pub meshing_angle: f64,
    /// Force in N.
    pub force: f64,
    /// Relative curvature 1/R_eq in 1/m.
    pub relative_curvature: f64,
}

/// One contact of a cycle with position and load.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CycleContact {
    /// Meshing angle in rad, signed.
    pub meshing_angle: f64,
    /// Force in N.
    pub force: f64,
    /// Hertz pressure in Pa.
    pub pressure: f64,
    /// Disc, counted from 0.
    pub disc: usize,
    /// Pin of the ring, counted from 0.
    pub pin: usize,
}

/// Loads of one pin on one disc over a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PinLoad {
    /// Disc, counted from 0.
    pub disc: usize,
    /// Pin of the ring, counted from 0.
    pub pin: usize,
    /// Largest force in N.
    pub max_force: f64,
    /// Meshing angle in rad of the largest force.
    pub max_force_at: f64,
    /// Mean force in N, unloaded positions included.
    pub mean_force: f64,
    /// Share of the positions at which the pin is loaded.
    pub loaded_share: f64,
}

/// One harmonic of the loaded transmission error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HarmonicError {
    /// Order per turn of the output.
    pub order: f64,
    /// Amplitude in rad.
    pub amplitude: f64,
}

impl Meshing {
    /// Solves the load sharing at `count` crank angles over one period of the pattern (2π/z_p of the
    /// crankshaft).
    ///
    /// # Errors
    /// [`LoadError`] of the first position that has no solution.
    pub fn cycle(&self, torque: f64, count: usize) -> Result<Cycle, LoadError> {
        let period = self.kinematics().pattern_period();
        let mut cycle = Cycle::empty(period);
        for index in 0..count {
            let crank = CrankAngle::from_radians(period * index as f64 / count as f64);
            cycle.add_travel(self.free_travel(crank)?, torque);
            cycle.positions.push(match cycle.positions.last() {
                Some(last) => self.load_sharing_near(crank, torque, last.output_error)?,
                None => self.load_sharing(crank, torque)?,
            });
        }
        Ok(cycle)
    }
}

fn sorted<'a>(contacts: impl Iterator<Item = &'a PinContact>) -> Vec<FlankForce> {
    let mut forces: Vec<FlankForce> = contacts
        .map(|c| FlankForce {
            meshing_angle: c.meshing_angle,
            force: c.force,
            relative_curvature: c.relative_curvature,
        })
        .collect();
    forces.sort_by(|a, b| a.meshing_angle.total_cmp(&b.meshing_angle));
    forces
}

fn mean(angles: impl ExactSizeIterator<Item = OutputAngle>) -> OutputAngle {
    let count = angles.len().max(1) as f64;
    OutputAngle::from_radians(angles.map(OutputAngle::radians).sum::<f64>() / count)
}

impl Cycle {
    pub(super) fn empty(period: f64) -> Cycle {
        Cycle {
            positions: Vec::new(),
            play: Vec::new(),
            free_travel: Vec::new(),
            preload: Vec::new(),
            period,
        }
    }

    /// Adds the play of one position, towards the flank that carries the torque.
    pub(super) fn add_travel(&mut self, travel: FreeTravel, torque: f64) {
        let toward = if torque < 0.0 { travel.lead.radians() } else { -travel.lag.radians() };
        self.play.push(OutputAngle::from_radians(toward));
        self.free_travel.push(OutputAngle::from_radians(travel.lead.radians() - travel.lag.radians()));
        self.preload.push(travel.preload);
    }

    /// Largest force of a pin without load in N; 0 if there is play at all positions.
    pub fn max_preload(&self) -> f64 {
        self.preload.iter().map(|preload| preload.force).fold(0.0, f64::max)
    }

    /// Friction torque at the output in N·m due to the preload for a friction coefficient of the flanks, mean
    /// over the cycle.
    pub fn preload_friction_torque(&self, flank_friction: f64) -> f64 {
        let sum: f64 = self.preload.iter().map(|preload| preload.friction_torque(flank_friction)).sum();
        sum / self.preload.len().max(1) as f64
    }

    /// Largest contact force in N.
    pub fn max_force(&self) -> f64 {
        self.positions.iter().map(LoadSharing::max_force).fold(0.0, f64::max)
    }

    /// Largest Hertz pressure in Pa under the contact law.
    pub fn max_pressure(&self, contact: &LineContact) -> f64 {
        self.positions
            .iter()
            .flat_map(LoadSharing::contacts)
            .map(|c| contact.pressure(c.force, 1.0 / c.relative_curvature))
            .fold(0.0, f64::max)
    }

    /// Mean number of loaded pairs of one disc.
    pub fn loaded_pairs(&self) -> f64 {
        self.positions.iter().map(LoadSharing::loaded_pairs).sum::<f64>() / self.positions.len() as f64
    }

    /// Mean output error under load.
    pub fn mean_error(&self) -> OutputAngle {
        mean(self.positions.iter().map(|position| position.output_error))
    }

    /// Peak-to-peak output error under load.
    pub fn peak_to_peak_error(&self) -> OutputAngle {
        let errors = || self.positions.iter().map(|position| position.output_error.radians());
        OutputAngle::from_radians(
            errors().fold(f64::NEG_INFINITY, f64::max) - errors().fold(f64::INFINITY, f64::min),
        )
    }

    /// Mean one-sided play, signed.
    pub fn mean_play(&self) -> OutputAngle {
        mean(self.play.iter().copied())
    }

    /// Mean total free travel, signed.
    pub fn mean_free_travel(&self) -> OutputAngle {
        mean(self.free_travel.iter().copied())
    }

    /// Forces on one flank of a tooth over its passage through the mesh, sorted by meshing angle, from all
    /// positions and discs.
    pub fn flank_forces(&self) -> Vec<FlankForce> {
        sorted(self.positions.iter().flat_map(LoadSharing::contacts))
    }

    /// The same if the pins have different loads: for each of `cells` equal intervals of the meshing angle the
    /// mean over all pins in it, and the contact with the largest force. For one disc; intervals without
    /// contacts are left out.
    pub fn flank_cells(&self, disc: usize, cells: usize) -> (Vec<FlankForce>, Vec<FlankForce>) {
        let all = sorted(self.positions.iter().filter_map(|position| position.discs.get(disc)).flatten());
        let cell = |force: &FlankForce| ((force.meshing_angle / TAU + 0.5) * cells as f64).floor();
        let mean = |forces: &[FlankForce]| {
            let mean =
                |value: fn(&FlankForce) -> f64| forces.iter().map(value).sum::<f64>() / forces.len() as f64;
            FlankForce {
                meshing_angle: mean(|f| f.meshing_angle),
                force: mean(|f| f.force),
                relative_curvature: mean(|f| f.relative_curvature),
            }
        };
        let largest =
            |forces: &[FlankForce]| forces.iter().copied().max_by(|a, b| a.force.total_cmp(&b.force));
        let cells = || all.chunk_by(|a, b| cell(a) == cell(b));
        (cells().map(mean).collect(), cells().filter_map(largest).collect())
    }

    /// Loads of every pin on every disc over all positions, disc by disc.
    pub fn pin_loads(&self) -> Vec<PinLoad> {
        let discs = self.positions.first().map_or(0, |position| position.discs.len());
        let share = 1.0 / self.positions.len().max(1) as f64;
        let mut loads: Vec<PinLoad> = Vec::new();
        for disc in 0..discs {
            let first = loads.len();
            for contact in self.positions.iter().flat_map(|position| &position.discs[disc]) {
                while loads.len() <= first + contact.pin {
                    let pin = loads.len() - first;
                    loads.push(PinLoad {
                        disc,
                        pin,
                        max_force: 0.0,
                        max_force_at: 0.0,
                        mean_force: 0.0,
                        loaded_share: 0.0,
                    });
                }
                let load = &mut loads[first + contact.pin];
                load.mean_force += share * contact.force;
                if contact.force > 0.0 {
                    load.loaded_share += share;
                }
                if contact.force > load.max_force {
                    (load.max_force, load.max_force_at) = (contact.force, contact.meshing_angle);
                }
            }
        }
        loads
    }

    /// Harmonics of the loaded transmission error within the pattern: order per output turn is z_c z_p times
    /// the harmonic.
    pub fn harmonics(&self, lobe_count: f64, pin_count: f64) -> Vec<HarmonicError> {
        let n = self.positions.len();
        (1..n.div_ceil(2))
            .map(|harmonic| {
                let (mut real, mut imaginary) = (0.0, 0.0);
                for (index, position) in self.positions.iter().enumerate() {
                    let (sin, cos) = (TAU * (harmonic * index % n) as f64 / n as f64).sin_cos();
                    real += position.output_error.radians() * cos;
                    imaginary += position.output_error.radians() * sin;
                }
                HarmonicError {
                    order: harmonic as f64 * lobe_count * pin_count,
                    amplitude: 2.0 / n as f64 * real.hypot(imaginary),
                }
            })
            .collect()
    }
}
