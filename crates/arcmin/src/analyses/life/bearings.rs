//! Rating lives of all bearings at the duty.

use super::demands::Demands;
use crate::analyses::AnalysisError;
use crate::analyses::rig::with_friction;
use crate::dynamics::{JointSettings, TiltingOutput};
use crate::machine::{DutyPoint, Machine};
use crate::results::{TableOf, decimals, quantities as q, quantity};
use crate::rig::{BearingLoad, bearing_loads, dynamic_load_rating, main_bearing_load};
use crate::units::HOUR;

/// Basic rating life of one bearing at the duty.
#[derive(Debug, Clone, PartialEq)]
pub struct BearingLife {
    /// Kind and place of the bearing, for tables.
    pub name: String,
    /// Equivalent dynamic load P in N over duty and crank turn.
    pub equivalent: f64,
    /// C in N.
    pub rating: f64,
    /// L10h in h.
    pub life_h: f64,
}

/// All turning-arm bearings and crank supports, and the main bearings if the duty has tilting moments or forces on
/// the output.
#[derive(Debug, Clone, PartialEq)]
pub struct BearingLives {
    /// Bearing by bearing.
    pub bearings: Vec<BearingLife>,
    /// L10h in h of all bearings together.
    pub system_h: f64,
    /// If the design gives no friction and the lives contain an assumed one: the coefficient on the flanks, and the
    /// shortest life in h without friction.
    pub assumed_friction: Option<AssumedFriction>,
}

/// Assumed friction in the bearing lives of a design without friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AssumedFriction {
    /// Coulomb coefficient between flank and pin.
    pub flank: f64,
    /// Shortest life of the bearings in h without it.
    pub without_h: f64,
}

/// Crank positions over a turn of the crankshafts.
pub(super) const POSITIONS: usize = 72;
/// Weibull slope of rolling bearings with line contact (ISO 281; Lundberg and Palmgren).
pub(in crate::analyses) const WEIBULL_SLOPE: f64 = 9.0 / 8.0;

/// `bearing_life.csv`.
pub(in crate::analyses) const TABLE: TableOf<BearingLife> = TableOf {
    name: "bearing_life",
    what: "One row per bearing, at the duty of the design",
    columns: || {
        vec![
            q::BEARING.of(|b: &BearingLife| b.name.clone().into()),
            quantity(
                "duty_equivalent_load_n",
                decimals(0),
                "Equivalent dynamic load over duty and crank turn (ISO 281, exponent 10/3, balls 3).",
            )
            .of(|b| b.equivalent.into()),
            quantity("dynamic_load_rating_n", decimals(0), "Basic dynamic load rating C.")
                .of(|b| b.rating.into()),
            quantity("life_l10_h", decimals(0), "Basic rating life L10 at the duty.").of(|b| b.life_h.into()),
        ]
    },
};

/// Rating lives of the new machine by ISO 281, with the friction of the test bench: damages of the rows of the duty
/// add up (Palmgren–Miner), and the system fails with its first bearing, L^(−e) = Σ L_i^(−e) with e = 9/8. Rows
/// without torque or speed do no damage.
///
/// # Errors
/// [`AnalysisError`] where a balance cannot be found.
pub fn bearing_lives(
    machine: &Machine,
    settings: &JointSettings,
    positions: usize,
) -> Result<BearingLives, AnalysisError> {
    let lives = lives_in_friction(machine, settings, positions)?;
    let (rough, assumed) = with_friction(machine, false);
    if !assumed {
        return Ok(lives);
    }
    let smooth = lives_as_given(machine, settings, positions)?;
    let without = smooth.worst().map(|worst| worst.life_h);
    let assumed_friction =
        without.map(|without_h| AssumedFriction { flank: rough.friction.flank, without_h });
    Ok(BearingLives { assumed_friction, ..lives })
}

/// [`bearing_lives`] without the comparison with no friction.
pub(super) fn lives_in_friction(
    machine: &Machine,
    settings: &JointSettings,
    positions: usize,
) -> Result<BearingLives, AnalysisError> {
    // Friction in the mesh adds to the loads of the bearings; if a design gives none, that of the bench is assumed.
    lives_as_given(&with_friction(machine, false).0, settings, positions)
}

