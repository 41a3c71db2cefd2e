use super::*;
use crate::templates::TAO2024;

/// The shipped design without its unknowns, which would refer to keys that tests remove.
fn text() -> &'static str {
    let text = TAO2024.text;
    &text[..text.find("# What is not known exactly").unwrap()]
}

/// The error of the shipped design with one line changed, as displayed to a user.
fn answer(from: &str, to: &str) -> String {
    assert!(text().contains(from), "{from} is not in the shipped design");
    match Design::parse(&text().replacen(from, to, 1), "d.toml") {
        Ok(_) => "accepted".to_owned(),
        Err(error) => {
            let lines: Vec<&str> = error.text.lines().take(1).collect();
            format!("{error} | {} | {}", lines.join(""), error.hint.as_deref().unwrap_or_default())
        }
    }
}

#[test]
fn wrong_files_are_answered_with_line_text_and_remedy() {
    let cases: &[(&str, &str, &str)] = &include!("answers.in");
    let mut report = String::new();
    for (from, to, expected) in cases {
        let answer = answer(from, to);
        if answer != *expected {
            report.push_str(&format!("({from:?}, {to:?}, {answer:?}),\n"));
        }
    }
    assert!(report.is_empty(), "{report}");
}

/// Unknown keys and wrong values of one file are reported together, in the order of the file after the first.
#[test]
fn all_mistakes_are_reported_together() {
    let mistakes = |text: &str| {
        let error = Design::parse(text, "d.toml").unwrap_err();
        error.all().map(|error| error.to_string()).collect::<Vec<String>>()
    };
    let wrong = text()
        .replace("pin_radius_mm = 3 ", "pin_radius_mm = -3 ")
        .replace("pin_count = 40 ", "pin_count = \"40\" ");
    let told = mistakes(&wrong);
    assert!(
        told.len() == 2 && told[0].contains("pin_count") && told[1].contains("pin_radius_mm"),
        "{told:?}"
    );
    let told = mistakes(&wrong.replace("width_mm = 8.75 ", "widht_mm = 8.75 "));
    assert!(told.len() == 3 && told[0].contains("widht_mm") && told[1].contains("pin_count"), "{told:?}");
}

/// Shares whose sum differs from 1 by rounding only are scaled; a missing row is an error.
#[test]
fn rounded_shares_are_taken_in_proportion() {
    let read = |shares: &[f64]| {
        let row =
            |share: &f64| format!("[[duty]]\ntorque_n_m = 300\ninput_speed_rpm = 1500\nshare = {share}\n");
        let rows: String = shares.iter().map(row).collect();
        let (before, rest) = text().split_once("[[duty]]").unwrap();
        let after = &rest[rest.find("[wear]").unwrap()..];
        Design::parse(&format!("{before}{rows}\n{after}"), "d.toml").map(|design| design.machine().duty)
    };
    for (shares, right) in [
        (vec![0.3333, 0.3333, 0.3333], vec![1.0 / 3.0; 3]),
        (vec![0.33, 0.33, 0.33], vec![1.0 / 3.0; 3]),
        (vec![0.667, 0.334], vec![0.667 / 1.001, 0.334 / 1.001]),
        (vec![0.25, 0.75], vec![0.25, 0.75]),
    ] {
        let duty = read(&shares).unwrap_or_else(|error| panic!("{shares:?}: {error}"));
        assert!((duty.iter().map(|row| row.share).sum::<f64>() - 1.0).abs() < 1e-12);
        for (row, right) in duty.iter().zip(right) {
            assert!((row.share - right).abs() < 1e-12, "{shares:?}");
        }
    }
    for shares in
        [vec![0.5, 0.4], vec![0.49, 0.49], vec![0.3334, 0.3333], vec![0.9998, 0.0009], vec![0.25, 0.78]]
    {
        assert!(read(&shares).is_err(), "{shares:?}");
    }
}

