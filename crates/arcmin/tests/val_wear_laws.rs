//! Wear laws against the measured lost motion of Lubricants 2025, 13(8), 362: 10.64″ after 600 h, 12.92″ after
//! 1550 h. k is fitted to the first, the second is predicted.

use arcmin::design::Value;
use arcmin::dynamics::{BearingMeshing, JointSettings};
use arcmin::geometry::Relief;
use arcmin::load::ShareLoad;
use arcmin::machine::Machine;
use arcmin::tribology::{Local, LocalRate, WearLaw};
use arcmin::units::{ARCSEC, HOUR, MPA, UM};
use arcmin::wear::calibrate::{Observation, Observed, fit_and_predict};
use arcmin::wear::{CoupledOptions, CoupledWear, Exposure};

fn observation(hours: f64, arcsec: f64) -> Observation {
    Observation { time: hours * HOUR, value: Observed::LostMotionIncrease(arcsec * ARCSEC) }
}

fn machine(law: WearLaw) -> Machine {
    let keys: Vec<(&str, Value)> = match law {
        WearLaw::Archard => Vec::new(),
        WearLaw::PressurePower { exponent, threshold } => vec![
            ("wear.law.name", "pressure-power".into()),
            ("wear.law.exponent", exponent.into()),
            ("wear.law.threshold_mpa", (threshold / MPA).into()),
        ],
        WearLaw::Smoothing { factor, depth } => vec![
            ("wear.law.name", "smoothing".into()),
            ("wear.law.factor", factor.into()),
            ("wear.law.smoothing_depth_um", (depth / UM).into()),
        ],
    };
    arcmin::templates::design("tao2024").unwrap().with_all(keys).unwrap().machine()
}

/// The rows of the table in the chapter on validation: predicted increase at 1550 h in seconds of arc with ideal
/// joints and with bearings.
const ROWS: [(WearLaw, [f64; 2]); 5] = [
    (WearLaw::Archard, [29.4, 25.4]),
    (WearLaw::PressurePower { exponent: 3.0, threshold: 0.0 }, [28.0, 23.2]),
    (WearLaw::PressurePower { exponent: 1.0, threshold: 300e6 }, [29.6, 24.5]),
    (WearLaw::Smoothing { factor: 30.0, depth: UM }, [16.4, 15.8]),
    (WearLaw::Smoothing { factor: 30.0, depth: 2.0 * UM }, [18.7, 17.8]),
];

/// With k fitted at 600 h; 2 % for the steps of the updates.
fn check<S: ShareLoad + Clone>(column: usize, joints: impl Fn(&Machine) -> S) {
    let (seen, later) = ([observation(600.0, 10.64)], [observation(1550.0, 12.92)]);
    for (law, expected) in ROWS {
        let machine = machine(law);
        let options = CoupledOptions::default();
        let fit = fit_and_predict(&machine, joints(&machine), options, &seen, &later, None).unwrap();
        let found = [fit.predicted[0] / ARCSEC, fit.predicted[1] / ARCSEC];
        assert!((found[0] - 10.64).abs() < 0.01, "{law:?} {found:?}");
        assert!((found[1] / expected[column] - 1.0).abs() < 0.02, "{law:?} {found:?}");
    }
}

#[test]
fn val_laws_predict_1550_h_with_ideal_joints() {
    check(0, |machine| machine.meshing(&Relief::uniform(0.0)));
}

#[test]
fn val_laws_predict_1550_h_with_bearings() {
    check(1, |machine| BearingMeshing::new(machine, &JointSettings::default()).unwrap());
}

/// A law of one's own, whose rate falls with time at every place alike.
#[derive(Debug)]
struct FallingWithTime {
    factor: f64,
    duration: f64,
}

impl LocalRate for FallingWithTime {
    fn rate(&self, at: &Local) -> f64 {
        at.pressure * at.sliding * (1.0 + (self.factor - 1.0) * (-at.time / self.duration).exp())
    }

    fn depends_on_time(&self) -> bool {
        true
    }
}

/// Stepping in time with k constant and a rate that falls with time is the same wear as the exposure of a k
/// that falls with time: the fast path of laws that separate.
#[test]
fn stepping_in_time_agrees_with_the_exposure() {
    let machine = machine(WearLaw::Archard);
    let options = CoupledOptions { depth_increment: 0.04 * UM, ..CoupledOptions::default() };
    let (factor, duration) = (6.0, 50.0 * HOUR);
    let clock = Exposure { coefficient: 4e-18, running_in: None };
    let time = 150.0 * HOUR;
    let mut stepped = CoupledWear::new(&machine, options)
        .with_law(Box::new(FallingWithTime { factor, duration }))
        .on_clock(&clock);
    stepped.advance_to(clock.at(time)).unwrap();
    let exposure = Exposure {
        coefficient: clock.coefficient,
        running_in: Some(arcmin::machine::RunningIn { factor, duration }),
    };
    let mut exposed = CoupledWear::new(&machine, options);
    exposed.advance_to(exposure.at(time)).unwrap();
    let (a, b) = (stepped.state().flank().deepest().0, exposed.state().flank().deepest().0);
    assert!(b > 2.0 * UM, "{b:e}");
    // Both are second order in the increment; their steps differ.
    assert!((a / b - 1.0).abs() < 3e-3, "{a:e} {b:e}");
    let mut without =
        CoupledWear::new(&machine, options).with_law(Box::new(FallingWithTime { factor, duration }));
    assert_eq!(without.advance_to(1.0), Err(arcmin::wear::WearError::NoClock));
}
