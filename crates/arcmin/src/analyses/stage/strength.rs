//! Stresses of the parts of a drive compared with the strength of their materials, and the torques at which the
//! limits are reached.

mod heat;
mod order;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::contact::{self, OutputContact, StageContacts};
use super::drive::EccentricDrive;
use super::findings::no_rest;
use super::keys::{ECCENTRIC, StageKeys};
use crate::analyses::{AnalysisError, NoHost};
use crate::checks::sections::{SectionStress, between, lobe, web};
use crate::checks::{Finding, Severity, severity_if};
use crate::design::{DiscSection, RingSection};
use crate::geometry::{Vec2, unit};
use crate::machine::{Bore, PinBeam, PinStress, RingMesh, RingPartner, SingleStage};
use crate::materials::{LINE_CONTACT_YIELD, Material};
use crate::units::MPA;

pub use heat::HeatBalance;
pub use order::FAILURES;

/// Bodies of a stage for its stresses.
pub struct StageBody<'a> {
    /// Flank and ring of the stage.
    pub mesh: &'a RingMesh,
    /// Face width of a disc in m.
    pub width: f64,
    /// Discs of the stage.
    pub discs: usize,
    /// Material of the discs.
    pub disc: &'a Material,
    /// Material of the ring pins.
    pub ring: &'a Material,
    /// The bore of the eccentric bearing, the holes of the output pins, others.
    pub openings: &'a [Bore],
    /// Output pins: their number, and one as a beam.
    pub pins: Option<(usize, &'a PinBeam)>,
}

impl<'a> StageBody<'a> {
    pub(super) fn of(stage: &'a SingleStage, disc: &'a DiscSection, ring: &'a RingSection) -> StageBody<'a> {
        StageBody {
            mesh: &stage.mesh,
            width: *disc.width_mm * crate::units::MM,
            discs: stage.phases.len(),
            disc: &disc.material,
            ring: &ring.material,
            openings: &stage.openings,
            pins: Some((stage.output_pins.count, &stage.pin_beam)),
        }
    }
}

/// A part with the kind of its load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bearing {
    /// Hertz pressure of ring pins on flanks.
    RingContact,
    /// Hertz pressure of output pins in holes.
    OutputContact,
    /// Bending of lobes at their roots.
    LobeBending,
    /// Shear of lobes at their roots.
    LobeShear,
    /// Bending of the walls beside openings.
    WebBending,
    /// Shear of the walls beside openings.
    WebShear,
    /// Bending of output pins.
    PinBending,
    /// Shear of output pins.
    PinShear,
}

impl Bearing {
    /// Part and kind of load, for readers.
    pub fn words(self, ring: RingPartner) -> [&'static str; 2] {
        match self {
            Bearing::RingContact => match ring {
                RingPartner::Pins => ["ring pins on flanks", "contact"],
                RingPartner::Teeth => ["ring teeth on flanks", "contact"],
                RingPartner::Both => ["ring pins and teeth on flanks", "contact"],
            },
            Bearing::OutputContact => ["output pins in holes", "contact"],
            Bearing::LobeBending => ["lobes", "bending"],
            Bearing::LobeShear => ["lobes", "shear"],
            Bearing::WebBending => ["walls beside openings", "bending"],
            Bearing::WebShear => ["walls beside openings", "shear"],
            Bearing::PinBending => ["output pins", "bending"],
            Bearing::PinShear => ["output pins", "shear"],
        }
    }
}

/// Stress of one part under a torque.
#[derive(Debug, Clone, PartialEq)]
pub struct Borne {
    /// Number of the stage from the input.
    pub stage: usize,
    /// Part and kind of load.
    pub bearing: Bearing,
    /// Ring partner (pins or teeth) of its stage.
    pub ring: RingPartner,
    /// Pa.
    pub stress: f64,
    /// At which it yields, Pa.
    pub limit: f64,
    /// Material; for contacts the softer one.
    pub material: String,
}

impl Borne {
    /// Stress over its limit.
    pub fn share(&self) -> f64 {
        self.stress / self.limit
    }
}

/// Loads in static equilibria over a turn of the input.
#[derive(Debug, Clone)]
pub(super) struct Loads {
    /// The ring pin with the largest pressure (Pa), and its force (N).
    pub hardest: [f64; 2],
    borne: Vec<Borne>,
}

