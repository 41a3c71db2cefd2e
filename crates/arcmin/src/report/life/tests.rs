use super::*;
use crate::machine::CrankAngle;
use crate::report::{Annotation, Page, Plot, Tone};
use crate::templates::rv_40e_81;
use crate::units::{DEG, UM};

fn row(hours: f64, depth_um: f64) -> LifeRow {
    LifeRow {
        hours,
        max_depth_um: depth_um,
        play_arcmin: 0.0654 * depth_um,
        te_loaded_arcmin: -0.09 - 0.0654 * depth_um,
        max_force_n: 400.0,
        max_pressure_mpa: 1200.0,
        loaded_pairs: 15.0,
        lost_motion_arcmin: Some(0.01 + 0.13 * depth_um),
        ..LifeRow::default()
    }
}

fn study() -> Vec<LifeRow> {
    [0.0, 1590.0, 2902.0, 4146.0, 5334.0, 6442.0, 7500.0]
        .iter()
        .enumerate()
        .map(|(level, hours)| {
            let mut row = row(*hours, 10.0 * level as f64);
            let play = row.play_arcmin;
            row.ste_rigid = Some(MeanAndMax { mean_arcmin: 0.6 * play, max_arcmin: play });
            row.dte_rigid = Some(MeanAndMax { mean_arcmin: 0.9 * play, max_arcmin: play + 0.17 });
            row.ste_flexible = Some(MeanAndMax { mean_arcmin: 0.6 * play, max_arcmin: play });
            row
        })
        .collect()
}

fn page_with(machine: &Machine, change: impl FnOnce(&mut LifePage)) -> Page {
    let cycle = machine
        .meshing(&Relief::uniform(0.0))
        .cycle(machine.rated.torque, 6)
        .expect("a new machine carries its rated torque");
    let worn = Relief::uniform(5.0 * UM);
    let worn_cycle = machine
        .meshing(&worn)
        .cycle(machine.rated.torque, 6)
        .expect("a worn machine carries its rated torque");
    let new = Relief::uniform(0.0);
    let (forces, worn_forces) = (cycle.flank_forces(), worn_cycle.flank_forces());
    let flanks = [
        WornFlank { hours: 0.0, flank: &new, cycle: &cycle, forces: &forces, peaks: &forces, pins: &[] },
        WornFlank {
            hours: 7500.0,
            flank: &worn,
            cycle: &worn_cycle,
            forces: &worn_forces,
            peaks: &worn_forces,
            pins: &[],
        },
    ];
    let (prediction, study) = ([row(0.0, 0.0), row(3750.0, 4.0), row(7500.0, 5.0)], study());
    let findings = crate::checks::check(machine);
    let mut life = LifePage {
        machine,
        provenance: Provenance::default(),
        design_name: "design.toml",
        design_text: "[ring]\npin_count = 40\n",
        contacts_alone: true,
        errors: None,
        prediction: &prediction,
        flanks: &flanks,
        hours_to_limit: None,
        searched_hours: 7500.0,
        ste_starts: Vec::new(),
        prediction_coefficient_per_pa: 8.4e-19,
        study: &study,
        study_coefficient_per_pa: 8.4e-19,
        ste_rigid_run: None,
        dte_rigid_run: None,
        ste_flexible_run: None,
        dte_flexible_run: None,
        findings: &findings,
        advice: Vec::new(),
        more: Vec::new(),
    };
    change(&mut life);
    life.page()
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
    let machine = rv_40e_81();
    let page = page_with(&machine, |_| {});
    let figure = plot(&page, "Contact force in the paper's study (closed form)");
    assert!((largest(figure, 0) / 446.94 - 1.0).abs() < 2e-3, "{}", largest(figure, 0));
    assert!((1..figure.series.len()).all(|level| largest(figure, level) > largest(figure, level - 1)));
    assert!(figure.note.contains("9535"), "the misprint is explained: {}", figure.note);
}

#[test]
fn figure_7_marks_the_inflection() {
    let page = page_with(&rv_40e_81(), |_| {});
    let figure = plot(&page, "Curvature radius of the flank");
    let Annotation::Vertical { at, .. } = figure.annotations[0] else { panic!("a vertical mark") };
    assert!((at - 34.644).abs() < 1e-3);
    // Concave before, convex after.
    let points = &figure.series[0].points;
    assert!(
        points
            .x
            .iter()
            .zip(&points.y)
            .filter_map(|(x, y)| y.map(|y| (x, y)))
            .all(|(x, y)| (*x < at) == (y > 0.0))
    );
}

/// Figure 10 ends where the study's uniform depth ends: the worst point of every level wears by the whole
/// step.
#[test]
fn figure_10_reaches_nearly_the_uniform_depth() {
    let page = page_with(&rv_40e_81(), |_| {});
    let figure = plot(&page, "Wear along the flank in the paper's study");
    let deepest = largest(figure, figure.series.len() - 1);
    // The worst angle moves from 61° to some 50° as the depth grows, so no single point collects all of it.
    assert!(deepest > 50.0 && deepest < 60.0, "{deepest}");
}

