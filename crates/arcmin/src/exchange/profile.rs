use std::fmt::Write as _;

use super::outline::Outline;
use super::spline::FittedSpline;
use super::{ExchangeError, Stamp, millimetres, trimmed};
use crate::contact::Pin;
use crate::design::{DiscSection, StageDesign, TwoRingDesign, TwoStageDesign};
use crate::fem::{DiscShape, RoundHole};
use crate::geometry::{Profile, Relief, Segment, Vec2, turned, unit};
use crate::machine::{Bore, Machine, RingMesh, RingProfile, SingleStage};
use crate::materials::Material;
use crate::units::{DEG, MM, UM};

/// Which flank is handed over.
#[derive(Debug, Clone, PartialEq)]
pub enum Flank {
    /// The flank as the generating pins cut it: the modification's two offsets, but neither rotation nor free
    /// form.
    AsCut,
    /// With the whole modification.
    Modified,
    /// With the whole modification, less this wear.
    Worn(Relief),
}

/// Which parts a STEP file holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Parts {
    /// Every disc.
    Discs,
    /// One pin.
    Pin,
    /// A ring that is one part with its arcs.
    Ring,
    /// One crankshaft.
    Crankshaft,
    /// All of them in place at this crank angle in rad.
    Assembly {
        /// rad, counter-clockwise.
        crank_angle: f64,
    },
}

/// Openings of a disc: bores for the crankshafts, round holes, windows for pillars.
pub(super) struct Openings {
    pub bores: Vec<RoundHole>,
    pub holes: Vec<RoundHole>,
    pub windows: Vec<crate::geometry::Outline>,
}

/// Choices of an export of profiles and parts.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfileOptions {
    /// Flank that is drawn: as designed or worn.
    pub flank: Flank,
    /// Allowed distance of chords from the exact flank in m; splines keep a fiftieth of it.
    pub tolerance: f64,
    /// Distance in m by which the flank is moved out of the metal, along its normal: the radius of a wire or
    /// wheel and its gap, or stock that stays for grinding. Bores and holes are not moved.
    pub offset: f64,
    /// The only disc (from 0) that is handed over, as for a cutter; all of them if none is given.
    pub disc: Option<usize>,
}

impl Default for ProfileOptions {
    /// The modified flank within 1 µm, not moved.
    fn default() -> ProfileOptions {
        ProfileOptions { flank: Flank::Modified, tolerance: 1.0 * UM, offset: 0.0, disc: None }
    }
}

/// The discs' flank within a tolerance, and everything around it, ready to be written.
///
/// Frame of drawings: that of the flank, the root of τ = 0 on the x axis. All discs have the same flank;
/// their bores stand at the carrier's angles minus the mounting angle δ_j = −α_j/z_c of each.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfileExport {
    /// Of every disc, in the frame of its flank.
    shapes: Vec<DiscShape>,
    /// The pins of the ring as installed, about the ring's own centre.
    ring: Vec<Pin>,
    /// The ring as one part, where it is one.
    contour: Option<RingProfile>,
    /// An RV reducer; of single stages only discs and pins are drawn.
    machine: Option<Machine>,
    pub(super) stamp: Stamp,
    pub(super) options: ProfileOptions,
    pub(super) outline: Outline,
    /// Corners of the polyline over one lobe, from root to next root, the last left out.
    pub(super) corners: Vec<f64>,
    /// Root to crest and crest to root of the first lobe, each up to a corner and from there on where the lobe has a tip.
    pub(super) flanks: Vec<FittedSpline>,
    polyline_deviation: f64,
}

/// A disc with a flank and round openings, the first of which is the bore of its eccentric bearing, in the frame of the flank:
/// openings stand at their angles less `turned` (rad).
fn disc_shape(mesh: &RingMesh, openings: &[Bore], turned: f64, width: f64, material: &Material) -> DiscShape {
    let round = |hole: &Bore| RoundHole {
        centre: hole.centre_radius * unit(hole.centre_angle - turned),
        radius: hole.radius,
    };
    DiscShape {
        profile: mesh.profile.clone(),
        bores: openings[..1].iter().map(round).collect(),
        holes: openings[1..].iter().map(round).collect(),
        windows: Vec::new(),
        width,
        material: material.clone(),
    }
}

