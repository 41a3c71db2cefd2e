//! Force and pressure of every pin; loaded transmission error.

mod closed_form;
mod declared;
mod page;

use declared::ROLLERS;
pub(crate) use declared::{SUMMARY, tables};

use super::rig::with_friction;
use super::{AnalysisError, Attachment, Host, elastic_disc, outcome};
use crate::contact::PinContact;
use crate::design::{Choice, Design, default, default_word, optional, options};
use crate::fidelity::{Fidelity, FidelityOptions, Joints, MachineMeshing, MeshingStart};
use crate::life::{WornState, worn_after};
use crate::load::{Cycle, HarmonicError, LoadSharing, PinLoad, ShareLoad};
use crate::machine::{CrankAngle, Friction, Machine};
use crate::results::quantities::TORSIONAL_STIFFNESS;
use crate::units::UM;

pub(crate) const ABOUT: &str = "Compute force and pressure of every pin over one turn of the crankshaft";
pub(crate) const GUIDE: &str = "Computes how the pins share the output torque over one turn of the crankshaft, with the input \
    locked.\n\nThe method equilibrium solves the equilibrium of forces and moments with the actual gaps \
    of both flanks. The method closed-form is that of Tao2024 (eqs. 5-10), at one crank position and \
    with ideal joints.\n\nManufacturing errors need joints in bearings. Errors of single pins repeat \
    after one output turn. Summary and pins.csv (loads of every pin) then cover the whole output turn; \
    contact.csv contains the first turn of the crankshaft.";
pub(crate) const EXAMPLES: &[&str] = &[
    "arcmin contact my-reducer.toml",
    "arcmin contact my-reducer.toml --torque-nm 100 --wear-um 10",
    "arcmin contact my-reducer.toml --joints bearings --discs elastic --hours 2000",
    "arcmin contact my-reducer.toml --joints bearings --errors drawn --seed 7",
    "arcmin contact my-reducer.toml --joints bearings --friction",
    "arcmin contact my-reducer.toml --method closed-form",
];

options! {
    /// Options of `contact`.
    pub struct Options {
        [fidelity: FidelityOptions]
        /// Method of load sharing.
        method: Method => default_word("equilibrium"),
        /// Output torque; positive torque opposes positive output motion. Left out: the rated torque.
        torque_nm: Option<f64> => optional(-1e7, 1e7),
        /// Uniform wear depth of the whole flank.
        wear_um: f64 => default(0.0, 0.0, 1000.0),
        /// Age of the machine in hours of its duty: flanks, pins, bearings and gears are worn accordingly, with the same
        /// model of the machine.
        hours: f64 => default(0.0, 0.0, 1e7),
        /// With friction, as in steady running at rated speed; needs joints in bearings. Coefficients are assumed if the
        /// design gives none.
        friction: bool => optional(0.0, 0.0),
        /// Crank positions per turn.
        positions: usize => default(360.0, 8.0, 36_000.0),
    }
}

/// How the load is shared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Balance of forces and moments with the real gaps.
    Equilibrium,
    /// Handbook method of Tao2024.
    ClosedForm,
}

impl Choice for Method {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("equilibrium", "equilibrium of forces and moments with the actual gaps"),
        ("closed-form", "closed form of Tao2024"),
    ];
    const VALUES: &'static [Method] = &[Method::Equilibrium, Method::ClosedForm];
}

/// Load sharing of a machine.
#[derive(Debug, Clone)]
pub struct Contact {
    /// Machine whose pins share the load.
    pub machine: Machine,
    /// Joints, bodies and errors.
    pub fidelity: Fidelity,
    /// N·m.
    pub torque: f64,
    /// Its wear of surfaces and parts.
    pub worn: WornState,
    /// Friction of the computation, and whether it was assumed.
    pub friction: Option<(Friction, bool)>,
    /// Forces and pressures.
    pub answer: Answer,
}

/// Result of the selected method.
#[derive(Debug, Clone)]
pub enum Answer {
    /// Equilibrium with the actual gaps of both flanks.
    Equilibrium(Box<Equilibrium>),
    /// Closed form of Tao2024 at one crank position.
    ClosedForm(closed_form::Handbook),
}

/// Load sharing by equilibrium.
#[derive(Debug, Clone)]
pub struct Equilibrium {
    /// One turn of the crankshafts.
    pub turn: Vec<LoadSharing>,
    /// Loaded rolling elements of the turning-arm bearings over this turn; empty with ideal joints.
    pub turning_arm_rollers: Vec<ArmRoller>,
    /// One full period: a pin pitch with ideal joints, a turn of the crankshafts in bearings, a turn of the output
    /// with errors of the ring.
    pub cycle: Cycle,
    /// Pin pitches that the cycle covers.
    pub pitches: usize,
    /// Harmonics of the loaded error, if its period is one pin pitch; else empty.
    pub harmonics: Vec<HarmonicError>,
    /// Loads of every pin if they differ; else empty.
    pub pins: Vec<PinLoad>,
    /// The machine without errors, if it has errors.
    pub nominal: Option<Cycle>,
}

