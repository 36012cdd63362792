//! Firefox, by its own protocol for remote control, Marionette: JSON over TCP, each message with its length before it.

use std::cell::RefCell;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};

use super::{own_group, program};

/// Preferences: any free port, and nobody to talk to, not even where a page asked for it.
const PREFERENCES: &str = r#"user_pref("marionette.port", 0);
user_pref("network.proxy.type", 1);
user_pref("network.proxy.http", "127.0.0.1");
user_pref("network.proxy.http_port", 9);
user_pref("network.proxy.ssl", "127.0.0.1");
user_pref("network.proxy.ssl_port", 9);
user_pref("browser.shell.checkDefaultBrowser", false);
user_pref("datareporting.policy.dataSubmissionEnabled", false);
user_pref("toolkit.telemetry.enabled", false);
user_pref("app.normandy.enabled", false);
user_pref("browser.startup.page", 0);
"#;
/// The file of a profile that holds the port.
const PORT: &str = "MarionetteActivePort";

/// A session of Firefox.
pub(super) struct Marionette {
    stream: RefCell<BufReader<TcpStream>>,
}

impl Marionette {
    /// Starts Firefox; `None` where it is not installed.
    pub(super) fn start([width, height]: [u32; 2], profile: &Path) -> Option<(Child, Self)> {
        let mut firefox = Command::new(program(&["firefox-esr", "firefox"])?);
        std::fs::write(profile.join("user.js"), PREFERENCES).expect("a profile can be written");
        firefox
            .args(["--headless", "--marionette", "--no-remote", "--profile"])
            .arg(profile)
            .args([format!("--width={width}"), format!("--height={height}")])
            .env("MOZ_CRASHREPORTER_DISABLE", "1")
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        let firefox = own_group(&mut firefox).spawn().expect("Firefox starts");
        let stream = TcpStream::connect(("127.0.0.1", port_in(profile))).expect("Firefox listens");
        let session = Self {
            stream: RefCell::new(BufReader::new(stream)),
        };
        session.read();
        let wanted = json!({ "timeouts": { "script": 120_000 } });
        session.ask(
            "NewSession",
            &json!({ "capabilities": { "alwaysMatch": wanted } }),
        );
        Some((firefox, session))
    }

    /// A command by its path in the protocol of web drivers.
    #[track_caller]
    pub(super) fn command(&self, name: &str, body: &Value) -> Value {
        let answer = self.ask(
            match name {
                "url" => "Navigate",
                "execute/async" => "ExecuteAsyncScript",
                "element" => "FindElement",
                "actions" => "PerformActions",
                other => panic!("Firefox knows no {other}"),
            },
            body,
        );
        // What has no other fields is the value itself.
        answer.get("value").cloned().unwrap_or(answer)
    }

    #[track_caller]
    fn ask(&self, name: &str, parameters: &Value) -> Value {
        let message = json!([0, 1, format!("WebDriver:{name}"), parameters]).to_string();
        let text = format!("{}:{message}", message.len());
        let sent = self.stream.borrow_mut().get_mut().write_all(text.as_bytes());
        sent.expect("Firefox reads");
        let answer = self.read();
        assert!(answer[2].is_null(), "{name}: {}", answer[2]);
        answer[3].clone()
    }

    /// A message.
    fn read(&self) -> Value {
        let mut stream = self.stream.borrow_mut();
        let mut length = Vec::new();
        stream.read_until(b':', &mut length).expect("Firefox answers");
        let length = str::from_utf8(&length)
            .ok()
            .and_then(|text| text.strip_suffix(':'));
        let length = length.and_then(|text| text.parse().ok());
        let mut message = vec![0; length.expect("a message has a length")];
        stream.read_exact(&mut message).expect("a message is whole");
        serde_json::from_slice(&message).expect("a message is JSON")
    }
}

/// The port that Firefox writes into its profile.
fn port_in(profile: &Path) -> u16 {
    for _ in 0..1200 {
        // The file may be there before its text.
        let text = std::fs::read_to_string(profile.join(PORT)).unwrap_or_default();
        if let Ok(port) = text.trim().parse() {
            return port;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    panic!("Firefox names no port");
}
