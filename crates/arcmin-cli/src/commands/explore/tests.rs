use std::time::Duration;

use arcmin::design::Value;
use rand_like::Sequence;

use super::http::Guard;
use super::routes::plain_name;
use super::session::{Session, Tryout};
use super::work::HEADLINE;

/// Reproducible pseudo-random numbers.
mod rand_like {
    pub struct Sequence(pub u64);

    impl Sequence {
        pub fn next(&mut self, below: usize) -> usize {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as usize % below
        }
    }
}

fn guard() -> Guard {
    Guard::new(4711).unwrap()
}

fn head(guard: &Guard, lines: &[&str]) -> Vec<u8> {
    let mut text = format!("GET /api/state?token={} HTTP/1.1\r\n", guard.token());
    for line in lines {
        text.push_str(&format!("{line}\r\n"));
    }
    (text + "\r\n").into_bytes()
}

fn status(guard: &Guard, lines: &[&str]) -> u16 {
    guard.admit(&head(guard, lines)).map_or_else(|refusal| refusal.status, |_| 200)
}

#[test]
fn only_requests_of_the_page_are_accepted() {
    let guard = guard();
    assert_eq!(guard.token().len(), 32);
    assert_eq!(status(&guard, &["Host: 127.0.0.1:4711"]), 200);
    assert_eq!(status(&guard, &["host: localhost:4711", "Origin: http://localhost:4711"]), 200);
    for strange in [
        &["Host: 127.0.0.1"][..],
        &["Host: evil.example:4711"],
        &["Host: 127.0.0.1:4711.evil.example"],
        &[],
        &["Host: 127.0.0.1:4711", "Origin: http://evil.example"],
        &["Host: 127.0.0.1:4711", "Origin: https://127.0.0.1:4711"],
        &["Host: 127.0.0.1:4711", "Origin: null"],
        &["Host: 127.0.0.1:4711", "Sec-Fetch-Site: cross-site"],
    ] {
        assert_eq!(status(&guard, strange), 403, "{strange:?}");
    }
    assert_eq!(status(&guard, &["Host: 127.0.0.1:4711", "Host: 127.0.0.1:4711"]), 400);
    let own = "Host: 127.0.0.1:4711";
    for (length, status_of_it) in
        [("x", 400), ("-1", 400), ("+5", 400), ("", 400), ("65537", 413), ("99999999999999999999999", 413)]
    {
        assert_eq!(status(&guard, &[own, &format!("Content-Length: {length}")]), status_of_it, "{length}");
    }
    assert_eq!(status(&guard, &[own, "Transfer-Encoding: chunked"]), 411);
}

#[test]
fn every_digit_of_the_token_counts() {
    let guard = guard();
    let own = String::from_utf8(head(&guard, &["Host: 127.0.0.1:4711"])).unwrap();
    let token = guard.token().to_owned();
    let with = |other: &str| guard.admit(own.replace(&token, other).as_bytes()).is_ok();
    assert!(with(&token));
    for place in 0..token.len() {
        let mut other = token.clone().into_bytes();
        other[place] ^= 1;
        assert!(!with(std::str::from_utf8(&other).unwrap()), "digit {place}");
    }
    assert!(!with("") && !with(&token[1..]) && !with(&format!("{token}0")) && !with(&format!("%{token}")));
    assert!(Guard::new(4711).unwrap().token() != token);
}

/// Ten thousand requests with changed, removed and duplicated bytes: a response or a refusal, never a panic.
#[test]
fn fuzzed_heads_cause_no_panic() {
    let guard = guard();
    let good = head(&guard, &["Host: 127.0.0.1:4711", "Origin: http://127.0.0.1:4711", "Content-Length: 12"]);
    let mut sequence = Sequence(0x9e37_79b9_7f4a_7c15);
    let mut admitted = 0;
    for _ in 0..10_000 {
        let mut bytes = good.clone();
        for _ in 0..=sequence.next(4) {
            let at = sequence.next(bytes.len().max(1));
            if bytes.is_empty() {
                break;
            }
            match sequence.next(4) {
                0 => bytes[at] = sequence.next(256) as u8,
                1 => drop(bytes.remove(at)),
                2 => bytes.insert(at, sequence.next(256) as u8),
                _ => bytes.truncate(at.max(1)),
            }
        }
        if let Ok((request, length)) = guard.admit(&bytes) {
            admitted += 1;
            assert!(length <= 64 << 10 && request.body.is_empty());
        }
    }
    assert!(admitted < 9_000, "{admitted}");
}

#[test]
fn names_lead_to_no_other_directory() {
    for good in ["a.toml", "RV 40E (thin).toml", "ünder-1.5.toml"] {
        assert_eq!(plain_name(good, ".toml"), Ok(good));
    }
    let long = "a".repeat(200) + ".toml";
    for bad in [
        "",
        ".toml",
        "a.txt",
        "../a.toml",
        "a/b.toml",
        "/etc/a.toml",
        "..\\a.toml",
        "C:\\a.toml",
        "C:a.toml",
        ".hidden.toml",
        "-a.toml",
        "a\0.toml",
        "a\n.toml",
        "con.toml",
        "LPT1.x.toml",
        "a|b.toml",
        "~/a.toml",
        &long,
    ] {
        assert!(plain_name(bad, ".toml").is_err(), "{bad:?}");
    }
}

