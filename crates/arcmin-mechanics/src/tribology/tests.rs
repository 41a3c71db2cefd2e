use super::*;
use proptest::prelude::*;

fn at(sliding: f64, film_ratio: f64, depth: f64, time: f64) -> Local {
    Local { pressure: 0.0, sliding, equivalent_radius: 3e-3, film_ratio, depth, time }
}

/// Every law, with parameters from three numbers between 0 and 1.
pub(crate) fn every_law([a, b, c]: [f64; 3]) -> Vec<WearLaw> {
    use crate::named::LawName;
    let range = |key: &str| match key {
        "exponent" => 1.0 + 4.0 * a,
        "threshold_mpa" => 600.0 * b,
        "factor" => 1.0 + 99.0 * a,
        "smoothing_depth_um" => 0.1 + 5.0 * c,
        _ => panic!("{key} {c}"),
    };
    WearLawName::NAMES
        .iter()
        .map(|name| {
            let numbers: Vec<f64> = name.parameters().iter().map(|key| range(key)).collect();
            name.law(&numbers).unwrap()
        })
        .collect()
}

/// ∫ p^m dx of the Hertz pressure is p0^m b √π Γ(m/2 + 1)/Γ(m/2 + 3/2); for m = 1 and 3: π/2 and 3π/8 b p0^m.
#[test]
fn integral_over_the_contact_agrees_with_closed_forms() {
    let (line_load, half_width) = (5e4, 7e-5);
    let p0 = 2.0 * line_load / (PI * half_width);
    for (exponent, factor) in
        [(1.0, PI / 2.0), (2.0, 4.0 / 3.0), (3.0, 3.0 * PI / 8.0), (5.0, 5.0 * PI / 16.0)]
    {
        let law = PressurePower { exponent, threshold: 0.0 };
        let expected = 0.1 * half_width * factor * p0.powf(exponent) * 1e9_f64.powf(1.0 - exponent);
        let found = law.section_rate(line_load, half_width, &at(0.1, 0.0, 0.0, 0.0));
        assert!((found / expected - 1.0).abs() < 1e-6, "{exponent}: {found} {expected}");
    }
    // With a threshold, m = 1: 2b ∫ (p0 cos θ − p_t) cos θ dθ up to cos θ = p_t/p0.
    let threshold = 0.6 * p0;
    let end = 0.6_f64.acos();
    let expected = 0.2 * half_width * (p0 * (0.5 * end + 0.25 * (2.0 * end).sin()) - threshold * end.sin());
    let law = PressurePower { exponent: 1.0, threshold };
    let found = law.section_rate(line_load, half_width, &at(0.1, 0.0, 0.0, 0.0));
    assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
}

/// Archard's closed form is the integral that serves every law.
#[test]
fn power_one_without_threshold_is_archards_law() {
    let place = at(0.1, 0.4, 0.0, 0.0);
    let closed = Archard.section_rate(5e4, 7e-5, &place);
    let integral = PressurePower { exponent: 1.0, threshold: 0.0 }.section_rate(5e4, 7e-5, &place);
    assert!((integral / closed - 1.0).abs() < 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    /// No law lets metal grow, none loses its value, and none wears slower under more load.
    #[test]
    fn rates_are_finite_and_rise_with_load_for_every_law(
        unit in prop::array::uniform3(0.0..1.0f64),
        line_load in 1.0..3e5f64,
        half_width in 1e-6..5e-4f64,
        place in (0.0..2.0f64, 0.0..5.0f64, 0.0..1e-4f64, 0.0..1e8f64),
    ) {
        for law in every_law(unit) {
            let rate = law.local_rate();
            let place = at(place.0, place.1, place.2, place.3);
            let one = rate.section_rate(line_load, half_width, &place);
            let more = rate.section_rate(1.1 * line_load, half_width, &place);
            prop_assert!(one.is_finite() && one >= 0.0, "{law:?} {one}");
            prop_assert!(more >= one, "{law:?} {one} {more}");
            if !rate.depends_on_time() {
                let later = Local { time: 2.0 * place.time + 1.0, ..place };
                prop_assert_eq!(rate.section_rate(line_load, half_width, &later), one);
            }
        }
    }
}
