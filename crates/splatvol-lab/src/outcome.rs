//! Results of an experiment.

use std::time::Duration;

use crate::{Effort, Experiment, Finding, Plate, Plot, Table};

/// Results of an experiment.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// Numbers beside the published ones.
    pub findings: Vec<Finding>,
    /// Rows of measurements, written as CSV.
    pub tables: Vec<Table>,
    /// Plots, written as SVG.
    pub plots: Vec<Plot>,
    /// Pictures side by side, written as PNG.
    pub plates: Vec<Plate>,
}

impl Outcome {
    /// Adds a finding.
    pub fn find(&mut self, finding: Finding) {
        self.findings.push(finding);
    }
}

/// An experiment that was run.
#[derive(Debug, Clone)]
pub struct Run {
    /// The experiment.
    pub experiment: &'static Experiment,
    /// Thoroughness.
    pub effort: Effort,
    /// Number of worker threads; `None`: one per logical processor.
    pub threads: Option<usize>,
    /// Results.
    pub outcome: Outcome,
    /// Time taken.
    pub took: Duration,
}
