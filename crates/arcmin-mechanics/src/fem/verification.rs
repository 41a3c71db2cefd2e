//! Elements and solvers compared with closed forms.

use std::f64::consts::TAU;

use faer::Mat;

use super::assembly::{self, DofMap, SymmetricMatrix};
use super::elements::{physical_gradient_t6, shape_t6};
use super::quadrature::LINE_4;
use super::solve::{Cholesky, ModeRange, lowest_modes};
use super::{Boundary, Mesh, PlaneDomain, PlaneMesh};
use crate::geometry::{Profile, Vec2};
use crate::materials::Material;

pub(super) fn steel() -> Material {
    Material::elastic("test steel", 219e9, 0.3, 7830.0)
}

pub(super) fn circle(x: f64, y: f64, radius: f64) -> Boundary {
    Boundary::Circle { centre: Vec2::new(x, y), radius }
}

pub(super) fn paper_profile() -> Profile {
    Profile::new(40, 64e-3, 1.3e-3, 3e-3)
}

/// The RV-40E-81's disc: bores of Ø27 at 40.5 mm on the y axis, centre hole Ø40.
pub(super) fn disc_mesh(flank: f64, rows: usize, hole: f64, interior: f64) -> PlaneMesh {
    let domain = PlaneDomain {
        boundaries: vec![
            (Boundary::Flank(paper_profile()), flank, rows),
            (circle(0.0, 40.5e-3, 13.5e-3), hole, 1),
            (circle(0.0, -40.5e-3, 13.5e-3), hole, 1),
            (circle(0.0, 0.0, 20e-3), hole, 1),
        ],
        interior_size: interior,
    };
    PlaneMesh::triangulate(&domain).unwrap()
}

/// Solves K u = f with the displacement prescribed where `given` says so; returns all unknowns.
fn solve_with_given(stiffness: &SymmetricMatrix, force: &[f64], given: &[Option<f64>]) -> Vec<f64> {
    let prescribed: Vec<f64> = given.iter().map(|g| g.unwrap_or(0.0)).collect();
    let reaction = stiffness.product(&prescribed);
    let free: Vec<usize> = (0..given.len()).filter(|i| given[*i].is_none()).collect();
    let mut place = vec![usize::MAX; given.len()];
    free.iter().enumerate().for_each(|(k, i)| place[*i] = k);
    let mut block =
        SymmetricMatrix { order: free.len(), column_start: vec![0], rows: Vec::new(), values: Vec::new() };
    for column in &free {
        for k in stiffness.column_start[*column]..stiffness.column_start[*column + 1] {
            if place[stiffness.rows[k]] != usize::MAX {
                block.rows.push(place[stiffness.rows[k]]);
                block.values.push(stiffness.values[k]);
            }
        }
        block.column_start.push(block.rows.len());
    }
    let mut rhs = Mat::from_fn(free.len(), 1, |k, _| force[free[k]] - reaction[free[k]]);
    Cholesky::new(&block).unwrap().solve(rhs.as_mut());
    let mut u = prescribed;
    free.iter().enumerate().for_each(|(k, i)| u[*i] = rhs[(k, 0)]);
    u
}

/// Prescribed values per unknown for the nodes where `field` gives some.
fn given_on(mesh: &Mesh, map: &DofMap, field: impl Fn([f64; 3]) -> [Option<f64>; 3]) -> Vec<Option<f64>> {
    let mut given = vec![None; map.count];
    for (node, position) in mesh.nodes.iter().enumerate() {
        for (component, value) in field(*position).into_iter().enumerate().take(mesh.kind.dimension()) {
            if let Some(value) = value {
                given[map.terms(node, component)[0].0] = Some(value);
            }
        }
    }
    given
}

fn square(side: f64, size: f64) -> PlaneMesh {
    let corners =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec2::new(x * side, y * side)).to_vec();
    PlaneMesh::triangulate(&PlaneDomain {
        boundaries: vec![(Boundary::Polygon(corners), size, 0)],
        interior_size: size,
    })
    .unwrap()
}

