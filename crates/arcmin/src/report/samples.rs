//! Many designs as data: every sample with its inputs and results.

use serde::{Serialize, Serializer};

use super::plot::Number;

/// Samples of a study: parallel coordinates with brushes, a scatter matrix, and the design behind every
/// point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Samples {
    /// Heading of the figure.
    pub title: String,
    /// Text below the figure.
    #[serde(skip)]
    pub note: String,
    /// Keys that vary, then results.
    pub columns: Vec<SampleColumn>,
    /// Number of each sample in the study.
    pub numbers: Vec<u64>,
    /// (place in `numbers`, reason) of samples without results.
    pub failed: Vec<(usize, String)>,
    /// The design that copying a sample writes.
    pub design: DesignTemplate,
}

/// One column: a key that varies, or a result.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SampleColumn {
    /// Path or key.
    pub name: String,
    /// Unit as a reader writes it; empty for none.
    pub unit: String,
    /// Whether it is a result.
    pub result: bool,
    /// Words that the values count from 0; empty for numbers.
    pub words: Vec<String>,
    /// Least value within limits of a result.
    pub low: Option<f64>,
    /// Largest value within limits of a result.
    pub high: Option<f64>,
    /// Scale of its axis is logarithmic.
    pub logarithmic: bool,
    /// Values of the samples in their order; `None` where a sample has none.
    #[serde(serialize_with = "numbers")]
    pub values: Vec<Option<f64>>,
}

/// A design file with places for the values of samples.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct DesignTemplate {
    /// Text between places; one more than there are places.
    pub text: Vec<String>,
    /// Column of the value at each place.
    pub columns: Vec<usize>,
    /// Column of the seed of drawn machines.
    pub seed: Option<usize>,
}

impl DesignTemplate {
    /// Finds the places of values in a text, from two texts for each column that differ only in its value. `base` is
    /// the text with one value of every column; `other` gives the text with another value of a column, `None` if the
    /// text does not contain the column.
    pub fn find(base: &str, count: usize, other: impl Fn(usize) -> Option<String>) -> DesignTemplate {
        let mut places: Vec<(usize, usize, usize)> = (0..count)
            .filter_map(|column| {
                let (start, end) = difference(base, &other(column)?)?;
                Some((start, end, column))
            })
            .collect();
        places.sort_unstable();
        // Two columns cannot have the same place.
        places.dedup_by(|next, place| next.0 < place.1);
        let mut template = DesignTemplate::default();
        let mut from = 0;
        for (start, end, column) in places {
            template.text.push(base[from..start].to_owned());
            template.columns.push(column);
            from = end;
        }
        template.text.push(base[from..].to_owned());
        template
    }
}

/// The value in `base` around the difference: bytes up to spaces, commas and brackets.
fn difference(base: &str, other: &str) -> Option<(usize, usize)> {
    let same_before = base.bytes().zip(other.bytes()).take_while(|(a, b)| a == b).count();
    if same_before == base.len() && same_before == other.len() {
        return None;
    }
    let most = base.len().min(other.len()) - same_before;
    let same_behind =
        base.bytes().rev().zip(other.bytes().rev()).take(most).take_while(|(a, b)| a == b).count();
    let delimits = |byte: &u8| byte.is_ascii_whitespace() || b",=[]{}#".contains(byte);
    let bytes = base.as_bytes();
    let start = bytes[..same_before].iter().rposition(delimits).map_or(0, |at| at + 1);
    let behind = base.len() - same_behind;
    let end = bytes[behind..].iter().position(delimits).map_or(base.len(), |at| behind + at);
    (start < end && base.is_char_boundary(start) && base.is_char_boundary(end)).then_some((start, end))
}

fn numbers<S: Serializer>(values: &[Option<f64>], serializer: S) -> Result<S::Ok, S::Error> {
    // Seeds are whole numbers of up to sixteen digits and must not be rounded.
    serializer.collect_seq(values.iter().map(|value| value.map(Exact)))
}

struct Exact(f64);

impl Serialize for Exact {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.fract() == 0.0 && self.0.abs() < 9.1e15 {
            serializer.serialize_i64(self.0 as i64)
        } else {
            Number(self.0).serialize(serializer)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_of_values_are_found() {
        let text = |a: &str, b: &str| format!("# a = 1\n[x]\na_mm = {a} # wide\nlist = [{b}, 2]\n");
        let base = text("8.75", "1.5");
        let template = DesignTemplate::find(&base, 3, |column| match column {
            0 => Some(text("8.5", "1.5")),
            1 => Some(text("8.75", "7")),
            _ => None,
        });
        assert_eq!(template.text, ["# a = 1\n[x]\na_mm = ", " # wide\nlist = [", ", 2]\n"]);
        assert_eq!(template.columns, [0, 1]);
        assert!(DesignTemplate::find("a = 1", 1, |_| Some("a = 1".into())).columns.is_empty());
    }

    #[test]
    fn seeds_keep_all_their_digits() {
        let column = SampleColumn {
            name: "seed".into(),
            unit: String::new(),
            result: false,
            words: vec![],
            low: None,
            high: None,
            logarithmic: false,
            values: vec![Some(9_007_199_254_740_991.0), Some(0.123_456_789), None, Some(f64::INFINITY)],
        };
        let json = serde_json::to_value(&column).unwrap();
        assert_eq!(json["values"], serde_json::json!([9_007_199_254_740_991_i64, 0.1234568, null, null]));
    }
}
