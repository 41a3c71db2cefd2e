//! Shape of a disc and the settings of its finite element model.

use super::body::Traction;
use super::carrier::{rim_tractions, translations};
use super::{BoreTie, Boundary, MasterMotion, MeshSizes, PlaneDomain, TiedBore};
use crate::geometry::{Profile, Sector, Vec2, unit};
use crate::machine::{Kinematics, Machine, SingleStage};
use crate::materials::Material;

/// A round hole of the disc in the frame of its flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundHole {
    /// m.
    pub centre: Vec2,
    /// m.
    pub radius: f64,
}

/// Geometry of the finite element model: the solid disc in the frame of its flank (the root of τ = 0 on the x
/// axis).
#[derive(Debug, Clone, PartialEq)]
pub struct DiscShape {
    /// Flank as cut.
    pub profile: Profile,
    /// Bores that joints load: one per crankshaft, or that of the eccentric bearing and the holes of the output pins.
    pub bores: Vec<RoundHole>,
    /// Centre hole, lightening holes.
    pub holes: Vec<RoundHole>,
    /// Windows for the carrier's pillars.
    pub windows: Vec<Sector>,
    /// Face width B in m.
    pub width: f64,
    /// Elastic constants and density.
    pub material: Material,
}

impl DiscShape {
    /// Disc `disc` of a machine. Bores and holes belong to the carrier's pattern; the flank is cut δ_j ahead
    /// of it, so in the flank's frame they stand at their angle minus δ_j.
    pub fn of(machine: &Machine, disc: usize) -> DiscShape {
        let mounting = machine.kinematics().mounting_angle(disc);
        let part = &machine.disc;
        let cranks = &machine.crankshafts;
        let bores = (0..cranks.count)
            .map(|k| {
                let angle = Kinematics::crankshaft_angle(cranks.first_angle, k, cranks.count) - mounting;
                RoundHole {
                    centre: machine.gear_stage.centre_distance() * unit(angle),
                    radius: part.crank_bore_radius,
                }
            })
            .collect();
        let centre = (part.centre_hole_radius > 0.0)
            .then(|| RoundHole { centre: Vec2::zeros(), radius: part.centre_hole_radius });
        let holes = part.holes.iter().map(|hole| RoundHole {
            centre: hole.centre_radius * unit(hole.centre_angle - mounting),
            radius: hole.radius,
        });
        DiscShape {
            profile: machine.profile(),
            bores,
            holes: centre.into_iter().chain(holes).collect(),
            windows: part.windows.iter().map(|window| window.turned(-mounting)).collect(),
            width: part.width,
            material: part.material.clone(),
        }
    }

    /// All discs of a machine.
    pub fn all(machine: &Machine) -> Vec<DiscShape> {
        (0..machine.disc_count).map(|disc| DiscShape::of(machine, disc)).collect()
    }

    /// All discs of a single stage. Its openings belong to the pattern of the output pins, as in [`DiscShape::of`] to that of
    /// the carrier.
    pub fn all_of_stage(stage: &SingleStage) -> Vec<DiscShape> {
        let disc = |disc: usize| {
            let mounting = stage.mounting(disc);
            let mut openings = stage.openings.iter().map(|opening| RoundHole {
                centre: opening.centre_radius * unit(opening.centre_angle - mounting),
                radius: opening.radius,
            });
            DiscShape {
                profile: stage.profile.clone(),
                bores: openings.by_ref().take(1 + stage.output_pins.count).collect(),
                holes: openings.collect(),
                windows: Vec::new(),
                width: stage.contact.width,
                material: stage.disc_material.clone(),
            }
        };
        (0..stage.phases.len()).map(disc).collect()
    }

    /// Lobes by which the disc must be turned, at least one, until it covers itself.
    pub fn lobes_to_repeat(&self) -> usize {
        let lobes = self.profile.lobe_count();
        let pitch = std::f64::consts::TAU / lobes as f64;
        (1..lobes).find(|turned| self.covers(pitch * *turned as f64, self)).unwrap_or(lobes)
    }

    /// The angle by which this disc must be turned to cover `other`, if the two are the same part mounted
    /// differently: bores and holes fall on bores and holes, and the flank on itself.
    pub fn turned_onto(&self, other: &DiscShape) -> Option<f64> {
        if self.profile != other.profile || self.width != other.width || self.material != other.material {
            return None;
        }
        let pitch = std::f64::consts::TAU / self.profile.lobe_count() as f64;
        let mut angles = (0..self.profile.lobe_count()).map(|lobe| pitch * lobe as f64);
        angles.find(|angle| self.covers(*angle, other))
    }

    /// Whether the openings of this disc, turned by an angle (rad), fall on those of another.
    fn covers(&self, angle: f64, other: &DiscShape) -> bool {
        let covered = |from: &[RoundHole], to: &[RoundHole]| {
            from.len() == to.len()
                && from.iter().all(|hole| {
                    let turned = crate::geometry::turned(hole.centre, unit(angle));
                    to.iter().any(|other| {
                        (turned - other.centre).norm() < 1e-9 && (hole.radius - other.radius).abs() < 1e-12
                    })
                })
        };
        let same = |a: &Sector, b: &Sector| {
            let apart = (a.centre_angle + angle - b.centre_angle).rem_euclid(std::f64::consts::TAU);
            apart.min(std::f64::consts::TAU - apart) < 1e-9
                && Sector { centre_angle: 0.0, ..*a } == Sector { centre_angle: 0.0, ..*b }
        };
        covered(&self.bores, &other.bores)
            && covered(&self.holes, &other.holes)
            && self.windows.len() == other.windows.len()
            && self.windows.iter().all(|a| other.windows.iter().any(|b| same(a, b)))
    }

