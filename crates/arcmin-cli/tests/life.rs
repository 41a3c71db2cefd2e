//! The main analysis and the paper's study, from the command line.

#[path = "cli/common.rs"]
#[allow(dead_code)]
mod common;

use common::*;
use tempfile::TempDir;

const LIFE: &str = "hours, max_depth_um, play_arcmin, lost_motion_arcmin, contact_lost_motion_arcmin, \
                    te_no_load_arcmin, te_loaded_arcmin, ste_mean_arcmin, ste_max_arcmin, dte_mean_arcmin, \
                    dte_max_arcmin, max_force_n, max_pressure_mpa";

const STUDY: &str = "hours, max_depth_um, play_arcmin, te_no_load_arcmin, te_loaded_arcmin, \
                     ste_rigid_mean_arcmin, ste_rigid_max_arcmin, dte_rigid_mean_arcmin, \
                     dte_rigid_max_arcmin, ste_flexible_mean_arcmin, ste_flexible_max_arcmin, \
                     dte_flexible_mean_arcmin, dte_flexible_max_arcmin";

fn with_short_life() -> TempDir {
    let directory = with_design();
    edit(directory.path(), "service_life_h = 7500", "service_life_h = 100");
    directory
}

/// Columns of a table in any order.
fn holds(directory: &std::path::Path, file: &str, wanted: &str) {
    let found = header(directory, file);
    for name in wanted.split(", ") {
        assert!(found.iter().any(|column| column == name), "{file} lacks {name}: {found:?}");
    }
}

#[test]
fn life_writes_the_documented_files() {
    let directory = with_short_life();
    let d = directory.path();
    good(d, &["life", "d.toml", "--quasi-static", "--points", "4", "--bodies", "rigid", "--out", "l"]);
    holds(d, "l/life.csv", LIFE);
    for name in ["ste_mean_arcmin", "ste_max_arcmin", "dte_mean_arcmin", "dte_max_arcmin"] {
        assert!(column(d, "l/life.csv", name).iter().all(String::is_empty), "{name} was not asked for");
    }
    let told = summary(d, "l");
    assert_eq!(told["joints"], "bearings");
    assert!(figure(&told, "lost_motion_arcmin") > 0.5);
    assert!(told["stages"].as_object().unwrap().values().all(serde_json::Value::is_number));
    assert!(told["verdict"]["ok"].is_boolean());
    let limits = told["verdict"]["limits"].as_array().unwrap();
    let named = |name: &str| limits.iter().find(|limit| limit["limit"] == name).unwrap();
    for name in ["lost_motion", "contact_pressure", "bearing_life"] {
        let limit = named(name).as_object().unwrap();
        for key in ["value", "allowed", "hours", "transient"] {
            assert!(limit.contains_key(key), "{name} {key}");
        }
    }
    assert!(named("bearing_life")["where"].is_string());
    for key in ["hours_to_limit", "hours_to_lost_motion_limit"] {
        assert!(told.as_object().unwrap().contains_key(key), "{key}");
    }
    // The last row is the end of the service life, which the summary gives.
    let last = column(d, "l/life.csv", "lost_motion_arcmin").pop().unwrap().parse::<f64>().unwrap();
    assert!((last - figure(&told, "lost_motion_arcmin")).abs() < 1e-9 * last);
}

#[test]
#[ignore = "long"]
fn lost_motion_by_cause_adds_up() {
    let directory = with_short_life();
    let d = directory.path();
    good(d, &["life", "d.toml", "--quasi-static", "--points", "4", "--bodies", "rigid", "--out", "l"]);
    let file = "l/lost_motion_causes.csv";
    let numbers =
        |name: &str| -> Vec<f64> { column(d, file, name).iter().map(|cell| cell.parse().unwrap()).collect() };
    let parts: Vec<String> = header(d, file)
        .into_iter()
        .filter(|name| name.ends_with("_arcmin") && name != "lost_motion_arcmin")
        .collect();
    for (row, whole) in numbers("lost_motion_arcmin").into_iter().enumerate() {
        let sum: f64 = parts.iter().map(|name| numbers(name)[row]).sum();
        assert!((sum - whole).abs() < 1e-9, "row {row}: {sum} {whole}");
        assert!(numbers("residual_arcmin")[row].abs() < 0.01 * whole);
    }
}

/// An exceeded limit is a verdict, not a failure of the run.
#[test]
fn an_unkept_limit_is_no_failure() {
    let directory = with_short_life();
    let d = directory.path();
    edit(d, "lost_motion_arcmin = 1.0", "lost_motion_arcmin = 0.1");
    good(d, &["life", "d.toml", "--quasi-static", "--points", "4", "--bodies", "rigid", "--out", "l"]);
    let told = summary(d, "l");
    assert_eq!(told["verdict"]["ok"], false);
    assert_eq!(told["verdict"]["limited_by"], "lost_motion");
}

