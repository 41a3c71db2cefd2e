//! A file as a tree of values with their places in the text, read from a text or set by a program. Branches are
//! shared, so that a changed copy costs only the nodes on the path to the change.

use std::ops::Range;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value and its bytes in the text; an empty range at 0 for a value set by a program.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    pub node: Node,
    pub span: Range<usize>,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Node {
    Number(f64),
    Text(Arc<str>),
    Flag(bool),
    /// A date or time, which no key accepts.
    Date,
    List(Arc<Vec<Item>>),
    Table(Arc<Branch>),
}

/// The keys of a table in the order of the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Branch {
    pub entries: Vec<Entry>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    pub key: Arc<str>,
    pub key_span: Range<usize>,
    pub item: Item,
}

impl Item {
    /// A value without a place in a text.
    pub fn made(node: Node) -> Item {
        Item { node, span: 0..0 }
    }

    fn from_toml(value: &Spanned<DeValue<'_>>) -> Item {
        let node = match value.get_ref() {
            DeValue::String(text) => Node::Text(text.as_ref().into()),
            DeValue::Integer(whole) => Node::Number(integer(whole.as_str(), whole.radix())),
            DeValue::Float(float) => Node::Number(number(float.as_str()).unwrap_or(f64::NAN)),
            DeValue::Boolean(flag) => Node::Flag(*flag),
            DeValue::Datetime(_) => Node::Date,
            DeValue::Array(rows) => Node::List(Arc::new(rows.iter().map(Item::from_toml).collect())),
            DeValue::Table(table) => Node::Table(Arc::new(Branch::from_toml(table))),
        };
        Item { node, span: value.span() }
    }

    /// Kind of the node, for messages.
    pub fn kind_name(&self) -> &'static str {
        match self.node {
            Node::Text(_) => "a text",
            Node::Number(_) => "a number",
            Node::Flag(_) => "true or false",
            Node::Date => "a date",
            Node::List(_) => "a list",
            Node::Table(_) => "a table",
        }
    }
}

impl Branch {
    pub fn from_toml(table: &DeTable<'_>) -> Branch {
        let mut entries: Vec<Entry> = table
            .iter()
            .map(|(key, value)| Entry {
                key: key.get_ref().as_ref().into(),
                key_span: key.span(),
                item: Item::from_toml(value),
            })
            .collect();
        // The parser sorts the keys by name.
        entries.sort_by_key(|entry| entry.key_span.start);
        Branch { entries }
    }

    pub fn get(&self, key: &str) -> Option<&Item> {
        self.entries.iter().find(|entry| &*entry.key == key).map(|entry| &entry.item)
    }

    /// The value of a dotted key.
    pub fn at(&self, path: &[&str]) -> Option<&Item> {
        let (first, rest) = path.split_first()?;
        let item = self.get(first)?;
        match &item.node {
            _ if rest.is_empty() => Some(item),
            Node::Table(inner) => inner.at(rest),
            _ => None,
        }
    }

    /// Path of the innermost value or key that covers the bytes, dotted and with indices.
    pub fn path_at(&self, span: &Range<usize>) -> Option<String> {
        let covers = |outer: &Range<usize>| outer.start <= span.start && span.end <= outer.end;
        for entry in &self.entries {
            let inner = match &entry.item.node {
                Node::Table(branch) => branch.path_at(span).map(|path| format!(".{path}")),
                Node::List(rows) => rows.iter().enumerate().find_map(|(index, row)| match &row.node {
                    Node::Table(branch) => match branch.path_at(span) {
                        Some(path) => Some(format!("[{index}].{path}")),
                        None => covers(&row.span).then(|| format!("[{index}]")),
                    },
                    _ => None,
                }),
                _ => None,
            };
            if let Some(inner) = inner {
                return Some(format!("{}{inner}", quoted_key(&entry.key)));
            }
            if covers(&entry.key_span) || covers(&entry.item.span) {
                return Some(quoted_key(&entry.key));
            }
        }
        None
    }
}

/// A key as written in a path: in quotes if it contains dots.
pub fn quoted_key(key: &str) -> String {
    if key.contains(['.', '[', '"']) { format!("{key:?}") } else { key.to_owned() }
}

/// A number in TOML; its parser returns it as text.
pub fn number(text: &str) -> Option<f64> {
    text.replace('_', "").parse().ok()
}

/// A whole number in any base; numbers too large for the type are rejected.
fn integer(text: &str, radix: u32) -> f64 {
    match radix {
        10 => number(text).unwrap_or(f64::NAN),
        _ => i64::from_str_radix(&text.replace('_', ""), radix).map_or(f64::NAN, |whole| whole as f64),
    }
}
