//! Fig. 2, 3 and 4: size and energy of one splat by its distance, and the spacing of the rays there.

use splatvol::{Camera, Filter, ImageSize, Projection};

use super::single::{Moments, Single};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Mark, Outcome, Plot, Published, Table, Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "swan1997-splat-size",
    paper: "swan1997",
    title: "Size and energy of a splat by its distance",
    figures: &["Fig. 2", "Fig. 3", "Fig. 4"],
    about: "The paper draws how splats are scaled: as they are before the distance k (eq. 3), larger in space in proportion to \
the distance beyond it (eq. 4), so that they all have the same size on screen, and with less energy per area, (k / d)^2 \
(eq. 8), so that each gives the picture as much energy as if it had not been scaled.\n\n\
We draw a single splat on the axis, 100 pixels per unit of slope, as an X-ray, and move it away. Size is the standard \
deviation of what is seen, energy its sum, both from many pictures whose pixels lie shifted against each other.",
    run,
};

/// Pixels per unit of slope: k in voxels.
const SCALE: f64 = 100.0;
const EWA: Filter = Filter::Ewa { pixel_sigma: 0.55 };

/// A splat at one distance.
struct Row {
    /// d / k.
    distance: f64,
    plain: Moments,
    swan: Moments,
    ewa: Moments,
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let distances = [0.25, 0.35, 0.5, 0.7, 0.9, 1.0, 1.4, 2.0, 2.8, 4.0];
    let mut renderer = bench.renderer()?;
    let single = Single::new(SCALE, bench.choose(16, 12))?;
    let mut rows = Vec::new();
    for (index, distance) in distances.into_iter().enumerate() {
        bench.step(index, distances.len(), "splats");
        let mut of = |filter| single.moments(&mut renderer, filter, (distance * SCALE, 0.0));
        rows.push(Row {
            distance,
            plain: of(Filter::None)?,
            swan: of(Filter::Swan)?,
            ewa: of(EWA)?,
        });
    }
    let mut outcome = Outcome::default();
    sizes(&mut outcome, &rows);
    energies(&mut outcome, &rows);
    outcome.find(ray_spacing()?);
    outcome.tables.push(table(&rows));
    outcome.plots.push(plot(&rows));
    Ok(outcome)
}

/// The largest of some numbers.
fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, f64::max)
}

/// Slope of the least-squares line through the logarithms.
fn exponent(points: impl Iterator<Item = [f64; 2]> + Clone) -> f64 {
    let points: Vec<[f64; 2]> = points.map(|point| point.map(f64::ln)).collect();
    let n = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / n;
    let [x, y] = [mean(0), mean(1)];
    let covariance: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    let variance: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
    covariance / variance
}

fn sizes(outcome: &mut Outcome, rows: &[Row]) {
    let beyond = || rows.iter().filter(|row| row.distance >= 1.0);
    let at_k = beyond().next().map_or(f64::NAN, |row| row.swan.deviation.x);
    outcome.find(
        Finding::new(
            "Fig. 3 (b)",
            "standard-size",
            "exponent of the distance in the size on screen, standard splatting",
            exponent(rows.iter().map(|row| [row.distance, row.plain.deviation.x])),
            Expectation::Near {
                value: -1.0,
                within: 0.02,
            },
        )
        .published(Published::Claim(
            "splats shrink with distance, as 1 / d".to_owned(),
        )),
    );
    outcome.find(
        Finding::new(
            "Fig. 3 (d)",
            "size-before-k",
            "largest change of size that the filter makes before k",
            largest(
                rows.iter()
                    .filter(|row| row.distance < 1.0)
                    .map(|row| (row.swan.deviation.x / row.plain.deviation.x - 1.0).abs()),
            ),
            Expectation::AtMost(0.001),
        )
        .published(Published::Claim("none".to_owned())),
    );
    outcome.find(
        Finding::new(
            "Fig. 3 (d)",
            "size-beyond-k",
            "largest deviation from the size at k, beyond it",
            largest(beyond().map(|row| (row.swan.deviation.x / at_k - 1.0).abs())),
            Expectation::AtMost(0.01),
        )
        .published(Published::Claim("all splats have the same size".to_owned())),
    );
}

fn energies(outcome: &mut Outcome, rows: &[Row]) {
    let beyond = rows.iter().filter(|row| row.distance >= 1.0);
    outcome.find(
        Finding::new(
            "Fig. 2",
            "energy",
            "largest change of a splat's energy on screen beyond k",
            largest(
                beyond
                    .clone()
                    .map(|row| (row.swan.mass / row.plain.mass - 1.0).abs()),
            ),
            Expectation::AtMost(0.01),
        )
        .published(Published::Claim("none: as if it had not been scaled".to_owned())),
    );
    outcome.find(
        Finding::new(
            "Fig. 2",
            "attenuation",
            "exponent of the distance in the energy per area beyond k (eq. 8)",
            exponent(beyond.map(|row| [row.distance, row.swan.peak / row.plain.peak])),
            Expectation::Near {
                value: -2.0,
                within: 0.02,
            },
        )
        .published(Published::Number(-2.0)),
    );
}

/// Fig. 4, eq. 9: rays at the distance 3 k lie three voxels apart, by the camera that draws all pictures.
fn ray_spacing() -> Result<Finding, LabError> {
    let size = ImageSize::new(270, 157)?;
    let projection = Projection::Perspective { fov_degrees: 60.0 };
    let camera = Camera::new(glam::DVec3::ZERO, glam::DVec3::X, glam::DVec3::Z, projection)?;
    let screen = camera.screen_from_camera(size);
    let spacing = 1.0;
    let k = spacing * screen.scale;
    let at = |column: f64| {
        let (origin, direction) = screen.ray(glam::DVec2::new(column, screen.centre.y));
        origin + 3.0 * k * direction
    };
    let apart = (at(screen.centre.x + 1.0) - at(screen.centre.x)).length();
    Ok(Finding::new(
        "Fig. 4",
        "ray-spacing",
        "distance between neighbouring rays at 3 k (eq. 9)",
        apart,
        Expectation::relative(3.0, 1e-9),
    )
    .unit("voxels")
    .published(Published::Number(3.0)))
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "sizes",
        "Fig. 3",
        "One splat by distance",
        &[
            "distance (k)",
            "size, standard (pixels)",
            "size, swan (pixels)",
            "size, ewa (pixels)",
            "energy, swan / standard",
            "peak, swan / standard",
        ],
    );
    for row in rows {
        table.row([
            row.distance.into(),
            row.plain.deviation.x.into(),
            row.swan.deviation.x.into(),
            row.ewa.deviation.x.into(),
            (row.swan.mass / row.plain.mass).into(),
            (row.swan.peak / row.plain.peak).into(),
        ]);
    }
    table
}

fn plot(rows: &[Row]) -> Plot {
    let curve = |name: &str, of: fn(&Row) -> &Moments| {
        Curve::new(name, rows.iter().map(|row| [row.distance, of(row).deviation.x])).dots()
    };
    Plot::curves(
        "sizes",
        "Fig. 3",
        "size of a splat on screen by its distance",
        Axis::logarithmic("distance (k)"),
        Axis::new("standard deviation on screen (pixels)"),
    )
    .curve(curve("standard", |row| &row.plain))
    .curve(curve("swan", |row| &row.swan).dashed())
    .curve(curve("ewa", |row| &row.ewa))
    .mark(Mark::Vertical {
        at: 1.0,
        label: "k".to_owned(),
    })
}
