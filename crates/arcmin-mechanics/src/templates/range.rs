//! Ranges of the rules by which designs are made.

/// A value outside the range of the rules by which a design is made.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{what} of {value} is out of range; the range is {low} to {high}")]
pub struct OutOfRange {
    /// Quantity with its unit as named in the message.
    pub what: &'static str,
    /// Value given.
    pub value: f64,
    /// Least value accepted.
    pub low: f64,
    /// Largest value accepted.
    pub high: f64,
}

impl OutOfRange {
    /// Checks a value; NaN is out of every range.
    ///
    /// # Errors
    /// [`OutOfRange`] below `low` and above `high`.
    pub fn check(what: &'static str, value: f64, low: f64, high: f64) -> Result<(), OutOfRange> {
        if (low..=high).contains(&value) { Ok(()) } else { Err(OutOfRange { what, value, low, high }) }
    }
}
