//! The command as a user meets it: exit status, texts, files.

use std::path::Path;
use std::process::Output;

use tempfile::TempDir;

fn arcmin(directory: &Path, arguments: &[&str]) -> Output {
    assert_cmd::Command::cargo_bin("arcmin").unwrap().current_dir(directory).args(arguments).output().unwrap()
}

fn texts(output: &Output) -> (String, String) {
    (String::from_utf8(output.stdout.clone()).unwrap(), String::from_utf8(output.stderr.clone()).unwrap())
}

/// A directory with the default design as d.toml.
fn with_design() -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    assert!(arcmin(directory.path(), &["new", "d.toml"]).status.success());
    directory
}

fn summary(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path.join("summary.json")).unwrap()).unwrap()
}

fn edit(directory: &Path, from: &str, to: &str) {
    let file = directory.join("d.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.contains(from));
    std::fs::write(file, text.replacen(from, to, 1)).unwrap();
}

fn leftovers(directory: &Path) -> Vec<String> {
    let names =
        std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.starts_with('.')).collect()
}

#[test]
fn help_of_every_command_runs_and_shows_an_example() {
    let directory = tempfile::tempdir().unwrap();
    let (help, _) = texts(&arcmin(directory.path(), &["--help"]));
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| !line.trim().is_empty())
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(commands.len() >= 4, "{help}");
    for command in commands.into_iter().filter(|command| *command != "help") {
        let output = arcmin(directory.path(), &[command, "--help"]);
        assert!(output.status.success() && texts(&output).0.contains("Examples:"), "{command}");
    }
}

#[test]
fn new_does_not_overwrite_unless_told_so() {
    let directory = with_design();
    std::fs::write(directory.path().join("d.toml"), "mine").unwrap();
    let refused = arcmin(directory.path(), &["new", "d.toml"]);
    assert_eq!(refused.status.code(), Some(2));
    assert_eq!(texts(&refused).1, "  × d.toml exists already\n  help: --force overwrites it\n");
    assert_eq!(std::fs::read_to_string(directory.path().join("d.toml")).unwrap(), "mine");
    assert!(arcmin(directory.path(), &["new", "rv-80e", "d.toml", "--force"]).status.success());
    assert!(std::fs::read_to_string(directory.path().join("d.toml")).unwrap().contains("RV-80E"));
    let unknown = arcmin(directory.path(), &["new", "rv-9", "e.toml"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert_eq!(
        texts(&unknown).1,
        "  × no template is called \"rv-9\"\n  help: templates are rv-40e-81, rv-80e\n"
    );
}

#[test]
fn shipped_designs_have_no_error_findings() {
    let directory = with_design();
    arcmin(directory.path(), &["new", "rv-80e", "e.toml"]);
    for design in ["d.toml", "e.toml"] {
        let output = arcmin(directory.path(), &["check", design]);
        assert_eq!(output.status.code(), Some(0), "{}", texts(&output).0);
    }
    assert_eq!(summary(&directory.path().join("out/d/check"))["errors"], 0);
}

#[test]
fn an_error_finding_exits_with_one_and_says_what_to_change() {
    let directory = with_design();
    edit(directory.path(), "pin_radius_mm = 3 ", "pin_radius_mm = 4.9 ");
    let output = arcmin(directory.path(), &["check", "d.toml"]);
    assert_eq!(output.status.code(), Some(1));
    let (out, _) = texts(&output);
    assert!(
        out.contains("ERROR    undercut: the generating pin radius 4.900 mm exceeds the smallest convex radius of the pin path, 4.612 mm at 64.9°"),
        "{out}"
    );
    assert!(out.contains("change: smaller pins, smaller eccentricity, or a larger pin circle"));
}

#[test]
fn profile_writes_the_flank_with_its_closed_forms() {
    let directory = with_design();
    assert!(arcmin(directory.path(), &["profile", "d.toml", "--points", "50"]).status.success());
    let out = directory.path().join("out/d/profile");
    let summary = summary(&out);
    assert_eq!(summary["ratio"], 81.0);
    assert_eq!(summary["short_width_coefficient"], 0.8125);
    assert!((summary["inflection_deg"].as_f64().unwrap() - 34.644).abs() < 5e-4);
    assert!((summary["min_convex_flank_radius_mm"].as_f64().unwrap() - 1.6117).abs() < 5e-5);
    assert_eq!(summary["design"]["name"], "RV-40E-81");
    let table = std::fs::read_to_string(out.join("profile.csv")).unwrap();
    assert!(table.starts_with("tau_deg,meshing_angle_deg,x_mm,y_mm,normal_x,normal_y,curvature_radius_mm,"));
    assert_eq!(table.lines().count(), 1 + 39 * 50);
    // Tip and root radii: R_p ± a − r_p.
    let radii: Vec<f64> = table
        .lines()
        .skip(1)
        .map(|line| {
            let fields: Vec<f64> = line.split(',').take(6).map(|field| field.parse().unwrap()).collect();
            assert!((fields[4].hypot(fields[5]) - 1.0).abs() < 1e-12);
            fields[2].hypot(fields[3])
        })
        .collect();
    let (low, high) =
        radii.iter().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), r| (low.min(*r), high.max(*r)));
    assert!((low - 59.7).abs() < 1e-9 && (high - 62.3).abs() < 1e-9, "{low} {high}");
}

