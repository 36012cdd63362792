//! Rows and plots of Fig. 5 and 6.

use super::{ENGINE, RADII, Rates};
use crate::experiments::huang2000::method::FASTSPLATS;
use crate::{Axis, Curve, Plot, Table};

pub(super) fn numbers(figure: &str, name: &str, rates: &Rates) -> Table {
    let mut columns = vec!["radius (pixels)"];
    columns.extend(&rates.methods);
    let mut table = Table::new(name, figure, "Million pixels per second", &columns);
    for (index, radius) in RADII.into_iter().enumerate() {
        let of_radius = rates.values.iter().map(|values| (values[index] / 1e6).into());
        table.row(std::iter::once(radius.into()).chain(of_radius));
    }
    table
}

/// The paper's curves and ours of the same engine on a linear scale; and all, with the default engine's, on a
/// logarithmic one.
pub(super) fn plots(figure: &str, name: &str, rates: &Rates) -> [Plot; 2] {
    let plot = |name: &str, caption: &str, axis: Axis| {
        Plot::curves(name, figure, caption, Axis::new("radius (pixels)"), axis)
    };
    let unit = "million pixels per second";
    let by_engine = rates
        .methods
        .iter()
        .zip(&rates.values)
        .filter(|one| *one.0 != ENGINE);
    let most = by_engine.flat_map(|one| one.1).copied().fold(0.0, f64::max);
    let axis = Axis::new(unit).range(0.0, 1.1e-6 * most);
    let looked_up = plot(name, "scan-conversion rates by the radius", axis);
    let caption = "the same, and the default engine";
    let with_engine = plot(
        &format!("{name}-default-engine"),
        caption,
        Axis::logarithmic(unit),
    );
    [
        curves(looked_up, rates, |method| method != ENGINE),
        curves(with_engine, rates, |_| true),
    ]
}

fn curves(start: Plot, rates: &Rates, is_shown: impl Fn(&str) -> bool) -> Plot {
    rates
        .methods
        .iter()
        .zip(&rates.values)
        .filter(|(method, _)| is_shown(method))
        .fold(start, |plot, (method, values)| {
            let points = RADII
                .iter()
                .zip(values)
                .map(|(&radius, rate)| [radius, rate / 1e6]);
            let curve = Curve::new(method, points).dots();
            plot.curve(match FASTSPLATS.iter().any(|one| one.0 == *method) {
                true => curve,
                false => curve.dashed(),
            })
        })
}
