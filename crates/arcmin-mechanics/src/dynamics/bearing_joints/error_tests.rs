//! Single errors compared with their first-order closed forms.
//!
//! With stiff joints, a linear contact law and flanks without clearance, changes δg_i of the gaps shift the
//! output by δε = −Σ F_i δg_i/T (virtual work), with the forces F_i of the machine without errors from the load
//! sharing with ideal joints, which is a different solver.

use super::*;
use crate::contact::{ContactLaw, PinContact};
use crate::dynamics::{EquilibriumControl, Reducer, solve_equilibrium};
use crate::geometry::{quarter_turn, unit};
use crate::load::ShareLoad;
use crate::machine::{
    BoreError, CrankAngle, DiscError, EccentricError, ManufacturingErrors, PinError, RunOut, Tolerances,
};
use crate::units::UM;

const TORQUE: f64 = 412.0;
/// Small compared with the approach of lightly loaded pins, so that few contacts open, because the closed forms
/// are of first order.
const SMALL: f64 = 0.02 * UM;

fn machine() -> Machine {
    let mut machine = crate::templates::tao2024();
    machine.contact_law = ContactLaw::Linear { stiffness: 2.85e8 };
    machine.bearings.turning_arm.clearance = 0.0;
    machine
}

fn model(machine: &Machine, errors: &ManufacturingErrors, sun: f64) -> (BearingJoints, Vec<f64>) {
    let settings = JointSettings {
        stiffness_scale: 1e6,
        damped: false,
        errors: errors.clone(),
        ..JointSettings::default()
    };
    let mut model = BearingJoints::held(machine, &settings).unwrap();
    model.hold_sun(sun, 0.0);
    model.set_load(TORQUE);
    // With bearings a million times stiffer, the rounding is some mN.
    let control = EquilibriumControl { tolerance: 1e-9, ..EquilibriumControl::default() };
    let q = solve_equilibrium(&*model, 0.0, &model.nominal_position_at(sun), control).unwrap().position;
    (model, q)
}

/// Shift of the output by the errors, rad.
fn shift(machine: &Machine, errors: &ManufacturingErrors, sun: f64) -> f64 {
    let (with, q) = model(machine, errors, sun);
    let (without, q0) = model(machine, &ManufacturingErrors::default(), sun);
    with.output_error(&q) - without.output_error(&q0)
}

/// −Σ F_i δg_i/T with δg_i from `gap` for the contacts of every disc.
fn closed_form(machine: &Machine, sun: f64, gap: impl Fn(usize, f64, &PinContact) -> f64) -> f64 {
    let crank = -sun * 39.0 / 81.0;
    let sharing = machine.load_sharing(CrankAngle::from_radians(crank), TORQUE).unwrap();
    let work: f64 = sharing
        .discs
        .iter()
        .enumerate()
        .flat_map(|(j, disc)| disc.iter().map(move |c| (j, c)))
        .map(|(j, c)| c.force * gap(j, crank, c))
        .sum();
    -work / TORQUE
}

const SUNS: [f64; 4] = [0.3, 1.3, 2.9, 5.1];

fn agree(name: &str, sun: f64, found: f64, expected: f64, size: f64) {
    assert!(
        (found - expected).abs() < 0.02 * size,
        "{name} at sun angle {sun}: {found:e}, closed form {expected:e}"
    );
}

#[test]
fn val_eccentricity() {
    let machine = machine();
    let error = EccentricError { eccentricity: SMALL, phase: 0.0 };
    let errors =
        ManufacturingErrors { eccentrics: vec![vec![error; 2]; 2], ..ManufacturingErrors::default() };
    for sun in SUNS {
        let phases = [0.0, std::f64::consts::PI];
        let expected =
            closed_form(&machine, sun, |j, crank, c| -SMALL * c.normal.dot(&unit(crank + phases[j])));
        agree("eccentricity", sun, shift(&machine, &errors, sun), expected, expected.abs());
    }
}

#[test]
fn val_pin_circle_and_pin_radius() {
    let machine = machine();
    let circle = ManufacturingErrors { pin_circle_radius: SMALL, ..ManufacturingErrors::default() };
    let radius = ManufacturingErrors { pin_radius: -SMALL, ..ManufacturingErrors::default() };
    for sun in SUNS {
        let expected = closed_form(&machine, sun, |_, _, c| {
            SMALL * c.normal.dot(&unit(std::f64::consts::TAU * c.pin as f64 / 40.0))
        });
        agree("pin circle", sun, shift(&machine, &circle, sun), expected, expected.abs());
        let expected = closed_form(&machine, sun, |_, _, _| SMALL);
        agree("pin radius", sun, shift(&machine, &radius, sun), expected, expected.abs());
    }
}

