//! The explorer's server: access control, and agreement of its numbers with those of the commands.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};

use crate::common::*;

struct Server {
    child: Child,
    port: u16,
    token: String,
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = (self.child.kill(), self.child.wait());
    }
}

impl Server {
    fn start(directory: &Path, design: &str) -> Server {
        let mut child = Command::new(binary())
            .current_dir(directory)
            .args(["explore", design, "--no-browser"])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let rest = line.trim().strip_prefix("http://127.0.0.1:").unwrap_or_else(|| panic!("{line}"));
        let (port, token) = rest.split_once("/?token=").unwrap();
        Server { child, port: port.parse().unwrap(), token: token.to_owned() }
    }

    /// Status and body of the response to these bytes.
    fn raw(&self, bytes: &[u8]) -> (u16, String) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        // The server may refuse the request before all bytes are sent.
        let _ = stream.write_all(bytes);
        let mut text = Vec::new();
        let _ = stream.read_to_end(&mut text);
        let text = String::from_utf8_lossy(&text).into_owned();
        let status = text.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
        (status, text.split_once("\r\n\r\n").map_or(String::new(), |(_, body)| body.to_owned()))
    }

    fn ask(&self, method: &str, path: &str, body: &str) -> (u16, Value) {
        let head = format!(
            "{method} {path}?token={} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nContent-Length: {}\r\n\r\n{body}",
            self.token,
            self.port,
            body.len()
        );
        let (status, text) = self.raw(head.as_bytes());
        (status, serde_json::from_str(&text).unwrap_or(Value::Null))
    }

    fn set(&self, key: &str, value: Value) -> (u16, Value) {
        self.ask("POST", "/api/set", &json!({ "key": key, "value": value }).to_string())
    }

    fn lives(&self) -> bool {
        self.ask("GET", "/api/state", "").0 == 200
    }
}

fn with_template(name: &str) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    good(directory.path(), &["new", name, "d.toml"]);
    directory
}

/// Reports are those of the tried design, for clients with the token, and leave no file.
#[test]
fn reports_are_served_and_written_nowhere() {
    let directory = with_template("two-ring-225");
    let server = Server::start(directory.path(), "d.toml");
    let get = |path: &str, token: &str| {
        let own = format!("Host: 127.0.0.1:{}\r\n", server.port);
        server.raw(format!("GET {path}?token={token} HTTP/1.1\r\n{own}\r\n").as_bytes())
    };
    let (status, state) = server.set("load.rated_torque_n_m", json!(57.25));
    assert_eq!(status, 200);
    let path = format!("/api/report/contact/{}", state["state"]);
    let (status, html) = get(&path, &server.token);
    assert!(
        status == 200 && html.starts_with("<!doctype html>") && html.contains("At 57.25 N·m"),
        "{status}"
    );
    assert!(get("/api/report/contact/0", &server.token).1.contains("At 60 N·m"));
    assert_eq!(get(&path, "0").0, 403);
    // Requests that cannot be computed are refused with the message of the command.
    let (status, state) = server.set("wear", Value::Null);
    assert_eq!(status, 200);
    let (status, refused) = get(&format!("/api/report/life/{}", state["state"]), &server.token);
    assert!(status == 422 && refused.contains("no wear coefficient"), "{status} {refused}");
    for missing in ["contact/9999", "contact/x", "film/0", "contact/0/0", "robot/0"] {
        assert_eq!(get(&format!("/api/report/{missing}"), &server.token).0, 404, "{missing}");
    }
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
}

