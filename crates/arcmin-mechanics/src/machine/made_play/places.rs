//! Positions of the pins relative to a disc, and the gaps there with the errors of a drive.

use super::bounds::{Bound, Bounds, drop_idle, off_zero};
use crate::geometry::{FlankErrorReader, Vec2, cross, quarter_turn, turned, unit};
use crate::machine::{OutputPins, RingMesh, RunOut, StageErrors};

/// The pins of one ring, or the output pins, in contact with one disc at one position.
#[derive(Debug, Clone)]
pub(super) struct Side {
    /// Stage to which the pins belong.
    pub stage: usize,
    /// Rotation of the output per unit of the free range of these pins: rad/m for a ring, 1 for output pins.
    pub weight: f64,
    places: Places,
}

#[derive(Debug, Clone)]
enum Places {
    Ring {
        /// Number of the first pin among the errors.
        first: usize,
        /// Angle of the eccentric in rad, relative to the body with the ring.
        eccentric: f64,
        pins: Vec<RingPlace>,
    },
    Output {
        /// R_w and δ in m.
        circle_radius: f64,
        hole_clearance: f64,
        pins: Vec<OutputPlace>,
    },
}

/// One ring pin.
#[derive(Debug, Clone, Copy)]
struct RingPlace {
    /// Gap as designed, m.
    gap: f64,
    /// Normal from flank to pin, components along and perpendicular to the eccentric.
    normal: Vec2,
    /// Radial and tangential components of the normal at the pin.
    outward: f64,
    around: f64,
    /// Position on the flank: angle on the disc, its unit vector, and the normal there.
    tau: f64,
    on_disc: [Vec2; 2],
}

/// One output pin.
#[derive(Debug, Clone, Copy)]
struct OutputPlace {
    /// Radial and tangential components of the eccentric's direction at the pin.
    outward: f64,
    around: f64,
}

/// A ring at the position of a disc, all angles in rad.
pub(super) struct RingAt<'a> {
    pub mesh: &'a RingMesh,
    /// Number of its first pin among the errors.
    pub first: usize,
    /// Angle of the first pin, and of the body that carries the centre of the pin circle.
    pub first_pin: f64,
    pub body: f64,
    /// Angles of the eccentric and of the disc.
    pub eccentric: f64,
    pub disc: f64,
}

impl Side {
    pub fn ring(stage: usize, weight: f64, at: &RingAt<'_>) -> Side {
        let (profile, e) = (&at.mesh.profile, unit(at.eccentric));
        let pins = (0..profile.pin_count).map(|pin| {
            let place = at.first_pin + std::f64::consts::TAU * pin as f64 / profile.pin_count as f64;
            let (tau, on_disc, gap) = contact(at, place);
            let (normal, outward) = (turned(on_disc, unit(at.disc)), unit(place));
            RingPlace {
                gap,
                normal: Vec2::new(normal.dot(&e), cross(e, normal)),
                outward: normal.dot(&outward),
                around: normal.dot(&quarter_turn(outward)),
                tau,
                on_disc: [unit(tau), on_disc],
            }
        });
        let (first, eccentric) = (at.first, at.eccentric - at.body);
        Side { stage, weight, places: Places::Ring { first, eccentric, pins: pins.collect() } }
    }

    /// Output pins, with the angles (rad) of the first pin and of the eccentric.
    pub fn output(stage: usize, pins: &OutputPins, first_pin: f64, eccentric: f64) -> Side {
        let e = unit(eccentric);
        let place = |pin: usize| {
            let outward = unit(std::f64::consts::TAU * pin as f64 / pins.count as f64 + first_pin);
            OutputPlace { outward: e.dot(&outward), around: e.dot(&quarter_turn(outward)) }
        };
        let OutputPins { circle_radius, hole_clearance, .. } = *pins;
        let pins = (0..pins.count).map(place).collect();
        Side { stage, weight: 1.0, places: Places::Output { circle_radius, hole_clearance, pins } }
    }

