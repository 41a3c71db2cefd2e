use super::*;
use crate::geometry::turned;
use crate::units::{ARCMIN, UM, wrap_angle};

fn machine() -> crate::machine::Machine {
    crate::templates::tao2024()
}

fn worn(phi: f64) -> f64 {
    12.0 * UM * (0.5 - 0.5 * (2.0 * phi).cos())
}

#[test]
fn nominal_pose_touches_every_pin_with_zero_gap() {
    let machine = machine();
    let contacts = machine.pin_contacts(&Relief::uniform(0.0));
    let kinematics = machine.kinematics();
    for disc in 0..2 {
        for step in 0..50 {
            let crank = 0.3 + 0.1 * step as f64;
            let pose = kinematics.disc_pose(disc, crank, kinematics.nominal_output_angle(crank));
            for contact in contacts.contacts(pose, DiscVelocity::REST) {
                assert!(contact.gap.abs() < 1e-15);
                let eccentric = crank + kinematics.phases[disc];
                let expected = std::f64::consts::TAU * contact.pin as f64 / 40.0 - eccentric;
                assert!(wrap_angle(contact.meshing_angle - expected).abs() < 1e-7);
            }
        }
    }
}

#[test]
fn pins_at_positive_meshing_angle_push_the_disc_clockwise() {
    let machine = machine();
    let contacts = machine.pin_contacts(&Relief::uniform(0.0));
    let pose = machine.kinematics().disc_pose(0, 0.0, 5e-5);
    contacts.visit(pose, DiscVelocity::REST, false, |contact| {
        if contact.force > 0.0 {
            assert!(contact.gradient[2] * contact.meshing_angle < 0.0);
        }
    });
}

/// Exact where reactions include the change of R_eq as the foot moves; without it, 0.3 % of the stiffness of the line
/// contact is missing. The ramp of the damping is compared at constant curvature.
#[test]
fn stiffness_is_the_derivative_of_the_force() {
    use crate::contact::ContactLaw;
    let damping = Some(Damping { coefficient: 2e3, ramp_depth: 1e-6 });
    check_tangent(ContactLaw::Linear { stiffness: 2.85e8 }, damping, false, 2e-6);
    check_tangent(ContactLaw::LineHertz, damping, false, 5e-3);
    check_tangent(ContactLaw::LineHertz, None, true, 1e-6);
    check_tangent(ContactLaw::Tao2024, None, true, 1e-6);
}

fn check_tangent(
    law: crate::contact::ContactLaw,
    damping: Option<Damping>,
    is_conservative: bool,
    tolerance: f64,
) {
    let machine = crate::machine::Machine { contact_law: law, ..machine() };
    let mut line = machine.line_contact();
    line.damping = damping;
    let mut contacts = PinContacts::new(machine.profile(), machine.pins(), Relief::uniform(0.0), line);
    contacts.set_conservative(is_conservative);
    let kinematics = machine.kinematics();
    let base = kinematics.disc_pose(0, 1.234, kinematics.nominal_output_angle(1.234) - 0.1 * ARCMIN);
    let velocity = DiscVelocity { centre: Vec2::new(1e-4, -2e-4), angle: 3e-3 };
    let shifted = |axis: usize, h: f64| {
        let mut pose = base;
        match axis {
            0 => pose.centre.x += h,
            1 => pose.centre.y += h,
            _ => pose.angle += h / 0.05,
        }
        contacts.react(pose, velocity).force
    };
    let reaction = contacts.react(base, velocity);
    let size = reaction.stiffness[0][0].abs();
    for axis in 0..3 {
        let h = 1e-10;
        let (a, b) = (shifted(axis, -h), shifted(axis, h));
        let scale = if axis == 2 { 1.0 / 0.05 } else { 1.0 };
        for row in 0..3 {
            let difference = -(b[row] - a[row]) / (2.0 * h);
            let tangent = reaction.stiffness[row][axis] * scale;
            assert!((difference - tangent).abs() < tolerance * size, "{row} {axis}: {difference} {tangent}");
        }
    }
}

