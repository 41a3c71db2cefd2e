//! The drawing of a machine, and its findings as a table.

use super::{
    Block, Column, CrankshaftDrawing, ForceState, GearStageDrawing, Hole, Mechanism, Table, compact,
};
use crate::checks::{Finding, Severity};
use crate::load::Cycle;
use crate::machine::Machine;
use crate::units::DEG;

/// The drawing of a machine with the forces of load-sharing cycles; positions of each cycle must be
/// equidistant over one pin pitch.
pub fn mechanism(machine: &Machine, states: &[(String, &Cycle)]) -> Mechanism {
    /// Points per lobe: chords stay within 2 µm of the flank of the sizes in use.
    const LOBE_POINTS: usize = 60;
    const MM_PER_M: f64 = 1e3;
    let profile = machine.profile();
    let kinematics = machine.kinematics();
    let lobe = std::f64::consts::TAU / profile.lobe_count() as f64;
    let lobe_mm = (0..LOBE_POINTS)
        .map(|i| {
            let point = profile.flank_point(lobe * i as f64 / LOBE_POINTS as f64);
            [point.x * MM_PER_M, point.y * MM_PER_M]
        })
        .collect();
    let places: Vec<f64> = (0..machine.crankshafts.count)
        .map(|index| {
            crate::machine::Kinematics::crankshaft_angle(
                machine.crankshafts.first_angle,
                index,
                machine.crankshafts.count,
            )
        })
        .collect();
    let circle_radius = machine.gear_stage.centre_distance();
    let hole = |radius: f64, at_radius: f64, angle: f64| Hole {
        x_mm: at_radius * angle.cos() * MM_PER_M,
        y_mm: at_radius * angle.sin() * MM_PER_M,
        radius_mm: radius * MM_PER_M,
    };
    let mut holes: Vec<Hole> =
        places.iter().map(|angle| hole(machine.disc.crank_bore_radius, circle_radius, *angle)).collect();
    holes.push(hole(machine.disc.centre_hole_radius, 0.0, 0.0));
    holes.extend(
        machine.disc.holes.iter().map(|bore| hole(bore.radius, bore.centre_radius, bore.centre_angle)),
    );
    let ring = machine.ring.pin_circle_radius;
    let forces = |cycle: &Cycle| {
        (0..kinematics.phases.len())
            .map(|disc| {
                let row = |contacts: &Vec<crate::contact::PinContact>| {
                    let mut row = vec![0.0; machine.ring.pin_count];
                    for contact in contacts {
                        row[contact.pin] = contact.force;
                    }
                    row
                };
                cycle.positions.iter().filter_map(|position| position.discs.get(disc)).map(row).collect()
            })
            .collect()
    };
    let eccentric_radius = machine.disc.crank_bore_radius
        - machine.bearings.turning_arm.roller_diameter
        - 0.5 * machine.bearings.turning_arm.clearance;
    Mechanism {
        title: format!("{}, seen from the output side", machine.name),
        note: format!(
            "To scale. Contact forces of the load-sharing equilibrium at {} N·m; the arrows act on the disc, their lines of action meet in the \
             pitch point. Elastic approach and wear (micrometres) do not show at this scale. The outer radius of the housing is not part of \
             the design and drawn schematically.",
            compact(machine.rated.torque, 4)
        ),
        pin_circle_radius_mm: ring * MM_PER_M,
        pin_radius_mm: machine.ring.pin_radius * MM_PER_M,
        pin_count: machine.ring.pin_count,
        lobe_count: profile.lobe_count(),
        eccentricity_mm: machine.crankshafts.eccentricity * MM_PER_M,
        housing_outer_radius_mm: (1.08 * ring + 2.0 * machine.ring.pin_radius) * MM_PER_M,
        lobe_mm,
        eccentric_phase_deg: kinematics.phases.iter().map(|phase| phase / DEG).collect(),
        holes,
        crankshafts: CrankshaftDrawing {
            circle_radius_mm: circle_radius * MM_PER_M,
            place_deg: places.iter().map(|angle| angle / DEG).collect(),
            shaft_radius_mm: 0.5 * machine.crankshafts.shaft_diameter * MM_PER_M,
            // A design may leave the bearing out; the eccentric is then drawn as the bore.
            eccentric_radius_mm: if eccentric_radius > 0.0 {
                eccentric_radius
            } else {
                machine.disc.crank_bore_radius
            } * MM_PER_M,
        },
        gear_stage: GearStageDrawing {
            sun_teeth: machine.gear_stage.sun_teeth,
            planet_teeth: machine.gear_stage.planet_teeth,
            sun_pitch_radius_mm: machine.gear_stage.sun_pitch_radius() * MM_PER_M,
            planet_pitch_radius_mm: machine.gear_stage.planet_pitch_radius() * MM_PER_M,
        },
        input_speed_rpm: machine.rated.input_speed / crate::units::RPM,
        states: states
            .iter()
            .map(|(label, cycle)| ForceState { label: label.clone(), force_n: forces(cycle) })
            .collect(),
    }
}

