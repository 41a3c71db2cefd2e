use super::*;
use crate::design::Design;
use crate::geometry::{Relief, Vec2, cross, turned, unit};
use crate::machine::Machine;

fn shipped(name: &str) -> Design {
    let template = crate::templates::TEMPLATES.iter().find(|t| t.name == name).unwrap();
    Design::parse(template.text, name).unwrap()
}

pub(super) fn machine() -> (Machine, Stamp) {
    let design = shipped("tao2024");
    (design.machine(), Stamp::of(&design))
}

/// Wear that differs between the two flanks of a tooth space.
pub(super) fn wear() -> Relief {
    Relief::from_samples(
        Relief::grid(180).map(|phi| 1e-5 * (1.0 + phi.sin() + 0.3 * (3.0 * phi).cos())).collect(),
    )
}

fn export(options: ProfileOptions) -> ProfileExport {
    let (machine, stamp) = machine();
    ProfileExport::new(&machine, stamp, options).unwrap()
}

#[test]
fn derivatives_of_the_outline_agree_with_differences() {
    let (machine, _) = machine();
    for (relief, offset) in [(Relief::uniform(0.0), 0.0), (wear(), 0.0), (wear(), 1e-4), (wear(), -2e-4)] {
        let outline = Outline::new(machine.profile(), relief, offset).unwrap();
        for i in 0..300 {
            let tau = 0.0123 + 0.001 * f64::from(i);
            let h = 2e-6;
            let (a, p, b) = (outline.at(tau - h), outline.at(tau), outline.at(tau + h));
            let first = (b.place - a.place) / (2.0 * h);
            assert!((first - p.speed * p.tangent).norm() < 1e-6 * p.speed, "{offset} {tau}");
            let turn = cross(a.tangent, b.tangent) / (2.0 * h * p.speed);
            assert!((turn - p.curvature).abs() < 1e-4 * (p.curvature.abs() + 10.0), "{offset} {tau}");
        }
        assert!(
            (outline.length(0.1, 0.4) - {
                let n = 200_000;
                let places: Vec<Vec2> =
                    (0..=n).map(|i| outline.at(0.1 + 0.3 * f64::from(i) / f64::from(n)).place).collect();
                places.windows(2).map(|w| (w[1] - w[0]).norm()).sum::<f64>()
            })
            .abs()
                < 1e-9
        );
    }
}

/// Without relief and offset the outline is the flank; a uniform relief is an inward offset.
#[test]
fn outline_is_the_flank() {
    let (machine, _) = machine();
    let profile = machine.profile();
    let bare = Outline::new(profile.clone(), Relief::uniform(0.0), 0.0).unwrap();
    let worn = Outline::new(profile.clone(), Relief::uniform(3e-5), 0.0).unwrap();
    let moved = Outline::new(profile.clone(), Relief::uniform(0.0), -3e-5).unwrap();
    for i in 0..200 {
        let tau = 0.031 * f64::from(i);
        let p = bare.at(tau);
        assert!((p.place - profile.flank_point(tau)).norm() < 1e-15);
        assert!((p.outward_normal() - profile.outward_normal(tau)).norm() < 1e-12);
        assert!((p.curvature + profile.flank_curvature(profile.meshing_angle(tau).cos())).abs() < 1e-6);
        assert!((worn.at(tau).place - moved.at(tau).place).norm() < 1e-15);
    }
}

/// The centre of a wire with the pin's radius follows the trace, whose root is nearly a cusp; a thicker wire
/// undercuts there. For inward offsets the sharpest convex point is decisive.
#[test]
fn undercutting_offsets_are_refused() {
    let (machine, _) = machine();
    let profile = machine.profile();
    let offset = |d: f64| Outline::new(profile.clone(), Relief::uniform(0.0), d);
    assert!(offset(2.9e-3).is_ok());
    let error = offset(3.2e-3).unwrap_err();
    assert!(
        matches!(error, ExchangeError::Undercut { meshing_angle, .. } if meshing_angle.abs() < 0.2),
        "{error}"
    );
    let (trace, _) = profile.sharpest_convex_trace();
    let sharpest = trace - profile.pin_radius;
    assert!(offset(-0.99 * sharpest).is_ok() && offset(-1.01 * sharpest).is_err());
}

