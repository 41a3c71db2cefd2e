use super::{Finding, Severity, severity_if};
use crate::load::closed_form;
use crate::machine::Machine;
use crate::units::{DEG, MPA, UM};

pub(super) fn check(machine: &Machine) -> Vec<Finding> {
    vec![contact_pressure(machine)]
}

/// Largest Hertz pressure p0 of the closed form (one disc carries 0.55 T) at the largest torque of rating and
/// duty.
fn contact_pressure(machine: &Machine) -> Finding {
    let torque = machine.duty.iter().map(|point| point.torque.abs()).fold(machine.rated.torque, f64::max);
    let profile = machine.profile();
    let contact = machine.line_contact();
    let limit = machine.limits.contact_pressure;
    let finding = |severity, message, value| Finding {
        code: "contact-pressure",
        severity,
        message,
        value,
        limit: limit / MPA,
        unit: "MPa",
        why: "above its limit the surface pits; pressure also drives wear",
        change: "wider discs, more pins, a larger pin circle, or less torque",
    };
    let solution = match closed_form::solve(machine, torque, 0.0) {
        Ok(solution) => solution,
        Err(error) => {
            return finding(Severity::Warning, format!("the closed form cannot tell: {error}"), 0.0);
        }
    };
    let worst = solution
        .pairs
        .iter()
        .filter(|pair| pair.force > 0.0)
        .map(|pair| {
            let curvature = profile.relative_curvature(pair.meshing_angle.cos(), machine.ring.pin_radius);
            // An undercut flank has no contact there; its own finding says so.
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
        None => finding(
            Severity::Warning,
            format!("no pin carries at {torque} N·m with gaps of {:.1} µm", solution.smallest_gap() / UM),
            0.0,
        ),
    }
}
