//! Studies from the command line: files, shards, kills, scripts of engines, searches.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::common::*;

const STUDY: &str = r#"design = "d.toml"
analysis = "contact"
results = ["max_force_n", "te_loaded_arcmin"]
tolerances = false
unknowns = false

[options]
joints = "ideal"
positions = 8

[vary]
"disc.modification.equidistant_offset_um" = { low = 0, high = 20 }
"disc.width_mm" = { mean = 8.75, deviation = 0.05 }
"crankshafts.count" = [2]

[method]
kind = "latin-hypercube"
samples = 60
seed = 7
samples_per_part = 1

[[limits]]
result = "max_force_n"
high = 2000
"#;

fn with_study() -> tempfile::TempDir {
    let directory = with_machine_of_paper();
    write(directory.path(), "s.toml", STUDY);
    directory
}

/// Drawn drives of a study are those drawn by the bench with the same seeds, and each tolerance has its gain.
#[test]
#[ignore = "long"]
fn single_stages_are_drawn_and_tightened() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    good(d, &["new", "nema17-19", "d.toml"]);
    let tolerances = "[tolerances]\npin_circle_radius_um = 6\nbore_diameter_um = 5\n";
    write(d, "d.toml", &format!("{}\n{tolerances}", read(d, "d.toml")));
    let study = "design = \"d.toml\"\nanalysis = \"rig\"\nresults = [\"gap_play_arcmin\", \"jams\"]\ntolerances = true\n\
                 [options]\npositions = 1\nte_positions = 8\n";
    write(d, "s.toml", &format!("{study}[method]\nkind = \"random\"\nsamples = 3\n"));
    good(d, &["study", "s.toml", "--out", "s"]);
    let samples = read(d, "s/samples.csv");
    let mut lines = samples.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let column = |name: &str| head.iter().position(|own| *own == name).unwrap();
    let (seed, play) = (column("seed"), column("gap_play_arcmin"));
    for line in lines {
        let drawn = ["--errors", "drawn", "--positions", "1", "--te-positions", "8", "--out", "r", "--force"];
        good(d, &[&["rig", "d.toml", "--seed", line[seed]][..], &drawn].concat());
        let alone = summary(d, "r")["gap_play_arcmin"].as_f64().unwrap();
        assert!((alone - line[play].parse::<f64>().unwrap()).abs() < 1e-9, "{alone} {line:?}");
    }
    write(d, "t.toml", &format!("{study}[method]\nkind = \"tighten\"\nsamples = 4\n"));
    let said = good(d, &["study", "t.toml", "--out", "t"]);
    assert!(
        said.contains("16 samples computed") && said.contains("tolerances.pin_circle_radius_um"),
        "{said}"
    );
    good(d, &["study", "tighten", "d.toml", "--out", "u", "--quiet"]);
    let said = good(d, &["check", "d.toml", "--out", "c"]);
    assert!(said.contains("play as made") && said.contains("selected by size"), "{said}");
    has_columns(
        d,
        "c/matched.csv",
        "step_um, mean_arcmin, low_arcmin, high_arcmin, jam_rate, variance_share",
    );
    let told = summary(d, "c");
    assert_eq!(told["play_as_made"]["tighten_first"], "tolerances.pin_circle_radius_um", "{told}");
}

/// Lives of drives of two rings and of two stages are studied with the results of either ring.
#[test]
fn lives_of_two_rings_and_two_stages_are_studied() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    for (name, other) in [("two-ring-225", "second"), ("two-stage-500", "first_stage")] {
        good(d, &["new", name, "d.toml", "--force"]);
        let study = format!(
            "design = \"d.toml\"\nanalysis = \"life\"\nresults = [\"{other}_max_depth_um\", \"hours_to_lost_motion_limit\", \
             \"verdict.ok\"]\n[options]\npoints = 4\n[vary]\n\"limits.service_life_h\" = [40, 60]\n\
             [method]\nkind = \"grid\"\n"
        );
        write(d, "s.toml", &study);
        good(d, &["study", "s.toml", "--out", name]);
        let told = summary(d, name);
        assert_eq!(told["rows"], 2, "{told}");
        assert_eq!(told["results"][format!("{other}_max_depth_um")]["count"], 2, "{told}");
        // The verdict covers every limit.
        assert!(told["limits"]["not_judged"].as_array().unwrap().is_empty(), "{told}");
    }
}

