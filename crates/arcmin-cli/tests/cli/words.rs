//! `new`, `check`, `keys`, help: commands and texts before a computation.

use crate::common::*;

#[test]
fn help_of_every_command_runs_and_shows_an_example() {
    let directory = tempfile::tempdir().unwrap();
    let help = good(directory.path(), &["--help"]);
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| !line.trim().is_empty())
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    for word in ["new", "keys", "check", "profile", "contact", "wear", "calibrate", "simulate", "rig"] {
        assert!(commands.contains(&word), "{word}: {help}");
    }
    for command in commands.into_iter().filter(|command| *command != "help") {
        assert!(good(directory.path(), &[command, "--help"]).contains("Examples:"), "{command}");
    }
}

#[test]
fn every_analysis_takes_the_same_words() {
    let directory = tempfile::tempdir().unwrap();
    let common = ["--out <DIR>", "--threads <N>", "--quiet"];
    let fidelity = ["--joints <", "--discs <", "--errors <", "--seed <"];
    for (command, words) in [
        ("check", &["--json", "--explain"][..]),
        ("profile", &["--points <", "--wear-um <"]),
        ("contact", &["--method <", "--wear-um <", "--hours <", "--torque-nm <"]),
        ("wear", &["--mode <", "--hours <"]),
        ("calibrate", &["[DATA]", "--reading <", "--limit <"]),
        (
            "simulate",
            &[
                "--wear-um <",
                "--hours <",
                "--load <",
                "--torque-nm <",
                "--period-s <",
                "--drag-nm <",
                "--end-s <",
                "--contact <",
                "--resume",
            ],
        ),
        ("rig", &["--hours <", "--measured <"]),
    ] {
        let help = good(directory.path(), &[command, "-h"]);
        let shared: &[&str] = if matches!(command, "check" | "profile") { &[] } else { &fidelity };
        for word in common.iter().chain(words).chain(shared) {
            assert!(help.contains(word), "{command} {word}: {help}");
        }
        for word in fidelity.iter().filter(|_| !shared.is_empty()) {
            assert_eq!(help.matches(word).count(), 1, "{command} {word}");
        }
    }
    let ideal = ["contact", "simulate"];
    for command in ["contact", "simulate", "wear", "calibrate", "rig"] {
        let help = good(directory.path(), &[command, "-h"]);
        let line = help.lines().skip_while(|line| !line.contains("--joints <")).take(3).collect::<String>();
        let word = if ideal.contains(&command) { "ideal" } else { "bearings" };
        assert!(line.contains(&format!("[default: {word}]")), "{command}: {line}");
    }
}

#[test]
#[ignore = "long"]
fn new_lists_its_templates_and_writes_one() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    let list = good(d, &["new", "--list"]);
    let first: Vec<&str> = list.lines().filter_map(|line| line.split_whitespace().next()).collect();
    let drives = ["nema17-19", "printed-15", "steel-59", "two-ring-225", "two-stage-500"];
    assert_eq!(first, [&["rv-40e", "rv-80e", "tao2024"][..], &drives].concat());
    assert_eq!(names(d), Vec::<String>::new(), "a list writes nothing");
    assert!(good(d, &["new", "d.toml"]).ends_with("next: arcmin check d.toml\n"));
    good(d, &["new", "rv-80e", "e.toml"]);
    good(d, &["new", "nema17-19", "f.toml"]);
    // A file with the name of a template contains that one.
    good(d, &["new", "tao2024.toml"]);
    assert!(
        read(d, "f.toml").contains("family = \"eccentric\"") && read(d, "tao2024.toml").contains("Tao2024")
    );
    assert!(read(d, "d.toml").contains("RV-40E-81") && read(d, "e.toml").contains("RV-80E"));
    for template in first {
        let file = format!("shipped-{template}.toml");
        good(d, &["new", template, &file]);
        let said = good(d, &["check", &file]);
        assert!(said.contains(" 0 errors"), "shipped designs have no error findings: {said}");
    }
}

