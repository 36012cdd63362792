//! Development tasks of splatvol: checks of the repository that no compiler makes.
//!
//! | task | demands |
//! |---|---|
//! | `licenses` | every dependency may be used under a licence that `deny.toml` allows |
//! | `msrv` | no dependency needs a newer Rust than the workspace |
//! | `architecture` | `ARCHITECTURE.md` names every crate, its allowed dependencies, and every stage |
//! | `files` | no committed file names a machine's paths, no Rust file is too long, no link is broken |
//! | `targets` | cargo runs every test: no file of a test program is left out, no test lies where none is looked for |
//! | `papers` | `docs/papers.md` names code, tests and experiments that are there, and counts its items right |
//!
//! `cargo xtask` runs all of them, `cargo xtask NAME` one; `--offline` looks at the dependencies of this platform only.
//! Each is a test as well. `cargo xtask instructions [PROGRAM]`, which needs a release build, demands that the kernels'
//! machine code uses vectors as wide as promised, in the command or in any given program. `cargo xtask wasm` checks all
//! crates but the command for `wasm32-unknown-unknown`, where its std is installed (`scripts/wasm`). `cargo xtask web` builds the
//! engine for browsers and the readers of files, `cargo xtask-webgpu` the GPU engine for browsers and the module with its laws: with
//! `--dev` for tests, sooner and slower; with `--committed` for a release; with `--check` to compare with what is committed.

mod architecture;
mod decode;
mod engines;
mod files;
mod instructions;
mod licenses;
mod metadata;
mod msrv;
mod papers;
#[path = "../../crates/splatvol-page/sources.rs"]
#[cfg_attr(
    not(feature = "webgpu"),
    expect(dead_code, reason = "the sources of a module that is not built")
)]
mod sources;
mod spdx;
mod targets;
mod toolchain;
mod wasm;
#[cfg(feature = "webgpu")]
mod webgpu;

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use metadata::Platforms;

/// A check of the repository below a folder. It returns a description of the things checked.
struct Task {
    name: &'static str,
    run: fn(&Path, Platforms) -> Result<String>,
}

const TASKS: [Task; 6] = [
    Task {
        name: "licenses",
        run: licenses::check,
    },
    Task {
        name: "msrv",
        run: msrv::check,
    },
    Task {
        name: "architecture",
        run: |root, _| architecture::check(root),
    },
    Task {
        name: "files",
        run: |root, _| files::check(root),
    },
    Task {
        name: "targets",
        run: |root, _| targets::check(root),
    },
    Task {
        name: "papers",
        run: |root, _| papers::check(root),
    },
];

fn main() -> Result<()> {
    let mut wanted: Vec<String> = std::env::args().skip(1).collect();
    if wanted.first().is_some_and(|name| name == "instructions") {
        let program = wanted.get(1).map(String::as_str);
        println!("instructions: {}", instructions::check(&root(), program)?);
        return Ok(());
    }
    if wanted.first().is_some_and(|name| name == "wasm") {
        let least = wanted.get(1).is_some_and(|option| option == "--least");
        println!("wasm: {}", wasm::check(&root(), least)?);
        return Ok(());
    }
    if wanted.first().is_some_and(|name| name == "web") {
        println!(
            "web: {}",
            wasm::engine(&root(), engines::Wish::of(&wanted[1..])?)?
        );
        return Ok(());
    }
    #[cfg(feature = "webgpu")]
    if wanted.first().is_some_and(|name| name == "webgpu") {
        println!(
            "webgpu: {}",
            webgpu::engine(&root(), engines::Wish::of(&wanted[1..])?)?
        );
        return Ok(());
    }
    let offline = wanted.iter().position(|argument| argument == "--offline");
    let platforms = match offline.map(|position| wanted.remove(position)) {
        Some(_) => Platforms::Host,
        None => Platforms::All,
    };
    if let Some(unknown) = wanted
        .iter()
        .find(|name| TASKS.iter().all(|task| task.name != **name))
    {
        let names = TASKS.map(|task| task.name).join(", ");
        bail!("unknown task {unknown}: the tasks are {names}, instructions, wasm, web");
    }
    for task in &TASKS {
        if wanted.is_empty() || wanted.iter().any(|name| name == task.name) {
            println!("{}: {}", task.name, (task.run)(&root(), platforms)?);
        }
    }
    Ok(())
}

/// The repository's root.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("xtask lies in the repository")
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pass(name: &str) {
        let task = TASKS.iter().find(|task| task.name == name).unwrap();
        match (task.run)(&root(), Platforms::Host) {
            Ok(summary) => println!("{summary}"),
            Err(error) => panic!("{error:#}"),
        }
    }

    #[test]
    fn licenses_of_dependencies_are_allowed() {
        pass("licenses");
    }

    #[test]
    fn dependencies_build_with_the_oldest_rust_that_we_promise() {
        pass("msrv");
    }

    #[test]
    fn cargo_runs_every_test() {
        pass("targets");
    }

    #[test]
    fn architecture_names_every_crate_and_stage() {
        pass("architecture");
    }

    #[test]
    fn items_of_the_papers_are_where_the_page_says() {
        pass("papers");
    }

    #[test]
    fn committed_files_are_clean() {
        pass("files");
    }
}