#[test]
fn val_one_displaced_pin() {
    let machine = machine();
    for sun in SUNS {
        // The most loaded pin is displaced by 0.2 µm, so that no contact opens.
        let sharing = machine.load_sharing(CrankAngle::from_radians(-sun * 39.0 / 81.0), TORQUE).unwrap();
        let most = sharing.contacts().max_by(|a, b| a.force.total_cmp(&b.force)).unwrap().pin;
        for (radial, tangential) in [(0.2 * UM, 0.0), (0.0, 0.2 * UM)] {
            let mut pins = vec![PinError::default(); 40];
            pins[most] = PinError { radial, tangential, radius: 0.0 };
            let errors = ManufacturingErrors { pins, ..ManufacturingErrors::default() };
            let outward = unit(std::f64::consts::TAU * most as f64 / 40.0);
            let moved = radial * outward + tangential * quarter_turn(outward);
            let expected =
                closed_form(&machine, sun, |_, _, c| if c.pin == most { c.normal.dot(&moved) } else { 0.0 });
            agree(
                "pin",
                sun,
                shift(&machine, &errors, sun),
                expected,
                expected.abs().max(
                    0.1 * closed_form(&machine, sun, |_, _, c| if c.pin == most { -0.2 * UM } else { 0.0 }),
                ),
            );
        }
    }
}

/// Both bores of one disc displaced by 1 µm in the direction of rotation turn it back by 1 µm/R_c; the moment
/// on that disc alone causes the shift.
#[test]
fn val_bore_position() {
    let machine = machine();
    let bore = BoreError { tangential: UM, ..BoreError::default() };
    let errors = ManufacturingErrors {
        discs: vec![DiscError { bores: vec![bore; 2], ..DiscError::default() }],
        ..ManufacturingErrors::default()
    };
    for sun in SUNS {
        let turn = -UM / machine.gear_stage.centre_distance();
        let expected = closed_form(&machine, sun, |j, _, c| if j == 0 { c.gradient[2] * turn } else { 0.0 });
        agree("bores", sun, shift(&machine, &errors, sun), expected, expected.abs());
    }
}

/// Planets whose gears have the run-out ε displace their meshes along the line of action. With opposite
/// run-outs on opposite planets all meshes move equally, the crankshafts rotate together, and the output
/// rotates by ε/(r_b2 z_c + r_b1 + r_b2). Amplitude over one turn of the planet relative to the carrier.
///
/// One planet alone would rotate the output by half of that if the discs coupled the crankshafts; when their
/// centres are in line with the eccentricity they do not.
#[test]
fn val_planet_run_out() {
    let machine = machine();
    // Below the 1.1 µm of elastic approach in the meshes: with more run-out the centre distance becomes so
    // small that teeth without backlash touch on both flanks.
    let amplitude = 0.5 * UM;
    let planets = vec![RunOut { amplitude, phase: 0.0 }, RunOut { amplitude, phase: std::f64::consts::PI }];
    let errors = ManufacturingErrors { planets, ..ManufacturingErrors::default() };
    let stage = &machine.gear_stage;
    let (r1, r2) = (stage.sun_base_radius(), stage.planet_base_radius());
    let expected = amplitude / (39.0 * r2 + r1 + r2);
    // One turn of the crankshaft relative to the carrier: 81/40 of the sun's turn.
    let count = 16;
    let (mut cosine, mut sine) = (0.0, 0.0);
    for i in 0..count {
        let turn = std::f64::consts::TAU * f64::from(i) / f64::from(count);
        let found = shift(&machine, &errors, turn * 81.0 / 40.0);
        cosine += 2.0 / f64::from(count) * found * turn.cos();
        sine += 2.0 / f64::from(count) * found * turn.sin();
    }
    agree("planet", 0.0, cosine.hypot(sine), expected, expected);
    let (loaded, q) = model(&machine, &ManufacturingErrors::default(), 0.0);
    assert!(
        loaded.forces(0.0, &q, &vec![0.0; q.len()]).mesh_force.abs() > 100.0,
        "the meshes are assumed to be loaded"
    );
}

