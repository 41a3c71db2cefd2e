//! Closed forms of single stages: kinematics, forces, play. Sources: Litvin and Feng 1996 for the flank, statics of rigid
//! discs on equal springs for the forces.

use super::*;
use crate::contact::{ContactLaw, LineContact};
use crate::dynamics::eccentrics::tests::{differences, rest};
use crate::dynamics::{BearingJoints, HeldDrive, JointSettings, System};
use crate::geometry::{Profile, Relief, Vec2, unit};
use crate::machine::{
    GapChain, PartWear, PinBeam, PinMounting, RingMesh, RollerBearing, RollerKind, StageErrors,
    StageFriction, StageOffsets, StageTolerances,
};
use crate::units::UM;

/// 19 : 1 with 20 pins on 80 mm and one disc without flank relief; all parts except ring and output pins are
/// stiff.
pub(in crate::dynamics) fn stage() -> SingleStage {
    let profile = Profile::new(20, 0.04, 1.2e-3, 3e-3);
    let steel = crate::templates::tao2024().disc.material;
    let law = ContactLaw::Linear { stiffness: 5e7 };
    SingleStage {
        phases: vec![0.0],
        mesh: RingMesh {
            contact: LineContact::new(law, &steel, &steel, 8e-3, profile.pin_radius),
            profile,
            ring_circle_radius: 0.04,
            ring_pin_radius: 3e-3,
            relief: Relief::uniform(0.0),
            mounting: PinMounting::Fixed,
        },
        eccentric: RollerBearing {
            kind: RollerKind::Cylindrical,
            roller_count: 240,
            roller_diameter: 3e-3,
            roller_length: 8.0,
            pitch_diameter: 24e-3,
            contact_angle: 0.0,
            clearance: 0.0,
            dynamic_load_rating: None,
        },
        output_pins: OutputPins { count: 8, circle_radius: 20e-3, radius: 4.5e-3, hole_clearance: 0.0 },
        pin_beam: PinBeam { radius: 4.5e-3, places: vec![4e-3], span: None, material: steel.clone() },
        output_pin_stiffness: vec![5e7],
        output_contact: LineContact::new(law, &steel, &steel, 8e-3, 4.5e-3),
        openings: Vec::new(),
        input_support: 1e13,
        output_support: 1e13,
        disc_material: steel.clone(),
        disc: (0.2, 1e-4),
        input: (0.1, 1e-5),
        output: (0.5, 3e-4),
        ring_body: (0.5, 3e-4),
        errors: StageErrors::default(),
    }
}

#[test]
fn the_output_turns_against_the_input() {
    let stage = stage();
    assert_eq!(stage.ratio(), -19.0);
    let joints = stage.joints().unwrap();
    let output = joints.output_index();
    for angle in [0.0, 1.0, 40.0] {
        let nominal = joints.nominal_position_at(angle);
        assert!((nominal[output] + angle / 19.0).abs() < 1e-12);
        // In nominal position all gaps are zero: at every angle the flank touches every pin on one side.
        for contact in joints.pin_contacts(0, &nominal) {
            assert!(contact.gap.abs() < 1e-12, "{contact:?}");
        }
        for pin in joints.output_pin_loads(0, &nominal) {
            assert!(pin.gap.abs() < 1e-12, "{pin:?}");
        }
    }
}

