//! The little of HTTP/1.1 that a page on the loopback needs: one request a connection.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// Largest head of a request, in bytes.
const MOST_HEAD: usize = 16 << 10;
const MOST_HEADERS: usize = 64;
/// Largest body of a request, in bytes: a log of a day is some 10 MB.
pub(crate) const MOST_BODY: u64 = 64 << 20;
/// For how long a peer may say nothing.
const PATIENCE: Duration = Duration::from_secs(10);

/// Why a request is not answered: status, and reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Refusal(pub(crate) u16, pub(crate) &'static str);

/// A request, its body unread.
#[derive(Debug)]
pub(crate) struct Request {
    pub(crate) method: String,
    /// Path without what stands behind `?`.
    pub(crate) path: String,
    pub(crate) headers: Vec<(String, String)>,
    /// Length of the body.
    pub(crate) body_bytes: u64,
}

impl Request {
    /// The value of a header, by its name in lower case.
    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
    }
}

/// A connection: what came behind the head, and the stream.
pub(crate) struct Connection {
    stream: TcpStream,
    begun: Vec<u8>,
}

impl Connection {
    /// # Errors
    /// Where the peer is gone.
    pub(crate) fn new(stream: TcpStream) -> io::Result<Self> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        stream.set_nodelay(true)?;
        Ok(Self { stream, begun: Vec::new() })
    }

    /// Reads the head of the request; none where the peer is gone.
    ///
    /// # Errors
    /// The refusal of one that is none, or too large.
    pub(crate) fn read_head(&mut self) -> Result<Option<Request>, Refusal> {
        let mut part = [0; 4096];
        loop {
            match self.stream.read(&mut part) {
                Ok(0) | Err(_) => return Ok(None),
                Ok(n) => self.begun.extend_from_slice(&part[..n]),
            }
            let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
            let mut head = httparse::Request::new(&mut headers);
            match head.parse(&self.begun) {
                Ok(httparse::Status::Complete(length)) => {
                    let request = request(&head)?;
                    self.begun.drain(..length);
                    return Ok(Some(request));
                }
                Ok(httparse::Status::Partial) if self.begun.len() <= MOST_HEAD => {}
                Ok(httparse::Status::Partial) => return Err(Refusal(431, "too long a head")),
                Err(_) => return Err(Refusal(400, "no request of HTTP/1.1")),
            }
        }
    }

    /// Reads the body of a request.
    ///
    /// # Errors
    /// The refusal of one that is too large, or ends before its end.
    pub(crate) fn read_body(&mut self, request: &Request) -> Result<Vec<u8>, Refusal> {
        let Request { body_bytes, .. } = *request;
        if body_bytes > MOST_BODY {
            return Err(Refusal(413, "more than 64 MB"));
        }
        let mut body = std::mem::take(&mut self.begun);
        body.truncate(body_bytes as usize);
        let rest = body_bytes - body.len() as u64;
        let read = (&self.stream).take(rest).read_to_end(&mut body);
        match read {
            Ok(read) if read as u64 == rest => Ok(body),
            _ => Err(Refusal(400, "the body ends before its end")),
        }
    }

    /// Begins an answer; what follows ends with the connection.
    ///
    /// # Errors
    /// Where the peer is gone.
    pub(crate) fn begin(&mut self, status: u16, kind: &str) -> io::Result<()> {
        write!(
            self.stream,
            "HTTP/1.1 {status} {}\r\nContent-Type: {kind}\r\nConnection: close\r\n\
             Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
             Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
             Content-Security-Policy: {POLICY}\r\n\r\n",
            words(status)
        )
    }

    /// Writes a part of an answer.
    ///
    /// # Errors
    /// Where the peer is gone.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.stream.write_all(bytes)
    }

    /// A whole answer; a peer that is gone does not mind.
    pub(crate) fn answer(&mut self, status: u16, kind: &str, body: &[u8]) {
        let _ = self.begin(status, kind).and_then(|()| self.write(body));
    }

    /// Whether the peer has gone away.
    pub(crate) fn is_closed(&self) -> bool {
        let mut one = [0];
        let _ = self.stream.set_nonblocking(true);
        let peeked = self.stream.peek(&mut one);
        let _ = self.stream.set_nonblocking(false);
        match peeked {
            Ok(0) => true,
            Ok(_) => false,
            Err(error) => error.kind() != io::ErrorKind::WouldBlock,
        }
    }
}

/// Policy on what a page may load: its own files, and pictures that it makes itself.
const POLICY: &str = "default-src 'self'; img-src 'self' data: blob:; style-src 'self'; object-src \
                      'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

fn request(head: &httparse::Request) -> Result<Request, Refusal> {
    let value = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let headers = head.headers.iter().map(|h| (h.name.to_ascii_lowercase(), value(h.value)));
    let target = head.path.unwrap_or_default();
    let mut request = Request {
        method: head.method.unwrap_or_default().to_owned(),
        path: target.split(['?', '#']).next().unwrap_or_default().to_owned(),
        headers: headers.collect(),
        body_bytes: 0,
    };
    if request.header("transfer-encoding").is_some() {
        return Err(Refusal(411, "a body needs its length"));
    }
    if let Some(length) = request.header("content-length") {
        request.body_bytes = length.parse().map_err(|_| Refusal(400, "no length of a body"))?;
    }
    Ok(request)
}

fn words(status: u16) -> &'static str {
    match status {
        200 => "OK",
        204 => "No Content",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        411 => "Length Required",
        413 => "Content Too Large",
        422 => "Unprocessable Content",
        431 => "Request Header Fields Too Large",
        503 => "Service Unavailable",
        _ => "Internal Server Error",
    }
}
