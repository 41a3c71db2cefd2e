//! Contribution of elastic carrier and housing to the compliance of a machine, to first order.

use super::RigError;
use super::settle::{creep, tangent};
use crate::contact::ConformalSeat;
use crate::dynamics::{BearingJoints, JointSettings};
use crate::fem::carrier::SEAT_COORDINATES;
use crate::fem::{Compliance, ElasticBodies};
use crate::machine::{Friction, Machine};

/// Compliance at the output in rad/(N·m) added by elastic bodies: the mean over the window of the torsional
/// stiffness (50 % to 100 % of rated torque) and both signs of torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyCompliance {
    /// Plates and pillars between the crank seats (as rigid rings), the main bearings' seats and the output
    /// face; 0 where the model contains them already ([`JointSettings::carrier`]).
    pub carrier: f64,
    /// Out-of-round deformation of the crank seats under the roller forces.
    pub crank_seats: f64,
    /// The ring of pins and the main bearings' seats in the housing relative to the fixed flange face.
    pub housing: f64,
    /// Pins with clearance in their grooves: compliance beyond that of the full contact assumed for the
    /// housing.
    pub pin_grooves: f64,
}

impl BodyCompliance {
    /// Compliance of all bodies together.
    pub fn sum(&self) -> f64 {
        self.carrier + self.crank_seats + self.housing + self.pin_grooves
    }
}

/// Adds up the compliance of the elastic bodies under the forces of the equilibrium with rigid bodies: dφ/dT =
/// Σ (dF/dT)ᵀ C (dF/dT) over 50 % to 100 % of rated torque (Castigliano's theorem, virtual work).
///
/// This is the first order: in the elastic machine the forces are redistributed to the stiffer paths, and by
/// the principle of minimum complementary energy the compliance is smaller. The sum is an upper bound for each
/// increment of torque, close where the bodies are stiff compared with contacts and bearings.
///
/// # Errors
/// [`RigError`] where no equilibrium is found or a body is not constrained.
pub fn body_compliance(
    machine: &Machine,
    settings: &JointSettings,
    bodies: &ElasticBodies,
    sun: f64,
) -> Result<BodyCompliance, RigError> {
    let rated = machine.rated.torque.abs();
    let settings = JointSettings { damped: false, ..settings.clone() };
    let mut frictionless = machine.clone();
    frictionless.friction =
        Friction { regularisation_speed: machine.friction.regularisation_speed, ..Friction::default() };
    let mut model = BearingJoints::held(&frictionless, &settings)?;
    model.hold_sun(sun, 0.0);
    let node = 0.5 * 0.6_f64.sqrt();
    let gauss = [(0.5 - node, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.5 + node, 5.0 / 18.0)];
    let mut sum = BodyCompliance { carrier: 0.0, crank_seats: 0.0, housing: 0.0, pin_grooves: 0.0 };
    let step = 1e-3 * rated;
    let solid = &machine.solids.housing;
    let groove = ConformalSeat::new(0.5 * solid.groove_clearance, &machine.ring.material, &solid.material);
    // Length of the pins per disc.
    let length = machine.solids.carrier.gap / machine.disc_count as f64;
    for sign in [1.0, -1.0] {
        let mut q = model.nominal_position_at(sun);
        for (place, weight) in gauss {
            model.set_load(-sign * (0.5 + 0.5 * place) * rated);
            q = creep(&model, machine.friction.regularisation_speed, &q)?;
            let motion = tangent(&model, &q)?;
            let at = |share: f64| -> Vec<f64> {
                q.iter().zip(&motion).map(|(q, g)| q + share * step * g).collect()
            };
            let (ahead, behind) = (at(1.0), at(-1.0));
            let rate = |loads: &dyn Fn(&[f64]) -> Vec<f64>| -> Vec<f64> {
                let (ahead, behind) = (loads(&ahead), loads(&behind));
                ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * step)).collect()
            };
            let carrier = rate(&|q| model.carrier_loads(q));
            let whole = twice_energy(&bodies.carrier, &carrier);
            let seats = 2 * machine.crankshafts.count * SEAT_COORDINATES;
            let as_wholes: Vec<f64> = carrier
                .iter()
                .enumerate()
                .map(|(i, f)| if i < seats && i % SEAT_COORDINATES > 1 { 0.0 } else { *f })
                .collect();
            let plates = twice_energy(&bodies.carrier, &as_wholes);
            if settings.carrier.is_none() {
                sum.carrier += 0.5 * weight * plates;
            }
            sum.crank_seats += 0.5 * weight * (whole - plates);
            let housing = rate(&|q| model.housing_loads(q));
            sum.housing += 0.5 * weight * twice_energy(&bodies.housing, &housing);
            let pins = 2 * machine.disc_count * machine.ring.pin_count;
            let loads = model.housing_loads(&q);
            let grooves: f64 = loads[..pins]
                .chunks_exact(2)
                .zip(housing.chunks_exact(2))
                .map(|(load, rate)| {
                    let force = load[0].hypot(load[1]);
                    let along =
                        if force > 0.0 { (load[0] * rate[0] + load[1] * rate[1]) / force } else { 0.0 };
                    along * along * groove.tangent_beyond_full_contact(force / length) / length
                })
                .sum();
            sum.pin_grooves += 0.5 * weight * grooves;
        }
    }
    Ok(sum)
}

fn twice_energy(compliance: &Compliance, forces: &[f64]) -> f64 {
    2.0 * compliance.energy(forces)
}

#[cfg(test)]
mod symmetry_tests;
#[cfg(test)]
mod tests;
