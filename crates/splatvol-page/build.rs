//! Includes the engines and the readers for browsers, if `cargo xtask web` and `cargo xtask-webgpu` have built them of these sources.
//! Nothing is built here: programs that write no pages need no compiler for WebAssembly.

#[path = "sources.rs"]
#[expect(dead_code, reason = "the place of a module that is not included")]
mod sources;

use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=engine");
    let (engine, readers) = ("splatvol_web.wasm.gz", "splatvol_readers.wasm.gz");
    let code = match is_built(&[engine, readers], ("sources.txt", &sources::SOURCES)) {
        Some(true) => format!("Ok([{}, {}])", included(engine), included(readers)),
        Some(false) => "Err(Absent::OutOfDate)".to_owned(),
        None => "Err(Absent::NotBuilt)".to_owned(),
    };
    write("engine.rs", &code);
    let (module, bindings) = ("splatvol_webgpu.wasm.gz", "splatvol_webgpu.js.gz");
    let digest = ("webgpu-sources.txt", &sources::WEBGPU_SOURCES[..]);
    let code = match is_built(&[module, bindings], digest) {
        Some(true) => format!(
            "Some(WebGpu {{ module: {}, bindings: {} }})",
            included(module),
            included(bindings)
        ),
        _ => "None".to_owned(),
    };
    write("webgpu.rs", &code);
}

fn package() -> PathBuf {
    PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default())
}

fn engine(name: &str) -> PathBuf {
    package().join("engine").join(name)
}

fn included(name: &str) -> String {
    format!("include_bytes!({:?})", engine(name).display().to_string())
}

/// Whether files were built of these sources; nothing where they were not built. A crate that was packed has no sources to be
/// compared with.
fn is_built(names: &[&str], (digest, sources): (&str, &[&str])) -> Option<bool> {
    let built = std::fs::read_to_string(engine(digest)).ok()?;
    names.iter().all(|name| engine(name).is_file()).then_some(())?;
    let root = package().join("../..");
    for source in sources {
        println!("cargo::rerun-if-changed={}", root.join(source).display());
    }
    Some(sources::digest(&root, sources).is_none_or(|now| now == built.trim()))
}

fn write(name: &str, code: &str) {
    let folder = std::env::var_os("OUT_DIR").unwrap_or_default();
    let file = Path::new(&folder).join(name);
    if let Err(error) = std::fs::write(&file, code) {
        println!("cargo::error={}: {error}", file.display());
    }
}