#[test]
fn uniform_wear_moves_the_flank_along_its_normal() {
    let directory = with_design();
    assert!(
        arcmin(
            directory.path(),
            &["profile", "d.toml", "--points", "20", "--wear-um", "60", "--out", "worn"]
        )
        .status
        .success()
    );
    let table = std::fs::read_to_string(directory.path().join("worn/profile.csv")).unwrap();
    for line in table.lines().skip(1) {
        let f: Vec<Option<f64>> = line.split(',').map(|field| field.parse().ok()).collect();
        let at = |index: usize| f[index].unwrap();
        assert!((at(2) - at(7) - 0.06 * at(4)).abs() < 1e-12 && (at(3) - at(8) - 0.06 * at(5)).abs() < 1e-12);
    }
}

#[test]
fn same_input_same_bytes() {
    let directory = with_design();
    for (out, threads) in [("a", "1"), ("b", "2")] {
        assert!(
            arcmin(directory.path(), &["profile", "d.toml", "--out", out, "--threads", threads, "--quiet"])
                .status
                .success()
        );
    }
    let read = |out: &str| std::fs::read(directory.path().join(out).join("profile.csv")).unwrap();
    assert!(read("a") == read("b"));
}

const LENGTH_WITHOUT_UNIT: &str = "  × `pin_radius` lacks its unit
    ╭─[d.toml:14:1]
 13 │ pin_circle_radius_mm = 64             # Tao2024, Table 1
 14 │ pin_radius = 3                     # Tao2024, Table 1
    · ──────────
 15 │ material = \"GCr15\"                    # Tao2024, Table 2
    ╰────
  help: units are part of the keys: write `pin_radius_mm = 3` if 3 is in mm
";

const ABSURD_VALUE: &str = "  × `pin_radius_mm` is outside of what this program believes
    ╭─[d.toml:14:17]
 13 │ pin_circle_radius_mm = 64             # Tao2024, Table 1
 14 │ pin_radius_mm = 3000                     # Tao2024, Table 1
    ·                 ────
 15 │ material = \"GCr15\"                    # Tao2024, Table 2
    ╰────
  help: 0.1 to 200 mm are believable; if the value is in µm, write pin_radius_mm = 3
";

const UNKNOWN_SECTION: &str = "  × unknown key `lead` in the design file
     ╭─[d.toml:100:2]
  99 │\x20
 100 │ [lead]
     ·  ────
 101 │ rated_torque_n_m = 412                # Tao2024, at the output
     ╰────
  help: did you mean `load`?
