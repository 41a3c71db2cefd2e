//! The single stage in SI units, with its closed forms.

use std::f64::consts::TAU;
use std::ops::{Deref, DerefMut};

use super::{Bore, PinBeam, RingMesh, RollerBearing, StageErrors, gcd};
use crate::contact::LineContact;
use crate::materials::Material;

/// Pins of the output in holes of the discs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputPins {
    /// Pins on the circle, each through a hole of every disc.
    pub count: usize,
    /// R_w in m.
    pub circle_radius: f64,
    /// r_w in m: of the roller, or of a pin without one.
    pub radius: f64,
    /// δ in m: a hole has the radius r_w + e + δ.
    pub hole_clearance: f64,
}

impl OutputPins {
    /// Radius of a hole in m for the eccentricity e: r_w + e + δ.
    pub fn hole_radius(&self, eccentricity: f64) -> f64 {
        self.radius + eccentricity + self.hole_clearance
    }

    /// Depth h in m of the contact law of a pin in its hole that contains all of the displacement of the wall beyond the mean
    /// of the rim, r_h exp(3/(8 (1 − ν))) with Poisson's number of the disc.
    ///
    /// In a wide plate in plane strain, pressures p_n cos nφ on a hole displace its wall by u_n = p_n r_h (1 − ν²)/E (2n + 1 −
    /// ν')/(n² − 1) with ν' = ν/(1 − ν), n ≥ 2, an even one by u_0 = p_0 r_h (1 − ν²)/E (1 + ν') (Airy's function r^−n and
    /// r^(2−n)). Under a force F on a width b small against r_h they sum up to F (1 − ν²)/(π B E) (2 ln(2 r_h/b) + (3 − ν')/4),
    /// and a half-space down to h yields F (1 − ν²)/(π B E) (2 ln(2 h/b) − ν').
    pub fn hole_depth(&self, eccentricity: f64, poisson_ratio: f64) -> f64 {
        self.hole_radius(eccentricity) * (0.375 / (1.0 - poisson_ratio)).exp()
    }

    /// Equivalent radius in m of the contact of a pin or roller with its hole, r_h r_w/(r_h − r_w).
    pub fn equivalent_radius(&self, eccentricity: f64) -> f64 {
        let hole = self.hole_radius(eccentricity);
        hole * self.radius / (hole - self.radius)
    }
}

/// A cycloidal drive of one stage: eccentrics in the middle of the input shaft, discs, a fixed ring of pins,
/// and output pins in holes of the discs. The output turns against the input, i = −z_c/m with the tooth
/// difference m.
///
/// Contacts are elastic, bodies otherwise rigid. The input shaft can shift in its bearings but does not bend.
#[derive(Debug, Clone, PartialEq)]
pub struct SingleStage {
    /// Flank and ring; its fields are accessible as fields of the stage.
    pub mesh: RingMesh,
    /// Angles of the eccentrics on the shaft in rad, one for each disc.
    pub phases: Vec<f64>,
    /// Bearing between eccentric and disc.
    pub eccentric: RollerBearing,
    /// Pins or rollers in holes of the discs.
    pub output_pins: OutputPins,
    /// Law of contact of a pin or roller of the output with its hole.
    pub output_contact: LineContact,
    /// An output pin as a beam.
    pub pin_beam: PinBeam,
    /// Stiffness of an output pin at each of the discs in N/m: pin, roller and hole in series.
    pub output_pin_stiffness: Vec<f64>,
    /// Round openings of a disc whose eccentric stands at the angle 0: the bore of the eccentric bearing, the holes of the
    /// output pins, others.
    pub openings: Vec<Bore>,
    /// Radial stiffness of the bearings of the input shaft, N/m.
    pub input_support: f64,
    /// Radial stiffness of the bearings of the output, N/m.
    pub output_support: f64,
    /// Of the discs.
    pub disc_material: Material,
    /// kg and kg·m² of a disc.
    pub disc: (f64, f64),
    /// Mass in kg and moment of inertia in kg·m² of the input shaft.
    pub input: (f64, f64),
    /// Mass in kg and moment of inertia in kg·m² of the output.
    pub output: (f64, f64),
    /// Mass in kg and moment of inertia in kg·m² of the ring, for drives in which it turns.
    pub ring_body: (f64, f64),
    /// Deviations of the drive from its drawing.
    pub errors: StageErrors,
}

