//! `cargo xtask wasm`: everything but the command builds for WebAssembly.
//!
//! If the target's std is not installed, the check is skipped with a message.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

const TARGET: &str = "wasm32-unknown-unknown";
/// The crates that run in a browser; they include those that they depend on.
const CRATES: [&str; 4] = ["splatvol", "splatvol-document", "splatvol-io", "splatvol-samples"];

/// Checks the crates for the target.
pub(crate) fn check(root: &Path) -> Result<String> {
    let Some(folder) = standard_library()? else {
        return Ok(format!(
            "skipped: std for {TARGET} is not installed (rustup target add {TARGET})"
        ));
    };
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .current_dir(root)
        .args(["check", "--locked", "--target", TARGET]);
    for name in CRATES {
        cargo.args(["--package", name]);
    }
    let status = cargo.status().context("cannot start cargo")?;
    ensure!(
        status.success(),
        "{} do not build for {TARGET}",
        CRATES.join(", ")
    );
    // A program that draws only given data can leave out readers and samples.
    let status = Command::new(env!("CARGO"))
        .current_dir(root)
        .args(["check", "--locked", "--target", TARGET])
        .args(["--package", "splatvol", "--no-default-features"])
        .status()
        .context("cannot start cargo")?;
    ensure!(
        status.success(),
        "splatvol without its features does not build for {TARGET}"
    );
    Ok(format!(
        "{} build for {TARGET}, by the std in {}",
        CRATES.join(", "),
        folder.display()
    ))
}

/// The folder of the target's std, if it is there.
fn standard_library() -> Result<Option<PathBuf>> {
    let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(&compiler)
        .args(["--print", "target-libdir", "--target", TARGET])
        .output()
        .context("cannot start the compiler")?;
    let folder = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
    let Ok(files) = folder.read_dir() else {
        return Ok(None);
    };
    let mut names = files.flatten().map(|file| file.file_name());
    let there = names.any(|name| name.to_string_lossy().starts_with("libstd-"));
    Ok(there.then_some(folder))
}
