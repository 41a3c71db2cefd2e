use super::gap_model::GapModel;
use crate::contact::{DiscVelocity, PinContact, PinContacts};
use crate::fem::FlankLoad;
use crate::geometry::{Relief, Vec2, quarter_turn, unit};
use crate::machine::{CrankAngle, Kinematics, Machine, OutputAngle};

/// Reason why no load sharing was found.
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
        /// Residual torque, N·m.
        residual: f64,
        /// Number of iterations.
        iterations: usize,
    },
    /// No pin touches the disc.
    #[error(
        "no pin can touch the disc within half a tooth pitch at crank angle {crank_angle_deg:.4}° (gap too large)"
    )]
    NoContact {
        /// Crank angle, degrees.
        crank_angle_deg: f64,
    },
    /// The uniform relief at which preloaded pins lose contact was not found.
    #[error(
        "the relief that frees the preloaded pins was not found at crank angle {crank_angle_deg:.4}°: {relief:.3e} m after {trials} trials"
    )]
    NotFreed {
        /// Crank angle, degrees.
        crank_angle_deg: f64,
        /// Last relief tried, m.
        relief: f64,
        /// Number of reliefs tried.
        trials: usize,
    },
    /// Torque, N·m, that is not finite.
    #[error("the torque must be a finite number, not {0} N·m")]
    BadTorque(f64),
}

/// Cycloid discs and pins with ideal crank joints and the input locked.
///
/// The only unknown is the output error ε = θ_out − θ_s/i. It turns the discs by s ε and the crankshafts by c ε
/// relative to the ring, so that the contact forces (F_j, M_j) on the discs do the work Q δε with Q = Σ_j [s
/// M_j + c F_j·∂C_j/∂θ_k]. Equilibrium is Q(ε) = T. With a fixed housing s = 1 and c = (z_1+z_2)/z_2: each of
/// two equal discs of an RV-40E-81 transmits 0.4815 T, the rest goes through the gear stage. With a fixed
/// carrier s = c = −1: the ring turns, discs and crankshafts do not move with ε, and each disc transmits 0.4875
/// T.
#[derive(Debug, Clone)]
pub struct Meshing {
    kinematics: Kinematics,
    contacts: PinContacts,
}

/// Play of the output with the input locked at no load, relative to the nominal position.
///
/// With interference there is no play, and the load-free position ε* is unique. Then the play is defined by w,
/// the uniform relief at which the mechanism just becomes free: lag = ε* + w/g and lead = ε* − w/g′, with g and
/// g′ the largest closing rate of any gap with the angle of the output in either direction (for the theoretical
/// flank the play of a uniform relief w is w/g). So lag is greater than lead, and play and free travel are
/// negative. Both are continuous in the relief through zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeTravel {
    /// Output error at which the flank that carries positive torque touches first: zero or negative (lagging)
    /// for a disc with clearance.
    pub lag: OutputAngle,
    /// The same for negative torque: zero or positive.
    pub lead: OutputAngle,
    /// Forces of the load-free equilibrium.
    pub preload: Preload,
}

/// Forces on the pins of a machine without load.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Preload {
    /// Largest force of a pin in the load-free equilibrium in N; 0 if there is play.
    pub force: f64,
    /// Σ F times the sliding way per radian of the disc ([`PinContacts::sliding_way`]) over all pins and discs in N·m: the
    /// friction torque at the output per unit of the flank's coefficient.
    pub sliding_moment: f64,
}

impl Preload {
    /// Preload from the contacts of a load-free equilibrium, `discs` being those of every disc.
    pub fn of(discs: &[Vec<PinContact>], contacts: &PinContacts) -> Preload {
        let mut preload = Preload::default();
        for contact in discs.iter().flatten() {
            preload.force = preload.force.max(contact.force);
            preload.sliding_moment += contact.force * contacts.sliding_way(contact);
        }
        preload
    }

    /// Friction torque at the output in N·m for a friction coefficient of the flanks (for pins that spin, the
    /// smaller of those of flank and seat).
    pub fn friction_torque(&self, flank_friction: f64) -> f64 {
        flank_friction * self.sliding_moment
    }
}

