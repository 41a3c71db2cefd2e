use std::f64::consts::TAU;

use super::RigError;
use super::settle::run;
use crate::dynamics::{BearingJoints, JointSettings};
use crate::machine::{Machine, RollerBearing, RollerKind};
use crate::units::HOUR;

/// Loads of one bearing over a crank turn at rated torque, and its basic rating life.
#[derive(Debug, Clone, PartialEq)]
pub struct BearingLoad {
    /// Kind and place of the bearing, for tables.
    pub name: String,
    /// Radial force (N) at equidistant crank angles.
    pub forces: Vec<f64>,
    /// Largest force on one rolling element, N.
    pub largest_element: f64,
    /// Largest axial force in N between the two tapered supports of a crankshaft; 0 for all other bearings.
    pub axial: f64,
    /// Equivalent dynamic load P in N: mean of the 10/3rd (balls: third) power.
    pub equivalent: f64,
    /// Dynamic load rating C in N, given or by ISO 281.
    pub rating: f64,
    /// L10h in s: (C/P)^p 10⁶ turns at the relative speed of the rings.
    pub life: f64,
}

/// Axial force (N) on both tapered supports of a crankshaft under radial forces in face-to-face or back-to-back
/// arrangement: the larger of F/(2 Y), Y = 0.4 cot α (ISO 281; makers' catalogues), which loads the other
/// support.
fn induced_axial(support: &RollerBearing, radial: [f64; 2]) -> f64 {
    match support.kind {
        RollerKind::Tapered => radial[0].max(radial[1]) * support.contact_angle.tan() / 0.8,
        RollerKind::Cylindrical | RollerKind::Ball => 0.0,
    }
}

/// Dynamic equivalent load (N) of a row of rollers by ISO 281: F_r, or 0.4 F_r + Y F_a beyond F_a/F_r = 1.5 tan α.
fn equivalent_load(support: &RollerBearing, radial: f64, axial: f64) -> f64 {
    let slope = support.contact_angle.tan();
    if axial <= 1.5 * slope * radial { radial } else { (0.4 * (radial + axial / slope)).max(radial) }
}

/// Basic dynamic radial load rating C in N by ISO 281: b_m f_c (L cos α)^(7/9) Z^(3/4) D^(29/27) for rollers
/// and b_m f_c (cos α)^0.7 Z^(2/3) D^1.8 for balls up to 25.4 mm, f_c from the formulae behind its tables
/// (ISO/TR 1281-1), one row.
pub fn dynamic_load_rating(bearing: &RollerBearing) -> f64 {
    if let Some(rating) = bearing.dynamic_load_rating {
        return rating;
    }
    let (d, z) = (bearing.roller_diameter * 1e3, bearing.roller_count as f64);
    let cosine = bearing.contact_angle.cos();
    let gamma = d * cosine / (bearing.pitch_diameter * 1e3);
    let ratio = (1.0 - gamma) / (1.0 + gamma);
    match bearing.kind {
        RollerKind::Cylindrical | RollerKind::Tapered => {
            let inner_outer = (1.0 + (1.04 * ratio.powf(143.0 / 108.0)).powf(4.5)).powf(-2.0 / 9.0);
            let fc = 207.9 * 0.83 * gamma.powf(2.0 / 9.0) * (1.0 - gamma).powf(29.0 / 27.0)
                / (1.0 + gamma).powf(0.25)
                * inner_outer;
            1.1 * fc
                * (bearing.roller_length * 1e3 * cosine).powf(7.0 / 9.0)
                * z.powf(0.75)
                * d.powf(29.0 / 27.0)
        }
        RollerKind::Ball => {
            // Groove radii 0.52 d on both raceways.
            let inner_outer = (1.0 + (1.04 * ratio.powf(1.72)).powf(10.0 / 3.0)).powf(-0.3);
            let groove = (1.04_f64 / 0.04).powf(0.41);
            let fc = 98.0665 * 0.41 * 0.95 * groove * gamma.powf(0.3) * (1.0 - gamma).powf(1.39)
                / (1.0 + gamma).powf(1.0 / 3.0)
                * inner_outer;
            let size = if d <= 25.4 { d.powf(1.8) } else { 3.647 * d.powf(1.4) };
            1.3 * fc * cosine.powf(0.7) * z.powf(2.0 / 3.0) * size
        }
    }
}

