use super::WearCase;
use super::deposit::FlankArc;
use crate::geometry::{Profile, Relief};

/// Effective worn surface of a contact: the depth averaged over the width of the contact.
///
/// A line contact is 50 to 200 µm wide. It flattens shorter waves of the flank, which neither displace the
/// contact nor change its curvature. Depth and derivatives are therefore those of the depth averaged with a
/// cubic B-spline whose mean-square width equals that of the Hertz pressure of half-width b (b²/4). The shape
/// of the kernel is an assumption; given are its width and the condition that its transform is positive,
/// without which waves of the flank would grow (see [`FlankArc::spread`]). A B-spline fulfils both and has
/// finite support. b is that of the largest torque of the duty; towards the root it is reduced so that the
/// average stays on its flank.
///
/// Pins have the deepest wear where the contact reverses on them, next to a zone without contact. A flank of
/// larger radius does not reach the bottom of such a groove but rests on its edges and wears these. For the
/// averaged depth d the effective depth is therefore w(s₀) = min over s of [d(s) + ½ κ (s − s₀)²], s along the
/// pin, κ the smallest relative curvature of the flanks in contact there. The curvature of the gaps is then
/// hardly larger than that of the bodies, so that the contact point of a pin on its flank is unique.
#[derive(Debug, Clone)]
pub(super) struct ContactAverage {
    /// Per grid point: first cell and the weights from there on.
    flank: Vec<(usize, Vec<f64>)>,
    /// Weights on the pin, centred.
    pin: Vec<f64>,
    /// κ in 1/m on the pin's grid.
    pin_curvature: Vec<f64>,
    pin_radius: f64,
    /// Half-width b in m of the contact at the reversal point.
    pin_half_width: f64,
}

/// Half the support of the kernel in half-widths: four boxes with a total width of b √3/2 each.
const SUPPORT: f64 = 1.732_050_807_568_877_2;

impl ContactAverage {
    pub fn new(case: &WearCase, arc: &FlankArc, pin_points: usize) -> ContactAverage {
        let (profile, contact, largest) = (&case.profile, &case.contact, case.largest_force);
        let half_width = |phi: f64| {
            let force = largest * (profile.lever_arm(phi) / profile.largest_lever_arm()).abs();
            contact.half_width(force, 1.0 / profile.relative_curvature(phi.cos(), case.pin_radius))
        };
        let cells = arc.cells();
        let root = arc.centre(cells / 2);
        let flank = Relief::grid(cells)
            .enumerate()
            .map(|(cell, phi)| {
                let centre = arc.centre(cell);
                // Not across the root, and not narrower than the grid resolves: with 0.6 cells the spline (2.1
                // cells wide in total) includes both neighbours, so that derivatives are defined. This
                // assumption affects small forces only; with a grid twice as fine, depth and backlash change by
                // less than 0.2 % and 1 % (tested).
                let b = half_width(phi).min((centre - root).abs() / SUPPORT).max(0.6 * arc.cell_width(cell));
                weights(centre, b, |index| arc.face(index))
            })
            .map(|(first, weights)| (first.rem_euclid(cells as isize) as usize, weights))
            .collect();
        let pin_cell = std::f64::consts::TAU * case.pin_radius / pin_points as f64;
        // Pins wear most where the contact reverses on them, at cos φ = K1.
        let pin_width = half_width(profile.short_width_coefficient().min(1.0).acos()).max(pin_cell);
        let (_, pin) = weights(0.5 * pin_cell, pin_width, |index| index as f64 * pin_cell);
        ContactAverage {
            flank,
            pin,
            pin_curvature: pin_curvature(profile, case.pin_radius, pin_points),
            pin_radius: case.pin_radius,
            pin_half_width: pin_width,
        }
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
        // The effective depth has a kink where the contact changes from one edge of a groove to the other.
        Relief::from_control_points(&self.reached(&self.averaged(depth)))
    }

    /// Depth of a pin averaged over the width of the contact, at its grid points.
    fn averaged(&self, depth: &Relief) -> Vec<f64> {
        let depths = depth.samples();
        let n = depths.len();
        let reach = self.pin.len() / 2;
        (0..n)
            .map(|i| self.pin.iter().enumerate().map(|(k, w)| w * depths[(i + n + k - reach) % n]).sum())
            .collect()
    }

    /// min over s of [d(s) + ½ κ (s − s₀)²] at the grid points of the pin.
    fn reached(&self, depths: &[f64]) -> Vec<f64> {
        let n = depths.len();
        let cell = std::f64::consts::TAU * self.pin_radius / n as f64;
        let least_from = |i: usize| {
            let bow = 0.5 * self.pin_curvature[i] * cell * cell;
            let mut least = depths[i];
            for away in 1..n / 2 {
                let rise = bow * (away * away) as f64;
                if rise >= least {
                    break;
                }
                least = least.min(rise + depths[(i + away) % n].min(depths[(i + n - away) % n]));
            }
            least
        };
        (0..n).map(least_from).collect()
    }