/// A single stage has the commands of its family; all others are refused with the family's name.
#[test]
#[ignore = "long"]
fn single_stages_are_known_to_some_commands() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    good(d, &["new", "nema17-19", "s.toml"]);
    good(d, &["contact", "s.toml", "--positions", "24", "--out", "c"]);
    let pins = read(d, "c/output_pins.csv");
    assert!(pins.starts_with("crank_angle_deg,disc,pin,force_n,pressure_mpa,gap_um\n"), "{pins}");
    assert_eq!(pins.lines().count(), 1 + 24 * 2 * 6);
    good(d, &["rig", "s.toml", "--positions", "2", "--te-positions", "12", "--out", "r"]);
    let summary: serde_json::Value = serde_json::from_str(&read(d, "r/summary.json")).unwrap();
    let part = |key: &str| summary["play_chain"][key].as_f64().unwrap();
    let sum = part("ring_arcmin") + part("eccentric_bearing_arcmin") + part("output_arcmin");
    assert!((part("total_arcmin") - sum).abs() < 1e-9 && summary["ratio"] == -19.0, "{summary}");
    good(d, &["export", "profile", "s.toml", "--format", "dxf", "--out", "e"]);
    good(d, &["life", "s.toml", "--points", "4", "--quasi-static", "--out", "l"]);
    let life: serde_json::Value = serde_json::from_str(&read(d, "l/summary.json")).unwrap();
    assert!(life["verdict"]["ok"] == true && life["hours_to_limit"].as_f64().unwrap() > 2000.0, "{life}");
    assert_eq!(read(d, "l/life.csv").lines().count(), 6);
    assert!(refused(d, &["life", "s.toml", "--bodies", "elastic"]).contains("\"rigid\""));
    assert!(refused(d, &["life", "s.toml", "--band"]).contains("[unknowns]"));
    let rows = life_rows(&read(d, "l/life.csv"));
    write(d, "read.csv", &rows);
    good(d, &["calibrate", "s.toml", "read.csv", "--out", "k"]);
    let found: serde_json::Value = serde_json::from_str(&read(d, "k/summary.json")).unwrap();
    let k = found["wear_coefficient_per_pa"].as_f64().unwrap();
    assert!((k / 1e-18 - 1.0).abs() < 0.03, "{k:e}");
    for (file, words) in [
        ("lost_motion_arcmin\n17\n", "hours"),
        ("hours,depth_um\n0,3\n", "counts from new"),
        ("hours,lost_motion_arcmin\n0,17\n900,17\n", "has not grown"),
        ("hours,depth_um\n100,x\n", "depth_um"),
        ("hours,depth_um\n", "no rows"),
    ] {
        write(d, "bad.csv", file);
        let said = refused(d, &["calibrate", "s.toml", "bad.csv", "--out", "b"]);
        assert!(said.contains("bad.csv") && said.replace("\n  │ ", " ").contains(words), "{said}");
    }
    let said = good(d, &["simulate", "s.toml", "--load", "constant", "--end-s", "0.05", "--out", "m"]);
    assert!(said.contains("TE  mean") || read(d, "m/summary.json").contains("\"complete\": true"), "{said}");
    let said =
        good(d, &["export", "joint", "s.toml", "--hours", "0,500", "--te-positions", "64", "--out", "j"]);
    assert!(said.contains("friction is assumed") && said.contains("output assumed"), "{said}");
    let joint: serde_json::Value = serde_json::from_str(&read(d, "j/joint.json")).unwrap();
    assert!(joint["ratio"] == -19.0 && joint["states"][1]["hours"] == 500.0, "{}", joint["ratio"]);
    let said = refused(d, &["tao2024", "s.toml"]);
    assert!(said.contains("RV reducers only") && said.contains("single stages can be used with"), "{said}");
    // Any file replaces the shared library, which is read before the model is created.
    let ideal =
        ["export", "fmu", "s.toml", "--model", "multibody", "--joints", "ideal", "--library", "s.toml"];
    let said = refused(d, &ideal);
    assert!(said.replace("\n  │ ", " ").contains("no model in ideal joints"), "{said}");
    let said = refused(d, &["new", "--like", "nema17-19", "--ratio", "30", "--torque-nm", "3", "x.toml"]);
    assert!(said.contains("is a single stage"), "{said}");
}

