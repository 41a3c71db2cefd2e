use super::{Finding, Severity, severity_if};
use crate::geometry::unit;
use crate::machine::{Bore, Machine, RollerBearing, roller_spacing};
use crate::units::{DEG, MM};

/// Thinnest wall between two bores divided by the smaller radius.
const LIGAMENT_TO_RADIUS: f64 = 0.1;
/// Fraction of the unbalance of one disc below which the sum is rounding.
const BALANCED: f64 = 1e-9;
/// Smallest number of teeth of an involute gear without undercut and profile shift at 20°.
const LEAST_TEETH_20_DEG: f64 = 17.0;

pub(super) fn check(machine: &Machine) -> Vec<Finding> {
    let mut findings = Vec::new();
    findings.extend(ligament(&machine.disc_bores()));
    let (_, crank, _) = machine.kinematics().speeds(machine.rated.input_speed);
    let phases = &machine.kinematics().phases;
    findings.extend([
        balance(phases, machine.disc.mass * machine.crankshafts.eccentricity, crank, None),
        assembly(machine),
        planet_clearance(machine),
        sun_undercut(machine),
        gear_play(machine),
    ]);
    findings.extend([
        bearing(machine, "turning-arm-bearing", &machine.bearings.turning_arm),
        bearing(machine, "crank-support-bearing", &machine.bearings.crank_support),
    ]);
    findings.extend([eccentric_fit(machine), width(machine), pin_slenderness(machine), crank_count(machine)]);
    findings
}

/// Thinnest wall between two bores of a disc.
pub fn ligament(bores: &[Bore]) -> Option<Finding> {
    let centre = |bore: &Bore| bore.centre_radius * unit(bore.centre_angle);
    let (wall, limit) = bores
        .iter()
        .enumerate()
        .flat_map(|(i, a)| bores[..i].iter().map(move |b| (a, b)))
        .map(|(a, b)| {
            (
                (centre(a) - centre(b)).norm() - a.radius - b.radius,
                LIGAMENT_TO_RADIUS * a.radius.min(b.radius),
            )
        })
        .min_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)))?;
    Some(Finding {
        code: "bore-ligament",
        severity: severity_if(wall < limit, Severity::Warning),
        message: format!("the thinnest wall between bores of the disc is {:.2} mm", wall / MM),
        value: wall / MM,
        limit: limit / MM,
        unit: "mm",
        why: "bearing forces deform thin walls; the bore becomes out of round, and the load of its rollers uneven",
        change: "smaller or fewer bores, or a larger circle for them",
    })
}

/// A size with three digits; below a tenth of its unit in a thousandth of the unit.
fn sized(size: f64, unit: &str, thousandth: &str) -> String {
    let (size, unit) = if size == 0.0 || size >= 0.1 { (size, unit) } else { (1e3 * size, thousandth) };
    let above = if size > 0.0 { size.log10().floor() as i32 } else { 2 };
    let decimals = (2 - above).max(0) as usize;
    format!("{size:.decimals$} {unit}")
}

/// A moment in N·m with three digits, small ones in N·mm.
pub fn newton_metres(moment: f64) -> String {
    sized(moment, "N·m", "N·mm")
}

/// Rotating force of eccentrics at these angles (rad), each with the unbalance of its disc (kg·m), at the speed
/// in rad/s; and their couple, if the distance between neighbouring discs (m) is given.
pub fn balance(phases: &[f64], unbalance: f64, speed: f64, distance: Option<f64>) -> Finding {
    let newtons = unbalance * speed * speed;
    let sum = |arm: &dyn Fn(usize) -> f64| {
        let terms = phases.iter().enumerate().map(|(disc, phase)| arm(disc) * unit(*phase));
        newtons * terms.sum::<crate::geometry::Vec2>().norm()
    };
    let force = sum(&|_| 1.0);
    let middle = 0.5 * (phases.len() as f64 - 1.0);
    let distance = distance.filter(|_| phases.len() > 1);
    let couple = distance.map(|distance| sum(&|disc| distance * (disc as f64 - middle)));
    let couple =
        couple.map_or_else(String::new, |couple| format!(" and a couple of {}", newton_metres(couple)));
    let is_balanced = phases.len() > 1 && force < BALANCED * newtons;
    let force = if is_balanced { 0.0 } else { force };
    Finding {
        code: "eccentric-balance",
        severity: severity_if(!is_balanced, Severity::Warning),
        message: format!(
            "{} a rotating force of {}{couple} at rated speed",
            if phases.len() == 1 {
                "one eccentric leaves".to_owned()
            } else {
                format!("{} eccentrics leave", phases.len())
            },
            sized(force, "N", "mN")
        ),
        value: force,
        limit: 0.0,
        unit: "N",
        why: "a single disc excites the housing once per crank turn; the forces of two or more discs with equally spaced phases cancel each other",
        change: "two or three discs",
    }
}

