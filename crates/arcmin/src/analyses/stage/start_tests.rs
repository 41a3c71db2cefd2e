//! Starts of simulations of random drives under light loads.

use rand::{RngExt as _, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::PI;

use super::EccentricDrive;
use crate::design::{TwoRingDesign, TwoStageDesign, Value};
use crate::dynamics::{Drive, GivenMotion, Model, OutputLoad, Simulation, StepControl};
use crate::progress::Silent;
use crate::templates::{TWO_RING_225, TWO_STAGE_500};
use crate::units::ARCMIN;

struct Draw(Pcg64Mcg);

impl Draw {
    fn of(seed: u64) -> Draw {
        Draw(Pcg64Mcg::seed_from_u64(seed))
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// A value with uniform logarithm.
    fn decades(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn count(&mut self, low: usize, high: usize) -> usize {
        low + (self.0.random::<f64>() * (high - low + 1) as f64) as usize
    }
}

/// Radius in mm of pins with room between them.
fn pin(draw: &mut Draw, circle: f64, count: usize) -> Value {
    (draw.between(0.4, 0.64) * circle * (PI / count as f64).sin()).into()
}

/// Two stages of 10 to 50 pins with K1 of 0.4 to 0.8, gaps of 2 to 40 µm, one or two discs. `None` where bores or walls overlap.
fn two_stages(seed: u64) -> Option<TwoStageDesign> {
    let mut draw = Draw::of(seed);
    let mut changes: Vec<(String, Value)> =
        vec![("load.rated_torque_n_m".to_owned(), draw.decades(30.0, 200.0).into())];
    for (stage, circle) in [("first_stage.", 26.0), ("", 52.0)] {
        let pins = draw.count(10, 45);
        let values: [(&str, Value); 8] = [
            ("ring.pin_count", pins.into()),
            ("ring.pin_radius_mm", pin(&mut draw, circle, pins)),
            ("eccentric.eccentricity_mm", (draw.between(0.4, 0.8) * circle / pins as f64).into()),
            ("disc.count", draw.count(1, 2).into()),
            ("disc.modification.equidistant_offset_um", draw.decades(2.0, 40.0).into()),
            ("output_pins.hole_clearance_um", draw.decades(2.0, 40.0).into()),
            ("output_pins.count", draw.count(4, 8).into()),
            ("bearings.eccentric.clearance_um", draw.between(0.0, 20.0).into()),
        ];
        changes.extend(values.map(|(key, value)| (format!("{stage}{key}"), value)));
    }
    TwoStageDesign::parse(TWO_STAGE_500.text, "stages").unwrap().with_all(changes).ok()
}

/// Two rings of 10 to 40 pins, one or two pins apart, with K1 of 0.4 to 0.8, gaps of 2 to 40 µm.
fn two_rings(seed: u64) -> Option<TwoRingDesign> {
    let mut draw = Draw::of(seed);
    let pins = draw.count(10, 40);
    let second = pins - draw.count(1, 2);
    let circle = 40.0 * second as f64 / pins as f64;
    let changes: [(&str, Value); 11] = [
        ("load.rated_torque_n_m", draw.decades(10.0, 80.0).into()),
        ("ring.pin_count", pins.into()),
        ("ring.pin_radius_mm", pin(&mut draw, 40.0, pins)),
        ("second_ring.pin_count", second.into()),
        ("second_ring.pin_circle_radius_mm", circle.into()),
        ("second_ring.pin_radius_mm", pin(&mut draw, circle, second)),
        ("eccentric.eccentricity_mm", (draw.between(0.4, 0.8) * 40.0 / pins as f64).into()),
        ("disc.count", draw.count(1, 2).into()),
        ("disc.modification.equidistant_offset_um", draw.decades(2.0, 40.0).into()),
        ("second_disc.modification.equidistant_offset_um", draw.decades(2.0, 40.0).into()),
        ("bearings.eccentric.clearance_um", draw.between(0.0, 20.0).into()),
    ];
    TwoRingDesign::parse(TWO_RING_225.text, "rings").unwrap().with_all(changes).ok()
}

/// Starts under 0.1, 1 and 2 % of the rated torque in both directions, and the error of the output there: that of the drive
/// with its input held, which is computed separately.
fn starts<D: EccentricDrive>(design: &D, seed: u64) {
    let rated = design.rated().torque;
    for share in [1e-3, -1e-3, 0.01, -0.01, 0.02, -0.02] {
        let load = share * rated;
        let mechanism = design.moving(&[]).unwrap().moving(
            design.contact_damping(),
            (0.0, 0.1),
            Drive::GivenMotion(GivenMotion::default()),
            OutputLoad::Constant { torque: load },
        );
        let started = Simulation::from_rest(Model::from(mechanism), StepControl::default(), &Silent);
        let started = started.unwrap_or_else(|error| panic!("seed {seed}, {load} N·m: {error}"));
        let error = started.outputs().unwrap().transmission_error;
        let mut held = design.new_drive(&[]).unwrap();
        let place = held.rest(0.0, load, None).unwrap().0;
        let expected = held.output_error(&place);
        assert!((error - expected).abs() < 1e-4 * ARCMIN, "seed {seed}, {load} N·m: {error} {expected}");
    }
}

#[test]
fn light_loads_start() {
    let mut drives = 0;
    for seed in 1..=60 {
        if let Some(design) = two_stages(seed) {
            starts(&design, seed);
            drives += 1;
        }
        if let Some(design) = two_rings(seed) {
            starts(&design, seed);
            drives += 1;
        }
    }
    assert!(drives > 100, "{drives}");
}
