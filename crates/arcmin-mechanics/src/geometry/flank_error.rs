use std::f64::consts::{PI, TAU};

use super::{DepthSample, Profile, Relief, Vec2, cross, quarter_turn, turned, unit};

/// Depth of missing metal on one disc's flank: harmonics of the angle τ on the disc, and a measurement around
/// it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FlankError {
    /// Waves around the disc, of any orders.
    pub harmonics: Vec<FlankHarmonic>,
    /// Depth along the normal over the angle τ on the disc.
    pub measured: Option<Relief>,
}

/// amplitude × cos(order × (τ − phase)), a displacement of the flank along `direction`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankHarmonic {
    /// Waves around the disc.
    pub order: usize,
    /// m.
    pub amplitude: f64,
    /// rad.
    pub phase: f64,
    /// Sense in which the flank deviates.
    pub direction: FlankDirection,
}

/// Direction of a flank deviation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FlankDirection {
    /// Into the metal, along the normal: profile.
    #[default]
    Normal,
    /// Towards the centre of the disc: radial run-out is order 1.
    Inwards,
    /// Counter-clockwise: cumulative pitch.
    Around,
}

/// Reasons why a measured flank cannot be used. Points are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum FlankDataError {
    /// Number of the point whose angle does not exceed that of the point before.
    #[error("the angles must rise, but {0} does not")]
    NotRising(usize),
    /// Number of the point that lies beyond 2π after the first.
    #[error("the angle of {0} is outside of the turn that starts at the first angle")]
    MoreThanATurn(usize),
    /// Number of the point before the gap, width of the gap in rad, lobes of the disc.
    #[error("after {0} there is a gap of {degrees:.3}°; {lobes} lobes need a point every {need:.3}° at least", degrees = .1.to_degrees(), need = 90.0 / *.2 as f64, lobes = .2)]
    TooCoarse(usize, f64, usize),
}

/// Grid points per lobe that a measured flank is resampled to.
const POINTS_PER_LOBE: usize = 32;

