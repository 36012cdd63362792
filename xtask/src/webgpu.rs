//! `cargo xtask-webgpu`: builds the module that shows the GPU engine's laws in browsers, with the JavaScript that it needs.
//!
//! If the target's std is not installed, it is skipped with a message.

#[path = "../../crates/splatvol-webgpu/sources.rs"]
mod of_module;

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use wasm_bindgen_cli_support::Bindgen;

use crate::wasm::{TARGET, not_installed, sources, standard_library, target_folder};

/// The package of the module.
const PACKAGE: &str = "splatvol-webgpu";

/// Builds the module, and puts it where its tests look for it.
pub(crate) fn build_module(root: &Path) -> Result<String> {
    let Some(folder) = standard_library()? else {
        return Ok(not_installed());
    };
    let digest = sources::digest(root, &of_module::SOURCES).context("the module's sources cannot be read")?;
    let status = Command::new(env!("CARGO"))
        .current_dir(root)
        .args(["rustc", "--locked", "--target", TARGET])
        .args(["--package", PACKAGE, "--lib", "--crate-type", "cdylib"])
        .status()
        .context("cannot start cargo")?;
    ensure!(status.success(), "{PACKAGE} does not build for {TARGET}");
    let built = target_folder(root)?.join(TARGET).join("debug");
    let place = root.join(of_module::PLACE);
    Bindgen::new()
        .input_path(built.join("splatvol_webgpu.wasm"))
        .web(true)?
        .typescript(false)
        .remove_name_section(true)
        .generate(&place)?;
    std::fs::write(place.join("sources.txt"), digest).with_context(|| place.display().to_string())?;
    Ok(format!(
        "the module is in {}, by the std in {}",
        of_module::PLACE,
        folder.display()
    ))
}