    /// Bounds of the free range from the pins at one disc, for depths (m) removed from flanks and from walls of
    /// holes. Bounds that others dominate at every shift within ±reach (m) are dropped.
    pub fn bounds(
        &self,
        disc: usize,
        errors: &StageErrors,
        reader: Option<&FlankErrorReader>,
        [off_flanks, off_holes]: [f64; 2],
        reach: f64,
    ) -> Bounds {
        let mut bounds = Bounds::default();
        match &self.places {
            Places::Ring { first, eccentric, pins } => {
                let off = centre(errors, *eccentric);
                for (pin, place) in pins.iter().enumerate() {
                    let gap = place.made(first + pin, off, errors, reader) + off_flanks;
                    let across = off_zero(place.normal.y);
                    let bound = Bound { at_rest: gap / across, per_shift: place.normal.x / across };
                    bounds[usize::from(across > 0.0)].push(bound);
                }
            }
            Places::Output { circle_radius, hole_clearance, pins } => {
                for (pin, place) in pins.iter().enumerate() {
                    let (own, hole) = (errors.output_pin(pin), errors.hole(disc, pin));
                    let clearance = hole_clearance + off_holes + 0.5 * hole.diameter - own.radius
                        + place.outward * (own.radial - hole.radial)
                        + place.around * (own.tangential - hole.tangential);
                    // A pin ahead of the eccentric approaches the hole's wall with a rotation of the output.
                    let lever = off_zero(-place.around) * circle_radius;
                    let bound = Bound { at_rest: clearance / lever, per_shift: 1.0 / lever };
                    bounds[usize::from(lever > 0.0)].push(bound);
                }
            }
        }
        let [below, above] = &mut bounds;
        drop_idle(below, -1.0, reach);
        drop_idle(above, 1.0, reach);
        bounds
    }

    /// Weighted sums over the pins of the contributions of errors to the gaps (m), and sums of the weights: for
    /// ring pins the square of the normal's component perpendicular to the eccentric. For ring and output pins.
    pub fn added(
        &self,
        disc: usize,
        errors: &StageErrors,
        reader: Option<&FlankErrorReader>,
    ) -> [[f64; 2]; 2] {
        let mut sums = [[0.0; 2]; 2];
        match &self.places {
            Places::Ring { first, eccentric, pins } => {
                let off = centre(errors, *eccentric);
                for (pin, place) in pins.iter().enumerate() {
                    let weight = place.normal.y * place.normal.y;
                    sums[0][0] += weight * (place.made(first + pin, off, errors, reader) - place.gap);
                    sums[0][1] += weight;
                }
            }
            Places::Output { pins, .. } => {
                for pin in 0..pins.len() {
                    sums[1][0] += 0.5 * errors.hole(disc, pin).diameter - errors.output_pin(pin).radius;
                    sums[1][1] += 1.0;
                }
            }
        }
        sums
    }
}

/// Contact of the nominal disc with a pin at an angle (rad): parameter, normal on the disc, and gap (m) as
/// designed.
fn contact(at: &RingAt<'_>, place: f64) -> (f64, Vec2, f64) {
    let profile = &at.mesh.profile;
    if profile.tip().is_none() {
        let tau = place - at.disc;
        return (tau, profile.outward_normal(tau), at.mesh.gap(profile.meshing_angle(tau)));
    }
    // The flank as cut, in a ring of the generating pins; depths of modification are added along the normal.
    let centre = profile.pin_circle_radius * unit(place) - profile.eccentricity * unit(at.eccentric);
    let foot = profile.foot(turned(centre, unit(-at.disc)), 0.0);
    let inwards = foot.normal.dot(&unit(place - at.disc));
    let gap = foot.distance + profile.pin_radius
        - at.mesh.ring_pin_radius
        - (profile.pin_circle_radius - at.mesh.ring_circle_radius) * inwards
        + at.mesh.relief.at(profile.meshing_angle(foot.tau)).depth;
    (foot.tau, foot.normal, gap)
}

/// Offset of the centre of the pin circle along and perpendicular to the eccentric, whose angle (rad) is in the
/// frame of the ring, m.
fn centre(errors: &StageErrors, eccentric: f64) -> Vec2 {
    let RunOut { amplitude, phase } = errors.pin_circle_offset;
    amplitude * unit(phase - eccentric)
}

impl RingPlace {
    /// Gap (m) with the errors of pin and flank for a disc in nominal position; `off` is the offset of the
    /// whole ring.
    fn made(&self, pin: usize, off: Vec2, errors: &StageErrors, reader: Option<&FlankErrorReader>) -> f64 {
        let own = errors.pin(pin);
        let [place, normal] = self.on_disc;
        self.gap + self.outward * own.radial + self.around * own.tangential + self.normal.dot(&off)
            - own.radius
            + reader.map_or(0.0, |reader| reader.depth(self.tau, place, normal))
    }
}
