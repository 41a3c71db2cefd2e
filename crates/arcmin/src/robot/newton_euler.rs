//! Inverse dynamics by the recursive Newton–Euler equations (Luh, Walker, Paul 1980), in the frame of the base.
//!
//! Outwards: ω_k = ω_{k−1} + z_k q̇_k, α_k = α_{k−1} + z_k q̈_k + ω_{k−1} × z_k q̇_k, a_k = a_{k−1} + α_{k−1} × r_k +
//! ω_{k−1} × (ω_{k−1} × r_k) with a_0 = −g. Inwards: f_k = f_{k+1} + m_k a_ck, n_k = n_{k+1} + r_{k+1} × f_{k+1} +
//! c_k × m_k a_ck + I_k α_k + ω_k × I_k ω_k about the origin of link k; the torque of the axis is z_k · n_k.

use nalgebra::Vector3;

use super::arm::{Arm, Posture};

/// Load that the reducer of an axis transmits to its link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisLoad {
    /// About the axis on the link, N·m: positive drives positive motion.
    pub torque: f64,
    /// Force on the link in N, in the frame of the base.
    pub force: Vector3<f64>,
    /// Moment on the link about its origin in N·m, without the torque about the axis, in the frame of the
    /// base.
    pub moment: Vector3<f64>,
}

impl AxisLoad {
    /// Tilting moment about a point `offset` (m) along the axis `z` from the origin of the link, as a vector across
    /// the axis.
    pub fn tilting(&self, z: &Vector3<f64>, offset: f64) -> Vector3<f64> {
        let about = self.moment - (offset * z).cross(&self.force);
        about - about.dot(z) * z
    }

    /// Force along the axis in N, positive along it.
    pub fn axial(&self, z: &Vector3<f64>) -> f64 {
        self.force.dot(z)
    }

    /// Force across the axis in N.
    pub fn radial(&self, z: &Vector3<f64>) -> f64 {
        (self.force - self.axial(z) * z).norm()
    }
}

/// Loads of all axes at angles, speeds and accelerations in rad, rad/s and rad/s².
pub fn inverse_dynamics(
    arm: &Arm,
    posture: &Posture,
    speeds: &[f64],
    accelerations: &[f64],
) -> Vec<AxisLoad> {
    let count = arm.count();
    let (mut spin, mut turn, mut acceleration) = (Vector3::zeros(), Vector3::zeros(), -arm.gravity);
    let mut origin = Vector3::zeros();
    let mut inertial = Vec::with_capacity(count);
    for k in 0..count {
        let (link, z) = (&posture.links[k], posture.axes[k]);
        let r = link.position - origin;
        acceleration += turn.cross(&r) + spin.cross(&spin.cross(&r));
        turn += z * accelerations[k] + spin.cross(&(z * speeds[k]));
        spin += z * speeds[k];
        origin = link.position;
        let body = &arm.axes[k].link;
        let centre = link.rotation * body.centre;
        let force = body.mass * (acceleration + turn.cross(&centre) + spin.cross(&spin.cross(&centre)));
        let inertia = link.rotation * body.inertia * link.rotation.transpose();
        let moment = inertia * turn + spin.cross(&(inertia * spin)) + centre.cross(&force);
        inertial.push((force, moment));
    }
    let (mut force, mut moment, mut outer) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
    let mut loads = Vec::with_capacity(count);
    for k in (0..count).rev() {
        let origin = posture.links[k].position;
        moment += (outer - origin).cross(&force) + inertial[k].1;
        force += inertial[k].0;
        outer = origin;
        let torque = moment.dot(&posture.axes[k]);
        loads.push(AxisLoad { torque, force, moment: moment - torque * posture.axes[k] });
    }
    loads.reverse();
    loads
}

/// Loads at rest under gravity only.
pub fn holding_loads(arm: &Arm, angles: &[f64]) -> Vec<AxisLoad> {
    let still = vec![0.0; arm.count()];
    inverse_dynamics(arm, &arm.posture(angles), &still, &still)
}

