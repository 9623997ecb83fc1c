//! The server: connections, and what each of them asks for.

use crate::assets;
use crate::guard::Guard;
use crate::http::{Connection, Refusal, Request};
use crate::session::Session;
use ocmc_api::ask::Message;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Letters of what a tab calls itself that count.
const MOST_TAB: usize = 40;
/// Connections at a time.
const MOST_CONNECTIONS: usize = 64;
/// Time between two messages of how far the work is.
const TICK: Duration = Duration::from_millis(200);
/// How long connections that are under way are waited for at the end.
const FAREWELL: Duration = Duration::from_secs(2);

/// Time between two looks at whether a tab is there.
const LOOK: Duration = Duration::from_millis(100);
/// How long a tab may be away that loads the page again.
const RELOAD: Duration = Duration::from_secs(3);

const TEXT: &str = "text/plain; charset=utf-8";
const LINES: &str = "application/x-ndjson";

/// Why there is no page.
#[derive(Debug)]
pub enum PageError {
    /// The loopback or a folder for files cannot be had.
    System(io::Error),
    /// A file that was named cannot be read, or has no plain name.
    File(PathBuf, String),
}

impl From<io::Error> for PageError {
    fn from(error: io::Error) -> Self {
        Self::System(error)
    }
}

/// A page that is served until it is dropped.
#[derive(Debug)]
pub struct Page {
    shared: Arc<Shared>,
    at: SocketAddr,
    accepting: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    guard: Guard,
    session: Session,
    open: AtomicUsize,
    tabs: Tabs,
}

/// Tabs that show the page: each holds a connection open for as long as it is there.
#[derive(Debug, Default)]
struct Tabs {
    open: AtomicUsize,
    /// When the last one was closed.
    left: Mutex<Option<Instant>>,
}

impl Page {
    /// Serves the page on the loopback, with some files as if they had been dropped on it.
    ///
    /// Changes the folder that the program runs in to one of the page: studies name files there.
    ///
    /// # Errors
    /// [`PageError`] where the system does not let it, or a file cannot be read.
    pub fn serve(port: u16, files: &[PathBuf]) -> Result<Self, PageError> {
        let session = Session::new()?;
        for path in files {
            let fault = |reason: String| PageError::File(path.clone(), reason);
            let name = path.file_name().and_then(|name| name.to_str());
            let name = name.ok_or_else(|| fault("its name is no text".to_owned()))?;
            let bytes = std::fs::read(path).map_err(|error| fault(error.to_string()))?;
            session.put(name, &bytes).map_err(|Refusal(_, reason)| fault(reason.to_owned()))?;
        }
        std::env::set_current_dir(session.folder())?;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let at = listener.local_addr()?;
        let guard = Guard::new(at).map_err(io::Error::other)?;
        let shared =
            Arc::new(Shared { guard, session, open: AtomicUsize::new(0), tabs: Tabs::default() });
        let own = Arc::clone(&shared);
        let accepting = thread::spawn(move || accept(&listener, &own));
        Ok(Self { shared, at, accepting: Some(accepting) })
    }

    /// Its address, which has the token.
    pub fn address(&self) -> String {
        self.shared.guard.address()
    }

    /// Whether the last tab with it was closed, and not only loaded again.
    pub fn is_left(&self) -> bool {
        let Tabs { open, left } = &self.shared.tabs;
        let left = *left.lock().expect("nobody panics with it");
        open.load(Ordering::Relaxed) == 0 && left.is_some_and(|at| at.elapsed() > RELOAD)
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.shared.session.end();
        // wakes the thread that waits for connections
        drop(TcpStream::connect(self.at));
        let _ = self.accepting.take().map(JoinHandle::join);
        let begun = Instant::now();
        while self.shared.open.load(Ordering::Relaxed) > 0 && begun.elapsed() < FAREWELL {
            thread::sleep(Duration::from_millis(10));
        }
        // the folder goes with the session: nobody may stand in it
        let _ = std::env::set_current_dir(std::env::temp_dir());
    }
}

fn accept(listener: &TcpListener, shared: &Arc<Shared>) {
    for stream in listener.incoming() {
        if shared.session.is_ended() {
            return;
        }
        let Some(mut connection) = stream.and_then(Connection::new).ok() else { continue };
        if shared.open.load(Ordering::Relaxed) >= MOST_CONNECTIONS {
            connection.answer(503, TEXT, b"too many requests at once");
            continue;
        }
        let place = Place::of(shared);
        // where no thread can be started, the place is given back with what it would have run
        let _ = thread::Builder::new().spawn(move || serve(&place.0, &mut connection));
    }
}

