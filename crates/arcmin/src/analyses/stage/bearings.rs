//! Basic rating lives of eccentric bearings under their forces in static equilibrium, for `check` and `life`.

use std::f64::consts::TAU;

use super::EccentricDrive;
use super::keys::ECCENTRIC;
use super::meshing::{LoadedRing, duty_of};
use crate::analyses::AnalysisError;
use crate::analyses::life::{BearingLife, BearingLives, system_life};
use crate::dynamics::ElasticDiscs;
use crate::machine::{DutyPoint, gcd};
use crate::rig::dynamic_load_rating;
use crate::units::HOUR;

/// Positions over a turn of the input.
const POSITIONS: usize = 72;
/// Positions of `check`, which runs at every change of a design. For 204 stages of random drives the lives differ by
/// at most 4 %, for 190 of them by less than 1 %.
pub(super) const FEW_POSITIONS: usize = 24;

/// Basic rating lives of the eccentric bearings by ISO 281 under their loads in static equilibria over a turn of the input of
/// their stage; damages of the rows of the duty add up. New drive, without friction.
///
/// # Errors
/// [`AnalysisError`] where a static equilibrium is not found.
pub(super) fn bearing_lives(
    design: &impl EccentricDrive,
    discs: &[ElasticDiscs],
) -> Result<BearingLives, AnalysisError> {
    let bearings: Vec<BearingLife> =
        lives_by_stage(design, discs, POSITIONS)?.into_iter().flatten().collect();
    Ok(BearingLives { system_h: system_life(&bearings), bearings, assumed_friction: None })
}

/// [`bearing_lives`], separately for each stage, at `positions` positions over a turn of the input; with errors over
/// the turns after which all parts are in the same position again.
///
/// # Errors
/// As [`bearing_lives`].
pub(super) fn lives_by_stage<D: EccentricDrive>(
    design: &D,
    discs: &[ElasticDiscs],
    positions: usize,
) -> Result<Vec<Vec<BearingLife>>, AnalysisError> {
    let several = D::STAGES.iter().filter(|stage| stage.parts[ECCENTRIC].is_some()).count() > 1;
    let rings = design.rings(discs)?.into_iter().zip(D::STAGES);
    let lives = rings.map(|(ring, stage)| {
        let place = if several { format!("{}, ", stage.name) } else { String::new() };
        if stage.parts[ECCENTRIC].is_some() {
            of_ring(design, ring, positions, &place)
        } else {
            Ok(Vec::new())
        }
    });
    lives.collect()
}

/// Rows of a duty with the same forces, and the turns per hour of the eccentric relative to its disc.
fn turns_by_torque(duty: &[DutyPoint], turns: f64) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = Vec::new();
    for row in duty.iter().filter(|row| row.wears()) {
        let per_hour = row.share * (row.input_speed.abs() / TAU * turns) * HOUR;
        match all.iter_mut().find(|(torque, _)| *torque == row.torque) {
            Some((_, sum)) => *sum += per_hour,
            None => all.push((row.torque, per_hour)),
        }
    }
    all
}

fn of_ring(
    design: &impl EccentricDrive,
    ring: LoadedRing<'_>,
    positions: usize,
    place: &str,
) -> Result<Vec<BearingLife>, AnalysisError> {
    let LoadedRing { of, mut meshing, parts, .. } = ring;
    let bearing = &parts.eccentric;
    // At tips contacts end abruptly: positions at which every pin is at the same place could miss this.
    let pins = of.mesh.profile.pin_count;
    let positions = match of.mesh.profile.tip() {
        Some(_) => (positions..).find(|count| gcd(*count, pins) == 1).unwrap_or(positions),
        None => positions,
    };
    let (power, rating) = (bearing.kind.life_exponent(), dynamic_load_rating(bearing));
    let (mut damage, mut turns) = (vec![0.0; of.discs], 0.0);
    for (torque, per_hour) in turns_by_torque(&duty_of(design, &of), parts.turns) {
        turns += per_hour;
        let mut start: Option<Vec<f64>> = None;
        for step in 0..positions {
            let angle = meshing.position(TAU, step, positions);
            let (rest, _) = meshing
                .rest(angle, torque, start.as_deref())
                .map_err(AnalysisError::compute("find the loads of the bearings"))?;
            for (disc, damage) in damage.iter_mut().enumerate() {
                let force = meshing.joints().eccentric_force(disc, &rest);
                *damage += per_hour / positions as f64 * (force / rating).powf(power) / 1e6;
            }
            start = Some(meshing.deviation(angle, &rest));
        }
    }
    let life = |(disc, damage): (usize, &f64)| BearingLife {
        name: format!("{place}eccentric, disc {}", disc + 1),
        equivalent: rating * (1e6 * damage / turns).powf(1.0 / power),
        rating,
        life_h: 1.0 / damage,
    };
    Ok(damage.iter().enumerate().filter(|(_, damage)| **damage > 0.0).map(life).collect())
}

