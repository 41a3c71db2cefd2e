use super::{Cause, Distance, Joint, Limit, Nominal, Part, Sink, State, damp};
use crate::dynamics::bearing_joints::Arm;
use crate::dynamics::bearing_joints::assembly::Element;
use crate::dynamics::{Five, MainBearings};
use crate::geometry::{Vec2, quarter_turn};
use crate::machine::OutputForces;

/// The two rows of the main bearings between the carrier, which leans in them, and the housing.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct MainPair {
    pub rows: MainBearings,
    /// (x, y, θ) of the carrier, (x, y) of the housing; (φ_x, φ_y, z) of the carrier against the housing.
    pub index: [usize; 8],
    /// What the rows hold on the carrier, from its centre.
    pub seat: Arm,
    /// Ratio of damping to stiffness in s.
    pub loss_time: f64,
}

/// Rows of x, y, z, φ_x, φ_y over the coordinates.
type Rows = [[f64; 8]; 5];

impl MainPair {
    fn seat_at(&self, q: &[f64]) -> Vec2 {
        if self.seat.radius == 0.0 { Vec2::zeros() } else { self.seat.at(q[self.index[2]]) }
    }

    fn displacement(&self, q: &[f64]) -> Five {
        let [x, y, _, hx, hy, lean_x, lean_y, z] = self.index;
        let seat = self.seat_at(q);
        Five::from([q[x] - q[hx] + seat.x, q[y] - q[hy] + seat.y, q[z], q[lean_x], q[lean_y]])
    }

    fn rows(&self, q: &[f64]) -> Rows {
        let along = quarter_turn(self.seat_at(q));
        let mut rows = [[0.0; 8]; 5];
        (rows[0][0], rows[0][2], rows[0][3]) = (1.0, along.x, -1.0);
        (rows[1][1], rows[1][2], rows[1][4]) = (1.0, along.y, -1.0);
        (rows[2][7], rows[3][5], rows[4][6]) = (1.0, 1.0, 1.0);
        rows
    }
}

impl Joint for MainPair {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let (state, rows) = (self.rows.react(&self.displacement(at.q)), self.rows(at.q));
        let by = |a: usize, b: usize| -> f64 {
            (0..5)
                .map(|i| rows[i][a] * (0..5).map(|j| state.stiffness[(i, j)] * rows[j][b]).sum::<f64>())
                .sum()
        };
        let mut hessian: [f64; 64] = std::array::from_fn(|k| by(k / 8, k % 8));
        damp(&self.index, &hessian, self.loss_time, at, sink);
        let seat = self.seat_at(at.q);
        hessian[2 * 8 + 2] -= state.load[0] * seat.x + state.load[1] * seat.y;
        let gradient: [f64; 8] = std::array::from_fn(|a| (0..5).map(|i| state.load[i] * rows[i][a]).sum());
        sink.element(&Element {
            part: Part::Housing,
            index: &self.index,
            gradient: &gradient,
            hessian: &hessian,
            stored: state.stored,
        });
    }

    /// As if the rows held the carrier in the middle: what play they have is along the axis.
    fn limits(&self, q: &[f64], _: f64, add: &mut dyn FnMut(Limit<'_>)) {
        let (at, rows) = (self.displacement(q), self.rows(q));
        let stiffness = self.rows.react(&Five::zeros()).stiffness;
        for axis in 0..2 {
            let (gradient, value) = (&rows[axis][..5], at[axis]);
            let stiffness = stiffness[(axis, axis)].max(1.0);
            add(Limit::Bond(Distance { index: &self.index[..5], gradient, value, stiffness }));
        }
        self.index[5..].iter().for_each(|lean| add(Limit::Held(*lean)));
    }

    fn work(&self, at: State<'_>, nominal: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        let here = self.displacement(at.q);
        let load = self.rows.react(&here).load;
        add(Cause::Elastic, load.dot(&here));
        if let Some(nominal) = nominal.of_errors() {
            add(Cause::ManufacturingErrors, -load.dot(&self.displacement(nominal)));
        }
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}

/// Constant forces on the output from outside.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct OutsideForces {
    /// Coordinates and the force (N, N·m) on each.
    index: [usize; 5],
    force: [f64; 5],
    /// −1 where the housing is the output: it leans the other way in the carrier.
    sense: f64,
}

