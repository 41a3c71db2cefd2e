use super::gear_mesh::{GearMesh, MeshState};
use super::{Balance, DenseLinearisation, Drive, DynamicsError, ForceSummary, OutputLoad, Reducer, System};
use crate::contact::{DiscVelocity, MeshContact, PinContact, PinContacts, Reaction, Sliding};
use crate::geometry::{Relief, quarter_turn};
use crate::machine::{FixedMember, Kinematics, Machine};
use crate::units::ARCMIN;

/// The rigid model of Tao2024's Table 3: ideal joints, elastic contacts and gear meshes.
///
/// Absolute angles: sun θ_s, carrier θ_c, crankshafts θ_k (common to all), housing θ_h, where θ_c or θ_h is
/// fixed. Disc j has its centre at a e(θ_k + α_j) and rotates with the carrier, θ_j = θ_c + δ_j. The pin
/// contacts depend on the motion relative to the ring, κ = θ_k − θ_h and ο = θ_c − θ_h. Coordinates: q = (θ_k,
/// θ_out) with a prescribed sun, (θ_k, θ_out, θ_s) with a free one.
///
/// Mass: M_k = n_cr J_cr + n_d m_d a²; M_out = J_carrier + n_d J_d + n_cr m_cr R_c² (carrier) or the housing's
/// inertia; M_s = J_sun + J_motor. There are no velocity-dependent inertia forces: the crankshafts rotate about
/// axes that move with the carrier, and the discs' centres depend on θ_k alone.
///
/// Not modelled: compliance and clearance of bearings and shafts, out-of-plane motion, the sun's inertia
/// under a prescribed speed, losses in bearings and meshes.
#[derive(Debug, Clone)]
pub struct IdealJoints {
    kinematics: Kinematics,
    rings: Vec<PinContacts>,
    meshes: Vec<GearMesh>,
    drive: Drive,
    load: OutputLoad,
    drag: f64,
    drag_speed: f64,
    oil_drag: f64,
    /// Index of the absolute angle of each coordinate.
    members: Vec<usize>,
    mass: Vec<f64>,
    scale: Vec<f64>,
    ratio: f64,
}

const SUN: usize = 0;
const CARRIER: usize = 1;
const CRANK: usize = 2;
const HOUSING: usize = 3;

/// Torques on the four absolute angles with their tangents, before those of fixed members are removed.
#[derive(Default)]
struct Torques {
    torque: [f64; 4],
    stiffness: [[f64; 4]; 4],
    damping: [[f64; 4]; 4],
    balance: Balance,
}

impl IdealJoints {
    /// Builds the model of `machine` with the wear depth `wear` on every disc's flanks.
    ///
    /// `drag` is a steady torque (N·m) at the output against its motion, in addition to the machine's seal
    /// drag.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for stiffnesses, masses, loads or drags without meaning.
    pub fn new(
        machine: &Machine,
        wear: &Relief,
        drive: Drive,
        load: OutputLoad,
        drag: f64,
    ) -> Result<IdealJoints, DynamicsError> {
        drive.validate()?;
        load.validate()?;
        DynamicsError::require(
            drag >= 0.0 && drag.is_finite(),
            "drag torque",
            drag,
            "N·m",
            "must not be negative",
        )?;
        let (stage, damping) = (&machine.gear_stage, machine.contact_damping);
        let kinematics = machine.kinematics();
        let friction = machine.friction;
        let coefficient = machine.flank_friction();
        let mut ring = machine.pin_contacts(wear);
        ring.set_damping(Some(damping));
        ring.set_conservative(true);
        ring.set_sliding(Some(Sliding { coefficient, regularisation_speed: friction.regularisation_speed }));
        let (output, output_inertia) = match machine.fixed_member {
            FixedMember::Housing => (CARRIER, carrier_inertia(machine)),
            FixedMember::Carrier => (HOUSING, machine.housing.inertia),
        };
        let cranks = machine.crankshafts.count as f64;
        let crank_inertia = cranks * machine.crankshafts.inertia
            + machine.disc_count as f64
                * machine.disc.mass
                * machine.crankshafts.eccentricity
                * machine.crankshafts.eccentricity;
        let ratio = kinematics.ratio();
        let mut members = vec![CRANK, output];
        let mut mass = vec![crank_inertia, output_inertia];
        let mut scale = vec![kinematics.lobe_count * ARCMIN, ARCMIN];
        if drive.leaves_sun_free() {
            members.push(SUN);
            mass.push(stage.sun_inertia + stage.motor_inertia);
            scale.push(ratio.abs() * ARCMIN);
        }
        debug_assert!(mass.iter().all(|inertia| *inertia > 0.0), "moments of inertia {mass:?}");
        Ok(IdealJoints {
            rings: vec![ring; machine.disc_count],
            meshes: (0..machine.crankshafts.count).map(|k| GearMesh::turning(machine, k)).collect(),
            drive,
            load,
            drag: drag + friction.seal_drag,
            // A hundredth of the rated output speed, well below any speed of interest for the drag.
            drag_speed: (0.01 * machine.rated.input_speed / ratio).abs().max(1e-6),
            oil_drag: friction.oil_drag,
            members,
            mass,
            scale,
            ratio,
            kinematics,
        })
    }

