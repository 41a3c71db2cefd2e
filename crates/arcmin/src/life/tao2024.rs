//! The wear study of Tao2024: uniform depths with the hours of its wear model.

use super::{Accuracy, Travel, accuracy, travel};
use crate::geometry::Relief;
use crate::machine::Machine;
use crate::units::UM;
use crate::wear::paper::PaperWear;
use crate::wear::{WearCase, WearError};

/// The paper's study.
#[derive(Debug, Clone)]
pub struct PaperStudy {
    /// Depth in m with accuracy and play; the hours are NaN if the wear rule gives none.
    pub points: Vec<(f64, Accuracy, Travel)>,
    /// The wear rule; an error if its closed form does not converge.
    pub wear: Result<PaperWear, WearError>,
}

/// Uniform depths in m, as in Tao2024: 0, 10, …, 60 µm.
pub fn paper_depths() -> [f64; 7] {
    std::array::from_fn(|level| 10.0 * UM * level as f64)
}

/// The paper's study at the given uniform depths (m), with ideal joints.
///
/// # Errors
/// [`WearError`] when load sharing fails. If the closed form does not converge, only the hours are missing.
pub fn paper_study(
    machine: &Machine,
    depths: &[f64],
    crank_positions: usize,
) -> Result<PaperStudy, WearError> {
    let deepest = depths.iter().copied().fold(0.0, f64::max);
    let (wear, case) = (PaperWear::new(machine, deepest), WearCase::from(machine));
    let mut points = Vec::with_capacity(depths.len());
    for depth in depths {
        let flank = Relief::uniform(*depth);
        let hours = wear.as_ref().map_or(f64::NAN, |wear| wear.hours_at(*depth));
        let mut meshing = machine.meshing(&flank);
        let accuracy = accuracy(&case, &mut meshing, &flank, hours, crank_positions)?;
        points.push((*depth, accuracy, travel(&case, &mut meshing, crank_positions)?));
    }
    Ok(PaperStudy { points, wear })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The study reproduces the play of the uniformly worn disc and the paper's hours.
    #[test]
    fn val_study_at_ten_and_sixty_micrometres() {
        let machine = crate::templates::tao2024();
        let study = paper_study(&machine, &paper_depths(), 72).unwrap();
        assert!((study.points[1].2.play.arcmin() - 0.6536).abs() < 1e-4);
        assert!((study.points[6].2.play.arcmin() - 3.9218).abs() < 1e-4);
        assert!((study.points[6].1.hours - 7500.0).abs() < 1e-6);
        assert!((study.points[5].1.hours / 6442.0 - 1.0).abs() < 0.01);
    }
}
