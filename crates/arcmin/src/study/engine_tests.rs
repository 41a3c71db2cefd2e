//! Any sharding, in any order, with parts lost and broken on the way, gives the same rows.

use std::sync::atomic::{AtomicU64, Ordering};

use serde_json::{Value as Json, json};

use super::collect::collect;
use super::plan::{Factor, Kept, Kind, Plan, Row, Setting};
use super::run::{Done, Memory, RowError, Shard, Watch, run};
use super::sampling::Layout;
use super::{Distribution, Purpose, Stream};

fn plan(what: &str, samples: u64) -> Plan {
    let factors = vec![
        Factor::number("disc.width_mm", "mm", Distribution::Uniform { low: 8.0, high: 9.0 }),
        Factor::one_of("contact.law", vec![Setting::Word("hertz".into()), Setting::Word("a, \"b\"".into())]),
        Factor { whole: true, ..Factor::number("n", "", Distribution::Uniform { low: 1.0, high: 5.0 }) },
        Factor::drawn(),
    ];
    let kept = [
        ("te.mean_arcmin", Kind::Number),
        ("word", Kind::Word),
        ("curve", Kind::Curve),
        ("ok", Kind::Number),
    ];
    let kept = kept.map(|(key, kind)| Kept { key: key.into(), kind }).to_vec();
    Plan::new(what, factors, Layout::Sobol, samples, 3, kept).unwrap().with_samples_per_part(8)
}

/// Some arithmetic that fails here and there.
fn compute(row: &Row) -> Result<Json, RowError> {
    let [Setting::Number(width), Setting::Word(_), Setting::Number(n), Setting::Seed(seed)] =
        &row.settings[..]
    else {
        panic!("{row:?}");
    };
    if row.number % 7 == 3 {
        return Err(RowError::Failed(format!("jams, \"at\" {n}")));
    }
    let curve: Vec<Json> = (0..row.number % 4).map(|k| json!(k as f64 * width)).collect();
    Ok(
        json!({ "te": { "mean_arcmin": width.sin() * *seed as f64 }, "word": "x\ny", "curve": curve, "ok": true }),
    )
}

fn go(plan: &Plan, shard: Shard, store: &Memory) -> Done {
    run(plan, shard, store, &compute, &Watch::NONE).unwrap()
}

fn csv(plan: &Plan, store: &Memory) -> String {
    collect(plan, store).unwrap().to_csv(plan)
}

#[test]
fn any_sharding_gives_the_same_rows() {
    let plan = plan("a", 100);
    let whole = Memory::default();
    let done = go(&plan, Shard::WHOLE, &whole);
    assert_eq!((done.computed, done.found, done.failed), (100, 0, 14));
    let expected = csv(&plan, &whole);
    assert_eq!(expected.lines().count(), 1 + 100 + 86);
    for shards in [2, 7, 50] {
        let store = Memory::default();
        let mut order: Vec<u64> = (1..=shards).collect();
        Stream::new(1, Purpose::Points, shards).shuffle(&mut order);
        for index in order {
            go(&plan, Shard::new(index, shards).unwrap(), &store);
        }
        assert_eq!(csv(&plan, &store), expected);
        assert_eq!(*store.0.lock().unwrap(), *whole.0.lock().unwrap(), "bytes of the parts");
        assert_eq!(go(&plan, Shard::WHOLE, &store).found, 100);
    }
}

#[test]
fn killed_shards_lose_only_their_running_rows() {
    let plan = plan("a", 100);
    let whole = Memory::default();
    go(&plan, Shard::WHOLE, &whole);
    let store = Memory::default();
    for kill in 0..30 {
        let mut stream = Stream::new(2, Purpose::Points, kill);
        let until = stream.below(12) as u64;
        let count = AtomicU64::new(0);
        let stopping = |row: &Row| {
            if count.fetch_add(1, Ordering::Relaxed) >= until {
                Err(RowError::Cancelled)
            } else {
                compute(row)
            }
        };
        let shard = Shard::new(1 + stream.below(7) as u64, 7).unwrap();
        run(&plan, shard, &store, &stopping, &Watch::NONE).unwrap();
        // A part is cut off, or its bytes are spoilt, by whatever the system did.
        let mut parts = store.0.lock().unwrap();
        let name = parts.keys().nth(stream.below(parts.len().max(1))).cloned();
        if let (Some(name), 0) = (name, kill % 3) {
            let bytes = parts.get_mut(&name).unwrap();
            bytes.truncate(stream.below(bytes.len()));
        }
    }
    let done = go(&plan, Shard::WHOLE, &store);
    assert!(done.computed + done.found == 100 && done.found > 0 && !done.cancelled, "{done:?}");
    assert_eq!(csv(&plan, &store), csv(&plan, &whole));
}

#[test]
fn parts_of_another_study_are_not_taken() {
    let store = Memory::default();
    go(&plan("a", 20), Shard::WHOLE, &store);
    let rows = collect(&plan("b", 20), &store).unwrap();
    assert!(rows.records.is_empty() && rows.unusable.len() == 3, "{:?}", rows.unusable);
    assert!(rows.unusable[0].1.contains("another study"));
    assert_eq!(go(&plan("b", 20), Shard::WHOLE, &store).replaced, 3);
    // More samples of the same study are the same study.
    let store = Memory::default();
    go(&plan("a", 24), Shard::WHOLE, &store);
    assert_eq!(go(&plan("a", 40), Shard::WHOLE, &store).found, 24);
}

#[test]
fn rows_are_found_by_their_place() {
    let plan = plan("a", 20);
    let store = Memory::default();
    go(&plan, Shard::new(2, 3).unwrap(), &store);
    let rows = collect(&plan, &store).unwrap();
    assert!(!rows.is_complete() && rows.records.len() == 8 && rows.of == 20);
    let in_place = rows.in_place(&plan, "te.mean_arcmin").unwrap();
    assert!(in_place[..8].iter().all(Option::is_none) && in_place[8].is_some() && in_place[10].is_none());
    assert_eq!(rows.numbers(&plan, "ok").unwrap().iter().flatten().sum::<f64>(), 7.0);
    assert!(rows.numbers(&plan, "nothing").is_none());
    assert!(Shard::parse("3/50").is_some() && Shard::parse("0/5").is_none() && Shard::parse("6/5").is_none());
}
