//! The sections of the design file that describe supports, losses, loads, wear and limits.

use super::Section;
use super::field::Choice;
use super::schema::{At, default, default_word, optional, required, section, word};
use super::sections::SECTION_OR_DEFAULTS;
use crate::contact::ContactLawName;
use crate::machine::RollerKind;
use crate::named::LawName;
use crate::tribology::WearLawName;

section! {
    /// Bearings and supports, used where the joints are not ideal.
    pub struct BearingsSection {
        /// Turning-arm bearings between eccentric and disc bore: one per crankshaft and disc.
        turning_arm: Section<RollerBearingSection> => word(),
        /// Crank supports between crankshaft and carrier: two per crankshaft.
        crank_support: Section<RollerBearingSection> => word(),
        /// Distance between the two supports of a crankshaft.
        crank_support_span_mm: f64 => required(1.0, 2000.0),
        /// The pair of main bearings between carrier and housing.
        main: Section<MainBearingSection> => word(),
        /// Radial stiffness of the sun's support: the input shaft and its bearing.
        sun_radial_stiffness_n_per_um: f64 => default(50.0, 0.1, 1e6),
    }

    /// A rolling bearing given by its geometry.
    pub struct RollerBearingSection {
        /// Shape of the rolling elements.
        kind: RollerKind => word(),
        /// Number of rolling elements.
        roller_count: usize => required(3.0, 200.0),
        /// Diameter of a rolling element.
        roller_diameter_mm: f64 => required(0.3, 200.0),
        /// Effective length of a roller; for balls the key is left out.
        roller_length_mm: Option<f64> => optional(0.3, 500.0),
        /// Diameter of the circle through the centres of the rolling elements.
        pitch_diameter_mm: f64 => required(1.0, 2000.0),
        /// Contact angle.
        contact_angle_deg: f64 => default(0.0, 0.0, 60.0),
        /// Diametral clearance; negative is preload.
        clearance_um: f64 => default(0.0, -100.0, 500.0),
        /// Basic dynamic load rating C as the maker states it. Left out, it is computed from the geometry
        /// (ISO 281).
        dynamic_load_rating_kn: Option<f64> => optional(0.01, 1e5),
    }

    /// The main bearings as one linear radial support.
    pub struct MainBearingSection {
        /// Radial stiffness of the pair.
        radial_stiffness_n_per_um: f64 => required(0.1, 1e6),
        /// Diametral clearance.
        clearance_um: f64 => default(0.0, 0.0, 1000.0),
        /// Its rows, for tilt, moments and axial forces.
        rows: Section<MainRowsSection> => SECTION_OR_DEFAULTS,
    }

    /// The main bearings as two equal rows. Missing keys are scaled from the space between the carrier's plates
    /// and the seats in the housing; these rules are assumptions.
    pub struct MainRowsSection {
        /// Shape of the rolling elements. Left out: "ball".
        kind: Option<RollerKind> => optional(0.0, 0.0),
        /// Number of rolling elements of a row. Left out: they fill 90 % of the circle.
        roller_count: Option<usize> => optional(3.0, 500.0),
        /// Diameter of a rolling element. Left out: 0.6 of the space between plate and seat.
        roller_diameter_mm: Option<f64> => optional(0.3, 200.0),
        /// Effective length of a roller. Left out: its diameter.
        roller_length_mm: Option<f64> => optional(0.3, 500.0),
        /// Diameter of the circle through the centres of the rolling elements. Left out: midway between plate
        /// and seat.
        pitch_diameter_mm: Option<f64> => optional(1.0, 4000.0),
        /// Contact angle. Left out: 40°.
        contact_angle_deg: Option<f64> => optional(0.0, 80.0),
        /// Distance of the two rows. Left out: that of the middles of the plates.
        spacing_mm: Option<f64> => optional(0.1, 2000.0),
        /// Axial preload of each row as an approach; negative is play. Left out: 5 µm.
        preload_um: Option<f64> => optional(-500.0, 200.0),
        /// Arrangement of the two rows. Left out: "back-to-back".
        arrangement: Option<Arrangement> => optional(0.0, 0.0),
        /// Basic dynamic load rating C of one row as the maker states it. Left out, it is computed (ISO 281).
        dynamic_load_rating_kn: Option<f64> => optional(0.01, 1e5),
    }

    /// Friction coefficients and losses; without this section the machine is frictionless.
    pub struct FrictionSection {
        /// Coulomb coefficient between flank and pin.
        flank_coefficient: f64 => default(0.0, 0.0, 1.0),
        /// Coulomb coefficient between pin and seat.
        pin_seat_coefficient: f64 => default(0.0, 0.0, 1.0),
        /// Rolling friction coefficient of the bearings, on their mean radius.
        bearing_coefficient: f64 => default(0.0, 0.0, 0.5),
        /// Coulomb coefficient of the gear meshes.
        gear_mesh_coefficient: f64 => default(0.0, 0.0, 1.0),
        /// Constant drag torque of the seals at the output, at 20 °C. One lip on a diameter d drags with about
        /// 244 N/m · d² when new, a third of it when run in.
        seal_drag_n_m: f64 => default(0.0, 0.0, 1e5),
        /// Viscous drag at the input.
        oil_drag_n_m_s_per_rad: f64 => default(0.0, 0.0, 100.0),
        /// Sliding speed below which Coulomb friction grows smoothly from zero.
        regularisation_speed_mm_s: f64 => default(1.0, 1e-4, 1e3),
        /// No-load drag of the bearings as a multiple of Palmgren's formula: 1 uses his factors for grease and the
        /// preload of the main bearings; 0 is none.
        bearing_drag_factor: f64 => default(0.0, 0.0, 20.0),
        /// Axial preload of each crank support; its drag follows Palmgren's factors. Needs supports
        /// with a contact angle.
        crank_support_preload_n: f64 => default(0.0, 0.0, 1e6),
    }

    /// Elastic law and damping of a contact between flank and pin.
    pub struct ContactSection {
        /// Force from approach.
        law: ContactLawName => default_word("line-hertz"),
        /// Stiffness per pin, only with the law "linear".
        stiffness_n_per_um: Option<f64> => optional(0.1, 1e5),
        /// Stiffness k per pin in F = k δ^e, only with the law "impact".
        impact_stiffness_n_per_mm_e: Option<f64> => optional(1.0, 1e10),
        /// Exponent e, only with the law "impact".
        impact_exponent: Option<f64> => optional(1.0, 3.0),
        /// Damping c of one contact.
        damping_n_s_per_m: f64 => default(2000.0, 0.0, 1e7),
        /// Depth over which the damping grows from zero to its full value.
        damping_depth_um: f64 => default(1.0, 1e-3, 1e3),
    }

    /// Rated load at the output and rated speed at the input.
    pub struct LoadSection {
        /// Rated output torque.
        rated_torque_n_m: f64 => required(1e-3, 1e7),
        /// Rated input speed; the sign is the sense of rotation.
        input_speed_rpm: f64 => required(-30000.0, 30000.0),
    }

    /// One row of the load spectrum.
    pub struct DutySection {
        /// Output torque, positive against positive (counter-clockwise) output motion.
        torque_n_m: f64 => required(-1e7, 1e7),
        /// Input speed; the sign is the sense of rotation.
        input_speed_rpm: f64 => required(-30000.0, 30000.0),
        /// Share of the running time. The shares of all rows add up to 1; rounded shares, as 3 × 0.3333, are scaled
        /// to this sum.
        share: f64 => required(1e-9, 1.0),
        /// External tilting moment on the output; it acts on the life of the main bearings and, with joints in bearings, on the wear.
        moment_n_m: f64 => default(0.0, 0.0, 1e7),
        /// External axial force on the output, positive out of the machine.
        axial_n: f64 => default(0.0, -1e8, 1e8),
        /// External radial force on the output in the middle of the main bearings, in the plane of the moment.
        radial_n: f64 => default(0.0, -1e8, 1e8),
    }

    /// Wear of flanks and pins: at each point dh/dt = k × the local rate of the wear law.
    pub struct WearSection {
        /// Local rate of wear. Left out: Archard's law.
        law: Section<WearLawSection> => OPTIONAL_SECTION,
        /// Wear coefficient k of the coupled prediction, in which the load sharing follows the worn flank.
        coupled: Section<CoefficientSection> => word(),
        /// Wear coefficient k of the uniform-depth study of Tao2024. Left out, it is that of `wear.coupled`.
        paper: Option<Section<CoefficientSection>> => optional(0.0, 0.0),
        /// Faster wear at the beginning. Left out: none.
        running_in: Option<Section<RunningInSection>> => optional(0.0, 0.0),
        /// Wear coefficient of the pins relative to that of the discs; of single stages also that of output pins and rollers.
        pin_ratio: f64 => default(0.0, 0.0, 1e4),
        /// Mixed lubrication: k decreases with the film ratio λ. Left out: k does not depend on the film.
        lubrication: Option<Section<LubricationSection>> => optional(0.0, 0.0),
        /// Wear of the turning-arm bearings, of single stages the eccentric bearings, which widens their clearance. Left out: none.
        turning_arm: Option<Section<RollingWearSection>> => optional(0.0, 0.0),
        /// Wear of the crank supports. Left out: none.
        crank_support: Option<Section<RollingWearSection>> => optional(0.0, 0.0),
        /// Wear of the teeth of the sun. Left out: none.
        sun: Option<Section<PartWearSection>> => optional(0.0, 0.0),
        /// Wear of the teeth of the planets. Left out: none.
        planet: Option<Section<PartWearSection>> => optional(0.0, 0.0),
    }

    /// The wear law of flanks and pins. Bearings and gears wear by Archard's.
    pub struct WearLawSection {
        /// Local rate.
        name: WearLawName => default_word("archard"),
        /// Exponent m of the pressure, only with the law "pressure-power".
        exponent: Option<f64> => optional(0.5, 10.0),
        /// Pressure below which there is no wear, only with the law "pressure-power".
        threshold_mpa: Option<f64> => optional(0.0, 5000.0),
        /// Rate of a new surface relative to that of the smooth one, only with the law "smoothing".
        factor: Option<f64> => optional(1.0, 1e4),
        /// Depth of the order of the roughness over which the rate falls, only with the law "smoothing".
        smoothing_depth_um: Option<f64> => optional(0.01, 100.0),
    }

    /// Wear of gear teeth by Archard's law, Δh = k (F/b) ξ per pass; k in exactly one of the ways
    /// `coefficient_per_pa`; `coefficient_mm2_per_n`; `archard_coefficient` with `hardness_mpa`.
    pub struct PartWearSection {
        /// k in 1/Pa.
        coefficient_per_pa: Option<f64> => optional(1e-24, 1e-11),
        /// k in mm²/N; 1 mm²/N is 1e-6 1/Pa.
        coefficient_mm2_per_n: Option<f64> => optional(1e-18, 1e-5),
        /// Archard's dimensionless K; k = K/H.
        archard_coefficient: Option<f64> => optional(1e-14, 1.0),
        /// Hardness H of the softer surface.
        hardness_mpa: Option<f64> => optional(10.0, 1e5),
    }

    /// Wear of a roller bearing by Archard's law with the slip of its rollers; k as for gear teeth. Only the
    /// product of k and slip counts.
    pub struct RollingWearSection {
        /// k in 1/Pa.
        coefficient_per_pa: Option<f64> => optional(1e-24, 1e-11),
        /// k in mm²/N; 1 mm²/N is 1e-6 1/Pa.
        coefficient_mm2_per_n: Option<f64> => optional(1e-18, 1e-5),
        /// Archard's dimensionless K; k = K/H.
        archard_coefficient: Option<f64> => optional(1e-14, 1.0),
        /// Hardness H of the softer surface.
        hardness_mpa: Option<f64> => optional(10.0, 1e5),
        /// Sliding distance per rolled distance at either raceway. There is no value for all bearings, so it
        /// must be given.
        slip: f64 => required(1e-6, 1.0),
    }

    /// The wear coefficient, in exactly one of these ways: `coefficient_per_pa`; `coefficient_mm2_per_n`;
    /// `archard_coefficient` with `hardness_mpa`; `after_h` with `depth_um`; `after_h` with
    /// `lost_motion_arcmin`.
    pub struct CoefficientSection {
        /// k in 1/Pa.
        coefficient_per_pa: Option<f64> => optional(1e-24, 1e-11),
        /// k in mm²/N; 1 mm²/N is 1e-6 1/Pa.
        coefficient_mm2_per_n: Option<f64> => optional(1e-18, 1e-5),
        /// Archard's dimensionless K; k = K/H.
        archard_coefficient: Option<f64> => optional(1e-14, 1.0),
        /// Hardness H of the softer surface.
        hardness_mpa: Option<f64> => optional(10.0, 1e5),
        /// Hours after which the depth or the lost motion below was observed, at this file's duty.
        after_h: Option<f64> => optional(1e-3, 1e7),
        /// Depth of the deepest point of the flank after these hours.
        depth_um: Option<f64> => optional(1e-3, 5000.0),
        /// Increase of the lost motion after these hours.
        lost_motion_arcmin: Option<f64> => optional(1e-4, 600.0),
    }

    /// k(t) = k (1 + (factor − 1) e^(−t/duration)).
    pub struct RunningInSection {
        /// Wear coefficient of the new machine relative to the steady one.
        factor: f64 => required(1.0, 1e4),
        /// Time constant.
        duration_h: f64 => required(1e-3, 1e6),
    }

    /// Inputs of the film ratio λ.
    pub struct LubricationSection {
        /// Dynamic viscosity at running temperature.
        viscosity_mpa_s: f64 => required(0.01, 1e6),
        /// Pressure–viscosity coefficient.
        pressure_viscosity_per_gpa: f64 => default(20.0, 0.1, 100.0),
        /// Combined RMS roughness of flank and pin.
        roughness_um: f64 => required(1e-3, 50.0),
    }

    /// Temperature, oil and cooling; for the test bench.
    pub struct ThermalSection {
        /// Temperature of housing and oil. If given, parts expand and the friction of flanks, seats, gears and
        /// oil depends on the film. Left out: all dimensions as drawn (20 °C) and friction as given.
        temperature_c: Option<f64> => optional(-30.0, 150.0),
        /// Temperature of discs, shafts and carrier above that of the housing, in kelvin.
        internal_excess_k: f64 => default(0.0, -50.0, 50.0),
        /// Thermal expansion of discs, pins, shafts and carrier.
        steel_expansion_um_per_m_k: f64 => default(11.5, 0.1, 40.0),
        /// Thermal expansion of the housing.
        housing_expansion_um_per_m_k: f64 => default(11.5, 0.1, 40.0),
        /// ISO VG grade of the oil or of the grease's base oil: mm²/s at 40 °C.
        iso_vg: f64 => default(150.0, 2.0, 3200.0),
        /// Kinematic viscosity at 100 °C. Left out: that of a mineral oil of this grade, viscosity index 95.
        viscosity_100c_mm2_s: Option<f64> => optional(0.5, 500.0),
        /// Pressure–viscosity coefficient.
        pressure_viscosity_per_gpa: f64 => default(20.0, 0.1, 100.0),
        /// Combined RMS roughness of flank and pin.
        roughness_um: f64 => default(0.4, 1e-3, 50.0),
        /// Temperature around the machine.
        ambient_c: f64 => default(20.0, -60.0, 80.0),
        /// Heat transfer of the surface, radiation included; still air 10 to 20.
        heat_transfer_w_m2_k: f64 => default(15.0, 0.1, 1e4),
        /// Surface that dissipates heat. Left out: that of the housing with its flange, both ends included.
        surface_m2: Option<f64> => optional(1e-5, 100.0),
        /// Heat that flows into the mounting per kelvin above the surroundings. Left out: that of a long arm of cast
        /// iron, a tube as wide as the flange with a wall of 10 mm; an insulated mounting is 0.
        mounting_conductance_w_k: Option<f64> => optional(0.0, 1e5),
    }

    /// Limits of the design.
    pub struct LimitsSection {
        /// Largest lost motion at the output.
        lost_motion_arcmin: f64 => default(1.0, 1e-3, 600.0),
        /// Largest contact pressure.
        contact_pressure_mpa: f64 => default(2000.0, 10.0, 10000.0),
        /// Planned service life.
        service_life_h: f64 => default(6000.0, 1e-2, 1e7),
        /// Largest transmission error over one full period, peak to peak at rated torque. Left out: no
        /// limit.
        transmission_error_arcmin: Option<f64> => optional(1e-4, 600.0),
        /// Largest backlash: travel of the output at no load from one flank to the other, input locked. Left
        /// out: no limit.
        backlash_arcmin: Option<f64> => optional(1e-3, 600.0),
        /// Permitted torque at start and stop in daily operation; no row of the duty may exceed it.
        /// Left out: no limit.
        start_stop_torque_n_m: Option<f64> => optional(1e-3, 1e7),
        /// Torque of an emergency stop: the pressure of flanks and pins must stay below 4000 MPa (ISO 76). Left out: not
        /// checked.
        emergency_torque_n_m: Option<f64> => optional(1e-3, 1e7),
        /// Largest speed of the output; no row of the duty may exceed it. Left out: no limit.
        output_speed_rpm: Option<f64> => optional(1e-3, 1e5),
        /// The maker's life in hours at rated torque and 15 rpm of the output; converted to the duty by ISO 281
        /// (exponent 10/3). Left out: no limit.
        catalogue_life_h: Option<f64> => optional(1.0, 1e7),
        /// Hertz pressure that flanks and pins endure for 5·10⁷ passes without pitting; by the life factors of
        /// ISO 6336-2 the permitted pressure is higher for fewer passes. Left out: fatigue is not checked.
        contact_endurance_mpa: Option<f64> => optional(10.0, 10000.0),
    }
}

