//! The complete computation, on arms with known results.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

mod bench;
mod families;
mod remedies;

use super::*;
use crate::analyses::{AnalysisError, Host, NoHost, Origin};
use crate::design::InputFile;
use crate::load::ShareLoad;
use crate::progress::{Progress, Silent};
use crate::study::{Memory, Shard};

/// Files by their names, and stored lives with the number of accesses.
pub(super) struct Files {
    files: Vec<(String, Vec<u8>)>,
    kept: Mutex<BTreeMap<String, Vec<u8>>>,
    times: AtomicUsize,
}

impl Files {
    fn new(files: Vec<(String, Vec<u8>)>) -> Files {
        Files { files, kept: Mutex::default(), times: AtomicUsize::new(0) }
    }
}

impl Progress for Files {
    fn report(&self, stage: &str, share: f64) {
        Silent.report(stage, share);
    }

    fn is_cancelled(&self) -> bool {
        false
    }
}

impl Host for Files {
    fn read(&self, file: &InputFile, origin: Origin) -> Result<Vec<u8>, AnalysisError> {
        match self.files.iter().find(|(name, _)| *name == file.0) {
            Some((_, bytes)) => Ok(bytes.clone()),
            None => NoHost.read(file, origin),
        }
    }

    fn cached(&self, name: &str) -> Option<Vec<u8>> {
        self.kept.lock().unwrap().get(name).cloned()
    }

    fn cache(&self, name: &str, bytes: &[u8]) {
        self.times.fetch_add(1, Ordering::Relaxed);
        self.kept.lock().unwrap().insert(name.to_owned(), bytes.to_vec());
    }
}

fn files() -> Files {
    Files::new(
        example().designs.iter().map(|(name, text)| ((*name).to_owned(), text.as_bytes().to_vec())).collect(),
    )
}

#[test]
fn loads_of_the_example_are_plausible() {
    let example = example();
    let file = RobotFile::parse(example.text, "arm.toml").unwrap_or_else(|error| panic!("{error}"));
    let robot = run(&file, &RobotOptions { loads: true, lives: None }, &files(), &Memory::default()).unwrap();
    for joint in &robot.joints {
        let duty = &joint.duty;
        println!(
            "{} {}: rms {:.0} peak {:.0} of {:.0} N·m, moving {:.3}, rows {}, moment {:.0} N·m",
            joint.axis,
            joint.design_name,
            duty.torque_rms,
            duty.torque_peak,
            joint.rated,
            duty.moving,
            duty.rows.len(),
            duty.forces.moment
        );
        assert!(duty.torque_peak < 2.5 * joint.rated && duty.moving > 0.1 && duty.moving < 1.0);
    }
}

/// One axis along `direction` at the origin, an arm of one metre along x, the mass at its end.
fn one_axis(direction: &str, mass: f64, more: &str, program: &str) -> String {
    format!(
        "name = \"one\"\nplanned_hours = 6000\n[[axis]]\nname = \"a\"\ndirection = {direction}\nmass_kg = {mass}\n\
         centre_mm = [1000, 0, 0]\ninertia_kg_m2 = [0, 0, 0]\nlower_deg = -400\nupper_deg = 400\n\
         [tool]\nposition_mm = [1000, 0, 0]\n[[joint]]\naxis = \"a\"\n{more}\n\
         [model]\nages = 2\npositions = 2\nte_positions = 64\n{program}"
    )
}

const RV_40E: &str = "rv-40e.toml";

/// The files of one-axis robots: the design, and a program with these readings in s and degrees.
pub(super) fn with_readings(readings: &[(f64, f64)]) -> Files {
    let mut text = String::from("time_s,a_deg\n");
    for (time, angle) in readings {
        text.push_str(&format!("{time},{angle}\n"));
    }
    let design = crate::templates::find("rv-40e").unwrap().text;
    Files::new(vec![(RV_40E.to_owned(), design.as_bytes().to_vec()), ("p.csv".to_owned(), text.into_bytes())])
}

/// From one angle to another and back, each in a time in s with smooth ends, with rests of 1 s.
fn to_and_fro(from: f64, to: f64, seconds: f64) -> Vec<(f64, f64)> {
    let steps = 400;
    let soft = |x: f64| 0.5 - 0.5 * (std::f64::consts::PI * x).cos();
    let mut readings = Vec::new();
    let mut push = |time: f64, angle: f64| readings.push((time, angle));
    for k in 0..=steps {
        let x = f64::from(k) / f64::from(steps);
        push(seconds * x, from + (to - from) * soft(x));
    }
    for k in 1..=20 {
        push(seconds + 0.05 * f64::from(k), to);
    }
    for k in 1..=steps {
        let x = f64::from(k) / f64::from(steps);
        push(seconds + 1.0 + seconds * x, to + (from - to) * soft(x));
    }
    for k in 1..=20 {
        push(2.0 * seconds + 1.0 + 0.05 * f64::from(k), from);
    }
    readings
}

