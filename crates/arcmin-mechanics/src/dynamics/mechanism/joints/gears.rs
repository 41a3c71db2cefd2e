use super::{
    Cause, ContactRequest, Distance, Joint, JointWear, Limit, Losses, Nominal, PlayLabel, Sink, State,
};
use crate::contact::ContactSpring;
use crate::dynamics::gear_mesh::{GearMesh, MESH_COORDINATES, MeshState};
use crate::dynamics::mechanism::assembly::Element;
use crate::dynamics::{Contact, ForceSummary};

/// A mesh of two involute gears.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::dynamics) struct Gears {
    /// Names of its compliance, backlash and wear.
    pub label: PlayLabel,
    pub law: GearMesh,
    pub index: [usize; MESH_COORDINATES],
    pub losses: Losses,
    /// Mean distance of the contact from the pitch point, m.
    pub sliding: f64,
}

impl Gears {
    fn state(&self, State { q, v }: State<'_>) -> MeshState<MESH_COORDINATES> {
        self.law.react(&self.index.map(|i| q[i]), &self.index.map(|i| v[i]))
    }
}

impl Gears {
    /// Passes on the teeth that are loaded or nearly in contact, and removes their stiffness along the gaps
    /// from the Hessian.
    fn show_teeth(
        &self,
        q: &[f64],
        wanted: ContactRequest,
        hessian: &mut [[f64; MESH_COORDINATES]; MESH_COORDINATES],
        sink: &mut dyn Sink,
    ) {
        let place = self.index.map(|i| q[i]);
        let stiffness = self.law.stiffness_at(&place);
        let spring = ContactSpring::Linear { stiffness };
        for (overlap, slope) in self.law.overlaps(&place).into_iter().flatten() {
            if overlap > 0.0 {
                for (row, a) in hessian.iter_mut().zip(slope) {
                    row.iter_mut().zip(slope).for_each(|(entry, b)| *entry -= stiffness * a * b);
                }
            }
            if -overlap < wanted.reach {
                sink.contact(&Contact::new(&self.index, &slope.map(|s| -s), -overlap, spring));
            }
        }
    }
}

impl Joint for Gears {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let index = self.index;
        let rate = index.map(|i| at.v[i]);
        let mut mesh = self.state(at);
        if let Some(wanted) = sink.contact_request() {
            self.show_teeth(at.q, wanted, &mut mesh.hessian, sink);
        }
        sink.element(&Element {
            part: self.label.part,
            index: &index,
            gradient: &mesh.gradient,
            hessian: mesh.hessian.as_flattened(),
            stored: mesh.stored,
        });
        let mut force = mesh.damping_force;
        let (mut damping, mut by_place) = (mesh.damping, mesh.damping_slope);
        let mut dissipation = mesh.dissipation;
        let friction = self.losses.sliding;
        if friction.coefficient > 0.0 {
            // Mean sliding over the path of contact, against the relative rotation of the two gears.
            let speed = rate[2] - rate[5];
            let (share, slope) = friction.share(speed * self.sliding);
            let torque = mesh.elastic_force().abs() * self.sliding;
            force[2] -= torque * share;
            force[5] += torque * share;
            if let Some(interval) = sink.contact_request().and_then(|wanted| wanted.slip_interval) {
                let spring = friction.slip(mesh.elastic_force().abs(), interval);
                let gradient = [self.sliding, -self.sliding];
                let gap = speed * self.sliding * interval;
                sink.contact(&Contact::new(&[index[2], index[5]], &gradient, gap, spring));
            } else {
                let c = torque * slope * self.sliding;
                for (i, j, sign) in [(2, 2, 1.0), (2, 5, -1.0), (5, 2, -1.0), (5, 5, 1.0)] {
                    damping[i][j] += sign * c;
                }
            }
            dissipation += torque * share * speed;
            let factor = self.sliding * share * mesh.elastic_force().signum();
            for (j, slope) in mesh.elastic_slope.iter().enumerate() {
                by_place[2][j] += factor * slope;
                by_place[5][j] -= factor * slope;
            }
        }
        if friction.coefficient > 0.0 || self.law.damping > 0.0 {
            sink.friction_slope(&index, by_place.as_flattened());
        }
        sink.damper(&index, &force, damping.as_flattened(), dissipation);
    }

    fn limits(&self, q: &[f64], _: f64, add: &mut dyn FnMut(Limit<'_>)) {
        for (overlap, slope) in self.law.overlaps(&self.index.map(|i| q[i])).into_iter().flatten() {
            let gradient = &slope.map(|s| -s);
            // The weights of the limits are constant while the teeth rotate.
            let stiffness = self.law.stiffness;
            add(Limit::Gap(Distance { index: &self.index, gradient, value: -overlap, stiffness }));
        }
    }

    fn work(&self, at: State<'_>, nominal: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        let mesh = self.state(at);
        add(Cause::ELASTIC, 2.0 * mesh.stored);
        let made = nominal.of_errors().and_then(|q| self.law.made_overlap(&self.index.map(|i| q[i])));
        for side in 0..2 {
            let force = mesh.side_force[side];
            add(self.label.play, force * self.law.half_backlash);
            add(self.label.wear, force * self.law.flank_loss[side]);
            if let Some(made) = made {
                add(Cause::MANUFACTURING_ERRORS, -force * made[side]);
            }
        }
    }

    fn set_wear(&mut self, wear: JointWear) {
        if let JointWear::ToothSides(lost) = wear {
            self.law.flank_loss = lost;
        }
    }

    fn wearing_forces(&self, at: State<'_>) -> [f64; 2] {
        self.state(at).side_force
    }

    fn add_forces(&self, at: State<'_>, summary: &mut ForceSummary) {
        summary.mesh_force += self.state(at).force;
    }

    fn scale_friction(&mut self, share: f64) {
        self.losses.sliding.coefficient *= share;
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
