//! Closed forms of drives of two rings: kinematics, forces, play, work.

use std::f64::consts::TAU;

use super::*;
use crate::contact::{ContactLaw, LineContact};
use crate::dynamics::eccentrics::tests::{self, rest};
use crate::dynamics::single_stage::tests::everything;
use crate::geometry::{Profile, Relief};
use crate::machine::{
    GapChain, PinMounting, RingMesh, RollerBearing, RollerKind, StageErrors, StageFriction,
};
use crate::units::UM;

fn mesh(pin_count: usize, pin_circle_radius: f64) -> RingMesh {
    let profile = Profile::new(pin_count, pin_circle_radius, 1.2e-3, 2.5e-3);
    let steel = crate::templates::tao2024().disc.material;
    let law = ContactLaw::Linear { stiffness: 5e7 };
    RingMesh {
        contact: LineContact::new(law, &steel, &steel, 8e-3, profile.pin_radius),
        ring_circle_radius: pin_circle_radius,
        ring_pin_radius: profile.pin_radius,
        profile,
        relief: Relief::uniform(0.0),
        mounting: PinMounting::Fixed,
    }
}

/// A stepped disc of 19 and 18 lobes, 361 : 1; all parts except the rings' pins are stiff.
fn drive() -> TwoRing {
    TwoRing {
        meshes: [mesh(20, 0.04), mesh(19, 0.038)],
        widths: [8e-3; 2],
        phases: vec![0.0],
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
        openings: Vec::new(),
        input_support: 1e13,
        output_support: 1e13,
        disc: (0.2, 1e-4),
        errors: Default::default(),
    }
}

/// Every pin of both rings touches every flank in nominal position, for any numbers of teeth and discs, only at
/// the closed-form ratio.
#[test]
fn both_rings_mesh_at_the_closed_form_ratio() {
    for (pins, ratio) in
        [([20, 19], 361.0), ([20, 21], -399.0), ([15, 14], 196.0), ([22, 20], 210.0), ([13, 24], -26.181_818)]
    {
        for discs in 1..4 {
            let phases = (0..discs).map(|j| TAU * j as f64 / discs as f64).collect();
            let drive =
                TwoRing { meshes: pins.map(|pins| mesh(pins, 2e-3 * pins as f64)), phases, ..drive() };
            assert!((drive.ratio() / ratio - 1.0).abs() < 1e-6, "{}", drive.ratio());
            let joints = drive.joints().unwrap();
            for angle in [0.0, 1.0, 40.0] {
                let nominal = joints.nominal_position_at(angle);
                assert!((nominal[joints.output_index()] - angle / drive.ratio()).abs() < 1e-12);
                for ring in 0..2 * discs {
                    for contact in joints.pin_contacts(ring, &nominal) {
                        assert!(contact.gap.abs() < 1e-11, "{pins:?} {discs} {ring} {contact:?}");
                    }
                }
            }
        }
    }
}

