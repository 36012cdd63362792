//! A server on this machine that shows volumes in browsers: for data that are too large to be sent, and machines without
//! a screen.
//!
//! A page asks it what an instance of [`splatvol_web`] would answer, by the same messages: so one player shows files, and
//! pictures from here, and both are the command's, to the byte. Requests name no files, so nothing can be asked for but
//! what the server was started with; nothing is written. No dependency on an asynchronous runtime: a few pages have a
//! thread each.
//!
//! | request | answer |
//! |---|---|
//! | `GET /?token=T` | the cookie, and on to `/` |
//! | `GET /` | the page |
//! | `GET /facts` | what is shown |
//! | `POST /ask`, a message of [`splatvol_web::message`] | two lengths, 32 bits each, little-endian; the answer's header, its bytes |
//!
//! | module | holds |
//! |---|---|
//! | `http` | requests, bounded in bytes and time, and answers |
//! | `guard` | who may ask: token, host, origin |
//! | `clients` | the state of each open page |
//! | `gate` | whose picture is drawn next |
#![forbid(unsafe_code)]

mod clients;
mod error;
mod gate;
mod guard;
mod http;

use std::io::Write;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use flate2::Compression;
use flate2::write::GzEncoder;
use splatvol::{EngineConfig, Frame, ImageSize, Renderer};
use splatvol_web::message::Request as Message;
use splatvol_web::{Answer, BLOCK, Shown, Tiles};

use clients::{Client, Clients};
pub use error::ServeError;
use gate::Gate;
use guard::Guard;
use http::{NoRequest, Request, Response};

/// Most connections at a time.
const MOST_CONNECTIONS: usize = 128;
/// Between two looks at the listener.
const SLICE: Duration = Duration::from_millis(20);
/// Most pixels of a picture.
const MOST_PIXELS: u64 = 1 << 24;
/// Keys that a page may change, of the picture and of items. Others may name files.
const KEYS: [&str; 1] = ["effects.clip-box"];
const ITEM_KEYS: [&str; 2] = ["visible", "opacity"];

/// Whether a page may change what is at a path: `effects.clip-box`, `item[0].visible`.
fn may_change(path: &str) -> bool {
    let of_item = path.strip_prefix("item[").and_then(|rest| rest.split_once("]."));
    let is_of_item = |(index, key): (&str, &str)| index.parse::<usize>().is_ok() && ITEM_KEYS.contains(&key);
    KEYS.contains(&path) || of_item.is_some_and(is_of_item)
}

/// What is served.
#[derive(Debug)]
pub struct Served {
    /// The page, HTML.
    pub page: String,
    /// What it shows.
    pub shown: Shown,
    /// Number of threads; one per processor without it.
    pub threads: Option<usize>,
}

/// Where, and for how long.
#[derive(Debug, Clone)]
pub struct Place {
    /// Address; port 0 takes a free one.
    pub address: SocketAddr,
    /// Names of this machine by which it may be asked, beside the loopback's.
    pub names: Vec<String>,
    /// It ends when nobody has asked for so long; `None` for never.
    pub idle: Option<Duration>,
}

/// A server that listens.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    idle: Option<Duration>,
    shared: Arc<Shared>,
}

/// What connections share.
#[derive(Debug)]
struct Shared {
    page: String,
    guard: Guard,
    clients: Clients,
    gate: Gate,
    engine: Mutex<(Renderer, Frame)>,
    connections: AtomicUsize,
    last: Mutex<Instant>,
    is_over: AtomicBool,
}

impl Server {
    /// Listens.
    ///
    /// # Errors
    /// Addresses and threads that the system refuses.
    pub fn new(served: Served, place: &Place) -> Result<Self, ServeError> {
        let listener = TcpListener::bind(place.address)
            .map_err(|error| std::io::Error::new(error.kind(), format!("{}: {error}", place.address)))?;
        let address = listener.local_addr()?;
        listener.set_nonblocking(true)?;
        let config = EngineConfig {
            threads: served.threads,
            tile_edge: Some(BLOCK),
            ..EngineConfig::default()
        };
        let shared = Shared {
            page: served.page,
            guard: Guard::new(address, place.names.clone())?,
            clients: Clients::new(served.shown),
            gate: Gate::default(),
            engine: Mutex::new((Renderer::new(config)?, Frame::empty(ImageSize::new(1, 1)?))),
            connections: AtomicUsize::new(0),
            last: Mutex::new(Instant::now()),
            is_over: AtomicBool::new(false),
        };
        Ok(Self {
            listener,
            idle: place.idle,
            shared: Arc::new(shared),
        })
    }

