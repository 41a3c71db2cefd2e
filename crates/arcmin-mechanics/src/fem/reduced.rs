use super::flank::{FlankStations, LOBE_REFINEMENT, Stencil};

/// A disc reduced to modes and flank compliances, all in SI units, in the frame of its flank.
#[derive(Debug, Clone)]
pub struct ReducedDisc {
    /// Lobes of the flank, z_c.
    pub lobe_count: usize,
    /// Places of the flank where unit loads were solved for.
    pub stations: FlankStations,
    /// Depth h in m to which the contact law reaches; see [`crate::contact::LineContact::at_disc_depth`].
    pub reading_depth: f64,
    /// ω² of the held modes in rad²/s², ascending; the shapes have unit modal mass.
    pub eigenvalues: Vec<f64>,
    /// Number of fixed-interface normal modes; the others follow from flank loads.
    pub normal_modes: usize,
    /// Spline coefficients of the inward normal displacement per unit modal coordinate, mode after mode, in
    /// 1/√kg.
    pub(super) flank_modes: Vec<f64>,
    /// Static displacement of the flank under forces on it, the interface held.
    pub compliance: FlankCompliance,
    /// Φᵀ M r for unit rates of x, y (√kg) and of rotation about the disc centre (√kg·m).
    pub momentum: [Vec<f64>; 3],
    /// The disc's bore centres as coordinates; empty with one spider for all bores.
    pub interface: Interface,
}

/// Craig–Bampton matrices of the interface coordinates b, bore by bore: (x, y) of its centre, and where its rim may go out
/// of round the expansion and the cosine and sine of the orders from 2 on, as in `fem::carrier`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Interface {
    /// Number of coordinates b.
    pub count: usize,
    /// Coordinates of one bore: 2 with round rims.
    pub per_bore: usize,
    /// Condensed stiffness K_bb + K_bi Ψ in N/m, count × count, row-major; rigid motions cost nothing.
    pub stiffness: Vec<f64>,
    /// Ψᵀ M Ψ in kg.
    pub mass: Vec<f64>,
    /// Ψᵀ M Φ in √kg, count × modes.
    pub coupling: Vec<f64>,
    /// Spline coefficients of the inward normal displacement per unit of each coordinate, count × stations.
    pub flank: Vec<f64>,
}

/// Static normal displacement of flank places per unit normal force, m/N, the interface held.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankCompliance {
    pub(super) stations: usize,
    /// Spline coefficients of the surface displacement at one station under a force at another, stations ×
    /// stations, symmetric.
    pub(super) cross: Vec<f64>,
    /// Those of the displacement of a station under its own force, at the reading depth.
    pub(super) own: Vec<f64>,
    /// Part of the own displacement that the stations do not resolve: it varies with the curvature of the flank, on
    /// every lobe alike. Spline coefficients of the difference on the finer grid of one lobe.
    pub(super) own_detail: Vec<f64>,
}

#[inline]
pub(super) fn spline(coefficients: &[f64], weights: &[(usize, f64); 4]) -> f64 {
    weights.iter().map(|(s, w)| w * coefficients[*s]).sum()
}

impl FlankCompliance {
    /// From values at the stations.
    pub(super) fn new(stations: &FlankStations, mut cross: Vec<f64>, own: Vec<f64>) -> FlankCompliance {
        let count = stations.count();
        for s in 0..count {
            FlankStations::filter(&mut cross, s * count, 1, count);
        }
        for s in 0..count {
            FlankStations::filter(&mut cross, s, count, count);
        }
        let own_detail = vec![0.0; stations.per_lobe() * LOBE_REFINEMENT];
        FlankCompliance { stations: count, cross, own: stations.coefficients(own), own_detail }
    }

    /// Sets the detail of the own displacement from exact values on the finer grid of one lobe, given as
    /// (grid index, place, value).
    pub(super) fn refine_own(&mut self, exact: &[(usize, Stencil, f64)]) {
        let mut difference = vec![0.0; self.own_detail.len()];
        for (index, place, value) in exact {
            difference[*index] = value - spline(&self.own, &place.stations);
        }
        self.own_detail = FlankStations::periodic_coefficients(difference);
    }

    /// Displacement of a place under its own unit force, read at the reading depth, in m/N.
    #[inline]
    pub fn own(&self, at: &Stencil) -> f64 {
        spline(&self.own, &at.stations) + spline(&self.own_detail, &at.lobe)
    }

