//! Element matrices: six-node triangles in plane stress (T6) and ten-node tetrahedra (Tet10), isoparametric.
//!
//! K_e = ∫ Bᵀ D B dV (12×12, 30×30), M_e = ∫ ρ Nᵀ N dV (consistent). Degrees of freedom node by node (x, y[,
//! z]). Linear, isotropic, small displacements; no thermal strain. Plane stress assumes a thin disc: σ_z = 0
//! through the thickness B. Source: Zienkiewicz & Taylor, The Finite Element Method, vol. 1, chs. 8–9.

use nalgebra::{Matrix2, Matrix3, Vector3};

use super::quadrature::{TETRAHEDRON_4, TETRAHEDRON_15, TRIANGLE_6};
use crate::materials::Material;

/// Shape functions of a three-node edge at x in [0, 1]: first, last, middle node.
pub fn shape_edge(x: f64) -> [f64; 3] {
    [(1.0 - x) * (1.0 - 2.0 * x), x * (2.0 * x - 1.0), 4.0 * x * (1.0 - x)]
}

/// Their derivatives.
pub fn gradient_edge(x: f64) -> [f64; 3] {
    [4.0 * x - 3.0, 4.0 * x - 1.0, 4.0 - 8.0 * x]
}

/// Shape functions of T6 at area coordinates (l0, l1): corners L(2L−1), mid-sides 4 L L.
pub fn shape_t6([l0, l1]: [f64; 2]) -> [f64; 6] {
    let l2 = 1.0 - l0 - l1;
    [
        l0 * (2.0 * l0 - 1.0),
        l1 * (2.0 * l1 - 1.0),
        l2 * (2.0 * l2 - 1.0),
        4.0 * l0 * l1,
        4.0 * l1 * l2,
        4.0 * l2 * l0,
    ]
}

/// ∂N/∂(l0, l1) of T6.
pub fn gradient_t6([l0, l1]: [f64; 2]) -> [[f64; 2]; 6] {
    let l2 = 1.0 - l0 - l1;
    let corner2 = -(4.0 * l2 - 1.0);
    [
        [4.0 * l0 - 1.0, 0.0],
        [0.0, 4.0 * l1 - 1.0],
        [corner2, corner2],
        [4.0 * l1, 4.0 * l0],
        [-4.0 * l1, 4.0 * (l2 - l1)],
        [4.0 * (l2 - l0), -4.0 * l0],
    ]
}

/// Edges of a tetrahedron in the order of the mid-side nodes 4…9 (that of VTK and Abaqus).
pub const TET_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Shape functions of Tet10 at volume coordinates (l1, l2, l3); l0 is the rest.
pub fn shape_tet10([l1, l2, l3]: [f64; 3]) -> [f64; 10] {
    let l = [1.0 - l1 - l2 - l3, l1, l2, l3];
    let mut shape = [0.0; 10];
    for i in 0..4 {
        shape[i] = l[i] * (2.0 * l[i] - 1.0);
    }
    for (k, [a, b]) in TET_EDGES.into_iter().enumerate() {
        shape[4 + k] = 4.0 * l[a] * l[b];
    }
    shape
}

/// ∂N/∂(l1, l2, l3) of Tet10.
pub fn gradient_tet10([l1, l2, l3]: [f64; 3]) -> [[f64; 3]; 10] {
    let l = [1.0 - l1 - l2 - l3, l1, l2, l3];
    // ∂l_i/∂l_(j+1) with l0 = 1 − l1 − l2 − l3.
    let dl = |i: usize, j: usize| if i == 0 { -1.0 } else { f64::from(u8::from(i == j + 1)) };
    let mut gradient = [[0.0; 3]; 10];
    for j in 0..3 {
        for i in 0..4 {
            gradient[i][j] = (4.0 * l[i] - 1.0) * dl(i, j);
        }
        for (k, [a, b]) in TET_EDGES.into_iter().enumerate() {
            gradient[4 + k][j] = 4.0 * (dl(a, j) * l[b] + l[a] * dl(b, j));
        }
    }
    gradient
}