/// The drawing's rule, normals through the pitch point a·z_p·e(θ_k + α), carries the torque: 0.4815 T on each
/// disc of the new machine.
#[test]
fn drawn_forces_balance_the_torque() {
    let machine = rv_40e_81();
    let cycle = machine.meshing(&Relief::uniform(0.0)).cycle(machine.rated.torque, 6).expect("solvable");
    let drawing = crate::report::mechanism(&machine, &[("new".to_owned(), &cycle)]);
    let pins = drawing.pin_count;
    for (disc, phase) in drawing.eccentric_phase_deg.iter().enumerate() {
        for (step, forces) in drawing.states[0].force_n[disc].iter().enumerate() {
            let crank = std::f64::consts::TAU / pins as f64 * step as f64
                / drawing.states[0].force_n[disc].len() as f64
                + phase * DEG;
            let pitch_point = crate::geometry::unit(crank) * drawing.eccentricity_mm * pins as f64;
            let centre = crate::geometry::unit(crank) * drawing.eccentricity_mm;
            let moment: f64 = forces
                .iter()
                .enumerate()
                .map(|(pin, force)| {
                    let place = crate::geometry::unit(std::f64::consts::TAU * pin as f64 / pins as f64)
                        * drawing.pin_circle_radius_mm;
                    let normal = (pitch_point - place).normalize();
                    crate::geometry::cross(place - centre, normal) * 1e-3 * force
                })
                .sum();
            // Micrometres of elastic approach tilt the normals by some 1e-4.
            assert!(
                (moment / (0.48148 * machine.rated.torque) - 1.0).abs() < 2e-3,
                "disc {disc}, step {step}: {moment}"
            );
        }
    }
}

/// One pin pitch later the same forces act on the next pin: what lets the drawing turn on a table of one
/// pitch.
#[test]
fn forces_move_on_by_one_pin_per_pitch() {
    let machine = rv_40e_81();
    let meshing = machine.meshing(&Relief::uniform(3.0 * UM));
    let at = |crank: f64| meshing.load_sharing(CrankAngle::from_radians(crank), 412.0).expect("solvable");
    let pitch = meshing.kinematics().pattern_period();
    let force = |position: &crate::load::LoadSharing, pin: usize| {
        position.discs[1].iter().find(|contact| contact.pin == pin).map_or(0.0, |contact| contact.force)
    };
    let (here, later) = (at(0.05), at(0.05 + pitch));
    for pin in 0..40 {
        let (before, after) = (force(&here, pin), force(&later, (pin + 1) % 40));
        assert!((before - after).abs() < 1e-5 * 412.0, "pin {pin}: {before} N, then {after} N");
    }
}

#[test]
fn the_papers_numbers_stand_beside_its_own_machine_only() {
    let of = |machine: &Machine| page_with(machine, |_| {}).render();
    assert!(of(&rv_40e_81()).contains("0.5351"));
    let mut other = rv_40e_81();
    other.ring.pin_radius = 3.2e-3;
    assert!(!of(&other).contains("0.5351"));
}

#[test]
fn verdict_follows_the_hours_to_the_limit() {
    let machine = rv_40e_81();
    for (hours, tone) in [
        (Some(5000.0), Tone::Bad),
        (Some(8000.0), Tone::Caution),
        (Some(20_000.0), Tone::Good),
        (None, Tone::Good),
    ] {
        let verdict = page_with(&machine, |life| life.hours_to_limit = hours).verdict;
        assert_eq!(verdict.tone, tone, "{hours:?}: {}", verdict.headline);
        assert_eq!(verdict.figures.len(), 4);
        assert!(verdict.summary.contains(&verdict.headline));
    }
    // A prediction that stopped early is no promise for the whole life.
    let short = page_with(&machine, |life| life.searched_hours = 1500.0).verdict;
    assert_eq!(short.tone, Tone::Caution, "{}", short.headline);
}

#[test]
fn a_page_without_results_still_renders() {
    let machine = rv_40e_81();
    let page = page_with(&machine, |life| {
        life.prediction = &[];
        life.flanks = &[];
        life.study = &[];
        life.findings = &[];
    });
    assert!(page.render().contains("Nothing was predicted"));
}

#[test]
fn no_citation_is_left_without_its_entry() {
    let html = page_with(&rv_40e_81(), |_| {}).render();
    for key in ["Tao2024", "Johnson1985", "Archard1953"] {
        assert!(html.contains(&format!("href=\"#ref-{key}\"")), "{key} is not cited as a link");
        assert!(!html.contains(&format!("[{key}]")), "{key} is cited without an entry");
    }
}

#[test]
fn long_runs_keep_their_peaks_when_thinned() {
    let time: Vec<f64> = (0..100_000).map(|i| f64::from(i) * 1e-5).collect();
    let mut error: Vec<f64> = time.iter().map(|t| (t * 50.0).sin()).collect();
    error[41_234] = 7.5;
    // Leaked, because the page only borrows and the closure below outlives this function's locals.
    let run = RunTrace {
        wear_um: 10.0,
        time_s: time.clone().leak(),
        input_speed_deg_s: vec![9000.0; time.len()].leak(),
        output_speed_deg_s: vec![9000.0 / 81.0; time.len()].leak(),
        load_n_m: vec![0.0; time.len()].leak(),
        te_arcmin: error.leak(),
        steady_from_s: 0.1,
        mean_abs_arcmin: 0.64,
        max_abs_arcmin: 7.5,
    };
    let page = page_with(&rv_40e_81(), |life| life.ste_rigid_run = Some(run));
    let figure = plot(&page, "Rigid model without load: transmission error");
    assert_eq!(largest(figure, 0), 7.5);
    assert!(figure.series[0].points.x.len() <= 4000);
    assert!(figure.series[0].points.x.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(plot(&page, "Rigid model without load: speeds").note.contains("9000"));
}
