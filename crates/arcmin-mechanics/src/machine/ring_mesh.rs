//! The flank of a disc and its ring of pins, with closed forms for equal springs.

use std::f64::consts::TAU;

use super::{PinMounting, RingPartner};
use crate::contact::{LineContact, Pin};
use crate::geometry::{Profile, Relief, Vec2, unit};

/// The flank of a disc and the ring of pins with which it meshes.
#[derive(Debug, Clone, PartialEq)]
pub struct RingMesh {
    /// The flank as cut.
    pub profile: Profile,
    /// Radius of the circle of the pin centres as installed, m.
    pub ring_circle_radius: f64,
    /// Radius of the pins as installed, m.
    pub ring_pin_radius: f64,
    /// Law of contact of a pin with a flank.
    pub contact: LineContact,
    /// Metal removed from the flank, m.
    pub relief: Relief,
    /// Mounting of the pins, or ring of one piece.
    pub mounting: PinMounting,
}

/// Number of positions on the flank at which the backlash is evaluated.
const STOPS: usize = 2000;

impl RingMesh {
    /// Words for the counterpart of the flank.
    pub fn partner(&self) -> RingPartner {
        RingPartner::of([self.mounting])
    }

    /// Pins of the ring at equal distances, the first at the angle 0.
    pub fn pins(&self) -> Vec<Pin> {
        let count = self.profile.pin_count;
        let pin = |pin: usize| Pin {
            centre: self.ring_circle_radius * unit(TAU * pin as f64 / count as f64),
            radius: self.ring_pin_radius,
        };
        (0..count).map(pin).collect()
    }

    /// e z_c/m in m: ratio of the moment about the disc's centre to the force perpendicular to its eccentric.
    pub fn lever(&self) -> f64 {
        self.profile.eccentricity * self.profile.lobes_per_turn()
    }

    /// Gap (m) of the flank in nominal position at a meshing angle, from offsets of the cut and from the
    /// relief.
    pub fn gap(&self, meshing_angle: f64) -> f64 {
        let (equidistant, radial) = (
            self.profile.pin_radius - self.ring_pin_radius,
            self.profile.pin_circle_radius - self.ring_circle_radius,
        );
        let normal = self.profile.pin_angle(meshing_angle);
        equidistant - radial * normal.cos() + self.relief.at(meshing_angle).depth
    }

    /// Two-sided free rotation (rad) of a disc about its centre. On either side it is limited by the pin with
    /// the smallest ratio of gap Δ to lever arm l: min Δ/l + min Δ/l, which is 2 Δ m/(e z_c) if the gap is the
    /// same everywhere.
    pub fn free_turn(&self) -> f64 {
        let last = self.profile.last_meshing_angle();
        let turn = |side: f64| {
            let free = |i: usize| {
                let phi = side * last * (i as f64 + 0.5) / STOPS as f64;
                self.gap(phi).max(0.0) / self.profile.lever_arm(phi).abs()
            };
            (0..STOPS).map(free).fold(f64::INFINITY, f64::min)
        };
        turn(1.0) + turn(-1.0)
    }

    /// Largest force (N) on a pin if all pins on one side carry a moment (N·m) about the disc's centre as equal
    /// springs: 4 T/(K₁ z_c R) for a flank that is smooth over the tip, multiplied by [`Profile::crowding`] for
    /// one that ends before.
    pub(crate) fn pin_force(&self, moment: f64) -> f64 {
        let profile = &self.profile;
        let lever =
            profile.short_width_coefficient() * profile.lobe_count() as f64 * profile.pin_circle_radius;
        4.0 * moment.abs() / lever * profile.crowding()
    }

    /// Ratio of the ring force's components along and perpendicular to the eccentric, for equal springs.
    pub(crate) fn slant(&self) -> f64 {
        ring_slant(&self.profile, self.ring_circle_radius)
    }

    /// Σ F s/Σ F l in m/m: the sliding distance (m) per radian of the disc's rotation relative to the ring,
    /// weighted with the forces of equal springs and divided by their moment about the disc's centre. The
    /// instantaneous centre of rotation is the pitch point, in which the normals meet, so that the sliding
    /// distance is the distance of the contact from it.
    pub(crate) fn sliding(&self) -> f64 {
        let (mut sliding, mut moment) = (0.0, 0.0);
        for (pin, normal) in normals(&self.profile, self.ring_circle_radius) {
            let lever = self.lever() * normal.y;
            sliding += normal.y * (pin - self.ring_pin_radius).abs();
            moment += normal.y * lever;
        }
        sliding / moment
    }
}

/// Ratio of the ring force's components along and perpendicular to the eccentric, if all pins on one side act
/// as equal springs.
pub fn ring_slant(profile: &Profile, ring_circle_radius: f64) -> f64 {
    let (mut squares, mut along) = (0.0, 0.0);
    for (_, normal) in normals(profile, ring_circle_radius) {
        squares += normal.y * normal.y;
        along -= normal.y * normal.x;
    }
    along / squares
}

/// For positions along the flank of one side: distance (m) of the pin's axis from the pitch point, e z_p/m from
/// the centre of the ring, in which the lines of action of all pins meet; and the direction of that line, for
/// an eccentric at the angle 0.
fn normals(profile: &Profile, ring_circle_radius: f64) -> impl Iterator<Item = (f64, Vec2)> {
    let pitch_point = Vec2::new(profile.eccentricity * profile.pins_per_turn(), 0.0);
    let last = profile.last_meshing_angle();
    (0..STOPS).map(move |i| {
        let arm = ring_circle_radius * unit(last * (i as f64 + 0.5) / STOPS as f64) - pitch_point;
        (arm.norm(), arm.normalize())
    })
}
