//! All springs of the model except the pins, each handed to a [`Sink`].

use super::assembly::{Element, Part, Sink};
use super::elastic::{BoreMode, WithModes};
use super::planar_mesh::{MESH_COORDINATES, MeshState};
use super::{BearingJoints, BearingState, RadialBearing};
use crate::geometry::{Vec2, quarter_turn};

/// A bearing between a shaft that carries `arm` (m) around and a body whose bore is at `bore` from its
/// centre.
struct Journal<'a> {
    part: Part,
    law: &'a RadialBearing,
    state: BearingState,
    /// (x, y, θ) of the shaft, (x, y, θ) of the body.
    index: [usize; 6],
    arm: Vec2,
    bore: Vec2,
    /// Modes of the body that move its bore.
    modes: &'a [BoreMode],
}

impl BearingJoints {
    /// Visits all springs, dampers and frictions but those of the pins. `q` and `v` include a prescribed sun
    /// as their last entry.
    pub(super) fn visit(&self, q: &[f64], v: &[f64], sink: &mut impl Sink) {
        for k in 0..self.layout.cranks {
            self.visit_crankshaft(k, q, v, sink);
        }
        self.visit_supports(q, v, sink);
    }

    fn visit_crankshaft(&self, k: usize, q: &[f64], v: &[f64], sink: &mut impl Sink) {
        let layout = &self.layout;
        let turn = layout.crank_angle(k);
        let [cx, cy, carrier] = layout.carrier();
        for end in 0..2 {
            let at = layout.support(k, end);
            let (u, cage) = self.support_state(k, end, q);
            let law = &self.supports[k];
            let journal = Journal {
                part: Part::CrankSupport,
                law,
                state: law.react(u, cage),
                index: [at, at + 1, turn, cx, cy, carrier],
                arm: self.journals[k].at(q[turn]),
                bore: self.carrier_bores[k].at(q[carrier]),
                modes: &[],
            };
            self.add_journal(&journal, v, sink);
        }
        for j in 0..layout.discs {
            let (at, disc) = (layout.disc_station(k, j), layout.disc(j));
            let (u, cage) = self.turning_arm_state(k, j, q);
            let law = &self.turning_arms[k][j];
            let modes: Vec<BoreMode> = self.bore_modes(k, j, q[disc + 2]).collect();
            let journal = Journal {
                part: Part::TurningArm,
                law,
                state: law.react(u, cage),
                index: [at, at + 1, turn, disc, disc + 1, disc + 2],
                arm: self.eccentrics[k][j].at(q[turn]),
                bore: self.bore_at(k, j, q),
                modes: &modes,
            };
            self.add_journal(&journal, v, sink);
        }
        self.add_bending(k, q, v, sink);
        self.add_mesh(k, q, v, sink);
    }

