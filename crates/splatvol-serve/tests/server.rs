//! The server by its socket: who is answered and who is not, that pictures are those of the renderer, and that nobody
//! disturbs anybody.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use splatvol::{Content, EngineConfig, Frame, Renderer};
use splatvol_document::{Document, Held};
use splatvol_io::{Data, Description};
use splatvol_serve::{Place, Served, Server};
use splatvol_web::Shown;

/// A server on a port of its own, which ends with the test.
struct Running {
    host: String,
    cookie: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<std::io::Result<()>>>,
}

/// An answer: its status, its lines, its body.
struct Answered {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Answered {
    fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }
}

fn shown(edge: usize) -> (Shown, Frame) {
    let volume =
        splatvol::samples::sample("head", Some(splatvol::samples::SampleSize::Dims([edge; 3]))).unwrap();
    let description = Description {
        oriented: true,
        ..Description::default()
    };
    let held = vec![Some(Held::new(Data::Volume(volume), description))];
    let text = r#"{ "size": "80x48", "item": [{ "file": "head" }], "camera": { "view": "left" } }"#;
    let document = Document::from_json(text, "document".as_ref()).unwrap();
    let shown = Shown::new(&document, held.clone()).unwrap();
    let picture = document
        .resolve(splatvol_document::Resolving {
            reading: splatvol_document::Reading {
                rules: splatvol_document::ReadRules::default(),
                folder: None,
                listener: &splatvol_document::Silent,
            },
            held: &held,
            moves: splatvol_document::CameraMotion::default(),
            keeps_alpha: false,
            in_windows: false,
        })
        .unwrap();
    assert!(matches!(picture.scene.items[0].content, Content::Volume { .. }));
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let frame = renderer
        .render(&picture.scene, &picture.camera, &picture.settings)
        .unwrap();
    let laid = splatvol_document::resolve::laid_over(&frame.image, picture.background().unwrap());
    (shown, Frame { image: laid, ..frame })
}

impl Running {
    fn new(edge: usize, idle: Option<Duration>) -> (Self, Frame) {
        let (shown, frame) = shown(edge);
        let served = Served {
            page: "<!doctype html>the page".to_owned(),
            shown,
            threads: None,
        };
        let place = Place {
            address: "127.0.0.1:0".parse().unwrap(),
            names: vec!["lab.example".to_owned()],
            idle,
        };
        let server = Server::new(served, &place).unwrap();
        let url = server.url().unwrap();
        let (host, token) = url
            .strip_prefix("http://")
            .unwrap()
            .split_once("/?token=")
            .unwrap();
        let port = host.rsplit(':').next().unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let over = Arc::clone(&stop);
        let running = Self {
            host: host.to_owned(),
            cookie: format!("splatvol-{port}={token}"),
            stop,
            thread: Some(std::thread::spawn(move || server.run(&over))),
        };
        (running, frame)
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        stream
    }

    /// Sends bytes, and reads the answer.
    fn raw(&self, request: &[u8]) -> Answered {
        let mut stream = self.connect();
        // A server that has seen enough need not read the rest.
        let _ = stream.write_all(request);
        read(&mut stream)
    }

    /// A request with the cookie, and other lines.
    fn request(&self, line: &str, lines: &str, body: &str) -> Answered {
        self.raw(self.text(line, lines, body).as_bytes())
    }

    fn text(&self, line: &str, lines: &str, body: &str) -> String {
        format!(
            "{line} HTTP/1.1\r\nHost: {}\r\nCookie: a=b; {}\r\nX-Splatvol-Client: page1\r\nContent-Length: {}\r\n{lines}\r\n{body}",
            self.host,
            self.cookie,
            body.len()
        )
    }

