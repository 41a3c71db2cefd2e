//! The housing as an elastic body: ring with pin grooves, seats of the main bearings, and flange held by bolts.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::body::{Body, Compliance, NodalLoad, Seat, Traction};
use super::carrier::translations;
use super::symmetry::{Mirrors, Symmetric, SymmetricPart, reflection_sign};
use super::{Boundary, FemError, Mesh, PlaneDomain, PlaneMesh};
use crate::geometry::{Outline, Segment, Vec2, unit};
use crate::machine::{Hold, HousingSolid, Machine};
use crate::materials::Material;

/// Geometry of the finite element model of a housing. x, y of the housing's frame, z along the carrier from
/// its input end.
#[derive(Debug, Clone, PartialEq)]
pub struct HousingShape {
    /// Dimensions of ring, seats and flange.
    pub solid: HousingSolid,
    /// Number of pins of the ring, each in a groove.
    pub pin_count: usize,
    /// m.
    pub pin_circle_radius: f64,
    /// Radius of the grooves in m.
    pub groove_radius: f64,
    /// Discs side by side, which share the length of the pins.
    pub disc_count: usize,
    /// Length of each main bearing's seat in m.
    pub seat_length: f64,
    /// Length of the pins in m, over all discs.
    pub pin_length: f64,
    /// Edge lengths in m: at the grooves, elsewhere.
    pub sizes: [f64; 2],
    /// Layers of elements through a main bearing's seat and through one disc's share of the pins.
    pub layers: [usize; 2],
}

/// Curves of the section, in this order; faces of bolts follow.
const FLANGE: usize = 0;
const BODY: usize = 1;
const SEAT: usize = 2;
const GROOVES: usize = 3;
const BOLTS: usize = 4;
/// Edge lengths relative to those elsewhere: at the edge of held faces, along the flange's foot, along the
/// seats' shoulders.
const RIM: f64 = 0.28;
const FOOT: f64 = 0.5;
const SHOULDER: f64 = 0.7;
/// Thickness of the layer over the held face relative to the layer from which it is cut; with a thinner one the
/// elements above it are too coarse.
const CLAMPED: f64 = 0.35;
/// Thickness of the layer below the far shoulder relative to the others.
const UNDER_SHOULDER: f64 = 0.72;
/// Five layers through a seat are 0.32, 0.26, 0.21, 0.15 and 0.06 of it.
const TOWARDS_SHOULDER: f64 = 1.7;

impl HousingShape {
    /// The housing of a machine with edges of 0.02 R_p at the grooves (seven edges in each; with four, the
    /// stiffness of the grooves along the ring is 0.5 % higher) and 0.1 R_p elsewhere, five layers through a
    /// seat (with three the eighth frequency is 0.3 % higher, with a single one the tenth 3 %), and two through
    /// a disc's part of the pins (with a single one grooves are 4 % too stiff).
    pub fn of(machine: &Machine) -> HousingShape {
        let r = machine.ring.pin_circle_radius;
        HousingShape {
            solid: machine.solids.housing.clone(),
            pin_count: machine.ring.pin_count,
            pin_circle_radius: r,
            groove_radius: machine.ring.pin_radius,
            disc_count: machine.disc_count,
            seat_length: machine.solids.carrier.plate_thickness,
            pin_length: machine.solids.carrier.gap,
            sizes: [0.02 * r, 0.1 * r],
            layers: [5, 2],
        }
    }

    /// Half-round grooves about the pin centres, with lands on the pin circle between them; segment 2i is the
    /// groove of pin i.
    fn grooves(&self) -> Outline {
        let (r, groove) = (self.pin_circle_radius, self.groove_radius);
        let edge = self.groove_edge();
        let pitch = TAU / self.pin_count as f64;
        let segments = (0..self.pin_count).flat_map(|i| {
            let pin = pitch * i as f64;
            let reach = FRAC_PI_2 + 0.5 * edge;
            [
                Segment::Arc {
                    centre: r * unit(pin),
                    radius: groove,
                    start: pin - reach,
                    sweep: 2.0 * reach,
                },
                Segment::Arc {
                    centre: Vec2::zeros(),
                    radius: r,
                    start: pin + edge,
                    sweep: pitch - 2.0 * edge,
                },
            ]
        });
        Outline { segments: segments.collect() }
    }

    /// Angle between pin and edge of its groove, about the axis, in rad.
    fn groove_edge(&self) -> f64 {
        2.0 * (0.5 * self.groove_radius / self.pin_circle_radius).asin()
    }