    /// Ratios, phases and nominal poses of the machine.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Sets the wear depth of every pin, as a function of the angle on the pin
    /// ([`PinContacts::set_pin_relief`]).
    pub fn set_pin_wear(&mut self, wear: &Relief) {
        for ring in &mut self.rings {
            ring.set_pin_relief(wear.clone());
        }
    }

    /// Replaces the flanks by a mesh with nodes at the given τ ([`PinContacts::set_facets`]).
    pub fn set_facets(&mut self, contact: MeshContact, nodes: &[f64]) {
        for ring in &mut self.rings {
            ring.set_facets(contact, nodes.to_vec());
        }
    }

    /// Index of the output angle among the coordinates.
    pub const OUTPUT: usize = 1;

    fn angles(&self, time: f64, position: &[f64], velocity: &[f64]) -> ([f64; 4], [f64; 4]) {
        let (mut angle, mut speed) = ([0.0; 4], [0.0; 4]);
        let motion = self.drive.motion(time);
        (angle[SUN], speed[SUN]) = (motion.angle, motion.speed);
        for (index, member) in self.members.iter().enumerate() {
            (angle[*member], speed[*member]) = (position[index], velocity[index]);
        }
        if let Some(motion) = self.load.motion() {
            let output = self.members[IdealJoints::OUTPUT];
            (angle[output], speed[output]) = motion.at(time);
        }
        (angle, speed)
    }

    fn disc_state(
        &self,
        disc: usize,
        angle: &[f64; 4],
        speed: &[f64; 4],
    ) -> (crate::contact::DiscPose, DiscVelocity) {
        let (crank, carrier) = (angle[CRANK] - angle[HOUSING], angle[CARRIER] - angle[HOUSING]);
        let pose = self.kinematics.disc_pose(disc, crank, carrier);
        let velocity = DiscVelocity {
            centre: (speed[CRANK] - speed[HOUSING]) * quarter_turn(pose.centre),
            angle: speed[CARRIER] - speed[HOUSING],
        };
        (pose, velocity)
    }

    /// State of every pin on one disc, in the frame of the ring.
    pub fn pin_contacts(
        &self,
        disc: usize,
        time: f64,
        position: &[f64],
        velocity: &[f64],
    ) -> Vec<PinContact> {
        let (angle, speed) = self.angles(time, position, velocity);
        let (pose, rate) = self.disc_state(disc, &angle, &speed);
        self.rings[disc].contacts(pose, rate)
    }

    /// Number of discs, each with contacts of its own.
    pub fn disc_count(&self) -> usize {
        self.rings.len()
    }

    /// Total force of the sun–planet meshes on the line of action, in N.
    pub fn mesh_force(&self, time: f64, position: &[f64], velocity: &[f64]) -> f64 {
        let (angle, speed) = self.angles(time, position, velocity);
        self.mesh_at(&angle, &speed).force
    }

    /// Sum of all meshes over the first three angles.
    fn mesh_at(&self, angle: &[f64; 4], speed: &[f64; 4]) -> MeshState<3> {
        let mut state = MeshState::default();
        let turns = |x: &[f64; 4]| [x[SUN], x[CARRIER], x[CRANK]];
        self.meshes.iter().for_each(|mesh| mesh.turn(&turns(angle), &turns(speed), &mut state));
        state
    }

