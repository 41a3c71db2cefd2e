//! Runs that are interrupted or killed at any time, for all commands.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::*;

fn spawn(directory: &Path, arguments: &[&str]) -> Child {
    let mut command = Command::new(binary());
    command
        .args(arguments)
        .current_dir(directory)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Long commands, including elastic discs and calibration.
const LONG: &[&[&str]] = &[
    &["contact", "d.toml", "--discs", "elastic", "--element", "solid"],
    &["contact", "d.toml", "--joints", "bearings", "--positions", "36000"],
    &["wear", "d.toml", "--points", "400"],
    &["calibrate", "d.toml", "readings.csv", "--fit-running-in", "--errors", "drawn"],
    &["simulate", "d.toml", "--joints", "bearings", "--end-s", "30"],
    &["simulate", "d.toml", "--discs", "elastic", "--end-s", "30"],
    &["rig", "d.toml", "--te-positions", "65536"],
    &["life", "d.toml", "--points", "100", "--bodies", "rigid"],
    &["tao2024", "d.toml"],
];

/// Time in seconds from a signal to the end of the process.
fn seconds_to_stop(directory: &Path, arguments: &[&str], signal: &str, after: Duration) -> f64 {
    let mut child = spawn(directory, arguments);
    std::thread::sleep(after);
    assert!(child.try_wait().unwrap().is_none(), "{arguments:?} is over before it can be stopped");
    let started = Instant::now();
    Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    let code = child.wait().unwrap().code();
    let seconds = started.elapsed().as_secs_f64();
    assert_eq!(code, Some(2), "{arguments:?}");
    seconds
}

fn readings(directory: &Path) {
    write(directory, "readings.csv", "hours,depth_um\n500,2\n1500,4\n3000,6\n5000,8\n7500,10\n");
}

/// Every long command ends soon after a signal and leaves no incomplete file. The bound is wide: it only
/// distinguishes a run that reacts to the signal from one that continues to its end.
#[cfg(unix)]
#[test]
#[ignore = "long"]
fn every_long_command_can_be_interrupted() {
    let directory = with_design();
    let d = directory.path();
    readings(d);
    for (index, command) in LONG.iter().enumerate() {
        let signal = ["-INT", "-TERM"][index % 2];
        let arguments = [command, &["--out", "o", "--force"][..]].concat();
        let seconds = seconds_to_stop(d, &arguments, signal, Duration::from_millis(600));
        assert!(seconds < 3.0, "{arguments:?} went on for {seconds} s");
        assert_eq!(leftovers(&d.join("o")), Vec::<String>::new(), "{arguments:?}");
        assert!(!d.join("o/summary.json").exists(), "{arguments:?}");
    }
}

/// Measures the time from signal to end of each long command: `cargo test … measured_stops -- --ignored
/// --nocapture`.
#[cfg(unix)]
#[test]
#[ignore = "a measurement of some minutes"]
fn manual_measured_stops() {
    let directory = with_design();
    let d = directory.path();
    readings(d);
    for command in LONG {
        let arguments = [command, &["--out", "o", "--force"][..]].concat();
        let mut worst = 0.0_f64;
        for signal in ["-INT", "-TERM"] {
            for after in [300, 900, 1800] {
                worst = worst.max(seconds_to_stop(d, &arguments, signal, Duration::from_millis(after)));
            }
        }
        println!("{worst:.2} s at most: {}", command.join(" "));
    }
}

/// All files of a directory by name, hidden ones left out.
fn content(directory: &Path) -> Vec<(String, Vec<u8>)> {
    let names = names(directory).into_iter().filter(|name| !name.starts_with('.'));
    names.map(|name| (name.clone(), std::fs::read(directory.join(name)).unwrap())).collect()
}

/// Results that do not depend on clock and directory: tables.
fn tables(directory: &Path) -> Vec<(String, Vec<u8>)> {
    content(directory).into_iter().filter(|(name, _)| name.ends_with(".csv")).collect()
}

/// Kills runs of all commands at random times. The directory contains results of the same command with other
/// options: afterwards it contains the old summary with all its old tables, or the new one with all the new
/// ones, or no summary; every table is complete and from one of the two runs; the next run removes everything
/// else.
fn kill_at_random(kills: usize) {
    let commands: &[(&[&str], &[&str])] = &[
        (&["check", "d.toml"], &["--explain"]),
        (&["profile", "d.toml", "--points", "900"], &["--wear-um", "5"]),
        (&["contact", "d.toml", "--positions", "90"], &["--torque-nm", "300"]),
        (&["contact", "d.toml", "--joints", "bearings", "--positions", "12"], &["--torque-nm", "300"]),
        (&["wear", "d.toml", "--hours", "30", "--points", "3"], &["--seed", "2", "--errors", "drawn"]),
        (&["calibrate", "d.toml", "short.csv", "--joints", "ideal"], &["--reading-error-percent", "5"]),
        (&["simulate", "d.toml", "--end-s", "0.3"], &["--wear-um", "5"]),
        (&["rig", "d.toml", "--positions", "1", "--te-positions", "64"], &["--frictionless"]),
        (&["export", "profile", "d.toml", "--format", "csv"], &["--tolerance-um", "0.1"]),
    ];
    let directory = with_design();
    let d = directory.path();
    write(d, "short.csv", "hours,depth_um\n30,0.2\n60,0.4\n");
    let mut state = 88_172_645_463_325_252_u64;
    let mut random = move || {
        // xorshift64
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut done, mut running) = (0, 0);
    let rounds = kills.div_ceil(commands.len());
    for (index, (command, other)) in commands.iter().enumerate() {
        let (new, old) = (format!("new{index}"), format!("old{index}"));
        let started = Instant::now();
        good(d, &[command, &["--out", &new][..]].concat());
        let whole = started.elapsed();
        good(d, &[command, *other, &["--out", &old][..]].concat());
        let (new_tables, old_tables) = (tables(&d.join(&new)), tables(&d.join(&old)));
        for _ in 0..rounds {
            let out = format!("o{index}");
            let _ = std::fs::remove_dir_all(d.join(&out));
            good(d, &[command, *other, &["--out", &out][..]].concat());
            let before = content(&d.join(&out));
            let mut child = spawn(d, &[command, &["--out", &out][..]].concat());
            std::thread::sleep(whole.mul_f64(1.1 * random()));
            running += usize::from(child.try_wait().unwrap().is_none());
            let _ = child.kill();
            child.wait().unwrap();
            done += 1;
            let found = tables(&d.join(&out));
            for table in &found {
                assert!(
                    old_tables.contains(table) || new_tables.contains(table),
                    "{command:?}: {} is damaged",
                    table.0
                );
            }
            let all = content(&d.join(&out));
            if all.iter().any(|(name, _)| name == "summary.json") {
                let told = summary(d, &out);
                let files: Vec<String> = serde_json::from_value(told["files"].clone()).unwrap();
                for file in &files {
                    assert!(d.join(&out).join(file).exists(), "{command:?}: {file} is lost");
                }
                let is_old = before.iter().find(|(name, _)| name == "summary.json")
                    == all.iter().find(|(name, _)| name == "summary.json");
                assert_eq!(
                    found,
                    if is_old { old_tables.clone() } else { new_tables.clone() },
                    "{command:?}: mixed"
                );
            }
        }
        let out = format!("o{index}");
        good(d, &[command, &["--out", &out][..]].concat());
        assert_eq!(tables(&d.join(&out)), new_tables, "{command:?}");
        assert_eq!(leftovers(&d.join(&out)), Vec::<String>::new(), "{command:?}");
    }
    println!("{done} kills, {running} of them while it ran");
    assert!(running * 3 > done, "{running} of {done}: hardly a run was interrupted");
}

/// A simulation that is killed repeatedly continues from its checkpoints to the same bytes as a single run.
fn kill_and_resume(kills: usize) {
    let directory = with_design();
    let d = directory.path();
    let run = ["simulate", "d.toml", "--joints", "bearings", "--end-s", "1.5", "--quiet", "--out"];
    let started = Instant::now();
    good(d, &[&run[..], &["whole"]].concat());
    let whole = started.elapsed();
    let mut ended = 0;
    for kill in 0..kills {
        let goes_on = d.join("parts/checkpoint.json").exists();
        let arguments = [&run[..], &["parts"], if goes_on { &["--resume"][..] } else { &[] }].concat();
        let mut child = spawn(d, &arguments);
        std::thread::sleep(whole.mul_f64(0.1 + 0.9 * ((kill * 7919) % 97) as f64 / 97.0));
        ended += usize::from(child.try_wait().unwrap().is_some());
        let _ = child.kill();
        child.wait().unwrap();
    }
    let goes_on = d.join("parts/checkpoint.json").exists();
    good(d, &[&run[..], &["parts"], if goes_on { &["--resume"][..] } else { &[] }].concat());
    assert_eq!(
        tables(&d.join("whole")),
        tables(&d.join("parts")),
        "after {kills} kills, {ended} of them too late"
    );
    assert_eq!(leftovers(&d.join("parts")), Vec::<String>::new());
}

#[test]
#[ignore = "long"]
fn kills_at_random_moments_mix_nothing() {
    kill_at_random(18);
    kill_and_resume(3);
}

/// `cargo test … two_hundred_kills -- --ignored --nocapture`.
#[test]
#[ignore = "some minutes"]
fn manual_two_hundred_kills() {
    kill_at_random(180);
    kill_and_resume(20);
}
