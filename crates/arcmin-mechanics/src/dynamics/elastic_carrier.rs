use std::sync::Arc;

use super::DynamicsError;
use crate::fem::carrier::SEAT_COORDINATES;
use crate::fem::{Compliance, FemError};

/// The carrier as an elastic body of the model with bearings: displacements of its crank seats relative to the
/// output face, and their ovalisation; the main bearings' seats are free of force.
#[derive(Debug, Clone, PartialEq)]
pub struct ElasticCarrier {
    crank_count: usize,
    /// K = C⁻¹ of all coordinates of every seat, for each crankshaft and end, in N/m, row by row.
    stiffness: Arc<Vec<f64>>,
}

impl ElasticCarrier {
    /// From the compliance between the carrier's interface coordinates.
    ///
    /// # Errors
    /// [`FemError::Factorisation`] if the compliance of the seats has no inverse.
    pub fn new(compliance: &Compliance, crank_count: usize) -> Result<ElasticCarrier, FemError> {
        let seats: Vec<usize> = (0..2 * crank_count * SEAT_COORDINATES).collect();
        Ok(ElasticCarrier { crank_count, stiffness: Arc::new(compliance.stiffness(&seats)?) })
    }

    pub(crate) fn crank_count(&self) -> usize {
        self.crank_count
    }

    pub(super) fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// The same for a material `factor` times stiffer.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for a factor that is not positive.
    pub fn stiffened(&self, factor: f64) -> Result<ElasticCarrier, DynamicsError> {
        DynamicsError::require(factor > 0.0 && factor.is_finite(), "factor", factor, "", "must be positive")?;
        let stiffness = self.stiffness.iter().map(|k| k * factor).collect();
        Ok(ElasticCarrier { crank_count: self.crank_count, stiffness: Arc::new(stiffness) })
    }
}
