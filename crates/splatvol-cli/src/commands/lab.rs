//! `splatvol lab`: the papers' experiments, listed or run.

use std::path::Path;
use std::time::Instant;

use anyhow::anyhow;
use splatvol_lab::{
    Effort, Experiment, LabError, Published, Run, Workbench, experiment, experiments, folder, papers, report,
};

use crate::args::LabArgs;
use crate::commands::studio::threads_within;
use crate::failure::{During, Failure, Step};
use crate::output::Target;
use crate::terminal::Terminal;

pub(crate) fn run(args: &LabArgs, terminal: &Terminal) -> Result<(), Failure> {
    if args.names.is_empty() {
        return list();
    }
    let chosen = chosen(&args.names)?;
    let data = data(args)?;
    let output = args.report.as_deref().unwrap_or(&args.output);
    if !args.write.overwrite {
        refuse_existing(output, &chosen, args.report.is_some())?;
    }
    let mut runs = Vec::with_capacity(chosen.len());
    for (index, one) in chosen.iter().enumerate() {
        let label = format!("{}/{} {}", index + 1, chosen.len(), one.name);
        let Some(run) = run_one(one, (args, data), &label, terminal)? else {
            continue;
        };
        folder::write(&run, output).during(Step::Output)?;
        Target::Stdout.write(told(&run).as_bytes(), false)?;
        runs.push(run);
    }
    match &args.report {
        Some(folder) => {
            report::write(&runs, folder).during(Step::Output)?;
            terminal.note(format!("wrote {}", folder.join("index.html").display()));
        }
        None => terminal.note(format!("pictures, plots and CSV are in {}", output.display())),
    }
    Ok(())
}

/// The experiments with these names, in the catalogue's order, each once.
fn chosen(names: &[String]) -> Result<Vec<&'static Experiment>, Failure> {
    let is_group = |name: &str| name == "all" || experiments().any(|one| one.paper == name);
    for name in names.iter().filter(|name| !is_group(name)) {
        experiment(name).map_err(|error| Failure::usage(error).hint("splatvol lab lists them"))?;
    }
    let takes = |one: &Experiment, name: &String| name == "all" || name == one.name || name == one.paper;
    Ok(experiments()
        .filter(|one| names.iter().any(|name| takes(one, name)))
        .collect())
}

fn refuse_existing(output: &Path, chosen: &[&Experiment], report: bool) -> Result<(), Failure> {
    let page = report.then(|| output.join("index.html"));
    let option = if report { "--report" } else { "-o" };
    let folders = chosen.iter().map(|one| output.join(one.name));
    match page.into_iter().chain(folders).find(|path| path.exists()) {
        Some(path) => Err(anyhow!("{} exists", path.display()))
            .during(Step::Output)
            .map_err(|failure| failure.hint(format!("-w overwrites it, {option} names another folder"))),
        None => Ok(()),
    }
}

/// Default folder of data that are not part of splatvol, beside the checkout.
const DATA: &str = "../shared/data";

/// The folder of data, if there is one.
fn data(args: &LabArgs) -> Result<Option<&Path>, Failure> {
    match &args.data {
        Some(folder) if folder.is_dir() => Ok(Some(folder)),
        Some(folder) => Err(anyhow!("--data {}: no such folder", folder.display())).during(Step::Input),
        None => Ok(Some(Path::new(DATA)).filter(|folder| folder.is_dir())),
    }
}

/// Runs one; `None` if its data are missing and it was not requested by name.
fn run_one(
    one: &'static Experiment,
    (args, data): (&LabArgs, Option<&Path>),
    label: &str,
    terminal: &Terminal,
) -> Result<Option<Run>, Failure> {
    let bar = terminal.progress(label.to_owned());
    let start = Instant::now();
    let bench = Workbench {
        effort: match args.quick {
            true => Effort::Quick,
            false => Effort::Full,
        },
        threads: args.threads.and_then(|asked| threads_within(asked, terminal)),
        data,
        progress: &|share, what| bar.show(share, format!("{label}: {what}")),
    };
    let outcome = match (one.run)(&bench) {
        Err(error @ LabError::NoData { .. }) if !args.names.iter().any(|name| name == one.name) => {
            terminal.note(format!("skipped {}: {error}; --data names a folder", one.name));
            return Ok(None);
        }
        Err(error) => return Err(failed(one, error)),
        Ok(outcome) => outcome,
    };
    let took = start.elapsed();
    terminal.detail(format!("{} took {:.1} s", one.name, took.as_secs_f64()));
    Ok(Some(Run {
        experiment: one,
        effort: bench.effort,
        threads: bench.threads,
        outcome,
        took,
    }))
}

fn failed(one: &Experiment, error: LabError) -> Failure {
    let (step, hint) = match error {
        LabError::NoData { .. } => (Step::Input, Some("--data names a folder that holds it")),
        LabError::Io(_) => (Step::Input, None),
        _ => (Step::Render, None),
    };
    let failure = Failure::of(step, anyhow!("{}: {error}", one.name));
    match hint {
        Some(hint) => failure.hint(hint),
        None => failure,
    }
}

/// A run's findings for the terminal: measured against published.
fn told(run: &Run) -> String {
    let mut text = format!("{}: {}\n", run.experiment.name, run.experiment.title);
    for one in &run.outcome.findings {
        let paper = match &one.published {
            Published::Nothing => String::new(),
            published => format!("paper {published}; "),
        };
        text.push_str(&format!(
            "  {:<12} {}\n               measured {}; {paper}condition {}: {}\n",
            one.figure,
            one.quantity,
            one.measured_text(),
            one.expected,
            one.verdict_text()
        ));
    }
    text
}

fn list() -> Result<(), Failure> {
    let mut text = String::new();
    let mut group = "";
    for one in experiments() {
        if one.paper != group {
            group = one.paper;
            let paper = papers().into_iter().find(|paper| paper.key == group);
            let title = paper.map_or("Beyond the papers", |paper| paper.citation);
            text.push_str(&format!("{group}: {title}\n"));
        }
        text.push_str(&format!(
            "  {:<30} {} ({})\n",
            one.name,
            one.title,
            one.figures.join(", ")
        ));
    }
    Target::Stdout.write(text.as_bytes(), false)
}
