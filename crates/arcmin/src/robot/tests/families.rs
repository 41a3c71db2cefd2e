//! Joints with drives of eccentrics.

use super::*;
use crate::analyses::stage::AnyDesign;
use crate::analyses::{by_name, joint};
use crate::templates::{DRIVES, NEMA17_19};

/// Design and table of a joint are equivalent: ages, hysteresis and waves agree with those of `export joint`
/// for the design with its duty, and a robot with that table has the same results.
#[test]
#[ignore = "long"]
fn drives_of_eccentrics_are_joints_by_their_designs() {
    for (template, rated) in DRIVES.into_iter().zip([3.0, 18.0, 500.0, 60.0, 150.0]) {
        let readings = to_and_fro(0.0, 180.0, 60.0);
        let mut files = with_readings(&readings);
        files.files.push(("drive.toml".to_owned(), template.text.as_bytes().to_vec()));
        let mass = 0.9 * rated / 9.80665;
        let asked = |words: &str, files: &Files| {
            let text = one_axis("[0, -1, 0]", mass, words, READ).replace("hours = 6000", "hours = 500");
            answered(&text, files)
        };
        let robot = asked("design = \"drive.toml\"", &files);
        let text = robot.joints[0].design_text.clone().unwrap();
        let design = AnyDesign::parse(&text, "joint.toml").unwrap();
        let moving = robot.joints[0].duty.moving;
        let options = joint::JointOptions {
            fidelity: <crate::fidelity::FidelityOptions as crate::design::OptionSet>::parse(
                "joints = \"bearings\"",
                "test",
            )
            .unwrap(),
            hours: vec![0.0, 500.0 * moving],
            positions: 2,
            error_positions: 64,
            timestep: 1e-3,
            load_inertia: None,
            masses: Default::default(),
        };
        let bench = joint::joint(&design, &options, &NoHost).unwrap();
        let tool = robot.tool.as_ref().unwrap();
        assert_eq!(tool.joints[0].ages.len(), 2);
        for (age, state) in tool.joints[0].ages.iter().zip(&bench.states) {
            assert!((age.lost_motion / state.lost_motion_rad - 1.0).abs() < 1e-12, "{}", template.name);
        }
        // Wear by the duty increases the lost motion of the joint.
        assert!(tool.joints[0].ages[1].lost_motion > tool.joints[0].ages[0].lost_motion);
        let table = serde_json::to_vec(&bench).unwrap();
        files.files.push(("joint.json".to_owned(), table));
        let by_table = asked("table = \"joint.json\"", &files);
        let position =
            |robot: &Robot| robot.table("tool").unwrap().numbers("position_error_mm").unwrap().to_vec();
        for (one, other) in position(&robot).iter().zip(position(&by_table)) {
            assert!((one / other - 1.0).abs() < 1e-9, "{}: {one} {other}", template.name);
        }
        // The eccentric bearing has the shortest life of the bearings, as in `life` for the design with its
        // duty.
        let (name, hours) = robot.joints[0].bearing.clone().unwrap();
        let life =
            design.run(by_name("life").unwrap(), "points = 4\ndiscs = \"rigid\"", "test", &NoHost).unwrap();
        let tables = life.tables();
        let lives =
            tables.iter().find(|table| table.name == "bearing_life").unwrap().numbers("life_l10_h").unwrap();
        let shortest = lives.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(
            name.contains("eccentric") && (hours * moving / shortest - 1.0).abs() < 1e-9,
            "{name} {hours}"
        );
    }
}

/// Mounting and drawn robots: only an RV reducer has a mounting, and every design with tolerances can be drawn.
#[test]
fn mountings_are_refused_and_tolerances_drawn() {
    let mut files = with_readings(&to_and_fro(0.0, 90.0, 30.0));
    let tolerances = "[tolerances]\npin_position_um = 3\neccentricity_um = 2\n";
    let text = format!("{}\n{tolerances}", NEMA17_19.text);
    files.files.push(("drive.toml".to_owned(), text.into_bytes()));
    let asked = |words: &str, more: &str| {
        let text = one_axis("[0, -1, 0]", 0.1, words, &format!("{READ}{more}"));
        RobotFile::parse(&text.replace("hours = 6000", "hours = 100"), "one.toml").unwrap()
    };
    let file = asked("design = \"drive.toml\"\nmounting = \"housing\"", "");
    let error = run(&file, &RobotOptions::default(), &files, &Memory::default()).unwrap_err().to_string();
    assert!(error.contains("a single stage has the mounting of its design"), "{error}");
    let file = asked("design = \"drive.toml\"", "[population]\nrobots = 3\n");
    let robot = run(&file, &RobotOptions::default(), &files, &Memory::default()).unwrap();
    let population = robot.tool.as_ref().unwrap().population.as_ref().unwrap();
    let drawn: Vec<_> = population.robots.iter().map(|robot| robot.as_ref().unwrap()[0].numbers()).collect();
    assert!(population.alike.is_empty() && drawn[0] != drawn[1] && drawn[1] != drawn[2], "{drawn:?}");
}
