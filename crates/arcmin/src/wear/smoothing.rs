use super::deposit::FlankArc;
use crate::geometry::{Profile, Relief};
use crate::load::closed_form::first_max_force;
use crate::machine::Machine;

/// What the contact sees of a worn surface: depth averaged over the width of the contact.
///
/// A line contact is 50 to 200 µm wide; waves of the flank shorter than that are pressed flat and neither
/// shift the contact nor change its curvature. Depth, slope and bend are therefore read from the depth
/// averaged with a cubic B-spline whose mean-square width equals that of the Hertz pressure of half-width b
/// (b²/4). The spline is an assumption: what is known is the width, and that the transform must be positive, or
/// waves of the flank would grow (see [`FlankArc::spread`]); a B-spline has both and ends somewhere. b is that of
/// the largest torque of the duty; towards the root it shrinks so that the average stays
/// on its flank.
#[derive(Debug, Clone)]
pub(super) struct ContactAverage {
    /// Per grid point: first cell and the weights from there on.
    flank: Vec<(usize, Vec<f64>)>,
    /// Weights on the pin, centred.
    pin: Vec<f64>,
}

/// Support of the kernel in half-widths: four boxes of width b √3/2 in all.
const SUPPORT: f64 = 1.732_050_807_568_877_2;

impl ContactAverage {
    pub fn new(machine: &Machine, profile: &Profile, arc: &FlankArc, pin_points: usize) -> ContactAverage {
        let contact = machine.line_contact();
        let torque = machine.duty.iter().map(|duty| duty.torque.abs()).fold(0.0, f64::max);
        let largest = first_max_force(machine, torque);
        let half_width = |phi: f64| {
            let force = largest * (profile.lever_arm(phi) / profile.largest_lever_arm()).abs();
            contact.half_width(force, 1.0 / profile.relative_curvature(phi.cos(), machine.ring.pin_radius))
        };
        let cells = arc.cells();
        let root = arc.centre(cells / 2);
        let flank = Relief::grid(cells)
            .enumerate()
            .map(|(cell, phi)| {
                let centre = arc.centre(cell);
                // Never across the root, and never narrower than the grid resolves: 0.6 cells let the spline
                // (2.1 cells wide in all) reach both neighbours, so that slope and bend have a meaning. An
                // assumption that acts on small forces only; a grid twice as fine moves depth and play by less
                // than 0.2 % and 1 % (tested).
                let b = half_width(phi).min((centre - root).abs() / SUPPORT).max(0.6 * arc.cell_width(cell));
                weights(centre, b, |index| arc.face(index))
            })
            .map(|(first, weights)| (first.rem_euclid(cells as isize) as usize, weights))
            .collect();
        let pin_cell = std::f64::consts::TAU * machine.ring.pin_radius / pin_points as f64;
        // Pins wear where the contact turns back on them, at cos φ = K1.
        let pin_width = half_width(profile.short_width_coefficient().min(1.0).acos()).max(pin_cell);
        let (_, pin) = weights(0.5 * pin_cell, pin_width, |index| index as f64 * pin_cell);
        ContactAverage { flank, pin }
    }

    pub fn flank(&self, depth: &Relief) -> Relief {
        let depths = depth.samples();
        let n = depths.len();
        Relief::from_samples(
            self.flank
                .iter()
                .map(|(first, weights)| {
                    weights.iter().enumerate().map(|(k, w)| w * depths[(first + k) % n]).sum()
                })
                .collect(),
        )
    }

    pub fn pin(&self, depth: &Relief) -> Relief {
        if depth.is_zero() {
            return depth.clone();
        }
        let depths = depth.samples();
        let n = depths.len();
        let reach = self.pin.len() / 2;
        Relief::from_samples(
            (0..n)
                .map(|i| self.pin.iter().enumerate().map(|(k, w)| w * depths[(i + n + k - reach) % n]).sum())
                .collect(),
        )
    }
}

/// Weights of the cells around `centre`: integrals of the B-spline over each cell. `face(i)` is the left end
/// of cell i on the unrolled line.
fn weights(centre: f64, half_width: f64, face: impl Fn(isize) -> f64) -> (isize, Vec<f64>) {
    let box_width = 0.5 * SUPPORT * half_width;
    let below = |place: f64| cubic_spline_share((place - centre) / box_width);
    let reach = 2.0 * box_width;
    let mut first = 0;
    // Cells are counted from the one that holds the centre.
    while face(first + 1) <= centre {
        first += 1;
    }
    while face(first) > centre {
        first -= 1;
    }
    let mut last = first;
    while face(first) > centre - reach {
        first -= 1;
    }
    while face(last + 1) < centre + reach {
        last += 1;
    }
    (first, (first..=last).map(|cell| below(face(cell + 1)) - below(face(cell))).collect())
}

/// ∫ of the cubic B-spline on [−2, 2] from −2 to x: Σ_k (−1)^k C(4,k) (x + 2 − k)₊⁴/24.
fn cubic_spline_share(x: f64) -> f64 {
    if x >= 2.0 {
        return 1.0;
    }
    [1.0, -4.0, 6.0, -4.0, 1.0]
        .iter()
        .enumerate()
        .map(|(k, c)| c * (x + 2.0 - k as f64).max(0.0).powi(4))
        .sum::<f64>()
        / 24.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averaging_keeps_a_uniform_depth() {
        let machine = crate::templates::rv_40e_81();
        let profile = machine.profile();
        let arc = FlankArc::new(&profile, 720);
        let average = ContactAverage::new(&machine, &profile, &arc, 1440);
        for relief in [
            average.flank(&Relief::from_samples(vec![1e-5; 720])),
            average.pin(&Relief::from_samples(vec![1e-5; 1440])),
        ] {
            assert!(relief.samples().iter().all(|depth| (depth - 1e-5).abs() < 1e-17));
        }
    }

    #[test]
    fn kernel_has_the_mean_square_width_of_the_hertz_pressure() {
        let (first, weights) = weights(0.0, 1.0, |index| index as f64 * 0.01 - 0.005);
        let variance: f64 =
            weights.iter().enumerate().map(|(k, w)| w * ((first + k as isize) as f64 * 0.01).powi(2)).sum();
        assert!((variance - 0.25).abs() < 1e-4, "{variance}");
    }
}
