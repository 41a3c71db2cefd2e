//! Tables of other programs: read with the intended meaning, or refused with the line and a remedy.

use crate::common::*;

fn says(directory: &std::path::Path, arguments: &[&str], expected: &str) {
    // The terminal output breaks long lines.
    let said = refused(directory, arguments).replace("\n  │ ", " ").replace("\n        ", " ");
    assert_eq!(said, expected, "{arguments:?}");
}

#[test]
fn measurements_beyond_belief_are_refused() {
    let directory = with_design();
    let d = directory.path();
    write(d, "huge.csv", "hours,lost_motion_arcsec\n1e300,10\n");
    says(
        d,
        &["calibrate", "d.toml", "huge.csv", "--joints", "ideal"],
        "  × huge.csv, line 2: 1e300 in column hours is out of the allowed range 0 to 1e7\n  \
         help: check the unit in the column's name\n",
    );
    write(d, "tiny.csv", "hours,lost_motion_increase_arcsec\n600,1e-12\n");
    says(
        d,
        &["calibrate", "d.toml", "tiny.csv", "--joints", "ideal"],
        "  × tiny.csv, line 2: lost_motion_increase_arcmin is 1.67e-14 after 600 h; wear cannot give \
         such a value\n  help: check the unit in the name of the column; use lost_motion_arcmin for readings that may also \
         decrease\n",
    );
    write(d, "te.csv", "output_angle_deg,te_arcmin\n0,0\n7.03125e+199,0.0306604\n");
    says(
        d,
        &["rig", "d.toml", "--measured", "te.csv"],
        "  × te.csv, line 3: 7.03125e199 in column output_angle_deg is out of the allowed range -360000 to \
         360000\n  help: check the unit in the column's name\n",
    );
    assert!(!d.join("out/d/calibrate/summary.json").exists());
}

const DECIMAL_COMMAS: &str = "the header names 2 columns, but here are 3 fields
  help: if these are decimal commas, separate the fields by semicolons or write decimal points
";

#[test]
fn decimal_commas_between_commas_are_refused() {
    let directory = with_design();
    let d = directory.path();
    write(d, "load.csv", "time_s,torque_n_m\n0,0\n1,2,412\n2,5,412\n");
    says(
        d,
        &["simulate", "d.toml", "--load", "table", "--load-file", "load.csv", "--end-s", "0.05"],
        &format!("  × load.csv, line 3: {DECIMAL_COMMAS}"),
    );
    let rows: String = (1..361).map(|i| format!("{i},0,{i:03}\n")).collect();
    write(d, "te.csv", &format!("output_angle_deg,te_arcmin\n0,0,000\n{rows}"));
    says(d, &["rig", "d.toml", "--measured", "te.csv"], &format!("  × te.csv, line 2: {DECIMAL_COMMAS}"));
}

#[test]
fn a_table_without_names_is_refused() {
    let directory = with_design();
    write(directory.path(), "load.csv", "0,0\n0.02,412\n0.05,100\n");
    says(
        directory.path(),
        &["simulate", "d.toml", "--load", "table", "--load-file", "load.csv", "--end-s", "0.05"],
        "  × load.csv, line 1: the first line \"0,0\" contains numbers instead of the names of the columns\n  \
         help: put a line with the names in front: time_s, torque_n_m; or give them by number: --columns \
         \"1=time_s,2=torque_n_m\"\n",
    );
}

#[test]
fn columns_are_found_by_name() {
    let directory = with_design();
    let d = directory.path();
    write(d, "a.csv", "time_s,torque_n_m\n0,0\n0.02,412\n0.05,413\n");
    write(d, "b.csv", "torque_n_m,time_s\n0,0\n412,0.02\n413,0.05\n");
    write(d, "c.csv", "torque_mn_m;time_ms\n0;0\n412000;20\n413000;50\n");
    for file in ["a", "b", "c"] {
        let name = format!("{file}.csv");
        good(
            d,
            &[
                "simulate",
                "d.toml",
                "--load",
                "table",
                "--load-file",
                &name,
                "--end-s",
                "0.03",
                "--out",
                file,
            ],
        );
    }
    let series = read(d, "a/timeseries.csv");
    assert!(series == read(d, "b/timeseries.csv"));
    let numbers = |out: &str, name: &str| -> Vec<f64> {
        column(d, &format!("{out}/timeseries.csv"), name).iter().map(|cell| cell.parse().unwrap()).collect()
    };
    for out in ["a", "c"] {
        for (time, load) in numbers(out, "time_s").iter().zip(numbers(out, "load_n_m")) {
            let given = if *time < 0.02 { 412.0 * time / 0.02 } else { 412.0 + (time - 0.02) / 0.03 };
            assert!((load - given).abs() < 1e-6, "{out}: {load} at {time}");
        }
    }
}

