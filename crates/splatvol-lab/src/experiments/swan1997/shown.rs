//! Table, plot and pictures of Fig. 7.

use super::comparison::Comparison;
use super::window::{over_white, with_line_at};
use crate::{Axis, Cell, Curve, Mark, Plate, Plot, Table};

/// Table of all measurements with all filters.
pub(super) fn table(comparison: &Comparison, figure: &str) -> Table {
    let samples = comparison.samples * comparison.samples;
    let [power, _] = comparison.power;
    let mut table = Table::new(
        "filters",
        figure,
        "Standard splatting, the paper's filter and ewa, beyond k; energies in that of standard splatting",
        &[
            "filter",
            "above Nyquist, 4 samples per pixel (%)",
            &format!("above Nyquist, {samples} samples per pixel (%)"),
            "above Nyquist, the same voxels faint, against standard splatting (%)",
            "flicker (levels)",
            "flicker, the same voxels faint, against standard splatting (%)",
            "up the picture (pixels)",
            &format!("error there against means of {samples} samples (levels)"),
            "mean opacity",
        ],
    );
    let faint_flicker = comparison.number("plain", |one| one.faint.flicker);
    let faint = comparison.number("plain", |one| one.faint.above);
    for one in &comparison.measured {
        let [plain, ewa] = comparison
            .finer_above
            .map(|above| Cell::from(100.0 * above / power));
        let finer = match one.method.key {
            "plain" => plain,
            "ewa" => ewa,
            _ => "–".into(),
        };
        let [up, error] = one.displaced;
        table.row([
            one.method.name.into(),
            (100.0 * one.above / power).into(),
            finer,
            (100.0 * one.faint.above / faint).into(),
            one.flicker.into(),
            (100.0 * one.faint.flicker / faint_flicker).into(),
            up.into(),
            error.into(),
            one.opacity.into(),
        ]);
    }
    table
}

/// Power by frequency.
pub(super) fn plot(comparison: &Comparison, figure: &str) -> Plot {
    let [power, _] = comparison.power;
    let plot = Plot::curves(
        "spectrum",
        figure,
        "energy of the pictures beyond k by frequency; right of the line pixels cannot hold it",
        Axis::new("frequency along rows or columns, the larger (cycles per pixel)").range(0.0, 1.0),
        Axis::logarithmic("share of standard splatting's, per .05 cycles"),
    )
    .mark(Mark::Vertical {
        at: 0.5,
        label: "Nyquist limit".to_owned(),
    });
    comparison.measured.iter().fold(plot, |plot, one| {
        let points = one.bands.iter().map(|&[x, y]| [x, (y / power).max(1e-8)]);
        plot.curve(Curve::new(one.method.name, points).dots())
    })
}

/// The pictures, as the paper shows them, and their reference.
pub(super) fn plate(comparison: &Comparison, figure: &str, k: f64) -> Plate {
    let samples = comparison.samples * comparison.samples;
    let caption =
        "Without anti-aliasing, a black line at k where it is crossed; with it; and what it should be";
    let plate = Plate::new("pictures", figure, caption);
    let plate = comparison.measured.iter().fold(plate, |plate, one| {
        let image = match one.method.key {
            "plain" => with_line_at(&one.frame, k),
            _ => over_white(&one.frame.image),
        };
        plate.panel(one.method.name, image)
    });
    plate.panel(
        &format!("mean of {samples} samples per pixel"),
        over_white(&comparison.truth),
    )
}
