use super::*;
use crate::templates::{RV_80E, TAO2024, TEMPLATES};

fn findings(template: usize, edits: &[(&str, &str)]) -> Vec<Finding> {
    let text = edits.iter().fold([TAO2024, RV_80E][template].text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from} is not in the design");
        text.replacen(from, to, 1)
    });
    check_design(&Design::parse(&text, "d.toml").unwrap_or_else(|error| panic!("{error} {:?}", error.hint)))
}

fn severity(findings: &[Finding], code: &str) -> Severity {
    findings
        .iter()
        .find(|finding| finding.code == code)
        .unwrap_or_else(|| panic!("no finding {code}"))
        .severity
}

/// Each check passes on the shipped design, and reports an error or warning where its limit, and no other one,
/// is broken.
#[test]
fn every_check_can_fail() {
    use Severity::{Error, Warning};
    let cases: &[(&str, Severity, &[(&str, &str)])] = &[
        // 4.6117 mm is the limit (closed form).
        ("undercut", Error, &[("pin_radius_mm = 3 ", "pin_radius_mm = 4.62 ")]),
        ("flank-sharpness", Warning, &[("pin_radius_mm = 3 ", "pin_radius_mm = 4 ")]),
        // The pin pitch is 10.043 mm.
        ("pin-overlap", Error, &[("pin_radius_mm = 3 ", "pin_radius_mm = 5.03 ")]),
        ("pin-overlap", Warning, &[("pin_radius_mm = 3 ", "pin_radius_mm = 4.3 ")]),
        ("short-width-coefficient", Warning, &[("eccentricity_mm = 1.3", "eccentricity_mm = 1.45")]),
        ("short-width-coefficient", Warning, &[("eccentricity_mm = 1.3", "eccentricity_mm = 0.7")]),
        // The root radius is 3.0714 mm: an offset of −72 µm causes contact at two points.
        ("root-conformity", Error, &[("equidistant_offset_um = 0", "equidistant_offset_um = -72")]),
        ("rim-thickness", Warning, &[("crank_bore_diameter_mm = 27", "crank_bore_diameter_mm = 35")]),
        ("modification-gap", Warning, &[("radial_offset_um = 0", "radial_offset_um = 20")]),
        ("bore-ligament", Warning, &[("centre_hole_diameter_mm = 40", "centre_hole_diameter_mm = 53")]),
        ("eccentric-balance", Warning, &[("[disc]\ncount = 2", "[disc]\ncount = 1")]),
        (
            "planet-assembly",
            Warning,
            &[
                ("[crankshafts]\ncount = 2", "[crankshafts]\ncount = 4"),
                ("centre_hole_diameter_mm = 40", "centre_hole_diameter_mm = 4"),
            ],
        ),
        // Tip circle 57 mm; the distance of four planets on 40.5 mm is 57.28 mm, of five 47.6 mm.
        (
            "planet-clearance",
            Error,
            &[
                ("[crankshafts]\ncount = 2", "[crankshafts]\ncount = 5"),
                ("centre_hole_diameter_mm = 40", "centre_hole_diameter_mm = 4"),
            ],
        ),
        ("gear-undercut", Warning, &[("pressure_angle_deg = 30", "pressure_angle_deg = 18")]),
        ("gear-backlash", Warning, &[("backlash_um = 0 ", "backlash_um = 100 ")]),
        // 15 rollers Ø4.5 need a pitch circle of 21.64 mm at least.
        (
            "turning-arm-bearing",
            Warning,
            &[
                ("roller_count = 14", "roller_count = 15"),
                ("pitch_diameter_mm = 22.5", "pitch_diameter_mm = 21.7"),
            ],
        ),
        ("crank-support-bearing", Warning, &[("roller_count = 15", "roller_count = 18")]),
        ("turning-arm-fit", Error, &[("crank_bore_diameter_mm = 27", "crank_bore_diameter_mm = 26.9")]),
        ("crank-span", Error, &[("crank_support_span_mm = 40", "crank_support_span_mm = 17")]),
        (
            "pin-slenderness",
            Warning,
            &[
                ("width_mm = 8.75", "width_mm = 25"),
                ("crank_support_span_mm = 40", "crank_support_span_mm = 60"),
            ],
        ),
        ("crank-count", Error, &[("[crankshafts]\ncount = 2", "[crankshafts]\ncount = 1")]),
        ("contact-pressure", Error, &[("rated_torque_n_m = 412", "rated_torque_n_m = 1000")]),
        ("duty-torque", Warning, &[("\ntorque_n_m = 412", "\ntorque_n_m = 1040")]),
        ("wear-coefficient", Warning, &[("coefficient_mm2_per_n = 8.4e-13", "coefficient_mm2_per_n = 1e-7")]),
    ];
    let shipped = findings(0, &[]);
    for (code, expected, edits) in cases {
        assert_eq!(severity(&shipped, code), Severity::Info, "{code}");
        assert_eq!(severity(&findings(0, edits), code), *expected, "{code}");
    }
    for finding in &shipped {
        assert!(
            finding.code == "defaults" || cases.iter().any(|(code, ..)| *code == finding.code),
            "{} is not tested",
            finding.code
        );
    }
}

/// p0 at the largest torque, compared with 1.316 GPa from two other programs for 0.55 · 412 N·m on one disc.
#[test]
fn val_contact_pressure_of_the_closed_form() {
    let findings = findings(0, &[]);
    let pressure = findings.iter().find(|finding| finding.code == "contact-pressure").unwrap().value;
    assert!((pressure / 1316.0 - 1.0).abs() < 2e-3, "{pressure}");
}

/// The pressure of an interference increases with it. The finding is a warning up to the pressure at which
/// contacts dent, and an error if the pressure of the load alone exceeds the limit.
#[test]
fn pressure_of_a_preload_rises_with_it() {
    use Severity::{Error, Info, Warning};
    let of = |offset: &str, torque: &str| {
        let offset = format!("equidistant_offset_um = {offset}");
        let edits = [("equidistant_offset_um = 0", offset.as_str()), ("rated_torque_n_m = 412", torque)];
        let findings = findings(0, &edits);
        let finding = findings.iter().find(|finding| finding.code == "contact-pressure").unwrap();
        (finding.severity, finding.value)
    };
    let rated = "rated_torque_n_m = 412";
    let mut before = 0.0;
    for (offset, severity) in [
        ("-1", Info),
        ("-2", Info),
        ("-4", Warning),
        ("-6", Warning),
        ("-8", Warning),
        ("-10", Warning),
        ("-15", Error),
    ] {
        let found = of(offset, rated);
        assert!(found.0 == severity && found.1 > before, "{offset} µm: {found:?} after {before} MPa");
        before = found.1;
    }
    assert_eq!(of("-0.1", "rated_torque_n_m = 1500").0, Error);
}

#[test]
fn shipped_designs_have_no_error_findings() {
    for template in TEMPLATES {
        let design = Design::parse(template.text, template.file).unwrap();
        assert!(worst(&check_design(&design)) < Severity::Error, "{}", template.name);
    }
}

#[test]
fn keys_left_to_their_defaults_are_named() {
    let findings = findings(0, &[("seat_compliance_um_per_kn = 0 ", "# ")]);
    let defaults = findings.iter().find(|finding| finding.code == "defaults").unwrap();
    assert!(defaults.message.contains("ring.seat_compliance_um_per_kn"), "{}", defaults.message);
}
