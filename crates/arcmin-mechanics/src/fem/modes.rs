//! Modes of a disc that a simulation keeps as coordinates, as displacements of flank and bores.

use faer::Mat;

use super::carrier::{RIM_COORDINATES, RIM_ORDER};
use super::reduced::spline;
use super::solve::symmetric_eigen;
use super::{FemError, ReducedDisc, Stencil};
use crate::geometry::{Vec2, turned, unit};

/// Modes of unit modal mass with their displacement of the flank.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankModes {
    /// ω² in rad²/s², ascending.
    pub eigenvalues: Vec<f64>,
    stations: usize,
    /// Spline coefficients of the inward normal displacement, mode after mode, in 1/√kg.
    shapes: Vec<f64>,
}

impl FlankModes {
    /// Modes kept.
    pub fn count(&self) -> usize {
        self.eigenvalues.len()
    }

    /// Inward normal displacement at a place per unit of a mode, in 1/√kg.
    #[inline]
    pub fn at(&self, mode: usize, place: &Stencil) -> f64 {
        spline(&self.shapes[mode * self.stations..], &place.stations)
    }

    /// Bound of the displacement of any place of the flank per unit of a mode, in 1/√kg.
    pub fn peak(&self, mode: usize) -> f64 {
        let shape = &self.shapes[mode * self.stations..(mode + 1) * self.stations];
        shape.iter().fold(0.0, |most: f64, c| most.max(c.abs()))
    }
}

/// Motion of a bore: displacement of its centre, and ovalisation of its rim (expansion, then cosine and sine of the
/// orders from 2).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BoreMotion {
    /// Displacement (x, y) of the centre.
    pub centre: Vec2,
    /// Radial displacement of the rim: expansion, then cosine and sine of every order from 2 on.
    pub rim: [f64; RIM_COORDINATES],
}

impl BoreMotion {
    /// From interface coordinates, without those of the rim if it is round.
    fn new(coordinates: &[f64]) -> BoreMotion {
        let mut motion =
            BoreMotion { centre: Vec2::new(coordinates[0], coordinates[1]), rim: [0.0; RIM_COORDINATES] };
        motion.rim.iter_mut().zip(&coordinates[2..]).for_each(|(to, from)| *to = *from);
        motion
    }

    /// The same, rotated by an angle in rad: the phase of order n advances by n times the angle.
    #[must_use]
    pub fn turned(&self, angle: f64) -> BoreMotion {
        let mut motion = BoreMotion { centre: turned(self.centre, unit(angle)), ..*self };
        for order in 2..=RIM_ORDER {
            let at = 2 * order - 3;
            let wave = turned(Vec2::new(self.rim[at], self.rim[at + 1]), unit(order as f64 * angle));
            (motion.rim[at], motion.rim[at + 1]) = (wave.x, wave.y);
        }
        motion
    }
}

/// Elastic modes of a disc whose bore centres, and rims if they are free, are supported by its bearings.
///
/// They are orthogonal to the three rigid motions with respect to the mass (∫ρ u = 0, ∫ρ r × u = 0): in the mean axes
/// of the disc, in which its kinetic energy is the sum of those of centre, rotation and modes.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeModes {
    /// Displacement of the flank by the modes.
    pub flank: FlankModes,
    /// Motion of every bore per unit of a mode, mode after mode, in 1/√kg.
    bores: Vec<BoreMotion>,
    /// Whether rims ovalise.
    pub rims: bool,
}

impl FreeModes {
    /// Motion of a bore per unit of `mode`.
    pub fn bore(&self, mode: usize, bore: usize) -> BoreMotion {
        self.bores[mode * (self.bores.len() / self.flank.count().max(1)) + bore]
    }
}

/// Rigid motions in the plane.
const RIGID: usize = 3;

impl ReducedDisc {
    /// The lowest `count` modes with the interface held.
    pub fn held_modes(&self, count: usize) -> FlankModes {
        let count = count.min(self.eigenvalues.len());
        let stations = self.stations.count();
        FlankModes {
            eigenvalues: self.eigenvalues[..count].to_vec(),
            stations,
            shapes: self.flank_modes[..count * stations].to_vec(),
        }
    }

    /// Elastic modes spanned by the interface coordinates and the lowest `held` modes with the interface held.
    /// Together with [`ReducedDisc::residual_compliance`] of the same number they contain the whole static compliance
    /// between flank and bores: the omitted modes do not displace the interface coordinates.
    ///
    /// # Errors
    /// [`FemError::NoInterface`] where one rigid spider ties the bores, [`FemError::Factorisation`] if the
    /// small eigenproblem cannot be solved.
    pub fn free_modes(&self, held: usize) -> Result<FreeModes, FemError> {
        let nb = self.interface.count;
        let per_bore = self.interface.per_bore;
        // Fewer than two bores do not support the disc.
        if nb < 2 * per_bore.max(1) {
            return Err(FemError::NoInterface);
        }
        let held = held.min(self.eigenvalues.len());
        let stations = self.stations.count();
        let (values, vectors) = self.free_eigen(held)?;
        let kept = RIGID..nb + held;
        let mut shapes = Vec::with_capacity(kept.len() * stations);
        let mut bores = Vec::with_capacity(kept.len() * nb / per_bore);
        for mode in kept.clone() {
            shapes.extend((0..stations).map(|s| {
                let interface: f64 =
                    (0..nb).map(|b| vectors[(b, mode)] * self.interface.flank[b * stations + s]).sum();
                interface
                    + (0..held)
                        .map(|m| vectors[(nb + m, mode)] * self.flank_modes[m * stations + s])
                        .sum::<f64>()
            }));
            bores.extend(vectors.col_as_slice(mode)[..nb].chunks_exact(per_bore).map(BoreMotion::new));
        }
        Ok(FreeModes {
            flank: FlankModes { eigenvalues: values[kept].to_vec(), stations, shapes },
            bores,
            rims: per_bore > 2,
        })
    }

