use crate::geometry::{Vec2, quarter_turn, unit};
use crate::machine::{Kinematics, Machine};

/// One involute mesh of sun and planet whose centres may move.
///
/// On the flank s = ±1 the teeth overlap by e_s = s (r_b1 θ_s + r_b2 θ_p − (r_b1 + r_b2)(ψ − γ)) − (r_b1 +
/// r_b2)(inv α' − inv α) − j/2 − h_s, where ψ is the direction and D the distance of the centres, cos α' =
/// (r_b1 + r_b2)/D, γ the planet's place on the carrier, j the backlash and h_s what that side has worn. Its
/// gradient is the unit normal of the contact, so a planet that moves in its bearings changes the mesh, and
/// teeth pressed together wedge on both flanks.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanarMesh {
    pub sun_base_radius: f64,
    pub planet_base_radius: f64,
    /// N/m, shaft torsion in series.
    pub stiffness: f64,
    variation: f64,
    pub damping: f64,
    pub half_backlash: f64,
    /// Metal lost along the line of action by the teeth of either side, m: where the sun drives
    /// counter-clockwise, and the other.
    pub flank_loss: [f64; 2],
    sun_teeth: f64,
    /// γ of this planet in rad.
    place: f64,
    nominal_involute: f64,
    /// Run-out of the planet: the centre of its base circle lies at this distance (m) and angle (rad) from
    /// its axis of rotation.
    pub planet_run_out: (f64, f64),
    pub sun_run_out: (f64, f64),
}

/// Coordinates of a mesh in the order (x_s, y_s, θ_s, x_p, y_p, θ_p, θ_c).
pub const MESH_COORDINATES: usize = 7;
type Row = [f64; MESH_COORDINATES];

/// Energy of one mesh with gradient and Hessian, and its damping.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MeshState {
    pub stored: f64,
    pub gradient: Row,
    pub hessian: [Row; MESH_COORDINATES],
    /// Generalised damping forces and −∂/∂q̇ of them.
    pub damping_force: Row,
    pub damping: [Row; MESH_COORDINATES],
    pub dissipation: f64,
    /// Elastic force on the line of action in N, positive where the sun's tooth drives.
    pub force: f64,
    /// ∂(force)/∂q.
    pub force_slope: Row,
    /// Sizes of the elastic forces on either side, as in [`PlanarMesh::flank_loss`], in N.
    pub side_force: [f64; 2],
}

/// The flanks on which the sun drives counter-clockwise, and the others.
const SIDES: [f64; 2] = [1.0, -1.0];

/// How sun and planet stand to each other.
struct Centres {
    /// Run-outs of their base circles in m.
    planet_arm: Vec2,
    sun_arm: Vec2,
    distance: f64,
    /// From sun to planet, and a quarter turn on.
    radial: Vec2,
    tangential: Vec2,
    /// Of the pressure angle as they run.
    cos: f64,
    sin: f64,
    /// inv α'.
    involute: f64,
    /// r_b1 θ_s + r_b2 θ_p − (r_b1 + r_b2)(ψ − γ) in m.
    twist: f64,
}

impl Centres {
    /// Of the flank of the planet.
    fn normal(&self, side: f64) -> Vec2 {
        side * self.cos * self.tangential + self.sin * self.radial
    }
}

/// Depth in m over which the damping sets in.
const DAMPING_RAMP: f64 = 1e-6;

impl PlanarMesh {
    /// `torsion` is the torsional stiffness of the shaft behind the planet in N·m/rad, `scale` multiplies the
    /// shaft only.
    pub fn new(machine: &Machine, crankshaft: usize, torsion: f64) -> PlanarMesh {
        let stage = &machine.gear_stage;
        let (r1, r2) = (stage.sun_base_radius(), stage.planet_base_radius());
        let alpha = stage.pressure_angle;
        PlanarMesh {
            sun_base_radius: r1,
            planet_base_radius: r2,
            stiffness: 1.0 / (1.0 / stage.mesh_stiffness + r2 * r2 / torsion),
            variation: stage.mesh_stiffness_variation,
            damping: stage.mesh_damping,
            half_backlash: 0.5 * stage.backlash,
            flank_loss: [0.0; 2],
            sun_teeth: stage.sun_teeth as f64,
            place: Kinematics::crankshaft_angle(
                machine.crankshafts.first_angle,
                crankshaft,
                machine.crankshafts.count,
            ),
            nominal_involute: alpha.tan() - alpha,
            planet_run_out: (0.0, 0.0),
            sun_run_out: (0.0, 0.0),
        }
    }

