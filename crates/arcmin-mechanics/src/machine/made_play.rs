//! Backlash of drives of eccentrics with manufacturing errors, from the gaps of all contacts to first order.

mod bounds;
mod places;

use std::f64::consts::TAU;

use self::bounds::{Bounds, STEPS, ends, largest};
use self::places::{RingAt, Side};
use super::{RingPartner, SingleStage, StageErrors, TwoRing, TwoStage, gcd};
use crate::geometry::FlankErrorReader;

/// The gaps of a drive of eccentrics at positions of its input over a turn of the output. All quantities that
/// do not depend on the errors are computed once.
///
/// Every normal of a flank passes through the pitch point of the disc, e n from its centre along the eccentric,
/// n = z_c/m with the tooth difference m. For a disc shifted by x along and y perpendicular to its eccentric
/// and turned by θ, the condition of non-penetration with a fixed ring is g − n_x x − n_y w ≥ 0 for every pin
/// with the gap g, w = y + e n θ; for a ring turned by ψ it is the same with w = y + e n θ − e (z_p/m) ψ. In
/// the eccentric bearing x² + y² is at most the square of the radial clearance. For output pins the condition
/// is h − x − s β ≥ 0 with the clearance h of a pin including errors of position, s = R_w times the sine of its
/// angle from the eccentric, and β the rotation of the output relative to the disc. For a given x, the bounds
/// of w, y and β are the smallest and largest quotients, and the rotation of the output is a linear combination
/// of them; its upper end is concave in x: for a single stage β + (w − y)/(e n), for two rings ((n_2/n_1)(w_1 − y) + y
/// − w_2)/(e (n_2 + 1)). Stages in series add up. Gaps are assumed to be small compared with the eccentricity.
#[derive(Debug, Clone)]
pub struct GapChain {
    /// For every position, the stages in series.
    positions: Vec<Vec<Link>>,
    /// Number of stages, each with its own errors.
    stages: usize,
    /// Depth in m at which the whole tooth is removed.
    deepest: f64,
}

/// Discs that act in parallel at one position.
#[derive(Debug, Clone)]
struct Link {
    /// Rotation of the drive's output per rotation of the output of these discs, absolute value.
    factor: f64,
    discs: Vec<DiscGaps>,
}

/// One disc at one position.
#[derive(Debug, Clone)]
struct DiscGaps {
    disc: usize,
    /// Stage to which its eccentric belongs; eccentricity and diametral clearance in m.
    stage: usize,
    eccentricity: f64,
    clearance: f64,
    /// Rotation of the output per displacement of the disc perpendicular to its eccentric, rad/m.
    across: f64,
    sides: Vec<Side>,
}

/// Interference of a drive that can be assembled by force only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// Depth in m by which all flanks and walls of holes would have to be reduced so that the drive can be
    /// assembled at every position. The contacts have to deform elastically by this depth.
    pub depth: f64,
    /// Contacts with interference.
    pub place: OverlapPlace,
}

/// Contacts whose reduction alone removes the interference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OverlapPlace {
    /// Ring pins and flanks.
    Ring,
    /// Output pins and holes.
    Output,
    /// The reduction of neither alone is sufficient.
    Both,
}

impl OverlapPlace {
    /// All of them, in the order of their declaration.
    pub const ALL: [OverlapPlace; 3] = [OverlapPlace::Ring, OverlapPlace::Output, OverlapPlace::Both];

    /// Words for messages, with those of the ring.
    pub fn words(self, ring: RingPartner) -> &'static str {
        match (self, ring) {
            (OverlapPlace::Ring, _) => ring.all_of_ring(),
            (OverlapPlace::Output, _) => "output pins",
            (OverlapPlace::Both, RingPartner::Pins) => "ring and output pins",
            (OverlapPlace::Both, RingPartner::Teeth) => "ring teeth and output pins",
            (OverlapPlace::Both, RingPartner::Both) => "ring pins, ring teeth and output pins",
        }
    }
}

/// First depth in m of the search, and number of bisections of an interference: to 1 %.
const FINEST: f64 = 1e-8;
const HALVINGS: usize = 7;

