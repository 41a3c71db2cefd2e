//! `arcmin robot`, from the command line.

use std::process::{Command, Stdio};
use std::time::Duration;

use crate::common::*;

/// The example with joints that are computed quickly.
fn with_robot() -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    good(d, &["robot", "new", "arm.toml"]);
    let quick = "ages = 2\npositions = 1\nte_positions = 64\n";
    write(d, "arm.toml", &read(d, "arm.toml").replace("ages = 7\n", quick));
    directory
}

/// The error of the example with one change; nothing is written.
fn wrong(from: &str, to: &str) -> String {
    let directory = with_robot();
    let d = directory.path();
    let text = read(d, "arm.toml");
    assert!(text.contains(from), "{from}");
    write(d, "arm.toml", &text.replacen(from, to, 1));
    let said = refused(d, &["robot", "arm.toml", "--out", "out", "--loads"]);
    assert!(!d.join("out/summary.json").exists());
    said
}

#[test]
#[ignore = "long"]
fn the_example_runs_as_it_is() {
    let directory = with_robot();
    let d = directory.path();
    let said = good(d, &["robot", "arm.toml", "--cache", "cache", "--out", "out"]);
    assert!(said.contains("arm-20kg") && said.contains("lost motion"), "{said}");
    has_columns(d, "out/joints.csv", "joint, hours, torque_rms_n_m, lost_motion_arcmin, share_at_tool_mm");
    let told = summary(d, "out");
    let position = figure(&told, "tool.position_error_mm");
    assert!(position > 0.0 && figure(&told, "tool.repeatability_mm") > 0.0, "{told}");
    let limited = told["limited_by"].as_str().unwrap();
    assert!(limited.starts_with("axis "), "{limited}");
    let hours = figure(&told, "hours_to_limit");
    assert!(hours > 0.0 && hours < 20000.0, "{hours}");
    assert_eq!(told["verdict"]["ok"], false);
    // The contributions of the joints add up to the total at every age.
    let of = |name: &str| -> Vec<f64> {
        column(d, "out/joints.csv", name).iter().map(|cell| cell.parse().unwrap()).collect()
    };
    let (shares, when) = (of("share_at_tool_mm"), of("hours"));
    let last: f64 = shares.iter().zip(&when).filter(|(_, h)| **h == 20000.0).map(|(share, _)| share).sum();
    assert!((last - position).abs() < 1e-9, "{last} {position}");
    for file in [
        "tool",
        "poses",
        "path",
        "loads",
        "duty",
        "motion",
        "overhauls",
        "plan",
        "levers",
        "compensation",
        "compensation_waves",
        "remains",
        "variants",
        "reach",
    ] {
        assert!(read(d, &format!("out/{file}.csv")).lines().count() > 1, "{file}");
    }
    // A joint's design with its duty is a complete design.
    good(d, &["check", "out/joint-2.toml", "--out", "checked"]);
    // The same program gives the same joints; a slower one causes less wear.
    good(d, &["robot", "arm.toml", "--lives", "out/lives.json", "--cache", "cache", "--out", "again"]);
    assert_eq!(figure(&summary(d, "again"), "tool.position_error_mm"), position);
    // Again from the cache, identical to the byte.
    good(d, &["robot", "arm.toml", "--cache", "cache", "--out", "cached"]);
    for file in ["joints.csv", "tool.csv", "path.csv", "lives.json"] {
        assert_eq!(read(d, &format!("out/{file}")), read(d, &format!("cached/{file}")), "{file}");
    }
}

#[test]
fn existing_files_are_not_overwritten() {
    let directory = with_robot();
    let d = directory.path();
    let said = refused(d, &["robot", "new", "arm.toml"]);
    assert!(said.contains("arm.toml exists already"), "{said}");
    good(d, &["robot", "new", "other.toml"]);
    write(d, "rv-20e.toml", "mine");
    let said = refused(d, &["robot", "new", "third.toml"]);
    assert!(said.contains("rv-20e.toml exists already"), "{said}");
    assert_eq!(read(d, "rv-20e.toml"), "mine");
}