/// Gear trains with a ring gear need a condition for equally spaced planets. Here there is no ring gear: all
/// planets can be assembled if their teeth can be indexed on the shafts; for equal crankshafts z_1 must be
/// divisible by their number.
fn assembly(machine: &Machine) -> Finding {
    let count = machine.crankshafts.count;
    let sun = machine.gear_stage.sun_teeth;
    let remainder = sun % count;
    Finding {
        code: "planet-assembly",
        severity: severity_if(remainder != 0, Severity::Warning),
        message: format!(
            "{sun} sun teeth on {count} planets {}",
            if remainder == 0 {
                "allow equal crankshafts"
            } else {
                "require planets at different angles to their eccentrics"
            }
        ),
        value: remainder as f64,
        limit: 0.0,
        unit: "teeth",
        why: "all eccentrics must have the same direction at any time; only if the sun's number of teeth is divisible by the number of planets do all planets \
              mesh with the same angle between tooth and eccentric",
        change: "a sun whose number of teeth is divisible by the number of planets, or matched crankshafts",
    }
}

fn planet_clearance(machine: &Machine) -> Finding {
    let gear = &machine.gear_stage;
    let count = machine.crankshafts.count;
    let tip_diameter = 2.0 * (gear.planet_pitch_radius() + gear.module);
    let distance = if count > 1 {
        2.0 * gear.centre_distance() * (std::f64::consts::PI / count as f64).sin()
    } else {
        f64::INFINITY
    };
    let broken = distance <= tip_diameter;
    Finding {
        code: "planet-clearance",
        severity: severity_if(broken, Severity::Error),
        message: match count {
            1 => "one planet has no neighbour".to_owned(),
            _ => format!(
                "planets are {:.2} mm apart, centre to centre; their tip diameter is {:.2} mm",
                distance / MM,
                tip_diameter / MM
            ),
        },
        value: if count > 1 { distance / MM } else { tip_diameter / MM },
        limit: tip_diameter / MM,
        unit: "mm",
        why: "all planets lie in one plane around the sun and must pass each other",
        change: "fewer planets, smaller planets, or a larger sun",
    }
}

fn sun_undercut(machine: &Machine) -> Finding {
    let gear = &machine.gear_stage;
    let sin = gear.pressure_angle.sin();
    let least = 2.0 / (sin * sin);
    let teeth = gear.sun_teeth.min(gear.planet_teeth) as f64;
    debug_assert!((2.0 / (20.0 * DEG).sin().powi(2) - LEAST_TEETH_20_DEG).abs() < 0.2);
    Finding {
        code: "gear-undercut",
        severity: severity_if(teeth < least.floor(), Severity::Warning),
        message: format!(
            "the smaller gear has {teeth} teeth; without profile shift there is undercut below {least:.1} teeth at {:.1}°",
            gear.pressure_angle / DEG
        ),
        value: teeth,
        limit: least,
        unit: "teeth",
        why: "undercut weakens the root and shortens the contact; small suns need profile shift, which is not modelled here",
        change: "more teeth, a larger pressure angle, or profile shift",
    }
}

fn gear_play(machine: &Machine) -> Finding {
    let gear = &machine.gear_stage;
    let ratio = machine.kinematics().housing_fixed_ratio();
    let arcmin = gear.backlash / gear.sun_base_radius() / ratio / crate::units::ARCMIN;
    let limit = 0.2 * machine.limits.lost_motion / crate::units::ARCMIN;
    Finding {
        code: "gear-backlash",
        severity: severity_if(arcmin > limit, Severity::Warning),
        message: format!("the gear stage's backlash is {arcmin:.4}′ at the output"),
        value: arcmin,
        limit,
        unit: "arcmin",
        why: "the backlash of the first stage is divided by the ratio; it reduces the lost motion that is available for wear",
        change: "less backlash in the gear stage",
    }
}

