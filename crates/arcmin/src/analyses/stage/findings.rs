//! Checks of a single stage.

use std::f64::consts::{PI, TAU};

use super::contact;
use crate::analyses::NoHost;
use crate::checks::{Finding, Severity};
use crate::design::{StageDesign, openings};
use crate::geometry::{Relief, unit};
use crate::machine::RollerKind;
use crate::report::significant;
use crate::rig::dynamic_load_rating;
use crate::units::{HOUR, MM, MPA, UM};

/// Walls (share of the pin circle's radius) below this are thin: 0.5 mm of a drive of 50 mm.
const THIN: f64 = 0.02;

/// All checks of a single stage.
pub fn findings(design: &StageDesign) -> Vec<Finding> {
    let mut all = vec![
        undercut(design),
        pin_overlap(design),
        root_wall(design),
        hole_walls(design),
        modification_gap(design),
        contact_pressure(design),
        eccentric_life(design),
        balance(design),
        defaults(design),
    ];
    all.extend(unused(design));
    all
}

fn judged(bad: bool, worst: Severity) -> Severity {
    if bad { worst } else { Severity::Info }
}

fn undercut(design: &StageDesign) -> Finding {
    let profile = &design.stage().profile;
    let (trace, at) = profile.sharpest_convex_trace();
    let radius = trace - profile.pin_radius;
    Finding {
        code: "undercut",
        severity: judged(radius <= 0.0, Severity::Error),
        message: format!(
            "the sharpest convex radius of the flank is {:.3} mm, at a meshing angle of {:.1}°",
            radius / MM,
            at.to_degrees()
        ),
        value: radius / MM,
        limit: 0.0,
        unit: "mm",
        why: "a flank whose radius falls to zero is undercut: the cutter takes away what should carry",
        change: "thinner ring pins, less eccentricity, a larger pin circle, or fewer pins",
    }
}

fn pin_overlap(design: &StageDesign) -> Finding {
    let stage = design.stage();
    let room = 2.0 * stage.ring_circle_radius * (PI / stage.profile.pin_count as f64).sin()
        - 2.0 * stage.ring_pin_radius;
    Finding {
        code: "pin-overlap",
        severity: judged(room <= 0.0, Severity::Error),
        message: format!("neighbouring ring pins are {:.3} mm apart", room / MM),
        value: room / MM,
        limit: 0.0,
        unit: "mm",
        why: "pins that overlap cannot be installed",
        change: "thinner ring pins, fewer of them, or a larger pin circle",
    }
}

/// Between the holes of the output pins and the roots of the flank.
fn root_wall(design: &StageDesign) -> Finding {
    let stage = design.stage();
    let profile = &stage.profile;
    let root = profile.pin_circle_radius - profile.eccentricity - profile.pin_radius;
    let reach =
        openings(design, stage).iter().map(|hole| hole.centre_radius + hole.radius).fold(0.0, f64::max);
    wall(
        design,
        "hole-to-root",
        root - reach,
        "between the holes of the output pins and the roots of the flank",
        "a hole that reaches the flank breaks into its teeth",
        "a smaller circle of the output pins, thinner rollers, or less eccentricity",
    )
}

/// Between neighbouring holes, and between holes and the bore of the eccentric bearing.
fn hole_walls(design: &StageDesign) -> Finding {
    let all = openings(design, design.stage());
    let mut least = f64::INFINITY;
    for (index, one) in all.iter().enumerate() {
        for other in &all[..index] {
            let apart =
                one.centre_radius * unit(one.centre_angle) - other.centre_radius * unit(other.centre_angle);
            least = least.min(apart.norm() - one.radius - other.radius);
        }
    }
    wall(
        design,
        "hole-walls",
        least,
        "between the holes of the output pins, or from them to the bore of the eccentric bearing",
        "holes that overlap leave no disc",
        "fewer or thinner output pins, another circle for them, or a smaller eccentric bearing",
    )
}

fn wall(
    design: &StageDesign,
    code: &'static str,
    wall: f64,
    place: &str,
    why: &'static str,
    change: &'static str,
) -> Finding {
    let thin = THIN * design.stage().ring_circle_radius;
    Finding {
        code,
        severity: judged(wall <= 0.0, Severity::Error).max(judged(wall < thin, Severity::Warning)),
        message: format!("the thinnest wall {place} is {:.3} mm", wall / MM),
        value: wall / MM,
        limit: thin / MM,
        unit: "mm",
        why,
        change,
    }
}

/// The least gap between flank and ring pins in the nominal place.
fn modification_gap(design: &StageDesign) -> Finding {
    let stage = design.stage();
    let gap = Relief::grid(720).map(|phi| stage.gap(phi)).fold(f64::INFINITY, f64::min);
    let overlaps = gap < -ROUNDING;
    Finding {
        code: "modification-gap",
        severity: judged(overlaps, Severity::Warning),
        message: match overlaps {
            true => format!("flank and ring pins overlap by up to {:.1} µm before any load", -gap / UM),
            false => format!("the least gap between flank and ring pins is {:.1} µm", gap / UM),
        },
        value: gap / UM,
        limit: 0.0,
        unit: "µm",
        why: "discs that overlap the pins must be pressed into the ring, and press on all pins without load",
        change: "a larger equidistant offset, or a smaller radial offset",
    }
}

/// Gaps below this in m are rounding.
const ROUNDING: f64 = 1e-9;

