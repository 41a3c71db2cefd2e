use super::{Distance, Joint, Limit, Part, Sink, State};
use crate::dynamics::mechanism::assembly::Element;

/// Torsion spring between two angles.
#[derive(Debug, Clone, PartialEq)]
pub struct Torsion {
    /// Part to which the compliance is assigned.
    pub part: Part,
    /// Numbers of the two angles among the coordinates.
    pub index: [usize; 2],
    /// Torsional stiffness, N·m/rad.
    pub stiffness: f64,
    /// Ratio of damping to stiffness in s.
    pub loss_time: f64,
}

impl Joint for Torsion {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let (index, k) = (self.index, self.stiffness);
        let twist = at.q[index[1]] - at.q[index[0]];
        let gradient = [-k * twist, k * twist];
        sink.element(&Element {
            part: self.part,
            index: &index,
            gradient: &gradient,
            hessian: &[k, -k, -k, k],
            stored: 0.5 * k * twist * twist,
        });
        if self.loss_time > 0.0 {
            let c = self.loss_time * k;
            let rate = at.v[index[1]] - at.v[index[0]];
            sink.damper(&index, &[c * rate, -c * rate], &[c, -c, -c, c], c * rate * rate);
        }
    }

    fn limits(&self, q: &[f64], _: f64, add: &mut dyn FnMut(Limit<'_>)) {
        let value = q[self.index[1]] - q[self.index[0]];
        let (index, gradient) = (&self.index, &[-1.0, 1.0]);
        add(Limit::Bond(Distance { index, gradient, value, stiffness: self.stiffness }));
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