    /// By how much the teeth of either side would overlap without backlash and wear: in the nominal place,
    /// what run-outs make of it. m.
    pub fn overlap(&self, q: &Row) -> [f64; 2] {
        let base = self.sun_base_radius + self.planet_base_radius;
        let arm = |(amplitude, phase): (f64, f64), turn: f64| amplitude * unit(turn + phase);
        let d = Vec2::new(q[3] - q[0], q[4] - q[1]) + arm(self.planet_run_out, q[5])
            - arm(self.sun_run_out, q[2]);
        let reference = unit(q[6] + self.place);
        let turn = (reference.x * d.y - reference.y * d.x).atan2(reference.dot(&d));
        let pressure_angle = (base / d.norm()).min(1.0).acos();
        let twist = self.sun_base_radius * q[2] + self.planet_base_radius * q[5] - base * (q[6] + turn);
        let closer = base * (pressure_angle.tan() - pressure_angle - self.nominal_involute);
        [twist - closer, -twist - closer]
    }

    /// How the centres stand to each other; `None` where base circles overlap, so that no involute mesh exists.
    fn centres(&self, q: &Row) -> Option<Centres> {
        let base = self.sun_base_radius + self.planet_base_radius;
        let planet_arm = self.planet_run_out.0 * unit(q[5] + self.planet_run_out.1);
        let sun_arm = self.sun_run_out.0 * unit(q[2] + self.sun_run_out.1);
        let d = Vec2::new(q[3] - q[0], q[4] - q[1]) + planet_arm - sun_arm;
        let distance = d.norm();
        if !(distance > base) {
            return None;
        }
        let radial = d / distance;
        let tangential = quarter_turn(radial);
        let reference = unit(q[6] + self.place);
        let turn = (reference.x * d.y - reference.y * d.x).atan2(reference.dot(&d));
        // ψ − γ, without the jumps of atan2.
        let psi = q[6] + turn;
        let (cos, sin) = (base / distance, (1.0 - (base / distance).powi(2)).sqrt());
        let involute = sin / cos - sin.atan2(cos);
        let twist = self.sun_base_radius * q[2] + self.planet_base_radius * q[5] - base * psi;
        Some(Centres { planet_arm, sun_arm, distance, radial, tangential, cos, sin, involute, twist })
    }

    /// e_s of one of the two sides.
    fn overlap_of(&self, centres: &Centres, number: usize) -> f64 {
        let base = self.sun_base_radius + self.planet_base_radius;
        SIDES[number] * centres.twist
            - base * (centres.involute - self.nominal_involute)
            - self.half_backlash
            - self.flank_loss[number]
    }

    /// ∂e_s/∂q.
    fn slope(&self, centres: &Centres, side: f64) -> Row {
        let normal = centres.normal(side);
        [
            normal.x,
            normal.y,
            side * self.sun_base_radius + normal.dot(&quarter_turn(centres.sun_arm)),
            -normal.x,
            -normal.y,
            side * self.planet_base_radius - normal.dot(&quarter_turn(centres.planet_arm)),
            0.0,
        ]
    }

    /// e_s and its gradient for both sides; `None` where base circles overlap.
    pub fn overlaps(&self, q: &Row) -> Option<[(f64, Row); 2]> {
        let centres = self.centres(q)?;
        let of = |number: usize| (self.overlap_of(&centres, number), self.slope(&centres, SIDES[number]));
        Some([of(0), of(1)])
    }

    /// Mesh stiffness in N/m where the teeth stand.
    pub fn stiffness_at(&self, q: &Row) -> f64 {
        let phase = self.sun_teeth * (q[2] - q[6] + self.place);
        self.stiffness * (1.0 + self.variation * phase.cos())
    }