    fn add_journal(&self, journal: &Journal<'_>, v: &[f64], sink: &mut impl Sink) {
        let BearingState { stored, gradient, hessian, .. } = journal.state;
        if stored == 0.0 {
            return;
        }
        let mut sink = WithModes { sink, modes: journal.modes };
        let (a, b) = (quarter_turn(journal.arm), quarter_turn(journal.bore));
        let w = journal.law.inner_share;
        // Rows u_x, u_y, ψ.
        let jacobian = [
            [1.0, 0.0, a.x, -1.0, 0.0, -b.x],
            [0.0, 1.0, a.y, 0.0, -1.0, -b.y],
            [0.0, 0.0, w, 0.0, 0.0, 1.0 - w],
        ];
        let mut slope = [0.0; 6];
        let mut matrix = [0.0; 36];
        let mut damping = [0.0; 36];
        for i in 0..6 {
            let mut column = [0.0; 3];
            for c in 0..3 {
                slope[i] += gradient[c] * jacobian[c][i];
                column[c] = (0..3).map(|d| hessian[c][d] * jacobian[d][i]).sum();
            }
            for j in 0..6 {
                matrix[j * 6 + i] =
                    jacobian[0][j] * column[0] + jacobian[1][j] * column[1] + jacobian[2][j] * column[2];
            }
        }
        matrix[2 * 6 + 2] -= gradient[0] * journal.arm.x + gradient[1] * journal.arm.y;
        matrix[5 * 6 + 5] += gradient[0] * journal.bore.x + gradient[1] * journal.bore.y;
        sink.element(&Element {
            part: journal.part,
            index: &journal.index,
            gradient: &slope,
            hessian: &matrix,
            stored,
        });
        let mut rate = journal.index.map(|i| v[i]);
        for (mode, by) in journal.modes {
            rate[3] += v[*mode] * by.x;
            rate[4] += v[*mode] * by.y;
        }
        let mut force = [0.0; 6];
        let mut dissipation = 0.0;
        if self.loss_time > 0.0 {
            let spread = |row: usize| jacobian[row].iter().zip(&rate).map(|(j, v)| j * v).sum::<f64>();
            let u = [spread(0), spread(1)];
            for i in 0..6 {
                let pull = [0, 1].map(|c| {
                    self.loss_time * (hessian[c][0] * jacobian[0][i] + hessian[c][1] * jacobian[1][i])
                });
                force[i] -= pull[0] * u[0] + pull[1] * u[1];
                for j in 0..6 {
                    damping[i * 6 + j] += pull[0] * jacobian[0][j] + pull[1] * jacobian[1][j];
                }
            }
            for c in 0..2 {
                dissipation += self.loss_time * u[c] * (hessian[c][0] * u[0] + hessian[c][1] * u[1]);
            }
        }
        if self.friction.bearing > 0.0 {
            // Rolling friction: μ F r_m against the relative turn. The torque's change with the load is left
            // out of the tangent; it is μ r_m/R small.
            let load = gradient[0].hypot(gradient[1]);
            let speed = rate[2] - rate[5];
            let (share, slope) = self.coulomb(speed * journal.law.mean_radius);
            let torque = self.friction.bearing * load * journal.law.mean_radius;
            force[2] -= torque * share;
            force[5] += torque * share;
            let c = torque * slope * journal.law.mean_radius;
            for (i, j, sign) in [(2, 2, 1.0), (2, 5, -1.0), (5, 2, -1.0), (5, 5, 1.0)] {
                damping[i * 6 + j] += sign * c;
            }
            dissipation += torque * share * speed;
        }
        if self.loss_time > 0.0 || self.friction.bearing > 0.0 {
            sink.damper(&journal.index, &force, &damping, dissipation);
        }
    }

    /// v/√(v² + v_r²) and its derivative: regularised Coulomb friction.
    pub(super) fn coulomb(&self, speed: f64) -> (f64, f64) {
        let floor = self.friction.regularisation_speed;
        let reach = 1.0 / speed.hypot(floor);
        (speed * reach, floor * floor * reach.powi(3))
    }

    fn add_bending(&self, k: usize, q: &[f64], v: &[f64], sink: &mut impl Sink) {
        let n = self.layout.discs;
        let stations = n + 2;
        let stiffness = &self.shaft.stiffness;
        // Rows of the deflections over the stations A, B, discs.
        let share = |j: usize, s: usize| match s {
            0 => self.shaft.shares[j] - 1.0,
            1 => -self.shaft.shares[j],
            s if s == j + 2 => 1.0,
            _ => 0.0,
        };
        let mut matrix = vec![0.0; stations * stations];
        for a in 0..stations {
            for b in 0..stations {
                for i in 0..n {
                    for j in 0..n {
                        matrix[a * stations + b] += share(i, a) * stiffness[i * n + j] * share(j, b);
                    }
                }
            }
        }
        let damping: Vec<f64> = matrix.iter().map(|k| self.loss_time * k).collect();
        let first = self.layout.support(k, 0);
        for axis in 0..2 {
            let index: Vec<usize> = (0..stations).map(|s| first + 2 * s + axis).collect();
            // Deflections are differences of nearby places: taken from the first station, they keep their
            // digits.
            let place: Vec<f64> = index.iter().map(|i| q[*i] - q[index[0]]).collect();
            let times = |m: &[f64], x: &dyn Fn(usize) -> f64| -> Vec<f64> {
                (0..stations).map(|a| (0..stations).map(|b| m[a * stations + b] * x(b)).sum()).collect()
            };
            let gradient = times(&matrix, &|b| place[b]);
            let stored = 0.5 * gradient.iter().zip(&place).map(|(g, x)| g * x).sum::<f64>();
            sink.element(&Element {
                part: Part::CrankBending,
                index: &index,
                gradient: &gradient,
                hessian: &matrix,
                stored,
            });
            if self.loss_time > 0.0 {
                let force: Vec<f64> = times(&damping, &|b| -v[index[b]]);
                let dissipation = -force.iter().zip(&index).map(|(f, i)| f * v[*i]).sum::<f64>();
                sink.damper(&index, &force, &damping, dissipation);
            }
        }
    }

