//! Play of a single stage as made, from the gaps of every pin to first order.

use std::f64::consts::TAU;

use super::{RunOut, SingleStage, StageErrors};
use crate::geometry::{FlankErrorReader, Vec2, cross, quarter_turn, turned, unit};

/// The gaps of a single stage at positions of its input over a turn of the output, with all that does not depend on its
/// errors computed once.
///
/// Every normal of the flank passes through the pitch point of the disc, e z_c from its centre along the eccentric. A disc
/// that is shifted by x along and y across its eccentric and turned by θ therefore keeps to the ring where
/// g − n_x x − n_y w ≥ 0 for every pin with the gap g, w = y + e z_c θ. The eccentric bearing lets x² + y² be at most the
/// square of its radial clearance. Output pins press along the eccentric: h − x − s β ≥ 0, h the clearance of a pin with the
/// errors of place, s = R_w times the sine of its place from the eccentric, β the turn of output against disc. For one x the
/// ends of w, y and β are least and largest quotients, and the turn of the output, β + (w − y)/(e z_c), is convex in x. Gaps
/// are small against the eccentricity.
#[derive(Debug, Clone)]
pub struct GapChain {
    stage: SingleStage,
    /// e z_c in m.
    lever: f64,
    /// For every position, for every disc.
    stations: Vec<Vec<Station>>,
}

/// By how much a drive overlaps that goes together by force only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// Depth in m that would have to come off all flanks and walls of holes alike for the drive to go together at every
    /// position: what contacts that share the force have to give way.
    pub depth: f64,
    pub place: OverlapPlace,
}

/// Which of them is enough.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OverlapPlace {
    /// Ring pins and flanks.
    Ring,
    /// Output pins and holes.
    Output,
    /// Neither alone.
    Both,
}

impl OverlapPlace {
    pub const ALL: [OverlapPlace; 3] = [OverlapPlace::Ring, OverlapPlace::Output, OverlapPlace::Both];

    pub fn words(self) -> &'static str {
        match self {
            OverlapPlace::Ring => "ring pins",
            OverlapPlace::Output => "output pins",
            OverlapPlace::Both => "ring and output pins",
        }
    }
}

/// First depth in m that is tried, and how often the interval about an overlap is halved: to 1 %.
const FINEST: f64 = 1e-8;
const HALVINGS: usize = 7;

/// One disc at one position.
#[derive(Debug, Clone)]
struct Station {
    /// Direction of the eccentric in rad.
    eccentric: f64,
    ring: Vec<RingPlace>,
    output: Vec<OutputPlace>,
}

/// One ring pin.
#[derive(Debug, Clone, Copy)]
struct RingPlace {
    /// Gap as designed, m.
    gap: f64,
    /// Normal from flank to pin, along and across the eccentric.
    normal: Vec2,
    /// Outward and counter-clockwise parts of the normal at the pin.
    outward: f64,
    around: f64,
    /// Place on the flank: angle on the disc, its unit vector, and the normal there.
    tau: f64,
    on_disc: [Vec2; 2],
}

/// One output pin.
#[derive(Debug, Clone, Copy)]
struct OutputPlace {
    /// Parts of the eccentric's direction outward and counter-clockwise at the pin.
    outward: f64,
    around: f64,
}

/// a − b·x bounds what is above it from below or above, x the shift along the eccentric.
#[derive(Debug, Clone, Copy)]
struct Bound {
    at_rest: f64,
    per_shift: f64,
}

/// Bounds of one disc on one side and the other.
#[derive(Debug, Default)]
struct Bounds {
    ring: [Vec<Bound>; 2],
    output: [Vec<Bound>; 2],
}

/// Positions over a turn of the output, a prime so that the phases of the eccentric are spread over its turn as well.
const POSITIONS: [usize; 2] = [31, 37];
/// Steps of the golden section: its interval falls to 0.3 % of the clearance.
const STEPS: usize = 12;
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Weight of interference against play where both are looked for.
const STIFF: f64 = 1e6;

impl GapChain {
    /// At positions over a turn of the output.
    pub fn new(stage: &SingleStage) -> GapChain {
        let lobes = stage.profile.lobe_count();
        let [usual, other] = POSITIONS;
        let count = if lobes.is_multiple_of(usual) { other } else { usual };
        let angles: Vec<f64> = (0..count).map(|k| TAU * (lobes * k) as f64 / count as f64).collect();
        GapChain::at(stage, &angles)
    }

    /// At angles of the input in rad.
    pub fn at(stage: &SingleStage, angles: &[f64]) -> GapChain {
        let lever = stage.lever();
        let discs = 0..stage.phases.len();
        let stations =
            angles.iter().map(|angle| discs.clone().map(|disc| Station::of(stage, *angle, disc)).collect());
        GapChain { stations: stations.collect(), lever, stage: stage.clone() }
    }

    /// Two-sided play in rad at the output with the input held, the least over the positions. `None` for a drive that cannot
    /// be put together without force: at some position no place of the discs leaves all gaps open.
    pub fn least(&self, errors: &StageErrors) -> Option<f64> {
        self.least_with(errors, [0.0; 2])
    }

