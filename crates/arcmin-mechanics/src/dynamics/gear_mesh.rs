use crate::geometry::{Vec2, quarter_turn, unit};
use crate::machine::{Kinematics, Machine};

/// Involute mesh of sun and one planet.
///
/// On the flank s = ±1 the overlap of the teeth is e_s = s (r_b1 θ_s + r_b2 θ_p − (r_b1 + r_b2)(ψ − γ)) −
/// (r_b1 + r_b2)(inv α' − inv α) − j/2 − h_s, where ψ is the direction and D the distance of the centres, cos α' =
/// (r_b1 + r_b2)/D, γ the planet's angle on the carrier, j the backlash and h_s the wear depth of that side.
/// Its gradient is the unit normal of the contact; therefore a displacement of the planet in its bearings
/// changes the mesh, and a small centre distance loads both flanks. Planets on a rigid carrier have rotations
/// only: then ψ − γ is the carrier's angle θ_c, D is constant, and e_s = s (r_b1 (θ_s − θ_c) + r_b2 (θ_p −
/// θ_c)) − j/2 − h_s.
///
/// Either side is a spring U = ½ k(σ) e² with k = k₀ (1 + ε cos z_1 (σ + γ)) over the mesh phase σ = θ_s − θ_c,
/// in parallel with a damper c(e) ė. The coefficient c rises with the overlap; the force is never tensile as
/// long as teeth can separate.
#[derive(Debug, Clone, PartialEq)]
pub struct GearMesh {
    pub sun_base_radius: f64,
    pub planet_base_radius: f64,
    /// Stiffness in N/m, with the torsion of the shaft in series.
    pub stiffness: f64,
    variation: f64,
    pub damping: f64,
    pub half_backlash: f64,
    /// Whether teeth can separate. Without backlash on centres that only move on circles they cannot: as one
    /// flank loses contact, the other gains it, and the damper acts fully in both directions.
    parts: bool,
    /// Wear depth along the line of action of the teeth of either side, m: the side on which the sun drives
    /// counter-clockwise, and the other.
    pub flank_loss: [f64; 2],
    sun_teeth: f64,
    /// γ of this planet in rad.
    place: f64,
    nominal_involute: f64,
    /// Run-out of the planet: distance (m) and direction (rad) of the centre of its base circle from its axis
    /// of rotation.
    pub planet_run_out: (f64, f64),
    pub sun_run_out: (f64, f64),
}

/// Coordinates of a mesh in the order (x_s, y_s, θ_s, x_p, y_p, θ_p, θ_c).
pub const MESH_COORDINATES: usize = 7;
type Row = [f64; MESH_COORDINATES];

/// Energy of meshes with gradient and Hessian over N coordinates, and their damping.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshState<const N: usize> {
    pub stored: f64,
    pub gradient: [f64; N],
    pub hessian: [[f64; N]; N],
    /// Generalised damping forces, and −∂/∂q̇ and −∂/∂q of them.
    pub damping_force: [f64; N],
    pub damping: [[f64; N]; N],
    pub damping_slope: [[f64; N]; N],
    pub dissipation: f64,
    /// Force on the line of action in N, positive where the sun's tooth drives.
    pub force: f64,
    /// ∂/∂q of its elastic part.
    pub elastic_slope: [f64; N],
    /// Magnitudes of the elastic forces on either side, as in [`GearMesh::flank_loss`], in N.
    pub side_force: [f64; 2],
}

impl<const N: usize> Default for MeshState<N> {
    fn default() -> Self {
        MeshState {
            stored: 0.0,
            gradient: [0.0; N],
            hessian: [[0.0; N]; N],
            damping_force: [0.0; N],
            damping: [[0.0; N]; N],
            damping_slope: [[0.0; N]; N],
            dissipation: 0.0,
            force: 0.0,
            elastic_slope: [0.0; N],
            side_force: [0.0; 2],
        }
    }
}

impl<const N: usize> MeshState<N> {
    /// Elastic force on the line of action in N, positive where the sun's tooth drives.
    pub fn elastic_force(&self) -> f64 {
        self.side_force[0] - self.side_force[1]
    }
}

/// Overlap of the teeth of one side: e in m with ∂e/∂q and ∂²e/∂q² = diag(arm) − turning across acrossᵀ, and
/// the mesh phase σ + γ in rad with ∂σ/∂q.
struct Overlap<const N: usize> {
    side: usize,
    depth: f64,
    slope: [f64; N],
    arm: [f64; N],
    across: [f64; N],
    turning: f64,
    phase: f64,
    phase_slope: [f64; N],
}