    fn has_flange(&self) -> bool {
        self.solid.flange_radius > self.solid.body_radius * (1.0 + 1e-9)
    }

    fn domain(&self) -> PlaneDomain {
        let solid = &self.solid;
        let [fine, coarse] = self.sizes;
        let circle = |centre: Vec2, radius: f64| Boundary::Circle { centre, radius };
        let mut boundaries = vec![
            (circle(Vec2::zeros(), solid.flange_radius), coarse, 0),
            (circle(Vec2::zeros(), solid.body_radius), FOOT * coarse, 0),
            (circle(Vec2::zeros(), solid.seat_radius), SHOULDER * coarse, 0),
            (Boundary::Outline(self.grooves()), fine, 0),
        ];
        boundaries.extend(self.bolts().map(|k| {
            let angle = solid.first_bolt_angle + TAU * k as f64 / solid.bolt_count as f64;
            (circle(solid.bolt_circle_radius * unit(angle), solid.bolt_face_radius), RIM * coarse, 0)
        }));
        PlaneDomain { boundaries, interior_size: coarse }
    }

    /// The bolts whose faces are held; `None` if the whole face of the flange is held.
    fn bolts(&self) -> std::ops::Range<usize> {
        0..if self.solid.hold == Hold::Bolts { self.solid.bolt_count } else { 0 }
    }

    fn check(&self) -> Result<(), FemError> {
        let s = &self.solid;
        let (r, groove) = (self.pin_circle_radius, self.groove_radius);
        let rules = [
            (self.has_flange(), "the flange must be wider than the ring"),
            (s.seat_radius > r + groove, "the seats of the main bearings must lie outside of the grooves"),
            (s.body_radius > s.seat_radius, "the ring must be wider than the seats of the main bearings"),
            (
                s.flange_thickness <= self.pin_length * (1.0 + 1e-9),
                "the flange is around the pins and cannot be thicker than their length",
            ),
            (
                s.hold == Hold::Face
                    || (s.bolt_circle_radius - s.bolt_face_radius > s.body_radius
                        && s.bolt_circle_radius + s.bolt_face_radius < s.flange_radius),
                "the faces of the bolts must lie on the flange",
            ),
            (
                self.pin_count as f64 * (0.5 * groove / r).asin() * 4.0 < TAU,
                "there must be a land between neighbouring grooves",
            ),
        ];
        match rules.iter().find(|(holds, _)| !holds) {
            Some((_, reason)) => Err(FemError::Mesh { reason: (*reason).to_owned() }),
            None => Ok(()),
        }
    }

    /// Heights between layers of elements: seat, pins (a layer per disc, cut by the flange's faces), seat.
    fn cuts(&self) -> Vec<f64> {
        let (seat, pins) = (self.seat_length, self.pin_length);
        let [through_seat, through_share] = self.layers.map(|layers| layers.max(1));
        let shares = self.disc_count * through_share;
        let mut cuts: Vec<f64> = (0..=shares).map(|j| seat + pins * j as f64 / shares as f64).collect();
        // Thinner towards the shoulders, where the section changes.
        if through_share > 1 {
            cuts[shares - 1] = seat + pins * (1.0 - UNDER_SHOULDER / shares as f64);
        }
        let depths = (0..through_seat)
            .map(|k| seat * (1.0 - (1.0 - k as f64 / through_seat as f64).powf(TOWARDS_SHOULDER)));
        cuts.extend(depths.flat_map(|z| [z, 2.0 * seat + pins - z]));
        cuts.extend(self.flange());
        cuts.sort_by(f64::total_cmp);
        cuts.dedup_by(|a, b| (*a - *b).abs() < 1e-3 * pins);
        // A thin layer over the held face.
        let held = cuts.partition_point(|z| *z < self.flange()[0] - 1e-3 * pins);
        cuts.insert(held + 1, cuts[held] + CLAMPED * (cuts[held + 1] - cuts[held]));
        cuts
    }

    /// Faces of the flange.
    fn flange(&self) -> [f64; 2] {
        let middle = self.seat_length + 0.5 * self.pin_length;
        [-0.5, 0.5].map(|side| middle + side * self.solid.flange_thickness)
    }

    /// Layers between two heights.
    fn layers(&self, cuts: &[f64], from: f64, to: f64) -> std::ops::Range<usize> {
        let near = 1e-3 * self.pin_length;
        cuts.partition_point(|z| *z < from - near)..cuts.partition_point(|z| *z < to - near)
    }

