//! Bodies and their coordinates.

use std::ops::Range;

use super::Arm;

/// One coordinate of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Mass in kg, moment of inertia in kg·m², or 1 for a mode.
    pub mass: f64,
    /// Unit of the error tolerance, in m or rad.
    pub scale: f64,
    /// Whether it is free; otherwise it is held or prescribed.
    pub free: bool,
}

/// Rotation in the nominal mechanism, proportional to that of the input, with an offset in rad.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Turn {
    /// Rotation per rotation of the input, signed.
    pub per_input: f64,
    /// Angle at an input angle of 0, rad.
    pub offset: f64,
}

impl Turn {
    /// A rotation without offset.
    pub fn of(per_input: f64) -> Turn {
        Turn { per_input, offset: 0.0 }
    }

    fn at(self, input: f64) -> f64 {
        self.per_input * input + self.offset
    }
}

/// Motion of a body in the nominal mechanism, without clearance, errors and load. Axes without a motion are at
/// 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NominalMotion {
    /// (x, y) at the end of an arm from the middle of the mechanism, and the rotation of the arm.
    pub place: Option<(Arm, Turn)>,
    /// The angle, which is the axis after x and y, or the first axis of a body without position.
    pub turn: Option<Turn>,
}

impl NominalMotion {
    /// Rotation about the middle of the mechanism.
    pub fn turning(per_input: f64) -> NominalMotion {
        NominalMotion { place: None, turn: Some(Turn::of(per_input)) }
    }

    /// Translation on a circle without an angle of its own.
    pub fn carried(arm: Arm, per_input: f64) -> NominalMotion {
        NominalMotion { place: Some((arm, Turn::of(per_input))), turn: None }
    }
}

/// A body before its registration.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Axes in the order of its coordinates.
    pub axes: Vec<Axis>,
    /// Whether the first two axes are its position (x, y) in the plane.
    pub has_place: bool,
    /// Its translation and rotation with the input.
    pub nominal: NominalMotion,
}

/// Identifier of a registered body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BodyId(usize);

/// Registers bodies and numbers their coordinates.
///
/// Free coordinates are numbered in the order of registration, held or prescribed ones after them. This is the
/// order of elimination: bodies with few neighbours should come first, which keeps the fill small.
#[derive(Debug, Clone, Default)]
pub struct Registry {
    bodies: Vec<Body>,
}

impl Registry {
    /// Adds a body; its coordinates follow those of the bodies before.
    pub fn add(&mut self, body: Body) -> BodyId {
        self.bodies.push(body);
        BodyId(self.bodies.len() - 1)
    }

    /// A body with a single axis.
    pub fn add_turn(&mut self, axis: Axis, nominal: NominalMotion) -> BodyId {
        self.add(Body { axes: vec![axis], has_place: false, nominal })
    }

    /// Adds a mass that is attached to an axis of a body.
    pub fn add_mass(&mut self, body: BodyId, axis: usize, mass: f64) {
        self.bodies[body.0].axes[axis].mass += mass;
    }

    /// Numbers the axes of all bodies.
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

/// Range of consecutive coordinate numbers.
pub(in crate::dynamics) fn range_of(numbers: &[usize]) -> Range<usize> {
    numbers.first().map_or(0..0, |first| *first..first + numbers.len())
}

/// Numbers of the coordinates: free ones first, then held or prescribed ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinates {
    bodies: Vec<Body>,
    /// For each body, the number of each axis.
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

    /// Masses (kg) or moments of inertia (kg·m²) of the free coordinates.
    pub fn mass(&self) -> Vec<f64> {
        self.free(|axis| axis.mass)
    }

    /// Unit of the error tolerance (m or rad) of each of them.
    pub fn scale(&self) -> Vec<f64> {
        self.free(|axis| axis.scale)
    }

    /// Number of x of every centre that moves in the plane; y has the next number.
    pub fn centres(&self) -> impl Iterator<Item = usize> + '_ {
        self.bodies
            .iter()
            .zip(&self.numbers)
            .filter(|(body, _)| body.has_place && body.axes[0].free)
            .map(|(_, numbers)| numbers[0])
    }

    /// Free coordinates of the nominal mechanism for an angle of the input in rad.
    pub fn nominal(&self, input: f64) -> Vec<f64> {
        let mut q = self.nominal_of_all(input);
        q.truncate(self.size);
        q
    }

    /// All coordinates of the nominal mechanism, including held or prescribed ones.
    pub fn nominal_of_all(&self, input: f64) -> Vec<f64> {
        let mut q = vec![0.0; self.whole];
        for (Body { has_place, nominal, .. }, at) in self.bodies.iter().zip(&self.numbers) {
            if let Some((arm, turn)) = nominal.place {
                let place = arm.at(turn.at(input));
                (q[at[0]], q[at[1]]) = (place.x, place.y);
            }
            if let Some(turn) = nominal.turn {
                q[at[if *has_place { 2 } else { 0 }]] = turn.at(input);
            }
        }
        q
    }
}