/// Hours and lost motion of a life as a file of readings.
fn life_rows(life: &str) -> String {
    let mut lines = life.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let [hours, lost] =
        ["hours", "lost_motion_arcmin"].map(|name| head.iter().position(|h| *h == name).unwrap());
    let rows = lines.map(|line| format!("{},{}\n", line[hours], line[lost]));
    format!("hours,lost_motion_arcmin\n{}", rows.collect::<String>())
}

/// The same for drives of two rings and of two stages, with both flanks and the pins of both.
#[test]
#[ignore = "long"]
fn two_rings_and_two_stages_are_known_to_some_commands() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    for (name, ratio, other) in [("two-ring-225", 225.0, "second"), ("two-stage-500", 500.0, "first_stage")] {
        let file = format!("{name}.toml");
        good(d, &["new", name, &file]);
        assert!(good(d, &["check", &file]).contains(" 0 errors"));
        let ask = |command: &str, more: &[&str]| {
            good(d, &[&[command, file.as_str(), "--out", "o", "--force"][..], more].concat());
            serde_json::from_str::<serde_json::Value>(&read(d, "o/summary.json")).unwrap()
        };
        let contact = ask("contact", &["--positions", "12"]);
        assert!(contact["ratio"] == ratio && contact[format!("{other}_max_force_n")].as_f64().unwrap() > 0.0);
        assert!(read(d, &format!("o/{other}_contact.csv")).lines().count() > 24);
        let rig = ask("rig", &["--positions", "2", "--te-positions", "12"]);
        assert!(rig["play_chain"][format!("{other}_ring_arcmin")].as_f64().unwrap() > 0.0, "{rig}");
        ask("profile", &["--points", "8"]);
        assert!(read(d, &format!("o/{other}_profile.csv")).lines().count() > 100);
        good(d, &["export", "profile", &file, "--format", "dxf", "--out", "e"]);
        assert!(read(d, "e/profile.dxf") != read(d, &format!("e/{other}_profile.dxf")));
        let motion = ask("simulate", &["--load", "constant", "--rise-s", "0.02", "--end-s", "0.04"]);
        assert!(motion["complete"] == true && motion["te"]["max_abs_arcmin"].as_f64().unwrap() > 1.0);
        let worn = ask("wear", &["--hours", "20", "--points", "2"]);
        assert!(worn[format!("{other}_max_depth_um")].as_f64().unwrap() > 0.0, "{worn}");
        assert_eq!(read(d, &format!("o/{other}_wear.csv")).lines().count(), 1 + 3 * 720);
        let life = ask("life", &["--points", "4"]);
        assert!(life["verdict"]["ok"] == true && life["max_depth_um"].as_f64().unwrap() > 0.1, "{life}");
        assert_eq!(read(d, "o/life.csv").lines().count(), 6);
        ask("contact", &["--hours", "9", "--positions", "8"]);
        let found = ask("calibrate", &["--reading", "500h=3um", "--limit", "lost_motion"]);
        assert!(found["wear_coefficient_per_pa"].as_f64().unwrap() > 0.0, "{found}");
        assert!(
            good(d, &["check", "o/calibrated.toml", "--out", &format!("k-{name}")]).contains(" 0 errors")
        );
        let said = refused(d, &["tao2024", &file]);
        assert!(said.contains("drive of two") && said.contains("contact, wear,"), "{said}");
        good(d, &["export", "joint", &file, "--te-positions", "64", "--out", "j"]);
        assert!(read(d, "j/joint.json").contains(&format!("\"ratio\": {ratio:.1}")));
    }
}

