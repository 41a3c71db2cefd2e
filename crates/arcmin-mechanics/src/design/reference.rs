//! The reference of all keys, from the same declarations as the reader.

use super::field::join;
use super::hint::plain;
use super::schema::{Key, Kind, Presence, SectionSchema};
use super::{DesignSections, MaterialTable, StageSections, TwoRingSections};
use crate::materials::Material;

const INTRODUCTION: &str = "\
# The design file

A design file is [TOML](https://toml.io). Units are part of the keys, so that no value can be read in the wrong one. Unknown keys are
errors, and so are values outside of the range given here, values that are not finite, and values that contradict each other. `arcmin new FILE` writes a complete file to start from.

Materials are given by name or as an inline table, for example
`material = { name = \"42CrMo4\", youngs_modulus_gpa = 210, poisson_ratio = 0.3, density_g_cm3 = 7.85 }`.

This chapter is the output of `arcmin keys`.
";

const SINGLE_STAGE: &str = "
## Single stages

A file with `[drive] family = \"eccentric\"` describes a [single stage](single-stage.md): eccentrics in the middle of the input
shaft, discs, a ring of pins, and output pins in holes of the discs. `[ring]`, `[disc]`, `[contact]`, `[load]` and `[limits]` are
those above, as are torques, speeds and shares of `[[duty]]`; of `[friction]` the first three coefficients count, of `[wear]` the law, the coefficient, the running-in and the pins. `[unknowns]` are those of RV reducers, with keys of this family. There is no
`[crankshafts]`, `[gear_stage]` or `[carrier]`. `fixed_member` is `ring` (the default: the output pins turn, ratio −z_c/m with the tooth
difference m) or `output` (the ring turns with the load, ratio z_p/m). `ring.tooth_difference` and `disc.tip_diameter_mm` are keys of this
family and of the two below alone. These sections are its own:
";

const TWO_RINGS: &str = "
## Drives of two rings

A file with `[drive] family = \"two-ring\"` describes stepped discs in [two rings](two-rings-and-stages.md). `[ring]` is the ring at
rest, `[disc]` the stepped discs with the step in it, `[second_ring]` with the keys of `[ring]` the ring that is the output,
`[second_disc]` the step in it. `[eccentric]` and `[bearings]` are those of a single stage, `[friction]`, `[contact]`, `[load]`,
`[[duty]]`, `[wear]` and `[limits]` as there; `[wear]` holds for both rings, and a coefficient that is found from a depth is found from
that of the flank in `[ring]`. `[thermal]` and `[unknowns]` are those of a single stage. These sections are
its own, single pins, flanks and eccentrics of errors as those of a single stage:
";

const TWO_STAGES: &str = "
## Drives of two stages

A file with `[drive] family = \"two-stage\"` describes [two single stages in series](two-rings-and-stages.md#two-stages). The sections of
a single stage are those of the stage at the output. Those of the stage at the input stand under `first_stage`:
`[first_stage.ring]`, `[first_stage.disc]`, `[first_stage.eccentric]`, `[first_stage.output_pins]`, `[first_stage.bearings]`, with the
same keys. Both rings are at rest. `[friction]`, `[contact]`, `[load]`, `[[duty]]`, `[wear]` and `[limits]` are those of the drive; `[wear]`
holds for both stages, and a coefficient that is found from a depth is found from that of the stage at the output.
`[errors]`, `[tolerances]` and `[process]` are those of the stage at the output, `[first_stage.errors]`, `[first_stage.tolerances]` and
`[first_stage.process]` of the other. `[thermal]` and `[unknowns]` are those of a single stage.
";
/// Sections of a single stage that differ from those of RV reducers.
const OF_STAGES: [&str; 7] =
    ["eccentric", "output_pins", "bearings", "thermal", "errors", "process", "tolerances"];

/// The same for a drive of two rings.
const OF_TWO_RINGS: [&str; 7] = [
    "second_disc",
    "errors",
    "second_errors",
    "process",
    "second_process",
    "tolerances",
    "second_tolerances",
];

/// The chapter in Markdown.
pub fn markdown() -> String {
    let mut out = INTRODUCTION.to_owned();
    out.push_str(
        "\n## Materials known by name\n\n| name | E/GPa | ν | density/(g/cm³) | yield/MPa | softens/°C | expansion/(µm/(m·K)) | source of these \
         |\n|---|---|---|---|---|---|---|---|\n",
    );
    for material in Material::known_names().filter_map(Material::by_name) {
        let (e, density) = (plain(material.youngs_modulus / 1e9), plain(material.density / 1e3));
        let known =
            |value: Option<f64>, unit: f64| value.map_or("–".to_owned(), |value| plain(value / unit));
        out.push_str(&format!(
            "| {} | {e} | {} | {density} | {} | {} | {} | {} |\n",
            material.name,
            material.poisson_ratio,
            known(material.yield_strength, 1e6),
            known(material.softening_temperature, 1.0),
            known(material.thermal_expansion.map(|alpha| (alpha * 1e8).round() / 1e2), 1.0),
            material.source
        ));
    }
    section(&mut out, &MaterialTable::SCHEMA, "", "Materials inline");
    section(&mut out, &DesignSections::SCHEMA, "", "Top of the file");
    out.push_str(SINGLE_STAGE);
    let own = |out: &mut String, schema: &SectionSchema, names: &[&str], of: &str| {
        for key in schema.keys.iter().filter(|key| names.contains(&key.name)) {
            if let Kind::Section(inner) = (key.kind)() {
                section(out, inner, key.name, &format!("`[{}]` of {of}", key.name));
            }
        }
    };
    own(&mut out, &StageSections::SCHEMA, &OF_STAGES, "a single stage");
    out.push_str(TWO_RINGS);
    own(&mut out, &TwoRingSections::SCHEMA, &OF_TWO_RINGS, "a drive of two rings");
    out.push_str(TWO_STAGES);
    out
}

/// The keys of a section and of the sections within it.
pub fn section(out: &mut String, schema: &SectionSchema, path: &str, title: &str) {
    let (inner, own): (Vec<&Key>, Vec<&Key>) = schema
        .keys
        .iter()
        .partition(|key| matches!((key.kind)(), Kind::Section(_) | Kind::Sections(_) | Kind::Variations(_)));
    out.push_str(&format!("\n## {title}\n\n{}\n", paragraph(schema.doc)));
    if !own.is_empty() {
        out.push_str("\n| key | value | default | meaning |\n|---|---|---|---|\n");
    }
    for key in own {
        out.push_str(&format!("| `{}` | {} | {} | {} |\n", key.name, value(key), default(key), meaning(key)));
    }
    for key in inner {
        let path = join(path, key.name);
        match (key.kind)() {
            Kind::Section(schema) => section(out, schema, &path, &format!("`[{path}]`")),
            Kind::Sections(schema) => section(out, schema, &path, &format!("`[[{path}]]`, any number")),
            Kind::Variations(schema) => {
                section(out, schema, &path, &format!("`[{path}]`"));
                out.push_str(&format!("\n{}\n", paragraph(key.doc)));
            }
            _ => {}
        }
    }
}

fn value(key: &Key) -> String {
    let unit = if key.unit().is_empty() { String::new() } else { format!(" {}", key.unit()) };
    let range = match (key.rule.low.is_finite(), key.rule.high.is_finite()) {
        (true, true) => format!("{} … {}{unit}", plain(key.rule.low), plain(key.rule.high)),
        (true, false) => format!("from {}{unit}", plain(key.rule.low)),
        _ => format!("number{unit}"),
    };
    match (key.kind)() {
        Kind::Number => range,
        Kind::Count => format!("whole, {range}"),
        Kind::Flag => "true or false".to_owned(),
        Kind::Text => "text".to_owned(),
        Kind::File => "file name".to_owned(),
        Kind::Files => "file names".to_owned(),
        Kind::Choice(_) => "one of those listed".to_owned(),
        Kind::Material(_) => "material".to_owned(),
        Kind::Pairs => "pairs [°, µm]".to_owned(),
        Kind::Numbers => format!("list, {range}"),
        Kind::Texts => "list of texts".to_owned(),
        Kind::Section(_) | Kind::Sections(_) | Kind::Variations(_) => "section".to_owned(),
    }
}

fn default(key: &Key) -> String {
    match key.rule.presence {
        Presence::Required => "required".to_owned(),
        Presence::Optional | Presence::Positional => "may be left out".to_owned(),
        Presence::Number(number) => plain(number),
        Presence::Flag(flag) => flag.to_string(),
        Presence::Numbers(numbers) => {
            numbers.iter().map(|number| plain(*number)).collect::<Vec<_>>().join(", ")
        }
        Presence::Word("") => "none".to_owned(),
        Presence::Word(word) => format!("`\"{word}\"`"),
    }
}

fn meaning(key: &Key) -> String {
    let mut text = paragraph(key.doc);
    if let Kind::Choice(words) = (key.kind)() {
        let list: Vec<String> = words.iter().map(|(word, what)| format!("`\"{word}\"` {what}")).collect();
        text.push_str(&format!(" {}.", list.join("; ")));
    }
    text
}

/// Documentation comments on one line.
fn paragraph(doc: &str) -> String {
    doc.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|")
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_chapter_in_the_book_is_this_one() {
        let book = include_str!("../../../../docs/src/design-file.md");
        assert!(book == super::markdown(), "rewrite it with `arcmin keys > docs/src/design-file.md`");
    }

    #[test]
    fn every_key_is_explained() {
        let text = super::markdown();
        for row in text.lines().filter(|line| line.starts_with("| `")) {
            let meaning = row.trim_end_matches('|').rsplit(" | ").next().unwrap().trim();
            assert!(meaning.len() > 3 && meaning.ends_with('.'), "{row}");
        }
        assert!(text.lines().filter(|line| line.starts_with("| `")).count() > 90);
    }
}
