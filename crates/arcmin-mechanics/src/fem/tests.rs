//! The reduced disc compared with the full mesh, and results that must not depend on parameters of the model.

use std::sync::OnceLock;

use super::solve::ModeRange;
use super::*;
use crate::contact::ContactLaw;
use crate::geometry::Relief;
use crate::machine::{CrankAngle, Machine};
use crate::templates::tao2024;
use crate::units::ARCMIN;

mod compliance;

/// Plane stress on a mesh coarse enough for tests: edges 1.5 times as long.
fn coarse(shape: &DiscShape) -> FlexibleSettings {
    let fine = FlexibleSettings::plane_stress(shape);
    let sizes =
        MeshSizes { flank: 1.5 * fine.sizes.flank, flank_rows: 2, bore: 1.5 * fine.sizes.bore, ..fine.sizes };
    FlexibleSettings { sizes, ..fine }
}

struct Fixture {
    model: DiscModel,
    reduced: ReducedDisc,
    report: ReductionReport,
}

fn fixture() -> &'static Fixture {
    fixture_of(&tao2024(), BoreInterface::PerBore)
}

/// The reference machine's disc as it is, or with the windows assumed for its carrier's pillars, with one of
/// the two kinds of movable bores.
fn fixture_of(machine: &Machine, interface: BoreInterface) -> &'static Fixture {
    static FIXTURES: [OnceLock<Fixture>; 4] = [const { OnceLock::new() }; 4];
    let windows = usize::from(!machine.disc.windows.is_empty());
    FIXTURES[2 * usize::from(interface == BoreInterface::Rims) + windows].get_or_init(|| {
        let shape = DiscShape::of(machine, 0);
        let settings = FlexibleSettings { interface, ..coarse(&shape) };
        let model = DiscModel::new(shape, settings).unwrap();
        let (reduced, report) = model.reduce().unwrap();
        Fixture { model, reduced, report }
    })
}

/// The reduced disc of the reference machine, on the coarse mesh.
pub(crate) fn reduced() -> &'static ReducedDisc {
    &fixture().reduced
}

pub(crate) fn discs(machine: &Machine) -> FlexibleDiscs {
    discs_with(machine, BoreInterface::PerBore)
}

/// Discs whose bores have deformable rims.
pub(crate) fn discs_with_rims(machine: &Machine) -> FlexibleDiscs {
    discs_with(machine, BoreInterface::Rims)
}

fn discs_with(machine: &Machine, interface: BoreInterface) -> FlexibleDiscs {
    let reduce = |_: &DiscShape| Ok::<_, FemError>(fixture_of(machine, interface).reduced.clone());
    FlexibleDiscs::with(DiscShape::all(machine), reduce).unwrap()
}

#[test]
fn reduction_reports_small_errors_against_the_full_mesh() {
    let report = fixture().report;
    assert!(report.own_compliance_error < 0.01, "{report:?}");
    assert!(report.cross_compliance_error < 0.01, "{report:?}");
    // Modes alone do not resolve a load that moves along the flank; therefore the static compliance is stored
    // as well.
    assert!(report.modal_compliance_gap > 0.1, "{report:?}");
}

/// The reduced disc with free interface has the natural frequencies of the free disc of the full mesh.
#[test]
fn free_frequencies_of_the_reduced_disc_are_those_of_the_mesh() {
    let Fixture { model, reduced, .. } = fixture();
    let exact = model.free_modes(8).unwrap().frequencies();
    let found = reduced.free_frequencies().unwrap();
    for k in 0..3 {
        assert!(found[k] < 1.0, "three rigid motions: {found:?}");
    }
    for k in 3..8 {
        // Rayleigh–Ritz values are upper bounds; with nine normal modes up to 40 kHz the first five elastic
        // ones are within a few per cent.
        assert!(
            found[k] >= exact[k] * (1.0 - 1e-9) && found[k] < 1.02 * exact[k],
            "{} {}",
            found[k],
            exact[k]
        );
    }
}

#[test]
fn one_spider_for_all_bores_leaves_none_to_bearings() {
    let mut tied = reduced().clone();
    tied.interface = Interface::default();
    assert_eq!(tied.free_modes(3).unwrap_err(), FemError::NoInterface);
}