impl FlankError {
    /// From measured depths along the normal, as (angle τ on the disc in rad, depth of missing metal in m),
    /// around the whole disc.
    ///
    /// Resampling: the measured points are joined by straight lines, closed around the disc. Every value of a
    /// grid with 32 points per lobe is the mean of these lines over one grid step, which filters shorter waves;
    /// a periodic cubic spline passes through the grid.
    ///
    /// # Errors
    /// [`FlankDataError`] if the angles do not rise, cover more than a turn, or leave a gap wider than a
    /// quarter of a lobe.
    pub fn from_measured(points: &[(f64, f64)], lobe_count: usize) -> Result<FlankError, FlankDataError> {
        let coarsest = TAU / (4 * lobe_count) as f64;
        let Some(first) = points.first() else { return Err(FlankDataError::TooCoarse(0, TAU, lobe_count)) };
        for (index, pair) in points.windows(2).enumerate() {
            if !(pair[1].0 > pair[0].0) {
                return Err(FlankDataError::NotRising(index + 1));
            }
            // A point at the end of the turn repeats the first one.
            if pair[1].0 > first.0 + TAU * (1.0 + 1e-9) {
                return Err(FlankDataError::MoreThanATurn(index + 1));
            }
        }
        let mut nodes: Vec<(f64, f64)> =
            points.iter().filter(|p| p.0 < first.0 + TAU * (1.0 - 1e-9)).copied().collect();
        nodes.push((first.0 + TAU, first.1));
        if let Some((index, pair)) =
            nodes.windows(2).enumerate().find(|(_, pair)| pair[1].0 - pair[0].0 > coarsest * (1.0 + 1e-9))
        {
            return Err(FlankDataError::TooCoarse(index, pair[1].0 - pair[0].0, lobe_count));
        }
        // Integral of the straight lines from the first node.
        let mut sums = vec![0.0];
        for pair in nodes.windows(2) {
            sums.push(sums[sums.len() - 1] + 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0));
        }
        let whole = sums[sums.len() - 1];
        let integral = |angle: f64| {
            let turns = ((angle - first.0) / TAU).floor();
            let x = angle - turns * TAU;
            let cell = nodes.partition_point(|node| node.0 <= x).clamp(1, nodes.len() - 1) - 1;
            let ((x0, y0), (x1, y1)) = (nodes[cell], nodes[cell + 1]);
            let share = (x - x0) / (x1 - x0);
            turns * whole + sums[cell] + (x - x0) * (y0 + 0.5 * share * (y1 - y0))
        };
        let count = POINTS_PER_LOBE * lobe_count;
        let step = TAU / count as f64;
        let depths = Relief::grid(count)
            .map(|angle| (integral(angle + 0.5 * step) - integral(angle - 0.5 * step)) / step)
            .collect();
        Ok(FlankError { harmonics: Vec::new(), measured: Some(Relief::from_samples(depths)) })
    }

    /// Missing metal in m at the angle τ (rad) on the disc, along the outward normal of the flank there.
    pub fn depth(&self, tau: f64, normal: Vec2) -> f64 {
        FlankErrorReader::new(self).depth(tau, unit(tau), normal)
    }

    /// Derivative of the depth along the flank by τ, m/rad.
    pub fn slope(&self, tau: f64, profile: &Profile) -> f64 {
        let (e, ez) = (unit(tau), unit(profile.pin_count as f64 * tau));
        FlankErrorReader::new(self).slope_on(tau, e, ez, profile)
    }

    /// Lower bound of the depth around the disc, in m.
    pub fn shallowest(&self) -> f64 {
        let measured = self.measured.as_ref().map_or(0.0, |relief| {
            let (low, high) = relief
                .samples()
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| (l.min(*d), h.max(*d)));
            // The spline may undershoot its points a little.
            low - 0.5 * (high - low)
        });
        // A wave of order 0 along the normal has the same depth everywhere.
        let everywhere = |h: &&FlankHarmonic| h.order == 0 && h.direction == FlankDirection::Normal;
        let depth: f64 = self.harmonics.iter().filter(everywhere).map(|h| h.amplitude).sum();
        let waves = self.harmonics.iter().filter(|h| !everywhere(h));
        measured.min(0.0) + depth - waves.map(|h| h.amplitude.abs()).sum::<f64>()
    }

    /// Lower bounds of the depth in m, one for each of equal sectors of τ from 0, valid also in the
    /// neighbouring sectors: the smallest depth at two points per sector less the largest difference between
    /// neighbouring points. The amplitude of waves too short for these points is subtracted everywhere.
    pub(crate) fn floors(&self, profile: &Profile) -> ErrorFloors {
        let lobes = profile.lobe_count();
        let count = SECTORS_PER_LOBE * lobes;
        let (short, long): (Vec<FlankHarmonic>, Vec<FlankHarmonic>) =
            self.harmonics.iter().copied().partition(|h| h.order > 8 * lobes);
        let short: f64 = short.iter().map(|h| h.amplitude.abs()).sum();
        let reader = FlankErrorReader::new(&FlankError { harmonics: long, measured: self.measured.clone() });
        let places = 2 * count;
        let depths: Vec<f64> = (0..places)
            .map(|i| {
                let tau = TAU * i as f64 / places as f64;
                reader.depth(tau, unit(tau), profile.outward_normal(tau))
            })
            .collect();
        let floor = |sector: usize| {
            // From the beginning of the previous sector to the end of the next.
            let near = |i: usize| depths[(2 * sector + places - 2 + i) % places];
            let (mut least, mut step) = (near(0), 0.0_f64);
            for i in 1..=6 {
                least = least.min(near(i));
                step = step.max((near(i) - near(i - 1)).abs());
            }
            least - step - short
        };
        ErrorFloors { sectors: (0..count).map(floor).collect() }
    }

    /// Whether no metal is missing.
    pub fn is_zero(&self) -> bool {
        self.harmonics.iter().all(|h| h.amplitude == 0.0)
            && self.measured.as_ref().is_none_or(Relief::is_zero)
    }
}

/// Number of sectors per lobe, each with its own lower bound.
const SECTORS_PER_LOBE: usize = 32;