    /// ω² ascending and M-orthonormal vectors over (interface coordinates, held modes) of the disc with its
    /// interface free: rigid motions first.
    fn free_eigen(&self, held: usize) -> Result<(Vec<f64>, Mat<f64>), FemError> {
        let (nb, all) = (self.interface.count, self.eigenvalues.len());
        let n = nb + held;
        let mass = Mat::from_fn(n, n, |i, j| match (i < nb, j < nb) {
            (true, true) => self.interface.mass[i * nb + j],
            (true, false) => self.interface.coupling[i * all + j - nb],
            (false, true) => self.interface.coupling[j * all + i - nb],
            (false, false) => f64::from(u8::from(i == j)),
        });
        let (values, vectors) = symmetric_eigen(mass.as_ref())?;
        let whitening = Mat::from_fn(n, n, |i, k| vectors[(i, k)] / values[k].sqrt());
        let stiffness = |i: usize, j: usize| match (i < nb, j < nb) {
            (true, true) => self.interface.stiffness[i * nb + j],
            (false, false) if i == j => self.eigenvalues[i - nb],
            _ => 0.0,
        };
        let half =
            Mat::from_fn(n, n, |i, k| (0..n).map(|j| stiffness(i, j) * whitening[(j, k)]).sum::<f64>());
        let projected =
            Mat::from_fn(n, n, |i, j| (0..n).map(|k| whitening[(k, i)] * half[(k, j)]).sum::<f64>());
        let symmetric = Mat::from_fn(n, n, |i, j| 0.5 * (projected[(i, j)] + projected[(j, i)]));
        let (eigenvalues, rotation) = symmetric_eigen(symmetric.as_ref())?;
        Ok((
            eigenvalues,
            Mat::from_fn(n, n, |i, k| (0..n).map(|j| whitening[(i, j)] * rotation[(j, k)]).sum::<f64>()),
        ))
    }

    /// Frequencies in Hz of the reduced disc with its interface free: three zeros, then elastic modes. For comparison
    /// with [`DiscModel::free_modes`](super::DiscModel::free_modes). Empty where the interface is one rigid spider.
    ///
    /// # Errors
    /// [`FemError::Factorisation`] if the small eigenproblem cannot be solved.
    pub fn free_frequencies(&self) -> Result<Vec<f64>, FemError> {
        if self.interface.count == 0 {
            return Ok(Vec::new());
        }
        let (eigenvalues, _) = self.free_eigen(self.eigenvalues.len())?;
        Ok(eigenvalues.iter().map(|l| l.max(0.0).sqrt() / std::f64::consts::TAU).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::reduced;
    use crate::templates::tao2024;

    /// Momentum and angular momentum of a mode, from rᵀ M (Ψ b + Φ q) = (Ψᵀ M Ψ r_b)·b + (Φᵀ M r)·q, are zero:
    /// the vibration of a disc contains no rigid motion. The second factor is from the rigid motions of the
    /// mesh.
    #[test]
    fn free_modes_have_no_momentum() {
        let (disc, machine) = (reduced(), tao2024());
        let held = 3;
        let nb = disc.interface.count;
        let (_, vectors) = disc.free_eigen(held).unwrap();
        let centres: Vec<_> =
            crate::fem::DiscShape::of(&machine, 0).bores.iter().map(|bore| bore.centre).collect();
        let rigid = |motion: usize, b: usize| match (motion, b % 2) {
            (0, 0) | (1, 1) => 1.0,
            (2, 0) => -centres[b / 2].y,
            (2, _) => centres[b / 2].x,
            _ => 0.0,
        };
        for (motion, inertia) in
            [machine.disc.mass, machine.disc.mass, machine.disc.inertia].into_iter().enumerate()
        {
            for mode in 3..nb + held {
                let interface: f64 = (0..nb)
                    .map(|a| {
                        vectors[(a, mode)]
                            * (0..nb).map(|b| disc.interface.mass[a * nb + b] * rigid(motion, b)).sum::<f64>()
                    })
                    .sum();
                let momentum = interface
                    + (0..held).map(|m| vectors[(nb + m, mode)] * disc.momentum[motion][m]).sum::<f64>();
                assert!(momentum.abs() < 1e-9 * inertia.sqrt(), "motion {motion}, mode {mode}: {momentum:e}");
            }
        }
    }

    #[test]
    fn stiffer_material_raises_all_free_modes_equally() {
        let (soft, stiff) =
            (reduced().free_modes(3).unwrap(), reduced().stiffened(1e4).free_modes(3).unwrap());
        for (a, b) in soft.flank.eigenvalues.iter().zip(&stiff.flank.eigenvalues) {
            assert!((b / a / 1e4 - 1.0).abs() < 1e-9, "{a} {b}");
        }
    }
}
