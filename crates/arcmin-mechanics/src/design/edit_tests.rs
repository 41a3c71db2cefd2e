use super::field::{self, SectionValue};
use super::schema::{default_flag, default_numbers, optional, section};
use super::*;
use crate::templates;

fn design() -> Design {
    templates::design("tao2024").unwrap()
}

/// A changed design equals the design read from its text.
fn agrees_with_its_text(design: &Design) {
    let again = Design::parse(design.text(), design.file_name()).unwrap();
    assert_eq!(again.canonical(), design.canonical());
    assert_eq!(again.machine(), design.machine());
    assert_eq!(again.given_errors(), design.given_errors());
    assert_eq!(again.defaulted(), design.defaulted());
}

#[test]
fn a_change_gives_the_machine_of_the_changed_file_and_keeps_its_comments() {
    let base = design();
    let changed = base.with("crankshafts.eccentricity_mm", 1.4).unwrap();
    let expected = base.text().replace("eccentricity_mm = 1.3 ", "eccentricity_mm = 1.4 ");
    assert_eq!(changed.text(), expected);
    assert_eq!(changed.machine(), Design::parse(&expected, "d").unwrap().machine());
    // The disc's mass follows its flank; the original is unchanged.
    assert!(changed.machine().disc.mass != base.machine().disc.mass);
    assert_eq!(base, design());
    agrees_with_its_text(&changed);
}

#[test]
fn every_kind_of_value_can_be_set_left_out_and_added() {
    let base = design();
    let steel = crate::materials::Material {
        yield_strength: Some(900e6),
        source: "own test".to_owned(),
        ..crate::materials::Material::elastic("42CrMo4", 210e9, 0.3, 7850.0)
    };
    let changes: Vec<(&str, Value)> = vec![
        ("ring.pin_radius_mm", 3.05.into()),
        ("wear.coupled.coefficient_mm2_per_n", 1.25e-12.into()),
        ("crankshafts.first_angle_deg", Value::LeftOut),
        ("gear_stage.sun_teeth", 18.into()),
        ("fixed_member", "carrier".into()),
        ("description", "with \"quotes\"".into()),
        ("disc.material", steel.into()),
        ("ring.material.youngs_modulus_gpa", 200.0.into()),
        (
            "disc.modification.free_form_deg_um",
            vec![[-90.0, 0.0], [0.0, 5.0], [60.0, 1.0], [90.0, 0.0]].into(),
        ),
        ("duty[0].share", 0.25.into()),
        ("duty[1].share", 0.75.into()),
        ("duty[1].torque_n_m", 200.into()),
        ("duty[1].input_speed_rpm", 1000.into()),
        ("errors.sun.amplitude_um", 4.into()),
        ("errors.pins[0].pin", 8usize.into()),
        ("errors.pins[0].radial_um", 5.0.into()),
        ("wear.lubrication.viscosity_mpa_s", 30.0.into()),
        ("wear.lubrication.roughness_um", 0.3.into()),
        ("disc.holes[0].diameter_mm", 5.0.into()),
        ("disc.holes[0].centre_radius_mm", 50.0.into()),
        ("tolerances", Value::LeftOut),
    ];
    let changed = base.with_all(changes.clone()).unwrap();
    agrees_with_its_text(&changed);
    for (path, value) in &changes {
        let found = changed.get(path);
        match (value, *path) {
            (Value::LeftOut, "tolerances") => assert!(changed.drawing_tolerances().is_none()),
            (Value::LeftOut, _) => assert_eq!(found.unwrap(), Value::Number(90.0)),
            (Value::Number(number), _) => assert_eq!(found.unwrap().as_number(), Some(*number), "{path}"),
            _ => assert_eq!(found.unwrap(), *value, "{path}"),
        }
    }
    // Reverting the changes gives the original design.
    let back = changed.with_all([("duty[1]", Value::LeftOut), ("duty[0].share", 1.0.into())]).unwrap();
    assert_eq!(back.machine().duty, base.machine().duty);
    agrees_with_its_text(&back);
    assert_eq!(changed.machine().ring.material.density, base.machine().ring.material.density);
    assert_eq!(changed.machine().ring.material.youngs_modulus, 200e9);
}