/// Newton's closest point against the exact distance of the pin centre from the worn flank, by golden
/// section.
#[test]
fn gap_on_an_unevenly_worn_flank_agrees_with_the_exact_distance() {
    let machine = machine();
    let relief = Relief::from_samples(Relief::grid(720).map(worn).collect());
    let contacts = machine.pin_contacts(&relief);
    let profile = machine.profile();
    let kinematics = machine.kinematics();
    let pose = kinematics.disc_pose(0, 0.4, kinematics.nominal_output_angle(0.4) - 0.2 * ARCMIN);
    let surface = |tau: f64| {
        let normal = profile.outward_normal(tau);
        profile.flank_point(tau) - relief.at(profile.meshing_angle(tau)).depth * normal
    };
    let back = unit(-pose.angle);
    let mut worst: f64 = 0.0;
    for contact in contacts.contacts(pose, DiscVelocity::REST) {
        let p = turned(contact.arm, back);
        let distance = |tau: f64| (p - surface(tau)).norm();
        let (mut a, mut b) = (contact.tau - 2e-3, contact.tau + 2e-3);
        for _ in 0..200 {
            let (c, d) = (b - 0.618_034 * (b - a), a + 0.618_034 * (b - a));
            if distance(c) < distance(d) { b = d } else { a = c }
        }
        let exact = distance(0.5 * (a + b)) - 3e-3;
        worst = worst.max((contact.gap - exact).abs());
    }
    assert!(worst < 1e-13, "{worst:e}");
}

/// New, evenly, unevenly and wavily worn flanks, with and without flank errors, of the shipped and of random
/// machines, and flanks with the shape of a pin. The discs are in nominal position and displaced by 30 µm, so
/// that pins touch, nearly touch and are clear; at rest and in motion (without damping).
#[test]
fn culling_keeps_all_loaded_pins() {
    use crate::geometry::{FlankDirection, FlankHarmonic};
    let wavy = |phi: f64| worn(phi) + 0.3 * UM * (40.0 * phi).sin();
    let depths = |depth: &dyn Fn(f64) -> f64| Relief::from_samples(Relief::grid(720).map(depth).collect());
    let reliefs = [Relief::uniform(0.0), Relief::uniform(10.0 * UM), depths(&worn), depths(&wavy)];
    let harmonic = |order, direction| FlankHarmonic { order, amplitude: 4.0 * UM, phase: 0.3, direction };
    let errors = FlankError {
        harmonics: vec![harmonic(1, FlankDirection::Inwards), harmonic(37, FlankDirection::Normal)],
        measured: None,
    };
    let (mut carried, mut passed_over) = (0, 0);
    let moving = DiscVelocity { centre: Vec2::new(0.03, -0.02), angle: 7.0 };
    let shipped = [machine(), crate::templates::design("rv-80e").unwrap().machine()];
    let random = (1..=6).map(|seed| crate::random_designs::sound_design(seed).0.machine());
    for machine in shipped.into_iter().chain(random) {
        let kinematics = machine.kinematics();
        let bedded = machine.profile().bedded(0.5, 40.0 * UM, 0.01);
        let reliefs = reliefs.iter().chain([&bedded]);
        for (relief, errors) in reliefs.flat_map(|r| [(r, FlankError::default()), (r, errors.clone())]) {
            let mut contacts = machine.pin_contacts(relief);
            contacts.set_flank_error(errors);
            for step in 0..800 {
                let off = if step < 400 { 0.0 } else { 30.0 * UM };
                let velocity = if step % 2 == 0 { DiscVelocity::REST } else { moving };
                let step = f64::from(step % 400);
                let crank = 0.011 * step;
                let turn = (step * 0.7).sin() * ARCMIN;
                let mut pose = kinematics.disc_pose(0, crank, kinematics.nominal_output_angle(crank) + turn);
                pose.centre += off * crate::geometry::unit(1.3 * step);
                let all = contacts.contacts(pose, DiscVelocity::REST);
                let mut seen = vec![false; all.len()];
                let mut culled = 0.0;
                contacts.visit(pose, velocity, false, |c| {
                    assert_eq!(c.force, all[c.pin].force);
                    seen[c.pin] = true;
                    culled += c.force;
                });
                assert_eq!(all.iter().map(|c| c.force).sum::<f64>(), culled);
                for (contact, seen) in all.iter().zip(seen) {
                    assert!(seen || contact.gap > 0.0, "{contact:?}");
                    carried += usize::from(contact.force > 0.0);
                    passed_over += usize::from(!seen);
                }
            }
        }
    }
    assert!(carried > 10_000 && passed_over > 10_000, "{carried} {passed_over}");
}

