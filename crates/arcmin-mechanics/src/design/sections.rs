//! The sections of the design file that describe the mechanism.

use super::Section;
use super::field::Choice;
use super::schema::{At, default, default_word, optional, required, section, word};
use crate::machine::{FixedMember, Hold, PinMounting};
use crate::materials::Material;
use crate::units::MPA;

section! {
    /// A material that is not in the library, written as an inline table.
    pub struct MaterialTable {
        /// Name for reports.
        name: String => default_word("own material"),
        /// Young's modulus E.
        youngs_modulus_gpa: f64 => required(1.0, 1200.0),
        /// Poisson's ratio ν.
        poisson_ratio: f64 => required(0.0, 0.49),
        /// Density.
        density_g_cm3: f64 => required(0.5, 25.0),
        /// Yield strength; for printed parts with tension across the layers the strength in that direction.
        /// Left out: unknown, and no strength is checked.
        yield_strength_mpa: Option<f64> => optional(1.0, 5000.0),
        /// Highest permitted temperature: glass transition or heat deflection of a plastic, tempering of a
        /// hardened steel. Left out: unknown.
        softening_temperature_c: Option<f64> => optional(-50.0, 1500.0),
        /// Linear thermal expansion. Left out: unknown.
        thermal_expansion_um_per_m_k: Option<f64> => optional(0.1, 300.0),
        /// Source of these three values.
        source: String => default_word(""),
    }

    /// The ring of pins in the housing, as installed.
    pub struct RingSection {
        /// Number of pins z_p. The disc has m lobes less, with the tooth difference m (1 by default).
        pin_count: usize => required(4.0, 400.0),
        /// Tooth difference m, 1 or 2, of drives of eccentrics: z_c = z_p − m lobes and a ratio of −z_c/m. Left out, and
        /// always in RV reducers: 1.
        tooth_difference: Option<usize> => optional(1.0, 2.0),
        /// Radius R_p of the circle through the pin centres.
        pin_circle_radius_mm: f64 => required(2.0, 2000.0),
        /// Radius r_p of the pins.
        pin_radius_mm: f64 => required(0.1, 200.0),
        /// Material of the pins, by name or inline.
        material: Material => word(),
        /// Whether the pins turn in their seats, or are arcs of one part with the ring.
        pin_mounting: PinMounting => default_word("fixed"),
        /// Radial compliance of a pin in its seat. Enters with bearings, not with ideal joints.
        seat_compliance_um_per_kn: f64 => default(0.0, 0.0, 100.0),
    }

    /// The cycloid discs, all alike; their eccentrics are spread equally over one turn.
    pub struct DiscSection {
        /// Number of discs.
        count: usize => required(1.0, 6.0),
        /// Number of lobes z_c. May be left out; if given, it must be less than the pins by one, or by the tooth difference.
        lobe_count: Option<usize> => optional(3.0, 399.0),
        /// Diameter of the tip circle of the lobes after turning, for drives of eccentrics. Left out: with a
        /// tooth difference of 1 the flank is smooth over the tip; with 2 the tip circle is a tenth of the
        /// eccentricity (in radius) below the point where the flanks of a lobe meet.
        tip_diameter_mm: Option<f64> => optional(1.0, 4000.0),
        /// Face width B of one disc.
        width_mm: f64 => required(0.5, 500.0),
        /// Material of the discs, by name or inline.
        material: Material => word(),
        /// Diameter of the bores for the turning-arm bearings. They lie on the circle of the crankshafts. Left
        /// out, the rollers run in the bore: pitch diameter and one roller diameter of that bearing.
        crank_bore_diameter_mm: Option<f64> => optional(1.0, 1000.0),
        /// Diameter of the centre hole; 0 for none.
        centre_hole_diameter_mm: f64 => default(0.0, 0.0, 3000.0),
        /// Mass of one disc. Left out, it is computed from the solid: exact flank, bores and holes, width,
        /// density.
        mass_kg: Option<f64> => optional(1e-6, 1e4),
        /// Moment of inertia of one disc about its centre. Left out, it is computed from the solid.
        inertia_kg_m2: Option<f64> => optional(1e-12, 1e4),
        /// Metal ground off the theoretical flank on purpose.
        modification: Section<ModificationSection> => super::sections::SECTION_OR_DEFAULTS,
        /// Windows and lightening holes in addition to crank bores and centre hole.
        holes: Vec<At<Section<HoleSection>>> => optional(0.0, 0.0),
        /// Windows for the pillars of the carrier, one between every two crankshafts, that leave this much
        /// metal to the root circle of the flank, to the crank bores and to the centre hole. Instead of
        /// `[[disc.windows]]`; with neither the disc is as solid as bores and holes leave it.
        window_rim_mm: Option<f64> => optional(0.1, 500.0),
        /// Windows for the pillars of the carrier: annular sectors with rounded corners.
        windows: Vec<At<Section<WindowSection>>> => optional(0.0, 0.0),
    }

    /// A window for a pillar of the carrier, or several equally spaced around the disc.
    pub struct WindowSection {
        /// Radius of the inner side.
        inner_radius_mm: f64 => required(0.5, 2000.0),
        /// Radius of the outer side.
        outer_radius_mm: f64 => required(0.5, 2000.0),
        /// Angle of the middle of the (first) window on the disc; 0 is the x axis.
        angle_deg: f64 => default(0.0, -360.0, 360.0),
        /// Angle between the two straight sides.
        width_deg: f64 => required(0.5, 350.0),
        /// Radius of the corners.
        corner_radius_mm: f64 => required(0.05, 200.0),
        /// Number of such windows, equally spaced over the turn.
        count: usize => default(1.0, 1.0, 60.0),
    }

    /// Flank modification. Depths count into the metal; a positive equidistant and a negative radial offset
    /// both open the gap.
    pub struct ModificationSection {
        /// Equidistant offset Δr_p: the flank is cut with a pin larger by this radius.
        equidistant_offset_um: f64 => default(0.0, -500.0, 500.0),
        /// Radial offset ΔR_p: the flank is cut on a pin circle larger by this radius.
        radial_offset_um: f64 => default(0.0, -500.0, 500.0),
        /// Both flanks of each tooth turned into the metal by this angle: depth = angle × lever arm.
        rotation_arcmin: f64 => default(0.0, 0.0, 60.0),
        /// Free form: pairs of meshing angle in degrees and depth in µm, the angles rising within −180 to
        /// 180. Between the points the depth is interpolated by a monotone cubic that closes around the
        /// tooth.
        free_form_deg_um: Vec<[f64; 2]> => optional(0.0, 500.0),
    }

    /// A hole, or several equally spaced around the disc.
    pub struct HoleSection {
        /// Diameter.
        diameter_mm: f64 => required(0.5, 1000.0),
        /// Distance of the hole's centre from the disc's centre.
        centre_radius_mm: f64 => required(0.0, 2000.0),
        /// Angle of the (first) hole on the disc; 0 is the x axis.
        angle_deg: f64 => default(0.0, -360.0, 360.0),
        /// Number of such holes, equally spaced over the turn.
        count: usize => default(1.0, 1.0, 60.0),
    }

    /// The crankshafts, each with its planet gear.
    pub struct CrankshaftSection {
        /// Number of crankshafts and planets.
        count: usize => required(1.0, 6.0),
        /// Eccentricity a.
        eccentricity_mm: f64 => required(0.02, 100.0),
        /// Angle of the first crankshaft on the carrier; the others follow equally spaced.
        first_angle_deg: f64 => default(90.0, -360.0, 360.0),
        /// Radius of the circle of the crankshafts. May be left out; if given, it must be the centre distance
        /// of the gear stage.
        circle_radius_mm: Option<f64> => optional(1.0, 2000.0),
        /// Diameter of the shaft between its supports (bending, torsion).
        shaft_diameter_mm: f64 => required(1.0, 500.0),
        /// Material, by name or inline.
        material: Material => word(),
        /// Mass of one crankshaft with its planet. Left out, it is computed from cylinders: shaft over the
        /// support span, eccentrics as wide as the discs, planet with the pitch diameter.
        mass_kg: Option<f64> => optional(1e-6, 1e4),
        /// Moment of inertia of one crankshaft with its planet about its axis. Left out, it is computed like
        /// the mass.
        inertia_kg_m2: Option<f64> => optional(1e-12, 1e4),
    }

    /// Sun and planet gears, the first stage.
    pub struct GearStageSection {
        /// Teeth of the sun z_1.
        sun_teeth: usize => required(4.0, 1000.0),
        /// Teeth of a planet z_2.
        planet_teeth: usize => required(4.0, 1000.0),
        /// Module.
        module_mm: f64 => required(0.1, 50.0),
        /// Transverse pressure angle.
        pressure_angle_deg: f64 => default(20.0, 10.0, 35.0),
        /// Ratio of input to output speed, housing fixed. May be left out; if given, it must be 1 + z_p
        /// z_2/z_1.
        ratio: Option<f64> => optional(1.0, 1e5),
        /// Face width (wear of the gears, planet mass).
        face_width_mm: f64 => required(0.5, 500.0),
        /// Mean stiffness of one sun–planet mesh along the line of action.
        mesh_stiffness_n_per_um: f64 => required(0.1, 1e5),
        /// Amplitude of the stiffness over the mesh cycle, as a part of the mean.
        mesh_stiffness_variation: f64 => default(0.0, 0.0, 0.95),
        /// Damping of one mesh along the line of action.
        mesh_damping_n_s_per_m: f64 => default(2000.0, 0.0, 1e7),
        /// Backlash of one mesh along the line of action.
        backlash_um: f64 => default(0.0, 0.0, 2000.0),
        /// Moment of inertia of sun and input shaft.
        sun_inertia_kg_m2: f64 => required(1e-12, 1e3),
        /// Moment of inertia of the motor at the input; counts where the input is driven by a torque.
        motor_inertia_kg_m2: f64 => default(0.0, 0.0, 1e3),
        /// Torsional stiffness of the input shaft between motor and sun. Left out: rigid. Enters with
        /// bearings, not with ideal joints.
        input_torsional_stiffness_n_m_per_arcmin: Option<f64> => optional(1e-4, 1e6),
    }

    /// The carrier: both flanges and the output shaft as one body.
    pub struct CarrierSection {
        /// Mass.
        mass_kg: f64 => required(1e-4, 1e5),
        /// Moment of inertia about the machine's axis, without the crankshafts.
        inertia_kg_m2: f64 => required(1e-9, 1e5),
        /// Material, by name or inline.
        material: Material => word(),
        /// Torsional stiffness between crank supports and output flange. Left out: rigid. With elastic bodies the
        /// carrier's solid takes its place.
        torsional_stiffness_n_m_per_arcmin: Option<f64> => optional(0.1, 1e7),
        /// Its solid, for elastic bodies.
        solid: Section<CarrierSolidSection> => SECTION_OR_DEFAULTS,
    }

    /// The carrier as a solid: two plates joined by pillars. Missing keys are scaled from the pin circle; these
    /// rules are assumptions.
    pub struct CarrierSolidSection {
        /// Diameter of the plates. Left out: that of the pin circle.
        plate_diameter_mm: Option<f64> => optional(2.0, 4000.0),
        /// Diameter of the bore through the plates. Left out: that of the disc's centre hole, but 0.04 R_p
        /// away from the crank seats.
        centre_bore_diameter_mm: Option<f64> => optional(0.5, 4000.0),
        /// Diameter of the seats of the crank supports' outer rings. Left out: raceway and 0.08 R_p.
        crank_seat_diameter_mm: Option<f64> => optional(1.0, 1000.0),
        /// Thickness of a plate. Left out: each crank support sits in the middle of its plate.
        plate_thickness_mm: Option<f64> => optional(0.5, 1000.0),
        /// Radius of the inner side of the pillars. Left out: the assumed window drawn in by eccentricity and
        /// 0.02 R_p.
        pillar_inner_radius_mm: Option<f64> => optional(0.5, 2000.0),
        /// Radius of the outer side of the pillars. Left out: likewise.
        pillar_outer_radius_mm: Option<f64> => optional(0.5, 2000.0),
        /// Angle between the straight sides of a pillar. Left out: likewise.
        pillar_width_deg: Option<f64> => optional(0.5, 350.0),
        /// Radius of the corners of a pillar. Left out: likewise.
        pillar_corner_radius_mm: Option<f64> => optional(0.05, 200.0),
        /// Support of the output face. Left out: "face".
        hold: Option<Hold> => optional(0.0, 0.0),
    }

    /// The housing with the ring of pins. Its inertia counts where the carrier is at rest.
    pub struct HousingSection {
        /// Mass. Left out, it is computed from the pins and a ring of cast iron from the pin circle to 1.25
        /// of its radius, 1.25 times as wide as the discs.
        mass_kg: Option<f64> => optional(1e-4, 1e5),
        /// Moment of inertia about the machine's axis. Left out, it is computed like the mass.
        inertia_kg_m2: Option<f64> => optional(1e-9, 1e5),
        /// Its solid, for elastic bodies.
        solid: Section<HousingSolidSection> => SECTION_OR_DEFAULTS,
    }

    /// The housing as a solid: a ring with grooves for the pins between the seats of the main bearings, and a
    /// flange with bolts. Missing keys are scaled from the pin circle; these rules are assumptions.
    pub struct HousingSolidSection {
        /// Material, by name or inline. Left out: QT450.
        material: Option<Material> => optional(0.0, 0.0),
        /// Diametral clearance of the pins in their grooves. Left out: 0.1 % of the pins' diameter.
        groove_clearance_um: Option<f64> => optional(0.0, 1000.0),
        /// Outer diameter of the ring. Left out: 2.5 R_p.
        body_diameter_mm: Option<f64> => optional(2.0, 4000.0),
        /// Diameter of the main bearings' seats. Left out: 0.24 R_p more than the carrier's plates.
        seat_diameter_mm: Option<f64> => optional(2.0, 4000.0),
        /// Diameter of the flange. Left out: 2.96 R_p.
        flange_diameter_mm: Option<f64> => optional(2.0, 4000.0),
        /// Thickness of the flange. Left out: as long as the pins.
        flange_thickness_mm: Option<f64> => optional(0.5, 1000.0),
        /// Diameter of the circle of bolts. Left out: the middle of the flange.
        bolt_circle_diameter_mm: Option<f64> => optional(2.0, 4000.0),
        /// Number of bolts. Left out: 16.
        bolt_count: Option<usize> => optional(2.0, 48.0),
        /// Angle of the first bolt. Left out: 0.
        first_bolt_angle_deg: Option<f64> => optional(-360.0, 360.0),
        /// Diameter of the face that one bolt presses. Left out: 0.18 R_p.
        bolt_face_diameter_mm: Option<f64> => optional(0.5, 500.0),
        /// Support of the flange. Left out: "bolts".
        hold: Option<Hold> => optional(0.0, 0.0),
    }
}

