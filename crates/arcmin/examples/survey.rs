//! Runs random sound designs through contact, wear, quasi-static life and test bench, and says what failed and
//! how long it took:
//!
//! `cargo run --release -p arcmin --example survey -- [designs] [first seed] [contact,wear,life,rig]`
//!
//! Designs in files are run instead where paths end in `.toml`.

#[path = "../tests/support/run.rs"]
mod run;
#[path = "../tests/support/mod.rs"]
mod support;

use std::time::Instant;

use arcmin::design::Design;
use run::{Analysis, Outcome, run};

fn main() {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let words =
        |list: &str| Analysis::ALL.into_iter().filter(|a| list.contains(a.word())).collect::<Vec<_>>();
    let files: Vec<String> = arguments.extract_if(.., |argument| argument.ends_with(".toml")).collect();
    let analyses = arguments
        .extract_if(.., |argument| !argument.starts_with(|c: char| c.is_ascii_digit()))
        .next()
        .map_or_else(|| Analysis::ALL.to_vec(), |list| words(&list));
    let mut numbers = arguments.iter().filter_map(|argument| argument.parse::<u64>().ok());
    let (count, first) = (numbers.next().unwrap_or(10), numbers.next().unwrap_or(1));
    let designs: Vec<(String, Design)> = if files.is_empty() {
        (first..first + count).map(|seed| (format!("seed {seed}"), support::sound_design(seed).0)).collect()
    } else {
        let read = |path: &String| {
            let text = std::fs::read_to_string(path).ok()?;
            Some((path.clone(), Design::parse(&text, path).ok()?))
        };
        files.iter().filter_map(read).collect()
    };
    let (mut runs, mut failures, mut slowest) = (0, 0, 0.0_f64);
    for (name, design) in &designs {
        for analysis in &analyses {
            let start = Instant::now();
            let outcome = run(design, *analysis);
            let seconds = start.elapsed().as_secs_f64();
            runs += 1;
            slowest = slowest.max(seconds);
            if let Outcome::Failed(_) = outcome {
                failures += 1;
            }
            if !matches!(outcome, Outcome::Result) || seconds > 10.0 {
                println!("{name} {}: {seconds:.1} s, {outcome:?}", analysis.word());
            }
        }
    }
    println!("{runs} runs, {failures} failed, the slowest took {slowest:.1} s");
}