";

#[test]
fn design_errors_show_the_line_and_the_remedy() {
    let directory = with_design();
    edit(directory.path(), "pin_radius_mm = 3 ", "pin_radius = 3 ");
    let output = arcmin(directory.path(), &["check", "d.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(texts(&output).1, LENGTH_WITHOUT_UNIT);
    edit(directory.path(), "pin_radius = 3 ", "pin_radius_mm = 3000 ");
    assert_eq!(texts(&arcmin(directory.path(), &["check", "d.toml"])).1, ABSURD_VALUE);
    edit(directory.path(), "pin_radius_mm = 3000 ", "pin_radius_mm = 3 ");
    edit(directory.path(), "[load]", "[lead]");
    assert_eq!(texts(&arcmin(directory.path(), &["profile", "d.toml"])).1, UNKNOWN_SECTION);
    assert!(!directory.path().join("out").exists(), "nothing is created for a design that cannot be read");
}

#[test]
fn a_missing_design_and_a_binary_one_are_clear_errors() {
    let directory = tempfile::tempdir().unwrap();
    let missing = arcmin(directory.path(), &["check", "nowhere.toml"]);
    assert_eq!(missing.status.code(), Some(2));
    let expected = "  × cannot read nowhere.toml: No such file or directory (os error 2)\n  help: `arcmin new FILE` writes a design file to start from\n";
    assert_eq!(texts(&missing).1, expected);
    std::fs::write(directory.path().join("b.toml"), [0xff, 0xfe, 0x00]).unwrap();
    let binary = arcmin(directory.path(), &["check", "b.toml"]);
    assert_eq!(binary.status.code(), Some(2));
    assert!(texts(&binary).1.contains("cannot read b.toml: invalid utf-8"));
}

#[test]
fn a_file_in_place_of_the_output_directory_is_a_clear_error() {
    let directory = with_design();
    std::fs::write(directory.path().join("blocked"), "precious").unwrap();
    for out in ["blocked", "blocked/deeper"] {
        let output = arcmin(directory.path(), &["profile", "d.toml", "--out", out]);
        assert_eq!(output.status.code(), Some(2));
        let (_, error) = texts(&output);
        assert!(
            error.contains(&format!("cannot write {out}: "))
                && error.contains("choose another place with --out"),
            "{error}"
        );
    }
    assert_eq!(std::fs::read_to_string(directory.path().join("blocked")).unwrap(), "precious");
}

/// A disk that is full after some kilobytes: the limit of the file size with its signal ignored gives the
/// same kind of write error.
#[cfg(unix)]
#[test]
fn a_full_disk_is_a_clear_error_and_keeps_earlier_results() {
    let directory = with_design();
    let out = directory.path().join("full");
    assert!(
        arcmin(directory.path(), &["profile", "d.toml", "--points", "4", "--out", "full"]).status.success()
    );
    let before =
        (std::fs::read(out.join("profile.csv")).unwrap(), std::fs::read(out.join("summary.json")).unwrap());
    let script = "trap '' XFSZ; ulimit -f 16; exec \"$0\" profile d.toml --points 2000 --out full";
    let binary = assert_cmd::cargo::cargo_bin("arcmin");
    let output = std::process::Command::new("bash")
        .args(["-c", script])
        .arg(binary)
        .current_dir(directory.path())
        .output()
        .unwrap();
    let (_, error) = texts(&output);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(
        error.contains("cannot write full/profile.csv: File too large") && error.contains("make room"),
        "{error}"
    );
    assert!(
        before
            == (
                std::fs::read(out.join("profile.csv")).unwrap(),
                std::fs::read(out.join("summary.json")).unwrap()
            )
    );
    assert!(leftovers(&out).is_empty(), "{:?}", leftovers(&out));
}

/// Kills runs at many moments: whatever is found under a final name is complete.
#[test]
fn a_killed_run_leaves_no_damaged_file() {
    let directory = with_design();
    let binary = assert_cmd::cargo::cargo_bin("arcmin");
    let out = directory.path().join("killed");
    let arguments = ["profile", "d.toml", "--points", "3000", "--out", "killed", "--quiet"];
    assert!(arcmin(directory.path(), &arguments).status.success());
    let complete = std::fs::read(out.join("profile.csv")).unwrap();
    let mut interrupted = 0;
    for attempt in 0..30 {
        let mut child = std::process::Command::new(&binary)
            .args(arguments)
            .current_dir(directory.path())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(4 * attempt));
        if child.try_wait().unwrap().is_none() {
            interrupted += 1;
        }
        let _ = child.kill();
        child.wait().unwrap();
        assert!(std::fs::read(out.join("profile.csv")).unwrap() == complete, "attempt {attempt}");
        // Between the first new table and the new summary there is none; a damaged one would not parse.
        if out.join("summary.json").exists() {
            assert_eq!(summary(&out)["points_per_lobe"], 3000);
        }
    }
    assert!(interrupted > 0, "no run was interrupted: nothing was tested");
}

/// Runs with `arguments` and sends SIGINT after each of the delays (ms) until a run was interrupted while it
/// computed; returns what it said.
#[cfg(unix)]
fn interrupted(directory: &Path, arguments: &[&str], delays: impl Iterator<Item = u64>) -> Option<String> {
    let binary = assert_cmd::cargo::cargo_bin("arcmin");
    for delay in delays {
        let mut command = std::process::Command::new(&binary);
        let child = command
            .args(arguments)
            .current_dir(directory)
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(delay));
        std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        let output = child.wait_with_output().unwrap();
        // Before the handler stands the signal ends the process without a code.
        if output.status.code() == Some(2) {
            return Some(texts(&output).1);
        }
    }
    None
}