/// The same with tooth differences of 2 in one ring or both: every pin at a usable flank touches it, no other
/// pin penetrates the disc.
#[test]
fn rings_of_tooth_difference_two_mesh_at_the_closed_form_ratio() {
    // (z_p, m) of either ring; z_c1 z_p2/(z_c1 m_2 − z_c2 m_1).
    for (teeth, ratio) in [
        ([(22, 2), (20, 2)], 20.0 * 20.0 / (40.0 - 36.0)),
        ([(23, 2), (22, 2)], 21.0 * 22.0 / (42.0 - 40.0)),
        ([(22, 2), (12, 1)], 20.0 * 12.0 / (20.0 - 22.0)),
        ([(12, 1), (21, 2)], 11.0 * 21.0 / (22.0 - 19.0)),
    ] {
        for discs in 1..4 {
            let phases = (0..discs).map(|j| TAU * j as f64 / discs as f64).collect();
            // K1 = 0.6 in both rings of one eccentricity.
            let mesh = |(pins, m): (usize, usize)| {
                let mut mesh = mesh(pins, 2e-3 * pins as f64 / m as f64);
                let pin = if m == 2 { 1.2e-3 } else { 2.5e-3 };
                mesh.profile =
                    Profile::new(pins, mesh.ring_circle_radius, 1.2e-3, pin).with_teeth(m, None).unwrap();
                mesh.ring_pin_radius = pin;
                mesh
            };
            let drive = TwoRing { meshes: teeth.map(mesh), phases, ..drive() };
            assert!((drive.ratio() / ratio - 1.0).abs() < 1e-12, "{}", drive.ratio());
            let joints = drive.joints().unwrap();
            let turns = TAU * drive.turns_to_repeat() as f64;
            assert!(
                (turns / drive.ratio() / TAU)
                    .fract()
                    .abs()
                    .min(1.0 - (turns / drive.ratio() / TAU).fract().abs())
                    < 1e-9
            );
            let mut touching = 0;
            for angle in [0.0, 1.0, 40.0, 7.7, 3.1] {
                let nominal = joints.nominal_position_at(angle);
                for ring in 0..2 * discs {
                    for contact in joints.pin_contacts(ring, &nominal) {
                        assert!(contact.gap > -1e-11, "{teeth:?} {discs} {ring} {contact:?}");
                        touching += usize::from(contact.gap < 1e-11);
                    }
                }
            }
            let [first, second] = drive.meshes.each_ref().map(|mesh| {
                mesh.profile.pin_count as f64 * mesh.profile.last_meshing_angle() / std::f64::consts::PI
            });
            let expected = 5.0 * discs as f64 * (first + second);
            assert!((touching as f64 / expected - 1.0).abs() < 0.1, "{touching} {expected}");
        }
    }
}

/// Forces of pins, of the rings perpendicular to the eccentric and of its bearing agree with the closed forms,
/// and the moments of both rings about the centre of the disc are equal.
#[test]
fn forces_are_the_closed_forms() {
    for pins in [[20, 19], [20, 21], [26, 22]] {
        let drive = TwoRing { meshes: pins.map(|pins| mesh(pins, 2e-3 * pins as f64)), ..drive() };
        let mut joints = drive.joints().unwrap();
        let torque = 20.0;
        let (mut largest, mut mean_bearing) = ([0.0_f64; 2], 0.0);
        let positions = 60;
        for step in 0..positions {
            let angle = 0.37 + TAU * step as f64 / positions as f64;
            let q = rest(&mut joints, angle, torque);
            for (ring, most) in largest.iter_mut().enumerate() {
                let forces = joints.pin_contacts(ring, &q).into_iter().map(|contact| contact.force);
                *most = forces.fold(*most, f64::max);
            }
            mean_bearing += joints.eccentric_force(0, &q) / positions as f64;
        }
        for (found, closed) in largest.into_iter().zip(drive.ring_forces(torque)) {
            assert!((found / closed - 1.0).abs() < 0.02, "{pins:?} {found} {closed}");
        }
        let closed = drive.eccentric_force(torque);
        assert!((mean_bearing / closed - 1.0).abs() < 0.02, "{pins:?} {mean_bearing} {closed}");
        // 4 T/(K₁ z_p R) of the second ring.
        let profile = &drive.meshes[1].profile;
        let direct = 4.0 * torque
            / (profile.short_width_coefficient() * profile.pin_count as f64 * profile.pin_circle_radius);
        assert!((drive.ring_forces(torque)[1] / direct - 1.0).abs() < 1e-12);
    }
}

#[test]
fn work_in_is_work_out() {
    tests::work_in_is_work_out(drive().joints().unwrap(), 20.0);
}

/// The play of each gap alone agrees with its closed form; all gaps together give slightly more than the sum.
#[test]
fn play_is_at_least_the_sum_of_its_parts() {
    let play = |drive: &TwoRing, angle: f64| {
        let mut joints = drive.joints().unwrap();
        // A torque so small that elastic displacements are negligible.
        let ends = [1e-4, -1e-4].map(|torque| {
            let q = rest(&mut joints, angle, torque);
            joints.output_error(&q)
        });
        ends[1] - ends[0]
    };
    let mut all = drive();
    let singles = [0, 1, 2].map(|part| {
        let mut one = drive();
        for drive in [&mut one, &mut all] {
            match part {
                0 | 1 => drive.meshes[part].relief = Relief::uniform(20.0 * UM),
                _ => drive.eccentric.clearance = 40.0 * UM,
            }
        }
        one
    });
    for step in 0..8 {
        let angle = 0.05 + TAU * step as f64 / 8.0;
        for (part, one) in singles.iter().enumerate() {
            let share = play(one, angle) / one.play()[part];
            assert!((0.9999..1.01).contains(&share), "{part} {angle}: {share}");
        }
        let share = play(&all, angle) / all.play().iter().sum::<f64>();
        assert!((0.9999..1.02).contains(&share), "{angle}: {share}");
    }
}

