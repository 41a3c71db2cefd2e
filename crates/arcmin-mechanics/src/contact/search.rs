//! Search of contacts: from the pose of a disc to the state of its contacts.

use super::ContactForce;
use super::PinContact;
use super::ring::{DiscPose, DiscVelocity, PinContacts};
use super::worn_pin::turn_on_pin;
use crate::geometry::{Closest, Foot, LANES, Vec2, cross, quarter_turn, turned, unit};

/// Pins whose foot points are searched simultaneously.
#[derive(Default)]
struct Batch {
    count: usize,
    pin: [usize; LANES],
    /// Pin centre from the disc centre, in the housing frame and in the disc frame.
    arm: [Vec2; LANES],
    place: [Vec2; LANES],
    /// Start of the search: τ and e(τ).
    tau: [f64; LANES],
    direction: [Vec2; LANES],
}

impl Batch {
    #[inline]
    fn push(&mut self, pin: usize, arm: Vec2, place: Vec2, tau: f64, direction: Vec2) {
        let lane = self.count;
        self.pin[lane] = pin;
        self.arm[lane] = arm;
        self.place[lane] = place;
        self.tau[lane] = tau;
        self.direction[lane] = direction;
        self.count += 1;
    }
}

/// A contact, given by the foot of its pin on the unworn flank.
struct FromFoot<'a> {
    foot: &'a Foot,
    /// Depth of the flank's error there, in m.
    error: f64,
}

/// Displacements of pins and flank by elastic bodies, which the search of contacts includes.
#[derive(Debug, Clone, Copy, Default)]
pub struct Displacements<'a> {
    /// Displacement of every pin in m, in the frame of the ring; empty for a rigid ring.
    pub shifts: &'a [Vec2],
    /// Upper bound (m) of the flank's displacement towards a pin.
    pub lift: f64,
}

impl PinContacts {
    /// Calls `visit` for every pin (`all`) or for every pin that may touch.
    pub fn visit(&self, pose: DiscPose, velocity: DiscVelocity, all: bool, visit: impl FnMut(&PinContact)) {
        self.visit_displaced(pose, velocity, all, Displacements::default(), visit);
    }

