//! Balances of shipped and random machines: how often the search evaluates the machine, from the nominal place and from
//! the balance a 512th of a turn before, and how long it takes.
//!
//! `cargo run --release -p arcmin --example states_of_rest -- [random designs] [first seed]`

#[path = "../tests/support/mod.rs"]
#[allow(dead_code)]
mod support;

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::time::{Duration, Instant};

use arcmin::dynamics::{BearingJoints, EquilibriumControl, JointSettings, solve_equilibrium};
use arcmin::geometry::Relief;
use arcmin::machine::{Machine, ManufacturingErrors};
use arcmin::units::UM;

/// Evaluations of all searches, their time, and how many found nothing.
#[derive(Default)]
struct Tally {
    evaluations: Vec<usize>,
    time: Duration,
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
    let mut tallies: BTreeMap<(String, String, &str), Tally> = BTreeMap::new();
    for (name, machine) in shipped.chain(random).map(|design| (design.name.value.clone(), design.machine())) {
        for (state, settings) in states(&machine) {
            let Ok(mut model) = BearingJoints::held(&machine, &settings) else { continue };
            for share in [1.0, 0.03, 1e-3, 1e-4] {
                let mut before: Option<Vec<f64>> = None;
                for place in 0..12 {
                    let sun = model.kinematics().ratio() * TAU * f64::from(place) / 512.0;
                    model.hold_sun(sun, 0.0);
                    model.set_load(share * machine.rated().torque);
                    let nominal = model.nominal_position_at(sun);
                    let control = EquilibriumControl { tolerance: 1e-7, force_tolerance: 1e-6, held: None };
                    let near = before.take().map(|way| nominal.iter().zip(way).map(|(q, d)| q + d).collect());
                    let starts = [("nominal", Some(nominal.clone())), ("before", near)];
                    for (start, from) in starts {
                        let Some(from) = from else { continue };
                        let tally = tallies.entry((state.to_owned(), format!("{share}"), start)).or_default();
                        let begin = Instant::now();
                        let found = solve_equilibrium(&*model, 0.0, &from, control);
                        tally.time += begin.elapsed();
                        match found {
                            Ok(found) => {
                                tally.evaluations.push(found.iterations);
                                let way = found.position.iter().zip(&nominal).map(|(q, n)| q - n).collect();
                                before = Some(way);
                            }
                            Err(failure) => {
                                println!("{name} {state} {share} from {start} at {place}: {failure}");
                                tally.failed += 1;
                            }
                        }
                    }
                }
            }
        }
    }
    println!("state share start, balances: evaluations in the median and at most, failed, mean time");
    for ((state, share, start), Tally { evaluations: all, time, failed }) in &mut tallies {
        all.sort_unstable();
        let (count, each) = (all.len(), *time / (all.len() + *failed) as u32);
        println!(
            "{state:6} {share:6} {start:8} {count:4}: {} {}, {failed}, {each:?}",
            all[count / 2],
            all[count - 1]
        );
    }
}
