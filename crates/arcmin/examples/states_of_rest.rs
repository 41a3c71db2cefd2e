//! Balances of shipped and random machines by the solver of the analyses and by `dynamics::statics`: how often each
//! evaluates the machine, from the nominal place and from the balance a 512th of a turn before.
//!
//! `cargo run --release -p arcmin --example states_of_rest -- [random designs] [first seed]`

#[path = "../tests/support/mod.rs"]
#[allow(dead_code)]
mod support;

use std::cell::Cell;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

use arcmin::dynamics::{
    Balance, BearingJoints, Contact, EquilibriumControl, Gap, JointSettings, System, solve_equilibrium,
    statics,
};
use arcmin::geometry::Relief;
use arcmin::machine::{Machine, ManufacturingErrors};
use arcmin::units::{ARCMIN, UM};

/// A model that counts its evaluations.
struct Counted<'a>(&'a BearingJoints, Cell<usize>);

type Tangent = <BearingJoints as System>::Linearisation;

impl System for Counted<'_> {
    type Linearisation = Tangent;

    fn linearisation(&self) -> Tangent {
        self.0.linearisation()
    }

    fn linearisation_at_rest(&self) -> Tangent {
        self.0.linearisation_at_rest()
    }

    fn mass(&self) -> &[f64] {
        self.0.mass()
    }

    fn scale(&self) -> &[f64] {
        self.0.scale()
    }

    fn evaluate(&self, time: f64, q: &[f64], v: &[f64], force: &mut [f64], tangent: &mut Tangent) -> Balance {
        self.1.set(self.1.get() + 1);
        self.0.evaluate(time, q, v, force, tangent)
    }

    fn evaluate_forces(&self, time: f64, q: &[f64], v: &[f64], force: &mut [f64]) -> Balance {
        self.1.set(self.1.get() + 1);
        self.0.evaluate_forces(time, q, v, force)
    }

    fn gaps(&self, time: f64, q: &[f64], reach: f64, see: &mut dyn FnMut(&Gap<'_>)) {
        self.0.gaps(time, q, reach, see);
    }

    fn contacts(&self, time: f64, q: &[f64], reach: f64, see: &mut dyn FnMut(&Contact<'_>)) {
        self.0.contacts(time, q, reach, see);
    }

    fn crank_angle(&self, q: &[f64]) -> f64 {
        self.0.crank_angle(q)
    }
}

/// Evaluations of all searches, and how many found nothing.
#[derive(Default)]
struct Tally {
    evaluations: Vec<usize>,
    failed: usize,
}

fn states(machine: &Machine) -> Vec<(&'static str, JointSettings)> {
    let tolerances = arcmin::templates::design("tao2024").and_then(|design| design.drawing_tolerances());
    let worn = |phi: f64| 20.0 * UM * (2.0 * phi).sin().powi(2);
    let usual = || JointSettings { damped: false, ..JointSettings::default() };
    let mut states = vec![
        ("new", usual()),
        (
            "worn",
            JointSettings {
                flank_wear: vec![Relief::from_samples(Relief::grid(360).map(worn).collect())],
                ..usual()
            },
        ),
        ("tight", JointSettings { flank_wear: vec![Relief::uniform(-4.0 * UM)], ..usual() }),
    ];
    states.extend(tolerances.map(|tolerances| {
        ("drawn", JointSettings { errors: ManufacturingErrors::draw(machine, &tolerances, 3), ..usual() })
    }));
    states
}

fn main() {
    let mut numbers = std::env::args().skip(1).map(|argument| argument.parse::<u64>().unwrap_or(1));
    let (count, first) = (numbers.next().unwrap_or(4), numbers.next().unwrap_or(1));
    let shipped = arcmin::templates::TEMPLATES.iter().filter_map(|t| arcmin::templates::design(t.name));
    let random = (first..first + count).map(|seed| support::sound_design(seed).0);
    let mut tallies: BTreeMap<(String, String, &str), [Tally; 2]> = BTreeMap::new();
    let mut apart = 0.0_f64;
    for machine in shipped.chain(random).map(|design| design.machine()) {
        for (state, settings) in states(&machine) {
            let Ok(mut model) = BearingJoints::held(&machine, &settings) else { continue };
            for share in [1.0, 0.03, 1e-3, 1e-4] {
                let mut before: [Option<Vec<f64>>; 2] = [None, None];
                for place in 0..12 {
                    let sun = model.kinematics().ratio() * TAU * f64::from(place) / 512.0;
                    model.hold_sun(sun, 0.0);
                    model.set_load(share * machine.rated().torque);
                    let nominal = model.nominal_position_at(sun);
                    let jump_tolerance = if state == "drawn" {
                        (0.01 * share + 1e-4) * machine.rated().torque.abs() * ARCMIN
                    } else {
                        0.0
                    };
                    let control = EquilibriumControl {
                        tolerance: 1e-7,
                        force_tolerance: 1e-6,
                        jump_tolerance,
                        ..EquilibriumControl::default()
                    };
                    let starts = ["nominal", "before"];
                    let mut ends: [Option<Vec<f64>>; 2] = [None, None];
                    for start in starts {
                        for (solver, end) in ends.iter_mut().enumerate() {
                            let way = if start == "before" { before[solver].as_ref() } else { None };
                            if start == "before" && way.is_none() {
                                continue;
                            }
                            let moved =
                                |way: &Vec<f64>| nominal.iter().zip(way).map(|(q, d)| q + d).collect();
                            let from = way.map_or_else(|| nominal.clone(), moved);
                            let counted = Counted(&model, Cell::new(0));
                            let found = match solver {
                                0 => solve_equilibrium(&counted, 0.0, &from, control),
                                _ => statics::rest(&counted, 0.0, &from, control, &|| false),
                            };
                            let key = (state.to_owned(), format!("{share}"), start);
                            let tally = &mut tallies.entry(key).or_default()[solver];
                            tally.evaluations.push(counted.1.get());
                            tally.failed += usize::from(found.is_err());
                            *end = found.ok().map(|found| found.position);
                        }
                        if let [Some(one), Some(other)] = &ends {
                            let error = model.output_error(one) - model.output_error(other);
                            apart = apart.max(error.abs() / ARCMIN);
                        }
                    }
                    let way = |end: Vec<f64>| end.iter().zip(&nominal).map(|(q, n)| q - n).collect();
                    before = ends.map(|end| end.map(way));
                }
            }
        }
    }
    println!(
        "state share start, balances: evaluations in the median and at most, failed; the same of statics"
    );
    for ((state, share, start), both) in &mut tallies {
        let balances = both[0].evaluations.len();
        let told = both.iter_mut().map(|tally| {
            tally.evaluations.sort_unstable();
            let (count, all) = (tally.evaluations.len(), &tally.evaluations);
            format!("{} {} {}", all[count / 2], all[count - 1], tally.failed)
        });
        println!("{state:6} {share:6} {start:8} {balances:3}: {}", told.collect::<Vec<_>>().join("; "));
    }
    println!("balances of both differ by {apart:.1e}' at most");
}
