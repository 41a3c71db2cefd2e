//! A mechanism other than the reducers of this library, built with the public interface: two shafts in
//! bearings, coupled by parallel cranks.

use std::f64::consts::TAU;
use std::path::Path;

use crate::dynamics::mechanism::{
    Arm, Axis, Body, Element, Flanges, Input, Joint, Limit, Mechanism, NominalMotion, Part, Registry,
    Resistance, Sink, State, Support,
};
use crate::dynamics::{
    Drive, DynamicsError, EquilibriumControl, OutputLoad, Reducer, Run, RunPlan, System, solve_equilibrium,
};
use crate::progress::Silent;

/// A rod of stiffness k (N/m) between two crank pins.
#[derive(Debug, Clone)]
struct Rod {
    /// (x, y, θ) of either shaft.
    index: [usize; 6],
    crank: f64,
    phase: f64,
    length: f64,
    stiffness: f64,
}

impl Rod {
    /// Elongation in m and its gradient.
    fn stretch(&self, q: &[f64]) -> (f64, [f64; 6]) {
        let [x, y, turn, ox, oy, other] = self.index;
        let pin = |x: usize, y: usize, turn: usize| {
            let (sin, cos) = (q[turn] + self.phase).sin_cos();
            ([q[x] + self.crank * cos, q[y] + self.crank * sin], [-self.crank * sin, self.crank * cos])
        };
        let (a, turning_a) = pin(x, y, turn);
        let (b, turning_b) = pin(ox, oy, other);
        let d = [b[0] - a[0], b[1] - a[1]];
        let length = d[0].hypot(d[1]);
        let e = [d[0] / length, d[1] / length];
        let along = |v: [f64; 2]| e[0] * v[0] + e[1] * v[1];
        (length - self.length, [-e[0], -e[1], -along(turning_a), e[0], e[1], along(turning_b)])
    }
}

