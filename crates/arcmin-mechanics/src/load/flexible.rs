use super::{FreeTravel, LoadError, LoadSharing, Meshing, Preload, ShareLoad};
use crate::contact::{DiscVelocity, LineContact, PinContact, PinContacts};
use crate::fem::{CoupledContact, CoupledForces, FlexibleDiscs};
use crate::geometry::{Relief, Vec2, quarter_turn, unit};
use crate::machine::{CrankAngle, Machine, OutputAngle};

/// [`Meshing`] with elastic discs: ideal crank joints, input locked, each disc held at its bores.
///
/// The displacement of a flank is due to the forces at all contacts of its disc, u_i = Σ_j C_ij F_j; the
/// contact law takes the rest of the approach, for the depth from the surface at which C_ii is evaluated.
/// Inertia forces are neglected. The only unknown is the output error ε, as for rigid discs.
#[derive(Debug, Clone)]
pub struct FlexibleMeshing {
    rigid: Meshing,
    discs: FlexibleDiscs,
    law: LineContact,
    /// Per disc, in m/N: largest outward displacement of a flank per force.
    lifts: Vec<f64>,
}

const MAX_ITERATIONS: usize = 200;
/// As for rigid discs: from this iteration on a bracket that does not shrink is bisected, down to the width of
/// a jump.
const SAFE_FROM: usize = 20;
const JUMP_WIDTH: f64 = 3e-15;
/// Gaps in m up to which pins are included; further pins are included if the forces found can close them.
const REACH: f64 = 5e-6;
/// As for rigid discs.
const RESIDUAL_FLOOR: f64 = 5e-9;
/// First estimate of the torsional stiffness in N·m/rad: teeth and discs in series.
const EXPECTED_STIFFNESS: f64 = 2500.0 / crate::units::ARCMIN;

impl Machine {
    /// The meshing of this machine with elastic discs after its flanks have lost `wear`.
    pub fn flexible_meshing(&self, wear: &Relief, discs: FlexibleDiscs) -> FlexibleMeshing {
        let lifts = (0..discs.count()).map(|disc| discs.reduced(disc).compliance.largest_lift()).collect();
        let law = self.line_contact().at_disc_depth(&self.disc.material, discs.reading_depth(0));
        FlexibleMeshing { rigid: self.meshing(wear), law, discs, lifts }
    }
}

/// Contacts of one disc with their coupled forces.
struct DiscState {
    contacts: Vec<PinContact>,
    forces: CoupledForces,
}

impl FlexibleMeshing {
    /// The same machine with rigid discs.
    pub fn rigid(&self) -> &Meshing {
        &self.rigid
    }

    /// Reduced discs with elastic flanks.
    pub fn discs(&self) -> &FlexibleDiscs {
        &self.discs
    }

    /// Replaces the relief of the pins by wear, in m as a function of the angle on the pin.
    pub fn set_pin_relief(&mut self, relief: Relief) {
        self.rigid.set_pin_relief(relief);
    }

    /// Replaces the relief of the flanks in m (designed relief included).
    pub fn set_relief(&mut self, relief: Relief) {
        self.rigid.set_relief(relief);
    }

    fn state(&self, disc: usize, nominal_crank: f64, error: f64) -> Result<(DiscState, Vec2), LoadError> {
        let k = self.rigid.kinematics();
        let crank = nominal_crank + k.crank_per_output_locked() * error;
        let output = k.nominal_output_angle(nominal_crank) + k.disc_per_output_locked() * error;
        let mut all = Vec::new();
        let pose = k.disc_pose(disc, crank, output);
        self.rigid.contacts().visit(pose, DiscVelocity::REST, true, |contact| all.push(*contact));
        let mut reach = REACH;
        let (contacts, forces) = loop {
            let contacts: Vec<PinContact> = all.iter().filter(|pin| pin.gap < reach).copied().collect();
            let coupled: Vec<CoupledContact> = contacts
                .iter()
                .map(|contact| CoupledContact {
                    place: self.discs.stencil(disc, contact.tau),
                    approach: -contact.gap,
                    equivalent_radius: 1.0 / contact.designed_curvature,
                    skew: 0.0,
                })
                .collect();
            let mut forces = CoupledForces::default();
            if !forces.solve(&self.law, &self.discs.reduced(disc).compliance, &coupled) {
                return Err(LoadError::NotConverged {
                    crank_angle_deg: CrankAngle::from_radians(nominal_crank).degrees(),
                    torque: f64::NAN,
                    residual: f64::NAN,
                    iterations: MAX_ITERATIONS,
                });
            }
            let lift = self.lifts[disc] * forces.force.iter().sum::<f64>();
            // All pins are there at last.
            if contacts.len() == all.len() || lift <= reach {
                break (contacts, forces);
            }
            reach = 2.0 * lift;
        };
        let motion =
            k.crank_per_output_locked() * k.eccentricity * quarter_turn(unit(crank + k.phases[disc]));
        Ok((DiscState { contacts, forces }, motion))
    }

