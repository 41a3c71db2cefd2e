//! Symmetric bodies: a part in every class of symmetry represents the whole.

use rayon::prelude::*;

use super::body::{Body, Compliance, NodalLoad};
use super::{FemError, Mesh};
use crate::geometry::Vec2;
use crate::materials::Material;

/// Planes through the axis that a section is symmetric about: only the part on one side of them is meshed, its nodes on
/// them exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mirrors {
    /// No plane: all of the section is meshed.
    None,
    /// x = 0; the part with x ≥ 0 is left.
    X,
    /// y = 0; the part with y ≥ 0 is left.
    Y,
    /// Both; a quarter is left.
    Both,
}

impl Mirrors {
    /// The present planes.
    pub fn of(x: bool, y: bool) -> Mirrors {
        match (x, y) {
            (false, false) => Mirrors::None,
            (true, false) => Mirrors::X,
            (false, true) => Mirrors::Y,
            (true, true) => Mirrors::Both,
        }
    }

    /// Components of the normals of the planes: 0 of x = 0, 1 of y = 0.
    pub fn components(self) -> &'static [usize] {
        match self {
            Mirrors::None => &[],
            Mirrors::X => &[0],
            Mirrors::Y => &[1],
            Mirrors::Both => &[0, 1],
        }
    }
}

/// Reflection of a point in the plane with this normal.
pub(super) fn reflected(mut place: Vec2, mirror: usize) -> Vec2 {
    place[mirror] = -place[mirror];
    place
}

/// Sign of a motion along x (0) or y (1) after reflection in the plane with a normal.
pub(super) fn reflection_sign(axis: usize, mirror: usize) -> f64 {
    if axis == mirror { -1.0 } else { 1.0 }
}

/// Symmetric part of a body with the boundary conditions of even or odd motions on its planes.
pub struct Class {
    /// For each plane the component of its normal, and whether motions are odd (reversed by reflection) or even.
    pub mirrors: Vec<(usize, bool)>,
    /// The part, meshed, held and factorised.
    pub body: Body,
}

/// Symmetric part of a body, meshed.
pub struct SymmetricPart {
    /// Mesh with nodes exactly on the mirrors.
    pub mesh: Mesh,
    /// Bits of the curves around every triangle of the section.
    pub regions: Vec<u64>,
    /// Held displacement components.
    pub held: Vec<[bool; 3]>,
}

/// A body in layers that may be symmetric about planes through its axis.
pub trait Symmetric: Sync {
    /// All of those planes.
    fn mirrors(&self) -> Mirrors;

    /// Elastic constants and density of the whole body.
    fn material(&self) -> &Material;

    /// Meshes the symmetric part.
    ///
    /// # Errors
    /// [`FemError`] if dimensions contradict each other.
    fn mesh_part(&self, mirrors: Mirrors) -> Result<SymmetricPart, FemError>;

    /// Unit loads of all interface coordinates; of each the part on the mesh.
    fn loads(&self, body: &Body) -> Vec<NodalLoad>;

    /// The image of a coordinate under reflection in the plane with a normal (0 along x, 1 along y), and its sign.
    fn reflected(&self, coordinate: usize, mirror: usize) -> (usize, f64);

    /// The body of one class of symmetry: the held displacement components follow from the planes.
    ///
    /// # Errors
    /// [`FemError`] if the body cannot be factorised.
    fn class(&self, part: &SymmetricPart, mirrors: Vec<(usize, bool)>) -> Result<Class, FemError> {
        let SymmetricPart { mesh, regions, held } = part;
        let mut held = held.clone();
        for (component, odd) in &mirrors {
            let on = (0..held.len()).filter(|node| mesh.nodes[*node][*component] == 0.0);
            // Even motions lie in the plane, odd ones are normal to it.
            on.for_each(|node| (0..3).for_each(|c| held[node][c] |= (c == *component) != *odd));
        }
        let body = Body::new(mesh.clone(), regions.clone(), self.material().clone(), &held)?;
        Ok(Class { mirrors, body })
    }

    /// Applies `of` to the classes of symmetry, which together represent the whole. Fewer planes give the same result
    /// but are slower. Each class is dropped after its use, because its factor needs half a gigabyte.
    ///
    /// # Errors
    /// As [`Symmetric::mesh_part`].
    fn of_classes<T: Send>(
        &self,
        mirrors: Mirrors,
        of: impl Fn(Class) -> T + Sync,
    ) -> Result<Vec<T>, FemError> {
        let (part, planes) = (self.mesh_part(mirrors)?, mirrors.components());
        (0..1_usize << planes.len())
            .into_par_iter()
            .map(|bits| {
                let odd = |(k, component): (usize, &usize)| (*component, bits >> k & 1 == 1);
                self.class(&part, planes.iter().enumerate().map(odd).collect()).map(&of)
            })
            .collect()
    }

    /// C of [`Symmetric::loads`] of the whole.
    ///
    /// Reflections g turn a load L into another or its opposite, g L. Its share in a class is L_c = Σ_g χ(g) g L/n, n
    /// their number and χ(g) = ± 1 the class's own sign, so that L = Σ_c L_c; the displacement under L_c belongs to
    /// the class, and its product with L is n times that with L_c on the meshed part.
    ///
    /// # Errors
    /// As [`Symmetric::of_classes`].
    fn compliance_of(&self, mirrors: Mirrors) -> Result<Compliance, FemError> {
        let of_class = |class: Class| -> Compliance {
            let loads = self.loads(&class.body);
            let count = loads.len();
            let (there, here): (Vec<usize>, Vec<NodalLoad>) =
                loads.into_iter().enumerate().filter(|(_, load)| !load.is_empty()).unzip();
            let part = class.body.compliance(&here);
            let images: Vec<Vec<(usize, f64)>> = (0..count)
                .map(|load| {
                    let mut images = vec![(load, 1.0)];
                    for (component, odd) in &class.mirrors {
                        let own = if *odd { -1.0 } else { 1.0 };
                        for k in 0..images.len() {
                            let (load, sign) = images[k];
                            let (to, turned) = self.reflected(load, *component);
                            images.push((to, own * turned * sign));
                        }
                    }
                    let on_part = |(load, sign): (usize, f64)| Some((there.binary_search(&load).ok()?, sign));
                    images.into_iter().filter_map(on_part).collect()
                })
                .collect();
            let share = 1.0 / (1_usize << class.mirrors.len()) as f64;
            let sum = |i: &[(usize, f64)], j: &[(usize, f64)]| -> f64 {
                let pairs = i.iter().flat_map(|(a, p)| j.iter().map(move |(b, q)| (a, b, p * q)));
                share * pairs.map(|(a, b, sign)| sign * part.at(*a, *b)).sum::<f64>()
            };
            let values = images.iter().flat_map(|i| images.iter().map(|j| sum(i, j))).collect();
            Compliance { count, values }
        };
        let whole = self.of_classes(mirrors, of_class)?.into_iter().reduce(|mut sum, class| {
            sum.values.iter_mut().zip(class.values).for_each(|(sum, value)| *sum += value);
            sum
        });
        Ok(whole.unwrap_or(Compliance { count: 0, values: Vec::new() }))
    }
}