/// State of all contacts in equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadSharing {
    /// Angle of the crankshafts.
    pub crank_angle: CrankAngle,
    /// Output torque in N·m.
    pub torque: f64,
    /// Output error ε: elastic wind-up and play; negative under positive torque.
    pub output_error: OutputAngle,
    /// Q(ε) − T in N·m.
    pub residual: f64,
    /// dQ/dε: torsional stiffness at the output in N·m/rad, if the search computes it; otherwise it is computed
    /// by [`ShareLoad::stiffness`](crate::load::ShareLoad::stiffness).
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

    /// Tooth forces on one disc for the finite element model.
    pub fn tooth_loads(&self, disc: usize) -> Vec<FlankLoad> {
        let contacts = self.discs.get(disc).into_iter().flatten().filter(|contact| contact.force > 0.0);
        contacts.map(|contact| FlankLoad { tau: contact.tau, force: contact.force }).collect()
    }

    /// Number of pins of one disc that carry force, the mean over the discs.
    pub fn loaded_pairs(&self) -> f64 {
        self.contacts().filter(|contact| contact.force > 0.0).count() as f64 / self.discs.len() as f64
    }
}

/// Set of contacts to be evaluated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scope {
    /// For intermediate iterations: the pins that may touch.
    MayTouch,
    /// All pins: within the clearance, any may be the next to touch.
    All,
    /// All pins, close to equilibrium: the gap model is used for a small step only.
    Last,
}

pub(super) const MAX_ITERATIONS: usize = 60;
/// From this iteration on a bracket that does not shrink is bisected, down to the width of a jump.
const SAFE_FROM: usize = 12;
const LAST_ITERATION: usize = 250;
/// Width in rad of a bracket in which Q jumps: rounding error of the angles of crankshaft and output.
const JUMP_WIDTH: f64 = 3e-15;
/// Largest Newton step of the output error in rad: several times the wind-up. With larger steps pins may reach
/// other lobes.
pub(super) const LARGEST_STEP: f64 = 1.0 * crate::units::ARCMIN;
/// Rounding error of a gap (1e-17 m) times the stiffness of all pins in N·m: the smallest residual that is
/// reached reliably, which is 1e-9 relative from 5 N·m on.
const RESIDUAL_FLOOR: f64 = 5e-9;
/// Step of the output error (rad) below which the next evaluation is expected to be the last.
const NEAR_THE_SOLUTION: f64 = 1e-6;
/// Residual over torque below which one linear step ends the iteration: dF/F is of the same size, and its
/// square is below the rounding error of a gap.
const LAST_RESIDUAL: f64 = 1e-7;
/// Gap in m up to which the model of a contact includes the change of its curvature.
const CURVATURE_REACH: f64 = 2e-6;
/// First estimate of the torsional stiffness in N·m/rad: two steel discs on 40 pins have 4 300–5 400
/// N·m/arcmin.
const EXPECTED_STIFFNESS: f64 = 5000.0 / crate::units::ARCMIN;

impl Machine {
    /// The meshing of this machine after its flanks have lost `wear`.
    pub fn meshing(&self, wear: &Relief) -> Meshing {
        Meshing { kinematics: self.kinematics(), contacts: self.pin_contacts(wear) }
    }

    /// Load sharing of the unworn machine at one crank angle under an output torque in N·m.
    ///
    /// # Errors
    /// [`LoadError`] when no pin can touch or the iteration does not converge.
    pub fn load_sharing(&self, crank_angle: CrankAngle, torque: f64) -> Result<LoadSharing, LoadError> {
        self.meshing(&Relief::uniform(0.0)).load_sharing(crank_angle, torque)
    }
}

impl Meshing {
    /// Ratios, phases and nominal poses of the machine.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Contacts of a disc with the pins; the same for all discs.
    pub fn contacts(&self) -> &PinContacts {
        &self.contacts
    }

    /// Replaces the relief of the flanks in m (designed relief included).
    pub fn set_relief(&mut self, relief: Relief) {
        self.contacts.set_relief(relief);
    }

