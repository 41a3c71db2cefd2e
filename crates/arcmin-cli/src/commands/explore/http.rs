//! HTTP for one user on one machine: requests are read within limits of size and time, and foreign requests are
//! refused before their content is evaluated.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Size limits of a request in bytes: head and body.
const LARGEST_HEAD: usize = 16 << 10;
const LARGEST_BODY: usize = 64 << 10;
const MOST_HEADERS: usize = 64;
/// Number of simultaneous connections; a page needs three.
const MOST_CONNECTIONS: usize = 48;
/// Time limit for receiving a request and for sending a response.
const PATIENCE: Duration = Duration::from_secs(5);

/// An accepted request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    pub method: String,
    /// Path without the query.
    pub path: String,
    pub body: Vec<u8>,
}

/// Reason why a request is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refusal {
    pub status: u16,
    pub message: &'static str,
}

const fn refusal(status: u16, message: &'static str) -> Refusal {
    Refusal { status, message }
}

/// Access control: the request must contain the token, come from no other page, and use a local name of this
/// machine.
pub struct Guard {
    port: u16,
    token: String,
}

impl Guard {
    /// A guard with a new token of 128 bits.
    ///
    /// # Errors
    /// A system without random numbers.
    pub fn new(port: u16) -> Result<Guard, getrandom::Error> {
        let mut bytes = [0_u8; 16];
        getrandom::fill(&mut bytes)?;
        Ok(Guard { port, token: bytes.iter().map(|byte| format!("{byte:02x}")).collect() })
    }

    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/?token={}", self.port, self.token)
    }

    #[cfg(test)]
    pub fn token(&self) -> &str {
        &self.token
    }

    /// Whether these bytes are the token, in a time that does not depend on the position of a difference.
    fn is_token(&self, given: &[u8]) -> bool {
        let own = self.token.as_bytes();
        let differing = own.iter().zip(given).fold(0, |all, (a, b)| std::hint::black_box(all | (a ^ b)));
        given.len() == own.len() && differing == 0
    }

    /// Names of this server in a Host header, and as an origin.
    fn is_own_host(&self, host: &str) -> bool {
        ["127.0.0.1", "localhost"].iter().any(|name| host == format!("{name}:{}", self.port))
    }

    /// The request of a head, without its body, and the length of the body.
    ///
    /// # Errors
    /// The reason for the refusal.
    pub fn admit(&self, head: &[u8]) -> Result<(Request, usize), Refusal> {
        let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut parsed = httparse::Request::new(&mut headers);
        match parsed.parse(head) {
            Ok(httparse::Status::Complete(_)) => {}
            _ => return Err(refusal(400, "the request is malformed")),
        }
        let (Some(method), Some(target)) = (parsed.method, parsed.path) else {
            return Err(refusal(400, "the request is malformed"));
        };
        let mut all = parsed.headers.iter();
        let of = |name: &str| {
            let mut found = parsed.headers.iter().filter(|header| header.name.eq_ignore_ascii_case(name));
            match (found.next(), found.next()) {
                (first, None) => Ok(first.map(|header| header.value)),
                _ => Err(refusal(400, "a header is given twice")),
            }
        };
        let host = of("host")?.and_then(|host| std::str::from_utf8(host).ok());
        if !host.is_some_and(|host| self.is_own_host(host)) {
            return Err(refusal(403, "the server answers to 127.0.0.1 and localhost only"));
        }
        if let Some(origin) = of("origin")? {
            let origin = std::str::from_utf8(origin).ok().and_then(|origin| origin.strip_prefix("http://"));
            if !origin.is_some_and(|host| self.is_own_host(host)) {
                return Err(refusal(403, "requests of other pages are refused"));
            }
        }
        // Browsers send the origin of the page; only the address bar and the page itself are allowed.
        if let Some(site) = of("sec-fetch-site")?
            && !matches!(site, b"same-origin" | b"none")
        {
            return Err(refusal(403, "requests of other pages are refused"));
        }
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let token = query.split('&').find_map(|pair| pair.strip_prefix("token="));
        if !token.is_some_and(|token| self.is_token(token.as_bytes())) {
            return Err(refusal(
                403,
                "the token is missing or wrong: open the address that `arcmin explore` printed",
            ));
        }
        if all.any(|header| header.name.eq_ignore_ascii_case("transfer-encoding")) {
            return Err(refusal(411, "Content-Length is missing"));
        }
        let length = match of("content-length")? {
            None => 0,
            Some(digits) => {
                let text = std::str::from_utf8(digits).unwrap_or_default();
                if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) {
                    return Err(refusal(400, "Content-Length is not a number"));
                }
                match text.parse::<usize>() {
                    Ok(length) if length <= LARGEST_BODY => length,
                    _ => return Err(refusal(413, "the body is too long")),
                }
            }
        };
        Ok((Request { method: method.to_owned(), path: path.to_owned(), body: Vec::new() }, length))
    }

    /// Reads a request.
    ///
    /// # Errors
    /// `None` where the connection is closed.
    fn read(&self, stream: &mut TcpStream) -> Result<Request, Option<Refusal>> {
        let until = Instant::now() + PATIENCE;
        let mut read = |buffer: &mut [u8]| -> Result<usize, Option<Refusal>> {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
                return Err(Some(refusal(408, "the request took too long")));
            }
            match stream.read(buffer) {
                Ok(0) => Err(None),
                Ok(count) => Ok(count),
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                    Err(Some(refusal(408, "the request took too long")))
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => Ok(0),
                Err(_) => Err(None),
            }
        };
        let (mut bytes, mut buffer) = (Vec::new(), [0_u8; 4096]);
        let end = loop {
            let count = read(&mut buffer)?;
            let from = bytes.len().saturating_sub(3);
            bytes.extend_from_slice(&buffer[..count]);
            if let Some(at) = bytes[from..].windows(4).position(|four| four == b"\r\n\r\n") {
                break from + at + 4;
            }
            if bytes.len() > LARGEST_HEAD {
                return Err(Some(refusal(431, "the head of the request is too long")));
            }
        };
        let (mut request, length) = self.admit(&bytes[..end]).map_err(Some)?;
        request.body = bytes.split_off(end);
        while request.body.len() < length {
            let count = read(&mut buffer)?;
            request.body.extend_from_slice(&buffer[..count]);
        }
        request.body.truncate(length);
        Ok(request)
    }
}