#[test]
fn held_modes_are_reproduced() {
    let Fixture { model, reduced, .. } = fixture();
    let exact = model.held_modes(ModeRange::Count(6)).unwrap();
    for (a, b) in exact.eigenvalues.iter().zip(&reduced.eigenvalues) {
        assert!((a / b - 1.0).abs() < 1e-6);
    }
}

/// The static compliance is the same for any number of modes as coordinates with their residual compliance.
#[test]
fn modes_and_residual_compliance_add_up_to_the_static_compliance() {
    let reduced = &fixture().reduced;
    let (a, b) = (reduced.stations.stencil(0.012), reduced.stations.stencil(1.7));
    for modes in [0, 3, 9, reduced.eigenvalues.len()] {
        let residual = reduced.residual_compliance(modes);
        let modal = |p: &Stencil, q: &Stencil| {
            (0..modes)
                .map(|m| reduced.mode_at(m, p) * reduced.mode_at(m, q) / reduced.eigenvalues[m])
                .sum::<f64>()
        };
        let cross = residual.cross(&a, &b) + modal(&a, &b);
        assert!((cross - reduced.compliance.cross(&a, &b)).abs() < 1e-9 * reduced.compliance.own(&a));
        // φ² between stations differs from its spline.
        let own = residual.own(&a) + modal(&a, &a);
        assert!((own / reduced.compliance.own(&a) - 1.0).abs() < 5e-3);
    }
}

/// The displacement of a point under its own load, plus that of the half-space down to the reading depth, does
/// not depend on this depth: no part is counted twice or left out. The mesh is in plane stress, the logarithmic
/// term in plane strain; they differ by ν² of the change.
#[test]
fn total_compliance_does_not_depend_on_the_reading_depth() {
    let Fixture { model, reduced, .. } = fixture();
    let material = &model.shape.material;
    for station in [2.0, 5.0, 7.0] {
        let tau = reduced.stations.parameter(station);
        let unknowns = model.deflect(&[FlankLoad { tau, force: 1.0 }]);
        let total = |depth: f64| {
            let inside = model.read_at_depth(&unknowns, tau, depth).unwrap();
            inside
                + 2.0 * material.plane_strain_compliance() / (std::f64::consts::PI * model.shape.width)
                    * depth.ln()
        };
        let own = model.read_at_depth(&unknowns, tau, 1e-3).unwrap();
        for depth in [1.25e-3, 1.5e-3, 2e-3] {
            assert!(
                (total(depth) - total(1e-3)).abs() < 0.03 * own,
                "{depth}: {} of {own}",
                total(depth) - total(1e-3)
            );
        }
        // The trap: Johnson's formula down to 2 r_p in addition to the mesh counts the range of 1–6 mm twice, a
        // quarter of the compliance.
        let twice = 2.0 * material.plane_strain_compliance() / (std::f64::consts::PI * model.shape.width)
            * 6.0_f64.ln();
        assert!(twice > 0.2 * own);
    }
}

#[test]
fn both_discs_of_the_reference_machine_are_one_part() {
    let machine = tao2024();
    let (first, second) = (DiscShape::of(&machine, 0), DiscShape::of(&machine, 1));
    let turn = second.turned_onto(&first).expect("half a turn brings 39 lobes and two bores onto each other");
    // 39 lobes: half a turn is a whole number of pitches plus a half, which the mounting angle compensates.
    assert!(turn > 0.0);
    assert!(discs(&machine).is_shared(0, 1));
}

fn lag(machine: &Machine, wear: f64, torque: f64, flexible: bool) -> f64 {
    let relief = Relief::uniform(wear);
    let at = CrankAngle::from_radians(0.7);
    let error = if flexible {
        machine.flexible_meshing(&relief, discs(machine)).load_sharing(at, torque).unwrap().output_error
    } else {
        machine.meshing(&relief).load_sharing(at, torque).unwrap().output_error
    };
    error.radians() / ARCMIN
}

#[test]
fn at_vanishing_torque_elastic_and_rigid_discs_have_the_same_contacts() {
    let machine = tao2024();
    for wear in [10e-6, 60e-6] {
        for torque in [1e-3, -1e-3] {
            let difference = lag(&machine, wear, torque, true) - lag(&machine, wear, torque, false);
            // The first contact is the same; 1e-3 N·m twists an elastic disc by about 1e-6'.
            assert!(difference.abs() < 1e-5, "{wear} {torque}: {difference}");
        }
    }
}