/// A study of single stages keeps their results; a result that a stage does not have is refused at its place.
#[test]
#[ignore = "long"]
fn a_single_stage_is_studied() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    good(d, &["new", "nema17-19", "d.toml"]);
    let study = |analysis: &str, results: &str, more: &str| {
        format!(
            "design = \"d.toml\"\nanalysis = \"{analysis}\"\nresults = [\"{results}\"]\n{more}\n\
             [options]\n{}\n[vary]\n\"output_pins.hole_clearance_um\" = {{ low = 0, high = 30 }}\n\
             \"output_pins.count\" = [5, 6]\n\
             [method]\nkind = \"latin-hypercube\"\nsamples = 6\n",
            match analysis {
                "contact" => "positions = 8",
                "rig" => "positions = 2\nte_positions = 12",
                _ => "",
            }
        )
    };
    for (analysis, result) in [
        ("check", "play_chain.output_arcmin"),
        ("contact", "max_output_pin_force_n"),
        ("rig", "lost_motion_arcmin"),
    ] {
        write(d, "s.toml", &study(analysis, result, ""));
        good(d, &["study", "s.toml", "--out", analysis]);
        let told = summary(d, analysis);
        assert_eq!(told["rows"], 6, "{told}");
        assert!(told["results"][result]["quantiles"].is_array(), "{told}");
        assert!(
            read(d, &format!("{analysis}/samples.csv"))
                .lines()
                .all(|line| line.ends_with(',') || line.ends_with("failed"))
        );
    }
    // The values in [unknowns] vary as well; the life of proposed drives has a band by the range of the wear
    // coefficient.
    let proposed =
        ["--ratio", "15", "--torque-nm", "8", "--outer-diameter-mm", "80", "--process", "printed-fdm"];
    good(d, &[&["new", "--family", "eccentric"][..], &proposed[..], &["p.toml"][..]].concat());
    let text = study("wear", "max_depth_um", "unknowns = true").replace("d.toml", "p.toml");
    let text = text.replace("[options]\n", "[options]\nhours = 20\npoints = 1\n");
    write(d, "s.toml", &text);
    good(d, &["study", "s.toml", "--out", "unknown"]);
    let columns = read(d, "unknown/samples.csv");
    assert!(columns.lines().next().unwrap().contains("wear.coupled.coefficient_per_pa"), "{columns}");
    good(d, &["life", "p.toml", "--points", "4", "--band", "--band-machines", "4", "--out", "l"]);
    let band = &summary(d, "l")["band"]["results"]["max_depth_um"];
    let [low, high] = ["low", "high"].map(|end| band[end].as_f64().unwrap());
    assert!(high > 1.1 * low && low > 0.0, "{band}");
    for (text, words) in [
        (study("contact", "max_force_n", "tolerances = true"), "gives no tolerances"),
        (study("check", "play_chain.output_arcmin", "tolerances = true"), "does not support drawn machines"),
        (study("contact", "max_forces_n", ""), "max_force_n"),
        (study("tao2024", "max_force_n", ""), "RV reducers only"),
    ] {
        write(d, "s.toml", &text);
        let said = refused(d, &["study", "s.toml", "--out", "x"]);
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn a_study_leaves_table_summary_report_and_parts() {
    let directory = with_study();
    let d = directory.path();
    let said = good(d, &["study", "s.toml", "--out", "o"]);
    assert!(said.contains("60 samples computed") && said.contains("max force"), "{said}");
    let columns = "sample, disc.modification.equidistant_offset_um, disc.width_mm, crankshafts.count, \
                   max_force_n, te_loaded_arcmin, failed";
    has_columns(d, "o/samples.csv", columns);
    assert_eq!(read(d, "o/samples.csv").lines().count(), 61);
    let told = summary(d, "o");
    assert_eq!(
        (&told["rows"], &told["of"], &told["method"]),
        (&60.into(), &60.into(), &"latin-hypercube".into())
    );
    let force = &told["results"]["max_force_n"];
    assert!(force["yield"]["of"] == 60 && force["quantiles"][4]["share"] == 0.95, "{force}");
    assert_eq!(force["sensitivity"]["kind"], "linear");
    assert!(
        names(&d.join("o/parts")).len() == 60 && read(d, "o/report.html").contains("data-kind=\"samples\"")
    );
    // A single row computed again by the analysis.
    let offset = column(d, "o/samples.csv", "disc.modification.equidistant_offset_um")[17].clone();
    let width = column(d, "o/samples.csv", "disc.width_mm")[17].clone();
    edit(d, "equidistant_offset_um = 0", &format!("equidistant_offset_um = {offset}"));
    edit(d, "width_mm = 8.75 ", &format!("width_mm = {width} "));
    good(d, &["contact", "d.toml", "--positions", "8", "--out", "one"]);
    let force = column(d, "o/samples.csv", "max_force_n")[17].parse::<f64>().unwrap();
    assert_eq!(figure(&summary(d, "one"), "max_force_n"), force);
}

/// Two, seven and fifty shards, in both orders, give the same bytes as a single run; `collect` evaluates the
/// available rows before all are complete.
#[test]
fn shards_give_the_same_rows() {
    let directory = with_study();
    let d = directory.path();
    good(d, &["study", "s.toml", "--out", "whole", "--quiet"]);
    let whole = read(d, "whole/samples.csv");
    for shards in [2, 7, 50] {
        let out = format!("of{shards}");
        let order: Vec<u32> = if shards == 7 { (1..=shards).collect() } else { (1..=shards).rev().collect() };
        for (done, shard) in order.into_iter().enumerate() {
            let shard = format!("{shard}/{shards}");
            good(
                d,
                &["study", "run", "s.toml", "--shard", &shard, "--out", &out, "--threads", "1", "--quiet"],
            );
            if done == 0 {
                good(d, &["study", "collect", "s.toml", "--out", &out, "--quiet"]);
                let told = summary(d, &out);
                assert!(told["rows"].as_u64().unwrap() < 60 && told["of"] == 60, "{told}");
            }
        }
        good(d, &["study", "collect", "s.toml", "--out", &out, "--quiet"]);
        assert!(read(d, &format!("{out}/samples.csv")) == whole, "{shards} shards");
    }
    let said = good(d, &["study", "plan", "s.toml", "--out", "of2"]);
    assert!(said.contains("60 samples in 60 parts") && d.join("of2/plan.json").exists(), "{said}");
    let planned = read(d, "of2/plan.csv");
    for (planned, computed) in planned.lines().zip(whole.lines()).skip(1) {
        assert!(computed.starts_with(planned), "{planned} {computed}");
    }
    // A study that was planned in a directory need not be given again.
    good(d, &["study", "plan", "s.toml", "--out", "planned", "--quiet"]);
    good(d, &["study", "run", "--shard", "1/1", "--out", "planned", "--quiet"]);
    good(d, &["study", "collect", "--out", "planned", "--quiet"]);
    assert!(read(d, "planned/samples.csv") == whole);
    assert!(refused(d, &["study", "run", "--out", "nowhere"]).contains("no study is planned"));
    // A damaged part is computed again, with a message.
    std::fs::write(d.join("of2/parts").join(&names(&d.join("of2/parts"))[3]), "spoilt").unwrap();
    let output = arcmin(d, &["study", "collect", "s.toml", "--out", "of2"]);
    assert!(texts(&output).1.contains("is left out"), "{:?}", texts(&output));
    good(d, &["study", "s.toml", "--out", "of2", "--quiet"]);
    assert!(read(d, "of2/samples.csv") == whole);
}

/// Thirty kills of shards at any time, then computation of the missing rows: the same bytes.
#[test]
fn killed_shards_are_computed_again() {
    let directory = with_study();
    let d = directory.path();
    good(d, &["study", "s.toml", "--out", "whole", "--quiet"]);
    let mut killed = 0;
    for attempt in 0..30_u64 {
        let shard = format!("{}/7", 1 + attempt % 7);
        let mut child = Command::new(binary())
            .args(["study", "run", "s.toml", "--shard", &shard, "--out", "k", "--threads", "1", "--quiet"])
            .current_dir(d)
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(5 + (attempt * 7) % 60));
        child.kill().unwrap();
        killed += i32::from(!child.wait().unwrap().success());
    }
    assert!(killed > 0, "no shard was killed: nothing was tested");
    good(d, &["study", "submit", "s.toml", "--engine", "local", "--shards", "7", "--out", "k", "--quiet"]);
    assert!(read(d, "whole/samples.csv") == read(d, "k/samples.csv"));
}

