//! Names that users and other programs depend on: files, columns, keys of the summary, exit status.

use crate::common::*;

#[test]
fn profile_writes_the_flank_with_its_closed_forms() {
    let directory = with_machine_of_paper();
    let d = directory.path();
    good(d, &["profile", "d.toml", "--points", "50"]);
    let out = "out/d/profile";
    let told = summary(d, out);
    assert_eq!(figure(&told, "ratio"), 81.0);
    assert_eq!(figure(&told, "short_width_coefficient"), 0.8125);
    assert!((figure(&told, "inflection_deg") - 34.644).abs() < 5e-4);
    assert!((figure(&told, "min_convex_flank_radius_mm") - 1.6117).abs() < 5e-5);
    let file = format!("{out}/profile.csv");
    has_columns(d, &file, "tau_deg, meshing_angle_deg, x_mm, y_mm, normal_x, normal_y, curvature_radius_mm");
    let numbers = |name: &str| -> Vec<f64> {
        column(d, &file, name).iter().map(|field| field.parse().unwrap()).collect()
    };
    let (x, y, nx, ny) = (numbers("x_mm"), numbers("y_mm"), numbers("normal_x"), numbers("normal_y"));
    assert_eq!(x.len(), 39 * 50);
    assert!(nx.iter().zip(&ny).all(|(x, y)| (x.hypot(*y) - 1.0).abs() < 1e-12));
    // Root and tip: R_p ∓ a − r_p.
    let radii = x.iter().zip(&y).map(|(x, y)| x.hypot(*y));
    let (low, high) =
        radii.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), r| (low.min(r), high.max(r)));
    assert!((low - 59.7).abs() < 1e-9 && (high - 62.3).abs() < 1e-9, "{low} {high}");
}

#[test]
fn uniform_wear_moves_the_flank_along_its_normal() {
    let directory = with_design();
    let d = directory.path();
    good(d, &["profile", "d.toml", "--points", "20", "--wear-um", "60", "--out", "worn"]);
    for line in read(d, "worn/profile.csv").lines().skip(1) {
        let f: Vec<Option<f64>> = line.split(',').map(|field| field.parse().ok()).collect();
        let at = |index: usize| f[index].unwrap();
        assert!((at(2) - at(7) - 0.06 * at(4)).abs() < 1e-12 && (at(3) - at(8) - 0.06 * at(5)).abs() < 1e-12);
    }
}

#[test]
fn contact_in_both_methods() {
    let directory = with_design();
    let d = directory.path();
    let columns =
        "crank_angle_deg, disc, pin, meshing_angle_deg, force_n, pressure_mpa, half_width_um, gap_um";
    for (method, out) in [("equilibrium", "e"), ("closed-form", "c")] {
        good(d, &["contact", "d.toml", "--method", method, "--positions", "12", "--out", out]);
        has_columns(d, &format!("{out}/contact.csv"), columns);
        let told = summary(d, out);
        for key in ["max_force_n", "loaded_pairs", "max_pressure_mpa"] {
            assert!(figure(&told, key) > 1.0, "{key}");
        }
        let angle = |field: &String| -> f64 { field.parse().unwrap() };
        let angles: Vec<f64> =
            column(d, &format!("{out}/contact.csv"), "meshing_angle_deg").iter().map(angle).collect();
        assert!(angles.iter().all(|angle| *angle > -180.0 && *angle <= 180.0));
        assert!(angles.iter().any(|angle| *angle < 0.0), "angles keep their sign");
    }
    let told = summary(d, "e");
    // A positive torque opposes the motion: the output lags.
    assert!(figure(&told, "te_loaded_arcmin") < 0.0 && told["play_arcmin"].is_number());
    assert_eq!((told["joints"].as_str(), told["discs"].as_str()), (Some("ideal"), Some("rigid")));
    // Uniform wear increases the play in both directions.
    good(d, &["contact", "d.toml", "--wear-um", "10", "--positions", "12", "--out", "w"]);
    assert!(figure(&summary(d, "w"), "play_arcmin") > 0.1);
}

