//! `cargo xtask wasm`: everything but the command builds for WebAssembly (with `--least` only what the engine does not prove). `cargo xtask web`: builds the engine for
//! browsers, and the readers of files, which programs built after that include in their pages.
//!
//! If no Rust here has the target's std, either is skipped with a message.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::engines::{Modules, Wish};
use crate::sources::{PROFILES, WEB, WEB_FILES};
use crate::toolchain::{TARGET, Toolchain, not_found};

/// The crates that run in a browser; they include those that they depend on.
const CRATES: [&str; 5] = [
    "splatvol",
    "splatvol-document",
    "splatvol-io",
    "splatvol-samples",
    "splatvol-web",
];
/// A module of the crate for browsers.
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

/// Checks the crates for the target; with `least` only the library without its features: building the engine proves the rest.
pub(crate) fn check(root: &Path, least: bool) -> Result<String> {
    let Some(toolchain) = Toolchain::find(root)? else {
        return Ok(not_found());
    };
    let checked = match least {
        true => "splatvol without its features".to_owned(),
        false => CRATES.join(", "),
    };
    if !least {
        let mut all = check_of(&toolchain)?;
        all.args(["--features", "splatvol-web/module"]);
        for name in CRATES {
            all.args(["--package", name]);
        }
        run(all, || format!("{checked} do not build for {TARGET}"))?;
    }
    // A program that draws only given data can leave out readers and samples.
    let mut least = check_of(&toolchain)?;
    least.args(["--package", "splatvol", "--no-default-features"]);
    run(least, || {
        format!("splatvol without its features does not build for {TARGET}")
    })?;
    Ok(format!(
        "{checked}: built for {TARGET}, by the std in {}",
        toolchain.std.display()
    ))
}

/// `cargo check` by the profile of tests, whose build scripts and macros the modules share.
fn check_of(toolchain: &Toolchain) -> Result<Command> {
    let [_, for_tests] = PROFILES;
    let mut cargo = toolchain.cargo("check")?;
    cargo.args(["--profile", for_tests]);
    Ok(cargo)
}

/// Runs a command that must succeed.
pub(crate) fn run(mut command: Command, problem: impl Fn() -> String) -> Result<()> {
    let status = command.status().context("cannot start a program")?;
    ensure!(status.success(), "{}", problem());
    Ok(())
}

/// Builds the engine for browsers, and the readers.
pub(crate) fn engine(root: &Path, wish: Wish) -> Result<String> {
    let modules = Modules {
        name: WEB,
        files: WEB_FILES,
        build,
    };
    modules.run(root, wish)
}

fn build(toolchain: &Toolchain, profile: &str) -> Result<[Vec<u8>; 2]> {
    let mut cargo = toolchain.cargo("rustc")?;
    cargo
        .args(["--profile", profile])
        .args(["--package", WEB, "--features", "module"])
        .args(["--lib", "--crate-type", "staticlib"]);
    run(cargo, || format!("{WEB} does not build for {TARGET}"))?;
    let folder = toolchain.folder.join(TARGET).join(profile);
    let [engine, readers] = MODULES.map(|module| module.linked(toolchain, &folder));
    Ok([engine?, readers?])
}

impl Module {
    /// The module, of the library in a folder: what its exports reach. Cargo's own link would export every name of the crates that
    /// it depends on, and keep them: bindings to all of JavaScript, which nothing calls, and which would ask for imports.
    fn linked(&self, toolchain: &Toolchain, folder: &Path) -> Result<Vec<u8>> {
        let module = folder.join(format!("{}.wasm", self.name));
        let mut linker = Command::new(&toolchain.linker);
        linker
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
            .arg(&module);
        run(linker, || format!("{} does not link", self.name))?;
        let bytes = std::fs::read(&module).with_context(|| module.display().to_string())?;
        without_custom_sections(&bytes, self.imports)
    }
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