    fn ask(&self, message: &serde_json::Value) -> (serde_json::Value, Vec<u8>) {
        let answered = self.request("POST /ask", "Connection: close\r\n", &message.to_string());
        assert_eq!(answered.status, 200, "{}", answered.text());
        let length = |at: usize| u32::from_le_bytes(answered.body[at..at + 4].try_into().unwrap()) as usize;
        let (said, pixels) = (length(0), length(4));
        let header = serde_json::from_slice(&answered.body[8..8 + said]).unwrap();
        let bytes = answered.body[8 + said..].to_vec();
        assert_eq!(bytes.len(), pixels);
        (header, bytes)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn read(stream: &mut TcpStream) -> Answered {
    let mut bytes = Vec::new();
    let mut piece = [0; 4096];
    loop {
        let end = bytes
            .windows(4)
            .position(|four| four == b"\r\n\r\n")
            .map(|at| at + 4);
        if let Some(end) = end {
            let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
            let length = head
                .lines()
                .find_map(|line| line.strip_prefix("Content-Length: "));
            let length: usize = length.unwrap().parse().unwrap();
            if bytes.len() >= end + length {
                let status = head.split(' ').nth(1).unwrap().parse().unwrap();
                return Answered {
                    status,
                    head,
                    body: bytes[end..end + length].to_vec(),
                };
            }
        }
        match stream.read(&mut piece) {
            Ok(count) if count > 0 => bytes.extend_from_slice(&piece[..count]),
            _ => {
                return Answered {
                    status: 0,
                    head: String::new(),
                    body: bytes,
                };
            }
        }
    }
}

#[test]
fn the_address_leads_to_the_page_and_pictures_are_the_renderers() {
    let (running, frame) = Running::new(24, None);
    let token = running.cookie.split_once('=').unwrap().1;
    let first = running.raw(format!("GET /?token={token} HTTP/1.1\r\nHost: localhost:1\r\n\r\n").as_bytes());
    assert_eq!(first.status, 303);
    assert!(first.head.contains(&format!(
        "Set-Cookie: {}; Path=/; HttpOnly; SameSite=Strict",
        running.cookie
    )));
    let page = running.request("GET /", "", "");
    assert_eq!(
        (page.status, page.text().as_str()),
        (200, "<!doctype html>the page")
    );
    let facts = running.request("GET /facts", "", "");
    assert!(facts.text().contains("color-maps"), "{}", facts.text());
    let mut pixels = vec![[0u8; 4]; 80 * 48];
    for share in 0..3 {
        let (header, bytes) = running.ask(&serde_json::json!({ "do": "render", "share": [share, 3] }));
        let mut at = 0;
        for tile in header["tiles"].as_array().unwrap() {
            let [x0, y0, x1, y1] = [0, 1, 2, 3].map(|i| tile[i].as_u64().unwrap() as usize);
            for y in y0..y1 {
                for x in x0..x1 {
                    pixels[y * 80 + x].copy_from_slice(&bytes[at..at + 4]);
                    at += 4;
                }
            }
        }
    }
    assert!(pixels == splatvol_io::image::png::srgb8(&frame.image));
}

#[test]
fn whoever_was_not_invited_is_refused() {
    let (running, _) = Running::new(8, None);
    let host = &running.host;
    let cookie = &running.cookie;
    let refused = [
        // Neither token nor cookie, wrong ones.
        format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n"),
        format!("GET /?token=00 HTTP/1.1\r\nHost: {host}\r\n\r\n"),
        format!("GET / HTTP/1.1\r\nHost: {host}\r\nCookie: {cookie}0\r\n\r\n"),
        // Another name that leads here, none, two.
        format!("GET / HTTP/1.1\r\nHost: evil.example\r\nCookie: {cookie}\r\n\r\n"),
        format!("GET / HTTP/1.1\r\nCookie: {cookie}\r\n\r\n"),
        format!("GET / HTTP/1.1\r\nHost: {host}\r\nHost: {host}\r\nCookie: {cookie}\r\n\r\n"),
        // Another page, or one without an address.
        format!(
            "POST /ask HTTP/1.1\r\nHost: {host}\r\nOrigin: http://evil.example\r\nCookie: {cookie}\r\n\r\n"
        ),
        format!("POST /ask HTTP/1.1\r\nHost: {host}\r\nOrigin: null\r\nCookie: {cookie}\r\n\r\n"),
        format!(
            "POST /ask HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}.evil.example\r\nCookie: {cookie}\r\n\r\n"
        ),
    ];
    for request in refused {
        let answered = running.raw(request.as_bytes());
        assert_eq!(answered.status, 403, "{request}");
        assert!(!answered.text().contains("the page"), "{request}");
    }
    let named = format!("GET / HTTP/1.1\r\nHost: lab.example:80\r\nCookie: {cookie}\r\n\r\n");
    assert_eq!(running.raw(named.as_bytes()).status, 200);
    let own = running.request("POST /ask", &format!("Origin: http://{host}\r\n"), "{}");
    assert_eq!(own.status, 200);
}

#[test]
fn no_request_names_a_file() {
    let (running, _) = Running::new(8, None);
    for path in [
        "/etc/passwd",
        "/../../etc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "//etc/passwd",
        "/facts/../x",
    ] {
        assert_eq!(
            running.request(&format!("GET {path}"), "", "").status,
            404,
            "{path}"
        );
    }
    for (path, value) in [
        ("item[0].file", serde_json::json!("/etc/passwd")),
        ("effects.bump", serde_json::json!("/etc/passwd")),
        ("camera.path", serde_json::json!("/etc/passwd")),
    ] {
        let edit = serde_json::json!({ "do": "edit", "edits": [{ "path": path, "value": value }] });
        let (header, _) = running.ask(&edit);
        assert_eq!(
            header["error"], "a page changes no key but effects.clip-box, and visible and opacity of items",
            "{path}"
        );
    }
    let (header, _) = running.ask(&serde_json::json!({ "do": "open", "document": {}, "data": [] }));
    assert!(header["error"].is_string());
    let (header, _) = running.ask(&serde_json::json!({ "do": "render", "size": [60000, 60000] }));
    assert!(header["error"].as_str().unwrap().contains("at most"));
}

#[test]
fn long_and_slow_requests_are_dropped_and_others_are_not_disturbed() {
    let (running, _) = Running::new(8, None);
    // A client that never ends its request, and one that does not read.
    let mut slow = running.connect();
    slow.write_all(b"GET / HTTP/1.1\r\nHost:").unwrap();
    let mut deaf = running.connect();
    for _ in 0..50 {
        deaf.write_all(running.text("GET /facts", "", "").as_bytes())
            .unwrap();
    }
    let mut long = running.connect();
    let mut sent = 0;
    long.write_all(b"GET / HTTP/1.1\r\n").unwrap();
    while sent < 10 << 20 && long.write_all(&[b'a'; 4096]).is_ok() {
        sent += 4096;
        if sent == 64 << 10 {
            // It is refused long before all has come.
            let refused = read(&mut long);
            assert!([0, 400, 431].contains(&refused.status), "{}", refused.status);
            break;
        }
    }
    let start = Instant::now();
    for _ in 0..20 {
        assert_eq!(running.request("GET /", "", "").status, 200);
    }
    assert!(start.elapsed() < Duration::from_secs(9), "{:?}", start.elapsed());
    let refused = read(&mut slow);
    assert_eq!(refused.status, 408);
    let large = running.request("POST /ask", "", &"x".repeat(70 << 10));
    assert_eq!(large.status, 413);
}

#[test]
fn a_client_that_leaves_stops_its_picture_and_many_share() {
    let (running, _) = Running::new(48, None);
    // Pictures that would take minutes.
    let large = serde_json::json!({ "do": "render", "size": [4000, 4000] }).to_string();
    for _ in 0..3 {
        let mut stream = running.connect();
        stream
            .write_all(running.text("POST /ask", "", &large).as_bytes())
            .unwrap();
        std::thread::sleep(Duration::from_millis(100));
    }
    let start = Instant::now();
    std::thread::scope(|scope| {
        let clients: Vec<_> = (0..20)
            .map(|number| {
                let running = &running;
                scope.spawn(move || {
                    let name = format!("X-Splatvol-Client: page{number}\r\n");
                    let body = r#"{ "do": "render", "size": [64, 64] }"#;
                    let text = running
                        .text("POST /ask", "", body)
                        .replace("X-Splatvol-Client: page1\r\n", &name);
                    let mut stream = running.connect();
                    for _ in 0..3 {
                        stream.write_all(text.as_bytes()).unwrap();
                        assert_eq!(read(&mut stream).status, 200);
                    }
                })
            })
            .collect();
        for client in clients {
            client.join().unwrap();
        }
    });
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
}

#[test]
fn it_ends_by_itself_when_nobody_asks() {
    let (mut running, _) = Running::new(8, Some(Duration::from_millis(300)));
    assert_eq!(running.request("GET /", "", "").status, 200);
    let thread = running.thread.take().unwrap();
    thread.join().unwrap().unwrap();
}
