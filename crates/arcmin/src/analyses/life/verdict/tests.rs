use super::super::record::worn_in;
use super::super::undecided::undecided;
use super::*;

fn limit(kind: LimitKind, hours: Option<f64>) -> Limit {
    Limit { place: Some("turning arm".to_owned()), ..Limit::new(kind, 1.0, 2.0).lasting(hours) }
}

fn verdict(limits: Vec<Limit>) -> LifeVerdict {
    LifeVerdict { limits, service_h: 7500.0, searched_h: 30_000.0, band: None, undecided: Vec::new() }
}

/// A limit that the new machine exceeds is no limit that is reached after 0 h.
#[test]
fn limits_exceeded_from_the_start_are_called_so() {
    for (kind, words) in [
        (LimitKind::LostMotion, "Lost motion is above 2 arcmin from the start"),
        (LimitKind::TransmissionError, "Transmission error is above 2 arcmin from the start"),
        (LimitKind::Backlash, "Backlash is above 2 arcmin from the start"),
    ] {
        assert_eq!(limit(kind, Some(0.0)).sentence(), words);
        assert!(limit(kind, Some(10.0)).sentence().contains("after about 10 h"));
    }
}

/// Lost motion is kept for 9235 h of 7500 h; a bearing with 4885 h makes the verdict bad.
#[test]
fn the_first_limit_is_stated_first() {
    let both = verdict(vec![
        limit(LimitKind::LostMotion, Some(9235.0)),
        limit(LimitKind::BearingLife, Some(4885.0)),
    ]);
    assert!(!both.ok());
    assert_eq!(both.tone(), Tone::Bad);
    assert_eq!(both.hours_to_limit(), Some(4885.0));
    assert_eq!(both.limited_by().unwrap().kind, LimitKind::BearingLife);
    assert!(
        both.headline().starts_with("The bearing “turning arm” has an L10 of about 4900 h"),
        "{}",
        both.headline()
    );
}

/// The range of the first limit stands once in the sentence, whether the limit or the verdict alone has it.
#[test]
fn the_range_of_the_hours_is_stated_once() {
    let band = Band {
        low: Some(8000.0),
        high: Some(22_000.0),
        hangs_on: Some("wear.coupled.coefficient_per_pa".to_owned()),
        furthest_h: 30_000.0,
    };
    let first = limit(LimitKind::LostMotion, Some(12_000.0));
    for of_limit in [Some(band.clone()), None] {
        let limits = vec![Limit { band: of_limit, ..first.clone() }];
        let text = LifeVerdict { band: Some(band.clone()), ..verdict(limits) }.headline();
        assert_eq!(text.matches("8000 to 22000 h").count(), 1, "{text}");
        assert!(
            text.ends_with("`wear.coupled.coefficient_per_pa` has the largest influence: measure it first.")
        );
    }
}

#[test]
fn the_tone_follows_the_first_limit() {
    for (hours, tone) in [
        (Some(5000.0), Tone::Bad),
        (Some(8000.0), Tone::Caution),
        (Some(20_000.0), Tone::Good),
        (None, Tone::Good),
    ] {
        let one = verdict(vec![limit(LimitKind::LostMotion, hours)]);
        assert_eq!(one.tone(), tone, "{hours:?}: {}", one.headline());
        assert_eq!(one.ok(), tone != Tone::Bad);
    }
}

/// A limit that is kept with only one kind of bodies is undecided: the verdict is not ok, in words undecided, with both
/// hours. A limit that is kept with neither is not kept, also if another one is undecided.
#[test]
fn verdicts_that_depend_on_the_bodies_are_undecided() {
    let rigid = vec![
        limit(LimitKind::LostMotion, Some(8849.0)),
        limit(LimitKind::ContactPressure, None),
        limit(LimitKind::BearingLife, Some(9000.0)),
    ];
    let elastic = vec![
        limit(LimitKind::LostMotion, Some(894.0)),
        limit(LimitKind::ContactPressure, None),
        limit(LimitKind::BearingLife, Some(8000.0)),
    ];
    let found = undecided(&rigid, &elastic, 7500.0);
    assert_eq!(found.iter().map(|one| one.kind).collect::<Vec<_>>(), [LimitKind::LostMotion]);
    let open = LifeVerdict { undecided: found, ..verdict(rigid.clone()) };
    assert!(!open.ok() && open.word() == "undecided" && open.tone() == Tone::Caution);
    let headline = open.headline();
    assert!(headline.starts_with("Undecided: lost motion (8800 h"), "{headline}");
    assert!(headline.contains("890 h") && !headline.contains("Keeps every limit"), "{headline}");
    let mut broken = rigid;
    broken[2].hours = Some(4885.0);
    let mut worse = elastic;
    worse[2].hours = Some(3106.0);
    let both = LifeVerdict { undecided: undecided(&broken, &worse, 7500.0), ..verdict(broken) };
    assert_eq!((both.word(), both.tone(), both.undecided.len()), ("not kept", Tone::Bad, 1));
    let headline = both.headline();
    assert!(headline.starts_with("The bearing") && headline.contains("Undecided: lost motion"), "{headline}");
    // The other way round, elastic bodies alone keep it.
    let flipped = undecided(&worse, &both.limits, 7500.0);
    assert_eq!(flipped.len(), 1);
}

/// Exceeded while contacts wear in, exceeded from the start for good, exceeded later, never; and the wear
/// that follows decides, however long it takes.
#[test]
fn a_pressure_during_running_in_is_distinguished() {
    let of = |values: [f64; 6]| {
        let history: Vec<(f64, f64)> =
            values.iter().enumerate().map(|(i, value)| (1500.0 * i as f64, *value)).collect();
        let limit = worn_in(&history, 2000.0);
        (limit.hours, limit.worn_in_h.map(f64::round))
    };
    assert_eq!(of([2400.0, 2100.0, 1900.0, 1800.0, 1700.0, 1700.0]), (None, Some(2250.0)));
    assert_eq!(of([2400.0, 2300.0, 2200.0, 2100.0, 1900.0, 1900.0]), (None, Some(5250.0)));
    assert_eq!(of([2400.0, 2300.0, 2200.0, 2100.0, 2050.0, 2010.0]), (Some(0.0), None));
    assert_eq!(of([2400.0, 1900.0, 1900.0, 1900.0, 2050.0, 2010.0]), (Some(0.0), None));
    let (hours, worn_in_h) = of([1500.0, 1600.0, 1700.0, 1900.0, 2100.0, 2300.0]);
    assert!(worn_in_h.is_none() && (hours.unwrap() - 5250.0).abs() < 1e-6);
    assert_eq!(of([1500.0; 6]), (None, None));
}

#[test]
fn hours_are_rounded_to_two_digits() {
    let all = [0.0, 7.4, 96.0, 1249.0, 13_953.0, 30_000.0].map(about);
    assert_eq!(all, ["0", "7", "96", "1200", "14000", "30000"]);
}
