//! Results are complete or absent, whatever happens to a run.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use crate::common::*;

#[test]
fn a_file_in_place_of_the_output_directory_is_a_clear_error() {
    let directory = with_design();
    let d = directory.path();
    write(d, "blocked", "precious");
    for out in ["blocked", "blocked/deeper"] {
        let said = refused(d, &["profile", "d.toml", "--out", out]);
        assert!(said.contains(&format!("cannot write {out}: ")), "{said}");
        assert!(said.contains("choose another directory with --out"), "{said}");
    }
    assert_eq!(read(d, "blocked"), "precious");
}

/// A disk that is full after some kilobytes: the limit of the file size with its signal ignored causes the same
/// kind of write error.
#[cfg(unix)]
#[test]
fn a_full_disk_is_a_clear_error_and_keeps_earlier_results() {
    let directory = with_design();
    let d = directory.path();
    good(d, &["profile", "d.toml", "--points", "4", "--out", "full"]);
    let before = (read(d, "full/profile.csv"), read(d, "full/summary.json"));
    let script = "trap '' XFSZ; ulimit -f 16; exec \"$0\" profile d.toml --points 2000 --out full";
    let output = Command::new("bash").args(["-c", script]).arg(binary()).current_dir(d).output().unwrap();
    let (_, said) = texts(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("cannot write full/profile.csv: File too large") && said.contains("free disk space"),
        "{said}"
    );
    assert!(before == (read(d, "full/profile.csv"), read(d, "full/summary.json")));
    assert_eq!(leftovers(&d.join("full")), Vec::<String>::new());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error() {
    let directory = with_design();
    for arguments in [
        "keys",
        "check d.toml",
        "check d.toml --json",
        "new --list",
        "completions bash",
        "man",
        "--help",
        "life --help",
        "--version",
    ] {
        let script = format!("\"$0\" {arguments} > /dev/full");
        let mut command = Command::new("bash");
        let output =
            command.args(["-c", &script]).arg(binary()).current_dir(directory.path()).output().unwrap();
        let (_, said) = texts(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
        assert!(
            said.contains("cannot write standard output: No space left on device"),
            "{arguments}: {said}"
        );
    }
}

#[cfg(unix)]
#[test]
fn a_reader_who_leaves_early_does_no_harm() {
    let directory = with_design();
    for arguments in ["check d.toml", "keys", "life --help"] {
        let script = format!("\"$0\" {arguments} | head -c 1 > /dev/null; exit ${{PIPESTATUS[0]}}");
        let mut command = Command::new("bash");
        let output =
            command.args(["-c", &script]).arg(binary()).current_dir(directory.path()).output().unwrap();
        assert_eq!((output.status.code(), texts(&output).1.as_str()), (Some(0), ""));
    }
}

#[test]
fn tables_of_the_run_before_do_not_stay() {
    let directory = with_design();
    let d = directory.path();
    write(d, "d.toml", &(read(d, "d.toml") + "\n[errors]\npin_circle_radius_um = 2\n"));
    let run = ["contact", "d.toml", "--joints", "bearings", "--positions", "8", "--out", "o"];
    good(d, &run);
    assert!(d.join("o/errors.csv").exists());
    // Existing files are kept, also those that a manipulated summary lists.
    write(d, "o/notes.txt", "mine");
    write(d, "precious.csv", "mine");
    write(
        d,
        "o/summary.json",
        &read(d, "o/summary.json").replace("\"errors.csv\"", "\"errors.csv\", \"../precious.csv\""),
    );
    good(d, &[&run[..], &["--errors", "none"]].concat());
    assert!(!d.join("o/errors.csv").exists(), "a stale table stands beside a new summary");
    assert_eq!((read(d, "o/notes.txt"), read(d, "precious.csv")), ("mine".to_owned(), "mine".to_owned()));
}

#[test]
fn results_of_another_design_are_not_written_over() {
    let directory = with_design();
    let d = directory.path();
    good(d, &["new", "rv-80e", "e.toml"]);
    good(d, &["profile", "d.toml", "--points", "4", "--out", "o"]);
    let before = names(&d.join("o")).iter().map(|name| read(d, &format!("o/{name}"))).collect::<Vec<_>>();
    assert_eq!(
        refused(d, &["profile", "e.toml", "--points", "4", "--out", "o"]),
        "  × o holds results of another design, \"RV-40E-81 of Tao2024\"\n  \
         help: choose another directory with --out, or overwrite them with --force\n"
    );
    assert_eq!(
        before,
        names(&d.join("o")).iter().map(|name| read(d, &format!("o/{name}"))).collect::<Vec<_>>()
    );
    good(d, &["profile", "e.toml", "--points", "4", "--out", "o", "--force"]);
    assert_ne!(summary(d, "o")["design"]["name"], "RV-40E-81");
}

/// Temporary files of killed runs are removed by the next one; those of running processes are kept.
#[cfg(target_os = "linux")]
#[test]
fn leftovers_of_killed_runs_are_removed() {
    let directory = with_design();
    let d = directory.path();
    std::fs::create_dir(d.join("o")).unwrap();
    let (dead, alive) = (".arcmin-01-x", ".arcmin-02-x");
    write(d, &format!("o/{dead}"), "half");
    write(d, &format!("o/{alive}"), "half");
    // A running process holds the lock of its files.
    let held = std::fs::File::open(d.join("o").join(alive)).unwrap();
    held.lock().unwrap();
    write(d, "o/.hidden", "mine");
    good(d, &["profile", "d.toml", "--points", "4", "--out", "o"]);
    assert_eq!(leftovers(&d.join("o")), [alive, ".hidden"]);
}

/// Kills runs at many times: every file with a final name is complete.
#[test]
fn a_killed_run_leaves_no_damaged_file() {
    let directory = with_design();
    let d = directory.path();
    let arguments = ["profile", "d.toml", "--points", "3000", "--out", "killed", "--quiet"];
    good(d, &arguments);
    let complete = std::fs::read(d.join("killed/profile.csv")).unwrap();
    let mut interrupted = 0;
    for attempt in 0..30 {
        let mut child = Command::new(binary()).args(arguments).current_dir(d).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(4 * attempt));
        interrupted += usize::from(child.try_wait().unwrap().is_none());
        let _ = child.kill();
        child.wait().unwrap();
        assert!(std::fs::read(d.join("killed/profile.csv")).unwrap() == complete, "attempt {attempt}");
        // Between the first new table and the new summary there is none; a damaged one would not parse.
        if d.join("killed/summary.json").exists() {
            assert_eq!(summary(d, "killed")["points_per_lobe"], 3000);
        }
    }
    assert!(interrupted > 0, "no run was interrupted: nothing was tested");
    good(d, &arguments);
    assert_eq!(leftovers(&d.join("killed")), Vec::<String>::new());
}

/// Sends a signal after longer and longer delays until a run ends in an orderly way.
#[cfg(unix)]
pub fn interrupted(directory: &Path, arguments: &[&str], signal: &str) -> Output {
    for delay in (0..40).map(|i| 100 + 25 * i) {
        let mut command = Command::new(binary());
        let child = command
            .args(arguments)
            .current_dir(directory)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(delay));
        Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        let output = child.wait_with_output().unwrap();
        // Before the handler is installed the signal ends the process without a code.
        if output.status.code() == Some(2) {
            return output;
        }
    }
    panic!("no run was interrupted: nothing was tested");
}

