//! The whole way, on arms whose answers are known.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

mod families;

use super::*;
use crate::analyses::{AnalysisError, Host, NoHost, Origin};
use crate::design::InputFile;
use crate::load::ShareLoad;
use crate::progress::{Progress, Silent};
use crate::study::{Memory, Shard};

/// Files by their names, and what is kept of lives, with how often something was.
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
fn the_example_has_believable_loads() {
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

/// One axis along `direction` at the origin, a metre of arm along x, the mass at its end.
fn one_axis(direction: &str, mass: f64, more: &str, program: &str) -> String {
    format!(
        "name = \"one\"\nplanned_hours = 6000\n[[axis]]\nname = \"a\"\ndirection = {direction}\nmass_kg = {mass}\n\
         centre_mm = [1000, 0, 0]\ninertia_kg_m2 = [0, 0, 0]\nlower_deg = -400\nupper_deg = 400\n\
         [tool]\nposition_mm = [1000, 0, 0]\n[[joint]]\naxis = \"a\"\n{more}\n\
         [model]\nages = 2\npositions = 2\nte_positions = 64\n{program}"
    )
}

const RV_40E: &str = "rv-40e.toml";

/// The files of one-axis robots: the design and a program of these readings in s and degrees.
pub(super) fn with_readings(readings: &[(f64, f64)]) -> Files {
    let mut text = String::from("time_s,a_deg\n");
    for (time, angle) in readings {
        text.push_str(&format!("{time},{angle}\n"));
    }
    let design = crate::templates::find("rv-40e").unwrap().text;
    Files::new(vec![(RV_40E.to_owned(), design.as_bytes().to_vec()), ("p.csv".to_owned(), text.into_bytes())])
}

/// From one angle to another and back, each way in so many s with soft ends, with rests of 1 s.
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

/// Overhauled at the start a joint is as old as without, at the end as new, in between it has the age since; one after the
/// limit has been left gains nothing, one before it the hours that the joint then lasts.
#[test]
fn an_overhaul_is_judged_at_any_hour() {
    let files = with_readings(&to_and_fro(0.0, 180.0, 300.0));
    let asked = |hours: &str, limits: &str| {
        let text = one_axis("[0, -1, 0]", 20.0, "design = \"rv-40e.toml\"", &format!("{READ}{limits}"));
        answered(
            &text.replace("planned_hours = 6000", &format!("planned_hours = 6000\noverhaul_h = {hours}")),
            &files,
        )
    };
    let column = |robot: &Robot, table: &str, key: &str| -> Vec<f64> {
        robot.table(table).unwrap().numbers(key).unwrap().to_vec()
    };
    let robot = asked("[0, 3000, 6000]", "");
    assert_eq!(column(&robot, "overhauls", "overhaul_h"), [0.0, 3000.0, 6000.0]);
    let then = column(&robot, "overhauls", "position_error_mm");
    let over_life = column(&robot, "tool", "position_error_mm");
    let [new, old] = [over_life[0], over_life[over_life.len() - 1]];
    assert!(
        (then[0] / old - 1.0).abs() < 1e-9 && (then[2] / new - 1.0).abs() < 1e-9,
        "{then:?} {over_life:?}"
    );
    assert!(new < then[1] && then[1] < old, "{then:?}");

    let limit = format!("[limits]\nposition_mm = {}\n", 0.5 * (new + old));
    let robot = asked("[1000, 5900]", &limit);
    let until = robot.hours_to_limit().unwrap();
    assert!(1000.0 < until && until < 5900.0, "{until}");
    let gained = column(&robot, "overhauls", "gained_h");
    let expected = (until + 1000.0).min(6000.0) - until;
    assert!((gained[0] - expected).abs() < 20.0 && gained[1] == 0.0, "{gained:?} {expected}");

    let text = one_axis("[0, -1, 0]", 20.0, "design = \"rv-40e.toml\"", READ);
    let late = text.replace("planned_hours = 6000", "planned_hours = 6000\noverhaul_h = [7000]");
    let file = RobotFile::parse(&late, "one.toml").unwrap();
    let error = run(&file, &RobotOptions::default(), &files, &Memory::default()).unwrap_err().to_string();
    assert!(error.contains("7000 h lies after the planned 6000 h"), "{error}");
}

/// A weight that takes the joint to ± its rated torque: the tool a metre away is where the bench's loop and its
/// transmission error say, and the joint's lost motion at the end is that of `rig` and of `life` for its design with
/// its duty.
#[test]
#[ignore = "long"]
fn one_joint_with_a_metre_of_arm_is_the_bench() {
    let rated = 412.0;
    let mass = 1.0001 * rated / 9.80665;
    let text = one_axis(
        "[0, -1, 0]",
        mass,
        "design = \"rv-40e.toml\"\noutput_drag_n_m = 0",
        &format!("{READ}[controller]\ncompensates = \"none\"\n"),
    );
    let robot = answered(&text, &with_readings(&to_and_fro(0.0, 180.0, 300.0)));
    let tool = robot.tool.as_ref().unwrap();
    let joint = &tool.joints[0];

    // The bench, asked anew for the design that the run has written.
    let design =
        crate::design::Design::parse(robot.joints[0].design_text.as_ref().unwrap(), "joint").unwrap();
    let options = crate::analyses::joint::JointOptions {
        fidelity: <crate::fidelity::FidelityOptions as crate::design::OptionSet>::parse(
            "joints = \"bearings\"",
            "test",
        )
        .unwrap(),
        hours: vec![0.0, 6000.0 * robot.joints[0].duty.moving],
        positions: 2,
        error_positions: 64,
        timestep: 1e-3,
        load_inertia: None,
        masses: Default::default(),
    };
    let bench = crate::analyses::joint::joint(&design.clone().into(), &options, &NoHost).unwrap();
    for (age, state) in joint.ages.iter().zip(&bench.states) {
        let off = age.lost_motion / state.lost_motion_rad - 1.0;
        println!("{:.0} h: lost motion {:.6e} rad, bench off by {off:.1e}", age.hours, age.lost_motion);
        assert!(off.abs() < 1e-12);
        assert!((age.curve.lost_motion() / state.lost_motion_rad - 1.0).abs() < 1e-9);
    }
    let life_options =
        crate::analyses::life::Options::parse("quasi_static = true\nbodies = \"rigid\"", "test");
    let life = crate::analyses::life::run(&design, &life_options.unwrap(), &NoHost).unwrap();
    let life_end = life.last().lost_motion.radians();
    // `life` states lost motion without friction, at crank positions of its own: there the bench's loop without friction
    // says the same. With friction the middle of the branches is 0.2 % less, and two positions stand for all.
    let machine = design.machine();
    let fidelity = crate::fidelity::Fidelity::resolve(&design, &options.fidelity, &NoHost).unwrap();
    let worn = crate::life::worn_after(&machine, &fidelity, options.hours[1], &Silent).unwrap();
    let settings = worn.on(fidelity.joint_settings().unwrap());
    let meshing = crate::dynamics::BearingMeshing::new(&machine, &settings).unwrap();
    let (rubbed, _) = crate::analyses::rig::with_friction(&machine, false);
    let mut smooth = rubbed.clone();
    smooth.friction = crate::machine::Friction {
        regularisation_speed: rubbed.friction.regularisation_speed,
        ..Default::default()
    };
    let at_lifes_positions = |machine: &crate::machine::Machine| {
        let kinematics = machine.kinematics();
        let turns = kinematics.housing_fixed_ratio() / (machine.ring.pin_count as f64 - 1.0);
        let of = |index: usize| {
            let sun = meshing.crank_position(index, 12, 0.0, 0).radians() * turns;
            let points = crate::rig::hysteresis_loop(machine, &settings, sun).unwrap();
            crate::rig::evaluate_loop(&points, machine.rated.torque).unwrap().lost_motion
        };
        (0..12).map(of).sum::<f64>() / 12.0
    };
    let (smooth, rubbed) = (at_lifes_positions(&smooth) / life_end, at_lifes_positions(&rubbed) / life_end);
    let ours = joint.ages[1].lost_motion / life_end;
    println!(
        "`life` at the end: {:.6e} rad; off: without friction at its positions {:.1e}, with friction {:.1e}, the joint \
         {:.1e}",
        life_end,
        smooth - 1.0,
        rubbed - 1.0,
        ours - 1.0
    );
    assert!((smooth - 1.0).abs() < 2e-5, "{smooth}");
    assert!((rubbed - 1.0).abs() < 3e-3, "{rubbed}");
    assert!((ours - 1.0).abs() < 5e-3, "{ours}");

    // Along the way the displacement of the tool, at right angles to the arm, is the angle times one metre.
    for (hours, state) in [(0.0, &bench.states[0]), (6000.0, &bench.states[1])] {
        let loop_points = &state.torsion_loop;
        let half = loop_points.len() / 2;
        let between = |branch: &[(f64, f64)], torque: f64| -> f64 {
            let pair =
                branch.windows(2).find(|pair| (pair[0].0 - torque) * (pair[1].0 - torque) <= 0.0).unwrap();
            pair[0].1 + (torque - pair[0].0) / (pair[1].0 - pair[0].0) * (pair[1].1 - pair[0].1)
        };
        let (mut seen, mut worst) = (0, 0.0_f64);
        for place in &tool.sorted.ways {
            let here = &tool.places.places[*place];
            if !(20.0..280.0).contains(&here.time) && !(321.0..581.0).contains(&here.time) {
                continue;
            }
            let angle = here.angles[0];
            // The weight pulls the arm down, against the angle, and the more the flatter it lies; what little it takes
            // to speed it up comes with it.
            let torque = -here.loads[0].torque;
            assert!((torque + mass * 9.80665 * angle.cos()).abs() < 0.02);
            let rising = here.time < 300.0;
            let branch = if rising { &loop_points[half..] } else { &loop_points[..half] };
            let waves = joint.ages[usize::from(hours > 0.0)].transmission_error(angle, torque);
            let expected = between(branch, torque) + waves;
            let moved = tool.field.tool(&tool.places, &[hours], *place)[0];
            let up = nalgebra::Vector3::new(-angle.sin(), 0.0, angle.cos());
            // The bench's branches do not quite meet at their tips; what is drawn there is the middle.
            let allowed = if torque.abs() < 0.9 * rated { 1e-11 } else { 2e-6 };
            worst = worst.max((moved.dot(&up) - expected).abs() / allowed);
            seen += 1;
        }
        println!("{seen} places, off by {:.1e} m at most on a metre", worst * 1e-11);
        assert!(seen > 300 && worst < 1.0, "{worst}");
    }
}

/// Signs by experiments: a weight hangs lower than commanded; approached slowly from below the tool stops below the pose,
/// from above above it; after hard braking it is past the pose.
#[test]
#[ignore = "long"]
fn signs_are_those_that_everybody_sees() {
    let design = "design = \"rv-40e.toml\"\n";
    let none = "[controller]\ncompensates = \"none\"\n";
    // Level arm under its weight.
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

    // Axis upright, slow: no weight acts, the seal drags.
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
        // Along growing angles.
        let ahead = moved.dot(&nalgebra::Vector3::new(-angle.sin(), angle.cos(), 0.0));
        println!("{:.0}° reached {:.4} mm ahead", angle.to_degrees(), ahead * 1e3);
        // The first half comes to +30° from below and stays below.
        assert!(ahead * angle.signum() < 0.0);
    }
    // The same pose from both sides differs by about the lost motion: 15 N·m are near ± 3 % of the rated torque.
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
    // Braking hard without drag: the arm goes on past the place.
    let robot = slow(0.0, 0.8);
    let tool = robot.tool.as_ref().unwrap();
    let mut seen = 0;
    for place in &tool.sorted.ways {
        let here = &tool.places.places[*place];
        // Just before it stands at +30°.
        if (0.70..0.79).contains(&here.time) {
            let moved = tool.field.tool(&tool.places, &[0.0], *place)[0];
            let angle = here.angles[0];
            assert!(moved.dot(&nalgebra::Vector3::new(-angle.sin(), angle.cos(), 0.0)) > 0.0);
            seen += 1;
        }
    }
    assert!(seen > 5);
}

