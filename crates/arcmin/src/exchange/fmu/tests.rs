use std::f64::consts::TAU;

use super::*;
use crate::exchange::joint::tests::sample;
use crate::units::ARCMIN;

fn model(load: LoadFlange, friction: bool) -> MapModel {
    MapModel::at(&sample(), &[], 1000.0, load, friction).unwrap()
}

fn run(model: &MapModel, communication: f64, end: f64) -> Vec<MapOutputs> {
    // The torque does not cross the dead band, within which the instants of contact depend on the interpolation
    // of the load.
    let torque = |t: f64| {
        let angle = TAU * 5.0 * t;
        [-250.0 - 100.0 * angle.sin(), -100.0 * TAU * 5.0 * angle.cos()]
    };
    let inputs =
        |t: f64| MapInputs { motor: [100.0 * t, 100.0, 0.0], load_torque: torque(t), ..Default::default() };
    let mut state = model.start(&inputs(0.0)).unwrap();
    let steps = (end / communication).round() as usize;
    let mut out = Vec::new();
    for step in 0..steps {
        let t = communication * step as f64;
        model.advance(&mut state, &inputs(t), communication * (step + 1) as f64).unwrap();
        out.push(model.outputs(&state));
    }
    out
}

/// Another communication step gives the same motion, and the energy balance is fulfilled.
#[test]
fn the_map_does_not_depend_on_the_communication_step() {
    let model = model(LoadFlange::Torque, true);
    let (coarse, fine) = (run(&model, 1e-3, 0.2), run(&model, 1e-4, 0.2));
    for (index, at) in coarse.iter().enumerate() {
        let other = fine[10 * (index + 1) - 1];
        assert!((at.transmission_error - other.transmission_error).abs() < 2e-3 * ARCMIN, "{index}");
    }
    let last = fine[fine.len() - 1];
    assert!(last.balance.abs() < 5e-3, "{last:?}");
    let turned = last.flange[0] * 81.0;
    assert!((turned / (100.0 * 0.2) - 1.0).abs() < 0.01, "{turned}");
}

/// Held input, torque varied slowly and periodically: the map has the dead band and stiffness of the joint.
#[test]
fn the_map_has_the_loop_of_the_joint() {
    let model = model(LoadFlange::Torque, true);
    let mut at = [[0.0; 2]; 2];
    for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
        for (place, share) in [0.5, 1.0].into_iter().enumerate() {
            let inputs = MapInputs { load_torque: [sign * share * 400.0, 0.0], ..Default::default() };
            let state = model.start(&inputs).unwrap();
            at[side][place] = model.outputs(&state).flange[0];
        }
    }
    let stiffness = 200.0 / (at[0][1] - at[0][0]);
    // K₃ of the sample is 260 N·m/arcmin at either age; slip elements that still stick add to it.
    assert!((stiffness * ARCMIN / 260.0 - 1.0).abs() < 0.1, "{}", stiffness * ARCMIN);
    // Value of the transmission error at this angle on either side.
    let wave = 1e-5 * 0.3_f64.cos();
    assert!((at[0][1] + at[1][1] - 2.0 * wave).abs() < 1e-12);
}

/// The same motion prescribed at the load flange gives the torque that caused it.
#[test]
fn both_forms_of_the_load_flange_agree() {
    let (torque, motion) = (model(LoadFlange::Torque, true), model(LoadFlange::Motion, true));
    let inputs = MapInputs { load_torque: [250.0, 0.0], ..Default::default() };
    let state = torque.start(&inputs).unwrap();
    let flange = torque.outputs(&state).flange;
    let held = MapInputs { load_motion: [flange[0], 0.0, 0.0], ..Default::default() };
    let other = motion.start(&held).unwrap();
    assert!((motion.outputs(&other).load_torque / 250.0 - 1.0).abs() < 1e-6);
}

#[test]
fn an_age_outside_of_the_maps_is_refused() {
    assert!(MapModel::at(&sample(), &[], 2001.0, LoadFlange::Torque, true).is_err());
    assert!(MapModel::at(&sample(), &[], -1.0, LoadFlange::Torque, true).is_err());
    assert!(MapModel::at(&sample(), &[], 2000.0, LoadFlange::Torque, true).is_ok());
    let model = model(LoadFlange::Torque, false);
    let wrong = MapInputs { motor: [f64::NAN, 0.0, 0.0], ..Default::default() };
    assert!(model.start(&wrong).is_err());
}

/// Names and references are unique, and every unit is defined.
#[test]
fn variables_are_consistent() {
    for depth in [Depth::Map, Depth::Multibody] {
        for load in [LoadFlange::Torque, LoadFlange::Motion] {
            let all = variables(depth, load);
            for (index, one) in all.iter().enumerate() {
                assert!(all[index + 1..].iter().all(|o| o.name != one.name && o.reference != one.reference));
            }
            let description = ModelDescription {
                model_name: "a \"b\" & c".into(),
                model_identifier: "arcmin_fmu",
                description: String::new(),
                version: "0".into(),
                token: instantiation_token(&[b"x"]),
                depth,
                load,
                start_hours: 0.0,
                hours: [0.0, 1.0],
                start_seed: 0,
                step_size: 1e-3,
            };
            for text in [description.fmi2(), description.fmi3()] {
                for one in &all {
                    assert!(text.contains(&format!("name=\"{}\"", one.name)));
                    assert!(one.unit.is_empty() || text.contains(&format!("Unit name=\"{}\"", one.unit)));
                }
            }
        }
    }
    assert_eq!(instantiation_token(&[b"a"]), instantiation_token(&[b"a"]));
    assert_ne!(instantiation_token(&[b"ab", b""]), instantiation_token(&[b"a", b"b"]));
}
