//! Checks of drives of eccentrics.

use super::bearings::{FEW_POSITIONS, lives_by_stage};
use super::drive::{EccentricDrive, Efficiency};
use super::keys::StageKeys;
use super::strength::{Loads, Strength};
use crate::analyses::AnalysisError;
use crate::analyses::life::BearingLife;
use crate::checks::{
    Finding, Severity, Teeth, balance, defaults, ligament, newton_metres, rim, severity_if, unknowns,
};
use crate::design::{Family, StageDesign, TwoRingDesign, TwoStageDesign};
use crate::geometry::Relief;
use crate::machine::{Bore, RingMesh, RingPartner, RingProfile};
use crate::units::{DEG, HOUR, MM, MPA, UM};

/// All checks of a single stage; those of teeth, bores and eccentrics are those of RV reducers.
pub(super) fn of_single_stage(design: &StageDesign, strength: &Strength) -> Vec<Finding> {
    let stage = design.drive();
    let mut all = of_mesh(&stage.mesh, &stage.openings);
    all.push(contact_pressure(design, strength));
    all.extend(strength.findings());
    all.extend(bearing_life(design));
    all.push(balance(
        &stage.phases,
        stage.disc.0 * stage.profile.eccentricity,
        design.rated().input_speed,
        Some(*design.disc.width_mm * MM),
    ));
    all.push(defaults(&design.defaulted()));
    all.extend(unknowns(&design.unknowns(), &design.unknowns));
    all.extend(unused(design.unused(), Family::Eccentric));
    all
}

/// All checks of a drive of two rings.
pub(super) fn of_two_rings(design: &TwoRingDesign, strength: &Strength) -> Vec<Finding> {
    let (drive, rated) = (design.drive(), design.rated());
    let mut all = Vec::new();
    for (mesh, keys) in drive.meshes.iter().zip(TwoRingDesign::STAGES) {
        all.extend(of_mesh(mesh, &drive.openings).into_iter().map(named(keys.name)));
    }
    all.push(contact_pressure(design, strength));
    all.extend(strength.findings());
    let unbalance = drive.disc.0 * drive.meshes[0].profile.eccentricity;
    all.extend(bearing_life(design));
    all.push(balance(&drive.phases, unbalance, rated.input_speed, Some(drive.widths[0] + drive.widths[1])));
    let efficiency = drive.efficiency(rated.torque, &design.friction().0);
    let losses = 1.0 / efficiency - 1.0;
    all.extend([back_driving(Efficiency::of(losses), design.friction().1), leaning(design)]);
    all.push(defaults(&design.defaulted()));
    all.extend(unknowns(&design.unknowns(), &design.unknowns));
    all.extend(unused(design.unused(), Family::TwoRing));
    all
}

/// All checks of two stages in series.
pub(super) fn of_two_stages(design: &TwoStageDesign, strength: &Strength) -> Vec<Finding> {
    let (drive, rated) = (design.drive(), design.rated());
    let speeds = [rated.input_speed, rated.input_speed / drive.first.ratio().abs()];
    let widths = [*design.first_stage.disc.width_mm * MM, *design.disc.width_mm * MM];
    let mut all = Vec::new();
    for (k, stage) in [&drive.first, &drive.second].into_iter().enumerate() {
        let unbalance = stage.disc.0 * stage.profile.eccentricity;
        let balance = balance(&stage.phases, unbalance, speeds[k], Some(widths[k]));
        let of_stage = of_mesh(&stage.mesh, &stage.openings).into_iter().chain([balance]);
        all.extend(of_stage.map(named(TwoStageDesign::STAGES[k].name)));
    }
    all.extend(bearing_life(design));
    all.push(contact_pressure(design, strength));
    all.extend(strength.findings());
    all.push(defaults(&design.defaulted()));
    all.extend(unknowns(&design.unknowns(), &design.unknowns));
    all.extend(unused(design.unused(), Family::TwoStage));
    all
}

/// Adds the ring or stage to the message.
fn named(place: &'static str) -> impl Fn(Finding) -> Finding {
    move |finding| Finding { message: format!("{place}: {}", finding.message), ..finding }
}

