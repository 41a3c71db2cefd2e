//! Invariants of geometry, load sharing and wear on random machines, for every law.

use crate::contact::ContactLaw;
use crate::geometry::{Relief, cross, unit};
use crate::machine::{CrankAngle, Machine};
use crate::tribology::WearLaw;
use crate::units::{MM, UM};
use crate::wear::{CoupledOptions, CoupledWear};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Machines of 20 to 60 pins, 30 to 150 mm, with flanks that can be ground, loaded to 10 to 60 N/mm by the
/// handbook's first estimate.
fn machines() -> impl Strategy<Value = Machine> {
    let whole = (10..30usize, 1..=3usize);
    let real = (30.0..150.0f64, 0.5..0.85f64, 0.3..0.7f64, 4.0..30.0f64, 10.0..60.0f64, 0.0..20.0f64);
    (whole, real).prop_map(|((pins, discs), (circle, k1, pin, width, load, offset))| {
        let mut machine = crate::templates::tao2024();
        let pins = 2 * pins;
        machine.ring.pin_count = pins;
        machine.ring.pin_circle_radius = circle * MM;
        machine.crankshafts.eccentricity = k1 * circle * MM / pins as f64;
        machine.disc_count = discs;
        machine.disc.width = width * MM;
        machine.disc.modification.equidistant_offset = offset * UM;
        let sharpest = machine.profile().sharpest_convex_trace().0.abs();
        // There must be clearance between neighbouring pins.
        machine.ring.pin_radius = pin * sharpest.min(2.0 * circle * MM / pins as f64);
        let force = load * 1e3 * machine.disc.width;
        let torque = force * k1 * (pins as f64 - 1.0) * circle * MM / 2.2 * discs as f64 / 2.0;
        machine.rated.torque = torque;
        machine.duty[0].torque = torque;
        machine
    })
}