/// The experiment that everybody can do: a pose is approached from the left, then from the right. Each time the tool
/// stops short of it, on the side that it comes from, and the two are as far apart as the branches of the loop.
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
    // To the left are growing angles, along y.
    let visits: Vec<usize> = tool.sorted.visits.iter().map(|(place, _)| *place).collect();
    let [from_right, from_left] = visits[..] else { panic!("{visits:?}") };
    let reached = |place: usize| tool.field.tool(&tool.places, &[0.0], place)[0].y;
    // Lost motion and wind-up; the transmission error differs with the flanks that carry.
    let stands = |place: usize| {
        let [lost, wound, ..] = tool.field.caused(&tool.places, 0, 0.0, place);
        lost[0].y + wound[0].y
    };
    let apart = stands(from_left) - stands(from_right);
    let joint = &tool.joints[0].ages[0];
    // Setting off asks for a little more than the drag, and friction keeps what that winds up.
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
    // Friction of the joint itself holds a little of it back.
    assert!(apart > 0.75 * joint.lost_motion && apart < joint.lost_motion, "{apart} {}", joint.lost_motion);
}

/// Two axes: the first lifts a weight, the second swings what is before it sideways.
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

/// Every limit ends the hours where its figure reaches it. Under a weight that hangs always the same way lost motion is an
/// offset of the pose and nothing of its repeatability, which the axis that swings free makes. With all limits the first
/// one counts.
#[test]
fn every_limit_ends_the_hours() {
    let host = with_readings(&[]);
    let free = answered(&two_axes(""), &host);
    assert!(free.end.is_none());
    let tool = free.tool.as_ref().unwrap();
    let [new, end] = [0.0, 6000.0].map(|hours| Figure::ALL.map(|f| tool.mapped().figure(f, &[hours, hours])));
    let mut all = (String::from("[limits]\n"), f64::INFINITY);
    for (index, figure) in Figure::ALL.into_iter().enumerate() {
        let unit = if figure == Figure::Orientation { crate::units::DEG } else { crate::units::MM };
        let key = if figure == Figure::Orientation { "deg" } else { "mm" };
        // Each somewhere else.
        let share = 0.3 + 0.1 * index as f64;
        let allowed = new[index] + share * (end[index] - new[index]);
        let line = format!("{}_{key} = {}\n", figure.word(), allowed / unit);
        let robot = answered(&two_axes(&format!("[limits]\n{line}")), &host);
        let found = robot.end.unwrap_or_else(|| panic!("{} is never left", figure.word()));
        let then = robot.tool.as_ref().unwrap().mapped().figure(figure, &[found.hours, found.hours]);
        println!(
            "{}: {:.4} new, {:.4} at the end, {:.4} allowed until {:.0} h, by {} of {}",
            figure.word(),
            new[index] / unit,
            end[index] / unit,
            allowed / unit,
            found.hours,
            CAUSES[found.cause],
            robot.joints[found.axis].axis
        );
        assert_eq!(found.limit.figure, figure);
        assert!(found.hours > 600.0 && found.hours < 5400.0 && (then / allowed - 1.0).abs() < 1e-3);
        let joint = if figure == Figure::Repeatability { "swings" } else { "lifts" };
        assert_eq!((robot.joints[found.axis].axis.as_str(), CAUSES[found.cause]), (joint, "lost motion"));
        all.0.push_str(&line);
        all.1 = all.1.min(found.hours);
    }
    let robot = answered(&two_axes(&all.0), &host);
    assert_eq!(robot.hours_to_limit(), Some(all.1));
    // New it is beyond every limit: hours 0.
    let never = answered(&two_axes("[limits]\npath_mm = 1e-5\n"), &host);
    assert_eq!(never.hours_to_limit(), Some(0.0));
}