/// A decimal comma is not valid TOML; the hint gives the notation of numbers.
#[test]
fn decimal_commas_are_answered() {
    let wrong = text().replacen("pin_radius_mm = 3 ", "pin_radius_mm = 3,5 ", 1);
    let error = Design::parse(&wrong, "d.toml").unwrap_err();
    assert_eq!((error.line(), error.hint()), (Some(14), Some("write a decimal point: 3.5")), "{error}");
}

#[test]
fn hash_depends_on_values_alone() {
    let hash = |text: &str| Design::parse(text, "d.toml").unwrap().hash();
    let base = hash(text());
    assert_eq!(base.len(), 64);
    // Comments, layout, order of sections, notation of numbers, written defaults, the description.
    assert_eq!(hash(&format!("# a comment\n{}", text())), base);
    assert_eq!(hash(&text().replace("pin_radius_mm = 3 ", "pin_radius_mm   =  3.0e0 ")), base);
    assert_eq!(hash(&text().replace("seat_compliance_um_per_kn = 0 ", "# ")), base);
    assert_eq!(hash(&text().replace("missing data assumed", "other words")), base);
    let limits = text().find("[limits]").unwrap();
    let moved =
        format!("{}\n{}", &text()[..limits].replace("[ring]", &format!("{}\n[ring]", &text()[limits..])), "");
    assert_eq!(hash(&moved), base);
    // A value, with a very small change.
    assert_ne!(hash(&text().replace("pin_radius_mm = 3 ", "pin_radius_mm = 3.0001 ")), base);
    assert_ne!(hash(&text().replace("\"fixed\"", "\"spinning\"")), base);
}

#[test]
fn wear_coefficients_in_all_their_units_are_the_same_number() {
    let k = |lines: &str| {
        let design =
            Design::parse(&text().replace("coefficient_mm2_per_n = 8.4e-13", lines), "d.toml").unwrap();
        match design.machine().wear.coupled {
            crate::machine::WearCoefficient::Given(k) => k,
            other => panic!("{other:?}"),
        }
    };
    for lines in [
        "coefficient_per_pa = 8.4e-19",
        "coefficient_mm2_per_n = 8.4e-13",
        "archard_coefficient = 5.88e-9\nhardness_mpa = 7000",
    ] {
        assert!((k(lines) / 8.4e-19 - 1.0).abs() < 1e-12, "{lines}");
    }
}

/// Bearings and gears: no wear by default, the same units as for the flank, and an error where the model does
/// not apply.
#[test]
fn wear_of_bearings_and_gears_takes_the_same_units() {
    let with = |section: &str| Design::parse(&format!("{}\n{section}\n", text()), "d.toml");
    assert!(!with("").unwrap().machine().wear.parts.any());
    for k in [
        "coefficient_per_pa = 8.4e-19",
        "coefficient_mm2_per_n = 8.4e-13",
        "archard_coefficient = 5.88e-9\nhardness_mpa = 7000",
    ] {
        let parts = with(&format!("[wear.turning_arm]\nslip = 0.01\n{k}\n[wear.sun]\n{k}"))
            .unwrap()
            .machine()
            .wear
            .parts;
        let arm = parts.turning_arm.unwrap();
        assert!((arm.coefficient / 8.4e-19 - 1.0).abs() < 1e-12 && arm.slip == 0.01, "{k}");
        assert!(
            (parts.sun / 8.4e-19 - 1.0).abs() < 1e-12 && parts.planet == 0.0 && parts.crank_support.is_none(),
            "{k}"
        );
    }
    for (section, words) in [
        ("[wear.turning_arm]\ncoefficient_per_pa = 1e-18", "slip"),
        ("[wear.turning_arm]\nslip = 0.01", "not given"),
        ("[wear.sun]\ncoefficient_per_pa = 1e-18\ncoefficient_mm2_per_n = 1e-12", "more than one way"),
        ("[wear.planet]\narchard_coefficient = 1e-8", "hardness_mpa"),
    ] {
        let error = with(section).unwrap_err();
        assert!(error.to_string().contains(words), "{section}: {error}");
    }
}

