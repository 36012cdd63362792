//! A server of files on this machine, and what servers do wrong.

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// What a server does wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    Nothing,
    /// Every fifth answer: busy.
    Busy,
    /// Every fifth answer breaks off in the middle.
    Cut,
    /// Every answer takes its time.
    Slow,
    /// Every fifth answer never comes.
    Stalls,
    /// No answer comes.
    Mute,
    /// Ranges are ignored.
    NoRanges,
    /// All chunks are denied.
    Denied,
    /// Everything that is not there is denied.
    Secretive,
}

/// A server.
#[derive(Debug)]
pub struct Server {
    /// Its address.
    pub address: String,
    counts: Arc<Counts>,
}

impl Server {
    /// Requests so far.
    pub fn requests(&self) -> usize {
        self.counts.all.load(Ordering::Relaxed)
    }

    /// The most requests that were answered at the same time.
    pub fn most_at_once(&self) -> usize {
        self.counts.most_at_once.load(Ordering::Relaxed)
    }
}

#[derive(Debug, Default)]
struct Counts {
    all: AtomicUsize,
    now: AtomicUsize,
    most_at_once: AtomicUsize,
}

/// Serves a folder on this machine.
///
/// # Panics
/// A machine without a port for it.
pub fn serve(folder: PathBuf, fault: Fault) -> Server {
    let listener = TcpListener::bind("127.0.0.1:0").expect("the machine has a free port");
    let place = listener.local_addr().expect("a listener has an address");
    let address = format!("http://{place}");
    let counts = Arc::new(Counts::default());
    let counted = Arc::clone(&counts);
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let (folder, counted) = (folder.clone(), Arc::clone(&counted));
            std::thread::spawn(move || answer(stream, &folder, fault, &counted));
        }
    });
    Server { address, counts }
}

/// Longer than a test waits.
const FOR_EVER: Duration = Duration::from_secs(600);

/// Answers the requests of a connection, one after the other.
fn answer(stream: TcpStream, folder: &Path, fault: Fault, counted: &Counts) {
    let Ok(reader) = stream.try_clone() else { return };
    let (mut lines, mut stream) = (BufReader::new(reader).lines(), stream);
    loop {
        let mut request = Vec::new();
        for line in lines.by_ref() {
            match line {
                Ok(line) if line.is_empty() => break,
                Ok(line) => request.push(line),
                Err(_) => return,
            }
        }
        let Some(first) = request.first() else { return };
        let number = counted.all.fetch_add(1, Ordering::Relaxed) + 1;
        let now = counted.now.fetch_add(1, Ordering::Relaxed) + 1;
        counted.most_at_once.fetch_max(now, Ordering::Relaxed);
        match fault {
            Fault::Slow => std::thread::sleep(Duration::from_millis(30)),
            Fault::Mute => std::thread::sleep(FOR_EVER),
            Fault::Stalls if number.is_multiple_of(5) => std::thread::sleep(FOR_EVER),
            _ => {}
        }
        let path = first.split(' ').nth(1).unwrap_or("/").trim_start_matches('/');
        let range = request.iter().find_map(|line| {
            let (name, value) = line.split_once(": ")?;
            name.eq_ignore_ascii_case("range")
                .then(|| value.strip_prefix("bytes=").unwrap_or_default().to_owned())
        });
        // One packet: servers that wait for the answer to the first of two take their time.
        let (head, body) = respond(&folder.join(path), range.as_deref(), (fault, number));
        let sent = match fault == Fault::Cut && number.is_multiple_of(5) {
            true => &body[..body.len() / 2],
            false => &body[..],
        };
        let answer = [head.as_bytes(), sent].concat();
        counted.now.fetch_sub(1, Ordering::Relaxed);
        if stream.write_all(&answer).is_err() || sent.len() < body.len() {
            return;
        }
    }
}

/// Head and body of an answer.
fn respond(path: &Path, range: Option<&str>, (fault, number): (Fault, usize)) -> (String, Vec<u8>) {
    let plain = |status: &str, body: Vec<u8>| {
        let head = format!(
            "HTTP/1.1 {status}\r\nContent-Length: {}\r\nLast-Modified: Wed, 25 Nov 2026 10:00:00 GMT\r\n\r\n",
            body.len()
        );
        (head, body)
    };
    let is_chunk = path.to_string_lossy().contains("/c/");
    if fault == Fault::Busy && number.is_multiple_of(5) {
        return plain("503 Service Unavailable", Vec::new());
    }
    if fault == Fault::Denied && is_chunk {
        return plain("403 Forbidden", Vec::new());
    }
    let Ok(all) = std::fs::read(path) else {
        return match fault {
            Fault::Secretive => plain("403 Forbidden", Vec::new()),
            _ => plain("404 Not Found", Vec::new()),
        };
    };
    let Some(range) = range.filter(|_| fault != Fault::NoRanges) else {
        return plain("200 OK", all);
    };
    let (from, to) = range.split_once('-').unwrap_or(("", ""));
    let number = |text: &str| text.parse::<usize>().unwrap_or(all.len());
    let (start, end) = match from {
        "" => (all.len() - number(to).min(all.len()), all.len()),
        from => (
            number(from).min(all.len()),
            number(to).saturating_add(1).min(all.len()),
        ),
    };
    if start >= end {
        return plain("416 Range Not Satisfiable", Vec::new());
    }
    let head = format!(
        "HTTP/1.1 206 Partial Content\r\nContent-Length: {}\r\nContent-Range: bytes {start}-{}/{}\r\n\
         Last-Modified: Wed, 25 Nov 2026 10:00:00 GMT\r\n\r\n",
        end - start,
        end - 1,
        all.len()
    );
    (head, all[start..end].to_vec())
}
