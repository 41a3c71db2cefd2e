//! Designs and results as JSON.

use arcmin::analyses::life::Life;
use arcmin::analyses::stage::AnyDesign;
use arcmin::analyses::stage::life::StageLife;
use arcmin::analyses::{AnalysisError, Host, Outcome};
use arcmin::contact::LineContact;
use arcmin::design::{Choice, KeyEntry, Kind, Value};
use arcmin::dynamics::StageMeshing;
use arcmin::geometry::Relief;
use arcmin::life::{LifePoint, WornState};
use arcmin::load::ShareLoad;
use arcmin::results::{Cells, Table};
use arcmin::scene::{self, Scene};
use arcmin::units::{ARCMIN, DEG, MPA, UM};
use serde_json::{Map, Value as Json, json};

use super::session::{Look, Session};
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

/// What a key can be, for its control.
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

/// All keys of a design with what the schema says of them.
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

pub fn scene_of(design: &AnyDesign) -> Scene {
    match design {
        AnyDesign::Rv(design) => scene::of_machine(&design.machine()),
        AnyDesign::Eccentric(design) => scene::of_stage(design),
        _ => unreachable!("drives of other families are refused when they are opened"),
    }
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

/// The present design with all that is known of it.
pub fn state(session: &Session, look: &Look) -> String {
    let design = &look.state.design;
    let keys = look.state.design.keys();
    let values: Map<String, Json> = keys.iter().map(|key| (key.path.clone(), json_of(&key.value))).collect();
    let answers: Map<String, Json> = look
        .answers
        .iter()
        .filter(|(name, _)| **name != "film")
        .filter_map(|(name, answer)| Some(((*name).to_owned(), serde_json::from_str(answer).ok()?)))
        .collect();
    // The headline: figures of all that a change waits for, under the keys of their `summary.json`. `errors` are those
    // of the machine that `contact` computes; how many findings are errors stands with `check`.
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
        "state": look.state.number,
        "design": {
            "name": design.name(),
            "family": design.family().word(),
            "file": session.file_name(),
            "hash": design.hash(),
            "toml": look.state.design.text(),
            "values": values,
            "limits": limits(design),
        },
        "results": results,
        "findings": findings,
        "analyses": answers,
        "pending": look.pending,
        "can_undo": look.can_undo,
        "can_redo": look.can_redo,
        "scene": scene_of(design),
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

/// The turn of `contact`: its table and the error at every position.
pub fn film(tables: &[Table]) -> Json {
    let of = |name: &str| table(tables.iter().find(|table| table.name == name));
    let (contact, error) = (of("contact"), of("error"));
    json!({
        "crank_angle_deg": error["crank_angle_deg"],
        "te_loaded_arcmin": error["te_loaded_arcmin"],
        "contacts": {
            "crank_angle_deg": contact["crank_angle_deg"], "disc": contact["disc"], "pin": contact["pin"],
            "force_n": contact["force_n"], "pressure_mpa": contact["pressure_mpa"], "gap_um": contact["gap_um"],
        },
    })
}

/// Meshing angles at which depths of the flank are told.
const DEPTH_POINTS: usize = 181;

/// Depth lost by the first disc's flank, µm, from −180° to 180° of meshing angle.
fn depths(state: &WornState) -> Vec<f64> {
    let at = |i: usize| (-180.0 + 360.0 * i as f64 / (DEPTH_POINTS - 1) as f64) * DEG;
    let rounded = |depth: f64| (depth / UM * 1e4).round() / 1e4;
    (0..DEPTH_POINTS).map(|i| rounded(state.surfaces.flank().at(at(i)).depth)).collect()
}

/// A state of the life as soon as it is reached: what needs no further balance.
pub fn reached(state: &WornState) -> Json {
    json!({ "hours": state.hours, "max_depth_um": state.deepest() / UM, "depth_um": depths(state) })
}

/// Ages at which forces are told.
const FORCE_AGES: usize = 5;
/// Crank positions over one pin pitch.
const FORCE_POSITIONS: usize = 12;

/// The flank at every point of a life, and the forces over one pin pitch of crank angle at some.
///
/// # Errors
/// [`AnalysisError`] where the joints cannot be modelled, or the host stops it.
pub fn ages(outcome: &dyn Outcome, design: &AnyDesign, host: &dyn Host) -> Result<Json, AnalysisError> {
    if let (Some(life), AnyDesign::Rv(_)) = (outcome.as_any().downcast_ref::<Life>(), design) {
        let (machine, points) = (&life.machine, &life.prediction.points);
        let joints = life.fidelity.meshing(machine)?;
        let law = machine.line_contact();
        return ages_of(points, (&machine.designed_relief(), joints, law), machine.rated().torque, host);
    }
    if let (Some(life), AnyDesign::Eccentric(design)) = (outcome.as_any().downcast_ref::<StageLife>(), design)
    {
        let (stage, rated) = (design.stage(), design.rated().torque);
        let joints = StageMeshing::new(stage, rated, design.seen_from_ring())
            .map_err(AnalysisError::compute("build the drive from its design"))?;
        return ages_of(&life.prediction.points, (&stage.relief, joints, stage.contact), rated, host);
    }
    Ok(Json::Null)
}

/// Of any joints, with what the design takes off the flank and the law of contact.
fn ages_of<S: ShareLoad>(
    points: &[LifePoint],
    (designed, mut joints, law): (&Relief, S, LineContact),
    torque: f64,
    host: &dyn Host,
) -> Result<Json, AnalysisError> {
    let last = points.len() - 1;
    let mut shown: Vec<usize> = (0..FORCE_AGES).map(|i| i * last / (FORCE_AGES - 1)).collect();
    shown.dedup();
    let mut forces = Vec::new();
    for index in shown {
        if host.is_cancelled() {
            return Err(AnalysisError::Stopped);
        }
        points[index].state.put_on(designed, &mut joints);
        // A machine that wears away may not share its load any more at its last point.
        let Ok(cycle) = joints.pitch_cycle(torque, FORCE_POSITIONS) else { continue };
        let positions: Vec<Json> = cycle
            .positions
            .iter()
            .map(|position| {
                let contacts = position.discs.iter().enumerate().flat_map(|(disc, contacts)| {
                    contacts.iter().filter(|c| c.force > 0.0).map(move |c| {
                        let pressure = law.pressure(c.force, 1.0 / c.relative_curvature) / MPA;
                        json!([disc, c.pin, (c.force * 10.0).round() / 10.0, pressure.round()])
                    })
                });
                json!({
                    "crank_angle_deg": position.crank_angle.degrees(),
                    "te_arcmin": position.output_error.arcmin(),
                    "contacts": contacts.collect::<Vec<_>>(),
                })
            })
            .collect();
        forces.push(json!({ "hours": points[index].hours(), "positions": positions }));
    }
    let flanks: Vec<Json> = points.iter().map(|point| json!(depths(&point.state))).collect();
    Ok(json!({ "depth_um": flanks, "forces": forces }))
}
