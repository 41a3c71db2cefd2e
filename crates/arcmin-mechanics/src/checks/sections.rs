//! Stresses in sections of a disc: lobes as cantilevers, walls next to openings as beams.

use std::f64::consts::PI;

use crate::geometry::{Profile, unit};
use crate::machine::Bore;

/// Largest stresses in a section, Pa.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SectionStress {
    /// At the edge: from bending and from the force along the part.
    pub bending: f64,
    /// In the middle of the section.
    pub shear: f64,
}

impl SectionStress {
    /// Stresses in a rectangle of thickness t and width B under a moment M, a transverse force Q and a
    /// longitudinal force N: 6 M/(B t²) + N/(B t), 3 Q/(2 B t).
    fn of_rectangle([thickness, width]: [f64; 2], moment: f64, across: f64, along: f64) -> SectionStress {
        let area = thickness * width;
        SectionStress {
            bending: 6.0 * moment.abs() / (area * thickness) + along.abs() / area,
            shear: 1.5 * across.abs() / area,
        }
    }

    /// The larger of the two, component by component.
    pub fn or(self, other: SectionStress) -> SectionStress {
        SectionStress { bending: self.bending.max(other.bending), shear: self.shear.max(other.shear) }
    }
}

/// A lobe under the force (N) of a pin at a meshing angle (rad), on a disc of a width (m): a cantilever clamped
/// at the section between the two neighbouring roots, of thickness 2 R_root sin(π/z_c). The root is a notch:
/// the stress there is up to 1.6 times as large by finite elements (test).
pub fn lobe(profile: &Profile, meshing_angle: f64, force: f64, width: f64) -> SectionStress {
    let half = PI / profile.lobe_count() as f64;
    let (axis, beside) = (unit(half), unit(half + 0.5 * PI));
    // On the lobe from the root at τ = 0 to the tip at π/z_c.
    let tau = meshing_angle.abs() / profile.lobe_count() as f64;
    let place = profile.flank_point(tau);
    let push = -force * profile.outward_normal(tau);
    let root = profile.root_radius();
    let [up, aside] = [place.dot(&axis) - root * half.cos(), place.dot(&beside)];
    let [along, across] = [push.dot(&axis), push.dot(&beside)];
    SectionStress::of_rectangle([2.0 * root * half.sin(), width], up * across - aside * along, across, along)
}

/// The wall next to an opening as a beam, clamped where the opening is widest and loaded in its middle: F l/8
/// and F/2 in a rectangle with the smallest thickness of the wall, m. The actual wall is thicker towards its
/// ends, so that its stress is smaller.
pub fn web(span: f64, [thickness, width]: [f64; 2], force: f64) -> SectionStress {
    if thickness <= 0.0 {
        return SectionStress { bending: f64::INFINITY, shear: f64::INFINITY };
    }
    SectionStress::of_rectangle([thickness, width], force * span / 8.0, 0.5 * force, 0.0)
}