/// Table of the warnings and errors, worst first.
pub fn findings_table(findings: &[Finding]) -> Block {
    let mut shown: Vec<&Finding> =
        findings.iter().filter(|finding| finding.severity > Severity::Info).collect();
    shown.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let rows = shown
        .iter()
        .map(|finding| {
            let amount = |value: f64| {
                compact(value, 4) + if finding.unit.is_empty() { "" } else { " " } + finding.unit
            };
            vec![
                finding.severity.word().to_owned(),
                format!("`{}`", finding.code),
                format!("{} {}", finding.message, finding.why),
                amount(finding.value),
                amount(finding.limit),
                finding.change.to_owned(),
            ]
        })
        .collect();
    Block::Table(Table {
        title: "Warnings and errors".into(),
        columns: vec![
            Column::text("Verdict"),
            Column::text("Code"),
            Column::text("Finding and reason"),
            Column::number("Value", ""),
            Column::number("Limit", ""),
            Column::text("Remedy"),
        ],
        rows,
        note: format!("{} checks were made; the others are passed.", findings.len()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Relief;
    use crate::machine::CrankAngle;
    use crate::templates::tao2024;
    use crate::units::UM;

    /// The drawing's rule, normals through the pitch point a·z_p·e(θ_k + α), carries the torque: 0.4815 T on each
    /// disc of the new machine.
    #[test]
    fn drawn_forces_balance_the_torque() {
        let machine = tao2024();
        let cycle = machine.meshing(&Relief::uniform(0.0)).cycle(machine.rated.torque, 6).expect("solvable");
        let drawing = mechanism(&machine, &[("new".to_owned(), &cycle)]);
        let pins = drawing.pin_count;
        for (disc, phase) in drawing.eccentric_phase_deg.iter().enumerate() {
            for (step, forces) in drawing.states[0].force_n[disc].iter().enumerate() {
                let crank = std::f64::consts::TAU / pins as f64 * step as f64
                    / drawing.states[0].force_n[disc].len() as f64
                    + phase * DEG;
                let pitch_point = crate::geometry::unit(crank) * drawing.eccentricity_mm * pins as f64;
                let centre = crate::geometry::unit(crank) * drawing.eccentricity_mm;
                let moment: f64 = forces
                    .iter()
                    .enumerate()
                    .map(|(pin, force)| {
                        let place = crate::geometry::unit(std::f64::consts::TAU * pin as f64 / pins as f64)
                            * drawing.pin_circle_radius_mm;
                        let normal = (pitch_point - place).normalize();
                        crate::geometry::cross(place - centre, normal) * 1e-3 * force
                    })
                    .sum();
                // Micrometres of elastic approach tilt the normals by some 1e-4.
                assert!(
                    (moment / (0.48148 * machine.rated.torque) - 1.0).abs() < 2e-3,
                    "disc {disc}, step {step}: {moment}"
                );
            }
        }
    }

    /// One pin pitch later the same forces act on the next pin, so that the drawing can turn with the data of
    /// one pitch.
    #[test]
    fn forces_move_on_by_one_pin_per_pitch() {
        let machine = tao2024();
        let meshing = machine.meshing(&Relief::uniform(3.0 * UM));
        let at = |crank: f64| meshing.load_sharing(CrankAngle::from_radians(crank), 412.0).expect("solvable");
        let pitch = meshing.kinematics().pattern_period();
        let force = |position: &crate::load::LoadSharing, pin: usize| {
            position.discs[1].iter().find(|contact| contact.pin == pin).map_or(0.0, |contact| contact.force)
        };
        let (here, later) = (at(0.05), at(0.05 + pitch));
        for pin in 0..40 {
            let (before, after) = (force(&here, pin), force(&later, (pin + 1) % 40));
            assert!((before - after).abs() < 1e-5 * 412.0, "pin {pin}: {before} N, then {after} N");
        }
    }
}
