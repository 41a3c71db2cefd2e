use super::{Joint, Limit, Part, Sink, State, damp};
use crate::dynamics::mechanism::assembly::Element;

/// A body's elastic interface: displacements d of its seats in its own frame with U = ½ dᵀ K d.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::dynamics) struct Frame {
    pub part: Part,
    pub index: Vec<usize>,
    /// K in N/m, row by row.
    pub stiffness: Vec<f64>,
    /// Ratio of damping to stiffness in s.
    pub loss_time: f64,
}

impl Joint for Frame {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let rows = self.stiffness.chunks_exact(self.index.len());
        let along = |row: &[f64]| row.iter().zip(&self.index).map(|(k, i)| k * at.q[*i]).sum();
        let gradient: Vec<f64> = rows.map(along).collect();
        let stored = 0.5 * gradient.iter().zip(&self.index).map(|(g, i)| g * at.q[*i]).sum::<f64>();
        sink.element(&Element {
            part: self.part,
            index: &self.index,
            gradient: &gradient,
            hessian: &self.stiffness,
            stored,
        });
        damp(&self.index, &self.stiffness, self.loss_time, at, sink);
    }

    fn limits(&self, _: &[f64], _: f64, add: &mut dyn FnMut(Limit<'_>)) {
        self.index.iter().for_each(|at| add(Limit::Held(*at)));
    }

    fn elastic(&self, add: &mut dyn FnMut(&[usize], &[f64])) {
        add(&self.index, &self.stiffness);
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
