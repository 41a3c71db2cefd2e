use std::f64::consts::PI;

use super::*;
use crate::design::StageDesign;
use crate::life::{WholeDrive, WornState};
use crate::machine::Around;
use crate::templates::NEMA17_19;
use crate::units::{HOUR, UM};

/// Sliding pins with a ratio and the gaps of a drive as it is, or none.
fn design(ratio: f64, gaps: bool) -> StageDesign {
    let design = StageDesign::parse(NEMA17_19.text, "test.toml").unwrap();
    let sliding = [
        ("output_pins.roller_radius_mm", 2.0),
        ("output_pins.pin_radius_mm", 2.0),
        ("wear.pin_ratio", ratio),
    ];
    let tight = [
        ("output_pins.hole_clearance_um", 0.0),
        ("bearings.eccentric.clearance_um", 0.0),
        ("disc.modification.equidistant_offset_um", 0.0),
    ];
    let keys = sliding.into_iter().chain(tight.into_iter().filter(|_| !gaps));
    design.with_all(keys).unwrap()
}

fn follower(design: &StageDesign, coefficient: f64) -> StageFollower {
    let exposure = Exposure { coefficient, running_in: None };
    crate::analyses::stage::followers(design, exposure).unwrap().swap_remove(0)
}

/// F̄ of a pin follows from the torque: Σ F R_w |sin| = T of a disc, so the sum of all lies between T/R_w and, with half
/// sines, 4 T/(π R_w). A turn takes k F̄ e 2π/(2π r B) off hole and pin.
#[test]
fn mean_depths_are_the_closed_form() {
    for gaps in [false, true] {
        let design = design(0.5, gaps);
        let (stage, rated, k) = (design.drive().clone(), design.rated(), 1e-19);
        let mut parts = follower(&design, k);
        parts.advance(HOUR).unwrap();
        let pins = stage.output_pins;
        let turns = HOUR * rated.input_speed / TAU * design.eccentric_turns();
        let e = stage.profile.eccentricity;
        let sum = rated.torque / stage.phases.len() as f64 / pins.circle_radius;
        let depth = k * sum / pins.count as f64 * e * turns / (parts.case.disc_width * pins.hole_radius(e));
        let (hole, pin) = (parts.wear.holes.mean, parts.wear.output_pins.mean);
        assert!((0.99..1.01 * 4.0 / PI).contains(&(hole / depth)), "{gaps}: {hole:e} {depth:e}");
        assert!(
            (pin / hole / (0.5 * pins.hole_radius(e) / pins.radius) - 1.0).abs() < 1e-9,
            "{pin:e} {hole:e}"
        );
    }
}

/// Metal lost by the holes is k Σ F |v| of all pins, v from the difference of neighbouring static equilibria.
#[test]
fn metal_lost_by_holes_is_the_work_of_sliding() {
    let design = design(0.0, true);
    let (stage, torque) = (design.drive().clone(), design.rated().torque);
    let mut parts = follower(&design, 1e-19);
    parts.advance(HOUR).unwrap();
    let holes = (stage.phases.len() * stage.output_pins.count) as f64;
    let round = TAU * stage.output_pins.hole_radius(stage.profile.eccentricity);
    let lost = parts.wear.holes.mean * holes * round * parts.case.disc_width;
    let mut new = follower(&design, 0.0);
    let period = TAU * 19.0 / 20.0;
    let (step, positions) = (1e-3, 360);
    let mut work = 0.0;
    for position in 0..positions {
        let angle = period * f64::from(position) / f64::from(positions);
        let [behind, here, ahead] =
            [-step, 0.0, step].map(|way| new.meshing.rest(angle + way, torque, None).unwrap().0);
        let motion: Vec<f64> = behind.iter().zip(&ahead).map(|(a, b)| (b - a) / (2.0 * step)).collect();
        work += new.meshing.joints().output_sliding_power(&here, &motion) / f64::from(positions);
    }
    let expected = 1e-19 * work * design.rated().input_speed * HOUR;
    assert!((lost / expected - 1.0).abs() < 0.02, "{} {lost:e} {expected:e}", lost / expected);
}

/// One hole of one disc, its directions summed up by themselves over many positions: about a half sine, π times its mean at
/// the deepest (six pins share less evenly than many, 11 % more), and nothing on the other side.
#[test]
fn a_hole_wears_on_one_side() {
    let design = design(0.0, false);
    let mut parts = follower(&design, 1e-19);
    parts.advance(HOUR).unwrap();
    const BINS: usize = 36;
    let (positions, mut bins) = (36 * 40, [0.0; BINS]);
    for position in 0..positions {
        let angle = TAU * 19.0 / 20.0 * position as f64 / positions as f64;
        let (place, _) = parts.meshing.rest(angle, design.rated().torque, None).unwrap();
        let pin = parts.meshing.joints().output_pin_loads(0, &place)[2];
        bins[(pin.around.rem_euclid(TAU) / TAU * BINS as f64) as usize % BINS] += pin.force;
    }
    let mean = bins.iter().sum::<f64>() / BINS as f64;
    let at =
        |bin: usize| parts.wear.holes.at((bin as f64 + 0.5) * TAU / BINS as f64)[0] / parts.wear.holes.mean;
    for (bin, force) in bins.iter().enumerate() {
        assert!((force / mean - at(bin)).abs() < 0.3, "{bin}: {} {}", force / mean, at(bin));
    }
    let worn = parts.wear.holes.deepest() / parts.wear.holes.mean;
    assert!((worn / PI - 1.0).abs() < 0.15, "{worn}");
    assert!(bins.iter().filter(|force| **force == 0.0).count() > BINS / 3, "{bins:?}");
}

