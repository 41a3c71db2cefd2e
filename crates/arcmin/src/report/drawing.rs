//! Drawings as data: the mechanism to scale, and a finite element mesh.

use serde::{Serialize, Serializer};

use super::plot::{Number, rounded};

/// The reducer in a view along its axis, to scale and turning.
///
/// The script turns it by the ideal kinematics: with the crank angle θ_k, the carrier is at θ_o = −θ_k/z_c,
/// disc j has its centre at a·e(θ_k + α_j) and its teeth at θ_o − α_j/z_c; its bores are aligned with the
/// carrier. The normal of every contact passes through the pitch point a·z_p·e(θ_k + α_j). Displacements under
/// load (micrometres) are not visible at this scale and not drawn.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mechanism {
    /// Heading of the figure.
    pub title: String,
    /// Text below the figure.
    #[serde(skip)]
    pub note: String,
    /// R_p.
    pub pin_circle_radius_mm: f64,
    /// r_p as installed.
    pub pin_radius_mm: f64,
    /// z_p.
    pub pin_count: usize,
    /// z_c.
    pub lobe_count: usize,
    /// a.
    pub eccentricity_mm: f64,
    /// Outer radius of the ring around the pins.
    pub housing_outer_radius_mm: f64,
    /// The flank over one lobe in the disc's frame, counter-clockwise; the script repeats it.
    #[serde(serialize_with = "rounded_points")]
    pub lobe_mm: Vec<[f64; 2]>,
    /// Phase α_j of each disc's eccentric.
    pub eccentric_phase_deg: Vec<f64>,
    /// Bores, windows and centre hole of a disc, about its centre, in line with the carrier.
    pub holes: Vec<Hole>,
    /// Crankshafts with their eccentrics.
    pub crankshafts: CrankshaftDrawing,
    /// Sun and planets.
    pub gear_stage: GearStageDrawing,
    /// For the display of the slow-motion factor.
    pub input_speed_rpm: f64,
    /// Forces to choose from, for instance new and after some hours; may be empty.
    pub states: Vec<ForceState>,
}

/// A circular hole.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hole {
    /// Place along x in the frame of the disc.
    pub x_mm: f64,
    /// Place along y in the frame of the disc.
    pub y_mm: f64,
    /// Radius of the hole.
    pub radius_mm: f64,
}

/// Crankshafts as circles on the carrier.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CrankshaftDrawing {
    /// Distance of the crankshafts from the machine axis.
    pub circle_radius_mm: f64,
    /// Place γ_k of every crankshaft on the carrier.
    pub place_deg: Vec<f64>,
    /// Radius of the shaft between the discs.
    pub shaft_radius_mm: f64,
    /// Radius of the inner raceways of the turning-arm bearings; of the disc bores where the design has no
    /// bearings.
    pub eccentric_radius_mm: f64,
}

/// Sun and planets as pitch circles.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GearStageDrawing {
    /// z_1.
    pub sun_teeth: usize,
    /// z_2.
    pub planet_teeth: usize,
    /// Pitch radius of the sun.
    pub sun_pitch_radius_mm: f64,
    /// Pitch radius of a planet.
    pub planet_pitch_radius_mm: f64,
}

/// Contact forces of all pins over one pin pitch of crank angle.
///
/// `force_n[disc][step][pin]` at the crank angle θ_k = step / steps · 360°/z_p. After one pitch the same
/// forces act on the next pin, so that one pitch describes the whole turn of a machine with equal pins.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ForceState {
    /// Name to choose the state by.
    pub label: String,
    /// Forces by disc, step and pin.
    #[serde(serialize_with = "rounded_forces")]
    pub force_n: Vec<Vec<Vec<f64>>>,
}

