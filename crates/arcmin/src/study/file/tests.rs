//! The study file: its content, and the messages for invalid files.

use super::{MethodName, StudyFile};
use crate::analyses::NoHost;
use crate::study::statistics::Limits;
use crate::study::{Distribution, Kind, Setting, Shard, Store, Study, Watch, collect, judge, run};

const STUDY: &str = r#"design = "rv-40e-81.toml"
analysis = "contact"
results = ["max_force_n", "te_loaded_arcmin"]

[options]
joints = "ideal"

[vary]
"disc.modification.equidistant_offset_um" = { low = 0, high = 20 }
"disc.width_mm" = { mean = 8.75, deviation = 0.05 }
"crankshafts.count" = [2]

[method]
kind = "latin-hypercube"
samples = 8
seed = 7

[[limits]]
result = "max_force_n"
high = 2000
"#;

fn design() -> crate::analyses::stage::AnyDesign {
    crate::templates::design("rv-40e-81").unwrap().into()
}

/// The study with one line changed or added.
fn changed(from: &str, to: &str) -> Result<Study, String> {
    assert!(STUDY.contains(from), "{from}");
    let text = STUDY.replacen(from, to, 1);
    let told = |error: &crate::design::DesignError| format!("{error} | {}", error.hint().unwrap_or_default());
    let file = StudyFile::parse(&text, "study.toml").map_err(|error| told(&error))?;
    file.study(&design(), "test").map_err(|error| match &error {
        crate::analyses::AnalysisError::Design(inner) => told(inner),
        other => other.to_string(),
    })
}

#[test]
fn the_documented_study_is_read() {
    let file = StudyFile::parse(STUDY, "study.toml").unwrap();
    assert_eq!((file.design.0.as_str(), *file.method.kind), ("rv-40e-81.toml", MethodName::LatinHypercube));
    let study = file.study(&design(), "test").unwrap();
    let [offset, width, count] = study.plan.factors() else { panic!() };
    assert_eq!(
        (offset.distribution, offset.unit.as_str()),
        (Distribution::Uniform { low: 0.0, high: 20.0 }, "µm")
    );
    let normal = Distribution::Normal { mean: 8.75, deviation: 0.05, limit: Some(3.0) };
    assert_eq!((width.distribution, width.unit.as_str()), (normal, "mm"));
    assert_eq!(count.entries, [Setting::Number(2.0)]);
    assert!(study.plan.kept().iter().all(|kept| kept.kind == Kind::Number));
    assert_eq!(study.plan.rows(), 8);
}

/// Machines are drawn by seeds of 53 bits, and the analyses take every one of them.
#[test]
fn every_seed_that_is_drawn_is_taken() {
    let study = changed("joints = \"ideal\"", "joints = \"bearings\"\npositions = 12").unwrap();
    let mut row = study.plan.row(0);
    for seed in [0, crate::fidelity::LARGEST_SEED as u64] {
        row.settings.push(Setting::Seed(seed));
        study.compute(&row, &NoHost).unwrap();
        row.settings.pop();
    }
}

/// Each message has its line and its remedy.
#[test]
fn faults_are_reported_with_their_place() {
    for (from, to, expected) in [
        ("joints = \"ideal\"", "joints = \"magic\"", "study.toml:6:"),
        ("joints = \"ideal\"", "joint = \"ideal\"", "study.toml:6:"),
        ("disc.width_mm", "disc.widht_mm", "did you mean `disc.width_mm`?"),
        ("low = 0, high = 20", "low = 20, high = 0", "study.toml:9:"),
        ("[2]", "[\"two\"]", "study.toml:11:"),
        ("te_loaded_arcmin", "te_load_arcmin", "did you mean `te_loaded_arcmin`?"),
        ("\"contact\"", "\"contakt\"", "no analysis is called \"contakt\""),
        ("latin-hypercube", "hypercube", "study.toml:14:"),
        ("samples = 8", "sampels = 8", "did you mean `samples`?"),
        ("[[limits]]\nresult = \"max_force_n\"", "[[limits]]\nresult = \"max\"", "add it to `results`"),
        ("high = 2000\n", "", "exclude all values"),
        ("\n[options]", "tolerances = true\n[options]\nseed = 3", "not options here"),
        ("kind = \"latin-hypercube\"", "kind = \"morris\"\nlevels = 5", "even number of levels"),
    ] {
        let message = changed(from, to).err().unwrap_or_else(|| panic!("{to} is accepted"));
        assert!(message.contains(expected), "{to}: {message}");
    }
}

