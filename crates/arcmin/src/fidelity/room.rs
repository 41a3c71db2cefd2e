//! Check before meshing that the solids of carrier, housing and discs are possible.

use crate::analyses::AnalysisError;
use crate::geometry::{Sector, unit};
use crate::machine::{Hold, Kinematics, Machine};
use crate::units::MM;

/// A solid that is not possible: a sentence with the values, and a sentence with the keys to change.
type NoRoom = (String, &'static str);

/// Reports the first solid of a machine that is not possible with the given or scaled dimensions.
pub(super) fn check(machine: &Machine) -> Result<(), AnalysisError> {
    let found = windows(machine).or_else(|| plates(machine)).or_else(|| pillars(machine));
    match found.or_else(|| housing(machine)) {
        None => Ok(()),
        Some((message, remedy)) => Err(AnalysisError::usage(
            format!("the design leaves no room for elastic bodies: {message}"),
            format!("{remedy}; or leave bodies = elastic out"),
        )),
    }
}

fn mm(length: f64) -> String {
    format!("{:.2} mm", length / MM)
}

fn windows(machine: &Machine) -> Option<NoRoom> {
    (!machine.disc.windows.iter().all(Sector::is_sound)).then(|| {
        (
            "between centre hole, crank bores and root circle of the disc no window for a pillar is left"
                .to_owned(),
            "set a smaller `disc.window_rim_mm` or `disc.centre_hole_diameter_mm`",
        )
    })
}

fn plates(machine: &Machine) -> Option<NoRoom> {
    let carrier = &machine.solids.carrier;
    let (circle, seat) = (machine.gear_stage.centre_distance(), carrier.crank_seat_radius);
    let count = machine.crankshafts.count;
    let apart = if count > 1 { circle * (std::f64::consts::PI / count as f64).sin() } else { f64::INFINITY };
    let rules = [
        (
            carrier.plate_radius - circle - seat,
            "the crank seats reach out of the carrier's plates",
            "set a larger `carrier.solid.plate_diameter_mm` or a smaller `carrier.solid.crank_seat_diameter_mm`",
        ),
        (
            circle - seat - carrier.centre_bore_radius,
            "the crank seats reach into the bore through the carrier's plates",
            "set a smaller `carrier.solid.centre_bore_diameter_mm` or `carrier.solid.crank_seat_diameter_mm`",
        ),
        (
            apart - seat,
            "the crank seats of the carrier overlap",
            "set a smaller `carrier.solid.crank_seat_diameter_mm`, or fewer crankshafts",
        ),
    ];
    let found = rules.into_iter().find(|(room, ..)| !(*room > 0.0))?;
    Some((format!("{} by {}", found.1, mm(-found.0)), found.2))
}

fn pillars(machine: &Machine) -> Option<NoRoom> {
    const SMALLER: &str =
        "set a smaller `carrier.solid.pillar_width_deg` or `carrier.solid.crank_seat_diameter_mm`";
    let carrier = &machine.solids.carrier;
    if !carrier.pillars.iter().all(Sector::is_sound) {
        return Some((
            "the windows leave no material for the pillars of the carrier".to_owned(),
            "set a smaller `disc.window_rim_mm` or `disc.centre_hole_diameter_mm`, or the pillars by \
             `carrier.solid.pillar_inner_radius_mm`, `pillar_outer_radius_mm`, `pillar_width_deg` and \
             `pillar_corner_radius_mm`",
        ));
    }
    let inside = |pillar: &Sector| {
        (pillar.inner_radius - carrier.centre_bore_radius).min(carrier.plate_radius - pillar.outer_radius)
    };
    if carrier.pillars.iter().any(|pillar| !(inside(pillar) > 0.0)) {
        return Some((
            "a pillar of the carrier reaches over the edge of its plates".to_owned(),
            "set `carrier.solid.pillar_inner_radius_mm` above the centre bore's and `pillar_outer_radius_mm` below \
             the plates' radius",
        ));
    }
    let cranks = &machine.crankshafts;
    let circle = machine.gear_stage.centre_distance();
    let wall = (0..cranks.count)
        .flat_map(|k| carrier.pillars.iter().map(move |pillar| (k, pillar)))
        .map(|(k, pillar)| {
            let place = circle * unit(Kinematics::crankshaft_angle(cranks.first_angle, k, cranks.count));
            let outline = pillar.outline();
            let sign = if outline.contains(place) { -1.0 } else { 1.0 };
            sign * outline.distance(place) - carrier.crank_seat_radius
        })
        .fold(f64::INFINITY, f64::min);
    (wall <= 0.0)
        .then(|| (format!("pillars and crank seats of the carrier overlap by {}", mm(-wall)), SMALLER))
}

fn housing(machine: &Machine) -> Option<NoRoom> {
    let solid = &machine.solids.housing;
    let (circle, pin) = (machine.ring.pin_circle_radius, machine.ring.pin_radius);
    let bolts = solid.hold == Hold::Bolts;
    let spread = solid.bolt_circle_radius * (std::f64::consts::PI / solid.bolt_count as f64).sin();
    let rules = [
        (
            solid.seat_radius - circle - pin,
            "the seats of the main bearings reach into the grooves of the pins",
            "set a larger `housing.solid.seat_diameter_mm`",
        ),
        (
            solid.body_radius - solid.seat_radius,
            "the radius of the housing's ring is not larger than that of the main bearing seats",
            "set a larger `housing.solid.body_diameter_mm` (left out: 2.5 R_p)",
        ),
        (
            solid.flange_radius - solid.body_radius,
            "the radius of the housing's flange is not larger than that of its ring",
            "set a larger `housing.solid.flange_diameter_mm` (left out: 2.96 R_p) or a smaller \
             `housing.solid.body_diameter_mm`",
        ),
        (
            // Equal is the rule where it is left out.
            machine.solids.carrier.gap * (1.0 + 1e-9) - solid.flange_thickness,
            "the housing's flange is thicker than the pins are long",
            "set a smaller `housing.solid.flange_thickness_mm`",
        ),
        (
            if bolts { solid.bolt_circle_radius - solid.bolt_face_radius - solid.body_radius } else { 1.0 },
            "the faces of the bolts reach into the housing's ring",
            "set a larger `housing.solid.bolt_circle_diameter_mm`, a smaller `housing.solid.bolt_face_diameter_mm` or \
             a smaller `housing.solid.body_diameter_mm`",
        ),
        (
            if bolts { solid.flange_radius - solid.bolt_circle_radius - solid.bolt_face_radius } else { 1.0 },
            "the faces of the bolts reach out of the flange",
            "set a smaller `housing.solid.bolt_circle_diameter_mm` or `housing.solid.bolt_face_diameter_mm`",
        ),
        (
            if bolts { spread - solid.bolt_face_radius } else { 1.0 },
            "the faces of neighbouring bolts overlap",
            "set a smaller `housing.solid.bolt_count` or `housing.solid.bolt_face_diameter_mm`",
        ),
    ];
    let found = rules.into_iter().find(|(room, ..)| !(*room > 0.0))?;
    Some((format!("{} by {}", found.1, mm(-found.0)), found.2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::templates::{TEMPLATES, design};

    /// Every solid that is made too large or too small is rejected with its key, and the shipped machines have
    /// room.
    #[test]
    fn solids_without_room_name_their_key() {
        for template in TEMPLATES {
            let machine = design(template.name).unwrap().machine();
            check(&super::super::bodies::with_windows(&machine)).unwrap();
            let seat = 2.0 * machine.solids.housing.seat_radius / MM;
            let cases = [
                ("housing.solid.body_diameter_mm", 0.9 * seat),
                ("housing.solid.body_diameter_mm", 2.0 * seat),
                ("housing.solid.flange_diameter_mm", 0.9 * seat),
                ("housing.solid.bolt_face_diameter_mm", 0.5 * seat),
                ("housing.solid.bolt_circle_diameter_mm", 2.0 * seat),
                ("housing.solid.flange_thickness_mm", 500.0),
                ("housing.solid.seat_diameter_mm", 0.5 * seat),
                ("carrier.solid.plate_diameter_mm", 0.5 * seat),
                ("carrier.solid.centre_bore_diameter_mm", 0.7 * seat),
                ("carrier.solid.crank_seat_diameter_mm", 0.45 * seat),
                ("carrier.solid.pillar_width_deg", 175.0),
                ("disc.centre_hole_diameter_mm", 0.78 * seat),
            ];
            for (key, value) in cases {
                // Some are refused already where the design is read.
                let Ok(changed) = design(template.name).unwrap().with(key, value) else { continue };
                let machine = super::super::bodies::with_windows(&changed.machine());
                let error = check(&machine).expect_err(key);
                let text = format!("{error} {}", error.help().unwrap_or_default());
                assert!(text.contains("solid.") || text.contains("disc."), "{key}: {text}");
                let section = key.rsplit_once('.').unwrap().0;
                assert!(text.contains(section) || text.contains("disc."), "{key}: {text}");
            }
        }
    }
}