/// Forces of all turning-arm bearings and crank supports over one turn of the crankshaft relative to the
/// carrier, rated torque and speed.
///
/// # Errors
/// [`RigError`] where no equilibrium is found.
pub fn bearing_loads(
    machine: &Machine,
    settings: &JointSettings,
    positions: usize,
) -> Result<Vec<BearingLoad>, RigError> {
    let mut model = BearingJoints::held(machine, &JointSettings { damped: false, ..settings.clone() })?;
    let kinematics = model.kinematics().clone();
    let ratio = kinematics.ratio();
    let (cranks, discs) = (machine.crankshafts.count, machine.disc_count);
    let (output_speed, crank_speed, _) = kinematics.speeds(machine.rated.input_speed);
    let mut names = Vec::new();
    for k in 0..cranks {
        names.extend((0..discs).map(|j| format!("turning arm, crankshaft {}, disc {}", k + 1, j + 1)));
        names
            .extend(["planet side", "far side"].map(|side| format!("support, crankshaft {}, {side}", k + 1)));
    }
    let mut forces = vec![Vec::with_capacity(positions); names.len()];
    // Loads in the rating life, per position.
    let mut carried = forces.clone();
    let mut largest = vec![0.0_f64; names.len()];
    let mut axial = vec![0.0_f64; names.len()];
    let direction = machine.rated.input_speed.signum();
    let mut deviation: Vec<f64> = Vec::new();
    for i in 0..positions {
        let sun = direction * TAU * i as f64 / positions as f64 * ratio.abs() / (kinematics.lobe_count + 1.0);
        model.hold_sun(sun, machine.rated.input_speed);
        model.set_load(ratio.signum() * machine.rated.torque);
        let nominal = model.nominal_position_at(sun);
        let velocity = model.nominal_velocity_at(sun, machine.rated.input_speed);
        let start: Vec<f64> =
            nominal.iter().enumerate().map(|(n, x)| x + deviation.get(n).copied().unwrap_or(0.0)).collect();
        let q = run(&model, &start, velocity)?;
        let mut at = 0;
        for k in 0..cranks {
            let loads = (0..discs)
                .map(|j| model.turning_arm_load(k, j, &q).0)
                .chain((0..2).map(|end| model.support_load(k, end, &q).0));
            let first = at;
            for state in loads.collect::<Vec<_>>() {
                let force = state.gradient[0].hypot(state.gradient[1]);
                forces[at].push(force);
                carried[at].push(force);
                largest[at] = largest[at].max(state.largest_element);
                at += 1;
            }
            let support = &machine.bearings.crank_support;
            let ends = [first + discs, first + discs + 1];
            let along = induced_axial(support, ends.map(|end| forces[end][i]));
            if along > 0.0 {
                for end in ends {
                    axial[end] = axial[end].max(along);
                    carried[end][i] = equivalent_load(support, forces[end][i], along);
                }
            }
        }
        deviation = q.iter().zip(&nominal).map(|(q, n)| q - n).collect();
    }
    // Relative turn of both rings: the same for disc and carrier.
    let turns_per_second = (crank_speed - output_speed).abs() / TAU;
    let load = |(index, (name, forces)): (usize, (String, Vec<f64>))| {
        let bearing = match index % (discs + 2) < discs {
            true => &machine.bearings.turning_arm,
            false => &machine.bearings.crank_support,
        };
        let power = bearing.kind.life_exponent();
        let mean = carried[index].iter().map(|f| f.powf(power)).sum::<f64>() / positions.max(1) as f64;
        let equivalent = mean.powf(1.0 / power);
        let rating = dynamic_load_rating(bearing);
        let life = rating_life(bearing, equivalent, turns_per_second);
        let (largest_element, axial) = (largest[index], axial[index]);
        BearingLoad { name, forces, largest_element, axial, equivalent, rating, life }
    };
    Ok(names.into_iter().zip(forces).enumerate().map(load).collect())
}

/// Basic rating life in s under an equivalent load (N), L10 = (C/P)^p 10⁶ turns [ISO 281].
pub fn rating_life(bearing: &RollerBearing, equivalent: f64, turns_per_second: f64) -> f64 {
    1e6 * (dynamic_load_rating(bearing) / equivalent).powf(bearing.kind.life_exponent()) / turns_per_second
}

impl BearingLoad {
    /// L10h in hours.
    pub fn life_h(&self) -> f64 {
        self.life / HOUR
    }

    /// Mean of the radial force over the crank angles, N.
    pub fn mean_force(&self) -> f64 {
        self.forces.iter().sum::<f64>() / self.forces.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::templates::tao2024;

    /// Two equally loaded tapered supports of 15°: each loads the other axially by F/(2 Y), Y = 1.49, and its
    /// equivalent load is its radial force; the unloaded one of two has Y S = F/2.
    #[test]
    fn tapered_supports_push_each_other() {
        let support = RollerBearing {
            kind: RollerKind::Tapered,
            contact_angle: 15.0_f64.to_radians(),
            ..tao2024().bearings.crank_support
        };
        let axial = induced_axial(&support, [3000.0, 3000.0]);
        assert!((axial - 3000.0 / (2.0 * 1.492_82)).abs() < 0.1, "{axial}");
        assert_eq!(equivalent_load(&support, 3000.0, axial), 3000.0);
        let axial = induced_axial(&support, [3000.0, 0.0]);
        assert!((equivalent_load(&support, 0.0, axial) - 1500.0).abs() < 1e-6);
        let straight = RollerBearing { kind: RollerKind::Cylindrical, ..support };
        assert_eq!(induced_axial(&straight, [3000.0, 0.0]), 0.0);
    }

    /// In a machine with tapered supports the less loaded support has a shorter life than by its radial force
    /// alone.
    #[test]
    fn axial_forces_shorten_the_life_of_the_lighter_support() {
        let mut machine = tao2024();
        let settings = JointSettings::default();
        machine.bearings.crank_support.contact_angle = 0.2;
        machine.bearings.crank_support.dynamic_load_rating = Some(20e3);
        let supports = |machine: &Machine| -> Vec<BearingLoad> {
            let loads = bearing_loads(machine, &settings, 8).unwrap();
            loads.into_iter().filter(|load| load.name.starts_with("support")).collect()
        };
        machine.bearings.crank_support.kind = RollerKind::Cylindrical;
        let straight = supports(&machine);
        machine.bearings.crank_support.kind = RollerKind::Tapered;
        let tapered = supports(&machine);
        for (a, b) in tapered.iter().zip(&straight) {
            assert!(a.axial > 0.0 && b.axial == 0.0);
            assert!(a.equivalent >= b.equivalent && a.life <= b.life);
        }
    }
}
