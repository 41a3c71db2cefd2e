//! Joints compared with the test bench.

use super::*;

/// A weight that loads the joint up to ± its rated torque: the displacement of the tool at a distance of one
/// metre agrees with the bench's loop and transmission error, and the joint's lost motion at the end agrees
/// with `rig` and `life` for its design with its duty.
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

    // The bench, computed again for the design that the run has written.
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
    // `life` computes lost motion without friction, at crank positions of its own; it agrees with the bench's
    // loop without friction at these. With friction the middle of the branches is 0.2 % smaller, and two
    // positions represent all.
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

    // On the path the displacement of the tool, perpendicular to the arm, is the angle times one metre.
    for (hours, state) in [(0.0, &bench.states[0]), (6000.0, &bench.states[1])] {
        let loop_points = &state.torsion_loop;
        let half = loop_points.len() / 2;
        let between = |branch: &[(f64, f64)], torque: f64| -> f64 {
            let pair =
                branch.windows(2).find(|pair| (pair[0].0 - torque) * (pair[1].0 - torque) <= 0.0).unwrap();
            pair[0].1 + (torque - pair[0].0) / (pair[1].0 - pair[0].0) * (pair[1].1 - pair[0].1)
        };
        let (mut seen, mut worst) = (0, 0.0_f64);
        for place in &tool.sorted.paths {
            let here = &tool.places.places[*place];
            if !(20.0..280.0).contains(&here.time) && !(321.0..581.0).contains(&here.time) {
                continue;
            }
            let angle = here.angles[0];
            // The weight causes a torque against the angle, largest for a horizontal arm; the small torque for
            // its acceleration is added.
            let torque = -here.loads[0].torque;
            assert!((torque + mass * 9.80665 * angle.cos()).abs() < 0.02);
            let rising = here.time < 300.0;
            let branch = if rising { &loop_points[half..] } else { &loop_points[..half] };
            let waves = joint.ages[usize::from(hours > 0.0)].transmission_error(angle, torque);
            let expected = between(branch, torque) + waves;
            let moved = tool.field.tool(&tool.places, &[hours], *place)[0];
            let up = nalgebra::Vector3::new(-angle.sin(), 0.0, angle.cos());
            // The branches of the bench do not meet exactly at their tips; the model uses their middle there.
            let allowed = if torque.abs() < 0.9 * rated { 1e-11 } else { 2e-6 };
            worst = worst.max((moved.dot(&up) - expected).abs() / allowed);
            seen += 1;
        }
        println!("{seen} places, off by {:.1e} m at most on a metre", worst * 1e-11);
        assert!(seen > 300 && worst < 1.0, "{worst}");
    }
}

/// Cycles of ±10, 30 and 60 % of the rated torque on the bench compared with the model, which uses the loop to
/// ± rated torque only. Where the loaded flanks change, below 3 % of the rated torque, the loop of the bench
/// jumps between two points by more than a tenth of the lost motion; nothing is compared there.
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
    // The loaded flanks change between two points of the loop.
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