/// The side on which the sun drives counter-clockwise, and the other.
const SIDES: [f64; 2] = [1.0, -1.0];

/// Relative position of the centres of sun and planet.
struct Centres {
    /// Run-outs of their base circles in m.
    planet_arm: Vec2,
    sun_arm: Vec2,
    distance: f64,
    /// Unit vector from sun to planet, and the same rotated by 90°.
    radial: Vec2,
    tangential: Vec2,
    /// Cosine and sine of the working pressure angle.
    cos: f64,
    sin: f64,
    /// inv α'.
    involute: f64,
    /// r_b1 θ_s + r_b2 θ_p − (r_b1 + r_b2)(ψ − γ) in m.
    twist: f64,
}

impl Centres {
    /// Normal of the flank of the planet.
    fn normal(&self, side: f64) -> Vec2 {
        side * self.cos * self.tangential + self.sin * self.radial
    }

    /// Displacement of the planet relative to the sun in a direction, by coordinate.
    fn along(&self, direction: Vec2) -> Row {
        let turn = |arm: Vec2| direction.dot(&quarter_turn(arm));
        [
            -direction.x,
            -direction.y,
            -turn(self.sun_arm),
            direction.x,
            direction.y,
            turn(self.planet_arm),
            0.0,
        ]
    }
}

/// Overlap in m at which the damping coefficient is fully effective.
const DAMPING_RAMP: f64 = 1e-6;

