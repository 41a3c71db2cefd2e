//! Drives of eccentrics as joints of a robot model: results of their bench in the form of the export.

use std::f64::consts::TAU;

use super::drive::{EccentricDrive, Efficiency};
use super::made::{Made, MadeOptions};
use super::{Rests, rig};
use crate::analyses::joint::{BETWEEN, GivenMasses, JointOptions, PIN_POSITIONS, PIN_SHARES};
use crate::analyses::{AnalysisError, Host};
use crate::dynamics::{ElasticDiscs, StageLosses};
use crate::exchange::fmu::PinLoadAt;
use crate::exchange::{JointBench, JointDrive, JointExport, JointInertia, JointState};
use crate::machine::StageFriction;
use crate::progress::Progress;
use crate::rig::{ErrorCurve, LOSS_SHARES, LOSS_SPEEDS, LoopFigures, LossLine, evaluate_loop};

/// Share of the rated torque that keeps the flanks in contact in the test without load, as on the bench of RV
/// reducers.
const HELD: f64 = 0.01;
/// Share of the rated torque that counts as no load: only preloaded contacts are loaded.
const NO_LOAD: f64 = 1e-4;

/// Runs the bench at each age, the youngest first.
///
/// # Errors
/// [`AnalysisError`]: ages or errors that the family does not have, static equilibria that are not found, loops that cannot be
/// fitted.
pub fn joint<D: EccentricDrive>(
    design: &D,
    options: &JointOptions,
    (host, progress): (&dyn Host, &dyn Progress),
) -> Result<JointExport, AnalysisError> {
    let errors = MadeOptions::of_fidelity(&options.fidelity)?;
    let (rated, assumed) = (design.rated(), design.inertia());
    let GivenMasses { input_inertia, output_inertia, output_mass } = options.masses;
    let mut drive = JointDrive {
        stamp: design.stamp(),
        model: String::new(),
        ratio: design.ratio(),
        rated_torque: rated.torque.abs(),
        rated_input_speed: rated.input_speed.abs(),
        inertia: JointInertia {
            sun_kg_m2: input_inertia.unwrap_or(assumed.sun_kg_m2),
            output_kg_m2: output_inertia.unwrap_or(assumed.output_kg_m2),
            output_kg: output_mass.unwrap_or(assumed.output_kg),
            ..assumed
        },
        friction_assumed: design.friction().1,
        inertia_assumed: output_inertia.is_none() || output_mass.is_none(),
    };
    let mut states = Vec::new();
    for hours in options.ages() {
        let Made { design, discs, fidelity } = design.as_made(&errors, host)?;
        let bodies = if discs.is_empty() { "rigid bodies" } else { "elastic discs" };
        let words = fidelity.words().unwrap_or_else(|| "nominal drive".to_owned());
        drive.model = format!("every body in its bearings, {bodies}, {words}");
        let found = bench((&design, &discs), hours, options, progress)?;
        let state = JointState::of(&found, (drive.ratio, drive.rated_torque));
        states.push(state.map_err(AnalysisError::compute("describe the joint"))?);
    }
    Ok(JointExport::new(&drive, (options.timestep, options.load_inertia), states))
}

/// Names of the eccentric bearings and their lives in hours of the duty, of the new drive with its errors.
///
/// # Errors
/// As [`joint`].
pub fn bearings<D: EccentricDrive>(
    design: &D,
    options: &JointOptions,
    host: &dyn Host,
) -> Result<Vec<(String, f64)>, AnalysisError> {
    let Made { design, discs, .. } = design.as_made(&MadeOptions::of_fidelity(&options.fidelity)?, host)?;
    let lives = super::bearings::bearing_lives(&design, &discs)?.bearings.into_iter();
    Ok(lives.map(|bearing| (bearing.name, bearing.life_h)).collect())
}