/// The stated bounds are valid on a much denser sampling than that by which they were computed, and are not
/// excessive.
#[test]
fn deviations_are_bounded() {
    for (flank, offset, tolerance) in [
        (Flank::Modified, 0.0, 1e-6),
        (Flank::Worn(wear()), 1.5e-4, 1e-6),
        (Flank::Worn(wear()), 0.0, 5e-8),
        (Flank::AsCut, -1e-4, 2e-5),
    ] {
        let export = export(ProfileOptions { flank, offset, tolerance, disc: None });
        let outline = export.outline();
        let table = outline.table();
        let mut worst = 0.0_f64;
        let corners: Vec<Vec2> = export.corners.iter().map(|tau| outline.at(*tau).place).collect();
        for pair in corners.windows(2) {
            for i in 0..40 {
                let place = pair[0] + (pair[1] - pair[0]) * (f64::from(i) / 40.0);
                worst = worst.max(outline.distance(place, &table).0.abs());
            }
        }
        assert!(
            worst <= export.polyline_deviation() && export.polyline_deviation() <= tolerance,
            "{worst:e}"
        );
        assert!(worst > 0.5 * tolerance, "chords are idle: {worst:e}");
        let mut worst = 0.0_f64;
        for flank in &export.flanks {
            let (knots, control) = (flank.spline.flat_knots(), &flank.spline.control);
            let end = knots[knots.len() - 1];
            for i in 0..=4000 {
                let place = de_boor(&knots, control, end * f64::from(i) / 4000.0);
                worst = worst.max(outline.distance(place, &table).0.abs());
            }
        }
        assert!(worst <= export.spline_deviation() && export.spline_deviation() <= tolerance, "{worst:e}");
    }
}

/// De Boor's algorithm, by which readers evaluate a spline.
fn de_boor(knots: &[f64], control: &[Vec2], t: f64) -> Vec2 {
    let last = control.len() - 1;
    let cell = knots.partition_point(|k| *k <= t).saturating_sub(1).clamp(3, last);
    let mut d: Vec<Vec2> = (0..4).map(|j| control[cell + j - 3]).collect();
    for r in 1..4 {
        for j in (r..4).rev() {
            let (low, high) = (knots[j + cell - 3], knots[j + 1 + cell - r]);
            let a = (t - low) / (high - low);
            d[j] = (1.0 - a) * d[j - 1] + a * d[j];
        }
    }
    d[3]
}

#[test]
fn closed_spline_closes_smoothly() {
    let export = export(ProfileOptions::default());
    let spline = export.closed_spline();
    let knots = spline.flat_knots();
    assert_eq!(knots.len(), spline.control.len() + 4);
    assert!((spline.control[0] - spline.control[spline.control.len() - 1]).norm() < 1e-15);
    let (outline, table) = (export.outline(), export.outline().table());
    let end = knots[knots.len() - 1];
    assert!((end - outline.area_and_length().1).abs() < 1e-9 * end);
    for i in 0..5000 {
        let place = de_boor(&knots, &spline.control, end * f64::from(i) / 5000.0);
        assert!(outline.distance(place, &table).0.abs() < 1e-6);
    }
}

/// Area and length from the polyline, whose own errors are of the order of the deviation.
#[test]
fn area_of_the_outline() {
    let export = export(ProfileOptions { tolerance: 2e-8, ..ProfileOptions::default() });
    let corners = export.polyline();
    let next = |i: usize| corners[(i + 1) % corners.len()];
    let area: f64 = (0..corners.len()).map(|i| 0.5 * cross(corners[i], next(i))).sum();
    let length: f64 = (0..corners.len()).map(|i| (next(i) - corners[i]).norm()).sum();
    let (exact, around) = export.outline().area_and_length();
    assert!((area / exact - 1.0).abs() < 1e-6 && (length / around - 1.0).abs() < 1e-5);
}

#[test]
fn distance_finds_the_foot() {
    let (machine, _) = machine();
    let outline = Outline::new(machine.profile(), wear(), 0.0).unwrap();
    let table = outline.table();
    for i in 0..500 {
        let tau = 0.0126 * f64::from(i);
        let p = outline.at(tau);
        let gap = 2e-4 * (f64::from(i) * 0.7).sin();
        let (found, foot) = outline.distance(p.place + gap * p.outward_normal(), &table);
        assert!((found - gap).abs() < 1e-12, "{i}: {found:e} {gap:e}");
        assert!(crate::units::wrap_angle(foot - tau).abs() < 1e-8);
    }
}

#[test]
fn files_are_stamped_and_repeat_to_the_byte() {
    let make = || export(ProfileOptions { flank: Flank::Worn(wear()), ..ProfileOptions::default() });
    let (a, b) = (make(), make());
    let assembly = Parts::Assembly { crank_angle: 0.3 };
    let files = |e: &ProfileExport| [e.dxf(Contour::Both), e.step(assembly).unwrap(), e.csv(), e.svg()];
    assert_eq!(files(&a), files(&b));
    for file in files(&a) {
        for word in
            [env!("CARGO_PKG_VERSION"), &a.stamp.design_hash, "largest deviation from the exact flank"]
        {
            assert!(file.contains(word));
        }
        assert!(!file.contains("NaN") && !file.contains("inf"));
    }
    assert_eq!(a.step(assembly).unwrap().matches("=PRODUCT(").count(), 5);
    assert_eq!(a.csv().lines().filter(|line| !line.starts_with('#')).count(), a.polyline().len() + 1);
}

