//! The reducer in SI units, with the invariants that every solver relies on.
//!
//! Frames: the housing is at rest, ring of `z_p` pins with pin i at angle 2π i/z_p; sun (input) θ_s, carrier
//! (output) θ_o, crankshafts θ_k, discs θ_j. All angles are absolute and counter-clockwise positive.

mod access;
mod angles;
mod assumed;
mod bearings;
mod errors;
mod kinematics;
mod made_play;
mod part_wear;
mod parts;
mod pin_beam;
mod ring_mesh;
mod ring_profile;
mod single_stage;
mod solids;
mod stage_errors;
mod stage_thermal;
mod thermal;
mod tolerances;
mod two_ring;
mod two_stage;

pub use access::InvalidAssumption;
pub use angles::{CrankAngle, OutputAngle};
pub use bearings::{BearingSet, RollerBearing, RollerKind, SupportStiffness, roller_spacing};
pub use errors::gcd;
pub use errors::{BoreError, DiscError, EccentricError, ManufacturingErrors, PinError, RunOut};
pub use kinematics::Kinematics;
pub use made_play::{GapChain, Overlap, OverlapPlace};
pub use part_wear::{Around, PartWear, PartWearLaws, RollingWear};
pub use parts::{
    Bore, Carrier, Crankshafts, CycloidDisc, DutyPoint, FixedMember, FlankModification, Friction, GearStage,
    Housing, OutputForces, PinMounting, PinRing, RingPartner, RunningIn, Wear, WearCoefficient,
};
pub use pin_beam::{PinBeam, PinStress};
pub use ring_mesh::RingMesh;
pub use ring_mesh::ring_slant;
pub use ring_profile::RingProfile;
pub use single_stage::{OutputPins, PlayChain, SingleStage, StageFriction};
pub use solids::{CarrierSolid, Hold, HousingSolid, MainRows, Solids};
pub(crate) use solids::{SolidsBasis, WindowRoom};
pub use stage_errors::{PartCounts, StageErrors, StageOffsets, StageTolerances};
pub use stage_thermal::StageThermal;
pub use thermal::{REFERENCE_C, Thermal, WarmFriction, arm_conductance};
pub use tolerances::{Batch, Tolerances};
pub use two_ring::TwoRing;
pub use two_stage::TwoStage;

use crate::contact::{ContactLaw, Damping, LineContact, Pin, PinContacts};
use crate::geometry::{Profile, Relief, unit};

/// A complete RV reducer in SI units.
///
/// It is created from a validated design ([`Design::machine`](crate::design::Design::machine)), so that every
/// solver may rely on it: sizes are positive, numbers finite, parts compatible. Variants are derived from
/// modified designs ([`Design::with`](crate::design::Design::with)).
///
/// ```
/// # extern crate arcmin_mechanics as arcmin;
/// let design = arcmin::templates::design("rv-40e-81").unwrap();
/// let machine = design.with("ring.pin_radius_mm", 3.05)?.machine();
/// assert!((machine.ring().pin_radius - 3.05e-3).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Name from the design file.
    pub name: String,
    /// Pins in the housing.
    pub ring: PinRing,
    /// One of the discs, which are equal except for the phase of their eccentric.
    pub disc: CycloidDisc,
    /// Discs side by side on every crankshaft.
    pub disc_count: usize,
    /// Crankshafts with their eccentrics and planets.
    pub crankshafts: Crankshafts,
    /// Sun and planets.
    pub gear_stage: GearStage,
    /// Carrier with output flange.
    pub carrier: Carrier,
    /// Housing, which is the output if the carrier is fixed.
    pub housing: Housing,
    /// Carrier and housing as solids for finite element models.
    pub solids: Solids,
    /// The fixed member; the other one is the output.
    pub fixed_member: FixedMember,
    /// Bearings of crankshafts, carrier and input.
    pub bearings: BearingSet,
    /// Coefficients and drags at the reference temperature.
    pub friction: Friction,
    /// Temperature, oil and heat transfer.
    pub thermal: Thermal,
    /// Force law of pins against flanks.
    pub contact_law: ContactLaw,
    /// Damping of these contacts in motion.
    pub contact_damping: Damping,
    /// Rated operating point: output torque in N·m, input speed in rad/s.
    pub rated: DutyPoint,
    /// Load spectrum for wear; one point with the share 1 where only the rated point is known.
    pub duty: Vec<DutyPoint>,
    /// Laws and coefficients of wear.
    pub wear: Wear,
    /// Limits for comparison with results.
    pub limits: Limits,
}