/// Stresses of the parts of a drive.
#[derive(Debug, Clone)]
pub struct Strength {
    stages: &'static [StageKeys],
    /// The largest torque of rating and duty, N·m.
    pub torque: f64,
    /// Loads under that torque, or the reason why there is no equilibrium.
    borne: Result<Loads, String>,
    /// Torque (N·m) at which each part of `borne` reaches its limit; `None` beyond the computed torques; empty if
    /// they were not computed.
    pub torques: Vec<Option<f64>>,
    /// Materials without yield strength.
    unknown: Vec<String>,
    /// Heat balance of the running drive, or the reason why there is none.
    pub heat: Result<HeatBalance, String>,
}

/// Positions over a turn of the input.
const POSITIONS: usize = 24;

/// Stresses under an output torque in N·m, in static equilibria over a turn of the input.
fn loads(design: &impl EccentricDrive, torque: f64) -> Result<Loads, AnalysisError> {
    let options = contact::Options { torque_nm: Some(torque), ..contact::Options::of_positions(POSITIONS) };
    let contact = contact::run(design, &options, &NoHost)?;
    let mut all = Vec::new();
    for (k, body) in design.bodies().iter().enumerate() {
        let eccentric = contact.turn.iter().map(|at| at.forces[k][ECCENTRIC]).fold(0.0, f64::max);
        all.extend(
            body.borne(&contact.stages[k], eccentric).into_iter().map(|one| Borne { stage: k, ..one }),
        );
    }
    let pins = contact.stages.iter().flat_map(|stage| &stage.ring);
    let hardest = pins.max_by(|a, b| a.pressure.total_cmp(&b.pressure));
    Ok(Loads { hardest: hardest.map_or([0.0; 2], |pin| [pin.pressure, pin.force]), borne: all })
}