/// Ctrl-C keeps the finished rows, reports them, and gives the command to continue.
#[cfg(unix)]
#[test]
fn an_interrupted_study_keeps_its_samples() {
    let directory = with_study();
    let d = directory.path();
    write(d, "s.toml", &STUDY.replace("samples = 60", "samples = 4000").replace("samples_per_part = 1", ""));
    let child = Command::new(binary())
        .args(["study", "s.toml", "--out", "o"])
        .current_dir(d)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    for _ in 0..600 {
        std::thread::sleep(Duration::from_millis(20));
        if d.join("o/parts").exists() && !names(&d.join("o/parts")).is_empty() {
            break;
        }
    }
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let output = child.wait_with_output().unwrap();
    let (_, complaint) = texts(&output);
    assert_eq!(output.status.code(), Some(2), "{complaint}");
    assert!(complaint.contains("from there"), "{complaint}");
    let there = summary(d, "o")["rows"].as_u64().unwrap();
    assert!(there > 0 && there < 4000, "{there}");
    assert_eq!(read(d, "o/samples.csv").lines().count() as u64, there + 1);
}

/// A study that is interrupted before its first sample reports the interruption, not missing rows.
#[cfg(unix)]
#[test]
fn a_study_interrupted_at_the_start_reports_it() {
    let directory = with_study();
    let d = directory.path();
    let study = "design = \"d.toml\"\nanalysis = \"life\"\nresults = [\"lost_motion_arcmin\"]\n\
                 tolerances = true\n\
                 [method]\nkind = \"random\"\nsamples = 50\nseed = 7\n";
    write(d, "slow.toml", study);
    let child = Command::new(binary())
        .args(["study", "slow.toml", "--out", "o"])
        .current_dir(d)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(400));
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let output = child.wait_with_output().unwrap();
    let (_, complaint) = texts(&output);
    assert_eq!(output.status.code(), Some(2), "{complaint}");
    assert!(complaint.contains("from there") && !complaint.contains("no samples"), "{complaint}");
}