/// Number of positions over the turns of a period: the first of these primes that divides none of the numbers
/// of teeth, so that the phases of eccentrics and rings are distributed as well.
const POSITIONS: [usize; 8] = [31, 37, 41, 43, 47, 53, 59, 61];
/// Penalty factor of interference relative to rotation, where both enter one objective function.
const STIFF: f64 = 1e6;

/// Angles (rad) of the input over a number of its turns, for a drive with these numbers of teeth.
fn input_angles(turns: usize, teeth: &[usize]) -> Vec<f64> {
    let divides = |count: usize| teeth.iter().any(|teeth| teeth.is_multiple_of(count));
    let count = POSITIONS.into_iter().find(|count| !divides(*count)).unwrap_or(POSITIONS[0]);
    (0..count).map(|k| TAU * (turns * k) as f64 / count as f64).collect()
}

/// For each stage and disc; `None` for a flank without error.
type Readers = Vec<Vec<Option<FlankErrorReader>>>;

impl GapChain {
    /// For a single stage, at positions over a turn of the output.
    pub fn new(stage: &SingleStage) -> GapChain {
        GapChain::at(stage, &input_angles(stage.turns_to_repeat(), &[stage.profile.lobe_count()]))
    }

    /// For a single stage, at angles of the input in rad.
    pub fn at(stage: &SingleStage, angles: &[f64]) -> GapChain {
        let positions = angles.iter().map(|angle| vec![Link::of(stage, 0, *angle, 1.0)]).collect();
        GapChain { positions, stages: 1, deepest: stage.profile.eccentricity }
    }

    /// For two rings, at positions over the turns of the input after which all parts return to their positions.
    pub fn of_two_rings(drive: &TwoRing) -> GapChain {
        let [first, second] = drive.meshes.each_ref().map(|mesh| mesh.profile.lobe_count());
        let [pins, others] = drive.meshes.each_ref().map(|mesh| mesh.profile.pin_count);
        let turns = drive.turns_to_repeat();
        let teeth = [first, second, pins, others, turns, drive.teeth_apart()];
        GapChain::of_two_rings_at(drive, &input_angles(turns, &teeth))
    }

    /// For two rings, at angles of the input in rad.
    pub fn of_two_rings_at(drive: &TwoRing, angles: &[f64]) -> GapChain {
        let at = |angle: f64| {
            let discs = (0..drive.phases.len()).map(|disc| DiscGaps::of_two_rings(drive, angle, disc));
            vec![Link { factor: 1.0, discs: discs.collect() }]
        };
        let positions = angles.iter().map(|angle| at(*angle)).collect();
        GapChain { positions, stages: 2, deepest: drive.meshes[0].profile.eccentricity }
    }

    /// For two stages, at positions over a turn of the output.
    pub fn of_two_stages(drive: &TwoStage) -> GapChain {
        let [first, second] = [&drive.first, &drive.second].map(|stage| stage.profile.lobe_count());
        let [pins, others] = [&drive.first, &drive.second].map(|stage| stage.profile.pin_count);
        let turns = drive.first.turns_to_repeat() * drive.second.turns_to_repeat();
        GapChain::of_two_stages_at(drive, &input_angles(turns, &[first, second, pins, others]))
    }

    /// For two stages, at angles of the input in rad.
    pub fn of_two_stages_at(drive: &TwoStage, angles: &[f64]) -> GapChain {
        let TwoStage { first, second } = drive;
        let factor = 1.0 / second.ratio().abs();
        let at = |angle: f64| {
            vec![Link::of(first, 0, angle, factor), Link::of(second, 1, angle / first.ratio(), 1.0)]
        };
        GapChain {
            positions: angles.iter().map(|angle| at(*angle)).collect(),
            stages: 2,
            deepest: first.profile.eccentricity.max(second.profile.eccentricity),
        }
    }

