//! Browsers without a window.

mod chromedriver;
mod marionette;

use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use chromedriver::Chromedriver;
use marionette::Marionette;

/// Longer than any page takes to run its script.
const PATIENCE: Duration = Duration::from_secs(60);

/// A kind of browser.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Chromium,
    /// Chromium with WebGPU, on a device that it imitates itself.
    ChromiumWithGpu,
    Firefox,
}

impl Kind {
    /// Those that show pages without WebGPU.
    pub(crate) const ALL: [Self; 2] = [Self::Chromium, Self::Firefox];

    /// What has to be installed for it.
    fn needs(self) -> &'static str {
        match self {
            Self::Chromium | Self::ChromiumWithGpu => {
                "Chromium and its driver (Debian: chromium, chromium-driver)"
            }
            // It shows what Chromium shows; scripts/browsers does not install it.
            Self::Firefox => "Firefox",
        }
    }
}

/// How a browser is told what to do.
enum Session {
    Chromium(Chromedriver),
    Firefox(Marionette),
}

/// A browser with one page.
pub(crate) struct Browser {
    /// The browser or its driver, which leads a group of processes.
    program: Child,
    session: Session,
    _profile: tempfile::TempDir,
}

/// A program by its name.
fn program(names: &[&str]) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let places =
        std::env::split_paths(&path).flat_map(|folder| names.iter().map(move |name| folder.join(name)));
    places.into_iter().find(|place| place.is_file())
}

/// Gives what is started a group of its own, so that all of it can be ended.
fn own_group(command: &mut Command) -> &mut Command {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    command
}

impl Browser {
    /// Starts a browser; says so, and gives `None`, where it is not installed.
    pub(crate) fn start(kind: Kind, size: [u32; 2]) -> Option<Self> {
        let profile = tempfile::tempdir().expect("the system has a temporary folder");
        let started = match kind {
            Kind::Chromium | Kind::ChromiumWithGpu => {
                Chromedriver::start(size, kind == Kind::ChromiumWithGpu, profile.path())
                    .map(|(program, session)| (program, Session::Chromium(session)))
            }
            Kind::Firefox => Marionette::start(size, profile.path())
                .map(|(program, session)| (program, Session::Firefox(session))),
        };
        let Some((program, session)) = started else {
            splatvol_recorded::skip(&format!("not installed: {}", kind.needs()));
            return None;
        };
        Some(Self {
            program,
            session,
            _profile: profile,
        })
    }

    /// Opens a file.
    pub(crate) fn open(&self, page: &Path) {
        self.visit(&format!("file://{}", page.display()));
    }

    /// Opens an address, and waits until its script has run: a driver may answer before it has.
    #[track_caller]
    pub(crate) fn visit(&self, url: &str) {
        // So that the page of before is not taken for it.
        self.promised("(window.splatvol = undefined, 0)");
        self.command("url", &json!({ "url": url }));
        self.wait_until("typeof window.splatvol === 'object'");
    }

    /// Waits until an expression of the page is true.
    #[track_caller]
    pub(crate) fn wait_until(&self, expression: &str) {
        let start = Instant::now();
        while self.promised(expression) != true {
            assert!(start.elapsed() < PATIENCE, "it stays false: {expression}");
            std::thread::sleep(Duration::from_millis(20));
        }
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
        self.pixels(&format!("splatvol.picture({width}, {height})"))
    }

    /// RGBA of what a script's promise becomes.
    #[track_caller]
    pub(crate) fn pixels(&self, image: &str) -> Vec<u8> {
        use base64::Engine;
        let text = self.promised(&format!(
            "{image}.then((image) => {{ let text = ''; const size = 3 << 13; \
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

    /// Drops files and folders of the disk on a place of the page, as a user does; `false` where no driver can.
    #[track_caller]
    pub(crate) fn drop_files(&self, paths: &[&Path], [x, y]: [u32; 2]) -> bool {
        if !matches!(self.session, Session::Chromium(_)) {
            return false;
        }
        let data = json!({ "items": [], "files": paths, "dragOperationsMask": 1 });
        for kind in ["dragEnter", "dragOver", "drop"] {
            let event = json!({ "type": kind, "x": x, "y": y, "data": data });
            self.command(
                "goog/cdp/execute",
                &json!({ "cmd": "Input.dispatchDragEvent", "params": event }),
            );
        }
        true
    }

    /// Presses a key on what has the focus.
    pub(crate) fn press(&self, key: &str) {
        let actions = json!([{ "type": "keyDown", "value": key }, { "type": "keyUp", "value": key }]);
        self.command(
            "actions",
            &json!({ "actions": [{ "type": "key", "id": "keys", "actions": actions }] }),
        );
    }

    /// Addresses that pages of files asked for since the last call; of Chromium only.
    pub(crate) fn requests(&self) -> Vec<String> {
        let Session::Chromium(session) = &self.session else {
            return Vec::new();
        };
        let log = session.command("se/log", &json!({ "type": "performance" }));
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

    #[track_caller]
    fn command(&self, name: &str, body: &Value) -> Value {
        match &self.session {
            Session::Chromium(session) => session.command(name, body),
            Session::Firefox(session) => session.command(name, body),
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Ends the program with its group; either may have ended already.
        let group = format!("-{}", self.program.id());
        let _ = Command::new("kill").args(["-KILL", "--", &group]).status();
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}
