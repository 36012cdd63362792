//! Committed files: no paths of one machine, no long Rust files, no broken links.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::metadata::run;

/// Paths that exist on one machine only. Written in halves, so that this file may be committed.
const MACHINE_PATHS: [&str; 3] = [
    concat!("/ro", "ot/"),
    concat!("/ho", "me/"),
    concat!("/wo", "rk/"),
];

/// Largest number of lines of a Rust file, so that one person can keep it in mind.
const MAX_LINES: usize = 600;

pub(crate) fn check(root: &Path) -> Result<String> {
    let output = run(Command::new("git").args(["ls-files", "-z"]).current_dir(root))?;
    let list = String::from_utf8(output).context("the names of committed files")?;
    let mut problems = Vec::new();
    let mut count = 0;
    for name in list.split_terminator('\0') {
        let path = root.join(name);
        // Deleted, but not yet committed.
        if !path.is_file() {
            continue;
        }
        count += 1;
        let bytes = std::fs::read(&path).with_context(|| name.to_owned())?;
        // Pictures and test data have no lines.
        let Ok(text) = String::from_utf8(bytes) else {
            continue;
        };
        problems.extend(machine_paths(&text).map(|problem| format!("{name}:{problem}")));
        let lines = text.lines().count();
        if name.ends_with(".rs") && lines > MAX_LINES {
            problems.push(format!("{name}: {lines} lines; at most {MAX_LINES}"));
        }
        if name.ends_with(".md") {
            // A link to a README elsewhere is read where it lies.
            let path = path.canonicalize().with_context(|| name.to_owned())?;
            let folder = path.parent().unwrap_or(root);
            let dead = links(&text).filter(|link| !leads_somewhere(&folder.join(link)));
            problems.extend(dead.map(|link| format!("{name}: the link {link} leads nowhere")));
        }
    }
    if count == 0 {
        bail!("git lists no files");
    }
    if !problems.is_empty() {
        bail!("{}", problems.join("\n"));
    }
    Ok(format!("{count} committed files are clean"))
}

fn machine_paths(text: &str) -> impl Iterator<Item = String> {
    text.lines().enumerate().filter_map(|(i, line)| {
        let path = MACHINE_PATHS.iter().find(|path| line.contains(**path))?;
        Some(format!("{}: the path {path} of one machine", i + 1))
    })
}

/// Whether a link's target lies in a clean clone. What git ignores is made by a build, and that build checks it.
fn leads_somewhere(target: &Path) -> bool {
    let folder = target.parent().filter(|folder| folder.is_dir());
    target.exists()
        || Command::new("git")
            .args(["check-ignore", "--quiet", "--"])
            .arg(target)
            .current_dir(folder.unwrap_or(Path::new(".")))
            .status()
            .is_ok_and(|status| status.success())
}

/// Targets of Markdown links to files, without the section.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
        .filter(|link| !link.contains("://") && !link.starts_with("data:") && !link.contains(' '))
        .filter_map(|link| link.split('#').next())
        .filter(|link| !link.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn machine_paths_are_found_by_line() {
        let text = format!("fine\nat {}x\n", MACHINE_PATHS[0]);
        let found: Vec<String> = machine_paths(&text).collect();
        assert!(found.len() == 1 && found[0].starts_with("2:"), "{found:?}");
        assert_eq!(machine_paths("../shared/data\n").count(), 0);
    }

    #[test]
    fn only_links_to_files_are_followed() {
        let text = "[a](docs/a.md#part) [b](https://x.y/z) [c](#here) ![d](d.png) f(x)[0](no link)";
        assert_eq!(links(text).collect::<Vec<_>>(), ["docs/a.md", "d.png"]);
    }
}
