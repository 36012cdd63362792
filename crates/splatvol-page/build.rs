//! Includes the engine for browsers, if `cargo xtask web` has built it of these sources. Nothing is built here: programs
//! that write no pages need no compiler for WebAssembly.

#[path = "sources.rs"]
mod sources;

use std::path::{Path, PathBuf};

fn main() {
    let own = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let root = own.join("../..");
    let (engine, digest) = (
        own.join("engine/splatvol_web.wasm.gz"),
        own.join("engine/sources.txt"),
    );
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=engine");
    let code = match (engine.is_file(), std::fs::read_to_string(digest)) {
        (true, Ok(built)) => {
            for source in sources::SOURCES {
                println!("cargo::rerun-if-changed={}", root.join(source).display());
            }
            match sources::digest(&root, &sources::SOURCES) {
                Some(now) if now != built.trim() => "Err(Absent::OutOfDate)".to_owned(),
                _ => format!("Ok(include_bytes!({:?}))", engine.display().to_string()),
            }
        }
        _ => "Err(Absent::NotBuilt)".to_owned(),
    };
    let folder = std::env::var_os("OUT_DIR").unwrap_or_default();
    let file = Path::new(&folder).join("engine.rs");
    if let Err(error) = std::fs::write(&file, code) {
        println!("cargo::error={}: {error}", file.display());
    }
}
