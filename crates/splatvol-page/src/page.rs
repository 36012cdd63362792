//! The page of a document.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use sha2::{Digest, Sha256};
use splatvol_web::ItemData;

use crate::PageError;
use crate::engine::{WebGpu, engine};
use crate::template::{Slot, fill};

const TEMPLATE: &str = include_str!("../player/page.html");
const STYLE: &str = include_str!("../player/style.css");

/// The part of the player's script that has nothing to do with its page: instances of the engine (`engine.js`), and drafts and final
/// pictures on a canvas (`frames.js`). Notebooks use it.
pub const ENGINE_SCRIPT: &str = concat!(
    include_str!("../player/engine.js"),
    include_str!("../player/frames.js"),
    include_str!("../player/webgpu.js")
);

/// The player's script, with a part of its own.
macro_rules! script {
    ($own:expr) => {
        concat!(
            "\"use strict\";\n(() => {\n",
            include_str!("../player/engine.js"),
            $own,
            include_str!("../player/camera.js"),
            include_str!("../player/frames.js"),
            include_str!("../player/controls.js"),
            include_str!("../player/webgpu.js"),
            include_str!("../player/files.js"),
            include_str!("../player/player.js"),
            "})();\n"
        )
    };
}

/// The script of a page alone, which connects to nothing.
const SCRIPT: &str = script!("");
/// The script of a page from a server.
const SERVED: &str = script!(include_str!("../player/server.js"));

fn script(is_served: bool) -> &'static str {
    if is_served { SERVED } else { SCRIPT }
}

/// What a page shows.
#[derive(Debug)]
pub struct Page<'a> {
    /// Its title.
    pub title: &'a str,
    /// What its picture shows, for those who cannot see it.
    pub description: &'a str,
    /// The document, with nothing left open: its items are in memory.
    pub document: &'a Value,
    /// What the bytes are, for each item.
    pub data: &'a [ItemData],
    /// The packed data of all items, gzip.
    pub bytes: &'a [u8],
    /// The picture until the engine has one, a PNG.
    pub poster: &'a [u8],
    /// Sentences about the data: what was left out, and how far the picture is from that of all data.
    pub notes: &'a [String],
    /// The readers, with which the page opens files of whoever has it; empty if it opens none.
    pub readers: &'a [u8],
    /// The GPU engine, which draws what moves where the browser has WebGPU.
    pub webgpu: Option<WebGpu>,
    /// Whether it comes from a server that makes the final pictures; all of them where there is no engine in the page.
    pub is_served: bool,
}

impl Page<'_> {
    /// The page, HTML.
    ///
    /// # Errors
    /// Programs without the engine for browsers.
    pub fn html(&self) -> Result<String, PageError> {
        match engine() {
            Ok(engine) => self.with_engine(engine),
            Err(_) if self.is_served => self.with_engine(&[]),
            Err(absent) => Err(absent.into()),
        }
    }

    fn with_engine(&self, engine: &[u8]) -> Result<String, PageError> {
        let facts = serde_json::json!({
            "document": self.document,
            "data": self.data,
            "notes": self.notes,
            "served": self.is_served,
        });
        let policy = policy(self.is_served);
        let none = WebGpu {
            module: &[],
            bindings: &[],
        };
        // It has the data of the engine beside it.
        let webgpu = self.webgpu.filter(|_| !engine.is_empty()).unwrap_or(none);
        fill(
            TEMPLATE,
            &[
                ("policy", Slot::Text(&policy)),
                ("title", Slot::Text(self.title)),
                ("description", Slot::Text(self.description)),
                ("version", Slot::Text(env!("CARGO_PKG_VERSION"))),
                ("style", Slot::Code(STYLE)),
                ("script", Slot::Code(script(self.is_served))),
                ("poster", Slot::Bytes(self.poster)),
                ("facts", Slot::Json(&facts)),
                ("engine", Slot::Bytes(engine)),
                ("readers", Slot::Bytes(self.readers)),
                ("webgpu-bindings", Slot::Bytes(webgpu.bindings)),
                ("webgpu", Slot::Bytes(webgpu.module)),
                ("samples", Slot::Bytes(self.bytes)),
            ],
        )
    }

    /// Bytes of the page without samples.
    ///
    /// # Errors
    /// See [`Page::html`].
    pub fn overhead(&self) -> Result<u64, PageError> {
        let empty = Page { bytes: &[], ..*self };
        Ok(empty.html()?.len() as u64)
    }

    /// Bytes of gzip that fit into a page of so many bytes whose rest takes `overhead` bytes.
    pub fn room(most: u64, overhead: u64) -> u64 {
        most.saturating_sub(overhead) / 4 * 3
    }
}