/// One rolling element of a turning-arm bearing at one crank position; numbers count from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmRoller {
    /// Angle of the crankshafts against the ring in rad.
    pub crank_angle: f64,
    /// Crankshaft that carries the bearing.
    pub crankshaft: usize,
    /// Disc with the bore of the bearing.
    pub disc: usize,
    /// Rolling element in its bearing.
    pub roller: usize,
    /// From the middle of the eccentric in the frame of the ring, in rad.
    pub direction: f64,
    /// On the disc, radial, in N.
    pub force: f64,
}

/// Shares the load.
///
/// # Errors
/// [`AnalysisError`] where no load sharing is found, or options contradict each other.
pub fn run(design: &Design, options: &Options, host: &dyn Host) -> Result<Contact, AnalysisError> {
    let machine = design.machine();
    let torque = options.torque_nm.unwrap_or(machine.rated.torque);
    if options.wear_um > 0.0 && options.hours > 0.0 {
        return Err(AnalysisError::usage(
            "uniform wear (wear_um) and wear by the duty (hours) exclude each other",
            "leave one of them out",
        ));
    }
    let fidelity = Fidelity::resolve(design, &options.fidelity, host)?;
    let worn = match options.hours {
        0.0 => WornState::uniform(options.wear_um * UM),
        hours => worn_after(&machine, &fidelity, hours, host)?,
    };
    // The wear is that of the duty; the option `friction` does not change it.
    let (machine, assumed) = if options.friction { with_friction(&machine, false) } else { (machine, false) };
    let friction = options.friction.then_some((machine.friction, assumed));
    let answer = match options.method {
        Method::Equilibrium => {
            Answer::Equilibrium(Box::new(equilibrium(&machine, &fidelity, torque, &worn, options, host)?))
        }
        Method::ClosedForm if options.friction => {
            return Err(AnalysisError::usage(
                "the closed form does not support friction",
                "leave out friction or the method",
            ));
        }
        Method::ClosedForm => {
            if options.hours > 0.0 {
                return Err(AnalysisError::usage(
                    "the closed form supports uniform wear only",
                    "give wear_um in place of hours, or leave the method out",
                ));
            }
            refuse_beyond_closed_form("the closed form", &fidelity)?;
            Answer::ClosedForm(closed_form::solve(&machine, torque, options.wear_um * UM)?)
        }
    };
    Ok(Contact { machine, fidelity, torque, worn, friction, answer })
}

/// The handbook's methods support ideal joints and rigid discs only.
pub(crate) fn refuse_beyond_closed_form(method: &str, fidelity: &Fidelity) -> Result<(), AnalysisError> {
    let what = match (fidelity.joints, &fidelity.elastic) {
        (Joints::Bearings, _) => "bearings",
        (Joints::Ideal, Some(_)) => "elastic discs",
        (Joints::Ideal, None) => return Ok(()),
    };
    let help = "use joints = ideal, discs = rigid";
    Err(AnalysisError::usage(format!("{method} does not support {what}"), help))
}

fn equilibrium(
    machine: &Machine,
    fidelity: &Fidelity,
    torque: f64,
    worn: &WornState,
    options: &Options,
    host: &dyn Host,
) -> Result<Equilibrium, AnalysisError> {
    let sharer = |fidelity: &Fidelity| {
        if options.friction { fidelity.running_meshing(machine) } else { fidelity.meshing(machine) }
    };
    let mut meshing = sharer(fidelity)?;
    worn.apply_to(&machine.designed_relief(), &mut meshing);
    let failed = || AnalysisError::compute("share the load");
    let (mut turn, mut start) = (Vec::with_capacity(options.positions), None);
    // Tables and figures show the turn; the summary is computed from the full period.
    let shows_turn = ["contact", "error", ROLLERS, "report"].iter().any(|result| host.needs(result));
    let needs_rollers = host.needs(ROLLERS);
    let mut turning_arm_rollers = Vec::new();
    for index in 0..if shows_turn { options.positions } else { 0 } {
        if host.is_cancelled() {
            return Err(AnalysisError::Stopped);
        }
        let crank = CrankAngle::from_degrees(360.0 * index as f64 / options.positions as f64);
        let (mut sharing, found) = meshing.share(crank, torque, start.as_ref()).map_err(failed())?;
        sharing.stiffness = Some(meshing.stiffness(&sharing));
        turn.push(sharing);
        if needs_rollers {
            turning_arm_rollers.extend(arm_rollers(machine, &meshing, crank, &found));
        }
        start = Some(found);
        host.report("load sharing", 0.5 * (index + 1) as f64 / options.positions as f64);
    }
    let needs_stiffness = host.needs(TORSIONAL_STIFFNESS.key) || host.needs("report");
    // For a full period of one turn of the output: enough positions for every pin to meet every disc at many angles.
    let positions = if meshing.discs_alike() { 72 } else { 720 };
    let mut cycle = meshing.whole_cycle(torque, positions).map_err(failed())?;
    for position in cycle.positions.iter_mut().filter(|_| needs_stiffness) {
        position.stiffness = Some(meshing.stiffness(position));
    }
    if host.is_cancelled() {
        return Err(AnalysisError::Stopped);
    }
    let kinematics = machine.kinematics();
    let harmonics = match meshing.pitches() {
        1 => cycle.harmonics(kinematics.lobe_count, kinematics.pin_count),
        _ => Vec::new(),
    };
    let pins = if meshing.discs_alike() { Vec::new() } else { cycle.pin_loads() };
    let needs_nominal = host.needs("nominal") || host.needs("report");
    let nominal = if fidelity.errors.is_zero() || !needs_nominal {
        None
    } else {
        let mut nominal = sharer(&fidelity.nominal())?;
        if options.hours == 0.0 {
            worn.apply_to(&machine.designed_relief(), &mut nominal);
        } else {
            worn_after(machine, &fidelity.nominal(), options.hours, host)?
                .apply_to(&machine.designed_relief(), &mut nominal);
        }
        Some(nominal.whole_cycle(torque, 72).map_err(failed())?)
    };
    Ok(Equilibrium { turn, turning_arm_rollers, cycle, pitches: meshing.pitches(), harmonics, pins, nominal })
}

