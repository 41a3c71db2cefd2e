use super::*;
use crate::contact::ContactSpring;
use crate::dynamics::{
    Balance, BearingJoints, Contact, DenseLinearisation, ElasticCoordinates, JointSettings, RoundSupport,
};
use crate::geometry::Relief;
use crate::machine::ManufacturingErrors;
use crate::units::{ARCMIN, UM};

/// New, drawn and worn machines of four kinds, from rated torque down to a thousandth of it: the search from
/// the nominal position and that from the equilibrium under the opposite torque converge to the same position
/// in few evaluations, and the forces there vanish.
#[test]
fn equilibria_do_not_depend_on_the_start() {
    let tolerances = crate::templates::design("tao2024").unwrap().drawing_tolerances().unwrap();
    let machines = [
        crate::templates::tao2024(),
        crate::templates::design("rv-80e").unwrap().machine(),
        crate::random_designs::sound_design(6).0.machine(),
        crate::random_designs::sound_design(11).0.machine(),
    ];
    let mut counts = Vec::new();
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
            let control = EquilibriumControl { tolerance: 1e-8, force_tolerance: 1e-7, held: None };
            let mut other = None;
            for (place, share) in [1.0, -1.0, 0.03, -0.03, 1e-3].into_iter().enumerate() {
                let sun = 0.37 * (1.0 + place as f64);
                model.hold_sun(sun, 0.0);
                model.set_load(share * machine.rated.torque);
                let nominal = model.nominal_position_at(sun);
                let found = solve_equilibrium(&*model, 0.0, &nominal, control)
                    .unwrap_or_else(|error| panic!("{} {share}: {error}", machine.name));
                counts.push(found.iterations);
                let mut force = vec![0.0; nominal.len()];
                model.evaluate_forces(0.0, &found.position, &vec![0.0; nominal.len()], &mut force);
                let left = force.iter().fold(0.0, |most: f64, force| most.max(force.abs()));
                assert!(
                    left < 1e-5 * (share * machine.rated.torque).abs() + 2e-7,
                    "{} {share}: {left}",
                    machine.name
                );
                if let Some(way) = other
                    .replace(found.position.iter().zip(&nominal).map(|(q, n)| q - n).collect::<Vec<f64>>())
                {
                    let start: Vec<f64> = nominal.iter().zip(way).map(|(n, d)| n + d).collect();
                    let again = solve_equilibrium(&*model, 0.0, &start, control).unwrap();
                    let [a, b] = [&found, &again].map(|found| model.output_error(&found.position));
                    assert!((a - b).abs() < 1e-6 * ARCMIN, "{} {share}: {a} {b}", machine.name);
                }
            }
        }
    }
    counts.sort_unstable();
    let (median, worst) = (counts[counts.len() / 2], counts[counts.len() - 1]);
    assert!(median <= 5 && worst <= 20, "{median} to {worst} evaluations");
}

/// A bead in the plane between walls, with a spring to each side; an elastic wall has a coordinate of its own,
/// and the bead may be in a round hole.
#[derive(Default)]
struct Bead {
    walls: Vec<([f64; 2], f64)>,
    /// Stiffness of the third coordinate, the displacement of the first wall.
    elastic: f64,
    eliminated: ElasticCoordinates,
    hole: f64,
}

const WALL: ContactSpring = ContactSpring::Linear { stiffness: 1e8 };
const PULL: [f64; 3] = [300.0, 200.0, 0.0];
const SPRING: f64 = 1e7;

impl Bead {
    fn see(&self, q: &[f64], see: &mut dyn FnMut(&Contact<'_>)) {
        for (number, (normal, place)) in self.walls.iter().enumerate() {
            let give = if number == 0 { 1.0 } else { 0.0 };
            let gap = place - normal[0] * q[0] - normal[1] * q[1] + give * q[2];
            let gradient = [-normal[0], -normal[1], give];
            let (index, place) = (&[0, 1, 2][..], None);
            see(&Contact { place, ..Contact::new(index, &gradient, gap, WALL) });
        }
    }

    fn support(&self, q: &[f64]) -> RoundSupport {
        let (index, gradient) = (vec![0, 1], vec![[1.0, 0.0], [0.0, 1.0]]);
        let shift = [q[0], q[1]];
        RoundSupport { index, gradient, shift, stiffness: 1e8, clearance: self.hole }
    }
}

impl System for Bead {
    fn linearisation(&self) -> DenseLinearisation {
        DenseLinearisation::new(3)
    }