    fn add_mesh(&self, angle: &[f64; 4], speed: &[f64; 4], total: &mut Torques) {
        let mesh = self.mesh_at(angle, speed);
        for i in 0..3 {
            total.torque[i] += mesh.damping_force[i] - mesh.gradient[i];
            for j in 0..3 {
                total.stiffness[i][j] += mesh.hessian[i][j] + mesh.damping_slope[i][j];
                total.damping[i][j] += mesh.damping[i][j];
            }
        }
        total.balance.stored += mesh.stored;
        total.balance.dissipation += mesh.dissipation;
    }

    fn add_disc(&self, disc: usize, angle: &[f64; 4], speed: &[f64; 4], total: &mut Torques) {
        let (pose, velocity) = self.disc_state(disc, angle, speed);
        let Reaction { force: f, stiffness: k, damping: c, stored, dissipation, onset_rate } =
            self.rings[disc].react(pose, velocity);
        // ∂(x, y)/∂κ is the centre rotated by 90°, ∂²(x, y)/∂κ² minus the centre.
        let arm = quarter_turn(pose.centre);
        let d = [arm.x, arm.y];
        let bend = [-pose.centre.x, -pose.centre.y];
        let rate = speed[CRANK] - speed[HOUSING];
        let (mut kk, mut ko, mut ok) = (0.0, 0.0, 0.0);
        let (mut ckk, mut cko, mut cok) = (0.0, 0.0, 0.0);
        let mut torque = 0.0;
        for i in 0..2 {
            torque += d[i] * f[i];
            kk -= bend[i] * f[i];
            for j in 0..2 {
                // The direction of the centre's velocity depends on κ.
                kk += d[i] * (k[i][j] * d[j] + c[i][j] * bend[j] * rate);
                ckk += d[i] * c[i][j] * d[j];
            }
            ko += d[i] * k[i][2];
            cko += d[i] * c[i][2];
            ok += k[2][i] * d[i] + c[2][i] * bend[i] * rate;
            cok += c[2][i] * d[i];
        }
        let relative = [torque, f[2]];
        let stiffness = [[kk, ko], [ok, k[2][2]]];
        let damping = [[ckk, cko], [cok, c[2][2]]];
        // κ = θ_k − θ_h, ο = θ_c − θ_h.
        let members = [[(CRANK, 1.0), (HOUSING, -1.0)], [(CARRIER, 1.0), (HOUSING, -1.0)]];
        for i in 0..2 {
            for (row, row_sign) in members[i] {
                total.torque[row] += row_sign * relative[i];
                for j in 0..2 {
                    for (column, sign) in members[j] {
                        total.stiffness[row][column] += row_sign * sign * stiffness[i][j];
                        total.damping[row][column] += row_sign * sign * damping[i][j];
                    }
                }
            }
        }
        total.balance.stored += stored;
        total.balance.dissipation += dissipation;
        total.balance.onset_rate = total.balance.onset_rate.max(onset_rate);
    }
}

impl System for IdealJoints {
    fn linearisation(&self) -> DenseLinearisation {
        DenseLinearisation::new(self.members.len())
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
        let (angle, speed) = self.angles(time, position, velocity);
        let mut total = Torques::default();
        self.add_mesh(&angle, &speed, &mut total);
        for disc in 0..self.rings.len() {
            self.add_disc(disc, &angle, &speed, &mut total);
        }
        self.add_drive_and_load(time, &speed, &mut total);
        lin.clear();
        for (i, row) in self.members.iter().enumerate() {
            force[i] = total.torque[*row];
            for (j, column) in self.members.iter().enumerate() {
                lin.add_stiffness(i, j, total.stiffness[*row][*column]);
                lin.add_damping(i, j, total.damping[*row][*column]);
            }
        }
        self.impose_output(time, self.mass[IdealJoints::OUTPUT], force, lin, &mut total.balance);
        total.balance
    }

    fn next_breakpoint(&self, time: f64) -> Option<f64> {
        self.load.next_jump(time)
    }

    fn crank_angle(&self, position: &[f64]) -> f64 {
        position[0]
    }
}