/// Ctrl-C ends the main job cleanly: it says so, leaves no temporary file, and the results of the run before
/// untouched.
#[cfg(unix)]
#[test]
fn an_interrupted_life_keeps_earlier_results() {
    let directory = with_design();
    let arguments = ["life", "d.toml", "--quasi-static", "--points", "2", "--out", "life", "--quiet"];
    assert!(arcmin(directory.path(), &arguments).status.success());
    let out = directory.path().join("life");
    let read = |name: &str| std::fs::read(out.join(name)).unwrap();
    let before: Vec<_> = ["life.csv", "wear.csv", "report.html", "summary.json"].map(read).into();
    let said = interrupted(directory.path(), &arguments, (0..20).map(|i| 60 + 10 * i))
        .expect("no run was interrupted: nothing was tested");
    assert!(said.contains("stopped before the end"), "{said}");
    let after: Vec<_> = ["life.csv", "wear.csv", "report.html", "summary.json"].map(read).into();
    assert!(before == after);
    assert_eq!(leftovers(&out), Vec::<String>::new());
}

/// An interrupted simulation goes on from its checkpoint to the same bytes.
#[cfg(unix)]
#[test]
fn an_interrupted_simulation_resumes_to_the_same_result() {
    let directory = with_design();
    let arguments = ["simulate", "d.toml", "--load", "constant", "--end-s", "6", "--quiet", "--out"];
    let whole = [&arguments[..], &["whole"]].concat();
    assert!(arcmin(directory.path(), &whole).status.success());
    let parts = [&arguments[..], &["parts"]].concat();
    let said = interrupted(directory.path(), &parts, (0..20).map(|i| 150 + 10 * i))
        .expect("no run was interrupted: nothing was tested");
    assert!(said.contains("checkpoint.json"), "{said}");
    assert!(directory.path().join("parts/checkpoint.json").exists());
    let resumed = arcmin(directory.path(), &[&parts[..], &["--resume"]].concat());
    assert!(resumed.status.success(), "{}", texts(&resumed).1);
    let read = |name: &str| std::fs::read(directory.path().join(name).join("timeseries.csv")).unwrap();
    assert!(read("whole") == read("parts"));
}

