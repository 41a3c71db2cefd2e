use super::super::JointSettings;
use super::*;
use crate::machine::{Machine, ManufacturingErrors};
use crate::random_designs::sound_design;

/// Gradients of all constraints compared with differences, at positions other than the nominal one. Returns the
/// number of constraints.
fn check_gradients(name: &str, machine: &Machine) -> usize {
    let tolerances = crate::templates::design("tao2024").unwrap().drawing_tolerances().unwrap();
    let mut errors = ManufacturingErrors::draw(machine, &tolerances, 2);
    // The slope of flank errors along the flank is omitted.
    errors.discs.iter_mut().for_each(|disc| disc.flank = Default::default());
    let settings = JointSettings { errors, ..JointSettings::default() };
    let mut meshing = BearingMeshing::new(machine, &settings).unwrap();
    meshing.model.hold_sun(2.2, 0.0);
    let model = &meshing.model;
    let scale = model.scale().to_vec();
    let place: Vec<f64> = model
        .nominal_position_at(2.2)
        .iter()
        .zip(&scale)
        .enumerate()
        .map(|(i, (q, s))| q + 0.3 * s * (i as f64 * 1.7).sin())
        .collect();
    let search = Search::new(model, &place);
    let here = search.linear(&place);
    let count = here.limits.bounds.len();
    assert!(count > 2 * model.layout.discs);
    let h = 1e-4;
    for (at, column) in search.columns.iter().enumerate() {
        let Some(column) = column else { continue };
        let moved = |sign: f64| {
            let mut q = place.clone();
            q[at] += sign * h * scale[at];
            search.linear(&q).limits.bounds
        };
        let (ahead, behind) = (moved(1.0), moved(-1.0));
        assert_eq!(ahead.len(), behind.len());
        for (row, (b, a)) in ahead.iter().zip(&behind).enumerate() {
            let slope = -(b - a) / (2.0 * h);
            let found = here.limits.row(row)[*column];
            assert!((slope - found).abs() < 2e-4 * (1.0 + found.abs()), "{name} {at} {row}: {slope} {found}");
        }
    }
    count
}

#[test]
fn gradients_of_constraints_agree_with_differences() {
    for name in ["tao2024", "rv-80e"] {
        assert!(check_gradients(name, &crate::templates::design(name).unwrap().machine()) > 100);
    }
    for seed in 1..=20 {
        check_gradients(&format!("random {seed}"), &sound_design(seed).0.machine());
    }
}
