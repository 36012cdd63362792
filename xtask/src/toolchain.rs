//! A Rust that can target browsers. It need not be the compiler of native builds, which `scripts/wasm` leaves as it is.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

pub(crate) const TARGET: &str = "wasm32-unknown-unknown";
/// The compiler to use instead of any that is found.
const COMPILER: &str = "SPLATVOL_WASM_RUSTC";
/// Where `scripts/wasm` puts a compiler, in the repository.
const MADE: &str = ".wasm-toolchain/bin/rustc";
/// The environment variable by which cargo and this program are given a linker.
const LINKER: &str = "CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER";
/// `cargo run` puts the libraries of its compiler there, in which another compiler would find the std of that one.
const LIBRARIES: &str = "LD_LIBRARY_PATH";

/// A compiler with the target's std, and a linker.
#[derive(Debug)]
pub(crate) struct Toolchain {
    /// The compiler, where it is not that of native builds.
    other: Option<OsString>,
    /// The folder of the target's std.
    pub(crate) std: PathBuf,
    /// The linker, in any of its flavours.
    pub(crate) linker: PathBuf,
    /// Where it builds: two compilers in one folder would build everything in turns.
    pub(crate) folder: PathBuf,
    /// The repository.
    root: PathBuf,
}

impl Toolchain {
    /// The first of: the compiler of [`COMPILER`], the one in use, the one of `scripts/wasm`. `None` where none has the std.
    pub(crate) fn find(root: &Path) -> Result<Option<Self>> {
        let compilers = match std::env::var_os(COMPILER) {
            Some(compiler) => vec![Some(compiler)],
            None => vec![None, Some(root.join(MADE).into_os_string())],
        };
        for other in compilers {
            if let Some(std) = std_of(&program(other.as_ref())) {
                let folder = target_folder(root)?.join("wasm");
                return Ok(Some(Self {
                    linker: linker(other.as_ref())?,
                    other,
                    std,
                    folder,
                    root: root.to_owned(),
                }));
            }
        }
        Ok(None)
    }

    /// Cargo, in the repository, for the target. No path of this machine stays in a module: neither of the repository, nor of
    /// what is built, nor of the crates that were downloaded.
    pub(crate) fn cargo(&self, command: &str) -> Result<Command> {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.current_dir(&self.root);
        cargo.args([command, "--locked", "--target", TARGET, "--target-dir"]);
        cargo.arg(&self.folder);
        let mut flags = vec![
            renamed(&self.root, "/splatvol")?,
            renamed(&self.folder, "/target")?,
        ];
        for registry in registries() {
            flags.push(renamed(&registry, "/crates")?);
        }
        // Added to those of .cargo/config.toml, which variables of the environment would replace.
        let flags = serde_json::to_string(&flags)?;
        cargo.args(["--config", &format!("target.{TARGET}.rustflags={flags}")]);
        cargo
            .env_remove("RUSTFLAGS")
            .env_remove("CARGO_ENCODED_RUSTFLAGS");
        cargo.env_remove(LIBRARIES);
        if let Some(other) = &self.other {
            cargo.env("RUSTC", other);
        }
        cargo.env(LINKER, &self.linker);
        Ok(cargo)
    }

    /// Version of the compiler, and of its code generator.
    pub(crate) fn compiler(&self) -> Result<String> {
        let said = said_by(program(self.other.as_ref()), &["--version", "--verbose"])?;
        let line = |start: &str| said.lines().find_map(|line| line.strip_prefix(start));
        let version = said.lines().next().context("the compiler has no version")?;
        let llvm = line("LLVM version: ").context("the compiler names no LLVM")?;
        Ok(format!("{version}, LLVM {llvm}"))
    }

    /// Version of the linker.
    pub(crate) fn linker_version(&self) -> Result<String> {
        let said = said_by(self.linker.as_os_str(), &["-flavor", "wasm", "--version"])?;
        let words: Vec<&str> = said.split_whitespace().take(2).collect();
        Ok(words.join(" "))
    }
}

/// Why nothing was built.
pub(crate) fn not_found() -> String {
    format!("skipped: no Rust here has a std for {TARGET}: scripts/wasm (Debian: rustc-web, rust-web-src)")
}

/// A compiler: another one, or that of native builds.
fn program(other: Option<&OsString>) -> OsString {
    let own = || std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    other.cloned().unwrap_or_else(own)
}

/// The folder of the target's std, if a compiler is there and has it.
fn std_of(compiler: &OsString) -> Option<PathBuf> {
    let said = said_by(compiler, &["--print", "target-libdir", "--target", TARGET]).ok()?;
    let folder = PathBuf::from(said.trim());
    let mut names = folder.read_dir().ok()?.flatten().map(|file| file.file_name());
    let there = names.any(|name| name.to_string_lossy().starts_with("libstd-"));
    there.then_some(folder)
}

/// The linker that is asked for, or that of a compiler.
fn linker(other: Option<&OsString>) -> Result<PathBuf> {
    if let Some(linker) = std::env::var_os(LINKER) {
        return Ok(linker.into());
    }
    let compiler = program(other);
    let said = said_by(&compiler, &["--print", "target-libdir"])?;
    let beside = |path: &Path| Some(path.parent()?.join("bin").join("rust-lld"));
    let places = [
        Path::new(&compiler).with_file_name("rust-lld"),
        beside(Path::new(said.trim())).unwrap_or_default(),
    ];
    let found = places.into_iter().find(|place| place.is_file());
    Ok(found.unwrap_or_else(|| "rust-lld".into()))
}

fn said_by(program: impl AsRef<std::ffi::OsStr>, arguments: &[&str]) -> Result<String> {
    let name = program.as_ref().to_string_lossy().into_owned();
    let output = Command::new(program)
        .args(arguments)
        .env_remove(LIBRARIES)
        .output()
        .with_context(|| format!("cannot start {name}"))?;
    ensure!(output.status.success(), "{name} fails");
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Where cargo builds.
fn target_folder(root: &Path) -> Result<PathBuf> {
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

/// Folders of downloaded crates, one for each registry.
fn registries() -> Vec<PathBuf> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let user = || std::env::home_dir().map(|home| home.join(".cargo"));
    let sources = home.or_else(user).map(|home| home.join("registry").join("src"));
    let folders = sources.and_then(|sources| sources.read_dir().ok());
    let mut found: Vec<PathBuf> = folders
        .into_iter()
        .flatten()
        .flatten()
        .map(|at| at.path())
        .collect();
    found.sort();
    found
}

/// The flag that writes a folder as another.
fn renamed(folder: &Path, name: &str) -> Result<String> {
    let folder = folder.to_str().context("a folder's name is no text")?;
    Ok(format!("--remap-path-prefix={folder}={name}"))
}
