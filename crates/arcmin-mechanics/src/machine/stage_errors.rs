//! Deviations of one single stage from its drawing, and the tolerances from which they are drawn at random.

use super::tolerances::Draw;
use super::{Batch, BoreError, EccentricError, PinError, RunOut, SingleStage};
use crate::geometry::{FlankDirection, FlankError, FlankHarmonic};

/// Deviations of one single stage; all zero for the nominal one. Lists may be shorter than the drive has parts:
/// parts without an entry have no error.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StageErrors {
    /// Added to the distance of every ring pin from the centre, m.
    pub pin_circle_radius: f64,
    /// Added to the radius of every ring pin, m.
    pub pin_radius: f64,
    /// Centre of the pin circle relative to the axis of input and output.
    pub pin_circle_offset: RunOut,
    /// For each ring pin.
    pub pins: Vec<PinError>,
    /// For each disc, relative to the axis of its eccentric bearing.
    pub flanks: Vec<FlankError>,
    /// For each disc.
    pub eccentrics: Vec<EccentricError>,
    /// For each disc, added to the diametral clearance of the eccentric bearing, m.
    pub eccentric_clearances: Vec<f64>,
    /// Added to the distance of every output pin from the axis, m.
    pub output_pin_circle_radius: f64,
    /// Added to the radius of every output pin or roller, m.
    pub output_pin_radius: f64,
    /// For each output pin; the radius is that of the roller.
    pub output_pins: Vec<PinError>,
    /// For each disc and output pin.
    pub holes: Vec<Vec<BoreError>>,
}

/// Tolerances of a single stage, ± in m (rad for phases); zero where a part is exact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StageTolerances {
    /// Position of every ring pin, radial and tangential.
    pub pin_position: f64,
    /// Radius of every ring pin.
    pub pin_radius: f64,
    /// Radius of the pin circle.
    pub pin_circle_radius: f64,
    /// Centre of the pin circle relative to the axis of input and output.
    pub pin_circle_offset: f64,
    /// Offset of the flanks, common to all discs.
    pub flank_offset: f64,
    /// Radial run-out of every flank relative to the bore of its disc.
    pub flank_run_out: f64,
    /// Cumulative pitch of every flank, spread over its orders 2 to 7.
    pub flank_pitch: f64,
    /// Profile error, common to all lobes of a disc.
    pub flank_profile: f64,
    /// Distance of every eccentric from the axis of the shaft.
    pub eccentricity: f64,
    /// rad.
    pub eccentric_phase: f64,
    /// Diametral clearance of every eccentric bearing.
    pub eccentric_clearance: f64,
    /// Radius of the circle of the output pins.
    pub output_pin_circle_radius: f64,
    /// Position of every output pin, radial and tangential.
    pub output_pin_position: f64,
    /// Radius of every output pin or roller.
    pub output_pin_radius: f64,
    /// Position of every hole, radial and tangential.
    pub bore_position: f64,
    /// Diameter of every hole for an output pin.
    pub bore_diameter: f64,
    /// Deviation of the hole diameter, common to all discs.
    pub bore_offset: f64,
    /// Rotation of every flank on its disc, as an arc length at the lobes.
    pub flank_turn: f64,
    /// Mean values of the deviations.
    pub offsets: StageOffsets,
}

/// Systematic deviations, common to all drives, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StageOffsets {
    /// Added to the diameter of every hole of an output pin.
    pub hole_diameter: f64,
    /// Depth of missing material on all flanks.
    pub flank: f64,
    /// Distance by which the first layer of a printed disc projects from flank and holes.
    pub elephant_foot: f64,
    /// Added to the distance of every ring pin from the centre.
    pub pin_circle_radius: f64,
    /// Added to the diametral clearance of every eccentric bearing.
    pub eccentric_clearance: f64,
}

/// Number of parts of a stage that have errors of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartCounts {
    /// Discs of the stage.
    pub discs: usize,
    /// Ring pins of all rows, if each disc has its own row.
    pub ring_pins: usize,
    /// Lobes of one disc.
    pub lobes: usize,
    /// Output pins, each with a hole in every disc.
    pub output_pins: usize,
}

impl SingleStage {
    /// Part counts for a draw of [`StageErrors`].
    pub fn part_counts(&self) -> PartCounts {
        PartCounts {
            discs: self.phases.len(),
            ring_pins: self.profile.pin_count,
            lobes: self.profile.lobe_count(),
            output_pins: self.output_pins.count,
        }
    }
}

impl StageErrors {
    /// One drive drawn at random from the tolerances of its stages, as one of a batch if given; see
    /// [`ManufacturingErrors::draw`](super::ManufacturingErrors::draw) and `draw_from_batch`.
    pub fn draw(
        stages: &[(PartCounts, StageTolerances)],
        seed: u64,
        batch: Option<Batch>,
    ) -> Vec<StageErrors> {
        let mut draw = Draw::new(seed, batch);
        stages
            .iter()
            .map(|(counts, tolerances)| StageErrors::of_stage(&mut draw, *counts, tolerances))
            .collect()
    }