#[test]
fn wear_in_both_modes() {
    let directory = with_machine_of_paper();
    let d = directory.path();
    good(d, &["wear", "d.toml", "--hours", "100", "--points", "1", "--out", "w"]);
    assert_eq!(summary(d, "w")["joints"], "bearings", "wear is that of the machine as it is");
    good(d, &["wear", "d.toml", "--mode", "tao2024", "--points", "2", "--out", "t"]);
    for out in ["w", "t"] {
        has_columns(
            d,
            &format!("{out}/wear.csv"),
            "hours, meshing_angle_deg, depth_um, force_n, specific_sliding",
        );
        has_columns(
            d,
            &format!("{out}/wear_history.csv"),
            "hours, max_depth_um, max_force_n, loaded_pairs, play_arcmin",
        );
        // A new flank has no wear.
        let angles = column(d, &format!("{out}/wear_history.csv"), "max_depth_at_deg");
        assert_eq!(angles[0], "", "{angles:?}");
        assert!(angles[1..].iter().all(|angle| angle.parse::<f64>().unwrap() > 0.0), "{angles:?}");
        let told = summary(d, out);
        for key in ["max_depth_um", "max_depth_at_deg", "wear_coefficient_per_pa"] {
            assert!(figure(&told, key) > 0.0, "{key}");
        }
    }
    // The default design's coefficient has been calibrated to this value.
    let told = summary(d, "t");
    assert!((figure(&told, "max_depth_um") - 60.0).abs() < 0.1, "{told}");
    assert_eq!(told["joints"], "ideal", "the study knows no others");
}

#[test]
fn simulate_gives_transmission_error_and_solver_statistics() {
    let directory = with_design();
    let d = directory.path();
    let run =
        ["simulate", "d.toml", "--load", "constant", "--rise-s", "0.02", "--end-s", "0.1", "--out", "s"];
    good(d, &run);
    has_columns(d, "s/timeseries.csv", "time_s, input_speed_deg_s, output_speed_deg_s, load_n_m, te_arcmin");
    let told = summary(d, "s");
    let te = |key: &str| figure(&told, &format!("te.{key}"));
    assert!(te("mean_arcmin") < 0.0 && te("mean_abs_arcmin") >= -te("mean_arcmin"));
    assert!(te("max_abs_arcmin") >= te("rms_arcmin") && te("rms_arcmin") >= te("mean_abs_arcmin"));
    assert!(te("peak_to_peak_arcmin") > 0.0);
    assert!(figure(&told, "solver.steps") > 10.0 && figure(&told, "solver.wall_s") > 0.0);
    assert!(figure(&told, "solver.energy_residual") < 1e-2);
    assert_eq!(told["joints"], "ideal");
}

#[test]
fn rig_measures_as_makers_do() {
    let directory = with_design();
    let d = directory.path();
    good(d, &["rig", "d.toml", "--positions", "1", "--te-positions", "64", "--out", "r"]);
    has_columns(d, "r/hysteresis.csv", "torque_n_m, angle_arcmin, branch");
    has_columns(d, "r/spectrum.csv", "order, amplitude_arcmin");
    let told = summary(d, "r");
    for key in ["lost_motion_arcmin", "backlash_arcmin", "stiffness_n_m_per_arcmin", "efficiency"] {
        assert!(figure(&told, key) > 0.0, "{key}");
    }
    assert!(figure(&told, "efficiency") < 1.0);
    assert_eq!(told["joints"], "bearings");
}

#[test]
#[ignore = "long"]
fn calibrate_finds_the_coefficient_and_reads_what_a_spreadsheet_writes() {
    let directory = with_design();
    let d = directory.path();
    let plain = "hours,lost_motion_increase_arcsec\n600,10.64\n1550,12.92\n";
    write(d, "plain.csv", plain);
    // A byte order mark, carriage returns, no end of the last line.
    write(d, "office.csv", &format!("\u{feff}{}", plain.trim_end().replace('\n', "\r\n")));
    write(d, "comma.csv", "hours;lost_motion_increase_arcsec\n600;10,64\n1550;12,92\n");
    let k = |file: &str| {
        good(d, &["calibrate", "d.toml", file, "--joints", "ideal", "--out", file.trim_end_matches(".csv")]);
        figure(&summary(d, file.trim_end_matches(".csv")), "wear_coefficient_per_pa")
    };
    let value = k("plain.csv");
    assert!((1e-18..1e-17).contains(&value), "{value}");
    assert_eq!((k("office.csv"), k("comma.csv")), (value, value));
    let told = summary(d, "plain");
    // Two readings that scatter by a third give no bound; with a known error they do.
    assert!(
        told["wear_coefficient_low_per_pa"].is_null() && told["hours_to_lost_motion_limit_low"].is_null()
    );
    assert!(
        told["cautions"].to_string().contains("the readings set no bound to the wear coefficient"),
        "{told}"
    );
    good(
        d,
        &[
            "calibrate",
            "d.toml",
            "plain.csv",
            "--joints",
            "ideal",
            "--reading-error-percent",
            "5",
            "--out",
            "e",
        ],
    );
    let told = summary(d, "e");
    assert!(figure(&told, "wear_coefficient_low_per_pa") < value);
    assert!(figure(&told, "hours_to_lost_motion_limit_low") < figure(&told, "hours_to_lost_motion_limit"));
}