    pub fn react(&self, q: &Row, v: &Row) -> MeshState {
        let mut state = MeshState::default();
        let Some(centres) = self.centres(q) else {
            // The caller's Newton step was absurd and is refused by its residual.
            state.stored = f64::NAN;
            return state;
        };
        let Centres { planet_arm, sun_arm, distance, radial, tangential, cos, sin, .. } = centres;
        let phase = self.sun_teeth * (q[2] - q[6] + self.place);
        let k = self.stiffness * (1.0 + self.variation * phase.cos());
        let k1 = -self.stiffness * self.variation * self.sun_teeth * phase.sin();
        let k2 = -self.stiffness * self.variation * self.sun_teeth.powi(2) * phase.cos();
        for (number, side) in SIDES.into_iter().enumerate() {
            let overlap = self.overlap_of(&centres, number);
            if overlap <= 0.0 {
                continue;
            }
            let normal = centres.normal(side);
            let across = quarter_turn(normal);
            // Turning of the normal per displacement of the planet.
            let turning = tangential / distance - side * cos / (distance * sin) * radial;
            let slope = self.slope(&centres, side);
            // Motion of d per coordinate.
            let (ps, pp) = (quarter_turn(sun_arm), quarter_turn(planet_arm));
            let motion: [Vec2; MESH_COORDINATES] = [
                Vec2::new(-1.0, 0.0),
                Vec2::new(0.0, -1.0),
                -ps,
                Vec2::new(1.0, 0.0),
                Vec2::new(0.0, 1.0),
                pp,
                Vec2::zeros(),
            ];
            let elastic = k * overlap;
            state.stored += 0.5 * k * overlap * overlap;
            let x = (overlap / DAMPING_RAMP).min(1.0);
            let c = self.damping * x * x * (3.0 - 2.0 * x);
            let rate: f64 = slope.iter().zip(v).map(|(s, v)| s * v).sum();
            if elastic + c * rate <= 0.0 {
                // Teeth part faster than they spring back: no force, for damping must not pull, and the
                // energy they held is lost.
                state.dissipation -= elastic * rate;
                continue;
            }
            state.force += side * elastic;
            state.side_force[number] = elastic;
            let sigma: Row = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0];
            let half_square = 0.5 * overlap * overlap;
            for i in 0..MESH_COORDINATES {
                state.gradient[i] += elastic * slope[i] + k1 * half_square * sigma[i];
                state.force_slope[i] += side * (k * slope[i] + k1 * overlap * sigma[i]);
                for j in 0..MESH_COORDINATES {
                    state.hessian[i][j] += k * slope[i] * slope[j]
                        - elastic * across.dot(&motion[i]) * turning.dot(&motion[j])
                        + k1 * overlap * (slope[i] * sigma[j] + sigma[i] * slope[j])
                        + k2 * half_square * sigma[i] * sigma[j];
                }
            }
            state.hessian[2][2] += elastic * -normal.dot(&sun_arm);
            state.hessian[5][5] += elastic * normal.dot(&planet_arm);
            for i in 0..MESH_COORDINATES {
                state.damping_force[i] -= c * rate * slope[i];
                for j in 0..MESH_COORDINATES {
                    state.damping[i][j] += c * slope[i] * slope[j];
                }
            }
            state.dissipation += c * rate * rate;
        }
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> (PlanarMesh, Row) {
        let mut machine = crate::templates::tao2024();
        machine.gear_stage.mesh_stiffness_variation = 0.1;
        let mut mesh = PlanarMesh::new(&machine, 1, 1e5);
        mesh.planet_run_out = (20e-6, 0.4);
        mesh.sun_run_out = (10e-6, 1.1);
        let carrier = 0.3;
        let place = 0.0405 * unit(carrier + mesh.place);
        (
            mesh,
            [
                1e-6,
                -2e-6,
                0.9,
                place.x + 3e-6,
                place.y - 1e-6,
                carrier - 0.5 * (0.9 - carrier) + 3e-3,
                carrier,
            ],
        )
    }

    #[test]
    fn gradient_and_hessian_derive_from_the_energy() {
        let (mesh, q) = state();
        let rest = [0.0; MESH_COORDINATES];
        let here = mesh.react(&q, &rest);
        assert!(here.force > 100.0, "{}", here.force);
        let stiffness = mesh.stiffness;
        for i in 0..MESH_COORDINATES {
            let h = if [2, 5, 6].contains(&i) { 1e-8 } else { 1e-10 };
            let shifted = |s: f64| {
                let mut y = q;
                y[i] += s * h;
                mesh.react(&y, &rest)
            };
            let (up, down) = (shifted(1.0), shifted(-1.0));
            let slope = (up.stored - down.stored) / (2.0 * h);
            assert!(
                (slope - here.gradient[i]).abs() < 1e-5 * here.force,
                "{i}: {slope} {}",
                here.gradient[i]
            );
            let slope = (up.force - down.force) / (2.0 * h);
            assert!((slope - here.force_slope[i]).abs() < 1e-4 * stiffness, "{i}: {slope}");
            for j in 0..MESH_COORDINATES {
                let slope = (up.gradient[j] - down.gradient[j]) / (2.0 * h);
                let size = (here.hessian[i][i] * here.hessian[j][j]).abs().sqrt().max(1.0);
                assert!(
                    (slope - here.hessian[i][j]).abs() < 1e-4 * size,
                    "{i} {j}: {slope} {}",
                    here.hessian[i][j]
                );
            }
        }
    }

    /// A carrier that turns with fixed sun and planet angles closes the mesh by (r_b1 + r_b2) per radian, and
    /// pulling the centres apart by dD opens it by sin α dD.
    #[test]
    fn centre_distance_opens_the_mesh() {
        let machine = crate::templates::tao2024();
        let mesh = PlanarMesh::new(&machine, 0, 1e30);
        let rest = [0.0; MESH_COORDINATES];
        let force = |extra: f64, twist: f64| {
            let place = (0.0405 + extra) * unit(mesh.place);
            mesh.react(&[0.0, 0.0, twist / mesh.sun_base_radius, place.x, place.y, 0.0, 0.0], &rest).force
        };
        let k = 2e8;
        assert!((force(0.0, 2e-6) - k * 2e-6).abs() < 1e-3);
        let alpha = machine.gear_stage.pressure_angle;
        assert!((force(1e-7, 2e-6) - k * (2e-6 - alpha.sin() * 1e-7)).abs() < 1e-2);
        assert!((force(0.0, -2e-6) + k * 2e-6).abs() < 1e-3);
    }
}
