//! Every experiment with `--quick`: its numbers lie in stored ranges, `ranges/PAPER.toml`, whose keys are experiment
//! and finding. A timed finding must only be a number. Experiments whose data are missing are skipped. A finding
//! without a range, and a range without a finding, fail.

use std::collections::BTreeMap;
use std::path::Path;

use splatvol_lab::{Effort, LabError, Outcome, Workbench, experiments, report};

type Ranges = BTreeMap<String, BTreeMap<String, [f64; 2]>>;

fn stored(paper: &str) -> Ranges {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/ranges")
        .join(format!("{paper}.toml"));
    let text = std::fs::read_to_string(&path).unwrap_or_default();
    toml::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Faults of an outcome; findings without a stored range are listed as lines to store.
fn complaints(name: &str, outcome: &Outcome, ranges: &BTreeMap<String, [f64; 2]>) -> Vec<String> {
    let mut wrong = Vec::new();
    for finding in &outcome.findings {
        let (key, measured) = (&finding.key, finding.measured);
        if !measured.is_finite() {
            wrong.push(format!("{name}: {key} is {measured}"));
        }
        match (finding.timed, ranges.get(key)) {
            (true, None) => {}
            (true, Some(_)) => wrong.push(format!("{name}: {key} is timed and may have no range")),
            (false, None) => {
                let margin = measured.abs() * 0.02;
                wrong.push(format!(
                    "no range for {name}: {key} = [{}, {}]",
                    measured - margin,
                    measured + margin
                ));
            }
            (false, Some(&[low, high])) if !(low..=high).contains(&measured) => {
                wrong.push(format!("{name}: {key} = {measured}, not within {low}..{high}"));
            }
            (false, Some(_)) => {}
        }
    }
    let found = |key: &String| outcome.findings.iter().any(|finding| finding.key == *key);
    wrong.extend(
        ranges
            .keys()
            .filter(|key| !found(key))
            .map(|key| format!("{name}: no finding {key}")),
    );
    wrong
}

fn check(paper: &str) {
    let stored = stored(paper);
    let nothing = BTreeMap::new();
    let mut wrong = Vec::new();
    let mut runs = Vec::new();
    let mut skipped = Vec::new();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    for experiment in experiments().filter(|one| one.paper == paper) {
        let start = std::time::Instant::now();
        let bench = Workbench {
            effort: Effort::Quick,
            threads: None,
            data: Some(&data),
            progress: &|_, _| {},
        };
        let outcome = match (experiment.run)(&bench) {
            Err(error @ LabError::NoData { .. }) => {
                splatvol_recorded::skip(&format!("{}: {error}", experiment.name));
                skipped.push(experiment.name);
                continue;
            }
            outcome => outcome.unwrap_or_else(|error| panic!("{}: {error}", experiment.name)),
        };
        println!("{}: {:.1} s", experiment.name, start.elapsed().as_secs_f64());
        let ranges = stored.get(experiment.name).unwrap_or(&nothing);
        wrong.extend(complaints(experiment.name, &outcome, ranges));
        assert!(
            !outcome.plots.is_empty() || !outcome.plates.is_empty(),
            "{} shows nothing",
            experiment.name
        );
        assert!(!outcome.tables.is_empty(), "{} keeps no numbers", experiment.name);
        runs.push(splatvol_lab::Run {
            experiment,
            effort: Effort::Quick,
            threads: None,
            outcome,
            took: start.elapsed(),
        });
    }
    let known = |name: &String| {
        skipped.iter().any(|skipped| skipped == name) || runs.iter().any(|run| run.experiment.name == name)
    };
    wrong.extend(
        stored
            .keys()
            .filter(|name| !known(name))
            .map(|name| format!("no experiment {name}")),
    );
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
    the_report_names_everything(&runs);
}

fn the_report_names_everything(runs: &[splatvol_lab::Run]) {
    let out = tempfile::tempdir().expect("the system has a temporary folder");
    report::write(runs, out.path()).expect("the folder can be written");
    let page = std::fs::read_to_string(out.path().join("index.html")).expect("the page was written");
    let text = std::fs::read_to_string(out.path().join("lab.md")).expect("the text was written");
    for run in runs {
        let name = run.experiment.name;
        assert!(page.contains(&format!("id=\"{name}\"")), "{name}");
        assert!(
            page.contains(&format!("href=\"#{name}\"")),
            "{name} is in no index"
        );
        assert!(
            text.contains(&format!("[{name}](#{name})")),
            "{name} is in no index"
        );
        for finding in &run.outcome.findings {
            let key = &finding.key;
            let named = |place: &&str| finding.figure.starts_with(place);
            assert!(
                run.experiment.figures.iter().any(named),
                "{name}: {key} is in no index"
            );
            assert_eq!(
                run.outcome.findings.iter().filter(|one| one.key == *key).count(),
                1,
                "{name}: {key} twice"
            );
        }
        let findings = std::fs::read_to_string(out.path().join(name).join("findings.csv"))
            .expect("the findings were written");
        assert_eq!(findings.lines().count(), run.outcome.findings.len() + 1, "{name}");
    }
    assert!(
        !page.contains("src=\"http") && !page.contains("href=\"http"),
        "the page needs other files"
    );
}

macro_rules! papers {
    ($($name:ident),*) => {$(
        #[test]
        fn $name() {
            check(stringify!($name));
        }
    )*};
}

papers!(swan1997, mueller1998, huang2000, zwicker2001, beyond);