    fn mass(&self) -> &[f64] {
        &[1.0; 3]
    }

    fn scale(&self) -> &[f64] {
        &[1e-5; 3]
    }

    fn evaluate(
        &self,
        _: f64,
        q: &[f64],
        _: &[f64],
        force: &mut [f64],
        tangent: &mut DenseLinearisation,
    ) -> Balance {
        tangent.clear();
        let stiffness = [SPRING, SPRING, self.elastic];
        for i in 0..3 {
            force[i] = PULL[i] - stiffness[i] * q[i];
            tangent.add_stiffness(i, i, stiffness[i]);
        }
        self.see(q, &mut |contact| {
            let pressed = contact.spring.at(-contact.gap).force;
            force.iter_mut().zip(contact.gradient).for_each(|(sum, g)| *sum += pressed * g);
        });
        if self.hole > 0.0 {
            let support = self.support(q);
            let push = support.force(support.shift);
            (0..2).for_each(|i| force[i] -= push[i]);
        }
        Balance::default()
    }

    fn evaluate_statics(&self, time: f64, q: &[f64], _: f64, evaluation: &mut Evaluation) {
        evaluation.contacts.clear();
        let mut tangent = self.linearisation();
        self.evaluate(time, q, &[0.0; 3], &mut evaluation.force, &mut tangent);
        evaluation.smooth.take_rows(&tangent, evaluation.columns.searched());
        self.see(q, &mut |contact| evaluation.contacts.push(contact, &evaluation.columns));
        if self.hole > 0.0 {
            evaluation.contacts.push_support(self.support(q), &evaluation.columns);
        }
    }

    fn elastic(&self) -> Option<&ElasticCoordinates> {
        (!self.eliminated.is_empty()).then_some(&self.eliminated)
    }

    fn crank_angle(&self, _: &[f64]) -> f64 {
        0.0
    }
}

fn rest_of(bead: &Bead) -> Equilibrium {
    let control = EquilibriumControl { tolerance: 1e-9, force_tolerance: 1e-7, held: None };
    solve_equilibrium(bead, 0.0, &[-2e-6, 0.0, 0.0], control).unwrap()
}

/// With linear walls the model is exact, and one step converges.
#[test]
fn linear_contacts_need_one_step() {
    let walls = vec![([1.0, 0.0], 2e-6), ([0.6, 0.8], 3e-6), ([-1.0, 0.0], 1e-6)];
    let found = rest_of(&Bead { walls, elastic: 1e12, ..Bead::default() });
    assert!(found.iterations <= 3, "{found:?}");
    // Without walls the displacement would be 30 µm.
    assert!(found.position[0] > 2e-6 && found.position[0] < 4e-6, "{:?}", found.position);
}

/// A wall on a spring in series: compared with the closed form, with its coordinate as an unknown and
/// eliminated.
#[test]
fn elastic_coordinates_are_springs_in_series() {
    let (stiffness, place) = (2e7, 2e-6);
    let series = 1.0 / (1.0 / 1e8 + 1.0 / stiffness);
    let exact = (PULL[0] + series * place) / (SPRING + series);
    for is_eliminated in [false, true] {
        let mut eliminated = ElasticCoordinates::new(3);
        if is_eliminated {
            eliminated.add(&[2], &[stiffness]);
        }
        let found =
            rest_of(&Bead { walls: vec![([1.0, 0.0], place)], elastic: stiffness, eliminated, hole: 0.0 });
        let [x, _, give] = found.position[..] else { panic!() };
        assert!((x / exact - 1.0).abs() < 1e-9, "{is_eliminated}: {x} {exact}");
        assert!((give - series * (x - place) / stiffness).abs() < 1e-15, "{is_eliminated}: {give}");
        assert!(found.iterations <= 3, "{is_eliminated}: {}", found.iterations);
    }
}

/// A bead in a round hole: equilibrium of spring, wall and external force, in the direction of this force.
#[test]
fn a_round_hole_has_the_force_of_a_circle() {
    let clearance = 5e-6;
    let found = rest_of(&Bead { elastic: 1.0, hole: clearance, ..Bead::default() });
    let pull = PULL[0].hypot(PULL[1]);
    let exact = (pull + 1e8 * clearance) / (SPRING + 1e8);
    let distance = found.position[0].hypot(found.position[1]);
    assert!((distance / exact - 1.0).abs() < 1e-9, "{distance} {exact}");
    assert!((found.position[1] / found.position[0] - PULL[1] / PULL[0]).abs() < 1e-9);
}
