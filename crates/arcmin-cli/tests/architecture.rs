//! Statements of the texts about the repository are true: the order of modules, generated chapters, copies.

use arcmin::templates::{DRIVES, TEMPLATES};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap()
}

fn sources(directory: &Path, endings: &[&str], out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, endings, out);
        } else if path.extension().is_some_and(|own| endings.iter().any(|ending| own == *ending)) {
            out.push(path);
        }
    }
}

/// Crates of the library, the lower one first.
const LIBRARY: [&str; 2] = ["arcmin-mechanics", "arcmin"];

/// Modules of a crate's table in ARCHITECTURE.md with the number of their row.
fn rows(package: &str) -> BTreeMap<String, usize> {
    let text = read("ARCHITECTURE.md");
    let heading = format!("### `crates/{package}`");
    let section = text.lines().skip_while(|line| *line != heading);
    let table = section.skip_while(|line| *line != "| module | what lives there |").skip(2);
    let mut rows = BTreeMap::new();
    for (row, line) in table.take_while(|line| line.starts_with('|')).enumerate() {
        let cell = line.split('|').nth(1).unwrap();
        for name in cell.split('`').skip(1).step_by(2) {
            rows.insert(name.to_owned(), row);
        }
    }
    rows
}

/// Code without tests and comments.
fn product(path: &Path) -> Option<String> {
    let name = path.file_stem().unwrap().to_str().unwrap();
    if name == "tests"
        || name.ends_with("_tests")
        || path.components().any(|part| part.as_os_str() == "tests")
    {
        return None;
    }
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    Some(text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n"))
}

/// Modules import only from rows above theirs; modules of one row may import each other where the table allows
/// it.
#[test]
fn modules_import_in_the_order_of_the_architecture() {
    for package in LIBRARY {
        imports_are_in_order(package);
    }
}

fn imports_are_in_order(package: &str) {
    let source = root().join(format!("crates/{package}/src"));
    let rows = rows(package);
    let lib = std::fs::read_to_string(source.join("lib.rs")).unwrap();
    let modules: Vec<&str> =
        lib.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    for module in &modules {
        assert!(rows.contains_key(*module), "ARCHITECTURE.md does not tell what lives in {module}");
    }
    assert_eq!(rows.len(), modules.len(), "ARCHITECTURE.md names a module that is not there");
    let mut files = Vec::new();
    sources(&source, &["rs"], &mut files);
    let mut wrong = Vec::new();
    for path in files {
        let inside = path.strip_prefix(&source).unwrap();
        let first = inside.components().next().unwrap().as_os_str().to_str().unwrap();
        let module = first.trim_end_matches(".rs");
        let (Some(row), Some(text)) = (rows.get(module), product(&path)) else { continue };
        for at in text.match_indices("crate::").map(|(at, _)| at) {
            let used: String =
                text[at + 7..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            // A `{` after `crate::` names several modules at once, which is not used in any file.
            if used != module && rows.get(&used).is_some_and(|other| other > row) {
                wrong.push(format!("{} uses {used}", inside.display()));
            }
        }
        assert!(!text.contains("use crate::{"), "{}: one line for each module", inside.display());
    }
    assert!(wrong.is_empty(), "against the order of ARCHITECTURE.md:\n{}", wrong.join("\n"));
}

/// The designs at the root are those that go into the package.
#[test]
fn shipped_designs_are_packaged() {
    for template in TEMPLATES.iter().chain(&DRIVES) {
        let name = template.file;
        let copy = format!("crates/arcmin-mechanics/designs/{name}");
        assert!(read(&format!("designs/{name}")) == read(&copy), "`cp designs/{name} {copy}`");
    }
    for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
        for package in ["arcmin-mechanics", "arcmin", "arcmin-cli"] {
            assert!(read(licence) == read(&format!("crates/{package}/{licence}")), "{package} {licence}");
        }
    }
}

#[test]
fn the_chapter_of_results_is_current() {
    let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("arcmin"));
    let output = command.args(["keys", "--results"]).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let hint = "`cargo run --release -- keys --results > docs/src/results.md` writes it";
    assert!(read("docs/src/results.md") == text, "the chapter is not that of the program; {hint}");
}