/// `check` and `life` agree within 5 % for every stage, and the message has the hours.
#[cfg(test)]
pub(super) fn agree<D: EccentricDrive>(design: &D) {
    let found = design.findings();
    let found: Vec<_> = found.iter().filter(|finding| finding.code == "eccentric-bearing-life").collect();
    let stages = lives_by_stage(design, &[], POSITIONS).unwrap();
    let lives: Vec<f64> = (stages.iter().filter(|lives| !lives.is_empty()))
        .map(|lives| lives.iter().map(|life| life.life_h).fold(f64::INFINITY, f64::min))
        .collect();
    assert_eq!(found.len(), lives.len(), "{}", design.text());
    for (finding, life) in found.into_iter().zip(lives) {
        assert!((finding.value / life - 1.0).abs() < 0.05, "{} {life}\n{}", finding.value, design.text());
        assert!(finding.message.contains(&format!("{:.0} h of the duty", finding.value)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{StageDesign, TwoRingDesign, TwoStageDesign};
    use crate::rig::rating_life;
    use crate::templates::{NEMA17_19, PRINTED_15, STEEL_59, TWO_RING_225, TWO_STAGE_500};

    #[test]
    fn check_and_life_agree_for_shipped_drives() {
        for template in [NEMA17_19, PRINTED_15, STEEL_59] {
            agree(&StageDesign::parse(template.text, template.file).unwrap());
        }
        agree(&TwoRingDesign::parse(TWO_RING_225.text, "a").unwrap());
        agree(&TwoStageDesign::parse(TWO_STAGE_500.text, "a").unwrap());
    }

    /// Without gaps and with stiff supports the force lies between that across the eccentric, T m/(e z_c), which follows from the
    /// moment about the centre of the ring alone, and the closed form with all pins as equal springs about fixed centres.
    #[test]
    fn a_tight_drive_lives_between_the_closed_forms() {
        let design = StageDesign::parse(NEMA17_19.text, "a").unwrap();
        let design = design
            .with_all([
                ("output_pins.hole_clearance_um", 0.0),
                ("bearings.eccentric.clearance_um", 0.0),
                ("disc.modification.equidistant_offset_um", 0.0),
                ("bearings.input_radial_stiffness_n_per_um", 1e5),
                ("bearings.output_radial_stiffness_n_per_um", 1e5),
            ])
            .unwrap();
        let (stage, rated) = (design.drive(), design.rated());
        let turns = rated.input_speed / TAU * design.eccentric_turns();
        let across = rated.torque / stage.phases.len() as f64 / stage.lever();
        let [shortest, longest] = [stage.eccentric_force(rated.torque), across]
            .map(|force| rating_life(&stage.eccentric, force, turns) / HOUR);
        let found = bearing_lives(&design, &[]).unwrap().worst().unwrap().life_h;
        assert!(shortest < found && found < 1.001 * longest, "{shortest} {found} {longest}");
    }

    /// Rows of one torque are one set of static equilibria; damages add up by hand over rows of other torques.
    #[test]
    fn damages_of_rows_add_up() {
        let with = |duty: &str| {
            let text = format!("{}\n{duty}", NEMA17_19.text);
            bearing_lives(&StageDesign::parse(&text, "a").unwrap(), &[]).unwrap().bearings[0].life_h
        };
        let row = |torque: f64, share: f64, speed: f64| {
            format!("[[duty]]\ntorque_n_m = {torque}\ninput_speed_rpm = {speed}\nshare = {share}\n")
        };
        let alone = [(3.0, 600.0), (1.5, 900.0)].map(|(torque, speed)| with(&row(torque, 1.0, speed)));
        let both = with(&(row(3.0, 0.25, 600.0) + &row(1.5, 0.5, 900.0) + &row(3.0, 0.25, 600.0)));
        let closed = 1.0 / (0.5 / alone[0] + 0.5 / alone[1]);
        assert!((both / closed - 1.0).abs() < 1e-9, "{both} {closed}");
    }

    /// A drive whose overlap exceeds its compliance has no life; the finding states the reason.
    #[test]
    fn a_drive_that_jams_has_no_bearing_life() {
        let design = StageDesign::parse(NEMA17_19.text, "a").unwrap();
        let jammed = design.with_all([("disc.modification.equidistant_offset_um", -300.0)]).unwrap();
        let findings = jammed.findings();
        let found = findings.iter().find(|finding| finding.code == "eccentric-bearing-life").unwrap();
        assert_eq!(found.severity, crate::checks::Severity::Warning);
        assert!(found.message.contains("the drive jams"), "{}", found.message);
    }
}