impl StageBody<'_> {
    fn borne(&self, contacts: &StageContacts, eccentric: f64) -> Vec<Borne> {
        let mut all = Vec::new();
        let mut add = |bearing: Bearing, stress: f64, limit: f64, materials: &[&Material]| {
            let strengths = materials.iter().map(|material| Some((material.yield_strength?, &material.name)));
            let known: Option<Vec<(f64, &String)>> = strengths.collect();
            let softest = known.and_then(|known| known.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)));
            all.extend(softest.map(|(strength, name)| Borne {
                stage: 0,
                bearing,
                ring: self.mesh.partner(),
                stress,
                limit: limit * strength,
                material: name.clone(),
            }));
        };
        // Shear stress at which a material yields by von Mises.
        let shear = 1.0 / 3.0_f64.sqrt();
        let pressure = contacts.ring.iter().map(|c| c.pressure).fold(0.0, f64::max);
        add(Bearing::RingContact, pressure, LINE_CONTACT_YIELD, &[self.disc, self.ring]);
        let lobes = contacts.ring.iter().fold(SectionStress::default(), |most, c| {
            most.or(lobe(&self.mesh.profile, c.meshing_angle, c.force, self.width))
        });
        add(Bearing::LobeBending, lobes.bending, 1.0, &[self.disc]);
        add(Bearing::LobeShear, lobes.shear, shear, &[self.disc]);
        let webs = self.webs(contacts, eccentric);
        add(Bearing::WebBending, webs.bending, 1.0, &[self.disc]);
        add(Bearing::WebShear, webs.shear, shear, &[self.disc]);
        if let Some((_, beam)) = self.pins {
            let pressure = contacts.output.iter().map(|c| c.pressure).fold(0.0, f64::max);
            add(Bearing::OutputContact, pressure, LINE_CONTACT_YIELD, &[self.disc, &beam.material]);
            let pins = self.pin_stress(beam, &contacts.output);
            add(Bearing::PinBending, pins.bending, 1.0, &[&beam.material]);
            add(Bearing::PinShear, pins.shear, shear, &[&beam.material]);
        }
        all
    }

    /// Every pin at every position under the forces of all discs.
    fn pin_stress(&self, beam: &PinBeam, contacts: &[OutputContact]) -> PinStress {
        let mut forces: BTreeMap<(u64, usize), Vec<Vec2>> = BTreeMap::new();
        for c in contacts {
            let discs = forces
                .entry((c.crank_angle.to_bits(), c.pin))
                .or_insert_with(|| vec![Vec2::zeros(); self.discs]);
            discs[c.disc] -= c.force * unit(c.direction);
        }
        let stresses = forces.values().map(|forces| beam.stress(forces));
        stresses.fold(PinStress { bending: 0.0, shear: 0.0 }, |most, one| PinStress {
            bending: most.bending.max(one.bending),
            shear: most.shear.max(one.shear),
        })
    }

    /// The metal between openings and the flank, and between openings.
    fn webs(&self, contacts: &StageContacts, eccentric: f64) -> SectionStress {
        let Some((bore, others)) = self.openings.split_first() else { return SectionStress::default() };
        let pins = self.pins.map_or(0, |(count, _)| count);
        let root = self.mesh.profile.root_radius();
        // Force of an output pin: outward, along its circle, in any direction.
        let largest = |of: fn(&OutputContact) -> f64| contacts.output.iter().map(of).fold(0.0, f64::max);
        let outward = largest(|c| c.force * c.around.cos());
        let along = largest(|c| c.force * c.around.sin().abs());
        let any = largest(|c| c.force);
        // The bearing loads half of its bore, p = 4 F/(π d B) cos; this is the part over the width of an opening.
        let pressed = |opening: &Bore| eccentric * (4.0 / PI * opening.radius / bore.radius).min(1.0);
        let mut most = SectionStress::default();
        let mut add = |span: f64, thickness: f64, force: f64| {
            most = most.or(web(span, [thickness, self.width], force));
        };
        for (i, opening) in others.iter().enumerate() {
            let is_hole = i < pins;
            if opening.centre_radius > 0.0 {
                let by_ring = self.pressed_inward(contacts, opening);
                let force = if is_hole { by_ring.max(outward) } else { by_ring };
                add(2.0 * opening.radius, root - opening.centre_radius - opening.radius, force);
            }
            add(2.0 * opening.radius, between(bore, opening), pressed(opening));
            for (j, other) in others[..i].iter().enumerate() {
                let force = match (is_hole, j < pins) {
                    (true, true) => along,
                    (false, false) => 0.0,
                    _ => any,
                };
                if force > 0.0 {
                    add(2.0 * opening.radius.min(other.radius), between(opening, other), force);
                }
            }
        }
        most
    }

    /// Largest sum (N) of the radial forces of neighbouring ring pins over the width of an opening, which passes all
    /// pins as the disc turns.
    fn pressed_inward(&self, contacts: &StageContacts, opening: &Bore) -> f64 {
        let profile = &self.mesh.profile;
        let count = profile.pin_count;
        let half = if opening.radius < opening.centre_radius {
            (opening.radius / opening.centre_radius).asin()
        } else {
            FRAC_PI_2
        };
        let over = (2.0 * half / (TAU / count as f64)).floor() as usize + 1;
        let mut inward: BTreeMap<(u64, usize), Vec<f64>> = BTreeMap::new();
        for c in &contacts.ring {
            let pins = inward.entry((c.crank_angle.to_bits(), c.disc)).or_insert_with(|| vec![0.0; count]);
            pins[c.pin] += c.force * profile.pin_angle(c.meshing_angle).cos();
        }
        let sums = inward.values().flat_map(|pins| {
            (0..count).map(|first| (0..over.min(count)).map(|k| pins[(first + k) % count]).sum::<f64>())
        });
        sums.fold(0.0, f64::max)
    }
}

