use super::{Friction, Machine, ManufacturingErrors};
use crate::tribology::{Lubrication, Oil, RubbingContact, film, seal_share};

/// Temperature of the machine, its oil, and its heat transfer.
#[derive(Debug, Clone, PartialEq)]
pub struct Thermal {
    /// Temperature of the housing and the oil in °C. `None`: the reference of 20 °C, friction as given.
    pub temperature: Option<f64>,
    /// Temperature of discs, shafts and carrier above that of the housing in K.
    pub internal_excess: f64,
    /// Expansion of discs, pins, shafts and carrier, 1/K.
    pub steel_expansion: f64,
    /// Expansion of the housing, 1/K.
    pub housing_expansion: f64,
    /// Viscosity of the oil against temperature.
    pub oil: Oil,
    /// Pressure–viscosity coefficient, 1/Pa.
    pub pressure_viscosity: f64,
    /// Combined RMS roughness of flank and pin in m.
    pub roughness: f64,
    /// °C.
    pub ambient: f64,
    /// Heat transfer of the surface in W/(m²·K), radiation included.
    pub transfer: f64,
    /// Surface of the machine in m².
    pub surface: f64,
    /// Conductance to the structure on which the machine is mounted, W/K above the surroundings.
    pub mounting: f64,
}

/// Wall thickness in m and conductivity in W/(m·K) of the cast iron arm on which a machine is assumed to be
/// mounted.
const ARM: (f64, f64) = (10e-3, 50.0);

/// Conductance in W/K of a long tube of the diameter (m), heated at one end and cooled on its outside by
/// `transfer` W/(m²·K): a fin, √(h P k A) = π D √(h k t). The tube dominates the resistance: bolted joints of
/// ground faces have some thousand W/(m²·K), ten times the conductance of the tube for these diameters.
pub fn arm_conductance(diameter: f64, transfer: f64) -> f64 {
    let (wall, conductivity) = ARM;
    std::f64::consts::PI * diameter * (transfer * conductivity * wall).sqrt()
}

/// Temperature in °C for which a design gives its dimensions and its oil drag.
pub const REFERENCE_C: f64 = 20.0;

/// Meshing angles in degrees over which contacts between flank and pin are averaged: the whole loaded half.
const LOADED_HALF: std::ops::Range<usize> = 1..180;

impl Thermal {
    /// Increase of the pin circle's radius relative to the discs, R_p (α_h ΔT_h − α_d ΔT_d) in m.
    pub fn pin_circle_growth(&self, pin_circle_radius: f64) -> f64 {
        pin_circle_radius * self.strain()
    }

    /// α_h ΔT_h − α_d ΔT_d.
    fn strain(&self) -> f64 {
        self.temperature.map_or(0.0, |celsius| {
            let above = celsius - REFERENCE_C;
            self.housing_expansion * above - self.steel_expansion * (above + self.internal_excess)
        })
    }

    /// Manufacturing errors plus the thermal expansion of the ring of pins relative to the discs: pins expand
    /// with the housing, the generating radii with the discs.
    pub fn on(&self, errors: ManufacturingErrors, machine: &Machine) -> ManufacturingErrors {
        if self.temperature.is_none() {
            return errors;
        }
        ManufacturingErrors {
            pin_circle_radius: errors.pin_circle_radius
                + self.pin_circle_growth(machine.ring.pin_circle_radius),
            pin_radius: errors.pin_radius
                - machine.ring.pin_radius * self.steel_expansion * self.internal_excess,
            ..errors
        }
    }

    /// Axial approach of the main bearings' rows in m due to temperature: the carrier expands relative to the
    /// housing by e, radially e cot α for each row, and axially over half of the spacing, with the sign of the
    /// arrangement.
    pub fn preload_growth(&self, machine: &Machine) -> f64 {
        let rows = &machine.solids.main_rows;
        let radial = -0.5 * rows.row.pitch_diameter * self.strain();
        let axial = -0.5 * rows.spacing * self.strain();
        let along = if rows.row.contact_angle > 0.0 { radial / rows.row.contact_angle.tan() } else { 0.0 };
        along + if rows.back_to_back { -axial } else { axial }
    }

    /// Conductance in W/K of surface and mounting.
    pub fn cooling(&self) -> f64 {
        self.transfer * self.surface + self.mounting
    }

    /// The oil at a temperature in °C.
    pub fn lubrication(&self, celsius: f64) -> Lubrication {
        Lubrication {
            viscosity: self.oil.viscosity(celsius),
            pressure_viscosity: self.pressure_viscosity,
            roughness: self.roughness,
        }
    }
}

/// Friction of a machine at one temperature, speed and torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WarmFriction {
    /// Coefficients and drags at that temperature.
    pub friction: Friction,
    /// Mean film ratio of all contacts of the loaded half, weighted with the load.
    pub film_ratio: f64,
}

