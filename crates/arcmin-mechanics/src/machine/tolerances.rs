use rand::SeedableRng;
use rand_distr::{Distribution, Normal, Uniform};
use rand_pcg::Pcg64Mcg;

use super::{BoreError, DiscError, EccentricError, Machine, ManufacturingErrors, PinError, RunOut};
use crate::geometry::{FlankDirection, FlankError, FlankHarmonic};

/// Tolerances of a machine, ± in m (rad for phases); zero where a part is exact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tolerances {
    /// Position of every pin, radial and tangential.
    pub pin_position: f64,
    /// Radius of every pin.
    pub pin_radius: f64,
    /// Radius of the pin circle.
    pub pin_circle_radius: f64,
    /// Distance of every eccentric from the axis of its shaft.
    pub eccentricity: f64,
    /// rad.
    pub eccentric_phase: f64,
    /// Position of every bore in discs and carrier, radial and tangential.
    pub bore_position: f64,
    /// Diameter of every bore in discs and carrier.
    pub bore_diameter: f64,
    /// Centre of the pin circle.
    pub pin_circle_offset: f64,
    /// Cumulative pitch of the disc's flank, spread over its orders 2 to 7.
    pub flank_pitch: f64,
    /// Profile error, common to all lobes of a disc.
    pub flank_profile: f64,
    /// Largest radial run-out of the flanks; its direction is random, as for the run-outs below.
    pub flank_run_out: f64,
    /// Largest run-out of the carrier's main bearing seats.
    pub carrier_run_out: f64,
    /// Largest run-out of the crankshafts' journals.
    pub journal_run_out: f64,
    /// Largest run-out of the planets on their crankshafts.
    pub planet_run_out: f64,
    /// Largest run-out of the sun.
    pub sun_run_out: f64,
}

/// Orders of the disc's pitch error that are drawn; order 1 is the run-out. The limit of 7 is an assumption:
/// pitch measurements show slow errors of the grinder's table, faster ones are random from tooth to tooth.
const PITCH_ORDERS: std::ops::Range<usize> = 2..8;

impl ManufacturingErrors {
    /// One machine drawn at random from its tolerances: truncated normal distributions with the tolerance as
    /// three standard deviations; uniform distributions of the directions of run-outs. The generator is
    /// PCG-64-MCG, so that a seed gives the same machine on all platforms.
    pub fn draw(machine: &Machine, tolerances: &Tolerances, seed: u64) -> ManufacturingErrors {
        Draw::new(seed, None).machine(machine, tolerances)
    }

    /// One machine of a batch. Its errors are √s times those of the batch, which are common to all its machines
    /// because they come from one set-up, plus √(1 − s) times its own, where s is [`Batch::share`], the share
    /// of the variance between batches. Run-outs add up as vectors. Machines outside of their tolerances are
    /// drawn again.
    pub fn draw_from_batch(
        machine: &Machine,
        tolerances: &Tolerances,
        seed: u64,
        batch: Batch,
    ) -> ManufacturingErrors {
        Draw::new(seed, Some(batch)).machine(machine, tolerances)
    }
}

/// Errors common to the machines of one batch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Batch {
    /// Number of the batch: equal seeds give equal common errors.
    pub seed: u64,
    /// Share of the variance of every tolerance that lies between batches.
    pub share: f64,
}

/// Makes a batch and a machine of the same seed independent.
const BATCHES: u64 = 0xba7c_4e5a_11ce_5eed;

/// Random deviates of one machine or one batch.
struct Deviates {
    sizes: Pcg64Mcg,
    directions: Pcg64Mcg,
}

impl Deviates {
    fn new(seed: u64) -> Deviates {
        Deviates {
            sizes: Pcg64Mcg::seed_from_u64(seed),
            directions: Pcg64Mcg::seed_from_u64(seed ^ 0x5eed_0fd1_4ec7_1075),
        }
    }

    /// Normal with a standard deviation of 1/3, within ±1.
    fn size(&mut self) -> f64 {
        // A standard deviation of 1/3 is a valid one.
        let Ok(normal) = Normal::new(0.0, 1.0 / 3.0) else { return 0.0 };
        loop {
            let x: f64 = normal.sample(&mut self.sizes);
            if x.abs() <= 1.0 {
                return x;
            }
        }
    }

    fn direction(&mut self) -> f64 {
        Uniform::new(0.0, std::f64::consts::TAU).map_or(0.0, |circle| circle.sample(&mut self.directions))
    }
}

pub(super) struct Draw {
    own: Deviates,
    /// The batch with its share of the variance.
    batch: Option<(Deviates, f64)>,
}