/// A triangle mesh with an optional displacement and an optional coloured field.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeshPicture {
    /// Heading of the figure.
    pub title: String,
    /// Text below the figure.
    #[serde(skip)]
    pub note: String,
    /// Places of the nodes.
    #[serde(serialize_with = "rounded_points")]
    pub nodes_mm: Vec<[f64; 2]>,
    /// Corners of the triangles as numbers of nodes.
    pub triangles: Vec<[u32; 3]>,
    /// Displacement of every node; empty if only the mesh is shown.
    #[serde(serialize_with = "rounded_points")]
    pub displacement_um: Vec<[f64; 2]>,
    /// Quantity shown as colour; `None` for the mesh alone.
    pub field: Option<MeshField>,
}

/// One value per node, shown as colour.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeshField {
    /// Name of the quantity.
    pub label: String,
    /// Unit of the values as a reader writes it.
    pub unit: String,
    /// Values of the nodes, in their order.
    #[serde(serialize_with = "rounded")]
    pub values: Vec<f64>,
}

fn rounded_points<S: Serializer>(points: &[[f64; 2]], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(points.iter().flatten().map(|value| Number(*value)))
}

fn rounded_forces<S: Serializer>(forces: &[Vec<Vec<f64>>], serializer: S) -> Result<S::Ok, S::Error> {
    /// A resolution of 0.1 N suffices for arrows.
    struct Row<'a>(&'a [f64]);
    impl Serialize for Row<'_> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            serializer.collect_seq(self.0.iter().map(|force| Number((force * 10.0).round() / 10.0)))
        }
    }
    serializer.collect_seq(forces.iter().map(|disc| disc.iter().map(|row| Row(row)).collect::<Vec<_>>()))
}

/// Picture of a plane mesh of linear or quadratic triangles (m), with displacements (m) of every node, if any.
///
/// Quadratic triangles list their corners first; only those are drawn. The colour is the size of the
/// displacement.
pub fn mesh_picture<const N: usize>(
    title: &str,
    note: &str,
    nodes: impl IntoIterator<Item = [f64; 2]>,
    triangles: &[[usize; N]],
    displacement: &[[f64; 2]],
) -> MeshPicture {
    // Only corners are drawn; the page does not contain midside nodes.
    let nodes: Vec<[f64; 2]> = nodes.into_iter().collect();
    let mut place = vec![u32::MAX; nodes.len()];
    let mut used = Vec::new();
    let corners = triangles
        .iter()
        .map(|triangle| {
            let mut corner = [0_u32; 3];
            for (slot, node) in corner.iter_mut().zip(triangle) {
                if place[*node] == u32::MAX {
                    place[*node] = used.len() as u32;
                    used.push(*node);
                }
                *slot = place[*node];
            }
            corner
        })
        .collect();
    let moved = displacement.len() == nodes.len();
    let displacement_um: Vec<[f64; 2]> = if moved {
        used.iter().map(|node| displacement[*node].map(|part| part * 1e6)).collect()
    } else {
        Vec::new()
    };
    let field = moved.then(|| MeshField {
        label: "displacement".into(),
        unit: "µm".into(),
        values: displacement_um.iter().map(|[x, y]| x.hypot(*y)).collect(),
    });
    MeshPicture {
        title: title.into(),
        note: note.into(),
        nodes_mm: used.iter().map(|node| nodes[*node].map(|part| part * 1e3)).collect(),
        triangles: corners,
        displacement_um,
        field,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mesh_picture_keeps_corners_only() {
        let nodes =
            vec![[0.0, 0.0], [1e-3, 0.0], [0.0, 1e-3], [0.5e-3, 0.0], [0.5e-3, 0.5e-3], [0.0, 0.5e-3]];
        let displacement: Vec<[f64; 2]> = (0..6).map(|i| [f64::from(i) * 1e-6, 0.0]).collect();
        let picture = mesh_picture("m", "", nodes, &[[0, 1, 2, 3, 4, 5]], &displacement);
        assert_eq!(picture.nodes_mm, vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        assert_eq!(picture.triangles, vec![[0, 1, 2]]);
        assert_eq!(picture.field.map(|field| field.values.len()), Some(3));
    }
}
