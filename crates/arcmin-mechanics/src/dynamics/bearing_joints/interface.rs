//! Loads of bearings and pins on carrier and housing, in the interface coordinates of their elastic solids.

use super::BearingJoints;
use crate::dynamics::mechanism::{Element, Sink, State};
use crate::fem::carrier::{RIM_ORDER, SEAT_COORDINATES};
use crate::geometry::{Vec2, unit};

impl BearingJoints {
    /// Generalised forces on the carrier in its own frame, in the order of
    /// [`CarrierShape::compliance`](crate::fem::CarrierShape::compliance): every roller of the crank supports
    /// loads its seat radially at its position; each plate carries half of the force of the main bearings.
    pub fn carrier_loads(&self, position: &[f64]) -> Vec<f64> {
        let (q, _) = self.full(0.0, position, &vec![0.0; position.len()]);
        let turn = q[self.layout.carrier()[2]];
        let mut loads = Vec::with_capacity(2 * self.layout.cranks * SEAT_COORDINATES + 4);
        for supports in &self.bearings.supports {
            for bearing in supports.iter().filter_map(|joint| self.joints[*joint].bearing()) {
                let mut seat = [0.0; SEAT_COORDINATES];
                for (angle, force) in bearing.radial_element_forces(&q) {
                    let psi = angle - turn;
                    seat[0] += force * psi.cos();
                    seat[1] += force * psi.sin();
                    seat[2] += force;
                    for order in 2..=RIM_ORDER {
                        let (sin, cos) = (order as f64 * psi).sin_cos();
                        seat[2 * order - 1] += force * cos;
                        seat[2 * order] += force * sin;
                    }
                }
                loads.extend(seat);
            }
        }
        let main = crate::geometry::turned(-0.5 * self.main_force(&q), unit(-turn));
        loads.extend([main.x, main.y, main.x, main.y]);
        loads
    }

    /// Generalised forces on the housing in its own frame, in the order of
    /// [`HousingShape::compliance`](crate::fem::HousingShape::compliance): forces of the pins on their grooves
    /// and of the main bearings on their seats.
    pub fn housing_loads(&self, position: &[f64]) -> Vec<f64> {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        let mut loads = Vec::new();
        for disc in 0..self.layout.discs {
            let pins = self.rings[disc].contacts.pins().len();
            let mut forces = vec![0.0; 2 * pins];
            for (pin, force) in self.rings[disc].pin_forces(State { q: &q, v: &v }) {
                let angle = std::f64::consts::TAU * pin as f64 / pins as f64;
                let pushed = crate::geometry::turned(force, unit(-angle));
                forces[2 * pin] += pushed.x;
                forces[2 * pin + 1] += pushed.y;
            }
            loads.extend(forces);
        }
        let main = crate::geometry::turned(0.5 * self.main_force(&q), unit(-q[self.layout.housing()[2]]));
        loads.extend([main.x, main.y, main.x, main.y]);
        loads
    }

    /// Force of the main bearings on the housing in N.
    fn main_force(&self, q: &[f64]) -> Vec2 {
        let [x, y, _] = self.layout.housing();
        let mut sum = EnergyGradient { on: [x, y], gradient: Vec2::zeros() };
        let rest = vec![0.0; q.len()];
        self.joints[self.bearings.main].visit(State { q, v: &rest }, &mut sum);
        -sum.gradient
    }
}

/// Sums the gradients of energies with respect to two coordinates.
struct EnergyGradient {
    on: [usize; 2],
    gradient: Vec2,
}

impl Sink for EnergyGradient {
    fn element(&mut self, element: &Element<'_>) {
        for (coordinate, value) in element.index.iter().zip(element.gradient) {
            for axis in (0..2).filter(|axis| self.on[*axis] == *coordinate) {
                self.gradient[axis] += value;
            }
        }
    }

    fn damper(&mut self, _: &[usize], _: &[f64], _: &[f64], _: f64) {}
}
