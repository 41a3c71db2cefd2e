//! The whole way, on arms whose answers are known.

use super::*;
use crate::analyses::{AnalysisError, Host, NoHost, Origin};
use crate::design::InputFile;
use crate::progress::{Progress, Silent};
use crate::study::Memory;

/// Files by their names.
struct Files(Vec<(String, Vec<u8>)>);

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
        match self.0.iter().find(|(name, _)| *name == file.0) {
            Some((_, bytes)) => Ok(bytes.clone()),
            None => NoHost.read(file, origin),
        }
    }
}

fn files() -> Files {
    Files(
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
fn with_readings(readings: &[(f64, f64)]) -> Files {
    let mut text = String::from("time_s,a_deg\n");
    for (time, angle) in readings {
        text.push_str(&format!("{time},{angle}\n"));
    }
    let design = crate::templates::find("rv-40e").unwrap().text;
    Files(vec![(RV_40E.to_owned(), design.as_bytes().to_vec()), ("p.csv".to_owned(), text.into_bytes())])
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

fn answered(text: &str, files: &Files) -> Robot {
    let file = RobotFile::parse(text, "one.toml").unwrap_or_else(|error| panic!("{error}: {text}"));
    run(&file, &RobotOptions::default(), files, &Memory::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// A weight that takes the joint to ± its rated torque: the tool a metre away is where the bench's loop and its
/// transmission error say, and the joint's lost motion at the end is that of `rig` and of `life` for its design with
/// its duty.
#[test]
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
    };
    let bench = crate::analyses::joint::joint(&design, &options, &NoHost).unwrap();
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
    // `life` takes its lost motion from more crank positions.
    let share = life_end / joint.ages[1].lost_motion;
    assert!((share - 1.0).abs() < 0.01, "{share}");

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

/// A life in the cache is taken for its own key alone, and whole.
#[test]
fn kept_lives_are_checked() {
    use std::sync::Mutex;
    struct Keeping(Files, Mutex<Vec<(String, Vec<u8>)>>, Mutex<usize>);
    impl Progress for Keeping {
        fn report(&self, stage: &str, share: f64) {
            self.0.report(stage, share);
        }
        fn is_cancelled(&self) -> bool {
            false
        }
    }
    impl Host for Keeping {
        fn read(&self, file: &InputFile, origin: Origin) -> Result<Vec<u8>, AnalysisError> {
            self.0.read(file, origin)
        }
        fn cached(&self, name: &str) -> Option<Vec<u8>> {
            let kept = self.1.lock().unwrap();
            kept.iter().find(|(known, _)| known == name).map(|(_, bytes)| bytes.clone())
        }
        fn cache(&self, name: &str, bytes: &[u8]) {
            *self.2.lock().unwrap() += 1;
            let mut kept = self.1.lock().unwrap();
            kept.retain(|(known, _)| known != name);
            kept.push((name.to_owned(), bytes.to_vec()));
        }
    }
    let text = one_axis("[0, -1, 0]", 20.0, "design = \"rv-40e.toml\"\n", READ);
    let file = RobotFile::parse(&text, "one.toml").unwrap();
    let host = Keeping(with_readings(&to_and_fro(-20.0, 0.0, 10.0)), Mutex::new(Vec::new()), Mutex::new(0));
    let lost = || {
        let robot = run(&file, &RobotOptions::default(), &host, &Memory::default()).unwrap();
        robot.tool.unwrap().joints[0].ages[1].lost_motion
    };
    let computed = lost();
    assert_eq!((lost(), *host.2.lock().unwrap()), (computed, 1));
    // One digit of a number changed: still JSON, no longer the life.
    let damaged = {
        let mut kept = host.1.lock().unwrap();
        let entry = String::from_utf8(kept[0].1.clone()).unwrap();
        let place = entry.find("\"lost_motion_rad\":").unwrap() + "\"lost_motion_rad\":".len();
        let digit = if entry.as_bytes()[place] == b'9' { b'8' } else { b'9' };
        kept[0].1[place] = digit;
        kept[0].1 != entry.into_bytes()
    };
    assert!(damaged);
    assert_eq!((lost(), *host.2.lock().unwrap()), (computed, 2));
}

#[test]
fn the_chapter_of_the_robot_file_is_current() {
    let book = include_str!("../../../../docs/src/robot-file.md");
    assert!(book == reference_of_keys(), "rewrite it with `arcmin keys --robot > docs/src/robot-file.md`");
}

#[test]
#[ignore = "experiment"]
fn experiment_lost_motion() {
    use crate::dynamics::{BearingMeshing, JointSettings};
    use crate::load::ShareLoad;
    use crate::machine::Friction;
    use crate::rig::{evaluate_loop, hysteresis_loop};
    for name in ["rv-40e", "rv-80e"] {
        let design = crate::templates::design(name).unwrap();
        let (rubbed, _) = crate::analyses::rig::with_friction(&design.machine(), false);
        let mut smooth = rubbed.clone();
        smooth.friction =
            Friction { regularisation_speed: rubbed.friction.regularisation_speed, ..Friction::default() };
        let settings = JointSettings::default();
        let mut meshing = BearingMeshing::new(&design.machine(), &settings).unwrap();
        println!("{name}: alike {} {:?}", meshing.discs_alike(), rubbed.friction);
        for n in [5, 12, 24] {
            let life = meshing.lost_motion(n).unwrap();
            let ratio = rubbed.kinematics().housing_fixed_ratio();
            let turn = std::f64::consts::TAU * ratio / (rubbed.ring.pin_count as f64 - 1.0);
            let mean = |machine: &crate::machine::Machine, of: &dyn Fn(usize) -> f64| {
                let rated = machine.rated.torque.abs();
                (0..n)
                    .map(|i| {
                        evaluate_loop(&hysteresis_loop(machine, &settings, of(i)).unwrap(), rated)
                            .unwrap()
                            .lost_motion
                    })
                    .sum::<f64>()
                    / n as f64
            };
            let even = |i: usize| turn * i as f64 / n as f64;
            let kin = rubbed.kinematics();
            let lifes = |i: usize| {
                let crank = meshing.crank_position(i, n, 0.0, 0).radians();
                crank * turn / std::f64::consts::TAU
            };
            let places: Vec<f64> = (0..n.min(5)).map(|i| lifes(i) / turn).collect();
            println!(
                "  n {n}: life {life:.9e}; smooth loop at the bench's places {:.3e}, at life's {:.3e}; rubbed at the bench's {:.3e}, at life's {:.3e}  {places:?} {}",
                mean(&smooth, &even) / life - 1.0,
                mean(&smooth, &lifes) / life - 1.0,
                mean(&rubbed, &even) / life - 1.0,
                mean(&rubbed, &lifes) / life - 1.0,
                kin.lobe_count
            );
        }
    }
}
