use super::DimensionedDesign;
use crate::design::{Design, StageDesign, TwoRingDesign, TwoStageDesign, Value};
use crate::templates::{NEMA17_19, RV_40E, TWO_RING_225, TWO_STAGE_500};

/// Value of an attribute of an element.
fn attribute<'a>(element: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = element.split_once(&format!(" {name}=\""))?;
    rest.split('"').next()
}

/// The length of every dimension line, from its own ends and the scale of the view, equals the value of its
/// key, and the key and its value are in the drawing.
fn lines_are_as_long_as_their_keys(drawing: &str, of: impl Fn(&str) -> Option<Value>, keys: &[&str]) {
    let mut found = Vec::new();
    for element in drawing.lines().filter(|line| line.starts_with("<line")) {
        let key = attribute(element, "data-key").unwrap();
        let number = |name: &str| -> f64 { attribute(element, name).unwrap().parse().unwrap() };
        let length = (number("x2") - number("x1")).hypot(number("y2") - number("y1"));
        let mm = number("data-mm");
        if let Some(value) = of(key).and_then(|value| value.as_number()) {
            assert!((mm - value).abs() < 2e-3 * value.max(0.5), "{key}: {mm} {value}");
            let name = key.rsplit('.').next().unwrap();
            assert!(drawing.contains(&format!("{name} </tspan><tspan class=\"value\">= {value}")), "{key}");
        }
        found.push((key.to_owned(), length / mm));
    }
    for key in keys {
        let name = key.rsplit('.').next().unwrap();
        assert!(drawing.contains(&format!(">{name} ")), "{key} is not in the drawing");
    }
    assert!(found.len() >= 4, "{found:?}");
    // Views have separate scales.
    let scales: Vec<f64> =
        found.iter().filter(|(_, scale)| scale.is_finite()).map(|(_, scale)| *scale).collect();
    let mut distinct = scales.clone();
    distinct.sort_by(f64::total_cmp);
    distinct.dedup_by(|a, b| (*a / *b - 1.0).abs() < 0.02);
    assert!(distinct.len() <= 4 && distinct[0] > 0.1, "{found:?}");
    // All coordinates are finite.
    assert!(!drawing.contains("NaN") && !drawing.contains("inf"));
}

#[test]
fn every_family_is_drawn_with_its_keys() {
    let stage = StageDesign::parse(NEMA17_19.text, "stage").unwrap();
    let keys = [
        "ring.pin_count",
        "ring.pin_circle_radius_mm",
        "ring.pin_radius_mm",
        "eccentric.eccentricity_mm",
        "output_pins.circle_radius_mm",
        "output_pins.hole_clearance_um",
        "disc.crank_bore_diameter_mm",
        "disc.width_mm",
        "output_pins.plate_distance_mm",
    ];
    lines_are_as_long_as_their_keys(&stage.dimension_drawing(), |key| stage.get(key).ok(), &keys);
    let one_end = stage.with_all([("output_pins.support", "one-end")]).unwrap();
    // A ring of one piece is drawn as a contour instead of pins: fewer circles, one additional path.
    let one_piece = stage.with_all([("ring.pin_mounting", "one-piece")]).unwrap();
    let count = |design: &StageDesign, element: &str| design.dimension_drawing().matches(element).count();
    assert_eq!(count(&stage, "<circle") - count(&one_piece, "<circle"), 20 - 1);
    assert_eq!(count(&one_piece, "<path class=\"pin\"") - count(&stage, "<path class=\"pin\""), 1);
    let one_disc = one_end.with_all([("disc.count", 1.0)]).unwrap();
    lines_are_as_long_as_their_keys(&one_disc.dimension_drawing(), |key| one_disc.get(key).ok(), &keys);
    let two_ring = TwoRingDesign::parse(TWO_RING_225.text, "two rings").unwrap();
    let keys = ["second_ring.pin_circle_radius_mm", "second_disc.width_mm", "disc.width_mm"];
    lines_are_as_long_as_their_keys(&two_ring.dimension_drawing(), |key| two_ring.get(key).ok(), &keys);
    let two_stage = TwoStageDesign::parse(TWO_STAGE_500.text, "two stages").unwrap();
    let keys = [
        "first_stage.ring.pin_circle_radius_mm",
        "first_stage.disc.width_mm",
        "output_pins.circle_radius_mm",
    ];
    lines_are_as_long_as_their_keys(&two_stage.dimension_drawing(), |key| two_stage.get(key).ok(), &keys);
    let rv = Design::parse(RV_40E.text, "rv").unwrap();
    let keys = [
        "crankshafts.eccentricity_mm",
        "disc.crank_bore_diameter_mm",
        "disc.centre_hole_diameter_mm",
        "disc.width_mm",
    ];
    lines_are_as_long_as_their_keys(&rv.dimension_drawing(), |key| rv.get(key).ok(), &keys);
}

/// The same design gives the same bytes; XML characters in a name are escaped.
#[test]
fn drawings_are_reproducible_and_escaped() {
    let text = NEMA17_19.text.replace("name = \"NEMA 17, 19 : 1\"", "name = \"<b> & co\"");
    let stage = StageDesign::parse(&text, "stage").unwrap();
    assert_eq!(stage.dimension_drawing(), stage.dimension_drawing());
    assert!(stage.dimension_drawing().contains("<title>&lt;b&gt; &amp; co</title>"));
}

/// Labels are at least one label apart and within their range, and at their required positions as far as
/// possible.
#[test]
fn labels_do_not_overlap() {
    let found = super::rows(&[10.0, 11.0, 12.0, 90.0, 99.0], [0.0, 100.0]);
    assert!(found.windows(2).all(|pair| pair[1] - pair[0] > super::LABEL - 1e-9), "{found:?}");
    assert!(found[0] >= 0.5 * super::LABEL && found[4] <= 100.0 - 0.5 * super::LABEL, "{found:?}");
    assert_eq!(super::rows(&[30.0, 60.0], [0.0, 100.0]), [30.0, 60.0]);
}