/// Losses from static equilibria without gaps compared with the closed form.
#[test]
fn efficiency_is_the_closed_form() {
    for pins in [[20, 19], [20, 21], [26, 22]] {
        let drive = TwoRing { meshes: pins.map(|pins| mesh(pins, 2e-3 * pins as f64)), ..drive() };
        let friction = StageFriction { ring: 0.05, output: 0.0, pin_over_roller: 1.0, bearing: 0.002 };
        let mut joints = drive.joints().unwrap();
        let (torque, positions) = (20.0, 40);
        let lost: f64 = (0..positions)
            .map(|step| {
                let q = rest(&mut joints, TAU * step as f64 / positions as f64, torque);
                let losses = joints.losses(&q, &[friction; 2]);
                losses.iter().map(|of_ring| of_ring.total()).sum::<f64>() / positions as f64
            })
            .sum();
        let (found, closed) =
            (lost * drive.ratio().abs() / torque, 1.0 / drive.efficiency(torque, &[friction; 2]) - 1.0);
        assert!((found / closed - 1.0).abs() < 0.02, "{pins:?} {found} {closed}");
        assert!(closed > 1.0, "large ratios hold by themselves: {closed}");
    }
}

#[test]
fn drives_that_cannot_be_are_refused() {
    let alike = TwoRing { meshes: [mesh(20, 0.04), mesh(20, 0.038)], ..drive() };
    assert!(alike.joints().unwrap_err().to_string().contains("must differ from the first"));
    let none = TwoRing { phases: Vec::new(), ..drive() };
    assert!(none.joints().unwrap_err().to_string().contains("number of stepped discs"));
}

/// The chain of gaps compared with static equilibria at nearly zero torque, nominal and with every kind of
/// error: one stepped disc, and two with separate pins in the ring at rest; ratios of either sign.
#[test]
fn play_as_made_is_that_of_the_mechanism() {
    for (pins, discs) in [([20, 19], 1), ([20, 21], 2), ([22, 20], 2)] {
        let mut drive = TwoRing {
            meshes: pins.map(|pins| mesh(pins, 2e-3 * pins as f64)),
            phases: (0..discs).map(|j| TAU * j as f64 / discs as f64).collect(),
            ..drive()
        };
        drive.meshes.iter_mut().for_each(|mesh| mesh.relief = Relief::uniform(25.0 * UM));
        drive.eccentric.clearance = 15.0 * UM;
        let [own, other] = drive.part_counts();
        assert_eq!((own.ring_pins, other.ring_pins), (discs * pins[0], pins[1]));
        let drawn = [own, other].map(|counts| (counts, everything(4.0 * UM)));
        for seed in 0..5 {
            let errors = match seed {
                0 => vec![StageErrors::default(); 2],
                _ => StageErrors::draw(&drawn, seed, None),
            };
            let mut made = drive.clone();
            made.set_errors([errors[0].clone(), errors[1].clone()]);
            let mut joints = made.joints().unwrap();
            for angle in [0.3, 2.0, 410.0] {
                let ends = [1e-3, -1e-3].map(|torque| {
                    let q = rest(&mut joints, angle, torque);
                    joints.output_error(&q)
                });
                let found = ends[1] - ends[0];
                let chain = GapChain::of_two_rings_at(&drive, &[angle]).least(&errors).unwrap();
                assert!((chain / found - 1.0).abs() < 0.02, "{pins:?} {seed} {angle}: {chain} {found}");
            }
        }
        // The sum of single gaps is a lower bound of the nominal drive.
        let nominal = GapChain::of_two_rings(&drive).least(&vec![StageErrors::default(); 2]).unwrap();
        let sum: f64 = drive.play().iter().sum();
        assert!(nominal > 0.98 * sum && nominal < 1.3 * sum, "{nominal} {sum}");
    }
}
