//! Quadrature on the unit triangle and the unit tetrahedron: points in the first area (volume) coordinates,
//! weights summing to the measure of the simplex (1/2, 1/6).
#![allow(clippy::excessive_precision)] // the digits as published

/// Degree 4, six points (Dunavant 1985): exact for the mass of a straight T6.
pub const TRIANGLE_6: [([f64; 2], f64); 6] = {
    const A: f64 = 0.445948490915965;
    const B: f64 = 0.091576213509771;
    const WA: f64 = 0.5 * 0.223381589678011;
    const WB: f64 = 0.5 * 0.109951743655322;
    [
        ([A, A], WA),
        ([1.0 - 2.0 * A, A], WA),
        ([A, 1.0 - 2.0 * A], WA),
        ([B, B], WB),
        ([1.0 - 2.0 * B, B], WB),
        ([B, 1.0 - 2.0 * B], WB),
    ]
};

/// Degree 2, four points: exact for the stiffness of a straight Tet10.
pub const TETRAHEDRON_4: [([f64; 3], f64); 4] = {
    const A: f64 = 0.1381966011250105;
    const B: f64 = 1.0 - 3.0 * A;
    const W: f64 = 1.0 / 24.0;
    [([A, A, A], W), ([B, A, A], W), ([A, B, A], W), ([A, A, B], W)]
};

/// Degree 5, fifteen points with positive weights (Keast 1986, rule 6): exact for the mass of a straight
/// Tet10.
pub const TETRAHEDRON_15: [([f64; 3], f64); 15] = {
    const W0: f64 = 0.0302836780970891856;
    const A1: f64 = 1.0 / 3.0;
    const W1: f64 = 0.00602678571428571597;
    const A2: f64 = 1.0 / 11.0;
    const B2: f64 = 8.0 / 11.0;
    const W2: f64 = 0.0116452490860289742;
    const A3: f64 = 0.0665501535736642813;
    const B3: f64 = 0.433449846426335728;
    const W3: f64 = 0.0109491415613864534;
    [
        ([0.25, 0.25, 0.25], W0),
        ([A1, A1, A1], W1),
        ([0.0, A1, A1], W1),
        ([A1, 0.0, A1], W1),
        ([A1, A1, 0.0], W1),
        ([A2, A2, A2], W2),
        ([B2, A2, A2], W2),
        ([A2, B2, A2], W2),
        ([A2, A2, B2], W2),
        ([B3, A3, A3], W3),
        ([A3, B3, A3], W3),
        ([A3, A3, B3], W3),
        ([A3, B3, B3], W3),
        ([B3, A3, B3], W3),
        ([B3, B3, A3], W3),
    ]
};

/// Gauss–Legendre with four points on [0, 1].
pub const LINE_4: [(f64, f64); 4] = [
    (0.069431844202973712, 0.173927422568726928),
    (0.330009478207571868, 0.326072577431273072),
    (0.669990521792428132, 0.326072577431273072),
    (0.930568155797026288, 0.173927422568726928),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: u32) -> f64 {
        (1..=n).map(f64::from).product()
    }

    /// ∫ x^a y^b over the unit triangle = a! b! / (a + b + 2)!.
    #[test]
    fn triangle_rule_is_exact_to_its_degree() {
        for a in 0..=4u32 {
            for b in 0..=4 - a {
                let sum: f64 =
                    TRIANGLE_6.iter().map(|([x, y], w)| w * x.powi(a as i32) * y.powi(b as i32)).sum();
                let exact = factorial(a) * factorial(b) / factorial(a + b + 2);
                assert!((sum - exact).abs() < 1e-14, "{a} {b}: {sum} {exact}");
            }
        }
    }

    /// ∫ x^a y^b z^c over the unit tetrahedron = a! b! c! / (a + b + c + 3)!.
    #[test]
    fn tetrahedron_rules_are_exact_to_their_degree() {
        for (rule, degree) in [(&TETRAHEDRON_4[..], 2u32), (&TETRAHEDRON_15[..], 5)] {
            for a in 0..=degree {
                for b in 0..=degree - a {
                    for c in 0..=degree - a - b {
                        let sum: f64 = rule
                            .iter()
                            .map(|([x, y, z], w)| w * x.powi(a as i32) * y.powi(b as i32) * z.powi(c as i32))
                            .sum();
                        let exact = factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3);
                        assert!((sum - exact).abs() < 1e-13, "{degree}: {a} {b} {c}: {sum} {exact}");
                    }
                }
            }
        }
    }
}