/// Flank, ring and openings of a disc.
fn of_mesh(mesh: &RingMesh, openings: &[Bore]) -> Vec<Finding> {
    let profile = &mesh.profile;
    let ring = mesh.ring_profile();
    let teeth = Teeth {
        profile,
        pin_circle_radius: mesh.ring_circle_radius,
        pin_radius: mesh.ring_pin_radius,
        partner: mesh.partner(),
    };
    let reach = openings.iter().map(|opening| opening.centre_radius + opening.radius).fold(0.0, f64::max);
    let mut all = teeth.check();
    all.extend(ring.map(|ring| ring_arcs(mesh, &ring)));
    all.push(rim(profile, mesh.ring_pin_radius, "the outermost opening", reach));
    all.extend(ligament(openings));
    all.push(interference(mesh));
    all
}

/// Extent of the arcs of a ring of one piece, and of their contact with lobes.
fn ring_arcs(mesh: &RingMesh, ring: &RingProfile) -> Finding {
    let (arc, touched) = (ring.arc / DEG, ring.touched / DEG);
    Finding {
        code: "ring-arcs",
        severity: severity_if(arc < touched, Severity::Error),
        message: format!(
            "the ring is one part: {} arcs of {:.3} mm extend {arc:.1}° to either side of their innermost points, \
                 lobes touch them up to \
             {touched:.1}°",
            mesh.profile.pin_count,
            mesh.ring_pin_radius / MM
        ),
        value: arc,
        limit: touched,
        unit: "°",
        why: "beyond the end of an arc the profile of the ring is not conjugate to the disc",
        change: "a smaller pin radius, or a larger pin circle",
    }
}

/// Efficiency by the closed form with equal springs, and whether the output can drive the input.
fn back_driving(Efficiency { forward, backward }: Efficiency, assumed: bool) -> Finding {
    let assumed = if assumed { ", with assumed coefficients of friction" } else { "" };
    let back = match backward > 0.0 {
        true => format!("{backward:.2} with the output driving"),
        false => "the output cannot drive the input".to_owned(),
    };
    Finding {
        code: "back-driving",
        severity: Severity::Info,
        message: format!("efficiency {forward:.2} at rated torque, {back}{assumed}"),
        value: backward,
        limit: 0.0,
        unit: "",
        why: "losses grow with the ratio, because both rings slide for little motion of the output; below one half the drive \
              holds by itself",
        change: "pins in needle bearings, or a smaller ratio",
    }
}

/// The couple of the two rings on a stepped disc.
fn leaning(design: &TwoRingDesign) -> Finding {
    let (drive, torque) = (design.drive(), design.rated().torque);
    let couple = drive.leaning_couple(torque);
    Finding {
        code: "leaning-couple",
        severity: Severity::Info,
        message: format!(
            "the rings load a stepped disc with a couple of {}, which its eccentric bearing must carry in addition \
                 to its radial load; its \
             life leaves the couple out",
            newton_metres(couple)
        ),
        value: couple,
        limit: 0.0,
        unit: "N·m",
        why: "the forces of the two rings act in opposite directions, in planes half the sum of both widths apart; \
             the plane model neglects this",
        change: "an eccentric bearing of two rows, narrower steps, or a step of the second ring between two halves of the first",
    }
}

/// Words for the ring pins or ring teeth of all stages.
pub(super) fn ring_of(design: &impl EccentricDrive) -> RingPartner {
    RingPartner::of(design.meshes().into_iter().map(|mesh| mesh.mounting))
}

fn least_gap(mesh: &RingMesh) -> f64 {
    let on_flank = Relief::grid(720).filter(|phi| mesh.profile.is_usable(phi.cos()));
    on_flank.map(|phi| mesh.gap(phi)).fold(f64::INFINITY, f64::min)
}

/// The least gap between flank and ring pins in the nominal position.
fn interference(mesh: &RingMesh) -> Finding {
    let gap = least_gap(mesh);
    let overlaps = gap < -ROUNDING;
    let ring = mesh.partner();
    Finding {
        code: "interference",
        severity: severity_if(overlaps, Severity::Warning),
        message: match overlaps {
            true => {
                format!("flank and {} overlap by up to {:.1} µm without load", ring.all_of_ring(), -gap / UM)
            }
            false => {
                format!("the least gap between flank and {} is {:.1} µm", ring.all_of_ring(), gap / UM)
            }
        },
        value: gap / UM,
        limit: 0.0,
        unit: "µm",
        why: "discs that overlap the ring must be assembled by force and are loaded all around without torque",
        change: "a larger equidistant offset, or a smaller radial offset",
    }
}

