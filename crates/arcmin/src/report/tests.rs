//! Requirements on a page: self-contained, escaped, finite, identical bytes every time.

use super::*;

fn plot_of(points: Vec<(f64, f64)>) -> Plot {
    Plot::new("A & B", Axis::new("x <y>", "mm"), Axis::new("value", "N")).with(Series::line("one", points))
}

fn page_of(blocks: Vec<Block>) -> Page {
    Page {
        title: "Reducer <script>alert(1)</script>".into(),
        subtitle: "a \"quoted\" 'subtitle'".into(),
        provenance: Provenance {
            version: "1.2.3".into(),
            design_hash: "abc".into(),
            command: "arcmin life x.toml --out \"a&b\"".into(),
            seeds: vec![3, 5],
        },
        verdict: Verdict { summary: "a <b> & c".into(), ..Verdict::new(Tone::Good, "Holds.") },
        sections: vec![Section::new("one", "Section one", blocks)],
    }
}

/// The JSON of every figure, as the script of the page would read it.
fn figure_data(html: &str) -> Vec<serde_json::Value> {
    html.split("<script type=\"application/json\">")
        .skip(1)
        .map(|rest| {
            let json = &rest[..rest.find("</script>").expect("data element is closed")];
            serde_json::from_str(json).expect("figure data is JSON")
        })
        .collect()
}

/// A page with solids contains the viewer once, and no other page contains it; a drawing in its place is
/// included.
#[test]
fn pages_with_solids_bring_their_scripts() {
    let machine = crate::templates::tao2024();
    let state = SolidState {
        label: "new".into(),
        depth_um: vec![depths(&crate::geometry::Relief::uniform(1e-6))],
        rings: vec![vec![Position { te_arcmin: -0.25, contacts: vec![(1, 7, 812.5, 900.0)] }]],
    };
    let solids = || {
        Block::Solids(Solids {
            title: "solids".into(),
            note: String::new(),
            scene: crate::scene::of_machine(&machine),
            states: vec![state.clone()],
            instead: Some(mechanism(&machine, &[])),
        })
    };
    let html = page_of(vec![solids(), solids()]).render();
    assert_eq!(html.matches("three.js\n").count(), 1);
    assert!(html.len() < 2_000_000, "{}", html.len());
    let data = &figure_data(&html)[1];
    assert_eq!(data["states"][0]["rings"][0][0]["contacts"][0], serde_json::json!([1, 7, 812.5, 900.0]));
    assert_eq!(data["states"][0]["depth_um"][0].as_array().map(Vec::len), Some(181));
    assert_eq!(data["instead"]["pin_count"], data["scene"]["rings"][0]["pin_count"]);
    assert!(!page_of(vec![Block::Plot(plot_of(vec![(0.0, 1.0)]))]).render().contains("three.js\n"));
}

/// A plot without a note has a caption, too: the quantities of its axes with their units.
#[test]
fn every_caption_names_quantities() {
    let map = HeatMap {
        title: "map".into(),
        x: Axis::new("speed", "rpm"),
        y: Axis::new("torque", "N·m"),
        value: Axis::new("efficiency", "%"),
        x_values: vec![1.0, 2.0],
        y_values: vec![1.0],
        cells: vec![Some(1.0), Some(2.0)],
        note: String::new(),
        width: Width::Full,
    };
    let plot = plot_of(vec![(0.0, 1.0)]);
    let noted = plot.clone().noted("At rated torque.");
    let html = page_of(vec![Block::Plot(plot), Block::Plot(noted), Block::HeatMap(map)]).render();
    for caption in [
        "<b>Figure 1.</b> value (N) over x &lt;y&gt; (mm).",
        "<b>Figure 2.</b> At rated torque.",
        "<b>Figure 3.</b> efficiency (%) over speed (rpm) and torque (N·m).",
    ] {
        assert!(html.contains(caption), "{caption}");
    }
}

#[test]
fn text_from_outside_cannot_become_markup() {
    let mut plot = plot_of(vec![(0.0, 1.0)]);
    plot.title = "</script><img src=x onerror=alert(1)>".into();
    plot.note = "<i>note</i>".into();
    let html = page_of(vec![
        Block::Plot(plot),
        Block::Text("<b>bold</b> [<u>]".into()),
        Block::Code { title: "<t>".into(), text: "<c>&".into() },
        Block::Table(Table {
            title: "\"><x>".into(),
            columns: vec![Column::text("<h>")],
            rows: vec![vec!["<d>".into()]],
            note: String::new(),
        }),
    ])
    .render();
    for forbidden in ["<img", "<i>note", "<b>bold", "<u>", "<t>", "<c>", "<x>", "<h>", "<d>", "<script>alert"]
    {
        assert!(!html.contains(forbidden), "{forbidden} reached the page");
    }
    // The title inside the data is intact for the script, though it could end the element.
    assert_eq!(figure_data(&html)[0]["title"], "</script><img src=x onerror=alert(1)>");
}