/// The same for flanks that end at their tips, new and worn, in single stages with a tooth difference of 2 and one of 1.
#[test]
fn culling_keeps_all_loaded_pins_near_a_tip() {
    let flanks = [
        Profile::new(22, 40e-3, 1.1e-3, 2.5e-3).with_teeth(2, None),
        Profile::new(21, 40e-3, 2.6e-3, 1.5e-3).with_teeth(2, None),
        Profile::new(42, 60e-3, 2.1e-3, 1.5e-3).with_teeth(2, None),
        Profile::new(12, 30e-3, 2.5e-3, 3e-3).with_teeth(2, None),
        Profile::new(20, 17e-3, 0.425e-3, 1.5e-3).with_teeth(1, Some(15.6e-3)),
    ];
    let worn = Relief::from_samples(Relief::grid(720).map(worn).collect());
    let (mut carried, mut passed_over) = (0, 0);
    for profile in flanks.map(Result::unwrap) {
        for (relief, thinner) in [
            (Relief::uniform(0.0), 0.0),
            (Relief::uniform(10.0 * UM), 0.0),
            (worn.clone(), 0.0),
            (Relief::uniform(0.0), 8.0 * UM),
        ] {
            let pin = |i: usize| Pin {
                centre: profile.pin_circle_radius
                    * unit(std::f64::consts::TAU * i as f64 / profile.pin_count as f64),
                radius: profile.pin_radius - thinner,
            };
            let pins = (0..profile.pin_count).map(pin).collect();
            let contacts = PinContacts::new(profile.clone(), pins, relief, machine().line_contact());
            for step in 0..1200 {
                let way = step as f64;
                let crank = 0.037 * way;
                let off = [0.0, 10.0 * UM, 100.0 * UM][step % 3] * unit(1.3 * way);
                let turn = [1.0, 10.0][step % 2] * (0.7 * way).sin() * ARCMIN;
                let pose = DiscPose {
                    centre: profile.eccentricity * unit(crank) + off,
                    angle: turn - crank / profile.lobes_per_turn(),
                };
                let all = contacts.contacts(pose, DiscVelocity::REST);
                let mut seen = vec![false; all.len()];
                contacts.visit(pose, DiscVelocity::REST, false, |c| {
                    assert_eq!(c.force, all[c.pin].force);
                    seen[c.pin] = true;
                });
                for (contact, seen) in all.iter().zip(seen) {
                    assert!(seen || contact.gap > 0.0, "{step} {contact:?}");
                    carried += usize::from(contact.force > 0.0);
                    passed_over += usize::from(!seen);
                }
            }
        }
    }
    println!("{carried} carried, {passed_over} passed over");
    assert!(carried > 10_000 && passed_over > 10_000, "{carried} {passed_over}");
}

/// A pin worn in fine waves, w = A cos(100 ψ): the second derivative of the gap is that of the waves times the square
/// of the normal's rotation, within the contribution of the waves' slope as this rotation changes.
#[test]
fn second_derivative_of_the_gap_includes_wear_of_the_pin() {
    let machine = machine();
    let kinematics = machine.kinematics();
    let mut contacts = machine.pin_contacts(&Relief::uniform(0.0));
    let waves = Relief::grid(7200).map(|psi| 1e-7 * (1.0 + (100.0 * psi).cos())).collect();
    contacts.set_pin_relief(Relief::from_samples(waves));
    let motion = Vec2::new(0.04, -0.03);
    let at = |x: f64| {
        let mut pose = kinematics.disc_pose(0, 0.3, kinematics.nominal_output_angle(0.3) - 5e-5);
        pose.centre += x * motion;
        pose.angle += x;
        contacts.contacts(pose, DiscVelocity::REST)
    };
    let h = 1e-5;
    let (before, here, after) = (at(-h), at(0.0), at(h));
    let mut largest = 0.0_f64;
    let mut misses = Vec::new();
    for ((a, m), b) in before.iter().zip(&here).zip(&after) {
        if m.meshing_angle.abs() < 0.4 {
            continue;
        }
        let turn_of = |c: &PinContact| c.pin_turn[0] * motion.x + c.pin_turn[1] * motion.y + c.pin_turn[2];
        let turn = turn_of(m);
        let by_slope = 1e-5 * ((turn_of(b) - turn_of(a)) / (2.0 * h)).abs();
        let difference = (b.gap - 2.0 * m.gap + a.gap) / (h * h);
        let bend = m.gap_bend(3e-3, motion);
        let waves = 1e-3 * turn * turn;
        if !((difference - bend).abs() < 0.05 * waves + 1.1 * by_slope + 5e-3) {
            misses.push((m.meshing_angle, difference, bend, waves, by_slope));
        }
        largest = largest.max(m.pin_bend.abs() * turn * turn);
    }
    assert!(misses.is_empty(), "{misses:?}");
    assert!(largest > 0.1, "{largest}");
}

