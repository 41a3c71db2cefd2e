use super::*;

/// One key means one thing: whatever analysis or table gives it.
#[test]
fn a_key_has_one_meaning_everywhere() {
    let mut meanings: std::collections::BTreeMap<&str, (&str, String)> = Default::default();
    for analysis in ALL {
        let declared = (analysis.results)();
        let columns = declared.tables.iter().flat_map(|table| table.columns.iter());
        for quantity in columns.chain(declared.summary.iter()) {
            let place = declared.analysis.to_owned();
            let (what, first) = meanings.entry(quantity.key).or_insert((quantity.what, place.clone()));
            assert_eq!(*what, quantity.what, "{} of {place} and {first}", quantity.key);
        }
    }
}

/// No table and no summary has two results of the same name, and every result is described in a sentence.
#[test]
fn results_are_declared_once_and_documented() {
    for analysis in ALL {
        let declared = (analysis.results)();
        let mut lists: Vec<_> = declared.tables.iter().map(|table| table.columns.clone()).collect();
        lists.push(declared.summary.clone());
        for list in lists {
            let mut keys: Vec<&str> = list.iter().map(|quantity| quantity.key).collect();
            keys.sort_unstable();
            assert!(keys.windows(2).all(|pair| pair[0] != pair[1]), "{}: {keys:?}", analysis.name);
            assert!(list.iter().all(|quantity| quantity.what.ends_with('.')), "{}", analysis.name);
        }
    }
}

/// Options are documented, and their defaults can be read.
#[test]
fn options_have_defaults_and_documentation() {
    for analysis in ALL {
        for key in (analysis.options)().keys {
            assert!(key.doc.trim().ends_with('.'), "{}: {}", analysis.name, key.name);
        }
    }
}

/// Results that are not required are not computed, and a result does not depend on the others that are
/// required: every number of a summary, computed alone.
#[test]
#[ignore = "long"]
fn a_single_result_equals_that_among_all() {
    let design = crate::templates::design("tao2024").unwrap().with("limits.service_life_h", 120.0).unwrap();
    for (name, options, keys) in [
        ("contact", "positions = 12", &["max_force_n", "play_arcmin", "te_loaded_arcmin"][..]),
        ("wear", "points = 2", &["max_depth_um", "play_arcmin"]),
        (
            "rig",
            "positions = 1\nte_positions = 64",
            &["lost_motion_arcmin", "te_rated_peak_to_peak_arcmin", "max_pressure_mpa"],
        ),
        (
            "life",
            // With both kinds of bodies the verdict needs both.
            "points = 4\nquasi_static = true\nbodies = \"rigid\"",
            &["lost_motion_arcmin", "verdict.ok", "max_pressure_mpa"],
        ),
        ("tao2024", "quasi_static = true", &["play_arcmin"]),
    ] {
        let analysis = by_name(name).unwrap();
        let whole = analysis.run(&design, options, "test", &NoHost).unwrap().summary().to_json();
        for key in keys {
            let host = OnlyResults { host: &NoHost, results: &[key] };
            let alone = analysis.run(&design, options, "test", &host).unwrap().summary().to_json();
            let of = |summary: &serde_json::Map<String, serde_json::Value>| {
                let whole = serde_json::Value::Object(summary.clone());
                key.split('.').fold(whole, |place, name| place[name].clone())
            };
            assert!(
                !of(&whole).is_null() && of(&whole) == of(&alone),
                "{name} {key}: {} {}",
                of(&whole),
                of(&alone)
            );
        }
    }
}

/// A life of which only the lost motion is required runs no simulation and is not extended beyond the service
/// life; one whose dynamic transmission error is required is simulated.
#[test]
#[ignore = "long"]
fn a_life_computes_the_required_results_only() {
    let design = crate::templates::design("tao2024").unwrap().with("limits.service_life_h", 60.0).unwrap();
    let run = |results: &[&str]| {
        let options = life::Options::parse("points = 4", "test").unwrap();
        life::run(&design, &options, &OnlyResults { host: &NoHost, results }).unwrap()
    };
    let quick = run(&["lost_motion_arcmin", "life.lost_motion_arcmin"]);
    assert!(quick.ages.is_empty() && quick.advice.is_empty());
    assert!(quick.first().travel.is_none() && quick.first().causes.is_none());
    assert!((quick.prediction.searched_hours - 60.0).abs() < 1e-9);
    assert!(!run(&["dte_max_arcmin"]).ages.is_empty());
    assert!(run(&["life.play_arcmin"]).first().travel.is_some());
    let further = run(&["hours_to_limit"]);
    assert!(further.ages.is_empty() && further.prediction.searched_hours > 60.0);
}

/// Groups contain their values, tables their columns.
#[test]
fn required_results_may_be_groups() {
    let host = OnlyResults { host: &NoHost, results: &["te.mean_arcmin", "life.play_arcmin", "verdict"] };
    for (result, expected) in [
        ("te", true),
        ("te.mean_arcmin", true),
        ("te.rms_arcmin", false),
        ("te_loaded_arcmin", false),
        ("life", true),
        ("life.hours", false),
        ("play_arcmin", false),
        ("verdict.kept.wear", true),
        ("report", false),
    ] {
        assert_eq!(host.needs(result), expected, "{result}");
    }
}