/// A single stage is proposed from its requirements and passes its checks, or is refused with a sufficient
/// change.
#[test]
#[ignore = "long"]
fn single_stages_are_proposed() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    let propose = |more: &[&'static str]| {
        [&["new", "--family", "eccentric", "--outer-diameter-mm", "80"][..], more].concat()
    };
    let said = good(d, &propose(&["--ratio", "20", "--torque-nm", "20", "s.toml"]));
    assert!(
        said.contains("Nearest to its limit: ")
            && said.contains("In 80 mm the rules reach")
            && said.ends_with("next: arcmin check s.toml\n"),
        "{said}"
    );
    assert!(read(d, "s.toml").contains("pin_count = 21 "));
    assert!(good(d, &["check", "s.toml"]).contains(" 0 errors"));
    good(d, &["rig", "s.toml", "--positions", "2", "--te-positions", "12"]);
    let two = ["--ratio", "10.5", "--torque-nm", "20", "--tooth-difference", "2", "two.toml"];
    good(d, &propose(&two));
    let text = read(d, "two.toml");
    assert!(text.contains("pin_count = 23 ") && text.contains("tooth_difference = 2 "), "{text}");
    assert!(good(d, &["check", "two.toml"]).contains(" 0 errors"));
    let printed = propose(&["--ratio", "11", "--process", "printed-fdm", "--speed-rpm", "300", "p.toml"]);
    let said = refused(d, &[&printed[..], &["--torque-nm", "60"]].concat());
    assert!(said.contains("carries 60 N·m") && said.contains("one of these does"), "{said}");
    good(d, &[&printed[..], &["--torque-nm", "4"]].concat());
    assert!(read(d, "p.toml").contains("PLA") && read(d, "p.toml").contains("input_speed_rpm = 300 "));
    for (arguments, words) in [
        (propose(&["--ratio", "20", "--torque-nm", "20"]), "one file"),
        (propose(&["--ratio", "20", "x.toml"]), "add --torque-nm"),
        (propose(&["--ratio", "20.5", "--torque-nm", "20", "x.toml"]), "20 or 21 does"),
        (
            propose(&["--ratio", "20.3", "--torque-nm", "20", "--tooth-difference", "2", "x.toml"]),
            "20 or 20.5 does",
        ),
        (propose(&["--ratio", "20", "--torque-nm", "20", "--tooth-difference", "3", "x.toml"]), "1..=2"),
        (propose(&["--ratio", "500", "--torque-nm", "20", "x.toml"]), "a ratio of 500"),
        (propose(&["--ratio", "20", "--torque-nm", "nan", "x.toml"]), "a torque"),
        (propose(&["--ratio", "20", "--torque-nm", "20", "--process", "cast", "x.toml"]), "wire-edm"),
        (propose(&["--ratio", "20", "--torque-nm", "20", "--lost-motion-arcmin", "1", "x.toml"]), "--like"),
        (propose(&["--ratio", "20", "--torque-nm", "20", "s.toml"]), "exists already"),
        (vec!["new", "--family", "excentric", "x.toml"], "eccentric"),
        (vec!["new", "--process", "milled", "x.toml"], "--family"),
    ] {
        let said = refused(d, &arguments);
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
    assert_eq!(names(d).iter().filter(|name| name.ends_with(".toml")).count(), 3);
}

#[test]
fn new_overwrites_only_with_the_option() {
    let directory = with_design();
    let d = directory.path();
    write(d, "d.toml", "mine");
    assert_eq!(refused(d, &["new", "d.toml"]), "  × d.toml exists already\n  help: --force overwrites it\n");
    assert_eq!(read(d, "d.toml"), "mine");
    good(d, &["new", "rv-80e", "d.toml", "--force"]);
    assert!(read(d, "d.toml").contains("RV-80E"));
    assert_eq!(
        refused(d, &["new", "rv-9", "e.toml"]),
        "  × there is no template \"rv-9\"\n  help: RV reducers: rv-40e, rv-80e, tao2024\n        \
         other drives: nema17-19, printed-15, steel-59, two-ring-225, two-stage-500\n"
    );
    assert_eq!(
        refused(d, &["new", "rv-80e"]),
        "  × rv-80e is a template; the name of the file to write is missing\n  \
         help: `arcmin new rv-80e rv-80e.toml` writes rv-80e.toml\n"
    );
    assert_eq!(
        refused(d, &["new"]),
        "  × the name of the file to write is missing\n  help: `arcmin new my-reducer.toml`, or `arcmin new --list`\n"
    );
    assert_eq!(names(d), ["d.toml"]);
}