    /// The same chain with the rotation of the output multiplied by a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> GapChain {
        self.positions.iter_mut().flatten().for_each(|link| link.factor *= factor);
        self
    }

    /// Smallest two-sided backlash over the positions in rad at the output with the input held, for errors of
    /// each stage. `None` if the drive cannot be assembled without force: at some position, no pose of the
    /// discs leaves all gaps open.
    pub fn least(&self, errors: &[StageErrors]) -> Option<f64> {
        self.least_with(errors, &self.readers(errors), [0.0; 2])
    }

    /// Whether a drive can be assembled after these depths (m) are removed from all flanks and from the walls
    /// of all holes.
    pub fn can_be_assembled(&self, errors: &[StageErrors], off: [f64; 2]) -> bool {
        self.least_with(errors, &self.readers(errors), off).is_some()
    }

    /// The interference of a drive that jams; `None` for others. Its place is the contact whose reduction alone
    /// requires the smaller depth; both, if neither alone is sufficient.
    pub fn overlap(&self, errors: &[StageErrors]) -> Option<Overlap> {
        let readers = self.readers(errors);
        let goes = |off: [f64; 2]| self.least_with(errors, &readers, off).is_some();
        if goes([0.0; 2]) {
            return None;
        }
        let depth = self.least_depth(|depth| goes([depth; 2])).unwrap_or(self.deepest);
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

    /// The smallest depth (m) at which a drive that jams can be assembled; `None` if a depth of the
    /// eccentricity is not sufficient.
    fn least_depth(&self, goes: impl Fn(f64) -> bool) -> Option<f64> {
        let (mut low, mut high) = (0.0, FINEST);
        while !goes(high) {
            (low, high) = (high, 2.0 * high);
            if high > self.deepest {
                return None;
            }
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if goes(middle) { high = middle } else { low = middle }
        }
        Some(high)
    }

    fn readers(&self, errors: &[StageErrors]) -> Readers {
        let of_stage = |errors: &StageErrors| {
            let flanks = errors.flanks.iter();
            flanks.map(|error| (!error.is_zero()).then(|| FlankErrorReader::new(error))).collect()
        };
        errors.iter().map(of_stage).collect()
    }

    /// As [`GapChain::least`], with these depths (m) removed from all flanks and from the walls of all holes.
    fn least_with(&self, errors: &[StageErrors], readers: &Readers, off: [f64; 2]) -> Option<f64> {
        self.positions.iter().try_fold(f64::INFINITY, |least, links| {
            let play = links.iter().try_fold(0.0, |play, link| {
                let ends =
                    link.discs.iter().try_fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], disc| {
                        let [down, up] = disc.ends(errors, readers, off)?;
                        Some([low.max(down), high.min(up)])
                    });
                let [low, high] = ends?;
                (high >= low).then_some(play + link.factor * (high - low))
            });
            Some(least.min(play?))
        })
    }

    /// For each stage, the mean over positions and discs of the contribution of errors to the ring gaps that
    /// limit the disc, and to the clearance of the output pins, m; 0 without output pins.
    pub fn mean_gaps(&self, errors: &[StageErrors]) -> Vec<[f64; 2]> {
        let readers = self.readers(errors);
        let mut sums = vec![[[0.0; 2]; 2]; self.stages];
        for disc in self.positions.iter().flatten().flat_map(|link| &link.discs) {
            for side in &disc.sides {
                let reader = reader(&readers, side.stage, disc.disc);
                let added = side.added(disc.disc, &errors[side.stage], reader);
                for (sum, added) in sums[side.stage].iter_mut().zip(added) {
                    *sum = [sum[0] + added[0], sum[1] + added[1]];
                }
            }
        }
        let mean = |[sum, weight]: [f64; 2]| if weight > 0.0 { sum / weight } else { 0.0 };
        sums.into_iter().map(|both| both.map(mean)).collect()
    }
}

fn reader(readers: &Readers, stage: usize, disc: usize) -> Option<&FlankErrorReader> {
    readers[stage].get(disc).and_then(Option::as_ref)
}

impl Link {
    /// One stage at an angle (rad) of its input.
    fn of(stage: &SingleStage, number: usize, angle: f64, factor: f64) -> Link {
        let discs = (0..stage.phases.len()).map(|disc| DiscGaps::of(stage, number, angle, disc));
        Link { factor, discs: discs.collect() }
    }
}