    /// The address that a browser opens first.
    ///
    /// # Errors
    /// A listener that the system has closed.
    pub fn url(&self) -> std::io::Result<String> {
        let port = self.listener.local_addr()?.port();
        let guard = &self.shared.guard;
        Ok(format!(
            "http://{}:{port}/?token={}",
            guard.first_name(),
            guard.token()
        ))
    }

    /// Answers until `stop` is set, or nobody has asked for long.
    ///
    /// # Errors
    /// A listener that fails.
    pub fn run(&self, stop: &AtomicBool) -> std::io::Result<()> {
        let ended = self.accept(stop);
        self.shared.is_over.store(true, Ordering::Relaxed);
        ended
    }

    fn accept(&self, stop: &AtomicBool) -> std::io::Result<()> {
        while !stop.load(Ordering::Relaxed) {
            match self.listener.accept() {
                Ok((stream, _)) => self.open(stream),
                Err(error) if http::is_wait(&error) => std::thread::sleep(SLICE),
                // A connection that ended before it was taken.
                Err(error) if error.kind() == std::io::ErrorKind::ConnectionAborted => {}
                Err(error) => return Err(error),
            }
            let last = *self.shared.last.lock().unwrap_or_else(PoisonError::into_inner);
            if self.idle.is_some_and(|idle| last.elapsed() > idle) {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Begins a connection, on a thread of its own.
    fn open(&self, mut stream: TcpStream) {
        let shared = Arc::clone(&self.shared);
        if shared.connections.fetch_add(1, Ordering::Relaxed) >= MOST_CONNECTIONS {
            shared.connections.fetch_sub(1, Ordering::Relaxed);
            return;
        }
        let started = std::thread::Builder::new().spawn(move || {
            if http::prepare(&stream).is_ok() {
                shared.converse(&mut stream);
            }
            shared.connections.fetch_sub(1, Ordering::Relaxed);
        });
        if started.is_err() {
            self.shared.connections.fetch_sub(1, Ordering::Relaxed);
        }
    }
}

impl Shared {
    /// Answers the requests of a connection.
    fn converse(&self, stream: &mut TcpStream) {
        while !self.is_over.load(Ordering::Relaxed) {
            let request = match http::read(stream) {
                Ok(request) => request,
                Err(NoRequest::Ended) => return,
                Err(NoRequest::Refused(status, why)) => {
                    // Nothing is owed to whoever does not listen.
                    let _ = Response::text(status, why).write(stream, true);
                    return;
                }
            };
            let Some(response) = self.answer(&request, stream) else {
                return;
            };
            let is_last = request
                .header("connection")
                .is_some_and(|own| own.eq_ignore_ascii_case("close"));
            if response.write(stream, is_last).is_err() || is_last {
                return;
            }
        }
    }

    /// The answer to a request; `None` where whoever asked has left.
    fn answer(&self, request: &Request, stream: &TcpStream) -> Option<Response> {
        if let Some(why) = self.guard.refusal(request) {
            return Some(Response::text(403, why));
        }
        let (path, query) = request.target.split_once('?').unwrap_or((&request.target, ""));
        let is_get = request.method == "GET";
        if is_get && path == "/" && self.guard.is_invited(query) {
            return Some(Response {
                status: 303,
                headers: vec![("Location", "./".to_owned()), ("Set-Cookie", self.guard.cookie())],
                body: Vec::new(),
            });
        }
        if !self.guard.is_known(request) {
            return Some(Response::text(
                403,
                "open the address that the server printed when it started",
            ));
        }
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
        let response = match (request.method.as_str(), path) {
            ("GET", "/") => packed("text/html; charset=utf-8", self.page.as_bytes(), request),
            ("GET", "/facts") => self.facts(request),
            ("POST", "/ask") => return self.ask(request, stream),
            (_, "/" | "/facts" | "/ask") => Response::text(405, "not by this method"),
            _ => Response::text(404, "there is nothing of this name: requests name no files"),
        };
        Some(response)
    }

    fn client(&self, request: &Request) -> Option<Arc<Client>> {
        let (client, forgotten) = self.clients.of(request.header("x-splatvol-client")?)?;
        if let Some(number) = forgotten {
            self.gate.forget(number);
        }
        Some(client)
    }

    fn facts(&self, request: &Request) -> Response {
        let Some(client) = self.client(request) else {
            return no_client();
        };
        let shown = client.shown.lock().unwrap_or_else(PoisonError::into_inner);
        let facts = shown.facts().and_then(|facts| Ok(serde_json::to_vec(&facts)?));
        match facts {
            Ok(facts) => packed("application/json", &facts, request),
            Err(error) => Response::text(500, &error.to_string()),
        }
    }

    fn ask(&self, request: &Request, stream: &TcpStream) -> Option<Response> {
        let Some(client) = self.client(request) else {
            return Some(no_client());
        };
        let answer = match self.answered(&client, &request.body, stream) {
            Ok(answer) => answer?,
            Err(error) => Answer {
                header: serde_json::json!({ "error": error.to_string() }).to_string(),
                bytes: Vec::new(),
            },
        };
        let mut body = Vec::with_capacity(8 + answer.header.len() + answer.bytes.len());
        for length in [answer.header.len(), answer.bytes.len()] {
            body.extend_from_slice(&(length as u32).to_le_bytes());
        }
        body.extend_from_slice(answer.header.as_bytes());
        body.extend_from_slice(&answer.bytes);
        Some(packed("application/octet-stream", &body, request))
    }

    /// What a client is answered; nothing if it has left.
    fn answered(
        &self,
        client: &Client,
        body: &[u8],
        stream: &TcpStream,
    ) -> Result<Option<Answer>, ServeError> {
        let message: Message = serde_json::from_slice(body)?;
        let tiles = {
            let mut shown = client.shown.lock().unwrap_or_else(PoisonError::into_inner);
            match message {
                Message::Render { size, camera, share } => {
                    let is_large = size.is_some_and(|[w, h]| u64::from(w) * u64::from(h) > MOST_PIXELS);
                    if is_large {
                        return Err(ServeError::TooLarge(MOST_PIXELS));
                    }
                    shown.tiles(size, camera, share)?
                }
                Message::Edit { edits } if !edits.iter().all(|edit| may_change(&edit.path)) => {
                    return Err(ServeError::Fixed);
                }
                change => return Ok(Some(shown.answer(change)?)),
            }
        };
        self.draw(client, &tiles, stream)
    }

    /// Draws tiles when it is their turn, unless whoever asked leaves before.
    fn draw(&self, client: &Client, tiles: &Tiles, stream: &TcpStream) -> Result<Option<Answer>, ServeError> {
        let watch = Watch::new(stream.try_clone()?)?;
        let turn = self
            .gate
            .enter(client.number, tiles.pixel_count(), &watch.has_left);
        let drawn = turn.map(|_turn| {
            let mut engine = self.engine.lock().unwrap_or_else(PoisonError::into_inner);
            let (renderer, frame) = &mut *engine;
            tiles.draw((renderer, frame), Some(&watch.has_left))
        });
        match drawn {
            Some(drawn) if !watch.has_left.load(Ordering::Relaxed) => Ok(Some(drawn?)),
            _ => Ok(None),
        }
    }
}

/// Watches whether the other end of a connection is closed, until it is dropped.
#[derive(Debug)]
struct Watch {
    has_left: Arc<AtomicBool>,
    is_over: Arc<AtomicBool>,
}

impl Watch {
    fn new(stream: TcpStream) -> std::io::Result<Self> {
        let watch = Self {
            has_left: Arc::default(),
            is_over: Arc::default(),
        };
        let [has_left, is_over] = [&watch.has_left, &watch.is_over].map(Arc::clone);
        // Nobody waits for it: a look may last a while longer than the picture.
        std::thread::Builder::new().spawn(move || {
            while !is_over.load(Ordering::Relaxed) {
                match stream.peek(&mut [0]) {
                    // The next request is there already.
                    Ok(1..) => std::thread::sleep(SLICE),
                    Err(error) if http::is_wait(&error) => {}
                    Ok(0) | Err(_) => return has_left.store(true, Ordering::Relaxed),
                }
            }
        })?;
        Ok(watch)
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
    }
}

fn no_client() -> Response {
    Response::text(400, "X-Splatvol-Client has to name the page: letters and digits")
}

/// A body, as gzip where it is taken: pictures go through slow connections, too.
fn packed(kind: &str, body: &[u8], request: &Request) -> Response {
    let mut headers = vec![("Content-Type", kind.to_owned())];
    let takes = request
        .header("accept-encoding")
        .is_some_and(|all| all.contains("gzip"));
    let gzip = || {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(body)?;
        encoder.finish()
    };
    let body = match takes.then(gzip) {
        Some(Ok(packed)) => {
            headers.push(("Content-Encoding", "gzip".to_owned()));
            packed
        }
        _ => body.to_vec(),
    };
    Response {
        status: 200,
        headers,
        body,
    }
}
