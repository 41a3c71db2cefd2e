//! Linear elastic, isotropic materials with their limits.

use crate::units::MPA;

/// A material of the solvers, with its limits as far as they are known.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Designation for messages and results, such as "100Cr6".
    pub name: String,
    /// Young's modulus E in Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Density in kg/m³.
    pub density: f64,
    /// Yield strength in Pa.
    pub yield_strength: Option<f64>,
    /// Temperature in °C above which it must not be used: glass transition or heat deflection of plastics,
    /// tempering of hardened steel.
    pub softening_temperature: Option<f64>,
    /// Linear thermal expansion in 1/K.
    pub thermal_expansion: Option<f64>,
    /// Source of these three values; empty without values.
    pub source: String,
}

/// Hertz pressure of a line contact over the yield strength at which it begins to yield under its surface (Tresca, for any
/// Poisson's ratio; Johnson, *Contact Mechanics*, 1985, section 6.1).
pub const LINE_CONTACT_YIELD: f64 = 1.67;

impl Material {
    /// A material with elasticity (Pa) and density (kg/m³) only.
    pub fn elastic(name: &str, youngs_modulus: f64, poisson_ratio: f64, density: f64) -> Material {
        Material {
            name: name.to_owned(),
            youngs_modulus,
            poisson_ratio,
            density,
            yield_strength: None,
            softening_temperature: None,
            thermal_expansion: None,
            source: String::new(),
        }
    }

    /// (1 − ν²)/E in 1/Pa: the plane-strain compliance that enters every line contact.
    pub fn plane_strain_compliance(&self) -> f64 {
        (1.0 - self.poisson_ratio * self.poisson_ratio) / self.youngs_modulus
    }

    /// The materials known by name: Table 2 of Tao2024, a common alternative, aluminium and plastics of printed parts.
    pub fn by_name(name: &str) -> Option<Material> {
        let known = LIBRARY.iter().find(|known| known.name.eq_ignore_ascii_case(name))?;
        Some(Material { name: name.to_owned(), ..known.material() })
    }

    /// Names that [`Material::by_name`] understands.
    pub fn known_names() -> impl Iterator<Item = &'static str> + Clone {
        LIBRARY.iter().map(|entry| entry.name)
    }
}

/// A material known by name.
#[derive(Debug, Clone, Copy)]
pub struct Known {
    /// Designation by which a design calls it.
    pub name: &'static str,
    /// E in GPa, ν, density in g/cm³.
    elastic: [f64; 3],
    yield_mpa: Option<f64>,
    softening_c: Option<f64>,
    expansion_um_per_m_k: Option<f64>,
    /// Of the last three.
    source: &'static str,
    /// Whether its values depend on how a part is printed.
    pub is_plastic: bool,
}

impl Known {
    /// The material in SI units.
    pub fn material(&self) -> Material {
        let [e_gpa, poisson_ratio, g_cm3] = self.elastic;
        Material {
            yield_strength: self.yield_mpa.map(|mpa| mpa * MPA),
            softening_temperature: self.softening_c,
            thermal_expansion: self.expansion_um_per_m_k.map(|um| um * 1e-6),
            source: self.source.to_owned(),
            ..Material::elastic(self.name, e_gpa * 1e9, poisson_ratio, g_cm3 * 1e3)
        }
    }
}

/// Elasticity of the first three is that of Table 2 of Tao2024 (the paper prints its unit of density a thousand times too
/// large). 100Cr6 is GCr15's European name with the usual handbook values.
const LIBRARY: [Known; 9] = [
    Known { name: "GCr15", elastic: [219.0, 0.3, 7.83], ..BEARING_STEEL },
    Known {
        name: "20CrMnTi",
        elastic: [212.0, 0.289, 7.86],
        yield_mpa: None,
        softening_c: None,
        expansion_um_per_m_k: None,
        source: "",
        is_plastic: false,
    },
    Known {
        name: "QT450",
        elastic: [169.0, 0.257, 7.06],
        yield_mpa: Some(310.0),
        softening_c: None,
        expansion_um_per_m_k: None,
        source: "least yield strength of QT450-10, GB/T 1348",
        is_plastic: false,
    },
    BEARING_STEEL,
    ALUMINIUM,
    PLA,
    Known {
        name: "PETG",
        elastic: [1.9, 0.4, 1.27],
        yield_mpa: Some(48.0),
        softening_c: Some(75.0),
        expansion_um_per_m_k: None,
        source: "data sheets of filaments: glass transition 75 to 80 °C; Poisson's ratio and density assumed",
        is_plastic: true,
    },
    Known {
        name: "PA6",
        elastic: [3.4, 0.39, 1.14],
        yield_mpa: Some(78.0),
        softening_c: Some(90.0),
        expansion_um_per_m_k: Some(50.0),
        source: "data sheets, dry: it softens as it takes up water; Poisson's ratio and density assumed",
        is_plastic: true,
    },
    PA12,
];

/// Bearing steel 100Cr6, hardened.
pub const BEARING_STEEL: Known = Known {
    name: "100Cr6",
    elastic: [210.0, 0.3, 7.83],
    yield_mpa: Some(2034.0),
    softening_c: Some(120.0),
    expansion_um_per_m_k: Some(11.9),
    source: "AISI 52100 as hardened balls: yield 295 000 psi; in use up to 120 °C",
    is_plastic: false,
};

/// Aluminium alloy 7075-T6.
pub const ALUMINIUM: Known = Known {
    name: "7075-T6",
    elastic: [71.7, 0.33, 2.81],
    yield_mpa: Some(503.0),
    softening_c: Some(121.0),
    expansion_um_per_m_k: Some(23.6),
    source: "usual values; it is aged at 121 °C",
    is_plastic: false,
};

/// Polylactide for filament printing.
pub const PLA: Known = Known {
    name: "PLA",
    elastic: [3.5, 0.36, 1.24],
    yield_mpa: Some(60.0),
    softening_c: Some(55.0),
    expansion_um_per_m_k: Some(41.0),
    source: "data sheets of filaments: yield 23 to 65 MPa along the layers, half of it across; heat deflection 51 to 58 °C; expansion \
             41 to 101 µm/(m·K)",
    is_plastic: true,
};

/// Polyamide 12 for laser sintering.
pub const PA12: Known = Known {
    name: "PA12",
    elastic: [1.7, 0.4, 0.93],
    yield_mpa: Some(48.0),
    softening_c: Some(90.0),
    expansion_um_per_m_k: None,
    source: "sintered: yield 44 to 52 MPa, continuous use up to 90 °C; Poisson's ratio assumed",
    is_plastic: true,
};

/// Effective contact modulus E* of two bodies: 1/E* = (1−ν₁²)/E₁ + (1−ν₂²)/E₂ (Johnson 1985, eq. 4.2).
pub fn effective_modulus(first: &Material, second: &Material) -> f64 {
    1.0 / (first.plane_strain_compliance() + second.plane_strain_compliance())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every material is found by its name in any case; its limits have a source.
    #[test]
    fn strengths_of_materials_have_a_source() {
        for name in Material::known_names() {
            let known = Material::by_name(&name.to_lowercase()).unwrap();
            let limits = [known.yield_strength, known.softening_temperature, known.thermal_expansion];
            assert_eq!(known.source.is_empty(), limits.iter().all(Option::is_none), "{name}");
            // Yield strain of any solid in use lies between 0.05 and 5 %.
            if let Some(strength) = known.yield_strength {
                let strain = strength / known.youngs_modulus;
                assert!((5e-4..5e-2).contains(&strain), "{name}: {strain}");
            }
        }
    }
}