#[cfg(test)]
mod tests {
    use super::super::arm::{Axis, Body, Pose};
    use super::*;
    use nalgebra::{DMatrix, DVector, Matrix3, Unit};

    fn axis(place: Pose, direction: [f64; 3], link: Body) -> Axis {
        Axis {
            name: String::new(),
            place,
            direction: Unit::new_normalize(Vector3::from(direction)),
            link,
            lower: -10.0,
            upper: 10.0,
            speed: f64::INFINITY,
            torque: f64::INFINITY,
        }
    }

    /// Two links in a vertical plane, x to the right, z up, axes along −y so that angles are positive upwards.
    fn two_links() -> Arm {
        let rod = |mass: f64, centre: f64, inertia: f64| Body {
            mass,
            centre: Vector3::new(centre, 0.0, 0.0),
            inertia: Matrix3::from_diagonal(&Vector3::new(0.01, inertia, inertia)),
        };
        Arm {
            axes: vec![
                axis(Pose::identity(), [0.0, -1.0, 0.0], rod(12.0, 0.4, 0.9)),
                axis(Pose::new([0.8, 0.0, 0.0], [0.0; 3]), [0.0, -1.0, 0.0], rod(7.0, 0.3, 0.4)),
            ],
            tool: Pose::new([0.6, 0.0, 0.0], [0.0; 3]),
            gravity: Vector3::new(0.0, 0.0, -9.81),
        }
    }

    fn torques(arm: &Arm, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
        inverse_dynamics(arm, &arm.posture(q), v, a).iter().map(|load| load.torque).collect()
    }

