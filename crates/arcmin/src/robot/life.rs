//! Wear of the joints by the programs: duty of each joint, its design with that duty, and test bench results at
//! every age.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::joint::AgedJoint;
use crate::analyses::joint::{GivenMasses, JointOptions, RvBench};
use crate::analyses::life::bearing_lives;
use crate::analyses::stage::{self, AnyDesign, EccentricDrive};
use crate::analyses::{AnalysisError, Host};
use crate::design::{Choice, Design, Family, Stated, Value};
use crate::exchange::{DutyRow, JointExport, Reduction, reduce_duty};
use crate::fidelity::{FidelityOptions, FrameBodies};
use crate::life::{MachineCourse, WornState};
use crate::machine::{FixedMember, OutputForces};
use crate::progress::Unseen;
use crate::rig::main_bearing_load;
use crate::units::{DEG, HOUR, RPM};
use crate::wear::CoupledOptions;

/// Duty of a joint by the programs.
#[derive(Debug, Clone, PartialEq)]
pub struct JointDuty {
    /// Load spectrum, torques at the output.
    pub rows: Vec<DutyRow>,
    /// Errors of the reduced duty relative to the programs; `None` if the joint does not move.
    pub reduction: Option<Reduction>,
    /// Hours in motion per hour of the robot.
    pub moving: f64,
    /// Power means over the rotation with the exponent 10/3 of bearing life: tilting moment in N·m, axial and
    /// radial force in N on the output.
    pub forces: OutputForces,
    /// Σ |T| |ω| t in J per hour of the robot, to which wear is proportional.
    pub work: f64,
    /// Root mean square of the torque over the time of the programs, N·m.
    pub torque_rms: f64,
    /// Largest torque, N·m.
    pub torque_peak: f64,
    /// Largest speed, rad/s.
    pub speed_peak: f64,
}

/// One sample of a joint.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// Torque on the link in N·m, and speed in rad/s.
    pub torque: f64,
    pub speed: f64,
    /// Time that the sample represents, in s per hour of the robot.
    pub time: f64,
    pub moves: bool,
    /// External moment in N·m and forces in N on the output.
    pub tilting: f64,
    pub axial: f64,
    pub radial: f64,
}

/// Exponent of life of roller bearings.
const LIFE: f64 = 10.0 / 3.0;

impl JointDuty {
    /// The duty of a joint from its samples, reduced to a number of rows; `ratio` gives the input speeds.
    pub fn of(moments: &[Moment], ratio: f64, rows: usize) -> JointDuty {
        let moving: Vec<&Moment> = moments.iter().filter(|m| m.moves && m.time > 0.0).collect();
        let samples: Vec<[f64; 3]> = moving.iter().map(|m| [m.torque, m.speed, m.time]).collect();
        let turns: f64 = moving.iter().map(|m| m.speed.abs() * m.time).sum();
        let mean = |of: &dyn Fn(&Moment) -> f64| {
            let sum: f64 = moving.iter().map(|m| of(m).abs().powf(LIFE) * m.speed.abs() * m.time).sum();
            if turns > 0.0 { (sum / turns).powf(1.0 / LIFE) } else { 0.0 }
        };
        let pulls: f64 = moving.iter().map(|m| m.axial * m.speed.abs() * m.time).sum();
        let forces = OutputForces {
            moment: mean(&|m| m.tilting),
            axial: mean(&|m| m.axial).copysign(pulls),
            radial: mean(&|m| m.radial),
        };
        let worn = samples.iter().any(|[torque, speed, _]| *torque != 0.0 && *speed != 0.0);
        let (rows, reduction) = match worn {
            true => {
                let (rows, reduction) = reduce_duty(&samples, rows, 1.0, ratio);
                (rows, Some(reduction))
            }
            false => (Vec::new(), None),
        };
        let time: f64 = moments.iter().map(|m| m.time).sum();
        let squares: f64 = moments.iter().map(|m| m.torque * m.torque * m.time).sum();
        let most = |of: fn(&Moment) -> f64| moments.iter().map(of).fold(0.0, |a: f64, b| a.max(b.abs()));
        JointDuty {
            rows,
            reduction,
            moving: moving.iter().map(|m| m.time).sum::<f64>() / HOUR,
            forces,
            work: moving.iter().map(|m| (m.torque * m.speed).abs() * m.time).sum(),
            torque_rms: if time > 0.0 { (squares / time).sqrt() } else { 0.0 },
            torque_peak: most(|m| m.torque),
            speed_peak: most(|m| m.speed),
        }
    }

    /// Work Σ |T| |ω| t per hour in motion, in J.
    pub fn work_in_motion(&self) -> f64 {
        work_in_motion(self.work, self.moving)
    }