#[test]
fn an_error_finding_exits_with_one_and_a_remedy() {
    let directory = with_machine_of_paper();
    edit(directory.path(), "pin_radius_mm = 3 ", "pin_radius_mm = 4.9 ");
    let output = arcmin(directory.path(), &["check", "d.toml"]);
    assert_eq!(output.status.code(), Some(1));
    let (said, _) = texts(&output);
    assert!(
        said.contains(
            "ERROR    undercut: the generating pin radius 4.900 mm exceeds the smallest convex radius of the \
             pin path, 4.612 mm at 64.9°"
        ),
        "{said}"
    );
    assert!(said.contains("change: smaller pins, smaller eccentricity, or a larger pin circle"));
    let words: Vec<&str> = said.lines().filter_map(|line| line.split_whitespace().next()).collect();
    let rank = |word: &&str| ["ERROR", "WARNING", "ok"].iter().position(|known| known == word);
    let ranks: Vec<usize> = words.iter().filter_map(rank).collect();
    assert!(ranks.len() > 20 && ranks.is_sorted(), "the worst first: {said}");
    assert!(!said.contains('\u{1b}'), "no colours where nobody looks");
}

#[test]
fn check_as_json_is_the_summary_and_writes_no_file() {
    let directory = with_machine_of_paper();
    let d = directory.path();
    edit(d, "pin_radius_mm = 3 ", "pin_radius_mm = 4.9 ");
    let output = arcmin(d, &["check", "d.toml", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(names(d), ["d.toml"]);
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let first = &told["findings"][0];
    assert_eq!((first["severity"].as_str(), first["code"].as_str()), (Some("error"), Some("undercut")));
    assert_eq!(first["value"], 4.9);
    assert!((first["limit"].as_f64().unwrap() - 4.6117).abs() < 1e-4);
    assert_eq!(told["errors"].as_u64().unwrap(), 1 + told["findings"][1]["severity"].eq("error") as u64);
    good(d, &["new", "e.toml"]);
    good(d, &["check", "e.toml", "--quiet", "--out", "e"]);
    let of_file = summary(d, "e");
    let told: serde_json::Value = serde_json::from_str(&good(d, &["check", "e.toml", "--json"])).unwrap();
    assert_eq!(told["findings"], of_file["findings"]);
}

#[test]
fn keys_explain_the_design_and_the_results() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    let all = good(d, &["keys"]);
    assert!(all.contains("| `pin_radius_mm` |") && all.contains("## `[load]`"));
    let some = good(d, &["keys", "PIN_radius"]);
    assert!(some.contains("## `[ring]`") && some.contains("| `pin_radius_mm` |"), "{some}");
    assert!(!some.contains("clearance_um") && some.lines().count() < 60, "{some}");
    let results = good(d, &["keys", "--results"]);
    for name in ["contact.csv", "wear_history.csv", "`max_force_n`", "`te.mean_abs_arcmin`", "`max_depth_um`"]
    {
        assert!(results.contains(name), "{name}");
    }
    let some = good(d, &["keys", "--results", "half_width"]);
    assert!(some.contains("contact.csv") && some.contains("| `half_width_um` |"), "{some}");
    assert!(!some.contains("timeseries"), "{some}");
    assert_eq!(
        refused(d, &["keys", "phlogiston"]),
        "  × no line contains \"phlogiston\"\n  help: try a part of the word, or no filter\n"
    );
}

#[test]
fn keys_are_found_by_their_paths() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    for (path, section, key) in [
        ("crankshafts.count", "## `[crankshafts]`", "| `count` |"),
        ("duty[0].torque_n_m", "## `[[duty]]`", "| `torque_n_m` |"),
        ("Bearings.turning_arm.clearance_um", "## `[bearings.turning_arm]`", "| `clearance_um` |"),
        ("disc.holes.count", "## `[[disc.holes]]`", "| `count` |"),
    ] {
        let found = good(d, &["keys", path]);
        assert!(found.contains(section) && found.contains(key), "{path}: {found}");
        assert_eq!(found.lines().filter(|line| line.starts_with("| `")).count(), 1, "{path}: {found}");
    }
    assert!(refused(d, &["keys", "crankshaft.count"]).contains("try its last part: `arcmin keys count`"));
}

