// A digest of all that a module for browsers is built from: an engine that is older than the program's own would make
// other pictures. `build.rs`, `cargo xtask web`, `cargo xtask-webgpu` and the tests of its module share this file.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

/// Files and folders of the engine for browsers, in the repository.
pub(crate) const SOURCES: [&str; 11] = [
    "Cargo.toml",
    "Cargo.lock",
    ".cargo/config.toml",
    "crates/splatvol",
    "crates/splatvol-core",
    "crates/splatvol-cpu",
    "crates/splatvol-document",
    "crates/splatvol-io",
    "crates/splatvol-samples",
    "crates/splatvol-scene",
    "crates/splatvol-web",
];

/// Where the module with the GPU engine's laws is, in the repository.
pub(crate) const LAWS: &str = "crates/splatvol-webgpu/module";

/// Files and folders of the GPU engine for browsers, in the repository.
pub(crate) const WEBGPU_SOURCES: [&str; 14] = [
    "Cargo.toml",
    "Cargo.lock",
    ".cargo/config.toml",
    "crates/splatvol",
    "crates/splatvol-core",
    "crates/splatvol-cpu",
    "crates/splatvol-document",
    "crates/splatvol-gpu",
    "crates/splatvol-gpu/shaders",
    "crates/splatvol-io",
    "crates/splatvol-samples",
    "crates/splatvol-scene",
    "crates/splatvol-web",
    "crates/splatvol-webgpu",
];

/// The digest of files, of crates and of other folders in a repository; `None` where there are none, as in a crate that was
/// packed.
pub(crate) fn digest(root: &Path, sources: &[&str]) -> Option<String> {
    let mut files = Vec::new();
    for source in sources {
        let path = root.join(source);
        match path.join("src").is_dir() {
            true => {
                files.push(path.join("Cargo.toml"));
                collect(&path.join("src"), &mut files)?;
            }
            false if path.is_dir() => collect(&path, &mut files)?,
            false => files.push(path),
        }
    }
    files.sort();
    let mut hasher = DefaultHasher::new();
    for file in files {
        file.strip_prefix(root).ok()?.to_str()?.hash(&mut hasher);
        std::fs::read(&file).ok()?.hash(&mut hasher);
    }
    Some(format!("{:016x}", hasher.finish()))
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Option<()> {
    for entry in std::fs::read_dir(folder).ok()? {
        let path = entry.ok()?.path();
        match path.is_dir() {
            true => collect(&path, files)?,
            false => files.push(path),
        }
    }
    Some(())
}
