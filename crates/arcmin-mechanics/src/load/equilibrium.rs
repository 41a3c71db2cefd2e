use super::gap_model::GapModel;
use crate::contact::{DiscVelocity, PinContact, PinContacts};
use crate::fem::FlankLoad;
use crate::geometry::{Relief, Vec2, quarter_turn, unit};
use crate::machine::{CrankAngle, Kinematics, Machine, OutputAngle};

/// Why no load sharing could be found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LoadError {
    /// The search for the equilibrium ended without one.
    #[error(
        "load sharing did not converge at crank angle {crank_angle_deg:.4}°: torque residual {residual:.3e} N·m of {torque} N·m after {iterations} iterations"
    )]
    NotConverged {
        /// Crank angle, degrees.
        crank_angle_deg: f64,
        /// Torque to be shared, N·m.
        torque: f64,
        /// Torque that the contacts failed to balance, N·m.
        residual: f64,
        /// Iterations done.
        iterations: usize,
    },
    /// All pins stay open.
    #[error(
        "no pin can touch the disc within half a tooth pitch at crank angle {crank_angle_deg:.4}° (gap too large)"
    )]
    NoContact {
        /// Crank angle, degrees.
        crank_angle_deg: f64,
    },
    /// The relief at which preloaded pins just come free was not found.
    #[error(
        "the relief that frees the preloaded pins was not found at crank angle {crank_angle_deg:.4}°: {relief:.3e} m after {trials} trials"
    )]
    NotFreed {
        /// Crank angle, degrees.
        crank_angle_deg: f64,
        /// Last relief tried, m.
        relief: f64,
        /// Reliefs tried.
        trials: usize,
    },
    /// Torque, N·m, that is not finite.
    #[error("the torque must be a finite number, not {0} N·m")]
    BadTorque(f64),
}

/// Cycloid discs and pins with ideal crank joints and the input locked.
///
/// One coordinate is left: the output error ε = θ_out − θ_s/i. It turns the discs by s ε and the crankshafts
/// by c ε against the ring, so that the contact forces (F_j, M_j) on the discs do the work Q δε with Q = Σ_j
/// [s M_j + c F_j·∂C_j/∂θ_k]. Equilibrium is Q(ε) = T. With the housing at rest s = 1 and c = (z_1+z_2)/z_2:
/// two equal discs carry 0.4815 T each of an RV-40E-81, the rest goes through the gear stage. With the
/// carrier at rest s = c = −1: it is the ring that turns, around discs and crankshafts that stand still, and
/// each disc carries 0.4875 T.
#[derive(Debug, Clone)]
pub struct Meshing {
    kinematics: Kinematics,
    contacts: PinContacts,
}

/// Play of the output with the input locked at no load, from the nominal position.
///
/// Where metal overlaps there is no play, and the load-free place ε* is the only one. Then w, the uniform
/// relief that would just free the mechanism, takes the place of what is missing: lag = ε* + w/g and lead =
/// ε* − w/g′, g and g′ the fastest closing of any gap along the output's angle either way (for the
/// theoretical flank the play of a uniform relief w is w/g). So lag lies beyond lead, and play and free
/// travel are negative. Both pass through zero with the relief without a jump.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeTravel {
    /// Output error at which the flank that carries positive torque touches first: zero or negative (lagging)
    /// for a disc with clearance.
    pub lag: OutputAngle,
    /// The same for negative torque: zero or positive.
    pub lead: OutputAngle,
    /// Forces of the load-free balance.
    pub preload: Preload,
}

/// Forces on the pins of a machine without load.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Preload {
    /// Largest force of a pin in the load-free balance in N; 0 where there is play.
    pub force: f64,
    /// Σ F times the sliding way per radian of the disc ([`PinContacts::sliding_way`]) over all pins and discs in N·m: the
    /// friction torque at the output per unit of the flank's coefficient.
    pub sliding_moment: f64,
}

impl Preload {
    /// Of the contacts of a load-free balance, `discs` those of every disc.
    pub fn of(discs: &[Vec<PinContact>], contacts: &PinContacts) -> Preload {
        let mut preload = Preload::default();
        for contact in discs.iter().flatten() {
            preload.force = preload.force.max(contact.force);
            preload.sliding_moment += contact.force * contacts.sliding_way(contact);
        }
        preload
    }

    /// Friction torque at the output in N·m with a coefficient of the flanks (the smaller of flank and seat for pins that
    /// spin).
    pub fn friction_torque(&self, flank_friction: f64) -> f64 {
        flank_friction * self.sliding_moment
    }
}

