//! Limits of the tool, overhauls and changes of the program.

use super::*;

/// A joint overhauled at the start has the same age as without, at the end it is new, in between it has the age
/// since; an overhaul after a limit is exceeded gains nothing, one before it the hours that the joint then
/// lasts.
#[test]
#[ignore = "long"]
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

/// Every limit ends the hours when its figure reaches it. Under a weight of constant direction lost motion is
/// an offset of the pose and does not contribute to its repeatability, which depends on the axis without load.
/// With all limits the first one applies.
#[test]
#[ignore = "long"]
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
        // Each at another fraction.
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
    // A new robot exceeds every limit: 0 hours.
    let never = answered(&two_axes("[limits]\npath_mm = 1e-5\n"), &host);
    assert_eq!(never.hours_to_limit(), Some(0.0));
}

const PAYLOAD: &str = "[payload]\nmass_kg = 20\ncentre_mm = [1000, 0, 0]\n";

/// Variants may not exceed torque and speed limits of an axis, like the robot itself.
#[test]
#[ignore = "long"]
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
    // 20° in 10 s are 3.1 °/s at most; 21 times 20 kg on a metre require 4119 N·m, and without a limit five
    // times the rated torque are allowed.
    let fast = variant("speed_share = 2", "speed_deg_s = 4").unwrap_err();
    assert!(fast.contains("°/s are allowed"), "{fast}");
    let heavy = variant("payload_share = 20", "").unwrap_err();
    assert!(heavy.contains("N·m are allowed"), "{heavy}");
    assert_eq!(variant("speed_share = 1", "speed_deg_s = 4"), Ok(()));
}

/// A variant in other poses equals the robot with a program in these poses; beyond the limits of an axis it is
/// refused.
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
    // Lives are scaled by the work, not computed again.
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