    /// The overlap of a drive that jams; `None` for others. It is at the pins where the smaller depth off them alone lets the
    /// drive go together, at both where no such depth does.
    pub fn overlap(&self, errors: &StageErrors) -> Option<Overlap> {
        let goes = |off: [f64; 2]| self.least_with(errors, off).is_some();
        if goes([0.0; 2]) {
            return None;
        }
        let depth = self.least_depth(|depth| goes([depth; 2])).unwrap_or(self.stage.profile.eccentricity);
        let ring = self.least_depth(|depth| goes([depth, 0.0]));
        let output = self.least_depth(|depth| goes([0.0, depth]));
        let place = match (ring, output) {
            (None, None) => OverlapPlace::Both,
            (Some(ring), Some(output)) if output < ring => OverlapPlace::Output,
            (None, Some(_)) => OverlapPlace::Output,
            (Some(_), _) => OverlapPlace::Ring,
        };
        Some(Overlap { depth, place })
    }

    /// The least depth (m) at which a drive that jams goes together; `None` where it does not with teeth as deep as the
    /// eccentricity off.
    fn least_depth(&self, goes: impl Fn(f64) -> bool) -> Option<f64> {
        let (mut low, mut high) = (0.0, FINEST);
        while !goes(high) {
            (low, high) = (high, 2.0 * high);
            if high > self.stage.profile.eccentricity {
                return None;
            }
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if goes(middle) { high = middle } else { low = middle }
        }
        Some(high)
    }

    /// As [`GapChain::least`], with depths (m) off all flanks and off the walls of all holes.
    fn least_with(&self, errors: &StageErrors, off: [f64; 2]) -> Option<f64> {
        let readers: Vec<Option<FlankErrorReader>> = (0..self.stage.phases.len())
            .map(|disc| errors.flanks.get(disc).filter(|error| !error.is_zero()).map(FlankErrorReader::new))
            .collect();
        self.stations.iter().try_fold(f64::INFINITY, |least, discs| {
            let ends = discs.iter().enumerate().try_fold(
                [f64::NEG_INFINITY, f64::INFINITY],
                |[low, high], (disc, station)| {
                    let [down, up] = self.ends(station, disc, errors, (readers[disc].as_ref(), off))?;
                    Some([low.max(down), high.min(up)])
                },
            );
            let [low, high] = ends?;
            (high >= low).then_some(least.min(high - low))
        })
    }

    /// Mean over positions and discs of what the errors add to the gaps that stop the disc in the ring, and to the
    /// clearance of the output pins, m.
    pub fn mean_gaps(&self, errors: &StageErrors) -> [f64; 2] {
        let (mut ring, mut weight, mut output, mut count) = (0.0, 0.0, 0.0, 0.0);
        for (disc, station) in self.stations.iter().flat_map(|discs| discs.iter().enumerate()) {
            let reader = errors.flanks.get(disc).map(FlankErrorReader::new);
            let off = station.off(errors);
            for (pin, place) in station.ring.iter().enumerate() {
                let lever = place.normal.y * place.normal.y;
                ring += lever * (place.made(pin, off, errors, reader.as_ref()) - place.gap);
                weight += lever;
            }
            for pin in 0..station.output.len() {
                output += 0.5 * errors.hole(disc, pin).diameter - errors.output_pin(pin).radius;
                count += 1.0;
            }
        }
        [ring / weight, output / count]
    }

