//! Meshes and contours for cutters.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use super::mesh::Mesh;
use super::tests::{machine, wear};
use super::*;
use crate::geometry::{Outline as Curve, Sector, Vec2, unit};
use crate::machine::Machine;

/// The reference machine with windows in its discs.
fn with_windows() -> (Machine, Stamp) {
    let (mut machine, stamp) = machine();
    machine.disc.windows = machine.solids.windows.clone();
    assert!(!machine.disc.windows.is_empty());
    (machine, stamp)
}

fn export(options: ProfileOptions) -> ProfileExport {
    let (machine, stamp) = with_windows();
    ProfileExport::new(&machine, stamp, options).unwrap()
}

/// Every edge belongs to two triangles that traverse it in opposite directions, and no triangle has coinciding
/// corners.
fn assert_closed(mesh: &Mesh) {
    let mut edges: HashMap<(usize, usize), i32> = HashMap::new();
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            assert_ne!(a, b);
            *edges.entry((a, b)).or_default() += 1;
        }
    }
    assert!(edges.iter().all(|((a, b), count)| *count == 1 && edges.get(&(*b, *a)) == Some(&1)));
}

/// Discs with bores, holes and windows, pin and crankshaft: closed, oriented outwards, and with volumes that
/// are smaller than the exact ones by no more than the tolerance times the surface.
#[test]
fn meshes_are_closed_and_keep_their_tolerance() {
    for (flank, tolerance) in [(Flank::Modified, 1e-6), (Flank::Worn(wear()), 2e-5), (Flank::AsCut, 1e-4)] {
        let export = export(ProfileOptions { flank, tolerance, ..ProfileOptions::default() });
        let figures = export.solid_figures();
        for parts in [Parts::Discs, Parts::Pin, Parts::Crankshaft] {
            for body in export.bodies(parts).unwrap() {
                assert_closed(&body.mesh);
                let exact = figures.iter().find(|part| part.name == body.name).unwrap();
                let off = body.mesh.volume() - exact.volume;
                assert!(off.abs() < tolerance * exact.surface, "{}: {off:e}", body.name);
                assert!(off.abs() > 1e-3 * tolerance * exact.surface, "{}: idle chords, {off:e}", body.name);
            }
        }
    }
}

/// Cylinders that are nested, intersect, or nearly touch, in any order: closed, with the volume of the
/// polygons.
#[test]
fn stacks_of_any_circles_are_closed() {
    for seed in 0..40_u32 {
        let random = |k: u32| f64::from((seed * 7919 + k * 104_729) % 1009) / 1009.0;
        let mut z = 0.0;
        let slices: Vec<crankshaft::Slice> = (0..4)
            .map(|k| {
                let off = if k % 2 == 0 { 0.0 } else { 2e-3 * random(k) };
                let from = z;
                z += 5e-3 + 5e-3 * random(k + 20);
                // Every fourth one nearly touches its neighbour from inside.
                let radius = if seed % 4 == 0 && k % 2 == 1 {
                    8e-3 - off - 2e-6
                } else {
                    7e-3 + 2e-3 * random(k + 10)
                };
                let radius = if seed % 4 == 0 && k % 2 == 0 { 8e-3 } else { radius };
                // Every third stack is a crankshaft: the shaft intersects the same eccentric below and above.
                let shaft = seed % 3 == 0 && k % 2 == 0;
                let radius = if shaft && seed % 4 != 0 { 8.5e-3 } else { radius };
                crankshaft::Slice { centre: off * unit(TAU * random(k + 30)), radius, from, to: z }
            })
            .collect();
        let mesh = Mesh::stack(&slices, 2e-6).unwrap_or_else(|| panic!("{seed}"));
        assert_closed(&mesh);
        let exact = crankshaft::figures("", &slices);
        let off = mesh.volume() - exact.volume;
        assert!(off < 0.0 && -off < 2e-6 * exact.surface, "{seed}: {off:e}");
    }
}