#[test]
fn errors_of_a_change_are_those_of_the_file() {
    let base = design();
    for (path, value, from, to) in [
        ("ring.pin_radius_mm", Value::from(-3.0), "pin_radius_mm = 3  ", "pin_radius_mm = -3 "),
        ("ring.pin_radius_mm", 3000.into(), "pin_radius_mm = 3    ", "pin_radius_mm = 3000 "),
        ("ring.pin_radius_mm", "3".into(), "pin_radius_mm = 3  ", "pin_radius_mm = \"3\""),
        ("ring.pin_count", 41.into(), "pin_count = 40", "pin_count = 41"),
        ("crankshafts.eccentricity_mm", 1.7.into(), "eccentricity_mm = 1.3", "eccentricity_mm = 1.7"),
        ("ring.material", "GCr16".into(), "material = \"GCr15\"", "material = \"GCr16\""),
        ("duty[0].share", 0.5.into(), "share = 1.0", "share = 0.5"),
    ] {
        let ours = base.with(path, value).unwrap_err();
        let file = Design::parse(&base.text().replacen(from, to, 1), base.file_name()).unwrap_err();
        assert_eq!(ours, file, "{path}");
    }
    let error = base.with("ring.pin_radius_mm", -3.0).unwrap_err();
    assert_eq!((error.key(), error.line(), error.column()), (Some("ring.pin_radius_mm"), Some(14), Some(17)));
}

#[test]
fn unknown_paths_are_answered_with_the_nearest() {
    let base = design();
    for (path, message, hint) in [
        (
            "ring.pin_radius",
            "`ring.pin_radius` lacks its unit",
            "units are part of the keys: write `pin_radius_mm = 7` if 7 is in mm",
        ),
        (
            "ring.pin_radius_um",
            "`ring.pin_radius_um` has a unit this file does not use",
            "convert the value from µm to mm and write `pin_radius_mm`",
        ),
        (
            "ring.pin_radios_mm",
            "unknown key `ring.pin_radios_mm` in the design file",
            "did you mean `ring.pin_radius_mm`?",
        ),
        (
            "crankshaft.eccentricity_mm",
            "unknown key `crankshaft.eccentricity_mm` in the design file",
            "did you mean `crankshafts.eccentricity_mm`?",
        ),
        (
            "eccentricity_mm",
            "unknown key `eccentricity_mm` in the design file",
            "did you mean `crankshafts.eccentricity_mm`?",
        ),
        (
            "duty.share",
            "unknown key `duty.share` in the design file",
            "`duty` is a list: write `duty[0]`, `duty[1]`, … for its rows",
        ),
        (
            "ring..",
            "unknown key `ring..` in the design file",
            "a path is like `ring.pin_radius_mm` or `duty[0].share`",
        ),
        (
            "ring.pin_count.x",
            "unknown key `ring.pin_count.x` in the design file",
            "`pin_count` is not a section",
        ),
        (
            "duty[3].share",
            "`duty[3].share` does not exist: the design has 1 of these rows, counted from 0",
            "write a number from 0 to 0, or [1] with all its required keys to add one",
        ),
        (
            "ring",
            "`ring` is not a single value",
            "`ring` is a section: set its keys, or leave it out as a whole",
        ),
    ] {
        let error = base.with(path, 7).unwrap_err();
        assert_eq!((error.kind.to_string().as_str(), error.hint()), (message, Some(hint)), "{path}");
        assert_eq!((error.key(), error.line()), (Some(path), None));
    }
}

#[test]
fn all_keys_are_listed_with_their_values() {
    let base = design();
    let keys = base.keys();
    let key = |path: &str| keys.iter().find(|key| key.path == path).unwrap();
    let radius = key("ring.pin_radius_mm");
    assert_eq!(
        (radius.unit, radius.range, radius.required, radius.written),
        ("mm", Some([0.1, 200.0]), true, true)
    );
    assert_eq!((&radius.value, &radius.default), (&Value::Number(3.0), &Value::LeftOut));
    assert_eq!(radius.documentation, "Radius r_p of the pins.");
    let seal = key("bearings.sun_radial_stiffness_n_per_um");
    assert_eq!(
        (&seal.value, &seal.default, seal.written),
        (&Value::Number(50.0), &Value::Number(50.0), false)
    );
    // Keys of a missing section have no value, not even their default.
    assert_eq!(key("wear.lubrication.pressure_viscosity_per_gpa").value, Value::LeftOut);
    assert_eq!(key("housing.mass_kg").value, Value::LeftOut);
    assert_eq!(key("duty[0].share").value, Value::Number(1.0));
    for key in &keys {
        assert_eq!(base.get(&key.path).unwrap(), key.value, "{}", key.path);
        assert!(!key.documentation.is_empty());
        // Setting a key to its present value changes only the written text.
        if key.value != Value::LeftOut {
            let same = base.with(&key.path, key.value.clone()).unwrap();
            assert_eq!(same.canonical(), base.canonical(), "{}", key.path);
            agrees_with_its_text(&same);
        }
    }
    let written: Vec<&str> = keys.iter().filter(|key| !key.written).map(|key| key.path.as_str()).collect();
    for path in base.defaulted() {
        assert!(written.contains(&path.as_str()), "{path}");
    }
}