impl IdealJoints {
    /// Prescribes the motion of the output, which has this moment of inertia.
    fn impose_output(
        &self,
        time: f64,
        inertia: f64,
        force: &mut [f64],
        lin: &mut DenseLinearisation,
        balance: &mut Balance,
    ) {
        if let Some(motion) = self.load.motion() {
            let at = IdealJoints::OUTPUT;
            motion.impose(time, at, inertia, force, Some((lin, at)), balance);
        }
    }

    /// Load, drag and drive; added last, because the input torque balances all torques on the sun.
    fn add_drive_and_load(&self, time: f64, speed: &[f64; 4], total: &mut Torques) {
        let output = self.members[IdealJoints::OUTPUT];
        let load = self.load.torque(time);
        total.torque[output] -= load;
        total.balance.load_torque = load;
        total.balance.load_power = load * speed[output];
        let reach = 1.0 / speed[output].hypot(self.drag_speed);
        total.torque[output] -= self.drag * speed[output] * reach;
        total.damping[output][output] += self.drag * self.drag_speed * self.drag_speed * reach.powi(3);
        total.balance.dissipation +=
            self.drag * speed[output] * speed[output] * reach + self.oil_drag * speed[SUN] * speed[SUN];
        let input_torque = if self.drive.leaves_sun_free() {
            let (torque, slope) = self.drive.torque(time, speed[SUN]);
            total.torque[SUN] += torque - self.oil_drag * speed[SUN];
            total.damping[SUN][SUN] += slope + self.oil_drag;
            torque
        } else {
            self.oil_drag * speed[SUN] - total.torque[SUN]
        };
        total.balance.input_torque = input_torque;
        total.balance.input_power = input_torque * speed[SUN];
    }
}

impl Reducer for IdealJoints {
    fn input(&self, time: f64, position: &[f64], velocity: &[f64]) -> (f64, f64) {
        if let (Some(angle), Some(speed)) = (position.get(2), velocity.get(2)) {
            return (*angle, *speed);
        }
        let motion = self.drive.motion(time);
        (motion.angle, motion.speed)
    }

    fn output_index(&self) -> usize {
        IdealJoints::OUTPUT
    }

    fn ratio(&self) -> f64 {
        self.ratio
    }

    fn drive(&self) -> Option<&Drive> {
        Some(&self.drive)
    }

    fn set_drive(&mut self, drive: Drive) {
        self.drive = drive;
    }

    fn output_load(&self) -> &OutputLoad {
        &self.load
    }

    fn set_output_load(&mut self, load: OutputLoad) {
        self.load = load;
    }

    fn nominal_position_at(&self, input: f64) -> Vec<f64> {
        let mut angle = [0.0; 4];
        if input != 0.0 {
            let output = self.members[IdealJoints::OUTPUT];
            angle[SUN] = input;
            angle[output] = input / self.ratio;
            angle[CRANK] = angle[HOUSING] - self.kinematics.lobe_count * (angle[CARRIER] - angle[HOUSING]);
        }
        self.members.iter().map(|member| angle[*member]).collect()
    }

    fn free_input(&self) -> Option<usize> {
        self.drive.leaves_sun_free().then_some(IdealJoints::OUTPUT + 1)
    }

    fn forces(&self, time: f64, position: &[f64], velocity: &[f64]) -> ForceSummary {
        let (angle, speed) = self.angles(time, position, velocity);
        let mut summary =
            ForceSummary { mesh_force: self.mesh_at(&angle, &speed).force, ..ForceSummary::default() };
        for disc in 0..self.rings.len() {
            let (pose, rate) = self.disc_state(disc, &angle, &speed);
            let law = self.rings[disc].contact();
            self.rings[disc].visit(pose, rate, false, |contact| {
                summary.add_pin(contact.force, law.pressure(contact.force, 1.0 / contact.relative_curvature));
            });
        }
        summary
    }
}

/// Moment of inertia of all parts that move with the carrier: itself, the discs, the crankshafts on their
/// circle.
fn carrier_inertia(machine: &Machine) -> f64 {
    let radius = machine.gear_stage.centre_distance();
    machine.carrier.inertia
        + machine.disc_count as f64 * machine.disc.inertia
        + machine.crankshafts.count as f64 * machine.crankshafts.mass * radius * radius
}

mod flexible;
#[cfg(test)]
mod tests;

pub use flexible::FlexibleJoints;