fn bearing(machine: &Machine, code: &'static str, bearing: &RollerBearing) -> Finding {
    debug_assert!(machine.disc_count > 0);
    let gap = roller_spacing(bearing.pitch_diameter, bearing.roller_count) - bearing.roller_diameter;
    let limit = 0.02 * bearing.roller_diameter;
    Finding {
        code,
        severity: severity_if(gap < limit, Severity::Warning),
        message: format!(
            "{} rollers Ø{:.2} mm leave {:.3} mm between neighbours",
            bearing.roller_count,
            bearing.roller_diameter / MM,
            gap / MM
        ),
        value: gap / MM,
        limit: limit / MM,
        unit: "mm",
        why: "rollers that touch slide on each other at twice their surface speed; a cage needs space as well",
        change: "one roller less, or a larger pitch circle",
    }
}

fn eccentric_fit(machine: &Machine) -> Finding {
    let bearing = &machine.bearings.turning_arm;
    let outside = bearing.pitch_diameter + bearing.roller_diameter;
    let bore = 2.0 * machine.disc.crank_bore_radius;
    let difference = bore - outside;
    // Without an outer ring the rollers run in the bore itself; a difference of more than a third of the radius
    // means a ring.
    let severity = match difference {
        x if x < -1e-6 => Severity::Error,
        x if x > 0.34 * bore => Severity::Warning,
        _ => Severity::Info,
    };
    Finding {
        code: "turning-arm-fit",
        severity,
        message: format!(
            "the turning-arm bearing is Ø{:.3} mm over its rollers, the bore Ø{:.3} mm",
            outside / MM,
            bore / MM
        ),
        value: outside / MM,
        limit: bore / MM,
        unit: "mm",
        why: "the rollers run in the bore of the disc, or in a ring pressed into it",
        change: "pitch diameter, roller diameter or crank bore",
    }
}

fn width(machine: &Machine) -> Finding {
    let needed = machine.disc_count as f64 * machine.disc.width;
    let span = machine.bearings.crank_support_span;
    Finding {
        code: "crank-span",
        severity: severity_if(needed > span, Severity::Error),
        message: format!(
            "{} discs with a width of {:.2} mm are between crank supports at a distance of {:.2} mm",
            machine.disc_count,
            machine.disc.width / MM,
            span / MM
        ),
        value: needed / MM,
        limit: span / MM,
        unit: "mm",
        why: "all discs must fit between the two supports of each crankshaft",
        change: "narrower discs or a larger distance of the supports",
    }
}

fn pin_slenderness(machine: &Machine) -> Finding {
    let length = machine.disc_count as f64 * machine.disc.width;
    let diameter = 2.0 * machine.ring.pin_radius;
    let ratio = length / diameter;
    let limit = 8.0;
    Finding {
        code: "pin-slenderness",
        severity: severity_if(ratio > limit, Severity::Warning),
        message: format!(
            "pins of Ø{:.2} mm mesh with discs of {:.2} mm total width: ratio of length to diameter {ratio:.1}",
            diameter / MM,
            length / MM
        ),
        value: ratio,
        limit,
        unit: "",
        why: "the pressure is assumed to be uniform over the width; long thin pins bend, and the pressure at their ends increases",
        change: "narrower discs or thicker pins",
    }
}

fn crank_count(machine: &Machine) -> Finding {
    let count = machine.crankshafts.count;
    Finding {
        code: "crank-count",
        severity: severity_if(count < 2, Severity::Error),
        message: format!("the discs are guided by {count} crankshaft{}", if count == 1 { "" } else { "s" }),
        value: count as f64,
        limit: 2.0,
        unit: "",
        why: "one crankshaft cannot carry the torque of a disc to the carrier: the disc would turn about it",
        change: "two or three crankshafts",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Light discs: m e ω² of each, in opposite directions at their distance; the text has the same numbers.
    #[test]
    fn small_forces_and_couples_are_shown() {
        // 2 g at 0.3 mm and 10 rad/s: 60 µN, 4 mm apart 0.24 µN·m.
        let found = balance(&[0.0, PI], 2e-3 * 0.3e-3, 10.0, Some(4e-3)).message;
        assert_eq!(
            found,
            "2 eccentrics leave a rotating force of 0 N and a couple of 0.000240 N·mm at rated speed"
        );
        let found = balance(&[0.0], 2e-3 * 0.3e-3, 10.0, None).message;
        assert_eq!(found, "one eccentric leaves a rotating force of 0.0600 mN at rated speed");
        for (size, words) in
            [(0.0, "0 N·m"), (0.1, "0.100 N·m"), (0.0421, "42.1 N·mm"), (1.5, "1.50 N·m"), (431.7, "432 N·m")]
        {
            assert_eq!(newton_metres(size), words);
        }
    }
}
