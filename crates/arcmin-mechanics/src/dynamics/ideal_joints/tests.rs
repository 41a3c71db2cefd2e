use super::*;
use crate::contact::ContactLaw;
use crate::dynamics::{EquilibriumControl, solve_equilibrium};
use crate::progress::Silent;
use crate::units::{RPM, UM};

fn drive() -> Drive {
    Drive::SpeedLaw { speed: 1500.0 * RPM, rise_time: 0.1 }
}

fn variants() -> Vec<IdealJoints> {
    let mut machine = crate::templates::tao2024();
    machine.contact_law = ContactLaw::Linear { stiffness: 2.85e8 };
    machine.gear_stage.mesh_stiffness_variation = 0.1;
    let load = OutputLoad::Constant { torque: 412.0 };
    let governed = Drive::Governed { speed: 1500.0 * RPM, rise_time: 0.1, gain: 0.5 };
    let mut models = Vec::new();
    for fixed_member in [FixedMember::Housing, FixedMember::Carrier] {
        machine.fixed_member = fixed_member;
        for drive in [drive(), governed.clone()] {
            models.push(
                IdealJoints::new(&machine, &Relief::uniform(2.0 * UM), drive, load.clone(), 5.0).unwrap(),
            );
        }
    }
    models
}

fn loaded_state(model: &IdealJoints, time: f64) -> (Vec<f64>, Vec<f64>) {
    // Angles relative to nominal rolling, with the output lagging by 0.3'.
    let sun = 0.7;
    let output = sun / model.ratio;
    let crank = match model.members[1] {
        CARRIER => -model.kinematics.lobe_count * output,
        _ => (1.0 + model.kinematics.lobe_count) * output,
    };
    let mut position = vec![crank + 2e-4, output - 0.3 * ARCMIN];
    let mut velocity = vec![-30.0, 0.8];
    if model.members.len() == 3 {
        position.push(sun);
        velocity.push(60.0);
    } else {
        let shift = model.drive.motion(time).angle - sun;
        position[0] += match model.members[1] {
            CARRIER => -model.kinematics.lobe_count * shift / model.ratio,
            _ => (1.0 + model.kinematics.lobe_count) * shift / model.ratio,
        };
        position[1] += shift / model.ratio;
    }
    (position, velocity)
}

#[test]
fn tangents_are_the_derivatives_of_the_forces() {
    for model in variants() {
        let n = model.size();
        let time = 0.06;
        let (q, v) = loaded_state(&model, time);
        let mut lin = model.linearisation();
        let mut force = vec![0.0; n];
        let balance = model.evaluate(time, &q, &v, &mut force, &mut lin);
        assert!(balance.stored > 1e-4, "the state is meant to be loaded: {balance:?}");
        let mut scratch = model.linearisation();
        let mut difference = |column: usize, on_velocity: bool, h: f64| {
            let mut forces = [vec![0.0; n], vec![0.0; n]];
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let (mut q, mut v) = (q.clone(), v.clone());
                if on_velocity {
                    v[column] += sign * h
                } else {
                    q[column] += sign * h
                }
                model.evaluate(time, &q, &v, &mut forces[side], &mut scratch);
            }
            forces[0].iter().zip(&forces[1]).map(|(a, b)| (a - b) / (2.0 * h)).collect::<Vec<_>>()
        };
        let largest = |f: &dyn Fn(usize, usize) -> f64, row: usize| {
            (0..n).map(|c| (f(row, c) * model.scale[c]).abs()).fold(0.0, f64::max)
        };
        for column in 0..n {
            let k = difference(column, false, 1e-5 * model.scale[column]);
            let c = difference(column, true, 1e-4 * model.scale[column]);
            for row in 0..n {
                let scale = model.scale[column];
                let size = largest(&|r, c| lin.stiffness(r, c), row);
                assert!(
                    ((k[row] - lin.stiffness(row, column)) * scale).abs() < 1e-5 * size,
                    "K {row} {column}: {} {}",
                    k[row],
                    lin.stiffness(row, column)
                );
                let size = largest(&|r, c| lin.damping(r, c), row);
                assert!(
                    ((c[row] - lin.damping(row, column)) * scale).abs() < 1e-5 * size,
                    "C {row} {column}: {} {}",
                    c[row],
                    lin.damping(row, column)
                );
            }
        }
    }
}

/// Without damping and load the work of the forces equals the decrease of the stored energy, in any direction.
#[test]
fn elastic_forces_derive_from_the_stored_energy() {
    let mut machine = crate::templates::tao2024();
    machine.contact_law = ContactLaw::Linear { stiffness: 2.85e8 };
    machine.gear_stage.mesh_stiffness_variation = 0.1;
    let governed = Drive::Governed { speed: 0.0, rise_time: 0.1, gain: 1e-30 };
    let model =
        IdealJoints::new(&machine, &Relief::uniform(1.0 * UM), governed, OutputLoad::None, 0.0).unwrap();
    let (q, v) = (loaded_state(&model, 0.0).0, vec![0.0; 3]);
    let mut lin = model.linearisation();
    let mut force = vec![0.0; 3];
    model.evaluate(0.0, &q, &v, &mut force, &mut lin);
    for i in 0..3 {
        let h = 1e-4 * model.scale[i];
        let mut energy = [0.0; 2];
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            let mut q = q.clone();
            q[i] += sign * h;
            energy[side] = model.evaluate(0.0, &q, &v, &mut [0.0; 3], &mut lin).stored;
        }
        let slope = (energy[0] - energy[1]) / (2.0 * h);
        assert!((slope / force[i] - 1.0).abs() < 1e-5, "{i}: {slope} {}", force[i]);
    }
}

