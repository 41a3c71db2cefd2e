//! Designs and results as JSON.

use arcmin::analyses::life::Life;
use arcmin::analyses::stage::AnyDesign;
use arcmin::analyses::stage::life::StageLife;
use arcmin::analyses::{AnalysisError, Host, Outcome};
use arcmin::design::{Choice, KeyEntry, Kind, Value};
use arcmin::life::{LifePoint, WornState};
use arcmin::load::ShareLoad;
use arcmin::report::{Position, depths, positions};
use arcmin::results::{Cells, Table};
use arcmin::scene::{Ring, Scene};
use arcmin::units::{ARCMIN, MPA, UM};
use serde_json::{Map, Value as Json, json};

use super::session::{Session, Snapshot};
use super::work::HEADLINE;

/// A JSON value as the value of a key; `None` for lists and objects.
pub fn value_of(json: &Json) -> Option<Value> {
    match json {
        Json::Null => Some(Value::LeftOut),
        Json::Bool(flag) => Some(Value::Flag(*flag)),
        Json::Number(number) => number.as_f64().map(Value::Number),
        Json::String(text) => Some(Value::Text(text.clone())),
        Json::Array(_) | Json::Object(_) => None,
    }
}

fn json_of(value: &Value) -> Json {
    match value {
        Value::LeftOut => Json::Null,
        Value::Number(number) => json!(number),
        Value::Count(count) => json!(count),
        Value::Text(text) => json!(text),
        Value::Flag(flag) => json!(flag),
        Value::Pairs(pairs) => json!(pairs),
        Value::Numbers(numbers) => json!(numbers),
        Value::Texts(texts) => json!(texts),
        Value::Material(_) => json!(value.to_string()),
    }
}

/// Kind of value of a key, for its control.
fn kind_of(kind: Kind) -> (&'static str, Vec<[&'static str; 2]>) {
    match kind {
        Kind::Number => ("number", Vec::new()),
        Kind::Count => ("count", Vec::new()),
        Kind::Flag => ("flag", Vec::new()),
        Kind::Choice(words) => ("choice", words.iter().map(|(word, what)| [*word, *what]).collect()),
        Kind::Text => ("text", Vec::new()),
        _ => ("other", Vec::new()),
    }
}

/// All keys of a design with their schema.
pub fn keys(keys: &[KeyEntry]) -> Json {
    let one = |key: &KeyEntry| {
        let (kind, words) = kind_of(key.kind);
        json!({
            "path": key.path, "unit": key.unit, "range": key.range, "default": json_of(&key.default),
            "required": key.required, "kind": kind, "words": words, "what": key.documentation,
        })
    };
    keys.iter().map(one).collect()
}

/// Limits of the strip over the hours, by column of `life.csv`.
fn limits(design: &AnyDesign) -> Json {
    let limits = design.limits();
    json!({
        "lost_motion_arcmin": limits.lost_motion / ARCMIN,
        "max_pressure_mpa": limits.contact_pressure / MPA,
        "service_life_h": limits.service_life / arcmin::units::HOUR,
    })
}

/// The present design with all available results.
pub fn state(session: &Session, snapshot: &Snapshot) -> String {
    let design = &snapshot.state.design;
    let keys = snapshot.state.design.keys();
    let values: Map<String, Json> = keys.iter().map(|key| (key.path.clone(), json_of(&key.value))).collect();
    let answers: Map<String, Json> = snapshot
        .answers
        .iter()
        .filter(|(name, _)| **name != "film")
        .filter_map(|(name, answer)| Some(((*name).to_owned(), serde_json::from_str(answer).ok()?)))
        .collect();
    // The headline: main results that are computed after every change, under the keys of their `summary.json`.
    // `errors` are those of the machine that `contact` computes; the number of error findings is in `check`.
    let mut results = Map::new();
    for name in HEADLINE {
        if let Some(summary) = answers.get(name).and_then(|answer| answer["summary"].as_object()) {
            for (key, value) in summary.iter().filter(|(key, _)| *key != "findings") {
                results.entry(key.clone()).or_insert_with(|| value.clone());
            }
        }
    }
    let findings = answers.get("check").map_or(Json::Null, |answer| answer["summary"]["findings"].clone());
    json!({
        "state": snapshot.state.number,
        "design": {
            "name": design.name(),
            "family": design.family().word(),
            "file": session.file_name(),
            "hash": design.hash(),
            "toml": snapshot.state.design.text(),
            "values": values,
            "limits": limits(design),
        },
        "results": results,
        "findings": findings,
        "analyses": answers,
        "pending": snapshot.pending,
        "can_undo": snapshot.can_undo,
        "can_redo": snapshot.can_redo,
        "changes": snapshot.changes,
        "scene": design.scene(),
    })
    .to_string()
}

/// A table by its columns.
pub fn table(table: Option<&Table>) -> Json {
    let Some(table) = table else { return Json::Null };
    let column = |cells: &Cells| (0..cells.len()).map(|row| cells.value(row).to_json()).collect::<Vec<_>>();
    table
        .columns
        .iter()
        .map(|c| (c.quantity.key.to_owned(), json!(column(&c.cells))))
        .collect::<Map<_, _>>()
        .into()
}