/// Physical gradients ∂N/∂x and the Jacobian determinant of a T6.
pub fn physical_gradient_t6(nodes: &[[f64; 3]; 6], at: [f64; 2]) -> ([[f64; 2]; 6], f64) {
    let local = gradient_t6(at);
    let mut jacobian = Matrix2::zeros();
    for (gradient, node) in local.iter().zip(nodes) {
        for i in 0..2 {
            for j in 0..2 {
                jacobian[(i, j)] += gradient[i] * node[j];
            }
        }
    }
    let determinant = jacobian.determinant();
    let inverse = jacobian.try_inverse().unwrap_or_else(Matrix2::zeros);
    let gradients = local.map(|g| [0, 1].map(|i| inverse[(i, 0)] * g[0] + inverse[(i, 1)] * g[1]));
    (gradients, determinant)
}

/// Physical gradients ∂N/∂x and the Jacobian determinant of a Tet10.
pub fn physical_gradient_tet10(nodes: &[[f64; 3]; 10], at: [f64; 3]) -> ([[f64; 3]; 10], f64) {
    let local = gradient_tet10(at);
    let mut jacobian = Matrix3::zeros();
    for (gradient, node) in local.iter().zip(nodes) {
        for i in 0..3 {
            for j in 0..3 {
                jacobian[(i, j)] += gradient[i] * node[j];
            }
        }
    }
    let determinant = jacobian.determinant();
    let inverse = jacobian.try_inverse().unwrap_or_else(Matrix3::zeros);
    let gradients = local.map(|g| {
        let v = inverse * Vector3::from(g);
        [v.x, v.y, v.z]
    });
    (gradients, determinant)
}

/// K_e of a T6 in plane stress, thickness in m, row-major 12×12, in N/m, and the smallest Jacobian determinant
/// at its points.
pub fn stiffness_t6(nodes: &[[f64; 3]; 6], material: &Material, thickness: f64) -> ([f64; 144], f64) {
    let (e, nu) = (material.youngs_modulus, material.poisson_ratio);
    let d11 = e / (1.0 - nu * nu);
    let d12 = nu * d11;
    let g = 0.5 * e / (1.0 + nu);
    let mut k = [0.0; 144];
    let mut smallest = f64::INFINITY;
    for (at, weight) in TRIANGLE_6 {
        let (b, determinant) = physical_gradient_t6(nodes, at);
        smallest = smallest.min(determinant);
        let w = weight * determinant * thickness;
        for i in 0..6 {
            for j in 0..=i {
                let [bx, by] = b[i];
                let [cx, cy] = b[j];
                k[(2 * i) * 12 + 2 * j] += w * (d11 * bx * cx + g * by * cy);
                k[(2 * i) * 12 + 2 * j + 1] += w * (d12 * bx * cy + g * by * cx);
                k[(2 * i + 1) * 12 + 2 * j] += w * (d12 * by * cx + g * bx * cy);
                k[(2 * i + 1) * 12 + 2 * j + 1] += w * (d11 * by * cy + g * bx * cx);
            }
        }
    }
    mirror_blocks(&mut k, 6, 2);
    (k, smallest)
}

/// K_e of a Tet10, row-major 30×30, in N/m, and the smallest Jacobian determinant at its points.
pub fn stiffness_tet10(nodes: &[[f64; 3]; 10], material: &Material) -> ([f64; 900], f64) {
    let (e, nu) = (material.youngs_modulus, material.poisson_ratio);
    let lambda = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    let mu = 0.5 * e / (1.0 + nu);
    let mut k = [0.0; 900];
    let mut smallest = f64::INFINITY;
    // Constant strain on an element drawn towards a sharp edge gives terms of third degree.
    let rule = if is_drawn(nodes) { &TETRAHEDRON_15[..] } else { &TETRAHEDRON_4[..] };
    for (at, weight) in rule.iter().copied() {
        let (b, determinant) = physical_gradient_tet10(nodes, at);
        smallest = smallest.min(determinant);
        let w = weight * determinant;
        for i in 0..10 {
            for j in 0..=i {
                let dot = w * mu * (b[i][0] * b[j][0] + b[i][1] * b[j][1] + b[i][2] * b[j][2]);
                for p in 0..3 {
                    for q in 0..3 {
                        let mut value = w * (lambda * b[i][p] * b[j][q] + mu * b[i][q] * b[j][p]);
                        if p == q {
                            value += dot;
                        }
                        k[(3 * i + p) * 30 + 3 * j + q] += value;
                    }
                }
            }
        }
    }
    mirror_blocks(&mut k, 10, 3);
    (k, smallest)
}

