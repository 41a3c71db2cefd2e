//! The book is correct: commands of the tutorials, of the how-to pages and of the chapter on single stages run
//! and print the text on the page, and links have targets.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::common::*;

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src")
}

/// Pages in a folder of the book and below, by their path from `docs/src`.
fn pages(folder: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(source().join(folder)).unwrap() {
        let entry = entry.unwrap();
        let path = format!("{folder}/{}", entry.file_name().into_string().unwrap());
        let path = path.trim_start_matches('/');
        if entry.path().is_dir() {
            found.extend(pages(path));
        } else if path.ends_with(".md") {
            found.push(path.to_owned());
        }
    }
    found.sort();
    found
}

/// Blocks of code with one of these words behind the fence, each as its place in the text and its lines.
fn blocks<'a>(text: &'a str, words: &[&str]) -> Vec<(usize, &'a str)> {
    let mut found = Vec::new();
    let mut inside: Option<(bool, usize)> = None;
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let fence = line.trim_start().strip_prefix("```");
        match (inside, fence) {
            (None, Some(word)) => inside = Some((words.contains(&word.trim()), at + line.len())),
            (Some((wanted, start)), Some(_)) => {
                if wanted {
                    found.push((start, &text[start..at]));
                }
                inside = None;
            }
            _ => {}
        }
        at += line.len();
    }
    assert!(inside.is_none(), "a block of code without an end");
    found
}

/// Words of a command line; quotes keep blanks, a backslash at the end of a line goes on.
fn words(command: &str) -> Vec<String> {
    let mut words = Vec::new();
    let (mut word, mut quoted) = (None::<String>, None::<char>);
    for letter in command.replace("\\\n", " ").chars() {
        match (letter, quoted) {
            ('"' | '\'', None) => {
                quoted = Some(letter);
                word.get_or_insert_default();
            }
            (_, Some(mark)) if letter == mark => quoted = None,
            (_, None) if letter.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(letter),
        }
    }
    words.extend(word);
    words
}

/// Commands of a block with their expected output: lines after `$ `, up to the next one.
fn commands(block: &str) -> Vec<(String, usize)> {
    let mut found: Vec<(String, usize)> = Vec::new();
    let (mut at, mut open) = (0, false);
    for line in block.split_inclusive('\n') {
        at += line.len();
        if let Some(command) = line.strip_prefix("$ ") {
            found.push((command.to_owned(), at));
            open = command.ends_with("\\\n");
        } else if open {
            let (command, end) = found.last_mut().unwrap();
            command.push_str(line);
            *end = at;
            open = line.ends_with("\\\n");
        }
    }
    found
}

/// Position of the expected words in the output; `…` is any number of words.
fn places(expected: &[&str], said: &[&str], same: fn(&str, &str) -> bool) -> Option<Vec<Option<usize>>> {
    let mut places = Vec::new();
    let mut next = 0;
    let segments: Vec<&[&str]> = expected.split(|word| *word == "…").collect();
    for (i, segment) in segments.iter().enumerate() {
        let fits = |at: usize| {
            let there = said.get(at..at + segment.len());
            there.is_some_and(|there| segment.iter().zip(there).all(|(a, b)| same(a, b)))
        };
        let last = i + 1 == segments.len();
        let at = match (i, last) {
            (0, false) => Some(0).filter(|at| fits(*at)),
            (0, true) => Some(0).filter(|at| fits(*at) && segment.len() == said.len()),
            (_, true) => said.len().checked_sub(segment.len()).filter(|at| *at >= next && fits(*at)),
            _ => (next..=said.len()).find(|at| fits(*at)),
        }?;
        places.extend((at..at + segment.len()).map(Some));
        if !last {
            places.push(None);
        }
        next = at + segment.len();
    }
    Some(places)
}

/// Equality except for numbers.
fn alike(a: &str, b: &str) -> bool {
    let bare =
        |word: &str| word.trim_matches(|c: char| c.is_ascii_digit() || "+-−.<>±".contains(c)).to_owned();
    let number = |word: &str| word.contains(|c: char| c.is_ascii_digit());
    a == b || (number(a) && number(b) && bare(a) == bare(b))
}

