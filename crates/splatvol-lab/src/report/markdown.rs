//! The report as Markdown.

use std::fmt::Write;

use super::index::Index;
use super::summary::{group_title, groups, lead, shown_in, took};
use crate::{Finding, Plate, Plot, Run, Table};

/// The whole page; pictures lie in a folder per experiment beside it.
pub(super) fn page(runs: &[Run]) -> String {
    let mut text = format!("# The papers' experiments\n\n{}\n", lead(runs));
    for key in groups(runs) {
        let _ = write!(text, "\n## {}\n", group_title(key));
        index(&mut text, &Index::of(key, runs));
        for run in runs.iter().filter(|run| run.experiment.paper == key) {
            experiment(&mut text, run);
        }
    }
    text
}

/// Figures, sections or titles, with links to their experiments.
fn index(text: &mut String, index: &Index) {
    let _ = write!(
        text,
        "\n| {} |\n|{}\n",
        index.heads.join(" | "),
        "---|".repeat(index.heads.len())
    );
    for entry in &index.entries {
        let about: Vec<String> = entry.about.iter().map(|words| cell(words)).collect();
        let links = entry.experiments.iter().map(|(name, was_run)| match was_run {
            true => format!("[{name}](#{name})"),
            false => format!("{name} (not run)"),
        });
        let _ = writeln!(
            text,
            "| {} | {} | {} |",
            about.join(" | "),
            links.collect::<Vec<_>>().join(", "),
            entry.standing
        );
    }
}

fn experiment(text: &mut String, run: &Run) {
    let about = run.experiment;
    let folder = about.name;
    let _ = write!(
        text,
        "\n### {}\n\n**{}.** {}\n\n{}\n",
        about.name,
        about.title,
        shown_in(run),
        about.about.trim()
    );
    findings(text, &run.outcome.findings);
    for plate in &run.outcome.plates {
        pictures(text, plate, folder);
    }
    for plot in &run.outcome.plots {
        drawing(text, plot, folder);
    }
    for table in run.outcome.tables.iter().filter(|table| table.shown) {
        rows(text, table);
    }
    let _ = write!(text, "\n{}\n", took(run));
}

fn findings(text: &mut String, findings: &[Finding]) {
    if findings.is_empty() {
        return;
    }
    text.push_str(
        "\n| figure | quantity | paper | measured | condition | verdict |\n|---|---|---|---|---|---|\n",
    );
    for one in findings {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} |",
            one.figure,
            cell(&one.quantity),
            cell(&one.published.to_string()),
            cell(&one.measured_text()),
            one.expected,
            cell(&one.verdict_text())
        );
    }
}

fn pictures(text: &mut String, plate: &Plate, folder: &str) {
    let labels: Vec<String> = plate.panels.iter().map(|panel| cell(&panel.label)).collect();
    let images: Vec<String> = (0..plate.panels.len())
        .map(|index| format!("![{}]({folder}/{})", labels[index], plate.file_name(index)))
        .collect();
    let _ = write!(
        text,
        "\n{}: {}\n\n| {} |\n|{}\n| {} |\n",
        plate.figure,
        plate.caption,
        labels.join(" | "),
        "---|".repeat(labels.len()),
        images.join(" | ")
    );
}

fn drawing(text: &mut String, plot: &Plot, folder: &str) {
    let _ = write!(
        text,
        "\n![{}: {}]({folder}/{})\n",
        plot.figure,
        plot.caption,
        plot.file_name()
    );
}

fn rows(text: &mut String, table: &Table) {
    let _ = write!(
        text,
        "\n{}: {}\n\n| {} |\n|{}\n",
        table.figure,
        table.caption,
        table
            .columns
            .iter()
            .map(|column| cell(column))
            .collect::<Vec<_>>()
            .join(" | "),
        "---|".repeat(table.columns.len())
    );
    for row in &table.rows {
        let cells: Vec<String> = row.iter().map(|one| cell(&one.to_string())).collect();
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
}

/// Text within a row.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "&lt;").replace('\n', " ")
}