/// Name of the table of `contact` with the pins of a ring.
pub fn contact_table(ring: &Ring) -> String {
    format!("{}contact", ring.key)
}

/// Name of the table of `contact` with the rolling elements beside a ring; not every family has it.
pub fn rollers_table(ring: &Ring, design: &AnyDesign) -> String {
    let bearing = if matches!(design, AnyDesign::Rv(_)) { "turning_arm" } else { "eccentric" };
    format!("{}{bearing}_rollers", ring.key)
}

/// One turn of `contact`: pins and rolling elements of every ring, and the error at every position.
pub fn film(tables: &[Table], rollers: &[Table], design: &AnyDesign, scene: &Scene) -> Json {
    let columns_of = |tables: &[Table], name: &str, columns: &[&str]| {
        let table = table(tables.iter().find(|table| table.name == name));
        columns.iter().map(|column| ((*column).to_owned(), table[*column].clone())).collect::<Map<_, _>>()
    };
    let error = columns_of(tables, "error", &["crank_angle_deg", "te_loaded_arcmin"]);
    let pins = |ring| {
        columns_of(
            tables,
            &contact_table(ring),
            &["crank_angle_deg", "disc", "pin", "force_n", "pressure_mpa"],
        )
    };
    let rollers = |ring| {
        let columns = ["crank_angle_deg", "crankshaft", "disc", "direction_deg", "force_n"];
        columns_of(rollers, &rollers_table(ring, design), &columns)
    };
    json!({
        "crank_angle_deg": error["crank_angle_deg"],
        "te_loaded_arcmin": error["te_loaded_arcmin"],
        "contacts": scene.rings.iter().map(pins).collect::<Vec<_>>(),
        "rollers": scene.rings.iter().map(rollers).collect::<Vec<_>>(),
    })
}

/// A state of the life as soon as it is reached, with values that need no further equilibrium.
pub fn reached(state: &WornState, scene: &Scene) -> Json {
    // Hosts get the state of the ring whose keys have no prefix.
    let of = |ring: &Ring| ring.key.is_empty().then(|| depths(state.surfaces.flank()));
    let flanks: Vec<Option<Vec<f64>>> = scene.rings.iter().map(of).collect();
    json!({ "hours": state.hours, "max_depth_um": state.deepest() / UM, "depth_um": flanks })
}

/// Ages at which forces are computed.
const FORCE_AGES: usize = 5;
/// Crank positions over one pin pitch.
const FORCE_POSITIONS: usize = 12;

/// The flank of each ring at every point of a life, and at some of them the forces over one pin pitch of crank
/// angle.
///
/// # Errors
/// [`AnalysisError`] where the joints cannot be modelled, or the computation is cancelled.
pub fn ages(outcome: &dyn Outcome, host: &dyn Host) -> Result<Json, AnalysisError> {
    if let Some(life) = outcome.as_any().downcast_ref::<Life>() {
        let (machine, points) = (&life.machine, &life.prediction.points);
        let (designed, law) = (machine.designed_relief(), machine.line_contact());
        let mut joints = life.fidelity.meshing(machine)?;
        return ages_of(&[points], host, |index| {
            points[index].state.apply_to(&designed, &mut joints);
            let cycle = joints.pitch_cycle(machine.rated().torque, FORCE_POSITIONS).ok()?;
            Some(vec![positions(&cycle, law)])
        });
    }
    if let Some(life) = outcome.as_any().downcast_ref::<StageLife>() {
        let rings: Vec<&Vec<LifePoint>> = life.rings.iter().map(|(_, ring)| &ring.points).collect();
        return ages_of(&rings, host, |index| Some(life.pictured(index, FORCE_POSITIONS)?.rings));
    }
    Ok(Json::Null)
}

/// For the points of every ring; `forces_at` gives those at one of them, ring by ring, if the load sharing has
/// a solution.
fn ages_of(
    rings: &[&Vec<LifePoint>],
    host: &dyn Host,
    mut forces_at: impl FnMut(usize) -> Option<Vec<Vec<Position>>>,
) -> Result<Json, AnalysisError> {
    let points = rings[0];
    let last = points.len() - 1;
    let mut shown: Vec<usize> = (0..FORCE_AGES).map(|i| i * last / (FORCE_AGES - 1)).collect();
    shown.dedup();
    let mut forces = Vec::new();
    for index in shown {
        if host.is_cancelled() {
            return Err(AnalysisError::Stopped);
        }
        // If the wear runs away, the last point may have no load sharing.
        let Some(found) = forces_at(index) else { continue };
        forces.push(json!({ "hours": points[index].hours(), "rings": found }));
    }
    let flank = |ring: &&Vec<LifePoint>, index: usize| depths(ring[index].state.surfaces.flank());
    let flanks: Vec<Vec<Vec<f64>>> =
        (0..points.len()).map(|index| rings.iter().map(|ring| flank(ring, index)).collect()).collect();
    Ok(json!({ "depth_um": flanks, "forces": forces }))
}