impl Draw {
    pub(super) fn new(seed: u64, batch: Option<Batch>) -> Draw {
        let common = |batch: Batch| (Deviates::new(batch.seed ^ BATCHES), batch.share.clamp(0.0, 1.0));
        Draw { own: Deviates::new(seed), batch: batch.map(common) }
    }

    pub(super) fn deviate(&mut self, tolerance: f64) -> f64 {
        let Some((batch, share)) = &mut self.batch else { return tolerance * self.own.size() };
        let common = share.sqrt() * batch.size();
        loop {
            let x = common + (1.0 - *share).sqrt() * self.own.size();
            if x.abs() <= 1.0 {
                return tolerance * x;
            }
        }
    }

    pub(super) fn run_out(&mut self, tolerance: f64) -> RunOut {
        let Some((batch, share)) = &mut self.batch else {
            let amplitude = (tolerance * self.own.size()).abs();
            return RunOut { amplitude, phase: self.own.direction() };
        };
        let vector = |size: f64, direction: f64| (size * direction.cos(), size * direction.sin());
        let common = vector(share.sqrt() * batch.size().abs(), batch.direction());
        loop {
            let own = vector((1.0 - *share).sqrt() * self.own.size().abs(), self.own.direction());
            let (x, y) = (common.0 + own.0, common.1 + own.1);
            if x.hypot(y) <= 1.0 {
                let phase = y.atan2(x).rem_euclid(std::f64::consts::TAU);
                return RunOut { amplitude: tolerance * x.hypot(y), phase };
            }
        }
    }

    pub(super) fn bore(&mut self, position: f64, diameter: f64) -> BoreError {
        BoreError {
            radial: self.deviate(position),
            tangential: self.deviate(position),
            diameter: self.deviate(diameter),
        }
    }

    pub(super) fn pin(&mut self, position: f64, radius: f64) -> PinError {
        PinError {
            radial: self.deviate(position),
            tangential: self.deviate(position),
            radius: self.deviate(radius),
        }
    }

    pub(super) fn eccentric(&mut self, eccentricity: f64, phase: f64) -> EccentricError {
        EccentricError { eccentricity: self.deviate(eccentricity), phase: self.deviate(phase) }
    }

    /// Radial run-out of a flank.
    pub(super) fn flank_run_out(&mut self, tolerance: f64) -> FlankHarmonic {
        let RunOut { amplitude, phase } = self.run_out(tolerance);
        FlankHarmonic { order: 1, amplitude, phase, direction: FlankDirection::Inwards }
    }

    /// Harmonics of a flank's cumulative pitch error, and the profile error common to all lobes.
    pub(super) fn pitch_and_profile(&mut self, pitch: f64, profile: f64, lobes: usize) -> Vec<FlankHarmonic> {
        // Variances of independent amplitudes add up.
        let each = pitch / (PITCH_ORDERS.len() as f64).sqrt();
        let pitches = PITCH_ORDERS.map(|order| (order, each, FlankDirection::Around));
        let all = pitches.into_iter().chain([(lobes, profile, FlankDirection::Normal)]);
        all.map(|(order, tolerance, direction)| {
            let RunOut { amplitude, phase } = self.run_out(tolerance);
            FlankHarmonic { order, amplitude, phase, direction }
        })
        .collect()
    }