/// Shards in any order draw the robots that a single run draws, to the byte; more robots of the same seed are the same
/// ones and more, another limit is no other joint.
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
    // A part that is lost is computed again, the other one is found.
    parts.0.lock().unwrap().pop_first();
    let kept = host.times.load(Ordering::Relaxed);
    assert_eq!(drawn(&text(2, ""), 1, &parts, &host), ((1, 1), robots.clone()));
    let limited = text(2, "[limits]\npath_mm = 1\n");
    assert_eq!(drawn(&limited, 1, &parts, &host), ((0, 2), robots.clone()));
    let (done, more) = drawn(&text(3, ""), 2, &parts, &host);
    assert_eq!((done, &more[..2]), ((1, 2), &robots[..]));
    assert_eq!(host.times.load(Ordering::Relaxed), kept + 2);
}

/// A mass in front of an upright axis tilts its bearings forward: the tool sinks by moment/stiffness × lever.
#[test]
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

/// Swings of ± 10, 30 and 60 % of the rated torque on the bench against the model, which knows the loop to ± rated torque
/// alone. Where the flanks change sides, below 3 % of the rated torque, the loop jumps between two points of the bench: by
/// more than a tenth of the lost motion, and there nothing is compared.
#[test]
fn inner_loops_are_near_the_bench() {
    let shipped = ["rv-40e", "rv-80e"].map(|name| crate::templates::design(name).unwrap());
    let random = [3, 6].map(|seed| crate::random_designs::sound_design(seed).0);
    for design in shipped.iter().chain(&random) {
        inner_loops_of(design);
    }
}

