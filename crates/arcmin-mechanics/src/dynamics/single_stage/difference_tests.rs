//! Single stages with a tooth difference of 2: kinematics, forces, play, work.

use std::f64::consts::PI;

use super::tests::{everything, stage};
use super::*;
use crate::contact::{DiscPose, DiscVelocity};
use crate::dynamics::eccentrics::tests::{differences, rest, work_in_is_work_out};
use crate::geometry::{Profile, Relief, Vec2, unit};
use crate::machine::{GapChain, StageErrors};
use crate::units::UM;

/// The stage of the other tests with this number of pins on the same circle and a tooth difference of 2.
fn of_two(pins: usize, k1: f64) -> SingleStage {
    let mut stage = stage();
    let eccentricity = k1 * 2.0 * 0.04 / pins as f64;
    stage.profile = Profile::new(pins, 0.04, eccentricity, 2e-3).with_teeth(2, None).unwrap();
    stage.ring_pin_radius = 2e-3;
    stage
}

/// A stage with an even number of lobes and an integer ratio, and one with an odd number.
fn stages() -> [SingleStage; 2] {
    [of_two(22, 0.6), of_two(31, 0.7)]
}

/// Whether a pin touches the usable flank of a nominal drive.
fn touches(stage: &SingleStage, meshing_angle: f64) -> bool {
    meshing_angle.abs() < stage.profile.last_meshing_angle()
}

/// The ratio is i = −z_c/m, or z_p/m with a driven housing: then in nominal position every pin at a usable
/// flank touches it and no other pin penetrates the disc.
#[test]
fn the_ratio_is_that_at_which_all_pins_mesh() {
    for stage in stages() {
        let (lobes, pins) = (stage.profile.lobe_count() as f64, stage.profile.pin_count as f64);
        assert_eq!(stage.ratio(), -lobes / 2.0);
        for (joints, ratio) in
            [(stage.joints().unwrap(), -lobes / 2.0), (stage.driven_housing(None).unwrap(), pins / 2.0)]
        {
            let (mut touching, mut off) = (0, 0);
            for step in 0..200 {
                let angle = 0.77 * step as f64;
                let nominal = joints.nominal_position_at(angle);
                assert!((nominal[joints.output_index()] - angle / ratio).abs() < 1e-11);
                for contact in joints.pin_contacts(0, &nominal) {
                    // At contact the meshing angle is the angle from the eccentric to the pin.
                    let pin = 2.0 * PI * contact.pin as f64 / pins;
                    let from = crate::units::wrap_angle(match ratio > 0.0 {
                        true => pin + angle / ratio - angle,
                        false => pin - angle,
                    });
                    if from.abs() < stage.profile.last_meshing_angle() - 1e-9 {
                        assert!(contact.gap.abs() < 1e-11, "{contact:?}");
                        assert!((contact.meshing_angle - from).abs() < 1e-6, "{from} {contact:?}");
                        touching += 1;
                    } else {
                        assert!(contact.gap > -1e-11, "{contact:?}");
                        off += 1;
                    }
                }
            }
            let share = touching as f64 / (touching + off) as f64;
            assert!((share - stage.profile.last_meshing_angle() / PI).abs() < 0.01, "{share}");
        }
    }
}

