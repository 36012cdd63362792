//! The report as one HTML page that needs no other file.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use pulldown_cmark::Event;

use super::index::Index;
use super::summary::{group_title, groups, lead, shown_in, took};
use crate::{Finding, LabError, Panel, Plate, Plot, Run, Table, Verdict, folder};

const STYLE: &str = include_str!("report.css");

/// The whole page.
pub(super) fn page(runs: &[Run]) -> Result<String, LabError> {
    let mut sections = Vec::new();
    for key in groups(runs) {
        sections.push(section(key, runs)?);
    }
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "splatvol lab" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "The papers' experiments" }
                p { (lead(runs)) }
                nav { ul { @for key in groups(runs) { li { a href={"#" (key)} { (group_title(key)) } } } } }
                @for section in sections { (section) }
            }
        }
    };
    Ok(page.into_string())
}

fn section(key: &str, runs: &[Run]) -> Result<Markup, LabError> {
    let mut sections = Vec::new();
    for run in runs.iter().filter(|run| run.experiment.paper == key) {
        sections.push(experiment(run)?);
    }
    Ok(html! {
        h2 id=(key) { (group_title(key)) }
        (index(&Index::of(key, runs)))
        @for section in sections { (section) }
    })
}

/// Figures, sections or titles, with links to their experiments.
fn index(index: &Index) -> Markup {
    html! {
        table {
            tr { @for head in index.heads { th { (head) } } }
            @for entry in &index.entries {
                tr {
                    @for words in &entry.about { td { (words) } }
                    td {
                        @for (name, was_run) in &entry.experiments {
                            @if *was_run { a href={"#" (name)} { (name) } " " } @else { (name) " (not run) " }
                        }
                    }
                    td { (entry.standing) }
                }
            }
        }
    }
}

fn experiment(run: &Run) -> Result<Markup, LabError> {
    let about = run.experiment;
    let outcome = &run.outcome;
    let plates = outcome
        .plates
        .iter()
        .map(pictures)
        .collect::<Result<Vec<_>, _>>()?;
    Ok(html! {
        h3 id=(about.name) { (about.name) }
        p { strong { (about.title) "." } " " (shown_in(run)) }
        (prose(about.about))
        @if !outcome.findings.is_empty() { (findings(&outcome.findings)) }
        @for plate in plates { (plate) }
        @for plot in &outcome.plots { (drawing(plot)) }
        @for table in outcome.tables.iter().filter(|table| table.shown) { (rows(table)) }
        p.small { (took(run)) }
    })
}

/// Markdown without headings; marks of HTML in it are text.
fn prose(text: &str) -> Markup {
    let mut page = String::new();
    let events = pulldown_cmark::Parser::new(text).map(|event| match event {
        Event::Html(marks) | Event::InlineHtml(marks) => Event::Text(marks),
        other => other,
    });
    pulldown_cmark::html::push_html(&mut page, events);
    PreEscaped(page)
}

fn findings(findings: &[Finding]) -> Markup {
    html! {
        table.findings {
            tr { th { "figure" } th { "quantity" } th { "paper" } th { "measured" } th { "condition" } th { "verdict" } }
            @for one in findings {
                tr class=(class(&one.verdict())) {
                    td { (one.figure) }
                    td { (one.quantity) }
                    td { (one.published) }
                    td { (one.measured_text()) }
                    td { (one.expected) }
                    td.verdict { (one.verdict_text()) }
                }
            }
        }
    }
}

fn class(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Reproduced => "held",
        Verdict::Differs { because } if because.is_empty() => "open",
        Verdict::Differs { .. } => "differs",
    }
}

fn pictures(plate: &Plate) -> Result<Markup, LabError> {
    let panels = plate.panels.iter().map(picture).collect::<Result<Vec<_>, _>>()?;
    Ok(html! {
        figure {
            div.panels { @for panel in panels { (panel) } }
            figcaption { (plate.figure) ": " (plate.caption) }
        }
    })
}

fn picture(panel: &Panel) -> Result<Markup, LabError> {
    let data = STANDARD.encode(folder::png(&panel.image)?);
    Ok(html! {
        div { img alt=(panel.label) src={"data:image/png;base64," (data)}; span { (panel.label) } }
    })
}

fn drawing(plot: &Plot) -> Markup {
    html! { figure { (PreEscaped(plot.svg())) } }
}

fn rows(table: &Table) -> Markup {
    html! {
        table {
            caption { (table.figure) ": " (table.caption) }
            tr { @for column in &table.columns { th { (column) } } }
            @for row in &table.rows { tr { @for cell in row { td { (cell) } } } }
        }
    }
}