const READ: &str = "[[program]]\nname = \"p\"\nfile = \"p.csv\"\ncycles_per_hour = 3\nsmoothing_ms = 0\n";

pub(super) fn answered(text: &str, files: &Files) -> Robot {
    let file = RobotFile::parse(text, "one.toml").unwrap_or_else(|error| panic!("{error}: {text}"));
    run(&file, &RobotOptions::default(), files, &Memory::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Signs in simple experiments: a weight causes a position below the commanded one; in a slow approach from
/// below the tool stops below the pose, from above above it; after strong braking it has overshot the pose.
#[test]
#[ignore = "long"]
fn signs_of_errors_agree_with_simple_experiments() {
    let design = "design = \"rv-40e.toml\"\n";
    let none = "[controller]\ncompensates = \"none\"\n";
    // Horizontal arm under its weight.
    let text = one_axis("[0, -1, 0]", 20.0, design, &format!("{READ}{none}"));
    let robot = answered(&text, &with_readings(&to_and_fro(-20.0, 0.0, 10.0)));
    let tool = robot.tool.as_ref().unwrap();
    let at = |tool: &super::run::ToolAnswer, visit: usize, hours: f64| {
        tool.field.tool(&tool.places, &[hours], tool.sorted.visits[visit].0)[0]
    };
    assert!(tool.sorted.visits.len() >= 2, "{}", tool.sorted.visits.len());
    let level = tool
        .sorted
        .visits
        .iter()
        .position(|(place, _)| tool.places.places[*place].angles[0].abs() < 1e-3)
        .unwrap();
    let sag = at(tool, level, 0.0).z;
    println!("a weight of 20 kg on a metre sags by {:.4} mm", sag * 1e3);
    assert!(sag < 0.0);
    let worn = at(tool, level, 6000.0).z;
    assert!(worn < sag, "worn it hangs lower: {worn} {sag}");

    // Vertical axis, slow: no effect of weight, only the drag of the seal.
    let slow = |drag: f64, seconds: f64| {
        let text = one_axis(
            "[0, 0, 1]",
            20.0,
            &format!("{design}output_drag_n_m = {drag}\n"),
            &format!("{READ}{none}"),
        );
        answered(&text, &with_readings(&to_and_fro(-30.0, 30.0, seconds)))
    };
    let robot = slow(15.0, 100.0);
    let tool = robot.tool.as_ref().unwrap();
    for visit in 0..tool.sorted.visits.len() {
        let here = &tool.places.places[tool.sorted.visits[visit].0];
        let (angle, moved) = (here.angles[0], at(tool, visit, 0.0));
        // In the direction of increasing angles.
        let ahead = moved.dot(&nalgebra::Vector3::new(-angle.sin(), angle.cos(), 0.0));
        println!("{:.0}° reached {:.4} mm ahead", angle.to_degrees(), ahead * 1e3);
        // The first half approaches +30° from below and remains below.
        assert!(ahead * angle.signum() < 0.0);
    }
    // The difference between the two approaches is about the lost motion: 15 N·m are close to ±3 % of the rated
    // torque.
    let pose = tool.sorted.approaches[0].clone();
    let along = |place: usize| tool.field.by_axis(&tool.places, 0, 0.0, place)[0];
    let angle = tool.places.places[pose[0]].angles[0];
    let forward = nalgebra::Vector3::new(-angle.sin(), angle.cos(), 0.0);
    let side = |index: usize| super::tool::side(index).dot(&forward);
    let (from_above, from_below) = (0..6).fold((0, 0), |(a, b), i| {
        (if side(i) > side(a) { i } else { a }, if side(i) < side(b) { i } else { b })
    });
    let differ = (along(pose[from_above]) - along(pose[from_below])).dot(&forward);
    let lost = tool.joints[0].ages[0].lost_motion;
    println!(
        "from above and from below {:.4} mm apart, lost motion on a metre {:.4} mm",
        differ * 1e3,
        lost * 1e3
    );
    assert!(differ > 0.9 * lost && differ < 1.3 * lost, "{differ} {lost}");
    // Strong braking without drag: the arm overshoots.
    let robot = slow(0.0, 0.8);
    let tool = robot.tool.as_ref().unwrap();
    let mut seen = 0;
    for place in &tool.sorted.paths {
        let here = &tool.places.places[*place];
        // Just before it comes to rest at +30°.
        if (0.70..0.79).contains(&here.time) {
            let moved = tool.field.tool(&tool.places, &[0.0], *place)[0];
            let angle = here.angles[0];
            assert!(moved.dot(&nalgebra::Vector3::new(-angle.sin(), angle.cos(), 0.0)) > 0.0);
            seen += 1;
        }
    }
    assert!(seen > 5);
}

/// A pose is approached from the left, then from the right: each time the tool stops short of it, on the side
/// that it comes from, and the distance between the two is the width of the loop.
#[test]
fn a_pose_from_the_left_and_from_the_right() {
    let drag = 0.03 * 412.0;
    let joint = format!(
        "design = \"rv-40e.toml\"\nspeed_deg_s = 10\nacceleration_deg_s2 = 1\noutput_drag_n_m = {drag}\n"
    );
    let poses = [(-30, false), (0, true), (30, false), (0, true)]
        .map(|(angle, test)| format!("[[program.pose]]\nangles_deg = [{angle}]\ntest = {test}\n"))
        .concat();
    let program = format!(
        "[[program]]\nname = \"p\"\ncycles_per_hour = 3\n{poses}[controller]\ncompensates = \"none\"\n"
    );
    let robot = answered(&one_axis("[0, 0, 1]", 20.0, &joint, &program), &with_readings(&[]));
    let tool = robot.tool.as_ref().unwrap();
    // The left is the direction of increasing angles, along y.
    let visits: Vec<usize> = tool.sorted.visits.iter().map(|(place, _)| *place).collect();
    let [from_right, from_left] = visits[..] else { panic!("{visits:?}") };
    let reached = |place: usize| tool.field.tool(&tool.places, &[0.0], place)[0].y;
    // Lost motion and wind-up; the transmission error depends on the loaded flanks.
    let stands = |place: usize| {
        let [lost, wound, ..] = tool.field.caused(&tool.places, 0, 0.0, place);
        lost[0].y + wound[0].y
    };
    let apart = stands(from_left) - stands(from_right);
    let joint = &tool.joints[0].ages[0];
    // The start of motion needs slightly more than the drag, and friction keeps the resulting wind-up.
    let most = drag + 20.0 * 1.0_f64.to_radians();
    let expected = joint.curve.branch(true, most) - joint.curve.branch(false, -most);
    println!(
        "from the right {:.4} mm, from the left {:.4} mm; {:.4} mm apart by the loop, {:.4} mm lost motion on a metre",
        1e3 * reached(from_right),
        1e3 * reached(from_left),
        1e3 * expected,
        1e3 * joint.lost_motion
    );
    assert!(reached(from_right) < 0.0 && reached(from_left) > 0.0);
    assert!((apart / expected - 1.0).abs() < 0.01, "{apart} {expected}");
    // Friction in the joint itself reduces it slightly.
    assert!(apart > 0.75 * joint.lost_motion && apart < joint.lost_motion, "{apart} {}", joint.lost_motion);
}

/// Two axes: the first lifts a weight, the second rotates the arm sideways.
pub(super) fn two_axes(limits: &str) -> String {
    let design = "design = \"rv-40e.toml\"\nspeed_deg_s = 100\nacceleration_deg_s2 = 200\n";
    let poses = [[-30, -20], [10, -20], [10, 20], [-30, 20]]
        .map(|angles| format!("[[program.pose]]\nangles_deg = {angles:?}\n"))
        .concat();
    format!(
        "name = \"two\"\nplanned_hours = 6000\n\
         [[axis]]\nname = \"lifts\"\ndirection = [0, -1, 0]\nmass_kg = 10\ncentre_mm = [250, 0, 0]\n\
         inertia_kg_m2 = [0, 0, 0]\n\
         [[axis]]\nname = \"swings\"\nposition_mm = [500, 0, 0]\ndirection = [0, 0, 1]\nmass_kg = 20\n\
         centre_mm = [100, 0, 0]\ninertia_kg_m2 = [0, 0, 60]\n\
         [tool]\nposition_mm = [500, 0, 0]\n\
         [[joint]]\naxis = \"lifts\"\n{design}[[joint]]\naxis = \"swings\"\n{design}output_drag_n_m = 15\n\
         [[program]]\nname = \"p\"\ncycles_per_hour = 500\n{poses}\
         [model]\nages = 2\npositions = 1\nte_positions = 64\n{limits}"
    )
}

/// Shards computed in any order draw the same robots, to the byte, as a single run; a larger number of robots
/// with the same seed contains the same ones; another limit does not change the joints.
#[test]
#[ignore = "long"]
fn shards_draw_the_robots_of_the_whole() {
    let design = crate::templates::find("rv-40e").unwrap().text;
    let text = |robots: usize, limits: &str| {
        two_axes(&format!("{limits}[population]\nrobots = {robots}\nseed = 3\n"))
    };
    let drawn = |text: &str, shards: u64, parts: &Memory, host: &Files| {
        let file = RobotFile::parse(text, "two.toml").unwrap();
        let loaded = Loaded::of(&file, host).unwrap();
        let plan = loaded.population_plan().unwrap().unwrap();
        let done = (1..=shards)
            .rev()
            .map(|shard| loaded.draw(&plan, Shard::new(shard, shards).unwrap(), parts, host).unwrap())
            .fold((0, 0), |sum, done| (sum.0 + done.computed, sum.1 + done.found));
        let population = loaded.population(&plan, parts).unwrap();
        (done, population.robots.into_iter().map(Result::unwrap).collect::<Vec<[Figures; 2]>>())
    };
    assert!(design.contains("[tolerances]"));
    let (whole, parts) = (Memory::default(), Memory::default());
    let ((computed, _), robots) = drawn(&text(2, ""), 1, &whole, &with_readings(&[]));
    let host = with_readings(&[]);
    let (_, shared) = drawn(&text(2, ""), 2, &parts, &host);
    assert_eq!((computed, &robots), (2, &shared));
    assert!(robots[0][1] != robots[1][1] && robots[0][1].position > robots[0][0].position);
    assert_eq!(*whole.0.lock().unwrap(), *parts.0.lock().unwrap());
    // A lost part is computed again, the other one is found.
    parts.0.lock().unwrap().pop_first();
    let kept = host.times.load(Ordering::Relaxed);
    assert_eq!(drawn(&text(2, ""), 1, &parts, &host), ((1, 1), robots.clone()));
    let limited = text(2, "[limits]\npath_mm = 1\n");
    assert_eq!(drawn(&limited, 1, &parts, &host), ((0, 2), robots.clone()));
    let (done, more) = drawn(&text(3, ""), 2, &parts, &host);
    assert_eq!((done, &more[..2]), ((1, 2), &robots[..]));
    assert_eq!(host.times.load(Ordering::Relaxed), kept + 2);
}

/// A mass in front of a vertical axis tilts its bearings forward: the tool is lowered by moment/stiffness ×
/// lever arm.
#[test]
#[ignore = "long"]
fn a_heavy_head_tilts_its_bearing_forward() {
    let text = one_axis(
        "[0, 0, 1]",
        20.0,
        "design = \"rv-40e.toml\"\nmoment_stiffness_n_m_per_arcmin = 900\n",
        &format!("{READ}[controller]\ncompensates = \"none\"\n"),
    );
    let robot = answered(&text, &with_readings(&to_and_fro(-30.0, 30.0, 100.0)));
    let tool = robot.tool.as_ref().unwrap();
    let moved = tool.field.caused(&tool.places, 0, 0.0, tool.sorted.visits[0].0)[3][0];
    let expected = -20.0 * 9.80665 / 900.0 * crate::units::ARCMIN;
    assert!((moved.z / expected - 1.0).abs() < 1e-6, "{moved:?} {expected}");
}

/// A stored life is used for its own key only, and only if it is intact.
#[test]
fn kept_lives_are_checked() {
    let text = one_axis("[0, -1, 0]", 20.0, "design = \"rv-40e.toml\"\n", READ);
    let file = RobotFile::parse(&text, "one.toml").unwrap();
    let host = with_readings(&to_and_fro(-20.0, 0.0, 10.0));
    let times = || host.times.load(Ordering::Relaxed);
    let lost = || {
        let robot = run(&file, &RobotOptions::default(), &host, &Memory::default()).unwrap();
        robot.tool.unwrap().joints[0].ages[1].lost_motion
    };
    let computed = lost();
    assert_eq!((lost(), times()), (computed, 1));
    // One digit of a number changed: still JSON, but no longer the stored life.
    for entry in host.kept.lock().unwrap().values_mut() {
        let text = std::str::from_utf8(entry).unwrap();
        let place = text.find("\"lost_motion_rad\":").unwrap() + "\"lost_motion_rad\":".len();
        entry[place] = if entry[place] == b'9' { b'8' } else { b'9' };
    }
    assert_eq!((lost(), times()), (computed, 2));
}

#[test]
fn the_chapter_of_the_robot_file_is_current() {
    let book = include_str!("../../../../docs/src/robot-file.md");
    assert!(book == reference_of_keys(), "rewrite it with `arcmin keys --robot > docs/src/robot-file.md`");
}
