//! Windows of the disc: space for the carrier's pillars, walls to bores.

use super::{Finding, Severity, severity_if};
use crate::geometry::unit;
use crate::machine::{Kinematics, Machine};
use crate::units::MM;

/// Ratio of the thinnest wall between a window and a bore to the bore's radius.
const WALL_TO_RADIUS: f64 = 0.1;

pub(super) fn check(machine: &Machine) -> Vec<Finding> {
    [pillars(machine), walls(machine)].into_iter().flatten().collect()
}

/// A disc moves on a circle with the radius of the eccentricity relative to the carrier, which is the clearance
/// that a window needs around its pillar.
fn pillars(machine: &Machine) -> Option<Finding> {
    let room = machine.solids.pillar_clearance(&machine.disc.windows)?;
    let needed = machine.crankshafts.eccentricity;
    Some(Finding {
        code: "pillar-clearance",
        severity: severity_if(room <= needed, Severity::Error),
        message: format!(
            "around the pillars of the carrier the windows leave {:.2} mm for an eccentric motion of {:.2} mm",
            room / MM,
            needed / MM
        ),
        value: room / MM,
        limit: needed / MM,
        unit: "mm",
        why: "the disc moves around the pillars by the eccentricity; contact with a pillar breaks the disc",
        change: "wider windows, or thinner pillars ([carrier.solid])",
    })
}

fn walls(machine: &Machine) -> Option<Finding> {
    let (disc, cranks) = (&machine.disc, &machine.crankshafts);
    let circle = machine.gear_stage.centre_distance();
    let mut bores: Vec<_> = (0..cranks.count)
        .map(|k| {
            let place = circle * unit(Kinematics::crankshaft_angle(cranks.first_angle, k, cranks.count));
            (place, disc.crank_bore_radius)
        })
        .collect();
    bores.extend(disc.holes.iter().map(|hole| (hole.centre_radius * unit(hole.centre_angle), hole.radius)));
    if disc.centre_hole_radius > 0.0 {
        bores.push((crate::geometry::Vec2::zeros(), disc.centre_hole_radius));
    }
    let wall = |(window, (centre, radius)): (&crate::geometry::Sector, (crate::geometry::Vec2, f64))| {
        let outline = window.outline();
        let away = if outline.contains(centre) { -1.0 } else { 1.0 };
        (away * outline.distance(centre) - radius, WALL_TO_RADIUS * radius)
    };
    let pairs = disc.windows.iter().flat_map(|window| bores.iter().map(move |bore| (window, *bore)));
    let (wall, limit) = pairs.map(wall).min_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)))?;
    Some(Finding {
        code: "window-wall",
        severity: if wall <= 0.0 { Severity::Error } else { severity_if(wall < limit, Severity::Warning) },
        message: format!("the thinnest wall between a window and a bore of the disc is {:.2} mm", wall / MM),
        value: wall / MM,
        limit: limit / MM,
        unit: "mm",
        why: "crank forces deform thin walls; the bore becomes out of round, and the load of its rollers uneven",
        change: "narrower windows",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rv_80e() -> Machine {
        crate::design::Design::parse(crate::templates::RV_80E.text, "rv-80e.toml").unwrap().machine()
    }

    /// The theoretical disc has no windows and nothing to check. Windows by the default rule leave 0.02 R_p in
    /// addition to the eccentricity, and a smaller window is reported.
    #[test]
    fn assumed_windows_pass_and_tight_ones_are_found() {
        for mut machine in [crate::templates::tao2024(), rv_80e()] {
            assert_eq!(check(&machine).is_empty(), machine.disc.windows.is_empty());
            machine.disc.windows = machine.solids.windows.clone();
            let [pillars, walls] = <[Finding; 2]>::try_from(check(&machine)).unwrap();
            let spare = 0.02 * machine.ring.pin_circle_radius / MM;
            assert!((pillars.value - pillars.limit - spare).abs() < 0.6 * spare, "{pillars:?}");
            assert_eq!(pillars.severity, Severity::Info);
            assert_eq!(walls.severity, Severity::Info, "{walls:?}");
            for window in &mut machine.disc.windows {
                window.outer_radius -= 1.1 * spare * MM;
            }
            assert_eq!(check(&machine)[0].severity, Severity::Error);
            for window in &mut machine.disc.windows {
                window.half_angle *= 1.5;
            }
            assert_eq!(check(&machine)[1].severity, Severity::Error);
        }
    }
}