    /// Q(ε) and −dQ/dε without the rotation of the normals, which is a thousandth of it; Σ F |∂gap/∂ε|.
    fn generalised_torque(&self, nominal_crank: f64, error: f64) -> Result<[f64; 3], LoadError> {
        let (mut torque, mut stiffness, mut turnover) = (0.0, 0.0, 0.0);
        let turn = self.rigid.kinematics().disc_per_output_locked();
        for disc in 0..self.discs.count() {
            let (state, motion) = self.state(disc, nominal_crank, error)?;
            let n = state.contacts.len();
            let slope: Vec<f64> = state
                .contacts
                .iter()
                .map(|c| c.gradient[0] * motion.x + c.gradient[1] * motion.y + c.gradient[2] * turn)
                .collect();
            let mut response = slope.clone();
            state.forces.respond(&mut response, &mut Vec::with_capacity(n));
            for i in 0..n {
                torque += state.forces.force[i] * slope[i];
                turnover += state.forces.force[i] * slope[i].abs();
                stiffness += slope[i] * response[i];
            }
        }
        Ok([torque, stiffness, turnover])
    }

    /// Finds ε with Q(ε) = T at the nominal crank angle; as [`Meshing::load_sharing`], with elastic discs. The
    /// `gap` of a contact includes the displacement of the flank; it is minus the local approach in contact.
    ///
    /// # Errors
    /// [`LoadError`] as for rigid discs.
    pub fn load_sharing(&self, crank_angle: CrankAngle, torque: f64) -> Result<LoadSharing, LoadError> {
        if !torque.is_finite() {
            return Err(LoadError::BadTorque(torque));
        }
        let (travel, tight_at) = self.rigid.free_angles(crank_angle)?;
        if let Some(place) = tight_at {
            return self.solve(crank_angle, torque, place - torque / EXPECTED_STIFFNESS);
        }
        let touch = if torque < 0.0 { travel.lead.radians() } else { travel.lag.radians() };
        if torque == 0.0 {
            return self.sharing_at(crank_angle, torque, touch, 0.0, 0.0);
        }
        self.solve(crank_angle, torque, touch - torque / EXPECTED_STIFFNESS)
    }

    /// [`FlexibleMeshing::load_sharing`] with a start value of the output error, such as that of the
    /// neighbouring crank angle.
    ///
    /// # Errors
    /// As there.
    pub fn load_sharing_near(
        &self,
        crank_angle: CrankAngle,
        torque: f64,
        start: OutputAngle,
    ) -> Result<LoadSharing, LoadError> {
        if !torque.is_finite() || torque == 0.0 {
            return self.load_sharing(crank_angle, torque);
        }
        self.solve(crank_angle, torque, start.radians())
    }

    /// Newton's method with a bracket: Q falls with ε.
    fn solve(&self, crank_angle: CrankAngle, torque: f64, start: f64) -> Result<LoadSharing, LoadError> {
        let nominal = crank_angle.radians();
        let half_pitch = std::f64::consts::PI / self.rigid.kinematics().lobe_count;
        let (mut low, mut high) = (-half_pitch, half_pitch);
        let mut error = start;
        let mut residual = f64::INFINITY;
        let mut halved = (high - low, 0);
        for iteration in 0..MAX_ITERATIONS {
            let [q, stiffness, turnover] = self.generalised_torque(nominal, error)?;
            residual = q - torque;
            // As for rigid discs: with preload the contact forces are much larger than the load.
            let carried = if turnover > 4.0 * torque.abs() { turnover } else { torque.abs() };
            if residual.abs() <= (5e-10 * carried).max(RESIDUAL_FLOOR) {
                return self.sharing_at(crank_angle, torque, error, residual, stiffness);
            }
            if residual > 0.0 {
                low = error;
            } else {
                high = error;
            }
            let width = high - low;
            if width <= 0.5 * halved.0 {
                halved = (width, iteration);
            }
            if width <= JUMP_WIDTH {
                // A pin in the root of a worn flank changes to the other side; the residual of the forces is
                // reported.
                return self.sharing_at(crank_angle, torque, error, residual, stiffness);
            }
            let creeps = iteration > SAFE_FROM && iteration > halved.1 + 2;
            // Within the clearance there is no stiffness; the search goes on to the flank that carries the
            // torque.
            let newton = error + residual / stiffness;
            error = if stiffness > 0.0 && newton > low && newton < high && !creeps {
                newton
            } else {
                0.5 * (low + high)
            };
        }
        Err(LoadError::NotConverged {
            crank_angle_deg: crank_angle.degrees(),
            torque,
            residual: residual.abs(),
            iterations: MAX_ITERATIONS,
        })
    }

