//! Meshes and fields for ParaView: VTK XML unstructured grids, as text.

use std::fmt::Write;

use super::{DiscModel, ElementKind, FlankLoad, Mesh};

/// A field over the nodes.
#[derive(Debug, Clone)]
pub struct NodeField<'a> {
    /// Name of the field in the file.
    pub name: &'a str,
    /// One vector or one scalar per node; scalars use the first entry.
    pub values: &'a [[f64; 3]],
    /// Whether all three entries are written.
    pub is_vector: bool,
}

/// The mesh with its fields; lengths in m. Element types 22 (T6) and 24 (Tet10).
pub fn render(mesh: &Mesh, fields: &[NodeField<'_>]) -> String {
    let per_element = mesh.kind.nodes_per_element();
    let mut text = String::new();
    // Writing to a String does not fail.
    let _ = writeln!(
        text,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>"
    );
    let _ = writeln!(
        text,
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">",
        mesh.nodes.len(),
        mesh.element_count()
    );
    let _ =
        writeln!(text, "<Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">");
    for [x, y, z] in &mesh.nodes {
        let _ = writeln!(text, "{x:.9e} {y:.9e} {z:.9e}");
    }
    let _ = writeln!(
        text,
        "</DataArray>\n</Points>\n<Cells>\n<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">"
    );
    for element in mesh.elements() {
        let row: Vec<String> = element.iter().map(usize::to_string).collect();
        let _ = writeln!(text, "{}", row.join(" "));
    }
    let _ = writeln!(text, "</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">");
    for k in 1..=mesh.element_count() {
        let _ = writeln!(text, "{}", k * per_element);
    }
    let code = match mesh.kind {
        ElementKind::T6 => 22,
        ElementKind::Tet10 => 24,
    };
    let _ = writeln!(text, "</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">");
    for _ in 0..mesh.element_count() {
        let _ = writeln!(text, "{code}");
    }
    let _ = writeln!(text, "</DataArray>\n</Cells>\n<PointData>");
    for field in fields {
        let components = if field.is_vector { 3 } else { 1 };
        let _ = writeln!(
            text,
            "<DataArray type=\"Float64\" Name=\"{}\" NumberOfComponents=\"{components}\" format=\"ascii\">",
            escaped(field.name)
        );
        for [x, y, z] in field.values {
            let _ = if field.is_vector {
                writeln!(text, "{x:.9e} {y:.9e} {z:.9e}")
            } else {
                writeln!(text, "{x:.9e}")
            };
        }
        let _ = writeln!(text, "</DataArray>");
    }
    let _ = writeln!(text, "</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>");
    text
}

fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// Mesh and deformed shape as polygons for a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct DeformedPicture {
    /// Nodes in mm: x, y.
    pub nodes_mm: Vec<[f64; 2]>,
    /// Displacement of each node in µm.
    pub displacement_um: Vec<[f64; 2]>,
    /// Von Mises stress of each node in MPa.
    pub von_mises_mpa: Vec<f64>,
    /// Corner nodes of each triangle.
    pub triangles: Vec<[usize; 3]>,
    /// Closed outlines as node indices: the flank first, then bores, holes and windows.
    pub outlines: Vec<Vec<usize>>,
    /// Places and directions of the loads: x, y in mm, F_x, F_y in N.
    pub loads: Vec<[f64; 4]>,
}

impl DiscModel {
    /// The mesh (its middle plane) with displacement and stress under flank loads, the interface held.
    pub fn picture(&self, loads: &[FlankLoad]) -> DeformedPicture {
        let unknowns = self.deflect(loads);
        let displacement = self.nodal_displacement(&unknowns);
        let stress = self.von_mises(&unknowns);
        let plane = &self.mesh.plane;
        let curves = 1 + self.shape.bores.len() + self.shape.holes.len() + self.shape.windows.len();
        DeformedPicture {
            nodes_mm: plane.nodes.iter().map(|p| [p.x * 1e3, p.y * 1e3]).collect(),
            displacement_um: displacement[..plane.nodes.len()]
                .iter()
                .map(|u| [u[0] * 1e6, u[1] * 1e6])
                .collect(),
            von_mises_mpa: stress[..plane.nodes.len()].iter().map(|s| s * 1e-6).collect(),
            triangles: plane.triangles.iter().map(|t| [t[0], t[1], t[2]]).collect(),
            outlines: (0..curves).map(|curve| plane.nodes_of(curve)).collect(),
            loads: loads
                .iter()
                .map(|load| {
                    let at = self.shape.profile.flank_point(load.tau) * 1e3;
                    let direction = -self.shape.profile.outward_normal(load.tau) * load.force;
                    [at.x, at.y, direction.x, direction.y]
                })
                .collect(),
        }
    }

    /// The mesh with displacement and von Mises stress under flank loads, and the first held modes, for
    /// ParaView.
    ///
    /// # Errors
    /// [`super::FemError`] if the modes do not converge.
    pub fn vtu(&self, loads: &[FlankLoad], modes: usize) -> Result<String, super::FemError> {
        let unknowns = self.deflect(loads);
        let displacement = self.nodal_displacement(&unknowns);
        let stress: Vec<[f64; 3]> = self.von_mises(&unknowns).into_iter().map(|s| [s, 0.0, 0.0]).collect();
        let shapes = self.held_modes(super::solve::ModeRange::Count(modes))?;
        let named: Vec<(String, Vec<[f64; 3]>)> = shapes
            .frequencies()
            .iter()
            .enumerate()
            .map(|(m, f)| {
                (
                    format!("mode {} ({f:.0} Hz)", m + 1),
                    self.nodal_displacement(shapes.shapes.col_as_slice(m)),
                )
            })
            .collect();
        let mut fields = vec![
            NodeField { name: "displacement (m)", values: &displacement, is_vector: true },
            NodeField { name: "von Mises stress (Pa)", values: &stress, is_vector: false },
        ];
        fields.extend(named.iter().map(|(name, values)| NodeField { name, values, is_vector: true }));
        Ok(render(&self.mesh, &fields))
    }
}