    fn meshed(&self, mirrors: Mirrors) -> Result<SymmetricPart, FemError> {
        let inside = |bits: u64, curve: usize| bits >> curve & 1 == 1;
        let metal = |bits: u64| inside(bits, FLANGE) && !inside(bits, GROOVES);
        let (plane, regions) = PlaneMesh::triangulate_part(&self.domain(), mirrors, metal)?;
        let cuts = self.cuts();
        let pins = self.layers(&cuts, self.seat_length, self.seat_length + self.pin_length);
        let [low, high] = self.flange();
        let flange = self.layers(&cuts, low, high);
        let mesh = Mesh::layered(plane, &cuts, |layer, triangle| {
            let bits = regions[triangle];
            let wide = inside(bits, BODY) || flange.contains(&layer);
            wide && (!inside(bits, SEAT) || pins.contains(&layer))
        });
        mesh.check()?;
        let level = 2 * flange.start * mesh.plane.nodes.len();
        // Edges of held faces, the flange's foot and the shoulders of the seats. The foot at the held face is
        // excluded: it is so close to the bolts that the nodes of elements between them would be displaced
        // towards both.
        let mut sharp = vec![false; mesh.nodes.len()];
        let mut mark = |curve: usize, layer: usize| {
            let first = 2 * layer * mesh.plane.nodes.len();
            mesh.plane.nodes_of(curve).into_iter().for_each(|node| sharp[first + node] = true);
        };
        self.bolts().for_each(|bolt| mark(BOLTS + bolt, flange.start));
        if self.solid.hold == Hold::Face {
            mark(BODY, flange.start);
        }
        mark(BODY, flange.end);
        [pins.start, pins.end].into_iter().for_each(|shoulder| mark(SEAT, shoulder));
        let mesh = mesh.drawn_towards(&sharp);
        let mut held = vec![[false; 3]; mesh.nodes.len()];
        for (triangle, bits) in mesh.plane.triangles.iter().zip(&regions) {
            let pressed = match self.solid.hold {
                Hold::Face => !inside(*bits, BODY),
                Hold::Bolts => bits >> BOLTS != 0,
            };
            if pressed {
                triangle.iter().for_each(|node| held[level + node] = [true; 3]);
            }
        }
        Ok(SymmetricPart { mesh, regions, held })
    }

    /// Index of the radial coordinate of a pin's groove; the tangential one follows.
    pub fn pin(&self, disc: usize, pin: usize) -> usize {
        2 * (disc * self.pin_count + pin)
    }

    /// Index of x of a main bearing's seat; `end` is 0 at the input.
    pub fn main_seat(&self, end: usize) -> usize {
        self.pin(self.disc_count, 0) + 2 * end
    }

    /// Number of equal sectors of the housing, by pins and bolts.
    pub fn symmetry(&self) -> usize {
        let common = |mut a: usize, mut b: usize| {
            while b > 0 {
                (a, b) = (b, a % b);
            }
            a
        };
        match self.solid.hold {
            Hold::Face => self.pin_count,
            Hold::Bolts => common(self.pin_count, self.solid.bolt_count),
        }
    }

    /// Compliance of all interface coordinates: for each disc and pin the radial (outward) and the tangential
    /// displacement of the groove over that disc's part of the pin, then x and y of the main bearing's seat at
    /// either end.
    ///
    /// # Errors
    /// [`FemError`] if dimensions contradict each other.
    pub fn compliance(&self) -> Result<Compliance, FemError> {
        Ok(self.over_sectors(&self.compliance_of(self.mirrors())?))
    }

    /// The mean over all rotations under which the housing is invariant, which removes differences of the mesh
    /// between sectors.
    fn over_sectors(&self, c: &Compliance) -> Compliance {
        let (count, sectors) = (c.count, self.symmetry());
        let (per_sector, seats) = (self.pin_count / sectors, self.main_seat(0));
        let mut values = vec![0.0; count * count];
        for turn in 0..sectors {
            // Rotation of the coordinates: pins are shifted, x and y of seats are rotated.
            let (sin, cos) = (TAU * turn as f64 / sectors as f64).sin_cos();
            let turned = |k: usize| -> [(usize, f64); 2] {
                match k.checked_sub(seats) {
                    None => [(self.shifted(k, turn * per_sector), 1.0), (k, 0.0)],
                    Some(seat) if seat % 2 == 0 => [(k, cos), (k + 1, sin)],
                    Some(_) => [(k, cos), (k - 1, -sin)],
                }
            };
            for (i, row) in values.chunks_exact_mut(count).enumerate() {
                for (j, value) in row.iter_mut().enumerate() {
                    for (a, p) in turned(i) {
                        *value +=
                            turned(j).iter().map(|(b, q)| p * q * c.at(a, *b)).sum::<f64>() / sectors as f64;
                    }
                }
            }
        }
        Compliance { count, values }
    }

