use super::{Joint, Limit, Part, Sink, State};
use crate::dynamics::bearing_joints::assembly::Element;

/// A body's elastic interface: displacements d of its seats in its own frame with U = ½ dᵀ K d.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Frame {
    pub part: Part,
    pub index: Vec<usize>,
    /// K in N/m, row by row.
    pub stiffness: Vec<f64>,
    /// Ratio of damping to stiffness in s.
    pub loss_time: f64,
}

impl Frame {
    fn times(&self, x: impl Fn(usize) -> f64) -> Vec<f64> {
        let rows = self.stiffness.chunks_exact(self.index.len());
        rows.map(|row| row.iter().zip(&self.index).map(|(k, at)| k * x(*at)).sum()).collect()
    }
}

impl Joint for Frame {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let gradient = self.times(|i| at.q[i]);
        let stored = 0.5 * gradient.iter().zip(&self.index).map(|(g, i)| g * at.q[*i]).sum::<f64>();
        sink.element(&Element {
            part: self.part,
            index: &self.index,
            gradient: &gradient,
            hessian: &self.stiffness,
            stored,
        });
        if self.loss_time > 0.0 {
            let damping: Vec<f64> = self.stiffness.iter().map(|k| self.loss_time * k).collect();
            let force: Vec<f64> = self.times(|i| -self.loss_time * at.v[i]);
            let dissipation = -force.iter().zip(&self.index).map(|(f, i)| f * at.v[*i]).sum::<f64>();
            sink.damper(&self.index, &force, &damping, dissipation);
        }
    }

    fn limits(&self, _: &[f64], add: &mut dyn FnMut(Limit<'_>)) {
        self.index.iter().for_each(|at| add(Limit::Held(*at)));
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
