use super::*;
use crate::dynamics::JointSettings;
use crate::machine::Machine;
use crate::rig::{assumed_friction, hysteresis_loop};
use crate::units::ARCMIN;

fn machine() -> Machine {
    let mut machine = crate::templates::tao2024();
    machine.friction = assumed_friction(&machine);
    machine
}

/// A loop computed from a known model is recovered: the torsion curve, and torques within the residual.
#[test]
fn a_known_model_is_recovered() {
    let rated = 400.0;
    let curve = TorsionCurve {
        half_gap_rad: 0.3 * ARCMIN,
        torques_n_m: [100.0, 200.0],
        stiffness_n_m_per_rad: [180.0 / ARCMIN, 220.0 / ARCMIN, 260.0 / ARCMIN],
        residual_rad: 0.0,
    };
    let elements = vec![
        SlipElement { slip_rad: 0.02 * ARCMIN, torque_n_m: 3.0, torque_per_load: 0.01 },
        SlipElement { slip_rad: 0.1 * ARCMIN, torque_n_m: 2.0, torque_per_load: 0.0 },
    ];
    // The flank of negative torque is worn: it is softer, and the middle is displaced.
    let worn =
        TorsionCurve { stiffness_n_m_per_rad: [140.0 / ARCMIN, 200.0 / ARCMIN, 250.0 / ARCMIN], ..curve };
    let truth = Hysteresis {
        curve,
        zero_rad: -0.1 * ARCMIN,
        sides: [curve, worn],
        elements,
        residual_rms_n_m: 0.0,
        residual_max_n_m: 0.0,
        residual_rms_rad: 0.0,
    };
    let shares: Vec<f64> = (-40..=40).rev().map(|i| f64::from(i) / 40.0).collect();
    let branch = |branch, shares: Vec<f64>| {
        shares.into_iter().map(move |s| LoopPoint { torque: s * rated, angle: 0.0, branch })
    };
    let back: Vec<f64> = shares.iter().rev().copied().collect();
    let torques: Vec<LoopPoint> =
        branch(Branch::Falling, shares).chain(branch(Branch::Rising, back)).collect();
    let points = truth.loop_at(&torques);
    let found = Hysteresis::fit(&points, rated, 0.03).unwrap();
    assert!((found.curve.half_gap_rad / curve.half_gap_rad - 1.0).abs() < 0.05, "{:?}", found.curve);
    for (found, truth) in found.sides.iter().zip([curve, worn]) {
        for (k, truth) in found.stiffness_n_m_per_rad.iter().zip(truth.stiffness_n_m_per_rad) {
            assert!((k / truth - 1.0).abs() < 0.05, "{found:?}");
        }
    }
    assert!((found.zero_rad / ARCMIN + 0.1).abs() < 0.01, "{}", found.zero_rad / ARCMIN);
    // Compliances of the mean are the means of the compliances.
    for (index, k) in found.curve.stiffness_n_m_per_rad.iter().enumerate() {
        let mean = 0.5 * found.sides.iter().map(|side| 1.0 / side.stiffness_n_m_per_rad[index]).sum::<f64>();
        assert!((k * mean - 1.0).abs() < 0.02, "{found:?}");
    }
    assert!(found.residual_rms_n_m < 0.01 * rated, "{}", found.residual_rms_n_m);
    // Independent check: lost motion and stiffness of the loops, evaluated as on the test bench.
    let (a, b) =
        (evaluate_loop(&points, rated).unwrap(), evaluate_loop(&found.loop_at(&torques), rated).unwrap());
    // Six elements approximate any slip; a loop of two elements is reproduced within the 3 % required for the
    // machine's.
    assert!((a.lost_motion / b.lost_motion - 1.0).abs() < 0.03, "{a:?} {b:?}");
    assert!((a.stiffness / b.stiffness - 1.0).abs() < 0.03, "{a:?} {b:?}");
    assert!((a.work / b.work - 1.0).abs() < 0.2, "{a:?} {b:?}");
}

/// The fitted model of the reference machine has its lost motion and stiffness within 3 %.
#[test]
fn the_fitted_joint_measures_like_the_machine() {
    let machine = machine();
    let rated = machine.rated.torque;
    let points = hysteresis_loop(&machine, &JointSettings::default(), 0.0).unwrap();
    let model = Hysteresis::fit(&points, rated, ACROSS).unwrap();
    let (ours, theirs) =
        (evaluate_loop(&points, rated).unwrap(), evaluate_loop(&model.loop_at(&points), rated).unwrap());
    assert!((ours.lost_motion / theirs.lost_motion - 1.0).abs() < 0.03, "{ours:?} {theirs:?}");
    assert!((ours.stiffness / theirs.stiffness - 1.0).abs() < 0.03, "{ours:?} {theirs:?}");
    assert!(model.residual_rms_n_m < 0.01 * rated, "{}", model.residual_rms_n_m);
}

