//! Rings of one piece.

use super::*;
use crate::analyses::NoHost;
use crate::checks::Severity;
use crate::design::Value as Given;
use crate::templates::{NEMA17_19, TWO_RING_225, TWO_STAGE_500};

fn with(text: &str, mounting: &str, keys: &[&str]) -> AnyDesign {
    let design = AnyDesign::parse(text, "test.toml").unwrap();
    let changes = keys.iter().map(|key| (*key, Given::from(mounting)));
    design.with_all(changes).unwrap_or_else(|error| panic!("{error}"))
}

fn asked(design: &AnyDesign, name: &str, options: &str) -> Box<dyn Outcome> {
    let outcome = design.run(crate::analyses::by_name(name).unwrap(), options, "test", &NoHost);
    outcome.unwrap_or_else(|error| panic!("{name} {error:?}"))
}

/// Arcs of the pins' radius carry the forces of fixed pins, slide and wear as they do, and have no seats: the check of pins that
/// overlap gives way to that of the arcs.
#[test]
fn arcs_carry_and_wear_as_fixed_pins() {
    for (text, keys) in [
        (NEMA17_19.text, vec!["ring.pin_mounting"]),
        (TWO_RING_225.text, vec!["ring.pin_mounting", "second_ring.pin_mounting"]),
        (TWO_STAGE_500.text, vec!["ring.pin_mounting", "first_stage.ring.pin_mounting"]),
    ] {
        let text =
            text.replace("coefficient_per_pa = 1e-18 ", "pin_ratio = 0.5\ncoefficient_per_pa = 1e-18 ");
        let text = text.replace("[wear.coupled]\npin_ratio = 0.5", "[wear]\npin_ratio = 0.5\n[wear.coupled]");
        let [pins, arcs] = ["fixed", "one-piece"].map(|mounting| with(&text, mounting, &keys));
        for (name, options) in [("contact", "positions = 24"), ("wear", "hours = 200\npoints = 1")] {
            let [one, other] = [&pins, &arcs].map(|design| asked(design, name, options).summary());
            for key in [
                "max_force_n",
                "max_pressure_mpa",
                "max_depth_um",
                "max_pin_depth_um",
                "te_loaded_peak_to_peak_arcmin",
            ] {
                match (one.number(key), other.number(key)) {
                    (Some(one), Some(other)) => {
                        assert!((one - other).abs() <= 1e-9 * one.abs(), "{name} {key} {one} {other}");
                    }
                    (one, other) => assert_eq!(one, other, "{name} {key}"),
                }
            }
        }
        let worn = asked(&arcs, "wear", "hours = 200\npoints = 1").summary();
        assert!(worn.number("max_pin_depth_um").unwrap() > 0.0, "the arcs wear");
        let codes = |design: &AnyDesign| design.findings().iter().map(|one| one.code).collect::<Vec<_>>();
        let (before, after) = (codes(&pins), codes(&arcs));
        assert!(before.contains(&"pin-overlap") && !before.contains(&"ring-arcs"));
        assert!(!after.contains(&"pin-overlap"));
        assert_eq!(after.iter().filter(|code| **code == "ring-arcs").count(), keys.len());
        let finding = arcs.findings().into_iter().find(|one| one.code == "ring-arcs").unwrap();
        assert!(finding.severity == Severity::Info && finding.value > finding.limit, "{}", finding.message);
    }
}

/// Seats of a ring of one piece, and such a ring of an RV reducer, are refused at their keys.
#[test]
fn rings_of_one_piece_are_refused_where_they_cannot_be() {
    let one = with(NEMA17_19.text, "one-piece", &["ring.pin_mounting"]);
    let error = one.with("ring.seat_compliance_um_per_kn", 2.0).unwrap_err();
    assert_eq!(error.key(), Some("ring.seat_compliance_um_per_kn"));
    let rv = AnyDesign::parse(crate::templates::RV_40E.text, "b").unwrap();
    let error = rv.with("ring.pin_mounting", "one-piece").unwrap_err();
    assert_eq!(error.key(), Some("ring.pin_mounting"));
}
