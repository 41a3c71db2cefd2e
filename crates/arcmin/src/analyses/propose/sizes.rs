//! Sizes of a single stage from its requirements.
//!
//! Rules. The number of lobes is the ratio times the tooth difference. The pin circle is as large as the housing permits. All combinations are
//! tried of K1 from 0.55 to 0.75 in steps of 0.05, of standard dowel pins in the ring, of standard eccentric
//! bearings, and of 6 to 12 output pins with standard bushes, as far outside as the rim under the roots allows. A
//! combination is rejected if its flank is near undercut or ends before its longest lever arm, its lobes have no land, its pins are too close to each other, its walls are too
//! thin, its eccentric leaves no shaft, or its output pins bend too much. The width of the two discs follows from the
//! closed forms of the ring pins, 4T/(K1 z_c R) times the crowding of flanks that end, and of the output pins, 4T/(z_w R_w), at the largest pressure.
//! Combinations whose eccentric bearing reaches the service life come first, then the narrowest, then those with
//! bushes, then those with the least bending of the output pins.

use std::cmp::Ordering;
use std::f64::consts::PI;

use super::demand::{Demand, Nearest, Shortfall};
use super::gaps::Gaps;
use super::process::{BALL_BEARINGS_MM, DOWELS_MM, Makes, Making, NEEDLE_CAGES_MM, OUTPUT_PINS_MM};
use crate::design::Choice;
use crate::geometry::Profile;
use crate::machine::{RollerBearing, RollerKind, ring_slant};
use crate::materials::{BEARING_STEEL, effective_modulus};
use crate::rig::rating_life;
use crate::units::{DEG, HOUR, MM, MPA, UM};

/// An eccentric bearing, mm.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bearing {
    pub(super) name: String,
    pub(super) kind: RollerKind,
    pub(super) bore: f64,
    pub(super) outer: f64,
    /// Least width of the disc: it is no narrower than its bearing.
    width: f64,
    pub(super) rollers: usize,
    pub(super) roller_diameter: f64,
    pub(super) clearance_um: f64,
}

/// A single stage with everything but the width of its discs.
#[derive(Debug, Clone)]
pub struct Proposal {
    pub(super) demand: Demand,
    pub(super) gaps: Gaps,
    pub(super) lobes: usize,
    pub(super) circle_mm: f64,
    pub(super) pin_mm: f64,
    pub(super) eccentricity_mm: f64,
    pub(super) bearing: Bearing,
    pub(super) output_count: usize,
    pub(super) output_circle_mm: f64,
    /// Diameters of pin and bush.
    pub(super) output_mm: [f64; 2],
    pub(super) shaft_mm: f64,
    /// Width by the closed forms, at least that of the bearing.
    pub width_mm: f64,
    /// Bending stress of the output pins in Pa, with equal springs and this width.
    pub(super) bending: f64,
    pub(super) life_h: f64,
}

const K1: [f64; 5] = [0.55, 0.6, 0.65, 0.7, 0.75];
/// Diameter of ring pins over the distance of their axes: the least that is tried, and the largest, with a gap of a
/// fifth of the diameter between pins.
const PIN_TO_PITCH: (f64, f64) = (0.3, 1.0 / 1.2);
/// Sharpest convex radius of the flank over the radius of the pin, as checked.
const SHARPEST_TO_PIN: f64 = 0.2;
/// Land of a lobe over the radius of the pin, as checked.
const LAND_TO_PIN: f64 = 0.1;
/// Wall beside a hole over its radius, as checked.
const WALL_TO_HOLE: f64 = 0.1;
/// Step of the circle of output pins, mm.
const CIRCLE_STEP_MM: f64 = 0.05;
const OUTPUT_COUNTS: [usize; 4] = [6, 8, 10, 12];
/// Wall of the eccentric beside the shaft, mm, and the least shaft.
const ECCENTRIC_WALL_MM: f64 = 0.75;
const LEAST_SHAFT_MM: f64 = 3.0;
/// Torsion of the shaft, Pa.
const SHAFT_STRESS: f64 = 30.0 * MPA;
/// Alternating bending of hardened output pins, Pa.
pub(super) const BENDING: f64 = 300.0 * MPA;
/// Largest force of an output pin over that of equal springs, since with gaps fewer pins carry: first guess.
const FEWER_CARRY: f64 = 2.0;

