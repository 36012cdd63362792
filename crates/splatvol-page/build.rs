//! Includes the engines and the readers for browsers: those that `cargo xtask web` and `cargo xtask-webgpu` have built of these
//! sources, or the committed ones. Nothing is built here: no user needs a compiler for WebAssembly.

#[path = "sources.rs"]
#[expect(dead_code, reason = "the place of a module that is not included")]
mod sources;

use std::path::{Path, PathBuf};

use sources::{BUILT, COMMITTED, PROFILES, WEB, WEB_FILES, WEBGPU, WEBGPU_FILES};

fn main() {
    let own = ["build.rs", "sources.rs", BUILT, COMMITTED].map(|name| package().join(name));
    // `None` where this crate was packed without the others, and with engines of its own version.
    let others = sources::sources(&root(), WEBGPU).unwrap_or_default();
    for watched in own.iter().chain(&others).filter(|path| path.exists()) {
        println!("cargo::rerun-if-changed={}", watched.display());
    }
    let web = best(WEB, WEB_FILES);
    let code = match &web {
        Some(Module {
            files, is_current, ..
        }) => {
            let [engine, readers] = files;
            format!("Ok(Modules {{ engine: {engine}, readers: {readers}, is_current: {is_current} }})")
        }
        None => "Err(Absent)".to_owned(),
    };
    write("engine.rs", &code);
    let gpu = best(WEBGPU, WEBGPU_FILES);
    // An older one goes only with an engine as old: both hear the same messages.
    let fits = |gpu: &Module| {
        gpu.is_current
            || web
                .as_ref()
                .is_some_and(|web| !web.is_current && web.folder == gpu.folder)
    };
    let code = match gpu.filter(fits) {
        Some(Module {
            files: [module, bindings],
            ..
        }) => {
            format!("Some(WebGpu {{ module: {module}, bindings: {bindings} }})")
        }
        None => "None".to_owned(),
    };
    write("webgpu.rs", &code);
}

/// Modules as code that includes them.
struct Module {
    folder: PathBuf,
    files: [String; 2],
    /// Whether they were built of the program's own sources.
    is_current: bool,
}

/// The modules to include: the first of these sources; else the first.
fn best(name: &str, files: [&str; 2]) -> Option<Module> {
    let now = sources::digest(&root(), name);
    let module = |folder: &PathBuf| {
        let note = std::fs::read_to_string(folder.join(sources::note_of(name))).ok()?;
        let files = files.map(|file| folder.join(file));
        files.iter().all(|file| file.is_file()).then_some(())?;
        Some(Module {
            folder: folder.clone(),
            files: files.map(|file| format!("include_bytes!({:?})", file.display().to_string())),
            is_current: now
                .as_deref()
                .is_none_or(|now| sources::noted(&note, "sources") == Some(now)),
        })
    };
    let [for_users, for_tests] = PROFILES.map(|profile| package().join(BUILT).join(profile));
    let places = [for_users, package().join(COMMITTED)];
    let mut modules: Vec<Module> = places.iter().filter_map(module).collect();
    if let Some(current) = modules.iter().position(|module| module.is_current) {
        return Some(modules.swap_remove(current));
    }
    // It draws slowly, so that only development builds have it.
    let is_development = std::env::var("PROFILE").is_ok_and(|profile| profile == "debug");
    let of_tests = is_development.then(|| module(&for_tests)).flatten();
    of_tests
        .filter(|module| module.is_current)
        .or_else(|| modules.into_iter().next())
}

fn package() -> PathBuf {
    PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default())
}

/// The repository, if this crate lies in it.
fn root() -> PathBuf {
    package().join("../..")
}

fn write(name: &str, code: &str) {
    let folder = std::env::var_os("OUT_DIR").unwrap_or_default();
    let file = Path::new(&folder).join(name);
    if let Err(error) = std::fs::write(&file, code) {
        println!("cargo::error={}: {error}", file.display());
    }
}