/// Forces 4 T/(K₁ z_c R) and 4 T/(z_w R_w) for equal springs; the forces of the output pins act along the
/// eccentric, T/(e z_c) acts perpendicular to it, and the force of the eccentric bearing follows from the
/// equilibrium of the disc.
#[test]
fn forces_are_the_closed_forms() {
    let stage = stage();
    let mut joints = stage.joints().unwrap();
    let torque = 10.0;
    let (mut largest_ring, mut largest_pin, mut mean_eccentric) = (0.0_f64, 0.0_f64, 0.0);
    for step in 0..40 {
        // Over the periods of ring and output stage.
        let angle = 0.37 + TAU * step as f64 / 40.0;
        let q = rest(&mut joints, angle, torque);
        let ring = joints.pin_contacts(0, &q);
        largest_ring = ring.iter().fold(largest_ring, |most, contact| most.max(contact.force));
        let pins = joints.output_pin_loads(0, &q);
        largest_pin = pins.iter().fold(largest_pin, |most, pin| most.max(pin.force));
        let e = unit(angle);
        let sum: Vec2 = ring
            .iter()
            .map(|contact| contact.force * Vec2::new(contact.gradient[0], contact.gradient[1]))
            .sum();
        let across = (e.x * sum.y - e.y * sum.x).abs();
        let lever = 19.0 * stage.profile.eccentricity;
        assert!((across * lever / torque - 1.0).abs() < 1e-3, "{angle}: {across} {}", torque / lever);
        let along: f64 = pins.iter().map(|pin| pin.force * unit(pin.direction).dot(&e).abs()).sum();
        let whole: f64 = pins.iter().map(|pin| pin.force).sum();
        assert!(along > 0.999 * whole, "{along} {whole}");
        // Pins at cos φ_i apart: Σ F_i R_w |sin φ_i| = T.
        assert!(pins.iter().filter(|pin| pin.force > 0.0).count() <= 4);
        // The eccentric transmits the sum of all forces of pins and holes on the disc.
        let by_pins: Vec2 = pins.iter().map(|pin| pin.force * unit(pin.direction)).sum();
        let bearing = joints.eccentric_force(0, &q);
        assert!(((sum + by_pins).norm() / bearing - 1.0).abs() < 1e-6, "{bearing}");
        mean_eccentric += bearing / 40.0;
    }
    let eccentric = stage.eccentric_force(torque);
    assert!((mean_eccentric / eccentric - 1.0).abs() < 0.01, "{mean_eccentric} {eccentric}");
    let (ring, pin) = (stage.ring_force(torque), stage.output_pin_force(torque));
    assert!((largest_ring / ring - 1.0).abs() < 0.015, "{largest_ring} {ring}");
    assert!((largest_pin / pin - 1.0).abs() < 0.01, "{largest_pin} {pin}");
}

/// Input work equals output work, with the input torque by virtual work; forces are gradients of the energy and
/// have their exact tangent, also for unevenly worn holes.
#[test]
fn forces_derive_from_an_energy() {
    let mut stage = stage();
    stage.phases = vec![0.0, 0.5 * TAU];
    stage.output_pin_stiffness = vec![5e7; 2];
    stage.eccentric.roller_length = 8e-3;
    stage.eccentric.roller_count = 14;
    stage.output_pins.hole_clearance = 5.0 * UM;
    let mut joints = stage.joints().unwrap();
    // Holes worn unevenly, 26 µm at the deepest.
    let mut wear = PartWear::default();
    wear.holes.deposit(1.3, TAU * 4e-3 * 2.0 * UM, 4e-3);
    joints.set_part_wear(0, &wear);
    let q = rest(&mut joints, 0.9, 15.0);
    assert!(joints.output_pin_loads(0, &q).iter().any(|pin| pin.force > 0.0));
    let found = differences(&joints, &q, 15.0);
    assert!(found.work < 1e-7 && found.tangent < 1e-4, "{} {}", found.work, found.tangent);
}

/// The play of each gap alone agrees with its closed form, for pins in holes depending on their position; all
/// gaps together give slightly more than the sum.
#[test]
fn play_is_the_sum_of_its_parts() {
    let tight = stage();
    let play = |stage: &SingleStage, angle: f64| {
        let mut joints = stage.joints().unwrap();
        // A torque so small that elastic displacements are negligible.
        let ends = [1e-4, -1e-4].map(|torque| {
            let q = rest(&mut joints, angle, torque);
            joints.output_error(&q)
        });
        ends[1] - ends[0]
    };
    let mut ring = stage();
    ring.relief = Relief::uniform(20.0 * UM);
    let mut bearing = stage();
    bearing.eccentric.clearance = 40.0 * UM;
    let mut output = stage();
    output.output_pins.hole_clearance = 20.0 * UM;
    let all = SingleStage {
        mesh: ring.mesh.clone(),
        eccentric: bearing.eccentric.clone(),
        output_pins: output.output_pins,
        ..stage()
    };
    let none = play(&tight, 0.3);
    assert!(none < 1e-3 * ring.play_chain().total(), "{none}");
    let mut found = [f64::INFINITY, 0.0];
    let mut whole = f64::INFINITY;
    for step in 0..16 {
        let angle = 0.05 + TAU * step as f64 / 16.0;
        let [by_ring, by_bearing] = [&ring, &bearing].map(|stage| play(stage, angle));
        assert!((by_bearing / bearing.play_chain().total() - 1.0).abs() < 0.02, "{angle}: {by_bearing}");
        assert!(by_ring >= 0.99 * ring.play_chain().total(), "{angle}: {by_ring}");
        assert!(by_ring <= 1.06 * ring.play_chain().total(), "{angle}: {by_ring}");
        let by_pins = play(&output, angle);
        found = [found[0].min(by_pins), found[1].max(by_pins)];
        whole = whole.min(play(&all, angle));
    }
    let closed = output.play_chain().total();
    let widest = 1.0 / (TAU / 16.0).cos();
    assert!(
        (found[0] / closed - 1.0).abs() < 0.01 && found[1] < 1.01 * widest * closed,
        "{found:?} {closed}"
    );
    // With all gaps open the disc also shifts along its eccentric, which increases the play of the pins in
    // their holes: a tenth more.
    let sum = all.play_chain().total();
    assert!(whole > 0.99 * sum && whole < 1.12 * sum, "{whole} {sum}");
}