#[test]
fn extra_words_are_refused_with_the_valid_ones() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    let answer = |arguments: &[&str]| refused(d, arguments);
    let hours = answer(&["life", "d.toml", "--hours", "100"]);
    assert!(hours.contains("tip: '--hours' is an option of contact, wear, simulate, rig"), "{hours}");
    assert!(hours.contains("Usage: arcmin life [OPTIONS] <DESIGN>") && !hours.contains("bores"), "{hours}");
    let out = answer(&["new", "--out", "x"]);
    assert!(
        out.contains("tip: '--out' is an option of most other commands") && !out.contains("outer-diameter"),
        "{out}"
    );
    let place = answer(&["life", "d.toml", "results"]);
    assert!(place.contains("tip: '--out results' sets the directory for results"), "{place}");
    let torque = answer(&["life", "d.toml", "--torque", "5"]);
    assert!(
        torque.contains("'--torque-nm' is an option of new, contact") && !torque.contains("force"),
        "{torque}"
    );
    assert!(
        answer(&["contact", "d.toml", "--torque", "5"]).contains("similar argument exists: '--torque-nm'")
    );
    assert!(
        answer(&["contact", "d.toml", "--jonts", "ideal"]).contains("similar argument exists: '--joints'")
    );
    assert!(!answer(&["export", "profile", "d.toml", "-x"]).contains("tip:"));
}

#[test]
fn missing_files_are_reported_with_the_command_that_writes_them() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    good(d, &["new", "d.toml"]);
    good(d, &["study", "new", "s.toml", "--design", "d.toml"]);
    assert!(refused(d, &["check", "none.toml"]).contains("`arcmin new FILE` writes a design file"));
    assert!(refused(d, &["study", "none.toml"]).contains("`arcmin study new FILE` writes a study file"));
    assert!(refused(d, &["import", "duty", "d.toml", "none.csv"]).contains("check its name and path"));
    let elsewhere = refused(d, &["study", "collect", "s.toml"]).replace("\n        ", " ");
    assert!(elsewhere.contains("if they are in another directory, give it with --out"), "{elsewhere}");
}

#[test]
fn keys_are_also_a_schema_for_editors() {
    let directory = tempfile::tempdir().unwrap();
    let text = good(directory.path(), &["keys", "--json-schema"]);
    let schema: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(schema["$schema"].as_str().unwrap().contains("json-schema.org"));
    assert!(schema["properties"]["ring"].to_string().contains("pin_radius_mm"), "{text:.300}");
}

#[test]
fn completions_and_manual_page_name_the_commands() {
    let directory = tempfile::tempdir().unwrap();
    assert!(good(directory.path(), &["completions", "bash"]).contains("simulate"));
    assert!(good(directory.path(), &["man"]).starts_with(".ie"));
    good(directory.path(), &["man", "--out", "."]);
    // Every page referred to by the first one exists.
    let first = std::fs::read_to_string(directory.path().join("arcmin.1")).unwrap().replace('\\', "");
    let pages: Vec<&str> = first.lines().filter_map(|line| line.strip_suffix("(1)")).collect();
    assert!(pages.contains(&"arcmin-life"), "{pages:?}");
    assert!(pages.iter().all(|page| directory.path().join(format!("{page}.1")).exists()), "{pages:?}");
}

/// Files named in a design are a part of it: a missing one is an error finding like any other.
#[test]
fn check_looks_for_the_files_of_a_design() {
    let directory = with_design();
    let d = directory.path();
    edit(d, "[tolerances]", "[[errors.measured_flanks]]\ndisc = 1\nfile = \"gone.csv\"\n[tolerances]");
    for arguments in [&["check", "d.toml", "--out", "o"][..], &["check", "d.toml", "--json"]] {
        let output = arcmin(d, arguments);
        let (said, complaint) = texts(&output);
        assert_eq!(output.status.code(), Some(1), "{said}{complaint}");
        assert!(said.contains("gone.csv"), "{said}");
    }
    let summary = summary(d, "o");
    assert_eq!((figure(&summary, "errors"), figure(&summary, "error_findings")), (1.0, 1.0));
}
