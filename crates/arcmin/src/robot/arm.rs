//! A serial arm of turning axes: where its links and its tool are.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

/// Pose of a frame in another one: x ↦ R x + p.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// R, without unit.
    pub rotation: Matrix3<f64>,
    /// m.
    pub position: Vector3<f64>,
}

impl Pose {
    /// The frame itself: R = 1, p = 0.
    pub fn identity() -> Pose {
        Pose { rotation: Matrix3::identity(), position: Vector3::zeros() }
    }

    /// Position in m; roll, pitch and yaw in rad about the fixed axes x, y, z, in this order (as URDF has them).
    pub fn new(position: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> Pose {
        let rotation = Rotation3::from_euler_angles(roll, pitch, yaw).into_inner();
        Pose { rotation, position: Vector3::from(position) }
    }

    /// The frame `inner`, given in this one, in the frame that this one is given in.
    pub fn then(&self, inner: &Pose) -> Pose {
        Pose { rotation: self.rotation * inner.rotation, position: self.at(&inner.position) }
    }

    /// A point.
    pub fn at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.position + self.rotation * point
    }

    /// Turned about an axis of its own by an angle in rad.
    fn turned(&self, axis: &Unit<Vector3<f64>>, angle: f64) -> Pose {
        let turn = Rotation3::from_axis_angle(axis, angle).into_inner();
        Pose { rotation: self.rotation * turn, ..*self }
    }
}

/// Mass of a link, in the frame of its axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// kg.
    pub mass: f64,
    /// m.
    pub centre: Vector3<f64>,
    /// About the centre of mass, kg·m².
    pub inertia: Matrix3<f64>,
}

impl Body {
    /// A body without mass.
    pub fn none() -> Body {
        Body { mass: 0.0, centre: Vector3::zeros(), inertia: Matrix3::zeros() }
    }

    /// The body, given in a frame, seen from the frame in which that one has a pose.
    pub fn seen_from(&self, pose: &Pose) -> Body {
        let inertia = pose.rotation * self.inertia * pose.rotation.transpose();
        Body { mass: self.mass, centre: pose.at(&self.centre), inertia }
    }

    /// Both as one, by Steiner's theorem.
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

/// A turning axis and the link behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name of the joint in the URDF or the table.
    pub name: String,
    /// Of the axis at angle 0 in the frame of the axis before it, the first in that of the base.
    pub place: Pose,
    /// In its own frame.
    pub direction: Unit<Vector3<f64>>,
    /// Mass behind the axis up to the next one.
    pub link: Body,
    /// Least angle, rad.
    pub lower: f64,
    /// Largest angle, rad.
    pub upper: f64,
    /// Largest speed, rad/s; infinite where none is given.
    pub speed: f64,
    /// Largest torque, N·m; infinite where none is given.
    pub torque: f64,
}

/// Angles this near are one, rad.
const SAME: f64 = 1e-6;

impl Axis {
    /// Whether an angle in rad is within its limits.
    pub fn reaches(&self, angle: f64) -> bool {
        self.lower - SAME <= angle && angle <= self.upper + SAME
    }
}

/// A serial arm.
#[derive(Debug, Clone, PartialEq)]
pub struct Arm {
    /// Axes from the base.
    pub axes: Vec<Axis>,
    /// Of the tool point in the frame of the last axis.
    pub tool: Pose,
    /// In the frame of the base, m/s².
    pub gravity: Vector3<f64>,
}

/// The arm in one posture, in the frame of the base.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture {
    /// Of every link.
    pub links: Vec<Pose>,
    /// Unit vectors along the axes.
    pub axes: Vec<Vector3<f64>>,
    /// Of the tool point.
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

    /// The arm with another body in its hand, given in the frame of the last axis.
    pub fn carrying(&self, payload: &Body) -> Arm {
        let mut arm = self.clone();
        if let Some(last) = arm.axes.last_mut() {
            last.link = last.link.with(payload);
        }
        arm
    }
}

impl Posture {
    /// Displacement (m) and turn (rad) of the tool when the axis gives by a small turn (rad) about a point on it
    /// that lies `offset` (m) along the axis from the origin of its link.
    pub fn moved_by(&self, axis: usize, turn: &Vector3<f64>, offset: f64) -> [Vector3<f64>; 2] {
        let pivot = self.links[axis].position + offset * self.axes[axis];
        [turn.cross(&(self.tool.position - pivot)), *turn]
    }

    /// Columns of the Jacobian: displacement and turn of the tool per rad of each axis.
    pub fn jacobian(&self) -> Vec<[Vector3<f64>; 2]> {
        (0..self.axes.len()).map(|axis| self.moved_by(axis, &self.axes[axis], 0.0)).collect()
    }
}