/// Thickness (m) of the wall between two openings.
pub fn between(a: &Bore, b: &Bore) -> f64 {
    let centre = |bore: &Bore| bore.centre_radius * unit(bore.centre_angle);
    (centre(a) - centre(b)).norm() - a.radius - b.radius
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{DiscModel, DiscShape, FlankLoad, FlexibleSettings, MeshSizes, RoundHole};
    use crate::geometry::Vec2;
    use crate::materials::Material;

    fn profile() -> Profile {
        Profile::new(16, 32e-3, 1.3e-3, 2.5e-3)
    }

    /// A force at the root line acts at the edge of the section: its moment is its component along the lobe
    /// times half the thickness. Stresses are proportional to the force and inversely proportional to the
    /// width.
    #[test]
    fn a_lobe_is_a_cantilever() {
        let at = |angle: f64, force: f64, width: f64| lobe(&profile(), angle, force, width);
        let (force, width) = (100.0, 8e-3);
        let half = PI / 15.0;
        let thickness = 2.0 * profile().root_radius() * half.sin();
        let root = at(0.0, force, width);
        // The normal at the root points outward, at the angle `half` to the axis of the lobe.
        let [along, across] = [force * half.cos(), force * half.sin()];
        let bending = (6.0 * along * 0.5 * thickness / thickness + along) / (thickness * width);
        assert!((root.bending / bending - 1.0).abs() < 1e-9, "{root:?} {bending}");
        assert!((root.shear / (1.5 * across / (thickness * width)) - 1.0).abs() < 1e-9);
        let [once, twice] = [at(1.0, force, width), at(1.0, 2.0 * force, 0.5 * width)];
        assert!((twice.bending / once.bending - 4.0).abs() < 1e-12);
        assert!((twice.shear / once.shear - 4.0).abs() < 1e-12);
        assert_eq!(at(1.0, force, width), at(-1.0, force, width));
    }

    /// A disc with all dimensions doubled has a quarter of the stress under the same force.
    #[test]
    fn stresses_scale_with_the_size() {
        let Profile { pin_count, pin_circle_radius, eccentricity, pin_radius, .. } = profile();
        let large = Profile::new(pin_count, 2.0 * pin_circle_radius, 2.0 * eccentricity, 2.0 * pin_radius);
        for angle in [0.3, 1.0, 2.0, 3.0] {
            let [small, large] = [lobe(&profile(), angle, 50.0, 8e-3), lobe(&large, angle, 50.0, 16e-3)];
            assert!((small.bending / large.bending - 4.0).abs() < 1e-9);
            assert!((small.shear / large.shear - 4.0).abs() < 1e-9);
        }
    }

    /// Clamped beams: 3 F l/(4 B t²) and 3 F/(4 B t); infinite for a thickness of zero.
    #[test]
    fn a_web_is_a_clamped_beam() {
        let stress = web(10e-3, [2e-3, 8e-3], 200.0);
        assert!((stress.bending / (0.75 * 200.0 * 10e-3 / (8e-3 * 4e-6)) - 1.0).abs() < 1e-12);
        assert!((stress.shear / (0.75 * 200.0 / (8e-3 * 2e-3)) - 1.0).abs() < 1e-12);
        assert_eq!(web(10e-3, [0.0, 8e-3], 200.0).bending, f64::INFINITY);
    }

    /// Von Mises stress at the nodes of a disc by finite elements (plane stress), held at bores near its centre.
    fn finite_elements(
        profile: &Profile,
        holes: &[Bore],
        width: f64,
        load: FlankLoad,
    ) -> (DiscModel, Vec<f64>) {
        let round = |bore: &Bore| RoundHole {
            centre: bore.centre_radius * unit(bore.centre_angle),
            radius: bore.radius,
        };
        let shape = DiscShape {
            profile: profile.clone(),
            // A disc held at one bore only could rotate.
            bores: [1.0, 3.0, 5.0]
                .map(|k| RoundHole { centre: 10e-3 * unit(k * PI / 3.0), radius: 3e-3 })
                .into(),
            holes: holes.iter().map(round).collect(),
            windows: Vec::new(),
            width,
            material: Material::by_name("PLA").unwrap(),
        };
        let fine = FlexibleSettings::plane_stress(&shape);
        let sizes = MeshSizes { hole: 0.3e-3, ..fine.sizes };
        let model = DiscModel::new(shape, FlexibleSettings { sizes, ..fine }).unwrap();
        let stress = model.von_mises(&model.deflect(&[load]));
        (model, stress)
    }

    /// The wall between a root and a hole: at the edge of the hole the stress by finite elements is half to
    /// three quarters of that of the clamped beam.
    #[test]
    fn val_stress_of_a_web_is_below_that_of_a_beam() {
        let (profile, width, force) = (profile(), 8e-3, 100.0);
        for thickness in [2e-3, 3e-3] {
            let radius = 4e-3;
            let centre_radius = profile.root_radius() - thickness - radius;
            let hole = Bore { radius, centre_radius, centre_angle: 0.0 };
            let (model, stress) = finite_elements(&profile, &[hole], width, FlankLoad { tau: 0.0, force });
            let centre = Vec2::new(centre_radius, 0.0);
            let edge = model.mesh.nodes.iter().zip(&stress).filter(|(node, _)| {
                let from = Vec2::new(node[0], node[1]) - centre;
                (from.norm() - radius).abs() < 1e-6 && from.x > 0.0
            });
            let largest = edge.map(|(_, stress)| *stress).fold(0.0, f64::max);
            let beam = web(2.0 * radius, [thickness, width], force).bending;
            assert!(largest < 0.8 * beam && largest > 0.45 * beam, "{thickness}: {largest:e} {beam:e}");
        }
    }

    /// In the root next to a loaded lobe the stress by finite elements is 1.1 to 1.6 times that of the
    /// cantilever, because the root is a notch.
    #[test]
    fn val_stress_of_a_lobe_agrees_with_a_cantilever() {
        let (profile, width, force) = (profile(), 8e-3, 100.0);
        for degrees in [60.0_f64, 90.0, 120.0] {
            let angle = degrees.to_radians();
            let lobes = profile.lobe_count() as f64;
            let tau = angle / lobes;
            let (model, stress) = finite_elements(&profile, &[], width, FlankLoad { tau, force });
            let loaded = profile.flank_point(tau);
            // The roots at both sides of the lobe, away from the force.
            let roots = [0.0, 2.0 * PI / lobes].map(|root| profile.flank_point(root));
            let near = model.mesh.nodes.iter().zip(&stress).filter(|(node, _)| {
                let place = Vec2::new(node[0], node[1]);
                roots.iter().any(|root| (place - root).norm() < 1e-3) && (place - loaded).norm() > 1.5e-3
            });
            let largest = near.map(|(_, stress)| *stress).fold(0.0, f64::max);
            let beam = lobe(&profile, angle, force, width).bending;
            assert!(largest < 1.6 * beam && largest > 1.1 * beam, "{degrees}: {largest:e} {beam:e}");
        }
    }
}