    /// The region to mesh: flank first, then bores, holes and windows.
    pub fn domain(&self, sizes: &MeshSizes) -> PlaneDomain {
        let mut boundaries = vec![(Boundary::Flank(self.profile.clone()), sizes.flank, sizes.flank_rows)];
        let circle = |hole: &RoundHole| Boundary::Circle { centre: hole.centre, radius: hole.radius };
        boundaries.extend(self.bores.iter().map(|bore| (circle(bore), sizes.bore, 1)));
        boundaries.extend(self.holes.iter().map(|hole| (circle(hole), sizes.hole, 1)));
        boundaries
            .extend(self.windows.iter().map(|window| (Boundary::Outline(window.outline()), sizes.hole, 0)));
        PlaneDomain { boundaries, interior_size: sizes.interior }
    }

    /// The bores with one tie for all.
    pub fn tied_bores(&self, tie: BoreTie) -> Vec<TiedBore> {
        self.bores
            .iter()
            .enumerate()
            .map(|(k, bore)| TiedBore { boundary: 1 + k, centre: bore.centre, radius: bore.radius, tie })
            .collect()
    }
}

/// Connection of the bores with the crankshafts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BoreInterface {
    /// Each bore carries its own bearing: its centre follows the crankshaft, its rim stays round and is free
    /// to turn about it (the released revolute joint of Tao2024).
    #[default]
    PerBore,
    /// As [`BoreInterface::PerBore`] with a deformable rim: the displacement of its centre and the orders of its
    /// ovalisation (`fem::carrier::SEAT_COORDINATES`) are means of its displacement.
    Rims,
    /// Each bore carries its own bearing or pin: the displacement of its centre is the mean of that of its rim under a
    /// pressure as the cosine, and the rim is free otherwise.
    Means,
    /// One rigid spider ties all bore rims together; they move with the carrier as one body.
    Common,
}

impl BoreInterface {
    /// Pressures on the rim of a bore under which its displacement is the interface; none where its centre is an unknown.
    pub(super) fn tractions(self) -> Vec<Traction> {
        match self {
            BoreInterface::Rims => rim_tractions().collect(),
            BoreInterface::Means => translations().collect(),
            BoreInterface::PerBore | BoreInterface::Common => Vec::new(),
        }
    }

    pub(crate) fn tie(self) -> BoreTie {
        match self {
            BoreInterface::PerBore => {
                BoreTie::Spider { translation: MasterMotion::Retained, rotation: MasterMotion::Free }
            }
            BoreInterface::Rims | BoreInterface::Means => BoreTie::Free,
            BoreInterface::Common => {
                BoreTie::Spider { translation: MasterMotion::Held, rotation: MasterMotion::Held }
            }
        }
    }
}

/// Plane stress or solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DiscElement {
    /// T6 in plane stress.
    #[default]
    PlaneStress,
    /// Tet10 from the middle plane to one face, mirrored: in-plane loads have no other motion.
    Solid {
        /// Layers of prisms through half the width.
        layers: usize,
    },
}

/// Settings of the reduction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlexibleSettings {
    /// Plane stress or solid.
    pub element: DiscElement,
    /// Edge lengths of the mesh.
    pub sizes: MeshSizes,
    /// Support of the bores at the interface.
    pub interface: BoreInterface,
    /// Places per lobe where unit loads are solved for; between them compliances are interpolated.
    pub stations_per_lobe: usize,
    /// Depth h in m below the loaded point at which its own displacement is read; the deformation above it
    /// belongs to the contact law.
    pub reading_depth: f64,
    /// Normal modes up to this frequency in Hz are kept.
    pub mode_frequency: f64,
}

impl FlexibleSettings {
    /// Sizes in proportion to the disc: skin elements half the reading depth.
    pub fn plane_stress(shape: &DiscShape) -> FlexibleSettings {
        let depth = shape.profile.pin_radius / 3.0;
        FlexibleSettings {
            element: DiscElement::PlaneStress,
            sizes: FlexibleSettings::sizes(shape, 0.5 * depth, 3),
            interface: BoreInterface::default(),
            stations_per_lobe: 24,
            reading_depth: depth,
            mode_frequency: 40e3,
        }
    }

    /// About 90 000 unknowns on a disc of the RV-40E's proportions.
    pub fn solid(shape: &DiscShape) -> FlexibleSettings {
        let depth = 0.5 * shape.profile.pin_radius;
        FlexibleSettings {
            element: DiscElement::Solid { layers: 1 },
            sizes: FlexibleSettings::sizes(shape, 0.5 * depth, 2),
            reading_depth: depth,
            stations_per_lobe: 20,
            ..FlexibleSettings::plane_stress(shape)
        }
    }

    fn sizes(shape: &DiscShape, flank: f64, flank_rows: usize) -> MeshSizes {
        let bore = shape.bores.iter().map(|bore| bore.radius).fold(f64::INFINITY, f64::min);
        MeshSizes {
            flank,
            flank_rows,
            bore: 0.1 * bore,
            hole: 0.03 * shape.profile.pin_circle_radius,
            interior: 0.05 * shape.profile.pin_circle_radius,
        }
    }
}