/// Patch test: a linear displacement field prescribed on the surface of an irregular patch is reproduced inside
/// to rounding, without inner forces.
#[test]
fn patch_test_for_both_elements() {
    let plane = square(10e-3, 2.5e-3);
    for mesh in [Mesh::plane_stress(plane.clone(), 1e-3), Mesh::extruded(plane, 10e-3, 2, false)] {
        let map = DofMap::new(&mesh, &[]);
        let stiffness = assembly::stiffness(&mesh, &steel(), &map).unwrap();
        let field = |p: [f64; 3]| {
            let [x, y, z] = p;
            [1e-3 * x + 2e-3 * y - 5e-4 * z, -7e-4 * x + 3e-4 * y + 1e-3 * z, 2e-4 * x - 1e-4 * y + 9e-4 * z]
        };
        let on_surface = |p: [f64; 3]| {
            let flat = mesh.kind.dimension() == 2;
            (0..2).any(|i| p[i] < 1e-9 || p[i] > 10e-3 - 1e-9) || (!flat && p[2].abs() > 5e-3 - 1e-9)
        };
        let given = given_on(&mesh, &map, |p| if on_surface(p) { field(p).map(Some) } else { [None; 3] });
        assert!(given.iter().any(|g| g.is_none()), "a patch needs inner nodes");
        let u = solve_with_given(&stiffness, &vec![0.0; map.count], &given);
        let exact = map.sample(&mesh, field);
        let largest = exact.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let error = u.iter().zip(&exact).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(error / largest < 1e-10, "{:?}: {:e}", mesh.kind, error / largest);
    }
}

/// Force of a traction p(point, outward normal) on a boundary curve of a plane mesh.
fn traction(mesh: &Mesh, map: &DofMap, boundary: usize, load: impl Fn(Vec2, Vec2) -> Vec2) -> Vec<f64> {
    let mut force = vec![0.0; map.count];
    for edge in mesh.plane.edges_of(boundary) {
        let [a, b, m] = edge.nodes.map(|n| mesh.plane.nodes[n]);
        for (s, weight) in LINE_4 {
            let shape = [(1.0 - s) * (1.0 - 2.0 * s), s * (2.0 * s - 1.0), 4.0 * s * (1.0 - s)];
            let slope = [4.0 * s - 3.0, 4.0 * s - 1.0, 4.0 - 8.0 * s];
            let point = shape[0] * a + shape[1] * b + shape[2] * m;
            let tangent = slope[0] * a + slope[1] * b + slope[2] * m;
            let outward =
                if boundary == 0 { 1.0 } else { -1.0 } * Vec2::new(tangent.y, -tangent.x).normalize();
            let t = load(point, outward) * (weight * tangent.norm() * mesh.thickness);
            for (node, n) in edge.nodes.into_iter().zip(shape) {
                map.add_force(&mut force, node, 0, n * t.x);
                map.add_force(&mut force, node, 1, n * t.y);
            }
        }
    }
    force
}

/// Constrains the three rigid motions of a plane body by prescribing the exact displacement at two nodes.
fn held_at_two_nodes(mesh: &Mesh, map: &DofMap, exact: impl Fn(Vec2) -> Vec2) -> Vec<Option<f64>> {
    let mut given = vec![None; map.count];
    let far = |direction: Vec2| {
        (0..mesh.plane.corner_count)
            .max_by(|a, b| {
                mesh.plane.nodes[*a].dot(&direction).total_cmp(&mesh.plane.nodes[*b].dot(&direction))
            })
            .unwrap()
    };
    let (a, b) = (far(Vec2::new(1.0, 1e-3)), far(Vec2::new(-1.0, 1e-3)));
    for (node, component) in [(a, 0), (a, 1), (b, 1)] {
        given[map.terms(node, component)[0].0] = Some(exact(mesh.plane.nodes[node])[component]);
    }
    given
}

