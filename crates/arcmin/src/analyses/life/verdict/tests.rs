use super::*;

fn limit(kind: LimitKind, hours: Option<f64>) -> Limit {
    Limit { kind, place: Some("turning arm".to_owned()), value: 1.0, allowed: 2.0, hours, transient: false }
}

fn verdict(limits: Vec<Limit>) -> LifeVerdict {
    LifeVerdict { limits, service_h: 7500.0, searched_h: 30_000.0 }
}

/// Lost motion kept for 9235 h of 7500 is no green tick where a bearing lasts 4885 h.
#[test]
fn the_worst_limit_speaks_first() {
    let both = verdict(vec![
        limit(LimitKind::LostMotion, Some(9235.0)),
        limit(LimitKind::BearingLife, Some(4885.0)),
    ]);
    assert!(!both.ok());
    assert_eq!(both.tone(), Tone::Bad);
    assert_eq!(both.hours_to_limit(), Some(4885.0));
    assert_eq!(both.limited_by().unwrap().kind, LimitKind::BearingLife);
    assert!(both.headline().starts_with("The bearing “turning arm” lasts 4885 h"), "{}", both.headline());
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

/// Pressure of the new machine is judged over the life; another error ends it at once.
#[test]
fn a_pressure_is_not_judged_twice() {
    let error = |code: &'static str| Finding {
        code,
        severity: Severity::Error,
        message: String::new(),
        value: 2.0,
        limit: 1.0,
        unit: "",
        why: "",
        change: "",
    };
    assert_eq!(errors(&[error(CONTACT_PRESSURE)]).map(|limit| limit.value), None);
    let both = errors(&[error(CONTACT_PRESSURE), error("undercut")]).unwrap();
    assert_eq!((both.place.as_deref(), both.hours), (Some("undercut"), Some(0.0)));
}

/// Exceeded while contacts wear in, exceeded from the start for good, exceeded later, never.
#[test]
fn a_pressure_of_wearing_in_is_told_apart() {
    let of = |values: [f64; 6]| {
        let history: Vec<(f64, f64)> =
            values.iter().enumerate().map(|(i, value)| (1500.0 * i as f64, *value)).collect();
        let limit = worn_in(&history, 2000.0, 7500.0);
        (limit.hours, limit.transient)
    };
    assert_eq!(of([2400.0, 2100.0, 1900.0, 1800.0, 1700.0, 1700.0]), (None, true));
    assert_eq!(of([2400.0, 2300.0, 2200.0, 2100.0, 2050.0, 2010.0]), (Some(0.0), false));
    let (hours, transient) = of([1500.0, 1600.0, 1700.0, 1900.0, 2100.0, 2300.0]);
    assert!(!transient && (hours.unwrap() - 5250.0).abs() < 1e-6);
    assert_eq!(of([1500.0; 6]), (None, false));
}
