//! Linear elastic, isotropic materials.

/// A material as the solvers need it.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    pub name: String,
    /// Young's modulus E in Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Density in kg/m³.
    pub density: f64,
}

impl Material {
    /// (1 − ν²)/E in 1/Pa: the plane-strain compliance that enters every line contact.
    pub fn plane_strain_compliance(&self) -> f64 {
        (1.0 - self.poisson_ratio * self.poisson_ratio) / self.youngs_modulus
    }

    /// The materials known by name: Table 2 of Tao2024 and one common alternative.
    pub fn by_name(name: &str) -> Option<Material> {
        LIBRARY.iter().find(|entry| entry.0.eq_ignore_ascii_case(name)).map(
            |&(name, e_gpa, poisson_ratio, g_cm3)| Material {
                name: name.to_owned(),
                youngs_modulus: e_gpa * 1e9,
                poisson_ratio,
                density: g_cm3 * 1e3,
            },
        )
    }

    /// Names that [`Material::by_name`] understands.
    pub fn known_names() -> impl Iterator<Item = &'static str> + Clone {
        LIBRARY.iter().map(|entry| entry.0)
    }
}

/// Name, E in GPa, ν, density in g/cm³. The first three are Table 2 of Tao2024 (the paper prints its unit of
/// density a thousand times too large). 100Cr6 is GCr15's European name with the usual handbook values.
const LIBRARY: [(&str, f64, f64, f64); 4] = [
    ("GCr15", 219.0, 0.3, 7.83),
    ("20CrMnTi", 212.0, 0.289, 7.86),
    ("QT450", 169.0, 0.257, 7.06),
    ("100Cr6", 210.0, 0.3, 7.83),
];

/// Effective contact modulus E* of two bodies: 1/E* = (1−ν₁²)/E₁ + (1−ν₂²)/E₂ (Johnson 1985, eq. 4.2).
pub fn effective_modulus(first: &Material, second: &Material) -> f64 {
    1.0 / (first.plane_strain_compliance() + second.plane_strain_compliance())
}
