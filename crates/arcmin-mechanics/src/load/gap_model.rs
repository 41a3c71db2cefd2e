use crate::contact::{LineContact, PinContact};

/// One contact near an output error ε: its gap to second order and its relative curvature to first order in the
/// change of ε.
#[derive(Debug, Clone, Copy)]
struct NearbyContact {
    /// Gap in m with its derivatives in m/rad and m/rad².
    gap: f64,
    slope: f64,
    bend: f64,
    /// Relative curvature in 1/m with its derivative in 1/(m·rad).
    relative_curvature: f64,
    relative_curvature_slope: f64,
}

/// All contacts that are or may become loaded near an output error ε. Solving the equilibrium with this model
/// is much faster than evaluating the contacts, and its error is of third order in the change of ε.
#[derive(Debug, Default)]
pub(super) struct GapModel {
    contacts: Vec<NearbyContact>,
    /// Q(ε) in N·m, and −dQ/dε in N·m/rad at constant relative curvature.
    pub torque: f64,
    pub stiffness: f64,
    /// Σ F |∂gap/∂ε| in N·m: the sum of the absolute torques of all contacts. With preload most of them cancel
    /// in Q.
    pub turnover: f64,
}

impl GapModel {
    pub fn with_capacity(contacts: usize) -> GapModel {
        GapModel { contacts: Vec::with_capacity(contacts), ..GapModel::default() }
    }

    pub fn clear(&mut self) {
        self.contacts.clear();
        (self.torque, self.stiffness, self.turnover) = (0.0, 0.0, 0.0);
    }

    /// Adds a contact with ∂gap/∂ε = `slope` (m/rad), ∂²gap/∂ε² = `bend`, and d(1/R_eq)/dε.
    #[inline]
    pub fn add(&mut self, contact: &PinContact, slope: f64, bend: f64, relative_curvature_slope: f64) {
        self.torque += contact.force * slope;
        self.turnover += contact.force * slope.abs();
        self.stiffness += contact.stiffness * slope * slope - contact.force * bend;
        let relative_curvature = contact.designed_curvature;
        self.contacts.push(NearbyContact {
            gap: contact.gap,
            slope,
            bend,
            relative_curvature,
            relative_curvature_slope,
        });
    }

    /// Changes gaps and forces of the contacts, in the order in which they were added, for a small change of ε
    /// to first order; returns the new Q.
    pub fn carry_over<'a>(&self, contacts: impl Iterator<Item = &'a mut PinContact>, change: f64) -> f64 {
        let mut torque = 0.0;
        for (contact, c) in contacts.zip(&self.contacts) {
            let closer = -c.slope * change;
            let more = contact.stiffness * closer;
            contact.gap -= closer;
            contact.stored += (contact.elastic + 0.5 * more) * closer;
            contact.force += more;
            contact.elastic += more;
            torque += contact.force * (c.slope + c.bend * change);
        }
        torque
    }

    /// Q and −dQ/dε after a change x of ε (rad).
    fn torque_after(&self, law: &LineContact, x: f64) -> (f64, f64) {
        let (mut torque, mut stiffness) = (0.0, 0.0);
        for c in &self.contacts {
            let gap = c.gap + x * (c.slope + 0.5 * x * c.bend);
            if gap < 0.0 {
                let slope = c.slope + x * c.bend;
                // The linear extrapolation of the curvature is limited to half of its value.
                let curvature =
                    (c.relative_curvature + x * c.relative_curvature_slope).max(0.5 * c.relative_curvature);
                let (force, tangent) = law.force(-gap, 1.0 / curvature);
                torque += force * slope;
                stiffness += tangent * slope * slope - force * c.bend;
            }
        }
        (torque, stiffness)
    }

    /// Change of ε in `direction` (±1) to the first contact among those that close faster than `least_closing`
    /// (m/rad), with `relief` (m) added to all gaps; opposite to the direction if a contact is already closed.
    pub fn first_touch(&self, direction: f64, least_closing: f64, relief: f64) -> Option<f64> {
        self.contacts
            .iter()
            .filter_map(|c| {
                // Root of gap − closing y + ½ bend y² = 0 in the form without cancellation.
                let gap = c.gap + relief;
                let closing = -direction * c.slope;
                let root = closing * closing - 2.0 * c.bend * gap;
                (closing > least_closing && root >= 0.0).then(|| 2.0 * gap / (closing + root.sqrt()))
            })
            .min_by(f64::total_cmp)
            .map(|change| direction * change)
    }

    /// Smallest gap in m after a change x of ε, and its derivative with respect to ε.
    fn smallest_after(&self, x: f64) -> (f64, f64) {
        let after = |c: &NearbyContact| (c.gap + x * (c.slope + 0.5 * x * c.bend), c.slope + x * c.bend);
        self.contacts.iter().map(after).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0.0))
    }

    /// Smallest gap in m and its derivative with respect to ε.
    pub fn smallest(&self) -> (f64, f64) {
        self.smallest_after(0.0)
    }

    /// Change of ε within ±`reach` at which the smallest gap is largest, that is between an opening and a
    /// closing gap. Bisection on the slope of the smallest gap.
    pub fn loosest(&self, reach: f64) -> f64 {
        let (mut low, mut high) = (-reach, reach);
        // Down to the rounding error of an angle.
        while high - low > 1e-15 {
            let middle = 0.5 * (low + high);
            if self.smallest_after(middle).1 > 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// Largest closing rate of any gap with ε in `direction`, in m/rad.
    pub fn fastest_closing(&self, direction: f64) -> f64 {
        self.contacts.iter().map(|c| -direction * c.slope).fold(0.0, f64::max)
    }

    /// Change of ε that brings Q to `torque`: Newton's method with steps no larger than `largest`; within the
    /// clearance it starts `wind_up` (rad) beyond the first contact. `None` where no contact closes.
    pub fn change_to(&self, law: &LineContact, torque: f64, wind_up: f64, largest: f64) -> Option<f64> {
        let mut residual = self.torque - torque;
        let mut change = if self.stiffness > 0.0 {
            (residual / self.stiffness).clamp(-largest, largest)
        } else {
            let direction = -torque.signum();
            self.first_touch(direction, 0.0, 0.0)? + direction * wind_up
        };
        // A step leaves the square of the residual; below 1e-4 this is less than the error of the model.
        for _ in 0..8 {
            if residual.abs() < 1e-4 * torque.abs() {
                break;
            }
            let (q, stiffness) = self.torque_after(law, change);
            if !(stiffness > 0.0) {
                break;
            }
            residual = q - torque;
            change += (residual / stiffness).clamp(-largest, largest);
        }
        Some(change)
    }
}