    fn mesh_index(&self, k: usize) -> [usize; MESH_COORDINATES] {
        let layout = &self.layout;
        let (sun, planet) = (layout.sun(), layout.support(k, 0));
        [sun, sun + 1, layout.sun_angle(), planet, planet + 1, layout.crank_angle(k), layout.carrier()[2]]
    }

    pub(super) fn mesh_state(&self, k: usize, q: &[f64], v: &[f64]) -> MeshState {
        let index = self.mesh_index(k);
        self.meshes[k].react(&index.map(|i| q[i]), &index.map(|i| v[i]))
    }

    /// [`PlanarMesh::overlap`](super::planar_mesh::PlanarMesh::overlap) of a mesh.
    pub(super) fn mesh_overlap(&self, k: usize, q: &[f64]) -> [f64; 2] {
        self.meshes[k].overlap(&self.mesh_index(k).map(|i| q[i]))
    }

    fn add_mesh(&self, k: usize, q: &[f64], v: &[f64], sink: &mut impl Sink) {
        let index = self.mesh_index(k);
        let rate = index.map(|i| v[i]);
        let mesh = self.mesh_state(k, q, v);
        let flat =
            |m: &[[f64; MESH_COORDINATES]; MESH_COORDINATES]| -> [f64; MESH_COORDINATES * MESH_COORDINATES] {
                std::array::from_fn(|i| m[i / MESH_COORDINATES][i % MESH_COORDINATES])
            };
        sink.element(&Element {
            part: Part::GearStage,
            index: &index,
            gradient: &mesh.gradient,
            hessian: &flat(&mesh.hessian),
            stored: mesh.stored,
        });
        let mut force = mesh.damping_force;
        let mut damping = flat(&mesh.damping);
        let mut dissipation = mesh.dissipation;
        if self.friction.gear_mesh > 0.0 {
            // Sliding in the mean over the path of contact, against the relative turn of the two gears.
            let speed = rate[2] - rate[5];
            let (share, slope) = self.coulomb(speed * self.mesh_sliding);
            let torque = self.friction.gear_mesh * mesh.force.abs() * self.mesh_sliding;
            force[2] -= torque * share;
            force[5] += torque * share;
            let c = torque * slope * self.mesh_sliding;
            for (i, j, sign) in [(2, 2, 1.0), (2, 5, -1.0), (5, 2, -1.0), (5, 5, 1.0)] {
                damping[i * MESH_COORDINATES + j] += sign * c;
            }
            dissipation += torque * share * speed;
        }
        sink.damper(&index, &force, &damping, dissipation);
    }

    /// Displacement of what the main bearings hold on the carrier against the housing, m.
    pub(super) fn main_displacement(&self, q: &[f64]) -> Vec2 {
        let ([cx, cy, turn], [hx, hy, _]) = (self.layout.carrier(), self.layout.housing());
        Vec2::new(q[cx] - q[hx], q[cy] - q[hy]) + self.main_seat.at(q[turn])
    }

