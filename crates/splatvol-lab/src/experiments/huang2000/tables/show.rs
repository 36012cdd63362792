//! Rows and plots of Fig. 3 and 4.

use super::Row;
use crate::{Axis, Curve, Plot, Table};

pub(super) fn numbers(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "errors",
        "Fig. 3",
        "Errors of tables. Bounds, largest and mean errors are in 256ths of the footprint's centre; by squared distance and by distance.",
        &[
            "entries",
            "sampling, squared",
            "sampling, linear",
            "8 bits",
            "16 bits",
            "bound, squared, 8 bits",
            "bound, linear, 8 bits",
            "bound, squared, 16 bits",
            "bound, linear, 16 bits",
            "largest, squared, 8 bits",
            "largest, linear, 8 bits",
            "mean, squared, 8 bits",
            "mean, linear, 8 bits",
        ],
    );
    for row in rows {
        table.row([
            row.entries.into(),
            row.sampling[0].into(),
            row.sampling[1].into(),
            row.quantisation[0].into(),
            row.quantisation[1].into(),
            row.bound(0, 0).into(),
            row.bound(1, 0).into(),
            row.bound(0, 1).into(),
            row.bound(1, 1).into(),
            row.largest[0].into(),
            row.largest[1].into(),
            row.mean[0].into(),
            row.mean[1].into(),
        ]);
    }
    table
}

pub(super) fn plots(rows: &[Row]) -> Vec<Plot> {
    let curve = |label: &str, value: &dyn Fn(&Row) -> f64| {
        Curve::new(label, rows.iter().map(|row| [row.entries as f64, value(row)])).dots()
    };
    // Bounds and measurements nearly coincide: only measurements have dots.
    let line = |label: &str, value: &dyn Fn(&Row) -> f64| Curve {
        dots: false,
        ..curve(label, value)
    };
    let sizes = || Axis::logarithmic("table size (entries)").range(30.0, 1100.0);
    let sources = Plot::curves(
        "errors",
        "Fig. 3",
        "errors by their source",
        sizes(),
        Axis::logarithmic("largest error (share of the centre)"),
    )
    .curve(curve("point sampling, squared distance", &|row| row.sampling[0]))
    .curve(curve("point sampling, distance", &|row| row.sampling[1]))
    .curve(curve("quantisation, 8 bits", &|row| row.quantisation[0]).dashed())
    .curve(curve("quantisation, 16 bits", &|row| row.quantisation[1]).dashed());
    let total = Plot::curves(
        "bounds",
        "Fig. 4",
        "bound of the total error, and the largest error found",
        sizes(),
        Axis::logarithmic("error (8-bit levels)"),
    )
    .curve(line("bound: squared, 8 bits", &|row| row.bound(0, 0)))
    .curve(line("bound: squared, 16 bits", &|row| row.bound(0, 1)).dashed())
    .curve(line("bound: linear, 8 bits", &|row| row.bound(1, 0)))
    .curve(line("bound: linear, 16 bits", &|row| row.bound(1, 1)).dashed())
    .curve(curve("found: squared, 8 bits", &|row| row.largest[0]))
    .curve(curve("found: linear, 8 bits", &|row| row.largest[1]));
    vec![sources, total]
}
