//! Drives of two rings and of two stages as their files describe them.

use super::tests::uniform;
use super::*;
use crate::analyses::NoHost;
use crate::checks::Severity;
use crate::geometry::{Vec2, unit};
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
        rollers_add_up(&design, 24, "rigid");
        for finding in design.findings() {
            // One stepped disc is not balanced: a warning.
            let known = finding.code == "eccentric-balance" && template == TWO_RING_225;
            assert!(known || finding.severity == Severity::Info, "{}: {}", template.name, finding.message);
        }
    }
}

#[test]
#[ignore = "long"]
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
        is_as_declared(&design, "contact", &*contact);
        is_as_declared(
            &design,
            "wear",
            &*asked(&design, "wear", "hours = 10\npoints = 1\ndiscs = \"rigid\""),
        );
        is_as_declared(
            &design,
            "calibrate",
            &*asked(&design, "calibrate", "reading = [\"100h=1um\"]\ndiscs = \"rigid\""),
        );
        let short = design.with("limits.service_life_h", 40).unwrap();
        is_as_declared(&design, "life", &*asked(&short, "life", "points = 4\ndiscs = \"rigid\""));
        assert_eq!(asked(&design, "profile", "points = 8").tables().len(), 2);
        let analysis = crate::analyses::by_name("tao2024").unwrap();
        let error = design.run(analysis, "", "test", &NoHost).unwrap_err().to_string();
        assert!(error.contains(design.family().drive()), "{error}");
    }
}