/// Splines keep this part of the tolerance: their error falls with the fourth power of the number of pieces,
/// so it costs 2.7 times as many points, and area and volume are then right to better than a millionth. At
/// the whole tolerance a mean of 0.15 µm on one side was 7e-6 of the disc's area.
const SPLINE_SHARE: f64 = 50.0;

impl ProfileExport {
    /// Prepares the export of a machine.
    ///
    /// # Errors
    /// An undercutting offset, a tolerance outside of 0.01 to 1000 µm or one that cannot be kept, a disc that the
    /// machine does not have.
    pub fn new(
        machine: &Machine,
        stamp: Stamp,
        options: ProfileOptions,
    ) -> Result<ProfileExport, ExchangeError> {
        let shapes = (0..machine.disc_count).map(|disc| DiscShape::of(machine, disc)).collect();
        let (relief, pins) = (machine.designed_relief(), machine.pins());
        ProfileExport::of(shapes, &relief, (pins, None), Some(machine.clone()), stamp, options)
    }

    /// Prepares the export of a single stage: the bore of the eccentric bearing in the centre of every disc, and holes for
    /// the output pins, which stand elsewhere against the lobes from disc to disc.
    ///
    /// # Errors
    /// As [`ProfileExport::new`].
    pub fn of_stage(design: &StageDesign, options: ProfileOptions) -> Result<ProfileExport, ExchangeError> {
        let stamp = Stamp::named(&design.name, &design.hash());
        ProfileExport::of_discs(design.drive(), &design.disc, stamp, options)
    }

    /// As [`ProfileExport::of_stage`] for both stages, that at the input first.
    ///
    /// # Errors
    /// As [`ProfileExport::new`].
    pub fn of_two_stages(
        design: &TwoStageDesign,
        options: &ProfileOptions,
    ) -> Result<[ProfileExport; 2], ExchangeError> {
        let export = |stage: &SingleStage, disc: &DiscSection| {
            let stamp = Stamp::named(&design.name, &design.hash());
            ProfileExport::of_discs(stage, disc, stamp, options.clone())
        };
        let drive = design.drive();
        Ok([export(&drive.first, &design.first_stage.disc)?, export(&drive.second, &design.disc)?])
    }

    /// The steps of the discs of a drive of two rings, that in the ring at rest first. Stepped discs are alike, with roots of
    /// both flanks on the x axis.
    ///
    /// # Errors
    /// As [`ProfileExport::new`].
    pub fn of_two_rings(
        design: &TwoRingDesign,
        options: &ProfileOptions,
    ) -> Result<[ProfileExport; 2], ExchangeError> {
        let drive = design.drive();
        let export = |k: usize| {
            let mesh = &drive.meshes[k];
            let shape = disc_shape(mesh, &drive.openings, 0.0, drive.widths[k], &design.disc.material);
            let stamp = Stamp::named(&design.name, &design.hash());
            let shapes = vec![shape; drive.phases.len()];
            let ring = (mesh.pins(), mesh.ring_profile());
            ProfileExport::of(shapes, &mesh.relief, ring, None, stamp, options.clone())
        };
        Ok([export(0)?, export(1)?])
    }

    fn of_discs(
        stage: &SingleStage,
        disc: &DiscSection,
        stamp: Stamp,
        options: ProfileOptions,
    ) -> Result<ProfileExport, ExchangeError> {
        let shape = |j: usize| {
            let turned = stage.mounting(j);
            disc_shape(&stage.mesh, &stage.openings, turned, *disc.width_mm * MM, &disc.material)
        };
        let shapes = (0..stage.phases.len()).map(shape).collect();
        let ring = (stage.pins(), stage.ring_profile());
        ProfileExport::of(shapes, &stage.relief, ring, None, stamp, options)
    }

