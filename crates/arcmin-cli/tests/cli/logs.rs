//! Logs and tables of instruments: read, or refused with line, reason and remedy.

use crate::common::*;

/// Moves of 10 rpm and rests, in a table with these names and factors.
fn log(head: &str, separator: &str, torque: f64, speed: f64) -> String {
    let rows = (0..2000).map(|i| {
        let t = f64::from(i) * 0.01;
        let moves = (t % 5.0) > 2.0;
        let (torque, speed) = (200.0 * torque, if moves { 10.0 * speed } else { 0.0 });
        format!("{t:.3}{separator}{torque}{separator}{speed}\n")
    });
    format!("{head}\n{}", rows.collect::<String>())
}

#[test]
fn a_duty_reports_its_assumptions_and_its_time_at_rest() {
    let directory = with_design();
    let d = directory.path();
    write(d, "log.csv", &log("time_s,motor_torque_n_m,motor_speed_rpm", ",", 1.0 / 81.0, 81.0));
    let said = good(d, &["import", "duty", "d.toml", "log.csv", "--efficiency", "0.8", "--out", "o"]);
    for words in ["--rotor-inertia", "at rest", "by the clock", "4 starts", "summary.json"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let figures: serde_json::Value = serde_json::from_str(&read(d, "o/summary.json")).unwrap();
    let figure = |key: &str| figures[key].as_f64().unwrap();
    assert!((figure("rest_h") * 3600.0 - 8.0).abs() < 0.05, "{figures}");
    assert!((figure("equivalent_torque_n_m") - 160.0).abs() < 1e-3, "{figures}");
    assert!(read(d, "o/duty.toml").contains("h at rest"));
    // The rows are copied to the design unchanged.
    let rows = read(d, "o/duty.toml");
    let design = read(d, "d.toml");
    let (before, rest) = design.split_once("[[duty]]").unwrap();
    let after = &rest[rest.find("\n[wear]").unwrap()..];
    write(d, "with.toml", &format!("{before}{rows}{after}"));
    arcmin(d, &["check", "with.toml"]).status.code().filter(|code| *code < 2).unwrap();
}

#[test]
fn columns_without_meaning_are_named_by_the_user() {
    let directory = with_design();
    let d = directory.path();
    let trace = log("Name;Trace\nFile;x\n\nName;Ch 1;Ch 2\nUnit;Nm (Torque);rpm (Speed)\n", ";", 1.0, 1.0);
    let trace = trace.replace("Name;Ch", "Time [s];Ch");
    write(d, "trace.csv", &trace);
    let said = refused(d, &["import", "duty", "d.toml", "trace.csv"]).replace("\n  │ ", " ");
    for words in ["line 4", "no column of torque", "--columns", "Ch 1=torque_n_m,Ch 2=speed_rpm"] {
        assert!(said.replace("\n        ", " ").contains(words), "{words}: {said}");
    }
    let names = "Ch 1=joint_torque,Ch 2=joint_speed";
    let said = good(d, &["import", "duty", "d.toml", "trace.csv", "--columns", names, "--out", "o"]);
    assert!(said.contains("the names are in line 4") && said.contains("4 starts"), "{said}");
    let plain = ["import", "duty", "d.toml", "trace.csv", "--out", "o"];
    let by_number = ["--columns", "2=joint_torque", "--columns", "3=joint_speed", "--skip-lines", "3"];
    good(d, &[&plain[..], &by_number].concat());
    for (wrong, words) in [("Ch 9=joint_torque", "Ch 9"), ("Ch 1=colour", "colour"), ("Ch 1", "name=column")]
    {
        let said = refused(d, &[&plain[..], &["--columns", wrong]].concat());
        assert!(said.contains(words) && said.contains("help:"), "{wrong}: {said}");
    }
}

#[test]
fn loads_have_steps_and_report_uncovered_time() {
    let directory = with_design();
    let d = directory.path();
    let run = |file: &str| {
        let options = ["--load", "table", "--load-file", file, "--end-s", "0.05", "--out", "o"];
        [&["simulate", "d.toml"][..], &options].concat().into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let good = |file: &str| good(d, &run(file).iter().map(String::as_str).collect::<Vec<_>>());
    write(d, "step.csv", "time_s,torque_n_m\n0,0\n0.01,0\n0.01,200\n0.04,200\n0.04,-200\n0.06,-200\n");
    let said = good("step.csv");
    assert!(!said.contains("step.csv"), "{said}");
    let loads: Vec<f64> =
        column(d, "o/timeseries.csv", "load_n_m").iter().map(|load| load.parse().unwrap()).collect();
    let times: Vec<f64> =
        column(d, "o/timeseries.csv", "time_s").iter().map(|time| time.parse().unwrap()).collect();
    for (time, load) in times.iter().zip(loads) {
        let right = if *time < 0.01 { 0.0 } else { if *time < 0.04 { 200.0 } else { -200.0 } };
        let near = (time - 0.01).abs() < 1e-9 || (time - 0.04).abs() < 1e-9;
        assert!(near || load == right, "{load} at {time}");
    }
    write(d, "short.csv", "time_s,torque_n_m\n0.01,5\n0.03,200\n");
    let said = good("short.csv");
    assert!(
        said.contains("begins at 0.01 s") && said.contains("ends at 0.03 s of 0.05 s of the run"),
        "{said}"
    );
    write(d, "clock.csv", "time_s,torque_n_m\n1772536853,5\n1772536854,200\n");
    assert!(good("clock.csv").contains("counted from its first row"));
    let refused = |file: &str| refused(d, &run(file).iter().map(String::as_str).collect::<Vec<_>>());
    write(d, "late.csv", "time_s,torque_n_m\n5,5\n6,200\n");
    assert!(refused("late.csv").contains("outside the run"));
    write(d, "three.csv", "time_s,torque_n_m\n0,1\n0,2\n0,3\n");
    assert!(refused("three.csv").contains("three.csv, line 4"));
}

/// Designs in the encodings that editors offer.
#[test]
fn designs_in_other_encodings() {
    let directory = with_design();
    let d = directory.path();
    let text = read(d, "d.toml");
    let marked = |mark: &[u8], bytes: Vec<u8>| [mark, &bytes].concat();
    let latin: Vec<u8> = text.replace(|c: char| c as u32 > 0xff, "?").chars().map(|c| c as u8).collect();
    let latin_named = [b"# \xdcbersetzung\n".to_vec(), latin].concat();
    for (file, bytes) in [
        ("le.toml", marked(&[0xff, 0xfe], text.encode_utf16().flat_map(u16::to_le_bytes).collect())),
        ("be.toml", marked(&[0xfe, 0xff], text.encode_utf16().flat_map(u16::to_be_bytes).collect())),
        ("bom.toml", marked(&[0xef, 0xbb, 0xbf], text.clone().into_bytes())),
        ("latin.toml", latin_named),
    ] {
        std::fs::write(d.join(file), bytes).unwrap();
        // The last line contains the names of the written files.
        let findings = |file| good(d, &["check", file]).rsplit_once("\nfindings.csv").unwrap().0.to_owned();
        assert_eq!(findings(file), findings("d.toml"), "{file}");
    }
    std::fs::write(d.join("odd.toml"), b"name = \"\x93\x94\"\n").unwrap();
    let said = refused(d, &["check", "odd.toml"]);
    assert!(said.contains("odd.toml") && said.contains("save it as UTF-8"), "{said}");
}