/// √∫(u − u_h)² dA / √∫u² dA.
fn l2_error(mesh: &Mesh, map: &DofMap, unknowns: &[f64], exact: impl Fn(Vec2) -> Vec2) -> f64 {
    let u = map.expand(unknowns);
    let (mut error, mut norm) = (0.0, 0.0);
    for (element, nodes) in mesh.elements().enumerate() {
        let places = mesh.element_nodes::<6>(element);
        for (at, weight) in super::quadrature::TRIANGLE_6 {
            let shape = shape_t6(at);
            let w = weight * physical_gradient_t6(&places, at).1;
            let (mut point, mut value) = (Vec2::zeros(), Vec2::zeros());
            for (i, node) in nodes.iter().enumerate() {
                point += shape[i] * Vec2::new(places[i][0], places[i][1]);
                value += shape[i] * Vec2::new(u[*node][0], u[*node][1]);
            }
            error += w * (value - exact(point)).norm_squared();
            norm += w * exact(point).norm_squared();
        }
    }
    (error / norm).sqrt()
}

/// Observed order between successive halvings of the edge length; displacements of quadratic elements
/// converge with order 3 in L2.
fn order_of(error: impl Fn(f64) -> f64, size: f64) -> (f64, f64) {
    let (coarse, fine) = (error(size), error(0.5 * size));
    ((coarse / fine).log2(), fine)
}

/// Lamé: a ring under inner pressure p, u_r = p a²/(E(b²−a²)) [(1−ν) r + (1+ν) b²/r].
#[test]
fn val_lame_ring_converges_with_order_three() {
    let (a, b, p) = (10e-3, 30e-3, 100e6);
    let (e, nu) = (steel().youngs_modulus, steel().poisson_ratio);
    let exact = |x: Vec2| {
        let r = x.norm();
        x / r * (p * a * a / (e * (b * b - a * a)) * ((1.0 - nu) * r + (1.0 + nu) * b * b / r))
    };
    let error = |size: f64| {
        let domain = PlaneDomain {
            boundaries: vec![(circle(0.0, 0.0, b), size, 0), (circle(0.0, 0.0, a), size, 0)],
            interior_size: size,
        };
        let mesh = Mesh::plane_stress(PlaneMesh::triangulate(&domain).unwrap(), 5e-3);
        let map = DofMap::new(&mesh, &[]);
        let stiffness = assembly::stiffness(&mesh, &steel(), &map).unwrap();
        let force = traction(&mesh, &map, 1, |_, outward| -p * outward);
        let u = solve_with_given(&stiffness, &force, &held_at_two_nodes(&mesh, &map, exact));
        l2_error(&mesh, &map, &u, exact)
    };
    let (order, fine) = order_of(error, 3e-3);
    assert!(order > 2.7 && fine < 1e-4, "order {order}, error {fine:e}");
}