#[test]
fn strangers_are_refused_and_the_server_lives() {
    let directory = with_template("nema17-19");
    let d = directory.path();
    let secret = d.join("secret.toml");
    std::fs::write(&secret, "secret = 1\n").unwrap();
    let server = Server::start(d, "d.toml");
    let (port, token) = (server.port, server.token.clone());
    let own = format!("Host: 127.0.0.1:{port}\r\n");
    let get = |target: &str, headers: &str| {
        server.raw(format!("GET {target} HTTP/1.1\r\n{headers}\r\n").as_bytes()).0
    };
    assert_eq!(get(&format!("/?token={token}"), &own), 200);
    assert_eq!(get("/", &own), 403);
    assert_eq!(get("/api/state", &own), 403);
    assert_eq!(get(&format!("/api/state?token={}", "0".repeat(32)), &own), 403);
    assert_eq!(get(&format!("/api/state?token={token}"), "Host: evil.example\r\n"), 403);
    assert_eq!(
        get(&format!("/api/state?token={token}"), &format!("{own}Origin: http://evil.example\r\n")),
        403
    );
    for path in ["/secret.toml", "/../secret.toml", "/d.toml", "/%2e%2e/secret.toml", "//etc/passwd"] {
        assert_eq!(get(&format!("{path}?token={token}"), &own), 404, "{path}");
    }
    assert_eq!(server.raw(format!("DELETE /?token={token} HTTP/1.1\r\n{own}\r\n").as_bytes()).0, 405);
    // Malformed and huge.
    for bytes in [&b"\r\n\r\n"[..], b"\0\0\0\0\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n"] {
        assert_eq!(server.raw(bytes).0, 400);
    }
    let long = format!("GET /?token={token} HTTP/1.1\r\n{own}X: {}\r\n\r\n", "x".repeat(1 << 20));
    assert!(matches!(server.raw(long.as_bytes()).0, 431 | 0));
    let huge = format!("POST /api/set?token={token} HTTP/1.1\r\n{own}Content-Length: 1000000000\r\n\r\n{{}}");
    assert_eq!(server.raw(huge.as_bytes()).0, 413);
    for body in ["", "{", "[]", "null", "{\"key\":1,\"value\":1}", "{\"key\":\"a\",\"value\":1,\"more\":1}"] {
        assert_eq!(server.ask("POST", "/api/set", body).0, 400, "{body}");
    }
    assert_eq!(server.set("output_pins.hole_clearance_um", json!([1])).0, 422);
    let deep = "[".repeat(30_000);
    assert_eq!(server.ask("POST", "/api/set", &deep).0, 400);
    for name in ["../x.toml", "/tmp/x.toml", "a/b.toml", ".x.toml", "x.sh", "secret.toml"] {
        let (status, answer) = server.ask("POST", "/api/save", &json!({ "name": name }).to_string());
        assert!(matches!(status, 409 | 422), "{name}: {status} {answer}");
    }
    assert_eq!(std::fs::read_to_string(&secret).unwrap(), "secret = 1\n");
    assert!(server.lives());
    assert_eq!(names(d), ["d.toml", "secret.toml"]);
}

/// More connections than a page needs, without requests: further ones are refused, and after their end the
/// server responds.
#[test]
#[ignore = "long"]
fn a_thousand_connections_do_no_harm() {
    let directory = with_template("nema17-19");
    let server = Server::start(directory.path(), "d.toml");
    let mut silent: Vec<TcpStream> = Vec::new();
    for _ in 0..1000 {
        silent.extend(TcpStream::connect(("127.0.0.1", server.port)).ok());
    }
    drop(silent);
    let answered = (0..100).any(|_| {
        std::thread::sleep(Duration::from_millis(100));
        server.lives()
    });
    assert!(answered);
}

/// Random bodies and keys, also of the right form: refused or accepted, and the server responds afterwards.
#[test]
fn fuzzed_messages_do_no_harm() {
    let directory = with_template("nema17-19");
    let server = Server::start(directory.path(), "d.toml");
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut next = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as usize % below
    };
    let paths = ["/api/set", "/api/save", "/api/goto", "/api/undo", "/api/redo", "/api/history", "/nothing"];
    let parts = [
        "{",
        "}",
        "\"key\"",
        ":",
        ",",
        "\"disc.width_mm\"",
        "\"value\"",
        "1e999",
        "-3",
        "\"\\u0000\"",
        "null",
        "[",
        "]",
        "\"duty[99]\"",
        "\"unknowns\"",
        "\u{feff}",
    ];
    for round in 0..400 {
        let mut body: String = (0..next(12)).map(|_| parts[next(parts.len())]).collect();
        if round % 4 == 0 {
            let key: String = (0..next(20)).map(|_| char::from(33 + next(90) as u8)).collect();
            body = json!({ "key": key, "value": next(1000) }).to_string();
        }
        let (status, answer) = server.ask("POST", paths[next(paths.len())], &body);
        assert!((200..500).contains(&status), "{body}: {status} {answer}");
    }
    assert!(server.lives());
    assert_eq!(names(directory.path()), ["d.toml"]);
}

