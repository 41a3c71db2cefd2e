//! Laws of rubbing surfaces: the local rate of wear, and the lubricant film that reduces it.
//!
//! A wear law is a [`LocalRate`] in a file of its own: dh/dt = k · rate(pressure, sliding, film, conformity,
//! depth, time) at one point. Everything else (load sharing, integration over the contact, calibration of k,
//! exposure) is common to all laws and is in [`wear`](crate::wear).

mod archard;
mod drag;
pub mod film;
mod oil;
mod pressure;
mod smoothing;

pub use archard::Archard;
pub use drag::{lubricant_moment, seal_drag, seal_share};
pub use film::{Lubrication, film_ratio};
pub use oil::{Oil, RubbingContact};
pub use pressure::PressurePower;
pub use smoothing::Smoothing;

use crate::named::named_laws;
use std::f64::consts::{FRAC_PI_2, PI};

named_laws! {
    /// Local rate of wear.
    #[derive(Default)]
    pub enum WearLaw;
    /// Wear laws by name.
    pub enum WearLawName, "wear law";

    /// [`Archard`].
    #[default]
    "archard", "Archard's law: rate ∝ pressure × sliding speed": Archard,
    /// [`PressurePower`].
    "pressure-power", "rate ∝ (pressure − threshold)^exponent × sliding speed; needs `exponent` and `threshold_mpa`":
        PressurePower {
            /// m.
            exponent: "exponent" => |p| p[0],
            /// Pa.
            threshold: "threshold_mpa" => |p| p[1] * 1e6,
        },
    /// [`Smoothing`].
    "smoothing", "Archard's law, faster until a place has lost its roughness; needs `factor` and `smoothing_depth_um`":
        Smoothing {
            /// f.
            factor: "factor" => |p| p[0],
            /// d in m.
            depth: "smoothing_depth_um" => |p| p[1] * 1e-6,
        },
}

impl WearLaw {
    /// The law itself.
    pub fn local_rate(&self) -> Box<dyn LocalRate> {
        match *self {
            WearLaw::Archard => Box::new(Archard),
            WearLaw::PressurePower { exponent, threshold } => Box::new(PressurePower { exponent, threshold }),
            WearLaw::Smoothing { factor, depth } => Box::new(Smoothing { factor, depth }),
        }
    }
}

/// Loads on a place of a surface while a contact passes over it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Local {
    /// Pressure in Pa.
    pub pressure: f64,
    /// Sliding speed |v_s| in m/s.
    pub sliding: f64,
    /// Equivalent radius R_eq of the contact in m: the larger, the closer the surfaces conform.
    pub equivalent_radius: f64,
    /// Film ratio λ = least film thickness over roughness; 0 where no lubricant is known.
    pub film_ratio: f64,
    /// Metal that the place has lost already in m.
    pub depth: f64,
    /// Running time in s.
    pub time: f64,
}

impl Local {
    /// Share of the load that asperities carry in mixed lubrication, 1/(1 + λ)²; 1 without a film.
    pub fn boundary_share(&self) -> f64 {
        film::boundary_share(self.film_ratio)
    }
}

/// A wear law.
pub trait LocalRate: std::fmt::Debug + Send + Sync {
    /// dh/dt per unit of the wear coefficient k, in m/s per 1/Pa = Pa·m/s. Never negative, and finite.
    fn rate(&self, at: &Local) -> f64;

    /// Pressure in Pa below which there is no wear.
    fn threshold(&self) -> f64 {
        0.0
    }

    /// Whether [`Local::time`] enters. A law of which it does not separates into k(t) times a function of the
    /// place, so that one computation in the exposure x = ∫k dt serves every k.
    fn depends_on_time(&self) -> bool {
        false
    }

    /// Removed section per unit of time and of k in m²/s per 1/Pa: the integral of the rate over the width of
    /// a line contact with the load `line_load` (N/m) and the Hertz half-width `half_width` (m). `at` holds
    /// everything but the pressure.
    ///
    /// With p = p0 cos θ at x = b sin θ this is 2b ∫ rate(p0 cos θ) cos θ dθ, taken by Gauss–Legendre's rule
    /// up to where the pressure falls to the threshold; eight nodes integrate p^m to 1e-6 for m up to 8.
    fn section_rate(&self, line_load: f64, half_width: f64, at: &Local) -> f64 {
        let largest = 2.0 * line_load / (PI * half_width);
        let threshold = self.threshold();
        if !(largest > threshold) {
            return 0.0;
        }
        let end = if threshold > 0.0 { (threshold / largest).acos() } else { FRAC_PI_2 };
        let half = 0.5 * end;
        let sum: f64 = GAUSS_LEGENDRE
            .iter()
            .flat_map(|(node, weight)| [(half * (1.0 - node), weight), (half * (1.0 + node), weight)])
            .map(|(angle, weight)| {
                let cos = angle.cos();
                weight * self.rate(&Local { pressure: largest * cos, ..*at }) * cos
            })
            .sum();
        2.0 * half_width * half * sum
    }
}

/// Positive nodes and weights of the rule with eight points on [−1, 1] (Abramowitz & Stegun 1964, table 25.4).
const GAUSS_LEGENDRE: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

#[cfg(test)]
mod tests;