/// 412 N·m: the additional rotation of elastic discs equals that of the full mesh under the same forces, by
/// virtual work.
#[test]
fn additional_twist_of_elastic_discs_is_the_compliance_of_the_full_mesh() {
    let machine = Machine { contact_law: ContactLaw::Linear { stiffness: 2.85e8 }, ..tao2024() };
    let meshing = machine.flexible_meshing(&Relief::uniform(10e-6), discs(&machine));
    let at = CrankAngle::from_radians(0.7);
    let sharing = meshing.load_sharing(at, 412.0).unwrap();
    let model = &fixture().model;
    let loads: Vec<(f64, FlankLoad)> = sharing.discs[0]
        .iter()
        .filter(|c| c.force > 0.0)
        .map(|c| (c.gap, FlankLoad { tau: c.tau, force: c.force }))
        .collect();
    let unknowns = model.deflect(&loads.iter().map(|(_, load)| *load).collect::<Vec<_>>());
    let rigid = machine.meshing(&Relief::uniform(10e-6));
    let k = rigid.kinematics();
    let error = sharing.output_error.radians();
    let crank = at.radians() + k.crank_per_output_locked() * error;
    let pose = k.disc_pose(0, crank, k.nominal_output_angle(at.radians()) + error);
    let geometric = rigid.contacts().contacts(pose, crate::contact::DiscVelocity::REST);
    for (local, load) in &loads {
        let own = |h: f64| model.read_at_depth(&model.deflect(&[*load]), load.tau, h).unwrap();
        // All parts from the mesh: the surface displacement under all forces, with the own part replaced by
        // that at depth.
        let surface = model.read_surface(&unknowns, load.tau)
            - model.read_surface(&model.deflect(&[*load]), load.tau)
            + own(fixture().reduced.reading_depth);
        let contact = geometric
            .iter()
            .min_by(|a, b| (a.tau - load.tau).abs().total_cmp(&(b.tau - load.tau).abs()))
            .unwrap();
        let reduced = -contact.gap + local;
        assert!((reduced / surface - 1.0).abs() < 0.02, "τ {}: {reduced:e} {surface:e}", load.tau);
    }
}

#[test]
fn a_disc_ten_thousand_times_stiffer_is_rigid() {
    let mut machine = Machine { contact_law: ContactLaw::Linear { stiffness: 2.85e8 }, ..tao2024() };
    machine.disc.material.youngs_modulus *= 1e4;
    let stiff = fixture().reduced.stiffened(1e4);
    let discs = FlexibleDiscs::with(DiscShape::all(&machine), |_| Ok::<_, FemError>(stiff.clone())).unwrap();
    for wear in [0.0, 10e-6, 60e-6] {
        let relief = Relief::uniform(wear);
        let at = CrankAngle::from_radians(0.7);
        let flexible = machine.flexible_meshing(&relief, discs.clone()).load_sharing(at, 412.0).unwrap();
        let rigid = machine.meshing(&relief).load_sharing(at, 412.0).unwrap();
        assert!((flexible.output_error.radians() - rigid.output_error.radians()).abs() < 1e-4 * ARCMIN);
    }
}

/// A disc scaled to another width is the one reduced with it, for every kind of interface. Modes of equal frequency may turn
/// into each other, so that sums over all modes are compared.
#[test]
#[ignore = "long"]
fn a_widened_disc_is_that_reduced_with_its_width() {
    let shape = DiscShape::of(&tao2024(), 0);
    for interface in [BoreInterface::PerBore, BoreInterface::Rims, BoreInterface::Means] {
        let reduce = |width: f64| {
            let shape = DiscShape { width, ..shape.clone() };
            let settings = FlexibleSettings { interface, ..coarse(&shape) };
            DiscModel::new(shape, settings).unwrap().reduce().unwrap().0
        };
        let (scaled, own) = (reduce(shape.width).widened(2.5), reduce(2.5 * shape.width));
        let same = |what: &str, of: &dyn Fn(&ReducedDisc) -> Vec<f64>| {
            let (a, b) = (of(&scaled), of(&own));
            let size = b.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
            let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(
                a.len() == b.len() && apart <= 1e-7 * size,
                "{interface:?} {what}: {apart:e} of {size:e}"
            );
        };
        let residual = |disc: &ReducedDisc| disc.residual_compliance(disc.eigenvalues.len());
        let products = |rows: &[&[f64]]| {
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            rows.iter().flat_map(|a| rows.iter().map(move |b| product(a, b))).collect::<Vec<_>>()
        };
        same("eigenvalues", &|disc| disc.eigenvalues.clone());
        same("compliance", &|disc| disc.compliance.cross.clone());
        same("own compliance", &|disc| disc.compliance.own.clone());
        same("detail", &|disc| disc.compliance.own_detail.clone());
        same("modes", &|disc| residual(disc).cross);
        same("own displacement by modes", &|disc| residual(disc).own);
        same("momentum", &|disc| products(&disc.momentum.each_ref().map(Vec::as_slice)));
        same("stiffness", &|disc| disc.interface.stiffness.clone());
        same("mass", &|disc| disc.interface.mass.clone());
        same("coupling", &|disc| {
            let modes = disc.eigenvalues.len().max(1);
            products(&disc.interface.coupling.chunks(modes).collect::<Vec<_>>())
        });
        same("flank", &|disc| disc.interface.flank.clone());
    }
}