#[test]
fn options_out_of_range() {
    let (machine, stamp) = machine();
    for options in [
        ProfileOptions { tolerance: 0.0, ..ProfileOptions::default() },
        ProfileOptions { tolerance: f64::NAN, ..ProfileOptions::default() },
        ProfileOptions { offset: f64::INFINITY, ..ProfileOptions::default() },
        ProfileOptions { offset: 5e-3, ..ProfileOptions::default() },
    ] {
        assert!(!ProfileExport::new(&machine, stamp.clone(), options).unwrap_err().remedy().is_empty());
    }
}

/// Bores have the positions of the finite element model in the flank's frame.
#[test]
fn holes_of_each_disc() {
    let export = export(ProfileOptions::default());
    let first = export.openings(0).bores;
    let second = export.openings(1).bores;
    let pitch = std::f64::consts::PI / 39.0;
    assert!((first[0].centre - 40.5e-3 * unit(std::f64::consts::FRAC_PI_2)).norm() < 1e-12);
    let turn = unit(pitch);
    let turned = crate::geometry::turned(first[0].centre, turn);
    let other = crate::geometry::turned(first[0].centre, Vec2::new(turn.x, -turn.y));
    assert!((second[0].centre - turned).norm().min((second[0].centre - other).norm()) < 1e-12);
}

/// The discs of a single stage: the bore in the centre, and the holes of a disc on an eccentric with the phase
/// p rotated by p/z_c relative to its lobes; area by Green's theorem less the round openings.
#[test]
fn discs_of_a_single_stage_differ_by_their_holes() {
    let template = crate::templates::NEMA17_19;
    let design = crate::design::StageDesign::parse(template.text, template.name).unwrap();
    let export = ProfileExport::of_stage(&design, ProfileOptions::default()).unwrap();
    let [first, second] = [0, 1].map(|disc| export.openings(disc));
    assert_eq!((first.bores.len(), first.holes.len()), (1, 6));
    assert!(first.bores[0].centre.norm() == 0.0 && (first.bores[0].radius - 6.5e-3).abs() < 1e-12);
    for (one, other) in first.holes.iter().zip(&second.holes) {
        assert!((one.radius - 2.51e-3).abs() < 1e-12 && (one.centre.norm() - 10.5e-3).abs() < 1e-12);
        let turn = cross(one.centre, other.centre).atan2(one.centre.dot(&other.centre));
        assert!((turn - std::f64::consts::PI / 19.0).abs() < 1e-12, "{turn}");
    }
    let corners = export.polyline();
    let polygon: f64 =
        (0..corners.len()).map(|i| 0.5 * cross(corners[i], corners[(i + 1) % corners.len()])).sum();
    let open = std::f64::consts::PI * (6.5e-3_f64.powi(2) + 6.0 * 2.51e-3_f64.powi(2));
    let (area, _) = export.disc_area_and_length();
    assert!((area / (polygon - open) - 1.0).abs() < 1e-3, "{area} {polygon}");
    assert_eq!(export.step(Parts::Discs).unwrap().matches("=PRODUCT(").count(), 2);
    assert!(export.stl(Parts::Discs).is_ok() && export.dxf(Contour::Both).contains("DISC_2_HOLES"));
    assert!(matches!(export.step(Parts::Crankshaft), Err(ExchangeError::NoPart(_))));
    assert!(matches!(export.stl(Parts::Ring), Err(ExchangeError::NoPart(_))));
}

