//! `cargo xtask wasm`: everything but the command builds for WebAssembly. `cargo xtask web`: builds the engine for
//! browsers, and the readers of files, which programs built after that include in their pages.
//!
//! If the target's std is not installed, either is skipped with a message.

#[path = "../../crates/splatvol-page/sources.rs"]
#[cfg_attr(
    not(feature = "webgpu"),
    expect(dead_code, reason = "the sources of a module that is not built")
)]
pub(crate) mod sources;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use flate2::Compression;
use flate2::write::GzEncoder;

pub(crate) const TARGET: &str = "wasm32-unknown-unknown";
/// The crates that run in a browser; they include those that they depend on.
const CRATES: [&str; 5] = [
    "splatvol",
    "splatvol-document",
    "splatvol-io",
    "splatvol-samples",
    "splatvol-web",
];
/// The package of the modules for browsers.
const PACKAGE: &str = "splatvol-web";
/// A module of the package.
struct Module {
    /// Its name, and that of its file.
    name: &'static str,
    /// What JavaScript calls.
    exports: [&'static str; 2],
    /// How many functions it imports of the page.
    imports: usize,
}
const MODULES: [Module; 2] = [
    Module {
        name: "splatvol_web",
        exports: ["splatvol_message", "splatvol_answer"],
        imports: 0,
    },
    Module {
        name: "splatvol_readers",
        exports: ["splatvol_message", "splatvol_read"],
        imports: 1,
    },
];
/// Where programs look for the engine, in the repository.
pub(crate) const PLACE: &str = "crates/splatvol-page/engine";

/// Checks the crates for the target.
pub(crate) fn check(root: &Path) -> Result<String> {
    let Some(folder) = standard_library()? else {
        return Ok(not_installed());
    };
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .current_dir(root)
        .args(["check", "--locked", "--target", TARGET]);
    cargo.args(["--features", "splatvol-web/module"]);
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

pub(crate) fn not_installed() -> String {
    format!("skipped: std for {TARGET} is not installed (rustup target add {TARGET})")
}

/// Builds the engine for browsers, and the readers, and puts them where programs look for them.
pub(crate) fn build_engine(root: &Path) -> Result<String> {
    let Some(folder) = standard_library()? else {
        return Ok(not_installed());
    };
    let digest = sources::digest(root, &sources::SOURCES).context("the engine's sources cannot be read")?;
    let place = root.join(PLACE);
    let packed = MODULES.map(|module| place.join(format!("{}.wasm.gz", module.name)));
    let sources = place.join("sources.txt");
    let is_up_to_date = std::fs::read_to_string(&sources).is_ok_and(|sources| sources == digest);
    if is_up_to_date && packed.iter().all(|module| module.is_file()) {
        return Ok("the engine and the readers for browsers are up to date".to_owned());
    }
    let status = Command::new(env!("CARGO"))
        .current_dir(root)
        .args(["rustc", "--locked", "--profile", "web", "--target", TARGET])
        .args(["--package", PACKAGE, "--features", "module"])
        .args(["--lib", "--crate-type", "staticlib"])
        .status()
        .context("cannot start cargo")?;
    ensure!(status.success(), "{PACKAGE} does not build for {TARGET}");
    let built = target_folder(root)?.join(TARGET).join("web");
    let mut said = Vec::new();
    for (module, packed) in MODULES.iter().zip(&packed) {
        let bytes = without_custom_sections(&module.linked(&built)?, module.imports)?;
        let in_gzip = pack(packed, &bytes)?;
        said.push(format!(
            "{} has {} bytes, {in_gzip} in gzip",
            module.name,
            bytes.len()
        ));
    }
    std::fs::write(&sources, digest).with_context(|| sources.display().to_string())?;
    Ok(format!(
        "{}; by the std in {}; programs built from now on include them",
        said.join(", "),
        folder.display()
    ))
}

/// Writes bytes as gzip; returns how many it has.
pub(crate) fn pack(path: &Path, bytes: &[u8]) -> Result<usize> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::best());
    gzip.write_all(bytes)?;
    let packed = gzip.finish()?;
    std::fs::write(path, &packed).with_context(|| path.display().to_string())?;
    Ok(packed.len())
}

