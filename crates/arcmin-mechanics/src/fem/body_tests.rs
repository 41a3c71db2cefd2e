//! Extruded bodies compared with closed forms and with differently meshed parts of the same body.

use std::f64::consts::{FRAC_PI_2, PI};

use super::body::{Body, NodalLoad, Seat, Traction};
use super::symmetry::{Class, Mirrors, Symmetric};
use super::verification::{circle, steel};
use super::*;
use crate::geometry::{Sector, Vec2};
use crate::machine::HousingSolid;
use crate::templates::tao2024;

/// A ring between radii a and b, held at three corners of its lower face against rigid motions only.
fn ring(a: f64, b: f64, width: f64, size: f64) -> (Body, Seat, Seat) {
    let domain = PlaneDomain {
        boundaries: vec![(circle(0.0, 0.0, b), size, 0), (circle(0.0, 0.0, a), size, 0)],
        interior_size: size,
    };
    let (plane, regions) = PlaneMesh::triangulate_regions(&domain, |bits| bits == 1).unwrap();
    let mesh = Mesh::layered(plane, &[0.0, width], |_, _| true);
    let near = |p: Vec2| {
        let distance = |n: &usize| (mesh.plane.nodes[*n] - p).norm();
        (0..mesh.plane.corner_count).min_by(|m, n| distance(m).total_cmp(&distance(n))).unwrap()
    };
    let mut held = vec![[false; 3]; mesh.nodes.len()];
    held[near(Vec2::new(b, 0.0))] = [false, true, true];
    held[near(Vec2::new(-b, 0.0))] = [false, true, true];
    held[near(Vec2::new(0.0, b))] = [true, false, true];
    let body = Body::new(mesh, regions, steel(), &held).unwrap();
    (body, Seat::around(0, 0..1, Vec2::zeros(), b), Seat::around(1, 0..1, Vec2::zeros(), a))
}

/// Lamé: mean radial displacement of a thick ring under the pressure p = F/(2π a w) on its bore; the energy of
/// elements of second order has an error of the fourth power of their size.
#[test]
fn val_thick_ring_expands_by_lames_formula() {
    let (a, b, w) = (10e-3, 25e-3, 6e-3);
    let (e, nu) = (steel().youngs_modulus, steel().poisson_ratio);
    let error = |size: f64| {
        let (body, _, bore) = ring(a, b, w, size);
        let load = body.load(&bore, Traction::Expansion);
        let found = body.compliance(&[load]).at(0, 0);
        let p = 1.0 / (2.0 * PI * a * w);
        let exact = p * a / e * ((b * b + a * a) / (b * b - a * a) + nu);
        found / exact - 1.0
    };
    let (coarse, fine) = (error(5e-3), error(2.5e-3));
    assert!(fine.abs() < 1e-3 && (coarse / fine).abs() > 7.0, "{coarse:e} {fine:e}");
}

/// Two opposite forces on a thin ring, as the sum of even orders of radial load: each order deforms it by F
/// R³/(π E I (n² − 1)²) per unit of its coordinate (Timoshenko, ring without extension), their sum changes the
/// diameter by 0.1488 F R³/(E I).
#[test]
fn val_ring_under_opposite_forces() {
    let (r, h, w) = (50e-3, 1.5e-3, 4e-3);
    let (body, outside, _) = ring(r - 0.5 * h, r + 0.5 * h, w, 2.5e-3);
    let inertia = w * h * h * h / 12.0;
    let unit = r.powi(3) / (PI * steel().youngs_modulus * inertia);
    let orders = [2usize, 4, 6];
    let loads: Vec<NodalLoad> =
        orders.iter().map(|n| body.load(&outside, Traction::Radial { order: *n, from: 0.0 })).collect();
    let c = body.compliance(&loads);
    for (k, n) in orders.iter().enumerate() {
        let expected = unit / ((n * n - 1) as f64).powi(2);
        // Shear and extension add n² h²/(4 R²); with the outer instead of the middle radius the result is 3
        // h/2R smaller.
        assert!((c.at(k, k) / expected - 1.0).abs() < 0.06, "{n}: {} {expected}", c.at(k, k) / expected);
        for other in 0..k {
            assert!(c.at(k, other).abs() < 1e-3 * (c.at(k, k) * c.at(other, other)).sqrt());
        }
    }
    // Sum over all orders: Σ 4/(π (n² − 1)²) over even n is 0.1488.
    let series: f64 = (1..400).map(|m| 4.0 / PI / ((4 * m * m - 1) as f64).powi(2)).sum();
    assert!((series - 0.1488).abs() < 1e-4, "{series}");
}

