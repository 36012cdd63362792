//! HTTP/1.1, as much as a page and its questions need: requests are bounded in bytes and in time, answers are whole.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Most bytes of a request's lines, and of its body.
const MOST_HEAD: usize = 16 << 10;
const MOST_BODY: usize = 64 << 10;
/// Most header lines.
const MOST_LINES: usize = 64;
/// Longest time from a request's first byte to its last.
const PATIENCE: Duration = Duration::from_secs(10);
/// Longest time that a connection waits for its next request.
const IDLE: Duration = Duration::from_secs(60);
/// Between two looks at the clock.
const SLICE: Duration = Duration::from_millis(200);
/// Longest time that a reader may keep one piece of an answer waiting.
const SLOWEST: Duration = Duration::from_secs(20);

/// A request.
#[derive(Debug)]
pub(crate) struct Request {
    pub method: String,
    /// Path and query, as they were sent.
    pub target: String,
    /// Names in lower case.
    pub headers: Vec<(String, String)>,
    pub body: Vec<u8>,
}

impl Request {
    /// A header's value; the first, if it is there several times.
    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        let found = self.headers.iter().find(|(own, _)| own == name);
        found.map(|(_, value)| value.as_str())
    }

    /// How often a header is there.
    pub(crate) fn count(&self, name: &str) -> usize {
        self.headers.iter().filter(|(own, _)| own == name).count()
    }
}

/// Why there is no request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NoRequest {
    /// The connection has ended, or waits for too long.
    Ended,
    /// It is refused with a status.
    Refused(u16, &'static str),
}

const SLOW: NoRequest = NoRequest::Refused(408, "the request takes too long");
const MALFORMED: NoRequest = NoRequest::Refused(400, "this is no HTTP request");

/// Reads the next request of a connection.
pub(crate) fn read(stream: &mut TcpStream) -> Result<Request, NoRequest> {
    let mut bytes = Vec::new();
    let start = Instant::now();
    let mut first: Option<Instant> = None;
    let mut piece = [0; 4096];
    loop {
        if let Some((request, head, length)) = parsed(&bytes)? {
            if bytes.len() >= head + length {
                return Ok(Request {
                    body: bytes[head..head + length].to_vec(),
                    ..request
                });
            }
        } else if bytes.len() >= MOST_HEAD {
            return Err(NoRequest::Refused(431, "the request's lines are too long"));
        }
        match first {
            Some(first) if first.elapsed() > PATIENCE => return Err(SLOW),
            None if start.elapsed() > IDLE => return Err(NoRequest::Ended),
            _ => {}
        }
        match stream.read(&mut piece) {
            Ok(0) => return Err(NoRequest::Ended),
            Ok(count) => {
                first.get_or_insert_with(Instant::now);
                bytes.extend_from_slice(&piece[..count]);
            }
            Err(error) if is_wait(&error) => {}
            Err(_) => return Err(NoRequest::Ended),
        }
    }
}

/// Whether an operation has only taken longer than a slice.
pub(crate) fn is_wait(error: &std::io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

/// Prepares a connection.
pub(crate) fn prepare(stream: &TcpStream) -> std::io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(SLICE))?;
    stream.set_write_timeout(Some(SLOWEST))
}

/// A request without its body, the bytes of its lines, and those of its body; `None` while lines are missing.
fn parsed(bytes: &[u8]) -> Result<Option<(Request, usize, usize)>, NoRequest> {
    let mut lines = [httparse::EMPTY_HEADER; MOST_LINES];
    let mut request = httparse::Request::new(&mut lines);
    let head = match request.parse(bytes) {
        Ok(httparse::Status::Complete(head)) => head,
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(httparse::Error::TooManyHeaders) => {
            return Err(NoRequest::Refused(431, "the request has too many lines"));
        }
        Err(_) => return Err(MALFORMED),
    };
    let (Some(method), Some(target)) = (request.method, request.path) else {
        return Err(MALFORMED);
    };
    let headers = request.headers.iter().map(|line| {
        let value = std::str::from_utf8(line.value).map_err(|_| MALFORMED)?;
        Ok((line.name.to_ascii_lowercase(), value.trim().to_owned()))
    });
    let request = Request {
        method: method.to_owned(),
        target: target.to_owned(),
        headers: headers.collect::<Result<_, NoRequest>>()?,
        body: Vec::new(),
    };
    if request.header("transfer-encoding").is_some() || request.count("content-length") > 1 {
        return Err(NoRequest::Refused(
            411,
            "the length of the body has to be said, once",
        ));
    }
    let length = match request.header("content-length") {
        None => 0,
        Some(length) => length.parse().map_err(|_| MALFORMED)?,
    };
    if length > MOST_BODY {
        return Err(NoRequest::Refused(413, "the request's body is too long"));
    }
    Ok(Some((request, head, length)))
}

/// An answer.
#[derive(Debug, Default)]
pub(crate) struct Response {
    pub status: u16,
    pub headers: Vec<(&'static str, String)>,
    pub body: Vec<u8>,
}

impl Response {
    /// A sentence.
    pub(crate) fn text(status: u16, sentence: &str) -> Self {
        Self {
            status,
            headers: vec![("Content-Type", "text/plain; charset=utf-8".to_owned())],
            body: format!("{sentence}\n").into_bytes(),
        }
    }

    /// Writes it; `is_last` ends the connection.
    pub(crate) fn write(&self, stream: &mut TcpStream, is_last: bool) -> std::io::Result<()> {
        let reason = match self.status {
            200 => "OK",
            303 => "See Other",
            403 => "Forbidden",
            404 => "Not Found",
            _ => "Refused",
        };
        let mut head = format!("HTTP/1.1 {} {reason}\r\n", self.status);
        let connection = if is_last { "close" } else { "keep-alive" };
        let own = [
            ("Content-Length", self.body.len().to_string()),
            ("Connection", connection.to_owned()),
            ("Cache-Control", "no-store".to_owned()),
            ("Referrer-Policy", "no-referrer".to_owned()),
            ("X-Content-Type-Options", "nosniff".to_owned()),
            ("Content-Security-Policy", "frame-ancestors 'self'".to_owned()),
        ];
        for (name, value) in own.iter().chain(&self.headers) {
            head += &format!("{name}: {value}\r\n");
        }
        head += "\r\n";
        stream.write_all(head.as_bytes())?;
        stream.write_all(&self.body)?;
        stream.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_parsed_and_bounded() {
        let text = "POST /ask HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2\r\n\r\n{}";
        let (request, head, length) = parsed(text.as_bytes()).unwrap().unwrap();
        assert_eq!(
            (request.method.as_str(), request.target.as_str()),
            ("POST", "/ask")
        );
        assert_eq!((&text[head..], length), ("{}", 2));
        assert_eq!(request.header("host"), Some("localhost"));
        assert!(parsed(&text.as_bytes()[..30]).unwrap().is_none());
        for (wrong, status) in [
            ("\0\0\0\r\n\r\n", 400),
            ("POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n", 400),
            (
                "POST / HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n",
                411,
            ),
            ("POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n", 411),
            ("POST / HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n", 413),
        ] {
            let found = parsed(wrong.as_bytes()).unwrap_err();
            assert!(
                matches!(found, NoRequest::Refused(own, _) if own == status),
                "{wrong:?}"
            );
        }
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(MOST_LINES + 1));
        assert!(matches!(parsed(many.as_bytes()), Err(NoRequest::Refused(431, _))));
    }
}
