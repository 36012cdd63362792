//! An experiment's results as files: `findings.csv`, a CSV per table, an SVG per plot, a PNG per picture.

use std::path::Path;

use splatvol::Image;
use splatvol_io::{ImageFormat, encode_image};

use crate::{Cell, Finding, LabError, Outcome, Run, Table};

/// Writes the results of a run into `folder/NAME/`, which is created; files of these names are overwritten.
///
/// # Errors
/// A file cannot be written.
pub fn write(run: &Run, folder: &Path) -> Result<(), LabError> {
    let folder = folder.join(run.experiment.name);
    std::fs::create_dir_all(&folder).map_err(|source| LabError::Write {
        path: folder.clone(),
        source,
    })?;
    for (name, bytes) in files(&run.outcome)? {
        put(&folder.join(name), &bytes)?;
    }
    Ok(())
}

/// Names and contents.
fn files(outcome: &Outcome) -> Result<Vec<(String, Vec<u8>)>, LabError> {
    let mut files = vec![(
        "findings.csv".to_owned(),
        findings(&outcome.findings).csv().into_bytes(),
    )];
    files.extend(
        outcome
            .tables
            .iter()
            .map(|table| (format!("{}.csv", table.name), table.csv().into_bytes())),
    );
    files.extend(
        outcome
            .plots
            .iter()
            .map(|plot| (plot.file_name(), plot.svg().into_bytes())),
    );
    for plate in &outcome.plates {
        for (index, panel) in plate.panels.iter().enumerate() {
            files.push((plate.file_name(index), png(&panel.image)?));
        }
    }
    Ok(files)
}

/// The findings as a table: published and measured values, and verdicts.
pub(crate) fn findings(findings: &[Finding]) -> Table {
    let columns = [
        "figure",
        "key",
        "quantity",
        "unit",
        "published",
        "measured",
        "detail",
        "expected",
        "verdict",
        "timed",
    ];
    let mut table = Table::new("findings", "", "Measured against published", &columns);
    for one in findings {
        table.row([
            one.figure.as_str().into(),
            one.key.as_str().into(),
            one.quantity.as_str().into(),
            one.unit.into(),
            one.published.to_string().into(),
            Cell::Number(one.measured),
            one.detail.as_str().into(),
            one.expected.to_string().into(),
            one.verdict_text().into(),
            one.timed.to_string().into(),
        ]);
    }
    table
}

/// A picture as PNG.
pub(crate) fn png(image: &Image) -> Result<Vec<u8>, LabError> {
    encode_image(image, None, ImageFormat::Png8, &[])
        .map_err(|error| LabError::Measurement(error.to_string()))
}

/// Writes a file.
pub(crate) fn put(path: &Path, bytes: &[u8]) -> Result<(), LabError> {
    std::fs::write(path, bytes).map_err(|source| LabError::Write {
        path: path.to_owned(),
        source,
    })
}