    /// As [`PinContacts::visit`], with displaced pins and flank. Approach rates are those of pins at rest.
    pub fn visit_displaced(
        &self,
        pose: DiscPose,
        velocity: DiscVelocity,
        all: bool,
        moved: Displacements<'_>,
        mut visit: impl FnMut(&PinContact),
    ) {
        let rotation = unit(pose.angle);
        let back = Vec2::new(rotation.x, -rotation.y);
        // z_p β_i is a whole number of turns, so all pins share e(z τ) at the start of their search.
        let ez = unit(-(self.profile.pin_count as f64) * pose.angle);
        let pitch = std::f64::consts::TAU / self.pins.len() as f64;
        // Pins with a larger gap at the foot are skipped. Larger gaps matter only for contacts about to close: not at
        // rest, and not in quasi-static mechanisms, which have no damping.
        let still = velocity == DiscVelocity::REST || self.contact.damping.is_none();
        let skim = !all && self.facets.is_none() && still;
        let open = skim.then_some(self.reach + moved.lift);
        let bounded = !all && self.facets.is_none();
        // Near the end of a flank the global bound is used.
        let tip = self.profile.tip();
        let first_turn = self.profile.meshing_angle(-pose.angle) / std::f64::consts::TAU + 0.5;
        // With the position of the first pin, in turns of τ from 0.
        let errors = self.error_floors.as_ref();
        let errors = errors.map(|floors| (floors, (-pose.angle / std::f64::consts::TAU).rem_euclid(1.0)));
        let (mut near, mut next) = (Batch::default(), Batch::default());
        for first in (0..self.pins.len()).step_by(LANES) {
            let count = LANES.min(self.pins.len() - first);
            near.count = 0;
            for index in first..first + count {
                let mut arm = self.pins[index].centre - pose.centre;
                if let Some(shift) = moved.shifts.get(index) {
                    arm += shift;
                }
                let e = turned(self.directions[index], back);
                near.push(index, arm, turned(arm, back), pitch * index as f64 - pose.angle, e);
            }
            if !bounded {
                self.visit_batch(&mut near, ez, rotation, velocity, open, &mut visit);
                continue;
            }
            let (distances, ways) = match tip {
                None => self.profile.least_distances(&near.place, &near.direction, ez),
                Some(tip) => {
                    let least = |lane: usize| {
                        let (place, tau) = (near.place[lane], near.tau[lane]);
                        self.profile.least_distance_below_tip(place, tip, tau, near.direction[lane])
                    };
                    (
                        std::array::from_fn(|lane| if lane < count { least(lane) } else { f64::NAN }),
                        [f64::INFINITY; LANES],
                    )
                }
            };
            for lane in 0..count {
                let index = first + lane;
                // From pin to pin z_c τ increases by a turn less a pitch.
                let turn = first_turn + index as f64 / self.pins.len() as f64;
                let distance = match tip {
                    Some(_) => self.offset.least_distance(distances[lane]),
                    None => self.offset.distance_about(turn, distances[lane]),
                };
                let error = errors.map_or(0.0, |(floors, first)| {
                    let turn = first + index as f64 / self.pins.len() as f64;
                    let within = ways[lane] < floors.reach();
                    if within {
                        floors.at(if turn < 1.0 { turn } else { turn - 1.0 })
                    } else {
                        self.least_error
                    }
                });
                // False for NaN.
                if distance - self.pins[index].radius + error + self.shallowest_pin - moved.lift > self.reach
                {
                    continue;
                }
                next.push(index, near.arm[lane], near.place[lane], near.tau[lane], near.direction[lane]);
                if next.count == LANES {
                    self.visit_batch(&mut next, ez, rotation, velocity, open, &mut visit);
                }
            }
        }
        self.visit_batch(&mut next, ez, rotation, velocity, open, &mut visit);
    }

    #[inline]
    fn visit_batch(
        &self,
        batch: &mut Batch,
        ez: Vec2,
        rotation: Vec2,
        velocity: DiscVelocity,
        open: Option<f64>,
        visit: &mut impl FnMut(&PinContact),
    ) {
        if batch.count == 0 {
            return;
        }
        // Unused lanes repeat the first pin; results do not depend on the other lanes.
        for lane in batch.count..LANES {
            (batch.place[lane], batch.tau[lane], batch.direction[lane]) =
                (batch.place[0], batch.tau[0], batch.direction[0]);
        }
        self.profile.feet_from(
            (&batch.place, &batch.tau, &batch.direction),
            ez,
            batch.count,
            |lane, foot| {
                let pin = batch.pin[lane];
                // The flank error changes little from the foot to the closest point.
                let error = self
                    .error_reader
                    .as_ref()
                    .map_or(0.0, |error| error.depth(foot.tau, foot.direction(), foot.normal));
                // A worn pin has only lost metal. Beyond the end of a flank the corner or the land of its tip is touched.
                let is_open = |open: f64| {
                    let distance = self.offset.distance(self.profile.meshing_angle(foot.tau), foot.distance);
                    !foot.at_tip && distance - self.pins[pin].radius + error > open
                };
                if open.is_some_and(is_open) {
                    return;
                }
                let seen = FromFoot { foot, error };
                let (arm, place) = (batch.arm[lane], batch.place[lane]);
                visit(&self.contact_of(pin, arm, place, seen, rotation, velocity));
            },
        );
        batch.count = 0;
    }

