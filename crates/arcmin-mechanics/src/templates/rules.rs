//! Scaling of every number of a shipped design with the size.

/// Scaling of a number of a template to a machine of another size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rule {
    /// Proportional to powers of s, of w and of the ratio of the torques.
    Size { s: f64, w: f64 },
    /// A tolerance: proportional to the cube root of the size, as the grades of ISO 286.
    Grade,
    /// Drag of the seals: proportional to the square of their diameter, but at most to the torque, because lost
    /// motion is read at ±3 % of it.
    Seal,
    /// A diameter of the crankshafts or a number of rollers on them: proportional to s and the factor of the
    /// crankshafts.
    Crank,
    /// From the data sheet or derived from it: ratio, torque, speed, teeth, limits.
    Sheet,
    /// As in the template, with the reason.
    Kept(&'static str),
}

const ACROSS: Rule = Rule::Size { s: 1.0, w: 0.0 };
const ALONG: Rule = Rule::Size { s: 1.0, w: 1.0 };
const MASS: Rule = Rule::Size { s: 3.0, w: 1.0 };
const INERTIA: Rule = Rule::Size { s: 5.0, w: 1.0 };
/// Rotating parallel faces with a gap proportional to the size: η ω r⁴/gap.
const OIL: Rule = Rule::Size { s: 3.0, w: 0.0 };
const FORCE: Rule = Rule::Size { s: 2.0, w: 1.0 };

const TEETH: Rule = Rule::Kept("a number of teeth that does not go with the size");
const RATIO_OF_ITSELF: Rule = Rule::Kept("a coefficient without dimension");
const SHAPE: Rule = Rule::Kept("an angle, the same in similar machines");
const PIECES: Rule = Rule::Kept("a number of parts, the same in similar machines");
const SURFACE: Rule = Rule::Kept("of materials and surfaces, not of the size");