#[test]
fn a_reader_who_leaves_early_does_no_harm() {
    let directory = with_design();
    let script = "\"$0\" check d.toml | head -c 1 > /dev/null; exit ${PIPESTATUS[0]}";
    let binary = assert_cmd::cargo::cargo_bin("arcmin");
    let output = std::process::Command::new("bash")
        .args(["-c", script])
        .arg(binary)
        .current_dir(directory.path())
        .output()
        .unwrap();
    assert_eq!((output.status.code(), texts(&output).1.as_str()), (Some(0), ""));
}

#[test]
fn wrong_usage_exits_with_two() {
    let directory = with_design();
    for arguments in [
        &["profile"][..],
        &["profil", "d.toml"],
        &["profile", "d.toml", "--wear-um", "nan"],
        &["profile", "d.toml", "--points", "0"],
    ] {
        assert_eq!(arcmin(directory.path(), arguments).status.code(), Some(2), "{arguments:?}");
    }
}

/// Load sharing and coupled wear with every body in its bearings, and lost motion by cause that adds up.
#[test]
fn bearings_serve_load_sharing_wear_and_life() {
    let directory = with_design();
    let run = |arguments: &[&str]| {
        let output = arcmin(directory.path(), arguments);
        assert!(output.status.success(), "{arguments:?}: {}", texts(&output).1);
    };
    run(&["contact", "d.toml", "--joints", "bearings", "--positions", "36", "--out", "c"]);
    let contact = summary(&directory.path().join("c"));
    assert!(contact["te_loaded_arcmin"].as_f64().unwrap() < -1.0 && contact["joints"] == "bearings");
    assert_eq!(contact["disc_torque_shares"].as_array().unwrap().len(), 2);
    run(&["wear", "d.toml", "--joints", "bearings", "--hours", "100", "--points", "1", "--out", "w"]);
    assert!(summary(&directory.path().join("w"))["max_depth_um"].as_f64().unwrap() > 0.1);
    run(&["life", "d.toml", "--quasi-static", "--points", "2", "--out", "l"]);
    let causes = summary(&directory.path().join("l"))["lost_motion_causes"].clone();
    let value = |key: &str| causes[key].as_f64().unwrap();
    let sum: f64 = causes
        .as_object()
        .unwrap()
        .iter()
        .filter(|(key, _)| *key != "whole_arcmin")
        .map(|(_, value)| value.as_f64().unwrap())
        .sum();
    assert!(
        (sum - value("whole_arcmin")).abs() < 1e-9
            && value("residual_arcmin").abs() < 0.01 * value("whole_arcmin"),
        "{causes}"
    );
    assert!(value("flank_wear_arcmin") > 0.05 && value("turning_arm_clearance_arcmin") > 0.05);
    let wrong =
        arcmin(directory.path(), &["contact", "d.toml", "--joints", "bearings", "--method", "closed-form"]);
    assert_eq!(wrong.status.code(), Some(2));
}

