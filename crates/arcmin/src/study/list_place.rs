use crate::analyses::stage::AnyDesign;
use crate::design::Value;

/// An entry of a list of numbers in a design, written `path[index]`; of pairs the second number (the depth at
/// an angle).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ListPlace {
    /// Path of the list.
    pub list: String,
    pub index: usize,
    /// Value in the design.
    pub number: f64,
}

impl ListPlace {
    /// `None` where the path leads to no entry of a list of numbers.
    pub fn find(design: &AnyDesign, path: &str) -> Option<ListPlace> {
        let (list, index) = path.strip_suffix(']')?.rsplit_once('[')?;
        let index: usize = index.parse().ok()?;
        let number = match design.get(list).ok()? {
            Value::Pairs(pairs) => pairs.get(index)?[1],
            Value::Numbers(numbers) => *numbers.get(index)?,
            _ => return None,
        };
        Some(ListPlace { list: list.to_owned(), index, number })
    }

    /// The list with another number in this place.
    pub fn set(&self, list: &mut Value, number: f64) {
        match list {
            Value::Pairs(pairs) => {
                if let Some(pair) = pairs.get_mut(self.index) {
                    pair[1] = number;
                }
            }
            Value::Numbers(numbers) => {
                if let Some(place) = numbers.get_mut(self.index) {
                    *place = number;
                }
            }
            _ => {}
        }
    }
}