fn session(text: &str) -> std::sync::Arc<Session> {
    let session = Session::open("nowhere/d.toml".as_ref(), text.to_owned(), "d.toml".to_owned()).unwrap();
    let session = std::sync::Arc::new(session);
    session.start();
    session
}

fn design_text(name: &str) -> String {
    let path = format!("{}/../arcmin-mechanics/designs/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

/// Undo and redo give the same bytes; a refused value changes nothing; a drag is one step.
#[test]
fn undo_gives_the_same_bytes() {
    for (name, key, values) in [
        ("nema17-19", "output_pins.hole_clearance_um", [11.0, 12.0, 13.0]),
        ("printed-15", "disc.modification.equidistant_offset_um", [140.0, 145.0, 155.0]),
        ("steel-59", "ring.seat_compliance_um_per_kn", [9.0, 10.0, 7.0]),
        ("tao2024", "load.rated_torque_n_m", [400.0, 401.0, 402.5]),
        ("two-ring-225", "second_disc.width_mm", [11.0, 12.0, 13.0]),
        ("two-stage-500", "first_stage.disc.width_mm", [6.0, 7.0, 6.5]),
    ] {
        let session = session(&design_text(name));
        let text = || session.snapshot(&[], Duration::ZERO).state.design.text().to_owned();
        let first = text();
        session.set(key, Value::Number(values[0]), false).unwrap();
        let second = text();
        assert!(first != second && second.contains(&format!("= {}", values[0])));
        for value in values {
            session.set(key, Value::Number(value), true).unwrap();
        }
        session.set(key, Value::Number(values[2]), false).unwrap();
        let third = text();
        let error = session.set(key, Value::Number(-1e300), false).unwrap_err();
        assert!(!error.kind.to_string().is_empty() && text() == third);
        session.set("no.such_key", Value::Number(1.0), false).unwrap_err();
        session.set(key, Value::Text("much".to_owned()), false).unwrap_err();
        assert!(text() == third);
        let changes = || session.snapshot(&[], Duration::ZERO).changes;
        let before = changes();
        assert!(session.undo() && text() == second, "{name}: a drag is one step");
        assert_eq!(changes(), before + 1, "a step back is a change as well");
        assert!(session.undo() && text() == first && !session.undo());
        assert!(session.redo() && session.redo() && text() == third && !session.redo());
        let comments = |text: &str| text.matches('#').count();
        assert_eq!(comments(&first), comments(&third));
    }
}

/// Values of invalid designs, of designs with error findings and of valid designs are distinguished.
#[test]
fn values_of_a_key_are_tried_without_changing_the_design() {
    let session = session(&design_text("nema17-19"));
    let before = session.snapshot(&[], Duration::ZERO).state.design.text().to_owned();
    let found = session.tried_with("eccentric.eccentricity_mm", &[-1.0, 0.5, 0.84]);
    assert!(
        matches!(&found[0], Tryout::Refused(message) if message.contains("eccentricity_mm")),
        "{found:?}"
    );
    assert_eq!(found[1], Tryout::Errors(Vec::new()));
    assert!(!matches!(&found[2], Tryout::Errors(codes) if codes.is_empty()), "{found:?}");
    assert_eq!(session.snapshot(&[], Duration::ZERO).state.design.text(), before);
}

/// Every ring of every family has its table of pins in `contact`, under the name used by the film.
#[test]
fn the_film_has_a_table_for_every_ring() {
    for name in ["rv-40e-81", "nema17-19", "printed-15", "steel-59", "two-ring-225", "two-stage-500"] {
        let session = session(&design_text(name));
        let answers = session.snapshot(&["film"], Duration::from_secs(60)).answers;
        let film: serde_json::Value = serde_json::from_str(&answers["film"]).unwrap();
        let rings = film["film"]["contacts"].as_array().unwrap();
        assert_eq!(rings.len(), session.snapshot(&[], Duration::ZERO).state.design.scene().rings.len());
        for ring in rings {
            let count = |column: &str| ring[column].as_array().map_or(0, Vec::len);
            assert!(count("force_n") > 100 && count("pin") == count("pressure_mpa"), "{name}");
        }
    }
}

/// Results of a design are the same, byte by byte, after a change and its reversal.
#[test]
#[ignore = "long"]
fn answers_are_kept_with_their_design() {
    let session = session(&design_text("nema17-19"));
    let answers = || session.snapshot(&HEADLINE, Duration::from_secs(60)).answers;
    let first = answers();
    assert!(HEADLINE.iter().all(|name| first[name].contains("\"status\":\"done\"")), "{first:?}");
    session.set("load.rated_torque_n_m", Value::Number(2.0), false).unwrap();
    let second = answers();
    assert!(first["contact"] != second["contact"]);
    assert!(session.undo());
    assert_eq!(answers()["contact"], first["contact"]);
    // The life follows later, with forces and flanks at some ages; without a wear coefficient there is none,
    // with the message of the command.
    let life = || session.snapshot(&["life"], Duration::from_secs(60)).answers["life"].clone();
    assert!(life().contains("\"status\":\"done\"") && life().contains("depth_um"), "{}", life());
    session.set("wear", Value::LeftOut, false).unwrap();
    assert!(life().contains("no wear coefficient"), "{}", life());
}
