//! Checks of a single stage.

use std::f64::consts::TAU;

use super::contact;
use crate::analyses::NoHost;
use crate::checks::{Finding, Severity, Teeth, balance, defaults, ligament, rim, severity_if};
use crate::design::StageDesign;
use crate::geometry::Relief;
use crate::rig::rating_life;
use crate::units::{HOUR, MM, MPA, UM};

/// All checks of a single stage; those of teeth, bores and eccentrics are those of RV reducers.
pub fn findings(design: &StageDesign) -> Vec<Finding> {
    let stage = design.stage();
    let profile = &stage.profile;
    let teeth =
        Teeth { profile, pin_circle_radius: stage.ring_circle_radius, pin_radius: stage.ring_pin_radius };
    let reach =
        stage.openings.iter().map(|opening| opening.centre_radius + opening.radius).fold(0.0, f64::max);
    let unbalance = stage.disc.0 * profile.eccentricity;
    let width = Some(*design.disc.width_mm * MM);
    let mut all = teeth.check().to_vec();
    all.push(rim(profile, stage.ring_pin_radius, "the outermost opening", reach));
    all.extend(ligament(&stage.openings));
    all.extend([
        interference(design),
        contact_pressure(design),
        eccentric_life(design),
        balance(&stage.phases, unbalance, design.rated().input_speed, width),
        defaults(&design.defaulted()),
    ]);
    all.extend(unused(design));
    all
}

/// The least gap between flank and ring pins in the nominal place.
fn interference(design: &StageDesign) -> Finding {
    let stage = design.stage();
    let gap = Relief::grid(720).map(|phi| stage.gap(phi)).fold(f64::INFINITY, f64::min);
    let overlaps = gap < -ROUNDING;
    Finding {
        code: "interference",
        severity: severity_if(overlaps, Severity::Warning),
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
    let found =
        contact::run(design, &contact::Options::of_positions(PRESSURE_POSITIONS), &NoHost).map(|contact| {
            let hardest = contact.ring.iter().max_by(|a, b| a.pressure.total_cmp(&b.pressure)).copied();
            hardest.map_or([0.0; 2], |pin| [pin.pressure / MPA, pin.force])
        });
    let (severity, message, value) = match found {
        Ok([pressure, force]) => (
            severity_if(pressure > limit, Severity::Error),
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
    let turns_per_second = design.rated().input_speed.abs() / TAU * design.eccentric_turns();
    let hours = rating_life(&stage.eccentric, force, turns_per_second) / HOUR;
    let limit = design.limits().service_life / HOUR;
    Finding {
        code: "eccentric-bearing-life",
        severity: severity_if(hours < limit, Severity::Warning),
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

/// Keys of the file that no analysis of a single stage uses.
fn unused(design: &StageDesign) -> Option<Finding> {
    let given = design.unused();
    (!given.is_empty()).then(|| Finding {
        code: "unused-keys",
        severity: Severity::Warning,
        message: format!("no analysis of a single stage uses these keys: {}", given.join(", ")),
        value: given.len() as f64,
        limit: 0.0,
        unit: "",
        why: "results do not contain what these keys describe",
        change: "nothing, if you know it: they are read and checked for their range",
    })
}
