//! Judgements of lives with rigid and with elastic discs.

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

/// The second judgement uses fewer times and positions than a life with elastic discs; its limits agree with those of that life
/// within the two digits of their hours, and the values within 1 %.
#[test]
#[ignore = "long"]
fn both_kinds_of_discs_are_judged() {
    let text = find_drive("nema17-19").unwrap().text;
    // More wear than in the template, so that the limit of lost motion is reached.
    let text = text.replace("coefficient_per_pa = 1e-18", "coefficient_per_pa = 2e-17");
    let both = life_of(&text, "points = 8");
    let [rigid, elastic] =
        ["rigid", "elastic"].map(|discs| life_of(&text, &format!("points = 8\ndiscs = \"{discs}\"")));
    assert!(matches!(rigid.with_elastic_bodies, WithElasticBodies::NotAsked));
    assert!(matches!(elastic.with_elastic_bodies, WithElasticBodies::NotAsked));
    assert_eq!(both.verdict.limits, rigid.verdict.limits);
    let judged = both.with_elastic_bodies.judged().unwrap();
    assert_eq!((judged.bodies, judged.limits.len()), (SoftBodies::Discs, elastic.verdict.limits.len()));
    for (judged, elastic) in judged.limits.iter().zip(&elastic.verdict.limits) {
        let close = |a: f64, b: f64, share: f64| (a / b - 1.0).abs() < share;
        assert_eq!(judged.kind, elastic.kind);
        assert!(close(judged.value, elastic.value, 0.01), "{judged:?} {elastic:?}");
        assert_eq!(judged.hours.is_some(), elastic.hours.is_some(), "{judged:?} {elastic:?}");
        if let (Some(a), Some(b)) = (judged.hours, elastic.hours) {
            assert!(close(a, b, 0.02), "{judged:?} {elastic:?}");
        }
    }
    let lag = |prediction: &Prediction| prediction.points[0].accuracy.loaded_error.arcmin();
    assert!(lag(&judged.prediction) < 1.005 * lag(&rigid.prediction), "elastic discs lag more");
}

/// Beyond the service life fewer and longer updates lead to the same hours within 0.1 %.
#[test]
#[ignore = "long"]
fn long_updates_beyond_the_service_life_keep_the_hours() {
    for (template, limit) in [("nema17-19", 19.2), ("two-ring-225", 8.0), ("steel-59", 4.4)] {
        let any = AnyDesign::parse(find_drive(template).unwrap().text, "test").unwrap();
        let any = any.with("limits.lost_motion_arcmin", limit).unwrap();
        fn hours<D: EccentricDrive>(design: &D, waves_beyond: bool) -> (f64, f64) {
            let made = design.as_made(&Options::parse("", "test").unwrap().made, &NoHost).unwrap();
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

/// A limit between the lost motions with rigid and with elastic discs is undecided, and the verdict states both.
#[test]
#[ignore = "long"]
fn a_limit_kept_with_one_kind_of_discs_is_undecided() {
    let text = find_drive("nema17-19").unwrap().text;
    let plain = life_of(text, "points = 4");
    let lost_motion =
        |limits: &[Limit]| limits.iter().find(|limit| limit.kind == LimitKind::LostMotion).unwrap().value;
    let limits = [&plain.verdict.limits, &plain.with_elastic_bodies.judged().unwrap().limits];
    let values = limits.map(|limits| lost_motion(limits));
    assert!(values[1] > values[0] + 0.02 && plain.verdict.undecided.is_empty(), "{values:?}");
    let any = AnyDesign::parse(text, "test").unwrap();
    let between = any.with("limits.lost_motion_arcmin", 0.5 * (values[0] + values[1])).unwrap();
    let design = StageDesign::of_any(&between).unwrap();
    let life = run(design, &Options::parse("points = 4", "test").unwrap(), &NoHost).unwrap();
    let undecided: Vec<LimitKind> = life.verdict.undecided.iter().map(|one| one.kind).collect();
    assert_eq!((undecided, life.verdict.ok()), (vec![LimitKind::LostMotion], false));
    assert!(life.verdict.headline().contains("with rigid discs"), "{}", life.verdict.headline());
    // The second judgement is not computed if its result is not required.
    let without = OnlyResults { host: &NoHost, results: &["lost_motion_arcmin"] };
    let life = run(design, &Options::parse("points = 4", "test").unwrap(), &without).unwrap();
    assert!(matches!(life.with_elastic_bodies, WithElasticBodies::NotAsked));
}

/// Drives of two rings have no model of elastic discs and are judged once.
#[test]
fn drives_of_two_rings_are_judged_once() {
    let design = TwoRingDesign::parse(find_drive("two-ring-225").unwrap().text, "test").unwrap();
    let life = run(&design, &Options::parse("points = 4", "test").unwrap(), &NoHost).unwrap();
    assert!(matches!(life.with_elastic_bodies, WithElasticBodies::NotAsked));
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