/// Every result of `check`, `profile` and `contact` after setting a key equals that of the command for the same
/// design.
fn gives_the_numbers_of_the_commands(template: &str, changes: &[(&str, Value)]) {
    let directory = with_template(template);
    let d = directory.path();
    let server = Server::start(d, "d.toml");
    for (key, value) in changes {
        let (status, answer) = server.set(key, value.clone());
        assert_eq!(status, 200, "{key}: {answer}");
        let toml = answer["design"]["toml"].as_str().unwrap();
        write(d, "changed.toml", toml);
        for command in ["check", "profile", "contact"] {
            let output = arcmin(d, &[command, "changed.toml", "--out", "o", "--force", "--quiet"]);
            assert!(matches!(output.status.code(), Some(0 | 1)), "{command} {key}");
            let told = summary(d, "o");
            let own = answer["analyses"][command]["summary"].as_object().unwrap();
            assert!(own.len() > 3, "{command}");
            for (name, value) in own {
                assert_eq!(*value, told[name], "{template}, {key}: {name} of {command}");
                if name != "findings" && command == "contact" {
                    assert_eq!(answer["results"][name], told[name]);
                }
            }
            if command == "check" {
                assert_eq!(answer["findings"], told["findings"]);
            }
        }
    }
    let (status, error) = server.set(changes[0].0, json!(-1e9));
    assert_eq!(status, 422);
    // In the words of the command line.
    write(d, "wrong.toml", &read(d, "changed.toml"));
    let toml = server.ask("GET", "/api/state", "").1["design"]["toml"].as_str().unwrap().to_owned();
    assert_eq!(toml, read(d, "changed.toml"), "a refused value leaves the design as it is");
    assert!(error["error"].as_str().is_some_and(|text| text.len() > 10), "{error}");
}

#[test]
fn numbers_of_an_rv_reducer_are_those_of_the_commands() {
    gives_the_numbers_of_the_commands(
        "rv-40e",
        &[
            ("load.rated_torque_n_m", json!(300)),
            ("disc.width_mm", json!(9.1)),
            ("disc.modification.equidistant_offset_um", json!(7.5)),
            ("crankshafts.eccentricity_mm", json!(1.25)),
            ("bearings.turning_arm.clearance_um", json!(3)),
            ("fixed_member", json!("carrier")),
        ],
    );
}

#[test]
fn numbers_of_the_paper_machine_are_those_of_the_commands() {
    gives_the_numbers_of_the_commands(
        "tao2024",
        &[
            ("ring.pin_radius_mm", json!(3.05)),
            ("load.input_speed_rpm", json!(900)),
            ("contact.law", json!("line-hertz")),
        ],
    );
}

#[test]
fn numbers_of_a_single_stage_are_those_of_the_commands() {
    gives_the_numbers_of_the_commands(
        "nema17-19",
        &[
            ("load.rated_torque_n_m", json!(2)),
            ("output_pins.count", json!(5)),
            ("output_pins.hole_clearance_um", json!(14)),
            ("bearings.eccentric.clearance_um", json!(4.5)),
        ],
    );
}

/// A saved design keeps its comments and is not overwritten without request; a saved page is self-contained.
#[test]
fn designs_and_pages_are_saved_beside_the_design() {
    let directory = with_template("nema17-19");
    let d = directory.path();
    let server = Server::start(d, "d.toml");
    let (_, answer) = server.set("disc.width_mm", json!(6));
    let save = |body: Value| server.ask("POST", "/api/save", &body.to_string()).0;
    assert_eq!(save(json!({ "name": "new.toml" })), 200);
    assert_eq!(read(d, "new.toml"), answer["design"]["toml"].as_str().unwrap());
    assert!(read(d, "new.toml").contains("# dowel pins of 3 mm"));
    assert_eq!(save(json!({ "name": "new.toml" })), 409);
    assert_eq!(save(json!({ "name": "new.toml", "overwrite": true })), 200);
    assert_eq!(save(json!({ "name": "d.html", "page": true })), 200);
    let page = read(d, "d.html");
    assert!(page.len() < 3_000_000 && page.contains("id=\"data\"") && !page.contains(&server.token));
    for outside in ["src=\"http", "href=\"http", "@import", "url(http"] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert_eq!(names(d), ["d.html", "d.toml", "new.toml"]);
}