/// A torque from the bore to the outer edge of an annular plate: θ = T/(4π G t) (1/a² − 1/b²) in pure shear.
#[test]
fn val_annular_plate_twists_in_shear() {
    let (a, b, w) = (10e-3, 25e-3, 4e-3);
    let (body, outside, bore) = ring(a, b, w, 2.5e-3);
    let c = body.compliance(&[body.load(&bore, Traction::Twist), body.load(&outside, Traction::Twist)]);
    let g = steel().youngs_modulus / (2.0 * (1.0 + steel().poisson_ratio));
    let expected = (1.0 / (a * a) - 1.0 / (b * b)) / (4.0 * PI * g * w);
    // The two torques balance, so that the held nodes have no reaction.
    let found = c.at(0, 0) - 2.0 * c.at(0, 1) + c.at(1, 1);
    assert!((found / expected - 1.0).abs() < 2e-3, "{}", found / expected);
}

/// A plate clamped on the middle of one face: elements with displaced mid-side nodes at the edge of the clamp
/// have the same geometry, and their result is closer to the extrapolation of meshes of plain elements, whose
/// error is of first order.
#[test]
fn val_edges_drawn_towards_the_rim_of_a_clamp() {
    let (radius, thickness) = (20e-3, 8e-3);
    let frequency = |size: f64, layers: usize, drawn: bool| {
        let domain = PlaneDomain {
            boundaries: vec![(circle(0.0, 0.0, radius), size, 0), (circle(0.0, 0.0, 0.5 * radius), size, 0)],
            interior_size: size,
        };
        let (plane, regions) = PlaneMesh::triangulate_regions(&domain, |bits| bits & 1 == 1).unwrap();
        let cuts: Vec<f64> = (0..=layers).map(|k| thickness * k as f64 / layers as f64).collect();
        let mesh = Mesh::layered(plane, &cuts, |_, _| true);
        let mut sharp = vec![false; mesh.nodes.len()];
        mesh.plane.nodes_of(1).into_iter().for_each(|node| sharp[node] = true);
        let mesh = if drawn { mesh.drawn_towards(&sharp) } else { mesh };
        let mut held = vec![[false; 3]; mesh.nodes.len()];
        for (triangle, bits) in mesh.plane.triangles.iter().zip(&regions) {
            if bits >> 1 == 1 {
                triangle.iter().for_each(|node| held[*node] = [true; 3]);
            }
        }
        let body = Body::new(mesh, regions, steel(), &held).unwrap();
        let expected = PI * radius * radius * thickness * steel().density;
        assert!(
            (body.mesh.mass(steel().density) / expected - 1.0).abs() < 2e-4,
            "{}",
            body.mesh.mass(steel().density) / expected
        );
        body.frequencies(1).unwrap()[0]
    };
    let (coarse, fine) = (frequency(4e-3, 2, false), frequency(2e-3, 4, false));
    let exact = 2.0 * fine - coarse;
    let drawn = frequency(4e-3, 2, true);
    assert!(coarse > 1.005 * exact, "{coarse} {exact}");
    assert!((drawn / exact - 1.0).abs() < 0.4 * (coarse / exact - 1.0), "{coarse} {fine} {drawn} {exact}");
}

fn coarse_carrier() -> CarrierShape {
    let shape = CarrierShape::of(&tao2024());
    CarrierShape { size: 2.0 * shape.size, layers: [1, 2], ..shape }
}

/// The body without planes of symmetry.
fn whole_of(shape: &impl Symmetric) -> Body {
    let mut bodies = shape.of_classes(Mirrors::None, |class| class.body).unwrap();
    bodies.pop().unwrap()
}

