//! Chromium without a window: a page that says something, by WebGPU on a device that the browser imitates itself.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A file that the browser may ask for.
#[derive(Debug, Clone, Copy)]
pub struct Served<'a> {
    /// Path: `/` for the page itself.
    pub path: &'a str,
    /// Type: `text/html`.
    pub content_type: &'a str,
    /// What it has.
    pub bytes: &'a [u8],
}

impl<'a> Served<'a> {
    /// The page itself.
    pub fn page(text: &'a str) -> Self {
        Self {
            path: "/",
            content_type: "text/html",
            bytes: text.as_bytes(),
        }
    }
}

/// Chromium with a device that it imitates itself.
const FLAGS: [&str; 8] = [
    "--headless",
    "--no-sandbox",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-dev-shm-usage",
    "--enable-unsafe-webgpu",
    "--use-webgpu-adapter=swiftshader",
];
/// A running browser, which ends with the test, whatever becomes of that.
struct Browser(Child);

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What a page posts to `/` within a time; `None` where there is no Chromium.
///
/// # Panics
/// No port or folder for it, or a browser that says nothing.
pub fn posted(files: &[Served<'_>], patience: Duration) -> Option<String> {
    let listener = TcpListener::bind(("127.0.0.1", 0)).expect("a port");
    let address = format!("http://{}/", listener.local_addr().expect("an address"));
    let profile = tempfile::tempdir().expect("a folder");
    let started = Command::new("chromium")
        .args(FLAGS)
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(address)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let _browser = Browser(started.ok()?);
    listener
        .set_nonblocking(true)
        .expect("a listener that does not wait");
    let start = Instant::now();
    while start.elapsed() < patience {
        match listener.accept() {
            Ok((stream, _)) => {
                if let Some(said) = answer(stream, files) {
                    return Some(said);
                }
            }
            Err(_) => std::thread::sleep(Duration::from_millis(20)),
        }
    }
    panic!("the browser says nothing");
}

/// Longest time for a request.
const SLOWEST: Duration = Duration::from_secs(30);

/// Answers a request with a file; the text of one that posts.
fn answer(mut stream: TcpStream, files: &[Served<'_>]) -> Option<String> {
    stream.set_nonblocking(false).expect("a stream that waits");
    stream.set_read_timeout(Some(SLOWEST)).expect("a limit");
    let mut reader = BufReader::new(stream.try_clone().expect("a second handle"));
    let mut line = String::new();
    let mut length = 0;
    let mut posts = false;
    let mut path = String::new();
    // A browser opens connections that it does not use.
    while reader.read_line(&mut line).is_ok_and(|read| read > 0) {
        let header = line.trim().to_ascii_lowercase();
        if header.is_empty() {
            break;
        }
        if path.is_empty() {
            posts = header.starts_with("post ");
            path = line.split(' ').nth(1).unwrap_or_default().to_owned();
        }
        if let Some(value) = header.strip_prefix("content-length:") {
            length = value.trim().parse().expect("a length");
        }
        line.clear();
    }
    let mut body = vec![0; length];
    reader
        .read_exact(&mut body)
        .expect("as many bytes as were announced");
    let file = files.iter().find(|file| file.path == path);
    let (status, content_type, bytes) = match file {
        Some(file) => ("200 OK", file.content_type, file.bytes),
        None => ("404 Not Found", "text/plain", &b"there is no such file"[..]),
    };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {content_type}\r\nConnection: close\r\nContent-Length: {}\r\n\r\n",
        bytes.len()
    );
    // The browser may have gone.
    let _ = stream.write_all(&[head.as_bytes(), bytes].concat());
    posts.then(|| String::from_utf8_lossy(&body).into_owned())
}