    /// Fraction of the pin's surface within reach of a flank, from 1 to 0 at the bottom of a groove, on the
    /// pin's grid: exp(−(d − o)/ε) with the averaged depth d, the largest depth o(s) = max over s₀ of [w(s₀) −
    /// ½ κ (s − s₀)²] of any flank position, and the height ε = ½ κ b² that the contact flattens. Empty if the
    /// whole pin is within reach by construction. Surfaces out of reach do not wear.
    pub fn within_reach(&self, pin: &Relief, seen: &Relief) -> Vec<f64> {
        if pin.is_zero() || pin.is_uniform() {
            return Vec::new();
        }
        let (depths, seen) = (self.averaged(pin), seen.samples());
        let n = depths.len();
        let cell = std::f64::consts::TAU * self.pin_radius / n as f64;
        let mut deepest_stand: Vec<f64> = seen.to_vec();
        for (i, stand) in seen.iter().enumerate() {
            let bow = 0.5 * self.pin_curvature[i] * cell * cell;
            for away in 1..n / 2 {
                let left = stand - bow * (away * away) as f64;
                if left <= 0.0 {
                    break;
                }
                for place in [(i + away) % n, (i + n - away) % n] {
                    deepest_stand[place] = deepest_stand[place].max(left);
                }
            }
        }
        let flat = |i: usize| 0.5 * self.pin_curvature[i] * self.pin_half_width.powi(2);
        (0..n).map(|i| (-(depths[i] - deepest_stand[i]).max(0.0) / flat(i)).exp()).collect()
    }

    /// Pin angle (rad) of the contact with a flank whose normal is at the pin angle ψ (rad), for the effective
    /// depth `seen`: s₀ − w′/κ, where d(s) + ½ κ (s − s₀)² is smallest, limited to the distance at which ½ κ (s
    /// − s₀)² equals w.
    pub fn touching(&self, seen: &Relief, angle: f64) -> f64 {
        if seen.is_uniform() {
            return angle;
        }
        let n = self.pin_curvature.len();
        let cell = ((angle + std::f64::consts::PI) / std::f64::consts::TAU * n as f64).round() as usize % n;
        let curvature = self.pin_curvature[cell];
        let at = seen.at(angle);
        let most = (2.0 * at.depth.max(0.0) / curvature).sqrt() / self.pin_radius;
        angle - (at.slope / (curvature * self.pin_radius.powi(2))).clamp(-most, most)
    }
}

/// Relative curvature in 1/m of the flank in contact with each grid point of a pin. A point within the zone has
/// two contacts, one between root and reversal point and one beyond it; the smaller curvature, that near the
/// root, is used.
fn pin_curvature(profile: &Profile, pin_radius: f64, pin_points: usize) -> Vec<f64> {
    const PLACES: usize = 256;
    let turning = profile.short_width_coefficient().min(1.0).acos();
    let met: Vec<(f64, f64)> = (0..=PLACES)
        .map(|i| {
            let phi = turning * i as f64 / PLACES as f64;
            let curvature = profile.relative_curvature(phi.cos(), pin_radius);
            (profile.pin_angle(phi).abs(), curvature.max(NEARLY_CONFORMAL / pin_radius))
        })
        .collect();
    Relief::grid(pin_points)
        .map(|angle| {
            let right = met.partition_point(|(psi, _)| *psi < angle.abs()).clamp(1, PLACES);
            let ((a, at_a), (b, at_b)) = (met[right - 1], met[right]);
            let share = if b > a { ((angle.abs() - a) / (b - a)).clamp(0.0, 1.0) } else { 1.0 };
            at_a + share * (at_b - at_a)
        })
        .collect()
}

/// Smallest relative curvature times pin radius, for flanks with nearly the shape of the pin.
const NEARLY_CONFORMAL: f64 = 1e-3;