    fn visit_supports(&self, q: &[f64], v: &[f64], sink: &mut impl Sink) {
        let layout = &self.layout;
        let ([cx, cy, carrier], [hx, hy, _], sun) = (layout.carrier(), layout.housing(), layout.sun());
        let seat = self.main_seat.at(q[carrier]);
        self.add_support(Part::Housing, [cx, cy, carrier, hx, hy], self.main, seat, q, v, sink);
        self.add_support(
            Part::GearStage,
            [sun, sun + 1, layout.sun_angle(), hx, hy],
            (self.sun_support, 0.0),
            Vec2::zeros(),
            q,
            v,
            sink,
        );
        if let Some(flange) = layout.flange() {
            self.add_torsion(Part::Carrier, [carrier, flange], self.carrier_torsion, q, v, sink);
        }
        if layout.input() != layout.sun_angle() {
            self.add_torsion(
                Part::InputShaft,
                [layout.input(), layout.sun_angle()],
                self.input_torsion,
                q,
                v,
                sink,
            );
        }
    }

    /// Torsion spring of stiffness k (N·m/rad) between two angles.
    fn add_torsion(&self, part: Part, index: [usize; 2], k: f64, q: &[f64], v: &[f64], sink: &mut impl Sink) {
        let twist = q[index[1]] - q[index[0]];
        let gradient = [-k * twist, k * twist];
        sink.element(&Element {
            part,
            index: &index,
            gradient: &gradient,
            hessian: &[k, -k, -k, k],
            stored: 0.5 * k * twist * twist,
        });
        if self.loss_time > 0.0 {
            let c = self.loss_time * k;
            let rate = v[index[1]] - v[index[0]];
            sink.damper(&index, &[c * rate, -c * rate], &[c, -c, -c, c], c * rate * rate);
        }
    }

    /// Linear support of stiffness and radial clearance between two bodies; `seat` is what it holds on the
    /// first, which turns with the third coordinate.
    fn add_support(
        &self,
        part: Part,
        index: [usize; 5],
        (stiffness, clearance): (f64, f64),
        seat: Vec2,
        q: &[f64],
        v: &[f64],
        sink: &mut impl Sink,
    ) {
        let u = Vec2::new(q[index[0]] - q[index[3]], q[index[1]] - q[index[4]]) + seat;
        let distance = u.norm();
        if distance < clearance {
            return;
        }
        let open = if distance > 0.0 { clearance / distance } else { 0.0 };
        let normal = if distance > 0.0 { u / distance } else { Vec2::zeros() };
        let depth = distance - clearance;
        let force = stiffness * (1.0 - open) * u;
        let along = quarter_turn(seat);
        let rows = [[1.0, 0.0, along.x, -1.0, 0.0], [0.0, 1.0, along.y, 0.0, -1.0]];
        let entry = |i: usize, j: usize| {
            stiffness * ((1.0 - open) * f64::from(u8::from(i == j)) + open * normal[i] * normal[j])
        };
        let radial = [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]];
        let mut hessian = [0.0; 25];
        for a in 0..5 {
            for b in 0..5 {
                for i in 0..2 {
                    for j in 0..2 {
                        hessian[a * 5 + b] += rows[i][a] * radial[i][j] * rows[j][b];
                    }
                }
            }
        }
        let damping = hessian.map(|k| self.loss_time * k);
        hessian[12] -= force.dot(&seat);
        let gradient: [f64; 5] = std::array::from_fn(|a| force.x * rows[0][a] + force.y * rows[1][a]);
        sink.element(&Element {
            part,
            index: &index,
            gradient: &gradient,
            hessian: &hessian,
            stored: 0.5 * stiffness * depth * depth,
        });
        if self.loss_time > 0.0 {
            let rate = index.map(|i| v[i]);
            let pull: [f64; 5] =
                std::array::from_fn(|a| -(0..5).map(|b| damping[a * 5 + b] * rate[b]).sum::<f64>());
            let dissipation = -pull.iter().zip(&rate).map(|(f, v)| f * v).sum::<f64>();
            sink.damper(&index, &pull, &damping, dissipation);
        }
    }
}