/// A preloaded machine has no dead band.
#[test]
fn a_preloaded_loop_has_no_dead_band() {
    let mut points = Vec::new();
    for branch in [Branch::Falling, Branch::Rising] {
        for i in -20..=20 {
            let torque = 20.0 * f64::from(i);
            // Stiffer near zero than further out, unlike a line contact under preload: a straight line.
            points.push(LoopPoint { torque, angle: torque / 1e6, branch });
        }
    }
    let curve = TorsionCurve::fit(&points, 400.0, 0.03).unwrap();
    assert!(curve.half_gap_rad.abs() < 1e-12);
    assert!((curve.torque(3e-4) / 300.0 - 1.0).abs() < 1e-9);
}

/// Amplitude and phase of waves are recovered for either direction.
#[test]
fn waves_have_their_phase() {
    for direction in [1.0, -1.0] {
        let truth = |angle: f64| 1e-3 + 2e-5 * (39.0 * angle + 0.7).cos() + 1e-5 * (80.0 * angle - 2.0).cos();
        let points = (0..=512)
            .map(|i| direction * TAU * f64::from(i) / 512.0)
            .map(|angle| (angle, truth(angle)))
            .collect();
        let found = TransmissionWaves::of(&ErrorCurve { direction, torque: 1.0, points, pins: None });
        assert_eq!(found.waves.len(), 2);
        let [first, second] = [found.waves[0], found.waves[1]];
        assert!((first.order, second.order) == (39.0, 80.0));
        assert!((first.amplitude_rad - 2e-5).abs() < 1e-12 && (first.phase_rad - 0.7).abs() < 1e-9);
        assert!((second.phase_rad + 2.0).abs() < 1e-9, "{}", second.phase_rad);
        assert!(found.left_rad < 1e-12);
    }
}

/// The gear's inertia at the input compared with its closed form: without the sun, crankshafts and discs by
/// their speeds.
#[test]
fn inertia_is_that_of_the_kinetic_energy() {
    let machine = machine();
    let found = JointInertia::of(&machine).unwrap();
    let (output, crank, _) = machine.kinematics().speeds(1.0);
    let shafts = machine.crankshafts.count as f64
        * (machine.crankshafts.inertia * crank * crank
            + machine.crankshafts.mass * (machine.gear_stage.centre_distance() * output).powi(2));
    let discs = machine.disc_count as f64
        * (machine.disc.inertia * output * output
            + machine.disc.mass * (machine.crankshafts.eccentricity * crank).powi(2));
    assert!((found.gear_kg_m2 / (shafts + discs) - 1.0).abs() < 1e-6, "{found:?} {}", shafts + discs);
    assert!(found.output_kg_m2 >= machine.carrier.inertia);
}

#[test]
fn numbers_are_short_and_exact_to_nine_digits() {
    let all = [0.0, 1.0, 0.25, 827_000.123_456_7, 1.0e-7, 1.234_567_894e-5, -3.0e12].map(number);
    assert_eq!(all, ["0", "1", "0.25", "827000.123", "1e-7", "1.23456789e-5", "-3e12"]);
    for text in ["a--b", "<&\">"] {
        assert!(!escaped(text).contains("--") && !escaped(text).contains('<'));
    }
}