/// The rule of every number, by its path without indices.
pub(super) const RULES: &[(&str, Rule)] = &[
    ("ring.pin_count", TEETH),
    ("ring.tooth_difference", TEETH),
    ("ring.pin_circle_radius_mm", ACROSS),
    ("ring.pin_radius_mm", ACROSS),
    ("ring.seat_compliance_um_per_kn", Rule::Size { s: -1.0, w: -1.0 }),
    ("disc.count", PIECES),
    ("disc.lobe_count", TEETH),
    ("disc.tip_diameter_mm", ACROSS),
    ("disc.width_mm", ALONG),
    ("disc.crank_bore_diameter_mm", Rule::Crank),
    ("disc.centre_hole_diameter_mm", ACROSS),
    ("disc.window_rim_mm", ACROSS),
    ("disc.mass_kg", MASS),
    ("disc.inertia_kg_m2", INERTIA),
    ("disc.modification.equidistant_offset_um", ACROSS),
    ("disc.modification.radial_offset_um", ACROSS),
    ("disc.modification.rotation_arcmin", SHAPE),
    ("crankshafts.count", Rule::Sheet),
    ("crankshafts.eccentricity_mm", ACROSS),
    ("crankshafts.first_angle_deg", SHAPE),
    ("crankshafts.circle_radius_mm", Rule::Sheet),
    ("crankshafts.shaft_diameter_mm", Rule::Crank),
    ("crankshafts.mass_kg", MASS),
    ("crankshafts.inertia_kg_m2", INERTIA),
    ("gear_stage.sun_teeth", Rule::Sheet),
    ("gear_stage.planet_teeth", Rule::Sheet),
    ("gear_stage.module_mm", Rule::Sheet),
    ("gear_stage.pressure_angle_deg", SHAPE),
    ("gear_stage.ratio", Rule::Sheet),
    ("gear_stage.face_width_mm", ALONG),
    ("gear_stage.mesh_stiffness_n_per_um", ALONG),
    ("gear_stage.mesh_stiffness_variation", RATIO_OF_ITSELF),
    ("gear_stage.mesh_damping_n_s_per_m", ACROSS),
    ("gear_stage.backlash_um", ACROSS),
    ("gear_stage.sun_inertia_kg_m2", INERTIA),
    ("gear_stage.motor_inertia_kg_m2", INERTIA),
    ("carrier.mass_kg", MASS),
    ("carrier.inertia_kg_m2", INERTIA),
    ("carrier.solid.plate_thickness_mm", ALONG),
    ("housing.solid.body_diameter_mm", ACROSS),
    ("housing.solid.groove_clearance_um", ACROSS),
    ("housing.solid.bolt_count", PIECES),
    ("bearings.crank_support_span_mm", ALONG),
    ("bearings.sun_radial_stiffness_n_per_um", ACROSS),
    ("bearings.turning_arm.roller_count", Rule::Crank),
    ("bearings.turning_arm.roller_diameter_mm", ACROSS),
    ("bearings.turning_arm.roller_length_mm", ALONG),
    ("bearings.turning_arm.pitch_diameter_mm", Rule::Crank),
    ("bearings.turning_arm.clearance_um", ACROSS),
    ("bearings.crank_support.roller_count", Rule::Crank),
    ("bearings.crank_support.roller_diameter_mm", ACROSS),
    ("bearings.crank_support.roller_length_mm", ALONG),
    ("bearings.crank_support.pitch_diameter_mm", Rule::Crank),
    ("bearings.crank_support.contact_angle_deg", SHAPE),
    ("bearings.crank_support.clearance_um", ACROSS),
    ("bearings.main.radial_stiffness_n_per_um", ACROSS),
    ("bearings.main.clearance_um", ACROSS),
    ("bearings.main.rows.preload_um", ACROSS),
    ("friction.flank_coefficient", RATIO_OF_ITSELF),
    ("friction.pin_seat_coefficient", RATIO_OF_ITSELF),
    ("friction.bearing_coefficient", RATIO_OF_ITSELF),
    ("friction.gear_mesh_coefficient", RATIO_OF_ITSELF),
    ("friction.seal_drag_n_m", Rule::Seal),
    ("friction.oil_drag_n_m_s_per_rad", OIL),
    ("friction.bearing_drag_factor", RATIO_OF_ITSELF),
    ("friction.crank_support_preload_n", FORCE),
    ("contact.damping_n_s_per_m", ACROSS),
    ("contact.damping_depth_um", Rule::Kept("smooths the damping in time, in micrometres of contact")),
    ("thermal.temperature_c", Rule::Kept("a temperature, the same in machines of any size")),
    ("load.rated_torque_n_m", Rule::Sheet),
    ("load.input_speed_rpm", Rule::Sheet),
    ("duty.torque_n_m", Rule::Sheet),
    ("duty.input_speed_rpm", Rule::Sheet),
    ("duty.share", RATIO_OF_ITSELF),
    ("wear.pin_ratio", RATIO_OF_ITSELF),
    ("wear.coupled.coefficient_mm2_per_n", SURFACE),
    ("wear.paper.after_h", Rule::Kept("the paper's own calibration of its method")),
    ("wear.paper.depth_um", Rule::Kept("the paper's own calibration of its method")),
    ("limits.lost_motion_arcmin", Rule::Sheet),
    ("limits.contact_pressure_mpa", SURFACE),
    ("limits.service_life_h", Rule::Sheet),
    ("tolerances.pin_position_um", Rule::Grade),
    ("tolerances.pin_radius_um", Rule::Grade),
    ("tolerances.pin_circle_radius_um", Rule::Grade),
    ("tolerances.pin_circle_offset_um", Rule::Grade),
    ("tolerances.eccentricity_um", Rule::Grade),
    ("tolerances.eccentric_phase_arcmin", SHAPE),
    ("tolerances.bore_position_um", Rule::Grade),
    ("tolerances.bore_diameter_um", Rule::Grade),
    ("tolerances.flank_run_out_um", Rule::Grade),
    ("tolerances.flank_pitch_um", Rule::Grade),
    ("tolerances.flank_profile_um", Rule::Grade),
    ("tolerances.journal_run_out_um", Rule::Grade),
    ("tolerances.planet_run_out_um", Rule::Grade),
    ("tolerances.carrier_run_out_um", Rule::Grade),
    ("tolerances.sun_run_out_um", Rule::Grade),
];

pub(super) fn rule(path: &str) -> Option<Rule> {
    RULES.iter().find(|(key, _)| *key == path).map(|(_, rule)| *rule)
}
