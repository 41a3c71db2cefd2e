//! Elastic discs of single stages: tangents, limits, energy, and the share of the disc in the compliance by a
//! second method.

use std::sync::OnceLock;

use super::tests::stage;
use super::*;
use crate::contact::{ContactLaw, LineContact};
use crate::dynamics::eccentrics::tests::{differences, rest, work_in_is_work_out};
use crate::dynamics::{FlexibleOptions, System};
use crate::fem::{BoreInterface, DiscShape, FemError, FlexibleDiscs, FlexibleSettings};
use crate::machine::Bore;

/// The stage of the closed forms with two discs of steel that have a bore, eight holes, and a contact law with a depth.
pub(crate) fn two_discs() -> SingleStage {
    let plain = stage();
    let pins = plain.output_pins;
    let hole = |pin: usize| Bore {
        radius: pins.hole_radius(plain.profile.eccentricity),
        centre_radius: pins.circle_radius,
        centre_angle: TAU * pin as f64 / pins.count as f64,
    };
    let bore = Bore { radius: 12e-3, centre_radius: 0.0, centre_angle: 0.0 };
    let law = |radius: f64| {
        LineContact::new(ContactLaw::LineHertz, &plain.disc_material, &plain.disc_material, 8e-3, radius)
    };
    SingleStage {
        phases: vec![0.0, 0.5 * TAU],
        output_pin_stiffness: vec![5e7; 2],
        openings: std::iter::once(bore).chain((0..pins.count).map(hole)).collect(),
        mesh: crate::machine::RingMesh { contact: law(3e-3), ..plain.mesh },
        output_contact: law(4.5e-3),
        ..plain
    }
}

fn settings(shape: &DiscShape) -> FlexibleSettings {
    let fine = FlexibleSettings::plane_stress(shape);
    let sizes = crate::fem::MeshSizes { flank: 1.5 * fine.sizes.flank, flank_rows: 2, ..fine.sizes };
    FlexibleSettings { sizes, interface: BoreInterface::Means, ..fine }
}

fn reduced() -> &'static FlexibleDiscs {
    static DISCS: OnceLock<FlexibleDiscs> = OnceLock::new();
    DISCS.get_or_init(|| FlexibleDiscs::reduce(DiscShape::all_of_stage(&two_discs()), settings).unwrap())
}

fn elastic(stage: &SingleStage, stiffer: f64) -> ElasticDiscs {
    let shapes = DiscShape::all_of_stage(stage);
    let of = |shape: &DiscShape| {
        let disc = shapes.iter().position(|one| one == shape).unwrap();
        Ok::<_, FemError>(reduced().reduced(disc).stiffened(stiffer))
    };
    let discs = FlexibleDiscs::with(shapes.clone(), of).unwrap();
    ElasticDiscs::free(&shapes, discs, FlexibleOptions::default()).unwrap().undamped()
}

#[test]
fn forces_and_tangents_derive_from_the_energy() {
    let stage = two_discs();
    let torque = 20.0;
    let mut joints = stage.joints_with(Some(&elastic(&stage, 1.0))).unwrap();
    joints.joints.iter_mut().for_each(|joint| joint.set_loss_time(0.0));
    let mut q = rest(&mut joints, 0.3, torque);
    // Displaced from the equilibrium, so that all contacts are loaded.
    q.iter_mut()
        .zip(joints.scale())
        .enumerate()
        .for_each(|(i, (q, scale))| *q += 0.1 * scale * (i as f64).sin());
    let found = differences(&joints, &q, torque);
    assert!(found.force < 2e-4 && found.tangent < 2e-3, "{} {}", found.force, found.tangent);
}

/// Discs of a material 10⁴ times stiffer agree with rigid discs whose contact laws exclude the disc.
#[test]
fn stiff_discs_are_rigid() {
    let mut stage = two_discs();
    // A law without depth, and holes whose wall has no compliance.
    let law = ContactLaw::Linear { stiffness: 5e7 };
    stage.mesh.contact = LineContact::new(law, &stage.disc_material, &stage.disc_material, 8e-3, 3e-3);
    let discs = elastic(&stage, 1e4);
    stage.disc_material.youngs_modulus *= 1e8;
    let error = |joints: Result<EccentricJoints, DynamicsError>| {
        let mut joints = joints.unwrap();
        let q = rest(&mut joints, 0.3, 20.0);
        joints.output_error(&q)
    };
    let (rigid, stiff) = (error(stage.joints()), error(stage.joints_with(Some(&discs))));
    let soft = error(stage.joints_with(Some(&elastic(&stage, 1.0))));
    assert!((stiff / rigid - 1.0).abs() < 1e-4, "{stiff} {rigid}");
    assert!(soft.abs() > 1.05 * rigid.abs(), "{soft} {rigid}");
}

#[test]
fn input_work_is_output_work_plus_stored_energy() {
    let stage = two_discs();
    let discs = elastic(&stage, 1.0);
    work_in_is_work_out(stage.joints_with(Some(&discs)).unwrap(), 20.0);
    work_in_is_work_out(stage.driven_housing(Some(&discs)).unwrap(), 20.0);
}

/// The sum of u_n over the orders of a force on a narrow patch, against its closed form.
#[test]
fn the_wall_of_a_hole_deforms_by_the_law() {
    let (poisson, radius, half_width) = (0.3, 1.0, 1e-2);
    let plane = poisson / (1.0 - poisson);
    // Hertz's pressure has the orders 2 J₁(n b/r)/(n b/r); J₁ by its integral.
    let bessel = |x: f64| {
        let count = 400;
        let at = |k: usize| std::f64::consts::PI * (k as f64 + 0.5) / count as f64;
        (0..count).map(|k| (at(k) - x * at(k).sin()).cos()).sum::<f64>() / count as f64
    };
    let share = |n: f64| 2.0 * bessel(n * half_width) / (n * half_width);
    let orders = (2..20_000).map(|n| n as f64);
    let sum: f64 =
        orders.map(|n| share(n) * (2.0 * n + 1.0 - plane) / (n * n - 1.0)).sum::<f64>() + 0.5 * (1.0 + plane);
    let pins = crate::machine::OutputPins { count: 8, circle_radius: 5.0, radius, hole_clearance: 0.0 };
    let depth = pins.hole_depth(0.0, poisson);
    let law = 2.0 * (2.0 * depth / half_width).ln() - plane;
    assert!((sum / law - 1.0).abs() < 1e-3, "{sum} {law}");
}
