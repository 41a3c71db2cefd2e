use super::{CARRIER, CRANK, HOUSING, IdealJoints, Torques};
use crate::contact::{LineContact, MeshContact, PinContact, TOLERABLE_DEPTH};
use crate::dynamics::{Balance, DenseLinearisation, Drive, DynamicsError, ForceSummary, OutputLoad, Reducer, System};
use crate::fem::{CoupledContact, CoupledForces, FlankCompliance, FlexibleDiscs};
use crate::geometry::{Relief, cross, quarter_turn};
use crate::machine::Machine;

/// [`IdealJoints`] with elastic discs.
///
/// Each disc moves with the frame of its bores (centre a e(θ_k + α_j), angle θ_c + δ_j) and deforms in it: u = Φ q. The flank gives way by
/// u_i = φ(τ_i)·q + Σ_j C^res_ij F_j along its inward normal: the modes kept as coordinates, and the static compliance of all the others. Contact is sought on the
/// analytic (worn) flank and the approach s_i = −gap_i − φ_i·q handed to the coupled contact law, so no facet and no second contact stiffness enters, and
/// the frequencies of modes left out do not limit the step.
///
/// Kinetic energy of a disc in its frame: ½ J θ̇_c² + θ̇_c c·q̇ + ½ q̇², with c = Φᵀ M r of rotation. With p = q + c θ_c as coordinates it is diagonal:
/// ½ (J − c·c) θ̇_c² + ½ ṗ². Modal damping 2 ζ ω q̇.
///
/// Coordinates: those of the rigid model, then p disc by disc. Not modelled: the modes' coupling to the motion of the disc *centre* (it deforms the disc
/// by some nanometres), Coriolis forces, the tangential displacement of the flank.
pub struct FlexibleJoints {
    rigid: IdealJoints,
    discs: FlexibleDiscs,
    law: LineContact,
    /// Static compliance beyond the modes kept, per disc.
    residual: Vec<std::sync::Arc<FlankCompliance>>,
    /// Modes kept per disc.
    modes: Vec<usize>,
    damping_ratio: f64,
    /// Whether the carrier, and with it the discs, turns.
    carrier_turns: bool,
    mass: Vec<f64>,
    scale: Vec<f64>,
}

/// What the flexible model needs beyond the rigid one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlexibleOptions {
    /// Modes up to this frequency in Hz are coordinates; the compliance of the others acts without inertia.
    pub mode_frequency: f64,
    /// ζ of every mode.
    pub damping_ratio: f64,
}

impl Default for FlexibleOptions {
    /// The three lowest held modes of an RV-40E's disc; bolted and fitted steel parts damp about 2 %.
    fn default() -> Self {
        FlexibleOptions { mode_frequency: 20e3, damping_ratio: 0.02 }
    }
}

/// Contacts of one disc at one state.
struct DiscContacts {
    contacts: Vec<PinContact>,
    /// Rate of s in m/s.
    rate: Vec<f64>,
    /// φ_i of the modes kept, contact by contact.
    shape: Vec<f64>,
    coupled: Vec<CoupledContact>,
    forces: CoupledForces,
}

