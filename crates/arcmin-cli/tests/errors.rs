//! Manufacturing errors in load sharing, wear and life, as a user meets them.

use std::path::Path;
use std::process::Output;

use tempfile::TempDir;

fn arcmin(directory: &Path, arguments: &[&str]) -> Output {
    assert_cmd::Command::cargo_bin("arcmin").unwrap().current_dir(directory).args(arguments).output().unwrap()
}

/// A directory with the default design as d.toml, with a short service life and whatever is added to it.
fn with_design(added: &str) -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    assert!(arcmin(directory.path(), &["new", "d.toml"]).status.success());
    let file = directory.path().join("d.toml");
    let text =
        std::fs::read_to_string(&file).unwrap().replace("service_life_h = 7500", "service_life_h = 100");
    std::fs::write(file, text + added).unwrap();
    directory
}

fn good(directory: &Path, arguments: &[&str]) -> String {
    let output = arcmin(directory, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn refused(directory: &Path, arguments: &[&str], words: &[&str]) {
    let output = arcmin(directory, arguments);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
    assert!(words.iter().all(|word| text.contains(word)), "{arguments:?}: {text}");
}

fn summary(directory: &Path, out: &str) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(directory.join(out).join("summary.json")).unwrap()).unwrap()
}

fn read(directory: &Path, file: &str) -> String {
    std::fs::read_to_string(directory.join(file)).unwrap()
}

#[test]
fn ideal_joints_refuse_errors_and_say_so_where_a_design_has_some() {
    let directory = with_design("\n[errors]\npin_circle_radius_um = 2\n");
    let d = directory.path();
    std::fs::write(d.join("m.csv"), "hours,depth_um\n600,2\n").unwrap();
    for command in [
        vec!["contact", "d.toml"],
        vec!["wear", "d.toml"],
        vec!["calibrate", "d.toml", "m.csv"],
        vec!["life", "d.toml"],
    ] {
        let with = |more: &[&'static str]| {
            command.iter().copied().chain(more.iter().copied()).collect::<Vec<&str>>()
        };
        refused(
            d,
            &with(&["--errors", "drawn"]),
            &["ideal joints have no place for manufacturing errors", "add --joints bearings"],
        );
        refused(
            d,
            &with(&["--joints", "bearings", "--seed", "4"]),
            &["--seed draws nothing here", "--errors drawn"],
        );
    }
    refused(
        d,
        &["life", "d.toml", "--joints", "bearings", "--machines", "3"],
        &["--machines draws", "--joints bearings --errors drawn"],
    );
    refused(d, &["life", "d.toml", "--machines", "1"], &["2..=1000"]);
    for (command, chosen, method) in [
        ("contact", ["--method", "closed-form"], "the closed form"),
        ("wear", ["--mode", "paper"], "the paper's study"),
    ] {
        let with = |more: &[&'static str]| [&[command, "d.toml"][..], &chosen, more].concat();
        refused(
            d,
            &with(&["--joints", "bearings"]),
            &[method, "knows no bearings", "leave --joints or", chosen[0]],
        );
        refused(
            d,
            &with(&["--flexible"]),
            &[method, "knows no elastic discs", "leave --flexible or", chosen[0]],
        );
    }
    let said = good(d, &["contact", "d.toml", "--positions", "8", "--out", "ideal"]);
    assert!(said.contains("the design's [errors] enter with --joints bearings only"), "{said}");
    let errors = summary(d, "ideal")["errors"].clone();
    assert!(errors["source"] == "none" && errors["left_out"].is_string(), "{errors}");
    let said =
        good(d, &["contact", "d.toml", "--joints", "bearings", "--positions", "8", "--out", "bearings"]);
    assert!(said.contains("as given in the design, listed in errors.csv"), "{said}");
    assert_eq!(read(d, "bearings/errors.csv"), "part,quantity,value,unit\npin circle,radius,2,um\n");
    let made = summary(d, "bearings");
    assert_eq!(made["errors"]["source"], "given");
    // A larger ring leaves the pins on the loaded side more play: fewer of them carry.
    assert!(
        made["play_arcmin"].as_f64().unwrap() > made["nominal"]["play_arcmin"].as_f64().unwrap() + 0.05,
        "{made}"
    );
}

#[test]
fn errors_of_zero_change_no_byte() {
    let directory = with_design("");
    let d = directory.path();
    good(d, &["contact", "d.toml", "--joints", "bearings", "--positions", "12", "--out", "a"]);
    good(d, &["wear", "d.toml", "--joints", "bearings", "--hours", "30", "--points", "2", "--out", "aw"]);
    let text =
        read(d, "d.toml") + "\n[errors]\npin_circle_radius_um = 0\n[[errors.pins]]\npin = 3\nradial_um = 0\n";
    std::fs::write(d.join("d.toml"), text).unwrap();
    good(d, &["contact", "d.toml", "--joints", "bearings", "--positions", "12", "--out", "b"]);
    good(d, &["wear", "d.toml", "--joints", "bearings", "--hours", "30", "--points", "2", "--out", "bw"]);
    for file in ["/contact.csv", "/error.csv"] {
        assert!(read(d, &format!("a{file}")) == read(d, &format!("b{file}")), "{file}");
    }
    for file in ["w/wear.csv", "w/wear_history.csv"] {
        assert!(read(d, &format!("a{file}")) == read(d, &format!("b{file}")), "{file}");
    }
}

/// Pin 8 stands 4 µm too far in.
#[test]
fn a_displaced_pin_stands_out_among_the_others() {
    let directory = with_design("\n[[errors.pins]]\npin = 8\nradial_um = -4\n");
    let d = directory.path();
    let said = good(d, &["contact", "d.toml", "--joints", "bearings", "--positions", "8", "--out", "o"]);
    assert!(said.contains("bears most: pin 8 on disc"), "{said}");
    let forces: Vec<(usize, f64)> = read(d, "o/pins.csv")
        .lines()
        .skip(1)
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            (fields[1].parse().unwrap(), fields[4].parse().unwrap())
        })
        .collect();
    assert_eq!(forces.len(), 80);
    // It bears for its neighbours, which bear least; those on the far side of the ring hardly notice.
    let of = |index: usize| forces.iter().filter(move |(pin, _)| *pin == index).map(|(_, force)| *force);
    let high = forces.iter().filter(|(pin, _)| *pin != 7).map(|(_, force)| *force).fold(0.0, f64::max);
    let low = forces.iter().map(|(_, force)| *force).fold(f64::INFINITY, f64::min);
    assert!(of(7).all(|force| force > 4.0 * high), "{forces:?}");
    assert!(of(6).chain(of(8)).all(|force| force < 1.1 * low), "{forces:?}");
    assert!(of(27).all(|force| force > 0.95 * high), "{forces:?}");
    assert_eq!(summary(d, "o")["mean_over"]["pin_pitches"], 1560);
}

