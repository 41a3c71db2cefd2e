use crate::geometry::{Profile, Relief, Vec2, cross, quarter_turn};

/// Discretisation error of a flank that is meshed with linear elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshContact {
    /// Straight edges from node to node.
    Edges,
    /// Contact with the nodes alone: between two of them a pin can penetrate by up to s²/(8 R_eq).
    Nodes,
}

/// A flank of straight edges between corners on the (worn) flank, as in a mesh of linear elements.
///
/// At convex places chords cut off metal and open a gap, at concave places they add metal and close it, by up to
/// s²/(8 ρ) for an edge of length s on the radius ρ.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Facets {
    /// τ of the corners in [0, 2π), ascending.
    parameters: Vec<f64>,
    /// Disc frame, m.
    corners: Vec<Vec2>,
    contact: MeshContact,
}

/// Point of a faceted flank that is nearest to a pin centre.
pub(super) struct NearestFacet {
    pub gap: f64,
    pub normal: Vec2,
    /// Curvature at this point in 1/m: 0 on an edge, [`CORNER_CURVATURE`] at a corner.
    pub curvature: f64,
}

/// Number of corners searched on either side of the foot. Facets are longer than the displacement of a pin
/// along the flank.
const REACH: usize = 4;
/// Curvature of a corner in 1/m: a circle of one nanometre.
const CORNER_CURVATURE: f64 = -1e9;

impl Facets {
    pub fn new(contact: MeshContact, mut parameters: Vec<f64>, profile: &Profile, relief: &Relief) -> Facets {
        parameters.iter_mut().for_each(|tau| *tau = tau.rem_euclid(std::f64::consts::TAU));
        parameters.sort_by(f64::total_cmp);
        let corner = |tau: &f64| {
            let depth = relief.at(profile.meshing_angle(*tau)).depth;
            profile.flank_point(*tau) - depth * profile.outward_normal(*tau)
        };
        Facets { contact, corners: parameters.iter().map(corner).collect(), parameters }
    }

    pub fn with_relief(&self, profile: &Profile, relief: &Relief) -> Facets {
        Facets::new(self.contact, self.parameters.clone(), profile, relief)
    }

    /// Point of the facets that is nearest to the pin centre `p` (disc frame, m), whose foot on the smooth flank is
    /// `tau`.
    pub fn nearest(&self, p: Vec2, tau: f64, pin_radius: f64) -> NearestFacet {
        let count = self.corners.len();
        let next = self.parameters.partition_point(|t| *t <= tau.rem_euclid(std::f64::consts::TAU));
        let mut best: Option<(f64, Vec2, f64)> = None;
        for step in 0..2 * REACH {
            let first = (next + count + step - REACH) % count;
            let (a, b) = (self.corners[first], self.corners[(first + 1) % count]);
            let edge = b - a;
            let share = (p - a).dot(&edge) / edge.norm_squared();
            let (place, curvature) = match share {
                s if s <= 0.0 || self.contact == MeshContact::Nodes => (a, CORNER_CURVATURE),
                s if s >= 1.0 => (b, CORNER_CURVATURE),
                s => (a + s * edge, 0.0),
            };
            // Outward is to the right of the way around; a pin centre deep in the metal would have a negative
            // distance.
            let away = p - place;
            let side = if cross(edge, away) > 0.0 && curvature == 0.0 { -1.0 } else { 1.0 };
            let distance = side * away.norm();
            if best.is_none_or(|(least, ..)| distance < least) {
                let normal =
                    if away.norm() > 0.0 { side * away.normalize() } else { -quarter_turn(edge).normalize() };
                best = Some((distance, normal, curvature));
            }
        }
        let (distance, normal, curvature) = best.unwrap_or((f64::INFINITY, Vec2::new(1.0, 0.0), 0.0));
        NearestFacet { gap: distance - pin_radius, normal, curvature }
    }
}