/// Gaps below this in m are rounding.
const ROUNDING: f64 = 1e-9;

/// Largest Hertz pressure of the ring pins at the largest torque of rating and duty, by static equilibria over a turn of the input.
fn contact_pressure(design: &impl EccentricDrive, strength: &Strength) -> Finding {
    let limit = design.limits().contact_pressure / MPA;
    let (severity, message, value) = match strength.loads() {
        Ok(Loads { hardest: [pressure, force], .. }) => {
            let pressure = pressure / MPA;
            let message = format!(
                "the largest pressure of {} at {} N·m is {pressure:.0} MPa, under {force:.0} N",
                ring_of(design).all_of_ring(),
                strength.torque
            );
            (severity_if(pressure > limit, Severity::Error), message, pressure)
        }
        Err(why) => (Severity::Warning, format!("no pressure and no stress can be computed: {why}"), 0.0),
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

/// Reason why there is no equilibrium: the drive jams, or the solver has not found one.
pub(super) fn no_rest(design: &impl EccentricDrive, error: &AnalysisError) -> String {
    let gap = design.meshes().iter().map(least_gap).fold(f64::INFINITY, f64::min);
    let ring = ring_of(design);
    let by_ring = (gap < -ROUNDING)
        .then(|| format!("flank and {} overlap by up to {:.1} µm", ring.all_of_ring(), -gap / UM));
    let by_chain = || {
        let overlap = design.gap_chain().overlap(&design.errors())?;
        Some(format!("it overlaps by {:.1} µm at the {}", overlap.depth / UM, overlap.place.words(ring)))
    };
    match by_ring.or_else(by_chain) {
        Some(overlap) => format!("the drive jams, {overlap}, and has no equilibrium under load"),
        None => error.to_string(),
    }
}

/// Shortest L10 by ISO 281 of the eccentric bearings of each stage, as in `life`; empty if no row of the duty turns
/// under load.
fn bearing_life<D: EccentricDrive>(design: &D) -> Vec<Finding> {
    let limit = design.limits().service_life / HOUR;
    let finding = |severity: Severity, message: String, value: f64| Finding {
        code: "eccentric-bearing-life",
        severity,
        message,
        value,
        limit,
        unit: "h",
        why: "the eccentric bearing carries the torque over a short lever arm and turns with the input; it is often \
             the first part to fail",
        change: "a larger eccentric bearing, more discs, more eccentricity, or a larger circle of output pins",
    };
    match lives_by_stage(design, &[], FEW_POSITIONS) {
        Ok(stages) => {
            let several = stages.iter().filter(|lives| !lives.is_empty()).count() > 1;
            let of_stage = |(lives, stage): (Vec<BearingLife>, &StageKeys)| {
                let worst = lives.into_iter().min_by(|a, b| a.life_h.total_cmp(&b.life_h))?;
                let place = if several { format!("{}: ", stage.name) } else { String::new() };
                let message = format!(
                    "{place}the eccentric bearings reach their basic rating life L10 after {:.0} h of the duty, under an equivalent \
                     load of {:.0} N",
                    worst.life_h, worst.equivalent
                );
                Some(finding(severity_if(worst.life_h < limit, Severity::Warning), message, worst.life_h))
            };
            stages.into_iter().zip(D::STAGES).filter_map(of_stage).collect()
        }
        Err(error) => {
            let why = no_rest(design, &error);
            let message = format!("no life of the eccentric bearings can be computed: {why}");
            vec![finding(Severity::Warning, message, 0.0)]
        }
    }
}

/// Keys of the file that no analysis of the family uses.
fn unused(given: &[&str], family: Family) -> Option<Finding> {
    (!given.is_empty()).then(|| Finding {
        code: "unused-keys",
        severity: Severity::Warning,
        message: format!("no analysis of a {} uses these keys: {}", family.drive(), given.join(", ")),
        value: given.len() as f64,
        limit: 0.0,
        unit: "",
        why: "these keys have no effect on any result",
        change: "no change is needed; the keys are read and checked for their range only",
    })
}