/// A ring of one piece is one closed part in every format: the volume of the triangles is that of the exact
/// contour and of the solid, drawings contain its contour instead of pins, and an export of pins is refused.
#[test]
fn a_ring_of_one_piece_is_one_part() {
    let template = crate::templates::NEMA17_19;
    let text = template.text.replacen("[ring]", "[ring]\npin_mounting = \"one-piece\"", 1);
    let text = text.replacen("\npin_mounting = \"fixed\"", "", 1);
    let design = crate::design::StageDesign::parse(&text, template.name).unwrap();
    let export = ProfileExport::of_stage(&design, ProfileOptions::default()).unwrap();
    let bodies = export.bodies(Parts::Ring).unwrap();
    assert_eq!((bodies.len(), bodies[0].copies.len()), (1, 1));
    let figures = export.solid_figures();
    let ring = figures.iter().find(|figures| figures.name == "ring").unwrap();
    let mesh = &bodies[0].mesh;
    let at = |index: usize| nalgebra::Vector3::from(mesh.vertices[index]);
    let volume: f64 = mesh.triangles.iter().map(|[a, b, c]| at(*a).cross(&at(*b)).dot(&at(*c)) / 6.0).sum();
    assert!((volume / ring.volume - 1.0).abs() < 2e-4, "{volume} {}", ring.volume);
    // Every edge of the triangles belongs to two of them.
    let mut edges = std::collections::HashMap::new();
    for triangle in &mesh.triangles {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
        }
    }
    assert!(edges.values().all(|count| *count == 2));
    assert_eq!(export.step(Parts::Ring).unwrap().matches("=PRODUCT(").count(), 1);
    assert!(export.stl(Parts::Ring).is_ok());
    let (dxf, svg) = (export.dxf(Contour::Both), export.svg());
    assert!(dxf.contains("\nRING\n") && !dxf.contains("PIN_RING"));
    assert!(svg.contains("id=\"RING\"") && !svg.contains("PIN_RING"));
    assert!(matches!(export.stl(Parts::Pin), Err(ExchangeError::NoPart(_))));
    assert!(matches!(export.step(Parts::Pin), Err(ExchangeError::NoPart(_))));
}

/// A disc with tips: its edge is closed and has corners at the ends of flanks, polyline and splines are within
/// their tolerances, areas agree, a relief that differs between flanks is joined by the lands, and a tool path
/// is refused.
#[test]
fn edges_with_tips_have_their_corners() {
    let profile = crate::geometry::Profile::new(22, 40e-3, 2.2e-3, 2.5e-3).with_teeth(2, None).unwrap();
    let one_sided = Relief::from_samples(Relief::grid(360).map(|phi| 2e-5 * (1.0 + phi.sin())).collect());
    for relief in [Relief::uniform(0.0), Relief::uniform(2e-5), one_sided] {
        let outline = Outline::new(profile.clone(), relief.clone(), 0.0).unwrap();
        let breaks = outline.breaks();
        assert_eq!(breaks.len(), 5);
        let (mut polygon, mut splines) = (0.0, 0.0);
        let mut last: Option<Vec2> = None;
        for pair in breaks.windows(2) {
            let course = outline.between(pair[0], pair[1]);
            let (chords, deviation) = course.chords(pair[0], pair[1], 1e-7);
            assert!(deviation < 1.01e-7);
            let places: Vec<Vec2> = chords.iter().map(|tau| course.at(*tau).place).collect();
            assert!(last.is_none_or(|last| (last - places[0]).norm() < 1e-12), "a gap at {pair:?}");
            last = places.last().copied();
            polygon += places.windows(2).map(|p| 0.5 * crate::geometry::cross(p[0], p[1])).sum::<f64>();
            let fitted = super::spline::FittedSpline::along(&course, pair[0], pair[1], 1e-8);
            assert!(fitted.deviation < 1e-8);
            splines += fitted.spline.control.len() as f64;
            for i in 0..=20 {
                let tau = pair[0] + (pair[1] - pair[0]) * f64::from(i) / 20.0;
                let h = 1e-6;
                let (a, p, b) = (course.at(tau - h), course.at(tau), course.at(tau + h));
                assert!(((b.place - a.place) / (2.0 * h) - p.speed * p.tangent).norm() < 1e-5 * p.speed);
                let turn = crate::geometry::cross(a.tangent, b.tangent) / (2.0 * h * p.speed);
                assert!((turn - p.curvature).abs() < 1e-3 * (p.curvature.abs() + 10.0));
            }
        }
        let end = last.unwrap();
        assert!((turned(outline.at(0.0).place, unit(outline.lobe_pitch())) - end).norm() < 1e-12);
        let (area, length) = outline.area_and_length();
        let lobes = outline.lobe_count() as f64;
        assert!((area / (polygon * lobes) - 1.0).abs() < 1e-6 && length > 0.0 && splines > 8.0, "{area}");
        // Points on flanks and lands are found by their positions.
        let table = outline.table();
        for i in 0..300 {
            let p = outline.at(0.021 * f64::from(i));
            let (off, tau) = outline.distance(p.place + 1e-5 * p.outward_normal(), &table);
            assert!((off - 1e-5).abs() < 1e-9, "{i} {off}");
            assert!((outline.at(tau).place - p.place).norm() < 2e-5);
        }
    }
    assert!(matches!(
        Outline::new(profile, Relief::uniform(0.0), 1e-4),
        Err(crate::exchange::ExchangeError::OffsetOfTips)
    ));
}
