//! Torque cycles of drives of eccentrics with friction at rest.

use super::settle::SlowLoad;
use super::*;
use crate::design::StageDesign;
use crate::dynamics::{HeldDrive, System};
use crate::dynamics::mechanism::Mechanism;
use crate::machine::StageFriction;
use crate::templates::NEMA17_19;
use crate::units::ARCMIN;

#[test]
fn explore() {
    let design = StageDesign::parse(NEMA17_19.text, "t").unwrap();
    let rated = design.rated().torque.abs();
    let held = HeldDrive::new(design.drive().joints().unwrap(), rated, 1.0);
    let given = design.friction().0;
    println!("{given:?}");
    let none = StageFriction { ring: 0.0, output: 0.0, pin_over_roller: given.pin_over_roller, bearing: 0.0 };
    for (name, f) in [("none", none), ("ring", StageFriction { ring: given.ring, ..none }), ("output", StageFriction { output: given.output, ..none }), ("bearing", StageFriction { bearing: given.bearing, ..none }), ("all", given)] {
        let t = std::time::Instant::now();
        let found = eccentric_loop(&held, &[f], 0.3).unwrap();
        let wall = t.elapsed().as_secs_f64();
        let g = evaluate_loop(&found, rated).unwrap();
        println!("{name}: lm {} bl {} k {} soft {} work {} wall {wall}", g.lost_motion / ARCMIN, g.backlash / ARCMIN, g.stiffness * ARCMIN, g.soft_stiffness * ARCMIN, g.work);
        for refine in [1, 4, 16] {
            let model = Mechanism::clone(&held.rubbing(0.3, &[f], 1e-3));
            let start = model.nominal_position_at(0.3);
            let mut m = SlowLoad::new((model, rated), 1e-3, start);
            for s in [0.05, 0.3, 0.6, 1.0] { m.change_to(-s * rated).unwrap(); }
            let falling = shares();
            let rising: Vec<f64> = falling.iter().rev().copied().collect();
            let (mut area, mut lost, mut before) = (0.0, 0.0, 1.0);
            let mut most: f64 = 0.0;
            let all: Vec<f64> = falling.into_iter().chain(rising).collect();
            for pass in 0..2 { (area, lost) = (0.0, 0.0); let _ = pass;
            for to in all.clone() {
                for k in 1..=refine {
                    let share = before + (to - before) * k as f64 / refine as f64;
                    let (t0, q0) = (-m.model.constant_load(), m.place.clone());
                    m.change_to(-share * rated).unwrap();
                    let interval = 2e-8 / 1e-3;
                    let v: Vec<f64> = m.place.iter().zip(&q0).map(|(a, b)| (a - b) / interval).collect();
                    let mut force = vec![0.0; v.len()];
                    let mut lin = m.model.linearisation();
                    let b = m.model.evaluate(0.0, &m.place, &v, &mut force, &mut lin);
                    lost += b.dissipation * interval;
                    most = most.max(force.iter().fold(0.0, |a: f64, f| a.max(f.abs())));
                    let out = m.model.output_index();
                    area += 0.5 * (t0 + share * rated) * (m.place[out] - q0[out]);
                }
                before = to;
            } }
            println!("   refine {refine}: area {area:.6e} lost {lost:.6e} residual {most:.1e}");
        }
    }
}
