//! Bounds of free ranges by single gaps, linear in the shift along the eccentric.

/// Steps of golden section search: its interval shrinks to 0.3 % of the clearance.
pub(super) const STEPS: usize = 12;
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Upper or lower bound a − b·x, linear in the shift x along the eccentric.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bound {
    pub at_rest: f64,
    pub per_shift: f64,
}

/// Lower and upper bounds.
pub(super) type Bounds = [Vec<Bound>; 2];

/// Pins along the eccentric bound x only; a tiny lever arm instead of zero has nearly the same effect.
pub(super) fn off_zero(lever: f64) -> f64 {
    if lever.abs() < 1e-12 { 1e-12 } else { lever }
}

/// Drops the bounds on one side that others dominate at every shift within ±reach.
pub(super) fn drop_idle(bounds: &mut Vec<Bound>, side: f64, reach: f64) {
    let variation = |bound: &Bound| bound.per_shift.abs() * reach;
    let least = bounds.iter().map(|b| side * b.at_rest + variation(b)).fold(f64::INFINITY, f64::min);
    bounds.retain(|bound| side * bound.at_rest - variation(bound) <= least);
}

/// Range left by lower and upper bounds at the shift x.
pub(super) fn ends([below, above]: &Bounds, x: f64) -> [f64; 2] {
    let at = |bound: &Bound| bound.at_rest - bound.per_shift * x;
    [
        below.iter().map(at).fold(f64::NEG_INFINITY, f64::max),
        above.iter().map(at).fold(f64::INFINITY, f64::min),
    ]
}

/// Maximum point of a concave function within ±width, by golden section search.
pub(super) fn largest(value: impl Fn(f64) -> f64, width: f64) -> f64 {
    if width == 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (-width, width);
    let inner = |low: f64, high: f64| [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    let [mut left, mut right] = inner(low, high);
    let (mut at_left, mut at_right) = (value(left), value(right));
    for _ in 0..STEPS {
        if at_left < at_right {
            (low, left, at_left) = (left, right, at_right);
            right = inner(low, high)[1];
            at_right = value(right);
        } else {
            (high, right, at_right) = (right, left, at_left);
            left = inner(low, high)[0];
            at_left = value(left);
        }
    }
    0.5 * (low + high)
}
