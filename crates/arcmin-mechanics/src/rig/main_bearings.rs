//! Tilt, stiffness and life of the pair of main bearings under moment, axial and radial force.

use super::RigError;
use super::bearing_life::dynamic_load_rating;
use crate::dynamics::{ElementLoad, MainBearings, RingVector};
use crate::machine::{Machine, OutputForces, RollerBearing, RollerKind};
use crate::units::HOUR;

/// Displacement, stiffness and life of the main bearings under load.
#[derive(Debug, Clone, PartialEq)]
pub struct MainBearingLoad {
    /// Forces and moment on the output.
    pub forces: OutputForces,
    /// Moment stiffness dM/dφ in N·m/rad without load and under load.
    pub moment_stiffness: [f64; 2],
    /// Axial stiffness in N/m without load.
    pub axial_stiffness: f64,
    /// Tilt of the output in rad.
    pub tilt: f64,
    /// Axial and radial displacement in m.
    pub displacement: [f64; 2],
    /// Largest force on one element in N.
    pub largest_element: f64,
    /// Number of loaded elements in both rows.
    pub loaded: usize,
    /// L10 of the pair in s at the rated speed of the output.
    pub life: f64,
}

/// The pair of bearings under forces at the output. Forces of the mechanism are neglected: with equal, opposite
/// discs gears and discs load the main bearings very little.
///
/// Life by ISO/TS 16281 from the forces of all elements (balls: exponents 3 and 10/3; rollers: 4 and 9/2,
/// without laminae), both rows combined by L^(−e), e = 10/9 or 9/8; the inner rings turn with the carrier.
///
/// # Errors
/// [`RigError::Balance`] if the clearance of the rows is so large that no equilibrium is found.
pub fn main_bearing_load(machine: &Machine, forces: OutputForces) -> Result<MainBearingLoad, RigError> {
    let row = &machine.solids.main_rows.row;
    let bearings = MainBearings::of(machine);
    let still = bearings.balance(&RingVector::zeros())?;
    let load = RingVector::from([forces.radial, 0.0, forces.axial, 0.0, forces.moment]);
    let found = bearings.balance(&load)?;
    let speed = machine.kinematics().speeds(machine.rated.input_speed).0.abs();
    let turns = pair_life(row, &found.elements);
    let moved = found.displacement - still.displacement;
    Ok(MainBearingLoad {
        forces,
        moment_stiffness: [&still, &found].map(|balance| balance.moment_stiffness()[1]),
        axial_stiffness: still.state.stiffness.try_inverse().map_or(0.0, |inverse| 1.0 / inverse[(2, 2)]),
        tilt: moved[4].hypot(moved[3]),
        displacement: [moved[2], moved[0].hypot(moved[1])],
        largest_element: found.largest_element(),
        loaded: found.elements.iter().flatten().filter(|element| element.force > 0.0).count(),
        life: if speed > 0.0 { turns * std::f64::consts::TAU / speed } else { f64::INFINITY },
    })
}

impl MainBearingLoad {
    /// L10 in hours.
    pub fn life_h(&self) -> f64 {
        self.life / HOUR
    }
}

/// L10 in turns of both rows.
fn pair_life(row: &RollerBearing, elements: &[Vec<ElementLoad>; 2]) -> f64 {
    let slope = if row.kind == RollerKind::Ball { 10.0 / 9.0 } else { 9.0 / 8.0 };
    let both: f64 = elements.iter().map(|row_elements| row_life(row, row_elements).powf(-slope)).sum();
    both.powf(-1.0 / slope)
}

