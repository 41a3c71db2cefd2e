use super::{CARRIER, CRANK, HOUSING, IdealJoints, Torques};
use crate::contact::{MeshContact, PinContact};
use crate::dynamics::elastic_disc::DiscMotion;
use crate::dynamics::{
    Balance, DenseLinearisation, Drive, DynamicsError, ElasticDiscs, FlexibleOptions, ForceSummary,
    OutputLoad, Reducer, System,
};
use crate::fem::FlexibleDiscs;
use crate::geometry::{Relief, Vec2, quarter_turn};
use crate::machine::Machine;

/// [`IdealJoints`] with [`ElasticDiscs`].
///
/// Each disc has the frame of its bores (centre a e(θ_k + α_j), angle θ_c + δ_j) and deforms in it.
///
/// Kinetic energy of a disc in its frame: ½ J θ̇_c² + θ̇_c c·q̇ + ½ q̇², with c = Φᵀ M r of rotation. With the
/// coordinates p = q + c θ_c it is diagonal: ½ (J − c·c) θ̇_c² + ½ ṗ².
///
/// Coordinates: those of the rigid model, then p disc by disc. Not modelled: the coupling of the modes with the
/// motion of the disc *centre* (it deforms the disc by some nanometres).
#[derive(Debug, Clone)]
pub struct FlexibleJoints {
    rigid: IdealJoints,
    discs: ElasticDiscs,
    /// Whether the carrier rotates, and the discs with it.
    carrier_turns: bool,
    mass: Vec<f64>,
    scale: Vec<f64>,
}

impl FlexibleJoints {
    /// # Errors
    /// [`DynamicsError::InvalidValue`] as for the rigid model, and for damping or frequencies without
    /// meaning.
    pub fn new(
        machine: &Machine,
        discs: FlexibleDiscs,
        wear: &Relief,
        drive: Drive,
        load: OutputLoad,
        drag: f64,
        options: FlexibleOptions,
    ) -> Result<FlexibleJoints, DynamicsError> {
        let check = DynamicsError::require;
        let discs = ElasticDiscs::held(discs, options)?;
        let mut rigid = IdealJoints::new(machine, wear, drive, load, drag)?;
        for (disc, ring) in rigid.rings.iter_mut().enumerate() {
            discs.prepare_ring_of(ring, disc, machine);
        }
        let carrier_turns = rigid.members[IdealJoints::OUTPUT] == CARRIER;
        let (mut mass, mut scale) = (rigid.mass.clone(), rigid.scale.clone());
        for disc in 0..discs.count() {
            for m in 0..discs.mode_count(disc) {
                if carrier_turns {
                    mass[IdealJoints::OUTPUT] -= discs.discs().reduced(disc).momentum[2][m].powi(2);
                }
                mass.push(1.0);
                scale.push(ElasticDiscs::scale(machine.ring.pin_circle_radius, machine.disc.mass));
            }
        }
        check(
            mass[IdealJoints::OUTPUT] > 0.0,
            "moment of inertia of the output",
            mass[IdealJoints::OUTPUT],
            "kg·m²",
            "must exceed that of the discs' modes",
        )?;
        Ok(FlexibleJoints { rigid, discs, carrier_turns, mass, scale })
    }

    /// As [`IdealJoints::set_pin_wear`].
    pub fn set_pin_wear(&mut self, wear: &Relief) {
        self.rigid.set_pin_wear(wear);
    }

    /// As [`IdealJoints::set_facets`]; the compliance remains that of the smooth disc.
    pub fn set_facets(&mut self, contact: MeshContact, nodes: &[f64]) {
        self.rigid.set_facets(contact, nodes);
    }

    /// The rigid model with these discs. Its pins have the contact law of elastic discs.
    pub fn rigid(&self) -> &IdealJoints {
        &self.rigid
    }

    /// Number of modes kept as coordinates, of all discs.
    pub fn mode_count(&self) -> usize {
        (0..self.discs.count()).map(|disc| self.discs.mode_count(disc)).sum()
    }

    /// Index of a disc's first modal coordinate.
    fn first_mode(&self, disc: usize) -> usize {
        self.rigid.members.len() + (0..disc).map(|disc| self.discs.mode_count(disc)).sum::<usize>()
    }

    /// c of a mode, 0 if the carrier is at rest.
    fn turning_share(&self, disc: usize, mode: usize) -> f64 {
        if self.carrier_turns { self.discs.discs().reduced(disc).momentum[2][mode] } else { 0.0 }
    }