#[test]
fn all_unknown_keys_are_reported_together() {
    let text =
        design().text().replace("pin_radius_mm", "pin_radios_mm").replace("[[duty]]", "[[duty]]\nhours = 3");
    let error = Design::parse(&text.replace("[limits]", "[limit]"), "d.toml").unwrap_err();
    let all: Vec<_> = error.all().map(|error| error.key().unwrap()).collect();
    assert_eq!(all, ["ring.pin_radios_mm", "duty[0].hours", "limit"]);
    assert_eq!((error.line(), error.hint()), (Some(14), Some("did you mean `pin_radius_mm`?")));
    assert!(error.others.iter().all(|other| other.line() > Some(14) && other.hint().is_some()));
}

/// Words, laws and materials as well as numbers, each once.
#[test]
fn all_wrong_values_are_reported_together() {
    let mut text = design().text().to_owned();
    for (right, wrong) in [
        ("fixed_member = \"housing\"", "fixed_member = \"hosing\""),
        ("material = \"20CrMnTi\"", "material = \"20CrMmTi\""),
        ("kind = \"tapered\"", "kind = \"taperd\""),
        ("law = \"line-hertz\"", "law = \"line-herz\""),
        ("share = 1.0", "share = \"all\""),
    ] {
        assert!(text.contains(right), "{right}");
        text = text.replacen(right, wrong, 1);
    }
    let error = Design::parse(&text, "d.toml").unwrap_err();
    let all: Vec<_> = error.all().map(|error| error.key().unwrap()).collect();
    let wrong =
        ["fixed_member", "carrier.material", "bearings.crank_support.kind", "contact.law", "duty[0].share"];
    assert_eq!(all, wrong);
    assert!(error.all().take(4).all(|error| error.hint().unwrap().contains("did you mean")));
}

section! {
    /// Options of a run.
    pub struct Sample {
        /// Whether to.
        fast: bool => default_flag(true),
        /// When.
        hours: Vec<f64> => default_numbers(&[0.0, 2.5], 0.0, 100.0),
        /// Which.
        results: Vec<String> => optional(0.0, 0.0),
    }
}

/// Flags and lists, in a file other than a design file.
#[test]
fn the_reader_takes_flags_and_lists() {
    let read = |text: &str| -> Result<Sample, Box<DesignError>> {
        let source = Source { text, file_name: "s.toml", title: "the study file" };
        field::read(&field::parse(&source)?, &source)
    };
    let sample = read("").unwrap();
    assert!(*sample.fast && *sample.hours == [0.0, 2.5] && sample.results.is_empty());
    let sample = read("fast = false\nhours = [1, 2.0]\nresults = [\"a\"]").unwrap();
    assert!(!*sample.fast && *sample.hours == [1.0, 2.0] && *sample.results == ["a"]);
    for (text, message) in [
        ("fast = 1", "s.toml:1:8: `fast` must be true or false, but here is a number"),
        ("hours = [1, 101]", "s.toml:1:13: `hours` is out of range"),
        ("hours = 1", "s.toml:1:9: `hours` must be a list of numbers, but here is a number"),
        ("results = [1]", "s.toml:1:12: `results` must be a list of texts, but here is a number"),
        ("result = []", "s.toml:1:1: unknown key `result` in the study file"),
    ] {
        assert_eq!(read(text).unwrap_err().to_string(), message);
    }
    let mut lines = Vec::new();
    sample.canonical_fields("", &mut lines);
    assert_eq!(lines, ["fast = false", "hours[0] = 1.0", "hours[1] = 2.0", "results[0] = \"a\""]);
}

mod properties {
    use proptest::prelude::*;

    use super::*;