#[test]
fn faults_of_a_robot_file_are_reported_with_their_place() {
    let said = wrong("planned_hours", "planed_hours");
    assert!(said.contains("planed_hours") && said.contains("did you mean `planned_hours`"), "{said}");
    let said = wrong("axis = \"axis 3\"", "axis = \"axis 33\"");
    assert!(
        said.contains("no axis is called \"axis 33\"") && said.contains("axes are axis 1, axis 2"),
        "{said}"
    );
    let said = wrong("angles_deg = [45, 30, 10, 0, -40, 0]", "angles_deg = [45, 130, 10, 0, -40, 0]");
    assert!(
        said.contains("takes the axis \"axis 2\" to 130°") && said.contains("range is -80° to 120°"),
        "{said}"
    );
    let said = wrong("angles_deg = [45, 30, 10, 0, -40, 0]", "angles_deg = [45, 30, 10]");
    assert!(said.contains("3 angles, the arm 6 axes"), "{said}");
    let said = wrong("cycles_per_hour = 240", "cycles_per_hour = 2400");
    assert!(said.contains("cannot run 2400 times an hour") && said.contains("is the most"), "{said}");
    let said = wrong("mass_kg = 20\n", "mass_kg = 400\n");
    assert!(said.contains("N·m are allowed") && said.contains("handling"), "{said}");
    let said = wrong("inertia_kg_m2 = [3.4, 3.9, 3.1]", "inertia_kg_m2 = [3.4, 3.9]");
    assert!(said.contains("2 numbers") && said.contains("xx, yy, zz"), "{said}");
    let said = wrong("design = \"rv-80e.toml\"", "design = \"rv-90e.toml\"");
    assert!(said.contains("rv-90e.toml"), "{said}");
    let said = wrong("mass_kg = 52\n", "");
    assert!(said.contains("mass_kg"), "{said}");
}

/// A table of angles: decreasing time, angles beyond the limits, columns of axes that do not exist.
#[test]
fn faults_of_a_program_are_reported_with_their_line() {
    let directory = with_robot();
    let d = directory.path();
    let text = read(d, "arm.toml");
    let program = text.find("[[program]]").unwrap();
    let limits = text.find("[limits]").unwrap();
    let given = "[[program]]\nname = \"t\"\nfile = \"t.csv\"\ncycles_per_hour = 10\n\n";
    write(d, "t.toml", &format!("{}{given}{}", &text[..program], &text[limits..]));
    let head = "time_s,axis_1_deg,axis_2_deg,axis_3_deg,axis_4_deg,axis_5_deg,axis_6_deg\n";
    let said = |table: &str| {
        write(d, "t.csv", table);
        refused(d, &["robot", "t.toml", "--loads", "--out", "t"])
    };
    let back = said(&format!("{head}0,0,0,0,0,0,0\n1,5,0,0,0,0,0\n0.5,9,0,0,0,0,0\n"));
    assert!(back.contains("line 4") && back.contains("rise"), "{back}");
    let far = said(&format!("{head}0,0,0,0,0,0,0\n1,5,0,0,0,0,0\n2,9,125,0,0,0,0\n"));
    assert!(far.contains("line 4") && far.contains("goes to 125°"), "{far}");
    let fast = said(&format!("{head}0,0,0,0,0,0,0\n0.1,50,0,0,0,0,0\n0.2,100,0,0,0,0,0\n"));
    assert!(fast.contains("°/s are allowed"), "{fast}");
    let other =
        said("time_s,axis_1_deg,axis_2_deg,axis_3_deg,axis_4_deg,axis_5_deg,axis_7_deg\n0,0,0,0,0,0,0\n");
    assert!(other.contains("axis_7_deg") || other.contains("axis_6_deg"), "{other}");
    write(d, "t.csv", &format!("{head}0,0,0,0,0,0,0\n1,5,0,0,0,0,0\n2,0,0,0,0,0,0\n"));
    good(d, &["robot", "t.toml", "--loads", "--out", "t"]);
}