fn inner_loops_of(design: &crate::design::Design) {
    use crate::dynamics::JointSettings;
    use crate::rig::hysteresis_loop;
    let name = design.name.value.as_str();
    let (machine, _) = crate::analyses::rig::with_friction(&design.machine(), false);
    let settings = JointSettings::default();
    let rated = machine.rated.torque;
    let points: Vec<(f64, f64)> =
        hysteresis_loop(&machine, &settings, 0.0).unwrap().iter().map(|p| (p.torque, p.angle)).collect();
    let whole = Loop::new(&points, rated).unwrap();
    let mut torques: Vec<f64> = points.iter().map(|point| point.0).collect();
    torques.sort_by(f64::total_cmp);
    torques.dedup();
    // Between two points of the loop the flanks change sides.
    let crosses = |torque: f64| {
        let upper = torques.partition_point(|t| *t <= torque).clamp(1, torques.len() - 1);
        let gives =
            |rises: bool| whole.branch(rises, torques[upper]) - whole.branch(rises, torques[upper - 1]);
        torque.abs() < crate::rig::LOST_MOTION_SHARE * rated
            && [true, false].into_iter().any(|rises| gives(rises) > 0.1 * whole.lost_motion())
    };
    for share in [0.1, 0.3, 0.6] {
        let mut smaller = machine.clone();
        smaller.rated.torque *= share;
        let bench = hysteresis_loop(&smaller, &settings, 0.0).unwrap();
        let mut standing = Standing::settled(&whole);
        let mut worst = 0.0_f64;
        for turn in 0..2 {
            for point in &bench {
                let wind_up = standing.load(point.torque);
                if turn == 1 && !crosses(point.torque) {
                    worst = worst.max((wind_up - point.angle).abs());
                }
            }
        }
        let span = bench[0].angle - bench[bench.len() / 2 - 1].angle;
        println!("{name}, ± {share} of the rated torque: off by {:.2} % of its way", 100.0 * worst / span);
        assert!(worst < 0.01 * span, "{name} {share}: {worst} {span}");
    }
}