impl FlexibleJoints {
    /// # Errors
    /// [`DynamicsError::InvalidValue`] as for the rigid model, and for damping or frequencies without meaning.
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
        check(options.damping_ratio >= 0.0 && options.damping_ratio < 1.0, "modal damping ratio", options.damping_ratio, "", "must lie in [0, 1)")?;
        check(options.mode_frequency >= 0.0, "mode frequency", options.mode_frequency, "Hz", "must not be negative")?;
        let rigid = IdealJoints::new(machine, wear, drive, load, drag)?;
        let mut law = discs.line_contact(machine);
        law.damping = Some(machine.contact_damping);
        let modes: Vec<usize> = (0..discs.count()).map(|disc| discs.reduced(disc).modes_up_to(options.mode_frequency)).collect();
        let mut residual: Vec<std::sync::Arc<FlankCompliance>> = Vec::new();
        for disc in 0..discs.count() {
            let same = (0..disc).find(|other| discs.is_shared(disc, *other)).map(|other| residual[other].clone());
            residual.push(same.unwrap_or_else(|| std::sync::Arc::new(discs.reduced(disc).residual_compliance(modes[disc]))));
        }
        let carrier_turns = rigid.members[IdealJoints::OUTPUT] == CARRIER;
        let (mut mass, mut scale) = (rigid.mass.clone(), rigid.scale.clone());
        for (disc, count) in modes.iter().enumerate() {
            let reduced = discs.reduced(disc);
            for m in 0..*count {
                if carrier_turns {
                    mass[IdealJoints::OUTPUT] -= reduced.momentum[2][m].powi(2);
                }
                mass.push(1.0);
                // The displacement of an arcmin at the flank: φ is of the order 1/√(disc mass).
                scale.push(machine.ring.pin_circle_radius * crate::units::ARCMIN * machine.disc.mass.sqrt());
            }
        }
        check(
            mass[IdealJoints::OUTPUT] > 0.0,
            "moment of inertia of the output",
            mass[IdealJoints::OUTPUT],
            "kg·m²",
            "must exceed that of the discs' modes",
        )?;
        Ok(FlexibleJoints { rigid, discs, law, residual, modes, damping_ratio: options.damping_ratio, carrier_turns, mass, scale })
    }

    /// As [`IdealJoints::set_pin_wear`].
    pub fn set_pin_wear(&mut self, wear: &Relief) {
        self.rigid.set_pin_wear(wear);
    }

    /// As [`IdealJoints::set_facets`]; the compliance stays that of the smooth disc.
    pub fn set_facets(&mut self, contact: MeshContact, nodes: &[f64]) {
        self.rigid.set_facets(contact, nodes);
    }

    /// The rigid model that carries the discs.
    pub fn rigid(&self) -> &IdealJoints {
        &self.rigid
    }

    /// Modes kept as coordinates, all discs together.
    pub fn mode_count(&self) -> usize {
        self.modes.iter().sum()
    }

    /// Index of a disc's first modal coordinate.
    fn first_mode(&self, disc: usize) -> usize {
        self.rigid.members.len() + self.modes[..disc].iter().sum::<usize>()
    }

    /// c of a mode, 0 where the carrier is at rest.
    fn turning_share(&self, disc: usize, mode: usize) -> f64 {
        if self.carrier_turns { self.discs.reduced(disc).momentum[2][mode] } else { 0.0 }
    }

    /// q and q̇ of a disc from p and the carrier's motion.
    fn modal_state(&self, disc: usize, position: &[f64], velocity: &[f64], angle: &[f64; 4], speed: &[f64; 4]) -> (Vec<f64>, Vec<f64>) {
        let first = self.first_mode(disc);
        (0..self.modes[disc])
            .map(|m| {
                let c = self.turning_share(disc, m);
                (position[first + m] - c * angle[CARRIER], velocity[first + m] - c * speed[CARRIER])
            })
            .unzip()
    }

    fn contacts_of(&self, disc: usize, angle: &[f64; 4], speed: &[f64; 4], q: &[f64], q_rate: &[f64]) -> DiscContacts {
        let (pose, velocity) = self.rigid.disc_state(disc, angle, speed);
        let reduced = self.discs.reduced(disc);
        let mut state =
            DiscContacts { contacts: Vec::new(), rate: Vec::new(), shape: Vec::new(), coupled: Vec::new(), forces: CoupledForces::default() };
        self.rigid.rings[disc].visit(pose, velocity, false, |contact| {
            let place = self.discs.stencil(disc, contact.tau);
            let (mut approach, mut rate) = (-contact.gap, contact.approach_rate);
            for m in 0..q.len() {
                let phi = reduced.mode_at(m, &place);
                approach -= phi * q[m];
                rate -= phi * q_rate[m];
                state.shape.push(phi);
            }
            state.coupled.push(CoupledContact { place, approach, equivalent_radius: 1.0 / contact.relative_curvature });
            state.rate.push(rate);
            state.contacts.push(*contact);
        });
        // An iteration that does not settle leaves a residual that the step's own Newton iteration sees and rejects.
        state.forces.solve(&self.law, &self.residual[disc], &state.coupled);
        state
    }

    /// Coordinate of each of the four absolute angles.
    fn coordinate(&self, member: usize) -> Option<usize> {
        self.rigid.members.iter().position(|m| *m == member)
    }

    fn add_disc(
        &self,
        disc: usize,
        (position, velocity): (&[f64], &[f64]),
        (angle, speed): (&[f64; 4], &[f64; 4]),
        total: &mut Torques,
        force: &mut [f64],
        lin: &mut DenseLinearisation,
    ) {
        let (q, q_rate) = self.modal_state(disc, position, velocity, angle, speed);
        let count = q.len();
        let state = self.contacts_of(disc, angle, speed, &q, &q_rate);
        let n = state.contacts.len();
        let first = self.first_mode(disc);
        let (pose, _) = self.rigid.disc_state(disc, angle, speed);
        let arm = quarter_turn(pose.centre);
        let slots = [self.coordinate(CRANK), self.coordinate(CARRIER), self.coordinate(HOUSING)];
        // Columns this disc touches: up to three members, then its modes.
        let columns: Vec<usize> = slots.iter().flatten().copied().chain(first..first + count).collect();
        let width = columns.len();
        let members = width - count;
        let mut gradient = vec![0.0; n * width];
        let mut along = vec![0.0; n * members];
        for (i, contact) in state.contacts.iter().enumerate() {
            let by = |g: &[f64; 3]| {
                let (crank, carrier) = (g[0] * arm.x + g[1] * arm.y, g[2]);
                [crank, carrier, -crank - carrier]
            };
            let (gap, slip) = (by(&contact.gradient), by(&contact.along));
            for (k, member) in (0..3).filter(|member| slots[*member].is_some()).enumerate() {
                gradient[i * width + k] = gap[member];
                along[i * members + k] = slip[member];
                if member == 1 {
                    gradient[i * width + k] -= (0..count).map(|m| self.turning_share(disc, m) * state.shape[i * count + m]).sum::<f64>();
                }
            }
            gradient[i * width + members..(i + 1) * width].copy_from_slice(&state.shape[i * count..(i + 1) * count]);
        }
        let balance = &mut total.balance;
        balance.stored += state.forces.flexural_energy;
        let mut gain = vec![0.0; n];
        for (i, contact) in state.contacts.iter().enumerate() {
            let local = state.forces.local[i];
            let here = self.law.damped_force(local, state.rate[i], 1.0 / contact.relative_curvature);
            if local <= 0.0 && state.rate[i] > 0.0 {
                balance.onset_rate = balance.onset_rate.max(state.rate[i] / (TOLERABLE_DEPTH - local));
            }
            balance.stored += here.stored;
            balance.dissipation += (here.force - here.elastic) * state.rate[i];
            let row = &gradient[i * width..(i + 1) * width];
            if here.force > 0.0 {
                gain[i] = here.stiffness / state.forces.local_stiffness[i];
            }
            let (share, slope) = self.rigid.rings[disc].sliding().map_or((0.0, 0.0), |sliding| sliding.share(contact.sliding_speed));
            let slip = &along[i * members..(i + 1) * members];
            balance.dissipation += share * here.force * contact.sliding_speed;
            for (a, column) in columns.iter().enumerate() {
                let tangential = slip.get(a).map_or(0.0, |slip| share * slip);
                force[*column] += here.force * (row[a] - tangential);
                for (b, other) in columns.iter().enumerate() {
                    lin.add_damping(*column, *other, here.damping * (row[a] - tangential) * row[b]);
                    if let (Some(p), Some(r)) = (slip.get(a), slip.get(b)) {
                        lin.add_damping(*column, *other, here.force * slope * p * r);
                    }
                }
            }
        }
        // −∂Q/∂z = Bᵀ (∂F/∂s) B, with ∂F/∂s = gain D.
        let mut scratch = Vec::with_capacity(n);
        let mut response = vec![0.0; n];
        for (b, other) in columns.iter().enumerate() {
            (0..n).for_each(|i| response[i] = gradient[i * width + b]);
            state.forces.respond(&mut response, &mut scratch);
            response.iter_mut().zip(&gain).for_each(|(r, gain)| *r *= gain);
            for (a, column) in columns.iter().enumerate() {
                lin.add_stiffness(*column, *other, (0..n).map(|i| gradient[i * width + a] * response[i]).sum());
            }
        }
        self.add_rolling(disc, &state, &q, arm, slots, force);
        self.add_turning_of_normals(&state, pose, slots, lin);
        self.add_modal_forces(disc, &q, &q_rate, balance, force, lin);
    }

    /// What makes the forces the gradient of the stored energy U = min over F of Σ W_i(δ_i, R_i) + ½ FᵀCF: its derivative with the places of the contacts,
    /// −∂U/∂τ_i = F_i φ′_i·q + ½ ∂(FᵀCF)/∂τ_i − ∂W_i/∂ln R · (ln R)′. It acts along the flank: the slope of the deformed flank under the contact force, and
    /// the work of rolling to another curvature. Its tangents are left out: it is 1e-3 of the contact force.
    fn add_rolling(&self, disc: usize, state: &DiscContacts, q: &[f64], arm: crate::geometry::Vec2, slots: [Option<usize>; 3], force: &mut [f64]) {
        let (reduced, compliance, forces) = (self.discs.reduced(disc), &self.residual[disc], &state.forces.force);
        for (i, contact) in state.contacts.iter().enumerate().filter(|(i, _)| forces[*i] > 0.0) {
            let slope = self.discs.slope_stencil(disc, contact.tau);
            let rolling = self.rigid.rings[disc].rolling(contact);
            let others: f64 = (0..forces.len())
                .filter(|j| *j != i && forces[*j] > 0.0)
                .map(|j| forces[j] * compliance.cross(&slope, &state.coupled[j].place))
                .sum();
            let modes: f64 = q.iter().enumerate().map(|(m, q)| q * reduced.mode_at(m, &slope)).sum();
            let pull = forces[i] * (modes + 0.5 * forces[i] * compliance.own(&slope) + others)
                - self.law.energy_by_log_radius(forces[i]) * rolling.log_radius_slope;
            let pose: [f64; 3] = std::array::from_fn(|k| pull * rolling.by_pose[k] + forces[i] * rolling.gap_slope[k]);
            let (crank, carrier) = (pose[0] * arm.x + pose[1] * arm.y, pose[2]);
            for (slot, value) in slots.iter().zip([crank, carrier, -crank - carrier]) {
                if let Some(row) = slot {
                    force[*row] += value;
                }
            }
        }
    }

    /// The crank circle bends the path of the disc centre, and normals turn with disc and pin: −F ∂²gap/∂(κ, ο)², a thousandth of the contact stiffness.
    fn add_turning_of_normals(&self, state: &DiscContacts, pose: crate::contact::DiscPose, slots: [Option<usize>; 3], lin: &mut DenseLinearisation) {
        let arm = quarter_turn(pose.centre);
        let (mut kk, mut ko, mut oo) = (0.0, 0.0, 0.0);
        for (contact, force) in state.contacts.iter().zip(&state.forces.force) {
            let n = contact.normal;
            kk -= force * n.dot(&pose.centre);
            ko += force * cross(n, arm);
            oo += force * n.dot(&contact.arm);
        }
        let entries = [(0, 0, kk), (0, 1, ko), (1, 0, ko), (1, 1, oo)];
        for (i, j, value) in entries {
            if let (Some(row), Some(column)) = (slots[i], slots[j]) {
                lin.add_stiffness(row, column, value);
            }
        }
    }

    fn add_modal_forces(&self, disc: usize, q: &[f64], q_rate: &[f64], balance: &mut Balance, force: &mut [f64], lin: &mut DenseLinearisation) {
        let first = self.first_mode(disc);
        let carrier = self.coordinate(CARRIER);
        for m in 0..q.len() {
            let square = self.discs.reduced(disc).eigenvalues[m];
            let damping = 2.0 * self.damping_ratio * square.sqrt();
            balance.stored += 0.5 * square * q[m] * q[m];
            balance.dissipation += damping * q_rate[m] * q_rate[m];
            let pull = square * q[m] + damping * q_rate[m];
            let share = -self.turning_share(disc, m);
            let terms = [Some((first + m, 1.0)), carrier.map(|carrier| (carrier, share))];
            for (row, a) in terms.into_iter().flatten() {
                force[row] -= a * pull;
                for (column, b) in terms.into_iter().flatten() {
                    lin.add_stiffness(row, column, a * b * square);
                    lin.add_damping(row, column, a * b * damping);
                }
            }
        }
    }
}

