//! The JSON Schema of a design file, for completion, explanations and checks in editors.

use serde_json::{Map, Value, json};

use super::DesignSections;
use super::schema::{Key, Kind, Presence, SectionSchema};
use crate::materials::Material;

/// JSON Schema (draft 2020-12) of a design file, from the same declaration as the reader. It contains keys,
/// kinds, ranges, words and defaults; contradictions between values are found by the program only.
///
/// For Even Better TOML and taplo: write `arcmin keys --json-schema > arcmin.schema.json` and put
/// `#:schema ./arcmin.schema.json` into the first line of the design.
pub fn json_schema() -> String {
    let mut schema = table(&DesignSections::SCHEMA);
    schema.insert("$schema".to_owned(), json!("https://json-schema.org/draft/2020-12/schema"));
    schema.insert("title".to_owned(), json!("arcmin design"));
    let mut text = serde_json::to_string_pretty(&schema).unwrap_or_default();
    text.push('\n');
    text
}

fn paragraph(doc: &str) -> String {
    doc.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn table(schema: &SectionSchema) -> Map<String, Value> {
    let properties: Map<String, Value> =
        schema.keys.iter().map(|key| (key.name.to_owned(), property(key))).collect();
    let required: Vec<&str> = schema
        .keys
        .iter()
        .filter(|key| key.rule.presence == Presence::Required)
        .map(|key| key.name)
        .collect();
    let mut out = Map::new();
    out.insert("type".to_owned(), json!("object"));
    out.insert("description".to_owned(), json!(paragraph(schema.doc)));
    out.insert("properties".to_owned(), Value::Object(properties));
    if !required.is_empty() {
        out.insert("required".to_owned(), json!(required));
    }
    out.insert("additionalProperties".to_owned(), json!(false));
    out
}

fn number(key: &Key, kind: &str) -> Map<String, Value> {
    let mut out = Map::new();
    out.insert("type".to_owned(), json!(kind));
    for (name, bound) in [("minimum", key.rule.low), ("maximum", key.rule.high)] {
        if bound.is_finite() {
            out.insert(name.to_owned(), json!(bound));
        }
    }
    out
}

fn property(key: &Key) -> Value {
    let mut out = match (key.kind)() {
        Kind::Number => number(key, "number"),
        Kind::Count => number(key, "integer"),
        Kind::Flag => object(json!({ "type": "boolean" })),
        Kind::Text if key.rule.presence == Presence::Required => {
            object(json!({ "type": "string", "pattern": "\\S" }))
        }
        Kind::Text => object(json!({ "type": "string" })),
        Kind::Choice(words) => object(json!({
            "enum": words.iter().map(|word| word.0).collect::<Vec<_>>(),
            "x-taplo": { "docs": { "enumValues": words.iter().map(|word| word.1).collect::<Vec<_>>() } },
        })),
        Kind::Material(schema) => object(json!({ "anyOf": [
            { "enum": Material::known_names().collect::<Vec<_>>() },
            { "type": "string", "pattern": any_case(Material::known_names()) },
            table(schema),
        ] })),
        Kind::Pairs => object(json!({
            "type": "array",
            "items": {
                "type": "array",
                "prefixItems": [{ "type": "number" }, number(key, "number")],
                "items": false,
                "minItems": 2,
            },
        })),
        Kind::Numbers => object(json!({ "type": "array", "items": number(key, "number") })),
        Kind::File => object(json!({ "type": "string" })),
        Kind::Files | Kind::Texts => object(json!({ "type": "array", "items": { "type": "string" } })),
        Kind::Section(schema) => table(schema),
        Kind::Sections(schema) => object(json!({ "type": "array", "items": table(schema) })),
        Kind::Variations(schema) => object(json!({
            "type": "object",
            "additionalProperties": { "anyOf": [table(schema), { "type": "array", "minItems": 1 }] },
        })),
    };
    out.insert("description".to_owned(), json!(description(key)));
    let default = match key.rule.presence {
        Presence::Number(number) if matches!((key.kind)(), Kind::Count) => Some(json!(number as usize)),
        Presence::Number(number) => Some(json!(number)),
        Presence::Word(word) => Some(json!(word)),
        Presence::Flag(flag) => Some(json!(flag)),
        Presence::Numbers(numbers) => Some(json!(numbers)),
        Presence::Required | Presence::Optional | Presence::Positional => None,
    };
    if let Some(default) = default {
        out.insert("default".to_owned(), default);
    }
    Value::Object(out)
}

fn description(key: &Key) -> String {
    match key.unit() {
        "" => paragraph(key.doc),
        unit => format!("{} [{unit}]", paragraph(key.doc)),
    }
}

fn object(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

/// A pattern for any of the names in any case, as the reader accepts them.
fn any_case<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let letter = |c: char| match c.is_ascii_alphabetic() {
        true => format!("[{}{}]", c.to_ascii_uppercase(), c.to_ascii_lowercase()),
        false => c.to_string(),
    };
    let names: Vec<String> = names.map(|name| name.chars().map(letter).collect()).collect();
    format!("^({})$", names.join("|"))
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    /// Every key of the reader is in the schema under the same path, with its kind and range.
    #[test]
    fn the_schema_has_every_key_of_a_design() {
        let schema: Value = serde_json::from_str(&super::json_schema()).unwrap();
        for template in crate::templates::TEMPLATES {
            for key in crate::templates::design(template.name).unwrap().keys() {
                let mut at = &schema;
                for step in key.path.split('.') {
                    let (name, row) = step.split_once('[').map_or((step, false), |(name, _)| (name, true));
                    at = &at["properties"][name];
                    if row {
                        at = &at["items"];
                    }
                }
                assert!(at["description"].as_str().unwrap().len() > 3, "{}", key.path);
                if let Some([low, high]) = key.range.filter(|_| at["type"] != "array") {
                    // serde_json reads numbers to one unit in the last place.
                    let same = |name: &str, bound: f64| {
                        (at[name].as_f64().unwrap() - bound).abs() <= 1e-14 * bound.abs()
                    };
                    assert!(same("minimum", low) && same("maximum", high), "{}", key.path);
                }
            }
        }
        assert_eq!(schema["properties"]["ring"]["additionalProperties"], false);
        assert_eq!(schema["properties"]["ring"]["properties"]["pin_mounting"]["default"], "fixed");
    }
}