#[test]
fn wear_has_a_flank_per_disc_with_errors() {
    let directory = with_design("");
    let d = directory.path();
    good(
        d,
        &[
            "wear", "d.toml", "--joints", "bearings", "--errors", "drawn", "--seed", "2", "--hours", "20",
            "--points", "1", "--out", "w",
        ],
    );
    let table = read(d, "w/wear.csv");
    assert!(table.starts_with("hours,meshing_angle_deg,depth_um,force_n,specific_sliding,disc\n"));
    assert_eq!(table.lines().count(), 1 + 2 * 2 * 720);
    assert_eq!(table.lines().filter(|line| line.ends_with(",1")).count(), 2 * 720);
    assert_eq!(summary(d, "w")["errors"], serde_json::json!({ "source": "drawn", "seed": 2 }));
}

/// The same bytes on one thread and on two, and the machine of the first seed is that of the prediction.
#[test]
fn a_series_of_machines_is_the_same_on_any_number_of_threads() {
    let directory = with_design("");
    let d = directory.path();
    let life = [
        "life",
        "d.toml",
        "--joints",
        "bearings",
        "--errors",
        "drawn",
        "--seed",
        "3",
        "--machines",
        "2",
        "--quasi-static",
        "--points",
        "2",
    ];
    for (out, threads) in [("a", "1"), ("b", "2")] {
        let said = good(d, &[&life[..], &["--out", out, "--threads", threads]].concat());
        assert!(said.contains("series of 2 machines") && said.contains("without errors"), "{said}");
    }
    for file in ["series.csv", "machines.csv", "life_coupled.csv", "wear.csv", "errors.csv"] {
        assert!(read(d, &format!("a/{file}")) == read(d, &format!("b/{file}")), "{file}");
    }
    let last = |file: &str, row: usize, column: usize| -> f64 {
        let line = read(d, file).lines().nth(row).unwrap().to_owned();
        line.split(',').nth(column).unwrap().parse().unwrap()
    };
    assert_eq!(last("a/machines.csv", 1, 0), 3.0);
    let column = read(d, "a/life_coupled.csv")
        .lines()
        .next()
        .unwrap()
        .split(',')
        .position(|name| name == "max_depth_um")
        .unwrap();
    assert_eq!(last("a/machines.csv", 1, 5), last("a/life_coupled.csv", 3, column));
    let series = summary(d, "a")["series"].clone();
    assert_eq!(series["seeds"], serde_json::json!([3, 4]));
    let median = series["lost_motion_new_arcmin"]["median"].as_f64().unwrap();
    assert!((median - 0.5 * (last("a/machines.csv", 1, 3) + last("a/machines.csv", 2, 3))).abs() < 1e-12);
    let report = read(d, "a/report.html");
    assert!(report.contains("Machines of a series") && report.contains("Load on every pin"));
}