const PAYLOAD: &str = "[payload]\nmass_kg = 20\ncentre_mm = [1000, 0, 0]\n";

/// A variant may ask no more of an axis than the robot as it is: neither torque nor speed.
#[test]
fn variants_keep_the_limits_of_the_axes() {
    let variant = |changes: &str, joint: &str| {
        let joint = format!("design = \"rv-40e.toml\"\n{joint}");
        let text = one_axis(
            "[0, -1, 0]",
            20.0,
            &joint,
            &format!("{READ}{PAYLOAD}[[variant]]\nname = \"v\"\n{changes}\n"),
        );
        let file = RobotFile::parse(&text, "one.toml").unwrap();
        let files = with_readings(&to_and_fro(-20.0, 0.0, 10.0));
        run(&file, &RobotOptions::default(), &files, &Memory::default())
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    // 20° in 10 s are 3.1 °/s at most; 21 times 20 kg on a metre ask for 4119 N·m, and without a limit five times the
    // rated torque are allowed.
    let fast = variant("speed_share = 2", "speed_deg_s = 4").unwrap_err();
    assert!(fast.contains("°/s are allowed"), "{fast}");
    let heavy = variant("payload_share = 20", "").unwrap_err();
    assert!(heavy.contains("N·m are allowed"), "{heavy}");
    assert_eq!(variant("speed_share = 1", "speed_deg_s = 4"), Ok(()));
}

/// A variant in other poses is the robot whose program goes there; where the limits of an axis end it is refused.
#[test]
#[ignore = "long"]
fn a_variant_in_other_poses_is_the_program_there() {
    let text = |variant: &str| {
        one_axis(
            "[0, -1, 0]",
            20.0,
            "design = \"rv-40e.toml\"\n",
            &format!("{READ}{PAYLOAD}[controller]\ncompensates = \"none\"\n{variant}"),
        )
    };
    let variant = |added: &str| text(&format!("[[variant]]\nname = \"v\"\nadded_deg = {added}\n"));
    let robot = answered(&variant("[80]"), &with_readings(&to_and_fro(-20.0, 0.0, 10.0)));
    let there = answered(&text(""), &with_readings(&to_and_fro(60.0, 80.0, 10.0)));
    let variant_of = &robot.tool.as_ref().unwrap().variants[0].figures;
    let tool = there.tool.as_ref().unwrap();
    let (now, expected) = (&tool.figures[0].1, &tool.figures[1].1);
    // Lives are scaled by the work, not computed anew.
    let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 5e-3, "{a} {b} {now:?}");
    near(variant_of.position, expected.position);
    near(variant_of.repeatability, expected.repeatability);
    let held = robot.tool.as_ref().unwrap().figures[1].1.position;
    assert!((variant_of.position / held - 1.0).abs() > 0.05, "{held}");
    let refused = |added: &str| {
        let file = RobotFile::parse(&variant(added), "one.toml").unwrap();
        let files = with_readings(&to_and_fro(-20.0, 0.0, 10.0));
        run(&file, &RobotOptions::default(), &files, &Memory::default()).unwrap_err().to_string()
    };
    assert!(refused("[450]").contains("to 430°"), "{}", refused("[450]"));
    assert!(refused("[1, 2]").contains("2 angles, the arm 1 axes"), "{}", refused("[1, 2]"));
}

/// A life in the cache is taken for its own key alone, and whole.
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
    // One digit of a number changed: still JSON, no longer the life.
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
