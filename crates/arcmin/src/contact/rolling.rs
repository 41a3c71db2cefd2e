use super::{PinContact, PinContacts};
use crate::geometry::{cross, quarter_turn, unit};

/// How a contact travels on flank and pin while the disc moves: what the forces need beyond F ∂g/∂q to derive from the stored energy.
///
/// The energy U(δ, R_eq) of a line contact falls with sharper curvature, the compliance of an elastic disc changes along its flank, and flank errors and
/// worn pins are read where the contact is. All depend on the foot τ, and rolling to another place takes or gives work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rolling {
    /// ∂τ/∂(x, y, θ) of the foot, in rad/m and rad/rad.
    pub by_pose: [f64; 3],
    /// d(ln R_eq)/dτ.
    pub log_radius_slope: f64,
    /// What ∂(gap)/∂(x, y, θ) leaves out: slopes of the flank's error and of the worn pin.
    pub gap_slope: [f64; 3],
}

impl PinContacts {
    /// Travel of the foot of `contact`. Exact for uniform relief; on worn flanks exact but for terms of second order in the slope of the depth (1e-5 of it).
    pub fn rolling(&self, contact: &PinContact) -> Rolling {
        let profile = self.profile();
        let pin_radius = self.pins()[contact.pin].radius;
        let phi = unit(contact.meshing_angle);
        let (lobes, z, k1) = (profile.lobe_count() as f64, profile.pin_count as f64, profile.short_width_coefficient());
        let factor = profile.speed_factor(phi.x);
        let speed = profile.pin_circle_radius * factor;
        let trace = profile.trace_curvature(phi.x);
        // Rates with τ; φ = −z_c τ.
        let speed_rate = -lobes * profile.pin_circle_radius * k1 * phi.y / factor;
        let trace_rate = lobes * k1 * phi.y * ((1.0 + z) / (profile.pin_circle_radius * factor.powi(3)) + 3.0 * trace / (factor * factor));

        let uniform = self.relief().is_uniform();
        let worn = self.relief().at(contact.meshing_angle);
        // R_eq of a uniformly worn flank is that of the flank as cut.
        let depth = profile.pin_radius + if uniform { 0.0 } else { worn.depth };
        let (depth_rate, stretch) = (-lobes * worn.slope, 1.0 + depth * trace);
        let unworn = 1.0 / pin_radius - trace / stretch;
        let unworn_rate = -(trace_rate - trace * trace * depth_rate) / (stretch * stretch);
        // What the worn flank's waves add to the relative curvature, in R_eq as the contact has it and in full: w_xx = (w_φ/l)_φ/l with the length l per φ.
        let (mut bend, mut bend_rate, mut full_bend) = (0.0, 0.0, 0.0);
        if !uniform {
            let per_angle = speed * stretch.abs() / lobes;
            let stretch_rate = depth_rate * trace + depth * trace_rate;
            let per_angle_rate = (speed_rate * stretch.abs() + speed * stretch_rate * stretch.signum()) / lobes;
            bend = worn.bend / (per_angle * per_angle);
            bend_rate = -lobes * self.relief().twist(contact.meshing_angle) / (per_angle * per_angle) - 2.0 * bend * per_angle_rate / per_angle;
            full_bend = bend + worn.slope * per_angle_rate / (lobes * per_angle.powi(3));
        }
        // The bound of a hollow sharper than the pin, as in the closest point.
        let hollow = unworn + bend < 0.1 * unworn;
        let log_radius_slope = if self.is_faceted() {
            0.0
        } else if hollow {
            -unworn_rate / unworn
        } else {
            -(unworn_rate + bend_rate) / (unworn + bend)
        };

        let (mut read, mut error_slope, mut pin_slope) = (0.0, 0.0, 0.0);
        if let Some(error) = self.flank_error() {
            read += error.depth(contact.tau, profile.outward_normal(contact.tau));
            error_slope = error.slope(contact.tau, profile);
        }
        if let Some(pin_relief) = self.pin_relief() {
            let sample = pin_relief.at(self.pin_angle(contact));
            read += sample.depth;
            pin_slope = sample.slope;
        }
        // The pin centre moves by −T dz past the flank, and the closest point by 1/(1 − κ D) of that, D being the distance between the two.
        let full_stretch = 1.0 + (profile.pin_radius + worn.depth) * trace;
        let curvature = trace / full_stretch - full_bend;
        let length = (speed * full_stretch).hypot(depth_rate);
        let reach = 1.0 - curvature * (contact.gap - read + pin_radius);
        let t = quarter_turn(contact.normal);
        let by_pose = [t.x, t.y, cross(contact.arm, t)].map(|along| -along / (reach * length));
        // Normals turn by −κ per length along the flank, and with the disc.
        let gap_slope = std::array::from_fn(|i| {
            let turn = f64::from(u8::from(i == 2)) - curvature * length * by_pose[i];
            error_slope * by_pose[i] + pin_slope * turn
        });
        Rolling { by_pose, log_radius_slope, gap_slope }
    }

    /// Generalised force (N, N, N·m) on the disc that the stored energy asks for beyond F ∂g/∂q.
    pub(super) fn rolling_force(&self, contact: &PinContact) -> [f64; 3] {
        let rolling = self.rolling(contact);
        let energy_rate = self.contact().energy_by_log_radius(contact.elastic) * rolling.log_radius_slope;
        std::array::from_fn(|i| contact.elastic * rolling.gap_slope[i] - energy_rate * rolling.by_pose[i])
    }
}