/// Place of a connection among those that are open, given back however its thread ends.
struct Place(Arc<Shared>);

impl Place {
    fn of(shared: &Arc<Shared>) -> Self {
        shared.open.fetch_add(1, Ordering::Relaxed);
        Self(Arc::clone(shared))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.open.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Answers the one request of a connection.
fn serve(shared: &Shared, connection: &mut Connection) {
    let answered = match connection.read_head() {
        Ok(None) => return,
        Ok(Some(request)) => answer(shared, connection, &request),
        Err(refusal) => Err(refusal),
    };
    if let Err(Refusal(status, reason)) = answered {
        connection.answer(status, TEXT, reason.as_bytes());
    }
}

fn answer(
    Shared { guard, session, tabs, .. }: &Shared,
    connection: &mut Connection,
    request: &Request,
) -> Result<(), Refusal> {
    let path = decoded(guard.admit(request)?)?;
    let tab = request.header("x-ocmc-tab").unwrap_or_default();
    let tab = tab.get(..MOST_TAB).unwrap_or(tab);
    match (&*request.method, path.split_once('/').unwrap_or((&path, ""))) {
        ("GET", ("alive", "")) => {
            tabs.open.fetch_add(1, Ordering::Relaxed);
            let begun = connection.begin(200, TEXT).and_then(|()| connection.write(b"alive\n"));
            while begun.is_ok() && !session.is_ended() && !connection.is_closed() {
                thread::sleep(LOOK);
            }
            *tabs.left.lock().expect("nobody panics with it") = Some(Instant::now());
            tabs.open.fetch_sub(1, Ordering::Relaxed);
        }
        ("GET", _) => {
            let asset = assets::find(&path).ok_or(Refusal(404, "no such page"))?;
            connection.answer(200, asset.kind, &asset.served());
        }
        ("PUT", ("files", name)) => {
            let body = connection.read_body(request)?;
            session.put(name, &body)?;
            connection.answer(204, TEXT, b"");
        }
        ("DELETE", ("files", name)) => {
            session.remove(name)?;
            connection.answer(204, TEXT, b"");
        }
        ("POST", ("ask", "")) => {
            let question = connection.read_body(request)?;
            let _ = connection.begin(200, LINES);
            converse(session, connection, tab, &question);
        }
        ("POST", ("save", name @ ("report.html" | "fleet.xlsx" | "study.toml"))) => {
            let question = connection.read_body(request)?;
            let saved = session.save(name, tab, &question, &mut || connection.is_closed());
            match saved {
                Ok(bytes) => connection.answer(200, "application/octet-stream", &bytes),
                Err(reason) => connection.answer(422, TEXT, reason.as_bytes()),
            }
        }
        ("PUT" | "DELETE" | "POST", _) => return Err(Refusal(404, "no such question")),
        _ => return Err(Refusal(405, "allowed are GET, POST, PUT and DELETE")),
    }
    Ok(())
}

/// Answers a question in lines of JSON.
fn converse(session: &Session, connection: &mut Connection, tab: &str, question: &[u8]) {
    let connection = std::cell::RefCell::new(connection);
    let mut told = Instant::now();
    let mut say = |message: &Message| {
        if matches!(message, Message::Progress(_)) {
            if told.elapsed() < TICK {
                return true;
            }
            told = Instant::now();
        }
        let text = serde_json::to_string(message).expect("numbers, and keys that are words");
        connection.borrow_mut().write(format!("{text}\n").as_bytes()).is_ok()
    };
    session.ask(tab, question, &mut say, &mut || connection.borrow().is_closed());
}

/// A path without its escapes.
fn decoded(path: &str) -> Result<String, Refusal> {
    let mut bytes = Vec::with_capacity(path.len());
    let mut rest = path.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let digits = [rest.next(), rest.next()].map(|digit| digit.and_then(hexadecimal));
        let [Some(high), Some(low)] = digits else {
            return Err(Refusal(400, "an escape that is none"));
        };
        bytes.push(16 * high + low);
    }
    String::from_utf8(bytes).map_err(|_| Refusal(400, "a path that is no text"))
}

fn hexadecimal(digit: u8) -> Option<u8> {
    char::from(digit).to_digit(16).map(|digit| digit as u8)
}
