//! Rings of one piece.

use super::*;
use crate::analyses::NoHost;
use crate::checks::Severity;
use crate::design::Value as Given;
use crate::results::Value;
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

/// Arcs with the radius of the pins have the forces, sliding and wear of fixed pins, and no seats. The check of the arcs
/// replaces that of overlapping pins.
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
        let defaults = |design: &AnyDesign| {
            design.findings().into_iter().find(|one| one.code == "defaults").unwrap().message
        };
        assert!(defaults(&pins).contains("ring.seat_compliance_um_per_kn"));
        assert!(!defaults(&arcs).contains("seat_compliance"), "{}", defaults(&arcs));
        assert!(
            !arcs.defaulted().iter().any(|key| key.contains("seat_compliance")),
            "{:?}",
            arcs.defaulted()
        );
        // Only rings of spinning pins and output pins with rollers slide with the friction of pin seats.
        let seat = |design: &AnyDesign| {
            let text = design.text().replace("pin_seat_coefficient", "# pin_seat_coefficient");
            let design = AnyDesign::parse(&text, "seats.toml").unwrap();
            design.defaulted().contains(&"friction.pin_seat_coefficient".to_owned())
        };
        let has_rollers = !matches!(arcs, AnyDesign::TwoRing(_));
        assert_eq!(seat(&arcs), has_rollers);
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

/// Words of a text about pins of the ring: not about output pins, keys, or the pin that cuts the flank.
fn pins_in(text: &str) -> Vec<String> {
    let text = text.replace("\\n", " ");
    let others = [
        "output pin",
        "Output pin",
        "generating pin",
        "pin path",
        "pin circle",
        "pin radius",
        "bushes of",
        "pins of 3 mm",
    ];
    let text = others.iter().fold(text, |text, other| text.replace(other, "…"));
    let is_of_word = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '-';
    let mut found = Vec::new();
    for (place, word) in text.match_indices("pin").chain(text.match_indices("Pin")) {
        let before = text[..place].chars().next_back();
        let rest = text[place + word.len()..].trim_start_matches('s');
        if !before.is_some_and(is_of_word) && !rest.chars().next().is_some_and(is_of_word) {
            let near =
                text.char_indices().filter(|(at, _)| at.abs_diff(place) < 60).map(|(_, letter)| letter);
            found.push(near.collect());
        }
    }
    found
}

/// Findings, terminal, pages and pictures mention ring pins only for drives with separate pins.
#[test]
#[ignore = "long"]
fn rings_of_one_piece_have_teeth_in_all_texts() {
    assert_eq!(pins_in("ring pins press, output pins too; ring.pin_count").len(), 1);
    for (text, keys) in [
        (NEMA17_19.text, vec!["ring.pin_mounting"]),
        (TWO_RING_225.text, vec!["ring.pin_mounting", "second_ring.pin_mounting"]),
        (TWO_STAGE_500.text, vec!["ring.pin_mounting", "first_stage.ring.pin_mounting"]),
    ] {
        let text = format!("{text}\n[tolerances]\nflank_offset_um = 5\neccentricity_um = 3\n");
        let [pins, arcs] = ["fixed", "one-piece"].map(|mounting| with(&text, mounting, &keys));
        let messages = |design: &AnyDesign| {
            design.findings().iter().map(|one| one.message.clone()).collect::<Vec<_>>().join("; ")
        };
        assert_eq!(pins_in(&messages(&arcs)), Vec::<String>::new());
        assert!(messages(&arcs).contains("ring teeth") && !pins_in(&messages(&pins)).is_empty());
        for (name, options) in [
            ("check", ""),
            ("contact", "positions = 8"),
            ("rig", "positions = 2\nte_positions = 8"),
            ("wear", "hours = 50\npoints = 1"),
            ("simulate", "end_s = 0.02"),
        ] {
            let outcome = asked(&arcs, name, options);
            let (said, page) = (format!("{:?}", outcome.text_blocks()), format!("{:?}", outcome.page()));
            assert_eq!(pins_in(&said), Vec::<String>::new(), "{name}");
            assert_eq!(pins_in(&page), Vec::<String>::new(), "{name}");
        }
        let scene = arcs.scene();
        assert!(scene.rings.iter().all(|ring| ring.one_piece));
        let names: Vec<&String> = scene.bodies.iter().map(|body| &body.name).collect();
        assert!(names.iter().any(|name| name.starts_with("Teeth of the")), "{names:?}");
        assert!(names.iter().all(|name| pins_in(name).is_empty()), "{names:?}");
        assert!(pins.scene().rings.iter().all(|ring| !ring.one_piece));
    }
}

/// Arcs cannot be selected by size: without output pins there are no parts to select, and with them a drive in a ring of one
/// piece keeps the scatter that a selection of ring pins removes.
#[test]
fn arcs_are_not_chosen_by_size() {
    let tolerances = "\n[tolerances]\nflank_offset_um = 5\n";
    let less = |text: &str, mounting: &str, keys: &[&str]| -> Option<f64> {
        let design = with(&format!("{text}{tolerances}"), mounting, keys);
        let table = asked(&design, "check", "").tables().into_iter().find(|table| table.name == "matched")?;
        let column = table.column("variance_share").filter(|_| table.rows() > 0)?;
        match column.cells.value(0) {
            Value::Number(share) => Some(share),
            _ => None,
        }
    };
    let ring = ["ring.pin_mounting"];
    assert!(less(NEMA17_19.text, "fixed", &ring).unwrap() > 0.9);
    assert!(less(NEMA17_19.text, "one-piece", &ring).unwrap().abs() < 1e-9);
    let rings = ["ring.pin_mounting", "second_ring.pin_mounting"];
    assert!(less(TWO_RING_225.text, "fixed", &rings).unwrap() > 0.9);
    assert_eq!(less(TWO_RING_225.text, "one-piece", &rings), None);
}

#[test]
fn rings_of_both_kinds_are_named_so() {
    let mixed = with(TWO_RING_225.text, "one-piece", &["second_ring.pin_mounting"]);
    let told = format!("{:?}", asked(&mixed, "contact", "positions = 8").page());
    assert!(told.contains("pin of the first ring") && told.contains("tooth of the second ring"), "{told}");
    assert!(told.contains("pins and ring teeth"), "{told}");
}
