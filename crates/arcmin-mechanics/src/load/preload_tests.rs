//! Signed play from interference to gap, compared with bisection on the gaps of the sampled flank.

use super::*;
use crate::geometry::{Relief, quarter_turn, turned, unit};
use crate::machine::{CrankAngle, Machine};
use crate::units::{ARCMIN, DEG, UM};

fn machine(equidistant_um: f64, radial_um: f64) -> Machine {
    let mut machine = crate::templates::tao2024();
    machine.disc.modification.equidistant_offset = equidistant_um * UM;
    machine.disc.modification.radial_offset = radial_um * UM;
    machine
}

/// Smallest distance of any pin's surface from the flank, by sampling and golden section: no foot search.
fn smallest_gap(machine: &Machine, crank: f64, error: f64) -> f64 {
    let (k, profile) = (machine.kinematics(), machine.profile());
    let mut smallest = f64::INFINITY;
    for disc in 0..machine.disc_count {
        let pose = k.disc_pose(
            disc,
            crank + k.crank_per_output_locked() * error,
            k.nominal_output_angle(crank) + k.disc_per_output_locked() * error,
        );
        for pin in machine.pins() {
            let p = turned(pin.centre - pose.centre, unit(-pose.angle));
            // Along the generating trace: its distance minus the radius of the generating pin is the gap of the
            // flank.
            let distance = |tau: f64| (p - profile.trace(tau)).norm();
            let inside = |tau: f64| (p - profile.trace(tau)).dot(&profile.outward_normal(tau));
            let start = p.y.atan2(p.x);
            let at = |i: i32| start + 0.05 * f64::from(i) / 200.0;
            let nearest = (-200..=200).min_by(|a, b| distance(at(*a)).total_cmp(&distance(at(*b)))).unwrap();
            let (mut a, mut b) = (at(nearest - 1), at(nearest + 1));
            for _ in 0..60 {
                let (c, d) = (b - 0.618_034 * (b - a), a + 0.618_034 * (b - a));
                if distance(c) < distance(d) { b = d } else { a = c }
            }
            let gap = inside(0.5 * (a + b)) + profile.pin_radius - pin.radius;
            smallest = smallest.min(gap);
        }
    }
    smallest
}

/// The relief at which the interference vanishes is minus the maximum over the output error of the smallest
/// gap; as an angle it is this relief times the play per micrometre of relief.
#[test]
fn val_play_of_an_interference_is_the_relief_that_frees_it() {
    for (equidistant, radial) in
        [(-20.0, 0.0), (-4.0, 0.0), (0.0, 20.0), (0.0, 4.0), (-3.0, -2.0), (2.0, 6.0)]
    {
        let machine = machine(equidistant, radial);
        let meshing = machine.meshing(&Relief::uniform(0.0));
        for crank in [0.0, 5.1 * DEG] {
            let (mut low, mut high) = (-2.0 * ARCMIN, 2.0 * ARCMIN);
            for _ in 0..45 {
                let (c, d) = (high - 0.618_034 * (high - low), low + 0.618_034 * (high - low));
                if smallest_gap(&machine, crank, c) > smallest_gap(&machine, crank, d) {
                    high = d;
                } else {
                    low = c;
                }
            }
            let missing = -smallest_gap(&machine, crank, 0.5 * (low + high));
            assert!(missing > 0.5 * UM);
            let travel = meshing.free_travel(CrankAngle::from_radians(crank)).unwrap();
            let per_um = {
                let play = crate::templates::tao2024()
                    .meshing(&Relief::uniform(UM))
                    .free_travel(CrankAngle::from_radians(crank))
                    .unwrap();
                play.lead.arcmin() - play.lag.arcmin()
            };
            let (found, expected) = (travel.lead.arcmin() - travel.lag.arcmin(), -per_um * missing / UM);
            // The closing rate is that of the modified flank at the actual positions of the pins.
            assert!((found / expected - 1.0).abs() < 3e-3, "{equidistant} {radial}: {found} {expected}");
            assert!(travel.preload.force > 100.0 && travel.preload.sliding_moment > 0.0);
        }
    }
}

/// In steps of a tenth of a micrometre from 20 µm of interference to 80 µm of gap by either offset: the play
/// increases throughout and passes zero with the offset; force, wind-up and preload have no jump.
#[test]
fn everything_passes_from_interference_to_gap_without_a_jump() {
    for radial in [false, true] {
        let at = |gap_um: f64| {
            let machine = if radial { machine(0.0, -gap_um) } else { machine(gap_um, 0.0) };
            machine.meshing(&Relief::uniform(0.0)).cycle(412.0, 6).unwrap()
        };
        let offsets = (-200..=-20).step_by(20).chain(-19..20).chain((20..=800).step_by(60));
        let mut last: Option<(f64, Cycle)> = None;
        for offset in offsets {
            let gap = 0.1 * f64::from(offset);
            let cycle = at(gap);
            let play = cycle.mean_play().arcmin();
            assert!(play.signum() == gap.signum() || play.abs() < 1e-9, "{gap} {play}");
            assert_eq!(cycle.max_preload() > 0.0, gap < 0.0, "{gap}");
            if let Some((before, last)) = last {
                let step = gap - before;
                assert!(play > last.mean_play().arcmin());
                assert!(play - last.mean_play().arcmin() < 0.07 * step);
                // The force changes by at most some 2 kN/µm with preload, and by some 40 N/µm otherwise.
                assert!((cycle.max_force() - last.max_force()).abs() < 2500.0 * step);
                assert!((cycle.mean_error().arcmin() - last.mean_error().arcmin()).abs() < 0.11 * step);
                assert!(cycle.max_preload() <= last.max_preload());
            }
            last = Some((gap, cycle));
        }
    }
}

/// The friction torque from the kinematics: the disc turns by one relative to the ring per turn of the output
/// while its centre goes back along the crank circle z_c times as fast; a pin is at rest.
#[test]
fn preload_causes_friction_torque() {
    let mut machine = machine(-4.0, 0.0);
    machine.friction.flank = 0.05;
    let meshing = machine.meshing(&Relief::uniform(0.0));
    let crank = CrankAngle::from_radians(0.3);
    let k = machine.kinematics();
    let balance = meshing.load_sharing(crank, 0.0).unwrap();
    assert!(balance.residual.abs() < 1e-3);
    let mut expected = 0.0;
    for (disc, contacts) in balance.discs.iter().enumerate() {
        let centre = k.disc_pose(disc, crank.radians(), 0.0).centre;
        let velocity = -k.lobe_count * quarter_turn(centre);
        for c in contacts {
            let point = c.arm - machine.ring.pin_radius * c.normal;
            let speed = velocity + quarter_turn(point);
            expected += 0.05 * c.force * speed.dot(&quarter_turn(c.normal)).abs();
        }
    }
    let preload = meshing.free_travel(crank).unwrap().preload;
    let found = preload.friction_torque(machine.flank_friction());
    // The positions differ from nominal rolling by the wind-up of the preload.
    assert!((found / expected - 1.0).abs() < 1e-3 && found > 1.0, "{found} {expected}");
    assert_eq!(preload.force, balance.max_force());
}
