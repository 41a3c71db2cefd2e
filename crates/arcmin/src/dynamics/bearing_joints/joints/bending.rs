use nalgebra::DMatrix;

use super::{Distance, Joint, Limit, Part, Sink, State};
use crate::dynamics::bearing_joints::assembly::Element;
use crate::dynamics::bearing_joints::shaft::Shaft;

/// Bending and shear of a crankshaft between its stations: both supports, then the discs.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Bending {
    /// Coordinates of the stations along x and along y.
    index: [Vec<usize>; 2],
    /// N/m over the stations, row by row.
    matrix: Vec<f64>,
    /// N·s/m; empty where nothing is damped.
    damping: Vec<f64>,
    /// √K times the deflections at the discs as rows over the stations: half the sum of their squares is the energy.
    deflection: Vec<f64>,
}

impl Bending {
    /// `stations` are (x, y) of the supports and the discs.
    pub fn new(shaft: &Shaft, stations: &[[usize; 2]], loss_time: f64) -> Bending {
        let count = stations.len();
        let n = count - 2;
        let stiffness = &shaft.stiffness;
        // Rows of the deflections over the stations A, B, discs.
        let share = |j: usize, s: usize| match s {
            0 => shaft.shares[j] - 1.0,
            1 => -shaft.shares[j],
            s if s == j + 2 => 1.0,
            _ => 0.0,
        };
        let mut matrix = vec![0.0; count * count];
        for a in 0..count {
            for b in 0..count {
                for i in 0..n {
                    for j in 0..n {
                        matrix[a * count + b] += share(i, a) * stiffness[i * n + j] * share(j, b);
                    }
                }
            }
        }
        let damping =
            if loss_time > 0.0 { matrix.iter().map(|k| loss_time * k).collect() } else { Vec::new() };
        // K is the inverse of influence numbers, so it has a root.
        let root = DMatrix::from_row_slice(n, n, stiffness).cholesky().map(|root| root.l().transpose());
        let shares = DMatrix::from_fn(n, count, share);
        let deflection = root.map_or_else(Vec::new, |root| (root * shares).transpose().as_slice().to_vec());
        let index = [0, 1].map(|axis| stations.iter().map(|station| station[axis]).collect());
        Bending { index, matrix, damping, deflection }
    }
}

impl Joint for Bending {
    fn visit(&self, State { q, v }: State<'_>, sink: &mut dyn Sink) {
        let count = self.index[0].len();
        for index in &self.index {
            // Deflections are differences of nearby places: taken from the first station, they keep their
            // digits.
            let place: Vec<f64> = index.iter().map(|i| q[*i] - q[index[0]]).collect();
            let times = |m: &[f64], x: &dyn Fn(usize) -> f64| -> Vec<f64> {
                (0..count).map(|a| (0..count).map(|b| m[a * count + b] * x(b)).sum()).collect()
            };
            let gradient = times(&self.matrix, &|b| place[b]);
            let stored = 0.5 * gradient.iter().zip(&place).map(|(g, x)| g * x).sum::<f64>();
            sink.element(&Element {
                part: Part::CrankBending,
                index,
                gradient: &gradient,
                hessian: &self.matrix,
                stored,
            });
            if !self.damping.is_empty() {
                let force: Vec<f64> = times(&self.damping, &|b| -v[index[b]]);
                let dissipation = -force.iter().zip(index).map(|(f, i)| f * v[*i]).sum::<f64>();
                sink.damper(index, &force, &self.damping, dissipation);
            }
        }
    }

    fn limits(&self, q: &[f64], _: f64, add: &mut dyn FnMut(Limit<'_>)) {
        for index in &self.index {
            for row in self.deflection.chunks_exact(index.len()) {
                let value = row.iter().zip(index).map(|(share, i)| share * (q[*i] - q[index[0]])).sum();
                add(Limit::Bond(Distance { index, gradient: row, value, stiffness: 1.0 }));
            }
        }
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
