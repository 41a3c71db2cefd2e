//! Manufacturing errors, from the command line.

use crate::common::*;

#[test]
fn ideal_joints_report_that_errors_are_neglected() {
    let directory = with_design();
    let d = directory.path();
    write(d, "d.toml", &(read(d, "d.toml") + "\n[errors]\npin_circle_radius_um = 2\n"));
    let said = good(d, &["contact", "d.toml", "--positions", "8", "--out", "ideal"]);
    assert!(said.contains("the design's [errors] left out"), "{said}");
    assert_eq!(summary(d, "ideal")["errors"]["source"], "none");
    good(d, &["contact", "d.toml", "--joints", "bearings", "--positions", "8", "--out", "bearings"]);
    assert_eq!(read(d, "bearings/errors.csv"), "part,quantity,value,unit\npin circle,radius,2,um\n");
    let made = summary(d, "bearings");
    assert_eq!(made["errors"]["source"], "given");
    // With a larger ring the pins on the loaded side have more clearance: fewer of them are loaded.
    assert!(figure(&made, "play_arcmin") > figure(&made, "nominal.play_arcmin") + 0.05, "{made}");
}

#[test]
fn errors_of_zero_do_not_change_the_result() {
    let directory = with_design();
    let d = directory.path();
    let run = |out: &str| {
        good(d, &["contact", "d.toml", "--joints", "bearings", "--positions", "12", "--out", out]);
        let wear = format!("{out}w");
        good(d, &["wear", "d.toml", "--hours", "30", "--points", "2", "--out", &wear]);
    };
    run("a");
    let zeros = "\n[errors]\npin_circle_radius_um = 0\n[[errors.pins]]\npin = 3\nradial_um = 0\n";
    write(d, "d.toml", &(read(d, "d.toml") + zeros));
    run("b");
    for file in ["/contact.csv", "/error.csv", "w/wear.csv", "w/wear_history.csv"] {
        assert!(read(d, &format!("a{file}")) == read(d, &format!("b{file}")), "{file}");
    }
}

/// Pin 8 is displaced inwards by 4 µm.
#[test]
fn a_displaced_pin_stands_out_among_the_others() {
    let directory = with_machine_of_paper();
    let d = directory.path();
    write(d, "d.toml", &(read(d, "d.toml") + "\n[[errors.pins]]\npin = 8\nradial_um = -4\n"));
    good(d, &["contact", "d.toml", "--joints", "bearings", "--positions", "8", "--out", "o"]);
    let pins = column(d, "o/pins.csv", "pin");
    let forces: Vec<f64> =
        column(d, "o/pins.csv", "mean_force_n").iter().map(|cell| cell.parse().unwrap()).collect();
    assert_eq!(forces.len(), 80);
    // It takes over load from its neighbours, which have the smallest loads; pins on the opposite side of the
    // ring are hardly affected.
    let of = |index: &'static str| {
        pins.iter().zip(&forces).filter(move |(pin, _)| *pin == index).map(|(_, force)| *force)
    };
    let others = pins.iter().zip(&forces).filter(|(pin, _)| *pin != "7").map(|(_, force)| *force);
    let high = others.fold(0.0, f64::max);
    let low = forces.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(of("7").all(|force| force > 4.0 * high), "{forces:?}");
    assert!(of("6").chain(of("8")).all(|force| force < 1.1 * low), "{forces:?}");
    assert!(of("27").all(|force| force > 0.95 * high), "{forces:?}");
    assert_eq!(summary(d, "o")["mean_over"]["pin_pitches"], 1560);
}

#[test]
fn wear_has_a_flank_per_disc_with_errors() {
    let directory = with_design();
    let d = directory.path();
    let run = ["wear", "d.toml", "--errors", "drawn", "--seed", "2", "--hours", "20", "--points", "1"];
    good(d, &[&run[..], &["--out", "w"]].concat());
    let discs = column(d, "w/wear.csv", "disc");
    assert_eq!(discs.len(), 2 * 2 * 720);
    assert_eq!(discs.iter().filter(|disc| *disc == "1").count(), 2 * 720);
    assert_eq!(summary(d, "w")["errors"], serde_json::json!({ "source": "drawn", "seed": 2 }));
}

/// A bench run with its own tables given as measured reads the same values, and draws them in the report.
#[test]
fn rig_evaluates_measured_curves_as_its_own() {
    let directory = with_design();
    let d = directory.path();
    let quick = ["rig", "d.toml", "--positions", "2", "--te-positions", "256", "--errors", "drawn"];
    let seven = [&quick[..], &["--seed", "7"]].concat();
    good(d, &[&seven[..], &["--out", "a"]].concat());
    let measured = ["--measured", "a/hysteresis.csv", "--measured", "a/te.csv", "--out", "b"];
    assert!(good(d, &[&seven[..], &measured].concat()).contains("measured"));
    let (a, b) = (summary(d, "a"), summary(d, "b"));
    assert_eq!(a["errors"], serde_json::json!({ "source": "drawn", "seed": 7 }));
    for key in ["lost_motion_arcmin", "backlash_arcmin", "stiffness_n_m_per_arcmin"] {
        let (own, read) = (figure(&a, key), figure(&b, &format!("measured.{key}")));
        assert!((own - read).abs() < 1e-9 * own, "{key}: {own} {read}");
    }
    assert!(read(d, "b/report.html").contains("seed 7"));
    let errors = read(d, "a/errors.csv");
    assert!(errors.lines().count() > 120 && errors.contains("pin 40,tangential,"), "{errors}");
    // Another seed is another machine.
    let eight = ["rig", "d.toml", "--positions", "1", "--te-positions", "64", "--errors", "drawn"];
    good(d, &[&eight[..], &["--seed", "8", "--out", "c"]].concat());
    assert_ne!(read(d, "c/errors.csv"), errors);
}
