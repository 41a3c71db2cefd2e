use super::elements::{physical_gradient_t6, physical_gradient_tet10};
use super::{DiscModel, ElementKind};

impl DiscModel {
    /// Von Mises stress at every node in Pa: element stresses at the nodes, averaged over the elements that
    /// meet there.
    ///
    /// Under the loaded patch the value depends on the mesh: the Hertz pressure of the contact law is the
    /// number to use there.
    pub fn von_mises(&self, unknowns: &[f64]) -> Vec<f64> {
        let displacement = self.nodal_displacement(unknowns);
        let (e, nu) = (self.shape.material.youngs_modulus, self.shape.material.poisson_ratio);
        let mu = 0.5 * e / (1.0 + nu);
        let mut sum = vec![[0.0; 7]; self.mesh.nodes.len()];
        // Local coordinates of the nodes: corners, then mid-sides.
        let triangle = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [0.5, 0.5], [0.0, 0.5], [0.5, 0.0]];
        let corner = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (element, nodes) in self.mesh.elements().enumerate() {
            for (k, node) in nodes.iter().enumerate() {
                let mut strain = [[0.0; 3]; 3];
                match self.mesh.kind {
                    ElementKind::T6 => {
                        let (gradient, _) =
                            physical_gradient_t6(&self.mesh.element_nodes(element), triangle[k]);
                        add_gradient(&mut strain, nodes, &displacement, &gradient);
                    }
                    ElementKind::Tet10 => {
                        let at = if k < 4 {
                            corner[k]
                        } else {
                            let [a, b] = super::elements::TET_EDGES[k - 4];
                            [0, 1, 2].map(|i| 0.5 * (corner[a][i] + corner[b][i]))
                        };
                        let (gradient, _) = physical_gradient_tet10(&self.mesh.element_nodes(element), at);
                        add_gradient(&mut strain, nodes, &displacement, &gradient);
                    }
                }
                let (xx, yy) = (strain[0][0], strain[1][1]);
                // Plane stress: ε_z follows from σ_z = 0.
                let zz = if self.mesh.kind == ElementKind::T6 {
                    -nu / (1.0 - nu) * (xx + yy)
                } else {
                    strain[2][2]
                };
                let dilation = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) * (xx + yy + zz);
                let stress = [
                    dilation + 2.0 * mu * xx,
                    dilation + 2.0 * mu * yy,
                    dilation + 2.0 * mu * zz,
                    mu * (strain[0][1] + strain[1][0]),
                    mu * (strain[1][2] + strain[2][1]),
                    mu * (strain[2][0] + strain[0][2]),
                ];
                for (total, s) in sum[*node].iter_mut().zip(stress) {
                    *total += s;
                }
                sum[*node][6] += 1.0;
            }
        }
        sum.iter()
            .map(|s| {
                let [x, y, z, xy, yz, zx] = [0, 1, 2, 3, 4, 5].map(|i| s[i] / s[6].max(1.0));
                (0.5 * ((x - y).powi(2) + (y - z).powi(2) + (z - x).powi(2))
                    + 3.0 * (xy * xy + yz * yz + zx * zx))
                    .sqrt()
            })
            .collect()
    }
}

/// Adds ∂u_i/∂x_j of one element at one point.
fn add_gradient<const D: usize>(
    strain: &mut [[f64; 3]; 3],
    nodes: &[usize],
    displacement: &[[f64; 3]],
    gradient: &[[f64; D]],
) {
    for (node, g) in nodes.iter().zip(gradient) {
        for i in 0..D {
            for j in 0..D {
                strain[i][j] += displacement[*node][i] * g[j];
            }
        }
    }
}