/// [`bearing_lives`] with the friction that the machine has.
fn lives_as_given(
    machine: &Machine,
    settings: &JointSettings,
    positions: usize,
) -> Result<BearingLives, AnalysisError> {
    let acts = |row: &&DutyPoint| {
        row.torque.abs() > 1e-6 * machine.rated.torque.abs() && row.input_speed != 0.0 && row.share > 0.0
    };
    let mut rows: Vec<(f64, Vec<BearingLoad>)> = Vec::new();
    for row in machine.duty.iter().filter(acts) {
        let at_row = Machine { rated: DutyPoint { share: 1.0, ..*row }, ..machine.clone() };
        let tilt = match row.forces.is_zero() {
            true => settings.tilt.clone(),
            false => Some(TiltingOutput::of(machine, row.forces)),
        };
        let settings = JointSettings { tilt, ..settings.clone() };
        let loads = bearing_loads(&at_row, &settings, positions)
            .map_err(AnalysisError::compute("find the loads of the bearings"))?;
        rows.push((row.share, loads));
    }
    let count = rows.first().map_or(0, |(_, loads)| loads.len());
    let mut bearings: Vec<BearingLife> = (0..count)
        .map(|index| {
            let of = |loads: &[BearingLoad]| (loads[index].life_h(), loads[index].rating);
            let damage: f64 = rows.iter().map(|(share, loads)| share / of(loads).0).sum();
            let speed: f64 =
                rows.iter().map(|(share, loads)| share * turns_per_hour(&loads[index], machine)).sum();
            let (_, rating) = of(&rows[0].1);
            let life_h = 1.0 / damage;
            let power = exponent(machine, &rows[0].1[index].name);
            BearingLife {
                name: rows[0].1[index].name.clone(),
                equivalent: rating * (1e6 / (life_h * speed)).powf(1.0 / power),
                rating,
                life_h,
            }
        })
        .collect();
    bearings.extend(main_bearings(machine)?);
    Ok(BearingLives { system_h: system_life(&bearings), bearings, assumed_friction: None })
}

/// L10h in h of bearings together: L^(−e) = Σ L_i^(−e).
pub(in crate::analyses) fn system_life(bearings: &[BearingLife]) -> f64 {
    let system: f64 = bearings.iter().map(|bearing| bearing.life_h.powf(-WEIBULL_SLOPE)).sum();
    system.powf(-1.0 / WEIBULL_SLOPE)
}

/// The pair of main bearings, where the duty tilts or pulls the output: life by ISO/TS 16281 row by row of the duty,
/// damages added up; P from C, the life and the mean speed. Without such forces their load is negligible.
fn main_bearings(machine: &Machine) -> Result<Option<BearingLife>, AnalysisError> {
    if machine.duty.iter().all(|row| row.forces.is_zero()) {
        return Ok(None);
    }
    let (mut damage, mut turns) = (0.0, 0.0);
    for row in machine.duty.iter().filter(|row| row.input_speed != 0.0 && row.share > 0.0) {
        let at_row = Machine { rated: DutyPoint { share: 1.0, ..*row }, ..machine.clone() };
        let found = main_bearing_load(&at_row, row.forces)
            .map_err(AnalysisError::compute("load the main bearings"))?;
        damage += row.share / found.life_h();
        let speed = machine.kinematics().speeds(row.input_speed).0.abs();
        turns += row.share * speed * HOUR / std::f64::consts::TAU;
    }
    let row = &machine.solids.main_rows.row;
    let (life_h, rating) = (1.0 / damage, dynamic_load_rating(row));
    let power = row.kind.life_exponent();
    let equivalent = rating * (1e6 / (life_h * turns)).powf(1.0 / power);
    Ok((damage > 0.0).then(|| BearingLife { name: "main bearings".to_owned(), equivalent, rating, life_h }))
}

fn exponent(machine: &Machine, name: &str) -> f64 {
    let bearing = if name.starts_with("turning arm") {
        &machine.bearings.turning_arm
    } else {
        &machine.bearings.crank_support
    };
    bearing.kind.life_exponent()
}

/// From the definition of the life: L10h = (C/P)^p 10⁶ turns.
fn turns_per_hour(load: &BearingLoad, machine: &Machine) -> f64 {
    1e6 * (load.rating / load.equivalent).powf(exponent(machine, &load.name)) / (load.life / HOUR)
}

impl BearingLives {
    /// The bearing with the shortest life; `None` if nothing turns under load.
    pub fn worst(&self) -> Option<&BearingLife> {
        self.bearings.iter().min_by(|a, b| a.life_h.total_cmp(&b.life_h))
    }

    /// Share of machines without failure of a bearing after some hours: 0.9^((t/L10)^e) with the system's L10 (ISO
    /// 281: nine of ten survive an L10).
    pub fn survival(&self, hours: f64) -> f64 {
        0.9_f64.powf((hours / self.system_h).powf(WEIBULL_SLOPE))
    }
}

