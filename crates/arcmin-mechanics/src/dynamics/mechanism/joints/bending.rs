use nalgebra::DMatrix;

use super::{Distance, Joint, Limit, Part, Sink, State};
use crate::dynamics::mechanism::assembly::Element;

/// Bending and shear of a shaft between its stations.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::dynamics) struct Bending {
    /// Part to which the compliance is assigned.
    part: Part,
    /// Coordinates along x and along y: displacements of the stations, and their slopes if they have any.
    index: [Vec<usize>; 2],
    /// Number of stations.
    stations: usize,
    /// Stiffness in N/m, N and N·m over the coordinates of one direction, row by row.
    matrix: Vec<f64>,
    /// Damping in N·s/m; empty without damping.
    damping: Vec<f64>,
    /// √K times the deviations from a straight line, as rows over the coordinates: half the sum of their
    /// squares is the energy.
    departures: Vec<f64>,
}

impl Bending {
    /// `index` are the coordinates along x and along y: displacements of the stations, and their slopes if they
    /// have any. `departures` gives, row by row over one direction, the deviations from a straight line,
    /// `stiffness` (N/m, row by row) the corresponding forces.
    pub fn new(
        part: Part,
        index: [Vec<usize>; 2],
        stations: usize,
        (departures, stiffness): (&[f64], &[f64]),
        loss_time: f64,
    ) -> Bending {
        let width = index[0].len();
        let count = departures.len() / width;
        let departures = DMatrix::from_row_slice(count, width, departures);
        let stiffness = DMatrix::from_row_slice(count, count, stiffness);
        let matrix = (departures.transpose() * &stiffness * &departures).as_slice().to_vec();
        let damping =
            if loss_time > 0.0 { matrix.iter().map(|k| loss_time * k).collect() } else { Vec::new() };
        // K is the inverse of a compliance matrix, so that its Cholesky factor exists.
        let root = stiffness.cholesky().map(|root| root.l().transpose());
        let departures =
            root.map_or_else(Vec::new, |root| (root * departures).transpose().as_slice().to_vec());
        Bending { part, index, stations, matrix, damping, departures }
    }

    /// The coordinates of one direction, with displacements relative to the first one: bending depends on small
    /// differences, which keep more digits in this way.
    fn relative_to_first(&self, index: &[usize], q: &[f64]) -> Vec<f64> {
        let (places, slopes) = index.split_at(self.stations);
        places.iter().map(|i| q[*i] - q[index[0]]).chain(slopes.iter().map(|i| q[*i])).collect()
    }
}

impl Joint for Bending {
    fn visit(&self, State { q, v }: State<'_>, sink: &mut dyn Sink) {
        let count = self.index[0].len();
        for index in &self.index {
            let place = self.relative_to_first(index, q);
            let times = |m: &[f64], x: &dyn Fn(usize) -> f64| -> Vec<f64> {
                (0..count).map(|a| (0..count).map(|b| m[a * count + b] * x(b)).sum()).collect()
            };
            let gradient = times(&self.matrix, &|b| place[b]);
            let stored = 0.5 * gradient.iter().zip(&place).map(|(g, x)| g * x).sum::<f64>();
            sink.element(&Element {
                part: self.part,
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
            let place = self.relative_to_first(index, q);
            for row in self.departures.chunks_exact(index.len()) {
                let value = row.iter().zip(&place).map(|(share, x)| share * x).sum();
                add(Limit::Bond(Distance { index, gradient: row, value, stiffness: 1.0 }));
            }
        }
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
