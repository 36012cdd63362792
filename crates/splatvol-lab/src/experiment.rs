//! Experiments and papers.

use crate::{LabError, Outcome, Workbench};

/// An experiment: its name, the figures it reproduces, and its procedure.
#[derive(Debug, Clone, Copy)]
pub struct Experiment {
    /// Name on the command line, as `swan1997-checker`.
    pub name: &'static str,
    /// Key of the paper, as `swan1997`; `beyond` for our own.
    pub paper: &'static str,
    /// Title, in a line.
    pub title: &'static str,
    /// The figures, tables and sections that it reproduces, as the paper numbers them: `Fig. 7`, `Table 1`.
    pub figures: &'static [&'static str],
    /// The method, the data (and how they stand in for data that are not public) and the measured quantities. Markdown
    /// paragraphs without headings.
    pub about: &'static str,
    /// Runs it.
    pub run: fn(&Workbench<'_>) -> Result<Outcome, LabError>,
}

/// A paper and every figure and table in it, so that a reader with the paper in hand finds each by its number.
#[derive(Debug, Clone, Copy)]
pub struct Paper {
    /// Key: first author and year.
    pub key: &'static str,
    /// Authors, title, where it appeared.
    pub citation: &'static str,
    /// All its figures and tables, in its order.
    pub figures: &'static [FigureEntry],
}

/// A figure or table of a paper.
#[derive(Debug, Clone, Copy)]
pub struct FigureEntry {
    /// Number in the paper: `Fig. 7`, `Table 1`.
    pub number: &'static str,
    /// Subject of the figure or table.
    pub shows: &'static str,
    /// Experiments that reproduce it; none for drawings that explain, with nothing to measure.
    pub experiments: &'static [&'static str],
}
