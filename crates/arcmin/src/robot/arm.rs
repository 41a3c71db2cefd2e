//! A serial arm with revolute axes: poses of its links and its tool.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

/// Pose of a frame in another one: x ↦ R x + p.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// R, without unit.
    pub rotation: Matrix3<f64>,
    /// p in m.
    pub position: Vector3<f64>,
}

impl Pose {
    /// The identity: R = 1, p = 0.
    pub fn identity() -> Pose {
        Pose { rotation: Matrix3::identity(), position: Vector3::zeros() }
    }

    /// Position in m; roll, pitch and yaw in rad about the fixed axes x, y, z, in this order (as URDF has them).
    pub fn new(position: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> Pose {
        let rotation = Rotation3::from_euler_angles(roll, pitch, yaw).into_inner();
        Pose { rotation, position: Vector3::from(position) }
    }

    /// Composition: the pose of a frame `inner`, given relative to this one, in the frame in which this one is
    /// given.
    pub fn then(&self, inner: &Pose) -> Pose {
        Pose { rotation: self.rotation * inner.rotation, position: self.at(&inner.position) }
    }

    /// Coordinates of a point, transformed.
    pub fn at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.position + self.rotation * point
    }

    /// Rotated about an axis of its own by an angle in rad.
    fn turned(&self, axis: &Unit<Vector3<f64>>, angle: f64) -> Pose {
        let turn = Rotation3::from_axis_angle(axis, angle).into_inner();
        Pose { rotation: self.rotation * turn, ..*self }
    }
}

/// Mass of a link, in the frame of its axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub centre: Vector3<f64>,
    /// Inertia tensor about the centre of mass, kg·m².
    pub inertia: Matrix3<f64>,
}

impl Body {
    /// A body without mass.
    pub fn none() -> Body {
        Body { mass: 0.0, centre: Vector3::zeros(), inertia: Matrix3::zeros() }
    }

    /// The body in a frame relative to which the body's present frame has this pose.
    pub fn transformed(&self, pose: &Pose) -> Body {
        let inertia = pose.rotation * self.inertia * pose.rotation.transpose();
        Body { mass: self.mass, centre: pose.at(&self.centre), inertia }
    }

    /// Both combined, by Steiner's theorem.
    pub fn with(&self, other: &Body) -> Body {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            return *self;
        }
        let centre = (self.mass * self.centre + other.mass * other.centre) / mass;
        let about = |body: &Body| body.inertia + steiner(body.mass, body.centre - centre);
        Body { mass, centre, inertia: about(self) + about(other) }
    }
}

fn steiner(mass: f64, r: Vector3<f64>) -> Matrix3<f64> {
    mass * (Matrix3::identity() * r.norm_squared() - r * r.transpose())
}

/// A revolute axis and the link behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name of the joint in the URDF or the table.
    pub name: String,
    /// Pose of the axis at angle 0 in the frame of the previous axis, for the first one in that of the base.
    pub place: Pose,
    /// Direction in its own frame.
    pub direction: Unit<Vector3<f64>>,
    /// Mass between this axis and the next one.
    pub link: Body,
    /// Smallest angle, rad.
    pub lower: f64,
    /// Largest angle, rad.
    pub upper: f64,
    /// Largest speed, rad/s; infinite if not given.
    pub speed: f64,
    /// Largest torque, N·m; infinite if not given.
    pub torque: f64,
}

/// Tolerance of equal angles, rad.
const SAME: f64 = 1e-6;

impl Axis {
    /// Whether an angle in rad is within the limits of the axis.
    pub fn reaches(&self, angle: f64) -> bool {
        self.lower - SAME <= angle && angle <= self.upper + SAME
    }
}

/// A serial arm.
#[derive(Debug, Clone, PartialEq)]
pub struct Arm {
    /// Axes from the base.
    pub axes: Vec<Axis>,
    /// Pose of the tool point in the frame of the last axis.
    pub tool: Pose,
    /// Gravity in the frame of the base, m/s².
    pub gravity: Vector3<f64>,
}

/// The arm in one posture, in the frame of the base.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture {
    /// Poses of all links.
    pub links: Vec<Pose>,
    /// Unit vectors along the axes.
    pub axes: Vec<Vector3<f64>>,
    /// Pose of the tool point.
    pub tool: Pose,
}

impl Arm {
    /// Number of axes.
    pub fn count(&self) -> usize {
        self.axes.len()
    }

    /// Links and tool at joint angles in rad.
    pub fn posture(&self, angles: &[f64]) -> Posture {
        let mut links = Vec::with_capacity(self.count());
        let mut axes = Vec::with_capacity(self.count());
        let mut at = Pose::identity();
        for (axis, angle) in self.axes.iter().zip(angles) {
            at = at.then(&axis.place).turned(&axis.direction, *angle);
            axes.push(at.rotation * axis.direction.into_inner());
            links.push(at);
        }
        Posture { links, axes, tool: at.then(&self.tool) }
    }

    /// The arm with an additional body, given in the frame of the last axis.
    pub fn carrying(&self, payload: &Body) -> Arm {
        let mut arm = self.clone();
        if let Some(last) = arm.axes.last_mut() {
            last.link = last.link.with(payload);
        }
        arm
    }
}

impl Posture {
    /// Displacement (m) and rotation (rad) of the tool due to a small rotation (rad) of the axis about a point
    /// at the distance `offset` (m) along the axis from the origin of its link.
    pub fn moved_by(&self, axis: usize, turn: &Vector3<f64>, offset: f64) -> [Vector3<f64>; 2] {
        let pivot = self.links[axis].position + offset * self.axes[axis];
        [turn.cross(&(self.tool.position - pivot)), *turn]
    }

    /// Columns of the Jacobian: displacement (m) and rotation (rad) of the tool per rad of each axis.
    pub fn jacobian(&self) -> Vec<[Vector3<f64>; 2]> {
        (0..self.axes.len()).map(|axis| self.moved_by(axis, &self.axes[axis], 0.0)).collect()
    }
}