impl System for FlexibleJoints {
    type Linearisation = DenseLinearisation;

    fn linearisation(&self) -> DenseLinearisation {
        DenseLinearisation::new(self.mass.len())
    }

    fn mass(&self) -> &[f64] {
        &self.mass
    }

    fn scale(&self) -> &[f64] {
        &self.scale
    }

    fn evaluate(&self, time: f64, position: &[f64], velocity: &[f64], force: &mut [f64], lin: &mut DenseLinearisation) -> Balance {
        let (angle, speed) = self.rigid.angles(time, position, velocity);
        let mut total = Torques::default();
        self.rigid.add_mesh(&angle, &speed, &mut total);
        force.fill(0.0);
        lin.clear();
        for disc in 0..self.discs.count() {
            self.add_disc(disc, (position, velocity), (&angle, &speed), &mut total, force, lin);
        }
        self.rigid.add_drive_and_load(time, &speed, &mut total);
        for (i, row) in self.rigid.members.iter().enumerate() {
            force[i] += total.torque[*row];
            for (j, column) in self.rigid.members.iter().enumerate() {
                lin.add_stiffness(i, j, total.stiffness[*row][*column]);
                lin.add_damping(i, j, total.damping[*row][*column]);
            }
        }
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

    fn output(&self, position: &[f64], velocity: &[f64]) -> (f64, f64) {
        self.rigid.output(position, velocity)
    }

    fn ratio(&self) -> f64 {
        self.rigid.ratio()
    }

    fn load_torque(&self, time: f64) -> f64 {
        self.rigid.load_torque(time)
    }

    fn free_input(&self) -> Option<usize> {
        self.rigid.free_input()
    }

    fn nominal_position(&self) -> Vec<f64> {
        vec![0.0; self.mass.len()]
    }

    fn forces(&self, time: f64, position: &[f64], velocity: &[f64]) -> ForceSummary {
        let (angle, speed) = self.rigid.angles(time, position, velocity);
        let members = self.rigid.members.len();
        let mut summary =
            ForceSummary { mesh_force: self.rigid.mesh_force(time, &position[..members], &velocity[..members]).force, ..ForceSummary::default() };
        for disc in 0..self.discs.count() {
            let (q, q_rate) = self.modal_state(disc, position, velocity, &angle, &speed);
            for force in self.contacts_of(disc, &angle, &speed, &q, &q_rate).forces.force.iter().filter(|force| **force > 0.0) {
                summary.loaded_pins += 1;
                summary.largest_pin_force = summary.largest_pin_force.max(*force);
            }
        }
        summary
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::ContactLaw;
    use crate::dynamics::{Run, RunPlan, RunResult, StepControl};
    use crate::fem::{FemError, FlexibleSettings, ReducedDisc};
    use crate::machine::CrankAngle;
    use crate::units::ARCMIN;
    use std::sync::OnceLock;

    /// Contact stiffness of one pin that the published comparison figures go with.
    fn machine() -> Machine {
        Machine { contact_law: ContactLaw::Linear { stiffness: 2.85e8 }, ..crate::templates::rv_40e_81() }
    }

    fn reduced() -> &'static ReducedDisc {
        static REDUCED: OnceLock<ReducedDisc> = OnceLock::new();
        REDUCED.get_or_init(|| {
            let shape = crate::fem::DiscShape::of(&machine(), 0);
            let fine = FlexibleSettings::plane_stress(&shape);
            let sizes = crate::fem::MeshSizes { flank: 1.5 * fine.sizes.flank, flank_rows: 2, ..fine.sizes };
            crate::fem::DiscModel::new(shape, FlexibleSettings { sizes, ..fine }).unwrap().reduce().unwrap().0
        })
    }

    fn discs(reduced: &ReducedDisc) -> FlexibleDiscs {
        FlexibleDiscs::with(&machine(), |_| Ok::<_, FemError>(reduced.clone())).unwrap()
    }

    fn speed_law() -> Drive {
        Drive::SpeedLaw { speed: machine().rated.input_speed, rise_time: 0.02 }
    }

    fn run<M: Reducer>(model: &M) -> RunResult {
        // A tenth of the default tolerance: what differs between two models must not be the local error of their runs.
        let control = StepControl { tolerance: 0.1 * StepControl::default().tolerance, ..StepControl::default() };
        let plan = RunPlan { end: 0.04, window_start: 0.02, control, ..RunPlan::default() };
        let mut run = Run::new(model, plan).unwrap();
        run.finish().unwrap();
        run.result()
    }

    fn flexible(reduced: &ReducedDisc, mode_frequency: f64) -> FlexibleJoints {
        let options = FlexibleOptions { mode_frequency, ..FlexibleOptions::default() };
        let load = OutputLoad::Constant { torque: 412.0 };
        FlexibleJoints::new(&machine(), discs(reduced), &Relief::uniform(10e-6), speed_law(), load, 0.0, options).unwrap()
    }

    fn rigid() -> IdealJoints {
        IdealJoints::new(&machine(), &Relief::uniform(10e-6), speed_law(), OutputLoad::Constant { torque: 412.0 }, 0.0).unwrap()
    }

    #[test]
    fn discs_ten_thousand_times_stiffer_move_like_rigid_ones() {
        let stiff = reduced().stiffened(1e4);
        let (elastic, rigid) = (run(&flexible(&stiff, 20e3)), run(&rigid()));
        for (a, b) in elastic.series.iter().zip(&rigid.series) {
            let difference = (a.transmission_error - b.transmission_error) / ARCMIN;
            assert!(difference.abs() < 1e-4, "{} s: {difference}'", a.time);
        }
    }

    #[test]
    fn excess_over_rigid_discs_is_the_static_compliance() {
        let (elastic, rigid) = (run(&flexible(reduced(), 20e3)), run(&rigid()));
        let relief = Relief::uniform(10e-6);
        let meshing = machine().flexible_meshing(&relief, discs(reduced()));
        let k = meshing.rigid().kinematics();
        let (mut dynamic, mut fixed) = (0.0, 0.0);
        for (a, b) in elastic.series.iter().zip(&rigid.series).filter(|(a, _)| a.time > 0.02).step_by(4) {
            dynamic += b.transmission_error - a.transmission_error;
            let crank = CrankAngle::from_radians(-k.lobe_count * a.input_angle / k.ratio());
            let error = |sharing: crate::load::LoadSharing| sharing.output_error.radians();
            fixed += error(meshing.rigid().load_sharing(crank, 412.0).unwrap()) - error(meshing.load_sharing(crank, 412.0).unwrap());
        }
        assert!(dynamic > 0.0);
        assert!((dynamic / fixed - 1.0).abs() < 0.03, "{}", dynamic / fixed);
    }

    #[test]
    fn the_result_does_not_depend_on_the_number_of_modes() {
        let mean = |frequency: f64| run(&flexible(reduced(), frequency)).statistics.unwrap().mean;
        let (few, more) = (mean(20e3), mean(40e3));
        assert!((few / more - 1.0).abs() < 0.01, "{few} {more}");
    }

    #[test]
    fn energy_balances() {
        for law in [ContactLaw::Linear { stiffness: 2.85e8 }, ContactLaw::LineHertz] {
            let machine = Machine { contact_law: law, ..machine() };
            let load = OutputLoad::Constant { torque: 412.0 };
            let options = FlexibleOptions::default();
            let model = FlexibleJoints::new(&machine, discs(reduced()), &Relief::uniform(10e-6), speed_law(), load, 0.0, options).unwrap();
            let residual = run(&model).energy.residual();
            assert!(residual < 1e-6, "{law:?} {residual:e}");
        }
    }

    /// Generalised forces are minus the gradient of the stored energy in every coordinate; a law without radius and one with.
    #[test]
    fn forces_are_the_gradient_of_the_stored_energy() {
        for (law, wear) in [
            (ContactLaw::Linear { stiffness: 2.85e8 }, Relief::uniform(10e-6)),
            (ContactLaw::LineHertz, Relief::uniform(10e-6)),
            (ContactLaw::LineHertz, Relief::from_samples(Relief::grid(720).map(|phi| 10e-6 * (1.0 + 0.2 * (2.0 * phi).cos())).collect())),
        ] {
            let mut machine = Machine { contact_law: law, ..machine() };
            machine.contact_damping.coefficient = 0.0;
            let options = FlexibleOptions { damping_ratio: 0.0, ..FlexibleOptions::default() };
            let held = Drive::SpeedLaw { speed: 0.0, rise_time: 1.0 };
            let model = FlexibleJoints::new(&machine, discs(reduced()), &wear, held, OutputLoad::None, 0.0, options).unwrap();
            let n = model.size();
            for crank in [0.0, 0.7, 2.0] {
                // Wound up by about the rated torque, the modes a little off their static place.
                let mut state = vec![3e-8; n];
                state[0] = crank + 2e-4;
                state[IdealJoints::OUTPUT] = -crank / 39.0 - 1.1 * ARCMIN;
                let rest = vec![0.0; n];
                let mut lin = model.linearisation();
                let mut force = vec![0.0; n];
                // Modes away from the carrier's angle: q = p − c θ.
                for disc in 0..2 {
                    for m in 0..model.modes[disc] {
                        state[model.first_mode(disc) + m] += model.turning_share(disc, m) * state[IdealJoints::OUTPUT];
                    }
                }
                model.evaluate(0.0, &state, &rest, &mut force, &mut lin);
                let energy = |i: usize, h: f64| {
                    let mut moved = state.clone();
                    moved[i] += h;
                    model.evaluate(0.0, &moved, &rest, &mut vec![0.0; n], &mut model.linearisation()).stored
                };
                let size = (0..n).map(|i| (force[i] * model.scale[i]).abs()).fold(0.0, f64::max);
                for i in 0..n {
                    let h = 1e-3 * model.scale[i];
                    let slope = -(8.0 * (energy(i, h) - energy(i, -h)) - energy(i, 2.0 * h) + energy(i, -2.0 * h)) / (12.0 * h);
                    let difference = (slope - force[i]) * model.scale[i] / size;
                    // Kinks of the tabulated arc length: 1e-3 of the slope of the deformed flank, itself 1e-3 of the force.
                    assert!(difference.abs() < 2e-6, "{law:?} {crank} {i}: {slope} {}", force[i]);
                }
            }
        }
    }
}