    fn of(
        shapes: Vec<DiscShape>,
        designed: &Relief,
        (ring, contour): (Vec<Pin>, Option<RingProfile>),
        machine: Option<Machine>,
        stamp: Stamp,
        options: ProfileOptions,
    ) -> Result<ProfileExport, ExchangeError> {
        let within = |what, value: f64, unit: f64, low, high| {
            let value = value / unit;
            if (low..=high).contains(&value) {
                Ok(())
            } else {
                Err(ExchangeError::Option { what, value, low, high })
            }
        };
        within("a tolerance in µm", options.tolerance, UM, 0.01, 1000.0)?;
        within("an offset in µm", options.offset, UM, -1e5, 1e5)?;
        if let Some(disc) = options.disc.filter(|disc| *disc >= shapes.len()) {
            return Err(ExchangeError::NoDisc { disc: disc + 1, count: shapes.len() });
        }
        let relief = match &options.flank {
            Flank::AsCut => Relief::uniform(0.0),
            Flank::Modified => designed.clone(),
            Flank::Worn(wear) => designed.plus(wear),
        };
        let outline = Outline::new(shapes[0].profile.clone(), relief, options.offset)?;
        // A thousandth is left for the decimals of the file.
        let tolerance = 0.999 * options.tolerance;
        let breaks = outline.breaks();
        let (mut corners, mut flanks, mut polyline_deviation) = (Vec::new(), Vec::new(), 0.0_f64);
        for pair in breaks.windows(2) {
            let course = outline.between(pair[0], pair[1]);
            let (chords, deviation) = course.chords(pair[0], pair[1], tolerance);
            corners.extend(&chords[..chords.len() - 1]);
            polyline_deviation = polyline_deviation.max(deviation);
            flanks.push(FittedSpline::along(&course, pair[0], pair[1], tolerance / SPLINE_SHARE));
        }
        let reached = flanks.iter().map(|flank| flank.deviation).fold(polyline_deviation, f64::max);
        if !(reached <= options.tolerance) {
            return Err(ExchangeError::Tolerance { reached, tolerance: options.tolerance });
        }
        Ok(ProfileExport {
            shapes,
            ring,
            contour,
            machine,
            stamp,
            options,
            outline,
            corners,
            flanks,
            polyline_deviation,
        })
    }

    /// The exact edge.
    pub fn outline(&self) -> &Outline {
        &self.outline
    }

    /// Bound of the distance between polyline and exact edge in m.
    pub fn polyline_deviation(&self) -> f64 {
        self.polyline_deviation
    }

    /// Bound of the distance between splines and exact edge in m.
    pub fn spline_deviation(&self) -> f64 {
        self.flanks.iter().map(|flank| flank.deviation).fold(0.0, f64::max)
    }

    /// Corners of the polyline around the whole disc in m.
    pub fn polyline(&self) -> Vec<Vec2> {
        let lobe: Vec<Vec2> = self.corners.iter().map(|tau| self.outline.at(*tau).place).collect();
        let turns = (0..self.outline.lobe_count()).map(|k| unit(self.outline.lobe_pitch() * k as f64));
        turns.flat_map(|turn| lobe.iter().map(move |place| turned(*place, turn))).collect()
    }

    /// Openings of disc j (from 0), in the frame of its flank.
    pub(super) fn openings(&self, disc: usize) -> Openings {
        let shape = self.shapes[disc].clone();
        let windows = shape.windows.iter().map(|window| window.outline()).collect();
        Openings { bores: shape.bores, holes: shape.holes, windows }
    }

    /// The discs that are handed over.
    pub(super) fn discs(&self) -> std::ops::Range<usize> {
        self.options.disc.map_or(0..self.shapes.len(), |disc| disc..disc + 1)
    }

    /// Stamps of every file, one sentence a line.
    pub fn stamps(&self) -> Vec<String> {
        let flank = match self.options.flank {
            Flank::AsCut => "as cut",
            Flank::Modified => "modified",
            Flank::Worn(_) => "worn",
        };
        let um = |metres: f64| trimmed(metres / UM, 4);
        vec![
            format!(
                "arcmin {}, design {} ({})",
                self.stamp.version, self.stamp.design_hash, self.stamp.design_name
            ),
            format!(
                "flank {flank}, moved outwards by {} um; unit mm; origin in the disc's centre, a root on the x axis",
                um(self.options.offset)
            ),
            format!(
                "largest deviation from the exact flank: polyline {} um, spline {} um",
                um(self.polyline_deviation),
                um(self.spline_deviation())
            ),
        ]
    }

