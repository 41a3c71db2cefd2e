//! The page of the explorer: with the server, and offline as a single file.

use std::fmt::Write;

use arcmin::scene;
use serde_json::{Value as Json, json};

use super::answers;
use super::session::{Session, Snapshot};

const STYLE: &str = include_str!("assets/explore.css");
/// In this order: later files use definitions of earlier ones.
const SCRIPT: &[&str] = &[
    scene::MOTION,
    scene::SPACE,
    scene::VIEW,
    include_str!("assets/model.js"),
    include_str!("assets/strip.js"),
    include_str!("assets/keys.js"),
    include_str!("assets/hours.js"),
    include_str!("assets/app.js"),
];
const BODY: &str = include_str!("assets/body.html");

/// The page with its server, and its nonce.
///
/// # Errors
/// A system without random numbers.
pub fn live() -> Result<(String, String), getrandom::Error> {
    let mut bytes = [0_u8; 16];
    getrandom::fill(&mut bytes)?;
    let nonce: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    Ok((html("arcmin explore", &format!(" nonce=\"{nonce}\""), "", None), nonce))
}

/// The page with all results of the present design, for readers without the program.
pub fn offline(session: &Session, snapshot: &Snapshot, view: &Json) -> String {
    const POLICY: &str = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
        style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'\">\n";
    let keys = snapshot.state.design.keys();
    let film = snapshot
        .answers
        .get("film")
        .and_then(|film| serde_json::from_str(film).ok())
        .map_or(Json::Null, coarse);
    let data = format!(
        "{{\"state\":{},\"keys\":{},\"film\":{film},\"about\":{}}}",
        answers::state(session, snapshot),
        answers::keys(&keys),
        json!({ "version": env!("CARGO_PKG_VERSION"), "hash": snapshot.state.design.hash(), "view": view }),
    );
    html(snapshot.state.design.name(), "", POLICY, Some(&data))
}

/// The same with six digits, which is sufficient for all pictures and keeps the file small enough (3 MB) for a
/// mail.
fn coarse(json: Json) -> Json {
    match json {
        Json::Array(all) => all.into_iter().map(coarse).collect(),
        Json::Object(all) => all.into_iter().map(|(key, one)| (key, coarse(one))).collect(),
        Json::Number(number) if number.is_f64() => {
            let short = number.as_f64().and_then(|number| format!("{number:.5e}").parse::<f64>().ok());
            json!(short)
        }
        other => other,
    }
}

fn html(title: &str, nonce: &str, head: &str, data: Option<&str>) -> String {
    let mut out = String::with_capacity(1 << 20);
    let title = title.replace('&', "&amp;").replace('<', "&lt;");
    let _ = write!(
        out,
        "<!doctype html>\n<html lang=\"en\" data-theme=\"auto\">\n<head>\n<meta charset=\"utf-8\">\n{head}\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n\
         <title>{title}</title>\n<style{nonce}>\n{STYLE}</style>\n</head>\n<body>\n{BODY}"
    );
    if let Some(data) = data {
        // No text of a design can end the element.
        let _ = writeln!(
            out,
            "<script type=\"application/json\" id=\"data\">{}</script>",
            data.replace('<', "\\u003c")
        );
    }
    let _ = writeln!(out, "<script{nonce}>\n{}</script>", scene::three());
    let _ = writeln!(out, "<script{nonce}>\n(() => {{\n'use strict';");
    for script in SCRIPT {
        out.push_str(script);
    }
    out.push_str("})();\n</script>\n</body>\n</html>\n");
    out
}
