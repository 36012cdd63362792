//! `cargo xtask-webgpu`: builds the GPU engine for browsers, with the JavaScript that it needs: the module that pages include,
//! and the one with its laws, which tests open.
//!
//! If the target's std is not installed, it is skipped with a message.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use wasm_bindgen_cli_support::Bindgen;

use crate::wasm::{PLACE, TARGET, not_installed, pack, sources, standard_library, target_folder};

/// The package of both modules.
const PACKAGE: &str = "splatvol-webgpu";

/// Builds the modules, and puts them where programs and tests look for them.
pub(crate) fn build_modules(root: &Path) -> Result<String> {
    let Some(folder) = standard_library()? else {
        return Ok(not_installed());
    };
    let said = build_for_pages(root)?;
    build_laws(root)?;
    Ok(format!(
        "{said}; the one with the laws is in {}; by the std in {}",
        sources::LAWS,
        folder.display()
    ))
}

/// The module with the laws.
fn build_laws(root: &Path) -> Result<()> {
    let digest =
        sources::digest(root, &sources::WEBGPU_SOURCES).context("the engine's sources cannot be read")?;
    let module = compiled(root, "debug", &["--profile", "dev"])?;
    let place = root.join(sources::LAWS);
    Bindgen::new()
        .input_path(module)
        .web(true)?
        .typescript(false)
        .remove_name_section(true)
        .generate(&place)?;
    std::fs::write(place.join("sources.txt"), digest).with_context(|| place.display().to_string())
}

/// The module that pages include, which is downloaded: as small as can be, with bindings that a worker runs as they are.
fn build_for_pages(root: &Path) -> Result<String> {
    let digest =
        sources::digest(root, &sources::WEBGPU_SOURCES).context("the engine's sources cannot be read")?;
    let place = root.join(PLACE);
    let of = place.join("webgpu-sources.txt");
    if std::fs::read_to_string(&of).is_ok_and(|built| built == digest) {
        return Ok("the module of pages is up to date".to_owned());
    }
    let module = compiled(root, "web", &["--profile", "web", "--no-default-features"])?;
    let mut output = Bindgen::new()
        .input_path(module)
        .no_modules(true)?
        .omit_default_module_path(true)
        .typescript(false)
        .remove_name_section(true)
        .remove_producers_section(true)
        .generate_output()?;
    ensure!(
        output.snippets().values().all(Vec::is_empty) && output.local_modules().is_empty(),
        "the module needs more JavaScript than its bindings"
    );
    let wasm = output.wasm_mut().emit_wasm();
    let bytes = pack(&place.join("splatvol_webgpu.wasm.gz"), &wasm)?;
    let bindings = pack(&place.join("splatvol_webgpu.js.gz"), output.js().as_bytes())?;
    std::fs::write(&of, digest).with_context(|| of.display().to_string())?;
    Ok(format!(
        "the module of pages has {} bytes, {bytes} in gzip, and its bindings {bindings}; programs built from now on include them",
        wasm.len()
    ))
}

/// Compiles a module; returns where it is.
fn compiled(root: &Path, profile: &str, arguments: &[&str]) -> Result<PathBuf> {
    let status = Command::new(env!("CARGO"))
        .current_dir(root)
        .args(["rustc", "--locked", "--target", TARGET])
        .args(["--package", PACKAGE, "--lib", "--crate-type", "cdylib"])
        .args(arguments)
        .status()
        .context("cannot start cargo")?;
    ensure!(status.success(), "{PACKAGE} does not build for {TARGET}");
    Ok(target_folder(root)?
        .join(TARGET)
        .join(profile)
        .join("splatvol_webgpu.wasm"))
}