/// L10 in turns of one row by ISO/TS 16281: L = 10⁶ [(Q_ci/Q_ei)^(−pe) + (Q_ce/Q_ee)^(−pe)]^(−1/e).
fn row_life(row: &RollerBearing, elements: &[ElementLoad]) -> f64 {
    let mean = |p: f64| -> f64 {
        let sum: f64 = elements.iter().map(|element| element.force.powf(p)).sum();
        (sum / elements.len() as f64).powf(1.0 / p)
    };
    let rating = dynamic_load_rating(row);
    let (z, cosine) = (row.roller_count as f64, row.contact_angle.cos());
    let gamma = row.roller_diameter * cosine / row.pitch_diameter;
    let ratio = (1.0 - gamma) / (1.0 + gamma);
    let (rated, carried, power, slope) = if row.kind == RollerKind::Ball {
        let shared = 1.044 * ratio.powf(1.72);
        let split = |sign: f64| (1.0 + shared.powf(sign * 10.0 / 3.0)).powf(0.3);
        let each = rating / (z * cosine.powf(0.7));
        (
            [each / 0.407 * split(1.0), each / 0.389 * split(-1.0)],
            [mean(3.0), mean(10.0 / 3.0)],
            10.0 / 3.0,
            0.9,
        )
    } else {
        let shared = 1.038 * ratio.powf(143.0 / 108.0);
        let split = |sign: f64| (1.0 + shared.powf(sign * 4.5)).powf(2.0 / 9.0);
        let each = rating / (z * cosine);
        ([each / 0.378 * split(1.0), each / 0.364 * split(-1.0)], [mean(4.0), mean(4.5)], 4.5, 8.0 / 9.0)
    };
    let damage: f64 = rated.iter().zip(carried).map(|(rated, carried)| (carried / rated).powf(power)).sum();
    if damage > 0.0 { 1e6 * damage.powf(-slope) } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::RollingBearing;
    use crate::templates::tao2024;
    use crate::units::ARCMIN;

    /// A radial load on half of the circumference of a deep-groove row gives the life (C/F)³ of ISO 281 for
    /// balls, within the rounding of its tables: the rating is defined for this load distribution. Rollers in
    /// line contact give Lundberg and Palmgren's fourth power; the exponent 10/3 of ISO 281 is for mixed line
    /// and point contact.
    #[test]
    fn val_life_of_a_half_loaded_row_is_iso_281s() {
        for (kind, power) in [(RollerKind::Ball, 3.0), (RollerKind::Cylindrical, 4.0)] {
            let row = RollerBearing {
                kind,
                roller_count: 24,
                roller_diameter: 8e-3,
                roller_length: 8e-3,
                pitch_diameter: 80e-3,
                contact_angle: 0.0,
                clearance: 0.0,
                dynamic_load_rating: Some(20e3),
            };
            let single = RollingBearing::row(&row, 0.0, 1.0, 0.0);
            let at = RingVector::from([8e-6, 0.0, 0.0, 0.0, 0.0]);
            let force = single.react(&at).load[0];
            let life = row_life(&row, &single.elements(&at));
            let expected = 1e6 * (20e3 / force).powf(power);
            assert!((life / expected - 1.0).abs() < 0.12, "{kind:?}: {life:e} {expected:e}");
        }
    }

    /// A larger moment gives a larger tilt and a shorter life; the stiffness under load is the slope between
    /// two loads.
    #[test]
    fn moments_tilt_the_output() {
        let machine = tao2024();
        let at = |moment: f64| {
            main_bearing_load(&machine, OutputForces { moment, axial: 500.0, radial: 0.0 }).unwrap()
        };
        let (low, middle, high) = (at(395.0), at(400.0), at(405.0));
        assert!(low.tilt < middle.tilt && high.life < low.life && high.largest_element > low.largest_element);
        let slope = 10.0 / (high.tilt - low.tilt);
        assert!((slope / middle.moment_stiffness[1] - 1.0).abs() < 0.01, "{slope} {middle:?}");
        let per_arcmin = middle.moment_stiffness[0] * ARCMIN;
        println!("{per_arcmin} N·m/arcmin, {middle:?}");
        assert!(per_arcmin > 100.0 && per_arcmin < 5000.0, "{per_arcmin}");
        let rest = main_bearing_load(&machine, OutputForces::default()).unwrap();
        assert!(rest.tilt == 0.0 && rest.life > middle.life && rest.loaded > 0);
    }
}
