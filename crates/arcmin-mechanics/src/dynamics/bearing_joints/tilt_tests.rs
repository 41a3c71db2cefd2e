//! Outputs, crankshafts and discs that tilt.

use crate::contact::ContactLaw;
use crate::dynamics::bearing_joints::{BearingJoints, JointSettings, TiltingOutput};
use crate::dynamics::{EquilibriumControl, System, solve_equilibrium};
use crate::machine::{FixedMember, Machine, OutputForces};
use crate::rig::main_bearing_load;
use crate::templates::tao2024;
use crate::units::ARCMIN;

fn model(machine: &Machine, forces: OutputForces, torque: f64) -> (BearingJoints, Vec<f64>) {
    let settings = JointSettings {
        tilt: Some(TiltingOutput::of(machine, forces)),
        damped: false,
        ..JointSettings::default()
    };
    let mut model = BearingJoints::held(machine, &settings).unwrap();
    model.hold_sun(1.7, 0.0);
    model.set_load(torque);
    let control = EquilibriumControl { tolerance: 1e-9, force_tolerance: 1e-6, ..Default::default() };
    let start = model.nominal_position_at(1.7);
    let found = solve_equilibrium(&*model, 0.0, &start, control).unwrap();
    (model, found.position)
}

/// Forces agree with differences of the stored energy, and tangents with those of the forces, under external
/// forces and for either fixed member.
#[test]
fn forces_of_a_tilting_output_are_derivatives_of_the_energy() {
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
        for (column, tilt) in layout.tilt().unwrap().into_iter().chain(others).enumerate() {
            let step = 1e-5 * model.scale()[tilt];
            let ends = [step, -step].map(|way| {
                let mut moved = place.clone();
                moved[tilt] += way;
                at(&moved)
            });
            let slope = (ends[1].0 - ends[0].0) / (2.0 * step);
            assert!(
                ((slope - force[tilt]) * work(tilt)).abs() < 1e-5 * largest,
                "{fixed:?} {column}: {slope} {}",
                force[tilt]
            );
            let stiffest =
                (0..n).fold(0.0_f64, |most, i| most.max((tangent.stiffness(i, tilt) * work(i)).abs()));
            for row in 0..n {
                let slope = (ends[1].1[row] - ends[0].1[row]) / (2.0 * step);
                let error = ((slope - tangent.stiffness(row, tilt)) * work(row)).abs();
                // A rigid disc's tangents omit the change of curvature as contacts move.
                let left_out = if on_discs.contains(&tilt) { 4.0 } else { 1.0 };
                assert!(error < 1e-3 * left_out * stiffest, "{fixed:?} {row} by {tilt}: {slope}");
            }
        }
    }
}

/// The carrier is supported against tilt by the main bearings only: the tilt under a moment is that of the pair
/// of bearings alone, and reverses with the moment.
#[test]
fn tilt_of_the_carrier_is_that_of_the_main_bearings_alone() {
    for machine in [tao2024(), crate::templates::design("rv-80e").unwrap().machine()] {
        let tilt = |moment: f64| {
            let forces = OutputForces { moment, ..OutputForces::default() };
            let (model, position) = model(&machine, forces, 0.05 * machine.rated.torque);
            let [about_x, about_y, _] = model.layout.tilt().unwrap();
            [position[about_x], position[about_y]]
        };
        let (ahead, still, behind) = (tilt(200.0), tilt(0.0), tilt(-200.0));
        let alone =
            main_bearing_load(&machine, OutputForces { moment: 200.0, ..Default::default() }).unwrap();
        let tilt = 0.5 * (ahead[1] - behind[1]);
        assert!((tilt / alone.tilt - 1.0).abs() < 0.01, "{} {}", tilt / ARCMIN, alone.tilt / ARCMIN);
        assert!((ahead[1] + behind[1] - 2.0 * still[1]).abs() < 0.02 * tilt);
        assert!(still[1].abs() < 0.05 * tilt, "{}", still[1] / ARCMIN);
    }
}

/// A moment tilts the carrier, and the crankshafts with it. Discs are coupled to the shafts and to the pins,
/// which do not tilt: with pins a thousand times softer the discs tilt with the shafts.
#[test]
fn tilt_of_discs_depends_on_the_stiffness_of_pins() {
    // Crankshafts of high bending stiffness.
    const STOUT: &str = include_str!("../../../../arcmin/tests/designs/rv-80e-two-crankshafts.toml");
    let stout = crate::design::Design::parse(STOUT, "stout").unwrap().machine();
    for machine in [tao2024(), stout] {
        let tilts = |stiffness: f64| {
            let mut machine = machine.clone();
            machine.contact_law = ContactLaw::Linear { stiffness };
            let by = |moment: f64| {
                let forces = OutputForces { moment, ..OutputForces::default() };
                let (model, q) = model(&machine, forces, 0.3 * machine.rated.torque);
                let shafts = (0..machine.crankshafts.count)
                    .flat_map(|k| model.layout.shaft_slopes(k).unwrap()[2..].iter().map(|slope| q[slope[0]]));
                let discs = (0..machine.disc_count).map(|j| q[model.layout.disc_slopes(j).unwrap()[0]]);
                let mean = |list: Vec<f64>| list.iter().sum::<f64>() / list.len() as f64;
                [q[model.layout.tilt().unwrap()[1]], mean(shafts.collect()), mean(discs.collect())]
            };
            let (ahead, behind) = (by(200.0), by(-200.0));
            [0, 1, 2].map(|i| 0.5 * (ahead[i] - behind[i]))
        };
        let [carrier, shafts, discs] = tilts(3e8);
        assert!(shafts > 0.8 * carrier && shafts < carrier, "{}: {shafts} {carrier}", machine.name);
        assert!(discs > 0.02 * shafts && discs < 0.6 * shafts, "{}: {discs} {shafts}", machine.name);
        let [_, shafts, soft] = tilts(3e5);
        assert!((soft / shafts - 1.0).abs() < 0.02, "{}: {soft} {shafts}", machine.name);
    }
}