/// Constant strain in plate, pillars and plate: forces only at surfaces and held nodes.
#[test]
fn layers_pass_the_patch_test() {
    let body = whole_of(&coarse_carrier());
    let mesh = &body.mesh;
    let mut faces: std::collections::HashMap<[usize; 3], (usize, [usize; 6])> = Default::default();
    for tet in mesh.elements() {
        for (corners, middles) in
            [([0, 1, 2], [4, 5, 6]), ([0, 1, 3], [4, 8, 7]), ([1, 2, 3], [5, 9, 8]), ([0, 2, 3], [6, 9, 7])]
        {
            let mut key = corners.map(|i| tet[i]);
            key.sort_unstable();
            let [a, b, c] = corners.map(|i| tet[i]);
            let [d, e, f] = middles.map(|i: usize| tet[i]);
            faces.entry(key).or_insert((0, [a, b, c, d, e, f])).0 += 1;
        }
    }
    assert!(faces.values().all(|(count, _)| *count <= 2), "elements overlap");
    let mut surface = vec![false; mesh.nodes.len()];
    faces
        .values()
        .filter(|(count, _)| *count == 1)
        .for_each(|(_, f)| f.iter().for_each(|n| surface[*n] = true));
    let field = |p: [f64; 3]| {
        let [x, y, z] = p;
        [1e-4 * x + 3e-5 * y - 2e-5 * z, -4e-5 * x + 7e-5 * y + 1e-5 * z, 2e-5 * x - 6e-5 * y + 5e-5 * z]
    };
    // The held face has no unknowns, so its nodes are excluded.
    let top = mesh.levels[mesh.levels.len() - 3];
    let (map, force) = body.inner_forces(field);
    let largest = force.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
    let mut inner = 0;
    for node in (0..mesh.nodes.len()).filter(|n| !surface[*n] && mesh.nodes[*n][2] < top - 1e-9) {
        for component in 0..3 {
            let [(dof, _), _] = map.terms(node, component);
            if dof != super::assembly::HELD {
                inner += 1;
                assert!(force[dof].abs() < 1e-10 * largest, "node {node}: {:e} of {largest:e}", force[dof]);
            }
        }
    }
    assert!(inner > 100, "{inner}");
}

/// Mass of the part that remains between the mirrors.
fn mass_of(shape: &impl Symmetric, mirrors: Mirrors) -> f64 {
    let parts = 1_usize << mirrors.components().len();
    parts as f64 * shape.mesh_part(mirrors).unwrap().mesh.mass(shape.material().density)
}

/// The lowest ten frequencies of a body, from all its classes of symmetry.
fn frequencies_of(shape: &impl Symmetric) -> Vec<f64> {
    let of_class = |class: Class| class.body.frequencies(10).unwrap();
    let mut all = shape.of_classes(shape.mirrors(), of_class).unwrap().concat();
    all.sort_by(f64::total_cmp);
    all.truncate(10);
    all
}

#[test]
fn masses_of_carrier_and_housing_follow_from_their_outlines() {
    let shape = CarrierShape::of(&tao2024());
    let s = &shape.solid;
    let disc = |r: f64| PI * r * r;
    let plate = disc(s.plate_radius)
        - disc(s.centre_bore_radius)
        - shape.cranks.len() as f64 * disc(s.crank_seat_radius);
    let pillars: f64 = s.pillars.iter().map(|p| p.outline().area()).sum();
    let expected = shape.material.density * (2.0 * s.plate_thickness * plate + s.gap * pillars);
    let mass = mass_of(&shape, shape.mirrors());
    assert!((mass / expected - 1.0).abs() < 2e-4, "{mass} {expected}");
    let small = small_housing();
    let mass = mass_of(&small, small.mirrors());
    let expected = small.volume() * small.solid.material.density;
    assert!((mass / expected - 1.0).abs() < 1e-3, "{mass} {expected}");
}

