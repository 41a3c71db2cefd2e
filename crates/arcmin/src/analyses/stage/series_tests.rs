//! Drives of two rings and of two stages as their files describe them.

use super::tests::uniform;
use super::*;
use crate::analyses::NoHost;
use crate::checks::Severity;
use crate::templates::{DRIVES, TWO_RING_225, TWO_STAGE_500};

fn any(text: &str) -> AnyDesign {
    AnyDesign::parse(text, "test.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn asked(design: &AnyDesign, name: &str, options: &str) -> Box<dyn Outcome> {
    let analysis = crate::analyses::by_name(name).unwrap();
    let outcome = design.run(analysis, options, "test", &NoHost);
    outcome.unwrap_or_else(|error| panic!("{error:?}\n{}", design.text()))
}

#[test]
fn shipped_drives_are_sound() {
    for template in DRIVES {
        let design = any(template.text);
        for finding in design.findings() {
            // One stepped disc is not balanced, and says so.
            let known = finding.code == "eccentric-balance" && template == TWO_RING_225;
            assert!(known || finding.severity == Severity::Info, "{}: {}", template.name, finding.message);
        }
    }
}

#[test]
fn ratios_and_keys_are_those_of_the_family() {
    for (template, ratio, keys) in [
        (TWO_RING_225, 225.0, ["second_max_force_n", "closed_form.second_ring_pin_force_n"]),
        (
            TWO_STAGE_500,
            500.0,
            ["first_stage_max_output_pin_force_n", "first_stage_eccentric_bearing_force_n"],
        ),
    ] {
        let design = any(template.text);
        let contact = asked(&design, "contact", "positions = 12");
        let summary = contact.summary();
        assert_eq!(summary.number("ratio"), Some(ratio));
        assert!(keys.iter().all(|key| summary.number(key).unwrap() > 0.0));
        // What is declared is what is written.
        let declared = design.results(crate::analyses::by_name("contact").unwrap()).unwrap();
        let written: Vec<&str> = summary.entries.iter().map(|(quantity, _)| quantity.key).collect();
        assert_eq!(declared.summary.iter().map(|quantity| quantity.key).collect::<Vec<_>>(), written);
        let names =
            |outcome: &dyn Outcome| outcome.tables().iter().map(|table| table.name).collect::<Vec<_>>();
        assert_eq!(declared.tables.iter().map(|table| table.name).collect::<Vec<_>>(), names(&*contact));
        let mut keys = written.clone();
        keys.sort_unstable();
        assert!(keys.windows(2).all(|pair| pair[0] != pair[1]), "{keys:?}");
        assert_eq!(asked(&design, "profile", "points = 8").tables().len(), 2);
        for name in ["wear", "life", "tao2024"] {
            let analysis = crate::analyses::by_name(name).unwrap();
            let error = design.run(analysis, "", "test", &NoHost).unwrap_err().to_string();
            assert!(error.contains(design.family().drive()), "{error}");
        }
    }
}

#[test]
fn what_cannot_be_is_refused_at_its_key() {
    for (template, from, to, key) in [
        (TWO_RING_225, "pin_count = 15 ", "pin_count = 16 ", "second_ring.pin_count"),
        (TWO_RING_225, "[second_disc] ", "[second_disc]\nlobe_count = 15 #", "second_disc.lobe_count"),
        (TWO_RING_225, "eccentricity_mm = 1.5", "eccentricity_mm = 2.6", "eccentric.eccentricity_mm"),
        (
            TWO_RING_225,
            "crank_bore_diameter_mm = 42",
            "crank_bore_diameter_mm = 65",
            "disc.crank_bore_diameter_mm",
        ),
        (TWO_RING_225, "count = 1\n", "count = 1\nwindow_rim_mm = 3\n", "disc.window_rim_mm"),
        (
            TWO_STAGE_500,
            "eccentricity_mm = 0.75",
            "eccentricity_mm = 1.3",
            "first_stage.eccentric.eccentricity_mm",
        ),
        (
            TWO_STAGE_500,
            "circle_radius_mm = 16",
            "circle_radius_mm = 24",
            "first_stage.output_pins.circle_radius_mm",
        ),
        (TWO_STAGE_500, "circle_radius_mm = 34", "circle_radius_mm = 50", "output_pins.circle_radius_mm"),
    ] {
        assert!(template.text.contains(from), "{from}");
        let error = AnyDesign::parse(&template.text.replacen(from, to, 1), "test.toml").unwrap_err();
        assert_eq!(error.key(), Some(key), "{error}");
    }
}

/// A drive is changed by its keys and stays what it is.
#[test]
fn drives_are_changed_by_their_keys() {
    let design = any(TWO_RING_225.text);
    let other = design.with_all([("ring.pin_count", 20), ("second_ring.pin_count", 21)]);
    let other = other.and_then(|other| other.with("eccentric.eccentricity_mm", 1.0)).unwrap();
    assert_eq!(asked(&other, "profile", "points = 8").summary().number("ratio"), Some(-399.0));
    assert!(design.with("drive.family", "two-stage").is_err());
    let stages = any(TWO_STAGE_500.text).with("first_stage.ring.pin_count", 16).unwrap();
    assert_eq!(asked(&stages, "profile", "points = 8").summary().number("ratio"), Some(375.0));
}

/// Both eccentrics go round, and the first ring is seen in as many places as there are positions.
#[test]
fn two_stages_are_seen_over_a_turn_of_the_second() {
    let contact = asked(&any(TWO_STAGE_500.text), "contact", "positions = 40");
    let tables = contact.tables();
    let error = tables.iter().find(|table| table.name == "error").unwrap();
    let angles = error.numbers("crank_angle_deg").unwrap();
    // 41 and 20 turns of 21 pins have no divisor in common.
    assert_eq!(angles.len(), 41);
    assert!((angles[40] - 7200.0 * 40.0 / 41.0).abs() < 0.1, "{}", angles[40]);
    assert_eq!(asked(&any(TWO_RING_225.text), "contact", "positions = 40").tables()[2].rows(), 40);
}

/// Every state of rest is found, and the play is at least the chain.
pub(super) fn answered(design: &AnyDesign) {
    let rig = asked(design, "rig", "positions = 2\nte_positions = 20").summary();
    let number = |key: &str| rig.number(key).unwrap();
    assert!(number("least_play_arcmin") > 0.98 * number("play_chain.total_arcmin"), "{}", design.text());
    assert!(number("stiffness_n_m_per_arcmin") > 0.0, "{}", design.text());
    assert!(number("efficiency") > 0.0 && number("efficiency") < 1.0, "{}", design.text());
}

/// A short run comes to its end, its drive turns by its ratio and loses no energy but in dampers.
pub(super) fn moves(design: &AnyDesign) {
    let options = "load = \"constant\"\nrise_s = 0.01\nend_s = 0.04\ntolerance = 1e-3";
    let run = asked(design, "simulate", options).summary();
    let number = |key: &str| run.number(key).unwrap_or_else(|| panic!("{key}\n{}", design.text()));
    assert!((number("mean_ratio") / number("ratio") - 1.0).abs() < 0.02, "{}", design.text());
    assert!(number("solver.energy_residual") < 1e-4, "{}", design.text());
}

fn is_buildable(design: &AnyDesign) -> bool {
    design.findings().iter().all(|finding| finding.severity != Severity::Error)
}

#[test]
fn random_drives_of_two_rings_are_answered() {
    let mut random = uniform(11);
    let mut tried = 0;
    while tried < 60 {
        let mut between = |low: f64, high: f64| low + (high - low) * random();
        let first = between(9.0, 40.0) as usize;
        let step = between(1.0, 4.99) as usize;
        let second = if between(0.0, 1.0) < 0.5 { first - step } else { first + step };
        if second < 6 {
            continue;
        }
        let circle = between(40.0, 120.0);
        let k1 = [between(0.4, 0.8), between(0.4, 0.8)];
        let eccentricity = k1[0] * circle / first as f64;
        let circles = [circle, eccentricity * second as f64 / k1[1]];
        let pin = |circle: f64, pins: usize, share: f64| {
            share * circle * (std::f64::consts::PI / pins as f64).sin()
        };
        let radii = [pin(circles[0], first, between(0.3, 0.6)), pin(circles[1], second, between(0.3, 0.6))];
        let pairs = [
            ("ring.pin_circle_radius_mm", circles[0]),
            ("second_ring.pin_circle_radius_mm", circles[1]),
            ("ring.pin_radius_mm", radii[0]),
            ("second_ring.pin_radius_mm", radii[1]),
            ("eccentric.eccentricity_mm", eccentricity),
            ("disc.modification.equidistant_offset_um", between(0.0, 60.0)),
            ("second_disc.modification.equidistant_offset_um", between(0.0, 60.0)),
            ("bearings.eccentric.clearance_um", between(0.0, 30.0)),
            ("load.rated_torque_n_m", between(0.2, 3.0) * 60.0 * (circle / 40.0_f64).powi(3)),
        ];
        let counts = [
            ("ring.pin_count", first),
            ("second_ring.pin_count", second),
            ("disc.count", between(1.0, 3.99) as usize),
        ];
        let changes = counts.map(|(key, count)| (key, crate::design::Value::from(count))).into_iter();
        let changes = changes.chain(pairs.map(|(key, value)| (key, crate::design::Value::from(value))));
        let Ok(design) = any(TWO_RING_225.text).with_all(changes) else { continue };
        if !is_buildable(&design) {
            continue;
        }
        tried += 1;
        answered(&design);
        if tried % 5 == 0 {
            moves(&design);
        }
    }
}

#[test]
fn random_drives_of_two_stages_are_answered() {
    let mut random = uniform(13);
    let mut tried = 0;
    while tried < 40 {
        let mut between = |low: f64, high: f64| low + (high - low) * random();
        let mut changes: Vec<(String, crate::design::Value)> = Vec::new();
        // Torque at the output that either stage bears.
        let mut torques = [0.0; 2];
        for (k, (prefix, circle, torque)) in
            [("first_stage.", 26.0, 6.0), ("", 52.0, 150.0)].into_iter().enumerate()
        {
            let pins = between(8.0, 45.0) as usize;
            let size = between(0.8, 2.0);
            let circle = circle * size;
            torques[k] = torque * size.powi(3);
            torques[0] *= if k == 1 { pins as f64 } else { 1.0 };
            let pin_radius = circle * (std::f64::consts::PI / pins as f64).sin() * between(0.3, 0.6);
            let roller = between(0.04, 0.08) * circle;
            for (key, value) in [
                ("ring.pin_circle_radius_mm", circle),
                ("ring.pin_radius_mm", pin_radius),
                ("eccentric.eccentricity_mm", between(0.4, 0.8) * circle / pins as f64),
                ("disc.modification.equidistant_offset_um", between(0.0, 60.0)),
                ("bearings.eccentric.clearance_um", between(0.0, 30.0)),
                ("output_pins.circle_radius_mm", 0.63 * circle),
                ("output_pins.roller_radius_mm", roller),
                ("output_pins.pin_radius_mm", 0.7 * roller),
                ("output_pins.hole_clearance_um", between(0.0, 60.0)),
            ] {
                changes.push((format!("{prefix}{key}"), value.into()));
            }
            for (key, count) in [
                ("ring.pin_count", pins),
                ("disc.count", between(1.0, 3.99) as usize),
                ("output_pins.count", between(4.0, 9.0) as usize),
            ] {
                changes.push((format!("{prefix}{key}"), count.into()));
            }
        }
        let torque = between(0.2, 3.0) * torques[0].min(torques[1]);
        changes.push(("load.rated_torque_n_m".to_owned(), torque.into()));
        let Ok(design) = any(TWO_STAGE_500.text).with_all(changes) else { continue };
        if !is_buildable(&design) {
            continue;
        }
        tried += 1;
        answered(&design);
        if tried % 5 == 0 {
            moves(&design);
        }
    }
}