    fn machine(mut self, machine: &Machine, tolerances: &Tolerances) -> ManufacturingErrors {
        let t = tolerances;
        let (cranks, discs, lobes) =
            (machine.crankshafts.count, machine.disc_count, machine.ring.pin_count - 1);
        let mut errors = ManufacturingErrors {
            pin_circle_radius: self.deviate(t.pin_circle_radius),
            ..ManufacturingErrors::default()
        };
        for _ in 0..machine.ring.pin_count {
            errors.pins.push(self.pin(t.pin_position, t.pin_radius));
        }
        for _ in 0..cranks {
            errors
                .eccentrics
                .push((0..discs).map(|_| self.eccentric(t.eccentricity, t.eccentric_phase)).collect());
        }
        for _ in 0..discs {
            let bores = (0..cranks).map(|_| self.bore(t.bore_position, t.bore_diameter)).collect();
            errors.discs.push(DiscError { flank: FlankError::default(), bores });
        }
        errors.carrier_bores = (0..cranks).map(|_| self.bore(t.bore_position, t.bore_diameter)).collect();
        for disc in &mut errors.discs {
            disc.flank.harmonics.push(self.flank_run_out(t.flank_run_out));
        }
        errors.journals = (0..cranks).map(|_| self.run_out(t.journal_run_out)).collect();
        errors.planets = (0..cranks).map(|_| self.run_out(t.planet_run_out)).collect();
        errors.sun = self.run_out(t.sun_run_out);
        // Errors introduced later are drawn last, so that a seed still gives the same values for earlier ones.
        for disc in &mut errors.discs {
            disc.flank.harmonics.extend(self.pitch_and_profile(t.flank_pitch, t.flank_profile, lobes));
            disc.flank.harmonics.retain(|harmonic| harmonic.amplitude != 0.0);
        }
        errors.carrier = self.run_out(t.carrier_run_out);
        errors.pin_circle_offset = self.run_out(t.pin_circle_offset);
        errors
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_same_machine_and_nothing_leaves_its_tolerance() {
        let machine = crate::templates::tao2024();
        let tolerances = Tolerances {
            pin_position: 5e-6,
            eccentricity: 3e-6,
            bore_position: 4e-6,
            planet_run_out: 10e-6,
            ..Tolerances::default()
        };
        let one = ManufacturingErrors::draw(&machine, &tolerances, 7);
        assert_eq!(one, ManufacturingErrors::draw(&machine, &tolerances, 7));
        assert_ne!(one, ManufacturingErrors::draw(&machine, &tolerances, 8));
        let places: Vec<f64> = one.pins.iter().flat_map(|pin| [pin.radial, pin.tangential]).collect();
        assert!(places.iter().all(|x| x.abs() <= 5e-6));
        // 80 normal deviates of standard deviation 5/3 µm: their root mean square is within 30 % of it except
        // for one seed in 10⁴, and this seed is fixed.
        let rms = (places.iter().map(|x| x * x).sum::<f64>() / places.len() as f64).sqrt();
        assert!((rms / (5e-6 / 3.0) - 1.0).abs() < 0.3, "{rms}");
        assert!(
            one.planets
                .iter()
                .all(|p| p.amplitude <= 10e-6 && (0.0..std::f64::consts::TAU).contains(&p.phase))
        );
        assert_eq!(one.discs.len(), 2);
        assert!(one.pins.iter().all(|pin| pin.radius == 0.0));
    }

    /// 30 batches of 40 machines: the variance of an error is the same as without batches, its part between
    /// batches is the requested share (the standard error from 30 batch means is a quarter of it), and the same
    /// holds for vectors of run-outs.
    #[test]
    fn batches_have_their_share_of_the_variance() {
        let machine = crate::templates::tao2024();
        let tolerances =
            Tolerances { eccentricity: 3e-6, pin_radius: 3e-6, sun_run_out: 3e-6, ..Tolerances::default() };
        let draw = |batch: u64, seed: u64, share: f64| {
            let batch = Batch { seed: batch, share };
            ManufacturingErrors::draw_from_batch(&machine, &tolerances, seed, batch)
        };
        for share in [0.2, 0.7] {
            let (mut total, mut between, mut vectors) = (0.0, 0.0, 0.0);
            let mut count = 0.0;
            for batch in 0..30 {
                let machines: Vec<ManufacturingErrors> =
                    (0..40).map(|k| draw(batch, 1000 * batch + k, share)).collect();
                for pin in 0..machine.ring.pin_count {
                    let mean = machines.iter().map(|m| m.pins[pin].radius).sum::<f64>() / 40.0;
                    between += mean * mean;
                    total += machines.iter().map(|m| m.pins[pin].radius.powi(2)).sum::<f64>() / 40.0;
                    count += 1.0;
                }
                let sum = machines.iter().fold((0.0, 0.0), |(x, y), m| {
                    (x + m.sun.amplitude * m.sun.phase.cos(), y + m.sun.amplitude * m.sun.phase.sin())
                });
                vectors += (sum.0 / 40.0).powi(2) + (sum.1 / 40.0).powi(2);
            }
            // 1200 means: four standard errors are a sixth.
            let found = between / total;
            let expected = share + (1.0 - share) / 40.0;
            assert!((found / expected - 1.0).abs() < 0.17, "{share}: {found}");
            // Truncation reduces the variance, which would be (1 µm)² without it.
            assert!((total / count / 1e-12 - 0.97).abs() < 0.12, "{}", total / count);
            assert!((vectors / 30.0 / (share * 1e-12) - 1.0).abs() < 0.6, "{share}: {vectors}");
            assert!((0..40).all(|k| draw(k, k, share).sun.amplitude <= 3e-6));
        }
        assert_eq!(draw(1, 2, 0.5), draw(1, 2, 0.5));
        assert_ne!(draw(1, 2, 0.5), draw(2, 2, 0.5));
        // With the whole variance between batches, machines of one batch are equal.
        assert_eq!(draw(1, 2, 1.0).pins, draw(1, 3, 1.0).pins);
    }
}
