//! Reference designs shipped with the program.

mod like;
mod lines;
mod range;
mod rules;
mod teeth;

pub use like::{DataSheet, ScaleError, Scaled, Tuning};
pub use range::OutOfRange;

use crate::design::Design;
use crate::machine::Machine;

/// A shipped design file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Template {
    /// Name on the command line.
    pub name: &'static str,
    /// Name of the design file.
    pub file: &'static str,
    /// Description in one line.
    pub summary: &'static str,
    /// The commented TOML.
    pub text: &'static str,
    /// Usual outer diameter of the size in mm, the reference for scaling.
    pub outer_diameter_mm: f64,
}

/// RV-40E-81 as it would be made, 412 N·m.
pub const RV_40E: Template = Template {
    name: "rv-40e",
    file: "rv-40e-81.toml",
    summary: "RV-40E-81 as it would be made: 40 pins, 39 lobes, ratio 81, 412 N·m",
    text: include_str!("../designs/rv-40e-81.toml"),
    outer_diameter_mm: 190.0,
};

/// RV-80E with the teeth of Yang 2021, 784 N·m.
pub const RV_80E: Template = Template {
    name: "rv-80e",
    file: "rv-80e.toml",
    summary: "RV-80E with the teeth of Yang 2021: 40 pins, 39 lobes, ratio 153, 784 N·m",
    text: include_str!("../designs/rv-80e.toml"),
    outer_diameter_mm: 222.0,
};

/// RV-40E-81 of Tao2024 without modification and friction.
pub const TAO2024: Template = Template {
    name: "tao2024",
    file: "tao2024.toml",
    summary: "the theoretical RV-40E-81 of Tao2024: unmodified flanks, no friction",
    text: include_str!("../designs/tao2024.toml"),
    outer_diameter_mm: 190.0,
};

/// A single stage (family `eccentric`).
pub const NEMA17_19: Template = Template {
    name: "nema17-19",
    file: "nema17-19.toml",
    summary: "single stage for a NEMA 17 motor: 20 pins, 19 lobes, ratio −19, 3 N·m",
    text: include_str!("../designs/nema17-19.toml"),
    outer_diameter_mm: 42.0,
};

/// A printed single stage (family `eccentric`).
pub const PRINTED_15: Template = Template {
    name: "printed-15",
    file: "printed-15.toml",
    summary: "single stage printed of PLA: 16 pins, 15 lobes, ratio −15, 18 N·m",
    text: include_str!("../designs/printed-15.toml"),
    outer_diameter_mm: 100.0,
};

/// An industrial single stage of steel (family `eccentric`).
pub const STEEL_59: Template = Template {
    name: "steel-59",
    file: "steel-59.toml",
    summary: "single stage of ground steel: 60 rollers, 59 lobes, ratio −59, 500 N·m",
    text: include_str!("../designs/steel-59.toml"),
    outer_diameter_mm: 240.0,
};

/// Stepped discs in two rings (family `two-ring`).
pub const TWO_RING_225: Template = Template {
    name: "two-ring-225",
    file: "two-ring-225.toml",
    summary: "two rings: 16 and 15 pins, 15 and 14 lobes, ratio 225, 60 N·m",
    text: include_str!("../designs/two-ring-225.toml"),
    outer_diameter_mm: 100.0,
};

/// Two stages in series (family `two-stage`).
pub const TWO_STAGE_500: Template = Template {
    name: "two-stage-500",
    file: "two-stage-500.toml",
    summary: "two stages, 20 and 25 lobes, ratio 500, 150 N·m",
    text: include_str!("../designs/two-stage-500.toml"),
    outer_diameter_mm: 125.0,
};

/// All shipped RV reducers, the default first.
pub const TEMPLATES: [Template; 3] = [RV_40E, RV_80E, TAO2024];

/// All shipped drives of other families.
pub const DRIVES: [Template; 5] = [NEMA17_19, PRINTED_15, STEEL_59, TWO_RING_225, TWO_STAGE_500];

/// A shipped design of an RV reducer by its name or the name of its file, with or without `.toml`.
pub fn find(name: &str) -> Option<&'static Template> {
    static ALL: [Template; 3] = TEMPLATES;
    named(&ALL, name)
}

/// A shipped design of another family, as [`find`] takes names.
pub fn find_drive(name: &str) -> Option<&'static Template> {
    static ALL: [Template; 5] = DRIVES;
    named(&ALL, name)
}

fn named<'a>(all: &'a [Template], name: &str) -> Option<&'a Template> {
    let stem = name.strip_suffix(".toml").unwrap_or(name);
    all.iter().find(|template| template.name == stem || template.file.strip_suffix(".toml") == Some(stem))
}

/// A shipped design by the names that [`find`] takes; `None` if there is none of that name.
pub fn design(name: &str) -> Option<Design> {
    find(name).map(read)
}

/// The theoretical machine of Tao2024, with the assumptions that the paper leaves open.
pub fn tao2024() -> Machine {
    read(&TAO2024).machine()
}

fn read(template: &Template) -> Design {
    // The text is part of the program and a test reads it, so a failure here is a fault of the build.
    match Design::parse(template.text, template.file) {
        Ok(design) => design,
        Err(error) => unreachable!("shipped design: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::*;

    #[test]
    fn every_shipped_design_is_read() {
        for template in TEMPLATES {
            Design::parse(template.text, template.name)
                .unwrap_or_else(|error| panic!("{error}: {:?}", error.hint));
        }
    }

    #[test]
    fn tao2024_has_the_values_of_its_sources() {
        let machine = tao2024();
        assert_eq!(machine.kinematics().ratio(), 81.0);
        assert_eq!(machine.ring.pin_circle_radius, 64.0 * MM);
        assert!((machine.disc.mass - 0.6366).abs() < 5e-5 && (machine.disc.inertia - 1.3394e-3).abs() < 5e-8);
        assert_eq!(machine.gear_stage.mesh_stiffness, 2e8);
        assert!((machine.rated.input_speed - 1500.0 * RPM).abs() < 1e-12);
        assert_eq!(machine.bearings.turning_arm.clearance, 5.0 * UM);
        assert!(
            matches!(machine.wear.coupled, crate::machine::WearCoefficient::Given(k) if (k / 8.4e-19 - 1.0).abs() < 1e-12)
        );
        assert_eq!(machine.disc_count, 2);
    }
}