/// Two equal discs transmit 0.4815 T each, the gear stage the rest.
#[test]
fn equilibrium_splits_the_torque_between_discs_and_gear_stage() {
    let machine = crate::templates::tao2024();
    let load = OutputLoad::Constant { torque: 412.0 };
    let model = IdealJoints::new(&machine, &Relief::uniform(0.0), drive(), load, 0.0).unwrap();
    let rest =
        solve_equilibrium(&model, 0.0, &model.nominal_position(), EquilibriumControl::default()).unwrap();
    let moment = |disc: usize| {
        let moments = model.pin_contacts(disc, 0.0, &rest.position, &[0.0; 2]);
        moments.iter().map(|c| c.force * c.gradient[2]).sum::<f64>()
    };
    // Exact for nominal rolling and normal forces only; the rolling forces of the conservative line contact
    // contribute 2.5e-4 of the torque.
    let share = (moment(0) + moment(1)) / 412.0;
    assert!((share - model.kinematics.locked_play_factor()).abs() < 5e-4, "{share}");
    assert!(rest.residual < 1e-6);
    // About 0.1' of elastic twist by Hertzian contact, lagging.
    let te = model.transmission_error(0.0, &rest.position, &[0.0; 2]) / ARCMIN;
    assert!((-0.13..-0.07).contains(&te), "{te}");
}

#[test]
fn input_without_meaning_is_refused() {
    let machine = crate::templates::tao2024();
    let build = |load: OutputLoad, drag: f64| {
        IdealJoints::new(&machine, &Relief::uniform(0.0), drive(), load, drag).map(|_| ())
    };
    assert!(build(OutputLoad::None, 0.0).is_ok());
    let error = build(OutputLoad::None, -5.0).unwrap_err();
    assert_eq!(error.to_string(), "drag torque = -5 N·m: must not be negative");
    assert!(build(OutputLoad::Constant { torque: f64::NAN }, 0.0).is_err());
}

#[test]
fn friction_dissipates_and_spinning_pins_take_the_smaller_coefficient() {
    let mut machine = crate::templates::tao2024();
    machine.friction.flank = 0.08;
    machine.friction.pin_seat = 0.02;
    let dissipation = |machine: &Machine| {
        let load = OutputLoad::Constant { torque: 412.0 };
        let model = IdealJoints::new(machine, &Relief::uniform(0.0), drive(), load, 0.0).unwrap();
        let motion = model.drive.motion(0.2);
        let output = motion.angle / model.ratio;
        let q = [-39.0 * output, output - 0.1 * ARCMIN];
        let v = [-39.0 * motion.speed / model.ratio, motion.speed / model.ratio];
        model.evaluate(0.2, &q, &v, &mut [0.0; 2], &mut model.linearisation()).dissipation
    };
    let fixed = dissipation(&machine);
    machine.ring.mounting = crate::machine::PinMounting::Spinning;
    let spinning = dissipation(&machine);
    machine.friction.flank = 0.0;
    let smooth = dissipation(&machine);
    assert!(fixed > 10.0, "{fixed}");
    assert!(((spinning - smooth) / (fixed - smooth) - 0.25).abs() < 1e-9);
}

/// The transmission error under drag on a meshed flank converges to that of the smooth one; edges of 0.4 mm
/// halve the backlash of 10 µm of wear.
#[test]
fn meshed_flanks_give_the_smooth_transmission_error_in_the_limit() {
    let machine = crate::templates::tao2024();
    let arc = crate::fem::boundary::FlankArc::new(&machine.profile());
    let mean = |mesh: Option<(MeshContact, f64)>| {
        let drive = Drive::SpeedLaw { speed: 1500.0 * RPM, rise_time: 0.01 };
        let mut model =
            IdealJoints::new(&machine, &Relief::uniform(10.0 * UM), drive, OutputLoad::None, 5.0).unwrap();
        if let Some((contact, size)) = mesh {
            model.set_facets(contact, &arc.nodes((arc.lobe_length() / size).round() as usize));
        }
        let plan = crate::dynamics::RunPlan { end: 0.06, window_start: 0.02, ..Default::default() };
        let mut run = crate::dynamics::Run::new(model, plan, &Silent).unwrap();
        run.finish(&Silent).unwrap();
        run.result().statistics.unwrap().mean / ARCMIN
    };
    let smooth = mean(None);
    let off = |contact: MeshContact, size: f64| (mean(Some((contact, size))) - smooth).abs();
    let edges = [0.4e-3, 0.2e-3, 0.1e-3].map(|size| off(MeshContact::Edges, size));
    assert!(edges[0] > 0.2 && edges[1] < 0.35 * edges[0] && edges[2] < 0.35 * edges[1], "{edges:?}");
    let nodes = off(MeshContact::Nodes, 0.1e-3);
    assert!(nodes < 0.02, "{nodes}");
}