impl DiscGaps {
    fn of(stage: &SingleStage, number: usize, angle: f64, disc: usize) -> DiscGaps {
        let output = -angle / stage.profile.lobes_per_turn();
        let eccentric = angle + stage.phases[disc];
        let at = RingAt {
            mesh: &stage.mesh,
            first: 0,
            first_pin: 0.0,
            body: 0.0,
            eccentric,
            disc: output + stage.mounting(disc),
        };
        let turn = 1.0 / stage.lever();
        DiscGaps {
            disc,
            stage: number,
            eccentricity: stage.profile.eccentricity,
            clearance: stage.eccentric.clearance,
            across: -turn,
            sides: vec![
                Side::ring(number, turn, &at),
                Side::output(number, &stage.output_pins, output, eccentric),
            ],
        }
    }

    fn of_two_rings(drive: &TwoRing, angle: f64, disc: usize) -> DiscGaps {
        let [first, second] = &drive.meshes;
        let [lobes, others] = drive.lobes_per_turn();
        let (output, row) = (angle / drive.ratio(), drive.row(disc));
        let eccentric = angle + drive.phases[disc];
        let turn = -angle / lobes - drive.phases[disc] / others;
        let pins = first.profile.pin_count;
        let at_rest =
            RingAt { mesh: first, first: disc * pins, first_pin: row, body: 0.0, eccentric, disc: turn };
        let turning =
            RingAt { mesh: second, first: 0, first_pin: output, body: output, eccentric, disc: turn };
        let per = 1.0 / (first.profile.eccentricity * second.profile.pins_per_turn());
        DiscGaps {
            disc,
            stage: 0,
            eccentricity: first.profile.eccentricity,
            clearance: drive.eccentric.clearance,
            across: per * (1.0 - others / lobes),
            sides: vec![Side::ring(0, per * others / lobes, &at_rest), Side::ring(1, -per, &turning)],
        }
    }

    /// Smallest and largest rotation of the output in rad that one disc allows.
    fn ends(&self, errors: &[StageErrors], readers: &Readers, off: [f64; 2]) -> Option<[f64; 2]> {
        let own = &errors[self.stage];
        let eccentric = own.eccentric(self.disc);
        let across = self.eccentricity * eccentric.phase;
        let clearance = 0.5 * (self.clearance + own.eccentric_clearance(self.disc)).max(0.0);
        let reach = clearance + eccentric.eccentricity.abs();
        let bounds = |side: &Side| {
            let reader = reader(readers, side.stage, self.disc);
            (side.weight, side.bounds(self.disc, &errors[side.stage], reader, off, reach))
        };
        let bounds: Vec<(f64, Bounds)> = self.sides.iter().map(bounds).collect();
        let evaluate = |shift: f64, side: f64| {
            let x = shift + eccentric.eccentricity;
            let free = (clearance * clearance - shift * shift).max(0.0).sqrt();
            let (mut turn, mut open) =
                (self.across.abs() * free + side * self.across * across, f64::INFINITY);
            for (weight, bounds) in &bounds {
                let [low, high] = ends(bounds, x);
                turn += side * weight * if side * weight > 0.0 { high } else { low };
                open = open.min(weight.abs() * (high - low));
            }
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
            // The optimum may lie at the edge of the feasible range, and numerically outside of it: bisection
            // towards the point with the largest gaps.
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

impl TwoRing {
    /// |z_c1 m_2 − z_c2 m_1| with the tooth differences m.
    pub fn teeth_apart(&self) -> usize {
        let [first, second] = self.meshes.each_ref().map(|mesh| &mesh.profile);
        (first.lobe_count() * second.tooth_difference).abs_diff(second.lobe_count() * first.tooth_difference)
    }

    /// Turns of the input after which eccentrics, discs and output return to their positions: discs after
    /// z_c1/gcd(z_c1, m_1), the output after z_c1 z_p2/gcd(z_c1 z_p2, z_c1 m_2 − z_c2 m_1).
    pub fn turns_to_repeat(&self) -> usize {
        let [first, second] = self.meshes.each_ref().map(|mesh| &mesh.profile);
        let lobes = first.lobe_count();
        let discs = lobes / gcd(lobes, first.tooth_difference);
        let teeth = lobes * second.pin_count;
        let output = teeth / gcd(teeth, self.teeth_apart());
        discs / gcd(discs, output) * output
    }
}