/// A joint may be a drive of another family, with the mounting of its design; here it is too small for its arm.
#[test]
fn a_design_of_another_family_is_a_joint() {
    let directory = with_robot();
    let d = directory.path();
    good(d, &["new", "nema17-19", "s.toml"]);
    let text = read(d, "arm.toml").replacen("design = \"", "design = \"s.toml\" # \"", 1);
    write(d, "s-arm.toml", &text);
    let said = refused(d, &["robot", "s-arm.toml", "--out", "out"]);
    assert!(said.contains("a single stage has the mounting of its design"), "{said}");
    write(d, "s-arm.toml", &text.replacen("\nmounting = ", "\n# mounting = ", 1));
    let said = refused(d, &["robot", "s-arm.toml", "--out", "out"]);
    assert!(said.contains("15 N·m are allowed"), "{said}");
}

/// One axis with an RV-40E and three drawn robots, as `validation/study/check.py` has them.
fn drawn() -> String {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/study/robot.toml");
    let text = std::fs::read_to_string(file).unwrap();
    assert!(text.ends_with("[population]\nrobots = 4\n"));
    text.replace("robots = 4", "robots = 3")
}

/// A killed shard, an interrupted one, and processes for the missing robots: together the robots of a single
/// run, identical to the byte, each computed with its own cache.
#[test]
#[ignore = "long"]
fn drawn_robots_go_on_after_a_kill() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    good(d, &["new", "rv-40e", "d.toml"]);
    write(d, "one.toml", &drawn());
    good(d, &["robot", "one.toml", "--cache", "first", "--out", "whole"]);
    let shard = |cache: &str| {
        let words = ["robot", "run", "one.toml", "--cache", cache, "--out", "k", "--threads", "1", "--quiet"];
        Command::new(binary()).args(words).current_dir(d).stderr(Stdio::null()).spawn().unwrap()
    };
    let parts = || {
        let entries = std::fs::read_dir(d.join("k/parts")).into_iter().flatten().flatten();
        entries.filter(|entry| entry.path().extension().is_some_and(|ending| ending == "parquet")).count()
    };
    let mut killed = shard("second");
    while parts() == 0 {
        assert!(killed.try_wait().unwrap().is_none(), "over before it can be killed");
        std::thread::sleep(Duration::from_millis(20));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert!(parts() < 3);
    let mut stopped = shard("second");
    std::thread::sleep(Duration::from_millis(300));
    Command::new("kill").args(["-INT", &stopped.id().to_string()]).status().unwrap();
    assert_eq!(stopped.wait().unwrap().code(), Some(2));
    let submit =
        ["robot", "submit", "one.toml", "--engine", "local", "--shards", "3", "--workers", "2", "--out", "k"];
    let submitted =
        Command::new(binary()).args(submit).current_dir(d).env("XDG_CACHE_HOME", d.join("third")).output();
    assert!(submitted.unwrap().status.success());
    assert_eq!(names(&d.join("whole/parts")), names(&d.join("k/parts")));
    for name in names(&d.join("whole/parts")) {
        let of = |out: &str| std::fs::read(d.join(out).join("parts").join(&name)).unwrap();
        assert!(of("whole") == of("k"), "{name}");
    }
    assert_eq!(read(d, "whole/population.csv"), read(d, "k/population.csv"));
    assert_eq!(read(d, "whole/population.csv").lines().count(), 4);
    // The study is complete: nothing is computed.
    let said = good(d, &["robot", "run", "one.toml", "--shard", "2/2", "--out", "k"]);
    assert!(said.contains("0 drawn robots computed, 1 were computed before"), "{said}");
    for (engine, file, runs) in
        [("hq", "hq.sh", "robot run"), ("dask", "on_dask.py", "\"robot run\".split()")]
    {
        let submit = ["robot", "submit", "one.toml", "--engine", engine, "--out", "k", "--print"];
        assert!(good(d, &submit).contains(file));
        let script = read(d, &format!("k/submit/{file}"));
        assert!(script.contains(runs) && script.contains("one.toml"), "{script}");
    }
    write(d, "alone.toml", &drawn().replace("[population]\nrobots = 3\n", ""));
    let said = refused(d, &["robot", "d.toml", "--out", "k"]);
    assert!(said.contains("d.toml is the design of a reducer"), "{said}");
    let said = refused(d, &["robot", "run", "alone.toml", "--out", "k"]);
    assert!(said.contains("no drawn robots") && said.contains("[population]"), "{said}");
}