    /// Closed form of the planar two-link arm from Lagrange's equations.
    #[test]
    fn two_links_have_the_closed_form() {
        let arm = two_links();
        let (m1, m2, l1, c1, c2, i1, i2, g) = (12.0, 7.0, 0.8, 0.4, 0.3, 0.9, 0.4, 9.81);
        for (q, v, a) in [([0.3, -0.7], [1.1, -2.0], [3.0, 0.5]), ([2.0, 1.0], [-0.4, 0.9], [-1.0, 8.0])] {
            let (c, s) = (f64::cos(q[1]), f64::sin(q[1]));
            let m11 = i1 + i2 + m1 * c1 * c1 + m2 * (l1 * l1 + c2 * c2 + 2.0 * l1 * c2 * c);
            let m12 = i2 + m2 * (c2 * c2 + l1 * c2 * c);
            let m22 = i2 + m2 * c2 * c2;
            let h = m2 * l1 * c2 * s;
            let g2 = m2 * g * c2 * (q[0] + q[1]).cos();
            let g1 = (m1 * c1 + m2 * l1) * g * q[0].cos() + g2;
            let expected = [
                m11 * a[0] + m12 * a[1] - h * (2.0 * v[0] * v[1] + v[1] * v[1]) + g1,
                m12 * a[0] + m22 * a[1] + h * v[0] * v[0] + g2,
            ];
            let found = torques(&arm, &q, &v, &a);
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12 * expected.abs().max(1.0), "{found} {expected}");
            }
        }
    }

    /// A weight on a horizontal rod: torque m g c, and bearing loads computed by hand.
    #[test]
    fn loads_of_one_link_at_rest_are_those_of_its_weight() {
        let mut arm = two_links();
        arm.axes.truncate(1);
        let load = holding_loads(&arm, &[0.0])[0];
        assert!((load.torque - 12.0 * 9.81 * 0.4).abs() < 1e-12);
        assert!((load.force - Vector3::new(0.0, 0.0, 12.0 * 9.81)).norm() < 1e-12);
        // A mass outside of the plane tilts the bearing about x.
        arm.axes[0].link.centre.y = 0.1;
        let load = holding_loads(&arm, &[0.0])[0];
        let z = Vector3::new(0.0, -1.0, 0.0);
        assert!((load.tilting(&z, 0.0) - Vector3::new(0.1 * 12.0 * 9.81, 0.0, 0.0)).norm() < 1e-12);
        // About the plane of the mass the tilting moment is zero: 0.1 m along +y is −0.1 m along the axis.
        assert!(load.tilting(&z, -0.1).norm() < 1e-12);
        assert!(load.axial(&z).abs() < 1e-12 && (load.radial(&z) - 12.0 * 9.81).abs() < 1e-12);
    }

    /// A spatial arm with arbitrarily oriented frames.
    fn six_axes() -> Arm {
        let mut axes = Vec::new();
        for k in 0..6 {
            let x = |n: usize| (((k * 7 + n) * 2654435761) % 1000) as f64 / 1000.0 - 0.5;
            let turn = Pose::new([0.0; 3], [3.0 * x(1), 2.0 * x(2), 3.0 * x(3)]).rotation;
            let principal = Matrix3::from_diagonal(&Vector3::new(0.3, 0.4, 0.5));
            let link = Body {
                mass: 4.0 + 3.0 * x(4),
                centre: Vector3::new(x(5), x(6), x(7)),
                inertia: turn * principal * turn.transpose(),
            };
            let place = Pose::new([x(8), x(9), x(10)], [3.0 * x(11), 2.0 * x(12), 3.0 * x(13)]);
            axes.push(axis(place, [x(14), x(15), 0.6 + x(16)], link));
        }
        Arm { axes, tool: Pose::identity(), gravity: Vector3::new(1.0, -2.0, -9.0) }
    }

    /// Kinetic and potential energy from the postures alone: speeds by differences of positions and rotations.
    fn energies(arm: &Arm, q: &[f64], v: &[f64]) -> [f64; 2] {
        let step = 1e-5;
        let at = |s: f64| arm.posture(&q.iter().zip(v).map(|(q, v)| q + s * step * v).collect::<Vec<_>>());
        let (here, before, after) = (at(0.0), at(-1.0), at(1.0));
        let (mut kinetic, mut potential) = (0.0, 0.0);
        for (k, axis) in arm.axes.iter().enumerate() {
            let centre = |p: &Posture| p.links[k].at(&axis.link.centre);
            let speed = (centre(&after) - centre(&before)) / (2.0 * step);
            let turn = (after.links[k].rotation - before.links[k].rotation) / (2.0 * step)
                * here.links[k].rotation.transpose();
            let spin = Vector3::new(turn[(2, 1)], turn[(0, 2)], turn[(1, 0)]);
            let rotation = here.links[k].rotation;
            let inertia = rotation * axis.link.inertia * rotation.transpose();
            kinetic += 0.5 * axis.link.mass * speed.norm_squared() + 0.5 * spin.dot(&(inertia * spin));
            potential -= axis.link.mass * arm.gravity.dot(&centre(&here));
        }
        [kinetic, potential]
    }

    /// τ·q̇ is the rate of the energy.
    #[test]
    fn power_is_the_change_of_energy() {
        let arm = six_axes();
        let q = [0.3, -0.8, 1.2, 0.1, 2.0, -0.4];
        let v = [0.7, -1.1, 0.4, 2.0, -0.9, 1.5];
        let a = [2.0, 1.0, -3.0, 0.5, 4.0, -2.0];
        let power: f64 = torques(&arm, &q, &v, &a).iter().zip(&v).map(|(t, v)| t * v).sum();
        let at = |s: f64| -> f64 {
            let h = 1e-4 * s;
            let q: Vec<f64> = (0..6).map(|k| q[k] + h * v[k] + 0.5 * h * h * a[k]).collect();
            let v: Vec<f64> = (0..6).map(|k| v[k] + h * a[k]).collect();
            energies(&arm, &q, &v).iter().sum()
        };
        let growth = (at(1.0) - at(-1.0)) / 2e-4;
        assert!((growth / power - 1.0).abs() < 1e-6, "{growth} {power}");
    }

    /// Mass matrix, column by column from unit accelerations.
    fn mass_matrix(arm: &Arm, q: &[f64]) -> DMatrix<f64> {
        let count = arm.count();
        let weightless = Arm { gravity: Vector3::zeros(), ..arm.clone() };
        let still = vec![0.0; count];
        let columns: Vec<DVector<f64>> = (0..count)
            .map(|k| {
                let mut a = still.clone();
                a[k] = 1.0;
                DVector::from_vec(torques(&weightless, q, &still, &a))
            })
            .collect();
        DMatrix::from_columns(&columns)
    }

    /// M is symmetric and ½ q̇ᵀM q̇ the kinetic energy.
    #[test]
    fn the_mass_matrix_gives_the_kinetic_energy() {
        let arm = six_axes();
        let (q, v) = ([0.3, -0.8, 1.2, 0.1, 2.0, -0.4], [0.7, -1.1, 0.4, 2.0, -0.9, 1.5]);
        let m = mass_matrix(&arm, &q);
        assert!((&m - m.transpose()).norm() < 1e-12 * m.norm());
        let v = DVector::from_row_slice(&v);
        let half = 0.5 * v.dot(&(&m * &v));
        let kinetic = energies(&arm, &q, v.as_slice())[0];
        assert!((half / kinetic - 1.0).abs() < 1e-8, "{half} {kinetic}");
    }

    /// Free motion without torque conserves the energy: fourth-order Runge–Kutta with steps of 0.1 ms, whose
    /// own error is much smaller.
    #[test]
    fn a_swinging_arm_keeps_its_energy() {
        let arm = six_axes();
        let still = vec![0.0; 6];
        let acceleration = |q: &DVector<f64>, v: &DVector<f64>| -> DVector<f64> {
            let bias = DVector::from_vec(torques(&arm, q.as_slice(), v.as_slice(), &still));
            mass_matrix(&arm, q.as_slice()).cholesky().unwrap().solve(&-bias)
        };
        let energy = |q: &DVector<f64>, v: &DVector<f64>| -> f64 {
            let m = mass_matrix(&arm, q.as_slice());
            let posture = arm.posture(q.as_slice());
            let lift =
                |(axis, link): (&Axis, &Pose)| -axis.link.mass * arm.gravity.dot(&link.at(&axis.link.centre));
            0.5 * v.dot(&(m * v)) + arm.axes.iter().zip(&posture.links).map(lift).sum::<f64>()
        };
        let mut q = DVector::from_row_slice(&[0.3, -0.8, 1.2, 0.1, 2.0, -0.4]);
        let mut v = DVector::from_row_slice(&[0.7, -1.1, 0.4, 2.0, -0.9, 1.5]);
        let (first, h) = (energy(&q, &v), 1e-4);
        let kinetic = 0.5 * v.dot(&(mass_matrix(&arm, q.as_slice()) * &v));
        let mut worst = 0.0_f64;
        for _ in 0..5000 {
            let a1 = acceleration(&q, &v);
            let (q2, v2) = (&q + 0.5 * h * &v, &v + 0.5 * h * &a1);
            let a2 = acceleration(&q2, &v2);
            let (q3, v3) = (&q + 0.5 * h * &v2, &v + 0.5 * h * &a2);
            let a3 = acceleration(&q3, &v3);
            let (q4, v4) = (&q + h * &v3, &v + h * &a3);
            let a4 = acceleration(&q4, &v4);
            q += h / 6.0 * (&v + 2.0 * &v2 + 2.0 * &v3 + &v4);
            v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
            worst = worst.max((energy(&q, &v) - first).abs() / kinetic);
        }
        println!("energy of a swing of 0.5 s is kept within {worst:.1e} of its first kinetic energy");
        assert!(worst < 1e-8, "{worst:e}");
    }

    /// Columns of the Jacobian agree with differences of postures.
    #[test]
    fn the_jacobian_is_the_derivative_of_the_posture() {
        let arm = six_axes();
        let q = [0.3, -0.8, 1.2, 0.1, 2.0, -0.4];
        let jacobian = arm.posture(&q).jacobian();
        for k in 0..6 {
            let at = |s: f64| {
                let mut q = q;
                q[k] += s * 1e-6;
                arm.posture(&q).tool
            };
            let slope = (at(1.0).position - at(-1.0).position) / 2e-6;
            assert!((slope - jacobian[k][0]).norm() < 1e-8);
        }
    }
}
