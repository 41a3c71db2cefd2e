//! Values of keys in programs.

use std::fmt;
use std::sync::Arc;

use super::schema::Kind;
use super::tree::{Branch, Entry, Item, Node};
use crate::materials::Material;
use crate::units::MPA;

/// The value of a key, in the unit of the key.
///
/// It is made from numbers, texts and lists: `design.with("crankshafts.eccentricity_mm", 1.4)`,
/// `design.with("fixed_member", "carrier")`.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// The key is missing and has no default. Setting this removes the key from the file, so that its default
    /// applies again.
    LeftOut,
    /// Real number, in the unit of the key.
    Number(f64),
    /// Whole number, zero or more, such as a number of teeth.
    Count(usize),
    /// A text, a word from a choice or the name of a material.
    Text(String),
    /// `true` or `false`.
    Flag(bool),
    /// Rows of two numbers, each in the unit that the key names for its column.
    Pairs(Vec<[f64; 2]>),
    /// List of numbers, in the unit of the key.
    Numbers(Vec<f64>),
    /// List of words or names of files.
    Texts(Vec<String>),
    /// A material with its own properties.
    Material(Material),
}

impl Value {
    /// The number of a [`Value::Number`] or [`Value::Count`].
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Value::Number(number) => Some(*number),
            Value::Count(count) => Some(*count as f64),
            _ => None,
        }
    }

    /// The text of a [`Value::Text`].
    pub fn as_text(&self) -> Option<&str> {
        match self {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// `None` for [`Value::LeftOut`].
    pub(super) fn node(&self) -> Option<Node> {
        let number = |number: &f64| Item::made(Node::Number(*number));
        let list = |items: Vec<Item>| Node::List(Arc::new(items));
        Some(match self {
            Value::LeftOut => return None,
            Value::Number(number) => Node::Number(*number),
            Value::Count(count) => Node::Number(*count as f64),
            Value::Text(text) => Node::Text(text.as_str().into()),
            Value::Flag(flag) => Node::Flag(*flag),
            Value::Pairs(pairs) => {
                list(pairs.iter().map(|pair| Item::made(list(pair.iter().map(number).collect()))).collect())
            }
            Value::Numbers(numbers) => list(numbers.iter().map(number).collect()),
            Value::Texts(texts) => {
                list(texts.iter().map(|text| Item::made(Node::Text(text.as_str().into()))).collect())
            }
            Value::Material(material) => Node::Table(Arc::new(material_branch(material))),
        })
    }

    /// The value of a key of this kind in a valid tree.
    pub(super) fn of(node: &Node, kind: Kind) -> Value {
        let numbers = |rows: &[Item]| rows.iter().filter_map(|row| plain_number(&row.node)).collect();
        match (node, kind) {
            (Node::Number(number), Kind::Count) => Value::Count(*number as usize),
            (Node::Number(number), _) => Value::Number(*number),
            (Node::Text(text), _) => Value::Text(text.to_string()),
            (Node::Flag(flag), _) => Value::Flag(*flag),
            (Node::List(rows), Kind::Pairs) => Value::Pairs(rows.iter().filter_map(pair).collect()),
            (Node::List(rows), Kind::Texts | Kind::Files) => {
                let text = |row: &Item| match &row.node {
                    Node::Text(text) => Some(text.to_string()),
                    _ => None,
                };
                Value::Texts(rows.iter().filter_map(text).collect())
            }
            (Node::List(rows), _) => Value::Numbers(numbers(rows)),
            (Node::Table(branch), _) => material(branch).map_or(Value::LeftOut, Value::Material),
            (Node::Date, _) => Value::LeftOut,
        }
    }
}

fn plain_number(node: &Node) -> Option<f64> {
    match node {
        Node::Number(number) => Some(*number),
        _ => None,
    }
}

fn pair(row: &Item) -> Option<[f64; 2]> {
    match &row.node {
        Node::List(pair) => match &pair[..] {
            [first, second] => Some([plain_number(&first.node)?, plain_number(&second.node)?]),
            _ => None,
        },
        _ => None,
    }
}

/// The inline table of a material, in the units of its keys.
pub(super) fn material_branch(material: &Material) -> Branch {
    // Twelve digits remove the rounding error of the conversion to SI units and back.
    let trade = |si: f64, unit: f64| format!("{:.11e}", si / unit).parse().unwrap_or(si / unit);
    let entry = |key: &str, node: Node| Entry { key: key.into(), key_span: 0..0, item: Item::made(node) };
    let mut entries = vec![
        entry("name", Node::Text(material.name.as_str().into())),
        entry("youngs_modulus_gpa", Node::Number(trade(material.youngs_modulus, 1e9))),
        entry("poisson_ratio", Node::Number(material.poisson_ratio)),
        entry("density_g_cm3", Node::Number(trade(material.density, 1e3))),
    ];
    let limits = [
        ("yield_strength_mpa", material.yield_strength, MPA),
        ("softening_temperature_c", material.softening_temperature, 1.0),
        ("thermal_expansion_um_per_m_k", material.thermal_expansion, 1e-6),
    ];
    let known = limits.into_iter().filter_map(|(key, si, unit)| Some((key, si?, unit)));
    entries.extend(known.map(|(key, si, unit)| entry(key, Node::Number(trade(si, unit)))));
    if !material.source.is_empty() {
        entries.push(entry("source", Node::Text(material.source.as_str().into())));
    }
    Branch { entries }
}

fn material(branch: &Branch) -> Option<Material> {
    let number = |key: &str| branch.get(key).and_then(|item| plain_number(&item.node));
    let text = |key: &str, otherwise: &str| match branch.get(key).map(|item| &item.node) {
        Some(Node::Text(text)) => text.to_string(),
        _ => otherwise.to_owned(),
    };
    Some(Material {
        yield_strength: number("yield_strength_mpa").map(|mpa| mpa * MPA),
        softening_temperature: number("softening_temperature_c"),
        thermal_expansion: number("thermal_expansion_um_per_m_k").map(|um| um * 1e-6),
        source: text("source", ""),
        ..Material::elastic(
            &text("name", "own material"),
            number("youngs_modulus_gpa")? * 1e9,
            number("poisson_ratio")?,
            number("density_g_cm3")? * 1e3,
        )
    })
}

/// As written in TOML; empty for [`Value::LeftOut`].
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.node().map_or(Ok(()), |node| write_node(f, &node))
    }
}