/// Readings of two machines from a prediction, given as read and relative to their own first readings. The
/// coefficient is recovered, and each machine has its own remaining life.
#[test]
#[ignore = "long"]
fn calibrate_takes_readings_of_several_machines() {
    let directory = with_design();
    let d = directory.path();
    write(d, "depth.csv", "hours,depth_um\n7500,10\n");
    good(d, &["calibrate", "d.toml", "depth.csv", "--joints", "ideal", "--out", "a"]);
    let k = figure(&summary(d, "a"), "wear_coefficient_per_pa");
    let (hours, grown) = (
        column(d, "a/calibration_curve.csv", "hours"),
        column(d, "a/calibration_curve.csv", "lost_motion_increase_arcmin"),
    );
    let mut table = "machine;hours;lost_motion_arcmin\n".to_owned();
    for (name, new, rows) in [("A", 0.5, [10, 40, 80]), ("B", 0.7, [0, 60, 100])] {
        for row in rows {
            let reading = new + grown[row].parse::<f64>().unwrap();
            table += &format!("{name};{};{reading}\n", hours[row]).replace('.', ",");
        }
    }
    write(d, "both.csv", &table);
    let said = good(
        d,
        &[
            "calibrate",
            "d.toml",
            "both.csv",
            "--joints",
            "ideal",
            "--reading-error-percent",
            "5",
            "--out",
            "b",
        ],
    );
    let told = summary(d, "b");
    assert!((figure(&told, "wear_coefficient_per_pa") / k - 1.0).abs() < 1e-3, "{k} {told}");
    let (low, high) =
        (figure(&told, "wear_coefficient_low_per_pa"), figure(&told, "wear_coefficient_high_per_pa"));
    assert!(low < k && k < high && high < 1.3 * k, "{low} {k} {high}");
    let machines = told["machines"].as_array().unwrap();
    assert_eq!(machines.len(), 3);
    for (machine, (name, new)) in machines[1..].iter().zip([("A", 0.5), ("B", 0.7)]) {
        assert_eq!(machine["machine"], name);
        assert!((figure(machine, "new_lost_motion_arcmin") - new).abs() < 1e-3, "{machine}");
    }
    // The machine with the smaller initial value has the longer life.
    let hours =
        |machine: &serde_json::Value| machine["hours_to_lost_motion_limit"].as_f64().unwrap_or(f64::INFINITY);
    assert!(hours(&machines[1]) > hours(&machines[2]), "{told}");
    assert!(said.contains("A (lost motion when new 0.500 arcmin, fitted)"), "{said}");
    let page = read(d, "b/report.html");
    assert!(page.contains("Growth of the lost motion") && page.contains("95 % band"));
    // A single reading of a machine uses the value of the design when new, and this is reported; a smaller
    // reading, and readings without growth, are refused.
    write(d, "one.csv", "hours,lost_motion_arcmin\n600,0.7\n");
    assert!(good(d, &["calibrate", "d.toml", "one.csv"]).contains("was read at one time only"));
    write(d, "less.csv", "hours,lost_motion_arcmin\n600,0.2\n");
    assert!(refused(d, &["calibrate", "d.toml", "less.csv"]).contains("no wear to fit"));
    write(d, "flat.csv", "hours,lost_motion_arcmin\n600,0.7\n900,0.6\n");
    assert!(refused(d, &["calibrate", "d.toml", "flat.csv"]).contains("has not grown"));
    write(d, "new.csv", "hours,lost_motion_increase_arcmin\n0,0.7\n900,0.9\n");
    assert!(
        refused(d, &["calibrate", "d.toml", "new.csv"]).replace("\n  │ ", " ").contains("counts from new")
    );
}

