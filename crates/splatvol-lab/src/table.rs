//! Rows of measurements.

use std::fmt;

use crate::finding::short;

/// Rows of measurements.
#[derive(Debug, Clone)]
pub struct Table {
    /// Name within the experiment, in kebab case; the CSV file is named after it.
    pub name: String,
    /// The paper's figure or table.
    pub figure: String,
    /// Description of the rows.
    pub caption: String,
    /// Heads of the columns, with units: `radius (pixels)`.
    pub columns: Vec<String>,
    /// Rows, each as long as `columns`.
    pub rows: Vec<Vec<Cell>>,
    /// Whether the report shows it; long ones are in the CSV only, and a plot shows them.
    pub shown: bool,
}

/// One entry.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A number.
    Number(f64),
    /// Words.
    Words(String),
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<usize> for Cell {
    fn from(value: usize) -> Self {
        Self::Number(value as f64)
    }
}

impl From<&str> for Cell {
    fn from(words: &str) -> Self {
        Self::Words(words.to_owned())
    }
}

impl From<String> for Cell {
    fn from(words: String) -> Self {
        Self::Words(words)
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(value) => f.write_str(&short(*value)),
            Self::Words(words) => f.write_str(words),
        }
    }
}

impl Table {
    /// A table without rows.
    pub fn new(name: &str, figure: &str, caption: &str, columns: &[&str]) -> Self {
        Self {
            name: name.to_owned(),
            figure: figure.to_owned(),
            caption: caption.to_owned(),
            columns: columns.iter().map(|&column| column.to_owned()).collect(),
            rows: Vec::new(),
            shown: true,
        }
    }

    /// Keeps it out of the report: the CSV has it.
    #[must_use]
    pub fn hidden(mut self) -> Self {
        self.shown = false;
        self
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// The rows as CSV, all digits, under the heads of the columns.
    pub fn csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let exact = |cell: &Cell| match cell {
            Cell::Number(value) => value.to_string(),
            Cell::Words(words) => words.clone(),
        };
        let rows = self.rows.iter().map(|row| row.iter().map(exact).collect());
        for record in std::iter::once(self.columns.clone()).chain(rows) {
            // Memory takes every byte, and rows as long as the head give no error.
            let _ = writer.write_record(&record);
        }
        let bytes = writer.into_inner().unwrap_or_default();
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_keeps_all_digits_and_quotes_commas() {
        let mut table = Table::new("t", "Fig. 1", "c", &["kernel", "error (levels)"]);
        table.row(["Gauss, cut".into(), 0.1234567890123.into()]);
        table.row(["cubic".into(), 3usize.into()]);
        assert_eq!(
            table.csv(),
            "kernel,error (levels)\n\"Gauss, cut\",0.1234567890123\ncubic,3\n"
        );
    }
}