#[test]
fn given_inertias_replace_computed_ones() {
    let with =
        |from: &str, to: &str| Design::parse(&text().replacen(from, to, 1), "d.toml").unwrap().machine();
    let disc = with("width_mm = 8.75 ", "mass_kg = 0.7\nwidth_mm = 8.75 ").disc;
    assert!(disc.mass == 0.7 && (disc.inertia - 1.3394e-3).abs() < 5e-8);
    let cranks = with("mass_kg = 0.27 ", "# ").crankshafts;
    // Shaft Ø18 × 40 and planet Ø54 × 10 of 7.83 g/cm³; the eccentrics have the shaft's diameter here.
    let expected = 7830.0 * std::f64::consts::PI * (0.009f64.powi(2) * 0.04 + 0.027f64.powi(2) * 0.01);
    assert!((cranks.mass / expected - 1.0).abs() < 1e-12 && cranks.inertia == 4e-5);
}

#[test]
fn free_form_passes_through_its_points_without_overshoot() {
    let points =
        "free_form_deg_um = [[-120, 0], [-60, 4], [0, 10], [60, 4], [120, 0]]\nequidistant_offset_um = 0";
    let machine =
        Design::parse(&text().replace("equidistant_offset_um = 0", points), "d.toml").unwrap().machine();
    let form = machine.disc.modification.free_form.unwrap();
    for (degrees, depth) in
        [(-120.0, 0.0), (-60.0, 4e-6), (0.0, 10e-6), (60.0, 4e-6), (120.0, 0.0), (180.0, 0.0), (150.0, 0.0)]
    {
        let here = form.at(degrees * crate::units::DEG).depth;
        assert!((here - depth).abs() < 1e-9, "{degrees}: {here}");
    }
    assert!(form.samples().iter().all(|depth| (-1e-12..=10.0000001e-6).contains(depth)));
}

mod properties {
    use proptest::prelude::*;

    use super::*;

    /// Any number a user may write, with more weight on plausible ones.
    fn number() -> impl Strategy<Value = String> {
        prop_oneof![
            4 => (1e-3f64..200.0).prop_map(|x| format!("{x}")),
            2 => (1u32..60).prop_map(|x| x.to_string()),
            1 => any::<f64>().prop_map(|x| format!("{x:?}").replace("NaN", "nan")),
            1 => prop::sample::select(vec!["0", "-1", "nan", "-inf", "1e400", "9223372036854775807", "true", "\"3\"", "[]", "{}", "0x10", ""])
                .prop_map(str::to_owned),
        ]
    }

    /// The shipped design with some of its `key = value` lines changed, removed or duplicated.
    fn mutated() -> impl Strategy<Value = String> {
        let lines = text().lines().count();
        prop::collection::vec((0..lines, 0..8u8, number()), 0..6).prop_map(|edits| {
            let mut lines: Vec<String> = text().lines().map(str::to_owned).collect();
            for (line, action, number) in edits {
                let key = lines[line].split('=').next().unwrap_or_default().trim().to_owned();
                lines[line] = match action {
                    0 => String::new(),
                    1 => format!("{key}x = {number}"),
                    2 => lines[line].chars().rev().collect(),
                    _ => format!("{key} = {number}"),
                };
            }
            lines.join("\n")
        })
    }