#[test]
fn every_summary_contains_its_provenance() {
    let directory = with_design();
    let d = directory.path();
    good(d, &["profile", "d.toml", "--points", "4", "--out", "p"]);
    let told = summary(d, "p");
    assert_eq!(told["arcmin_version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(told["command"], "profile");
    assert_eq!(told["command_line"], serde_json::json!(["profile", "d.toml", "--points", "4", "--out", "p"]));
    assert_eq!(told["design"]["name"], "RV-40E-81 of Tao2024");
    assert_eq!(told["design"]["hash"].as_str().unwrap().len(), 64);
    let mut files: Vec<String> = serde_json::from_value(told["files"].clone()).unwrap();
    files.sort();
    assert_eq!(files, names(&d.join("p")), "the summary lists all files");
}

#[test]
fn exit_codes_are_three() {
    let directory = with_design();
    let d = directory.path();
    assert_eq!(arcmin(d, &["check", "d.toml"]).status.code(), Some(0));
    edit(d, "pin_radius_mm = 3 ", "pin_radius_mm = 4.9 ");
    assert_eq!(arcmin(d, &["check", "d.toml"]).status.code(), Some(1));
    assert_eq!(arcmin(d, &["check", "d.toml", "--json"]).status.code(), Some(1));
    assert_eq!(arcmin(d, &["profile", "d.toml"]).status.code(), Some(1));
    for wrong in [
        &["profile"][..],
        &["profil", "d.toml"],
        &["profile", "d.toml", "--wear-um", "nan"],
        &["profile", "d.toml", "--points", "0"],
        &["profile", "d.toml", "--threads", "0"],
        &["contact", "d.toml", "--joints", "welded"],
    ] {
        refused(d, wrong);
    }
}

/// No result depends on the number of threads.
#[test]
#[ignore = "long"]
fn the_same_bytes_on_any_number_of_threads() {
    let directory = with_design();
    let d = directory.path();
    let drawn = ["--joints", "bearings", "--errors", "drawn", "--seed", "3"];
    for (name, arguments) in [
        ("profile", vec!["--points", "20"]),
        ("contact", [&drawn[..], &["--positions", "8"]].concat()),
        ("wear", [&drawn[..], &["--hours", "20", "--points", "1"]].concat()),
        ("rig", vec!["--errors", "drawn", "--seed", "3", "--positions", "2", "--te-positions", "64"]),
    ] {
        for threads in ["1", "2"] {
            let out = format!("{name}{threads}");
            let all = [&[name, "d.toml"][..], &arguments, &["--threads", threads, "--out", &out]].concat();
            good(d, &all);
        }
        for file in names(&d.join(format!("{name}1"))).iter().filter(|file| file.ends_with(".csv")) {
            let of = |threads: usize| read(d, &format!("{name}{threads}/{file}"));
            assert!(of(1) == of(2), "{name}: {file}");
        }
    }
}

/// The bench reports the age of its verdict, and names a bearing with too short a life.
#[test]
fn the_verdict_of_the_bench_has_its_hours() {
    let directory = with_machine_of_paper();
    let d = directory.path();
    let few = ["--positions", "1", "--te-positions", "64"];
    good(d, &[&["rig", "d.toml", "--hours", "100", "--out", "worn"][..], &few].concat());
    good(d, &[&["rig", "d.toml", "--out", "new"][..], &few].concat());
    assert!(read(d, "worn/report.html").contains("Lost motion after 100 h, "));
    let new = read(d, "new/report.html");
    assert!(new.contains("Lost motion when new, "));
    assert!(figure(&summary(d, "new"), "shortest_bearing_life_h") < 7500.0);
    assert!(new.contains("(L10) at rated torque and speed; 7500 h are planned."));
}

/// The curve of a calibration ends at the last computed wear, and so does its band: neither is extended
/// horizontally.
#[test]
fn the_curve_of_a_calibration_is_strictly_increasing() {
    let directory = with_design();
    let d = directory.path();
    write(d, "read.csv", "hours,lost_motion_arcmin\n0,0.70\n600,0.72\n1500,0.73\n3000,0.76\n");
    good(d, &["calibrate", "d.toml", "read.csv", "--joints", "ideal", "--out", "c"]);
    for name in ["lost_motion_increase_arcmin", "lost_motion_increase_high_arcmin"] {
        let values = column(d, "c/calibration_curve.csv", name);
        let values: Vec<f64> = values.iter().filter_map(|cell| cell.parse().ok()).collect();
        assert!(values.len() > 60 && values.windows(2).all(|pair| pair[1] > pair[0]), "{name}: {values:?}");
    }
}