/// Kirsch: a hole of radius a in an infinite sheet under stress σ in x. The exact tractions act on a square
/// around the hole.
#[test]
fn val_kirsch_hole_converges_with_order_three() {
    let (a, half, sigma) = (5e-3, 15e-3, 100e6);
    let (e, nu) = (steel().youngs_modulus, steel().poisson_ratio);
    let (mu, kappa) = (0.5 * e / (1.0 + nu), (3.0 - nu) / (1.0 + nu));
    let exact = |x: Vec2| {
        let (r, t) = (x.norm(), x.y.atan2(x.x));
        let (q, q3) = (a / r, (a / r).powi(3));
        let factor = sigma * a / (8.0 * mu);
        Vec2::new(
            factor
                * ((kappa + 1.0) / q * t.cos() + 2.0 * q * ((1.0 + kappa) * t.cos() + (3.0 * t).cos())
                    - 2.0 * q3 * (3.0 * t).cos()),
            factor
                * ((kappa - 3.0) / q * t.sin() + 2.0 * q * ((1.0 - kappa) * t.sin() + (3.0 * t).sin())
                    - 2.0 * q3 * (3.0 * t).sin()),
        )
    };
    let stress_times = |x: Vec2, n: Vec2| {
        let (r, t) = (x.norm(), x.y.atan2(x.x));
        let (q2, q4) = ((a / r).powi(2), (a / r).powi(4));
        let (c2, s2, c4, s4) = ((2.0 * t).cos(), (2.0 * t).sin(), (4.0 * t).cos(), (4.0 * t).sin());
        let xx = sigma * (1.0 - q2 * (1.5 * c2 + c4) + 1.5 * q4 * c4);
        let yy = sigma * (-q2 * (0.5 * c2 - c4) - 1.5 * q4 * c4);
        let xy = sigma * (-q2 * (0.5 * s2 + s4) + 1.5 * q4 * s4);
        Vec2::new(xx * n.x + xy * n.y, xy * n.x + yy * n.y)
    };
    let error = |size: f64| {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| half * Vec2::new(x, y))
            .to_vec();
        let domain = PlaneDomain {
            boundaries: vec![(Boundary::Polygon(corners), size, 0), (circle(0.0, 0.0, a), 0.5 * size, 0)],
            interior_size: size,
        };
        let mesh = Mesh::plane_stress(PlaneMesh::triangulate(&domain).unwrap(), 5e-3);
        let map = DofMap::new(&mesh, &[]);
        let stiffness = assembly::stiffness(&mesh, &steel(), &map).unwrap();
        let force = traction(&mesh, &map, 0, stress_times);
        let u = solve_with_given(&stiffness, &force, &held_at_two_nodes(&mesh, &map, exact));
        l2_error(&mesh, &map, &u, exact)
    };
    let (order, fine) = order_of(error, 1.6e-3);
    assert!(order > 2.7 && fine < 1e-4, "order {order}, error {fine:e}");
}

/// Timoshenko's cantilever under an end shear P: the exact field prescribed at the clamped end, the parabolic
/// shear at the free end.
#[test]
fn val_cantilever_converges_with_order_three() {
    let (l, c, p, thickness) = (40e-3, 5e-3, 1000.0, 5e-3);
    let (e, nu) = (steel().youngs_modulus, steel().poisson_ratio);
    let inertia = 2.0 / 3.0 * c * c * c * thickness;
    let exact = |x: Vec2| {
        // Coordinates from the clamped end; y in [−c, c] (Timoshenko & Goodier, art. 21, axes rotated).
        let (x, y) = (x.x, x.y);
        let k = p / (6.0 * e * inertia);
        Vec2::new(
            -k * y * ((6.0 * l - 3.0 * x) * x + (2.0 + nu) * (y * y - c * c)),
            k * (3.0 * nu * y * y * (l - x) + (4.0 + 5.0 * nu) * c * c * x + (3.0 * l - x) * x * x),
        )
    };
    let error = |size: f64| {
        let corners = [[0.0, -c], [l, -c], [l, c], [0.0, c]].map(|[x, y]| Vec2::new(x, y)).to_vec();
        let domain =
            PlaneDomain { boundaries: vec![(Boundary::Polygon(corners), size, 0)], interior_size: size };
        let mesh = Mesh::plane_stress(PlaneMesh::triangulate(&domain).unwrap(), thickness);
        let map = DofMap::new(&mesh, &[]);
        let stiffness = assembly::stiffness(&mesh, &steel(), &map).unwrap();
        let force = traction(&mesh, &map, 0, |x, n| {
            if n.x > 0.5 { Vec2::new(0.0, 0.5 * p / inertia * (c * c - x.y * x.y)) } else { Vec2::zeros() }
        });
        let given = given_on(&mesh, &map, |q| {
            if q[0] < 1e-9 {
                let u = exact(Vec2::new(q[0], q[1]));
                [Some(u.x), Some(u.y), None]
            } else {
                [None; 3]
            }
        });
        let u = solve_with_given(&stiffness, &force, &given);
        l2_error(&mesh, &map, &u, exact)
    };
    let (order, fine) = order_of(error, 5e-3);
    assert!(order > 2.7 && fine < 1e-4, "order {order}, error {fine:e}");
}

