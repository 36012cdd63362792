//! Chromium, by the protocol of web drivers (W3C): JSON over HTTP to the program `chromedriver`.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};

use super::{own_group, program};

/// Flags that keep Chromium from talking to anyone of its own accord.
const QUIET: [&str; 9] = [
    "--headless",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
];

/// Flags for a GPU that Chromium imitates itself, and for none.
const GPU: [&str; 2] = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"];
const NO_GPU: [&str; 1] = ["--disable-gpu"];

/// A session of Chromium.
pub(super) struct Chromedriver {
    port: u16,
    session: String,
}

impl Chromedriver {
    /// Starts the driver, and Chromium by it; `None` where either is not installed.
    pub(super) fn start([width, height]: [u32; 2], with_gpu: bool, profile: &Path) -> Option<(Child, Self)> {
        let chromium = program(&["chromium", "chromium-browser", "google-chrome"])?;
        let mut driver = Command::new(program(&["chromedriver"])?);
        driver
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        let mut driver = own_group(&mut driver).spawn().expect("chromedriver starts");
        let gpu: &[&str] = if with_gpu { &GPU } else { &NO_GPU };
        let mut arguments: Vec<String> = QUIET.iter().chain(gpu).map(|&flag| flag.to_owned()).collect();
        arguments.push(format!("--window-size={width},{height}"));
        arguments.push(format!("--user-data-dir={}", profile.display()));
        let options = json!({ "binary": chromium, "args": arguments });
        let wanted = json!({
            "browserName": "chrome",
            "goog:chromeOptions": options,
            "goog:loggingPrefs": { "performance": "ALL", "browser": "ALL" },
            "timeouts": { "script": 120_000 },
        });
        let mut session = Self {
            port: port_of(&mut driver),
            session: String::new(),
        };
        let started = session.post("/session", &json!({ "capabilities": { "alwaysMatch": wanted } }));
        started["sessionId"]
            .as_str()
            .expect("a session has a name")
            .clone_into(&mut session.session);
        Some((driver, session))
    }

    #[track_caller]
    pub(super) fn command(&self, name: &str, body: &Value) -> Value {
        self.post(&format!("/session/{}/{name}", self.session), body)
    }

    #[track_caller]
    fn post(&self, path: &str, body: &Value) -> Value {
        let (status, value) = self.request("POST", path, &body.to_string());
        assert!(status.contains(" 200"), "{path}: {status}: {value}");
        value
    }

    /// The status and the value of an answer.
    fn request(&self, method: &str, path: &str, body: &str) -> (String, Value) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).expect("chromedriver listens");
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\
             Connection: close\r\n\r\n{body}",
            self.port,
            body.len()
        )
        .expect("chromedriver reads");
        let mut reader = BufReader::new(stream);
        let mut line = || {
            let mut line = String::new();
            reader.read_line(&mut line).expect("chromedriver answers");
            line.trim_end().to_owned()
        };
        let status = line();
        let mut length = 0;
        loop {
            let header = line().to_ascii_lowercase();
            if header.is_empty() {
                break;
            }
            if let Some(value) = header.strip_prefix("content-length:") {
                length = value.trim().parse().expect("a length is a number");
            }
        }
        let mut body = vec![0; length];
        reader.read_exact(&mut body).expect("an answer is whole");
        let answer: Value = serde_json::from_slice(&body).expect("an answer is JSON");
        (status, answer["value"].clone())
    }
}

/// The port that the driver says it listens on.
fn port_of(driver: &mut Child) -> u16 {
    let output = driver.stdout.take().expect("its output is piped");
    for line in BufReader::new(output).lines() {
        let line = line.expect("chromedriver speaks text");
        if let Some((_, port)) = line.split_once("successfully on port ") {
            return port.trim_end_matches('.').parse().expect("a port is a number");
        }
    }
    panic!("chromedriver names no port");
}
