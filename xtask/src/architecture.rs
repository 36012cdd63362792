//! `ARCHITECTURE.md` against the workspace.
//!
//! The first table below "## Crates" has a row per crate: its name, its contents, and the crates of the workspace
//! that it may use. The engines of `splatvol-cpu` know nothing of each other. Modules of stages are named anywhere
//! as `` `splatvol_core::NAME` ``, `` `sheets::NAME` ``, `` `splats::NAME` `` and `` `classic::NAME` ``.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::metadata::{Package, own_packages};

pub(crate) fn check(root: &Path) -> Result<String> {
    let read = |path: &str| std::fs::read_to_string(root.join(path)).with_context(|| path.to_owned());
    let text = read("ARCHITECTURE.md")?;
    let packages = own_packages(root)?;
    let mut problems = crate_problems(&text, &packages);
    let mut stages = 0;
    for (prefix, declaration, file) in [
        ("splatvol_core::", "pub mod ", "crates/splatvol-core/src/lib.rs"),
        (
            "sheets::",
            "pub(crate) mod ",
            "crates/splatvol-cpu/src/sheets/mod.rs",
        ),
        ("splats::", "mod ", "crates/splatvol-cpu/src/splats/mod.rs"),
        ("classic::", "mod ", "crates/splatvol-cpu/src/classic/mod.rs"),
    ] {
        let source = read(file)?;
        let modules = modules(&source, declaration);
        if modules.is_empty() {
            bail!("{file} declares no `{declaration}`");
        }
        stages += modules.len();
        problems.extend(module_problems(&text, prefix, &modules));
    }
    for engine in ENGINES {
        let folder = root.join("crates/splatvol-cpu/src").join(engine);
        for file in rust_files(&folder)? {
            let source = std::fs::read_to_string(&file).with_context(|| file.display().to_string())?;
            let strays = imports_of_others(engine, &source);
            problems
                .extend(strays.map(|other| format!("{}: `{engine}` may not use `{other}`", file.display())));
        }
    }
    if !problems.is_empty() {
        bail!("ARCHITECTURE.md:\n{}", problems.join("\n"));
    }
    Ok(format!(
        "{} crates and {stages} modules of stages are described",
        packages.len()
    ))
}

/// The engines of `splatvol-cpu`, which know nothing of each other.
const ENGINES: [&str; 3] = ["sheets", "splats", "classic"];

/// The other engines that a file of one of them names.
fn imports_of_others<'a>(engine: &str, source: &'a str) -> impl Iterator<Item = &'static str> + use<'a> {
    let others = ENGINES.into_iter().filter(move |other| *other != engine);
    let others: Vec<_> = others.collect();
    others
        .into_iter()
        .filter(|other| source.contains(&format!("crate::{other}::")))
}

/// All Rust files below a folder.
fn rust_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            files.extend(rust_files(&path)?);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn crate_problems(text: &str, packages: &[Package]) -> Vec<String> {
    let rows = crate_rows(text);
    let names: BTreeSet<&str> = packages.iter().map(|package| package.name.as_str()).collect();
    let mut problems: Vec<String> = rows
        .keys()
        .filter(|name| !names.contains(**name))
        .map(|name| format!("`{name}` is no crate of the workspace"))
        .collect();
    for package in packages {
        let dependencies = package.dependencies.iter().map(String::as_str);
        let uses: BTreeSet<&str> = dependencies.filter(|name| names.contains(name)).collect();
        match rows.get(package.name.as_str()) {
            None => problems.push(format!("no row for the crate `{}`", package.name)),
            Some(may) => {
                let strays = uses.difference(may);
                problems.extend(strays.map(|other| format!("`{}` may not use `{other}`", package.name)));
            }
        }
    }
    problems
}

/// Crates and their allowed dependencies, from the table below "## Crates".
fn crate_rows(text: &str) -> BTreeMap<&str, BTreeSet<&str>> {
    text.lines()
        .skip_while(|line| *line != "## Crates")
        .skip(1)
        .take_while(|line| !line.starts_with("## "))
        .filter_map(|line| {
            let cells: Vec<&str> = line.strip_prefix('|')?.split('|').collect();
            let name = code(cells.first()?).into_iter().next()?;
            Some((name, code(cells.get(2)?)))
        })
        .collect()
}

/// The text between backticks.
fn code(cell: &str) -> BTreeSet<&str> {
    cell.split('`').skip(1).step_by(2).collect()
}

fn modules<'a>(source: &'a str, declaration: &str) -> BTreeSet<&'a str> {
    source
        .lines()
        .filter_map(|line| line.strip_prefix(declaration)?.strip_suffix(';'))
        .filter(|module| *module != "tests")
        .collect()
}

fn module_problems(text: &str, prefix: &str, modules: &BTreeSet<&str>) -> Vec<String> {
    let named: BTreeSet<&str> = text
        .split('`')
        .skip(1)
        .step_by(2)
        .filter_map(|code| code.strip_prefix(prefix))
        .collect();
    let missing = modules
        .difference(&named)
        .map(|name| format!("`{prefix}{name}` is missing"));
    let stale = named
        .difference(modules)
        .map(|name| format!("`{prefix}{name}` does not exist"));
    missing.chain(stale).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# A\n## Crates\n| crate | holds | may use |\n|---|---|---|\n| `one` | x | - |\n\
                        | `two` | `y` | `one` |\n## Stages\n| a | `sheets::a` | `splatvol_core::b` |\n";

    fn package(name: &str, dependencies: &[&str]) -> Package {
        Package {
            name: name.to_owned(),
            version: "0.1.0".to_owned(),
            license: None,
            rust_version: None,
            dependencies: dependencies.iter().map(|&name| name.to_owned()).collect(),
            own: true,
            targets: Vec::new(),
        }
    }

    #[test]
    fn a_complete_table_passes() {
        let packages = [package("one", &["serde"]), package("two", &["one", "serde"])];
        assert_eq!(crate_problems(TEXT, &packages), Vec::<String>::new());
    }

    #[test]
    fn missing_and_stale_rows_and_stray_uses_are_found() {
        let all = [
            package("one", &[]),
            package("two", &["one"]),
            package("three", &[]),
        ];
        assert_eq!(crate_problems(TEXT, &all), ["no row for the crate `three`"]);
        let wrong = crate_problems(TEXT, &[package("one", &["two"]), package("two", &[])]);
        assert_eq!(wrong, ["`one` may not use `two`"]);
        assert_eq!(
            crate_problems(TEXT, &all[..1]),
            ["`two` is no crate of the workspace"]
        );
    }

    #[test]
    fn engines_that_know_each_other_are_found() {
        let source = "use crate::sheets::place::Place;\nuse crate::splats::Cloud;\n";
        assert_eq!(
            imports_of_others("sheets", source).collect::<Vec<_>>(),
            ["splats"]
        );
        assert_eq!(
            imports_of_others("splats", source).collect::<Vec<_>>(),
            ["sheets"]
        );
    }

    #[test]
    fn missing_and_stale_modules_are_found() {
        let modules = modules(
            "mod private;\npub(crate) mod a;\npub(crate) mod c;\n",
            "pub(crate) mod ",
        );
        assert_eq!(
            module_problems(TEXT, "sheets::", &modules),
            ["`sheets::c` is missing"]
        );
        let none = BTreeSet::from(["x"]);
        assert_eq!(module_problems(TEXT, "splatvol_core::", &none).len(), 2);
    }
}