/// Bounds from below of a [`FlankError`] in m, by sectors of τ.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ErrorFloors {
    sectors: Vec<f64>,
}

impl ErrorFloors {
    /// Width of a sector in rad; a bound holds up to this distance on either side of a position.
    pub fn reach(&self) -> f64 {
        TAU / self.sectors.len() as f64
    }

    /// Lower bound near τ = 2π `turn`, in m; `turn` from 0 to 1.
    #[inline]
    pub fn at(&self, turn: f64) -> f64 {
        self.sectors[((turn * self.sectors.len() as f64) as usize).min(self.sectors.len() - 1)]
    }
}

/// A [`FlankError`] in a form for fast evaluation: the only sine and cosine are those of τ itself.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FlankErrorReader {
    terms: Vec<Term>,
    measured: Option<Relief>,
}

/// Re(amplitude e(order τ)) along a direction; the amplitude holds the phase.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Term {
    order: usize,
    amplitude: Vec2,
    direction: FlankDirection,
}

impl FlankErrorReader {
    pub fn new(error: &FlankError) -> FlankErrorReader {
        let mut terms: Vec<Term> = error
            .harmonics
            .iter()
            .map(|h| Term {
                order: h.order,
                amplitude: h.amplitude * unit(-(h.order as f64) * h.phase),
                direction: h.direction,
            })
            .collect();
        terms.sort_by_key(|term| term.order);
        FlankErrorReader { terms, measured: error.measured.clone() }
    }

    /// Calls `add` for every term with e(order τ).
    #[inline]
    fn visit(&self, e: Vec2, mut add: impl FnMut(&Term, Vec2)) {
        let (mut order, mut wave) = (0, Vec2::new(1.0, 0.0));
        for term in &self.terms {
            wave = turned(wave, power(e, term.order - order));
            order = term.order;
            add(term, wave);
        }
    }

    fn measured_at(&self, tau: f64) -> DepthSample {
        self.measured
            .as_ref()
            .map_or_else(DepthSample::default, |measured| measured.at((tau + PI).rem_euclid(TAU) - PI))
    }

    /// Missing metal in m at τ, where `e` is e(τ), along the outward normal there.
    #[inline]
    pub fn depth(&self, tau: f64, e: Vec2, normal: Vec2) -> f64 {
        let (inwards, around) = (normal.dot(&e), -cross(e, normal));
        let mut depth = self.measured_at(tau).depth;
        self.visit(e, |term, wave| {
            let along = match term.direction {
                FlankDirection::Normal => 1.0,
                FlankDirection::Inwards => inwards,
                FlankDirection::Around => around,
            };
            depth += along * (term.amplitude.x * wave.x - term.amplitude.y * wave.y);
        });
        depth
    }

    /// Its derivative along the flank in m/rad, where `ez` is e(zτ).
    #[inline]
    pub fn slope_on(&self, tau: f64, e: Vec2, ez: Vec2, profile: &Profile) -> f64 {
        let (pin, eccentric) = if profile.tooth_difference == 1 { (e, ez) } else { profile.directions(tau) };
        let (_, c1, c2) = profile.trace_derivatives(pin, eccentric);
        let per_speed = 1.0 / c1.norm();
        let tangent = c1 * per_speed;
        // Rotation of the tangent towards the normal per rad of τ.
        let turning = -cross(c1, c2) * per_speed * per_speed;
        let normal = Vec2::new(tangent.y, -tangent.x);
        let (ahead, normal_rate) = (quarter_turn(e), -turning * tangent);
        let inwards = (normal.dot(&e), normal_rate.dot(&e) + normal.dot(&ahead));
        let around = (-cross(e, normal), -cross(ahead, normal) - cross(e, normal_rate));
        let mut slope = self.measured_at(tau).slope;
        self.visit(e, |term, wave| {
            let (along, rate) = match term.direction {
                FlankDirection::Normal => (1.0, 0.0),
                FlankDirection::Inwards => inwards,
                FlankDirection::Around => around,
            };
            let value = term.amplitude.x * wave.x - term.amplitude.y * wave.y;
            let by_tau = -(term.order as f64) * (term.amplitude.x * wave.y + term.amplitude.y * wave.x);
            slope += rate * value + along * by_tau;
        });
        slope
    }
}