#[test]
fn study_files_are_refused_with_their_lines() {
    let directory = with_study();
    let d = directory.path();
    for (from, to, said) in [
        ("disc.width_mm", "disc.widht_mm", "did you mean `disc.width_mm`?"),
        ("\"contact\"", "\"kontakt\"", "no analysis is called"),
        ("\"ideal\"", "\"magic\"", "magic"),
        ("tolerances = false", "tolerances = true", "ideal joints do not support"),
        ("d.toml", "nowhere.toml", "cannot read nowhere.toml"),
        ("latin-hypercube", "optimise", "needs one goal or two"),
    ] {
        write(d, "wrong.toml", &STUDY.replacen(from, to, 1));
        let complaint = refused(d, &["study", "wrong.toml", "--out", "w"]).replace("\n  │ ", " ");
        assert!(complaint.contains(said), "{to}: {complaint}");
    }
    let complaint = refused(d, &["study", "collect", "s.toml", "--out", "empty"]);
    assert!(complaint.contains("there are no samples"), "{complaint}");
    refused(d, &["study", "run", "s.toml", "--shard", "8/7"]);
    refused(d, &["study"]);
}

#[test]
fn every_template_is_written_and_read() {
    let directory = with_design();
    let d = directory.path();
    let list = good(d, &["study", "new", "--list"]);
    for name in list.lines().filter_map(|line| line.split_whitespace().next()) {
        let file = format!("{name}.toml");
        assert!(good(d, &["study", "new", name, &file, "--design", "d.toml"]).contains("next: arcmin study"));
        good(d, &["study", "plan", &file, "--out", name, "--quiet"]);
        assert!(read(d, &format!("{name}/plan.csv")).lines().count() > 1, "{name}");
    }
    let said = good(d, &["study", "new", "grid", "later.toml", "--design", "later-design.toml"]);
    assert!(said.contains("later-design.toml does not exist yet"), "{said}");
    assert!(refused(d, &["study", "new", "grid", "grid.toml"]).contains("exists already"));
    assert!(refused(d, &["study", "new", "nothing", "x.toml"]).contains("no study template"));
}