    #[inline]
    fn contact_of(
        &self,
        pin: usize,
        arm: Vec2,
        p: Vec2,
        FromFoot { foot, error }: FromFoot<'_>,
        rotation: Vec2,
        velocity: DiscVelocity,
    ) -> PinContact {
        let radius = self.pins[pin].radius;
        let closest = if let Some(facets) = &self.facets {
            let nearest = facets.nearest(p, foot.tau, radius);
            Closest {
                tau: foot.tau,
                meshing_angle: self.profile.meshing_angle(foot.tau),
                gap: nearest.gap,
                normal: nearest.normal,
                flank_curvature: nearest.curvature,
                relative_curvature: 1.0 / radius,
            }
        } else if let Some(closest) = self.profile.closest_to_end(p, foot, &self.effective_relief, radius) {
            closest
        } else if self.effective_relief.is_uniform() {
            let depth = self.effective_relief.samples()[0];
            let curvature =
                foot.trace_curvature / (1.0 + (self.profile.pin_radius + depth) * foot.trace_curvature);
            Closest {
                tau: foot.tau,
                meshing_angle: self.profile.meshing_angle(foot.tau),
                gap: foot.distance + (self.profile.pin_radius - radius) + depth,
                normal: foot.normal,
                flank_curvature: curvature,
                relative_curvature: 1.0 / radius - curvature,
            }
        } else {
            self.profile.closest_on_worn(p, foot, &self.effective_relief, radius)
        };
        let Closest {
            meshing_angle, mut gap, normal: flank_normal, flank_curvature, relative_curvature, ..
        } = closest;
        let mut read = error;
        let direction = foot.direction();
        let normal = turned(flank_normal, rotation);
        let t = quarter_turn(normal);
        let mut gradient = [-normal.x, -normal.y, -normal.dot(&quarter_turn(arm))];
        let foot_normal = turned(foot.normal, rotation);
        let (mut pin_bend, mut pin_turn) = (0.0, [0.0; 3]);
        if let Some(worn) = self.worn_pin(pin, foot_normal) {
            pin_bend = worn.bend;
            pin_turn = turn_on_pin(quarter_turn(foot_normal), arm, foot.trace_curvature, foot.distance);
            read += worn.depth;
            gradient.iter_mut().zip(pin_turn).for_each(|(sum, turn)| *sum += worn.slope * turn);
        }
        gap += read;
        let designed_curvature = if self.facets.is_some() {
            1.0 / radius
        } else {
            let trace_curvature = match foot.at_tip {
                true => self.profile.trace_curvature(foot.cos_meshing),
                false => foot.trace_curvature,
            };
            self.profile.designed_curvature(trace_curvature, radius)
        };
        let [tau, slope, bend] = self.profile.contact_place(foot.tau);
        let place_by_foot = if foot.at_tip { [0.0; 2] } else { [slope, bend] };
        let along = [t.x, t.y, cross(arm, t) - radius];
        let v = velocity.as_array();
        let approach_rate = -(gradient[0] * v[0] + gradient[1] * v[1] + gradient[2] * v[2]);
        let sliding_speed = along[0] * v[0] + along[1] * v[1] + along[2] * v[2];
        // An open contact needs no radius.
        let ContactForce { force, stiffness, damping, elastic, stored } = if gap >= 0.0 {
            ContactForce::default()
        } else {
            self.contact.damped_force(-gap, approach_rate, 1.0 / designed_curvature)
        };
        let friction = match &self.sliding {
            Some(sliding) if force > 0.0 => -force * sliding.share(sliding_speed).0,
            _ => 0.0,
        };
        PinContact {
            pin,
            tau,
            meshing_angle,
            gap,
            approach_rate,
            force,
            stiffness,
            damping,
            elastic,
            stored,
            sliding_speed,
            friction,
            normal,
            arm,
            flank_curvature,
            relative_curvature,
            designed_curvature,
            gradient,
            pin_bend,
            pin_turn,
            along,
            meshing_unit: Vec2::new(foot.cos_meshing, foot.sin_meshing),
            direction,
            foot_normal,
            foot_distance: foot.distance,
            trace_curvature: foot.trace_curvature,
            place_by_foot,
            read,
        }
    }
}