impl Strength {
    /// Under the largest torque of rating and duty.
    pub fn at_largest_torque(design: &impl EccentricDrive) -> Strength {
        fn stages<D: EccentricDrive>(_: &D) -> &'static [StageKeys] {
            D::STAGES
        }
        let duty = design.duty_points();
        let torque = duty.iter().map(|row| row.torque.abs()).fold(design.rated().torque.abs(), f64::max);
        let mut unknown: Vec<String> = Vec::new();
        for body in design.bodies() {
            let pins = body.pins.map(|(_, beam)| &beam.material);
            for material in [Some(body.disc), Some(body.ring), pins].into_iter().flatten() {
                if material.yield_strength.is_none() && !unknown.contains(&material.name) {
                    unknown.push(material.name.clone());
                }
            }
        }
        Strength {
            stages: stages(design),
            torque,
            borne: loads(design, torque).map_err(|error| no_rest(design, &error)),
            torques: Vec::new(),
            unknown,
            heat: HeatBalance::of(design).map_err(|error| error.to_string()),
        }
    }

    /// The same with the torque at which each part reaches its limit.
    pub fn of(design: &impl EccentricDrive) -> Strength {
        let mut strength = Strength::at_largest_torque(design);
        if let Ok(loads) = &strength.borne {
            strength.torques = order::torques(design, strength.torque, &loads.borne);
        }
        strength
    }

    /// Loads under the torque, or the reason why there is no static equilibrium.
    pub(super) fn loads(&self) -> Result<&Loads, &str> {
        self.borne.as_ref().map_err(String::as_str)
    }

    /// Stresses of the parts; empty where they are not known.
    pub fn borne(&self) -> &[Borne] {
        self.borne.as_ref().map_or(&[], |loads| &loads.borne)
    }

    /// Prefix of a part in drives with several stages.
    fn place(&self, borne: &Borne) -> String {
        match self.stages.len() {
            1 => String::new(),
            _ => format!("{}: ", self.stages[borne.stage].name),
        }
    }

    /// The part of each kind that is nearest to its limit.
    fn finding(
        &self,
        all: &[Bearing],
        code: &'static str,
        why: &'static str,
        change: &'static str,
    ) -> Option<Finding> {
        let of_kind = self.borne().iter().filter(|one| all.contains(&one.bearing));
        let worst = of_kind.max_by(|a, b| a.share().total_cmp(&b.share()))?;
        let [part, load] = worst.bearing.words(worst.ring);
        let yields = if load == "contact" { "yields under its surface" } else { "yields" };
        Some(Finding {
            code,
            severity: severity_if(
                worst.share() > 1.0,
                if load == "contact" { Severity::Warning } else { Severity::Error },
            ),
            message: format!(
                "{}{part} bear {:.1} MPa in {load} at {} N·m; {} {yields} at {:.0} MPa",
                self.place(worst),
                worst.stress / MPA,
                self.torque,
                worst.material,
                worst.limit / MPA
            ),
            value: worst.stress / MPA,
            limit: worst.limit / MPA,
            unit: "MPa",
            why,
            change,
        })
    }

    /// Checks of strength and of temperature.
    pub fn findings(&self) -> Vec<Finding> {
        use Bearing::*;
        let mut all: Vec<Finding> = [
            self.finding(
                &[RingContact, OutputContact],
                "contact-yield",
                "a line contact yields below its surface at 1.67 times the yield strength (Johnson 1985, 6.1): the \
                     shape of the flank \
                 goes; plastics creep below it, the more the warmer they are",
                "wider discs, more or larger pins, a stronger material, or less torque",
            ),
            self.finding(
                &[LobeBending, LobeShear],
                "lobe-strength",
                "a lobe is a short cantilever that the largest force of a ring pin bends at its root; without safety factor, and \
                 without fatigue and notch, which halve what many parts bear",
                "wider discs, fewer lobes, a stronger material, or less torque",
            ),
            self.finding(
                &[WebBending, WebShear],
                "wall-strength",
                "walls beside holes and bore are modelled as clamped beams under the forces of pins or bearing",
                "smaller or fewer holes, thicker walls, wider discs, or less torque",
            ),
            self.finding(
                &[PinBending, PinShear],
                "output-pin-strength",
                "the discs bend the output pins at their supports; fatigue is not included: hardened pins endure \
                     about 300 MPa of alternating bending",
                "thicker or more pins, a plate on both sides, discs nearer to the plate, or less torque",
            ),
        ]
        .into_iter()
        .flatten()
        .collect();
        if !self.unknown.is_empty() {
            let names = self.unknown.join(", ");
            let message =
                format!("the yield strength of {names} is unknown: parts of this material are not checked");
            all.push(unknown("strength-unknown", Severity::Info, message));
        }
        all.extend(self.order_finding());
        all.extend(heat::findings(&self.heat));
        all
    }
}

fn unknown(code: &'static str, severity: Severity, message: String) -> Finding {
    let change =
        "give yield_strength_mpa in an inline table of the material, and a state that is free of jams";
    Finding { severity, ..Finding::warning(code, message, "strength is not checked", change) }
}