/// e(n x) from e(x): powers of a complex number.
#[inline]
fn power(e: Vec2, mut n: usize) -> Vec2 {
    let (mut square, mut result) = (e, Vec2::new(1.0, 0.0));
    while n > 0 {
        if n & 1 == 1 {
            result = turned(result, square);
        }
        n >>= 1;
        if n > 0 {
            square = turned(square, square);
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The depth is nowhere smaller than the bound of its sector, up to a sector's width on either side, and
    /// the bounds are close to the depth except at the roots, where normals turn within a sector: run-out,
    /// pitch and profile errors, measured flanks, waves too short for the points.
    #[test]
    fn floors_of_sectors_hold_and_are_close() {
        let profile = Profile::new(40, 64e-3, 1.3e-3, 3e-3);
        let wave = |order, amplitude, phase, direction| FlankHarmonic { order, amplitude, phase, direction };
        let waves = vec![
            wave(1, 4e-6, 0.3, FlankDirection::Inwards),
            wave(3, 2e-6, 1.3, FlankDirection::Around),
            wave(39, 2e-6, 0.7, FlankDirection::Normal),
            wave(117, 0.5e-6, 2.0, FlankDirection::Normal),
        ];
        let measured: Vec<(f64, f64)> = (0..39 * 40)
            .map(|i| TAU * f64::from(i) / (39.0 * 40.0))
            .map(|tau| (tau, 3e-6 * (2.0 * tau).sin() + 1e-6 * (78.0 * tau).cos()))
            .collect();
        let short = vec![wave(39 * 64, 1e-6, 0.1, FlankDirection::Normal)];
        for (error, excess) in [
            (FlankError { harmonics: waves, measured: None }, 1e-6),
            (FlankError::from_measured(&measured, 39).unwrap(), 1e-6),
            (FlankError { harmonics: short, measured: None }, 1.1e-6),
        ] {
            let floors = error.floors(&profile);
            let mut sum = 0.0;
            for i in 0..20_000 {
                let turn = f64::from(i) / 20_000.0;
                let floor = floors.at(turn);
                for way in [-1.0, -0.5, 0.0, 0.5, 1.0] {
                    let tau = TAU * turn + way * floors.reach();
                    let depth = error.depth(tau, profile.outward_normal(tau));
                    assert!(floor <= depth, "{turn} {way}: {floor:e} {depth:e}");
                    if way == 0.0 {
                        sum += depth - floor;
                    }
                }
            }
            let mean = sum / 20_000.0;
            assert!(mean < excess, "{mean:e}");
        }
    }

    /// A known wave is reproduced from unevenly spaced points, many times as many as the grid has and a quarter
    /// of them.
    #[test]
    fn measured_flanks_are_resampled() {
        let wave = |x: f64| 5e-6 * (3.0 * x).cos() + 2e-6 * (39.0 * x - 0.4).sin();
        for count in [39 * 16, 20_000] {
            let points: Vec<(f64, f64)> = (0..count)
                .map(|i| {
                    let x = 0.3 + TAU * (i as f64 + 0.3 * (i as f64).sin()) / count as f64;
                    (x, wave(x))
                })
                .collect();
            let error = FlankError::from_measured(&points, 39).unwrap();
            for i in 0..500 {
                let x = -4.0 + 0.017 * f64::from(i);
                // Straight lines over 1.3/16 of a wave are off by (1.3 π/16)²/2 = 3.3 % of its amplitude, the
                // mean over 1/32 by 0.2 %.
                assert!((error.depth(x, unit(x)) - wave(x)).abs() < 0.04 * 2e-6, "{count} {x}");
            }
        }
    }

    #[test]
    fn unusable_measurements_are_named() {
        let even = |count: usize| -> Vec<(f64, f64)> {
            (0..count).map(|i| (TAU * i as f64 / count as f64, 1e-6)).collect()
        };
        assert!(FlankError::from_measured(&even(156), 39).is_ok());
        assert!(matches!(FlankError::from_measured(&even(100), 39), Err(FlankDataError::TooCoarse(0, ..))));
        assert!(matches!(FlankError::from_measured(&[], 39), Err(FlankDataError::TooCoarse(..))));
        let mut points = even(400);
        points[7].0 = points[6].0;
        assert_eq!(FlankError::from_measured(&points, 39), Err(FlankDataError::NotRising(7)));
        let mut points = even(400);
        points.push((TAU, 1e-6));
        assert!(FlankError::from_measured(&points, 39).is_ok());
        points.push((TAU + 0.1, 1e-6));
        assert_eq!(FlankError::from_measured(&points, 39), Err(FlankDataError::MoreThanATurn(401)));
    }

    /// All kinds of terms, orders not sorted: the depth compared with the defining sum of cosines, its slope
    /// with differences of the depth.
    #[test]
    fn reading_agrees_with_the_definition() {
        let profile = Profile::new(40, 64e-3, 1.3e-3, 3e-3);
        let directions = [FlankDirection::Around, FlankDirection::Normal, FlankDirection::Inwards];
        let harmonics: Vec<FlankHarmonic> = [39, 1, 117, 5, 5, 0]
            .into_iter()
            .enumerate()
            .map(|(i, order)| FlankHarmonic {
                order,
                amplitude: 1e-6 * (i + 1) as f64,
                phase: 0.7 * i as f64 - 1.0,
                direction: directions[i % 3],
            })
            .collect();
        let error = FlankError { harmonics: harmonics.clone(), measured: None };
        for i in 0..300 {
            let tau = -3.0 + 0.0417 * f64::from(i);
            let normal = profile.outward_normal(tau);
            let expected: f64 = harmonics
                .iter()
                .map(|h| {
                    let along = match h.direction {
                        FlankDirection::Normal => 1.0,
                        FlankDirection::Inwards => normal.dot(&unit(tau)),
                        FlankDirection::Around => -cross(unit(tau), normal),
                    };
                    along * h.amplitude * (h.order as f64 * (tau - h.phase)).cos()
                })
                .sum();
            assert!((error.depth(tau, normal) - expected).abs() < 1e-18, "{tau}");
            let h = 1e-6;
            let at = |tau: f64| error.depth(tau, profile.outward_normal(tau));
            let difference = (at(tau + h) - at(tau - h)) / (2.0 * h);
            assert!((error.slope(tau, &profile) - difference).abs() < 1e-9, "{tau}");
        }
    }

    /// A flank that is off its centre by d: inwards −d·e(τ), around d·e'(τ) together are the translation,
    /// whose depth is −d·n.
    #[test]
    fn run_out_with_its_pitch_is_a_translation() {
        let profile = Profile::new(40, 64e-3, 1.3e-3, 3e-3);
        let (size, towards) = (1e-6, 0.7);
        let harmonic = |phase, direction| FlankHarmonic { order: 1, amplitude: size, phase, direction };
        // d·e(τ) = size cos(τ − towards); d·e'(τ) = −size sin(τ − towards) = size cos(τ − towards + π/2).
        let harmonics = vec![
            harmonic(towards + PI, FlankDirection::Inwards),
            harmonic(towards - PI / 2.0, FlankDirection::Around),
        ];
        let error = FlankError { harmonics, measured: None };
        for i in 0..200 {
            let tau = 0.0314 * f64::from(i);
            let normal = profile.outward_normal(tau);
            assert!((error.depth(tau, normal) + size * normal.dot(&unit(towards))).abs() < 1e-15);
        }
        // Its slope along the flank is due to the normal alone.
        let (tau, h) = (0.9, 1e-4);
        let turn = (profile.outward_normal(tau + h) - profile.outward_normal(tau - h)) / (2.0 * h);
        assert!(
            (error.slope(tau, &profile) + size * turn.dot(&unit(towards))).abs() < 1e-4 * size * turn.norm()
        );
    }
}