/// Runs blocks of a page in one directory, from the top down. `cat FILE` shows a file, or writes one that is not there yet. With ARCMIN_BOOK=rewrite numbers that have moved are put into the page.
fn run(page: &str, fences: &[&str]) -> Vec<String> {
    let path = source().join(page);
    let mut text = std::fs::read_to_string(&path).unwrap();
    let original = text.clone();
    let directory = tempfile::tempdir().unwrap();
    let mut wrong = Vec::new();
    let mut moved: Vec<(usize, usize, String)> = Vec::new();
    for (start, block) in blocks(&original, fences) {
        let commands = commands(block);
        assert!(!commands.is_empty(), "{page}: a console without a command:\n{block}");
        for (i, (command, from)) in commands.iter().enumerate() {
            let to = commands.get(i + 1).map_or(block.len(), |(next, at)| at - next.len() - "$ ".len());
            let expected = &block[*from..to];
            let arguments = words(command);
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            let said = match arguments[..] {
                ["cat", file] if !directory.path().join(file).exists() => {
                    write(directory.path(), file, expected);
                    continue;
                }
                ["cat", file] => read(directory.path(), file),
                ["arcmin", ref rest @ ..] => {
                    let output = arcmin(directory.path(), rest);
                    let (said, complaint) = texts(&output);
                    // A finding of severity error ends with 1, which pages show by its message.
                    let refused = output.status.code() == Some(2);
                    if refused || (!output.status.success() && expected.trim().is_empty()) {
                        wrong.push(format!("{page}: {command}{said}{complaint}"));
                    }
                    said
                }
                _ => panic!("{page}: only arcmin and cat are run: {command}"),
            };
            let tokens = |text: &str| -> Vec<(usize, usize)> {
                let base = text.as_ptr() as usize;
                text.split_whitespace().map(|word| (word.as_ptr() as usize - base, word.len())).collect()
            };
            let (wanted, found) = (tokens(expected), tokens(&said));
            let texts = |text: &'_ str, tokens: &[(usize, usize)]| -> Vec<String> {
                tokens.iter().map(|(at, length)| text[*at..at + length].to_owned()).collect()
            };
            let (wanted_words, found_words) = (texts(expected, &wanted), texts(&said, &found));
            let wanted_words: Vec<&str> = wanted_words.iter().map(String::as_str).collect();
            let found_words: Vec<&str> = found_words.iter().map(String::as_str).collect();
            if wanted_words.is_empty() || places(&wanted_words, &found_words, |a, b| a == b).is_some() {
                continue;
            }
            if let Some(places) = places(&wanted_words, &found_words, alike) {
                for (place, (at, length)) in places.iter().zip(&wanted) {
                    if let Some(place) = place {
                        moved.push((start + from + at, *length, found_words[*place].to_owned()));
                    }
                }
            }
            wrong.push(format!("{page}: {command}prints\n{said}\nwhere the page has\n{expected}"));
        }
    }
    if std::env::var("ARCMIN_BOOK").is_ok_and(|word| word == "rewrite") {
        for (at, length, word) in moved.into_iter().rev() {
            text.replace_range(at..at + length, &word);
        }
        std::fs::write(path, text).unwrap();
    }
    wrong
}

fn all_run(fences: &[&str]) {
    let drives = ["single-stage.md", "two-rings-and-stages.md"].map(str::to_owned).into();
    let pages = [pages("tutorials"), pages("how-to"), drives].concat();
    let wrong: Vec<String> = pages.iter().flat_map(|page| run(page, fences)).collect();
    let hint = "ARCMIN_BOOK=rewrite puts moved numbers into the pages; read what they then say";
    assert!(wrong.is_empty(), "{}\n{hint}", wrong.join("\n\n"));
}

#[test]
#[ignore = "long"]
fn book_commands_print_what_the_pages_show() {
    all_run(&["console"]);
}