/// Content policy of all pages: scripts and styles have the nonce of their page, connections go to this server
/// only.
fn policy(nonce: &str) -> String {
    format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; img-src data: blob:; \
         connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
}

/// Content policy of a report, whose scripts and styles have no nonce: in a sandbox it has another origin than
/// this server and cannot connect to anything.
const REPORT_POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; \
     base-uri 'none'; form-action 'none'; frame-ancestors 'none'; sandbox allow-scripts allow-downloads allow-modals";

/// Target of a response.
pub struct Reply<'a> {
    stream: &'a mut TcpStream,
}

/// Whether the client is still connected.
pub struct Waiting<'a>(&'a TcpStream);

impl Waiting<'_> {
    pub fn is_over(&self) -> bool {
        match self.0.peek(&mut [0]) {
            Ok(count) => count == 0,
            Err(error) => error.kind() != ErrorKind::WouldBlock,
        }
    }
}

impl Reply<'_> {
    fn head(&mut self, status: u16, kind: &str, policy: &str, length: Option<usize>) -> std::io::Result<()> {
        let length = length.map_or(String::new(), |length| format!("Content-Length: {length}\r\n"));
        let head = format!(
            "HTTP/1.1 {status} {}\r\nContent-Type: {kind}\r\n{length}Connection: close\r\nCache-Control: no-store\r\n\
             Content-Security-Policy: {policy}\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
             X-Frame-Options: DENY\r\nCross-Origin-Resource-Policy: same-origin\r\n\
             Cross-Origin-Opener-Policy: same-origin\r\n\r\n",
            reason(status),
        );
        self.stream.write_all(head.as_bytes())
    }

    fn whole(&mut self, status: u16, kind: &str, policy: &str, bytes: &[u8]) {
        // An error is ignored if the client has disconnected.
        let _ =
            self.head(status, kind, policy, Some(bytes.len())).and_then(|()| self.stream.write_all(bytes));
    }

    pub fn json(mut self, status: u16, json: &str) {
        self.whole(status, "application/json", &policy(""), json.as_bytes());
    }

    /// An error as text, with the key concerned and a remedy.
    pub fn error(self, status: u16, message: &str, hint: Option<&str>) {
        let json = serde_json::json!({ "error": message, "hint": hint });
        self.json(status, &json.to_string());
    }

    pub fn page(mut self, html: &str, nonce: &str) {
        self.whole(200, "text/html; charset=utf-8", &policy(nonce), html.as_bytes());
    }

    /// A report, as soon as it is complete; `make` can check whether the client is still connected.
    pub fn report<E>(&mut self, make: impl FnOnce(&Waiting<'_>) -> Result<String, E>) -> Result<(), E> {
        let unblocked = self.stream.set_nonblocking(true);
        let html = make(&Waiting(self.stream));
        let _ = unblocked.and_then(|()| self.stream.set_nonblocking(false));
        self.whole(200, "text/html; charset=utf-8", REPORT_POLICY, html?.as_bytes());
        Ok(())
    }

    /// Server-sent events, until the client disconnects: `next` returns the next message, or `None` after some
    /// time.
    pub fn events(mut self, mut next: impl FnMut() -> Vec<String>) {
        if self.head(200, "text/event-stream", &policy(""), None).is_err() {
            return;
        }
        loop {
            let messages = next();
            let mut text: String = messages.iter().map(|message| format!("data: {message}\n\n")).collect();
            if text.is_empty() {
                // A comment line: writing it fails after the client has disconnected.
                text.push_str(":\n\n");
            }
            if self.stream.write_all(text.as_bytes()).and_then(|()| self.stream.flush()).is_err() {
                return;
            }
        }
    }
}

fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        409 => "Conflict",
        411 => "Length Required",
        413 => "Content Too Large",
        422 => "Unprocessable Content",
        431 => "Request Header Fields Too Large",
        503 => "Service Unavailable",
        _ => "Internal Server Error",
    }
}

/// Counts open connections.
struct Counted(Arc<AtomicUsize>);

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Serves requests until the process ends.
pub fn serve(
    listener: &TcpListener,
    guard: Arc<Guard>,
    answer: impl Fn(Request, Reply<'_>) + Send + Sync + 'static,
) {
    let (answer, count) = (Arc::new(answer), Arc::new(AtomicUsize::new(0)));
    for stream in listener.incoming() {
        let Ok(mut stream) = stream else {
            // For instance too many open files: other connections end in the meantime.
            std::thread::sleep(Duration::from_millis(10));
            continue;
        };
        let _ = (stream.set_write_timeout(Some(PATIENCE)), stream.set_nodelay(true));
        let others = count.fetch_add(1, Ordering::SeqCst);
        let counted = Counted(Arc::clone(&count));
        if others >= MOST_CONNECTIONS {
            let _ = stream.set_write_timeout(Some(Duration::from_millis(10)));
            Reply { stream: &mut stream }.error(503, "too many connections", None);
            continue;
        }
        let (guard, answer) = (Arc::clone(&guard), Arc::clone(&answer));
        let serve_one = move || {
            let _counted = counted;
            match guard.read(&mut stream) {
                Ok(request) => answer(request, Reply { stream: &mut stream }),
                Err(Some(Refusal { status, message })) => {
                    Reply { stream: &mut stream }.error(status, message, None)
                }
                Err(None) => {}
            }
            finish(stream);
        };
        // If no thread can be started, the connection is dropped.
        let _ = std::thread::Builder::new().name("explore-request".to_owned()).spawn(serve_one);
    }
}

/// Closes a connection after the response has arrived: unread data of the client would reset it.
fn finish(mut stream: TcpStream) {
    if stream.shutdown(std::net::Shutdown::Write).is_err() {
        return;
    }
    let _ = stream.set_read_timeout(Some(Duration::from_millis(200)));
    let mut buffer = [0_u8; 4096];
    let mut left = 4 * LARGEST_BODY;
    while let Ok(count) = stream.read(&mut buffer) {
        if count == 0 || left < count {
            return;
        }
        left -= count;
    }
}