impl GearMesh {
    /// `torsion` is the torsional stiffness of the shaft behind the planet in N·m/rad.
    pub fn new(machine: &Machine, crankshaft: usize, torsion: f64) -> GearMesh {
        let stage = &machine.gear_stage;
        let (r1, r2) = (stage.sun_base_radius(), stage.planet_base_radius());
        let alpha = stage.pressure_angle;
        GearMesh {
            sun_base_radius: r1,
            planet_base_radius: r2,
            stiffness: 1.0 / (1.0 / stage.mesh_stiffness + r2 * r2 / torsion),
            variation: stage.mesh_stiffness_variation,
            damping: stage.mesh_damping,
            half_backlash: 0.5 * stage.backlash,
            parts: true,
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

    /// A mesh on a rigid carrier, with a rigid shaft.
    pub fn turning(machine: &Machine, crankshaft: usize) -> GearMesh {
        let parts = machine.gear_stage.backlash > 0.0;
        GearMesh { parts, ..GearMesh::new(machine, crankshaft, f64::INFINITY) }
    }

    /// Relative position of the centres; `None` where base circles overlap, so that no involute mesh exists.
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
        // ψ − γ, without the discontinuities of atan2.
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
        let mut slope = centres.along(-centres.normal(side));
        slope[2] += side * self.sun_base_radius;
        slope[5] += side * self.planet_base_radius;
        slope
    }

    /// e_s and its gradient for both sides; `None` where base circles overlap.
    pub fn overlaps(&self, q: &Row) -> Option<[(f64, Row); 2]> {
        let centres = self.centres(q)?;
        let of = |number: usize| (self.overlap_of(&centres, number), self.slope(&centres, SIDES[number]));
        Some([of(0), of(1)])
    }

    /// Overlap of the teeth of either side without backlash and wear, in m: for the nominal mechanism the
    /// effect of run-outs.
    pub fn made_overlap(&self, q: &Row) -> Option<[f64; 2]> {
        let centres = self.centres(q)?;
        let made = |side: usize| self.overlap_of(&centres, side) + self.half_backlash + self.flank_loss[side];
        Some([made(0), made(1)])
    }

    /// k in N/m, k' and k'' at the mesh phase σ + γ.
    fn stiffness_by_phase(&self, phase: f64) -> [f64; 3] {
        if self.variation == 0.0 {
            return [self.stiffness, 0.0, 0.0];
        }
        let (sin, cos) = (self.sun_teeth * phase).sin_cos();
        let amplitude = self.stiffness * self.variation;
        [
            self.stiffness + amplitude * cos,
            -amplitude * self.sun_teeth * sin,
            -amplitude * self.sun_teeth * self.sun_teeth * cos,
        ]
    }

    /// Mesh stiffness in N/m at the present mesh phase.
    pub fn stiffness_at(&self, q: &Row) -> f64 {
        self.stiffness_by_phase(q[2] - q[6] + self.place)[0]
    }

    /// Sun and planet with movable centres; the energy is NaN where base circles overlap.
    pub fn react(&self, q: &Row, v: &Row) -> MeshState<MESH_COORDINATES> {
        let mut state = MeshState::default();
        let Some(centres) = self.centres(q) else {
            // The Newton step of the caller was too large; it is rejected by its residual.
            state.stored = f64::NAN;
            return state;
        };
        for (number, side) in SIDES.into_iter().enumerate() {
            let normal = centres.normal(side);
            let mut arm = [0.0; MESH_COORDINATES];
            (arm[2], arm[5]) = (-normal.dot(&centres.sun_arm), normal.dot(&centres.planet_arm));
            let overlap = Overlap {
                side: number,
                depth: self.overlap_of(&centres, number),
                slope: self.slope(&centres, side),
                arm,
                across: centres.along(quarter_turn(normal)),
                // Derivative of the normal by the displacement of the planet across it.
                turning: 1.0 / (centres.distance * centres.sin),
                phase: q[2] - q[6] + self.place,
                phase_slope: [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0],
            };
            self.press(&overlap, v, &mut state);
        }
        state
    }

    /// Adds a sun and a planet on a rigid carrier: coordinates (θ_s, θ_c, θ_p).
    pub fn turn(&self, q: &[f64; 3], v: &[f64; 3], state: &mut MeshState<3>) {
        let (r1, r2) = (self.sun_base_radius, self.planet_base_radius);
        for (number, side) in SIDES.into_iter().enumerate() {
            let twist = r1 * (q[0] - q[1]) + r2 * (q[2] - q[1]);
            let overlap = Overlap {
                side: number,
                depth: side * twist - self.half_backlash - self.flank_loss[number],
                slope: [side * r1, -side * (r1 + r2), side * r2],
                arm: [0.0; 3],
                across: [0.0; 3],
                turning: 0.0,
                phase: q[0] - q[1] + self.place,
                phase_slope: [1.0, -1.0, 0.0],
            };
            self.press(&overlap, v, state);
        }
    }

    /// Adds the force of the teeth of one side.
    fn press<const N: usize>(&self, overlap: &Overlap<N>, v: &[f64; N], state: &mut MeshState<N>) {
        let Overlap { side, depth, ref slope, ref arm, ref across, turning, phase, phase_slope: ref sigma } =
            *overlap;
        if depth <= 0.0 {
            return;
        }
        let [k, k1, k2] = self.stiffness_by_phase(phase);
        let elastic = k * depth;
        let half_square = 0.5 * depth * depth;
        state.stored += 0.5 * elastic * depth;
        let x = if self.parts { (depth / DAMPING_RAMP).min(1.0) } else { 1.0 };
        let c = self.damping * x * x * (3.0 - 2.0 * x);
        let along = |row: &[f64; N]| row.iter().zip(v).map(|(w, v)| w * v).sum::<f64>();
        let rate = along(slope);
        if self.parts && elastic + c * rate <= 0.0 {
            // The teeth separate faster than they spring back: no force, because the damping force must not be
            // tensile, and their elastic energy is dissipated. It still depends on the mesh phase.
            state.dissipation -= elastic * rate;
            for i in 0..N {
                state.gradient[i] += k1 * half_square * sigma[i];
                for j in 0..N {
                    state.hessian[i][j] += sigma[i] * (k1 * depth * slope[j] + k2 * half_square * sigma[j]);
                }
            }
            return;
        }
        state.force += SIDES[side] * (elastic + c * rate);
        state.side_force[side] += elastic;
        for i in 0..N {
            state.gradient[i] += elastic * slope[i] + k1 * half_square * sigma[i];
            state.elastic_slope[i] += SIDES[side] * (k * slope[i] + k1 * depth * sigma[i]);
            state.hessian[i][i] += elastic * arm[i];
            for j in 0..N {
                state.hessian[i][j] += k * slope[i] * slope[j] - elastic * turning * across[i] * across[j]
                    + k1 * depth * (slope[i] * sigma[j] + sigma[i] * slope[j])
                    + k2 * half_square * sigma[i] * sigma[j];
            }
        }
        if !(c > 0.0) {
            return;
        }
        let (steepness, turned) =
            (6.0 * self.damping * x * (1.0 - x) / DAMPING_RAMP, turning * along(across));
        for i in 0..N {
            state.damping_force[i] -= c * rate * slope[i];
            state.damping_slope[i][i] += c * rate * arm[i];
            for j in 0..N {
                state.damping[i][j] += c * slope[i] * slope[j];
                let rate_slope = arm[j] * v[j] - turned * across[j];
                state.damping_slope[i][j] += slope[i] * (steepness * rate * slope[j] + c * rate_slope)
                    - c * rate * turning * across[i] * across[j];
            }
        }
        state.dissipation += c * rate * rate;
    }
}

#[cfg(test)]
mod tests;