#[test]
fn nothing_is_loaded_from_anywhere() {
    let html = page_of(vec![
        Block::Plot(plot_of(vec![(0.0, 1.0)])),
        Block::References(vec![Reference {
            key: "Tao2024".into(),
            citation: "Tao et al.".into(),
            doi: Some("10.3390/machines12080511".into()),
            used_for: "wear".into(),
        }]),
    ])
    .render();
    for loading in ["src=\"http", "<link", "@import", "fetch(", "XMLHttpRequest", "import("] {
        assert!(!html.contains(loading), "the page contains {loading}");
    }
    for (at, _) in html.match_indices("url(") {
        assert!(html[at..].starts_with("url(#"), "a style refers to a file");
    }
    assert!(html.contains("default-src 'none'"));
    // Addresses occur only as a link to follow and as the name of the SVG vocabulary.
    for (at, _) in html.match_indices("http") {
        let rest = &html[at..];
        assert!(
            rest.starts_with("https://doi.org/10.3390/machines12080511")
                || rest.starts_with("http://www.w3.org/2000/svg")
                || rest.starts_with("http-equiv"),
            "unexpected address: {}",
            &rest[..40]
        );
    }
}

#[test]
fn values_that_are_not_finite_become_gaps() {
    let points = vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, f64::INFINITY), (f64::NAN, 5.0), (3.0, 2.0)];
    let html = page_of(vec![Block::Plot(plot_of(points))]).render();
    let data = &figure_data(&html)[0]["series"][0]["points"];
    assert_eq!(data["x"], serde_json::json!([0, 1, 2, 3]));
    assert_eq!(data["y"], serde_json::json!([1, null, null, 2]));
}

#[test]
fn embedded_numbers_are_short_and_right_to_seven_digits() {
    for value in [1.0 / 3.0, -2.0e9 / 7.0, 6.02e-12 / 7.0, 123_456_789.123, 0.1 + 0.2, 5.0e-324, f64::MAX] {
        let text = serde_json::to_string(&plot::Number(value)).expect("a number");
        let back: f64 = text.parse().expect("a number again");
        // Half a unit of the seventh digit.
        assert!(
            (back - value).abs() <= 5.0e-7 * value.abs() || value.abs() < 1e-300,
            "{value} became {text}"
        );
        assert!(text.len() <= 14 || value.abs() > 1e15, "{value} became {text}");
    }
}

#[test]
fn same_page_same_bytes() {
    let build = || page_of(vec![Block::Plot(plot_of(vec![(0.0, 1.0), (0.1, 2.0)]))]).render();
    assert_eq!(build(), build());
}

#[test]
fn citations_link_only_to_entries_that_exist() {
    let html = page_of(vec![
        Block::Text("as [Tao2024] and [Nobody1999] say, `F = k δ`".into()),
        Block::References(vec![Reference {
            key: "Tao2024".into(),
            citation: "Tao et al.".into(),
            doi: None,
            used_for: String::new(),
        }]),
    ])
    .render();
    assert!(html.contains("href=\"#ref-Tao2024\"") && html.contains("id=\"ref-Tao2024\""));
    assert!(html.contains("[Nobody1999]") && !html.contains("#ref-Nobody1999"));
    assert!(html.contains("<code>F = k δ</code>"));
}

#[test]
fn every_link_inside_the_page_has_its_target() {
    let html = page_of(vec![Block::Text("text".into())]).render();
    for (at, mark) in html.match_indices("href=\"#") {
        let rest = &html[at + mark.len()..];
        let id = &rest[..rest.find('"').expect("closed attribute")];
        assert!(html.contains(&format!("id=\"{id}\"")), "no element #{id}");
    }
}

#[test]
fn significant_digits_as_engineers_write_them() {
    let cases = [
        (0.653_6, 3, "0.654"),
        (446.94, 4, "446.9"),
        (9.996, 3, "10.0"),
        (1.316e9, 3, "1.32e9"),
        (7500.0, 3, "7500"),
        (-0.0001234, 2, "-0.00012"),
        (0.0, 3, "0"),
        (f64::NAN, 3, "–"),
    ];
    for (value, digits, expected) in cases {
        assert_eq!(significant(value, digits), expected);
    }
}

/// Parts that reduce the whole are shown with their sign, and the shares add up to all of it.
#[test]
fn shares_add_up_with_their_signs() {
    let rows = [("clearance", 0.5), ("elastic", 0.2), ("preload", -0.1)];
    let rows = rows.map(|(label, value)| (label.to_owned(), value, String::new())).to_vec();
    let shares = Shares { title: "Causes".into(), unit: "arcmin".into(), rows, note: String::new() };
    let html = page_of(vec![Block::Shares(shares)]).render();
    for share in ["83.3 %", "33.3 %", "-16.7 %"] {
        assert!(html.contains(share), "{share}");
    }
    assert!(html.contains("<i class=\"less\" style=\"width:20.00%\">"));
}

/// The picture keeps the depth of the deepest place, however narrow it is, and the depths of an even flank.
#[test]
fn depths_of_a_picture_contain_the_deepest_place() {
    let mut samples = vec![1e-6; 720];
    samples[183] = 3.2e-6;
    let shown = depths(&crate::geometry::Relief::from_samples(samples));
    assert_eq!(shown.iter().copied().fold(0.0, f64::max), 3.2);
    assert_eq!(shown.iter().filter(|depth| **depth > 1.5).count(), 1);
    assert_eq!(shown.first(), shown.last());
}