/// Ctrl-C and SIGTERM end a run in an orderly way: with a message, without temporary files, and with the
/// earlier results unchanged.
#[cfg(unix)]
#[test]
fn an_interrupted_run_keeps_earlier_results() {
    let directory = with_design();
    let d = directory.path();
    good(d, &["wear", "d.toml", "--hours", "5", "--points", "1", "--out", "o"]);
    let all = || names(&d.join("o")).iter().map(|name| read(d, &format!("o/{name}"))).collect::<Vec<_>>();
    let before = all();
    for signal in ["-INT", "-TERM"] {
        let output = interrupted(d, &["wear", "d.toml", "--points", "400", "--out", "o"], signal);
        let (_, said) = texts(&output);
        assert!(
            said.contains("stopped before the end") && said.contains("no results were written"),
            "{said}"
        );
        assert_eq!((leftovers(&d.join("o")), all()), (Vec::new(), before.clone()));
    }
}

/// An interrupted simulation continues from its checkpoint to the same bytes, and only with the same inputs:
/// the content of the files matters, not their names.
#[cfg(unix)]
#[test]
fn an_interrupted_simulation_resumes_to_the_same_result() {
    let directory = with_design();
    let d = directory.path();
    let load = "time_s,torque_n_m\n0,0\n0.2,0\n9,1\n";
    write(d, "load.csv", load);
    let run = [
        "simulate",
        "d.toml",
        "--load",
        "table",
        "--load-file",
        "load.csv",
        "--end-s",
        "3",
        "--quiet",
        "--out",
    ];
    good(d, &[&run[..], &["whole"]].concat());
    let parts = [&run[..], &["parts"]].concat();
    let output = interrupted(d, &parts, "-TERM");
    let (_, said) = texts(&output);
    assert!(
        said.contains("stopped at t = ") && said.contains("with --resume to continue from there"),
        "{said}"
    );
    assert!(d.join("parts/checkpoint.json").exists());
    let resume = [&parts[..], &["--resume"]].concat();
    write(d, "load.csv", &load.replace("9,1", "9,2"));
    let said = refused(d, &resume).replace("\n  │ ", " ");
    assert!(said.contains("belongs to a run with another design, other options or input files"), "{said}");
    write(d, "load.csv", load);
    good(d, &resume);
    assert!(read(d, "whole/timeseries.csv") == read(d, "parts/timeseries.csv"));
    assert!(!d.join("parts/checkpoint.json").exists());
}