    /// q and q̇ of a disc from p and the carrier's motion.
    fn modal_state(
        &self,
        disc: usize,
        position: &[f64],
        velocity: &[f64],
        angle: &[f64; 4],
        speed: &[f64; 4],
    ) -> (Vec<f64>, Vec<f64>) {
        let first = self.first_mode(disc);
        (0..self.discs.mode_count(disc))
            .map(|m| {
                let c = self.turning_share(disc, m);
                (position[first + m] - c * angle[CARRIER], velocity[first + m] - c * speed[CARRIER])
            })
            .unzip()
    }

    /// Coordinate of each of the four absolute angles.
    fn coordinate(&self, member: usize) -> Option<usize> {
        self.rigid.members.iter().position(|m| *m == member)
    }

    /// Derivatives of the disc's (x, y, θ, q): (coordinate, ∂(x, y, θ, q)/∂coordinate) for each coordinate with
    /// an effect.
    fn motions(&self, disc: usize, centre: Vec2) -> Vec<(usize, Vec<f64>)> {
        let (arm, count) = (quarter_turn(centre), self.discs.mode_count(disc));
        let frame = |x: f64, y: f64, angle: f64| {
            [x, y, angle].into_iter().chain(std::iter::repeat_n(0.0, count)).collect::<Vec<f64>>()
        };
        let mut motions = Vec::with_capacity(3 + count);
        for (member, mut motion) in [
            (CRANK, frame(arm.x, arm.y, 0.0)),
            (CARRIER, frame(0.0, 0.0, 1.0)),
            (HOUSING, frame(-arm.x, -arm.y, -1.0)),
        ] {
            if member == CARRIER {
                (0..count).for_each(|m| motion[3 + m] = -self.turning_share(disc, m));
            }
            motions.extend(self.coordinate(member).map(|coordinate| (coordinate, motion)));
        }
        let first = self.first_mode(disc);
        for m in 0..count {
            let mut motion = frame(0.0, 0.0, 0.0);
            motion[3 + m] = 1.0;
            motions.push((first + m, motion));
        }
        motions
    }

    fn add_disc(
        &self,
        disc: usize,
        (position, velocity): (&[f64], &[f64]),
        (angle, speed): (&[f64; 4], &[f64; 4]),
        balance: &mut Balance,
        force: &mut [f64],
        lin: &mut DenseLinearisation,
    ) {
        let (modes, rates) = self.modal_state(disc, position, velocity, angle, speed);
        let (pose, rate) = self.rigid.disc_state(disc, angle, speed);
        let motion =
            DiscMotion { pose, velocity: rate, modes: &modes, rates: &rates, housing: None, tilt: None };
        let reaction = self.discs.react(disc, &self.rigid.rings[disc], motion, true, None);
        balance.stored += reaction.stored;
        balance.dissipation += reaction.dissipation;
        balance.onset_rate = balance.onset_rate.max(reaction.onset_rate);
        let width = reaction.force.len();
        let motions = self.motions(disc, pose.centre);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (row, by_row) in &motions {
            force[*row] += dot(&reaction.force, by_row);
            let against = |matrix: &[f64]| -> Vec<f64> {
                (0..width).map(|b| (0..width).map(|a| by_row[a] * matrix[a * width + b]).sum()).collect()
            };
            let (stiffness, damping) = (against(&reaction.stiffness), against(&reaction.damping));
            for (column, by_column) in &motions {
                lin.add_stiffness(*row, *column, dot(&stiffness, by_column));
                lin.add_damping(*row, *column, dot(&damping, by_column));
            }
        }
        // The path of the disc centre is curved: ∂²(x, y)/∂κ² is minus the centre.
        let bend = reaction.force[0] * pose.centre.x + reaction.force[1] * pose.centre.y;
        for (row, sign) in [(CRANK, 1.0), (HOUSING, -1.0)] {
            for (column, other) in [(CRANK, 1.0), (HOUSING, -1.0)] {
                if let (Some(row), Some(column)) = (self.coordinate(row), self.coordinate(column)) {
                    lin.add_stiffness(row, column, sign * other * bend);
                }
            }
        }
    }

    /// State of every pin on one disc, in the frame of the ring.
    pub fn pin_contacts(
        &self,
        disc: usize,
        time: f64,
        position: &[f64],
        velocity: &[f64],
    ) -> Vec<PinContact> {
        let (angle, speed) = self.rigid.angles(time, position, velocity);
        let (modes, rates) = self.modal_state(disc, position, velocity, &angle, &speed);
        let (pose, rate) = self.rigid.disc_state(disc, &angle, &speed);
        self.discs.pin_contacts(
            disc,
            &self.rigid.rings[disc],
            DiscMotion { pose, velocity: rate, modes: &modes, rates: &rates, housing: None, tilt: None },
        )
    }
}

