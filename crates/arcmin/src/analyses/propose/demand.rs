//! Requirements of a single stage, and the reasons why none meets them.

use super::process::Process;
use crate::templates::OutOfRange;

/// Lobes of a disc.
const LOBES: (f64, f64) = (5.0, 119.0);

/// Requirements of a single stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// Turns of the input for one of the output.
    pub ratio: f64,
    /// Tooth difference, 1 or 2: pins of the ring less lobes of a disc.
    pub tooth_difference: usize,
    /// Rated torque in N·m.
    pub torque: f64,
    /// Outer diameter of the ring.
    pub outer_diameter_mm: f64,
    /// Way of making the discs, which sets gaps and materials.
    pub process: Process,
    /// Speed of the input.
    pub speed_rpm: f64,
}

/// Reason why no single stage within the rules meets the requirements.
#[derive(Debug, Clone, PartialEq)]
pub struct Shortfall {
    /// The failing check, in a sentence with numbers.
    pub message: String,
    /// Value over its limit, or needed over available size.
    pub excess: f64,
    /// Whether it is the bending of the output pins.
    pub(super) is_bending: bool,
}

impl Shortfall {
    pub(super) fn new(message: String, excess: f64) -> Shortfall {
        Shortfall { message, excess, is_bending: false }
    }

    /// For a demand without any combination.
    pub(super) fn none() -> Shortfall {
        Shortfall::new("no combination of standard parts fits".to_owned(), f64::INFINITY)
    }
}

/// A requirement that is invalid or out of range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DemandError {
    /// A requirement is outside of the range of the rules.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// A ratio that is not a number of lobes.
    #[error(
        "a ratio of {ratio} {}: a single stage with its ring at rest has {} its ratio",
        if *.tooth_difference == 1 { "is not whole".to_owned() } else { format!("is no multiple of 1/{tooth_difference}") },
        if *.tooth_difference == 1 { "as many lobes as".to_owned() } else { format!("{tooth_difference} times as many lobes as") }
    )]
    Fraction {
        /// Ratio asked for.
        ratio: f64,
        /// Tooth difference.
        tooth_difference: usize,
    },
}

impl Demand {
    /// # Errors
    /// [`DemandError`] for values out of range.
    pub fn check(&self) -> Result<(), DemandError> {
        let within = OutOfRange::check;
        let difference = self.tooth_difference as f64;
        within("a tooth difference", difference, 1.0, 2.0)?;
        within("a ratio", self.ratio, LOBES.0 / difference, LOBES.1 / difference)?;
        within("a torque in N·m", self.torque, 1e-3, 1e5)?;
        within("an outer diameter in mm", self.outer_diameter_mm, 20.0, 400.0)?;
        within("an input speed in rpm", self.speed_rpm, 0.1, 30_000.0)?;
        if (difference * self.ratio).fract() == 0.0 {
            return Ok(());
        }
        Err(DemandError::Fraction { ratio: self.ratio, tooth_difference: self.tooth_difference })
    }
}

/// The shortfall of the best combination: by the rule that it reached, then by the size of its shortfall.
#[derive(Default)]
pub(super) struct Nearest(pub Option<(usize, Shortfall)>);

impl Nearest {
    pub fn note(&mut self, stage: usize, shortfall: Shortfall) {
        let nearer = self.0.as_ref().is_none_or(|(reached, held)| {
            stage > *reached || (stage == *reached && shortfall.excess < held.excess)
        });
        if nearer {
            self.0 = Some((stage, shortfall));
        }
    }
}