/// The compliance is reciprocal, equal for the two crankshafts of a symmetric carrier, and nearly independent
/// of the mesh.
#[test]
#[ignore = "long"]
fn compliance_of_the_carrier_is_reciprocal_and_symmetric() {
    let shape = coarse_carrier();
    let body = whole_of(&shape);
    let loads = shape.loads(&body);
    let all: Vec<usize> = (0..loads.len()).collect();
    let rows = body.rows(&loads, &all);
    for (i, j) in all.iter().flat_map(|i| all.iter().map(move |j| (*i, *j))) {
        let scale = (rows[i][i] * rows[j][j]).sqrt();
        assert!((rows[i][j] - rows[j][i]).abs() < 1e-10 * scale, "{i} {j}");
    }
    let c = body.compliance(&loads);
    // Symmetric parts give the same compliance as the whole carrier: two crankshafts on the y axis, and three
    // with the first on it.
    let three = {
        let mut drawn = (1..).map(|seed| crate::random_designs::sound_design(seed).0.machine());
        let machine = drawn.find(|machine| machine.crankshafts.count == 3).unwrap();
        let shape = CarrierShape::of(&machine);
        CarrierShape { size: 1.2 * shape.size, layers: [2, 2], ..shape }
    };
    let two = CarrierShape { size: 0.6 * shape.size, layers: [2, 2], ..shape.clone() };
    assert_eq!([shape.mirrors(), three.mirrors()], [Mirrors::Both, Mirrors::X]);
    for (shape, parts) in [(&two, vec![Mirrors::X, Mirrors::Y, Mirrors::Both]), (&three, vec![Mirrors::X])] {
        let whole = shape.compliance_of(Mirrors::None).unwrap();
        for part in parts {
            let c = shape.compliance_of(part).unwrap();
            for (i, j) in (0..c.count).flat_map(|i| (0..c.count).map(move |j| (i, j))) {
                let scale = (whole.at(i, i) * whole.at(j, j)).sqrt();
                let apart = (whole.at(i, j) - c.at(i, j)).abs() / scale;
                assert!(apart < 0.02, "{} crankshafts, {part:?}, {i} {j}: {apart}", shape.cranks.len());
            }
        }
    }
    for end in 0..2 {
        let (first, second) = (shape.seat(0, end), shape.seat(1, end));
        for k in 0..2 {
            let (a, b) = (c.at(first + k, first + k), c.at(second + k, second + k));
            assert!((a / b - 1.0).abs() < 0.02, "end {end}, {k}: {a:e} {b:e}");
        }
    }
    // The far end is softer, because the output face is held.
    assert!(c.at(shape.seat(0, 0), shape.seat(0, 0)) > 2.0 * c.at(shape.seat(0, 1), shape.seat(0, 1)));
    let finer = CarrierShape { size: 0.6 * shape.size, ..shape.clone() }.compliance().unwrap();
    for k in [shape.seat(0, 0), shape.seat(0, 0) + 1, shape.seat(1, 1)] {
        assert!(
            (c.at(k, k) / finer.at(k, k) - 1.0).abs() < 0.03,
            "{k}: {:e} {:e}",
            c.at(k, k),
            finer.at(k, k)
        );
    }
}

/// For random machines the masses of the symmetric parts of carriers and housings add up to those of the whole
/// bodies.
#[test]
#[ignore = "long"]
fn masses_of_symmetric_parts_add_up_for_random_machines() {
    let mut seen = Vec::new();
    for seed in 1..=12 {
        let machine = crate::random_designs::sound_design(seed).0.machine();
        // Some have no space for pillars; elastic bodies refuse these.
        if !machine.solids.carrier.pillars.iter().all(Sector::is_sound) {
            continue;
        }
        let housing = HousingShape::of(&machine);
        let carrier = CarrierShape::of(&machine);
        let expected = housing.volume() * housing.solid.material.density;
        let mass = mass_of(&housing, housing.mirrors());
        assert!((mass / expected - 1.0).abs() < 2e-3, "seed {seed}: {mass} {expected}");
        let [parts, whole] = [carrier.mirrors(), Mirrors::None].map(|mirrors| mass_of(&carrier, mirrors));
        assert!((parts / whole - 1.0).abs() < 2e-4, "seed {seed}: {parts} {whole}");
        seen.extend([housing.mirrors(), carrier.mirrors()]);
    }
    assert!(seen.len() >= 16, "{seen:?}");
    assert!([Mirrors::Y, Mirrors::X, Mirrors::Both].iter().all(|mirrors| seen.contains(mirrors)), "{seen:?}");
}

/// Eight pins and four bolts, two discs.
fn small_housing() -> HousingShape {
    let mut shape = HousingShape::of(&tao2024());
    shape.pin_count = 8;
    shape.solid.bolt_count = 4;
    shape.sizes = [6e-3, 12e-3];
    shape
}