/// Equal springs: the force of every pin on the loaded side is T l/Σ l² over the usable flank; the largest one
/// is 4 T/(K₁ z_c R) times the crowding factor, as a mean over positions; the force perpendicular to the
/// eccentric is T m/(e z_c), and the bearing force is its closed form.
#[test]
fn forces_are_the_closed_forms() {
    for stage in stages() {
        let mut joints = stage.joints().unwrap();
        // A torque so small that only pins next to the end of a flank are loaded among those beyond it.
        let torque = 0.05;
        let (positions, pitch) = (48, TAU / stage.profile.pin_count as f64);
        let (mut squares, mut eccentric) = (0.0, 0.0);
        for step in 0..positions {
            // Over a pitch of the ring, and of the output pins.
            let angle = 0.011 + pitch * (step as f64 / positions as f64 + 7.0 * step as f64);
            let q = rest(&mut joints, angle, torque);
            let ring = joints.pin_contacts(0, &q);
            let sum = |of: &dyn Fn(f64) -> f64| -> f64 {
                let usable = ring.iter().filter(|c| c.force > 0.0);
                usable.map(|c| of(stage.profile.lever_arm(c.meshing_angle).abs())).sum()
            };
            let all = sum(&|lever| lever * lever);
            squares += all / positions as f64;
            let near_end = ring.iter().any(|c| {
                (c.meshing_angle.abs() - stage.profile.last_meshing_angle()).abs() < 0.02 && c.gap < 3e-8
            });
            let bears = |lever: f64| torque * lever.abs() / all;
            for contact in ring.iter().filter(|c| c.force > 0.0) {
                assert!(touches(&stage, contact.meshing_angle) || near_end);
                let closed = bears(stage.profile.lever_arm(contact.meshing_angle));
                let most = bears(stage.profile.largest_lever_arm());
                assert!(
                    near_end || (contact.force - closed).abs() < 0.01 * most,
                    "{angle} {contact:?} {closed}"
                );
            }
            let e = unit(angle);
            let force: Vec2 = ring.iter().map(|c| c.force * Vec2::new(c.gradient[0], c.gradient[1])).sum();
            let across = (e.x * force.y - e.y * force.x).abs();
            let closed = torque * 2.0 / (stage.profile.eccentricity * stage.profile.lobe_count() as f64);
            assert!((across / closed - 1.0).abs() < 2e-3, "{angle}: {across} {closed}");
            eccentric += joints.eccentric_force(0, &q) / positions as f64;
        }
        let lever = stage.profile.largest_lever_arm();
        let closed = torque * lever / squares;
        assert!(
            (stage.ring_force(torque) / closed - 1.0).abs() < 0.03,
            "{} {closed}",
            stage.ring_force(torque)
        );
        let plain = 4.0 * torque
            / (stage.profile.short_width_coefficient() * stage.profile.lobe_count() as f64 * 0.04);
        assert!((stage.ring_force(torque) / plain / stage.profile.crowding() - 1.0).abs() < 1e-12);
        assert!((eccentric / stage.eccentric_force(torque) - 1.0).abs() < 0.02, "{eccentric}");
    }
}

/// Play 2 Δ m/(e z_c) of the ring and 2 c m/(e z_c) of the bearing, compared with static equilibria and with
/// the rotation of a disc about its centre until a gap closes; the chain of gaps compared with static
/// equilibria, with and without errors.
#[test]
fn play_is_that_of_gaps_and_of_states_of_rest() {
    let play = |stage: &SingleStage, angle: f64| {
        let mut joints = stage.joints().unwrap();
        let ends = [1e-4, -1e-4].map(|torque| {
            let q = rest(&mut joints, angle, torque);
            joints.output_error(&q)
        });
        ends[1] - ends[0]
    };
    for nominal in stages() {
        let lever = nominal.profile.eccentricity * nominal.profile.lobe_count() as f64 / 2.0;
        let depth = 20.0 * UM;
        let ring = SingleStage {
            mesh: crate::machine::RingMesh { relief: Relief::uniform(depth), ..nominal.mesh.clone() },
            ..nominal.clone()
        };
        assert!((ring.play_chain().ring / (2.0 * depth / lever) - 1.0).abs() < 1e-4);
        let mut bearing = nominal.clone();
        bearing.eccentric.clearance = 40.0 * UM;
        let mut least = f64::INFINITY;
        for step in 0..12 {
            let angle = 0.05 + TAU * step as f64 / 12.0 + 0.013 * step as f64;
            let by_bearing = play(&bearing, angle);
            assert!((by_bearing / (40.0 * UM / lever) - 1.0).abs() < 0.02, "{by_bearing}");
            let by_ring = play(&ring, angle);
            // Rotated about its held centre until a gap closes.
            let joints = ring.joints().unwrap();
            let contacts = &joints.rings[0].contacts;
            let gap = |turn: f64| {
                let pose = DiscPose {
                    centre: ring.profile.eccentricity * unit(angle),
                    angle: -angle / ring.profile.lobes_per_turn() + turn,
                };
                let all = contacts.contacts(pose, DiscVelocity::REST);
                all.iter().map(|contact| contact.gap).fold(f64::INFINITY, f64::min)
            };
            let free = [1.0, -1.0].map(|side| {
                let (mut low, mut high) = (0.0, 4.0 * depth / lever);
                assert!(gap(0.0) > 0.0 && gap(side * high) < 0.0);
                for _ in 0..40 {
                    let middle = 0.5 * (low + high);
                    if gap(side * middle) > 0.0 { low = middle } else { high = middle }
                }
                low
            });
            let turned = free[0] + free[1];
            assert!((turned / by_ring - 1.0).abs() < 0.02, "{angle}: {turned} {by_ring}");
            least = least.min(turned);
            let chain = GapChain::at(&ring, &[angle]).least(&[StageErrors::default()]).unwrap();
            assert!((chain / by_ring - 1.0).abs() < 0.02, "{angle}: {chain} {by_ring}");
        }
        assert!((least / (2.0 * depth / lever) - 1.0).abs() < 0.02, "{least}");
        let mut all = ring.clone();
        all.eccentric.clearance = 15.0 * UM;
        all.output_pins.hole_clearance = 20.0 * UM;
        for seed in 1..6 {
            let errors =
                StageErrors::draw(&[(all.part_counts(), everything(4.0 * UM))], seed, None).swap_remove(0);
            let made = SingleStage { errors: errors.clone(), ..all.clone() };
            for angle in [0.3, 2.0, 41.0] {
                let found = play(&made, angle);
                let chain = GapChain::at(&all, &[angle]).least(std::slice::from_ref(&errors)).unwrap();
                assert!((chain / found - 1.0).abs() < 0.03, "{seed} {angle}: {chain} {found}");
            }
        }
    }
}

