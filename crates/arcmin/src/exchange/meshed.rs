//! STL and 3MF.

use std::fmt::Write as _;

use super::drawing::escaped;
use super::mesh::{Mesh, circle, corners};
use super::profile::{Parts, ProfileExport};
use super::{ExchangeError, crankshaft, millimetres, trimmed};
use crate::geometry::{Vec2, unit};
use crate::units::{MM, UM};

/// Position of a copy of a body: rotated about the axis by an angle (rad), then translated (m).
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Name of the copy.
    pub name: String,
    /// Angle about the axis z, rad, counter-clockwise.
    pub angle: f64,
    /// Translation, m.
    pub place: [f64; 3],
}

/// A part as triangles, with its copies.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Name of the part.
    pub name: String,
    /// Triangles in the part's own frame.
    pub mesh: Mesh,
    /// Positions of the copies.
    pub copies: Vec<Placement>,
}

impl ProfileExport {
    /// The parts as triangles whose corners lie on the exact surfaces and whose chords are within the
    /// tolerance. Discs have their axial positions in the machine.
    ///
    /// # Errors
    /// [`ExchangeError::Fit`] if outlines of a part intersect, [`ExchangeError::NoPart`] as in
    /// [`ProfileExport::step`].
    pub fn bodies(&self, parts: Parts) -> Result<Vec<Body>, ExchangeError> {
        let floors = self.floors();
        let origin = |name: &str| Placement { name: name.into(), angle: 0.0, place: [0.0; 3] };
        let mut bodies = Vec::new();
        let assembly = match parts {
            Parts::Assembly { crank_angle } => {
                let kinematics = self.reducer()?.kinematics();
                let output = kinematics.nominal_output_angle(crank_angle);
                Some((crank_angle, output, kinematics))
            }
            _ => None,
        };
        if matches!(parts, Parts::Discs | Parts::Assembly { .. }) {
            for disc in self.discs() {
                let name = format!("cycloid disc {}", disc + 1);
                let pose = assembly
                    .as_ref()
                    .map(|(crank, output, kinematics)| kinematics.disc_pose(disc, *crank, *output));
                let (angle, centre) = pose.map_or((0.0, Vec2::zeros()), |pose| (pose.angle, pose.centre));
                // A single disc is at zero, as in a STEP file.
                let floor =
                    if self.options.disc.is_some() && assembly.is_none() { 0.0 } else { floors[disc] };
                let copy = Placement { name: name.clone(), angle, place: [centre.x, centre.y, floor] };
                bodies.push(Body { mesh: self.disc_mesh(disc)?, name, copies: vec![copy] });
            }
        }
        if matches!(parts, Parts::Pin | Parts::Assembly { .. }) {
            let copies = match &assembly {
                None => vec![origin("pin")],
                Some(_) => self
                    .pins()
                    .iter()
                    .enumerate()
                    .map(|(index, (centre, _))| Placement {
                        name: format!("pin {}", index + 1),
                        angle: 0.0,
                        place: [centre.x, centre.y, floors[0]],
                    })
                    .collect(),
            };
            let outline = circle(Vec2::zeros(), self.separate_pin()?, self.options.tolerance);
            let mesh = Mesh::prism(&outline, &[], 0.0, self.pin_length()).ok_or_else(crossing)?;
            bodies.push(Body { name: "pin".into(), mesh, copies });
        }
        if parts == Parts::Ring {
            let (ring, tolerance) = (self.contour()?, self.options.tolerance);
            let outside = circle(Vec2::zeros(), ring.outer_radius, tolerance);
            let openings = [corners(&ring.opening, tolerance)];
            let mesh = Mesh::prism(&outside, &openings, 0.0, self.pin_length()).ok_or_else(crossing)?;
            bodies.push(Body { name: "ring".into(), mesh, copies: vec![origin("ring")] });
        }
        if matches!(parts, Parts::Crankshaft | Parts::Assembly { .. }) {
            let machine = self.reducer()?;
            let copies = match assembly {
                None => vec![origin("crankshaft")],
                Some((crank, output, _)) => (0..machine.crankshafts.count)
                    .map(|k| {
                        let count = machine.crankshafts.count;
                        let first = machine.crankshafts.first_angle;
                        let angle = crate::machine::Kinematics::crankshaft_angle(first, k, count) + output;
                        let centre = machine.gear_stage.centre_distance() * unit(angle);
                        let name = format!("crankshaft {}", k + 1);
                        Placement { name, angle: crank, place: [centre.x, centre.y, 0.0] }
                    })
                    .collect(),
            };
            let slices = crankshaft::slices(machine);
            let mesh = Mesh::stack(&slices, self.options.tolerance).ok_or_else(crossing)?;
            bodies.push(Body { name: "crankshaft".into(), mesh, copies });
        }
        Ok(bodies)
    }

    fn disc_mesh(&self, disc: usize) -> Result<Mesh, ExchangeError> {
        let tolerance = self.options.tolerance;
        let openings = self.openings(disc);
        let round = openings.bores.iter().chain(&openings.holes);
        let holes: Vec<Vec<Vec2>> = round
            .map(|hole| circle(hole.centre, hole.radius, tolerance))
            .chain(openings.windows.iter().map(|window| corners(window, tolerance)))
            .collect();
        Mesh::prism(&self.polyline(), &holes, 0.0, self.width()).ok_or_else(crossing)
    }