/// Two discs on opposite eccentrics have equal forces half a turn apart, and equal mean shares of the torque
/// over a turn.
#[test]
fn opposite_discs_have_equal_forces() {
    let stage = SingleStage { phases: vec![0.0, 0.5 * TAU], output_pin_stiffness: vec![5e7; 2], ..stage() };
    let mut joints = stage.joints().unwrap();
    let largest = |joints: &EccentricJoints, disc: usize, q: &[f64]| {
        joints.pin_contacts(disc, q).iter().fold(0.0_f64, |most, contact| most.max(contact.force))
    };
    for angle in [0.2, 1.7, 3.0] {
        let one = rest(&mut joints, angle, 20.0);
        let first = largest(&joints, 0, &one);
        let other = rest(&mut joints, angle + 0.5 * TAU, 20.0);
        let second = largest(&joints, 1, &other);
        // The pins are another half pitch on: 20 pins against 19 lobes.
        assert!((first / second - 1.0).abs() < 0.02, "{first} {second}");
    }
}

/// A disc in a ring has the same forces as in an RV reducer with the same profile and position.
#[test]
fn pins_carry_as_in_an_rv_reducer() {
    let machine = crate::templates::tao2024();
    let rv =
        BearingJoints::held(&machine, &JointSettings { damped: false, ..JointSettings::default() }).unwrap();
    let stage = SingleStage {
        mesh: RingMesh {
            profile: machine.profile(),
            ring_circle_radius: machine.ring.pin_circle_radius,
            ring_pin_radius: machine.ring.pin_radius,
            contact: machine.line_contact(),
            relief: machine.designed_relief(),
            mounting: PinMounting::Fixed,
        },
        phases: vec![0.0],
        ..stage()
    };
    let joints = stage.joints().unwrap();
    let mut place = rv.nominal_position_at(0.0);
    let (mut q, at) = (joints.nominal_position_at(0.0), rv.disc_place(0));
    for (own, shift) in [4e-6, -7e-6, 3e-4].into_iter().enumerate() {
        place[at[own]] += shift;
        q[own] = place[at[own]];
    }
    let [one, other] = [rv.pin_contacts(0, &place), joints.pin_contacts(0, &q)];
    let most = one.iter().fold(0.0_f64, |most, contact| most.max(contact.force));
    assert!(most > 100.0, "{most}");
    for (one, other) in one.iter().zip(&other) {
        assert!((one.force - other.force).abs() < 1e-9 * most, "{} {}", one.force, other.force);
    }
}

#[test]
fn stages_that_cannot_be_are_refused() {
    let mut cusp = stage();
    cusp.profile.eccentricity = 2.1e-3;
    assert!(cusp.joints().unwrap_err().to_string().contains("cusp"));
    let none = SingleStage { phases: Vec::new(), ..stage() };
    assert!(none.joints().unwrap_err().to_string().contains("number of discs"));
}

/// Every kind of error, most of them within ± some m.
pub(in crate::dynamics) fn everything(width: f64) -> StageTolerances {
    StageTolerances {
        pin_position: width,
        pin_radius: 0.6 * width,
        pin_circle_radius: width,
        pin_circle_offset: width,
        flank_offset: width,
        flank_run_out: width,
        flank_pitch: width,
        flank_profile: width,
        eccentricity: width,
        eccentric_phase: 5.0 * ARCMIN,
        eccentric_clearance: width,
        output_pin_circle_radius: width,
        output_pin_position: width,
        output_pin_radius: 0.6 * width,
        bore_position: width,
        bore_diameter: 1.2 * width,
        bore_offset: 1.2 * width,
        flank_turn: width,
        offsets: StageOffsets::default(),
    }
}