impl Machine {
    /// Losses at a temperature (°C), input speed (rad/s) and output torque (N·m). The coefficients of flanks,
    /// pin seats and gears are those of boundary friction, reduced by the film between flank and pin (mean over
    /// the loaded half of the ring, weighted with the friction power of each contact). The drag of the oil is
    /// proportional to its viscosity, that of the seals follows [`seal_share`]. Rolling friction does not
    /// change. The same reduction for gears as for flanks is an assumption.
    pub fn friction_at(&self, celsius: f64, input_speed: f64, torque: f64) -> WarmFriction {
        let lubrication = self.thermal.lubrication(celsius);
        let given = &self.friction;
        let (mut rubbed, mut power, mut film_sum, mut weight) = (0.0, 0.0, 0.0, 0.0);
        let boundary = given.flank;
        for degrees in LOADED_HALF {
            let Some((contact, load)) = self.mean_contact(degrees as f64, input_speed, torque) else {
                continue;
            };
            let (friction, ratio) = contact.friction(&lubrication, boundary);
            rubbed += load * contact.sliding * friction;
            power += load * contact.sliding;
            film_sum += load * ratio;
            weight += load;
        }
        let (flank, film_ratio) =
            if power > 0.0 { (rubbed / power, film_sum / weight) } else { (boundary, 0.0) };
        let share = if boundary > 0.0 { flank / boundary } else { 1.0 };
        let thin = self.thermal.oil.viscosity(celsius) / self.thermal.oil.viscosity(REFERENCE_C);
        WarmFriction {
            friction: Friction {
                // A machine without friction remains without it.
                flank: if boundary > 0.0 { flank } else { 0.0 },
                pin_seat: given.pin_seat * share,
                gear_mesh: given.gear_mesh * share,
                seal_drag: given.seal_drag * seal_share(celsius, self.thermal.oil.at_40c),
                oil_drag: given.oil_drag * thin,
                ..*given
            },
            film_ratio,
        }
    }

    /// The contact at a meshing angle under a load proportional to its lever arm, and that load in N.
    fn mean_contact(&self, degrees: f64, input_speed: f64, torque: f64) -> Option<(RubbingContact, f64)> {
        let profile = self.profile();
        let angle = degrees.to_radians();
        let cos = angle.cos();
        let kinematics = self.kinematics();
        let (output, _, relative) = kinematics.speeds(input_speed);
        let arm = kinematics.eccentricity * kinematics.lobe_count;
        let largest = 4.0 * torque.abs() / (self.disc_count as f64 * arm * self.ring.pin_count as f64);
        let load = largest * profile.lever_arm(angle).abs() / profile.largest_lever_arm();
        let curvature = profile.relative_curvature(cos, self.ring.pin_radius);
        // The meshing angle rotates with the eccentric relative to the ring, z_c/z_p of its rotation relative
        // to the disc.
        let turning = relative.abs() * kinematics.lobe_count / (kinematics.lobe_count + 1.0);
        let along = profile.flank_length_per_meshing_angle(cos).abs() * turning;
        let sliding = profile.specific_sliding(cos).abs() * along;
        let line = self.line_contact();
        (curvature > 0.0 && load > 0.0 && output != 0.0).then(|| {
            let contact = RubbingContact {
                effective_modulus: line.effective_modulus,
                radius: 1.0 / curvature,
                line_load: load / line.width,
                entrainment: film::entrainment_speed(along, sliding),
                sliding,
            };
            (contact, load)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::templates::tao2024;

    /// 0.74 µm per kelvin of difference for a pin circle of 64 mm; equal temperatures and expansions cause no
    /// change; a cast housing with smaller expansion reduces the gaps of the discs.
    #[test]
    fn the_ring_grows_against_the_discs() {
        let mut machine = tao2024();
        machine.thermal.temperature = Some(21.0);
        machine.thermal.internal_excess = -1.0;
        let growth = machine.thermal.pin_circle_growth(64e-3);
        assert!((growth - 0.736e-6).abs() < 1e-12, "{growth:e}");
        machine.thermal.internal_excess = 0.0;
        machine.thermal.temperature = Some(70.0);
        assert_eq!(
            machine.thermal.on(ManufacturingErrors::default(), &machine),
            ManufacturingErrors::default()
        );
        machine.thermal.housing_expansion = 10.5e-6;
        let errors = machine.thermal.on(ManufacturingErrors::default(), &machine);
        assert!((errors.pin_circle_radius + 64e-3 * 1e-6 * 50.0).abs() < 1e-15);
        assert!(machine.thermal.preload_growth(&machine) > 0.0);
    }

    /// Warm oil has a lower viscosity: less drag and a thinner film; the film thickness increases with speed.
    /// Friction remains below boundary friction. Sliding speed of one contact computed by hand from the closed
    /// form.
    #[test]
    fn friction_over_speed_and_temperature() {
        let mut machine = tao2024();
        machine.friction.flank = 0.1;
        machine.friction.oil_drag = 1e-4;
        machine.friction.seal_drag = 4.0;
        let at = |celsius: f64, share: f64| {
            machine.friction_at(celsius, share * machine.rated.input_speed, machine.rated.torque)
        };
        let (cold, warm, fast) = (at(20.0, 1.0), at(70.0, 1.0), at(70.0, 2.0));
        assert!((cold.friction.oil_drag / 1e-4 - 1.0).abs() < 1e-12);
        assert!(warm.friction.oil_drag < 0.15 * cold.friction.oil_drag);
        assert!(warm.film_ratio < cold.film_ratio && fast.film_ratio > warm.film_ratio);
        for state in [&cold, &warm, &fast] {
            assert!(state.friction.flank < 0.1 && state.friction.flank > 0.01, "{state:?}");
        }
        let creeping = at(20.0, 1e-7).friction.flank;
        assert!(creeping > 0.09, "{creeping}");
        let seals = warm.friction.seal_drag / machine.friction.seal_drag;
        assert_eq!(seals, seal_share(70.0, machine.thermal.oil.at_40c));
        let (contact, load) = machine.mean_contact(60.0, machine.rated.input_speed, 412.0).unwrap();
        // v_s = |PK| ω with |PK| = R_p S − r_p and the disc turning with the output.
        let s: f64 = (1.0 + 0.8125 * 0.8125 - 0.8125_f64).sqrt();
        let sliding = (64e-3 * s - 3e-3) * machine.rated.input_speed / 81.0;
        assert!((contact.sliding / sliding - 1.0).abs() < 1e-9, "{} {sliding}", contact.sliding);
        assert!(load > 200.0 && load < 420.0, "{load}");
    }
}
