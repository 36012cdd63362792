//! `docs/papers.md` against the repository: every item of the four papers names code, tests and experiments that are there, and the
//! counts at the top of the page are those of its rows.
//!
//! A row has six cells: the item, what it says, code, tests, experiments of the lab, and its state. Code and tests are
//! `` `PATH` `NAME` ``, several of them between semicolons, with paths below `crates`; `-` stands for none. The state is `right`,
//! or `partly` or `missing` with a reason behind a colon.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, bail};

/// The page.
const PAGE: &str = "docs/papers.md";
/// Items that the page has at least.
const LEAST: usize = 180;
const STATES: [&str; 3] = ["right", "partly", "missing"];

pub(crate) fn check(root: &Path) -> Result<String> {
    let read = |path: &str| std::fs::read_to_string(root.join(path)).with_context(|| path.to_owned());
    let (page, lab) = (read(PAGE)?, read("docs/lab.md")?);
    let headings: Vec<&str> = lab.lines().filter_map(|line| line.strip_prefix("### ")).collect();
    let mut problems = Vec::new();
    let mut counts = BTreeMap::<&str, [usize; 3]>::new();
    let mut paper = "";
    for (number, line) in (1..).zip(page.lines()) {
        if let Some(heading) = line.strip_prefix("## ") {
            paper = heading;
        }
        let Some(row) = Row::of(line) else { continue };
        let found = row.problems(root, &headings);
        problems.extend(
            found
                .into_iter()
                .map(|problem| format!("{PAGE}:{number}: {problem}")),
        );
        if let Some(state) = row.state_index() {
            counts.entry(paper).or_default()[state] += 1;
        }
    }
    for (paper, count) in &counts {
        let [right, partly, missing] = count;
        let expected = format!("| {paper} | {right} | {partly} | {missing} |");
        if !page.lines().any(|line| line == expected) {
            problems.push(format!(
                "{PAGE}: no row `{expected}`, which is the count of its items"
            ));
        }
    }
    let total: usize = counts.values().flatten().sum();
    if total < LEAST {
        problems.push(format!("{PAGE}: {total} items, expected at least {LEAST}"));
    }
    if !problems.is_empty() {
        bail!("{}", problems.join("\n"));
    }
    Ok(format!(
        "{total} items of {} papers are where the page says",
        counts.len()
    ))
}

/// An item of a paper.
#[derive(Debug)]
struct Row<'a> {
    code: &'a str,
    tests: &'a str,
    lab: &'a str,
    state: &'a str,
}

impl<'a> Row<'a> {
    /// The row of a line; `None` for other lines, headings of tables and rulers.
    fn of(line: &'a str) -> Option<Self> {
        let cells: Vec<&str> = line
            .strip_prefix('|')?
            .strip_suffix('|')?
            .split('|')
            .map(str::trim)
            .collect();
        let &[item, _, code, tests, lab, state] = cells.as_slice() else {
            return None;
        };
        (item != "item" && !item.starts_with('-')).then_some(Self {
            code,
            tests,
            lab,
            state,
        })
    }

    fn state_index(&self) -> Option<usize> {
        let word = self.state.split(':').next()?;
        STATES.iter().position(|state| *state == word)
    }

    fn problems(&self, root: &Path, headings: &[&str]) -> Vec<String> {
        let mut problems = Vec::new();
        match self.state_index() {
            None => problems.push(format!(
                "state {:?}, expected right, partly or missing",
                self.state
            )),
            Some(0) if self.code == "-" => problems.push("right, but no code is named".to_owned()),
            Some(1 | 2) if reason(self.state).is_empty() => {
                problems.push(format!("{}, but not why", self.state));
            }
            Some(_) => {}
        }
        problems.extend(places(self.code).filter_map(|place| place.problem(root, "")));
        for place in places(self.tests) {
            let keyword = if place.path.ends_with(".py") {
                "def "
            } else {
                "fn "
            };
            problems.extend(place.problem(root, keyword));
        }
        for link in self.lab.split("](lab.md#").skip(1) {
            let name = link.split(')').next().unwrap_or_default();
            if !headings.contains(&name) {
                problems.push(format!("docs/lab.md has no experiment {name}"));
            }
        }
        problems
    }
}