const DISCS: f64 = 2.0;

/// Up to half a millimetre.
pub(super) fn half_mm(width: f64) -> f64 {
    (2.0 * width - 1e-9).ceil() / 2.0
}

/// Largest bending stress in Pa of an output pin of the diameter (m), clamped half a width beside two discs, under a force on one.
pub(super) fn pin_bending(force: f64, width: f64, diameter: f64) -> f64 {
    let [a, b, span] = [0.5 * width, 1.5 * width, 2.0 * width];
    force * a * b * b / (span * span) * 32.0 / (PI * diameter.powi(3))
}

impl Demand {
    /// Valid combinations with these gaps, the best first.
    ///
    /// # Errors
    /// The check that fails, if no combination passes.
    pub fn proposals(&self, gaps: Gaps) -> Result<Vec<Proposal>, Shortfall> {
        let making = self.process.making();
        let mut short = Nearest::default();
        let mut found = Vec::new();
        for k1 in K1 {
            for pin_mm in DOWELS_MM {
                match Teeth::new(self, (&making, gaps), k1, 0.5 * pin_mm) {
                    Ok(teeth) => teeth.fill(self, &making, &mut found, &mut short),
                    Err((stage, shortfall)) => short.note(stage, shortfall),
                }
            }
        }
        if found.is_empty() {
            return Err(short.0.map_or_else(Shortfall::none, |(_, shortfall)| shortfall));
        }
        let rank = |p: &Proposal| {
            let [pin, bush] = p.output_mm;
            [
                -(p.life_h / making.service_life_h).min(1.0),
                half_mm(p.width_mm),
                if bush > pin { 0.0 } else { 1.0 },
                p.bending,
                -p.life_h,
            ]
        };
        found.sort_by(|a, b| {
            let pairs = rank(a).into_iter().zip(rank(b));
            pairs.map(|(a, b)| a.total_cmp(&b)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
        });
        Ok(found)
    }
}

/// Ring and flank of a combination.
struct Teeth {
    gaps: Gaps,
    profile: Profile,
    lobes: usize,
    circle_mm: f64,
    pin_mm: f64,
    eccentricity_mm: f64,
    /// Width in m for the pressure of the ring pins.
    width: f64,
    slant: f64,
}

impl Teeth {
    /// The error contains the number of the failing rule; later rules are nearer to a valid drive.
    fn new(
        demand: &Demand,
        (making, gaps): (&Making, Gaps),
        k1: f64,
        pin_radius_mm: f64,
    ) -> Result<Teeth, (usize, Shortfall)> {
        let difference = demand.tooth_difference;
        let lobes = (difference as f64 * demand.ratio) as usize;
        let pins = (lobes + difference) as f64;
        let diameter = demand.outer_diameter_mm;
        let housing = (making.housing * diameter).max(making.wall_mm);
        let circle_mm = (10.0 * (0.5 * diameter - housing - pin_radius_mm)).floor() / 10.0;
        let pitch = 2.0 * circle_mm * (PI / pins).sin();
        let share = 2.0 * pin_radius_mm / pitch;
        // Thin pins are skipped; if none remains, the thinnest one is too thick.
        if !(PIN_TO_PITCH.0..=PIN_TO_PITCH.1).contains(&share) || circle_mm <= 0.0 {
            let message = format!(
                "pin-overlap: ring pins of {} mm stand {pitch:.2} mm apart; they need {:.2} mm",
                2.0 * pin_radius_mm,
                2.0 * pin_radius_mm / PIN_TO_PITCH.1
            );
            let excess = if share > PIN_TO_PITCH.1 { share / PIN_TO_PITCH.1 } else { f64::INFINITY };
            return Err((0, Shortfall::new(message, excess)));
        }
        let hundredths = 100.0 * k1 * circle_mm * difference as f64 / pins;
        // Towards the middle of the range, so that K1 stays in it.
        let eccentricity_mm = if k1 > 0.65 { hundredths.floor() } else { hundredths.ceil() } / 100.0;
        if eccentricity_mm < making.eccentricity_mm {
            let message = format!(
                "tooth height: {lobes} lobes on this circle have teeth of 2 e = {:.2} mm; {} needs {:.2} mm",
                2.0 * eccentricity_mm,
                demand.process.word(),
                2.0 * making.eccentricity_mm
            );
            return Err((1, Shortfall::new(message, making.eccentricity_mm / eccentricity_mm)));
        }
        let profile = Profile::new(
            lobes + difference,
            circle_mm * MM,
            eccentricity_mm * MM,
            pin_radius_mm * MM + gaps.profile_um * UM,
        );
        let profile = profile
            .with_teeth(difference, None)
            .map_err(|error| (2, Shortfall::new(format!("tips: {error}"), f64::INFINITY)))?;
        let sharpest = profile.sharpest_convex_trace().0;
        let needed = profile.pin_radius + SHARPEST_TO_PIN * pin_radius_mm * MM;
        if sharpest < needed || profile.short_width_coefficient() >= 1.0 {
            let message = format!(
                "undercut: ring pins of {} mm need a path with convex radii of {:.2} mm; it has {:.2} mm",
                2.0 * pin_radius_mm,
                needed / MM,
                sharpest / MM
            );
            return Err((2, Shortfall::new(message, needed / sharpest)));
        }
        if let Some(tip) = profile.tip() {
            let (land, needed) = (tip.land(lobes) / MM, LAND_TO_PIN * pin_radius_mm);
            let longest = profile.short_width_coefficient().acos();
            if land < needed || tip.end < longest {
                let message = format!(
                    "tip-land: the lobes have lands of {land:.3} mm and need {needed:.3} mm; their flanks reach to {:.1}° of meshing \
                     angle, the longest lever is at {:.1}°",
                    tip.end / DEG,
                    longest / DEG
                );
                return Err((2, Shortfall::new(message, (needed / land).max(longest / tip.end))));
            }
        }
        let share = demand.torque / DISCS;
        let largest =
            share * 4.0 * profile.crowding() / (profile.lobes_per_turn() * profile.eccentricity * pins);
        // p² = F E*/(π B R_eq): the width for the largest F/R_eq, each pin with the force of its lever.
        let last = profile.last_meshing_angle() / DEG;
        let worst = (1..180)
            .filter(|degrees| f64::from(*degrees) <= last)
            .map(|degrees| {
                let phi = f64::from(degrees) * DEG;
                let force = largest * profile.lever_arm(phi).abs() / profile.largest_lever_arm();
                force * profile.relative_curvature(phi.cos(), pin_radius_mm * MM)
            })
            .fold(0.0, f64::max);
        let width = worst * modulus(making) / (PI * (making.pressure_mpa * MPA).powi(2));
        let slant = ring_slant(&profile, profile.pin_circle_radius);
        Ok(Teeth { gaps, profile, lobes, circle_mm, pin_mm: pin_radius_mm, eccentricity_mm, width, slant })
    }

