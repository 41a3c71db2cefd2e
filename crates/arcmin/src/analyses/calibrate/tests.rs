//! Machines whose truth is known: their readings give back how long they last.

use super::*;
use crate::analyses::{NoHost, Outcome};
use crate::design::Value;

fn design() -> Design {
    crate::templates::design("tao2024").unwrap()
}

fn calibrated(options: &str) -> Calibrated {
    let options = Options::parse(&format!("joints = \"ideal\"\n{options}"), "test").unwrap();
    run(&design(), &options, &NoHost).unwrap()
}

/// Readings made from a prediction with a known coefficient, with an error: the hours to the limit in the full
/// prediction are in the band, and held-out readings in theirs, also far beyond the fitted readings and beyond
/// the limit.
#[test]
fn a_machine_of_known_wear_is_read_back() {
    // The truth: 10 µm in 4000 h. One reading is exact, so its curve is the truth's.
    let truth = calibrated("reading = [\"4000h=10um\"]\nlimit = \"lost_motion=1.3\"");
    let grown = |hours: f64| {
        let right = truth.curve.partition_point(|point| point.hours < hours).clamp(1, truth.curve.len() - 1);
        let (a, b) = (truth.curve[right - 1], truth.curve[right]);
        let t = (hours - a.hours) / (b.hours - a.hours);
        (a.increase.0 + t * (b.increase.0 - a.increase.0)) / ARCMIN
    };
    let new = truth.lives[0].new / ARCMIN;
    let hours = truth.lives[0].hours.unwrap();
    // Errors of 0.01′, up and down.
    let errors = [0.011, -0.008, 0.004, -0.012, 0.009];
    let times = [400.0, 1100.0, 1900.0, 2700.0, 3600.0];
    let written: Vec<String> = times
        .iter()
        .zip(errors)
        .map(|(t, error)| format!("\"{t}h={:.5}arcmin\"", new + grown(*t) + error))
        .collect();
    let found = calibrated(&format!("reading = [{}]\nlimit = \"lost_motion=1.3\"", written.join(", ")));
    let life = found.headline_machine();
    assert!((life.new / ARCMIN - new).abs() < 0.03, "{life:?} {new}");
    let (low, high) = (life.low.unwrap(), life.high.unwrap());
    assert!(low < hours && hours < high && high < 2.0 * hours, "{low} {hours} {high}");
    // The same with the later ones held out: predicted, not clamped.
    let held = calibrated(&format!(
        "reading = [{}]\nfit_until_h = 2000\nreading_error_percent = 4",
        written.join(", ")
    ));
    assert_eq!(held.rows.iter().filter(|row| !row.fitted).count(), 2);
    for row in held.rows.iter().filter(|row| !row.fitted) {
        let (low, high) = row.band.unwrap();
        let reading = row.observed.reading.value;
        assert!(low < reading && reading < high, "{row:?}");
    }
}

/// Held-out readings at ten times the hours, and beyond the limit: the prediction continues to increase.
#[test]
fn held_out_readings_are_predicted() {
    let found = calibrated(
        "reading = [\"300h=+0.05arcmin\", \"900h=+0.9arcmin\", \"3000h=+0.5arcmin\"]\nfit_until_h = 400",
    );
    let predicted: Vec<f64> = found.rows.iter().map(|row| row.predicted.unwrap() / ARCMIN).collect();
    assert!((predicted[0] - 0.05).abs() < 1e-6, "{predicted:?}");
    assert!(predicted[1] > 2.5 * predicted[0] && predicted[2] > 2.5 * predicted[1], "{predicted:?}");
    // The limit of 1′ is passed in between; later values are larger.
    assert!(found.lives[0].hours.unwrap() < 3000.0 && predicted[2] + found.lives[0].new / ARCMIN > 1.0);
}

/// One reading: the value when new is the design's or the one given, and its error widens the band.
#[test]
fn one_reading_gives_the_remaining_hours() {
    let reading = "reading = [\"5200h=1.4arcmin\"]\nlimit = \"lost_motion=2\"";
    let (assumed, given) = (calibrated(reading), calibrated(&format!("{reading}\nnew_arcmin = 0.6445")));
    for one in [&assumed, &given] {
        assert_eq!(one.headline_limit().kind, LimitKind::LostMotion);
        let (low, high) = one.headline_limit().band();
        let left = one.headline_limit().left().unwrap();
        assert!(low.unwrap() < left && left < high.unwrap(), "{low:?} {left} {high:?}");
        let summary = one.summary().to_json();
        assert_eq!(summary["limit"], "lost_motion");
        assert_eq!(summary["remaining_hours"].as_f64(), Some(left));
        assert_eq!(summary["remaining_hours_band"].as_array().map(Vec::len), Some(2));
    }
    let width =
        |one: &Calibrated| one.headline_limit().band().1.unwrap() - one.headline_limit().band().0.unwrap();
    assert!(width(&assumed) > 1.5 * width(&given), "{} {}", width(&assumed), width(&given));
    assert!(assumed.lives[1].new_is == NewIs::Assumed && given.lives[1].new_is == NewIs::Given);
    assert!(assumed.cautions().iter().any(|text| text.contains("assumed")));
    // Every limit of the design is listed, that of the bearings by their survival.
    let kinds: Vec<LimitKind> = assumed.its_limits().map(|limit| limit.kind).collect();
    assert!(
        kinds.contains(&LimitKind::ContactPressure) && kinds.contains(&LimitKind::BearingLife),
        "{kinds:?}"
    );
    // Less than when new is no wear.
    let options = Options::parse("joints = \"ideal\"\nreading = [\"5200h=0.2arcmin\"]", "test").unwrap();
    let refused = run(&design(), &options, &NoHost).unwrap_err();
    assert!(refused.to_string().contains("no wear to fit"), "{refused}");
}

/// A limit below the present reading is exceeded, and the hours since then are given.
#[test]
fn the_time_since_a_limit_was_exceeded_is_reported() {
    let over = calibrated("reading = [\"5200h=1.4arcmin\"]\nlimit = \"lost_motion=1.2\"");
    let limit = over.headline_limit();
    assert!(limit.is_over() && limit.left() == Some(0.0) && limit.hours().unwrap() < 5200.0);
    assert!(limit.sentence().contains("passed since"), "{}", limit.sentence());
}

/// The printed section belongs into the design, and the design with it reads it back.
#[test]
fn printed_keys_can_be_pasted() {
    let found = calibrated(
        "reading = [\"600h=+10.64arcsec\", \"1550h=+12.92arcsec\", \"3000h=+19arcsec\"]\nrunning_in_h = 300",
    );
    let printed = found.keys();
    let text = design().text().to_owned();
    // As a user does it: the section is replaced by the printed text.
    let start = text.find("[wear.coupled]").unwrap();
    let end = start + text[start + 1..].find("\n[").unwrap() + 1;
    let pasted = format!("{}{printed}\n{}", &text[..start], &text[end..]);
    let pasted = Design::parse(&pasted, "pasted.toml").unwrap();
    let k = "wear.coupled.coefficient_per_pa";
    let Value::Number(read) = pasted.get(k).unwrap() else { panic!() };
    assert!((read / found.fit.law.coefficient - 1.0).abs() < 1e-4);
    let written = found.design.as_ref().unwrap();
    assert_eq!(written.get(k).unwrap(), Value::Number(read));
    assert_eq!(written.get("wear.coupled.coefficient_mm2_per_n").unwrap(), Value::LeftOut);
    assert_eq!(written.get("wear.running_in.duration_h").unwrap(), Value::Number(300.0));
    assert!(written.text().contains('#'), "comments are kept");
}