    /// A thousand of each kind, or the number in HOSTILE_CASES.
    fn cases() -> u32 {
        std::env::var("HOSTILE_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(1000)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(cases()))]

        /// The result is an error with a place inside the file, or a machine whose geometry and checks are free
        /// of NaN.
        #[test]
        fn any_file_gives_an_error_or_a_sound_machine(text in mutated()) {
            match Design::parse(&text, "d.toml") {
                Err(error) => {
                    for error in error.all() {
                        let span = error.span().unwrap();
                        prop_assert!(span.end <= text.len() && error.line() >= Some(1) && error.column() >= Some(1));
                        prop_assert_eq!(text.get(span), Some(error.text.as_str()));
                    }
                }
                Ok(design) => sound(&design)?,
            }
        }

        #[test]
        fn any_bytes_give_an_error(text in "\\PC{0,200}") {
            let _ = Design::parse(&text, "d.toml");
        }

        /// Whole random mechanisms: sizes over two decades, any tooth numbers.
        #[test]
        #[ignore = "long"]
        fn any_mechanism_gives_an_error_or_a_sound_machine(
            pins in 4usize..120, circle in 5.0f64..500.0, pin in 0.01f64..0.2, k1 in 0.05f64..1.1, sun in 6usize..60, planet in 6usize..90,
            bore in 0.05f64..0.6, hole in 0.0f64..1.2, width in 0.02f64..0.5, discs in 1usize..4, offsets in (-50.0f64..50.0, -50.0f64..50.0),
        ) {
            let eccentricity = k1 * circle / pins as f64;
            let module = 0.6 * circle * 2.0 / (sun + planet) as f64;
            let bore = bore * circle;
            let edits = [
                ("pin_count = 40", format!("pin_count = {pins}")), ("pin_circle_radius_mm = 64", format!("pin_circle_radius_mm = {circle}")),
                ("pin_radius_mm = 3", format!("pin_radius_mm = {}", pin * circle)), ("lobe_count = 39", String::new()),
                ("count = 2 ", format!("count = {discs}")), ("width_mm = 8.75", format!("width_mm = {}", width * circle)),
                ("crank_bore_diameter_mm = 27", format!("crank_bore_diameter_mm = {bore}")),
                ("centre_hole_diameter_mm = 40", format!("centre_hole_diameter_mm = {}", hole * circle)),
                ("eccentricity_mm = 1.3", format!("eccentricity_mm = {eccentricity}")), ("circle_radius_mm = 40.5", String::new()),
                ("sun_teeth = 18", format!("sun_teeth = {sun}")), ("planet_teeth = 36", format!("planet_teeth = {planet}")),
                ("module_mm = 1.5", format!("module_mm = {module}")), ("ratio = 81", String::new()),
                ("equidistant_offset_um = 0", format!("equidistant_offset_um = {}", offsets.0)),
                ("radial_offset_um = 0", format!("radial_offset_um = {}", offsets.1)),
            ];
            let text = edits.iter().fold(text().to_owned(), |text, (from, to)| text.replacen(from, to, 1));
            if let Ok(design) = Design::parse(&text, "d.toml") {
                sound(&design)?;
            }
        }
    }

    fn sound(design: &Design) -> Result<(), TestCaseError> {
        let machine = design.machine();
        for positive in [
            machine.disc.mass,
            machine.disc.inertia,
            machine.crankshafts.mass,
            machine.crankshafts.inertia,
            machine.rated.torque,
        ] {
            prop_assert!(positive > 0.0 && positive.is_finite());
        }
        let profile = machine.profile();
        for step in 0..97 {
            let tau = std::f64::consts::TAU * step as f64 / 97.0;
            let point = profile.flank_point(tau);
            prop_assert!(point.norm().is_finite() && (profile.outward_normal(tau).norm() - 1.0).abs() < 1e-9);
            prop_assert!(!profile.flank_curvature_radius(profile.meshing_angle(tau).cos()).is_nan());
        }
        let relief = machine.designed_relief();
        prop_assert!(relief.samples().iter().all(|depth| depth.is_finite() && *depth >= -1e-12));
        for finding in crate::checks::check(&machine) {
            prop_assert!(finding.value.is_finite() && !finding.limit.is_nan(), "{:?}", finding);
        }
        Ok(())
    }
}

const GIVEN: &str = r#"[errors]
pin_circle_radius_um = 2
[errors.sun]
amplitude_um = 7
phase_deg = 90
[[errors.pins]]
pin = 40
tangential_um = -3
[[errors.flanks]]
disc = 2
kind = "pitch"
order = 3
amplitude_um = 4
[[errors.disc_bores]]
disc = 1
crankshaft = 2
diameter_um = 5
[[errors.eccentrics]]
crankshaft = 1
disc = 2
phase_arcmin = 2
[[errors.planets]]
crankshaft = 2
amplitude_um = 6
[[errors.measured_flanks]]
disc = 1
file = "disc-1.csv"
"#;

fn with(lines: &str) -> String {
    text().replacen("[limits]", &format!("{lines}[limits]"), 1)
}

#[test]
fn manufacturing_errors_become_si_units_at_their_parts() {
    use crate::geometry::FlankDirection;
    use crate::units::{ARCMIN, UM};
    assert_eq!(Design::parse(text(), "d.toml").unwrap().given_errors(), None);
    let design = Design::parse(&with(GIVEN), "d.toml").unwrap();
    let errors = design.given_errors().unwrap();
    assert_eq!(errors.pin_circle_radius, 2.0 * UM);
    assert_eq!((errors.sun.amplitude, errors.sun.phase), (7.0 * UM, 90.0 * crate::units::DEG));
    assert_eq!(errors.pins.len(), 40);
    assert_eq!((errors.pins[39].tangential, errors.pins[38].tangential), (-3.0 * UM, 0.0));
    let harmonic = errors.discs[1].flank.harmonics[0];
    assert_eq!(
        (harmonic.order, harmonic.amplitude, harmonic.direction),
        (3, 4.0 * UM, FlankDirection::Around)
    );
    assert_eq!(errors.discs[0].bores[1].diameter, 5.0 * UM);
    assert_eq!(errors.eccentrics[0][1].phase, 2.0 * ARCMIN);
    assert_eq!((errors.planets.len(), errors.planets[1].amplitude), (2, 6.0 * UM));
    assert_eq!(design.measured_flanks(), [MeasuredFlank { disc: 0, file: "disc-1.csv".to_owned() }]);
    // They are part of the design's hash; tolerances of the template are read as well.
    assert_ne!(design.hash(), Design::parse(text(), "d.toml").unwrap().hash());
    assert_eq!(design.drawing_tolerances().unwrap().planet_run_out, 8.0 * UM);
}

#[test]
fn wrong_manufacturing_errors_are_answered_with_line_and_remedy() {
    let first = text()[..text().find("[limits]").unwrap()].lines().count() + 1;
    for (lines, line, message, hint) in [
        (
            "[[errors.pins]]\npin = 41\n",
            1,
            "pin 41 does not exist: the design has 40",
            "write a number from 1 to 40",
        ),
        (
            "[[errors.pins]]\npin = 3\n[[errors.pins]]\npin = 3\n",
            3,
            "pin 3 is given twice",
            "give all of its errors in one table",
        ),
        (
            "[[errors.eccentrics]]\ncrankshaft = 3\ndisc = 1\n",
            1,
            "crankshaft 3 does not exist: the design has 2",
            "write a number from 1 to 2",
        ),
        (
            "[[errors.flanks]]\ndisc = 1\nkind = \"run-out\"\norder = 1\namplitude_um = 4\n",
            2,
            "`kind` has no choice \"run-out\"",
            "the choices are \"radial\", \"pitch\", \"profile\"",
        ),
        (
            "[[errors.flanks]]\ndisc = 1\nkind = \"pitch\"\norder = 1\n",
            0,
            "[errors.flanks] lacks the key `amplitude_um`",
            "add `amplitude_um = …`: Amplitude",
        ),
        (
            "[errors]\npin_radius = 1\n",
            1,
            "`pin_radius` lacks its unit",
            "units are part of the keys: write `pin_radius_um = 1` if 1 is in µm",
        ),
        (
            "[[errors.measured_flanks]]\ndisc = 1\nfile = \"a.csv\"\n[[errors.measured_flanks]]\ndisc = 1\nfile = \"b.csv\"\n",
            4,
            "the measured flank of disc 1 is given twice",
            "give all of its errors in one table",
        ),
    ] {
        let error = Design::parse(&with(lines), "d.toml").unwrap_err();
        assert_eq!(
            (error.kind.to_string().as_str(), error.hint(), error.line()),
            (message, Some(hint), Some(first + line)),
            "{lines}"
        );
    }
}
