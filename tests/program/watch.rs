//! The page of a solve that runs: what it answers, to whom, and that its button stops the solve.

use crate::support::endless::Endless;
use crate::support::{fresh_folder, json, run, thurible};
use core::time::Duration;
use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Instant;

/// A page, by its port and token.
struct Page {
    port: String,
    token: String,
}

impl Page {
    /// The one at this address.
    fn at(address: &str) -> Self {
        let rest = address.strip_prefix("http://127.0.0.1:").unwrap();
        let (port, token) = rest.trim_end_matches('/').split_once('/').unwrap();
        assert!(token.len() == 32 && token.bytes().all(|byte| byte.is_ascii_hexdigit()));
        Self {
            port: port.into(),
            token: token.into(),
        }
    }

    /// Asks for a path, calling it by `host`; head and body of the answer.
    fn ask_as(&self, host: &str, method: &str, path: &str) -> (String, Vec<u8>) {
        let mut stream = TcpStream::connect(format!("127.0.0.1:{}", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: {host}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
        )
        .unwrap();
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
        (head, bytes.split_off(end + 4))
    }

    fn ask(&self, method: &str, path: &str) -> (String, Vec<u8>) {
        let host = format!("127.0.0.1:{}", self.port);
        self.ask_as(&host, method, &format!("/{}{path}", self.token))
    }

    fn state(&self) -> Value {
        let (head, body) = self.ask("GET", "/state");
        assert!(
            head.starts_with("HTTP/1.1 200") && head.contains("application/json"),
            "{head}"
        );
        serde_json::from_slice(&body).unwrap()
    }

    /// What it shows when frames were drawn.
    fn drawn(&self) -> Value {
        let since = Instant::now();
        loop {
            let state = self.state();
            // From half a second on it tells how long it takes.
            if state["drawings"].as_u64().unwrap() > 0 && !state["seconds_left"].is_null() {
                return state;
            }
            assert!(since.elapsed() < Duration::from_secs(300), "{state}");
        }
    }

    /// Asks for all frames, from the first step on.
    fn check_frames(&self, state: &Value) -> Vec<Vec<u8>> {
        let steps = state["frames"].as_array().unwrap();
        assert!(steps.len() > 2 && steps[0] == 0, "{state}");
        let frame = |index| {
            let (head, png) = self.ask("GET", &format!("/frame/{index}?1"));
            assert!(
                head.contains("image/png") && png.starts_with(b"\x89PNG"),
                "{head}"
            );
            png
        };
        (0..steps.len()).map(frame).collect()
    }
}

/// A solve by `method` that goes on until it is stopped, and its page.
fn watched(name: &str, method: &str) -> (Endless, Page, std::path::PathBuf) {
    let folder = fresh_folder(name).join("out");
    let mut address = String::new();
    let mut command = thurible();
    command.args([
        "solve",
        "examples/letter_f.toml",
        "--watch",
        "--json",
        "--threads",
        "1",
        "--method",
        method,
    ]);
    let tolerance = format!("method.{method}.tolerance=1e-300");
    command.args(["--set", "method.iterations=1000000", "--set", &tolerance]);
    // Small, so that a busy machine comes to the finest grid too.
    command.args(["--set", "grid.cells=[32, 32]"]);
    command.args(["-o", folder.to_str().unwrap()]);
    let solve = Endless::seen(&mut command, |line| {
        let event: Value = serde_json::from_str(line).unwrap_or_default();
        if event["event"] == "watch" {
            address = event["address"].as_str().unwrap().into();
        }
        event["event"] == "iteration"
    });
    (solve, Page::at(&address), folder)
}

/// Frames, curves and numbers come; nobody else gets anything; the button ends the solve as Ctrl-C does.
#[test]
fn it_shows_the_solve_and_stops_it() {
    let (solve, page, folder) = watched("watched", "direct");
    let (head, body) = page.ask("GET", "/");
    let html = String::from_utf8(body).unwrap();
    assert!(
        head.contains("default-src 'none'") && head.contains("no-store"),
        "{head}"
    );
    assert!(
        html.contains("examples/letter_f.toml") && html.contains("<h2>Convergence</h2>"),
        "{html}"
    );
    let state = page.drawn();
    assert!(
        state["seconds_left"].as_f64().unwrap() > 0.0 && state["over"].is_null(),
        "{state}"
    );
    assert!(state["objective"]["total"].as_f64().unwrap() > 0.0, "{state}");
    page.check_frames(&state);
    let (_, charts) = page.ask("GET", "/charts");
    assert!(String::from_utf8(charts).unwrap().contains("<polyline"));
    let own = format!("127.0.0.1:{}", page.port);
    let right = format!("/{}/state", page.token);
    let wrong = right.replace(&page.token, &"0".repeat(32));
    for (host, method, path) in [
        (own.as_str(), "GET", "/"),
        (own.as_str(), "GET", wrong.as_str()),
        (own.as_str(), "POST", "/stop"),
        ("evil.example", "GET", right.as_str()),
    ] {
        let (head, body) = page.ask_as(host, method, path);
        assert!(
            head.starts_with("HTTP/1.1 404") && body.len() < 100,
            "{host} {path}: {head}"
        );
    }
    for (method, path) in [
        ("GET", "/stop"),
        ("GET", "/frame/99"),
        ("GET", "/frame/-1"),
        ("PUT", "/state"),
    ] {
        assert!(
            page.ask(method, path).0.starts_with("HTTP/1.1 404"),
            "{method} {path}"
        );
    }
    assert!(page.ask("POST", "/stop").0.starts_with("HTTP/1.1 200"));
    let ended = solve.wait();
    assert_eq!(ended.code, 130, "{}", ended.err);
    let report: Value = json(&folder.join("report.json"));
    assert_eq!(report["status"], "cancelled");
    let row = report["history"].as_array().unwrap().last().unwrap();
    assert!(row["seconds_left"].as_f64().unwrap() > 0.0);
}

/// A search that holds no steps is run once more for its frames, which are those of the flow as it is.
#[test]
fn it_shows_a_search_by_stable_fluids() {
    let (solve, page, folder) = watched("watched_fluids", "stable_fluids");
    let frames = page.check_frames(&page.drawn());
    assert!(frames.first() != frames.last(), "the smoke does not move");
    assert!(page.ask("POST", "/stop").0.starts_with("HTTP/1.1 200"));
    let ended = solve.wait();
    assert_eq!(ended.code, 130, "{}", ended.err);
    assert!(folder.join("result.npz").is_file());
}

/// A port that is taken, and an option that would have no page to tell of.
#[test]
fn it_says_why_there_is_no_page() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let folder = fresh_folder("watched_nowhere").join("out");
    let watch = format!("--watch={port}");
    let solve = [
        "solve",
        "examples/letter_f.toml",
        "-o",
        folder.to_str().unwrap(),
        &watch,
    ];
    let ended = run(&solve);
    assert!(
        ended.code == 2 && ended.err.contains(&format!("port {port}")) && ended.err.contains("--watch=8080"),
        "{}: {}",
        ended.code,
        ended.err
    );
    assert!(!folder.join("report.json").exists());
    let ended = run(&[&solve[..], &["--quiet"]].concat());
    assert!(ended.code == 2 && ended.err.contains("--quiet"), "{}", ended.err);
}
