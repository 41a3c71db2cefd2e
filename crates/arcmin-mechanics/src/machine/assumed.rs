//! Masses of bodies of drives of eccentrics that a design does not give, from simple bodies of steel.

use std::f64::consts::PI;

use super::{OutputPins, RingMesh, RollerBearing, TwoRing};

/// Density, kg/m³.
const STEEL: f64 = 7850.0;
/// Wall thickness of a ring outside of its pins as a fraction of its outer radius, as in proposed drives.
pub(super) const WALL: f64 = 0.12;

/// Mass in kg and moment of inertia in kg·m² of a hollow cylinder with two radii and a width, m.
fn body([inner, outer]: [f64; 2], width: f64) -> (f64, f64) {
    let mass = STEEL * PI * (outer * outer - inner * inner) * width;
    (mass, 0.5 * mass * (outer * outer + inner * inner))
}

impl OutputPins {
    /// Mass in kg and moment of inertia in kg·m² of the plates of the output pins: a disc up to the outer edge
    /// of the pins, with a thickness in m.
    pub fn plates(&self, thickness: f64) -> (f64, f64) {
        body([0.0, self.circle_radius + self.radius], thickness)
    }
}

impl RingMesh {
    /// Mass in kg and moment of inertia in kg·m² of the ring with a width in m.
    pub fn ring_body(&self, width: f64) -> (f64, f64) {
        body(
            [self.ring_circle_radius, (self.ring_circle_radius + self.ring_pin_radius) / (1.0 - WALL)],
            width,
        )
    }
}

impl RingMesh {
    /// Surface in m² of a closed cylinder around the ring, including this wall, with a length in m.
    pub fn housing_surface(&self, length: f64) -> f64 {
        let radius = (self.ring_circle_radius + self.ring_pin_radius) / (1.0 - WALL);
        2.0 * PI * radius * (radius + length)
    }
}

impl RollerBearing {
    /// Mass in kg and moment of inertia in kg·m² of the shaft within the inner raceway, with a length in m.
    pub fn shaft(&self, length: f64) -> (f64, f64) {
        body([0.0, 0.5 * (self.pitch_diameter - self.roller_diameter)], length)
    }
}

impl TwoRing {
    /// Mass in kg and moment of inertia in kg·m² of the input shaft, as long as the stepped discs together.
    pub fn input_body(&self) -> (f64, f64) {
        self.eccentric.shaft(self.phases.len() as f64 * (self.widths[0] + self.widths[1]))
    }

    /// Mass in kg and moment of inertia in kg·m² of the second ring, as wide as its steps together.
    pub fn output_body(&self) -> (f64, f64) {
        self.meshes[1].ring_body(self.phases.len() as f64 * self.widths[1])
    }
}