    /// The design with this duty over these hours in motion, so that `arcmin life` computes the wear of the
    /// joint.
    ///
    /// # Errors
    /// Errors of the reader of design files, for values that it would reject.
    pub fn apply_to(
        &self,
        design: &AnyDesign,
        hours: f64,
        moments_in_wear: bool,
    ) -> Result<AnyDesign, AnalysisError> {
        let mut changes: Vec<(String, Value)> =
            vec![("limits.service_life_h".into(), hours.into()), ("duty".into(), Value::LeftOut)];
        // Drives of eccentrics have no model of forces on their output.
        let leans = moments_in_wear && design.family() == Family::Rv;
        for (index, row) in self.rows.iter().enumerate() {
            let mut set =
                |key: &str, value: f64| changes.push((format!("duty[{index}].{key}"), value.into()));
            set("torque_n_m", row.torque);
            set("input_speed_rpm", row.input_speed / RPM);
            set("share", row.share);
            if leans {
                set("moment_n_m", self.forces.moment);
                set("axial_n", self.forces.axial);
                set("radial_n", self.forces.radial);
            }
        }
        Ok(design.without_unknowns()?.with_all(changes)?)
    }
}

/// Work Σ |T| |ω| t per hour in motion (J), from the work and the hours in motion per hour of the robot.
pub fn work_in_motion(work: f64, moving: f64) -> f64 {
    if moving > 0.0 { work / moving } else { 0.0 }
}

/// Converts the hours of ages under one work per hour in motion (J) to another one: by Archard's law wear is
/// proportional to Σ |T| |ω| t, so that the same work leaves approximately the same surfaces. Exact if the
/// distribution of torques does not change.
pub fn scale_hours(ages: &mut [AgedJoint], work: f64, other: f64) {
    if work > 0.0 && other > 0.0 {
        ages.iter_mut().for_each(|age| age.hours *= work / other);
    }
}

/// A design with the mounting of the joint; drives of eccentrics have one mounting only, and no key for the
/// motor's inertia.
///
/// # Errors
/// Errors of the reader of design files, for values that it would reject.
pub fn mounted(
    design: &AnyDesign,
    mounting: Option<FixedMember>,
    motor_inertia: Option<f64>,
) -> Result<AnyDesign, AnalysisError> {
    if design.family() != Family::Rv {
        return Ok(design.clone());
    }
    let mut changes: Vec<(&str, Value)> = Vec::new();
    if let Some(member) = mounting {
        changes.push(("fixed_member", member.word().into()));
    }
    if let Some(inertia) = motor_inertia {
        changes.push(("gear_stage.motor_inertia_kg_m2", inertia.into()));
    }
    Ok(if changes.is_empty() { design.clone() } else { design.with_all(changes)? })
}

/// Parameters of the computation of joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    pub fidelity: FidelityOptions,
    pub ages: usize,
    pub positions: usize,
    pub error_positions: usize,
}

/// A joint over its life, as stored between runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointLife {
    /// Loops, errors and friction at every age.
    pub export: JointExport,
    /// Names and L10 lives of the bearings in hours in motion, for the duty.
    pub bearings: Vec<(String, f64)>,
}

/// Crank positions for bearing loads, as in `life`.
const BEARING_POSITIONS: usize = 72;

/// A life with its key.
#[derive(Serialize, Deserialize)]
struct Entry<L> {
    key: String,
    life: L,
}

/// Bytes of an entry of the cache: the SHA-256 of the rest in hexadecimal digits, a line feed, JSON.
fn entry(key: &str, life: &JointLife) -> Option<Vec<u8>> {
    let text = serde_json::to_string(&Entry { key: key.to_owned(), life }).ok()?;
    Some(format!("{}\n{text}", hash(&text)).into_bytes())
}

/// The life in an entry; `None` if it is damaged or belongs to another joint.
fn read_entry(bytes: &[u8], key: &str) -> Option<JointLife> {
    let (checksum, text) = std::str::from_utf8(bytes).ok()?.split_once('\n')?;
    let entry: Entry<JointLife> = serde_json::from_str(text).ok().filter(|_| checksum == hash(text))?;
    (entry.key == key).then_some(entry.life)
}

/// The life of a joint of a design with its duty; `rests` for one that does not move and does not age.
///
/// # Errors
/// [`AnalysisError`]: load sharing or equilibrium not found, runaway wear, loops that cannot be fitted.
pub fn live(
    design: &AnyDesign,
    measured: &Measured,
    rests: bool,
    host: &dyn Host,
) -> Result<JointLife, AnalysisError> {
    let key = key(design, measured, rests);
    let name = format!("joint-life-{}.reduced", &hash(&key)[..32]);
    if let Some(kept) = host.cached(&name).and_then(|bytes| read_entry(&bytes, &key)) {
        return Ok(kept);
    }
    let service = design.limits().service_life / HOUR;
    let ages: Vec<f64> = match rests {
        true => vec![0.0],
        false => (0..measured.ages).map(|age| service * age as f64 / (measured.ages - 1) as f64).collect(),
    };
    let life = match design {
        AnyDesign::Rv(design) => of_rv(design, measured, &ages, rests, host)?,
        AnyDesign::Eccentric(design) => of_stages(&**design, measured, ages, rests, host)?,
        AnyDesign::TwoRing(design) => of_stages(&**design, measured, ages, rests, host)?,
        AnyDesign::TwoStage(design) => of_stages(&**design, measured, ages, rests, host)?,
    };
    if let Some(bytes) = entry(&key, &life) {
        host.cache(&name, &bytes);
    }
    Ok(life)
}

