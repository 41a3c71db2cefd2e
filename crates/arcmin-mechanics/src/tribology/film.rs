//! Film of lubricant between flank and pin.

/// Mixed lubrication: wear falls with the film ratio λ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lubrication {
    /// Dynamic viscosity at running temperature in Pa·s.
    pub viscosity: f64,
    /// Pressure–viscosity coefficient in 1/Pa.
    pub pressure_viscosity: f64,
    /// Combined RMS roughness of flank and pin in m.
    pub roughness: f64,
}

/// Film ratio λ = h_min/roughness of a line contact.
///
/// Dowson & Higginson (1966): h_min/R = 2.65 U^0.7 G^0.54 W^−0.13 with U = η u/(E′R), G = α E′, W = F/(B E′
/// R), E′ = 2 E*; u the entrainment speed (mean of the two surface speeds relative to the contact) in m/s,
/// `line_load` F/B in N/m, `radius` R_eq in m. Isothermal, fully flooded, smooth surfaces.
pub fn film_ratio(
    lubrication: &Lubrication,
    effective_modulus: f64,
    radius: f64,
    line_load: f64,
    entrainment_speed: f64,
) -> f64 {
    let e = 2.0 * effective_modulus;
    let u = lubrication.viscosity * entrainment_speed / (e * radius);
    let g = lubrication.pressure_viscosity * e;
    let w = (line_load / (e * radius)).max(1e-12);
    2.65 * radius * u.powf(0.7) * g.powf(0.54) * w.powf(-0.13) / lubrication.roughness
}

/// Share of the load that asperities carry at the film ratio λ: 1/(1 + λ)².
///
/// Olver & Spikes (1998) blend boundary and fluid traction with it. That wear follows the same share is an
/// assumption: only asperities in contact wear. It is 1 without film and 1/16 at λ = 3, from where on surfaces
/// are commonly taken as separated.
pub(super) fn boundary_share(film_ratio: f64) -> f64 {
    1.0 / ((1.0 + film_ratio) * (1.0 + film_ratio))
}

/// Entrainment speed in m/s of a contact that travels at `on_surface` (m/s) along the flank, where the surfaces
/// slide at `sliding` (m/s): the mean of their speeds relative to the contact, v_c − v_s/2.
///
/// It vanishes where v_c = v_s/2. A contact is wide and does not stay there, so the film never breaks down
/// altogether; the least speed kept, 0.001 v_s, is an assumption that hardly matters: the film is then below
/// 1 % of that at u = v_s, and the boundary share within 1 % of 1 for λ = 1 there.
pub fn entrainment_speed(on_surface: f64, sliding: f64) -> f64 {
    0.5 * (2.0 * on_surface - sliding).abs().max(1e-3 * sliding)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hand-calculated case: mineral oil 0.02 Pa·s, α 2e-8 1/Pa, R 10 mm, 1e5 N/m, 1 m/s, E′ 230 GPa.
    #[test]
    fn film_thickness_of_a_hand_calculation() {
        let oil = Lubrication { viscosity: 0.02, pressure_viscosity: 2e-8, roughness: 1e-6 };
        // U = 8.696e-12, G = 4600, W = 4.348e-5: h = 0.01·2.65·1.784e-8·95.0·3.69 m.
        let film = film_ratio(&oil, 115e9, 0.01, 1e5, 1.0) * 1e-6;
        let expected = 0.01
            * 2.65
            * (8.695_65e-12_f64.ln() * 0.7).exp()
            * (4600f64.ln() * 0.54).exp()
            * (4.347_83e-5_f64.ln() * -0.13).exp();
        assert!((film / expected - 1.0).abs() < 1e-5);
        assert!(film > 1e-7 && film < 1e-6, "{film:e}");
    }
}
