//! Lives with rigid and with elastic discs.

use super::*;
use crate::analyses::NoHost;
use crate::analyses::host::OnlyResults;
use crate::analyses::stage::{AnyDesign, rig};
use crate::design::{StageDesign, TwoRingDesign};
use crate::templates::find_drive;

fn life_of(text: &str, options: &str) -> StageLife {
    let design = StageDesign::parse(text, "test").unwrap();
    run(&design, &Options::parse(options, "test").unwrap(), &NoHost).unwrap()
}

/// Without a choice discs are elastic; a life with rigid discs states the deflections with both.
#[test]
#[ignore = "long"]
fn elastic_discs_are_the_default() {
    let text = find_drive("nema17-19").unwrap().text;
    let default = life_of(text, "points = 4");
    let [rigid, elastic] =
        ["rigid", "elastic"].map(|discs| life_of(text, &format!("points = 4\ndiscs = \"{discs}\"")));
    assert_eq!(default.verdict.limits, elastic.verdict.limits);
    assert_eq!((&default.about_discs, &elastic.about_discs), (&None, &None));
    let stated = rigid.about_discs.clone().unwrap();
    let [contacts, discs] = [&rigid, &elastic].map(|life| {
        let (accuracy, travel) = (&life.first().accuracy, life.first().travel.unwrap());
        accuracy.loaded_error.arcmin().abs() - travel.no_load_error.arcmin().abs()
    });
    assert!(discs > 1.02 * contacts, "{contacts} {discs}");
    for value in [contacts, discs] {
        assert!(stated.contains(&format!("{} arcmin", significant(value, 3))), "{stated} {value}");
    }
}

/// Discs whose walls are too thin for the mesh are rigid, with a finding, unless elastic ones were chosen.
#[test]
fn discs_without_room_for_a_mesh_are_rigid_with_a_finding() {
    let any = AnyDesign::parse(find_drive("nema17-19").unwrap().text, "test").unwrap();
    let any = any.with("output_pins.circle_radius_mm", 9.2).unwrap();
    let design = StageDesign::of_any(&any).unwrap();
    let of = |discs: &str| {
        let options = Options::parse(&format!("points = 4\n{discs}"), "test").unwrap();
        run(design, &options, &OnlyResults { host: &NoHost, results: &["verdict"] })
    };
    let life = of("").unwrap();
    let found = life.findings.iter().find(|finding| finding.code == "elastic-discs").unwrap();
    assert!(found.message.starts_with("discs are rigid: "), "{}", found.message);
    assert!(!life.made.elastic_discs);
    // Every result of such a drive states the reason, not only lives with their findings.
    assert!(life.made.model(StageDesign::STAGES).contains(&found.message));
    assert_eq!(life.verdict.limits, of("discs = \"rigid\"").unwrap().verdict.limits);
    assert!(of("discs = \"elastic\"").is_err());
}

/// Beyond the service life fewer and longer updates lead to the same hours within 0.1 %.
#[test]
#[ignore = "long"]
fn long_updates_beyond_the_service_life_keep_the_hours() {
    for (template, limit) in [("nema17-19", 19.2), ("two-ring-225", 8.0), ("steel-59", 4.4)] {
        let any = AnyDesign::parse(find_drive(template).unwrap().text, "test").unwrap();
        let any = any.with("limits.lost_motion_arcmin", limit).unwrap();
        fn hours<D: EccentricDrive>(design: &D, waves_beyond: bool) -> (f64, f64) {
            let made =
                design.as_made(&Options::parse("discs = \"rigid\"", "test").unwrap().made, &NoHost).unwrap();
            let options =
                LifeOptions { intervals: 4, crank_positions: 6, waves_beyond, ..LifeOptions::default() };
            let found = Predicted::of(&made, options, &NoHost, |_| ()).unwrap();
            let prediction = &found.predictions[main_of(D::STAGES)];
            (prediction.hours_to_limit.unwrap(), design.limits().service_life / HOUR)
        }
        let [(short, service), (long, _)] = [false, true].map(|waves| match &any {
            AnyDesign::TwoRing(design) => hours(&**design, waves),
            AnyDesign::Eccentric(design) => hours(&**design, waves),
            _ => unreachable!(),
        });
        assert!(short > service && (long / short - 1.0).abs() < 1e-3, "{template}: {short} {long} {service}");
    }
}

/// Drives of two rings have no model of elastic discs, so that theirs are rigid without a finding.
#[test]
fn discs_of_two_rings_are_rigid() {
    let design = TwoRingDesign::parse(find_drive("two-ring-225").unwrap().text, "test").unwrap();
    let life = run(&design, &Options::parse("points = 4", "test").unwrap(), &NoHost).unwrap();
    assert!(!life.made.elastic_discs && life.made.no_room.is_none() && life.about_discs.is_none());
}

/// Reports of life and bench, and the names of the bearings.
fn reports_of<D: EccentricDrive>(design: &D) -> ([String; 2], Vec<String>) {
    let options = Options::parse("points = 4\ndiscs = \"rigid\"", "test").unwrap();
    let life = run(design, &options, &OnlyResults { host: &NoHost, results: &["verdict"] }).unwrap();
    let options = rig::Options::parse("discs = \"rigid\"", "test").unwrap();
    let bench = rig::run(design, &options, &NoHost).unwrap();
    let names = life.bearings.bearings.iter().map(|bearing| bearing.name.clone()).collect();
    ([life.page().render(), bench.page().render()], names)
}

/// In the reports of every family each source that a text cites has its entry, and discs are counted from 1 as in design files.
#[test]
fn reports_have_the_sources_they_cite() {
    for template in ["nema17-19", "two-stage-500", "two-ring-225"] {
        let (html, names) = match AnyDesign::parse(find_drive(template).unwrap().text, "test").unwrap() {
            AnyDesign::Eccentric(design) => reports_of(&*design),
            AnyDesign::TwoStage(design) => reports_of(&*design),
            AnyDesign::TwoRing(design) => reports_of(&*design),
            AnyDesign::Rv(_) => panic!("{template} is an RV reducer"),
        };
        for (html, key) in html.iter().zip(["ISO281", "GBT35089"]) {
            assert!(
                html.contains(&format!("href=\"#ref-{key}\"")) && html.contains(&format!("id=\"ref-{key}\""))
            );
        }
        assert!(names.iter().any(|name| name.ends_with("disc 1")), "{names:?}");
        // Bands are explained where there is a column of them.
        let has_column = html[0].contains("90 % band");
        assert_eq!(html[0].contains("the band contains"), has_column, "{template}");
        assert!(!names.iter().any(|name| name.ends_with("disc 0")), "{names:?}");
    }
}