fn contact_laws() -> [ContactLaw; 5] {
    [
        ContactLaw::LineHertz,
        ContactLaw::Linear { stiffness: 2.85e8 },
        ContactLaw::Palmgren,
        ContactLaw::Tao2024,
        ContactLaw::Impact { stiffness: 1e10, exponent: 1.2 },
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// Tangent, normal and curvature of the flank agree with finite differences of its points, and the
    /// foot-point search recovers the foot of a pin at any penetration.
    #[test]
    fn flanks_agree_with_differences_of_their_points(
        machine in machines(),
        place in 0.0..1.0f64,
        depth in -20.0..20.0f64,
    ) {
        let profile = machine.profile();
        let lobe = TAU / profile.lobe_count() as f64;
        let (tau, h) = (lobe * place, 1e-5 * lobe);
        let point = |steps: f64| profile.flank_point(tau + steps * h);
        let normal = profile.outward_normal(tau);
        let first = (8.0 * (point(1.0) - point(-1.0)) - (point(2.0) - point(-2.0))) / (12.0 * h);
        prop_assert!((normal.norm() - 1.0).abs() < 1e-14);
        prop_assert!(first.dot(&normal).abs() < 1e-7 * first.norm(), "{}", first.dot(&normal));

        // Arc length per meshing angle is |df/dτ|/z_c, and the normal turns by the curvature times that length.
        let cos = profile.meshing_angle(tau).cos();
        let per_angle = profile.flank_length_per_meshing_angle(cos) * profile.lobe_count() as f64;
        prop_assert!((first.norm() / per_angle - 1.0).abs() < 1e-6);
        let turned = profile.outward_normal(tau + h) - profile.outward_normal(tau - h);
        let curvature = -turned.dot(&first.normalize()) / (2.0 * h * per_angle);
        let scale = curvature.abs().max(1.0 / profile.pin_circle_radius);
        prop_assert!((curvature - profile.flank_curvature(cos)).abs() < 1e-6 * scale);

        // For a point on the normal of the trace, closer than the centre of curvature, the foot is the original
        // point.
        let foot = profile.foot(profile.trace(tau) + depth * UM * normal, tau + 0.02 * lobe);
        prop_assert!((foot.tau - tau).abs() < 1e-9, "{} {tau}", foot.tau);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// F(δ) ≥ 0 and increasing, with the energy as its integral, for any radius, seat and machine.
    #[test]
    fn contact_force_rises_and_is_the_gradient_of_the_energy(
        machine in machines(),
        radius in 1e-4..1e-1f64,
        approach in 1e-8..2e-5f64,
        seat in 0.0..2e-8f64,
    ) {
        for contact_law in contact_laws() {
            let contact =
                Machine { contact_law, ..machine.clone() }.line_contact().with_seat_compliance(seat);
            let energy = |approach: f64| contact.energy(approach, contact.force(approach, radius).0, radius);
            let (force, stiffness) = contact.force(approach, radius);
            prop_assert!(force > 0.0 && stiffness > 0.0, "{contact_law:?} {force} {stiffness}");
            prop_assert!(contact.force(1.01 * approach, radius).0 > force, "{contact_law:?}");
            prop_assert_eq!(contact.force(-approach, radius).0, 0.0);
            let h = 1e-4 * approach;
            let slope = (energy(approach + h) - energy(approach - h)) / (2.0 * h);
            prop_assert!((slope / force - 1.0).abs() < 1e-6, "{contact_law:?}: {slope} {force}");
        }
    }

    /// The forces of all pins balance the torque, and none is negative.
    #[test]
    fn pins_balance_the_torque(machine in machines(), place in 0.0..1.0f64, depth in 0.0..20.0f64) {
        for contact_law in contact_laws() {
            let machine = Machine { contact_law, ..machine.clone() };
            let meshing = machine.meshing(&Relief::uniform(depth * UM));
            let k = meshing.kinematics();
            let crank = CrankAngle::from_radians(place * k.pattern_period());
            let sharing = meshing.load_sharing(crank, machine.rated.torque).unwrap();
            let turn = k.crank_per_output_locked();
            let angle = crank.radians() + turn * sharing.output_error.radians();
            let mut work = 0.0;
            for (disc, contacts) in sharing.discs.iter().enumerate() {
                let direction = unit(angle + k.phases[disc] + FRAC_PI_2);
                for contact in contacts {
                    prop_assert!(contact.force >= 0.0);
                    let force = -contact.force * contact.normal;
                    work += cross(contact.arm, force) + turn * k.eccentricity * force.dot(&direction);
                }
            }
            prop_assert!((work / machine.rated.torque - 1.0).abs() < 1e-8, "{contact_law:?} {work}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]

    /// Wear by every law only removes metal, and only on the loaded flank.
    #[test]
    fn wear_is_never_negative_and_only_grows(machine in machines(), unit in 0.0..1.0f64) {
        for law in [
            WearLaw::Archard,
            WearLaw::PressurePower { exponent: 1.0 + 3.0 * unit, threshold: 1e8 * unit },
            WearLaw::Smoothing { factor: 1.0 + 50.0 * unit, depth: UM },
        ] {
            let mut machine = machine.clone();
            machine.wear.law = law;
            machine.wear.pin_ratio = unit;
            let options = CoupledOptions {
                flank_points: 360,
                crank_positions: 8,
                depth_increment: 0.2 * UM,
                ..CoupledOptions::default()
            };
            let mut wear = CoupledWear::new(&machine, options);
            let mut last = wear.state().clone();
            // Steps are controlled by their error: as many as needed to remove half a micrometre.
            let mut deepest = 0.0;
            for _ in 0..200 {
                wear.advance_until(f64::MAX, |_| true).unwrap();
                let state = wear.state();
                let pairs = state.flanks.iter().chain(&state.pins).zip(last.flanks.iter().chain(&last.pins));
                for (now, before) in pairs {
                    for (now, before) in now.samples().iter().zip(before.samples()) {
                        prop_assert!(now.is_finite() && now >= before && *before >= 0.0, "{law:?} {now} {before}");
                    }
                }
                last = state.clone();
                deepest = last.flank().deepest().0.max(last.pin().deepest().0);
                if deepest > 0.5 * UM {
                    break;
                }
            }
            prop_assert!(deepest > 0.5 * UM, "{law:?} {deepest}");
        }
    }
}