fn write_node(f: &mut fmt::Formatter<'_>, node: &Node) -> fmt::Result {
    match node {
        Node::Number(number) => match number.abs() {
            size if size != 0.0 && size.is_finite() && !(1e-4..1e7).contains(&size) => {
                write!(f, "{number:e}")
            }
            _ if number.is_nan() => f.write_str("nan"),
            _ => write!(f, "{number}"),
        },
        Node::Text(text) => write!(f, "{}", toml_edit::Value::from(text.as_ref())),
        Node::Flag(flag) => write!(f, "{flag}"),
        Node::Date => Ok(()),
        Node::List(rows) => {
            f.write_str("[")?;
            for (index, row) in rows.iter().enumerate() {
                f.write_str(if index == 0 { "" } else { ", " })?;
                write_node(f, &row.node)?;
            }
            f.write_str("]")
        }
        Node::Table(branch) => {
            f.write_str("{ ")?;
            for (index, entry) in branch.entries.iter().enumerate() {
                write!(f, "{}{} = ", if index == 0 { "" } else { ", " }, entry.key)?;
                write_node(f, &entry.item.node)?;
            }
            f.write_str(" }")
        }
    }
}

macro_rules! from {
    ($($Type:ty => $make:expr,)*) => {$(
        impl From<$Type> for Value {
            fn from(value: $Type) -> Value {
                $make(value)
            }
        }
    )*};
}

from! {
    f64 => Value::Number,
    i32 => |whole| Value::Number(f64::from(whole)),
    usize => Value::Count,
    bool => Value::Flag,
    &str => |text: &str| Value::Text(text.to_owned()),
    String => Value::Text,
    Material => Value::Material,
    Vec<[f64; 2]> => Value::Pairs,
    Vec<f64> => Value::Numbers,
    Vec<String> => Value::Texts,
}
