//! Quasi-static torque cycles of drives of eccentrics with friction.

use super::hysteresis::slow_load;
use super::*;
use crate::design::{StageDesign, TwoRingDesign, TwoStageDesign};
use crate::dynamics::{HeldDrive, System};
use crate::machine::StageFriction;
use crate::templates::{NEMA17_19, TWO_RING_225, TWO_STAGE_500};

/// A drive of each family with its friction and its rated torque.
fn drives() -> Vec<(&'static str, HeldDrive, Vec<StageFriction>, f64)> {
    let one = StageDesign::parse(NEMA17_19.text, "one.toml").unwrap();
    let driven = NEMA17_19.text.replace("fixed_member = \"ring\" ", "fixed_member = \"output\" ");
    let driven = StageDesign::parse(&driven, "driven.toml").unwrap();
    let two = TwoRingDesign::parse(TWO_RING_225.text, "two.toml").unwrap();
    let stages = TwoStageDesign::parse(TWO_STAGE_500.text, "stages.toml").unwrap();
    let torques = [one.rated(), driven.rated(), two.rated(), stages.rated()].map(|point| point.torque.abs());
    // Relative to its ring a driven housing turns by z_c for z_p.
    let held = |joints, torque, seen| HeldDrive::new(joints, torque, seen);
    let mut drives = vec![
        (
            "ring at rest",
            held(one.drive().joints().unwrap(), torques[0], 1.0),
            vec![one.friction().0],
            torques[0],
        ),
        (
            "output at rest",
            held(driven.drive().joints().unwrap(), torques[1], 19.0 / 20.0),
            vec![driven.friction().0],
            torques[1],
        ),
    ];
    let joints = two.drive().joints().unwrap();
    drives.push(("two rings", held(joints, torques[2], 1.0), two.friction().0.into(), torques[2]));
    let joints = stages.drive().joints().unwrap();
    drives.push(("two stages", held(joints, torques[3], 1.0), stages.friction().0.into(), torques[3]));
    drives
}

fn without(friction: &[StageFriction]) -> Vec<StageFriction> {
    friction.iter().map(|friction| friction.none()).collect()
}

/// Without friction a state does not depend on its path: the loop consists of separate equilibria.
#[test]
fn without_friction_the_loop_consists_of_equilibria() {
    for (name, drive, friction, rated) in drives() {
        let angle = 0.3;
        let found = eccentric_loop(&drive, &without(&friction), angle).unwrap();
        let mut rests = drive.clone();
        let mut start = None;
        for point in &found {
            let (place, _) = rests.rest(angle, -point.torque, start.as_deref()).unwrap();
            start = Some(rests.deviation(angle, &place));
            let angle = rests.output_error(&place);
            assert!((point.angle - angle).abs() < 1e-9, "{name}: {} {angle} {}", point.angle, point.torque);
        }
        let figures = evaluate_loop(&found, rated).unwrap();
        assert!(figures.work.abs() < 1e-8 * rated * figures.lost_motion, "{name}: {}", figures.work);
    }
}

/// Work of the load and of friction over a closed cycle in J, with each step divided into `steps`.
fn cycle_works(drive: &HeldDrive, friction: &[StageFriction], steps: usize) -> [f64; 2] {
    let rated = drive.rated_torque();
    let mut machine = slow_load(drive, friction, 0.3);
    for share in [0.05, 0.3, 0.6, 1.0] {
        machine.change_to(-share * rated).unwrap();
    }
    let falling = shares();
    let rising: Vec<f64> = falling.iter().rev().copied().collect();
    let all: Vec<f64> = falling.into_iter().chain(rising).collect();
    let (mut area, mut lost, mut before) = (0.0, 0.0, 1.0);
    // The second cycle starts at the end of the first.
    for pass in 0..2 {
        for to in &all {
            // The play is crossed in one step, since at no load the equilibrium is not unique.
            let steps = if before * to < 0.0 { 1 } else { steps };
            for step in 1..=steps {
                let share = before + (to - before) * step as f64 / steps as f64;
                let (torque, from) = (-machine.model.constant_load(), machine.place.clone());
                machine.change_to(-share * rated).unwrap();
                if pass == 0 {
                    continue;
                }
                let way: Vec<f64> = machine.place.iter().zip(&from).map(|(q, q0)| q - q0).collect();
                let velocity: Vec<f64> = way.iter().map(|way| way / machine.interval()).collect();
                let (mut force, mut tangent) = (vec![0.0; way.len()], machine.model.linearisation());
                let balance =
                    machine.model.evaluate(0.0, &machine.place, &velocity, &mut force, &mut tangent);
                let left = force.iter().fold(0.0, |most: f64, force| most.max(force.abs()));
                assert!(left < 1e-4, "a balance leaves {left} N");
                lost += balance.dissipation * machine.interval();
                area += 0.5 * (torque + share * rated) * way[machine.model.output_index()];
            }
            before = *to;
        }
    }
    [area, lost]
}