/// The maker's catalogue life (hours at rated torque and 15 rpm of the output) at the duty, by ISO 281: L =
/// L_c (15/n_m) (T_r/T_m)^(10/3), n_m and T_m the mean speed and the equivalent torque of the duty. `None`
/// where nothing turns under load.
pub fn catalogue_life_at_duty(demands: &Demands, hours: f64) -> Option<f64> {
    const CATALOGUE_RPM: f64 = 15.0;
    let power = 10.0 / 3.0;
    let damage = |row: &DutyPoint| {
        let speed = demands.output_speed(row) / crate::units::RPM;
        row.share * speed / CATALOGUE_RPM * (row.torque / demands.rated_torque).abs().powf(power)
    };
    let damage: f64 = demands.duty.iter().map(damage).sum();
    (damage > 0.0).then(|| hours / damage)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::OutputForces;

    /// One row: the life of the bench. Two halves at full and half torque: 2/(1 + 2^(−10/3)) of it, as near
    /// as loads follow the torque.
    #[test]
    fn lives_follow_the_duty() {
        let machine = crate::templates::tao2024();
        let settings = JointSettings::default();
        let one = bearing_lives(&machine, &settings, 12).unwrap();
        let (rough, _) = with_friction(&machine, false);
        let bench = bearing_loads(&rough, &settings, 12).unwrap();
        for (life, load) in one.bearings.iter().zip(&bench) {
            assert!((life.life_h / load.life_h() - 1.0).abs() < 1e-9);
            assert!((life.equivalent / load.equivalent - 1.0).abs() < 1e-9);
        }
        let (worst, system) = (one.worst().unwrap().life_h, one.system_h);
        // 90 % of machines reach the L10 of the system; the reliabilities of the single bearings give the same.
        let product: f64 =
            one.bearings.iter().map(|b| 0.9_f64.powf((system / b.life_h).powf(WEIBULL_SLOPE))).product();
        assert!((one.survival(system) - 0.9).abs() < 1e-12 && (product - 0.9).abs() < 1e-12);
        // The design gives no friction: the lives contain the assumed one and state it.
        let assumed = one.assumed_friction.unwrap();
        let smooth = bearing_loads(&machine, &settings, 12).unwrap();
        let shortest = smooth.iter().map(BearingLoad::life_h).fold(f64::INFINITY, f64::min);
        assert!((assumed.without_h / shortest - 1.0).abs() < 1e-9 && assumed.without_h > worst);
        assert_eq!(assumed.flank, rough.friction.flank);
        assert_eq!(bearing_lives(&rough, &settings, 12).unwrap().assumed_friction, None);
        assert!(system < worst && system > worst / (one.bearings.len() as f64).powf(8.0 / 9.0), "{system}");
        let mut two = machine.clone();
        two.duty = vec![
            DutyPoint { share: 0.5, ..machine.rated },
            DutyPoint { share: 0.5, torque: 0.5 * machine.rated.torque, ..machine.rated },
        ];
        let of_two = bearing_lives(&two, &settings, 12).unwrap();
        let expected = 2.0 / (1.0 + 0.5_f64.powf(10.0 / 3.0));
        let found = of_two.worst().unwrap().life_h / worst;
        assert!((found / expected - 1.0).abs() < 0.03, "{found} {expected}");
    }

    /// With a duty that tilts the output the lives include the main bearings: for a single row the life of the bench, for two
    /// rows by their damages. Otherwise they are not included.
    #[test]
    fn a_tilting_duty_wears_the_main_bearings() {
        let mut machine = crate::templates::tao2024();
        let settings = JointSettings::default();
        let lives = |machine: &Machine| bearing_lives(machine, &settings, 6).unwrap();
        let of_main = |lives: &BearingLives| {
            lives
                .bearings
                .iter()
                .find(|bearing| bearing.name == "main bearings")
                .map(|bearing| bearing.life_h)
        };
        let upright = lives(&machine);
        assert_eq!(of_main(&upright), None);
        let forces = |moment: f64| OutputForces { moment, axial: 500.0, radial: 0.0 };
        let row = |share: f64, moment: f64| DutyPoint { share, forces: forces(moment), ..machine.rated };
        let alone = |moment: f64| main_bearing_load(&machine, forces(moment)).unwrap().life_h();
        let (heavy, light) = (alone(700.0), alone(300.0));
        let (one, two) = (vec![row(1.0, 700.0)], vec![row(0.25, 700.0), row(0.75, 300.0)]);
        machine.duty = one;
        let tilted = lives(&machine);
        assert!((of_main(&tilted).unwrap() / heavy - 1.0).abs() < 1e-12);
        assert!(tilted.system_h < upright.system_h);
        machine.duty = two;
        let expected = 1.0 / (0.25 / heavy + 0.75 / light);
        assert!((of_main(&lives(&machine)).unwrap() / expected - 1.0).abs() < 1e-12);
    }

    /// At rated torque and 15 rpm of the output the result is the catalogue life.
    #[test]
    fn catalogue_life_is_kept_at_its_own_conditions() {
        let mut machine = crate::templates::tao2024();
        let speed = 15.0 * crate::units::RPM * machine.kinematics().ratio();
        machine.duty = vec![DutyPoint { input_speed: speed, share: 1.0, ..machine.rated }];
        assert!((catalogue_life_at_duty(&Demands::of(&machine), 6000.0).unwrap() - 6000.0).abs() < 1e-6);
        machine.duty[0].torque *= 0.5;
        let half = catalogue_life_at_duty(&Demands::of(&machine), 6000.0).unwrap();
        assert!((half / 6000.0 - 2.0_f64.powf(10.0 / 3.0)).abs() < 1e-9);
    }
}