/// Options are named as on the command line, where `--wear-um` has a hyphen; in Python it has an underscore.
#[test]
fn options_take_the_names_of_the_command_line() {
    let with = |line: &str| {
        let text = STUDY.replacen("joints = \"ideal\"", &format!("joints = \"ideal\"\n{line}"), 1);
        StudyFile::parse(&text, "study.toml").unwrap()
    };
    let normal = |line: &str| {
        let analysis = crate::analyses::by_name("contact").unwrap();
        analysis.normal_options(with(line).options(), "study.toml").unwrap().text
    };
    assert_eq!(normal("wear-um = 3"), normal("wear_um = 3"));
    assert_ne!(normal("wear-um = 3"), normal("wear-um = 4"));
    // A text keeps its hyphens.
    assert!(with("method = \"closed-form\"").options().contains("\"closed-form\""));
    assert!(changed("joints = \"ideal\"", "wear-mm = 3").is_err_and(|told| told.contains("wear_um")));
}

#[test]
fn options_within_braces_are_options_too() {
    let text = STUDY.replacen("[options]\njoints = \"ideal\"\n", "", 1).replacen(
        "\n[vary]",
        "options = { joints = \"ideal\", positions = 8 }\n\n[vary]",
        1,
    );
    let file = StudyFile::parse(&text, "study.toml").unwrap();
    assert!(file.options().contains("joints = \"ideal\""), "{}", file.options());
    assert_eq!(file.options().lines().filter(|line| line.contains('=')).count(), 2);
}

struct Nowhere(std::sync::Mutex<std::collections::BTreeMap<String, Vec<u8>>>);

impl Store for Nowhere {
    fn read(&self, name: &str) -> Result<Option<Vec<u8>>, String> {
        Ok(self.0.lock().unwrap().get(name).cloned())
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), String> {
        self.0.lock().unwrap().insert(name.to_owned(), bytes.to_vec());
        Ok(())
    }
}

/// From the file to the page, with the analysis itself; every row is the result of the analysis for its design.
#[test]
fn a_study_runs_from_file_to_page() {
    let study = changed("samples = 8", "samples = 6").unwrap();
    let store = Nowhere(std::sync::Mutex::default());
    let compute = |row: &crate::study::Row| study.compute(row, &NoHost);
    let done = run(&study.plan, Shard::WHOLE, &store, &compute, &Watch::NONE).unwrap();
    assert_eq!((done.computed, done.failed), (6, 0));
    let rows = collect(&study.plan, &store).unwrap();
    let forces = rows.numbers(&study.plan, "max_force_n").unwrap();
    let row = study.plan.row(4);
    let alone = study.design_of(&row).unwrap();
    let outcome = alone.run(study.analysis, "joints = \"ideal\"", "test", &NoHost).unwrap();
    assert_eq!(forces[4], outcome.summary().number("max_force_n"));
    let judged = judge::judge(&study.plan, &rows, &study.limits, 0.95, None).unwrap();
    assert_eq!(study.limits.each[0].limits, Limits { low: None, high: Some(2000.0) });
    // The pressure is not kept, so its limit is not judged: the text states this and the missing result.
    assert!(
        judged
            .limits
            .unjudged
            .iter()
            .any(|(limit, how)| limit == "contact pressure" && how.contains("max_pressure_mpa"))
    );
    assert!(judged.results[0].kept.is_some() && judged.results[0].spread.is_some());
    let template = study.template();
    assert_eq!(template.columns.len(), 2, "the count of crankshafts has one value: {:?}", template.text);
    let page = crate::study::page::StudyReport {
        title: "RV-40E-81".into(),
        subtitle: "Study".into(),
        plan: &study.plan,
        rows: &rows,
        judged: &judged,
        template,
        goals: Vec::new(),
    };
    let html = page.page().render();
    assert!(html.contains("data-kind=\"samples\"") && html.contains("limit kept by"));
    assert!(judged.to_json(&study.plan)["results"]["max_force_n"]["yield"]["of"] == 6);
}