impl Joint for Rod {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let (stretch, gradient) = self.stretch(at.q);
        // The force's own tangent by differences; user-defined joints may do the same.
        let mut hessian = [0.0; 36];
        for column in 0..6 {
            let step = 1e-7;
            let mut q = at.q.to_vec();
            q[self.index[column]] += step;
            let (ahead, with) = self.stretch(&q);
            q[self.index[column]] -= 2.0 * step;
            let (behind, without) = self.stretch(&q);
            for row in 0..6 {
                hessian[row * 6 + column] =
                    self.stiffness * (ahead * with[row] - behind * without[row]) / (2.0 * step);
            }
        }
        let (index, gradient) = (&self.index[..], &gradient.map(|g| self.stiffness * stretch * g)[..]);
        let stored = 0.5 * self.stiffness * stretch * stretch;
        sink.element(&Element { part: Part::new("rods"), index, gradient, hessian: &hessian, stored });
    }

    fn limits(&self, _: &[f64], _: f64, _: &mut dyn FnMut(Limit<'_>)) {}

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}

const BEARING: f64 = 2e8;
const ROD: f64 = 5e7;
const CRANK: f64 = 0.03;
const APART: f64 = 0.2;
const INERTIA: f64 = 2e-3;

/// Two shafts 200 mm apart, coupled by two rods at a right angle, so that the output rotates with the input.
fn coupling(clearance: f64) -> Mechanism {
    let mut bodies = Registry::default();
    let place = Axis { mass: 1.5, scale: 1e-5, free: true };
    let turn = |free| Axis { mass: INERTIA, scale: 3e-4, free };
    let mut shaft = |x: f64, free: bool| {
        let at = Arm { radius: x, phase: 0.0 };
        let nominal = NominalMotion { turn: Some(super::Turn::of(1.0)), ..NominalMotion::carried(at, 0.0) };
        bodies.add(Body { axes: vec![place, place, turn(free)], has_place: true, nominal })
    };
    let (output, input) = (shaft(APART, true), shaft(0.0, false));
    // The ground has no mass.
    let mut ground = |x: f64| {
        let still = Axis { mass: 0.0, scale: 1.0, free: false };
        let nominal = NominalMotion::carried(Arm { radius: x, phase: 0.0 }, 0.0);
        bodies.add(Body { axes: vec![still; 2], has_place: true, nominal })
    };
    let (far, near) = (ground(APART), ground(0.0));
    let coordinates = bodies.number();
    let [output, input] = [output, input].map(|body| coordinates.of(body).to_vec());
    let support = |shaft: &[usize], ground: &[usize], seat: Arm| Support {
        part: Part::new("bearings of the shafts"),
        cause: None,
        index: [shaft[0], shaft[1], shaft[2], ground[0], ground[1]],
        stiffness: BEARING,
        clearance,
        seat,
        loss_time: 0.0,
    };
    let [far, near] = [far, near].map(|body| coordinates.of(body).to_vec());
    let rod = |phase: f64| Rod {
        index: [input[0], input[1], input[2], output[0], output[1], output[2]],
        crank: CRANK,
        phase,
        length: APART,
        stiffness: ROD,
    };
    let joints: Vec<Box<dyn Joint>> = vec![
        Box::new(support(&input, &near, Arm::default())),
        Box::new(support(&output, &far, Arm::default())),
        Box::new(rod(0.0)),
        Box::new(rod(0.25 * TAU)),
    ];
    let flanges = Flanges { input: input[2], output: output[2], phase: output[2], ratio: 1.0 };
    Mechanism::new(coordinates, joints, flanges, Resistance::none()).unwrap()
}

/// The coupling keeps its ratio at every angle, has the compliance of springs in series, and is symmetric under
/// reversal.
#[test]
fn a_coupling_has_its_ratio_and_compliance_at_every_angle() {
    let mut coupling = coupling(0.0);
    // Each rod transmits a part of the torque, and the bearings of both shafts deflect along the rods. With
    // rods at right angles, k_θ = Σ k r² sin² = k r² at every angle, except for the compliance of the bearings,
    // on which both rods act.
    let control = EquilibriumControl::default();
    for angle in [0.0, 0.4, 1.1, 2.9] {
        coupling.hold_input(angle, 0.0);
        let mut errors = [0.0; 2];
        for (error, sign) in errors.iter_mut().zip([1.0, -1.0]) {
            coupling.set_load(20.0 * sign);
            let start = coupling.nominal_position_at(angle);
            let rest = solve_equilibrium(&coupling, 0.0, &start, control).unwrap();
            *error = coupling.output_error(&rest.position);
            let mut force = vec![0.0; coupling.size()];
            coupling.evaluate_forces(0.0, &rest.position, &vec![0.0; start.len()], &mut force);
            assert!(force.iter().all(|force| force.abs() < 1e-6), "{force:?}");
        }
        assert!((errors[0] + errors[1]).abs() < 2e-3 * errors[0].abs(), "{errors:?}");
        // Forces F₁ = T s/r, F₂ = T c/r of rods at angle φ (s = sin φ, c = cos φ) act along x: the force on
        // either bearing is F₁ + F₂.
        let (sin, cos) = f64::sin_cos(angle);
        let (a, b) = (sin, cos);
        let stretch = |load: f64, k: f64| load / k;
        let torque = 20.0 / CRANK;
        // Castigliano's theorem with one redundant force: minimum of Σ F²/2k over the distribution of the
        // torque between the rods.
        let energy = |f: f64| {
            let (first, second) =
                if b.abs() > a.abs() { (f, (torque - f * a) / b) } else { ((torque - f * b) / a, f) };
            0.5 * (first * stretch(first, ROD) + second * stretch(second, ROD))
                + (first + second).powi(2) / BEARING
        };
        // The energy is a quadratic function of f.
        let (e0, e1, e2) = (energy(-1.0), energy(0.0), energy(1.0));
        let least = e1 - (e2 - e0).powi(2) / (8.0 * (e2 - 2.0 * e1 + e0));
        let expected = -2.0 * least / 20.0;
        assert!((errors[0] / expected - 1.0).abs() < 2e-3, "{angle}: {} {expected}", errors[0]);
    }
}

/// Clearance of the bearings, with an isotropic law in two components, adds free travel; the result does not
/// depend on the start.
#[test]
fn clearance_of_a_coupling_adds_free_travel() {
    let mut coupling = coupling(10e-6);
    coupling.hold_input(0.7, 0.0);
    coupling.set_load(5.0);
    let start = coupling.nominal_position_at(0.7);
    let rest = solve_equilibrium(&coupling, 0.0, &start, EquilibriumControl::default()).unwrap();
    let error = coupling.output_error(&rest.position);
    for shift in [-8e-6, 5e-6] {
        let elsewhere: Vec<f64> = start.iter().map(|q| q + shift).collect();
        let again = solve_equilibrium(&coupling, 0.0, &elsewhere, EquilibriumControl::default()).unwrap();
        assert!((coupling.output_error(&again.position) - error).abs() < 1e-9, "{error}");
    }
    let tight = super::tests::coupling(0.0);
    assert!(error < 0.0 && tight.flanges() == coupling.flanges());
}

/// Driven at a constant speed against a load, the output follows the input and the energy balance is fulfilled.
#[test]
fn a_running_coupling_conserves_energy() {
    let mut coupling = coupling(0.0);
    coupling.set_input(Input::Driven(Drive::SpeedLaw { speed: 30.0, rise_time: 0.01 }));
    coupling.set_output_load(OutputLoad::Constant { torque: 10.0 });
    let mut run = Run::new(coupling, RunPlan { end: 0.05, ..RunPlan::default() }, &Silent).unwrap();
    run.finish(&Silent).unwrap();
    let result = run.result();
    let last = result.series.last().unwrap();
    assert!(last.transmission_error.abs() < 1e-3 && (last.output_speed - 30.0).abs() < 0.5, "{last:?}");
    let energy = result.energy;
    assert!(energy.imbalance().abs() < 1e-4 * energy.turnover, "{energy:?}");
}

#[test]
fn invalid_mechanisms_are_refused() {
    let mut bodies = Registry::default();
    let axis = |scale, free| Axis { mass: 1.0, scale, free };
    let held = bodies.add_turn(axis(1.0, false), NominalMotion::default());
    bodies.add_turn(axis(0.0, true), NominalMotion::default());
    let coordinates = bodies.number();
    let output = coordinates.of(held)[0];
    let flanges = |output| Flanges { input: output, output, phase: 0, ratio: 1.0 };
    let build = |flanges| Mechanism::new(coordinates.clone(), Vec::new(), flanges, Resistance::none());
    for (flanges, word) in [(flanges(output), "output"), (flanges(0), "scale")] {
        let DynamicsError::InvalidValue { .. } = build(flanges).unwrap_err() else { panic!("{word}") };
        assert!(build(flanges).unwrap_err().to_string().contains(word));
    }
}

/// Names of parts come from the machine: the files of the mechanism contain none, and do not depend on the
/// module of any family.
#[test]
fn files_of_the_mechanism_contain_no_names_of_a_family() {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src/dynamics/mechanism")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if !path.ends_with("tests.rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                let named =
                    ["crankshaft", "turning-arm", "planet", "Machine", "Stage", "PartWear", "PartLoads"];
                let found = named.iter().find(|word| text.contains(**word));
                assert!(found.is_none(), "{}: {found:?}", path.display());
            }
        }
    }
}