/// The rule of sections whose keys all have defaults.
pub(super) const OPTIONAL_SECTION: super::schema::Rule = SECTION_OR_DEFAULTS;

/// A key that is a parameter of a law, with its value in the file.
pub(super) type Parameter<'a> = (&'static str, &'a At<Option<f64>>);

impl Choice for ContactLawName {
    const WORDS: &'static [(&'static str, &'static str)] = <ContactLawName as LawName>::WORDS;
    const VALUES: &'static [ContactLawName] = ContactLawName::NAMES;
}

impl Choice for WearLawName {
    const WORDS: &'static [(&'static str, &'static str)] = <WearLawName as LawName>::WORDS;
    const VALUES: &'static [WearLawName] = WearLawName::NAMES;
}

impl WearLawSection {
    /// The keys that parameters of the laws have.
    pub(super) fn parameters(&self) -> [Parameter<'_>; 4] {
        [
            ("exponent", &self.exponent),
            ("threshold_mpa", &self.threshold_mpa),
            ("factor", &self.factor),
            ("smoothing_depth_um", &self.smoothing_depth_um),
        ]
    }
}

impl ContactSection {
    /// The keys that parameters of the laws have.
    pub(super) fn parameters(&self) -> [Parameter<'_>; 3] {
        [
            ("stiffness_n_per_um", &self.stiffness_n_per_um),
            ("impact_stiffness_n_per_mm_e", &self.impact_stiffness_n_per_mm_e),
            ("impact_exponent", &self.impact_exponent),
        ]
    }
}

/// Arrangement of the two rows of the main bearings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrangement {
    /// Contact lines spread away from each other (O).
    BackToBack,
    /// Contact lines meet between the rows (X).
    FaceToFace,
}

impl Choice for Arrangement {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("back-to-back", "contact lines spread away from each other (O)"),
        ("face-to-face", "contact lines meet between the rows (X)"),
    ];
    const VALUES: &'static [Arrangement] = &[Arrangement::BackToBack, Arrangement::FaceToFace];
}

impl Choice for RollerKind {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("cylindrical", "cylindrical rollers or needles"),
        ("tapered", "tapered rollers"),
        ("ball", "balls"),
    ];
    const VALUES: &'static [RollerKind] = &[RollerKind::Cylindrical, RollerKind::Tapered, RollerKind::Ball];
}