    /// The corners of the polyline as a table: place, outward normal, arc length from the first root, meshing
    /// angle, radius of curvature (concave positive as in `profile.csv`, empty where straight). Lines with #
    /// carry the stamp.
    pub fn csv(&self) -> String {
        let mut text = String::new();
        for line in self.stamps() {
            let _ = writeln!(text, "# {line}");
        }
        text.push_str(
            "x_mm,y_mm,outward_normal_x,outward_normal_y,arc_length_mm,meshing_angle_deg,curvature_radius_mm\n",
        );
        let mut lengths = vec![0.0];
        for pair in self.corners.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + self.outline.length(pair[0], pair[1]));
        }
        let last = self.corners[self.corners.len() - 1];
        let lobe_length = lengths[lengths.len() - 1] + self.outline.length(last, self.outline.lobe_pitch());
        for lobe in 0..self.outline.lobe_count() {
            let turn = unit(self.outline.lobe_pitch() * lobe as f64);
            for (tau, length) in self.corners.iter().zip(&lengths) {
                let point = self.outline.at(*tau);
                let (place, normal) = (turned(point.place, turn), turned(point.outward_normal(), turn));
                let radius = -1.0 / point.curvature;
                let radius = if radius.abs() < 1e6 { millimetres(radius) } else { String::new() };
                let _ = writeln!(
                    text,
                    "{},{},{},{},{},{},{radius}",
                    millimetres(place.x),
                    millimetres(place.y),
                    trimmed(normal.x, 12),
                    trimmed(normal.y, 12),
                    millimetres(length + lobe as f64 * lobe_length),
                    trimmed(self.outline.meshing_angle(*tau) / DEG, 9),
                );
            }
        }
        text
    }

    /// The ring as one part, about its own centre.
    ///
    /// # Errors
    /// [`ExchangeError::NoPart`] where it is made of pins.
    pub(super) fn contour(&self) -> Result<&RingProfile, ExchangeError> {
        self.contour.as_ref().ok_or(ExchangeError::NoPart("the ring is made of pins"))
    }

    /// How far a drawing reaches from the centre, m.
    pub(super) fn reach(&self) -> f64 {
        let (circle, pin) = self.ring_radii();
        1.1 * self.contour.as_ref().map_or(circle + pin, |ring| ring.outer_radius)
    }

    /// One pin in its place at the centre.
    ///
    /// # Errors
    /// [`ExchangeError::NoPart`] where the ring is one part.
    pub(super) fn separate_pin(&self) -> Result<f64, ExchangeError> {
        match self.contour {
            None => Ok(self.ring_radii().1),
            Some(_) => Err(ExchangeError::NoPart("the ring is one part and has no pins")),
        }
    }

    /// The theoretical pin ring: places and radius of the installed pins in m, about the ring's own centre.
    pub(super) fn pins(&self) -> Vec<(Vec2, f64)> {
        self.ring.iter().map(|pin| (pin.centre, pin.radius)).collect()
    }

    /// Radius of the circle of the pins and of a pin in m.
    pub(super) fn ring_radii(&self) -> (f64, f64) {
        (self.ring[0].centre.norm(), self.ring[0].radius)
    }

    /// Face width of a disc in m.
    pub(super) fn width(&self) -> f64 {
        self.shapes[0].width
    }

    /// Heights of the discs' lower sides in m, 0 in the middle; discs of a single stage touch.
    pub(super) fn floors(&self) -> Vec<f64> {
        let (count, width) = (self.shapes.len(), self.width());
        match &self.machine {
            Some(machine) => super::crankshaft::heights(machine).0,
            None => (0..count).map(|disc| (disc as f64 - 0.5 * count as f64) * width).collect(),
        }
    }

    /// The RV reducer, for parts that only it has.
    pub(super) fn reducer(&self) -> Result<&Machine, ExchangeError> {
        self.machine.as_ref().ok_or(ExchangeError::NoPart("only discs and ring of a single stage are drawn"))
    }

    /// The flank profile without offset, for messages.
    pub fn profile(&self) -> &Profile {
        self.outline.profile()
    }

    /// Area in m² inside of the exact edge less bores, holes and windows, and the length of all edges in m.
    pub fn disc_area_and_length(&self) -> (f64, f64) {
        let (mut area, mut length) = self.outline.area_and_length();
        let openings = self.openings(0);
        for hole in openings.bores.iter().chain(&openings.holes) {
            area -= std::f64::consts::PI * hole.radius * hole.radius;
            length += std::f64::consts::TAU * hole.radius;
        }
        for window in &openings.windows {
            area -= window.area();
            length += window.segments.iter().map(Segment::length).sum::<f64>();
        }
        (area, length)
    }
}