/// Whether a mid-side node is nearer to one end of its edge: see [`Mesh::drawn_towards`](super::Mesh::drawn_towards).
fn is_drawn(nodes: &[[f64; 3]; 10]) -> bool {
    TET_EDGES.into_iter().enumerate().any(|(k, [a, b])| {
        let [a, b, middle] = [nodes[a], nodes[b], nodes[4 + k]].map(Vector3::from);
        (2.0 * middle - a - b).dot(&(b - a)).abs() > 0.05 * (b - a).norm_squared()
    })
}

/// ∫ ρ N_i N_j dV of a T6 in kg, 6×6, the same for each displacement component.
pub fn mass_t6(nodes: &[[f64; 3]; 6], density: f64, thickness: f64) -> [f64; 36] {
    let mut m = [0.0; 36];
    for (at, weight) in TRIANGLE_6 {
        let shape = shape_t6(at);
        let w = weight * physical_gradient_t6(nodes, at).1 * thickness * density;
        for i in 0..6 {
            for j in 0..6 {
                m[i * 6 + j] += w * shape[i] * shape[j];
            }
        }
    }
    m
}

/// ∫ ρ N_i N_j dV of a Tet10 in kg, 10×10.
pub fn mass_tet10(nodes: &[[f64; 3]; 10], density: f64) -> [f64; 100] {
    let mut m = [0.0; 100];
    for (at, weight) in TETRAHEDRON_15 {
        let shape = shape_tet10(at);
        let w = weight * physical_gradient_tet10(nodes, at).1 * density;
        for i in 0..10 {
            for j in 0..10 {
                m[i * 10 + j] += w * shape[i] * shape[j];
            }
        }
    }
    m
}

/// Copies the lower block triangle to the upper one.
fn mirror_blocks(k: &mut [f64], nodes: usize, dimension: usize) {
    let n = nodes * dimension;
    for i in 0..n {
        for j in 0..n {
            if j / dimension > i / dimension {
                k[i * n + j] = k[j * n + i];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shape functions are 1 at their own node, 0 at the others, and their gradients are their derivatives.
    #[test]
    fn shape_functions_interpolate_and_gradients_are_derivatives() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut places: Vec<[f64; 3]> = corners.to_vec();
        places.extend(TET_EDGES.map(|[a, b]| [0, 1, 2].map(|i| 0.5 * (corners[a][i] + corners[b][i]))));
        for (n, place) in places.iter().enumerate() {
            for (i, value) in shape_tet10(*place).into_iter().enumerate() {
                assert!((value - f64::from(u8::from(i == n))).abs() < 1e-15);
            }
        }
        let at = [0.2, 0.3, 0.1];
        let h = 1e-6;
        for j in 0..3 {
            let moved = |s: f64| {
                let mut p = at;
                p[j] += s * h;
                p
            };
            for i in 0..10 {
                let difference = (shape_tet10(moved(1.0))[i] - shape_tet10(moved(-1.0))[i]) / (2.0 * h);
                assert!((difference - gradient_tet10(at)[i][j]).abs() < 1e-9);
            }
            if j < 2 {
                let plane = |s: f64| [moved(s)[0], moved(s)[1]];
                for i in 0..6 {
                    let difference = (shape_t6(plane(1.0))[i] - shape_t6(plane(-1.0))[i]) / (2.0 * h);
                    assert!((difference - gradient_t6([at[0], at[1]])[i][j]).abs() < 1e-9);
                }
            }
        }
    }
}
