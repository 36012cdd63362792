//! `cargo xtask-webgpu`: builds the GPU engine for browsers, with the JavaScript that it needs: the module that pages include,
//! and the one with its laws, which tests open.
//!
//! If no Rust here has the target's std, it is skipped with a message.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use wasm_bindgen_cli_support::Bindgen;

use crate::engines::{Modules, Wish};
use crate::sources::{LAWS, PROFILES, WEBGPU, WEBGPU_FILES, digest};
use crate::toolchain::{TARGET, Toolchain};
use crate::wasm::run;

/// Builds the modules, and puts them where programs and tests look for them.
pub(crate) fn engine(root: &Path, wish: Wish) -> Result<String> {
    let modules = Modules {
        name: WEBGPU,
        files: WEBGPU_FILES,
        build,
    };
    let said = modules.run(root, wish)?;
    // The laws are tested, not shipped.
    let toolchain = Toolchain::find(root)?.filter(|_| matches!(wish, Wish::Built(_)));
    let Some(toolchain) = toolchain else {
        return Ok(said);
    };
    let laws = build_laws(root, &toolchain)?;
    Ok(format!("{said}; {laws}"))
}

/// The module with the laws, unless it is there.
fn build_laws(root: &Path, toolchain: &Toolchain) -> Result<String> {
    let digest = digest(root, WEBGPU).context("the engine's sources cannot be read")?;
    let place = root.join(LAWS);
    let note = place.join("sources.txt");
    if std::fs::read_to_string(&note).is_ok_and(|built| built == digest) {
        return Ok("the module with the laws is up to date".to_owned());
    }
    let [_, for_tests] = PROFILES;
    Bindgen::new()
        .input_path(compiled(toolchain, for_tests)?)
        .web(true)?
        .typescript(false)
        .remove_name_section(true)
        .generate(&place)?;
    std::fs::write(note, digest).with_context(|| place.display().to_string())?;
    Ok(format!("the one with the laws is in {LAWS}"))
}

/// The module that pages include, with bindings that a worker runs as they are.
fn build(toolchain: &Toolchain, profile: &str) -> Result<[Vec<u8>; 2]> {
    let mut output = Bindgen::new()
        .input_path(compiled(toolchain, profile)?)
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
    Ok([output.wasm_mut().emit_wasm(), output.js().as_bytes().to_vec()])
}

/// Compiles a module; returns where it is. For users without the laws, as it is downloaded; one for tests has all.
fn compiled(toolchain: &Toolchain, profile: &str) -> Result<PathBuf> {
    let [for_users, _] = PROFILES;
    let mut cargo = toolchain.cargo("rustc")?;
    cargo
        .args(["--profile", profile])
        .args(["--package", WEBGPU, "--lib", "--crate-type", "cdylib"]);
    if profile == for_users {
        cargo.arg("--no-default-features");
    }
    run(cargo, || format!("{WEBGPU} does not build for {TARGET}"))?;
    Ok(toolchain
        .folder
        .join(TARGET)
        .join(profile)
        .join("splatvol_webgpu.wasm"))
}
