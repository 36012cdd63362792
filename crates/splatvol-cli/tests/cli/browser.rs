//! A browser without a window, by the protocol of web drivers (W3C): JSON over HTTP to the program `chromedriver`.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};

/// Flags that keep Chromium from talking to anyone of its own accord.
const QUIET: [&str; 10] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
];

/// A browser with one page.
pub(crate) struct Browser {
    driver: Child,
    port: u16,
    session: String,
    _profile: tempfile::TempDir,
}

/// A program by its name.
fn program(names: &[&str]) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let places =
        std::env::split_paths(&path).flat_map(|folder| names.iter().map(move |name| folder.join(name)));
    places.into_iter().find(|place| place.is_file())
}

impl Browser {
    /// Starts Chromium; `None` where it or its driver is not installed.
    pub(crate) fn start([width, height]: [u32; 2]) -> Option<Self> {
        let chromium = program(&["chromium", "chromium-browser", "google-chrome"])?;
        let mut driver = Command::new(program(&["chromedriver"])?);
        driver
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        // A group of its own, so that all of it can be ended.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut driver, 0);
        let mut driver = driver.spawn().expect("chromedriver starts");
        let port = port_of(&mut driver);
        let profile = tempfile::tempdir().expect("the system has a temporary folder");
        let mut arguments: Vec<String> = QUIET.map(str::to_owned).to_vec();
        arguments.push(format!("--window-size={width},{height}"));
        arguments.push(format!("--user-data-dir={}", profile.path().display()));
        let options = json!({ "binary": chromium, "args": arguments });
        let wanted = json!({
            "browserName": "chrome",
            "goog:chromeOptions": options,
            "goog:loggingPrefs": { "performance": "ALL", "browser": "ALL" },
            "timeouts": { "script": 120_000 },
        });
        let mut browser = Self {
            driver,
            port,
            session: String::new(),
            _profile: profile,
        };
        let started = browser.post("/session", &json!({ "capabilities": { "alwaysMatch": wanted } }));
        started["sessionId"]
            .as_str()
            .expect("a session has a name")
            .clone_into(&mut browser.session);
        Some(browser)
    }

    /// Opens a file.
    pub(crate) fn open(&self, page: &Path) {
        self.visit(&format!("file://{}", page.display()));
    }

    /// Opens an address.
    pub(crate) fn visit(&self, url: &str) {
        self.command("url", &json!({ "url": url }));
    }

    /// What a promise of the page becomes.
    #[track_caller]
    pub(crate) fn promised(&self, expression: &str) -> Value {
        let script = format!(
            "const done = arguments[arguments.length - 1]; Promise.resolve({expression}).then((value) => done({{ value }}), \
             (error) => done({{ error: String(error) }}));"
        );
        let said = self.command("execute/async", &json!({ "script": script, "args": [] }));
        assert!(said.get("error").is_none(), "{expression}: {said}");
        said["value"].clone()
    }

    /// RGBA of the page's picture in a size.
    #[track_caller]
    pub(crate) fn picture(&self, [width, height]: [u32; 2]) -> Vec<u8> {
        use base64::Engine;
        let text = self.promised(&format!(
            "splatvol.picture({width}, {height}).then((image) => {{ let text = ''; const size = 3 << 13; \
             for (let i = 0; i < image.data.length; i += size) \
             text += btoa(String.fromCharCode(...image.data.subarray(i, i + size))); return text; }})"
        ));
        let text = text.as_str().expect("the page answers with text");
        base64::engine::general_purpose::STANDARD
            .decode(text)
            .expect("it is base64")
    }

    /// Drags on an element, in pixels from its middle.
    pub(crate) fn drag(&self, selector: &str, [x, y]: [i32; 2]) {
        let found = self.command("element", &json!({ "using": "css selector", "value": selector }));
        let step = |x: i32, y: i32| json!({ "type": "pointerMove", "duration": 60, "origin": found, "x": x, "y": y });
        let actions = json!([
            step(0, 0),
            { "type": "pointerDown", "button": 0 },
            step(x / 2, y / 2),
            step(x, y),
            { "type": "pointerUp", "button": 0 },
        ]);
        let pointer = json!({ "type": "pointer", "id": "mouse", "actions": actions });
        self.command("actions", &json!({ "actions": [pointer] }));
    }

    /// Presses a key on what has the focus.
    pub(crate) fn press(&self, key: &str) {
        let actions = json!([{ "type": "keyDown", "value": key }, { "type": "keyUp", "value": key }]);
        self.command(
            "actions",
            &json!({ "actions": [{ "type": "key", "id": "keys", "actions": actions }] }),
        );
    }

    /// Addresses that pages of files asked for since the last call.
    pub(crate) fn requests(&self) -> Vec<String> {
        let log = self.command("se/log", &json!({ "type": "performance" }));
        let entries = log.as_array().expect("a log is a list").iter();
        let messages =
            entries.filter_map(|entry| serde_json::from_str::<Value>(entry["message"].as_str()?).ok());
        let sent = messages.filter(|entry| entry["message"]["method"] == "Network.requestWillBeSent");
        // The browser's own first page asks for things, too.
        let urls = sent.filter_map(|entry| {
            let params = &entry["message"]["params"];
            let of_file = params["documentURL"].as_str()?.starts_with("file:");
            of_file.then(|| params["request"]["url"].as_str().map(str::to_owned))?
        });
        urls.collect()
    }

    /// Errors and warnings of the page since the last call.
    pub(crate) fn complaints(&self) -> Vec<String> {
        let log = self.command("se/log", &json!({ "type": "browser" }));
        let entries = log.as_array().expect("a log is a list").iter();
        entries.map(|entry| entry["message"].to_string()).collect()
    }

    #[track_caller]
    fn command(&self, name: &str, body: &Value) -> Value {
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

impl Drop for Browser {
    fn drop(&mut self) {
        // Ends the driver and its browser, whose group is the driver's; either may have ended already.
        let group = format!("-{}", self.driver.id());
        let _ = Command::new("kill").args(["-KILL", "--", &group]).status();
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}
