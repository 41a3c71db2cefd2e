//! Responses of the server.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use arcmin::analyses::by_name;
use arcmin::design::DesignError;
use serde::Deserialize;
use serde_json::{Value as Json, json};

use super::http::{Reply, Request};
use super::session::{Delivered, Session, State, Tryout};
use super::work::{HEADLINE, Lane};
use super::{answers, page, work};
use crate::run::write_file;

/// Time limit for the response to a drag, with the results available by then; the others are streamed.
const DRAG_PATIENCE: Duration = Duration::from_millis(30);
/// Time limit of all other requests for the headline.
const PATIENCE: Duration = Duration::from_secs(20);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Set {
    key: String,
    value: Json,
    /// Whether more values of the same key follow immediately.
    #[serde(default)]
    drag: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Save {
    name: String,
    #[serde(default)]
    overwrite: bool,
    /// The page without its server, in place of the design.
    #[serde(default)]
    page: bool,
    /// State of the page: names and values of its controls.
    #[serde(default)]
    view: Json,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GoTo {
    state: u64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Try {
    key: String,
    values: Vec<f64>,
}

/// Largest number of values tried in one request.
const MOST_VALUES: usize = 32;

/// Answers a request.
pub fn answer(session: &Arc<Session>, request: Request, mut reply: Reply<'_>) {
    let now = |reply: Reply<'_>, patience| {
        reply.json(200, &answers::state(session, &session.snapshot(&HEADLINE, patience)));
    };
    match (request.method.as_str(), request.path.as_str()) {
        ("GET", "/") => match page::live() {
            Ok((html, nonce)) => reply.page(&html, &nonce),
            Err(cause) => reply.error(500, &format!("the system gives no random numbers: {cause}"), None),
        },
        ("GET", "/api/state") => now(reply, PATIENCE),
        ("GET", "/api/keys") => {
            let snapshot = session.snapshot(&[], Duration::ZERO);
            reply.json(200, &answers::keys(&snapshot.state.design.keys()).to_string());
        }
        ("GET", "/api/history") => {
            let one = |tried: super::session::Tried| {
                let figure = |name: &str, key: &str| -> Json {
                    let answer: Option<Json> =
                        tried.answers.get(name).and_then(|answer| serde_json::from_str(answer).ok());
                    answer.map_or(Json::Null, |answer| answer["summary"][key].clone())
                };
                json!({
                    "state": tried.number, "change": tried.change, "present": tried.is_present,
                    "errors": figure("check", "errors"), "warnings": figure("check", "warnings"),
                    "max_force_n": figure("contact", "max_force_n"), "hours_to_limit": figure("life", "hours_to_limit"),
                    "verdict": figure("life", "verdict")["ok"],
                })
            };
            let all: Vec<Json> = session.tried().into_iter().map(one).collect();
            reply.json(200, &json!(all).to_string());
        }
        ("GET", "/api/stream") => {
            let mut delivered = Delivered::default();
            reply.events(|| session.news(&mut delivered));
        }
        ("POST", "/api/set") => match read::<Set>(&request) {
            Err(message) => reply.error(400, &message, None),
            Ok(set) => {
                let Some(value) = answers::value_of(&set.value) else {
                    return reply.error(422, "a value is a number, a text, true, false or null", None);
                };
                match session.set(&set.key, value, set.drag) {
                    Ok(()) => now(reply, if set.drag { DRAG_PATIENCE } else { PATIENCE }),
                    Err(error) => refuse(reply, &error),
                }
            }
        },
        ("POST", "/api/undo") if session.undo() => now(reply, PATIENCE),
        ("POST", "/api/redo") if session.redo() => now(reply, PATIENCE),
        ("POST", "/api/undo" | "/api/redo") => reply.error(409, "there is no such step", None),
        ("POST", "/api/goto") => match read::<GoTo>(&request) {
            Err(message) => reply.error(400, &message, None),
            Ok(to) if session.go_to(to.state) => now(reply, PATIENCE),
            Ok(_) => reply.error(409, "there is no such design", None),
        },
        ("POST", "/api/try") => match read::<Try>(&request) {
            Err(message) => reply.error(400, &message, None),
            Ok(tried) if tried.values.len() > MOST_VALUES => {
                reply.error(422, &format!("no more than {MOST_VALUES} values are tried at once"), None);
            }
            Ok(tried) => {
                let one = |tryout| match tryout {
                    Tryout::Refused(message) => json!({ "refused": message }),
                    Tryout::Errors(codes) => json!({ "errors": codes }),
                };
                let all: Vec<Json> =
                    session.tried_with(&tried.key, &tried.values).into_iter().map(one).collect();
                reply.json(200, &json!(all).to_string());
            }
        },
        ("POST", "/api/save") => match read::<Save>(&request) {
            Err(message) => reply.error(400, &message, None),
            Ok(save) => match saved(session, &save) {
                Ok(path) => reply.json(200, &json!({ "saved": path.display().to_string() }).to_string()),
                Err((status, message)) => reply.error(status, &message, None),
            },
        },
        ("GET", path) if path.starts_with("/api/report/") => match reported(session, path) {
            None => reply.error(404, "there is no such report", None),
            Some((name, state)) => {
                if let Err(error) = reply.report(|waiting| work::report(name, session, &state, waiting)) {
                    reply.error(422, &error.to_string(), error.help().as_deref());
                }
            }
        },
        ("GET" | "POST", _) => reply.error(404, "there is nothing of this name", None),
        _ => reply.error(405, "requests are GET or POST", None),
    }
}

/// Analysis and design of `/api/report/NAME/STATE`.
fn reported(session: &Session, path: &str) -> Option<(&'static str, Arc<State>)> {
    let (name, number) = path.strip_prefix("/api/report/")?.split_once('/')?;
    let mut names = Lane::ALL.iter().flat_map(|lane| lane.answers()).copied();
    let name = names.find(|known| *known == name && by_name(known).is_some())?;
    Some((name, session.state(number.parse().ok()?)?))
}

fn read<'a, T: Deserialize<'a>>(request: &'a Request) -> Result<T, String> {
    serde_json::from_slice(&request.body).map_err(|error| format!("the body cannot be read: {error}"))
}

/// The error of the design in the words of the command line.
fn refuse(reply: Reply<'_>, error: &DesignError) {
    let body = json!({
        "error": error.kind.to_string(),
        "hint": error.hint(),
        "key": error.key(),
        "line": error.line(),
    });
    reply.json(422, &body.to_string());
}

/// Writes the present design or the page beside the original design file.
fn saved(session: &Arc<Session>, save: &Save) -> Result<PathBuf, (u16, String)> {
    let ending = if save.page { ".html" } else { ".toml" };
    let path = session.directory().join(plain_name(&save.name, ending).map_err(|message| (422, message))?);
    let bytes = if save.page {
        let all: Vec<&'static str> = Lane::ALL.iter().flat_map(|lane| lane.answers()).copied().collect();
        page::offline(session, &session.snapshot(&all, Duration::ZERO), &save.view).into_bytes()
    } else {
        session.snapshot(&[], Duration::ZERO).state.design.text().to_owned().into_bytes()
    };
    let exists = || (409, format!("{} exists already", path.display()));
    if save.overwrite {
        if path.symlink_metadata().is_ok_and(|about| !about.is_file()) {
            return Err((409, format!("{} is no file", path.display())));
        }
        write_file(&path, &bytes).map_err(|failure| (500, failure.to_string()))?;
        return Ok(path);
    }
    // The name is reserved first: a file that another program creates meanwhile is not overwritten.
    match std::fs::OpenOptions::new().write(true).create_new(true).open(&path) {
        Ok(_) => {}
        Err(cause) if cause.kind() == std::io::ErrorKind::AlreadyExists => return Err(exists()),
        Err(cause) => return Err((500, format!("cannot write {}: {cause}", path.display()))),
    }
    write_file(&path, &bytes).map_err(|failure| {
        // Removes the reserved, empty file.
        let _ = std::fs::remove_file(&path);
        (500, failure.to_string())
    })?;
    Ok(path)
}

/// A name without path separators.
pub(super) fn plain_name<'a>(name: &'a str, ending: &str) -> Result<&'a str, String> {
    let says = |what: &str| Err(format!("a name to save under {what}"));
    if !name.ends_with(ending) || name.len() == ending.len() {
        return says(&format!("ends with {ending}"));
    }
    if name.len() > 100 {
        return says("has 100 bytes at most");
    }
    // Device names of Windows have no extension.
    let stem = name.split('.').next().unwrap_or_default().to_ascii_lowercase();
    let device = ["con", "prn", "aux", "nul"].contains(&stem.as_str())
        || (stem.len() == 4 && (stem.starts_with("com") || stem.starts_with("lpt")));
    let fits = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ' | '+' | '(' | ')');
    let is_one_part = Path::new(name).components().count() == 1 && Path::new(name).file_name().is_some();
    if device || name.starts_with(['.', '-', ' ']) || !name.chars().all(fits) || !is_one_part {
        return says("consists of letters, digits, spaces and - _ . + ( )");
    }
    Ok(name)
}
