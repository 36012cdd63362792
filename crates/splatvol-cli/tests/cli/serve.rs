//! The server of the command: a browser that was given the address sees the command's picture.

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::browser::{Browser, Kind};
use crate::sandbox::{Sandbox, png};

/// A server that ends with the test.
struct Serving(Child);

impl Drop for Serving {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Serving {
    /// Starts one; its address.
    fn start(sandbox: &Sandbox, arguments: &str) -> (Self, String) {
        let child = Command::new(env!("CARGO_BIN_EXE_splatvol"))
            .arg("serve")
            .args(arguments.split_whitespace())
            .args(["--url-file", "url"])
            .current_dir(sandbox.path(""))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the command was built");
        let serving = Self(child);
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs(60) {
            // The file may be there before its text.
            let url = std::fs::read_to_string(sandbox.path("url")).unwrap_or_default();
            if url.ends_with('\n') {
                return (serving, url.trim().to_owned());
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        panic!("the server does not say where it is");
    }
}

#[test]
fn browsers_see_the_commands_picture_and_turn_it() {
    for kind in Kind::ALL {
        if let Some(browser) = Browser::start(kind, [900, 700]) {
            sees_the_commands_picture_and_turns_it(&browser);
        }
    }
}

fn sees_the_commands_picture_and_turns_it(browser: &Browser) {
    let sandbox = Sandbox::new();
    turns_the_commands_picture(browser, &sandbox, "sample:head:64 --view front --size 240x200");
}

/// The volume has more samples than the memory holds.
#[test]
fn browsers_see_a_volume_that_is_read_in_chunks() {
    let Some(browser) = Browser::start(Kind::ALL[0], [900, 700]) else {
        return;
    };
    let sandbox = Sandbox::new();
    sandbox.run("convert sample:head:320 head.ome.zarr").succeeds();
    let picture = "head.ome.zarr --view front --size 240x200 --memory 90MiB";
    turns_the_commands_picture(&browser, &sandbox, picture);
}

fn turns_the_commands_picture(browser: &Browser, sandbox: &Sandbox, picture: &str) {
    sandbox.run(&format!("render {picture} -o head.png")).succeeds();
    let (_serving, url) = Serving::start(sandbox, picture);
    let (_, _, expected) = png(&sandbox.path("head.png"));
    browser.visit(&url);
    let trouble = || browser.promised("document.getElementById('trouble').textContent");
    let shown = |size| browser.picture(size);
    let without_alpha = |pixels: &[u8]| -> Vec<u8> {
        pixels
            .chunks_exact(4)
            .flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
            .collect()
    };
    let first = shown([240, 200]);
    assert!(without_alpha(&first) == expected, "{}", trouble());
    browser.promised("splatvol.settled()");
    browser.drag("#view", [120, 40]);
    browser.promised("splatvol.settled()");
    assert!(shown([240, 200]) != first, "a drag turns nothing");
    assert_eq!(trouble(), "");
    // The token is no longer in the address.
    let address = browser.promised("location.href");
    assert!(
        !address.as_str().is_some_and(|address| address.contains("token")),
        "{address}"
    );
}

#[test]
fn what_cannot_be_served_is_refused_by_name() {
    let sandbox = Sandbox::new();
    sandbox.run("serve missing.nrrd").fails(3, &["missing.nrrd"]);
    sandbox
        .run("serve sample:head:16 --bits 16")
        .fails(2, &["--bits 16", "cannot show"]);
    sandbox
        .run("serve sample:head:16 --bind 203.0.113.7")
        .fails(2, &["203.0.113.7"]);
}