/// State of all contacts in equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadSharing {
    /// Angle of the crankshafts at which the torque is shared.
    pub crank_angle: CrankAngle,
    /// Torque shared, in N·m.
    pub torque: f64,
    /// Output error ε: elastic wind-up and play; negative under positive torque.
    pub output_error: OutputAngle,
    /// Q(ε) − T in N·m.
    pub residual: f64,
    /// dQ/dε: torsional stiffness at the output in N·m/rad, where it comes with the search; else
    /// [`ShareLoad::stiffness`](crate::load::ShareLoad::stiffness) tells it.
    pub stiffness: Option<f64>,
    /// Contacts per disc, in the order of the pins.
    pub discs: Vec<Vec<PinContact>>,
}

impl LoadSharing {
    /// All contacts, disc after disc.
    pub fn contacts(&self) -> impl Iterator<Item = &PinContact> {
        self.discs.iter().flatten()
    }

    /// Largest contact force in N.
    pub fn max_force(&self) -> f64 {
        self.contacts().map(|contact| contact.force).fold(0.0, f64::max)
    }

    /// Tooth forces on one disc, as the finite element model takes them.
    pub fn tooth_loads(&self, disc: usize) -> Vec<FlankLoad> {
        let contacts = self.discs.get(disc).into_iter().flatten().filter(|contact| contact.force > 0.0);
        contacts.map(|contact| FlankLoad { tau: contact.tau, force: contact.force }).collect()
    }

    /// Number of pins of one disc that carry force, the mean over the discs.
    pub fn loaded_pairs(&self) -> f64 {
        self.contacts().filter(|contact| contact.force > 0.0).count() as f64 / self.discs.len() as f64
    }
}

/// Purpose of an evaluation of the contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scope {
    /// A step on the way: the pins that may touch.
    MayTouch,
    /// All pins: out of the clearance, any may be the next to touch.
    All,
    /// All pins, expected to be in equilibrium: the model will be followed hardly any further.
    Last,
}

pub(super) const MAX_ITERATIONS: usize = 60;
/// From here on a bracket that does not shrink is halved, until it holds nothing but a jump.
const SAFE_FROM: usize = 12;
const LAST_ITERATION: usize = 250;
/// Width in rad of a bracket in which Q jumps: rounding of the angles of crankshaft and output.
const JUMP_WIDTH: f64 = 3e-15;
/// Largest Newton step of the output error in rad: some wind-ups. Further away other lobes would come into
/// reach.
pub(super) const LARGEST_STEP: f64 = 1.0 * crate::units::ARCMIN;
/// Rounding of a gap (1e-17 m) times the stiffness of all pins: no residual in N·m falls reliably below,
/// which is 1e-9 relative from 5 N·m on.
const RESIDUAL_FLOOR: f64 = 5e-9;
/// From a step of the output error (rad) below this on, the model of the gaps is expected to lead to the
/// solution.
const NEAR_THE_SOLUTION: f64 = 1e-6;
/// Residual over torque below which one step in proportion ends the iteration: dF/F is as small, and its
/// square below the rounding of a gap.
const LAST_RESIDUAL: f64 = 1e-7;
/// Up to this gap in m the model of a contact includes the change of its curvature.
const CURVATURE_REACH: f64 = 2e-6;
/// Torsional stiffness of two steel discs on 40 pins is 4 300–5 400 N·m/arcmin: the first guess of the
/// wind-up, N·m/rad.
const EXPECTED_STIFFNESS: f64 = 5000.0 / crate::units::ARCMIN;

impl Machine {
    /// The meshing of this machine after its flanks have lost `wear`.
    pub fn meshing(&self, wear: &Relief) -> Meshing {
        Meshing { kinematics: self.kinematics(), contacts: self.pin_contacts(wear) }
    }

    /// Load sharing of the unworn machine at one crank angle under an output torque in N·m.
    ///
    /// # Errors
    /// [`LoadError`] when no pin can touch or the iteration does not settle.
    pub fn load_sharing(&self, crank_angle: CrankAngle, torque: f64) -> Result<LoadSharing, LoadError> {
        self.meshing(&Relief::uniform(0.0)).load_sharing(crank_angle, torque)
    }
}

impl Meshing {
    /// Ratios, phases and nominal poses of the machine.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Contacts of any one disc with the pins: discs are alike.
    pub fn contacts(&self) -> &PinContacts {
        &self.contacts
    }

    /// Replaces the metal removed (designed relief included).
    pub fn set_relief(&mut self, relief: Relief) {
        self.contacts.set_relief(relief);
    }

    /// Replaces the metal removed from the pins, see [`PinContacts::set_pin_relief`].
    pub fn set_pin_relief(&mut self, relief: Relief) {
        self.contacts.set_pin_relief(relief);
    }