#[test]
#[ignore = "some minutes: lives, calibrations, robots, elastic bodies"]
fn manual_book_commands_of_minutes_print_what_the_pages_show() {
    all_run(&["console", "console,slow"]);
}

/// Commands without output (blocks of `sh`, and `console,slow`, which take minutes) exist with all their
/// options.
#[test]
fn book_commands_are_understood() {
    let directory = tempfile::tempdir().unwrap();
    let mut count = 0;
    for page in pages("") {
        let text = std::fs::read_to_string(source().join(&page)).unwrap();
        for (_, block) in blocks(&text, &["sh", "console,slow"]) {
            let bare = block.replace("\\\n", " ");
            for line in bare.lines().map(|line| line.trim_start_matches("$ ")) {
                let line = line.split(" #").next().unwrap();
                let Some(rest) = line.strip_prefix("arcmin ") else { continue };
                let mut arguments = words(rest);
                arguments.push("--help".to_owned());
                let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
                let output = arcmin(directory.path(), &arguments);
                assert!(output.status.success(), "{page}: {line}: {}", texts(&output).1);
                count += 1;
            }
        }
    }
    assert!(count > 20, "{count} commands");
}

/// Text outside of code.
fn prose(text: &str) -> String {
    let mut prose = String::new();
    let mut inside = false;
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            inside = !inside;
        } else if !inside {
            for (i, part) in line.split('`').enumerate() {
                prose.push_str(if i % 2 == 0 { part } else { "`" });
            }
            prose.push('\n');
        }
    }
    prose
}

/// Anchors of the headings of a page, as mdbook and GitHub make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let mut inside = false;
    let mut anchors = BTreeSet::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            inside = !inside;
        }
        if inside || !line.starts_with('#') {
            continue;
        }
        let heading = line.trim_start_matches('#').trim();
        let kept = heading.chars().filter_map(|c| match c {
            _ if c.is_alphanumeric() || c == '_' || c == '-' => Some(c.to_lowercase().to_string()),
            _ if c.is_whitespace() => Some("-".to_owned()),
            _ => None,
        });
        let anchor: String = kept.collect();
        let count = seen.entry(anchor.clone()).or_default();
        anchors.insert(if *count == 0 { anchor.clone() } else { format!("{anchor}-{count}") });
        *count += 1;
    }
    anchors
}

/// Every link inside the book leads to a file of the book and, where it names one, to a heading; every page is in the
/// table of contents.
#[test]
fn book_links_lead_to_pages_and_headings() {
    let texts: BTreeMap<String, String> = pages("")
        .into_iter()
        .map(|page| {
            let mut text = std::fs::read_to_string(source().join(&page)).unwrap();
            if let Some(file) = text.split("{{#include ").nth(1).and_then(|rest| rest.split("}}").next()) {
                text = std::fs::read_to_string(source().join(file)).unwrap();
            }
            (page, text)
        })
        .collect();
    let redirects = std::fs::read_to_string(source().join("../book.toml")).unwrap();
    let mut wrong = Vec::new();
    for (page, text) in &texts {
        for link in prose(text).split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if link.starts_with("http") {
                continue;
            }
            let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
            let mut target: Vec<&str> = page.split('/').collect();
            target.pop();
            for part in path.split('/') {
                match part {
                    ".." if target.pop().is_none() => wrong.push(format!("{page}: {link} leaves the book")),
                    ".." | "." => {}
                    _ => target.push(part),
                }
            }
            let target = if path.is_empty() { page.clone() } else { target.join("/") };
            if redirects.contains(&format!("\"/{}\" = ", target.replace(".md", ".html"))) {
                continue;
            }
            if !source().join(&target).is_file() {
                wrong.push(format!("{page}: {link} leads nowhere"));
            } else if !anchor.is_empty() && !anchors(&texts[&target]).contains(anchor) {
                wrong.push(format!("{page}: {link}: {target} has no such heading"));
            }
        }
    }
    for page in texts.keys().filter(|page| *page != "SUMMARY.md") {
        if !texts["SUMMARY.md"].contains(&format!("]({page})")) {
            wrong.push(format!("{page} is not in SUMMARY.md"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
