//! The Rust that dependencies need against the `rust-version` of the workspace.

use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::metadata::{Platforms, packages};

pub(crate) fn check(root: &Path, platforms: Platforms) -> Result<String> {
    let packages = packages(root, platforms)?;
    let ours = packages.list.iter().find(|package| package.own);
    let ours = ours.and_then(|package| package.rust_version.as_deref());
    let promised = ours.context("the workspace states no rust-version")?;
    let limit = version(promised)?;
    let mut newer = Vec::new();
    for package in &packages.list {
        let needs = package.rust_version.as_deref().unwrap_or("1.0");
        if version(needs)? > limit {
            newer.push(format!("{} {} needs Rust {needs}", package.name, package.version));
        }
    }
    if !newer.is_empty() {
        bail!(
            "the workspace promises Rust {promised}, but\n{}",
            newer.join("\n")
        );
    }
    Ok(format!(
        "{} packages{} state no need beyond Rust {promised}",
        packages.list.len(),
        packages.note
    ))
}

/// Major, minor and patch; absent ones are 0.
fn version(text: &str) -> Result<[u32; 3]> {
    let mut numbers = [0; 3];
    for (number, part) in numbers.iter_mut().zip(text.split('.')) {
        *number = part.parse().with_context(|| format!("version {text:?}"))?;
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::version;

    #[test]
    fn versions_are_ordered_by_number() {
        assert!(version("1.100").unwrap() > version("1.89.1").unwrap());
        assert_eq!(version("1.6").unwrap(), version("1.6.0").unwrap());
        assert!(version("one").is_err());
    }
}
