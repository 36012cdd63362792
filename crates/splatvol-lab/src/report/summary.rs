//! What both forms of the report say, apart from their marks.

use crate::{Effort, FigureEntry, Run, Verdict, papers};

/// The first paragraph.
pub(super) fn lead(runs: &[Run]) -> String {
    let findings = runs.iter().flat_map(|run| &run.outcome.findings);
    let verdicts: Vec<Verdict> = findings.map(crate::Finding::verdict).collect();
    let held = verdicts
        .iter()
        .filter(|&verdict| *verdict == Verdict::Reproduced)
        .count();
    let unexplained = verdicts
        .iter()
        .filter(|verdict| matches!(verdict, Verdict::Differs { because } if because.is_empty()))
        .count();
    let effort = match runs.iter().all(|run| run.effort == Effort::Full) {
        true => "",
        false => " with --quick, smaller than the papers' sizes",
    };
    format!(
        "{} experiments were run{effort}. Of {} numbers, {held} come out as published or expected, {} differ{}. \
         No verdict is written by hand: each follows from the measured number and the condition beside it, and a \
         reason for a difference is given only where its own measurement holds.",
        runs.len(),
        verdicts.len(),
        verdicts.len() - held,
        match unexplained {
            0 => ", each for a reason that was measured".to_owned(),
            count => format!(", {count} of them without an explanation that holds"),
        },
    )
}

/// Experiments of a figure, and whether they are among these runs.
pub(super) fn experiments<'a>(
    entry: &'a FigureEntry,
    runs: &'a [Run],
) -> impl Iterator<Item = (&'static str, bool)> + 'a {
    let was_run = |name: &str| runs.iter().any(|run| run.experiment.name == name);
    entry.experiments.iter().map(move |&name| (name, was_run(name)))
}

/// What became of a paper's figure in these runs.
pub(super) fn standing(entry: &FigureEntry, runs: &[Run]) -> String {
    if entry.experiments.is_empty() {
        return "a drawing: nothing to measure".to_owned();
    }
    let findings = runs
        .iter()
        .filter(|run| entry.experiments.contains(&run.experiment.name))
        .flat_map(|run| &run.outcome.findings)
        .filter(|finding| belongs(&finding.figure, entry.number));
    let verdicts: Vec<bool> = findings
        .map(|finding| finding.verdict() == Verdict::Reproduced)
        .collect();
    match (verdicts.len(), verdicts.iter().filter(|&&held| held).count()) {
        (0, _) => "pictures".to_owned(),
        (all, held) if all == held => format!("all {all} reproduced"),
        (all, held) => format!("{held} of {all} reproduced"),
    }
}

/// Whether `Fig. 5 (b)` is of `Fig. 5`, which `Fig. 51` is not.
fn belongs(figure: &str, number: &str) -> bool {
    let rest = figure.strip_prefix(number);
    rest.is_some_and(|rest| !rest.starts_with(|next: char| next.is_ascii_digit()))
}

/// Title of a group of experiments.
pub(super) fn group_title(key: &str) -> String {
    papers().iter().find(|paper| paper.key == key).map_or_else(
        || "Beyond the papers".to_owned(),
        |paper| format!("{}: {}", paper.key, paper.citation),
    )
}

/// Keys of the groups, in order.
pub(super) fn groups(runs: &[Run]) -> Vec<&'static str> {
    let mut keys: Vec<&'static str> = runs.iter().map(|run| run.experiment.paper).collect();
    keys.dedup();
    keys
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
    }
}