/// A bench run whose own tables are given back as measured finds its own figures, and draws them into the
/// report.
#[test]
fn rig_evaluates_measured_curves_as_its_own() {
    let directory = with_design();
    let quick =
        ["rig", "d.toml", "--positions", "2", "--te-positions", "256", "--errors", "drawn", "--seed", "7"];
    assert!(arcmin(directory.path(), &[&quick[..], &["--out", "a"]].concat()).status.success());
    let measured = ["--measured", "a/hysteresis.csv", "--measured", "a/te.csv", "--out", "b"];
    let (stdout, stderr) = texts(&arcmin(directory.path(), &[&quick[..], &measured].concat()));
    assert!(stdout.contains("measured"), "{stdout}{stderr}");
    let (a, b) = (summary(&directory.path().join("a")), summary(&directory.path().join("b")));
    assert_eq!(a["errors"], serde_json::json!({ "source": "drawn", "seed": 7 }));
    for key in ["lost_motion_arcmin", "backlash_arcmin", "stiffness_nm_per_arcmin"] {
        let (own, read) = (a[key].as_f64().unwrap(), b["measured"][key].as_f64().unwrap());
        assert!((own - read).abs() < 1e-9 * own, "{key}: {own} {read}");
    }
    assert_eq!(b["measured"]["transmission_error"].as_array().unwrap().len(), 4);
    let mean = |s: &serde_json::Value| s[1]["mean_arcmin"].as_f64().unwrap();
    assert!((mean(&a["transmission_error"]) - mean(&b["measured"]["transmission_error"])).abs() < 1e-9);
    let page = std::fs::read_to_string(directory.path().join("b/report.html")).unwrap();
    assert!(page.contains("Strongest orders, measured") && page.contains("seed 7"));
    let errors = std::fs::read_to_string(directory.path().join("a/errors.csv")).unwrap();
    assert!(errors.lines().count() > 120 && errors.contains("pin 40,tangential,"), "{errors}");
    // Another seed is another machine.
    let other = [
        "rig",
        "d.toml",
        "--positions",
        "1",
        "--te-positions",
        "64",
        "--errors",
        "drawn",
        "--seed",
        "8",
        "--out",
        "c",
    ];
    assert!(arcmin(directory.path(), &other).status.success());
    assert_ne!(std::fs::read_to_string(directory.path().join("c/errors.csv")).unwrap(), errors);
}

#[test]
fn measured_files_and_manufacturing_errors_that_do_not_fit_are_answered_with_their_line() {
    let directory = with_design();
    let refused = |arguments: &[&str], words: &[&str]| {
        let output = arcmin(directory.path(), arguments);
        let text = texts(&output).1.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(2), "{arguments:?} {text}");
        words.iter().for_each(|word| assert!(text.contains(word), "{arguments:?}: {text}"));
    };
    let write = |name: &str, text: &str| std::fs::write(directory.path().join(name), text).unwrap();
    write("loop.csv", "torque_n_m,angle_arcmin,branch\n1,0.1,falling\n\n2,0.2,up\n");
    refused(
        &["rig", "d.toml", "--measured", "loop.csv"],
        &["loop.csv, line 4", "\"up\"", "neither falling nor rising"],
    );
    write("te.csv", "output_angle_deg,te_arcmin\n0,0.1\n1,x\n");
    refused(
        &["rig", "d.toml", "--measured", "te.csv"],
        &["te.csv, line 3", "\"x\" in the column te_arcmin is not a number"],
    );
    write("other.csv", "# a comment\na,b\n1,2\n");
    refused(
        &["rig", "d.toml", "--measured", "other.csv"],
        &["other.csv, line 2", "neither a hysteresis loop nor a transmission error"],
    );
    refused(
        &["rig", "d.toml", "--errors", "given"],
        &["the design gives no manufacturing errors", "[errors]"],
    );
    refused(&["rig", "d.toml", "--seed", "3"], &["--errors drawn"]);
    refused(
        &["simulate", "d.toml", "--errors", "drawn"],
        &["ideal joints have no place for manufacturing errors", "--joints bearings"],
    );
    edit(
        directory.path(),
        "[tolerances]",
        "[[errors.measured_flanks]]\ndisc = 1\nfile = \"flank.csv\"\n[tolerances]",
    );
    refused(&["rig", "d.toml"], &["flank.csv"]);
    let flank = |change: &dyn Fn(usize) -> f64| {
        let rows: Vec<String> =
            (0..720).map(|i| format!("{},{}", change(i), 2.0 * (i as f64 / 40.0).sin())).collect();
        write("flank.csv", &format!("angle_deg,depth_um\n{}\n", rows.join("\n")));
    };
    flank(&|i| if i == 100 { 3.0 } else { 0.5 * i as f64 });
    refused(&["rig", "d.toml"], &["flank.csv, line 102", "the angles must rise, but 3° follows 49.5°"]);
    flank(&|i| 0.3 * i as f64);
    refused(&["rig", "d.toml"], &["flank.csv, line 721", "39 lobes need a point every 2.308° at least"]);
    flank(&|i| 0.5 * i as f64);
    let output = arcmin(
        directory.path(),
        &["rig", "d.toml", "--positions", "1", "--te-positions", "64", "--out", "r"],
    );
    assert!(output.status.success(), "{}", texts(&output).1);
    assert_eq!(summary(&directory.path().join("r"))["errors"]["source"], "given");
}

