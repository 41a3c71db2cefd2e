//! Wear of bearings, gears, output pins and their holes: laws and removed depths.

use std::f64::consts::{PI, TAU};

/// Wear of parts other than flank and pins.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PartWear {
    /// Growth of the diametral clearance of the turning-arm bearings in m.
    pub turning_arm: f64,
    /// Growth of the diametral clearance of the crank supports in m.
    pub crank_support: f64,
    /// Increase of the gap of every sun–planet mesh along its line of action in m: of the tooth sides on which
    /// the sun drives counter-clockwise, and of the opposite sides.
    pub gears: [f64; 2],
    /// Single stages: wear depth of the holes of the discs, m, as a function of the direction from hole to pin
    /// relative to the direction of the pin on its circle.
    pub holes: Around,
    /// Single stages: wear depth of the output pins, m, as a function of the same direction.
    pub output_pins: Around,
    /// Single stages: wear depth of the bores of the rollers, m; uniform, because rollers turn under the load.
    pub rollers: f64,
}

impl PartWear {
    /// Increase of the radial clearance of an output pin in its hole, m.
    pub fn hole_clearance(&self) -> Around {
        let mut clearance = self.holes.plus(&self.output_pins, 1.0);
        clearance.mean += self.rollers;
        clearance
    }

    /// This wear and `time` times the rates.
    pub fn plus(&self, rates: &PartWear, time: f64) -> PartWear {
        PartWear {
            turning_arm: self.turning_arm + time * rates.turning_arm,
            crank_support: self.crank_support + time * rates.crank_support,
            gears: [self.gears[0] + time * rates.gears[0], self.gears[1] + time * rates.gears[1]],
            holes: self.holes.plus(&rates.holes, time),
            output_pins: self.output_pins.plus(&rates.output_pins, time),
            rollers: self.rollers + time * rates.rollers,
        }
    }

    /// Whether nothing is worn.
    pub fn is_zero(&self) -> bool {
        *self == PartWear::default()
    }
}

/// Number of harmonics of a depth around a pin: with six the error is 1 % of the peak of the half sine that a
/// constant torque wears.
const HARMONICS: usize = 6;

/// A depth (m) as a function of the direction around a pin, as mean and harmonics: smooth, so that contacts
/// have tangents everywhere.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Around {
    /// Mean depth, m.
    pub mean: f64,
    /// Coefficients of cos mα and sin mα for m from 1, m.
    harmonics: [[f64; 2]; HARMONICS],
}

impl Around {
    /// Adds an area (m²) removed from a circle of this radius (m) in the direction α (rad).
    pub fn deposit(&mut self, angle: f64, area: f64, radius: f64) {
        let mean = area / (TAU * radius);
        self.mean += mean;
        for (m, [cos, sin]) in (1..).zip(&mut self.harmonics) {
            let (s, c) = (f64::from(m) * angle).sin_cos();
            *cos += 2.0 * mean * c;
            *sin += 2.0 * mean * s;
        }
    }

    /// Depth (m) in a direction (rad), with its first and second derivative (m/rad, m/rad²).
    pub fn at(&self, angle: f64) -> [f64; 3] {
        let mut found = [self.mean, 0.0, 0.0];
        if self.harmonics == [[0.0; 2]; HARMONICS] {
            return found;
        }
        for (m, [cos, sin]) in (1..).map(f64::from).zip(self.harmonics) {
            let (s, c) = (m * angle).sin_cos();
            found[0] += cos * c + sin * s;
            found[1] += m * (sin * c - cos * s);
            found[2] -= m * m * (cos * c + sin * s);
        }
        found
    }

    /// Largest depth in any direction, m.
    pub fn deepest(&self) -> f64 {
        (0..180).map(|i| self.at(f64::from(i) * PI / 90.0)[0]).fold(0.0, f64::max)
    }

    /// This and `factor` times the other.
    pub fn plus(&self, other: &Around, factor: f64) -> Around {
        let mut sum = *self;
        sum.mean += factor * other.mean;
        for (sum, other) in sum.harmonics.iter_mut().flatten().zip(other.harmonics.iter().flatten()) {
            *sum += factor * other;
        }
        sum
    }
}

/// Wear laws of bearings and gears; by default without wear, because no coefficient is valid for all machines.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PartWearLaws {
    /// Law of the turning-arm bearings; `None` for no wear.
    pub turning_arm: Option<RollingWear>,
    /// Law of the crank supports; `None` for no wear.
    pub crank_support: Option<RollingWear>,
    /// k of the teeth of the sun in 1/Pa.
    pub sun: f64,
    /// k of the teeth of the planets in 1/Pa.
    pub planet: f64,
}

impl PartWearLaws {
    /// Whether any bearing or gear wears.
    pub fn any(&self) -> bool {
        self.turning_arm.is_some() || self.crank_support.is_some() || self.sun > 0.0 || self.planet > 0.0
    }
}

/// Wear of a rolling bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollingWear {
    /// k in 1/Pa.
    pub coefficient: f64,
    /// Sliding distance per rolled distance.
    pub slip: f64,
}
