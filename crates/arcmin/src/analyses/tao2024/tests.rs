use super::*;
use crate::analyses::{NoHost, Outcome, TextBlock};
use crate::report::{Annotation, Block, Page, Plot};

fn study(design: &Design) -> Tao2024 {
    run(design, &Options::parse("quasi_static = true", "test").unwrap(), &NoHost).unwrap()
}

fn default_study() -> Tao2024 {
    study(&crate::templates::design("tao2024").unwrap())
}

fn plots(page: &Page) -> impl Iterator<Item = &Plot> {
    page.sections.iter().flat_map(|section| &section.blocks).filter_map(|block| match block {
        Block::Plot(plot) => Some(plot),
        _ => None,
    })
}

fn plot<'a>(page: &'a Page, title: &str) -> &'a Plot {
    plots(page).find(|plot| plot.title == title).unwrap_or_else(|| panic!("no plot “{title}”"))
}

fn largest(plot: &Plot, series: usize) -> f64 {
    plot.series[series].points.y.iter().flatten().copied().fold(0.0, f64::max)
}

/// 446.94 N is F_max0 of the handbook for the paper's machine; the curve passes its maximum between two of
/// its points.
#[test]
fn figure_8_starts_at_the_handbooks_force() {
    let page = default_study().page();
    let figure = plot(&page, "Contact force in the paper's study (closed form)");
    assert!((largest(figure, 0) / 446.94 - 1.0).abs() < 2e-3, "{}", largest(figure, 0));
    assert!((1..figure.series.len()).all(|level| largest(figure, level) > largest(figure, level - 1)));
    assert!(figure.note.contains("9535"), "the misprint is explained: {}", figure.note);
}

#[test]
fn figure_7_marks_the_inflection() {
    let page = default_study().page();
    let figure = plot(&page, "Curvature radius of the flank");
    let Annotation::Vertical { at, .. } = figure.annotations[0] else { panic!("a vertical mark") };
    assert!((at - 34.644).abs() < 1e-3);
    // Concave before, convex after.
    let points = figure.series[0].points.x.iter().zip(&figure.series[0].points.y);
    assert!(points.filter_map(|(x, y)| y.map(|y| (x, y))).all(|(x, y)| (*x < at) == (y > 0.0)));
}

/// Figure 10 ends where the study's uniform depth ends: the worst point of every level wears by the whole
/// step.
#[test]
fn figure_10_reaches_nearly_the_uniform_depth() {
    let page = default_study().page();
    let figure = plot(&page, "Wear along the flank in the paper's study");
    let deepest = largest(figure, figure.series.len() - 1);
    // The worst angle moves from 61° to some 50° as the depth grows, so no single point collects all of it.
    assert!(deepest > 50.0 && deepest < 60.0, "{deepest}");
}

#[test]
fn the_papers_numbers_stand_beside_its_own_machine_only() {
    let design = crate::templates::design("tao2024").unwrap();
    let simulated = |design: &Design| {
        let mut study = study(design);
        let wear = [Relief::uniform(0.0)];
        let settings = StudySettings {
            plan: crate::dynamics::RunPlan { end: 0.11, ..Default::default() },
            perturbed_starts: 0,
            ..StudySettings::tao2024(&study.machine)
        };
        let runs = transmission_error_study(&study.machine, &wear, &settings, &NoHost).unwrap();
        for level in &mut study.levels {
            level.rigid = Some(runs.points[0].clone());
        }
        study.page().render()
    };
    assert!(simulated(&design).contains("0.5351"));
    assert!(!simulated(&design.with("ring.pin_radius_mm", 3.2).unwrap()).contains("0.5351"));
}

/// Hours and play of the paper's levels, in the table under the names that outside checks rely on.
#[test]
fn the_table_has_the_papers_levels() {
    let study = default_study();
    let table = &study.tables()[0];
    assert_eq!(table.file_name(), "tao2024.csv");
    let hours = table.numbers("hours").unwrap();
    assert!((hours[6] - 7500.0).abs() < 1e-6 && (hours[5] / 6442.0 - 1.0).abs() < 0.01);
    assert!((table.numbers("play_arcmin").unwrap()[1] - 0.6536).abs() < 1e-3);
    assert!(table.numbers("ste_rigid_mean_arcmin").unwrap().iter().all(|value| value.is_nan()));
}

/// A closed form that does not settle costs the hours, not the study.
#[test]
fn a_closed_form_without_convergence_is_reported() {
    let mut study = default_study();
    study.coefficient = None;
    study.unsettled = Some("it did not settle".to_owned());
    for level in &mut study.levels {
        (level.hours, level.handbook) = (None, None);
    }
    assert!(study.page().render().contains("it did not settle"));
    assert!(study.tables()[0].numbers("hours").unwrap().iter().all(|value| value.is_nan()));
    assert!(
        study
            .text_blocks()
            .iter()
            .any(|said| matches!(said, TextBlock::Line(line) if line.contains("no hours")))
    );
}

#[test]
fn bearings_are_refused_with_the_reason() {
    let design = crate::templates::design("tao2024").unwrap();
    let options = Options::parse("joints = \"bearings\"", "test").unwrap();
    let error = run(&design, &options, &NoHost).unwrap_err();
    assert!(error.to_string().contains("ideal joints"), "{error}");
}

#[test]
fn no_citation_is_left_without_its_entry() {
    let html = default_study().page().render();
    for key in ["Tao2024", "Archard1953"] {
        assert!(html.contains(&format!("href=\"#ref-{key}\"")), "{key} is not cited as a link");
        assert!(!html.contains(&format!("[{key}]")), "{key} is cited without an entry");
    }
}