/// Results of the bench for the drive after some hours.
fn bench<D: EccentricDrive>(
    (design, discs): (&D, &[ElasticDiscs]),
    hours: f64,
    options: &JointOptions,
    progress: &dyn Progress,
) -> Result<JointBench, AnalysisError> {
    let (rated, ratio) = (design.rated().torque.abs(), design.ratio().abs());
    let mut rests = Rests::new(design, discs, hours, progress)?;
    let friction = design.friction().0;
    let (mut loops, mut figures) = (Vec::new(), Vec::new());
    for (position, angle) in rig::cycle_angles(design, options.positions).into_iter().enumerate() {
        progress.report("torque cycle", position as f64 / options.positions as f64);
        let cycle = rests.cycle(angle, &friction)?;
        figures.push(evaluate_loop(&cycle, rated).map_err(AnalysisError::compute("read the torque cycle"))?);
        loops.push(cycle);
    }
    // One full period under a torque in both directions: error and friction losses.
    let shares: Vec<f64> = [NO_LOAD, HELD].into_iter().chain(LOSS_SHARES).collect();
    let mut turned = |direction: f64| -> Result<Vec<(ErrorCurve, Efficiency)>, AnalysisError> {
        let one = |share: &f64| {
            progress.report("transmission error", *share);
            turn(design, &mut rests, (direction, share * rated), options.error_positions, &friction)
        };
        shares.iter().map(one).collect()
    };
    let (forward, backward) = (turned(1.0)?, turned(-1.0)?);
    // Torque at the input with the motor driving, and with the load driving the other flanks.
    let driving =
        |(curve, found): &(ErrorCurve, Efficiency)| (curve.torque, curve.torque / (ratio * found.forward));
    let driven =
        |(curve, found): &(ErrorCurve, Efficiency)| (curve.torque, -curve.torque * found.backward / ratio);
    let of_lines = shares.len() - LOSS_SHARES.len();
    let lines: [Vec<(f64, f64)>; 2] = [
        forward[of_lines..].iter().map(driving).collect(),
        backward[of_lines..].iter().map(driven).collect(),
    ];
    let speed = design.rated().input_speed.abs();
    // Coulomb friction does not depend on speed.
    let losses: Vec<LossLine> = LOSS_SPEEDS
        .map(|share| LossLine::through(share * speed, ratio, lines.each_ref().map(Vec::as_slice)))
        .into();
    let (light, input) = driving(&forward[0]);
    let no_load = input - light / ratio;
    let efficiency = forward[forward.len() - 1].1.forward;
    let backwards = losses[0].efficiency[1];
    let curves = forward.into_iter().chain(backward).map(|(curve, _)| curve);
    let curves =
        curves.filter(|curve| [HELD, BETWEEN, 1.0].iter().any(|share| share * rated == curve.torque));
    Ok(JointBench {
        hours,
        loops,
        figures: LoopFigures::mean(&figures),
        curves: curves.collect(),
        efficiency,
        no_load,
        starting: no_load,
        back_driving: if backwards > 0.0 { no_load * ratio / backwards } else { f64::INFINITY },
        losses,
    })
}

/// Error over one full period in a direction, with a torque (N·m) against the motion, and the efficiency.
fn turn<D: EccentricDrive>(
    design: &D,
    rests: &mut Rests<'_>,
    (direction, torque): (f64, f64),
    positions: usize,
    friction: &[StageFriction],
) -> Result<(ErrorCurve, Efficiency), AnalysisError> {
    let against_ring = design.turns_against_ring();
    let span = direction * TAU / design.order();
    let part = 1.0 / positions as f64;
    let mut losses = vec![StageLosses::default(); friction.len()];
    let mut points = Vec::with_capacity(positions + 1);
    for step in 0..positions {
        let output = span * step as f64 * part;
        let place = rests.at(output * against_ring, direction * torque)?;
        points.push((output, rests.output_error(&place)));
        for (mean, here) in losses.iter_mut().zip(rests.joints().losses(&place, friction)) {
            mean.add(part, &here);
        }
    }
    // The last point closes the turn.
    points.push((span, points[0].1));
    let curve = ErrorCurve { direction, torque, points, pins: None };
    Ok((curve, design.efficiency(torque, &losses)))
}

/// Largest force and pressure of a ring pin over torque at each age.
///
/// # Errors
/// As [`joint`].
pub fn pin_loads<D: EccentricDrive>(
    design: &D,
    options: &JointOptions,
    hours: &[f64],
    host: &dyn Host,
) -> Result<Vec<Vec<PinLoadAt>>, AnalysisError> {
    let errors = MadeOptions::of_fidelity(&options.fidelity)?;
    let mut all = Vec::with_capacity(hours.len());
    for hours in hours {
        let Made { design, discs, .. } = design.as_made(&errors, host)?;
        let meshes = design.meshes();
        let mut rests = Rests::new(&design, &discs, *hours, host)?;
        let stages = rests.joints().stages().to_vec();
        let mut loads = Vec::with_capacity(PIN_SHARES.len());
        for share in PIN_SHARES {
            let torque = share * design.rated().torque.abs();
            let mut load = PinLoadAt { torque_n_m: torque, force_n: 0.0, pressure_pa: 0.0 };
            for angle in design.angles(PIN_POSITIONS) {
                let place = rests.at(angle, torque.copysign(design.rated().torque))?;
                for (stage, mesh) in stages.iter().zip(&meshes) {
                    for ring in stage.rings.clone() {
                        let contacts = rests.joints().pin_contacts(ring, &place).into_iter();
                        for c in contacts.filter(|c| c.force > 0.0) {
                            let pressure = mesh.contact.pressure(c.force, 1.0 / c.relative_curvature);
                            load.force_n = load.force_n.max(c.force);
                            load.pressure_pa = load.pressure_pa.max(pressure);
                        }
                    }
                }
            }
            loads.push(load);
        }
        all.push(loads);
    }
    Ok(all)
}