/// A joint of two ages with a known model.
pub(in crate::exchange) fn sample() -> JointExport {
    let state = |hours: f64, gap: f64| {
        let curve = TorsionCurve {
            half_gap_rad: gap * ARCMIN,
            torques_n_m: [100.0, 200.0],
            stiffness_n_m_per_rad: [180.0 / ARCMIN, 220.0 / ARCMIN, 260.0 / ARCMIN],
            residual_rad: 0.0,
        };
        let elements = vec![SlipElement { slip_rad: 0.03 * ARCMIN, torque_n_m: 4.0, torque_per_load: 0.005 }];
        let hysteresis = Hysteresis {
            curve,
            zero_rad: 0.0,
            sides: [curve, curve],
            elements,
            residual_rms_n_m: 0.0,
            residual_max_n_m: 0.0,
            residual_rms_rad: 0.0,
        };
        let line = |speed: f64| LossLine {
            input_speed_rad_per_s: speed,
            efficiency: [0.88, 0.86],
            friction_n_m: [0.07 + 1e-4 * speed, 0.06],
            left_n_m: 0.0,
        };
        let waves = |direction: f64, torque: f64| TransmissionWaves {
            direction,
            torque_n_m: torque,
            mean_rad: 0.0,
            waves: vec![Wave { order: 80.0, amplitude_rad: 1e-5, phase_rad: 0.3 }],
            peak_to_peak_rad: 2e-5,
            left_rad: 0.0,
        };
        let friction = RunningFriction {
            coulomb_n_m: 4.9,
            viscous_n_m_s_per_rad: 0.6,
            load_mean: 0.13,
            load_difference: -0.01,
            relaxation_rad: 1e-5,
            residual_rms_n_m: 0.2,
            residual_max_n_m: 0.5,
            relaxation_residual_rms_n_m: 1.0,
        };
        JointState {
            hours,
            damping_ratio: 0.05,
            friction,
            friction_without_constant: friction,
            lost_motion_rad: 2.0 * gap * ARCMIN,
            backlash_rad: 2.0 * gap * ARCMIN,
            stiffness_n_m_per_rad: 250.0 / ARCMIN,
            soft_stiffness_n_m_per_rad: 180.0 / ARCMIN,
            hysteresis_loss_j: 0.01,
            hysteresis_width_rad: 1e-5,
            hysteresis,
            torsion_loop: vec![(400.0, 5e-4), (-400.0, -5e-4), (-400.0, -5e-4), (400.0, 5e-4)],
            transmission_error: vec![
                waves(1.0, 4.0),
                waves(1.0, 400.0),
                waves(-1.0, 4.0),
                waves(-1.0, 400.0),
            ],
            losses: vec![line(15.0), line(157.0)],
            efficiency: 0.87,
            no_load_torque_n_m: 0.07,
            starting_torque_n_m: 0.06,
            back_driving_torque_n_m: Some(4.0),
        }
    };
    JointExport {
        arcmin_version: "0".into(),
        design_name: "sample".into(),
        design_hash: "0".into(),
        model: "known".into(),
        friction_assumed: false,
        inertia_assumed: false,
        ratio: 81.0,
        rated_torque_n_m: 400.0,
        rated_input_speed_rad_per_s: 157.0,
        inertia: JointInertia {
            motor_kg_m2: 2e-4,
            sun_kg_m2: 1e-5,
            gear_kg_m2: 4e-5,
            output_kg_m2: 6e-3,
            output_kg: 2.5,
            gear_kg: 1.8,
        },
        timestep_s: 1e-3,
        load_inertia_kg_m2: 12.0,
        states: vec![state(0.0, 0.3), state(2000.0, 0.5)],
    }
}

#[test]
fn json_is_read_back_unchanged() {
    let joint = sample();
    assert_eq!(JointExport::from_json(&joint.json().unwrap()).unwrap(), joint);
}