/// Quarter, half and whole models of a housing give the same compliance within the differences of meshes with
/// equal sectors; the reduced models use only symmetries of both pins and bolts.
#[test]
#[ignore = "long"]
fn housing_by_classes_of_symmetry_is_the_whole() {
    let shape = small_housing();
    assert_eq!((shape.symmetry(), shape.mirrors()), (4, Mirrors::Both));
    let quarters = shape.compliance().unwrap();
    assert_eq!(quarters.count, shape.main_seat(1) + 2);
    let mut bolts = [4, 3, 2].map(|count| {
        let mut shape = small_housing();
        shape.solid.bolt_count = count;
        shape
    });
    bolts[2].solid.first_bolt_angle = 0.5 * PI;
    assert_eq!(bolts.each_ref().map(Symmetric::mirrors), [Mirrors::Both, Mirrors::Y, Mirrors::Both]);
    for shape in &bolts {
        let of = |mirrors| shape.compliance_of(mirrors).unwrap();
        let whole = of(Mirrors::None);
        let all =
            if shape.mirrors() == Mirrors::Y { vec![Mirrors::Y] } else { vec![Mirrors::Y, Mirrors::Both] };
        for part in all {
            let c = of(part);
            for (i, j) in (0..whole.count).flat_map(|i| (0..whole.count).map(move |j| (i, j))) {
                let scale = (whole.at(i, i) * whole.at(j, j)).sqrt();
                let apart = (whole.at(i, j) - c.at(i, j)).abs() / scale;
                assert!(apart < 0.02, "{} bolts, {part:?}, {i} {j}: {apart}", shape.solid.bolt_count);
            }
        }
    }
    let turned = HousingShape {
        solid: HousingSolid { first_bolt_angle: 0.1, ..shape.solid.clone() },
        ..shape.clone()
    };
    assert_eq!((turned.mirrors(), turned.symmetry()), (Mirrors::None, 4));
    let whole = shape.compliance_of(Mirrors::None).unwrap();
    // A ring of seats is softer if fewer bolts hold it.
    let mut two = shape.clone();
    two.solid.bolt_count = 2;
    let mut face = shape.clone();
    face.solid.hold = crate::machine::Hold::Face;
    let pin = shape.pin(0, 1);
    let radial = |c: &Compliance| c.at(pin, pin);
    let (two, face) = (two.compliance().unwrap(), face.compliance().unwrap());
    assert!(radial(&two) > radial(&whole) && radial(&whole) > radial(&face));
}

/// The tractions of grooves and rims have unit resultants in both directions.
#[test]
fn tractions_of_grooves_and_rims_have_unit_resultants() {
    let shape = small_housing();
    let loads = shape.loads(&whole_of(&shape));
    let sum = |load: &NodalLoad, component: usize| -> f64 {
        load.iter().filter(|(_, c, _)| *c == component).map(|(_, _, f)| f).sum()
    };
    for pin in 0..shape.pin_count {
        let angle = 2.0 * PI * pin as f64 / shape.pin_count as f64;
        for (k, direction) in [angle, angle + FRAC_PI_2].into_iter().enumerate() {
            let load = &loads[shape.pin(1, pin) + k];
            let along = sum(load, 0) * direction.cos() + sum(load, 1) * direction.sin();
            let across = sum(load, 1) * direction.cos() - sum(load, 0) * direction.sin();
            assert!((along - 1.0).abs() < 0.01 && across.abs() < 0.01, "{pin} {k}: {along} {across}");
        }
    }
    for end in 0..2 {
        let load = &loads[shape.main_seat(end)];
        assert!((sum(load, 0) - 1.0).abs() < 2e-3 && sum(load, 1).abs() < 2e-3);
    }
}

/// Values of another program for the solids of the shipped design: see validation/CalculiX.
fn reference(quantity: &str) -> f64 {
    let rows = include_str!("../../../../validation/CalculiX/bodies.csv");
    let row = rows.lines().find(|row| row.split(',').next() == Some(quantity)).unwrap();
    row.split(',').nth(1).unwrap().parse().unwrap()
}

/// Difference of a value from the reference as a fraction of `scale`.
fn distance(quantity: &str, found: f64, scale: f64) -> f64 {
    let expected = reference(quantity);
    println!("{quantity}: {found:e} {expected:e} {:.3} %", 100.0 * (found - expected) / scale);
    ((found - expected) / scale).abs()
}