#[test]
fn measured_curves_are_answered_with_their_line() {
    let directory = with_design();
    let d = directory.path();
    let told = |file: &str, text: &str, words: &[&str]| {
        write(d, file, text);
        let said = refused(d, &["rig", "d.toml", "--measured", file]).replace("\n  │ ", " ");
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    };
    told(
        "loop.csv",
        "torque_n_m,angle_arcmin,branch\n1,0.1,falling\n\n2,0.2,up\n",
        &["loop.csv, line 4", "up"],
    );
    told("te.csv", "output_angle_deg,te_arcmin\n0,0.1\n1,x\n", &["te.csv, line 3", "\"x\"", "te_arcmin"]);
    told(
        "other.csv",
        "# a comment\na,b\n1,2\n",
        &["other.csv, line 2", "torque_n_m of a loop", "te_arcmin of a transmission error", "a, b"],
    );
    let up: String = (-20..=20).map(|i| format!("{},{}\n", 20 * i, 0.1 * f64::from(i))).collect();
    told(
        "up.csv",
        &format!("torque_n_m,angle_arcmin\n{up}"),
        &["up.csv, line 2", "branch is missing", "-400 → 400 N·m", "from + rated (412 N·m)"],
    );
    edit(d, "[tolerances]", "[[errors.measured_flanks]]\ndisc = 1\nfile = \"flank.csv\"\n[tolerances]");
    let said = refused(d, &["rig", "d.toml"]);
    assert!(
        said.contains("flank.csv") && said.contains("it is relative to the file that names it"),
        "{said}"
    );
    let flank = |step: f64, bad: Option<usize>| {
        let angle = |i: usize| if bad == Some(i) { 3.0 } else { step * i as f64 };
        let rows: Vec<String> =
            (0..720).map(|i| format!("{},{}", angle(i), 2.0 * (i as f64 / 40.0).sin())).collect();
        write(d, "flank.csv", &format!("angle_deg,depth_um\n{}\n", rows.join("\n")));
    };
    flank(0.5, Some(100));
    let said = refused(d, &["rig", "d.toml"]);
    assert!(said.contains("flank.csv, line 102") && said.contains("49.5"), "{said}");
    flank(0.3, None);
    let said = refused(d, &["rig", "d.toml"]);
    assert!(said.contains("39 lobes need a point every 2.308°"), "{said}");
    flank(0.5, None);
    good(d, &["rig", "d.toml", "--positions", "1", "--te-positions", "64", "--out", "r"]);
    assert_eq!(summary(d, "r")["errors"]["source"], "given");
}

/// A loop as a bench gives it, with a first loading, a column of time and no names of branches, angle against
/// torque; a turn without its last place. Figures come with their uncertainty, and what was done is said with
/// its lines.
#[test]
fn measured_curves_are_read_as_benches_give_them() {
    let directory = with_design();
    let d = directory.path();
    let angle = |torque: f64, side: f64| torque / 200.0 + 0.2 * (torque / 4.0).tanh() + 0.15 * side;
    let mut rows = String::from("time_s,temperature_degc,angle_arcmin,torque_n_m\n");
    let mut time = 0;
    let mut add = |torque: f64, side: f64| {
        rows += &format!("{time},24.5,{:.5},{torque:.3}\n", -angle(torque, side));
        time += 1;
    };
    (0..50).for_each(|i| add(412.0 * f64::from(i) / 50.0, 0.0));
    for side in [1.0, -1.0] {
        (0..=824).for_each(|i| add(side * f64::from(412 - i), side));
    }
    write(d, "loop.csv", &rows);
    let error =
        |degrees: f64| 0.3 * (40.0 * degrees.to_radians()).sin() + 0.1 * (39.0 * degrees.to_radians()).cos();
    let turn: String =
        (0..1440).map(|i| 0.25 * f64::from(i)).map(|a| format!("{a},{:.5}\n", error(a))).collect();
    write(d, "te.csv", &format!("output_angle_deg,te_arcmin\n{turn}"));
    let bench = ["rig", "d.toml", "--positions", "1", "--te-positions", "64", "--out", "r"];
    let said = good(d, &[&bench[..], &["--measured", "loop.csv", "--measured", "te.csv"]].concat());
    for words in [
        "loop.csv, lines 2 to 52: the first loading",
        "opposite senses",
        "strongest measured orders: 40 (0.300 ±",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let summary = summary(d, "r");
    let reading = 0.03 * 412.0;
    for (name, unit, expected) in [
        ("lost_motion", "arcmin", angle(reading, 1.0) + angle(reading, -1.0)),
        ("backlash", "arcmin", 0.3),
        ("stiffness", "n_m_per_arcmin", 200.0),
    ] {
        let value = figure(&summary, &format!("measured.{name}_{unit}"));
        let uncertainty = figure(&summary, &format!("measured.{name}_uncertainty_{unit}"));
        assert!((value - expected).abs() < uncertainty + 2e-3 * expected, "{name}: {value} ± {uncertainty}");
        assert!(uncertainty < 0.02 * expected, "{name}: ± {uncertainty}");
    }
    let measured = &summary["measured"];
    assert_eq!(measured["orders"][0]["order"], 40);
    assert!(measured["orders"][0]["uncertainty_arcmin"].as_f64().unwrap() < 1e-3);
    assert!(measured["transmission_error"][0]["peak_to_peak_uncertainty_arcmin"].as_f64().unwrap() < 1e-3);
    assert_eq!(measured["remarks"].as_array().unwrap().len(), 2);
    let report = read(d, "r/report.html");
    assert!(report.contains("lines 2 to 52: the first loading") && report.contains(" ± "));
}