    /// Replaces the relief of the pins by wear, see [`PinContacts::set_pin_relief`].
    pub fn set_pin_relief(&mut self, relief: Relief) {
        self.contacts.set_pin_relief(relief);
    }

    /// dC/dε of a disc relative to the ring.
    fn disc_motion(&self, disc: usize, crank_angle: f64) -> Vec2 {
        let k = &self.kinematics;
        k.crank_per_output_locked() * k.eccentricity * quarter_turn(unit(crank_angle + k.phases[disc]))
    }

    fn crank_angle_at(&self, nominal: f64, error: f64) -> f64 {
        nominal + self.kinematics.crank_per_output_locked() * error
    }

    /// Gaps and forces at the output error ε with their derivatives with respect to ε; `visit` is called with
    /// every contact.
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
            // The centre moves on the crank circle, hence the second derivative d²C/dε² = −(dθ_k/dε)² C.
            let pose = k.disc_pose(disc, crank, output);
            let path_bend = -k.crank_per_output_locked().powi(2) * pose.centre;
            self.contacts.visit(pose, DiscVelocity::REST, scope != Scope::MayTouch, |contact| {
                visit(disc, contact);
                let g = contact.gradient;
                let radius = self.contacts.pins()[contact.pin].radius;
                let slope = g[0] * motion.x + g[1] * motion.y + g[2] * turn;
                let bend = contact.gap_bend(radius, turn * motion) + g[0] * path_bend.x + g[1] * path_bend.y;
                // For larger gaps the curvature is evaluated again before contact.
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

    /// Finds ε with Q(ε) = T at a nominal crank angle; torque T in N·m, positive against positive output
    /// motion.
    ///
    /// Q falls monotonically with ε, so Newton's method with a bracket converges. At T = 0 the result is the
    /// output error at which the flank of positive torque just touches, or the equilibrium of the preload.
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

    /// [`Meshing::load_sharing`] with a start value of the output error, such as that of the neighbouring crank
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

    /// Newton's method with a bracket; its steps are computed with the second-order model of all gaps at the
    /// last iterate. `scope` is that of the first evaluation.
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
        // Q > T at `low`, Q < T at `high`; only evaluated points are bounds.
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut error = start;
        let mut residual = f64::INFINITY;
        let mut model = self.empty_model();
        let mut discs = self.no_contacts();
        let mut was_clear = false;
        // Width of the bracket at its last halving, and the iteration of it.
        let mut halved = (f64::INFINITY, 0);
        for iteration in 0..LAST_ITERATION {
            discs.iter_mut().for_each(Vec::clear);
            self.survey(nominal, error, scope, &mut model, |disc, contact| discs[disc].push(*contact));
            residual = model.torque - torque;
            let is_clear = model.turnover == 0.0;
            // With preload, the rounding error is proportional to the preload forces, not to the load.
            let carried = if model.turnover > 4.0 * torque.abs() { model.turnover } else { torque.abs() };
            let tolerance = (1e-10 * carried).max(RESIDUAL_FLOOR);
            if scope != Scope::MayTouch && residual.abs() <= LAST_RESIDUAL * carried {
                // The remaining step is so short that the forces are linear in it: the square of the residual
                // is below the rounding error.
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
                // The model did not find the end of the clearance; the bracketed search does.
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

    /// Q jumps over T between two points (a pin in the root of a worn flank changes to the other side, or
    /// touches both): the pin is loaded on both sides, and the forces are the combination of both points with Q
    /// = T. Each contact is listed at the point with the larger part of its force.
    fn at_jump(&self, crank_angle: CrankAngle, torque: f64, low: f64, high: f64) -> LoadSharing {
        let nominal = crank_angle.radians();
        let evaluate_at = |error: f64| {
            let mut model = self.empty_model();
            let mut discs = self.no_contacts();
            self.survey(nominal, error, Scope::Last, &mut model, |disc, c| discs[disc].push(*c));
            (model, discs)
        };
        let ((below, mut discs), (above, others)) = (evaluate_at(low), evaluate_at(high));
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