    fn of_stage(draw: &mut Draw, counts: PartCounts, t: &StageTolerances) -> StageErrors {
        let PartCounts { discs, ring_pins: pins, lobes, output_pins } = counts;
        let mut errors = StageErrors {
            pin_circle_radius: draw.deviate(t.pin_circle_radius),
            pin_circle_offset: draw.run_out(t.pin_circle_offset),
            output_pin_circle_radius: draw.deviate(t.output_pin_circle_radius),
            ..StageErrors::default()
        };
        let depth = FlankHarmonic {
            order: 0,
            amplitude: draw.deviate(t.flank_offset),
            phase: 0.0,
            direction: FlankDirection::Normal,
        };
        let holes = draw.deviate(t.bore_offset);
        errors.pins = (0..pins).map(|_| draw.pin(t.pin_position, t.pin_radius)).collect();
        errors.output_pins =
            (0..output_pins).map(|_| draw.pin(t.output_pin_position, t.output_pin_radius)).collect();
        for _ in 0..discs {
            errors.eccentrics.push(draw.eccentric(t.eccentricity, t.eccentric_phase));
            errors.eccentric_clearances.push(draw.deviate(t.eccentric_clearance));
            let mut hole = || {
                let bore = draw.bore(t.bore_position, t.bore_diameter);
                BoreError { diameter: bore.diameter + holes, ..bore }
            };
            errors.holes.push((0..output_pins).map(|_| hole()).collect());
            let mut harmonics = vec![depth, draw.flank_run_out(t.flank_run_out)];
            harmonics.extend(draw.pitch_and_profile(t.flank_pitch, t.flank_profile, lobes));
            errors.flanks.push(FlankError { harmonics, measured: None });
        }
        // Errors introduced later are drawn last, so that a seed still gives the same values for earlier ones.
        for flank in &mut errors.flanks {
            flank.harmonics.push(FlankHarmonic {
                order: 0,
                amplitude: draw.deviate(t.flank_turn),
                phase: 0.0,
                direction: FlankDirection::Around,
            });
            flank.harmonics.retain(|harmonic| harmonic.amplitude != 0.0);
        }
        errors.shift(counts, &t.offsets);
        errors
    }

    /// A stage with the systematic deviations of all parts, without random ones.
    pub fn systematic(counts: PartCounts, offsets: &StageOffsets) -> StageErrors {
        let mut errors = StageErrors::default();
        errors.shift(counts, offsets);
        errors
    }

    /// Adds systematic deviations.
    fn shift(&mut self, counts: PartCounts, offsets: &StageOffsets) {
        if *offsets == StageOffsets::default() {
            return;
        }
        let (discs, pins) = (counts.discs, counts.output_pins);
        let StageOffsets { hole_diameter, flank, elephant_foot, pin_circle_radius, eccentric_clearance } =
            *offsets;
        self.pin_circle_radius += pin_circle_radius;
        self.holes.resize(discs, Vec::new());
        self.flanks.resize(discs, FlankError::default());
        self.eccentric_clearances.resize(discs, 0.0);
        for disc in 0..discs {
            self.holes[disc].resize(pins, BoreError::default());
            for hole in &mut self.holes[disc] {
                hole.diameter += hole_diameter - 2.0 * elephant_foot;
            }
            self.eccentric_clearances[disc] += eccentric_clearance;
            let amplitude = flank - elephant_foot;
            if amplitude != 0.0 {
                let direction = FlankDirection::Normal;
                self.flanks[disc].harmonics.push(FlankHarmonic {
                    order: 0,
                    amplitude,
                    phase: 0.0,
                    direction,
                });
            }
        }
    }

    /// Error of a ring pin, including the deviations common to all pins.
    pub fn pin(&self, pin: usize) -> PinError {
        let own = self.pins.get(pin).copied().unwrap_or_default();
        PinError {
            radial: own.radial + self.pin_circle_radius,
            tangential: own.tangential,
            radius: own.radius + self.pin_radius,
        }
    }

    /// Error of an output pin, including the deviations common to all pins.
    pub fn output_pin(&self, pin: usize) -> PinError {
        let own = self.output_pins.get(pin).copied().unwrap_or_default();
        PinError {
            radial: own.radial + self.output_pin_circle_radius,
            tangential: own.tangential,
            radius: own.radius + self.output_pin_radius,
        }
    }

    /// Error of one hole; zero where it is not listed.
    pub fn hole(&self, disc: usize, pin: usize) -> BoreError {
        self.holes.get(disc).and_then(|holes| holes.get(pin)).copied().unwrap_or_default()
    }

    /// Error of the eccentric of one disc; zero where it is not listed.
    pub fn eccentric(&self, disc: usize) -> EccentricError {
        self.eccentrics.get(disc).copied().unwrap_or_default()
    }

    /// Change of the diametral clearance of one eccentric bearing, m; zero where it is not listed.
    pub fn eccentric_clearance(&self, disc: usize) -> f64 {
        self.eccentric_clearances.get(disc).copied().unwrap_or_default()
    }

    /// Whether all ring pins and all discs have equal errors: the only ones are common deviations of size.
    pub fn is_even(&self) -> bool {
        let StageErrors { pin_circle_radius, pin_radius, output_pin_radius, .. } = *self;
        let even = StageErrors { pin_circle_radius, pin_radius, output_pin_radius, ..StageErrors::default() };
        *self == even
    }
}
