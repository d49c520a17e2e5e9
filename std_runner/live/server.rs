//! The server of the page.

use super::shared::Shared;
use crate::exit::Failure;
use crate::report;
use core::net::{Ipv4Addr, SocketAddr};
use core::time::Duration;
use std::sync::Arc;
use std::thread::{Builder, JoinHandle, sleep};
use std::time::Instant;
use tiny_http::{Header, Method, Request, Response, StatusCode};

/// How long the last answer may take when the solve is over, and how often it is looked at.
const PATIENCE: Duration = Duration::from_secs(1);
const STEP: Duration = Duration::from_millis(5);
/// The port that browsers do not name.
const HTTP: &str = "80";

const PAGE: &str = include_str!("page.html");

/// What every answer says: the page is nobody else's, is not kept, and takes nothing from elsewhere.
const HEADERS: [(&str, &str); 5] = [
    ("Cache-Control", "no-store"),
    ("Referrer-Policy", "no-referrer"),
    ("X-Content-Type-Options", "nosniff"),
    ("X-Frame-Options", "DENY"),
    (
        "Content-Security-Policy",
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self'; connect-src 'self'",
    ),
];

/// A port that is listened at.
pub(super) struct Listener(tiny_http::Server, u16);

/// Listens at `port` of the loopback address, or at any free one where that is 0.
pub(super) fn listen(port: u16) -> Result<Listener, Failure> {
    let server = tiny_http::Server::http(SocketAddr::from((Ipv4Addr::LOCALHOST, port))).map_err(|error| {
        Failure::Input(format!(
            "--watch: cannot listen at port {port}: {error}; give another one, as in --watch=8080, or none, for any that is free"
        ))
    })?;
    let found = server
        .server_addr()
        .to_ip()
        .map_or(port, |address| address.port());
    Ok(Listener(server, found))
}

impl Listener {
    /// The port.
    pub fn port(&self) -> u16 {
        self.1
    }

    /// Answers from a thread of its own.
    pub fn serve(self, shared: Arc<Shared>) -> Result<Server, Failure> {
        let server = Arc::new(self.0);
        let asked = Arc::clone(&server);
        let answer = move || {
            for request in asked.incoming_requests() {
                // Whoever has gone needs no answer.
                let _ = respond(&shared, request);
            }
        };
        let thread = Builder::new().name("watch".into()).spawn(answer);
        let thread = thread.map_err(|error| {
            Failure::Input(format!(
                "--watch: cannot start a thread: {error}; leave the option out"
            ))
        })?;
        Ok(Server { server, thread })
    }
}

/// A server that answers.
pub(super) struct Server {
    server: Arc<tiny_http::Server>,
    thread: JoinHandle<()>,
}

impl Server {
    /// Answers nobody any more. Whoever asks and does not read the answer is not waited for long: the program ends all the same.
    pub fn close(self) {
        self.server.unblock();
        let begun = Instant::now();
        while !self.thread.is_finished() {
            if begun.elapsed() > PATIENCE {
                return;
            }
            sleep(STEP);
        }
        let _ = self.thread.join();
    }
}

fn respond(shared: &Shared, request: Request) -> std::io::Result<()> {
    let (kind, code, body) = answer(shared, &request);
    let mut response = Response::from_data(body).with_status_code(StatusCode(code));
    for (name, value) in HEADERS.into_iter().chain([("Content-Type", kind)]) {
        if let Ok(header) = Header::from_bytes(name, value) {
            response.add_header(header);
        }
    }
    request.respond(response)
}

/// The type of the answer, its code and its bytes.
fn answer(shared: &Shared, request: &Request) -> (&'static str, u16, Vec<u8>) {
    const TEXT: &str = "text/plain; charset=utf-8";
    const HTML: &str = "text/html; charset=utf-8";
    let nothing = || {
        (
            TEXT,
            404,
            b"There is nothing here; open the address that thurible printed.\n".to_vec(),
        )
    };
    // A name that somebody else's server gave to this address is not ours.
    let host = request.headers().iter().find(|header| header.field.equiv("Host"));
    let is_ours = |host: &str| {
        let (name, port) = host.split_once(':').unwrap_or((host, HTTP));
        ["127.0.0.1", "localhost"].contains(&name) && port == shared.port.to_string()
    };
    if !host.is_some_and(|host| is_ours(host.value.as_str())) {
        return nothing();
    }
    let rest = request.url().strip_prefix('/');
    let Some(rest) = rest.and_then(|rest| rest.strip_prefix(shared.token.as_str())) else {
        return nothing();
    };
    let path = rest.split('?').next().unwrap_or_default();
    match (request.method(), path) {
        (Method::Get, "/") => (HTML, 200, page(shared).into_bytes()),
        (Method::Get, "/state") => (
            "application/json",
            200,
            shared.state().told().to_string().into_bytes(),
        ),
        (Method::Get, "/charts") => {
            let history = shared.state().history.clone();
            (HTML, 200, report::charts(&history).into_bytes())
        }
        (Method::Get, path) => {
            let index = path.strip_prefix("/frame/").and_then(|index| index.parse().ok());
            match index.and_then(|index: usize| shared.state().frame(index).map(<[u8]>::to_vec)) {
                Some(png) => ("image/png", 200, png),
                None => nothing(),
            }
        }
        (Method::Post, "/stop") => {
            shared.state().stopped = true;
            shared.interrupt.ask();
            (TEXT, 200, b"stopping\n".to_vec())
        }
        _ => nothing(),
    }
}

fn page(shared: &Shared) -> String {
    let title = report::escape(&shared.state().title);
    report::shell(&title, &PAGE.replace("TITLE", &title))
}
