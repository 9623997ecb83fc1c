//! `ocmc page` as a server: what it answers, whom it refuses, and what it leaves behind.

use crate::program::ocmc;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const BIG: u64 = 1 << 30;

/// A server, and how it is reached.
struct Server {
    child: Child,
    /// `127.0.0.1:PORT`.
    host: String,
    /// `/TOKEN/`.
    base: String,
    /// The folder that it puts its files in.
    room: tempfile::TempDir,
}

impl Server {
    fn start(arguments: &[&str]) -> Self {
        let room = tempfile::tempdir().unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_ocmc"));
        command.args(["page", "--no-open", "--quiet"]).args(arguments).env("TMPDIR", room.path());
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
        let rest = line.trim().strip_prefix("http://").unwrap();
        let (host, path) = rest.split_once('/').unwrap();
        Self { child, host: host.to_owned(), base: format!("/{path}"), room }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        stream
    }

    /// Status and body of an answer to a request with a head and a body.
    fn raw(&self, head: &str, body: &[u8]) -> (u16, String) {
        let mut stream = self.connect();
        let length = body.len();
        stream.write_all(format!("{head}\r\nContent-Length: {length}\r\n\r\n").as_bytes()).unwrap();
        stream.write_all(body).unwrap();
        answer(&mut stream)
    }

    fn send(&self, method: &str, path: &str, body: &[u8]) -> (u16, String) {
        let Self { host, base, .. } = self;
        self.raw(&format!("{method} {base}{path} HTTP/1.1\r\nHost: {host}"), body)
    }

    fn ask(&self, question: &str) -> serde_json::Value {
        let (status, body) = self.send("POST", "ask", question.as_bytes());
        assert_eq!(status, 200, "{body}");
        serde_json::from_str(body.lines().last().unwrap()).unwrap()
    }

    fn files(&self) -> usize {
        std::fs::read_dir(self.room.path()).unwrap().count()
    }

