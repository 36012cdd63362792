//! A group's index: figures and tables as the paper numbers them, then sections, each with its experiments; our own
//! experiments by their titles.

use crate::{FigureEntry, Finding, Run, Verdict, experiments, papers};

/// The index of a group.
pub(super) struct Index {
    /// Heads of the columns.
    pub(super) heads: &'static [&'static str],
    /// Lines.
    pub(super) entries: Vec<Entry>,
}

/// A line of it.
pub(super) struct Entry {
    /// Subject: as many cells as there are heads before those of experiments and numbers.
    pub(super) about: Vec<String>,
    /// The experiments, and whether they are in this report.
    pub(super) experiments: Vec<(&'static str, bool)>,
    /// Summary of the verdicts on its numbers.
    pub(super) standing: String,
}

impl Index {
    /// The index of a group in the report of these runs.
    pub(super) fn of(key: &str, runs: &[Run]) -> Self {
        match papers().into_iter().find(|paper| paper.key == key) {
            Some(paper) => Self {
                heads: &["in the paper", "shows", "here", "as published or expected"],
                entries: paper
                    .figures
                    .iter()
                    .map(|entry| figure(entry, runs))
                    .chain(sections(key).into_iter().map(|section| text(key, section, runs)))
                    .collect(),
            },
            None => Self {
                heads: &["experiment", "here", "as expected"],
                entries: runs
                    .iter()
                    .filter(|run| run.experiment.paper == key)
                    .map(own)
                    .collect(),
            },
        }
    }
}

fn figure(entry: &FigureEntry, runs: &[Run]) -> Entry {
    Entry {
        about: vec![entry.number.to_owned(), entry.shows.to_owned()],
        experiments: whether_run(entry.experiments, runs),
        standing: match entry.experiments {
            [] => "nothing to measure".to_owned(),
            names => standing(names, runs, |finding| belongs(&finding.figure, entry.number)),
        },
    }
}

/// The line of a section.
fn text(key: &str, section: &'static str, runs: &[Run]) -> Entry {
    let names: Vec<&'static str> = experiments()
        .filter(|one| one.paper == key && one.figures.contains(&section))
        .map(|one| one.name)
        .collect();
    Entry {
        about: vec![section.to_owned(), "text".to_owned()],
        experiments: whether_run(&names, runs),
        standing: standing(&names, runs, |finding| belongs(&finding.figure, section)),
    }
}

fn own(run: &Run) -> Entry {
    let about = run.experiment;
    let names = [about.name];
    Entry {
        about: vec![about.title.to_owned()],
        experiments: whether_run(&names, std::slice::from_ref(run)),
        standing: standing(&names, std::slice::from_ref(run), |_| true),
    }
}

/// Sections that experiments of a paper reproduce, in its order.
fn sections(key: &str) -> Vec<&'static str> {
    let named = experiments()
        .filter(|one| one.paper == key)
        .flat_map(|one| one.figures);
    let mut sections: Vec<&'static str> = named
        .copied()
        .filter(|name| name.starts_with("Section"))
        .collect();
    sections.sort_by_key(|section| numbers(section));
    sections.dedup();
    sections
}

/// 3 and 2 of `Section 3.2`.
fn numbers(section: &str) -> Vec<u32> {
    let parts = section.split(|letter: char| !letter.is_ascii_digit());
    parts.filter_map(|part| part.parse().ok()).collect()
}

fn whether_run(names: &[&'static str], runs: &[Run]) -> Vec<(&'static str, bool)> {
    let was_run = |name: &str| runs.iter().any(|run| run.experiment.name == name);
    names.iter().map(|&name| (name, was_run(name))).collect()
}

/// Summary of the verdicts on those findings of these experiments that belong to a place in the paper.
fn standing(names: &[&str], runs: &[Run], of_it: impl Fn(&Finding) -> bool) -> String {
    let of_names: Vec<&Run> = runs
        .iter()
        .filter(|run| names.contains(&run.experiment.name))
        .collect();
    let findings = of_names.iter().flat_map(|run| &run.outcome.findings);
    let verdicts: Vec<bool> = findings
        .filter(|finding| of_it(finding))
        .map(|finding| finding.verdict() == Verdict::Reproduced)
        .collect();
    match (of_names.len(), verdicts.len()) {
        (0, _) => String::new(),
        (_, 0) => "pictures only".to_owned(),
        (_, all) => format!("{} of {all}", verdicts.iter().filter(|&&held| held).count()),
    }
}

/// Whether a figure's label belongs to a number: `Fig. 5 (b)` to `Fig. 5`, but not `Fig. 51`, nor `Section 5.1` to
/// `Section 5`.
fn belongs(figure: &str, number: &str) -> bool {
    let rest = figure.strip_prefix(number);
    rest.is_some_and(|rest| !rest.starts_with(|next: char| next.is_ascii_digit() || next == '.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_figure_belong_to_it() {
        assert!(
            belongs("Fig. 5", "Fig. 5") && belongs("Fig. 5 (b)", "Fig. 5") && belongs("Fig. 5b", "Fig. 5")
        );
        assert!(!belongs("Fig. 51", "Fig. 5") && !belongs("Fig. 4", "Fig. 5"));
        assert!(!belongs("Section 5.1", "Section 5") && belongs("Section 5.1", "Section 5.1"));
    }

    #[test]
    fn every_experiment_of_a_paper_is_in_its_index() {
        for paper in papers() {
            let index = Index::of(paper.key, &[]);
            for one in experiments().filter(|one| one.paper == paper.key) {
                let mut named = index.entries.iter().flat_map(|entry| &entry.experiments);
                assert!(named.any(|named| *named == (one.name, false)), "{}", one.name);
            }
        }
    }

    #[test]
    fn sections_come_in_the_paper_s_order() {
        let mut sections = ["Section 10", "Section 3.2", "Section 3"];
        sections.sort_by_key(|section| numbers(section));
        assert_eq!(sections, ["Section 3", "Section 3.2", "Section 10"]);
    }
}
