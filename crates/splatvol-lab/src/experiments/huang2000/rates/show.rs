//! Rows and plots of Fig. 5 and 6.

use super::{RADII, Rates};
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

pub(super) fn plot(figure: &str, name: &str, rates: &Rates) -> Plot {
    let start = Plot::curves(
        name,
        figure,
        "scan-conversion rates by the radius",
        Axis::new("radius (pixels)"),
        Axis::logarithmic("million pixels per second"),
    );
    rates
        .methods
        .iter()
        .zip(&rates.values)
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