/// One pin displaced inwards by 0.2 µm, all pins equal linear springs, all other parts stiff: with the slopes
/// s_i of the gaps along the one remaining degree of freedom, its force increases by ΔF_m = k (δ_m + s_m Δε),
/// where Δε follows from Σ F_i s_i = T; the slopes are those of the machine with ideal joints.
#[test]
fn val_a_displaced_pin_takes_the_load_of_first_order_theory() {
    let machine = machine();
    let k = 2.85e8;
    let kinematics = machine.kinematics();
    for sun in SUNS {
        let crank = -sun * 39.0 / 81.0;
        let sharing = machine.load_sharing(CrankAngle::from_radians(crank), TORQUE).unwrap();
        let slope = |j: usize, c: &PinContact| {
            let motion = kinematics.crank_per_output_locked()
                * kinematics.eccentricity
                * quarter_turn(unit(crank + kinematics.phases[j]));
            c.gradient[0] * motion.x + c.gradient[1] * motion.y + c.gradient[2]
        };
        let loaded = || {
            sharing
                .discs
                .iter()
                .enumerate()
                .flat_map(|(j, disc)| disc.iter().filter(|c| c.force > 0.0).map(move |c| (j, c)))
        };
        // The slopes fulfil the equilibrium of the torque, which confirms them.
        let torque: f64 = loaded().map(|(j, c)| c.force * slope(j, c)).sum();
        assert!((torque / TORQUE - 1.0).abs() < 1e-6, "{torque}");
        let (disc, most) = loaded().max_by(|a, b| a.1.force.total_cmp(&b.1.force)).unwrap();
        let inwards = -0.2 * UM;
        let moved = |c: &PinContact| {
            if c.pin == most.pin {
                inwards * c.normal.dot(&unit(std::f64::consts::TAU * c.pin as f64 / 40.0))
            } else {
                0.0
            }
        };
        let stiffness: f64 = loaded().map(|(j, c)| slope(j, c).powi(2)).sum();
        let way = -loaded().map(|(j, c)| moved(c) * slope(j, c)).sum::<f64>() / stiffness;
        let expected = -k * (moved(most) + slope(disc, most) * way);

        let mut pins = vec![PinError::default(); 40];
        pins[most.pin].radial = inwards;
        let errors = ManufacturingErrors { pins, ..ManufacturingErrors::default() };
        let force = |errors: &ManufacturingErrors| {
            let (model, q) = model(&machine, errors, sun);
            model.pin_contacts(disc, &q)[most.pin].force
        };
        let found = force(&errors) - force(&ManufacturingErrors::default());
        assert!(found > 20.0);
        agree("force of the pin", sun, found, expected, expected);
    }
}

/// Means over the whole ring converge: `contact` uses 720 positions, `life` 144 (lost motion 48). Twelve,
/// sufficient for a machine without errors, omit some pins.
#[test]
fn means_over_the_ring_converge() {
    let machine = crate::templates::tao2024();
    let tolerances = Tolerances {
        pin_position: 3.0 * UM,
        pin_radius: UM,
        pin_circle_offset: 4.0 * UM,
        eccentricity: 2.0 * UM,
        ..Tolerances::default()
    };
    let errors = ManufacturingErrors::draw(&machine, &tolerances, 5);
    let meshing =
        BearingMeshing::new(&machine, &JointSettings { errors, ..JointSettings::default() }).unwrap();
    assert_eq!(meshing.pitches(), 39 * 40);
    let lost = |count: usize| crate::load::lost_motion(&mut meshing.clone(), TORQUE, count).unwrap().arcmin();
    let force =
        |cycle: &crate::load::Cycle| cycle.pin_loads().iter().map(|load| load.mean_force).fold(0.0, f64::max);
    let cycle = |count: usize| meshing.clone().whole_cycle(TORQUE, count).unwrap();
    let (few, some, many) = (cycle(12), cycle(144), cycle(720));
    let within =
        |name: &str, a: f64, b: f64, tolerance: f64| assert!((a - b).abs() < tolerance, "{name}: {a} {b}");
    within("mean error", some.mean_error().arcmin(), many.mean_error().arcmin(), 0.001);
    within("play", some.mean_play().arcmin(), many.mean_play().arcmin(), 0.005);
    within("lost motion", lost(48), lost(480), 0.002);
    within("share of a disc", some.disc_share(0), many.disc_share(0), 5e-4);
    within("largest mean force", force(&some), force(&many), 0.03 * force(&many));
    within("largest force", some.max_force(), many.max_force(), 0.03 * many.max_force());
    assert!(force(&few) > 1.2 * force(&many) && few.max_force() < 0.9 * many.max_force());
}
