use std::cell::Cell;

use super::*;
use crate::dynamics::{Balance, BearingJoints, Contact, JointSettings, solve_equilibrium};
use crate::geometry::Relief;
use crate::machine::ManufacturingErrors;
use crate::units::{ARCMIN, UM};

/// A system that counts how often it is evaluated.
struct Counted<'a> {
    model: &'a BearingJoints,
    evaluations: Cell<usize>,
}

impl System for Counted<'_> {
    fn linearisation(&self) -> DenseLinearisation {
        self.model.linearisation()
    }

    fn linearisation_at_rest(&self) -> DenseLinearisation {
        self.model.linearisation_at_rest()
    }

    fn mass(&self) -> &[f64] {
        self.model.mass()
    }

    fn scale(&self) -> &[f64] {
        self.model.scale()
    }

    fn evaluate(
        &self,
        time: f64,
        position: &[f64],
        velocity: &[f64],
        force: &mut [f64],
        linearisation: &mut DenseLinearisation,
    ) -> Balance {
        self.evaluations.set(self.evaluations.get() + 1);
        self.model.evaluate(time, position, velocity, force, linearisation)
    }

    fn contacts(&self, time: f64, position: &[f64], reach: f64, see: &mut dyn FnMut(&Contact<'_>)) {
        self.model.contacts(time, position, reach, see);
    }

    fn crank_angle(&self, position: &[f64]) -> f64 {
        self.model.crank_angle(position)
    }
}

/// New, drawn and worn machines of four kinds, from rated torque down to a thousandth of it, from the nominal place: the
/// balance of the present solver, in few evaluations.
#[test]
fn balances_are_those_of_the_present_solver() {
    let tolerances = crate::templates::design("tao2024").unwrap().drawing_tolerances().unwrap();
    let machines = [
        crate::templates::tao2024(),
        crate::templates::design("rv-80e").unwrap().machine(),
        crate::random_designs::sound_design(6).0.machine(),
        crate::random_designs::sound_design(11).0.machine(),
    ];
    let (mut counts, mut compared) = (Vec::new(), 0);
    for machine in &machines {
        let worn = Relief::from_samples(
            Relief::grid(360).map(|phi| 20.0 * UM * (2.0 * phi).sin().powi(2)).collect(),
        );
        for settings in [
            JointSettings::default(),
            JointSettings {
                errors: ManufacturingErrors::draw(machine, &tolerances, 2),
                ..JointSettings::default()
            },
            JointSettings { flank_wear: vec![worn], ..JointSettings::default() },
        ] {
            let settings = JointSettings { damped: false, ..settings };
            let mut model = BearingJoints::held(machine, &settings).unwrap();
            let control = EquilibriumControl { tolerance: 1e-8, force_tolerance: 1e-7, ..Default::default() };
            for (place, share) in [1.0, -1.0, 0.03, -0.03, 1e-3].into_iter().enumerate() {
                let sun = 0.37 * (1.0 + place as f64);
                model.hold_sun(sun, 0.0);
                model.set_load(share * machine.rated.torque);
                let start = model.nominal_position_at(sun);
                let counted = Counted { model: &model, evaluations: Cell::new(0) };
                let found = rest(&counted, 0.0, &start, control, &|| false)
                    .unwrap_or_else(|error| panic!("{} {share}: {error}", machine.name));
                counts.push(counted.evaluations.get());
                let Ok(known) = solve_equilibrium(&model, 0.0, &start, control) else { continue };
                let [a, b] = [&found, &known].map(|found| model.output_error(&found.position));
                assert!((a - b).abs() < 1e-6 * ARCMIN, "{} {share}: {a} {b}", machine.name);
                compared += 1;
            }
        }
    }
    counts.sort_unstable();
    let (median, worst) = (counts[counts.len() / 2], counts[counts.len() - 1]);
    assert!(
        compared > 50 && median <= 6 && worst <= 20,
        "{compared} compared, {median} to {worst} evaluations"
    );
}

/// A bead in the plane between walls: with linear walls the model is the machine, and one step ends at the balance.
#[test]
fn linear_contacts_need_one_step() {
    use crate::contact::ContactSpring;
    use crate::dynamics::DenseLinearisation;

    struct Bead;
    const WALLS: [([f64; 2], f64); 3] = [([1.0, 0.0], 2e-6), ([0.6, 0.8], 3e-6), ([-1.0, 0.0], 1e-6)];
    const WALL: ContactSpring = ContactSpring::Linear { stiffness: 1e8 };

    impl System for Bead {
        fn linearisation(&self) -> DenseLinearisation {
            DenseLinearisation::new(2)
        }

        fn mass(&self) -> &[f64] {
            &[1.0, 1.0]
        }

        fn scale(&self) -> &[f64] {
            &[1e-5, 1e-5]
        }

        fn evaluate(
            &self,
            time: f64,
            q: &[f64],
            _: &[f64],
            force: &mut [f64],
            linearisation: &mut DenseLinearisation,
        ) -> Balance {
            linearisation.clear();
            force.copy_from_slice(&[300.0 - 1e7 * q[0], 200.0 - 1e7 * q[1]]);
            (0..2).for_each(|i| linearisation.add_stiffness(i, i, 1e7));
            self.contacts(time, q, f64::INFINITY, &mut |contact| {
                let pressed = contact.spring.at(-contact.gap);
                force.iter_mut().zip(contact.gradient).for_each(|(sum, g)| *sum += pressed.force * g);
                linearisation.add_spring(contact.index, contact.gradient, pressed.stiffness);
            });
            Balance::default()
        }

        fn contacts(&self, _: f64, q: &[f64], _: f64, see: &mut dyn FnMut(&Contact<'_>)) {
            for (normal, place) in WALLS {
                let gap = place - normal[0] * q[0] - normal[1] * q[1];
                let gradient = normal.map(|n| -n);
                see(&Contact { index: &[0, 1], gradient: &gradient, gap, spring: WALL });
            }
        }

        fn crank_angle(&self, _: &[f64]) -> f64 {
            0.0
        }
    }

    let control = EquilibriumControl { tolerance: 1e-6, force_tolerance: 0.5, ..Default::default() };
    let found = rest(&Bead, 0.0, &[-2e-6, 0.0], control, &|| false).unwrap();
    assert!(found.iterations <= 2 && found.residual < 0.5, "{found:?}");
    // Without walls it would go 30 µm.
    assert!(found.position[0] > 2e-6 && found.position[0] < 4e-6, "{:?}", found.position);
}
