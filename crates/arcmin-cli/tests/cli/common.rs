//! Functions by which the tests call the command.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

pub fn binary() -> PathBuf {
    assert_cmd::cargo::cargo_bin("arcmin")
}

pub fn arcmin(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(binary()).current_dir(directory).args(arguments).output().unwrap()
}

/// Output of a run: standard output and standard error.
pub fn texts(output: &Output) -> (String, String) {
    (String::from_utf8(output.stdout.clone()).unwrap(), String::from_utf8(output.stderr.clone()).unwrap())
}

/// Output of a run that must succeed.
pub fn good(directory: &Path, arguments: &[&str]) -> String {
    let output = arcmin(directory, arguments);
    let (said, complaint) = texts(&output);
    assert!(output.status.success(), "{arguments:?}: {complaint}");
    said
}

/// Message of a run that must be refused with exit code 2.
pub fn refused(directory: &Path, arguments: &[&str]) -> String {
    let output = arcmin(directory, arguments);
    let (said, complaint) = texts(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}{complaint}");
    complaint
}

/// A directory with the theoretical machine of Tao2024, whose numbers are pinned, as d.toml.
pub fn with_design() -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    good(directory.path(), &["new", "tao2024", "d.toml"]);
    directory
}

/// The theoretical machine of Tao2024, whose lines and figures tests may pin.
pub fn with_machine_of_paper() -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    good(directory.path(), &["new", "tao2024", "d.toml"]);
    directory
}

pub fn write(directory: &Path, file: &str, text: &str) {
    std::fs::write(directory.join(file), text).unwrap();
}

pub fn read(directory: &Path, file: &str) -> String {
    std::fs::read_to_string(directory.join(file)).unwrap()
}

/// Changes the design d.toml at one place.
pub fn edit(directory: &Path, from: &str, to: &str) {
    let text = read(directory, "d.toml");
    assert!(text.contains(from), "the design does not hold {from}");
    write(directory, "d.toml", &text.replacen(from, to, 1));
}

pub fn summary(directory: &Path, out: &str) -> serde_json::Value {
    serde_json::from_str(&read(directory, &format!("{out}/summary.json"))).unwrap()
}

/// A value of the summary by its path.
pub fn figure(summary: &serde_json::Value, path: &str) -> f64 {
    let value = path.split('.').fold(summary, |value, key| &value[key]);
    value.as_f64().unwrap_or_else(|| panic!("{path} is {value} in {summary}"))
}

/// Names in a directory, sorted.
pub fn names(directory: &Path) -> Vec<String> {
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<String> = std::fs::read_dir(directory).unwrap().map(name).collect();
    names.sort();
    names
}

/// Temporary files in a directory.
pub fn leftovers(directory: &Path) -> Vec<String> {
    names(directory).into_iter().filter(|name| name.starts_with('.')).collect()
}

/// Columns of a table, by its header.
pub fn header(directory: &Path, file: &str) -> Vec<String> {
    read(directory, file).lines().next().unwrap().split(',').map(str::to_owned).collect()
}

/// Cells of one column; the columns before it must not contain quoted commas.
pub fn column(directory: &Path, file: &str, name: &str) -> Vec<String> {
    let text = read(directory, file);
    let index = header(directory, file).iter().position(|column| column == name).unwrap();
    text.lines().skip(1).map(|line| line.split(',').nth(index).unwrap().to_owned()).collect()
}

/// Asserts that a table has these columns in this order; further ones are allowed.
pub fn has_columns(directory: &Path, file: &str, wanted: &str) {
    let found = header(directory, file);
    let mut rest = found.iter();
    for name in wanted.split(", ") {
        assert!(rest.any(|column| column == name), "{file} lacks {name} in its place: {found:?}");
    }
}