/// The area of the loop is the work of friction, for all parts together and for each alone.
#[test]
fn the_area_of_a_loop_is_the_work_of_friction() {
    for (name, drive, friction, rated) in drives() {
        let only = |of: fn(&mut StageFriction, &StageFriction)| -> Vec<StageFriction> {
            let one = |friction: &StageFriction| {
                let mut alone = friction.none();
                of(&mut alone, friction);
                alone
            };
            friction.iter().map(one).collect()
        };
        let cases = [
            friction.clone(),
            only(|alone, all| alone.ring = all.ring),
            only(|alone, all| alone.output = all.output),
            only(|alone, all| alone.bearing = all.bearing),
        ];
        let whole = cycle_works(&drive, &friction, 4)[1];
        for (case, friction) in cases.iter().enumerate() {
            if case == 2 && name == "two rings" {
                continue;
            }
            let [area, lost] = cycle_works(&drive, friction, 4);
            // Steps at reversals count half: a few thousandths of the work of all parts together.
            assert!(lost > 0.0 && (area - lost).abs() < 3e-3 * whole, "{name} {case}: {area} {lost} {whole}");
        }
        let points = eccentric_loop(&drive, &friction, 0.3).unwrap();
        let figures = evaluate_loop(&points, rated).unwrap();
        assert!((figures.work.abs() / whole - 1.0).abs() < 0.1, "{name}: {} {whole}", figures.work);
    }
}

/// With the first eccentric in line with a ring pin and an output pin the drive is mirror-symmetric: after one
/// full cycle each branch is the mirror image of the other.
#[test]
fn the_loop_is_symmetric_under_reversal() {
    for (name, drive, friction, rated) in drives().into_iter().take(2) {
        let load = drive.rated_torque();
        let mut machine = slow_load(&drive, &friction, 0.0);
        for share in [0.05, 0.3, 0.6, 1.0] {
            machine.change_to(-share * load).unwrap();
        }
        let mut branch = |sign: f64| -> Vec<f64> {
            let to = |share: f64| {
                machine.change_to(-sign * share * load).unwrap();
                sign * machine.model.output_error(&machine.place)
            };
            shares().into_iter().map(to).collect()
        };
        let [_, rising, falling] = [1.0, -1.0, 1.0].map(&mut branch);
        let width =
            evaluate_loop(&eccentric_loop(&drive, &friction, 0.0).unwrap(), rated).unwrap().lost_motion;
        let apart = rising.iter().zip(&falling).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        // The rollers of the second disc are not mirror-symmetric.
        assert!(apart < 3e-3 * width, "{name}: {apart} {width}");
    }
}

/// The loss by joint friction of a running drive equals that of the forces at rest with the closed form of the
/// sliding distances.
#[test]
fn friction_of_joints_is_that_of_ways_per_turn() {
    for (name, drive, friction, _) in drives() {
        let (angle, speed) = (0.3, 1e5);
        let mut rests = drive.clone();
        let (place, _) = rests.rest(angle, drive.rated_torque() / drive.ratio_to_ring(), None).unwrap();
        let mut running = drive.with_friction(angle, &friction, 1e-3);
        running.hold_input(angle, speed);
        let velocity = running.nominal_velocity_at(angle, speed);
        let (mut force, mut tangent) = (vec![0.0; place.len()], running.linearisation());
        let power = running.evaluate(0.0, &place, &velocity, &mut force, &mut tangent).dissipation;
        let losses = rests.joints().losses(&place, &friction);
        let known: f64 = losses.iter().map(|losses| losses.total()).sum();
        // Pins slide by the centre distance, which play and compliance change by up to a hundredth of e.
        assert!((power / speed / known - 1.0).abs() < 1e-2, "{name}: {} {known}", power / speed);
    }
}