#[test]
fn stl_and_3mf_hold_the_same_triangles() {
    let export = export(ProfileOptions { tolerance: 1e-5, ..ProfileOptions::default() });
    let parts = Parts::Assembly { crank_angle: 0.4 };
    let bodies = export.bodies(parts).unwrap();
    let count: usize = bodies.iter().map(|body| body.copies.len() * body.mesh.triangles.len()).sum();
    let stl = export.stl(parts).unwrap();
    assert_eq!(stl, export.stl(parts).unwrap());
    assert_eq!(stl.len(), 84 + 50 * count);
    assert!(!stl.starts_with(b"solid"));
    let files = export.three_mf(parts).unwrap();
    let model = String::from_utf8(files[2].1.clone()).unwrap();
    let triangles: usize = bodies.iter().map(|body| body.mesh.triangles.len()).sum();
    assert_eq!(model.matches("<triangle ").count(), triangles);
    assert_eq!(model.matches("<item ").count(), bodies.iter().map(|body| body.copies.len()).sum::<usize>());
    assert!(model.contains("unit=\"millimeter\"") && model.contains("chords stay within 10 um"));
}

/// A drawing for cutting has one contour and the openings of its disc, and nothing else.
#[test]
fn one_contour_for_a_cutter() {
    let lines = |text: &str, kind: &str| text.lines().filter(|line| *line == kind).count();
    let (machine, _) = with_windows();
    let windows = machine.disc.windows.len();
    for (contour, polylines, splines) in [(Contour::Polyline, 1, 0), (Contour::Spline, 0, 1)] {
        let text = export(ProfileOptions { disc: Some(1), ..ProfileOptions::default() }).dxf(contour);
        assert_eq!(lines(&text, "LWPOLYLINE"), polylines + windows);
        assert_eq!(lines(&text, "SPLINE"), splines);
        assert_eq!(lines(&text, "CIRCLE"), machine.crankshafts.count + 1);
        assert!(lines(&text, "TEXT") == 0 && lines(&text, "LINE") == 0 && !text.contains("PIN_RING"));
        assert!(text.contains("DISC_2_BORES") && !text.contains("DISC_1"));
    }
    let both = export(ProfileOptions::default()).dxf(Contour::Both);
    assert_eq!(lines(&both, "LWPOLYLINE"), 1 + machine.disc_count * windows);
    let (machine, stamp) = with_windows();
    let error =
        ProfileExport::new(&machine, stamp, ProfileOptions { disc: Some(2), ..ProfileOptions::default() });
    assert_eq!(error.unwrap_err(), ExchangeError::NoDisc { disc: 3, count: 2 });
}

/// The parts of a spline are the same curve: their ends are points of it, and their lengths add up to its
/// length.
#[test]
fn parts_of_a_flank_are_the_same_curve() {
    let export = export(ProfileOptions::default());
    for flank in &export.flanks {
        let length = |spline: &CubicSpline| spline.knots[spline.knots.len() - 1].0;
        let parts: f64 = flank.parts.iter().map(length).sum();
        assert!((parts - length(&flank.spline)).abs() < 1e-15);
        assert!(flank.parts.iter().all(|part| part.knots.len() <= 7));
        for pair in flank.parts.windows(2) {
            assert_eq!(pair[0].control[pair[0].control.len() - 1], pair[1].control[0]);
        }
        // Control points of the whole are those of the parts except near the cuts.
        let kept =
            |p: &Vec2| flank.parts.iter().flat_map(|part| &part.control).any(|q| (p - q).norm() < 1e-15);
        let count = flank.spline.control.iter().filter(|p| kept(p)).count();
        assert!(count + 2 * flank.parts.len() >= flank.spline.control.len());
    }
}

/// Area of a window's polygon compared with the closed form.
#[test]
fn corners_of_a_window() {
    let window = Sector {
        inner_radius: 0.02,
        outer_radius: 0.03,
        centre_angle: 0.3,
        half_angle: 0.4,
        corner_radius: 0.002,
    };
    let outline: Curve = window.outline();
    let polygon = super::mesh::corners(&outline, 1e-6);
    let area: f64 = (0..polygon.len())
        .map(|i| 0.5 * crate::geometry::cross(polygon[i], polygon[(i + 1) % polygon.len()]))
        .sum();
    let length: f64 = outline.segments.iter().map(|segment| segment.length()).sum();
    assert!((area - outline.area()).abs() < 1e-6 * length && area > 0.0);
    assert!(PI * 0.03 * 0.03 > area);
}