    /// Least and largest turn of the output in rad that one disc leaves it.
    fn ends(
        &self,
        station: &Station,
        disc: usize,
        errors: &StageErrors,
        (reader, [off_flanks, off_holes]): (Option<&FlankErrorReader>, [f64; 2]),
    ) -> Option<[f64; 2]> {
        let (mut bounds, off) = (Bounds::default(), station.off(errors));
        for (pin, place) in station.ring.iter().enumerate() {
            let gap = place.made(pin, off, errors, reader) + off_flanks;
            let across = off_zero(place.normal.y);
            let bound = Bound { at_rest: gap / across, per_shift: place.normal.x / across };
            bounds.ring[usize::from(across > 0.0)].push(bound);
        }
        let pins = &self.stage.output_pins;
        for (pin, place) in station.output.iter().enumerate() {
            let (own, hole) = (errors.output_pin(pin), errors.hole(disc, pin));
            let clearance = pins.hole_clearance + off_holes + 0.5 * hole.diameter - own.radius
                + place.outward * (own.radial - hole.radial)
                + place.around * (own.tangential - hole.tangential);
            // A pin ahead of the eccentric turns into the hole's wall.
            let lever = off_zero(-place.around) * pins.circle_radius;
            let bound = Bound { at_rest: clearance / lever, per_shift: 1.0 / lever };
            bounds.output[usize::from(lever > 0.0)].push(bound);
        }
        let eccentric = errors.eccentric(disc);
        let across = self.stage.profile.eccentricity * eccentric.phase;
        let clearance = 0.5 * (self.stage.eccentric.clearance + errors.eccentric_clearance(disc)).max(0.0);
        let reach = clearance + eccentric.eccentricity.abs();
        for [below, above] in [&mut bounds.ring, &mut bounds.output] {
            drop_idle(below, -1.0, reach);
            drop_idle(above, 1.0, reach);
        }
        let evaluate = |shift: f64, side: f64| {
            let x = shift + eccentric.eccentricity;
            let [ring_low, ring_high] = ends(&bounds.ring, x);
            let [pins_low, pins_high] = ends(&bounds.output, x);
            let (ring, pins) = if side > 0.0 { (ring_high, pins_high) } else { (-ring_low, -pins_low) };
            let free = (clearance * clearance - shift * shift).max(0.0).sqrt();
            let turn = pins + (ring + free - side * across) / self.lever;
            let open = ((ring_high - ring_low) / self.lever).min(pins_high - pins_low);
            (turn, open)
        };
        let end = |side: f64| {
            let value = |shift: f64| {
                let (turn, open) = evaluate(shift, side);
                turn + STIFF * open.min(0.0)
            };
            let shift = largest(value, clearance);
            let (turn, open) = evaluate(shift, side);
            if open >= 0.0 {
                return Some(turn);
            }
            // The best shift may lie where the gaps end, and just beyond it: back to there from where they are widest.
            let mut inside = largest(|shift| evaluate(shift, side).1, clearance);
            if evaluate(inside, side).1 < 0.0 {
                return None;
            }
            let mut outside = shift;
            for _ in 0..STEPS {
                let middle = 0.5 * (inside + outside);
                if evaluate(middle, side).1 < 0.0 { outside = middle } else { inside = middle }
            }
            Some(evaluate(inside, side).0)
        };
        Some([-end(-1.0)?, end(1.0)?])
    }
}

impl Station {
    fn of(stage: &SingleStage, angle: f64, disc: usize) -> Station {
        let (profile, lobes) = (&stage.profile, stage.profile.lobe_count() as f64);
        let output = -angle / lobes;
        let (eccentric, turn) = (angle + stage.phases[disc], output + stage.mounting(disc));
        let e = unit(eccentric);
        let ring = (0..profile.pin_count).map(|pin| {
            let place = TAU * pin as f64 / profile.pin_count as f64;
            let tau = place - turn;
            let on_disc = profile.outward_normal(tau);
            let (normal, outward) = (turned(on_disc, unit(turn)), unit(place));
            RingPlace {
                gap: stage.gap(profile.meshing_angle(tau)),
                normal: Vec2::new(normal.dot(&e), cross(e, normal)),
                outward: normal.dot(&outward),
                around: normal.dot(&quarter_turn(outward)),
                tau,
                on_disc: [unit(tau), on_disc],
            }
        });
        let pins = stage.output_pins.count;
        let output = (0..pins).map(|pin| {
            let outward = unit(TAU * pin as f64 / pins as f64 + output);
            OutputPlace { outward: e.dot(&outward), around: e.dot(&quarter_turn(outward)) }
        });
        Station { eccentric, ring: ring.collect(), output: output.collect() }
    }

    /// Centre of the pin circle along and across the eccentric, m.
    fn off(&self, errors: &StageErrors) -> Vec2 {
        let RunOut { amplitude, phase } = errors.pin_circle_offset;
        amplitude * unit(phase - self.eccentric)
    }
}

impl RingPlace {
    /// Gap with the errors of pin and flank, the disc in its nominal place; `off` is that of the whole ring.
    fn made(&self, pin: usize, off: Vec2, errors: &StageErrors, reader: Option<&FlankErrorReader>) -> f64 {
        let own = errors.pin(pin);
        let [place, normal] = self.on_disc;
        self.gap + self.outward * own.radial + self.around * own.tangential + self.normal.dot(&off)
            - own.radius
            + reader.map_or(0.0, |reader| reader.depth(self.tau, place, normal))
    }
}

/// Pins along the eccentric bound x alone, which hardly any lever does as well.
fn off_zero(lever: f64) -> f64 {
    if lever.abs() < 1e-12 { 1e-12 } else { lever }
}

/// Drops the bounds on one side that others outdo at every shift within ±reach.
fn drop_idle(bounds: &mut Vec<Bound>, side: f64, reach: f64) {
    let spread = |bound: &Bound| bound.per_shift.abs() * reach;
    let least = bounds.iter().map(|b| side * b.at_rest + spread(b)).fold(f64::INFINITY, f64::min);
    bounds.retain(|bound| side * bound.at_rest - spread(bound) <= least);
}

/// Least and largest value that the bounds on one side and the other leave.
fn ends([below, above]: &[Vec<Bound>; 2], x: f64) -> [f64; 2] {
    let at = |bound: &Bound| bound.at_rest - bound.per_shift * x;
    [
        below.iter().map(at).fold(f64::NEG_INFINITY, f64::max),
        above.iter().map(at).fold(f64::INFINITY, f64::min),
    ]
}

/// Where a function that bends downwards is largest within ±width, by the golden section.
fn largest(value: impl Fn(f64) -> f64, width: f64) -> f64 {
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