    /// Stamp of meshes: the tolerance of their chords.
    fn mesh_stamp(&self) -> String {
        let um = trimmed(self.options.tolerance / UM, 4);
        format!("triangles whose chords stay within {um} um of the exact surfaces; unit mm")
    }

    /// Binary STL in millimetres, all copies in one file.
    ///
    /// # Errors
    /// As [`ProfileExport::bodies`].
    pub fn stl(&self, parts: Parts) -> Result<Vec<u8>, ExchangeError> {
        let bodies = self.bodies(parts)?;
        let mut head = format!(
            "arcmin {}, design {}, unit mm, chords within {} um",
            self.stamp.version,
            self.stamp.design_hash,
            trimmed(self.options.tolerance / UM, 4)
        )
        .into_bytes();
        head.resize(80, b' ');
        let count: usize = bodies.iter().map(|body| body.copies.len() * body.mesh.triangles.len()).sum();
        let mut bytes = head;
        bytes.extend((count as u32).to_le_bytes());
        for body in &bodies {
            for copy in &body.copies {
                let mesh = body.mesh.placed(copy.angle, copy.place);
                // Corners in the precision of the file, so that a common one is identical in all its triangles.
                let vertices: Vec<[f32; 3]> =
                    mesh.vertices.iter().map(|v| v.map(|metres| (metres / MM) as f32)).collect();
                for triangle in &mesh.triangles {
                    let corners = triangle.map(|index| vertices[index]);
                    let [a, b, c] = corners.map(|v| nalgebra::Vector3::from(v.map(f64::from)));
                    let normal = (b - a).cross(&(c - a)).normalize();
                    let normal = [normal.x, normal.y, normal.z].map(|x| x as f32);
                    for value in std::iter::once(normal).chain(corners).flatten() {
                        bytes.extend(value.to_le_bytes());
                    }
                    bytes.extend([0, 0]);
                }
            }
        }
        Ok(bytes)
    }

    /// The files in a 3MF archive (core specification 1.3), by their names: every part is an object, every copy
    /// an item.
    ///
    /// # Errors
    /// As [`ProfileExport::bodies`].
    pub fn three_mf(&self, parts: Parts) -> Result<Vec<(String, Vec<u8>)>, ExchangeError> {
        let bodies = self.bodies(parts)?;
        let description =
            self.stamps().into_iter().take(2).chain([self.mesh_stamp()]).collect::<Vec<_>>().join(". ");
        let mut text = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xml:lang=\"en-US\" \
             xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n  <metadata \
             name=\"Title\">{}</metadata>\n  <metadata name=\"Application\">arcmin {}</metadata>\n  <metadata \
             name=\"Description\">{}</metadata>\n  <resources>\n",
            escaped(&self.stamp.design_name),
            escaped(&self.stamp.version),
            escaped(&description)
        );
        for (index, body) in bodies.iter().enumerate() {
            let _ = writeln!(
                text,
                "    <object id=\"{}\" type=\"model\" name=\"{}\">\n      <mesh>\n        <vertices>",
                index + 1,
                escaped(&body.name)
            );
            for [x, y, z] in body.mesh.vertices.iter().map(|v| v.map(millimetres)) {
                let _ = writeln!(text, "          <vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>");
            }
            text.push_str("        </vertices>\n        <triangles>\n");
            for [a, b, c] in &body.mesh.triangles {
                let _ = writeln!(text, "          <triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>");
            }
            text.push_str("        </triangles>\n      </mesh>\n    </object>\n");
        }
        text.push_str("  </resources>\n  <build>\n");
        for (index, body) in bodies.iter().enumerate() {
            for copy in &body.copies {
                // Row vectors are multiplied from the left: (x, y, z, 1) M.
                let turn = unit(copy.angle);
                let [cos, sin, minus] = [turn.x, turn.y, -turn.y].map(|value| trimmed(value, 15));
                let [x, y, z] = copy.place.map(millimetres);
                let _ = writeln!(
                    text,
                    "    <item objectid=\"{}\" partnumber=\"{}\" transform=\"{cos} {sin} 0 {minus} {cos} 0 0 0 1 {x} {y} {z}\"/>",
                    index + 1,
                    escaped(&copy.name)
                );
            }
        }
        text.push_str("  </build>\n</model>\n");
        let files =
            [("[Content_Types].xml", CONTENT_TYPES), ("_rels/.rels", RELATIONS), ("3D/3dmodel.model", &text)];
        Ok(files.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec())).to_vec())
    }
}

const CONTENT_TYPES: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Types \
     xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\n  <Default Extension=\"rels\" \
     ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\n  <Default Extension=\"model\" \
     ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>\n</Types>\n";

const RELATIONS: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Relationships \
     xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\n  <Relationship Target=\"/3D/3dmodel.model\" \
     Id=\"model\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>\n</Relationships>\n";

fn crossing() -> ExchangeError {
    ExchangeError::Fit {
        message: "outlines of the part cross each other, so it cannot be covered with triangles".into(),
        remedy: "give a smaller tolerance; `arcmin check` names bores, holes or windows that overlap".into(),
    }
}