impl System for FlexibleJoints {
    fn linearisation(&self) -> DenseLinearisation {
        DenseLinearisation::new(self.mass.len())
    }

    fn mass(&self) -> &[f64] {
        &self.mass
    }

    fn scale(&self) -> &[f64] {
        &self.scale
    }

    fn evaluate(
        &self,
        time: f64,
        position: &[f64],
        velocity: &[f64],
        force: &mut [f64],
        lin: &mut DenseLinearisation,
    ) -> Balance {
        let (angle, speed) = self.rigid.angles(time, position, velocity);
        let mut total = Torques::default();
        self.rigid.add_mesh(&angle, &speed, &mut total);
        force.fill(0.0);
        lin.clear();
        for disc in 0..self.discs.count() {
            self.add_disc(disc, (position, velocity), (&angle, &speed), &mut total.balance, force, lin);
        }
        self.rigid.add_drive_and_load(time, &speed, &mut total);
        for (i, row) in self.rigid.members.iter().enumerate() {
            force[i] += total.torque[*row];
            for (j, column) in self.rigid.members.iter().enumerate() {
                lin.add_stiffness(i, j, total.stiffness[*row][*column]);
                lin.add_damping(i, j, total.damping[*row][*column]);
            }
        }
        let inertia = self.mass[IdealJoints::OUTPUT];
        self.rigid.impose_output(time, inertia, force, lin, &mut total.balance);
        total.balance
    }

    fn next_breakpoint(&self, time: f64) -> Option<f64> {
        self.rigid.next_breakpoint(time)
    }

    fn crank_angle(&self, position: &[f64]) -> f64 {
        self.rigid.crank_angle(position)
    }
}

impl Reducer for FlexibleJoints {
    fn input(&self, time: f64, position: &[f64], velocity: &[f64]) -> (f64, f64) {
        let members = self.rigid.members.len();
        self.rigid.input(time, &position[..members], &velocity[..members])
    }

    fn output_index(&self) -> usize {
        IdealJoints::OUTPUT
    }

    fn ratio(&self) -> f64 {
        self.rigid.ratio()
    }

    fn drive(&self) -> Option<&Drive> {
        self.rigid.drive()
    }

    fn set_drive(&mut self, drive: Drive) {
        self.rigid.set_drive(drive);
    }

    fn output_load(&self) -> &OutputLoad {
        self.rigid.output_load()
    }

    fn set_output_load(&mut self, load: OutputLoad) {
        self.rigid.set_output_load(load);
    }

    fn free_input(&self) -> Option<usize> {
        self.rigid.free_input()
    }

    /// Discs without deformation: p = c θ_c.
    fn nominal_position_at(&self, input: f64) -> Vec<f64> {
        let mut position = self.rigid.nominal_position_at(input);
        let carrier = self.coordinate(CARRIER).map_or(0.0, |index| position[index]);
        for disc in 0..self.discs.count() {
            let shares = (0..self.discs.mode_count(disc)).map(|m| self.turning_share(disc, m) * carrier);
            position.extend(shares.map(|p| if carrier == 0.0 { 0.0 } else { p }));
        }
        position
    }

    fn forces(&self, time: f64, position: &[f64], velocity: &[f64]) -> ForceSummary {
        let (angle, speed) = self.rigid.angles(time, position, velocity);
        let members = self.rigid.members.len();
        let mut summary = ForceSummary {
            mesh_force: self.rigid.mesh_force(time, &position[..members], &velocity[..members]),
            ..ForceSummary::default()
        };
        for disc in 0..self.discs.count() {
            let (modes, rates) = self.modal_state(disc, position, velocity, &angle, &speed);
            let (pose, velocity) = self.rigid.disc_state(disc, &angle, &speed);
            let motion =
                DiscMotion { pose, velocity, modes: &modes, rates: &rates, housing: None, tilt: None };
            let ring = &self.rigid.rings[disc];
            let state = self.discs.contacts(disc, ring, motion, 0.0);
            for (force, coupled) in state.forces.force.iter().zip(&state.coupled) {
                summary.add_pin(*force, ring.contact().pressure(*force, coupled.equivalent_radius));
            }
        }
        summary
    }
}

#[cfg(test)]
mod tests;
