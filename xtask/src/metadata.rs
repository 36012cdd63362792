//! `cargo metadata`: the packages of the workspace and those it depends on.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde_json::Value;

/// The platforms whose dependencies are examined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Platforms {
    /// Dependencies on every platform; some of them may have to be downloaded. Without network, only those on this
    /// platform.
    All,
    /// Dependencies on this platform, which a build has downloaded.
    Host,
}

/// Cargo's metadata of one package.
#[derive(Debug, Default)]
pub(crate) struct Package {
    pub(crate) name: String,
    pub(crate) version: String,
    pub(crate) license: Option<String>,
    pub(crate) rust_version: Option<String>,
    /// Names of the dependencies other than those of tests and build scripts.
    pub(crate) dependencies: Vec<String>,
    /// Whether it belongs to the workspace.
    pub(crate) own: bool,
    pub(crate) targets: Vec<Target>,
}

/// What cargo builds of a package: a library, a program, a test program, ...
#[derive(Debug)]
pub(crate) struct Target {
    /// `lib`, `bin`, `test`, ...
    pub(crate) kind: String,
    pub(crate) name: String,
    /// Its first source.
    pub(crate) path: PathBuf,
    /// Whether its tests run.
    pub(crate) test: bool,
    /// Whether the examples in its documentation run.
    pub(crate) doctest: bool,
}

impl Target {
    /// The folder of its sources.
    pub(crate) fn folder(&self) -> Result<&Path> {
        self.path.parent().context("a source in no folder")
    }
}

/// Every package, and a note if some could not be examined.
#[derive(Debug)]
pub(crate) struct Packages {
    pub(crate) list: Vec<Package>,
    pub(crate) note: &'static str,
}

/// The workspace and all its dependencies.
pub(crate) fn packages(root: &Path, platforms: Platforms) -> Result<Packages> {
    if platforms == Platforms::All
        && let Ok(list) = query(root, &["--locked"])
    {
        return Ok(Packages {
            list,
            note: " of all platforms",
        });
    }
    let host = host()?;
    let list = query(root, &["--locked", "--offline", "--filter-platform", &host])?;
    Ok(Packages {
        list,
        note: " of this platform",
    })
}

/// The workspace's own packages.
pub(crate) fn own_packages(root: &Path) -> Result<Vec<Package>> {
    query(root, &["--no-deps", "--offline"])
}

fn query(root: &Path, arguments: &[&str]) -> Result<Vec<Package>> {
    let output = run(
        Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
            .args(["metadata", "--format-version", "1"])
            .args(arguments)
            .env("CARGO_NET_RETRY", "0")
            .current_dir(root),
    )?;
    let metadata: Value = serde_json::from_slice(&output).context("the output of cargo metadata")?;
    let packages = metadata["packages"]
        .as_array()
        .context("cargo metadata: no packages")?;
    packages.iter().map(package).collect()
}

fn package(value: &Value) -> Result<Package> {
    let text = |key: &str| value[key].as_str().map(str::to_owned);
    let declared = value["dependencies"]
        .as_array()
        .context("a package without dependencies")?;
    let dependencies = declared
        .iter()
        .filter(|dependency| dependency["kind"].is_null())
        .filter_map(|dependency| dependency["name"].as_str().map(str::to_owned))
        .collect();
    Ok(Package {
        name: text("name").context("a package without a name")?,
        version: text("version").context("a package without a version")?,
        license: text("license"),
        rust_version: text("rust_version"),
        dependencies,
        own: value["source"].is_null(),
        targets: value["targets"]
            .as_array()
            .context("a package without targets")?
            .iter()
            .map(target)
            .collect::<Result<_>>()?,
    })
}

fn target(value: &Value) -> Result<Target> {
    let text = |value: &Value| {
        value
            .as_str()
            .map(str::to_owned)
            .context("a target without a name")
    };
    Ok(Target {
        kind: text(&value["kind"][0])?,
        name: text(&value["name"])?,
        path: text(&value["src_path"])?.into(),
        test: value["test"].as_bool().unwrap_or(true),
        doctest: value["doctest"].as_bool().unwrap_or(true),
    })
}

/// The platform that rustc builds for.
fn host() -> Result<String> {
    let output = run(Command::new("rustc").arg("-vV"))?;
    let text = String::from_utf8(output)?;
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    Ok(host.context("rustc -vV names no host")?.to_owned())
}

/// Standard output of a command.
pub(crate) fn run(command: &mut Command) -> Result<Vec<u8>> {
    let output = command
        .output()
        .with_context(|| format!("cannot run {command:?}"))?;
    if !output.status.success() {
        bail!("{command:?}: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(output.stdout)
}
