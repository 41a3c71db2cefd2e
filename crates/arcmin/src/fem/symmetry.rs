//! Bodies that mirrors leave as they are: a part of them in every class of symmetry stands for the whole.

use rayon::prelude::*;

use super::body::{Body, Compliance, NodalLoad};
use super::{FemError, Mesh};
use crate::geometry::Vec2;
use crate::materials::Material;

/// Planes through the axis that a section is symmetric about: only the part on one side of them is meshed, its nodes on
/// them exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mirrors {
    None,
    /// x = 0; the part with x ≥ 0 is left.
    X,
    /// y = 0; the part with y ≥ 0 is left.
    Y,
    /// Both; a quarter is left.
    Both,
}

impl Mirrors {
    /// Those of the two that are there.
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

/// A place as the mirror with this normal shows it.
pub(super) fn reflected(mut place: Vec2, component: usize) -> Vec2 {
    place[component] = -place[component];
    place
}

/// What mirrors leave of a body, held on them as motions are that are even or odd about each.
pub struct Class {
    /// Per mirror the component of its normal, and whether motions turn about by reflection in it (odd) or stay.
    pub mirrors: Vec<(usize, bool)>,
    pub body: Body,
}

/// What mirrors leave of a body, meshed: the mesh, the curves around every triangle of its section, and the components
/// of nodes that something holds.
pub(super) struct Part {
    pub mesh: Mesh,
    pub regions: Vec<u64>,
    pub held: Vec<[bool; 3]>,
}

impl Part {
    /// The bodies of all classes of symmetry.
    pub fn classes(&self, mirrors: Mirrors, material: &Material) -> Result<Vec<Class>, FemError> {
        let planes = mirrors.components();
        (0..1_usize << planes.len())
            .into_par_iter()
            .map(|bits| {
                let mirrors: Vec<(usize, bool)> = planes
                    .iter()
                    .enumerate()
                    .map(|(k, component)| (*component, bits >> k & 1 == 1))
                    .collect();
                let mut held = self.held.clone();
                for (component, odd) in &mirrors {
                    let on = (0..held.len()).filter(|node| self.mesh.nodes[*node][*component] == 0.0);
                    // What is even moves along the plane, what is odd through it.
                    on.for_each(|node| (0..3).for_each(|c| held[node][c] |= (c == *component) != *odd));
                }
                let body = Body::new(self.mesh.clone(), self.regions.clone(), material.clone(), &held)?;
                Ok(Class { mirrors, body })
            })
            .collect()
    }
}

/// C of `count` unit loads from bodies that together are the whole. `loads` gives the parts of them on a mesh,
/// `reflected` which load, with which sign, the mirror with a normal turns another into.
///
/// Reflections g turn a load L into another or its opposite, g L. Its share in a class is L_c = Σ_g χ(g) g L/n, n their
/// number and χ(g) = ± 1 the class's own sign, so that L = Σ_c L_c; what L_c displaces belongs to the class, and L reads
/// n times of it what L_c reads on the part that is meshed.
pub(super) fn compliance(
    classes: &[Class],
    count: usize,
    loads: impl Fn(&Body) -> Vec<NodalLoad> + Sync,
    reflected: impl Fn(usize, usize) -> (usize, f64) + Sync,
) -> Compliance {
    let of_class = |class: &Class| -> Vec<f64> {
        let (there, here): (Vec<usize>, Vec<NodalLoad>) =
            loads(&class.body).into_iter().enumerate().filter(|(_, load)| !load.is_empty()).unzip();
        let part = class.body.compliance(&here);
        let images: Vec<Vec<(usize, f64)>> = (0..count)
            .map(|load| {
                let mut images = vec![(load, 1.0)];
                for (component, odd) in &class.mirrors {
                    let own = if *odd { -1.0 } else { 1.0 };
                    let more = images.iter().map(|(load, sign)| {
                        let (to, turned) = reflected(*load, *component);
                        (to, own * turned * sign)
                    });
                    let more: Vec<(usize, f64)> = more.collect();
                    images.extend(more);
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
        images.iter().flat_map(|i| images.iter().map(|j| sum(i, j))).collect()
    };
    let of_classes: Vec<Vec<f64>> = classes.par_iter().map(of_class).collect();
    let mut values = vec![0.0; count * count];
    for class in of_classes {
        values.iter_mut().zip(class).for_each(|(sum, value)| *sum += value);
    }
    Compliance { count, values }
}