    /// All combinations of bearing and output pins in these teeth.
    fn fill(&self, demand: &Demand, making: &Making, found: &mut Vec<Proposal>, short: &mut Nearest) {
        let e = self.eccentricity_mm;
        let root = self.profile.root_radius() / MM;
        let rim = making.wall_mm.max(self.pin_mm);
        let share = demand.torque / DISCS;
        let shaft_mm = {
            let cube = 16.0 * demand.torque / (demand.ratio * PI * SHAFT_STRESS);
            (cube.cbrt() / MM).max(LEAST_SHAFT_MM)
        };
        let least_bore = shaft_mm + 2.0 * (e + ECCENTRIC_WALL_MM);
        let all = bearings(making);
        let largest = all.iter().map(|bearing| bearing.bore).fold(0.0, f64::max);
        if largest < least_bore {
            let message = format!(
                "shaft: {shaft_mm:.1} mm and the eccentric need a bearing with a bore of {least_bore:.1} mm; the largest has {largest} mm"
            );
            short.note(3, Shortfall::new(message, least_bore / largest));
        }
        for bearing in all.into_iter().filter(|bearing| bearing.bore >= least_bore) {
            for output_mm in OUTPUT_PINS_MM {
                let hole = 0.5 * output_mm[1] + e + self.gaps.hole_um * UM / MM;
                let wall = making.wall_mm.max(WALL_TO_HOLE * hole);
                // The circle is rounded inwards.
                let inner = making.wall_mm.max(WALL_TO_HOLE * hole + CIRCLE_STEP_MM);
                let needed = 0.5 * bearing.outer + inner + 2.0 * hole + rim;
                if needed > root {
                    let message = format!(
                        "room in the disc: shaft, eccentric bearing, holes of the output pins and walls need {needed:.2} mm up to the \
                         roots, which lie at {root:.2} mm ({} and output pins of {} mm)",
                        bearing.name, output_mm[0]
                    );
                    short.note(3, Shortfall::new(message, needed / root));
                    continue;
                }
                let circle = ((root - rim - hole) * (1.0 / CIRCLE_STEP_MM)).floor() / (1.0 / CIRCLE_STEP_MM);
                for count in OUTPUT_COUNTS {
                    let between = 2.0 * circle * (PI / count as f64).sin() - 2.0 * hole;
                    if between < wall {
                        continue;
                    }
                    let force = 4.0 * share / (count as f64 * circle * MM);
                    let [pin, roller] = output_mm.map(|diameter| 0.5 * diameter * MM);
                    let curvature = 1.0 / roller - 1.0 / (hole * MM);
                    let by_holes =
                        force * curvature * modulus(making) / (PI * (making.pressure_mpa * MPA).powi(2));
                    let width = self.width.max(by_holes).max(bearing.width * MM).max(making.width_mm * MM);
                    let widest = making.widest * demand.outer_diameter_mm;
                    if width / MM > widest {
                        let message = format!(
                            "contact-pressure: by the closed forms ring pins need discs of {:.1} mm, output pins of \
                                 {:.1} mm, the \
                             bearing for {} mm; the widest are {widest} mm, {} of the outer diameter",
                            self.width / MM,
                            by_holes / MM,
                            bearing.width,
                            making.widest
                        );
                        short.note(4, Shortfall::new(message, width / MM / widest));
                        continue;
                    }
                    let even = pin_bending(force, width, 2.0 * pin);
                    let bending = FEWER_CARRY * even;
                    if bending > BENDING {
                        let message = format!(
                            "bending of the output pins: {count} pins of {} mm have a bending stress of about {:.0} \
                                 MPa; {:.0} MPa are allowed",
                            output_mm[0],
                            bending / MPA,
                            BENDING / MPA
                        );
                        short.note(5, Shortfall::new(message, bending / BENDING));
                        continue;
                    }
                    let across = share / self.profile.largest_lever_arm();
                    let along = 4.0 * share / (PI * circle * MM) - across * self.slant;
                    let turns = demand.speed_rpm / 60.0 * (1.0 + 1.0 / demand.ratio);
                    let life_h = rating_life(&bearing.rolling(), across.hypot(along), turns) / HOUR;
                    found.push(Proposal {
                        demand: *demand,
                        gaps: self.gaps,
                        lobes: self.lobes,
                        circle_mm: self.circle_mm,
                        pin_mm: self.pin_mm,
                        eccentricity_mm: e,
                        bearing: bearing.clone(),
                        output_count: count,
                        output_circle_mm: circle,
                        output_mm,
                        shaft_mm,
                        width_mm: width / MM,
                        bending: even,
                        life_h,
                    });
                }
            }
        }
    }
}

/// E* in Pa of a disc on a pin of bearing steel.
fn modulus(making: &Making) -> f64 {
    effective_modulus(&making.material.material(), &BEARING_STEEL.material())
}

/// Balls of 0.28 of the difference of outer diameter and bore, 0.55 of a full row: deep groove bearings are assembled
/// eccentrically.
const BALL: (f64, f64) = (0.28, 0.55);
/// A cage takes a third of the row.
const NEEDLES: f64 = 0.65;
/// Length of needles over the width of their cage.
const NEEDLE_LENGTH: f64 = 0.8;

/// Bearings that a disc of this process can hold.
fn bearings(making: &Making) -> Vec<Bearing> {
    let row = |pitch: f64, roller: f64, share: f64| (share * PI * pitch / roller).floor().max(5.0) as usize;
    let needles = NEEDLE_CAGES_MM.iter().filter(|_| making.is_hardened).map(|[bore, outer, width]| {
        let roller_diameter = 0.5 * (outer - bore);
        Bearing {
            name: format!("needle cage K{bore}x{outer}x{width}, rollers in the bore of the disc"),
            kind: RollerKind::Cylindrical,
            bore: *bore,
            outer: *outer,
            width: *width,
            rollers: row(0.5 * (bore + outer), roller_diameter, NEEDLES),
            roller_diameter,
            clearance_um: 5.0,
        }
    });
    let balls = BALL_BEARINGS_MM.iter().map(|(name, [bore, outer, width])| {
        let roller_diameter = (100.0 * BALL.0 * (outer - bore)).round() / 100.0;
        Bearing {
            name: format!("ball bearing {name}, {bore} x {outer} x {width} mm"),
            kind: RollerKind::Ball,
            bore: *bore,
            outer: *outer,
            width: *width,
            rollers: row(0.5 * (bore + outer), roller_diameter, BALL.1),
            roller_diameter,
            clearance_um: 10.0,
        }
    });
    balls.chain(needles).collect()
}

impl Bearing {
    pub(super) fn pitch(&self) -> f64 {
        0.5 * (self.bore + self.outer)
    }

    pub(super) fn length(&self) -> Option<f64> {
        (self.kind != RollerKind::Ball).then_some(NEEDLE_LENGTH * self.width)
    }

    fn rolling(&self) -> RollerBearing {
        RollerBearing {
            kind: self.kind,
            roller_count: self.rollers,
            roller_diameter: self.roller_diameter * MM,
            roller_length: self.length().unwrap_or(0.0) * MM,
            pitch_diameter: self.pitch() * MM,
            contact_angle: 0.0,
            clearance: self.clearance_um * UM,
            dynamic_load_rating: None,
        }
    }
}

impl Proposal {
    /// Largest pressure of flanks and holes in Pa.
    pub(super) fn pressure(&self) -> f64 {
        self.demand.process.making().pressure_mpa * MPA
    }

    /// Diameter of the output pins in m.
    pub(super) fn output_pin(&self) -> f64 {
        self.output_mm[0] * MM
    }

    /// Widest disc over the outer diameter.
    pub(super) fn widest_share(&self) -> f64 {
        self.demand.process.making().widest
    }

    /// Widest disc, mm.
    pub(super) fn widest_mm(&self) -> f64 {
        (2.0 * self.widest_share() * self.demand.outer_diameter_mm).floor() / 2.0
    }
}