/// The questions of all templates exist for drives of eccentrics, with results that these have.
#[test]
fn every_template_suits_drives_of_eccentrics() {
    let directory = tempfile::tempdir().unwrap();
    let d = directory.path();
    for design in ["nema17-19", "printed-15", "steel-59", "two-ring-225", "two-stage-500"] {
        good(d, &["new", design, "d.toml", "--force"]);
        let (unknown, tolerance) = ("disc.modification.equidistant_offset_um", "pin_circle_radius_um = 1");
        let mut text = read(d, "d.toml");
        if !text.contains("[unknowns]") {
            text += &format!("\n[unknowns]\n\"{unknown}\" = {{ deviation = 1 }}\n");
        }
        write(d, "d.toml", &format!("{text}\n[tolerances]\n{tolerance}\n"));
        let list = good(d, &["study", "new", "--list"]);
        for name in list.lines().filter_map(|line| line.split_whitespace().next()) {
            let file = format!("{design}-{name}.toml");
            good(d, &["study", "new", name, &file, "--design", "d.toml"]);
            let out = format!("{design}-{name}");
            good(d, &["study", "plan", &file, "--out", &out, "--quiet"]);
            assert!(read(d, &format!("{out}/plan.csv")).lines().count() > 1, "{out}");
        }
    }
    good(d, &["study", "cases", "d.toml", "--out", "cases", "--quiet"]);
    assert_eq!(read(d, "cases/samples.csv").lines().count(), 5);
}

/// Scripts of engines that are not installed: they are written, with the commands they would start.
#[test]
fn scripts_of_engines_are_written() {
    let directory = with_study();
    let d = directory.path();
    for (engine, file) in [("hq", "hq.sh"), ("slurm", "slurm.sh"), ("dask", "on_dask.py")] {
        let arguments =
            ["study", "submit", "s.toml", "--engine", engine, "--shards", "9", "--out", "o", "--print"];
        assert!(good(d, &arguments).contains(file));
        let script = read(d, &format!("o/submit/{file}"));
        assert!(script.contains("s.toml") && script.contains("study") && script.contains('9'), "{script}");
    }
}

/// Smallest wind-up under load with a limit of the largest force, over the offset: in between a larger offset
/// increases both, so that the optimum is no offset; two shards per generation give the same.
#[test]
fn a_search_writes_the_best_design() {
    let directory = with_machine_of_paper();
    let d = directory.path();
    edit(d, "equidistant_offset_um = 0", "equidistant_offset_um = 10");
    let study = r#"design = "d.toml"
analysis = "contact"
results = ["max_force_n", "te_loaded_arcmin", "max_pressure_mpa"]

[options]
positions = 8

[vary]
"disc.modification.equidistant_offset_um" = { low = 0, high = 20 }
"disc.width_mm" = { low = 8, high = 9.5 }

[[goals]]
result = "max_pressure_mpa"

[[limits]]
result = "te_loaded_arcmin"
low = -3

[method]
kind = "optimise"
generations = 24
seed = 2
"#;
    write(d, "s.toml", study);
    let said = good(d, &["study", "s.toml", "--out", "o"]);
    assert!(said.contains("all limits kept") && said.contains("best"), "{said}");
    let told = summary(d, "o");
    let (start, best) =
        (figure(&told, "start.goals.max_pressure_mpa"), figure(&told, "best.goals.max_pressure_mpa"));
    assert!(best < 0.97 * start, "{start} {best}");
    let values = &told["best"]["values"];
    assert!(values["disc.width_mm"].as_f64().unwrap() > 9.4, "{values}");
    assert!(values["disc.modification.equidistant_offset_um"].as_f64().unwrap() < 1.0, "{values}");
    // The design file is the one that was evaluated.
    good(d, &["contact", "o/best.toml", "--positions", "8", "--out", "one"]);
    assert_eq!(figure(&summary(d, "one"), "max_pressure_mpa"), best);
    for file in ["samples.csv", "generations.csv", "report.html"] {
        assert!(Path::new(&d.join("o").join(file)).exists(), "{file}");
    }
    good(d, &["study", "submit", "s.toml", "--engine", "local", "--shards", "2", "--out", "p", "--quiet"]);
    assert!(read(d, "o/samples.csv") == read(d, "p/samples.csv"));
}