    fn ends_within(&mut self, limit: Duration) -> bool {
        let begun = Instant::now();
        while begun.elapsed() < limit {
            if self.child.try_wait().unwrap().is_some() {
                return true;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        false
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn answer(stream: &mut TcpStream) -> (u16, String) {
    let mut bytes = Vec::new();
    // a connection that is cut has said what it had to say
    let _ = stream.read_to_end(&mut bytes);
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let status = text.split(' ').nth(1).and_then(|code| code.parse().ok()).unwrap_or(0);
    (status, text.split_once("\r\n\r\n").map_or("", |(_, body)| body).to_owned())
}

#[test]
fn the_page_answers_with_the_numbers_of_the_command() {
    let track = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs/src/tutorial/export/tracks/2024-01-04-023.gpx");
    let server = Server::start(&[track.to_str().unwrap()]);
    let read = server.ask(r#"{"ask": "files", "files": ["2024-01-04-023.gpx"]}"#);
    let file = &read["answer"]["files"][0];
    assert_eq!(file["kind"], "route", "{file}");
    assert!(file["profile"]["altitude_m"].as_array().unwrap().len() > 100);
    let keys = serde_json::json!({
        "study": { "name": "mine", "base": "regional" },
        "mission": { "routes": [
            { "file": file["file"], "weight": 1.0, "draw": file["route"]["draw"] },
        ] },
        "fleet": { "trips_per_truck": 2 },
    });
    let study = serde_json::json!({ "study": keys });
    let run = serde_json::json!({ "ask": "run", "study": study, "trucks": 8 });
    let answer = server.ask(&run.to_string());
    let text = server.ask(&serde_json::json!({ "ask": "study", "study": study }).to_string());
    // the study that is saved, beside its track, under the command
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(&track, folder.path().join("2024-01-04-023.gpx")).unwrap();
    std::fs::write(folder.path().join("mine.toml"), text["answer"]["toml"].as_str().unwrap())
        .unwrap();
    let typed = ["--study", "mine.toml", "--trucks", "8", "--json"];
    let run = ocmc(&typed).current_dir(folder.path()).output().unwrap();
    let typed: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    for key in ["statistics", "trucks", "parts", "judged", "distance_m"] {
        assert!(!typed[key].is_null(), "{key}");
        assert_eq!(answer["answer"][key], typed[key], "{key}");
    }
    let trip =
        server.ask(&serde_json::json!({ "ask": "trip", "study": study, "cycle": 3 }).to_string());
    let speeds = trip["answer"]["columns"]["speed_mps"].as_array().unwrap();
    assert!(speeds.len() > 500 && speeds.iter().all(serde_json::Value::is_number));
    let (status, page) = server.send("POST", "save/report.html", answer_of(&study).as_bytes());
    assert!(status == 200 && page.contains("<html"), "{status}");
}

fn answer_of(study: &serde_json::Value) -> String {
    serde_json::json!({ "ask": "run", "study": study, "trucks": 4 }).to_string()
}

#[test]
fn strangers_and_names_that_lead_elsewhere_are_refused() {
    let server = Server::start(&[]);
    let Server { host, base, .. } = &server;
    let own = format!("GET {base} HTTP/1.1");
    assert_eq!(server.raw(&format!("{own}\r\nHost: {host}"), b"").0, 200);
    for head in [
        own.clone(),
        format!("{own}\r\nHost: evil.example"),
        format!("{own}\r\nHost: {host}\r\nOrigin: http://evil.example"),
        format!("{own}\r\nHost: {host}\r\nSec-Fetch-Site: cross-site"),
        format!("GET / HTTP/1.1\r\nHost: {host}"),
        format!("GET /{}/ HTTP/1.1\r\nHost: {host}", "0".repeat(base.len() - 2)),
    ] {
        assert_eq!(server.raw(&head, b"").0, 403, "{head}");
    }
    for name in ["..%2f..%2fx", "../x", "%2fetc%2fx", "a%2fb", "", ".x", "a%00", "%zz", "C:%5cx"] {
        assert_eq!(server.send("PUT", &format!("files/{name}"), b"1").0, 400, "{name}");
    }
    assert_eq!(server.send("GET", "../../../etc/passwd", b"").0, 404);
    assert_eq!(server.send("PUT", "files/a.csv", b"x\n1\n").0, 204);
    for name in ["/etc/passwd", "../a.csv", "-", "a\nb<script>", "a.csv"] {
        let study = serde_json::json!({ "ask": "run", "study": name });
        let answer = server.ask(&study.to_string());
        assert_eq!(answer["message"], "refused", "{answer}");
        assert!(!answer["reason"].as_str().unwrap().contains("root:"));
        let route =
            serde_json::json!({ "mission": { "routes": [{ "file": name, "weight": 1.0 }] } });
        let study = serde_json::json!({ "ask": "run", "study": { "study": route } });
        assert_eq!(server.ask(&study.to_string())["message"], "refused", "{name}");
    }
    for question in ["", "[]", "{\"ask\": \"run\"}", "{\"ask\": \"rm\"}", "\u{0}"] {
        assert_eq!(server.ask(question)["message"], "refused", "{question:?}");
    }
    let mut stream = server.connect();
    let head =
        format!("PUT {base}files/big HTTP/1.1\r\nHost: {host}\r\nContent-Length: {BIG}\r\n\r\n");
    stream.write_all(head.as_bytes()).unwrap();
    assert_eq!(answer(&mut stream).0, 413);
    assert_eq!(server.send("DELETE", "files/a.csv", b"").0, 204);
    assert_eq!(server.send("DELETE", "files/a.csv", b"").0, 404);
}

#[test]
fn newer_questions_end_older_ones_and_a_closed_tab_leaves_nothing() {
    let mut server = Server::start(&[]);
    let Server { host, base, .. } = &server;
    assert_eq!(server.files(), 1);
    let long = r#"{"ask": "run", "study": "field-truck", "plan": {"cycles": 10000000}}"#;
    let head = format!("POST {base}ask HTTP/1.1\r\nHost: {host}\r\nContent-Length: {}", long.len());
    let mut all: Vec<TcpStream> = (0..30).map(|_| server.connect()).collect();
    for stream in &mut all {
        stream.write_all(format!("{head}\r\n\r\n{long}").as_bytes()).unwrap();
    }
    let short = r#"{"ask": "run", "study": "field-truck", "plan": {"cycles": 10}}"#;
    // those that were sent first may be read last
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(server.ask(short)["message"], "answer");
    for stream in &mut all {
        let (_, body) = answer(stream);
        assert!(body.lines().last().unwrap().contains("interrupted"), "{body}");
    }
    let mut tab = server.connect();
    tab.write_all(format!("GET {base}alive HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes()).unwrap();
    let mut first = [0; 12];
    tab.read_exact(&mut first).unwrap();
    drop(tab);
    assert!(server.ends_within(Duration::from_secs(20)));
    assert_eq!(server.files(), 0);
}