/// Area and polar moment of area of a closed curve by Green's theorem on a fine polygon.
fn area_and_polar_moment(boundary: &Boundary) -> (f64, f64) {
    let count = 200_000;
    let points: Vec<Vec2> =
        (0..=count).map(|i| boundary.point(boundary.period() * i as f64 / count as f64)).collect();
    points.windows(2).fold((0.0, 0.0), |(area, moment), pair| {
        let (p, q) = (pair[0], pair[1]);
        let cross = crate::geometry::cross(p, q);
        (area + 0.5 * cross, moment + cross / 12.0 * (p.norm_squared() + p.dot(&q) + q.norm_squared()))
    })
}

/// K u = 0 for rigid motions, and uᵀ M u equals mass and moment of inertia of the solid between its outlines.
#[test]
fn rigid_motions_have_no_strain_energy_and_the_mass_of_the_solid() {
    let outlines = [
        Boundary::Flank(paper_profile()),
        circle(0.0, 40.5e-3, 13.5e-3),
        circle(0.0, -40.5e-3, 13.5e-3),
        circle(0.0, 0.0, 20e-3),
    ];
    let (mut solid, mut moment) = area_and_polar_moment(&outlines[0]);
    for hole in &outlines[1..] {
        let (a, j) = area_and_polar_moment(hole);
        solid -= a;
        moment -= j;
    }
    let per_area = steel().density * 8.75e-3;
    let (solid, moment) = (per_area * solid, per_area * moment);
    // 0.6366 kg is the accepted value; the inertia that goes with it is 1.3394e-3 kg·m².
    assert!((solid / 0.6366 - 1.0).abs() < 1e-4);
    let plane = disc_mesh(0.8e-3, 2, 2e-3, 4e-3);
    for mesh in [Mesh::plane_stress(plane.clone(), 8.75e-3), Mesh::extruded(plane.clone(), 8.75e-3, 1, false)]
    {
        mesh.check().unwrap();
        let map = DofMap::new(&mesh, &[]);
        let stiffness = assembly::stiffness(&mesh, &steel(), &map).unwrap();
        let mass = assembly::mass(&mesh, &steel(), &map);
        let scale = stiffness.values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let motions: [fn([f64; 3]) -> [f64; 3]; 3] =
            [|_| [1.0, 0.0, 0.0], |_| [0.0, 1.0, 0.0], |p| [-p[1], p[0], 0.0]];
        for (motion, expected) in motions.into_iter().zip([solid, solid, moment]) {
            let u = map.sample(&mesh, motion);
            let residual = stiffness.product(&u).iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            assert!(residual < 1e-11 * scale, "{residual:e}");
            let inertia: f64 = mass.product(&u).iter().zip(&u).map(|(a, b)| a * b).sum();
            // Parabolic edges have an error of fourth order in edge length over curvature radius: (0.8/1.6)⁴ of
            // a narrow strip at the flank.
            assert!((inertia / expected - 1.0).abs() < 2e-5, "{inertia} {expected}");
        }
    }
}