/// The rolling elements that carry in a solution at this crank angle.
fn arm_rollers(
    machine: &Machine,
    meshing: &MachineMeshing,
    crank: CrankAngle,
    solution: &MeshingStart,
) -> Vec<ArmRoller> {
    let bearings = (0..machine.crankshafts.count)
        .flat_map(|crankshaft| (0..machine.disc_count).map(move |disc| (crankshaft, disc)));
    let of_bearing =
        |(crankshaft, disc)| {
            let elements =
                meshing.turning_arm_elements(crank, solution, crankshaft, disc).into_iter().enumerate();
            elements.filter(|(_, (_, force))| *force > 0.0).map(move |(roller, (direction, force))| {
                ArmRoller { crank_angle: crank.radians(), crankshaft, disc, roller, direction, force }
            })
        };
    bearings.flat_map(of_bearing).collect()
}

impl Equilibrium {
    /// Mean stiffness over the cycle in N·m/rad.
    pub fn stiffness(&self) -> f64 {
        let positions = &self.cycle.positions;
        positions.iter().filter_map(|position| position.stiffness).sum::<f64>() / positions.len() as f64
    }

    fn contacts(&self) -> impl Iterator<Item = (&LoadSharing, usize, &PinContact)> {
        self.turn.iter().flat_map(|sharing| {
            let discs = sharing.discs.iter().enumerate();
            discs.flat_map(move |(disc, pins)| pins.iter().map(move |contact| (sharing, disc, contact)))
        })
    }
}

impl Contact {
    /// Largest force of one pin on one disc in N.
    pub fn max_force(&self) -> f64 {
        match &self.answer {
            Answer::Equilibrium(answer) => answer.cycle.max_force(),
            Answer::ClosedForm(answer) => answer.solution.max_force,
        }
    }
}

outcome!(Contact {
    fn attachments(&self) -> Result<Vec<Attachment>, AnalysisError> {
        elastic_disc::attachments(&self.machine, &self.fidelity)
    }
});

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Vec2, unit};

    /// A disc is in equilibrium under its pins and the rolling elements of its turning arms, in random machines and with
    /// either member at rest.
    #[test]
    fn rolling_elements_hold_the_discs() {
        let mounted = |fixed: &str| {
            let text = crate::templates::design("rv-40e").unwrap().text().to_owned();
            let text = text.replacen("fixed_member = \"housing\"", &format!("fixed_member = \"{fixed}\""), 1);
            Design::parse(&text, "test").unwrap()
        };
        let random = (1..=8).map(|seed| crate::random_designs::sound_design(seed).0);
        for design in random.chain(["housing", "carrier"].map(mounted)) {
            let options = Options::parse("joints = \"bearings\"\npositions = 9", "options").unwrap();
            let found = run(&design, &options, &crate::analyses::NoHost).unwrap();
            let Answer::Equilibrium(answer) = &found.answer else { panic!("a closed form") };
            let machine = &found.machine;
            for (disc, sharing) in
                (0..machine.disc_count).flat_map(|d| answer.turn.iter().map(move |s| (d, s)))
            {
                let crank = sharing.crank_angle.radians();
                let pins = sharing.discs[disc].iter().map(|pin| -pin.force * pin.normal);
                let rollers = answer
                    .turning_arm_rollers
                    .iter()
                    .filter(|one| one.disc == disc && (one.crank_angle - crank).abs() < 1e-12);
                let (pins, sum) =
                    (pins.sum::<Vec2>(), rollers.map(|one| one.force * unit(one.direction)).sum::<Vec2>());
                // The contacts' rolling force along the flank, by which their energy follows the curvature, is less than 0.1 %.
                let off = (sum + pins).norm() / pins.norm();
                assert!(off < 1e-3, "{disc}: {off:e}\n{}", design.text());
            }
        }
    }
}
