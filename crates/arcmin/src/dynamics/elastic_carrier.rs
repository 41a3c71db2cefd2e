use std::sync::Arc;

use super::DynamicsError;
use crate::fem::carrier::SEAT_COORDINATES;
use crate::fem::{Compliance, FemError};
use crate::geometry::Vec2;

/// The carrier as an elastic body of the model with bearings: the ways of its crank seats against the output
/// face and how they go out of round; the main bearings' seats free of force.
#[derive(Debug, Clone, PartialEq)]
pub struct ElasticCarrier {
    crank_count: usize,
    /// K = C⁻¹ of all coordinates of every seat, per crankshaft and end, in N/m, row by row.
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

    pub fn crank_count(&self) -> usize {
        self.crank_count
    }

    pub(super) fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// The same of a material `factor` times stiffer.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for a factor that is not positive.
    pub fn stiffened(&self, factor: f64) -> Result<ElasticCarrier, DynamicsError> {
        DynamicsError::require(factor > 0.0 && factor.is_finite(), "factor", factor, "", "must be positive")?;
        let stiffness = self.stiffness.iter().map(|k| k * factor).collect();
        Ok(ElasticCarrier { crank_count: self.crank_count, stiffness: Arc::new(stiffness) })
    }
}

/// The rims of the discs' bores as part of the model with bearings: they go out of round under their rollers,
/// with U = ½ wᵀ K w, and carry their bore's centre along by A w.
#[derive(Debug, Clone, PartialEq)]
pub struct ElasticRims {
    crank_count: usize,
    /// K = C⁻¹ of the rims of one disc in N/m, row by row.
    stiffness: Arc<Vec<f64>>,
    /// A = C_tr K: way of each bore per way of each rim coordinate, bore by bore, in the frame of the carrier.
    carried: Arc<Vec<Vec2>>,
}

impl ElasticRims {
    /// From [`RimShape::compliance`](crate::fem::RimShape::compliance).
    ///
    /// # Errors
    /// [`FemError::Factorisation`] if the compliance of the rims has no inverse.
    pub fn new(compliance: &Compliance, crank_count: usize) -> Result<ElasticRims, FemError> {
        let rims: Vec<usize> =
            (0..crank_count * SEAT_COORDINATES).filter(|k| k % SEAT_COORDINATES > 1).collect();
        let stiffness = compliance.stiffness(&rims)?;
        let n = rims.len();
        let way = |bore: usize, rim: usize| {
            let along = |axis: usize| -> f64 {
                let row = bore * SEAT_COORDINATES + axis;
                (0..n).map(|k| compliance.at(row, rims[k]) * stiffness[k * n + rim]).sum()
            };
            Vec2::new(along(0), along(1))
        };
        let carried = (0..crank_count).flat_map(|bore| (0..n).map(move |rim| (bore, rim)));
        Ok(ElasticRims {
            crank_count,
            carried: Arc::new(carried.map(|(bore, rim)| way(bore, rim)).collect()),
            stiffness: Arc::new(stiffness),
        })
    }

    pub fn crank_count(&self) -> usize {
        self.crank_count
    }

    pub(super) fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// Coordinates of one disc.
    pub(super) fn count(&self) -> usize {
        self.crank_count * (SEAT_COORDINATES - 2)
    }

    /// Ways of a bore per unit of each rim coordinate of its disc.
    pub(super) fn carried(&self, bore: usize) -> &[Vec2] {
        &self.carried[bore * self.count()..(bore + 1) * self.count()]
    }

    /// The same of a material `factor` times stiffer.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for a factor that is not positive.
    pub fn stiffened(&self, factor: f64) -> Result<ElasticRims, DynamicsError> {
        DynamicsError::require(factor > 0.0 && factor.is_finite(), "factor", factor, "", "must be positive")?;
        let stiffness = Arc::new(self.stiffness.iter().map(|k| k * factor).collect());
        Ok(ElasticRims { stiffness, ..self.clone() })
    }
}
