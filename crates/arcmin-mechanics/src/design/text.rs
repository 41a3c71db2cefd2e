//! Text of a changed design, with comments and layout kept.

use toml_edit::{ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value as TomlValue};

use super::edit::Change;
use super::path::Step;
use super::value::Value;
use crate::materials::Material;

/// The text with all changes. The original `text` was read before, so it is valid TOML.
pub(super) fn edited(text: &str, changes: &[Change]) -> String {
    let Ok(mut document) = text.parse::<DocumentMut>() else { return text.to_owned() };
    for change in changes {
        set(document.as_table_mut(), &change.steps, change);
    }
    document.to_string()
}

/// The value as written in TOML.
fn written(change: &Change) -> Option<TomlValue> {
    let value = match change.value {
        Value::Number(number) if change.whole && number.fract() == 0.0 && number.abs() < 1e15 => {
            Value::Count(number as usize)
        }
        ref value => value.clone(),
    };
    value.to_string().parse().ok()
}

fn set(table: &mut dyn TableLike, steps: &[Step], change: &Change) {
    let [Step::Key(name), rest @ ..] = steps else { return };
    if change.value == Value::LeftOut && !table.contains_key(name) {
        return;
    }
    if rest.is_empty() {
        match written(change) {
            None => {
                table.remove(name);
            }
            Some(value) => replace(table, name, value),
        }
        return;
    }
    let inside_of_values = false;
    let item = table.entry(name).or_insert_with(|| match rest.first() {
        Some(Step::Row(_)) => Item::ArrayOfTables(ArrayOfTables::new()),
        _ if inside_of_values => Item::Value(TomlValue::InlineTable(InlineTable::new())),
        _ => Item::Table(Table::new()),
    });
    if let Some(material) = item.as_str().and_then(Material::by_name)
        && let Ok(parts) = Value::Material(material).to_string().parse::<TomlValue>()
    {
        let decor = item.as_value().map(|value| value.decor().clone());
        let mut parts = parts;
        if let Some(decor) = decor {
            *parts.decor_mut() = decor;
        }
        *item = Item::Value(parts);
    }
    if let [Step::Row(row), rest @ ..] = rest {
        set_row(item, *row, rest, change);
    } else if let Some(inner) = item.as_table_like_mut() {
        set(inner, rest, change);
    }
}

fn set_row(item: &mut Item, row: usize, rest: &[Step], change: &Change) {
    match item {
        Item::ArrayOfTables(rows) => {
            if rest.is_empty() {
                rows.remove(row);
                return;
            }
            if row == rows.len() {
                rows.push(Table::new());
            }
            if let Some(table) = rows.get_mut(row) {
                set(table, rest, change);
            }
        }
        Item::Value(TomlValue::Array(rows)) => {
            if rest.is_empty() {
                rows.remove(row);
                return;
            }
            if row == rows.len() {
                rows.push(InlineTable::new());
            }
            if let Some(table) = rows.get_mut(row).and_then(TomlValue::as_inline_table_mut) {
                set(table, rest, change);
            }
        }
        _ => {}
    }
}

/// Replaces the old value. A comment behind it keeps its column if there is room.
fn replace(table: &mut dyn TableLike, name: &str, mut value: TomlValue) {
    let Some(old) = table.get_mut(name).and_then(Item::as_value_mut) else {
        value.decor_mut().clear();
        table.insert(name, Item::Value(value));
        return;
    };
    let length = |value: &TomlValue| {
        let mut bare = value.clone();
        bare.decor_mut().clear();
        bare.to_string().trim().chars().count()
    };
    let (before, after) = (length(old), length(&value));
    let decor = old.decor();
    let text = |raw: Option<&toml_edit::RawString>| {
        raw.and_then(toml_edit::RawString::as_str).unwrap_or_default().to_owned()
    };
    let (prefix, suffix) = (text(decor.prefix()), text(decor.suffix()));
    let comment = suffix.trim_start_matches(' ');
    let suffix = if comment.starts_with('#') {
        let room = suffix.len() - comment.len();
        format!("{}{comment}", " ".repeat((room + before).saturating_sub(after).max(1)))
    } else {
        suffix
    };
    *value.decor_mut() = toml_edit::Decor::new(prefix, suffix);
    *old = value;
}