    fn value() -> impl Strategy<Value = Value> {
        prop_oneof![
            4 => (1e-3f64..200.0).prop_map(Value::Number),
            2 => (0usize..60).prop_map(Value::Count),
            1 => any::<f64>().prop_map(Value::Number),
            1 => prop::sample::select(vec!["GCr15", "linear", "ball", "", "carrier"]).prop_map(Value::from),
            2 => Just(Value::LeftOut),
            1 => any::<bool>().prop_map(Value::Flag),
            1 => prop::collection::vec([-180.0f64..180.0, 0.0f64..9.0], 0..6).prop_map(Value::Pairs),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        /// Any change of any keys is equivalent to reading the changed text: the same design or the same error.
        #[test]
        fn any_change_agrees_with_its_text(changes in prop::collection::vec((0usize..400, value()), 1..4), which in 0..2usize) {
            let base = templates::design(templates::TEMPLATES[which].name).unwrap();
            let keys = base.keys();
            let changes: Vec<_> =
                changes.into_iter().map(|(key, value)| (keys[key % keys.len()].path.clone(), value)).collect();
            match base.with_all(changes.clone()) {
                Ok(changed) => agrees_with_its_text(&changed),
                Err(error) => prop_assert!(error.line().is_some(), "{changes:?}: {error}"),
            }
        }
    }
}

#[test]
fn unknowns_are_read_with_their_nominal_values() {
    use super::variation::Distribution;
    for template in templates::TEMPLATES {
        let design = templates::design(template.name).unwrap();
        let unknowns = design.unknowns();
        assert!(unknowns.len() > 20);
        for unknown in &unknowns {
            assert_eq!(design.get(&unknown.path).unwrap().as_number(), Some(unknown.nominal));
            // Either bound of each unknown gives a valid design.
            for end in unknown.distribution.bounds() {
                let free = design.with("unknowns", Value::LeftOut).unwrap();
                free.with(&unknown.path, end).unwrap_or_else(|error| panic!("{}: {error}", unknown.path));
            }
        }
    }
    let unknowns = design().unknowns();
    let of = |path: &str| unknowns.iter().find(|unknown| unknown.path == path).unwrap();
    let clearance = of("bearings.turning_arm.clearance_um");
    assert_eq!((clearance.unit, clearance.nominal), ("µm", 5.0));
    assert_eq!(clearance.distribution, Distribution::Uniform { low: 2.0, high: 12.0 });
    let [low, high] = of("wear.coupled.coefficient_mm2_per_n").distribution.bounds();
    assert!((low / 2.8e-13 - 1.0).abs() < 1e-12 && (high / 2.52e-12 - 1.0).abs() < 1e-12);
}

#[test]
fn wrong_unknowns_are_answered_with_line_and_remedy() {
    let base = design();
    let start = base.text().find("[unknowns]").unwrap();
    let line = base.text()[..start].lines().count() + 2;
    for (row, message, hint) in [
        (
            "\"ring.pin_radios_mm\" = { factor = 2 }",
            "unknown key `ring.pin_radios_mm` in the design file",
            "did you mean `ring.pin_radius_mm`?",
        ),
        (
            "\"ring.material\" = { factor = 2 }",
            "`ring.material` is not a number, so that it cannot be an unknown",
            "name a key with a number",
        ),
        (
            "\"ring.pin_radius_mm\" = { low = 0, high = 5 }",
            "`ring.pin_radius_mm` would vary from 0 to 5, which is out of range",
            "the allowed range is 0.1 to 200 mm",
        ),
        (
            "\"ring.pin_radius_mm\" = { low = 2 }",
            "the variation of `ring.pin_radius_mm` has none of the allowed forms",
            "write { low = …, high = … }, { factor = … }, { mean = …, deviation = … } or a list of values",
        ),
        (
            "\"ring.pin_radius_mm\" = { low = 2, hihg = 4 }",
            "unknown key `hihg` in [unknowns.\"ring.pin_radius_mm\"]",
            "did you mean `high`?",
        ),
        (
            "\"ring.pin_radius_mm\" = { mean = 3, deviation = 1, distribution = \"uniform\" }",
            "`deviation` makes `ring.pin_radius_mm` normal, but its `distribution` is another",
            "write { low = …, high = … }, { factor = … }, { mean = …, deviation = … } or a list of values",
        ),
    ] {
        let text = format!("{}[unknowns]\n{row}\n", &base.text()[..start]);
        let error = Design::parse(&text, "d.toml").unwrap_err();
        assert_eq!(
            (error.kind.to_string().as_str(), error.hint(), error.line()),
            (message, Some(hint), Some(line))
        );
    }
}

/// Quantiles against closed forms, and against the normal distribution's table: 68.27 % lie within one
/// deviation of an uncut one, the cut leaves 99.73 %.
#[test]
fn quantiles_follow_their_distributions() {
    use super::variation::Distribution;
    let uniform = Distribution::Uniform { low: 2.0, high: 12.0 };
    let log = Distribution::LogUniform { low: 1.0, high: 100.0 };
    let normal = Distribution::Normal { mean: 8.0, deviation: 0.5 };
    let list = Distribution::OneOf(vec![2.0, 3.0]);
    assert_eq!([0.0, 0.25, 1.0].map(|u| uniform.quantile(u)), [2.0, 4.5, 12.0]);
    assert!((log.quantile(0.5) - 10.0).abs() < 1e-12 && (log.quantile(0.25) - 10f64.sqrt()).abs() < 1e-12);
    assert_eq!([0.0, 0.49, 0.5, 1.0].map(|u| list.quantile(u)), [2.0, 2.0, 3.0, 3.0]);
    assert_eq!(normal.quantile(0.5), 8.0);
    assert!((normal.quantile(0.0) - 6.5).abs() < 1e-9 && (normal.quantile(1.0) - 9.5).abs() < 1e-9);
    let one_deviation = 0.5 + 0.5 * 0.682_689_492_137 / 0.997_300_203_937;
    assert!((normal.quantile(one_deviation) - 8.5).abs() < 1e-9);
}

#[test]
fn given_masses_that_no_longer_fit_are_named() {
    let base = design();
    assert!(base.stale_masses().is_empty());
    assert!(base.with("friction.seal_drag_n_m", 3).unwrap().stale_masses().is_empty());
    let wide = base.with("gear_stage.face_width_mm", 12).unwrap();
    let stale = wide.stale_masses();
    let paths: Vec<&str> = stale.iter().map(|mass| mass.path).collect();
    assert_eq!(paths, ["crankshafts.mass_kg", "crankshafts.inertia_kg_m2", "gear_stage.sun_inertia_kg_m2"]);
    // Shaft Ø18 × 40 and planet Ø54 × 10, then 12; the eccentrics have the shaft's diameter.
    let volume = |width: f64| 9f64.powi(2) * 40.0 + 27f64.powi(2) * width;
    assert!((stale[0].factor / (volume(12.0) / volume(10.0)) - 1.0).abs() < 1e-12 && stale[0].given == 0.27);
    assert!((stale[2].factor - 1.2).abs() < 1e-12);
    let findings = crate::checks::check_design(&wide);
    assert!(findings.iter().any(|finding| finding.code == "stale-mass"));
    // Changed together or left out, nothing is stale. The unknowns refer to these keys and are removed first.
    let (base, wide) = [base, wide].map(|design| design.with("unknowns", Value::LeftOut).unwrap()).into();
    let along =
        wide.with_all([("crankshafts.mass_kg", Value::LeftOut), ("crankshafts.inertia_kg_m2", 5e-5.into())]);
    assert_eq!(along.unwrap().stale_masses().len(), 1);
    let free = base
        .with_all([("crankshafts.mass_kg", Value::LeftOut), ("crankshafts.eccentricity_mm", 1.4.into())])
        .unwrap();
    assert!(free.stale_masses().is_empty(), "{:?}", free.stale_masses());
}

/// This is no test, since speed depends on the machine: `cargo test --profile checked -- --ignored --nocapture
/// cost_of`.
#[test]
#[ignore = "prints times"]
fn manual_cost_of_a_change() {
    for template in templates::TEMPLATES {
        let base = templates::design(template.name).unwrap();
        for (path, low) in [("crankshafts.eccentricity_mm", 1.2), ("bearings.turning_arm.clearance_um", 5.0)]
        {
            let start = std::time::Instant::now();
            for i in 0..2000 {
                std::hint::black_box(base.with(path, low + i as f64 * 1e-6).unwrap());
            }
            println!("{} {path}: {:.1} µs", template.name, start.elapsed().as_secs_f64() / 2000.0 * 1e6);
        }
        let changed = base.with("crankshafts.eccentricity_mm", 1.2).unwrap();
        let start = std::time::Instant::now();
        for _ in 0..200 {
            std::hint::black_box(super::text::edited(&changed.written.base.text, &changed.written.changes));
        }
        println!("{} text: {:.1} µs", template.name, start.elapsed().as_secs_f64() / 200.0 * 1e6);
        let start = std::time::Instant::now();
        for _ in 0..200 {
            std::hint::black_box(Design::parse(template.text, "d").unwrap());
        }
        println!("{} parse: {:.1} µs", template.name, start.elapsed().as_secs_f64() / 200.0 * 1e6);
    }
}
