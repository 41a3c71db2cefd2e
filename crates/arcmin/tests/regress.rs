//! Headline numbers of the shipped designs, as of their last review.
//!
//! Every analysis runs with its default options except for those that only increase the computing time. After
//! an intended change of a number, `ARCMIN_BASELINES=rewrite cargo test --profile checked -p arcmin --test
//! regress` writes the files again; the difference is then part of the commit, and its reason is given in
//! CHANGELOG under *Numbers*.

use arcmin::analyses::{self, NoHost};
use arcmin::templates;
use serde_json::{Map, Value};
use std::path::PathBuf;

/// Relative tolerance; two processors may round the last digits of a long integration differently.
const TOLERANCE: f64 = 1e-9;

/// Analysis and its options.
const RUNS: [(&str, &str); 8] = [
    ("check", ""),
    ("profile", "points = 90"),
    ("contact", ""),
    ("wear", "hours = 1000"),
    ("simulate", "end_s = 0.4"),
    ("rig", ""),
    ("life", "quasi_static = true\npoints = 4\nbodies = \"rigid\""),
    ("tao2024", "quasi_static = true"),
];

/// Dotted keys of every number that does not depend on the clock.
fn numbers(prefix: &str, value: &Value, into: &mut Map<String, Value>) {
    match value {
        Value::Object(entries) => {
            for (key, value) in entries {
                if key != "stages" && !key.ends_with("wall_s") {
                    numbers(
                        &if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") },
                        value,
                        into,
                    );
                }
            }
        }
        Value::Array(items) => {
            for (place, value) in items.iter().enumerate() {
                numbers(&format!("{prefix}.{place}"), value, into);
            }
        }
        Value::Number(_) => {
            into.insert(prefix.to_owned(), value.clone());
        }
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

fn headline(design: &str) -> Map<String, Value> {
    let design = templates::design(design).unwrap();
    let mut found = Map::new();
    for (name, options) in RUNS {
        let outcome = analyses::by_name(name).unwrap().run(&design, options, "regress", &NoHost).unwrap();
        numbers(name, &Value::Object(outcome.summary().to_json()), &mut found);
    }
    found
}

fn compare(design: &str) {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("tests/regress/{design}.json"));
    let found = headline(design);
    assert!(found.len() > 80, "{} numbers only", found.len());
    if std::env::var("ARCMIN_BASELINES").is_ok_and(|word| word == "rewrite") {
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, serde_json::to_string_pretty(&found).unwrap() + "\n").unwrap();
        return;
    }
    let kept: Map<String, Value> = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
    let mut moved = Vec::new();
    for key in found.keys().chain(kept.keys().filter(|key| !found.contains_key(*key))) {
        let number = |numbers: &Map<String, Value>| numbers.get(key).and_then(Value::as_f64);
        match (number(&kept), number(&found)) {
            // Residuals of a solver are rounding errors.
            (Some(old), Some(new)) if key.contains("residual") && old.abs().max(new.abs()) < 1e-6 => {}
            (Some(old), Some(new)) if (new - old).abs() <= TOLERANCE * old.abs().max(1e-6) => {}
            (old, new) => moved.push(format!("{key}: {old:?} -> {new:?}")),
        }
    }
    assert!(moved.is_empty(), "{design}: {} numbers moved:\n{}", moved.len(), moved.join("\n"));
}

#[test]
fn regress_tao2024() {
    compare("tao2024");
}

#[test]
fn regress_rv_40e() {
    compare("rv-40e");
}

#[test]
fn regress_rv_80e() {
    compare("rv-80e");
}