/// Declared results are those that are written.
fn is_as_declared(design: &AnyDesign, name: &str, outcome: &dyn Outcome) {
    let summary = outcome.summary();
    let declared = design.results(crate::analyses::by_name(name).unwrap()).unwrap();
    let written: Vec<&str> = summary.entries.iter().map(|(quantity, _)| quantity.key).collect();
    assert_eq!(declared.summary.iter().map(|quantity| quantity.key).collect::<Vec<_>>(), written);
    let tables = outcome.tables();
    let names: Vec<&str> = tables.iter().map(|table| table.name).collect();
    assert_eq!(declared.tables.iter().map(|table| table.name).collect::<Vec<_>>(), names);
    for (declared, table) in declared.tables.iter().zip(&tables) {
        let columns = table.columns.iter().map(|column| column.quantity.key);
        let keys: Vec<&str> = declared.columns.iter().map(|quantity| quantity.key).collect();
        assert_eq!(keys, columns.collect::<Vec<_>>(), "{}", table.name);
    }
    let mut keys = written.clone();
    keys.sort_unstable();
    assert!(keys.windows(2).all(|pair| pair[0] != pair[1]), "{keys:?}");
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

/// The keys of a drive can be changed, but not its family.
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

/// Both eccentrics make full turns, and every position of the input is a different position of the first ring.
#[test]
fn two_stages_are_seen_over_a_turn_of_the_second() {
    let contact = asked(&any(TWO_STAGE_500.text), "contact", "positions = 40");
    let tables = contact.tables();
    let error = tables.iter().find(|table| table.name == "error").unwrap();
    let angles = error.numbers("crank_angle_deg").unwrap();
    // 41 and 20 turns of 21 pins have no divisor in common.
    assert_eq!(angles.len(), 41);
    assert!((angles[40] - 7200.0 * 40.0 / 41.0).abs() < 0.1, "{}", angles[40]);
    let two_ring = asked(&any(TWO_RING_225.text), "contact", "positions = 40").tables();
    assert_eq!(two_ring.iter().find(|table| table.name == "error").unwrap().rows(), 40);
}

/// Forces of the rolling elements of an eccentric bearing add up to its force, position by position and stage by stage; the
/// largest of the discs is stated.
pub(super) fn rollers_add_up(design: &AnyDesign, positions: usize, discs: &str) {
    let options = format!("positions = {positions}\ndiscs = \"{discs}\"");
    let contact = asked(design, "contact", &options);
    let sharing = contact.as_any().downcast_ref::<contact::Contact>().unwrap();
    let mut seen = 0;
    for (k, stage) in sharing.stages.iter().enumerate() {
        for at in &sharing.turn {
            let here = || stage.rollers.iter().filter(|one| one.crank_angle == at.crank_angle);
            let of_disc = |disc: usize| {
                let forces = here().filter(|one| one.disc == disc).map(|one| one.force * unit(one.direction));
                forces.sum::<Vec2>().norm()
            };
            let largest = (0..3).map(of_disc).fold(0.0, f64::max);
            let stated = at.forces[k][keys::ECCENTRIC];
            assert!((largest - stated).abs() <= 1e-9 * stated, "{largest} {stated}\n{}", design.text());
            seen += here().count();
        }
    }
    assert!(seen >= sharing.turn.len(), "{}", design.text());
}

/// Every static equilibrium is found, and the play is at least the chain; `check` and `life` find the same lives of bearings.
pub(super) fn answered(design: &AnyDesign) {
    match design {
        AnyDesign::Eccentric(design) => bearings::agree(&**design),
        AnyDesign::TwoRing(design) => bearings::agree(&**design),
        AnyDesign::TwoStage(design) => bearings::agree(&**design),
        AnyDesign::Rv(_) => {}
    }
    rollers_add_up(design, 8, "rigid");
    let rig = asked(design, "rig", "positions = 2\nte_positions = 20\ndiscs = \"rigid\"").summary();
    let number = |key: &str| rig.number(key).unwrap();
    assert!(number("least_play_arcmin") > 0.98 * number("play_chain.total_arcmin"), "{}", design.text());
    assert!(number("stiffness_n_m_per_arcmin") > 0.0, "{}", design.text());
    assert!(number("hysteresis_loss_j") > 0.0, "{}", design.text());
    assert!(number("efficiency") > 0.0 && number("efficiency") < 1.0, "{}", design.text());
}

/// With elastic discs every static equilibrium is found as well, and the drive is softer.
pub(super) fn answered_with_elastic_discs(design: &AnyDesign) {
    let stiffness = |discs: &str| {
        let options = format!("positions = 2\nte_positions = 20\ndiscs = \"{discs}\"");
        asked(design, "rig", &options).summary().number("stiffness_n_m_per_arcmin").unwrap()
    };
    let (rigid, elastic) = (stiffness("rigid"), stiffness("elastic"));
    assert!(0.1 * rigid < elastic && elastic < 1.01 * rigid, "{elastic} {rigid}\n{}", design.text());
    rollers_add_up(design, 8, "elastic");
}

/// A short run is computed to its end; the drive turns by its ratio, and only dampers dissipate energy.
pub(super) fn moves(design: &AnyDesign, discs: &str) {
    let options = "load = \"constant\"\nrise_s = 0.01\nend_s = 0.04\ntolerance = 1e-3";
    let run = asked(design, "simulate", &format!("{options}\ndiscs = \"{discs}\"")).summary();
    let number = |key: &str| run.number(key).unwrap_or_else(|| panic!("{key}\n{}", design.text()));
    assert!((number("mean_ratio") / number("ratio") - 1.0).abs() < 0.02, "{}", design.text());
    assert!(number("solver.energy_residual") < 1e-4, "{}", design.text());
}

fn two_ring(text: &str) -> TwoRingDesign {
    TwoRingDesign::parse(text, "test.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Metal lost by the flanks in either ring is k Σ F |v| of its contacts, seen from the ring.
#[test]
fn metal_lost_in_each_of_two_rings_is_its_work_of_sliding() {
    let design = two_ring(TWO_RING_225.text);
    for ring in 0..2 {
        let share = wear_tests::loss_over_work_of_sliding(&design, 1e-18, ring);
        assert!((share - 1.0).abs() < 2e-3, "{ring}: {share}");
    }
}

/// Lost motion of the life equals that of the bench, new and worn. The mechanism of the bench contains both flanks, holes and
/// bearings: for two rings the same as in the life, for two stages one with the shaft between them.
#[test]
#[ignore = "long"]
fn lives_agree_with_the_bench() {
    for (template, within, others) in [
        (TWO_RING_225, 0.005, ["second_max_depth_um", "eccentric_clearance_growth_um"]),
        (TWO_STAGE_500, 0.01, ["first_stage_max_depth_um", "first_stage_hole_depth_um"]),
    ] {
        // A wear rate with which flanks, and bearings or holes, lose some micrometres.
        let text = template
            .text
            .replace("coefficient_per_pa = 1e-18 ", "coefficient_per_pa = 5e-18 ")
            .replace("service_life_h = 2000", "service_life_h = 1000");
        let text = match template == TWO_RING_225 {
            true => text
                .replace("kind = \"ball\"", "kind = \"cylindrical\"\nroller_length_mm = 8")
                .replace("[limits]", "[wear.turning_arm]\ncoefficient_per_pa = 1e-17\nslip = 0.02\n[limits]"),
            false => text
                .replace("roller_radius_mm = 3\n", "roller_radius_mm = 2\n")
                .replace("roller_radius_mm = 6\n", "roller_radius_mm = 4\n"),
        };
        let design = any(&text);
        let life = asked(&design, "life", "points = 4");
        let summary = life.summary();
        let number = |key: &str| summary.number(key).unwrap();
        assert!(number("max_depth_um") > 1.0 && others.iter().all(|key| number(key) > 0.3), "{summary:?}");
        let bench = |hours: f64| {
            let options = format!("hours = {hours}\npositions = 12\nte_positions = 60");
            asked(&design, "rig", &options).summary()
        };
        let (new, worn) = (bench(0.0), bench(1000.0));
        for (key, bench) in [("lost_motion_new_arcmin", &new), ("lost_motion_arcmin", &worn)] {
            let (found, other) = (number(key), bench.number("lost_motion_arcmin").unwrap());
            assert!((found / other - 1.0).abs() < within, "{key}: {found} {other}");
        }
        assert!(number("lost_motion_arcmin") > number("lost_motion_new_arcmin"));
        // The worn drive moves, and only dampers dissipate energy.
        let options = "hours = 1000\nload = \"constant\"\nrise_s = 0.01\nend_s = 0.03\ntolerance = 1e-3";
        let motion = asked(&design, "simulate", options).summary();
        assert!(motion.number("solver.energy_residual").unwrap() < 1e-4);
    }
}

/// Each stage of two is a single stage under its own torque at its own speed; errors of the first are divided by the
/// ratio of the second at the output.
#[test]
#[ignore = "long"]
fn a_life_of_two_stages_is_that_of_its_stages() {
    let more = "[wear.turning_arm]\ncoefficient_per_pa = 1e-17\nslip = 0.02\n[limits]";
    let text = TWO_STAGE_500.text.replace("kind = \"ball\"", "kind = \"cylindrical\"\nroller_length_mm = 6");
    let text = text.replace("[limits]", more).replace("service_life_h = 2000", "service_life_h = 400");
    let both = TwoStageDesign::parse(&text, "test.toml").unwrap();
    let single = |k: usize| {
        let (prefix, torque, speed) = [("first_stage.", 150.0 / 25.0, 1500.0), ("", 150.0, 1500.0 / 20.0)][k];
        // Sections of one stage, its torque and speed, the shaft between in the bearings of both.
        let mut own = String::new();
        let mut keep = true;
        for line in text.lines() {
            if let Some(section) = line.strip_prefix('[') {
                let section = section.split(']').next().unwrap();
                let first = section.starts_with("first_stage.");
                let shared =
                    ["drive", "load", "wear.coupled", "wear.turning_arm", "limits"].contains(&section);
                keep = shared || first == (k == 0);
            }
            if keep {
                own.push_str(&format!("{}\n", line.replace("[first_stage.", "[")));
            }
        }
        let own = own.replace("\"two-stage\"", "\"eccentric\"");
        let bearing =
            ["bearings.output_radial_stiffness_n_per_um", "bearings.input_radial_stiffness_n_per_um"][k];
        let design =
            StageDesign::parse(&own, "test.toml").unwrap_or_else(|error| panic!("{prefix}{error}\n{own}"));
        design
            .with_all([("load.rated_torque_n_m", torque), ("load.input_speed_rpm", speed), (bearing, 300.0)])
            .unwrap()
    };
    let options = life::Options::parse("points = 4", "test").unwrap();
    let whole = life::run(&both, &options, &NoHost).unwrap();
    let [first, second] = [0, 1].map(|k| life::run(&single(k), &options, &NoHost).unwrap());
    // Torque and errors of the first have the opposite sign of those of a single stage: positions are mirrored.
    let close = |a: f64, b: f64, within: f64| assert!((a / b - 1.0).abs() < within, "{a} {b}");
    for (k, alone, within) in [(0, &first, 0.01), (1, &second, 1e-6)] {
        for (point, own) in whole.rings[k].1.points.iter().zip(&alone.prediction.points).skip(1) {
            close(point.accuracy.max_depth, own.accuracy.max_depth, within);
            close(point.accuracy.max_pressure, own.accuracy.max_pressure, 5.0 * within);
            close(point.state.part_wear.turning_arm, own.state.part_wear.turning_arm, within);
        }
    }
    let points = first.prediction.points.iter().zip(&second.prediction.points);
    for (point, (first, second)) in whole.prediction.points.iter().zip(points) {
        let sum = |of: fn(&crate::life::LifePoint) -> f64| of(first) / 25.0 + of(second);
        close(point.lost_motion.radians(), sum(|point| point.lost_motion.radians()), 0.003);
        let travel = |point: &crate::life::LifePoint| point.travel.unwrap().free_travel.radians();
        close(travel(point), sum(travel), 0.003);
        // Under torque the first output lags behind its input, in the opposite direction to that of the drive.
        let error = |point: &crate::life::LifePoint| point.accuracy.loaded_error.radians().abs();
        close(error(point), sum(error), 0.003);
    }
    assert_eq!(whole.bearings.bearings.len(), 4);
}

/// With intervals of half the length, at whose ends the rings exchange their surfaces, depths are the same within 1 %.
#[test]
fn rings_exchange_their_surfaces_often_enough() {
    let depths = |service_h: f64| {
        let text =
            TWO_RING_225.text.replace("service_life_h = 2000", &format!("service_life_h = {service_h}"));
        let text = text.replace("coefficient_per_pa = 1e-18", "coefficient_per_pa = 5e-18");
        let design = two_ring(&text);
        let mut courses =
            super::meshing::courses(&design, &[], crate::wear::CoupledOptions::default()).unwrap();
        courses.advance_to(1000.0, &crate::progress::Silent).unwrap();
        let states = courses.states();
        let lost = super::meshing::rings(&design).unwrap();
        let lost = crate::life::WholeDrive::lost_motion(&mut { lost }, &states).unwrap();
        [states[0].deepest(), states[1].deepest(), lost]
    };
    let (coarse, fine) = (depths(2000.0), depths(1000.0));
    for (coarse, fine) in coarse.into_iter().zip(fine) {
        assert!((coarse / fine - 1.0).abs() < 0.01, "{coarse:e} {fine:e}");
    }
}

/// A coefficient is computed from a depth of the flank in `[disc]`, not from lost motion, to which both rings contribute.
#[test]
fn coefficients_are_found_from_depths_alone() {
    for (template, part) in [(TWO_RING_225, "rings"), (TWO_STAGE_500, "stages")] {
        let given = |key: &str| {
            let text = template.text.replace("coefficient_per_pa = 1e-18 ", &format!("after_h = 20\n{key} "));
            any(&text)
        };
        let found = asked(&given("depth_um = 0.5"), "wear", "hours = 20\npoints = 1").summary();
        assert!((found.number("max_depth_um").unwrap() / 0.5 - 1.0).abs() < 0.03, "{found:?}");
        let wear = crate::analyses::by_name("wear").unwrap();
        let error = given("lost_motion_arcmin = 1").run(wear, "", "test", &NoHost).unwrap_err();
        assert!(format!("{error:?}").contains(&format!("both of its {part}")), "{error:?}");
        let text = template.text.replace("[wear.coupled]\ncoefficient_per_pa = 1e-18 ", "#");
        let error = any(&text).run(wear, "", "test", &NoHost).unwrap_err();
        assert!(format!("{error:?}").contains("add [wear.coupled]"), "{error:?}");
    }
}

/// A short life is computed to its end and has results for both rings.
fn lives(design: &AnyDesign, other: &str) {
    let short = design.with("limits.service_life_h", 200).unwrap();
    let life = asked(&short, "life", "points = 4").summary();
    for key in ["lost_motion_arcmin", "max_depth_um", &format!("{other}max_depth_um")] {
        let value = life.number(key).unwrap_or_else(|| panic!("{key}\n{}", design.text()));
        assert!(value.is_finite() && value > 0.0, "{key} {value}\n{}", design.text());
    }
}

fn is_buildable(design: &AnyDesign) -> bool {
    design.findings().iter().all(|finding| finding.severity != Severity::Error)
}

#[test]
#[ignore = "long"]
fn random_drives_of_two_rings_have_results() {
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
            moves(&design, "rigid");
            lives(&design, "second_");
        }
    }
}

#[test]
#[ignore = "long"]
fn random_drives_of_two_stages_have_results() {
    let mut random = uniform(13);
    let mut tried = 0;
    while tried < 40 {
        let mut between = |low: f64, high: f64| low + (high - low) * random();
        let mut changes: Vec<(String, crate::design::Value)> = Vec::new();
        // Torque at the output, by the limits of both stages.
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
            answered_with_elastic_discs(&design);
            moves(&design, if tried % 10 == 0 { "elastic" } else { "rigid" });
            lives(&design, "first_stage_");
        }
    }
}
