//! Figure 9: contours of three kernels in perspective space, and the errors of their ray integrals.

use super::alignment::{Kernel, Row, STEEPNESS, Setting};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plot, Published, Table, Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "mueller1998-kernels",
    paper: "mueller1998",
    title: "Kernels in perspective space, and the errors of their ray integrals",
    figures: &["Fig. 9", "Section 4.2"],
    about: "The paper draws a Gaussian kernel in perspective space as it is (Table 1, row 1), aligned with the grid \
(row 5) and perpendicular to the ray through its centre (row 4). It also draws the errors that the ray integrals of \
the two approximate footprints have. It does so at three voxels of a volume of 512^3 in a picture of 512^2, within \
30 degrees of the axis.\n\n\
We evaluate the corrected equations in 64 bits. The three voxels are on the axis at z_k, at the volume's edge at z_k, and at the edge \
of its far face. Errors are in levels of eight bits of the footprint's largest value, as the paper counts \"bits\". The kernel is \
`exp(-1.38 r^2)`, cut at 2; the last finding is what a standard deviation of 1.38 voxels, as the text has it, would give.",
    run,
};

/// A voxel of the figure.
struct Column {
    key: &'static str,
    words: &'static str,
    kernel: Kernel,
}

fn columns(setting: &Setting) -> [Column; 3] {
    let [_, far] = setting.depths();
    [
        Column {
            key: "axis",
            words: "on the axis at z_k",
            kernel: setting.kernel(0.0, 0.0),
        },
        Column {
            key: "edge",
            words: "at the volume's edge at z_k",
            kernel: setting.kernel(setting.edge(), 0.0),
        },
        Column {
            key: "far",
            words: "at the edge of the far face",
            kernel: setting.kernel(setting.edge(), far),
        },
    ]
}

const KERNELS: [(Row, &str); 3] = [
    (Row::Trapezoid, "correct"),
    (Row::Grid, "along the grid"),
    (Row::Ray, "across the ray"),
];

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let setting = Setting::new(512.0);
    let rays = bench.choose(801, 161);
    let mut outcome = Outcome::default();
    for column in columns(&setting) {
        outcome.plots.push(contours(&column));
        outcome.plots.push(errors(&column, rays));
        bounds(&mut outcome, &column, rays);
    }
    ideal_and_practical(&mut outcome, &setting, rays);
    as_printed(&mut outcome, &setting, rays);
    outcome.tables.push(table(&setting, rays));
    Ok(outcome)
}

/// The line where a kernel has this share of its own height, around its centre: pixels, and voxels behind it.
fn contour(kernel: &Kernel, row: Row, level: f64) -> Vec<[f64; 2]> {
    const POINTS: usize = 96;
    let centre = [kernel.centre(), kernel.z];
    let height = kernel.density(row, centre[0], centre[1]);
    let point = |index: usize| {
        let turn = std::f64::consts::TAU * index as f64 / POINTS as f64;
        let at = |radius: f64| [centre[0] + radius * turn.cos(), centre[1] + radius * turn.sin()];
        let (mut low, mut high) = (0.0, 3.0 * kernel.reach());
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            let [y_p, z] = at(middle);
            match kernel.density(row, y_p, z) > level * height {
                true => low = middle,
                false => high = middle,
            }
        }
        let [y_p, z] = at(low);
        [y_p - centre[0], z - kernel.z]
    };
    (0..=POINTS).map(point).collect()
}

fn contours(column: &Column) -> Plot {
    let mut plot = Plot::curves(
        &format!("contours-{}", column.key),
        "Fig. 9",
        &format!(
            "the kernel {}: where it is a half and a tenth of its height",
            column.words
        ),
        Axis::new("y_p from the centre's ray (pixels)").range(-2.5, 2.5),
        Axis::new("z from the centre (voxels)").range(-1.5, 1.5),
    )
    .equal();
    for (row, name) in KERNELS {
        for (level, words) in [(0.5, "1/2"), (0.1, "1/10")] {
            let curve = Curve::new(&format!("{name}, {words}"), contour(&column.kernel, row, level));
            plot = plot.curve(if row == Row::Trapezoid {
                curve
            } else {
                curve.dashed()
            });
        }
    }
    plot
}

