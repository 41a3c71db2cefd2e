//! Summaries: named values, nested by the dots of their keys.

use serde_json::{Map, Value as Json};

use super::{Column, Quantity, Value};

/// Declaration of a summary that is read from an outcome `O`.
#[derive(Debug, Clone, Copy)]
pub struct SummaryOf<O> {
    /// Figures with their reading from an outcome; dots in their keys nest.
    pub entries: fn() -> Vec<Column<O>>,
}

impl<O> SummaryOf<O> {
    /// The summary of an outcome.
    pub fn fill(&self, outcome: &O) -> Summary {
        let one = |entry: Column<O>| (entry.quantity, entry.value(outcome));
        Summary { entries: (self.entries)().into_iter().map(one).collect() }
    }

    /// The quantities of its entries.
    pub fn quantities(&self) -> Vec<Quantity> {
        (self.entries)().into_iter().map(|entry| entry.quantity).collect()
    }
}

/// The figures of an outcome, in the order of their declaration.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Summary {
    /// Figures with their values.
    pub entries: Vec<(Quantity, Value)>,
}

impl Summary {
    /// A value by its dotted key.
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.entries.iter().find(|(quantity, _)| quantity.key == key).map(|(_, value)| value)
    }

    /// A number by its dotted key.
    pub fn number(&self, key: &str) -> Option<f64> {
        match self.get(key)? {
            Value::Number(number) => Some(*number),
            Value::Count(count) => Some(*count as f64),
            _ => None,
        }
    }

    /// As JSON: a dot in a key is nesting.
    pub fn to_json(&self) -> Map<String, Json> {
        let mut root = Map::new();
        for (quantity, value) in &self.entries {
            let mut place = &mut root;
            let mut path = quantity.key.split('.').peekable();
            while let Some(name) = path.next() {
                if path.peek().is_none() {
                    place.insert(name.to_owned(), value.to_json());
                    break;
                }
                let inner = place.entry(name).or_insert_with(|| Json::Object(Map::new()));
                let Json::Object(inner) = inner else { break };
                place = inner;
            }
        }
        root
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{PLAIN, quantity};

    #[test]
    fn a_dot_is_nesting() {
        const TWO: SummaryOf<f64> = SummaryOf {
            entries: || {
                vec![
                    quantity("te.mean_arcmin", PLAIN, "a").of(|x: &f64| (*x).into()),
                    quantity("te.max_arcmin", PLAIN, "b").of(|_| Value::Number(f64::NAN)),
                    quantity("name", PLAIN, "c").of(|_| "x".into()),
                ]
            },
        };
        let json = Json::Object(TWO.fill(&0.5).to_json());
        assert_eq!(
            json,
            serde_json::json!({ "te": { "mean_arcmin": 0.5, "max_arcmin": null }, "name": "x" })
        );
    }
}
