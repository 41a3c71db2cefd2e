//! Joints of drives of eccentrics against the bench and the mechanism.

use super::*;
use crate::analyses::NoHost;
use crate::analyses::joint::{GivenMasses, JointOptions, joint, pin_loads};
use crate::design::Value;
use crate::dynamics::System;
use crate::exchange::fmu::{LoadFlange, MapInputs, MapModel};
use crate::exchange::{Hysteresis, JointExport, JointState};
use crate::fidelity::FidelityOptions;
use crate::rig::{Branch, LoopPoint, evaluate_loop, shares};
use crate::templates::{DRIVES, NEMA17_19, PRINTED_15, TWO_RING_225, TWO_STAGE_500};
use crate::units::ARCMIN;

fn any(text: &str) -> AnyDesign {
    AnyDesign::parse(text, "test.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn options(fidelity: &str, hours: &[f64]) -> JointOptions {
    JointOptions {
        fidelity: FidelityOptions::parse(&format!("joints = \"bearings\"\n{fidelity}"), "test").unwrap(),
        hours: hours.to_vec(),
        positions: 3,
        error_positions: 96,
        timestep: 1e-3,
        load_inertia: None,
        masses: GivenMasses::default(),
    }
}

fn export(design: &AnyDesign, options: &JointOptions) -> JointExport {
    joint(design, options, &NoHost).unwrap_or_else(|error| panic!("{error:?}\n{}", design.text()))
}

fn bench(design: &AnyDesign, places: usize, more: &str) -> rig::Rig {
    let options = format!("discs = \"rigid\"\npositions = 3\nte_positions = {places}\n{more}");
    let found = design.run(crate::analyses::by_name("rig").unwrap(), &options, "test", &NoHost);
    found.unwrap_or_else(|error| panic!("{error:?}")).as_any().downcast_ref::<rig::Rig>().unwrap().clone()
}

/// Figures of the joint are those of the bench, the model has the loop of the bench, and the waves reproduce its transmission error.
///
/// Its elastic part is that of the bench without friction, `still`, which is not part of the fit.
fn measures_as_the_bench(state: &JointState, rig: &rig::Rig, still: &rig::Rig, against_ring: f64) {
    let near = |a: f64, b: f64, within: f64| assert!((a / b - 1.0).abs() < within, "{a} {b}");
    near(state.lost_motion_rad, rig.figures.lost_motion, 1e-6);
    near(state.stiffness_n_m_per_rad, rig.figures.stiffness, 1e-6);
    near(state.soft_stiffness_n_m_per_rad, rig.figures.soft_stiffness, 1e-6);
    near(state.efficiency, rig.efficiency.forward, 1e-3);
    near(state.backlash_rad, rig.figures.backlash, 1e-6);
    near(state.hysteresis_loss_j, rig.figures.work.abs(), 1e-6);
    let rated = state.torsion_loop.iter().map(|point| point.0).fold(0.0, f64::max);
    assert!(
        state.hysteresis.residual_rms_n_m < 0.01 * rated,
        "{}",
        state.hysteresis.residual_rms_n_m / rated
    );
    // Friction without load is that of preloaded pins: these joints move freely within their play.
    assert!(
        state.hysteresis.friction_torque() < 0.005 * rated,
        "{}",
        state.hysteresis.friction_torque() / rated
    );
    assert!(state.slipping_elements() > 0 && state.damping_ratio > 0.0);
    let elastic = Hysteresis { elements: Vec::new(), ..state.hysteresis.clone() };
    let (falling, rising) = (shares(), shares().into_iter().rev().collect());
    let branch = |branch, shares: Vec<f64>| {
        shares.into_iter().map(move |share| LoopPoint { torque: share * rated, angle: 0.0, branch })
    };
    let torques: Vec<LoopPoint> =
        branch(Branch::Falling, falling).chain(branch(Branch::Rising, rising)).collect();
    let elastic = evaluate_loop(&elastic.loop_at(&torques), rated).unwrap();
    near(elastic.lost_motion, still.figures.lost_motion, 0.01);
    near(elastic.stiffness, still.figures.stiffness, 0.05);
    let rated = state.transmission_error.iter().filter(|curve| curve.direction > 0.0);
    let rated = rated.max_by(|a, b| a.torque_n_m.total_cmp(&b.torque_n_m)).unwrap();
    // The positions of the bench are different.
    near(rated.peak_to_peak_rad, rig.peak_to_peak(), 0.05);
    assert!(rated.left_rad < 0.3 * rated.peak_to_peak_rad, "{} {}", rated.left_rad, rated.peak_to_peak_rad);
    for [angle, error] in &rig.errors {
        let again = rated.mean_rad + rated.at(angle / against_ring);
        assert!(
            (again - error).abs() <= rated.left_rad + 0.05 * rated.peak_to_peak_rad,
            "{angle}: {again} {error} {}",
            rated.left_rad
        );
    }
}

#[test]
#[ignore = "long"]
fn joints_measure_as_the_bench() {
    let output_at_rest = NEMA17_19.text.replace("fixed_member = \"ring\" ", "fixed_member = \"output\" ");
    // 16 and 13 lobes: 74 2/3 : 1, waves of thirds.
    let thirds = any(TWO_RING_225.text)
        .with_all([
            ("ring.pin_count", Value::from(17_usize)),
            ("ring.pin_radius_mm", 3.5.into()),
            ("second_ring.pin_count", 14_usize.into()),
            ("second_ring.pin_circle_radius_mm", 34.0.into()),
        ])
        .unwrap();
    for (design, against_ring, order) in [
        (any(NEMA17_19.text), -19.0, 20.0),
        (any(&output_at_rest), 19.0, 20.0),
        (any(TWO_RING_225.text), 225.0, 240.0),
        (thirds, 16.0 * 14.0 / 3.0, 17.0 * 14.0 / 3.0),
        (any(TWO_STAGE_500.text), 500.0, 26.0),
    ] {
        // Enough positions for the pin passes of a first stage, and for higher harmonics of the pins of two rings.
        let error_positions = if design.family() == Family::TwoStage { 900 } else { 480 };
        let found = export(&design, &JointOptions { error_positions, ..options("", &[0.0]) });
        let state = &found.states[0];
        let still = bench(&design, 96, "frictionless = true");
        measures_as_the_bench(state, &bench(&design, 96, ""), &still, against_ring);
        for wave in state.transmission_error.iter().flat_map(|curve| &curve.waves) {
            let number = wave.order / order;
            assert!((number - number.round()).abs() < 1e-9, "{} {}", wave.order, found.ratio);
        }
        // Both directions of power are within the losses of the coefficients, and friction is never negative.
        for line in &state.losses {
            assert!(line.efficiency[0] < 1.0 && line.efficiency[1] < line.efficiency[0], "{line:?}");
            assert!(line.friction_n_m.iter().all(|free| *free >= 0.0), "{line:?}");
        }
        assert!(found.inertia_assumed && found.mjcf().contains("inertia of the output assumed"));
        assert_eq!(JointExport::from_json(&found.json().unwrap()).unwrap(), found);
    }
}

#[test]
#[ignore = "long"]
fn a_drive_with_errors_and_a_worn_one_measure_as_the_bench() {
    let toleranced = format!("{}\n[tolerances]\npin_radius_um = 2\nbore_diameter_um = 4\n", NEMA17_19.text);
    let drawn = "errors = \"drawn\"\nseed = 7\n";
    let design = any(&toleranced);
    let coarse = JointOptions { error_positions: 64, ..options(drawn, &[0.0]) };
    let found = export(&design, &coarse);
    let rig = bench(&design, 96, drawn);
    let state = &found.states[0];
    assert!((state.lost_motion_rad / rig.figures.lost_motion - 1.0).abs() < 1e-9);
    // Over a turn of the output: orders that a nominal drive does not have.
    let curves = &state.transmission_error;
    assert!(curves.iter().any(|curve| curve.waves.iter().any(|wave| wave.order % 20.0 != 0.0)));
    // The error of the worn printed drive has peaks between fewer positions.
    for (template, hours, against_ring, error_positions, places) in [
        (NEMA17_19, 2000.0, -19.0, 480, 96),
        (PRINTED_15, 500.0, -15.0, 480, 240),
        (TWO_RING_225, 500.0, 225.0, 480, 96),
        (TWO_STAGE_500, 500.0, 500.0, 900, 96),
    ] {
        let asked = JointOptions { error_positions, ..options("", &[hours, 0.0, hours]) };
        let worn = export(&any(template.text), &asked);
        assert_eq!(worn.states.iter().map(|state| state.hours).collect::<Vec<_>>(), [0.0, hours]);
        let old = bench(&any(template.text), places, &format!("hours = {hours}"));
        let still = bench(&any(template.text), 96, &format!("hours = {hours}\nfrictionless = true"));
        measures_as_the_bench(&worn.states[1], &old, &still, against_ring);
        assert!(worn.states[1].lost_motion_rad > worn.states[0].lost_motion_rad);
    }
}

/// Discs from the kinetic energy of the nominal motion; given masses replace assumed ones.
#[test]
fn inertia_of_discs_is_that_of_the_kinetic_energy() {
    fn discs<D: EccentricDrive>(design: &D, others: f64) {
        let joints = design.moving(&[]).unwrap();
        let velocity = joints.nominal_velocity_at(0.0, 1.0);
        let whole: f64 = velocity.iter().zip(joints.mass()).map(|(v, m)| m * v * v).sum();
        let found = design.inertia().gear_kg_m2;
        assert!((found / (whole - others) - 1.0).abs() < 1e-9, "{found} {whole} {others}");
    }
    let AnyDesign::Eccentric(one) = any(NEMA17_19.text) else { panic!() };
    discs(&*one, one.drive().output.1 / one.ratio().powi(2));
    let AnyDesign::TwoRing(two) = any(TWO_RING_225.text) else { panic!() };
    discs(&*two, two.drive().output_body().1 / two.ratio().powi(2));
    let AnyDesign::TwoStage(stages) = any(TWO_STAGE_500.text) else { panic!() };
    discs(&*stages, stages.drive().second.output.1 / stages.ratio().powi(2));
    let driven = any(&NEMA17_19.text.replace("fixed_member = \"ring\" ", "fixed_member = \"output\" "));
    let AnyDesign::Eccentric(driven) = driven else { panic!() };
    discs(&*driven, driven.drive().ring_body.1 / driven.ratio().powi(2));
    // With the output at rest the discs move on circles without rotation.
    let turning = one.inertia().gear_kg_m2 - driven.inertia().gear_kg_m2;
    assert!((turning / (2.0 * one.drive().disc.1 / 361.0) - 1.0).abs() < 1e-9);
    let given = GivenMasses { input_inertia: Some(5e-6), output_inertia: Some(2e-5), output_mass: Some(0.1) };
    let masses = |masses| JointOptions { masses, ..options("", &[0.0]) };
    let found = export(&any(NEMA17_19.text), &masses(given));
    assert!(!found.inertia_assumed && found.inertia.output_kg_m2 == 2e-5 && found.inertia.output_kg == 0.1);
    assert!((found.usual_load() / (10.0 * 361.0 * 5e-6) - 1.0).abs() < 0.01, "{}", found.usual_load());
    let rv = any(crate::templates::RV_40E.text);
    assert!(joint(&rv, &masses(given), &NoHost).unwrap_err().to_string().contains("RV reducer"));
}

/// If the output cannot drive the input, the export states this, and its loss table is valid in Modelica.
#[test]
fn a_self_locking_drive_is_exported_as_such() {
    let design = any(TWO_RING_225.text).with("friction.pin_seat_coefficient", 0.05).unwrap();
    let found = export(&design, &options("", &[0.0]));
    let state = &found.states[0];
    assert!(state.losses[0].efficiency[1] < 0.0, "{:?}", state.losses[0]);
    assert!(state.back_driving_torque_n_m.is_none());
    assert!(found.urdf().contains("cannot drive the input") && found.modelica().contains("eta_mf2 = 0.001"));
}

#[test]
fn what_joints_of_drives_do_not_have_is_refused() {
    for (template, options, words) in [
        (NEMA17_19, options("bodies = \"elastic\"", &[0.0]), "rigid"),
        (TWO_RING_225, options("discs = \"elastic\"", &[0.0]), "rigid"),
        (NEMA17_19, options("errors = \"drawn\"", &[0.0]), "tolerances"),
        (TWO_STAGE_500, options("errors = \"drawn\"", &[0.0]), "tolerances"),
    ] {
        let error = joint(&any(template.text), &options, &NoHost).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let ideal = FidelityOptions::parse("", "test").unwrap();
    let ideal = JointOptions { fidelity: ideal, ..options("", &[0.0]) };
    assert!(joint(&any(NEMA17_19.text), &ideal, &NoHost).is_err());
}

/// The map lies between the branches of the torque cycle, within the residuals of fit and waves; its pin forces are those
/// of `contact`.
#[test]
fn the_map_rests_where_the_drive_rests() {
    for template in DRIVES {
        let design = any(template.text);
        let asked = options("", &[0.0]);
        let found = export(&design, &asked);
        let pins = pin_loads(&design, &asked, &[0.0], &NoHost).unwrap();
        let map = MapModel::at(&found, &pins, 0.0, LoadFlange::Torque, true).unwrap();
        let (rated, state) = (found.rated_torque_n_m, &found.states[0]);
        let waves = state.transmission_error.iter().map(|curve| curve.peak_to_peak_rad).fold(0.0, f64::max);
        for (torque, angle) in &state.torsion_loop {
            if torque.abs() < 0.1 * rated {
                continue;
            }
            let branches = state.torsion_loop.iter().filter(|point| point.0 == *torque);
            let width = branches.map(|point| (point.1 - angle).abs()).fold(0.0, f64::max);
            let inputs = MapInputs { load_torque: [*torque, 0.0], ..Default::default() };
            let out = map.outputs(&map.start(&inputs).unwrap());
            // Without a torque history the map lies between the branches. The loop is a mean over positions; the
            // variation with the position is in the waves.
            let fit = 3.0 * state.hysteresis.residual_rms_rad;
            assert!(
                (out.flange[0] - angle).abs() < width + fit + waves,
                "{torque}: {} {angle}",
                out.flange[0]
            );
        }
        let inputs = MapInputs { load_torque: [rated, 0.0], ..Default::default() };
        let out = map.outputs(&map.start(&inputs).unwrap());
        let contact =
            design.run(crate::analyses::by_name("contact").unwrap(), "positions = 24", "test", &NoHost);
        let summary = contact.unwrap().summary();
        let most = |name: &str| {
            let keys = ["", "second_", "first_stage_"].map(|part| format!("{part}{name}"));
            keys.iter().filter_map(|key| summary.number(key)).fold(0.0, f64::max)
        };
        let [force, pressure] = [most("max_force_n"), most("max_pressure_mpa") * 1e6];
        assert!((out.pin_force / force - 1.0).abs() < 0.05, "{} {force}", out.pin_force);
        assert!((out.pin_pressure / pressure - 1.0).abs() < 0.05, "{} {pressure}", out.pin_pressure);
        assert!(state.lost_motion_rad > ARCMIN);
    }
}