impl OutsideForces {
    pub fn new(index: [usize; 5], sense: f64, forces: OutputForces) -> OutsideForces {
        let mut outside = OutsideForces { index, force: [0.0; 5], sense };
        outside.set_output_forces(forces);
        outside
    }
}

impl Joint for OutsideForces {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let gradient = self.force.map(|force| -force);
        let stored = gradient.iter().zip(&self.index).map(|(g, i)| g * at.q[*i]).sum();
        sink.element(&Element {
            part: Part::Housing,
            index: &self.index,
            gradient: &gradient,
            hessian: &[0.0; 25],
            stored,
        });
    }

    fn limits(&self, _: &[f64], _: f64, _: &mut dyn FnMut(Limit<'_>)) {}

    fn set_output_forces(&mut self, OutputForces { moment, axial, radial }: OutputForces) {
        self.force = [radial, 0.0, 0.0, self.sense * moment, self.sense * axial];
    }

    /// What they do elsewhere, the elastic approaches of all joints hold.
    fn work(&self, at: State<'_>, _: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        add(Cause::Elastic, self.stored(at));
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use crate::contact::ContactLaw;
    use crate::dynamics::bearing_joints::{BearingJoints, JointSettings, Lean};
    use crate::dynamics::{EquilibriumControl, System, solve_equilibrium};
    use crate::machine::{FixedMember, Machine, OutputForces};
    use crate::rig::main_bearing_load;
    use crate::templates::tao2024;
    use crate::units::ARCMIN;

    fn model(machine: &Machine, forces: OutputForces, torque: f64) -> (BearingJoints, Vec<f64>) {
        let settings = JointSettings {
            lean: Some(Lean::of(machine, forces)),
            damped: false,
            ..JointSettings::default()
        };
        let mut model = BearingJoints::held(machine, &settings).unwrap();
        model.hold_sun(1.7, 0.0);
        model.set_load(torque);
        let control = EquilibriumControl { tolerance: 1e-9, force_tolerance: 1e-6, ..Default::default() };
        let start = model.nominal_position_at(1.7);
        let found = solve_equilibrium(&model, 0.0, &start, control).unwrap();
        (model, found.position)
    }

    /// Forces are differences of the stored energy and tangents those of the forces, under forces from outside,
    /// whichever member is at rest.
    #[test]
    fn a_leaning_output_derives_from_its_energy() {
        for fixed in [FixedMember::Housing, FixedMember::Carrier] {
            let machine = Machine { fixed_member: fixed, ..tao2024() };
            let forces = OutputForces { moment: 300.0, axial: -2000.0, radial: 1500.0 };
            let (model, position) = model(&machine, forces, machine.rated.torque);
            let (n, rest) = (model.size(), vec![0.0; model.size()]);
            let at = |q: &[f64]| {
                let (mut force, mut tangent) = (vec![0.0; n], model.linearisation_at_rest());
                let balance = model.evaluate(0.0, q, &rest, &mut force, &mut tangent);
                let torque = q[model.output_index()] * machine.rated.torque;
                (balance.stored + torque, force, tangent)
            };
            let place: Vec<f64> = position
                .iter()
                .zip(model.scale())
                .enumerate()
                .map(|(i, (q, scale))| q + 0.02 * scale * ((i * 7919 % 13) as f64 / 6.0 - 1.0))
                .collect();
            let (_, force, tangent) = at(&place);
            let work = |i: usize| model.scale()[i];
            let largest = (0..n).fold(0.0_f64, |most, i| most.max((force[i] * work(i)).abs()));
            let layout = &model.layout;
            let shafts = [layout.shaft_slopes(1).unwrap()[0], layout.shaft_slopes(0).unwrap()[3]];
            let [x, y] = layout.disc_slopes(1).unwrap();
            let on_discs = [x, y, layout.housing()[2]];
            let others = shafts.into_iter().flatten().chain([0, 1, 5]).chain(on_discs).filter(|at| *at < n);
            for (column, lean) in layout.lean().unwrap().into_iter().chain(others).enumerate() {
                let step = 1e-5 * model.scale()[lean];
                let ends = [step, -step].map(|way| {
                    let mut moved = place.clone();
                    moved[lean] += way;
                    at(&moved)
                });
                let slope = (ends[1].0 - ends[0].0) / (2.0 * step);
                assert!(
                    ((slope - force[lean]) * work(lean)).abs() < 1e-5 * largest,
                    "{fixed:?} {column}: {slope} {}",
                    force[lean]
                );
                let stiffest =
                    (0..n).fold(0.0_f64, |most, i| most.max((tangent.stiffness(i, lean) * work(i)).abs()));
                for row in 0..n {
                    let slope = (ends[1].1[row] - ends[0].1[row]) / (2.0 * step);
                    let error = ((slope - tangent.stiffness(row, lean)) * work(row)).abs();
                    // A rigid disc's tangents leave out how contacts roll to other curvatures.
                    let left_out = if on_discs.contains(&lean) { 4.0 } else { 1.0 };
                    assert!(error < 1e-3 * left_out * stiffest, "{fixed:?} {row} by {lean}: {slope}");
                }
            }
        }
    }

    /// Nothing but the main bearings holds the carrier upright: a moment leans it as it leans the pair by itself,
    /// and a moment the other way leans it the other way.
    #[test]
    fn a_moment_leans_the_carrier_as_the_pair_alone() {
        for machine in [tao2024(), crate::templates::design("rv-80e").unwrap().machine()] {
            let lean = |moment: f64| {
                let forces = OutputForces { moment, ..OutputForces::default() };
                let (model, position) = model(&machine, forces, 0.05 * machine.rated.torque);
                let [about_x, about_y, _] = model.layout.lean().unwrap();
                [position[about_x], position[about_y]]
            };
            let (ahead, still, behind) = (lean(200.0), lean(0.0), lean(-200.0));
            let alone =
                main_bearing_load(&machine, OutputForces { moment: 200.0, ..Default::default() }).unwrap();
            let tilt = 0.5 * (ahead[1] - behind[1]);
            assert!((tilt / alone.tilt - 1.0).abs() < 0.01, "{} {}", tilt / ARCMIN, alone.tilt / ARCMIN);
            assert!((ahead[1] + behind[1] - 2.0 * still[1]).abs() < 0.02 * tilt);
            assert!(still[1].abs() < 0.05 * tilt, "{}", still[1] / ARCMIN);
        }
    }

    /// A moment leans the carrier, and the crankshafts with it. Discs hang between the shafts and the pins, which stand
    /// straight: pins a thousand times softer let them go with the shafts.
    #[test]
    fn discs_lean_with_the_crankshafts_as_far_as_pins_let_them() {
        // Crankshafts that hardly bend.
        const STOUT: &str = include_str!("../../../../tests/designs/rv-80e-two-crankshafts.toml");
        let stout = crate::design::Design::parse(STOUT, "stout").unwrap().machine();
        for machine in [tao2024(), stout] {
            let leans = |stiffness: f64| {
                let mut machine = machine.clone();
                machine.contact_law = ContactLaw::Linear { stiffness };
                let by = |moment: f64| {
                    let forces = OutputForces { moment, ..OutputForces::default() };
                    let (model, q) = model(&machine, forces, 0.3 * machine.rated.torque);
                    let shafts = (0..machine.crankshafts.count).flat_map(|k| {
                        model.layout.shaft_slopes(k).unwrap()[2..].iter().map(|slope| q[slope[0]])
                    });
                    let discs = (0..machine.disc_count).map(|j| q[model.layout.disc_slopes(j).unwrap()[0]]);
                    let mean = |list: Vec<f64>| list.iter().sum::<f64>() / list.len() as f64;
                    [q[model.layout.lean().unwrap()[1]], mean(shafts.collect()), mean(discs.collect())]
                };
                let (ahead, behind) = (by(200.0), by(-200.0));
                [0, 1, 2].map(|i| 0.5 * (ahead[i] - behind[i]))
            };
            let [carrier, shafts, discs] = leans(3e8);
            assert!(shafts > 0.8 * carrier && shafts < carrier, "{}: {shafts} {carrier}", machine.name);
            assert!(discs > 0.02 * shafts && discs < 0.6 * shafts, "{}: {discs} {shafts}", machine.name);
            let [_, shafts, soft] = leans(3e5);
            assert!((soft / shafts - 1.0).abs() < 0.02, "{}: {soft} {shafts}", machine.name);
        }
    }
}
