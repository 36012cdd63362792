//! Tests that cargo would leave out in silence: files that no test program names as a module, and tests or documentation examples in
//! a target whose manifest says that it has none.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::metadata::{Package, Target, own_packages};

pub(crate) fn check(root: &Path) -> Result<String> {
    let mut problems = Vec::new();
    let mut count = 0;
    for package in own_packages(root)? {
        for target in &package.targets {
            count += 1;
            problems.extend(left_out(&package, target)?);
        }
    }
    if !problems.is_empty() {
        bail!("{}", problems.join("\n"));
    }
    Ok(format!("cargo runs every test of {count} targets"))
}

/// What cargo leaves out of a target.
fn left_out(package: &Package, target: &Target) -> Result<Vec<String>> {
    let name = format!("{}, {} {}", package.name, target.kind, target.name);
    let mut problems = Vec::new();
    if target.kind == "test" && target.path.ends_with("main.rs") {
        for path in sources(target.folder()?)? {
            if path != target.path && !is_named(&path)? {
                problems.push(format!("{}: no module of {name}", path.display()));
            }
        }
    }
    if !matches!(target.kind.as_str(), "lib" | "bin") || (target.test && target.doctest) {
        return Ok(problems);
    }
    // A program beside a library is a single file.
    let has_library = package.targets.iter().any(|target| target.kind == "lib");
    let paths = if target.kind == "bin" && has_library {
        vec![target.path.clone()]
    } else {
        sources(target.folder()?)?
    };
    for path in paths {
        let text = read(&path)?;
        if !target.test && text.lines().any(|line| line.trim() == "#[test]") {
            problems.push(format!("{}: a test, but {name} has test = false", path.display()));
        }
        if target.kind == "lib" && !target.doctest && has_example(&text) {
            problems.push(format!(
                "{}: an example, but {name} has doctest = false",
                path.display()
            ));
        }
    }
    Ok(problems)
}

/// Whether the parent of a module names it.
fn is_named(path: &Path) -> Result<bool> {
    let is_folder = path.ends_with("mod.rs");
    let path = if is_folder {
        path.parent().context("a module in no folder")?
    } else {
        path
    };
    let name = path
        .file_stem()
        .and_then(|name| name.to_str())
        .context("a module without a name")?;
    let folder = path.parent().context("a module in no folder")?;
    for parent in [
        folder.join("main.rs"),
        folder.join("mod.rs"),
        folder.with_extension("rs"),
    ] {
        if parent.is_file() && names(&read(&parent)?, name) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Whether a source has the line `mod NAME;`, of any visibility.
fn names(text: &str, module: &str) -> bool {
    let declaration = format!("mod {module};");
    text.lines().any(|line| {
        line.trim().strip_suffix(&declaration).is_some_and(|visibility| {
            visibility.is_empty() || visibility.starts_with("pub") && visibility.ends_with(' ')
        })
    })
}

/// Whether documentation has an example in Rust.
fn has_example(text: &str) -> bool {
    let mut is_inside = false;
    for line in text.lines().map(str::trim) {
        let Some(line) = line.strip_prefix("///").or_else(|| line.strip_prefix("//!")) else {
            is_inside = false;
            continue;
        };
        let Some(language) = line.trim().strip_prefix("```") else {
            continue;
        };
        let is_rust = language
            .split(',')
            .all(|word| ["", "rust", "no_run", "should_panic", "compile_fail"].contains(&word.trim()));
        if !is_inside && is_rust {
            return true;
        }
        is_inside = !is_inside;
    }
    false
}

/// Rust files below a folder.
fn sources(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(sources(&path)?);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
    Ok(found)
}

fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_are_found_by_their_declarations() {
        let text = "//! mod other;\nmod near;\npub(crate) mod far;\n    mod inner {}\n";
        let found = ["near", "far", "other", "inner", "ear"].map(|name| names(text, name));
        assert_eq!(found, [true, true, false, false, false]);
    }

    #[test]
    fn only_examples_in_rust_count() {
        assert!(has_example("/// ```\n/// f();\n/// ```\n"));
        assert!(has_example("//! ```text\n//! a\n//! ```\n//!\n//! ```no_run\n"));
        assert!(!has_example("//! ```text\n//! a\n//! ```\nfn f() {}\n// ```\n"));
    }

    #[test]
    fn a_forgotten_module_a_hidden_test_and_a_hidden_example_are_found() {
        let folder = std::env::temp_dir().join(format!("splatvol-targets-{}", std::process::id()));
        let target = |kind: &str, path: &str, runs| Target {
            kind: kind.to_owned(),
            name: "it".to_owned(),
            path: folder.join(path),
            test: runs,
            doctest: runs,
        };
        std::fs::create_dir_all(folder.join("it/deep")).unwrap();
        std::fs::create_dir_all(folder.join("src")).unwrap();
        for (path, text) in [
            ("it/main.rs", "mod one;\nmod deep;\n"),
            ("it/one.rs", ""),
            ("it/two.rs", ""),
            ("it/deep/mod.rs", "mod three;\n"),
            ("it/deep/three.rs", ""),
            ("it/deep/four.rs", ""),
            (
                "src/lib.rs",
                "/// ```\n/// ```\nmod a {\n    #[test]\n    fn b() {}\n}\n",
            ),
        ] {
            std::fs::write(folder.join(path), text).unwrap();
        }
        let package = Package::default();
        let found = |target: &Target| {
            let mut found = left_out(&package, target).unwrap();
            found.sort();
            found
        };
        let modules = found(&target("test", "it/main.rs", true));
        let switched_off = found(&target("lib", "src/lib.rs", false));
        let switched_on = found(&target("lib", "src/lib.rs", true));
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(
            modules.len() == 2 && modules[0].contains("four.rs") && modules[1].contains("two.rs"),
            "{modules:?}"
        );
        assert!(
            switched_off.len() == 2 && switched_on.is_empty(),
            "{switched_off:?}"
        );
    }
}