/// A section that may be left out because all of its keys have defaults.
pub(super) const SECTION_OR_DEFAULTS: super::schema::Rule = optional(0.0, 0.0);

impl MaterialTable {
    pub(super) fn material(&self) -> Material {
        Material {
            yield_strength: self.yield_strength_mpa.map(|mpa| mpa * MPA),
            softening_temperature: *self.softening_temperature_c,
            thermal_expansion: self.thermal_expansion_um_per_m_k.map(|um| um * 1e-6),
            source: self.source.value.clone(),
            ..Material::elastic(
                &self.name,
                *self.youngs_modulus_gpa * 1e9,
                *self.poisson_ratio,
                *self.density_g_cm3 * 1e3,
            )
        }
    }
}

impl Choice for PinMounting {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("fixed", "pins do not turn: they slide on the flank"),
        ("spinning", "pins turn freely in their seats"),
        (
            "one-piece",
            "no pins: arcs of their radius cut into the ring as one part, of single stages, two rings and two stages",
        ),
    ];
    const VALUES: &'static [PinMounting] =
        &[PinMounting::Fixed, PinMounting::Spinning, PinMounting::OnePiece];
}

impl Choice for Hold {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("face", "the whole face, as by a stiff and well bolted neighbour"),
        ("bolts", "around the bolts only; on the carrier over the pillars only"),
    ];
    const VALUES: &'static [Hold] = &[Hold::Face, Hold::Bolts];
}

impl Choice for FixedMember {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("housing", "housing at rest, the carrier is the output"),
        ("carrier", "carrier at rest, the housing is the output"),
    ];
    const VALUES: &'static [FixedMember] = &[FixedMember::Housing, FixedMember::Carrier];
}
