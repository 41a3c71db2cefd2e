use super::{Finding, Severity, severity_if};
use crate::geometry::Relief;
use crate::load::{Cycle, LoadError, closed_form};
use crate::machine::Machine;
use crate::units::{DEG, MPA};

pub(super) fn check(machine: &Machine) -> Vec<Finding> {
    vec![contact_pressure(machine)]
}

/// Number of crank positions for the static equilibrium.
const BALANCE_POSITIONS: usize = 6;
/// Hertz pressure in Pa with a permanent deformation of a ten-thousandth of the roller diameter (ISO 76).
const DENTING_PRESSURE: f64 = 4e9;

/// Code of the finding on the pressure of the new machine.
pub const CONTACT_PRESSURE: &str = "contact-pressure";

/// Overlap in m attributed to rounding.
const OVERLAP: f64 = -1e-9;

/// Largest Hertz pressure p0 at the largest torque of rating and duty by the closed form (one disc carries 0.55
/// T). The static equilibrium with ideal joints replaces it where the closed form has no solution, where its
/// gaps are negative (an interference would count as load), or where no pin carries load in it.
fn contact_pressure(machine: &Machine) -> Finding {
    let torque = machine.duty.iter().map(|point| point.torque.abs()).fold(machine.rated.torque, f64::max);
    let profile = machine.profile();
    let contact = machine.line_contact();
    let limit = machine.limits.contact_pressure;
    let finding = |severity, message, value| Finding {
        code: CONTACT_PRESSURE,
        severity,
        message,
        value,
        limit: limit / MPA,
        unit: "MPa",
        why: "above its limit the surface suffers pitting; wear increases with pressure",
        change: "wider discs, more pins, a larger pin circle, or less torque",
    };
    // Interference, a flank without closed form, or gaps without a loaded pin.
    let by_balance = || {
        let meshing = machine.meshing(&Relief::uniform(0.0));
        let cycle = match meshing.cycle(torque, BALANCE_POSITIONS) {
            Ok(cycle) => cycle,
            Err(error) => {
                // That no pin touches is a property of the design; another failure is one of the solver.
                let out_of_reach = matches!(error, LoadError::NoContact { .. });
                let severity = if out_of_reach { Severity::Error } else { Severity::Warning };
                return finding(severity, format!("no pressure can be computed: {error}"), 0.0);
            }
        };
        let (pressure, preload) = (cycle.max_pressure(&contact), cycle.max_preload());
        // A preload decreases with wear unless it exceeds the pressure that dents; the pressure of the load
        // alone remains.
        let stays = || {
            let relief = Relief::uniform(freeing_relief(machine, &cycle));
            let freed = machine.meshing(&relief).cycle(torque, BALANCE_POSITIONS);
            !freed.is_ok_and(|cycle| cycle.max_pressure(&contact) <= limit)
        };
        let severity = match pressure {
            pressure if pressure <= limit => Severity::Info,
            pressure if preload > 0.0 && pressure <= limit.max(DENTING_PRESSURE) && !stays() => {
                Severity::Warning
            }
            _ => Severity::Error,
        };
        let alone = if preload > 0.0 {
            format!(
                "; without load, the interference causes a force of {preload:.0} N on a pin with joints without clearance"
            )
        } else {
            String::new()
        };
        let message = format!(
            "the largest contact pressure at {torque} N·m is {:.0} MPa, under {:.0} N{alone}",
            pressure / MPA,
            cycle.max_force()
        );
        finding(severity, message, pressure / MPA)
    };
    let Ok(solution) = closed_form::solve(machine, torque, 0.0) else { return by_balance() };
    if solution.smallest_gap() < OVERLAP {
        return by_balance();
    }
    let worst = solution
        .pairs
        .iter()
        .filter(|pair| pair.force > 0.0)
        .map(|pair| {
            let curvature = profile.relative_curvature(pair.meshing_angle.cos(), machine.ring.pin_radius);
            // An undercut flank has no contact there; another finding reports it.
            let radius = if curvature > 0.0 { 1.0 / curvature } else { f64::INFINITY };
            (contact.pressure(pair.force, radius), pair.meshing_angle, pair.force)
        })
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match worst {
        Some((pressure, angle, force)) => finding(
            severity_if(pressure > limit, Severity::Error),
            format!(
                "the largest contact pressure at {torque} N·m is {:.0} MPa, at {:.0}° under {force:.0} N",
                pressure / MPA,
                angle / DEG
            ),
            pressure / MPA,
        ),
        None => by_balance(),
    }
}

/// Uniform relief in m that removes the forces without load: the largest interference as a distance.
fn freeing_relief(machine: &Machine, cycle: &Cycle) -> f64 {
    let kinematics = machine.kinematics();
    let tightest = cycle.play.iter().map(|play| -play.radians()).fold(0.0, f64::max);
    tightest * kinematics.eccentricity * kinematics.lobe_count / kinematics.locked_play_factor()
}