/// Weights of the cells around `centre`: integrals of the B-spline over each cell. `face(i)` is the left end
/// of cell i on the unrolled line.
fn weights(centre: f64, half_width: f64, face: impl Fn(isize) -> f64) -> (isize, Vec<f64>) {
    let box_width = 0.5 * SUPPORT * half_width;
    let below = |place: f64| cubic_spline_share((place - centre) / box_width);
    let reach = 2.0 * box_width;
    let mut first = 0;
    // Cells are counted from the one that contains the centre.
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
    use crate::units::UM;

    #[test]
    fn averaging_keeps_a_uniform_depth() {
        let machine = crate::templates::tao2024();
        let profile = machine.profile();
        let arc = FlankArc::new(&profile, 720);
        let average = ContactAverage::new(&WearCase::from(&machine), &arc, 1440);
        for relief in [
            average.flank(&Relief::from_samples(vec![1e-5; 720])),
            average.pin(&Relief::from_samples(vec![1e-5; 1440])),
        ] {
            assert!(relief.samples().iter().all(|depth| (depth - 1e-5).abs() < 1e-17));
        }
    }

    fn average_of_the_rv_40e() -> ContactAverage {
        let machine = crate::templates::tao2024();
        ContactAverage::new(&WearCase::from(&machine), &FlankArc::new(&machine.profile(), 720), 1440)
    }

    /// The effective depth of a deep notch consists of two parabolas that rest on its edges: w = ½ κ (distance
    /// from the nearer edge)², and the flank touches there. A dent flatter than the flank is not changed, and
    /// touched at the closest point according to its slope.
    #[test]
    fn a_flank_rests_on_the_edges_of_a_groove() {
        let average = average_of_the_rv_40e();
        let (n, r) = (1440, 3e-3);
        let cell = std::f64::consts::TAU / n as f64;
        let middle = n / 2 + 217;
        let kappa = average.pin_curvature[middle];
        let notch: Vec<f64> = (0..n).map(|i| if i.abs_diff(middle) < 6 { 30.0 * UM } else { 0.0 }).collect();
        let seen = average.reached(&notch);
        for off in 0..6 {
            let curvature = average.pin_curvature[middle + off];
            let expected = 0.5 * curvature * ((6 - off) as f64 * cell * r).powi(2);
            assert!((seen[middle + off] / expected - 1.0).abs() < 1e-9, "{off}");
        }
        assert_eq!(seen[middle + 6], 0.0);
        // Averaging rounds the notch; its bottom is out of reach, its surroundings are within reach.
        let reach = average.within_reach(&Relief::from_samples(notch), &Relief::from_samples(seen.clone()));
        assert!(
            reach[middle] < 1e-3 && reach[middle + 20] > 0.99,
            "{} {}",
            reach[middle],
            reach[middle + 20]
        );
        let relief = Relief::from_samples(seen);
        let psi = |i: usize| -std::f64::consts::PI + i as f64 * cell;
        for off in 2..5 {
            let touched = average.touching(&relief, psi(middle + off));
            assert!((touched - psi(middle + 6)).abs() < 0.7 * cell, "{off}: {touched}");
        }
        // d = w₀ exp(−½ (s/σ)²) with d″ ≤ w₀/σ² far below κ: the envelope displaces the contact by −d′/(κ +
        // d″).
        let (depth, sigma) = (0.2 * UM, 0.5e-3);
        assert!(depth / (sigma * sigma) < 0.01 * kappa);
        let d = |s: f64| depth * (-0.5 * (s / sigma).powi(2)).exp();
        let dent: Vec<f64> = (0..n).map(|i| d((psi(i) - psi(middle)) * r)).collect();
        let seen = Relief::from_samples(average.reached(&dent));
        for off in [5, 20, 40] {
            let s = off as f64 * cell * r;
            assert!((seen.at(psi(middle + off)).depth - d(s)).abs() < 0.01 * depth);
        }
        assert!(average.within_reach(&Relief::from_samples(dent), &seen).iter().all(|share| *share > 0.95));
    }

    /// The effective depth never exceeds the wear depth, and for a flank of uniform curvature its second
    /// derivative never exceeds that curvature.
    #[test]
    fn effective_depth_has_no_larger_curvature_than_the_flank() {
        let mut average = average_of_the_rv_40e();
        let (n, kappa) = (1440, 300.0);
        average.pin_curvature.fill(kappa);
        let waves = |x: f64| (0.5 + 0.5 * (0.7 * x).sin()) * (0.031 * x).cos().abs();
        let rough: Vec<f64> = (0..n).map(|i| 20.0 * UM * waves(i as f64)).collect();
        let seen = average.reached(&rough);
        let cell = std::f64::consts::TAU * 3e-3 / n as f64;
        for i in 0..n {
            assert!(seen[i] <= rough[i] && seen[i] >= 0.0);
            let bend = (seen[(i + 1) % n] - 2.0 * seen[i] + seen[(i + n - 1) % n]) / (cell * cell);
            assert!(bend <= kappa * (1.0 + 1e-6), "{i}: {bend}");
        }
        assert!(seen.iter().zip(&rough).any(|(seen, rough)| *seen < 0.5 * rough));
    }

    #[test]
    fn kernel_has_the_mean_square_width_of_the_hertz_pressure() {
        let (first, weights) = weights(0.0, 1.0, |index| index as f64 * 0.01 - 0.005);
        let variance: f64 =
            weights.iter().enumerate().map(|(k, w)| w * ((first + k as isize) as f64 * 0.01).powi(2)).sum();
        assert!((variance - 0.25).abs() < 1e-4, "{variance}");
    }
}
