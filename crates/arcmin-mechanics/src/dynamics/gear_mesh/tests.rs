use super::*;

fn state() -> (GearMesh, Row) {
    let mut machine = crate::templates::tao2024();
    machine.gear_stage.mesh_stiffness_variation = 0.1;
    let mut mesh = GearMesh::new(&machine, 1, 1e5);
    mesh.planet_run_out = (20e-6, 0.4);
    mesh.sun_run_out = (10e-6, 1.1);
    let carrier = 0.3;
    let place = 0.0405 * unit(carrier + mesh.place);
    (
        mesh,
        [1e-6, -2e-6, 0.9, place.x + 3e-6, place.y - 1e-6, carrier - 0.5 * (0.9 - carrier) + 3e-3, carrier],
    )
}

#[test]
fn gradient_and_hessian_derive_from_the_energy() {
    let (mesh, q) = state();
    let rest = [0.0; MESH_COORDINATES];
    let here = mesh.react(&q, &rest);
    assert!(here.force > 100.0, "{}", here.force);
    let stiffness = mesh.stiffness;
    for i in 0..MESH_COORDINATES {
        let h = if [2, 5, 6].contains(&i) { 1e-8 } else { 1e-10 };
        let shifted = |s: f64| {
            let mut y = q;
            y[i] += s * h;
            mesh.react(&y, &rest)
        };
        let (up, down) = (shifted(1.0), shifted(-1.0));
        let slope = (up.stored - down.stored) / (2.0 * h);
        assert!((slope - here.gradient[i]).abs() < 1e-5 * here.force, "{i}: {slope} {}", here.gradient[i]);
        let slope = (up.force - down.force) / (2.0 * h);
        assert!((slope - here.elastic_slope[i]).abs() < 1e-4 * stiffness, "{i}: {slope}");
        for j in 0..MESH_COORDINATES {
            let slope = (up.gradient[j] - down.gradient[j]) / (2.0 * h);
            let size = (here.hessian[i][i] * here.hessian[j][j]).abs().sqrt().max(1.0);
            assert!(
                (slope - here.hessian[i][j]).abs() < 1e-4 * size,
                "{i} {j}: {slope} {}",
                here.hessian[i][j]
            );
        }
    }
}

/// The tangents of damping equal differences of its forces, within the ramp and beyond it.
#[test]
fn tangents_of_damping_are_differences() {
    let (mut mesh, mut q) = state();
    let touch = mesh.overlaps(&q).unwrap()[0].0;
    mesh.half_backlash += touch - 0.6e-6;
    let mut v = [0.01, -0.02, 3.0, 0.005, 0.01, -1.4, 0.02];
    for depth in [0.0, 5e-6] {
        mesh.half_backlash -= depth;
        let here = mesh.react(&q, &v);
        let size = here.damping_force.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
        assert!(size > 1e-3 && here.side_force[1] == 0.0, "{here:?}");
        for j in 0..MESH_COORDINATES {
            for (speed, step) in [(false, 1e-10), (true, 1e-5)] {
                let at = if speed { &mut v } else { &mut q };
                let kept = at[j];
                let [up, down] = [step, -step].map(|way| {
                    let at = if speed { &mut v } else { &mut q };
                    at[j] = kept + way;
                    mesh.react(&q, &v).damping_force
                });
                if speed {
                    v[j] = kept
                } else {
                    q[j] = kept
                }
                let given = if speed { &here.damping } else { &here.damping_slope };
                for i in 0..MESH_COORDINATES {
                    let slope = (down[i] - up[i]) / (2.0 * step);
                    let scale = given.as_flattened().iter().fold(0.0_f64, |most, k| most.max(k.abs()));
                    assert!((slope - given[i][j]).abs() < 1e-4 * scale, "{i} {j}: {slope} {}", given[i][j]);
                }
            }
        }
    }
}