impl Module {
    /// The module, of the library in a folder: what its exports reach. Cargo's own link would export every name of the crates that
    /// it depends on, and keep them: bindings to all of JavaScript, which nothing calls, and which would ask for imports.
    fn linked(&self, folder: &Path) -> Result<Vec<u8>> {
        let module = folder.join(format!("{}.wasm", self.name));
        let status = Command::new(linker()?)
            .args([
                "-flavor",
                "wasm",
                "--no-entry",
                "--gc-sections",
                "--strip-all",
                "-O2",
            ])
            .args(["--allow-undefined", "--stack-first", "-z", "stack-size=1048576"])
            .args(self.exports.map(|name| format!("--export={name}")))
            .arg(folder.join("libsplatvol_web.a"))
            .arg("-o")
            .arg(&module)
            .status()
            .context("cannot start the linker")?;
        ensure!(status.success(), "{} does not link", self.name);
        std::fs::read(&module).with_context(|| module.display().to_string())
    }
}

/// The linker that is asked for, or the one of the compiler.
fn linker() -> Result<PathBuf> {
    if let Some(linker) = std::env::var_os("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER") {
        return Ok(linker.into());
    }
    let output = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
        .args(["--print", "target-libdir"])
        .output()
        .context("cannot start the compiler")?;
    let libraries = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
    let linker = libraries.with_file_name("bin").join("rust-lld");
    Ok(if linker.is_file() {
        linker
    } else {
        "rust-lld".into()
    })
}

/// Length of a WebAssembly module's magic number and version.
const HEAD: usize = 8;

/// A module without its custom sections, which nothing reads, and which imports so many functions.
fn without_custom_sections(module: &[u8], imports: usize) -> Result<Vec<u8>> {
    const CUSTOM: u8 = 0;
    const IMPORTS: u8 = 2;
    ensure!(module.starts_with(b"\0asm"), "it is no WebAssembly module");
    let mut kept = module[..HEAD].to_vec();
    let mut rest = &module[HEAD..];
    let mut imported = 0;
    while let [kind, after @ ..] = rest {
        let (length, digits) = leb128(after).context("a section has no length")?;
        let end = 1 + digits + length;
        ensure!(end <= rest.len(), "a section ends beyond the module");
        if *kind == IMPORTS {
            let (count, _) = leb128(&after[digits..]).context("imports have no number")?;
            imported += count;
        }
        if *kind != CUSTOM {
            kept.extend_from_slice(&rest[..end]);
        }
        rest = &rest[end..];
    }
    ensure!(
        imported == imports,
        "the module imports {imported} functions, not {imports}"
    );
    Ok(kept)
}

/// A number in 7-bit groups, the lowest first, and how many bytes it takes.
fn leb128(bytes: &[u8]) -> Option<(usize, usize)> {
    let mut number = 0;
    for (place, byte) in bytes.iter().take(5).enumerate() {
        number |= usize::from(byte & 0x7f) << (7 * place);
        if byte & 0x80 == 0 {
            return Some((number, place + 1));
        }
    }
    None
}

/// Where cargo builds.
pub(crate) fn target_folder(root: &Path) -> Result<PathBuf> {
    let output = Command::new(env!("CARGO"))
        .current_dir(root)
        .args(["metadata", "--locked", "--no-deps", "--format-version", "1"])
        .output()
        .context("cannot start cargo")?;
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).context("cargo metadata")?;
    let folder = metadata["target_directory"]
        .as_str()
        .context("cargo metadata names no target folder")?;
    Ok(PathBuf::from(folder))
}

/// The folder of the target's std, if it is there.
pub(crate) fn standard_library() -> Result<Option<PathBuf>> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn custom_sections_are_left_out_and_imports_are_counted() {
        let head = b"\0asm\x01\0\0\0";
        let (types, custom): (&[u8], &[u8]) = (&[1, 2, 9, 9], &[0, 0x83, 0, 7, 7, 7]);
        let module = [head, custom, types, custom].concat();
        assert_eq!(
            without_custom_sections(&module, 0).unwrap(),
            [head, types].concat()
        );
        let nothing = [&head[..], &[2, 1, 0]].concat();
        assert_eq!(without_custom_sections(&nothing, 0).unwrap(), nothing);
        let imports = [&head[..], &[2, 2, 1, 0]].concat();
        assert!(without_custom_sections(&imports, 0).is_err());
        assert_eq!(without_custom_sections(&imports, 1).unwrap(), imports);
        for broken in [
            &b"wasm"[..],
            &[&head[..], &[1, 9, 0]].concat(),
            &[&head[..], &[1]].concat(),
        ] {
            assert!(without_custom_sections(broken, 0).is_err());
        }
    }
}