    /// Bound of the outward displacement of the flank under a unit force elsewhere, in m/N: values of a B-spline lie
    /// between its coefficients.
    pub fn largest_lift(&self) -> f64 {
        self.cross.iter().fold(0.0, |most: f64, c| most.max(-c))
    }

    /// Displacement of one place under a unit force at another, in m/N. The two must lie on different teeth
    /// or flanks. Stations of a place stand side by side, but where the grid closes.
    #[inline]
    pub fn cross(&self, at: &Stencil, force: &Stencil) -> f64 {
        let [(first, a), (_, b), (_, c), (last, d)] = force.stations;
        let mut four = [0.0; 4];
        if last == first + 3 {
            for (s, ws) in at.stations {
                let row = &self.cross[s * self.stations + first..][..4];
                (0..4).for_each(|k| four[k] += ws * row[k]);
            }
        } else {
            for (s, ws) in at.stations {
                let row = &self.cross[s * self.stations..][..self.stations];
                four.iter_mut().zip(force.stations).for_each(|(sum, (t, _))| *sum += ws * row[t]);
            }
        }
        a * four[0] + b * four[1] + c * four[2] + d * four[3]
    }
}

impl ReducedDisc {
    /// Natural frequencies with the interface held, in Hz.
    pub fn frequencies(&self) -> Vec<f64> {
        self.eigenvalues.iter().map(|l| l.sqrt() / std::f64::consts::TAU).collect()
    }

    /// Inward normal displacement at a place per unit of modal coordinate `mode`, in 1/√kg.
    #[inline]
    pub fn mode_at(&self, mode: usize, at: &Stencil) -> f64 {
        spline(&self.flank_modes[mode * self.stations.count()..], &at.stations)
    }

    /// Inward normal displacement at a place per unit of an interface coordinate, the others held.
    pub fn interface_at(&self, coordinate: usize, at: &Stencil) -> f64 {
        spline(&self.interface.flank[coordinate * self.stations.count()..], &at.stations)
    }

    /// Remainder of the static compliance once the first `modes` modes are coordinates of their own: C − Σ φ
    /// φᵀ/ω².
    pub fn residual_compliance(&self, modes: usize) -> FlankCompliance {
        let count = self.stations.count();
        let mut residual = self.compliance.clone();
        let mut own = FlankStations::values(&residual.own);
        for m in 0..modes.min(self.eigenvalues.len()) {
            let shape = &self.flank_modes[m * count..(m + 1) * count];
            let values = FlankStations::values(shape);
            for s in 0..count {
                own[s] -= values[s] * values[s] / self.eigenvalues[m];
                let share = shape[s] / self.eigenvalues[m];
                for t in 0..count {
                    residual.cross[s * count + t] -= share * shape[t];
                }
            }
        }
        residual.own = self.stations.coefficients(own);
        residual
    }

    /// The same disc of a material `factor` times stiffer: compliances go with 1/E, ω² with E, shapes stay.
    pub fn stiffened(&self, factor: f64) -> ReducedDisc {
        let mut stiff = self.clone();
        let c = &mut stiff.compliance;
        c.cross.iter_mut().chain(&mut c.own).chain(&mut c.own_detail).for_each(|value| *value /= factor);
        stiff.eigenvalues.iter_mut().chain(&mut stiff.interface.stiffness).for_each(|value| *value *= factor);
        stiff
    }

    /// The same disc in plane stress, `factor` times as wide. Stiffness K and mass M go with the width B: compliances with
    /// 1/B, shapes of unit modal mass with 1/√B, and ω² stays.
    pub fn widened(mut self, factor: f64) -> ReducedDisc {
        let scale = |values: &mut [f64], by: f64| values.iter_mut().for_each(|value| *value *= by);
        let c = &mut self.compliance;
        for values in [&mut c.cross, &mut c.own, &mut c.own_detail] {
            scale(values, 1.0 / factor);
        }
        scale(&mut self.flank_modes, 1.0 / factor.sqrt());
        self.momentum.iter_mut().for_each(|values| scale(values, factor.sqrt()));
        let Interface { stiffness, mass, coupling, .. } = &mut self.interface;
        scale(stiffness, factor);
        scale(mass, factor);
        scale(coupling, factor.sqrt());
        self
    }

    /// Number of modes up to a frequency in Hz.
    pub fn modes_up_to(&self, frequency: f64) -> usize {
        let limit = (std::f64::consts::TAU * frequency).powi(2);
        self.eigenvalues.partition_point(|l| *l <= limit)
    }
}