/// Every chapter is in the book, and every file the README and ARCHITECTURE link to exists.
#[test]
fn links_of_the_documents_lead_somewhere() {
    for (file, base) in [
        ("README.md", ""),
        ("ARCHITECTURE.md", ""),
        ("CONTRIBUTING.md", ""),
        ("RELEASING.md", ""),
        ("ROADMAP.md", ""),
        ("SECURITY.md", ""),
        ("CODE_OF_CONDUCT.md", ""),
        ("docs/dependencies.md", "docs/"),
        ("docs/src/SUMMARY.md", "docs/src/"),
        ("validation/measurements/README.md", "validation/measurements/"),
    ] {
        for link in read(file).split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let path = link.split('#').next().unwrap();
            if !link.starts_with("http") && !path.is_empty() {
                assert!(root().join(base).join(path).exists(), "{file} links to {link}");
            }
        }
    }
}

/// Names of code in the documents for contributors exist in the sources: identifiers with an underscore or a capital after
/// the first letter, and the last part of paths with `::`.
#[test]
fn code_that_the_documents_name_exists() {
    let mut files = Vec::new();
    for directory in ["crates", "python"] {
        sources(&root().join(directory), &["rs", "js", "py"], &mut files);
    }
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let mut known: BTreeSet<String> = BTreeSet::new();
    for file in files {
        let text = std::fs::read_to_string(file).unwrap();
        known.extend(text.split(|c| !is_part(c)).map(str::to_owned));
    }
    let is_name = |name: &str| {
        let inside = name.get(1..name.len().saturating_sub(1)).unwrap_or_default();
        name.chars().all(is_part) && inside.contains(|c: char| c == '_' || c.is_uppercase())
    };
    let mut missing = Vec::new();
    for document in ["ARCHITECTURE.md", "CONTRIBUTING.md", "docs/src/extending.md", "docs/src/theory.md"] {
        let text = read(document);
        for code in text.split('`').skip(1).step_by(2) {
            let name = code.trim_end_matches("()").rsplit("::").next().unwrap_or_default();
            if is_name(name) && !known.contains(name) {
                missing.push(format!("{document}: {code}"));
            }
        }
    }
    assert!(missing.is_empty(), "names without code: {missing:?}");
}

/// Every direct dependency has a line with its reason, and every line has its dependency.
#[test]
fn every_dependency_is_justified() {
    let reasons = read("docs/dependencies.md");
    for (heading, packages) in [
        ("## Library", &LIBRARY[..]),
        ("## Command", &["arcmin-cli"]),
        ("## FMU", &["arcmin-fmu"]),
        ("## Python package", &["arcmin-py"]),
    ] {
        let section = reasons.split(&format!("{heading}\n")).nth(1).unwrap().split("\n## ").next().unwrap();
        let told: BTreeSet<&str> =
            section.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next()).collect();
        let mut needed = BTreeSet::new();
        for package in packages {
            for part in read(&format!("crates/{package}/Cargo.toml")).split("\n[") {
                if part.split(']').next().unwrap().ends_with("dependencies") {
                    let names = part.lines().skip(1).filter_map(|line| Some(line.split_once(" = ")?.0));
                    needed.extend(names.map(str::to_owned));
                }
            }
        }
        let needed: BTreeSet<&str> = needed.iter().map(String::as_str).collect();
        assert_eq!(told, needed, "docs/dependencies.md, {heading}");
    }
}

/// Two workspaces with one target directory share their builds only if the profiles agree. `parquet` is the
/// exception: it is optimised for the wheel, whose size is limited, and not for the first build of the command.
#[test]
fn the_python_package_is_built_with_the_profile_of_the_root() {
    let of = |path: &str| {
        let text = read(path);
        let start = text.find("[profile.release]").unwrap();
        let end = text.find("[profile.checked]").unwrap_or(text.len());
        let lines = text[start..end].lines().filter(|line| !line.starts_with('#') && !line.is_empty());
        lines
            .filter(|line| !line.starts_with("arcmin-fmu") && !line.starts_with("parquet"))
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    assert_eq!(of("Cargo.toml"), of("crates/arcmin-py/Cargo.toml"));
}
