//! Bodies and their coordinates.

use super::Arm;
use crate::machine::Kinematics;

/// One coordinate of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axis {
    /// kg, kg·m², or 1 for a mode.
    pub mass: f64,
    /// What counts as one unit of error, in m or rad.
    pub scale: f64,
    /// Whether it moves by forces; otherwise it is held or prescribed.
    pub free: bool,
}

/// Where a body stands in the nominal machine. Axes beyond those named stay at 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Follows {
    /// (x, y) at the centre of the housing.
    Centre,
    /// (x, y) at a place of the carrier.
    Carried(Arm),
    /// The turn of the crankshafts.
    Crank,
    /// (x, y, θ) of a disc.
    Disc(usize),
    /// θ of the carrier as its last axis.
    Carrier,
    /// θ of the housing as its last axis.
    Housing,
    /// The turn of the sun.
    Sun,
}

/// A body as it enters the registry.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Body {
    pub axes: Vec<Axis>,
    /// Whether the first two axes are its place (x, y) in the plane.
    pub has_place: bool,
    pub follows: Follows,
}

/// A body that has been registered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BodyId(usize);

/// Takes bodies and hands out coordinates.
///
/// Free coordinates are numbered in the order of registration, those held or prescribed after them. That
/// order is the order of elimination: bodies that touch few others go first, then elimination fills little.
#[derive(Debug, Clone, Default)]
pub(super) struct Registry {
    bodies: Vec<Body>,
}

impl Registry {
    pub fn add(&mut self, body: Body) -> BodyId {
        self.bodies.push(body);
        BodyId(self.bodies.len() - 1)
    }

    /// A body with a single axis.
    pub fn add_turn(&mut self, axis: Axis, follows: Follows) -> BodyId {
        self.add(Body { axes: vec![axis], has_place: false, follows })
    }

    /// What is fastened to an axis of a body.
    pub fn add_mass(&mut self, body: BodyId, axis: usize, mass: f64) {
        self.bodies[body.0].axes[axis].mass += mass;
    }

    /// Numbers all axes.
    pub fn number(self) -> Coordinates {
        let count = |free: bool| {
            self.bodies.iter().flat_map(|body| &body.axes).filter(|axis| axis.free == free).count()
        };
        let size = count(true);
        let whole = size + count(false);
        let (mut free, mut held) = (0..size, size..whole);
        let numbers = self
            .bodies
            .iter()
            .map(|body| {
                let next = |axis: &Axis| if axis.free { free.next() } else { held.next() };
                body.axes.iter().filter_map(next).collect()
            })
            .collect();
        Coordinates { bodies: self.bodies, numbers, size, whole }
    }
}

/// Where each coordinate sits: free ones first, those that are held or prescribed after them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Coordinates {
    bodies: Vec<Body>,
    /// Per body, the number of each axis.
    numbers: Vec<Vec<usize>>,
    /// Number of free coordinates.
    pub size: usize,
    /// Number of all coordinates.
    pub whole: usize,
}

impl Coordinates {
    /// Numbers of a body's axes.
    pub fn of(&self, body: BodyId) -> &[usize] {
        &self.numbers[body.0]
    }

    /// A property of the free coordinates.
    fn free(&self, property: fn(&Axis) -> f64) -> Vec<f64> {
        self.bodies.iter().flat_map(|body| &body.axes).filter(|axis| axis.free).map(property).collect()
    }

    pub fn mass(&self) -> Vec<f64> {
        self.free(|axis| axis.mass)
    }

    pub fn scale(&self) -> Vec<f64> {
        self.free(|axis| axis.scale)
    }

    /// x of every centre that moves in the plane; y comes next.
    pub fn centres(&self) -> impl Iterator<Item = usize> + '_ {
        self.bodies
            .iter()
            .zip(&self.numbers)
            .filter(|(body, _)| body.has_place && body.axes[0].free)
            .map(|(_, numbers)| numbers[0])
    }

    /// Free coordinates of the nominal machine with carrier, housing, crankshafts and sun at these angles in
    /// rad.
    pub fn nominal(
        &self,
        kinematics: &Kinematics,
        carrier: f64,
        housing: f64,
        crank: f64,
        sun: f64,
    ) -> Vec<f64> {
        let mut q = vec![0.0; self.whole];
        for (body, at) in self.bodies.iter().zip(&self.numbers) {
            let last = at[at.len() - 1];
            match body.follows {
                Follows::Centre => {}
                Follows::Carried(arm) => {
                    let place = arm.at(carrier);
                    (q[at[0]], q[at[1]]) = (place.x, place.y);
                }
                Follows::Crank => q[last] = crank,
                Follows::Disc(disc) => {
                    let pose = kinematics.disc_pose(disc, crank, carrier);
                    (q[at[0]], q[at[1]], q[at[2]]) = (pose.centre.x, pose.centre.y, pose.angle);
                }
                Follows::Carrier => q[last] = carrier,
                Follows::Housing => q[last] = housing,
                Follows::Sun => q[last] = sun,
            }
        }
        q.truncate(self.size);
        q
    }
}