    /// dC/dε of a disc in the ring.
    fn disc_motion(&self, disc: usize, crank_angle: f64) -> Vec2 {
        let k = &self.kinematics;
        k.crank_per_output_locked() * k.eccentricity * quarter_turn(unit(crank_angle + k.phases[disc]))
    }

    fn crank_angle_at(&self, nominal: f64, error: f64) -> f64 {
        nominal + self.kinematics.crank_per_output_locked() * error
    }

    /// Gaps and forces at the output error ε with their changes along ε; `visit` sees every contact.
    pub(super) fn survey(
        &self,
        nominal_crank: f64,
        error: f64,
        scope: Scope,
        model: &mut GapModel,
        mut visit: impl FnMut(usize, &PinContact),
    ) {
        let k = &self.kinematics;
        let crank = self.crank_angle_at(nominal_crank, error);
        let turn = k.disc_per_output_locked();
        let output = k.nominal_output_angle(nominal_crank) + turn * error;
        model.clear();
        for disc in 0..k.phases.len() {
            let motion = self.disc_motion(disc, crank);
            // The crank circle bends the path: d²C/dε² = −(dθ_k/dε)² C.
            let pose = k.disc_pose(disc, crank, output);
            let path_bend = -k.crank_per_output_locked().powi(2) * pose.centre;
            self.contacts.visit(pose, DiscVelocity::REST, scope != Scope::MayTouch, |contact| {
                visit(disc, contact);
                let g = contact.gradient;
                let radius = self.contacts.pins()[contact.pin].radius;
                let slope = g[0] * motion.x + g[1] * motion.y + g[2] * turn;
                let bend = contact.gap_bend(radius, turn * motion) + g[0] * path_bend.x + g[1] * path_bend.y;
                // Further off the curvature will have to be found anew.
                let curvature_slope = if scope != Scope::Last && contact.gap < CURVATURE_REACH {
                    self.contacts
                        .rolling(contact)
                        .relative_curvature_change(contact, [motion.x, motion.y, turn])
                } else {
                    0.0
                };
                model.add(contact, slope, bend, curvature_slope);
            });
        }
    }

    /// Finds ε with Q(ε) = T at the nominal crank angle given; torque T in N·m, positive against positive
    /// output motion.
    ///
    /// Q falls monotonically with ε, so a Newton iteration kept in a bracket is safe. At T = 0 the output
    /// rests where the flank of positive torque just touches, or where the forces of a preload balance.
    ///
    /// # Errors
    /// [`LoadError`] when no pin can touch, the torque is not finite, or the residual does not fall below
    /// 1e-9 T (5e-9 N·m).
    pub fn load_sharing(&self, crank_angle: CrankAngle, torque: f64) -> Result<LoadSharing, LoadError> {
        if !torque.is_finite() {
            return Err(LoadError::BadTorque(torque));
        }
        if torque == 0.0 {
            let (travel, tight_at) = self.free_angles(crank_angle)?;
            if let Some(place) = tight_at {
                return self.solve(crank_angle, torque, place, Scope::All);
            }
            let touch = travel.lag.radians();
            let mut discs = self.no_contacts();
            self.survey(
                crank_angle.radians(),
                touch,
                Scope::Last,
                &mut self.empty_model(),
                |disc, contact| discs[disc].push(*contact),
            );
            let output_error = OutputAngle::from_radians(touch);
            return Ok(LoadSharing {
                crank_angle,
                torque,
                output_error,
                residual: 0.0,
                stiffness: Some(0.0),
                discs,
            });
        }
        self.solve(crank_angle, torque, 0.0, Scope::All)
    }

    /// [`Meshing::load_sharing`] started from a known output error, such as that of the neighbouring crank
    /// angle.
    ///
    /// # Errors
    /// As [`Meshing::load_sharing`].
    pub fn load_sharing_near(
        &self,
        crank_angle: CrankAngle,
        torque: f64,
        start: OutputAngle,
    ) -> Result<LoadSharing, LoadError> {
        if !torque.is_finite() || torque == 0.0 {
            return self.load_sharing(crank_angle, torque);
        }
        self.solve(crank_angle, torque, start.radians(), Scope::MayTouch)
    }