/// An even depth h around all holes opens the play as a clearance h, and so does the lost motion.
#[test]
fn an_even_depth_is_a_clearance() {
    let design = design(0.0, true);
    let rated = design.rated().torque;
    let meshing = |design: &StageDesign| StageMeshing::new(design.drive(), None, rated, 1.0).unwrap();
    let mut even = Around::default();
    even.mean = 10.0 * UM;
    let mut whole = crate::analyses::stage::rings(&design).unwrap();
    let state = WornState { part_wear: PartWear { holes: even, ..PartWear::default() }, ..WornState::new() };
    let worn = whole.lost_motion(&[state]).unwrap();
    let clearance = *design.output_pins.hole_clearance_um + 10.0;
    let wider = design.with_all([("output_pins.hole_clearance_um", clearance)]).unwrap();
    let (mut wider, stage) = (meshing(&wider), wider);
    // The stiffness of the pins follows from the radius of the hole.
    assert!(
        (stage.drive().output_pin_stiffness[0] / design.drive().output_pin_stiffness[0] - 1.0).abs() < 0.01
    );
    let other = crate::load::lost_motion(&mut wider, rated, 12).unwrap().radians();
    assert!((worn / other - 1.0).abs() < 1e-3, "{worn} {other}");
    assert!(wider.discs_alike());
}

/// Error of intervals and positions: halved intervals change the depths by less than 1 %. Deep holes carry
/// on.
#[test]
fn deep_holes_are_followed() {
    let design = design(1.0, true);
    let depth = |intervals: i32| {
        let mut parts = follower(&design, 3e-17);
        for _ in 0..intervals {
            parts.advance(2000.0 * HOUR / f64::from(intervals)).unwrap();
        }
        parts.wear().hole_clearance().deepest()
    };
    let (coarse, fine) = (depth(4), depth(8));
    assert!(coarse > 10.0 * UM && (coarse / fine - 1.0).abs() < 0.01, "{coarse:e} {fine:e}");
}

/// Rollers spare the holes; their bores wear evenly, as much as the pins on the mean.
#[test]
fn rollers_wear_on_their_pins() {
    let design = StageDesign::parse(NEMA17_19.text, "test.toml").unwrap();
    assert!(!follower(&design, 1e-18).wear_at_all());
    let design = design.with_all([("wear.pin_ratio", 1.0)]).unwrap();
    let mut parts = follower(&design, 1e-18);
    parts.advance(100.0 * HOUR).unwrap();
    let wear = parts.wear();
    assert!(wear.holes == Around::default() && wear.rollers > 0.0);
    assert!((wear.rollers / wear.output_pins.mean - 1.0).abs() < 1e-12);
}

/// The forces of rollers over half of a bearing, about as a cosine, add up to 1 to 1.35 times its force (4/π for the cosine), and
/// their depth is added to the clearance of the drawing.
#[test]
fn eccentric_bearings_wear_by_their_force() {
    let text = NEMA17_19.text.replace("kind = \"ball\"", "kind = \"cylindrical\"\nroller_length_mm = 4");
    let law = "[wear.turning_arm]\ncoefficient_per_pa = 1e-17\nslip = 0.02\n\n[wear.coupled]";
    let design = StageDesign::parse(&text.replace("[wear.coupled]", law), "test.toml").unwrap();
    let mut parts = follower(&design, 0.0);
    parts.advance(HOUR).unwrap();
    let (bearing, rated, positions) = (&design.drive().eccentric, design.rated(), 72);
    let mut meshing = StageMeshing::new(design.drive(), None, rated.torque, 1.0).unwrap();
    let forces = (0..positions).map(|position| {
        let angle = TAU * f64::from(position) / f64::from(positions);
        let (place, _) = meshing.rest(angle, rated.torque, None).unwrap();
        0.5 * (0..2).map(|disc| meshing.joints().eccentric_force(disc, &place)).sum::<f64>()
    });
    let force = forces.sum::<f64>() / f64::from(positions);
    let relative = rated.input_speed * design.eccentric_turns();
    let closed = 1e-17 * HOUR * clearance_rate(bearing, 0.02, force, relative);
    let ratio = parts.wear().turning_arm / closed;
    assert!((1.0..1.35).contains(&ratio), "{ratio}");
    let grown = PartWear { turning_arm: 10.0 * UM, ..PartWear::default() };
    let lost_motion = |design: &StageDesign, part_wear: PartWear| {
        let mut whole = crate::analyses::stage::rings(design).unwrap();
        whole.lost_motion(&[WornState { part_wear, ..WornState::new() }]).unwrap()
    };
    let clearance = *design.bearings.eccentric.clearance_um + 10.0;
    let wider = design.with_all([("bearings.eccentric.clearance_um", clearance)]).unwrap();
    let (worn, drawn) = (lost_motion(&design, grown), lost_motion(&wider, PartWear::default()));
    assert!((worn / drawn - 1.0).abs() < 1e-6, "{worn} {drawn}");
}
