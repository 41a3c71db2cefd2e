//! Throws hostile tables and hostile designs at the readers and says what became of them:
//!
//!     cargo run --release --example hostile -- 100000
//!
//! A table is read or refused with a line and a remedy, never misread: numbers written with `;` and `,` read back
//! to the same bits, and what is accepted of a peppered table holds only numbers that stand in it. A design is
//! refused with a place and a text without control characters, or gives a machine whose checks hold no NaN.

use std::collections::BTreeMap;
use std::time::Instant;

use arcmin::checks::check_design;
use arcmin::design::Design;
use arcmin::tables::{Column, Form};
use arcmin::templates::TEMPLATES;

/// xorshift64: the same files on every machine.
struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % count
    }

    fn pick<'a>(&mut self, words: &[&'a str]) -> &'a str {
        words[self.below(words.len())]
    }

    fn number(&mut self) -> f64 {
        let digits = self.below(2_000_001) as f64 - 1e6;
        digits * 10.0_f64.powi(self.below(13) as i32 - 9)
    }
}

const PIECES: &[&str] = &[
    "hours",
    "depth_um",
    "depth [mm]",
    "note",
    "sep=;",
    ";",
    ",",
    "\t",
    "\"",
    "#",
    "\n",
    "\r\n",
    "\r",
    "0",
    "1,5",
    "1.5",
    "078",
    "1,234",
    "1.234,5",
    "-",
    "e9",
    "1e999",
    "nan",
    "inf",
    "[",
    "µ",
    "\u{feff}",
    " ",
    "\u{1b}[2J",
    "\u{0}",
    "\u{a0}",
    "°",
    "1;2\n",
    "3;4,5\n",
    "2,1\n",
    "''",
    "0x10",
    "999999999999999999999",
];

fn forms() -> [Form; 2] {
    let columns = || [Column::number("hours").rising(), Column::number("depth_um").within(-1e3, 1e3)];
    [Form::new(&columns()), Form::new(&columns()).with_others()]
}

/// A table of numbers with semicolons and decimal commas, and the numbers.
fn european(random: &mut Random) -> (String, Vec<(f64, f64)>) {
    let rows: Vec<(f64, f64)> =
        (0..1 + random.below(12)).map(|row| (row as f64 + 0.125, random.number() % 1e3)).collect();
    let end = random.pick(&["\n", "\r\n"]);
    let mut text = format!("{}hours;depth_um{end}", random.pick(&["", "\u{feff}"]));
    for (hours, depth) in &rows {
        text += &format!("{hours};{depth}{end}").replace('.', ",");
    }
    (text, rows)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count: usize = std::env::args().nth(1).map_or(Ok(1000), |word| word.parse())?;
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut outcomes: BTreeMap<&str, usize> = BTreeMap::new();
    let mut note = |what: &'static str| *outcomes.entry(what).or_default() += 1;
    let started = Instant::now();
    for _ in 0..count {
        let (text, rows) = european(&mut random);
        let table = forms()[0].read(text.as_bytes(), "t").map_err(|error| format!("{error}: {text:?}"))?;
        let (hours, depths) = (table.numbers("hours")?, table.numbers("depth_um")?);
        let back: Vec<(f64, f64)> = hours.iter().copied().zip(depths.iter().copied()).collect();
        assert_eq!(back, rows, "misread: {text:?}");
        note("tables written with ; and , that read back to the same bits");
        // The same table, cut, doubled and peppered.
        let mut bytes = text.into_bytes();
        for _ in 0..1 + random.below(4) {
            let at = random.below(bytes.len().max(1)).min(bytes.len());
            match random.below(4) {
                0 => bytes.truncate(at),
                1 => bytes.insert(at, random.below(256) as u8),
                2 => drop(bytes.splice(at..at, random.pick(PIECES).bytes())),
                _ => bytes.extend_from_within(at..),
            }
        }
        let pieces: String = (0..random.below(60)).map(|_| random.pick(PIECES)).collect();
        for hostile in [&bytes[..], pieces.as_bytes()] {
            for form in forms() {
                match form.read(hostile, "t") {
                    Ok(table) => {
                        let depths = table.numbers("depth_um")?;
                        assert!(depths.len() == table.len() && depths.iter().all(|depth| depth.abs() <= 1e3));
                        note("peppered tables that were read");
                    }
                    Err(error) => {
                        let told = format!("{error}{}", error.remedy());
                        assert!(
                            !told.chars().any(char::is_control) && !error.remedy().is_empty(),
                            "{told:?}"
                        );
                        note("peppered tables that were refused with a remedy");
                    }
                }
            }
        }
    }
    let tables = started.elapsed().as_secs_f64();
    let values = [
        "0",
        "-1",
        "1e-9",
        "1e9",
        "nan",
        "-inf",
        "1e400",
        "9223372036854775807",
        "true",
        "\"3\"",
        "[]",
        "{}",
        "[1, 2]",
        "\"\\u001b[31m\"",
        "",
        "0.5",
        "3",
        "17",
        "40",
        "2.5e2",
        "\"GCr15\"",
        "\"ball\"",
    ];
    let started = Instant::now();
    for index in 0..count {
        let mut lines: Vec<String> =
            TEMPLATES[index % TEMPLATES.len()].text.lines().map(str::to_owned).collect();
        for _ in 0..1 + random.below(5) {
            let at = random.below(lines.len());
            let key = lines[at].split('=').next().unwrap_or_default().trim().to_owned();
            lines[at] = match random.below(8) {
                0 => String::new(),
                1 => format!("{key}x = {}", random.pick(&values)),
                2 => lines[at].chars().rev().collect(),
                3 => format!("{}{}", lines[at], random.pick(PIECES)),
                4 => lines[random.below(lines.len())].clone(),
                _ => format!("{key} = {}", random.pick(&values)),
            };
        }
        let text = lines.join("\n");
        match Design::parse(&text, "d.toml") {
            Err(error) => {
                for error in error.all() {
                    assert!(error.span().is_some_and(|span| span.end <= text.len()), "{error}");
                }
                note("designs that were refused with line and text");
            }
            Ok(design) => {
                for finding in check_design(&design) {
                    assert!(!finding.value.is_nan() && !finding.message.contains("NaN"), "{finding:?}");
                }
                note("designs that were read and checked");
            }
        }
    }
    for (what, count) in &outcomes {
        println!("{count:>8} {what}");
    }
    println!("{tables:.1} s for tables, {:.1} s for designs", started.elapsed().as_secs_f64());
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        print!("{}", status.lines().find(|line| line.starts_with("VmHWM")).unwrap_or_default());
        println!(" of memory at most");
    }
    Ok(())
}