    fn sharing_at(
        &self,
        crank_angle: CrankAngle,
        torque: f64,
        error: f64,
        residual: f64,
        stiffness: f64,
    ) -> Result<LoadSharing, LoadError> {
        let nominal = crank_angle.radians();
        let k = self.rigid.kinematics();
        let crank = nominal + k.crank_per_output_locked() * error;
        let output = k.nominal_output_angle(nominal) + k.disc_per_output_locked() * error;
        let mut discs = Vec::with_capacity(self.discs.count());
        for disc in 0..self.discs.count() {
            let (state, _) = self.state(disc, nominal, error)?;
            let mut all =
                self.rigid.contacts().contacts(k.disc_pose(disc, crank, output), DiscVelocity::REST);
            for contact in &mut all {
                (contact.force, contact.stiffness) = (0.0, 0.0);
            }
            for (i, contact) in state.contacts.iter().enumerate() {
                if let Some(entry) = all.iter_mut().find(|entry| entry.pin == contact.pin) {
                    entry.force = state.forces.force[i];
                    entry.stiffness = state.forces.local_stiffness[i];
                    entry.gap = -state.forces.local[i];
                }
            }
            discs.push(all);
        }
        Ok(LoadSharing {
            crank_angle,
            torque,
            output_error: OutputAngle::from_radians(error),
            residual,
            stiffness: Some(stiffness),
            discs,
        })
    }
}

impl ShareLoad for FlexibleMeshing {
    type Start = OutputAngle;

    fn pattern_period(&self) -> f64 {
        self.rigid.pattern_period()
    }

    fn disc_speed(&self, input_speed: f64) -> f64 {
        self.rigid.disc_speed(input_speed)
    }

    fn contacts(&self) -> &PinContacts {
        self.rigid.contacts()
    }

    fn twin(&self) -> Self {
        self.clone()
    }

    fn set_relief(&mut self, relief: Relief) {
        FlexibleMeshing::set_relief(self, relief);
    }

    fn set_pin_relief(&mut self, relief: Relief) {
        FlexibleMeshing::set_pin_relief(self, relief);
    }

    /// The load rotates once around the disc, past bores and webs, in z_c pin pitches: one turn of the
    /// crankshafts relative to the carrier.
    fn pitches(&self) -> usize {
        self.rigid.contacts().profile().lobe_count()
    }

    fn share(
        &mut self,
        crank: CrankAngle,
        torque: f64,
        start: Option<&OutputAngle>,
    ) -> Result<(LoadSharing, OutputAngle), LoadError> {
        let sharing = match start {
            Some(start) => self.load_sharing_near(crank, torque, *start)?,
            None => self.load_sharing(crank, torque)?,
        };
        let error = sharing.output_error;
        Ok((sharing, error))
    }

    fn travel(&mut self, crank: CrankAngle) -> Result<FreeTravel, LoadError> {
        let (mut travel, tight_at) = self.rigid.free_angles(crank)?;
        if tight_at.is_some() {
            let sharing = self.load_sharing(crank, 0.0)?;
            travel.preload = Preload::of(&sharing.discs, self.rigid.contacts());
        }
        Ok(travel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{DiscModel, FemError, FlexibleSettings, MeshSizes};
    use crate::wear::{CoupledOptions, CoupledWear};

    /// A stiff disc wears as a rigid one; the real one has a more uniform load sharing, so that its largest
    /// wear is smaller.
    #[test]
    fn coupled_wear_on_elastic_discs() {
        let machine = crate::templates::tao2024();
        let reduced = {
            let shape = crate::fem::DiscShape::of(&machine, 0);
            let fine = FlexibleSettings::plane_stress(&shape);
            let sizes = MeshSizes { flank: 1.5 * fine.sizes.flank, flank_rows: 2, ..fine.sizes };
            DiscModel::new(shape, FlexibleSettings { sizes, ..fine }).unwrap().reduce().unwrap().0
        };
        // The same contacts in all three: only the discs differ.
        let machine =
            Machine { contact_law: crate::contact::ContactLaw::Linear { stiffness: 2.85e8 }, ..machine };
        let options =
            CoupledOptions { crank_positions: 13, depth_increment: 4e-7, ..CoupledOptions::default() };
        let exposure = machine.coupled_exposure(options).unwrap().at(1000.0 * crate::units::HOUR);
        let meshing = |factor: f64| {
            let stiff = reduced.stiffened(factor);
            let discs = FlexibleDiscs::with(crate::fem::DiscShape::all(&machine), |_| {
                Ok::<_, FemError>(stiff.clone())
            })
            .unwrap();
            machine.flexible_meshing(&Relief::uniform(0.0), discs)
        };
        let worn = |mut wear: CoupledWear<FlexibleMeshing>| {
            wear.advance_to(exposure).unwrap();
            wear.state().flank().clone()
        };
        let stiff = worn(CoupledWear::with(&machine, meshing(1e5), options));
        let soft = worn(CoupledWear::with(&machine, meshing(1.0), options));
        let mut rigid = CoupledWear::new(&machine, options);
        rigid.advance_to(exposure).unwrap();
        let rigid = rigid.state().flank().clone();
        let difference = |a: &Relief, b: &Relief| {
            a.samples().iter().zip(b.samples()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let depth = rigid.deepest().0;
        // Both stop at the same exposure; crank positions are spread over one pitch there, over a turn here.
        assert!(difference(&stiff, &rigid) < 0.03 * depth, "{:e} of {depth:e}", difference(&stiff, &rigid));
        assert!(difference(&soft, &rigid) > 0.05 * depth, "{:e} of {depth:e}", difference(&soft, &rigid));
    }
}