    /// Newton's method kept in a bracket, its steps taken on the second-order model of all gaps at the last
    /// place. `scope` is that of the first look.
    pub(super) fn solve(
        &self,
        crank_angle: CrankAngle,
        torque: f64,
        start: f64,
        mut scope: Scope,
    ) -> Result<LoadSharing, LoadError> {
        let nominal = crank_angle.radians();
        let law = self.contacts.contact();
        let wind_up = (torque.abs() / EXPECTED_STIFFNESS).min(LARGEST_STEP);
        // Q > T at `low`, Q < T at `high`; only places that were evaluated count.
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut error = start;
        let mut residual = f64::INFINITY;
        let mut model = self.empty_model();
        let mut discs = self.no_contacts();
        let mut was_clear = false;
        // Width of the bracket when it was halved last, and when.
        let mut halved = (f64::INFINITY, 0);
        for iteration in 0..LAST_ITERATION {
            discs.iter_mut().for_each(Vec::clear);
            self.survey(nominal, error, scope, &mut model, |disc, contact| discs[disc].push(*contact));
            residual = model.torque - torque;
            let is_clear = model.turnover == 0.0;
            // Under preload what the contacts hold against each other is the measure of rounding, not the load.
            let carried = if model.turnover > 4.0 * torque.abs() { model.turnover } else { torque.abs() };
            let tolerance = (1e-10 * carried).max(RESIDUAL_FLOOR);
            if scope != Scope::MayTouch && residual.abs() <= LAST_RESIDUAL * carried {
                // The rest of the way is so short that the forces change in proportion: the square of the
                // residual is below rounding.
                let change = residual / model.stiffness;
                residual = model.carry_over(discs.iter_mut().flatten(), change) - torque;
                if residual.abs() <= tolerance {
                    let output_error = OutputAngle::from_radians(error + change);
                    return Ok(LoadSharing {
                        crank_angle,
                        torque,
                        output_error,
                        residual,
                        stiffness: Some(model.stiffness),
                        discs,
                    });
                }
            }
            if scope == Scope::MayTouch && (is_clear || residual.abs() <= LAST_RESIDUAL * carried) {
                scope = Scope::All;
                continue;
            }
            if residual > 0.0 {
                low = low.max(error);
            } else {
                high = high.min(error);
            }
            let width = high - low;
            if width <= 0.5 * halved.0 {
                halved = (width, iteration);
            }
            if width <= JUMP_WIDTH {
                return Ok(self.at_jump(crank_angle, torque, low, high));
            }
            let next = if iteration > SAFE_FROM && iteration > halved.1 + 2 && width.is_finite() {
                0.5 * (low + high)
            } else if is_clear && was_clear {
                // The model did not find the way out of the clearance: the safe search does.
                let direction = -torque.signum();
                self.first_touch(nominal, direction, error, 0.0)? + direction * wind_up
            } else {
                let next = model
                    .change_to(law, torque, wind_up, LARGEST_STEP)
                    .map_or(f64::NAN, |change| error + change);
                if next > low && next < high {
                    next
                } else if low.is_finite() && high.is_finite() {
                    0.5 * (low + high)
                } else {
                    error + residual.signum() * LARGEST_STEP
                }
            };
            was_clear = is_clear;
            scope = match (next - error).abs() < NEAR_THE_SOLUTION {
                true => Scope::Last,
                false if is_clear => Scope::All,
                false => Scope::MayTouch,
            };
            error = next;
        }
        Err(LoadError::NotConverged {
            crank_angle_deg: crank_angle.degrees(),
            torque,
            residual: residual.abs(),
            iterations: LAST_ITERATION,
        })
    }

    /// Where Q jumps over T between two places (a pin in the root of a worn flank goes over to the other side,
    /// or lies against both): the pin bears on both sides, and the shares of the two places in the forces are
    /// those with which Q = T. A contact stands where the larger part of its force is.
    fn at_jump(&self, crank_angle: CrankAngle, torque: f64, low: f64, high: f64) -> LoadSharing {
        let nominal = crank_angle.radians();
        let look = |error: f64| {
            let mut model = self.empty_model();
            let mut discs = self.no_contacts();
            self.survey(nominal, error, Scope::Last, &mut model, |disc, c| discs[disc].push(*c));
            (model, discs)
        };
        let ((below, mut discs), (above, others)) = (look(low), look(high));
        let share = ((below.torque - torque) / (below.torque - above.torque)).clamp(0.0, 1.0);
        for (here, other) in discs.iter_mut().flatten().zip(others.iter().flatten()) {
            let (mine, theirs) = ((1.0 - share) * here.force, share * other.force);
            if theirs > mine {
                *here = *other;
            }
            (here.force, here.elastic) = (mine + theirs, mine + theirs);
        }
        LoadSharing {
            crank_angle,
            torque,
            output_error: OutputAngle::from_radians(0.5 * (low + high)),
            residual: below.torque + share * (above.torque - below.torque) - torque,
            stiffness: Some(below.stiffness + share * (above.stiffness - below.stiffness)),
            discs,
        }
    }

    pub(super) fn empty_model(&self) -> GapModel {
        GapModel::with_capacity(self.contacts.pins().len() * self.kinematics.phases.len())
    }

    pub(super) fn no_contacts(&self) -> Vec<Vec<PinContact>> {
        vec![Vec::with_capacity(self.contacts.pins().len()); self.kinematics.phases.len()]
    }
}