/// Limits set by the user.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Lost motion at the output in rad.
    pub lost_motion: f64,
    /// Largest contact pressure in Pa.
    pub contact_pressure: f64,
    /// Planned service life in s.
    pub service_life: f64,
    /// Transmission error in rad, peak to peak at rated torque.
    pub transmission_error: Option<f64>,
    /// Travel at no load in rad.
    pub backlash: Option<f64>,
    /// Largest torque of the duty at starts and stops, N·m.
    pub start_stop_torque: Option<f64>,
    /// Largest torque of an emergency stop, N·m.
    pub emergency_torque: Option<f64>,
    /// Output speed in rad/s.
    pub output_speed: Option<f64>,
    /// The maker's life in s at rated torque and 15 rpm of the output.
    pub catalogue_life: Option<f64>,
    /// Hertz pressure in Pa that flanks and pins endure for 5·10⁷ passes.
    pub contact_endurance: Option<f64>,
}

impl Machine {
    /// Whether the duty has forces or moments on the output in addition to the torque.
    pub fn duty_tilts(&self) -> bool {
        DutyPoint::any_tilts(&self.duty)
    }

    /// As [`DutyPoint::largest_signed_torque`].
    pub fn largest_signed_torque(&self) -> f64 {
        DutyPoint::largest_signed_torque(self.rated.torque, &self.duty)
    }

    /// The flank as cut: generating circle and pin radius differ from the installed ones by the offsets of
    /// the modification.
    pub fn profile(&self) -> Profile {
        let cut = &self.disc.modification;
        Profile::new(
            self.ring.pin_count,
            self.ring.pin_circle_radius + cut.radial_offset,
            self.crankshafts.eccentricity,
            self.ring.pin_radius + cut.equidistant_offset,
        )
    }

    /// Nominal pin places.
    pub fn pins(&self) -> Vec<Pin> {
        let count = self.ring.pin_count;
        (0..count)
            .map(|i| Pin {
                centre: self.ring.pin_circle_radius * unit(std::f64::consts::TAU * i as f64 / count as f64),
                radius: self.ring.pin_radius,
            })
            .collect()
    }

    /// The contact of disc and pins under the machine's law, without damping.
    pub fn line_contact(&self) -> LineContact {
        LineContact::new(
            self.contact_law,
            &self.disc.material,
            &self.ring.material,
            self.disc.width,
            self.ring.pin_radius,
        )
    }

    /// All contacts of one disc with the wear depth `wear` on its flanks in addition to the designed relief.
    pub fn pin_contacts(&self, wear: &Relief) -> PinContacts {
        PinContacts::new(self.profile(), self.pins(), self.designed_relief().plus(wear), self.line_contact())
    }

    /// Relief of the modification in addition to the two offsets: rotation and free form.
    pub fn designed_relief(&self) -> Relief {
        self.disc.modification.relief(&self.profile())
    }

    /// Coulomb coefficient between flank and pin; for pins that turn in their seats the smaller of flank and
    /// seat, because they slide where friction is smaller.
    pub fn flank_friction(&self) -> f64 {
        match self.ring.mounting {
            PinMounting::Fixed | PinMounting::OnePiece => self.friction.flank,
            PinMounting::Spinning => self.friction.flank.min(self.friction.pin_seat),
        }
    }

    /// All bores and holes of a disc: crank bores, further holes, centre hole, in this order.
    pub fn disc_bores(&self) -> Vec<Bore> {
        let (disc, cranks) = (&self.disc, &self.crankshafts);
        let crank_bores = (0..cranks.count).map(|k| Bore {
            radius: disc.crank_bore_radius,
            centre_radius: self.gear_stage.centre_distance(),
            centre_angle: Kinematics::crankshaft_angle(cranks.first_angle, k, cranks.count),
        });
        let centre = Bore { radius: disc.centre_hole_radius, centre_radius: 0.0, centre_angle: 0.0 };
        let holes = disc.holes.iter().copied().chain([centre]);
        crank_bores.chain(holes.filter(|hole| hole.radius > 0.0)).collect()
    }

    /// Ratios, phases and nominal poses.
    pub fn kinematics(&self) -> Kinematics {
        Kinematics::new(self)
    }
}