/// Compliance between the crank seats within 1 % (of the geometric mean of their own), and the first ten
/// frequencies within 0.5 % of the extrapolation from two meshes of the reference.
#[test]
#[ignore = "long"]
fn val_carrier_is_that_of_calculix() {
    let shape = CarrierShape::of(&tao2024());
    let c = shape.compliance_of(shape.mirrors()).unwrap();
    let names = ["x", "y"];
    let place = |name: &str| {
        let (seat, kind) = name.split_at(6);
        let digit = |k: usize| seat[k..=k].parse::<usize>().unwrap();
        let offset = ["x", "y", "expansion", "cos2", "sin2"].iter().position(|k| *k == kind).unwrap();
        shape.seat(digit(4), digit(5)) + offset
    };
    let mut all: Vec<String> =
        (0..8).map(|i| format!("seat{}{}{}", i / 4, i / 2 % 2, names[i % 2])).collect();
    all.extend(["seat00cos2".to_owned(), "seat00sin2".to_owned()]);
    let (mut apart, mut detuned) = (0.0_f64, 0.0_f64);
    for under in ["seat00x", "seat00y", "seat01x", "seat00cos2"] {
        for other in &all {
            let (i, j) = (place(under), place(other));
            let scale = (c.at(i, i) * c.at(j, j)).sqrt();
            apart = apart.max(distance(&format!("carrier_{under}_{other}"), c.at(i, j), scale));
        }
    }
    for (k, found) in frequencies_of(&shape).into_iter().enumerate() {
        detuned = detuned.max(distance(&format!("carrier_frequency_{}", k + 1), found, found));
    }
    assert!(apart < 0.01 && detuned < 0.005, "compliances {apart}, frequencies {detuned}");
}

/// Differences of the compliances of the housing, with pins loaded over their whole length and equal shares of
/// both discs, and of its first ten frequencies from reference values whose names end with `what`.
fn housing_apart(what: &str) -> [f64; 2] {
    let shape = HousingShape::of(&tao2024());
    let c = shape.compliance_of(shape.mirrors()).unwrap();
    // Half of the load acts on each disc's part of a pin.
    let mut chosen: Vec<(String, Vec<usize>)> = Vec::new();
    for i in [0, 3, 20] {
        for (name, across) in [("r", 0), ("t", 1)] {
            chosen.push((format!("pin{i}{name}"), (0..2).map(|disc| shape.pin(disc, i) + across).collect()));
        }
    }
    chosen.extend((0..2).map(|end| (format!("seat{end}x"), vec![shape.main_seat(end)])));
    let mean = |i: usize, j: usize| {
        let (i, j) = (&chosen[i].1, &chosen[j].1);
        let sum: f64 = i.iter().flat_map(|a| j.iter().map(move |b| (a, b))).map(|(a, b)| c.at(*a, *b)).sum();
        sum / (i.len() * j.len()) as f64
    };
    let (mut apart, mut detuned) = (0.0_f64, 0.0_f64);
    for (i, (under, _)) in chosen.iter().enumerate() {
        if !["pin0r", "pin3t"].contains(&under.as_str()) {
            continue;
        }
        for (j, (other, _)) in chosen.iter().enumerate() {
            let scale = (mean(i, i) * mean(j, j)).sqrt();
            apart = apart.max(distance(&format!("housing_{under}_{other}{what}"), mean(i, j), scale));
        }
    }
    for (k, found) in frequencies_of(&shape).into_iter().enumerate() {
        detuned = detuned.max(distance(&format!("housing_frequency_{}{what}", k + 1), found, found));
    }
    [apart, detuned]
}

/// Within 1 % of compliances and 0.5 % of frequencies on the finer mesh of the reference.
#[test]
#[ignore = "long"]
fn val_housing_is_that_of_calculix() {
    let [apart, detuned] = housing_apart("_on_the_finer_mesh");
    assert!(apart < 0.01 && detuned < 0.005, "compliances {apart}, frequencies {detuned}");
}

/// The same compared with the extrapolation from the two meshes of the reference.
#[test]
#[ignore = "open: compliances within 0.9 %, but up to 0.96 % of frequencies, for the mesh"]
fn manual_housing_is_the_extrapolation_of_calculix() {
    let [apart, detuned] = housing_apart("");
    assert!(apart < 0.01 && detuned < 0.005, "compliances {apart}, frequencies {detuned}");
}