/// Derivatives for Newton's method and the rolling force: along a motion of the disc the gap changes by the gradient
/// and `gap_bend`, the curvature of the contact law by `relative_curvature_change`, on evenly and unevenly worn
/// flanks.
#[test]
fn gap_and_curvature_follow_a_motion_of_the_disc() {
    let machine = machine();
    let kinematics = machine.kinematics();
    for relief in [Relief::uniform(10.0 * UM), Relief::from_samples(Relief::grid(720).map(worn).collect())] {
        let contacts = machine.pin_contacts(&relief);
        let motion = Vec2::new(0.04, -0.03);
        let at = |x: f64| {
            let mut pose = kinematics.disc_pose(0, 0.3, kinematics.nominal_output_angle(0.3) - 5e-5);
            pose.centre += x * motion;
            pose.angle += x;
            contacts.contacts(pose, DiscVelocity::REST)
        };
        let h = 1e-6;
        let (before, here, after) = (at(-h), at(0.0), at(h));
        for ((a, m), b) in before.iter().zip(&here).zip(&after) {
            // At the root itself the curvature of the flank changes within micrometres.
            if m.meshing_angle.abs() < 0.2 {
                continue;
            }
            let bend = m.gap_bend(3e-3, motion);
            let slope = m.gradient[0] * motion.x + m.gradient[1] * motion.y + m.gradient[2];
            assert!(
                ((b.gap - a.gap) / (2.0 * h) - slope).abs() < 1e-8,
                "{}: {} {slope}",
                m.meshing_angle,
                (b.gap - a.gap) / (2.0 * h)
            );
            let difference = (b.gap - 2.0 * m.gap + a.gap) / (h * h);
            assert!(
                (difference - bend).abs() < 1e-3 * bend.abs() + 1e-4,
                "{}: {difference} {bend}",
                m.meshing_angle
            );
            let curvature_slope = contacts.rolling(m).relative_curvature_change(m, [motion.x, motion.y, 1.0]);
            let difference = (b.designed_curvature - a.designed_curvature) / (2.0 * h);
            assert!(
                (difference - curvature_slope).abs()
                    < 1e-3 * curvature_slope.abs() + 1e-2 * m.designed_curvature,
                "{}: {difference} {curvature_slope}",
                m.meshing_angle
            );
        }
    }
}