/// The words behind a state's colon.
fn reason(state: &str) -> &str {
    state.split_once(':').map_or("", |(_, reason)| reason.trim())
}

/// A name in a file.
#[derive(Debug, PartialEq)]
struct Place<'a> {
    path: &'a str,
    names: Vec<&'a str>,
}

/// The places of a cell: of each, a path and the names in that file.
fn places(cell: &str) -> impl Iterator<Item = Place<'_>> {
    cell.split(';').filter_map(|place| {
        let mut quoted = place.split('`').skip(1).step_by(2);
        Some(Place {
            path: quoted.next()?,
            names: quoted.collect(),
        })
    })
}

impl Place<'_> {
    /// What is wrong with it. `keyword`: what stands before each name.
    fn problem(&self, root: &Path, keyword: &str) -> Option<String> {
        let Ok(text) = std::fs::read_to_string(root.join("crates").join(self.path)) else {
            return Some(format!("crates/{}: cannot be read", self.path));
        };
        if self.names.is_empty() {
            return Some(format!("crates/{}: no name in it", self.path));
        }
        let missing = self
            .names
            .iter()
            .find(|name| !has_word(&text, &format!("{keyword}{name}")));
        missing.map(|name| format!("crates/{}: no `{keyword}{name}`", self.path))
    }
}

/// Whether a text has these words, and not as a part of longer ones.
fn has_word(text: &str, words: &str) -> bool {
    let of_name = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(words).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let after = text[at + words.len()..].chars().next();
        !before.is_some_and(of_name) && !after.is_some_and(of_name)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Another file than this one, whose own words are in it.
    const FILE: &str = "../xtask/src/main.rs";

    fn problems(row: &str) -> Vec<String> {
        Row::of(row)
            .expect("a row")
            .problems(&crate::root(), &["some-experiment"])
    }

    #[test]
    fn rows_are_read_and_other_lines_are_not() {
        assert!(Row::of("| item | what it says | code | test | lab | state |").is_none());
        assert!(Row::of("|---|---|---|---|---|---|").is_none());
        assert!(Row::of("| swan1997 | 1 | 2 | 3 |").is_none());
        assert!(Row::of("words").is_none());
        let row = format!(
            "| eq. 1 | a = b | `{FILE}` `Task` `root` | `{FILE}` `cargo_runs_every_test` | [x](lab.md#some-experiment) | right |"
        );
        assert_eq!(problems(&row), Vec::<String>::new());
    }

    #[test]
    fn what_is_not_there_is_said() {
        for (row, problem) in [
            (
                "| eq. 1 | a | `no/such.rs` `x` | - | - | right |".to_owned(),
                "cannot be read",
            ),
            (
                format!("| eq. 1 | a | `{FILE}` `Tas` | - | - | right |"),
                "no `Tas`",
            ),
            (format!("| eq. 1 | a | `{FILE}` | - | - | right |"), "no name"),
            (
                format!("| eq. 1 | a | `{FILE}` `Task` | `{FILE}` `Task` | - | right |"),
                "no `fn Task`",
            ),
            (
                format!("| eq. 1 | a | `{FILE}` `Task` | - | [x](lab.md#other) | right |"),
                "no experiment other",
            ),
            ("| eq. 1 | a | - | - | - | right |".to_owned(), "no code"),
            ("| eq. 1 | a | - | - | - | partly: |".to_owned(), "not why"),
            ("| eq. 1 | a | - | - | - | done |".to_owned(), "expected right"),
        ] {
            let found = problems(&row);
            assert!(found.len() == 1 && found[0].contains(problem), "{row}: {found:?}");
        }
    }
}
