//! The licences of all dependencies against the list in `deny.toml`.
//!
//! If `cargo deny` is installed, it checks them too, and advisories besides. This check needs nothing but cargo.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::metadata::{Platforms, packages};
use crate::spdx;

pub(crate) fn check(root: &Path, platforms: Platforms) -> Result<String> {
    let configuration = std::fs::read_to_string(root.join("deny.toml")).context("deny.toml")?;
    let allowed = allowed(&configuration)?;
    let packages = packages(root, platforms)?;
    let mut refused = Vec::new();
    for package in &packages.list {
        let license = package.license.as_deref().unwrap_or("none");
        let accepted = spdx::satisfied(license, &|name| allowed.contains(name))
            .with_context(|| format!("{} {}", package.name, package.version))?;
        if !accepted {
            refused.push(format!("{} {}: {license}", package.name, package.version));
        }
    }
    if !refused.is_empty() {
        bail!("licences that deny.toml does not allow:\n{}", refused.join("\n"));
    }
    Ok(format!(
        "{} packages{} are allowed",
        packages.list.len(),
        packages.note
    ))
}

/// The strings of the list `allow` in `deny.toml`, one per line as taplo writes it.
fn allowed(configuration: &str) -> Result<BTreeSet<String>> {
    let list: BTreeSet<String> = configuration
        .lines()
        .skip_while(|line| line.trim() != "allow = [")
        .skip(1)
        .take_while(|line| line.trim() != "]")
        .filter_map(|line| line.split('"').nth(1).map(str::to_owned))
        .collect();
    if list.is_empty() {
        bail!("deny.toml: no list `allow = [`");
    }
    Ok(list)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_ends_where_it_ends() {
        let list = allowed("[licenses]\nallow = [\n  \"MIT\", # both\n  \"Zlib\",\n]\n\"GPL\"\n").unwrap();
        assert_eq!(list.into_iter().collect::<Vec<_>>(), ["MIT", "Zlib"]);
        assert!(allowed("[licenses]").is_err());
    }
}