/// The forces of conservative contacts are minus the gradient of the stored energy, on every kind of flank
/// and pin.
#[test]
fn forces_are_the_gradient_of_the_stored_energy() {
    use crate::geometry::{FlankDirection, FlankError, FlankHarmonic};
    let machine = machine();
    let uneven =
        Relief::from_samples(Relief::grid(720).map(|phi| worn(phi) + 2.0 * UM * (3.0 * phi).sin()).collect());
    let pin =
        Relief::from_samples(Relief::grid(180).map(|psi| 3.0 * UM * (1.0 + (2.0 * psi).cos())).collect());
    let error = FlankError {
        harmonics: vec![FlankHarmonic {
            order: 39,
            amplitude: 2.0 * UM,
            phase: 0.3,
            direction: FlankDirection::Normal,
        }],
        measured: None,
    };
    let kinematics = machine.kinematics();
    let mut rolling_share: f64 = 0.0;
    for relief in [Relief::uniform(8.0 * UM), uneven] {
        for (pin, error) in [(None, None), (Some(&pin), None), (None, Some(&error))] {
            let mut contacts =
                PinContacts::new(machine.profile(), machine.pins(), relief.clone(), machine.line_contact());
            pin.into_iter().for_each(|pin| contacts.set_pin_relief(pin.clone()));
            error.into_iter().for_each(|error| contacts.set_flank_error(error.clone()));
            let plain = contacts.clone();
            contacts.set_conservative(true);
            for crank in [0.4, 1.234, 2.9] {
                // An approach of some micrometres.
                let lag = 0.9 * ARCMIN;
                let base = kinematics.disc_pose(0, crank, kinematics.nominal_output_angle(crank) - lag);
                let shifted = |axis: usize, h: f64| {
                    let mut pose = base;
                    match axis {
                        0 => pose.centre.x += h,
                        1 => pose.centre.y += h,
                        _ => pose.angle += h / 0.05,
                    }
                    contacts.react(pose, DiscVelocity::REST).stored
                };
                let (exact, normal) =
                    (contacts.react(base, DiscVelocity::REST), plain.react(base, DiscVelocity::REST));
                let size = exact.force[0].hypot(exact.force[1]);
                assert!(size > 100.0, "{size}");
                for axis in 0..3 {
                    let h = 2e-9;
                    let slope = -(8.0 * (shifted(axis, h) - shifted(axis, -h)) - shifted(axis, 2.0 * h)
                        + shifted(axis, -2.0 * h))
                        / (12.0 * h);
                    let unit = if axis == 2 { 0.05 } else { 1.0 };
                    // The curvature of an uneven flank or pin is not smooth at the samples of its depth; flank errors
                    // enter in first order of their slopes only.
                    let tolerance = if relief.is_uniform() && pin.is_none() { 1e-8 } else { 1e-6 };
                    assert!(
                        (slope - exact.force[axis] / unit).abs() < tolerance * size,
                        "{axis}: {slope} {} of {size}",
                        exact.force[axis] / unit
                    );
                    rolling_share =
                        rolling_share.max(((normal.force[axis] - exact.force[axis]) / unit).abs() / size);
                }
            }
        }
    }
    // The contribution is significant: normal forces alone are not the gradient.
    assert!(rolling_share > 1e-4, "{rolling_share}");
}

/// Chords deviate from the flank by s²/(8 ρ), contact with nodes from contact with the flank by s²/(8 R_eq): both
/// vanish with the square of the element size. At concave places chords reduce the gap, at convex ones they increase
/// it; between nodes every gap is larger.
#[test]
fn meshed_flanks_converge_with_the_square_of_the_element_size() {
    let machine = machine();
    let kinematics = machine.kinematics();
    let arc = crate::fem::boundary::FlankArc::new(&machine.profile());
    let smooth = machine.pin_contacts(&Relief::uniform(10.0 * UM));
    let deviations = |kind: MeshContact, per_lobe: usize| {
        let mut meshed = smooth.clone();
        meshed.set_facets(kind, arc.nodes(per_lobe));
        let (mut closest, mut farthest) = (0.0_f64, 0.0_f64);
        for step in 0..200 {
            let crank = 0.0173 * step as f64;
            let pose = kinematics.disc_pose(0, crank, kinematics.nominal_output_angle(crank) - 0.3 * ARCMIN);
            for (a, b) in meshed
                .contacts(pose, DiscVelocity::REST)
                .iter()
                .zip(smooth.contacts(pose, DiscVelocity::REST))
            {
                closest = closest.min(a.gap - b.gap);
                farthest = farthest.max(a.gap - b.gap);
            }
        }
        (closest, farthest)
    };
    for kind in [MeshContact::Edges, MeshContact::Nodes] {
        let (coarse, fine) = (deviations(kind, 40), deviations(kind, 80));
        assert!((farthest_order(coarse.1, fine.1) - 2.0).abs() < 0.3, "{kind:?} {coarse:?} {fine:?}");
        match kind {
            MeshContact::Edges => {
                assert!((farthest_order(coarse.0, fine.0) - 2.0).abs() < 0.3, "{coarse:?} {fine:?}")
            }
            MeshContact::Nodes => assert!(coarse.0 > -1e-12 && fine.0 > -1e-12, "{coarse:?} {fine:?}"),
        }
        let edge = arc.lobe_length() / 40.0;
        let sharpest = match kind {
            MeshContact::Edges => 1.0 / 1.6117e-3,
            MeshContact::Nodes => 1.0 / 1.6117e-3 + 1.0 / 3e-3,
        };
        let sag = edge * edge * sharpest / 8.0;
        assert!(coarse.1 < 1.1 * sag && coarse.1 > 0.7 * sag, "{kind:?} {} {sag}", coarse.1);
    }
}

fn farthest_order(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).log2()
}
