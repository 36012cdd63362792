//! Text common to both forms of the report, apart from its markup.

use super::machine;
use crate::{Effort, Finding, Run, Verdict, papers};

/// The first paragraph.
pub(super) fn lead(runs: &[Run]) -> String {
    let count = match runs {
        [_] => "1 experiment was".to_owned(),
        runs => format!("{} experiments were", runs.len()),
    };
    let effort = match runs.iter().all(|run| run.effort == Effort::Full) {
        true => "",
        false => " with --quick, smaller than the papers' sizes",
    };
    format!(
        "{count} run{effort}. {}{} No verdict is written by hand: each follows from the measured number and the condition \
         beside it, and a reason for a difference is given only where its own measurement holds.",
        verdicts(runs),
        times(runs)
    )
}

/// Number of results that come out as published, and whether the differences are explained.
fn verdicts(runs: &[Run]) -> String {
    let findings = runs.iter().flat_map(|run| &run.outcome.findings);
    let verdicts: Vec<Verdict> = findings.map(Finding::verdict).collect();
    let differing = verdicts.iter().filter_map(|verdict| match verdict {
        Verdict::Reproduced => None,
        Verdict::Differs { because } => Some(because.is_empty()),
    });
    let unexplained: Vec<bool> = differing.collect();
    let held = verdicts.len() - unexplained.len();
    let end = match (unexplained.len(), unexplained.iter().filter(|&&one| one).count()) {
        (0, _) => ", none differs".to_owned(),
        (differ, 0) => format!(", {differ} differ, each for a reason that was measured"),
        (differ, count) => format!(", {differ} differ, {count} of them without an explanation that holds"),
    };
    format!(
        "Of {} numbers, {held} come out as published or expected{end}.",
        verdicts.len()
    )
}

/// The machine on which times were measured, if any finding is a time.
fn times(runs: &[Run]) -> String {
    let timed = |run: &&Run| run.outcome.findings.iter().any(|finding| finding.timed);
    runs.iter().find(timed).map_or_else(String::new, |run| {
        let threads = match machine::threads(run.threads) {
            1 => "one thread".to_owned(),
            count => format!("{count} threads unless an experiment says otherwise"),
        };
        format!(
            " Times are of this processor: {}, with {threads}.",
            machine::processor()
        )
    })
}

/// Time that an experiment took.
pub(super) fn took(run: &Run) -> String {
    match run.took.as_secs_f64() {
        seconds if seconds < 0.1 => "Took less than 0.1 s.".to_owned(),
        seconds => format!("Took {seconds:.1} s."),
    }
}

/// The paper's figures and sections that an experiment reproduces; none for our own.
pub(super) fn shown_in(run: &Run) -> String {
    let about = run.experiment;
    match papers().iter().any(|paper| paper.key == about.paper) {
        true => about.figures.join(", "),
        false => String::new(),
    }
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
