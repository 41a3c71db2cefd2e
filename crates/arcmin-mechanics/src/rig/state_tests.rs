//! The bench as a whole: computed results do not depend on the selection, and its resolution is sufficient.

use super::*;
use crate::dynamics::{BearingMeshing, JointSettings};
use crate::load::ShareLoad;
use crate::machine::{CrankAngle, Friction, Machine, ManufacturingErrors};
use crate::progress::Silent;
use crate::templates::{design, tao2024};

/// Both shipped machines and a random one.
fn machines() -> [Machine; 3] {
    let other = design("rv-80e").unwrap().machine();
    [tao2024(), other, crate::random_designs::sound_design(6).0.machine()]
}

/// A single curve of the transmission error equals the one among all: on a new machine, on a nominal one, and
/// on a random one.
#[test]
fn one_curve_is_that_of_all() {
    let tolerances = design("tao2024").unwrap().drawing_tolerances().unwrap();
    for (place, machine) in machines().into_iter().enumerate() {
        let errors = match place {
            0 => ManufacturingErrors::default(),
            _ => ManufacturingErrors::draw(&machine, &tolerances, 5),
        };
        let settings = JointSettings { errors, ..JointSettings::default() };
        let test = |curves| {
            let plan =
                RigPlan { loop_positions: 1, error_positions: 48, curves, pins: false, running: false };
            RigState::measure(&machine, &settings, 0.0, plan, &Silent).unwrap().unwrap()
        };
        let [one, two, all] = [Curves::Rated, Curves::Forward, Curves::Every].map(test);
        assert_eq!([&one, &two, &all].map(|state| state.curves.len()), [1, 2, 4]);
        assert_eq!(one.forward_held(), None);
        assert_eq!(two.forward_held(), all.forward_held());
        assert_eq!(two.forward_held().unwrap().torque, 0.01 * machine.rated.torque.abs());
        assert_eq!(one.forward_at_rated(), all.forward_at_rated());
        assert_eq!(one.forward_at_rated().unwrap().torque, machine.rated.torque.abs());
        assert_eq!(one.spectrum, all.spectrum);
    }
}

/// Without friction the pin forces of the bench over an output turn equal those of the load sharing at the same
/// positions, for random machines.
#[test]
fn pin_forces_agree_with_the_load_sharing() {
    const PLACES: usize = 97;
    for mut machine in machines() {
        machine.friction =
            Friction { regularisation_speed: machine.friction.regularisation_speed, ..Friction::default() };
        let settings = JointSettings::default();
        let plan = RigPlan {
            loop_positions: 1,
            error_positions: PLACES,
            curves: Curves::Rated,
            pins: true,
            running: false,
        };
        let state = RigState::measure(&machine, &settings, 0.0, plan, &Silent).unwrap().unwrap();
        let pins = state.forward_at_rated().unwrap().pins.unwrap();
        let mut meshing = BearingMeshing::new(&machine, &settings).unwrap();
        let kinematics = machine.kinematics();
        let law = machine.line_contact();
        let mut found = PinLoads::default();
        for i in 0..PLACES {
            // The crankshafts turn z_c times as fast as the output, the other way.
            let turned = std::f64::consts::TAU * i as f64 / PLACES as f64 * kinematics.ratio().signum();
            let crank = CrankAngle::from_radians(-kinematics.lobe_count * turned);
            let (sharing, _) = meshing.share(crank, machine.rated.torque.abs(), None).unwrap();
            for contact in sharing.contacts().filter(|contact| contact.force > 0.0) {
                found.force = found.force.max(contact.force);
                let pressure = law.pressure(contact.force, 1.0 / contact.relative_curvature);
                found.pressure = found.pressure.max(pressure);
            }
        }
        for (bench, sharing) in [(pins.force, found.force), (pins.pressure, found.pressure)] {
            assert!((bench / sharing - 1.0).abs() < 1e-5, "{}: {pins:?} {found:?}", machine.name);
        }
    }
}

/// The default number of crank positions of the bench represents many, with two crankshafts and with three; of
/// four positions two pairs coincide if there are two crankshafts.
#[test]
fn five_crank_positions_represent_many() {
    let mut three = tao2024();
    three.crankshafts.count = 3;
    let large = design("rv-80e").unwrap().machine();
    for machine in [tao2024(), large, three] {
        let over = |positions: usize| {
            let plan = RigPlan {
                loop_positions: positions,
                error_positions: 16,
                curves: Curves::Rated,
                pins: false,
                running: false,
            };
            let settings = JointSettings::default();
            let state = RigState::measure(&machine, &settings, 0.0, plan, &Silent);
            let state = state.unwrap().unwrap();
            [state.lost_motion(), state.soft_stiffness()]
        };
        let [many, five, four] = [17, 5, 4].map(over);
        let apart = |few: [f64; 2]| (0..2).map(|k| (few[k] / many[k] - 1.0).abs()).fold(0.0, f64::max);
        assert!(apart(five) < 0.01, "{five:?} {many:?}");
        assert!(machine.crankshafts.count != 2 || apart(four) > 2.0 * apart(five), "{four:?} {many:?}");
    }
}