/// No name is a reserved word of the target languages, and distinct names remain distinct.
#[test]
fn names_are_not_reserved_words() {
    let identifier = names::identifier;
    for word in [
        "end",
        "End",
        "model",
        "package",
        "when",
        "initial",
        "annotation",
        "der",
        "Modelica",
        "function",
        "world",
    ] {
        assert_eq!(identifier(word), format!("joint_{}", word.to_lowercase()));
    }
    for name in ["", "_", "__model__", "40E", "減速機", "a--b", "x\ny", "<&\">", "RV 40E-81"] {
        let own = identifier(name);
        assert!(own.starts_with(|c: char| c.is_ascii_lowercase()), "{own}");
        assert!(own.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'), "{own}");
    }
    assert_eq!(identifier("RV 40E-81"), "rv_40e_81");
    let ages = [0.0, 1e-4, 0.5, 2000.0, 2000.25, 1e7];
    let labels: std::collections::HashSet<String> = ages.map(names::label).into();
    assert_eq!(labels.len(), ages.len());
    assert!(labels.iter().all(|label| label.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')));
    let joint = JointExport { design_name: "end".into(), ..sample() };
    assert!(
        joint.modelica().contains("package joint_end ") && joint.modelica().ends_with("end joint_end;\n")
    );
}

/// Losses computed from a known friction recover its parameters, with and without a constant.
#[test]
fn a_known_friction_is_recovered() {
    let (ratio, rated) = (81.0, 400.0);
    let state = &sample().states[0];
    for (constant, viscous, driving, driven) in
        [(5.0, 0.7, 0.12, 0.13), (0.0, 0.5, 0.2, 0.1), (3.0, 0.0, 0.05, 0.0), (0.0, 0.0, 0.0, 0.0)]
    {
        // tau = c + v w + mu_1 tau + T if the motor drives; tau = c + v w - mu_2 tau - T if the load drives, as
        // long as the motor then brakes.
        let losses: Vec<LossLine> = [15.0, 80.0, 160.0]
            .map(|speed: f64| {
                let free = constant + viscous * speed / ratio;
                LossLine {
                    input_speed_rad_per_s: speed,
                    efficiency: [1.0 - driving, 1.0 / (1.0 + driven)],
                    friction_n_m: [free / (1.0 - driving) / ratio, free / (1.0 + driven) / ratio],
                    left_n_m: 0.0,
                }
            })
            .into();
        let points = state.loop_points();
        let found = RunningFriction::fit(&losses, (&state.hysteresis, &points), ratio, rated, constant > 0.0);
        let near = |found: f64, truth: f64, size: f64| (found - truth).abs() < 0.03 * size;
        assert!(near(found.coulomb_n_m, constant, 6.0), "{found:?}");
        assert!(near(found.viscous_n_m_s_per_rad, viscous, 1.0), "{found:?}");
        assert!(near(found.load_mean + found.load_difference, driving, 0.1), "{found:?}");
        assert!(near(found.load_mean - found.load_difference, driven, 0.1), "{found:?}");
        assert!(found.residual_max_n_m < 0.05, "{found:?}");
        let [c, v] = found.without_load();
        let turned = c + v * 1.5;
        assert!((turned - found.torque(1.5, turned)).abs() < 1e-9 * (1.0 + turned));
    }
}

/// The energy loss per period of an arm released on the hysteresis, integrated in time, agrees with the damping
/// ratio for any inertia.
#[test]
fn damping_ratio_is_that_of_a_swing_in_time() {
    let state = &sample().states[0];
    let (rated, model) = (400.0, &state.hysteresis);
    let expected = damping::damping_ratio(model, rated);
    for inertia in [2.0, 30.0] {
        let mut slips = vec![0.0; model.elements.len()];
        let (mut angle, mut speed) = (0.0, 0.0);
        while model.torque(angle, &slips) < 0.75 * rated {
            angle += 1e-9;
            model.follow(&mut slips, 1e-9);
        }
        let mut turns = vec![angle];
        let h = 0.002 * (inertia / model.stiffest()).sqrt();
        while turns.len() < 4 {
            let next = speed + h * (0.5 * rated - model.torque(angle, &slips)) / inertia;
            if next * speed < 0.0 {
                turns.push(angle);
            }
            speed = next;
            angle += h * speed;
            model.follow(&mut slips, h * speed);
        }
        let found = ((turns[0] - turns[1]) / (turns[2] - turns[3])).ln() / TAU;
        assert!((found - expected).abs() < 0.03 * expected, "{inertia}: {found} {expected}");
    }
    // The equivalent damper, at the load for which it is computed.
    let joint = sample();
    let stiffness = model.curve.stiffness_n_m_per_rad[2];
    let ratio = joint.damping(state) / (2.0 * (stiffness * joint.load_inertia_kg_m2).sqrt());
    assert!((ratio - state.damping_ratio).abs() < 1e-12);
}

/// The error of a time step is small compared with the hysteresis of an arm, and the integration is stable at
/// the stated step.
#[test]
fn a_time_step_does_not_damp_the_arm() {
    for timestep in [1e-5, 1e-4, 1e-3, 2e-3] {
        let joint = JointExport { timestep_s: timestep, ..sample() };
        for state in &joint.states {
            let needed = state.inertia_for(timestep).max(joint.inertia.output_kg_m2);
            let arm = 12.0;
            let stiffness = state.hysteresis.stiffest();
            let added = state.rest_damping(needed) / (2.0 * (stiffness * arm).sqrt());
            assert!(added <= 0.02 * (needed / arm).sqrt() * 1.001, "{timestep}: {added}");
            assert!(state.inertia_for(timestep) >= 0.5 * stiffness * timestep * timestep);
        }
        assert!(joint.mjcf().contains("implicitfast"), "{timestep}");
    }
    let coarse = JointExport { timestep_s: 0.02, ..sample() }.mjcf();
    assert!(coarse.contains("integrator=\"discrete\"") && coarse.contains("armature=\"0\""));
}

/// Each mass is included once; the moving part has its own.
#[test]
fn masses_are_those_of_the_parts() {
    let machine = machine();
    let found = JointInertia::of(&machine).unwrap();
    assert_eq!(found.output_kg, machine.carrier.mass);
    let turned = Machine { fixed_member: crate::machine::FixedMember::Carrier, ..machine.clone() };
    let other = JointInertia::of(&turned).unwrap();
    assert_eq!(other.output_kg, turned.housing.mass);
    assert!(other.output_kg != found.output_kg && other.gear_kg == found.gear_kg);
    let joint = sample();
    let count = |text: &str, mass: f64| text.matches(&format!("mass value=\"{}\"", number(mass))).count();
    assert_eq!(count(&joint.urdf(), joint.inertia.output_kg), joint.states.len());
    assert_eq!(count(&joint.urdf(), joint.inertia.gear_kg), joint.states.len());
    let sdf = joint.sdf();
    assert_eq!(sdf.matches("<mass>2.5</mass>").count(), 2);
    assert_eq!(sdf.matches("<mass>").count(), 4);
    assert_eq!(joint.mjcf().matches("mass=\"2.5\"").count(), 2);
}