/// The content policy: no connection to anything but the server that it may come from; the page's own script and style by
/// their hashes, workers and pictures of its own making, WebAssembly.
fn policy(is_served: bool) -> String {
    let connections = if is_served { "connect-src 'self'; " } else { "" };
    let hash = |code: &str| STANDARD.encode(Sha256::digest(code.as_bytes()));
    format!(
        "default-src 'none'; script-src 'sha256-{}' 'wasm-unsafe-eval'; worker-src blob:; style-src 'sha256-{}'; \
         img-src data:; {connections}base-uri 'none'; form-action 'none'",
        hash(script(is_served)),
        hash(STYLE)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(title: &str) -> String {
        let document = serde_json::json!({ "item": [{ "file": "</script><img src=x>" }] });
        let page = Page {
            title,
            description: "A \"picture\"",
            document: &document,
            data: &[],
            bytes: b"samples",
            poster: b"poster",
            notes: &["8 bits & less".to_owned()],
            readers: &[],
            webgpu: None,
            is_served: false,
        };
        page.with_engine(b"engine").unwrap()
    }

    #[test]
    fn whatever_a_title_or_a_name_says_is_text() {
        let plain = page("head");
        let nasty = page("</title><script>alert(1)</script>\"'&");
        assert_eq!(plain.matches("<script").count(), nasty.matches("<script").count());
        assert_eq!(plain.matches("<img").count(), 1);
        assert!(nasty.contains("&lt;/title&gt;&lt;script&gt;") && !nasty.contains("alert(1)</script>"));
    }

    #[test]
    fn the_policy_forbids_connections_and_knows_the_code_by_its_hash() {
        let page = page("head");
        let policy = policy(false).replace('\'', "&#39;");
        assert!(page.contains(&format!("content=\"{policy}\"")), "{policy}");
        assert!(policy.starts_with("default-src &#39;none&#39;;"));
        for forbidden in [
            "http:",
            "https:",
            "*",
            "unsafe-inline",
            "connect-src",
            "&#39;unsafe-eval",
        ] {
            assert!(!policy.contains(forbidden), "{forbidden}");
        }
        // The browser hashes what stands between the tags.
        let script = page
            .rsplit_once("</script>")
            .unwrap()
            .0
            .rsplit_once("<script>")
            .unwrap()
            .1;
        assert_eq!(script, SCRIPT);
        let style = page
            .split_once("<style>")
            .unwrap()
            .1
            .split_once("</style>")
            .unwrap()
            .0;
        assert_eq!(style, STYLE);
    }

    #[test]
    fn nothing_in_the_page_names_another_host() {
        for text in [TEMPLATE, STYLE, SCRIPT] {
            for word in ["http:", "https:", "//cdn", "@import", "url("] {
                assert!(!text.contains(word), "{word}");
            }
        }
        for word in [
            "fetch(",
            "XMLHttpRequest",
            "WebSocket",
            "sendBeacon",
            "importScripts",
            "innerHTML",
            "eval(",
        ] {
            assert!(!SCRIPT.contains(word), "{word}");
        }
    }

    #[test]
    fn the_room_for_samples_is_what_base64_leaves() {
        let room = Page::room(1000, 200);
        assert_eq!(room, 600);
        assert!(STANDARD.encode(vec![0; room as usize]).len() <= 800);
        assert_eq!(Page::room(100, 200), 0);
    }
}