/// Without an option for the bodies the machine is judged with both kinds: limits that only one of them keeps
/// are undecided, and the verdict is not ok. The reduction of the bodies is cached: the second run finds it.
#[test]
#[ignore = "long"]
fn bodies_of_both_kinds_are_judged() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    good(d, &["new", "tao2024", "d.toml"]);
    edit(d, "service_life_h = 7500", "service_life_h = 100");
    // Between the pressures that either kind finds.
    edit(d, "contact_pressure_mpa = 2000", "contact_pressure_mpa = 1700");
    let run = |more: &[&str]| {
        let short = ["life", "d.toml", "--quasi-static", "--points", "4", "--cache", "kept", "--out", "l"];
        (good(d, &[&short[..], more].concat()), summary(d, "l"))
    };
    let (said, told) = run(&[]);
    let kept = names(&d.join("kept"));
    assert_eq!(kept.len(), 2, "discs, and carrier with housing: {kept:?}");
    let undecided = told["verdict"]["undecided"].as_array().unwrap();
    let pressure = undecided.iter().find(|one| one["limit"] == "contact_pressure").unwrap();
    assert!(figure(pressure, "rigid_value") < 1700.0 && figure(pressure, "elastic_value") > 1700.0);
    assert!(told["verdict"]["ok"] == false && said.contains("undecided"), "{said}");
    let (_, again) = run(&[]);
    assert_eq!(names(&d.join("kept")), kept);
    assert_eq!(again["verdict"]["undecided"], told["verdict"]["undecided"]);
    for bodies in ["rigid", "elastic"] {
        let (said, told) = run(&["--bodies", bodies]);
        assert!(told["verdict"]["undecided"].as_array().unwrap().is_empty(), "{told}");
        assert_eq!(said.contains("rigid bodies were chosen"), bodies == "rigid", "{said}");
    }
}

/// Ctrl-C ends the main analysis in an orderly way and keeps the results of the earlier run.
#[cfg(unix)]
#[test]
#[ignore = "long"]
fn an_interrupted_life_keeps_earlier_results() {
    let directory = with_short_life();
    let d = directory.path();
    good(d, &["life", "d.toml", "--quasi-static", "--points", "4", "--bodies", "rigid", "--out", "l"]);
    let all = || names(&d.join("l")).iter().map(|name| read(d, &format!("l/{name}"))).collect::<Vec<_>>();
    let before = all();
    edit(d, "service_life_h = 100", "service_life_h = 7500");
    let mut stopped = false;
    for delay in (0..40).map(|i| 100 + 25 * i) {
        let mut command = std::process::Command::new(binary());
        let run = command.args(["life", "d.toml", "--out", "l"]).current_dir(d);
        let child = run.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
        let child = child.spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(delay));
        std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        let output = child.wait_with_output().unwrap();
        if output.status.code() == Some(2) {
            assert!(texts(&output).1.contains("stopped before the end"), "{}", texts(&output).1);
            stopped = true;
            break;
        }
    }
    assert!(stopped, "no run was interrupted: nothing was tested");
    assert_eq!((leftovers(&d.join("l")), all()), (Vec::new(), before));
}

/// The same bytes on one thread and on two.
#[test]
#[ignore = "long"]
fn a_drawn_machine_is_the_same_on_any_number_of_threads() {
    let directory = with_short_life();
    let d = directory.path();
    let drawn = ["--errors", "drawn", "--seed", "3", "--quasi-static", "--points", "4", "--bodies", "rigid"];
    for (out, threads) in [("a", "1"), ("b", "2")] {
        good(d, &[&["life", "d.toml"][..], &drawn, &["--out", out, "--threads", threads]].concat());
    }
    let tables: Vec<String> = names(&d.join("a")).into_iter().filter(|name| name.ends_with(".csv")).collect();
    assert!(tables.iter().any(|name| name == "errors.csv"), "{tables:?}");
    for file in tables {
        assert!(read(d, &format!("a/{file}")) == read(d, &format!("b/{file}")), "{file}");
    }
}

#[test]
#[ignore = "long"]
fn life_gives_transmission_error_at_five_ages() {
    let directory = with_short_life();
    let d = directory.path();
    good(d, &["life", "d.toml", "--bodies", "rigid", "--out", "l"]);
    for name in ["ste_mean_arcmin", "ste_max_arcmin", "dte_mean_arcmin", "dte_max_arcmin"] {
        let given = column(d, "l/life.csv", name).iter().filter(|cell| !cell.is_empty()).count();
        assert!(given >= 5, "{name}: {given}");
    }
}

#[test]
fn tao2024_writes_the_documented_files() {
    let directory = with_design();
    let d = directory.path();
    good(d, &["tao2024", "d.toml", "--out", "t"]);
    holds(d, "t/tao2024.csv", STUDY);
    let depths: Vec<f64> =
        column(d, "t/tao2024.csv", "max_depth_um").iter().map(|cell| cell.parse().unwrap()).collect();
    assert_eq!(depths, [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0]);
    assert!(column(d, "t/tao2024.csv", "ste_rigid_mean_arcmin").iter().all(|cell| !cell.is_empty()));
    assert!(column(d, "t/tao2024.csv", "ste_flexible_mean_arcmin").iter().all(String::is_empty));
}