fn errors(column: &Column, rays: usize) -> Plot {
    let kernel = &column.kernel;
    let peak = kernel.errors(Row::Grid, rays).peak;
    let curve = |row: Row, name: &str| {
        let error = |y_p: f64| {
            let error = kernel.integral(row, y_p) - kernel.integral(Row::Trapezoid, y_p);
            [y_p - kernel.centre(), 256.0 * error.abs() / peak]
        };
        Curve::new(name, kernel.rays(121).map(error))
    };
    Plot::curves(
        &format!("errors-{}", column.key),
        "Fig. 9",
        &format!("errors of the ray integrals {}", column.words),
        Axis::new("y_p from the centre's ray (pixels)"),
        Axis::new("error (levels of 256 of the peak)"),
    )
    .curve(curve(Row::Grid, "along the grid"))
    .curve(curve(Row::Ray, "across the ray"))
    .curve(curve(Row::RayIdeal, "across the ray, ideal").dashed())
}

fn bounds(outcome: &mut Outcome, column: &Column, rays: usize) {
    let [grid, ray] = [Row::Grid, Row::Ray].map(|row| column.kernel.errors(row, rays).levels());
    let claims = match column.key {
        "axis" => [("less than 1", Expectation::AtMost(1.0)); 2],
        "edge" => [
            ("more than 25", Expectation::AtLeast(25.0)),
            ("less than 2", Expectation::AtMost(2.0)),
        ],
        _ => [("less than 8", Expectation::AtMost(8.0)); 2],
    };
    for ((name, key, measured), (claim, expected)) in
        [("along the grid", "grid", grid), ("across the ray", "ray", ray)]
            .into_iter()
            .zip(claims)
    {
        outcome.find(
            Finding::new(
                "Fig. 9",
                &format!("{key}-{}", column.key),
                &format!("largest error of the footprint {name}, {}", column.words),
                measured,
                expected,
            )
            .unit("levels")
            .published(Published::Claim(claim.to_owned())),
        );
    }
}

fn ideal_and_practical(outcome: &mut Outcome, setting: &Setting, rays: usize) {
    let apart = |column: &Column| {
        let kernel = &column.kernel;
        let peak = kernel.errors(Row::Ray, rays).peak;
        let apart = |y_p: f64| (kernel.integral(Row::Ray, y_p) - kernel.integral(Row::RayIdeal, y_p)).abs();
        256.0 * kernel.rays(rays).map(apart).fold(0.0, f64::max) / peak
    };
    let largest = columns(setting).iter().map(apart).fold(0.0, f64::max);
    outcome.find(
        Finding::new(
            "Fig. 9",
            "ideal-against-practical",
            "largest difference of the ideal and the practical ray-perpendicular footprint at the three voxels",
            largest,
            Expectation::AtMost(1.0),
        )
        .unit("levels")
        .published(Published::Claim("not much difference".to_owned())),
    );
}

/// Errors with the standard deviation given in the text, where the text says that errors are below eight levels.
fn as_printed(outcome: &mut Outcome, setting: &Setting, rays: usize) {
    let [_, far] = setting.depths();
    let kernel = setting.kernel(setting.edge(), far);
    let printed = Kernel {
        steepness: 0.5 / STEEPNESS.powi(2),
        ..kernel
    };
    let largest = |kernel: &Kernel| {
        let errors = [Row::Grid, Row::Ray].map(|row| kernel.errors(row, rays).levels());
        errors[0].max(errors[1])
    };
    outcome.find(
        Finding::new(
            "Fig. 9",
            "printed-sigma",
            "larger error of the two footprints at the edge of the far face, of a kernel whose standard deviation is 1.38",
            largest(&printed),
            Expectation::AtMost(8.0),
        )
        .unit("levels")
        .published(Published::Claim("less than 8".to_owned()))
        .explained_by(
            "1.38 is the factor in the exponent: with exp(-1.38 r^2) the bound holds",
            largest(&kernel),
            Expectation::AtMost(8.0),
        ),
    );
}

fn table(setting: &Setting, rays: usize) -> Table {
    let columns_of = [
        "voxel",
        "y (voxels)",
        "z - z_k (voxels)",
        "box (levels)",
        "ideal ray (levels)",
        "ray (levels)",
        "grid (levels)",
    ];
    let mut table = Table::new(
        "errors",
        "Fig. 9",
        "largest errors of ray integrals, levels of 256 of the footprint's peak",
        &columns_of,
    );
    for column in columns(setting) {
        let kernel = column.kernel;
        let mut cells = vec![
            column.words.into(),
            kernel.y.into(),
            (kernel.z - setting.z_k).into(),
        ];
        let approximate = &Row::TABLE[1..];
        cells.extend(
            approximate
                .iter()
                .map(|&row| kernel.errors(row, rays).levels().into()),
        );
        table.row(cells);
    }
    table
}