/// In-plane modes of a free thin ring: ω_n² = E I n²(n²−1)²/(ρ A R⁴ (n²+1)) in pairs, after three rigid-body
/// modes.
#[test]
fn val_free_ring_modes_come_in_pairs_after_three_rigid_ones() {
    let (r, h) = (50e-3, 1e-3);
    let domain = PlaneDomain {
        boundaries: vec![(circle(0.0, 0.0, r + 0.5 * h), 1e-3, 0), (circle(0.0, 0.0, r - 0.5 * h), 1e-3, 0)],
        interior_size: 1e-3,
    };
    let mesh = Mesh::plane_stress(PlaneMesh::triangulate(&domain).unwrap(), 5e-3);
    let map = DofMap::new(&mesh, &[]);
    let stiffness = assembly::stiffness(&mesh, &steel(), &map).unwrap();
    let mass = assembly::mass(&mesh, &steel(), &map);
    let sigma = (TAU * 100.0_f64).powi(2);
    let factor = Cholesky::new(&stiffness.shifted(sigma, &mass)).unwrap();
    let modes = lowest_modes(&mass, &factor, sigma, ModeRange::Count(9)).unwrap();
    let frequencies = modes.frequencies();
    assert!(frequencies[2] < 0.05, "{frequencies:?}");
    for (pair, n) in [(3, 2.0_f64), (5, 3.0), (7, 4.0)] {
        let expected = (steel().youngs_modulus * h * h / 12.0 / (steel().density * r.powi(4))).sqrt()
            * n
            * (n * n - 1.0)
            / (n * n + 1.0).sqrt()
            / TAU;
        for f in &frequencies[pair..pair + 2] {
            // A thin ring of h/R = 1/50: shear and rotatory inertia lower the frequency by about (n h/R)²/3,
            // 0.2 % for n = 4.
            assert!((f / expected - 1.0).abs() < 4e-3, "n = {n}: {f} {expected}");
        }
    }
    // M-orthonormal, and Rayleigh's quotient is the eigenvalue.
    for i in 0..9 {
        let shape: Vec<f64> = modes.shapes.col(i).iter().copied().collect();
        let (mx, kx) = (mass.product(&shape), stiffness.product(&shape));
        for j in 0..9 {
            let other: f64 = mx.iter().zip(modes.shapes.col(j).iter()).map(|(a, b)| a * b).sum();
            assert!((other - f64::from(u8::from(i == j))).abs() < 1e-10);
        }
        let rayleigh: f64 = kx.iter().zip(&shape).map(|(a, b)| a * b).sum();
        assert!((rayleigh - modes.eigenvalues[i]).abs() < 1e-7 * modes.eigenvalues[8]);
    }
}

#[test]
fn a_free_body_is_not_factorised() {
    let mesh = Mesh::plane_stress(square(10e-3, 5e-3), 1e-3);
    let map = DofMap::new(&mesh, &[]);
    let stiffness = assembly::stiffness(&mesh, &steel(), &map).unwrap();
    // Rounding decides whether the last pivot is just positive: lower it by a part in 1e9 of the diagonal.
    let mut lowered = stiffness.clone();
    for c in 0..lowered.order {
        let k = lowered.column_start[c];
        lowered.values[k] *= 1.0 - 1e-9;
    }
    assert!(matches!(Cholesky::new(&lowered), Err(super::FemError::Factorisation { .. })));
}

#[test]
fn crossing_boundaries_are_refused() {
    let domain = PlaneDomain {
        boundaries: vec![(circle(0.0, 0.0, 10e-3), 1e-3, 0), (circle(8e-3, 0.0, 4e-3), 1e-3, 0)],
        interior_size: 2e-3,
    };
    assert!(matches!(PlaneMesh::triangulate(&domain), Err(super::FemError::Mesh { .. })));
}

#[test]
fn mesh_of_the_disc_is_sound() {
    let quality = Mesh::plane_stress(disc_mesh(0.4e-3, 3, 1.2e-3, 3e-3), 8.75e-3).quality();
    // 27° is the required smallest angle of the refinement; a triangle of 27°, 27°, 126° has the aspect 2.57.
    assert!(quality.smallest_angle_deg > 26.9 && quality.largest_aspect < 2.6, "{quality:?}");
    assert!(quality.smallest_jacobian_ratio > 0.5, "{quality:?}");
}