#[test]
fn work_in_is_work_out_of_either_member() {
    for stage in stages() {
        work_in_is_work_out(stage.joints().unwrap(), 10.0);
        work_in_is_work_out(stage.driven_housing(None).unwrap(), 10.0);
    }
}

/// A drive mirrored together with its torque has the same forces.
#[test]
fn a_mirrored_drive_has_the_same_forces() {
    for mut stage in stages() {
        stage.relief = Relief::uniform(10.0 * UM);
        stage.eccentric.clearance = 10.0 * UM;
        let mut joints = stage.joints().unwrap();
        for step in 0..10 {
            let angle = 0.1 + 0.61 * step as f64;
            let mut forces = [1.0, -1.0].map(|side| {
                let q = rest(&mut joints, side * angle, side * 12.0);
                let mut forces: Vec<f64> =
                    joints.pin_contacts(0, &q).iter().map(|contact| contact.force).collect();
                forces.sort_by(f64::total_cmp);
                forces
            });
            let [one, other] = &mut forces;
            let most = one[one.len() - 1];
            assert!(one.iter().zip(other.iter()).all(|(a, b)| (a - b).abs() < 1e-6 * most), "{angle}");
        }
    }
}

/// Forces are gradients of the energy and have their exact tangent, also for a pin on the corner of a tip.
#[test]
fn forces_derive_from_an_energy() {
    let mut stage = of_two(22, 0.6);
    stage.eccentric.roller_length = 8e-3;
    stage.eccentric.roller_count = 14;
    (stage.input_support, stage.output_support) = (1e9, 1e9);
    let mut joints = stage.joints().unwrap();
    let mut corners = 0;
    for step in 0..24 {
        let angle = 0.9 + TAU / 22.0 * step as f64 / 24.0;
        // A torque so large that pins beyond the end of the flank press on its corner.
        let q = rest(&mut joints, angle, 60.0);
        let pressed = joints.pin_contacts(0, &q);
        let at_corner = pressed.iter().filter(|contact| {
            contact.force > 0.0 && contact.meshing_angle.abs() > stage.profile.last_meshing_angle() - 1e-9
        });
        let here = at_corner.count();
        corners += here;
        if here == 0 && step % 6 > 0 {
            continue;
        }
        let found = differences(&joints, &q, 60.0);
        assert!(found.work < 1e-6 && found.tangent < 1e-4, "{angle}: {} {}", found.work, found.tangent);
    }
    assert!(corners > 0, "no pin pressed on a corner");
}