/// For a drive of eccentrics, of whose bodies the discs alone may be elastic.
fn of_stages<D: EccentricDrive>(
    design: &D,
    measured: &Measured,
    ages: Vec<f64>,
    rests: bool,
    host: &dyn Host,
) -> Result<JointLife, AnalysisError> {
    let given = &measured.fidelity;
    let bodies = Stated { value: FrameBodies::Rigid, ..given.bodies };
    let options = JointOptions {
        fidelity: FidelityOptions { bodies, ..given.clone() },
        hours: ages,
        positions: measured.positions,
        error_positions: measured.error_positions,
        timestep: 1e-3,
        load_inertia: None,
        masses: GivenMasses::default(),
    };
    Ok(JointLife {
        export: stage::joint::joint(design, &options, (host, &Unseen(host)))?,
        bearings: if rests { Vec::new() } else { stage::joint::bearings(design, &options, host)? },
    })
}

/// For an RV reducer.
fn of_rv(
    design: &Design,
    measured: &Measured,
    ages: &[f64],
    rests: bool,
    host: &dyn Host,
) -> Result<JointLife, AnalysisError> {
    let nominal = design.machine();
    let bench = RvBench::new(design, &measured.fidelity, host)?;
    let fidelity = &bench.fidelity;
    let positions = (measured.positions, measured.error_positions);
    let mut course = match rests {
        true => None,
        false => Some(MachineCourse::new(&nominal, fidelity, CoupledOptions::default())?),
    };
    let mut states = Vec::with_capacity(ages.len());
    for (age, hours) in ages.iter().copied().enumerate() {
        let worn = match &mut course {
            Some(course) if age > 0 => {
                course.advance_to(hours, host).map_err(AnalysisError::wear("compute the wear"))?;
                course.state()
            }
            _ => WornState::new(),
        };
        states.push(bench.state(&worn, hours, positions, &Unseen(host))?);
    }
    let bearings = match rests {
        true => Vec::new(),
        false => bearing_lives(&nominal, &fidelity.joint_settings()?, BEARING_POSITIONS)?
            .bearings
            .into_iter()
            .map(|bearing| (bearing.name, bearing.life_h))
            .collect(),
    };
    Ok(JointLife { export: JointExport::new(&bench.drive, (1e-3, None), states), bearings })
}

/// Key of a life: all inputs that it depends on.
fn key(design: &AnyDesign, measured: &Measured, rests: bool) -> String {
    format!("joint life 3\n{}\n{}\n{measured:?}\n{rests}", env!("CARGO_PKG_VERSION"), design.canonical())
}

/// SHA-256 of a text, in hexadecimal digits.
pub fn hash(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Tilt of the output (rad) for moments up to `largest` (N·m), under the axial and radial force of the duty,
/// and the life of the main bearings in hours in motion.
///
/// # Errors
/// [`AnalysisError`] if the load has no equilibrium.
pub fn leaning(
    design: &Design,
    duty: &JointDuty,
    largest: f64,
) -> Result<(Vec<(f64, f64)>, Option<f64>), AnalysisError> {
    const STEPS: usize = 12;
    let machine = design.machine();
    let at = |moment: f64| {
        main_bearing_load(&machine, OutputForces { moment, ..duty.forces })
            .map_err(AnalysisError::compute("load the main bearings"))
    };
    let straight = at(0.0)?.tilt;
    let most = largest.max(1e-3 * machine.rated.torque.abs());
    let mut points = Vec::with_capacity(STEPS + 1);
    for step in 0..=STEPS {
        let moment = most * step as f64 / STEPS as f64;
        // The small tilt by the radial force alone is subtracted.
        points.push((moment, (at(moment)?.tilt - straight).max(0.0)));
    }
    let speed: f64 = duty.rows.iter().map(|row| row.share * row.input_speed.abs()).sum();
    let life = match speed > 0.0 && !duty.forces.is_zero() {
        true => Some(at(duty.forces.moment)?.life_h() * machine.rated.input_speed.abs() / speed),
        false => None,
    };
    Ok((points, life))
}

/// Degrees for messages.
pub(super) fn degrees(angle: f64) -> String {
    crate::report::compact(angle / DEG, 4)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyses::NoHost;
    use crate::templates::PRINTED_15;

    /// Joints have the discs that the robot file names; elastic discs of printed drives are half as stiff.
    #[test]
    fn the_discs_of_a_single_stage_are_those_of_the_robot_file() {
        let design = AnyDesign::parse(PRINTED_15.text, PRINTED_15.file).unwrap();
        let stiffness = |discs: &str| {
            let words = format!("joints = \"bearings\"\ndiscs = \"{discs}\"\n");
            let fidelity = FidelityOptions::parse(&words, "the section [model]").unwrap();
            let measured = Measured { fidelity, ages: 2, positions: 1, error_positions: 64 };
            live(&design, &measured, true, &NoHost).unwrap().export.states[0].stiffness_n_m_per_rad
        };
        let [rigid, elastic] = ["rigid", "elastic"].map(stiffness);
        assert!(elastic < 0.6 * rigid, "{elastic} {rigid}");
    }
}