/// The chain of gaps compared with static equilibria at nearly zero torque: nominal drive, and drawn drives
/// with every kind of error.
#[test]
fn play_as_made_is_that_of_the_mechanism() {
    let mut stage = stage();
    stage.phases = vec![0.0, 0.5 * TAU];
    stage.output_pin_stiffness = vec![5e7; 2];
    stage.relief = Relief::uniform(20.0 * UM);
    stage.eccentric.clearance = 15.0 * UM;
    stage.output_pins.hole_clearance = 20.0 * UM;
    for seed in 0..12 {
        let errors = match seed {
            0 => StageErrors::default(),
            _ => StageErrors::draw(&[(stage.part_counts(), everything(5.0 * UM))], seed, None).swap_remove(0),
        };
        let made = SingleStage { errors: errors.clone(), ..stage.clone() };
        let mut joints = made.joints().unwrap();
        for angle in [0.3, 2.0, 41.0] {
            let ends = [1e-4, -1e-4].map(|torque| {
                let q = rest(&mut joints, angle, torque);
                joints.output_error(&q)
            });
            let found = ends[1] - ends[0];
            let chain = GapChain::at(&stage, &[angle]).least(std::slice::from_ref(&errors)).unwrap();
            assert!((chain / found - 1.0).abs() < 0.02, "{seed} {angle}: {chain} {found}");
        }
    }
}

/// The mean of Σ F over all output pins is 4 T/(π R_w), each with the friction μ F and the sliding distance e
/// (1 + 1/z_c) per radian of the input; a roller reduces it in proportion to the radius of its pin.
#[test]
fn friction_of_output_pins_is_their_closed_form() {
    let (stage, torque, speed, count) = (stage(), 20.0, 1e5, 12);
    let drive = HeldDrive::new(stage.joints().unwrap(), torque, 1.0);
    let pins = stage.output_pins;
    for pin_over_roller in [1.0, 0.6] {
        let friction = StageFriction { ring: 0.0, output: 0.1, pin_over_roller, bearing: 0.0 };
        let mut mean = 0.0;
        for position in 0..count {
            let angle = std::f64::consts::TAU * position as f64 / count as f64 + 0.01;
            let place = rest(&mut stage.joints().unwrap(), angle, torque);
            let mut running = drive.with_friction(angle, &[friction], 1e-3);
            running.hold_input(angle, speed);
            let velocity = running.nominal_velocity_at(angle, speed);
            let (mut force, mut tangent) = (vec![0.0; place.len()], running.linearisation());
            let balance = running.evaluate(0.0, &place, &velocity, &mut force, &mut tangent);
            mean += balance.dissipation / speed / count as f64;
        }
        let forces = 4.0 * torque / (std::f64::consts::PI * pins.circle_radius);
        let known = 0.1 * pin_over_roller * forces * stage.profile.eccentricity * (1.0 + 1.0 / 19.0);
        assert!((mean / known - 1.0).abs() < 0.01, "{pin_over_roller}: {mean} {known}");
    }
}

/// The tangents of friction between output pins and holes are those of its forces.
#[test]
fn friction_of_output_pins_has_the_slopes_of_its_forces() {
    let stage = stage();
    let place = rest(&mut stage.joints().unwrap(), 0.4, 20.0);
    let friction = StageFriction { ring: 0.0, output: 0.1, pin_over_roller: 1.0, bearing: 0.0 };
    let mut drive = HeldDrive::new(stage.joints().unwrap(), 20.0, 1.0).with_friction(0.4, &[friction], 1e-3);
    drive.hold_input(0.4, 0.5);
    let velocity: Vec<f64> = drive.nominal_velocity_at(0.4, 0.5);
    let at = |velocity: &[f64]| {
        let (mut force, mut tangent) = (vec![0.0; place.len()], drive.linearisation());
        drive.evaluate(0.0, &place, velocity, &mut force, &mut tangent);
        (force, tangent)
    };
    let tangent = at(&velocity).1;
    for column in 0..place.len() {
        let step = 1e-5 * drive.scale()[column] / ARCMIN;
        let [ahead, behind] = [step, -step].map(|step| {
            let mut moved = velocity.clone();
            moved[column] += step;
            at(&moved).0
        });
        for row in 0..place.len() {
            let slope = (behind[row] - ahead[row]) / (2.0 * step);
            let known = tangent.damping(row, column);
            let size = (tangent.damping(row, row) * tangent.damping(column, column)).sqrt();
            assert!((slope - known).abs() <= 1e-4 * size + 1e-6, "{row} {column}: {slope} {known} {size}");
        }
    }
}