    /// The coordinate of the pin that is `shift` pins further.
    fn shifted(&self, coordinate: usize, shift: usize) -> usize {
        let (component, place) = (coordinate % 2, coordinate / 2);
        let (disc, pin) = (place / self.pin_count, place % self.pin_count);
        self.pin(disc, (pin + shift) % self.pin_count) + component
    }

    /// Volume of the solid in m³, in closed form.
    pub fn volume(&self) -> f64 {
        let s = &self.solid;
        let disc = |radius: f64| PI * radius * radius;
        2.0 * self.seat_length * (disc(s.body_radius) - disc(s.seat_radius))
            + self.pin_length * (disc(s.body_radius) - self.grooves().area())
            + s.flange_thickness * (disc(s.flange_radius) - disc(s.body_radius))
    }
}

impl Symmetric for HousingShape {
    /// Common symmetry planes of pins and bolts through the axis.
    fn mirrors(&self) -> Mirrors {
        // Bolts are symmetric about a plane at this angle if twice the angle between it and the first bolt is a whole
        // number of pitches.
        let bolts_at = |plane: f64| match self.solid.hold {
            Hold::Face => true,
            Hold::Bolts => {
                let pitches =
                    2.0 * (plane - self.solid.first_bolt_angle) * self.solid.bolt_count as f64 / TAU;
                (pitches - pitches.round()).abs() < 1e-9
            }
        };
        Mirrors::of(self.pin_count.is_multiple_of(2) && bolts_at(FRAC_PI_2), bolts_at(0.0))
    }

    fn material(&self) -> &Material {
        &self.solid.material
    }

    /// Second attempt with edges of half the length, if curved edges of the grooves have inverted an element of a
    /// thin wall.
    fn mesh_part(&self, mirrors: Mirrors) -> Result<SymmetricPart, FemError> {
        self.check()?;
        match self.meshed(mirrors) {
            Err(FemError::InvertedElement { .. }) => {
                let [fine, coarse] = self.sizes;
                let groove = 0.25 * PI * self.groove_radius;
                HousingShape { sizes: [0.5 * fine.min(groove), 0.7 * coarse], ..self.clone() }.meshed(mirrors)
            }
            other => other,
        }
    }

    fn loads(&self, body: &Body) -> Vec<NodalLoad> {
        let cuts = self.cuts();
        let mut loads = Vec::new();
        let share = self.pin_length / self.disc_count as f64;
        for disc in 0..self.disc_count {
            let from = self.seat_length + share * disc as f64;
            for pin in 0..self.pin_count {
                let angle = TAU * pin as f64 / self.pin_count as f64;
                let seat = Seat {
                    curve: GROOVES,
                    parameters: [2.0 * pin as f64, 2.0 * pin as f64 + 1.0],
                    layers: self.layers(&cuts, from, from + share),
                    centre: self.pin_circle_radius * unit(angle),
                    radius: self.groove_radius,
                };
                let reach = FRAC_PI_2 + 0.5 * self.groove_edge();
                for across in [false, true] {
                    loads.push(body.load(&seat, Traction::Groove { bottom: angle, reach, across }));
                }
            }
        }
        let end = cuts[cuts.len() - 1];
        for (from, to) in [(0.0, self.seat_length), (end - self.seat_length, end)] {
            let seat =
                Seat::around(SEAT, self.layers(&cuts, from, to), Vec2::zeros(), self.solid.seat_radius);
            loads.extend(translations().map(|traction| body.load(&seat, traction)));
        }
        loads
    }

    fn reflected(&self, coordinate: usize, mirror: usize) -> (usize, f64) {
        let seats = self.main_seat(0);
        if coordinate >= seats {
            return (coordinate, reflection_sign((coordinate - seats) % 2, mirror));
        }
        let (across, place) = (coordinate % 2, coordinate / 2);
        let (disc, pin) = (place / self.pin_count, place % self.pin_count);
        let straight = if mirror == 0 { self.pin_count / 2 } else { 0 };
        let to = (straight + self.pin_count - pin) % self.pin_count;
        (self.pin(disc, to) + across, if across == 1 { -1.0 } else { 1.0 })
    }
}