/// Largest Hertz pressure of the ring pins at rated torque, by states of rest over a turn of the input.
fn contact_pressure(design: &StageDesign) -> Finding {
    let limit = design.limits().contact_pressure / MPA;
    let options = contact::Options { torque_nm: None, positions: PRESSURE_POSITIONS };
    let found = contact::run(design, &options, &NoHost).map(|contact| {
        let hardest = contact.ring.iter().max_by(|a, b| a.pressure.total_cmp(&b.pressure)).copied();
        hardest.map_or([0.0; 2], |pin| [pin.pressure / MPA, pin.force])
    });
    let (severity, message, value) = match found {
        Ok([pressure, force]) => (
            judged(pressure > limit, Severity::Error),
            format!(
                "the largest pressure of ring pins at {} N·m is {pressure:.0} MPa, under {force:.0} N",
                design.rated().torque
            ),
            pressure,
        ),
        // That a state of rest is not found is the solver's fault.
        Err(error) => (Severity::Warning, format!("no pressure can be computed: {error}"), 0.0),
    };
    Finding {
        code: "contact-pressure",
        severity,
        message,
        value,
        limit,
        unit: "MPa",
        why: "above its limit the surface pits; pressure also drives wear",
        change: "wider discs, more pins, a smaller gap, a larger pin circle, or less torque",
    }
}

/// Positions over a turn of the input.
const PRESSURE_POSITIONS: usize = 24;

/// L10 by ISO 281 with the closed form of the load: T/(e z_c) across the eccentric, and along it 4 T/(π R_w) of the output
/// pins less the radial part of the ring's force.
fn eccentric_life(design: &StageDesign) -> Finding {
    let stage = design.stage();
    let force = stage.eccentric_force(design.rated().torque * design.seen_from_ring());
    let bearing = &stage.eccentric;
    let exponent = if bearing.kind == RollerKind::Ball { 3.0 } else { 10.0 / 3.0 };
    // The disc turns against the input by 1 + 1/z_c turns a turn; where the output is at rest it does not turn itself.
    let slower = if design.is_driven_housing() { 0.0 } else { 1.0 / stage.profile.lobe_count() as f64 };
    let relative = design.rated().input_speed.abs() / TAU * (1.0 + slower);
    let hours = (dynamic_load_rating(bearing) / force).powf(exponent) * 1e6 / relative / HOUR;
    let limit = design.limits().service_life / HOUR;
    Finding {
        code: "eccentric-bearing-life",
        severity: judged(hours < limit, Severity::Warning),
        message: format!(
            "the eccentric bearings reach their basic rating life L10 after {hours:.0} h at rated torque and speed, under {force:.0} N each"
        ),
        value: hours,
        limit,
        unit: "h",
        why: "the eccentric bearing carries the torque over a short lever and turns with the input; it is often the first part to fail",
        change: "a larger eccentric bearing, more discs, more eccentricity, or a larger circle of output pins",
    }
}

fn balance(design: &StageDesign) -> Finding {
    let stage = design.stage();
    let unbalance = stage.disc.0 * stage.profile.eccentricity;
    let force = unbalance * design.rated().input_speed.powi(2);
    let discs = stage.phases.len();
    let message = match discs {
        1 => {
            format!(
                "one disc is out of balance by {:.1} g·mm, {} N at rated speed",
                unbalance / 1e-6,
                significant(force, 2)
            )
        }
        2 => {
            let couple = force * *design.disc.width_mm * MM;
            format!(
                "two discs balance each other but for a couple of {} N·m at rated speed",
                significant(couple, 2)
            )
        }
        _ => format!("{discs} discs balance each other"),
    };
    Finding {
        code: "eccentric-balance",
        severity: judged(discs == 1, Severity::Warning),
        message,
        value: if discs == 1 { force } else { 0.0 },
        limit: 0.0,
        unit: "N",
        why: "an unbalanced eccentric shakes the drive at input speed",
        change: "a second disc half a turn on, or a counterweight",
    }
}

fn defaults(design: &StageDesign) -> Finding {
    let keys = design.defaulted();
    Finding {
        code: "defaults",
        severity: Severity::Info,
        message: match keys.len() {
            0 => "every key is given".to_owned(),
            count => format!("{count} keys are left to their defaults: {}", keys.join(", ")),
        },
        value: keys.len() as f64,
        limit: 0.0,
        unit: "",
        why: "a default is an assumption; results are no better than the inputs nobody has looked at",
        change: "write the keys with their true values",
    }
}

/// Sections of the file that no analysis of a single stage uses yet.
fn unused(design: &StageDesign) -> Option<Finding> {
    let sections = [
        ("duty", !design.duty.is_empty()),
        ("wear", design.wear.is_some()),
        ("tolerances", design.tolerances.is_some()),
        ("unknowns", design.unknowns.span.is_some()),
    ];
    let given: Vec<&str> = sections.iter().filter(|(_, given)| *given).map(|(name, _)| *name).collect();
    (!given.is_empty()).then(|| Finding {
        code: "unused-sections",
        severity: Severity::Warning,
        message: format!("no analysis of a single stage uses these sections yet: {}", given.join(", ")),
        value: given.len() as f64,
        limit: 0.0,
        unit: "",
        why: "results look as if these inputs had been taken into account",
        change: "nothing, if you know it: they are read and checked",
    })
}