/// Coefficients of friction of a single stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StageFriction {
    /// Coulomb coefficient between ring pins and flanks.
    pub ring: f64,
    /// Coulomb coefficient between output pins and holes, or between rollers and their pins.
    pub output: f64,
    /// Radius of the pin divided by that of its roller, which rolls in the hole and slides on the pin.
    pub pin_over_roller: f64,
    /// Rolling friction coefficient of the eccentric bearings, on their mean radius.
    pub bearing: f64,
}

impl StageFriction {
    /// The same ratios of radii with all coefficients zero.
    #[must_use]
    pub fn none(self) -> StageFriction {
        StageFriction { ring: 0.0, output: 0.0, bearing: 0.0, ..self }
    }
}

/// Two-sided backlash at the output in rad with the input held, as the sum of the contributions of single
/// clearances.
///
/// The sum is a lower bound: when all clearances are open a disc also shifts along its eccentric, which added a
/// tenth in a drive of 19 : 1 with 8 output pins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlayChain {
    /// Contribution of the gap Δ between flank and pins, 2 Δ m/(e z_c), in rad.
    pub ring: f64,
    /// Contribution of the radial clearance c of the eccentric bearing, 2 c m/(e z_c), in rad.
    pub eccentric_bearing: f64,
    /// Contribution of the clearance δ of output pins in their holes, 2 δ/R_w where one of them lies at a right
    /// angle to the eccentric, up to 1/cos(π/z_w) times as much elsewhere, in rad.
    pub output: f64,
}

impl PlayChain {
    /// Sum of the parts.
    pub fn total(&self) -> f64 {
        self.ring + self.eccentric_bearing + self.output
    }
}

impl Deref for SingleStage {
    type Target = RingMesh;

    fn deref(&self) -> &RingMesh {
        &self.mesh
    }
}

impl DerefMut for SingleStage {
    fn deref_mut(&mut self) -> &mut RingMesh {
        &mut self.mesh
    }
}

impl SingleStage {
    /// Sets the deviations of the drive from its drawing.
    pub fn set_errors(&mut self, errors: StageErrors) {
        self.errors = errors;
    }

    /// Turns of the input for one of the output: −z_c/m.
    pub fn ratio(&self) -> f64 {
        -self.profile.lobes_per_turn()
    }

    /// Backlash of the drive as designed.
    pub fn play_chain(&self) -> PlayChain {
        PlayChain {
            ring: self.free_turn(),
            eccentric_bearing: self.eccentric.clearance.max(0.0) / self.lever(),
            output: 2.0 * self.output_pins.hole_clearance.max(0.0) / self.output_pins.circle_radius,
        }
    }

    /// Largest force (N) on a ring pin if all pins on one side of a disc act as equal springs, 4 T/(K₁ z_c R)
    /// with the disc's share T of the torque; larger by the factor
    /// [`Profile::crowding`](crate::geometry::Profile::crowding) if the flank ends before its tip.
    pub fn ring_force(&self, torque: f64) -> f64 {
        self.pin_force(torque / self.phases.len() as f64)
    }

    /// Largest force (N) on an output pin at a disc if half of them act as equal springs, 4 T/(z_w R_w).
    pub fn output_pin_force(&self, torque: f64) -> f64 {
        let share = torque.abs() / self.phases.len() as f64;
        4.0 * share / (self.output_pins.count as f64 * self.output_pins.circle_radius)
    }

    /// Force (N) on an eccentric bearing if all pins act as equal springs: T m/(e z_c) perpendicular to the
    /// eccentric, and along it 4 T/(π R_w) from the output pins less the force from the ring. The lines of
    /// action of the ring pins meet in the pitch point, e z_p/m from the centre of the ring.
    pub fn eccentric_force(&self, torque: f64) -> f64 {
        let share = torque.abs() / self.phases.len() as f64;
        let across = share / self.lever();
        let by_ring = across * self.slant();
        let by_pins = 2.0 * share / (0.25 * TAU * self.output_pins.circle_radius);
        across.hypot(by_pins - by_ring)
    }

    /// Turns of the input after which discs and eccentrics return to their positions: z_c/gcd(z_c, m).
    pub fn turns_to_repeat(&self) -> usize {
        let lobes = self.profile.lobe_count();
        lobes / gcd(lobes, self.profile.tooth_difference)
    }

    /// Angle of a disc relative to the output at which its flank meshes with the pins for the phase of its
    /// eccentric, rad.
    pub fn mounting(&self, disc: usize) -> f64 {
        self.phases[disc] / self.ratio()
    }
}
