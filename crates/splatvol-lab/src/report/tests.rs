use std::time::Duration;

use splatvol::{Image, ImageSize};

use super::*;
use crate::{
    Axis, Curve, Effort, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, Published, Table,
    Workbench,
};

static EXPERIMENT: Experiment = Experiment {
    name: "beyond-test",
    paper: "beyond",
    title: "Less < more & \"quoted\"",
    figures: &["Test"],
    about: "First <b>paragraph</b>.\n\nSecond.",
    run: nothing,
};

fn nothing(_: &Workbench<'_>) -> Result<Outcome, LabError> {
    Ok(Outcome::default())
}

/// A run with one of everything, whose words contain characters that HTML and Markdown treat as markup.
fn run() -> Run {
    let mut outcome = Outcome::default();
    outcome.find(
        Finding::new("Test (a)", "held", "a | b < c", 2.0, Expectation::AtLeast(1.0))
            .unit("dB")
            .published(Published::Claim("x & y".to_owned())),
    );
    outcome.find(Finding::new(
        "Test (b)",
        "open",
        "two\nlines",
        3.0,
        Expectation::AtMost(1.0),
    ));
    outcome.find(
        Finding::new("Test (c)", "explained", "third", 3.0, Expectation::AtMost(1.0)).explained_by(
            "5 > 4",
            5.0,
            Expectation::AtLeast(4.0),
        ),
    );
    let mut table = Table::new("t", "Test", "A table", &["kernel | filter", "error (dB)"]);
    table.row(["<none>".into(), 1.5.into()]);
    let mut hidden = Table::new("h", "Test", "Hidden", &["x"]).hidden();
    hidden.row([7.5.into()]);
    outcome.tables = vec![table, hidden];
    let [x, y] = [Axis::new("x (m)"), Axis::new("y (m)")];
    let plot = Plot::curves("p", "Test", "A plot", x, y).curve(Curve::new("line", [[0.0, 0.0], [1.0, 1.0]]));
    outcome.plots.push(plot);
    let image = Image::filled(ImageSize::new(2, 2).unwrap(), [0.5, 0.5, 0.5, 1.0]);
    let plate = Plate::new("q", "Test", "Two | pictures");
    outcome
        .plates
        .push(plate.panel("left \"1\"", image.clone()).panel("right | 2", image));
    Run {
        experiment: &EXPERIMENT,
        effort: Effort::Quick,
        threads: Some(3),
        outcome,
        took: Duration::from_millis(1500),
    }
}

#[test]
fn html_escapes_words_and_embeds_pictures_and_plots() {
    let page = html::page(&[run()]).unwrap();
    for escaped in [
        "Less &lt; more &amp; ",
        "First &lt;b&gt;paragraph&lt;/b&gt;.",
        "<td>a | b &lt; c</td>",
        "<td>x &amp; y</td>",
        "<td>&lt;none&gt;</td>",
        "alt=\"left &quot;1&quot;\"",
        "5 &gt; 4 (5)",
    ] {
        assert!(page.contains(escaped), "no {escaped}");
    }
    assert!(!page.contains("<b>paragraph") && !page.contains("<none>"));
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 2);
    assert_eq!(page.matches("<svg").count(), 1);
    for class in ["held", "open", "differs"] {
        assert_eq!(
            page.matches(&format!("<tr class=\"{class}\">")).count(),
            1,
            "{class}"
        );
    }
    assert!(!page.contains("Hidden") && page.contains("A table"));
    assert!(page.contains("Took 1.5 s."));
}

/// Cells of a row; a bar with a backslash before it does not separate cells.
fn cells(row: &str) -> usize {
    row.replace("\\|", "").matches('|').count() - 1
}

#[test]
fn markdown_rows_have_as_many_cells_as_their_heads() {
    let text = markdown::page(&[run()]);
    let mut head = None;
    let mut rows = 0;
    for line in text.lines() {
        if !line.starts_with('|') {
            head = None;
            continue;
        }
        let count = *head.get_or_insert_with(|| cells(line));
        assert_eq!(cells(line), count, "{line}");
        rows += 1;
    }
    // Head, rule and rows: the index's row, three findings, a plate's row, a table's.
    assert_eq!(rows, (2 + 1) + (2 + 3) + (2 + 1) + (2 + 1), "{text}");
    for part in [
        "| Test (a) | a \\| b &lt; c | x & y | 2 dB | ≥ 1 | reproduced |",
        "| Test (b) | two lines | – | 3 | ≤ 1 | differs, not explained |",
        "| Test (c) | third | – | 3 | ≤ 1 | differs because 5 > 4 (5) |",
        "![Test: A plot](beyond-test/p.svg)",
        "![right \\| 2](beyond-test/q-2.png)",
        "| Less &lt; more & \"quoted\" | [beyond-test](#beyond-test) | 1 of 3 |",
        "\nTook 1.5 s.\n",
    ] {
        assert!(text.contains(part), "no {part} in {text}");
    }
    assert!(!text.contains("Hidden"));
}

#[test]
fn the_first_paragraph_counts_verdicts() {
    let lead = summary::lead(&[run()]);
    assert!(lead.starts_with("1 experiment was run with --quick"), "{lead}");
    assert!(
        lead.contains("Of 3 numbers, 1 come out as published or expected, 2 differ, 1 of them without"),
        "{lead}"
    );
}

#[test]
fn the_first_paragraph_names_the_machine_of_times() {
    let mut run = run();
    assert!(!summary::lead(&[run.clone()]).contains("Times"));
    run.outcome.findings[0].timed = true;
    let lead = summary::lead(&[run]);
    assert!(
        lead.contains("Times are of this processor: ")
            && lead.contains(", with 3 threads unless an experiment says otherwise."),
        "{lead}"
    );
}

#[test]
fn what_holds_everywhere_differs_nowhere() {
    let mut run = run();
    run.outcome.findings.truncate(1);
    let lead = summary::lead(&[run.clone(), run]);
    assert!(
        lead.contains("2 experiments were")
            && lead.contains("2 come out as published or expected, none differs."),
        "{lead}"
    );
}

#[test]
fn the_report_s_files_are_those_that_it_names() {
    let out = tempfile::tempdir().unwrap();
    write(&[run()], out.path()).unwrap();
    let mut files: Vec<String> = std::fs::read_dir(out.path().join("beyond-test"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(
        files,
        ["findings.csv", "h.csv", "p.svg", "q-1.png", "q-2.png", "t.csv"]
    );
    let text = std::fs::read_to_string(out.path().join("lab.md")).unwrap();
    assert!(text.contains("](beyond-test/p.svg)"));
}
