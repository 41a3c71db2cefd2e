//! Reference machines shipped with the program.

use crate::contact::{ContactLaw, Damping};
use crate::machine::*;
use crate::materials::Material;
use crate::units::{ARCMIN, DEG, HOUR, MM, RPM, UM};

/// The RV-40E-81 of Tao2024, with the assumptions that the paper leaves open.
pub fn rv_40e_81() -> Machine {
    let material = |name: &str| Material::by_name(name).unwrap_or_else(|| unreachable!("library material"));
    Machine {
        name: "RV-40E-81".to_owned(),
        ring: PinRing {
            pin_count: 40,
            pin_circle_radius: 64.0 * MM,
            pin_radius: 3.0 * MM,
            material: material("GCr15"),
            mounting: PinMounting::Fixed,
            seat_compliance: 0.0,
        },
        disc: CycloidDisc {
            width: 8.75 * MM,
            material: material("GCr15"),
            modification: FlankModification::default(),
            crank_bore_radius: 13.5 * MM,
            centre_hole_radius: 20.0 * MM,
            holes: Vec::new(),
            mass: 0.6366,
            inertia: 1.338e-3,
        },
        disc_count: 2,
        crankshafts: Crankshafts {
            count: 2,
            eccentricity: 1.3 * MM,
            first_angle: 90.0 * DEG,
            mass: 0.27,
            inertia: 4e-5,
            shaft_diameter: 18.0 * MM,
            material: material("GCr15"),
        },
        gear_stage: GearStage {
            sun_teeth: 18,
            planet_teeth: 36,
            module: 1.5 * MM,
            pressure_angle: 30.0 * DEG,
            mesh_stiffness: 2e8,
            mesh_stiffness_variation: 0.0,
            mesh_damping: 2e3,
            backlash: 0.0,
            sun_inertia: 1e-5,
            motor_inertia: 2e-4,
            face_width: 10.0 * MM,
        },
        carrier: Carrier { mass: 2.5, inertia: 5e-3, material: material("20CrMnTi"), torsional_stiffness: f64::INFINITY },
        fixed_member: FixedMember::Housing,
        bearings: BearingSet {
            turning_arm: RollerBearing {
                kind: RollerKind::Cylindrical,
                roller_count: 14,
                roller_diameter: 4.5 * MM,
                roller_length: 8.0 * MM,
                pitch_diameter: 22.5 * MM,
                contact_angle: 0.0,
                clearance: 5.0 * UM,
                dynamic_load_rating: None,
            },
            crank_support: RollerBearing {
                kind: RollerKind::Tapered,
                roller_count: 15,
                roller_diameter: 4.5 * MM,
                roller_length: 9.0 * MM,
                pitch_diameter: 26.0 * MM,
                contact_angle: 12.0 * DEG,
                clearance: 0.0,
                dynamic_load_rating: None,
            },
            crank_support_span: 40.0 * MM,
            main: SupportStiffness { radial: 5e8, clearance: 0.0 },
        },
        friction: Friction { regularisation_speed: 1e-3, ..Friction::default() },
        contact_law: ContactLaw::LineHertz,
        contact_damping: Damping { coefficient: 2e3, ramp_depth: 1.0 * UM },
        rated: DutyPoint { torque: 412.0, input_speed: 1500.0 * RPM, share: 1.0 },
        duty: vec![DutyPoint { torque: 412.0, input_speed: 1500.0 * RPM, share: 1.0 }],
        wear: WearLaw {
            coupled: WearCoefficient::Given(8.4e-19),
            paper: WearCoefficient::Calibrated { time: 7500.0 * HOUR, depth: 60.0 * UM },
            running_in: None,
            pin_ratio: 0.0,
            lubrication: None,
        },
        limits: Limits { lost_motion: 1.0 * ARCMIN, contact_pressure: 2e9, service_life: 7500.0 * HOUR },
    }
}