/// A planet on a rigid carrier has the same forces as a mesh with movable centres that are held.
#[test]
fn a_planet_on_a_rigid_carrier_is_a_mesh_with_held_centres() {
    let machine = crate::templates::tao2024();
    let (mut mesh, _) = state();
    (mesh.planet_run_out, mesh.sun_run_out, mesh.half_backlash) = ((0.0, 0.0), (0.0, 0.0), 3e-6);
    for twist in [-6e-6, -2e-6, 3.4e-6, 9e-6] {
        let (sun, carrier, speed) = (0.9, 0.3, [0.5, 0.2, -0.1]);
        let planet = carrier + (twist - mesh.sun_base_radius * (sun - carrier)) / mesh.planet_base_radius;
        let mut held = MeshState::default();
        mesh.turn(&[sun, carrier, planet], &speed, &mut held);
        let arm = (mesh.sun_base_radius + mesh.planet_base_radius) / machine.gear_stage.pressure_angle.cos();
        let (place, along) =
            (arm * unit(carrier + mesh.place), speed[1] * arm * quarter_turn(unit(carrier + mesh.place)));
        let free = mesh.react(
            &[0.0, 0.0, sun, place.x, place.y, planet, carrier],
            &[0.0, 0.0, speed[0], along.x, along.y, speed[2], speed[1]],
        );
        assert!((held.stored - free.stored).abs() < 1e-9 * free.stored.max(1e-9), "{held:?} {free:?}");
        assert!((held.force - free.force).abs() <= 1e-6 * free.force.abs());
        assert!((held.gradient[0] - free.gradient[2]).abs() <= 1e-6 * free.gradient[2].abs());
        assert!((held.dissipation - free.dissipation).abs() <= 1e-6 * free.dissipation);
    }
}

/// Teeth within the backlash have no contact, and the damping force is never tensile.
#[test]
fn there_is_no_force_within_backlash_and_damping_is_never_tensile() {
    let mut machine = crate::templates::tao2024();
    machine.gear_stage.backlash = 20e-6;
    let mesh = GearMesh::turning(&machine, 0);
    let force = |twist: f64, rate: f64| {
        let mut state = MeshState::default();
        let turn = |x: f64| [x / mesh.sun_base_radius, 0.0, 0.0];
        mesh.turn(&turn(twist), &turn(rate), &mut state);
        state.force
    };
    assert_eq!(force(9e-6, 1.0), 0.0);
    assert!((force(12e-6, 0.0) - 2e8 * 2e-6).abs() < 1e-6);
    assert!((force(-12e-6, 0.0) + 2e8 * 2e-6).abs() < 1e-6);
    assert_eq!([force(12e-6, -10.0), force(-12e-6, 10.0)], [0.0; 2]);
    // Without backlash, on centres that move on their circles only, one flank makes contact as the other loses
    // it.
    let tight = GearMesh { half_backlash: 0.0, parts: false, ..mesh.clone() };
    let mut state = MeshState::default();
    tight.turn(
        &[1e-9 / tight.sun_base_radius, 0.0, 0.0],
        &[-1.0 / tight.sun_base_radius, 0.0, 0.0],
        &mut state,
    );
    assert!((state.force / (0.2 - tight.damping) - 1.0).abs() < 1e-9, "{}", state.force);
}

/// A rotation of the carrier at fixed angles of sun and planet closes the mesh by (r_b1 + r_b2) per radian, and
/// a displacement of the centres apart by dD opens it by sin α dD.
#[test]
fn centre_distance_opens_the_mesh() {
    let machine = crate::templates::tao2024();
    let mesh = GearMesh::new(&machine, 0, 1e30);
    let rest = [0.0; MESH_COORDINATES];
    let force = |extra: f64, twist: f64| {
        let place = (0.0405 + extra) * unit(mesh.place);
        mesh.react(&[0.0, 0.0, twist / mesh.sun_base_radius, place.x, place.y, 0.0, 0.0], &rest).force
    };
    let k = 2e8;
    assert!((force(0.0, 2e-6) - k * 2e-6).abs() < 1e-3);
    let alpha = machine.gear_stage.pressure_angle;
    assert!((force(1e-7, 2e-6) - k * (2e-6 - alpha.sin() * 1e-7)).abs() < 1e-2);
    assert!((force(0.0, -2e-6) + k * 2e-6).abs() < 1e-3);
}
