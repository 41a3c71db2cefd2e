//! Two stages in series compared with each of them alone.

use crate::dynamics::EccentricJoints;
use crate::dynamics::eccentrics::tests::{self, rest};
use crate::dynamics::mechanism::HolePinLoad;
use crate::dynamics::single_stage::tests::{everything, stage};
use crate::geometry::Relief;
use crate::machine::{GapChain, StageErrors, TwoStage};
use crate::units::UM;

/// 361 : 1 of two stages of 19 : 1.
fn drive() -> TwoStage {
    TwoStage { first: stage(), second: stage() }
}

#[test]
fn ratios_multiply_and_everything_meshes() {
    let drive = drive();
    assert_eq!(drive.ratio(), 361.0);
    let joints = drive.joints().unwrap();
    for angle in [0.0, 1.0, 40.0] {
        let nominal = joints.nominal_position_at(angle);
        assert!((nominal[joints.output_index()] - angle / 361.0).abs() < 1e-12);
        for number in 0..2 {
            for contact in joints.pin_contacts(number, &nominal) {
                assert!(contact.gap.abs() < 1e-11, "{contact:?}");
            }
            for HolePinLoad { gap, .. } in joints.output_pin_loads(number, &nominal) {
                assert!(gap.abs() < 1e-11, "{gap}");
            }
        }
    }
}

/// Plays and compliances, referred to the output, add up; the compliance of the first stage is divided by the
/// square of the second ratio. The torque of the first stage is the output torque divided by that ratio, with
/// opposite sign.
#[test]
fn plays_and_compliances_add_up() {
    let mut gaping = stage();
    gaping.relief = Relief::uniform(20.0 * UM);
    gaping.eccentric.clearance = 20.0 * UM;
    let ends = |joints: &mut EccentricJoints, angle: f64, torque: f64| {
        let [lag, lead] = [torque, -torque].map(|torque| {
            let q = rest(joints, angle, torque);
            joints.output_error(&q)
        });
        (lead - lag).abs()
    };
    for angle in [0.3, 2.0, 4.4] {
        let whole = TwoStage { first: gaping.clone(), second: gaping.clone() };
        let mut joints = whole.joints().unwrap();
        let mut alone = gaping.joints().unwrap();
        for (torque, within) in [(1e-3, 0.03), (20.0, 0.03)] {
            let found = ends(&mut joints, angle, torque);
            let first = ends(&mut alone, angle, torque / 19.0);
            let second = ends(&mut alone, -angle / 19.0, torque);
            let sum = first / 19.0 + second;
            assert!((found / sum - 1.0).abs() < within, "{angle} {torque}: {found} {sum}");
        }
        let closed: f64 = whole.play().iter().map(|play| play.total()).sum();
        let found = ends(&mut joints, angle, 1e-3);
        assert!(found > 0.99 * closed && found < 1.2 * closed, "{found} {closed}");
    }
}

/// The pin forces of the first stage are those of the stage alone under the torque divided by the second ratio.
#[test]
fn the_first_stage_has_its_share_of_the_torque() {
    let mut joints = drive().joints().unwrap();
    let mut alone = stage().joints().unwrap();
    let largest = |joints: &EccentricJoints, number: usize, q: &[f64]| {
        joints.pin_contacts(number, q).iter().fold(0.0_f64, |most, contact| most.max(contact.force))
    };
    for angle in [0.4, 3.1] {
        let q = rest(&mut joints, angle, 38.0);
        let alone_at = rest(&mut alone, angle, -2.0);
        let (one, other) = (largest(&joints, 0, &q), largest(&alone, 0, &alone_at));
        assert!((one / other - 1.0).abs() < 0.02, "{one} {other}");
    }
}

#[test]
fn work_in_is_work_out() {
    tests::work_in_is_work_out(drive().joints().unwrap(), 30.0);
}

/// The chain of gaps compared with static equilibria at nearly zero torque, nominal and with every kind of
/// error in both stages.
#[test]
fn play_as_made_is_that_of_the_mechanism() {
    let mut gaping = stage();
    gaping.relief = Relief::uniform(20.0 * UM);
    gaping.eccentric.clearance = 15.0 * UM;
    gaping.output_pins.hole_clearance = 20.0 * UM;
    let drive = TwoStage { first: gaping.clone(), second: gaping };
    let drawn = [&drive.first, &drive.second].map(|stage| (stage.part_counts(), everything(4.0 * UM)));
    for seed in 0..5 {
        let errors = match seed {
            0 => vec![StageErrors::default(); 2],
            _ => StageErrors::draw(&drawn, seed, None),
        };
        let mut made = drive.clone();
        made.set_errors([errors[0].clone(), errors[1].clone()]);
        let mut joints = made.joints().unwrap();
        for angle in [0.3, 41.0, 1000.0] {
            let [lag, lead] = [1e-3, -1e-3].map(|torque| {
                let q = rest(&mut joints, angle, torque);
                joints.output_error(&q)
            });
            let found = lead - lag;
            let chain = GapChain::of_two_stages_at(&drive, &[angle]).least(&errors).unwrap();
            assert!((chain / found - 1.0).abs() < 0.02, "{seed} {angle}: {chain} {found}");
        }
    }
}