/// The elastic disc goes to ParaView complete: a file that ends as it should, with displacement, stress and
/// modes.
#[test]
fn the_elastic_disc_is_written_for_paraview() {
    let directory = with_design();
    let output = arcmin(
        directory.path(),
        &["contact", "d.toml", "--flexible", "--positions", "8", "--vtu", "--out", "out", "--quiet"],
    );
    assert!(output.status.success(), "{}", texts(&output).1);
    let text = std::fs::read_to_string(directory.path().join("out/disc.vtu")).unwrap();
    assert!(text.trim_end().ends_with("</VTKFile>"));
    for field in ["displacement (m)", "mode 8"] {
        assert!(text.contains(field), "{field}");
    }
}

/// Elastic discs in bearings through all commands that take them; one reduction serves all. Bores tied to one
/// spider are refused before anything is meshed.
#[test]
fn elastic_discs_run_in_bearings() {
    let directory = with_design();
    let run = |arguments: &[&str], out: &str| {
        let mut all = arguments.to_vec();
        all.extend(["--out", out, "--cache", "cache", "--quiet"]);
        arcmin(directory.path(), &all)
    };
    let output = run(
        &["simulate", "d.toml", "--model", "flexible", "--joints", "bearings", "--bores", "common"],
        "no",
    );
    assert!(!output.status.success());
    assert!(texts(&output).1.contains("one spider for all bores"), "{}", texts(&output).1);
    assert!(!directory.path().join("cache").exists());
    let loaded = ["--load", "constant", "--rise-s", "0.02", "--end-s", "0.1"];
    let output = run(
        &[&["simulate", "d.toml", "--model", "flexible", "--joints", "bearings"], &loaded[..]].concat(),
        "s",
    );
    assert!(output.status.success(), "{}", texts(&output).1);
    let result = summary(&directory.path().join("s"));
    assert!(result["solver"]["energy_residual"].as_f64().unwrap() < 1e-6, "{result}");
    assert!((-2.6..-2.0).contains(&result["te"]["mean_arcmin"].as_f64().unwrap()), "{result}");
    for (command, more) in [("contact", ["--positions", "8"]), ("wear", ["--hours", "100"])] {
        let output =
            run(&[command, "d.toml", "--flexible", "--joints", "bearings", more[0], more[1]], command);
        assert!(output.status.success(), "{}", texts(&output).1);
        let result = summary(&directory.path().join(command));
        assert_eq!(
            (result["joints"].as_str(), result["elastic_discs"].as_bool()),
            (Some("bearings"), Some(true)),
            "{result}"
        );
    }
    let output = run(&["rig", "d.toml", "--flexible", "--positions", "1", "--te-positions", "64"], "rig");
    assert!(output.status.success(), "{}", texts(&output).1);
    let split = std::fs::read_to_string(directory.path().join("rig/stiffness.csv")).unwrap();
    assert!(split.contains("cycloid discs"), "{split}");
    assert!(
        std::fs::read_to_string(directory.path().join("rig/report.html")).unwrap().contains("Elastic disc")
    );
}
