//! Forces of machines with all bodies elastic: with and without tangent stiffness, and their energy.

use super::*;

/// Forces computed alone are bit-identical to those computed with a tangent, for any fixed member.
#[test]
fn forces_do_not_depend_on_the_computation_of_tangents() {
    let machine = tao2024();
    let bodies = coarse(&machine);
    let all = JointSettings {
        tilt: Some(TiltingOutput::of(&machine, OutputForces { moment: 200.0, ..OutputForces::default() })),
        ..elastic(&machine, &bodies)
    };
    for fixed_member in [FixedMember::Housing, FixedMember::Carrier] {
        for settings in [&JointSettings::default(), &all] {
            let machine = Machine { fixed_member, ..machine.clone() };
            let hold = |settings: &JointSettings| {
                let mut model = BearingJoints::held(&machine, settings).unwrap();
                model.hold_sun(0.7, 300.0);
                model.set_load(0.6 * machine.rated.torque);
                model
            };
            let model = hold(settings);
            let (nominal, speed) = (model.nominal_position_at(0.7), model.nominal_velocity_at(0.7, 300.0));
            let undamped = hold(&JointSettings { damped: false, ..settings.clone() });
            let place = creep(&undamped, 1e-3, &nominal).unwrap();
            let (mut with, mut alone) = (vec![0.0; place.len()], vec![1.0; place.len()]);
            let balance = model.evaluate(0.0, &place, &speed, &mut with, &mut model.linearisation());
            assert_eq!(model.evaluate_forces(0.0, &place, &speed, &mut alone), balance);
            assert_eq!(alone, with);
            assert!(balance.stored > 0.0);
        }
    }
}

/// Difference of stored energy and work of all forces, relative to the sum of absolute energy changes, on a
/// path with rotation of the machine and oscillation of every coordinate.
fn energy_left_on_a_path(machine: &Machine, settings: &JointSettings) -> f64 {
    let mut model = BearingJoints::held(machine, settings).unwrap();
    model.hold_sun(0.7, 0.0);
    model.set_load(0.0);
    let start = model.nominal_position_at(0.7);
    let settled = creep(&model, 1e-3, &start).unwrap();
    let scale = model.scale().to_vec();
    // Coordinates and the angle of the sun, the forces, and the stored energy at a share of the path.
    let mut at = |share: f64| {
        let sun = 0.7 + 3.0 * share;
        model.hold_sun(sun, 0.0);
        let mut place = model.nominal_position_at(sun);
        for (i, q) in place.iter_mut().enumerate() {
            *q += settled[i] - start[i] + 0.3 * scale[i] * (0.9 * i as f64 + 5.0 * share).sin();
        }
        let rest = vec![0.0; place.len()];
        let mut push = rest.clone();
        let (balance, torque) = model.evaluate_with_input(0.0, &place, &rest, &mut push, None);
        push.iter_mut().for_each(|force| *force = -*force);
        push.push(torque);
        place.push(sun);
        (place, push, balance.stored)
    };
    let steps = 4000;
    let first = at(0.0);
    let (mut work, mut turnover, mut before) = (0.0, 0.0, first.clone());
    for step in 1..=steps {
        let next = at(f64::from(step) / f64::from(steps));
        let forces = next.1.iter().zip(&before.1).map(|(one, other)| 0.5 * (one + other));
        let ways = next.0.iter().zip(&before.0).map(|(one, other)| one - other);
        work += forces.zip(ways).map(|(force, way)| force * way).sum::<f64>();
        turnover += (next.2 - before.2).abs();
        before = next;
    }
    (work - (before.2 - first.2)).abs() / turnover
}

fn tilting(machine: &Machine) -> JointSettings {
    let moment = machine.rated.torque;
    let forces = OutputForces { moment, axial: 1000.0, radial: 500.0 };
    JointSettings {
        tilt: Some(TiltingOutput::of(machine, forces)),
        damped: false,
        ..JointSettings::default()
    }
}

/// Conservation of energy: the work of all forces is the change of the stored energy, for any fixed member,
/// with tilting and elastic bodies.
#[test]
#[ignore = "long"]
fn energy_is_conserved_on_a_path() {
    let machine = tao2024();
    let bodies = coarse(&machine);
    let all = JointSettings { tilt: tilting(&machine).tilt, ..elastic(&machine, &bodies) };
    for fixed_member in [FixedMember::Housing, FixedMember::Carrier] {
        let machine = Machine { fixed_member, ..machine.clone() };
        for settings in [&tilting(&machine), &all] {
            let left = energy_left_on_a_path(&machine, settings);
            assert!(left < 1e-5, "{fixed_member:?}: {left:e}");
        }
    }
}

/// The same for random machines with tilting bodies.
#[test]
#[ignore = "long"]
fn forces_keep_their_energy_in_random_machines() {
    for seed in 1..=20 {
        let machine = crate::random_designs::sound_design(seed).0.machine();
        let left = energy_left_on_a_path(&machine, &tilting(&machine));
        assert!(left < 1e-5, "{seed}: {left:e}");
    }
}

/// Forces alone equal those computed with a tangent, for random machines at their nominal position, where most
/// contacts are closed or nearly so.
#[test]
fn forces_alone_are_the_same_on_random_machines() {
    for seed in 1..=30 {
        let machine = crate::random_designs::sound_design(seed).0.machine();
        let mut model = BearingJoints::held(&machine, &JointSettings::default()).unwrap();
        model.hold_sun(0.7, 300.0);
        model.set_load(machine.rated.torque);
        let speed = model.nominal_velocity_at(0.7, 300.0);
        // Every coordinate displaced by a different amount.
        let nominal = model.nominal_position_at(0.7);
        let moved = nominal.iter().zip(model.scale()).enumerate();
        let place: Vec<f64> = moved.map(|(i, (q, scale))| q + scale * (0.3 * i as f64).sin()).collect();
        let (mut with, mut alone) = (vec![0.0; place.len()], vec![1.0; place.len()]);
        let balance = model.evaluate(0.0, &place, &speed, &mut with, &mut model.linearisation());
        assert_eq!(model.evaluate_forces(0.0, &place, &speed, &mut alone), balance, "{seed}");
        assert_eq!(alone, with, "{seed}");
        assert!(balance.stored > 0.0, "{seed}");
    }
}

/// In a system of this size the last iterations use tangents of earlier positions: they converge to the same
/// equilibrium as with exact ones.
#[test]
fn kept_tangents_lead_to_the_same_equilibrium() {
    let machine = tao2024();
    let settings = elastic(&machine, &coarse(&machine));
    let mut model = BearingJoints::held(&machine, &settings).unwrap();
    let control = EquilibriumControl { tolerance: 1e-7, force_tolerance: 1e-6, ..Default::default() };
    let exact = EquilibriumControl { tolerance: 1e-11, ..control };
    for sun in [0.0, 3.3, 17.0] {
        model.hold_sun(sun, 0.0);
        model.set_load(0.9 * machine.rated.torque);
        let near = solve_equilibrium(&*model, 0.0, &model.nominal_position_at(sun), control).unwrap();
        model.set_load(machine.rated.torque);
        let short = solve_equilibrium(&*model, 0.0, &near.position, control).unwrap();
        let long = solve_equilibrium(&*model, 0.0, &near.position, exact).unwrap();
        assert!(short.iterations < 12, "{}", short.iterations);
        for ((a, b), scale) in short.position.iter().zip(&long.position).zip(model.scale()) {
            assert!((a - b).abs() < 1e-7 * scale, "{sun}: {a} {b}");
        }
    }
}
