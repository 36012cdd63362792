// Digests of the sources of modules for browsers, and places of built modules: an engine of other sources than the program's
// can draw other pictures. `build.rs`, `cargo xtask web`, `cargo xtask-webgpu` and the tests of its module share this file.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The crate of the engine and the readers for browsers.
pub(crate) const WEB: &str = "splatvol-web";
/// The crate of the GPU engine for browsers.
pub(crate) const WEBGPU: &str = "splatvol-webgpu";

/// The folder of `splatvol-page` with the engines of the last release, which are committed.
pub(crate) const COMMITTED: &str = "engine";
/// The folder of `splatvol-page` with engines that are built locally: a folder for each cargo profile.
pub(crate) const BUILT: &str = "built";
/// Names of the cargo profiles of modules: for users, and for tests, which is built sooner and runs slower.
pub(crate) const PROFILES: [&str; 2] = ["web", "web-dev"];
/// The module with the GPU engine's laws.
pub(crate) const LAWS: &str = "crates/splatvol-webgpu/module";

/// Files of the engine and the readers.
pub(crate) const WEB_FILES: [&str; 2] = ["splatvol_web.wasm.gz", "splatvol_readers.wasm.gz"];
/// Files of the GPU engine and its bindings.
pub(crate) const WEBGPU_FILES: [&str; 2] = ["splatvol_webgpu.wasm.gz", "splatvol_webgpu.js.gz"];

/// The file beside modules that says what they were built from.
pub(crate) fn note_of(name: &str) -> String {
    format!("{name}.txt")
}

/// The value of a key in a note: lines `key = value`.
pub(crate) fn noted<'a>(note: &'a str, key: &str) -> Option<&'a str> {
    let mut lines = note.lines().filter_map(|line| line.split_once('='));
    lines
        .find(|(name, _)| name.trim() == key)
        .map(|(_, value)| value.trim())
}

/// Files of the workspace that all modules depend on.
const WORKSPACE: [&str; 3] = ["Cargo.toml", "Cargo.lock", ".cargo/config.toml"];
/// Parts of a crate that its library is built from.
const PARTS: [&str; 4] = ["Cargo.toml", "build.rs", "src", "shaders"];

/// Files and folders that a crate of the workspace is built from, sorted; `None` outside the repository, as in a crate that
/// was packed.
pub(crate) fn sources(root: &Path, name: &str) -> Option<Vec<PathBuf>> {
    let mut sources: BTreeSet<PathBuf> = WORKSPACE.iter().map(|file| root.join(file)).collect();
    for name in closure(root, name)? {
        let folder = root.join("crates").join(name);
        sources.extend(
            PARTS
                .iter()
                .map(|part| folder.join(part))
                .filter(|part| part.exists()),
        );
    }
    Some(sources.into_iter().collect())
}

/// A crate and all crates of the workspace that it is built from.
pub(crate) fn closure(root: &Path, name: &str) -> Option<BTreeSet<String>> {
    let mut found = BTreeSet::new();
    let mut open = vec![name.to_owned()];
    while let Some(name) = open.pop() {
        let manifest = root.join("crates").join(&name).join("Cargo.toml");
        let manifest = std::fs::read_to_string(manifest).ok()?;
        if found.insert(name) {
            open.extend(dependencies(&manifest).map(str::to_owned));
        }
    }
    Some(found)
}

/// Crates of the workspace that a manifest depends on, for the library itself. Not optional ones: the crates of modules name
/// those that they need.
pub(crate) fn dependencies(manifest: &str) -> impl Iterator<Item = &str> {
    let mut counts = false;
    manifest.lines().filter_map(move |line| {
        if line.starts_with('[') {
            counts = line.ends_with("dependencies]") && !line.contains("dev-dependencies");
        }
        let name = line.split(['.', ' ', '=']).next()?;
        let is_own = name == "splatvol" || name.starts_with("splatvol-");
        (counts && is_own && !line.contains("optional = true")).then_some(name)
    })
}

/// The digest of all that a crate of the workspace is built from; `None` outside the repository.
///
/// It is FNV-1a with 64 bits: it must be the same on every machine and in every version of Rust, which the standard library's
/// hashers do not promise, and build scripts do without dependencies. It finds changes, not forgeries.
pub(crate) fn digest(root: &Path, name: &str) -> Option<String> {
    let mut files = Vec::new();
    for source in sources(root, name)? {
        collect(root, &source, &mut files)?;
    }
    // Separators of paths would sort differently.
    files.sort();
    let mut hash = Fnv::default();
    for (name, path) in files {
        let bytes = std::fs::read(path).ok()?;
        hash.add(name.as_bytes());
        hash.add(&[0]);
        // Git may have converted the ends of lines.
        bytes.split(|&byte| byte == b'\r').for_each(|part| hash.add(part));
        hash.add(&[0]);
    }
    Some(format!("{:016x}", hash.0))
}

/// Files below a path, with their names in the repository.
fn collect(root: &Path, path: &Path, files: &mut Vec<(String, PathBuf)>) -> Option<()> {
    if path.is_dir() {
        for entry in std::fs::read_dir(path).ok()? {
            collect(root, &entry.ok()?.path(), files)?;
        }
    } else {
        let parts = path.strip_prefix(root).ok()?.iter();
        let name: Option<Vec<&str>> = parts.map(|part| part.to_str()).collect();
        files.push((name?.join("/"), path.to_owned()));
    }
    Some(())
}

struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