#[test]
fn cache_returns_the_same_disc_and_refuses_everything_else() {
    let Fixture { model, reduced, .. } = fixture();
    let key = CacheKey::of(&model.shape, &model.settings);
    let bytes = reduced.to_bytes(&key);
    let back = ReducedDisc::from_bytes(&bytes, &model.shape, &model.settings).unwrap();
    assert_eq!(back.to_bytes(&key), bytes);
    for place in [0, 20, 60, bytes.len() / 2, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[place] ^= 1;
        assert!(ReducedDisc::from_bytes(&damaged, &model.shape, &model.settings).is_err(), "{place}");
    }
    assert_eq!(
        ReducedDisc::from_bytes(&bytes[..bytes.len() - 8], &model.shape, &model.settings).err(),
        Some(CacheError::Damaged)
    );
    assert_eq!(ReducedDisc::from_bytes(b"", &model.shape, &model.settings).err(), Some(CacheError::Foreign));
    let other = FlexibleSettings { reading_depth: 1.1e-3, ..model.settings };
    assert_eq!(ReducedDisc::from_bytes(&bytes, &model.shape, &other).err(), Some(CacheError::OtherKey));
}

#[test]
fn vtu_contains_every_node_and_element() {
    let model = &fixture().model;
    let text = model.vtu(&[FlankLoad { tau: 0.05, force: 100.0 }], 2).unwrap();
    assert!(text.contains(&format!(
        "NumberOfPoints=\"{}\" NumberOfCells=\"{}\"",
        model.mesh.nodes.len(),
        model.mesh.element_count()
    )));
    assert!(text.trim_end().ends_with("</VTKFile>") && !text.contains("NaN"));
}

/// Plane stress compared with tetrahedra: eight held modes and the torsion of the disc between bores and teeth.
#[test]
fn val_tetrahedra_agree_with_plane_stress() {
    let shape = DiscShape::of(&tao2024(), 0);
    let plane = &fixture().model;
    let sizes = MeshSizes { flank: 1.2e-3, flank_rows: 1, bore: 2.5e-3, hole: 3.5e-3, interior: 6e-3 };
    let settings = FlexibleSettings { element: DiscElement::Solid { layers: 1 }, sizes, ..plane.settings };
    let solid = DiscModel::new(shape.clone(), settings).unwrap();
    let frequencies = |model: &DiscModel| model.held_modes(ModeRange::Count(8)).unwrap().frequencies();
    for (a, b) in frequencies(plane).iter().zip(frequencies(&solid)) {
        assert!((a / b - 1.0).abs() < 0.01, "{a} {b}");
    }
    // One newton at the same meshing angle on every tooth causes a moment about the bores.
    let pitch = std::f64::consts::TAU / shape.profile.lobe_count() as f64;
    let loads: Vec<FlankLoad> = (0..shape.profile.lobe_count())
        .map(|lobe| FlankLoad { tau: (lobe as f64 + 0.2) * pitch, force: 1.0 })
        .collect();
    let twist = |model: &DiscModel| {
        let unknowns = model.deflect(&loads);
        loads.iter().map(|load| model.read_at_depth(&unknowns, load.tau, 3e-3).unwrap()).sum::<f64>()
    };
    let (flat, deep) = (twist(plane), twist(&solid));
    assert!((flat / deep - 1.0).abs() < 0.01, "{flat:e} {deep:e}");
}
