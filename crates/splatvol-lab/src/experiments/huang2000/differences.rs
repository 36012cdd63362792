//! Pictures by FastSplats against a precise one: the phantom cube of section 5.1 and Fig. 9 (c).

use glam::{DVec2, DVec3};
use splatvol::radial::{Precision, Spacing, TableSettings};
use splatvol::{
    Camera, ColorPoint, FlatSettings, Grid, Image, ImageSize, OpacityPoint, Rasterizer, RenderSettings,
    Samples, Scene, TableLayout, TablePrecision, TransferFunction, View, Volume,
};

use super::data;
use super::eight_bits::{self, Cube, Lookup, Rounding};
use super::method::{Subject, fastsplats};
use crate::measure::mean;
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, Published, Table,
    Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "huang2000-differences",
    paper: "huang2000",
    title: "Pixel-to-pixel differences on the phantom cube",
    figures: &["Section 5.1", "Fig. 9"],
    about: "The paper renders a phantom cube in 8-bit grey. The reference is the linear FastSplat with tables of 256 entries of 16 bits. \
Square and RLUT with 10 x 10 positions take 128 entries of 8 bits. It reports the mean and the largest absolute difference over all pixels that the cube touches.

Of the cube nothing more is told. Ours is 40 voxels along an edge, grey, opaque, lit by a headlight, in a volume of 64 x 64 x 64, seen from a corner at \
512 x 512. Grey is rounded to 8 bits at the end.

The paper's buffers had 8 bits per channel for pre-classified splatting. Ours hold floating-point numbers, so that only the tables err. \
To see what the buffers did, a second, small splatter renders a cube into buffers of 8 bits, which round after every splat and every sheet: to the nearest level, or down. Its cube has 24 voxels along an edge, 4.3 pixels each, of grey .8 and \
opacity .95, seen obliquely. These are ours too; what cubes of other sizes make of it stands beside the numbers.",
    run,
};

/// The methods compared, with the published mean and largest differences.
const METHODS: [(&str, Rasterizer, [f64; 2]); 2] = [
    ("square", Rasterizer::Square1d, [3.36, 14.0]),
    ("RLUT", Rasterizer::Rlut { subpixels: 10 }, [3.73, 17.0]),
];

/// A grey cube in the middle of a volume of this edge.
fn phantom(edge: usize) -> Result<Scene, LabError> {
    let inside = |at: usize| (edge * 3 / 16..edge * 13 / 16).contains(&at);
    let value = |index: usize| {
        let place = [index % edge, index / edge % edge, index / (edge * edge)];
        if place.into_iter().all(inside) { 200 } else { 0 }
    };
    let samples = Samples::U8((0..edge * edge * edge).map(value).collect());
    let grid = Grid::centred([edge; 3], DVec3::ONE)?;
    let volume = Volume::new(grid, samples, Default::default(), Default::default())?;
    let grey = TransferFunction::new(
        vec![ColorPoint::new(0.0, [0.9; 3])],
        vec![OpacityPoint::new(50.0, 0.0), OpacityPoint::new(100.0, 0.95)],
        None,
    )?;
    Ok(Scene::new(volume, grey))
}

/// Grey in 8-bit levels, and whether a pixel is touched.
fn grey(image: &Image) -> Vec<(f64, bool)> {
    let level = |pixel: &[f32; 4]| {
        let value = (255.0 * f64::from(pixel[0])).round().clamp(0.0, 255.0);
        (value, pixel[3] > 0.0)
    };
    image.pixels.iter().map(level).collect()
}

/// Differences of the pixels that either picture touches, in levels.
fn differences(a: &Image, b: &Image) -> Vec<f64> {
    let pairs = grey(a).into_iter().zip(grey(b));
    pairs
        .filter(|(a, b)| a.1 || b.1)
        .map(|(a, b)| (a.0 - b.0).abs())
        .collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    bench.step(0, 3, "phantom cube");
    let scene = phantom(bench.choose(64, 32))?;
    let camera = data::orthographic(&scene, View::Iso)?;
    let edge = bench.choose(512, 256);
    let base = fastsplats(ImageSize::new(edge, edge)?, Rasterizer::Linear1d);
    let reference = RenderSettings::try_from(FlatSettings {
        table: TableLayout {
            entries: 256,
            precision: TablePrecision::U16,
            ..TableLayout::default()
        },
        ..base
    })?;
    let reference = image(&scene, &camera, reference)?;
    let mut compared = Vec::new();
    for (name, rasterizer, published) in METHODS {
        let settings = RenderSettings::try_from(FlatSettings { rasterizer, ..base })?;
        let found = differences(&image(&scene, &camera, settings)?, &reference);
        compared.push((name, found, published));
    }
    bench.step(1, 3, "buffers of 8 bits");
    let buffers = buffers(bench)?;
    let mut outcome = Outcome::default();
    findings(&mut outcome, &compared, &buffers);
    outcome.tables.push(numbers(&compared, &buffers));
    outcome.plots.push(histogram(&compared));
    bench.step(2, 3, "picture");
    let square = RenderSettings::try_from(FlatSettings {
        rasterizer: Rasterizer::Square1d,
        ..base
    })?;
    let plate = Plate::new("cube", "Fig. 9 (c)", "the phantom cube, by the square FastSplat");
    outcome
        .plates
        .push(plate.panel("(c) phantom cube", image(&scene, &camera, square)?));
    Ok(outcome)
}

fn image(scene: &Scene, camera: &Camera, settings: RenderSettings) -> Result<Image, LabError> {
    Ok(Subject::new(scene, camera, settings)?.render()?.image)
}

/// Mean and largest difference of square and RLUT by the small splatter.
struct Buffers {
    nearest: [[f64; 2]; 2],
    down: [[f64; 2]; 2],
    unrounded: [[f64; 2]; 2],
    /// Differences rounded down, of cubes of other sizes: least and greatest.
    others: [[[f64; 2]; 2]; 2],
}

/// Voxels along an edge and pixels per voxel of the other cubes.
const OTHER_CUBES: [(usize, f64); 6] = [(12, 4.3), (16, 6.0), (20, 5.0), (24, 3.0), (24, 6.0), (32, 4.3)];

fn buffers(bench: &Workbench<'_>) -> Result<Buffers, LabError> {
    let table = |entries, precision, spacing| TableSettings {
        entries,
        precision,
        spacing,
        sections: 128,
    };
    let cube = Cube {
        voxels: bench.choose(24, 12),
        towards_viewer: DVec3::new(-0.62, 0.70, 0.36),
        scale: 4.3,
        opacity: 0.95,
        grey: 0.8,
    };
    let reference = Lookup {
        table: table(256, Precision::U16, Spacing::Linear),
        cells: None,
    };
    let square = Lookup {
        table: table(128, Precision::U8, Spacing::Squared),
        cells: None,
    };
    let rlut = Lookup {
        cells: Some(10.0),
        ..square
    };
    let compare = |cube: &Cube, rounding: Rounding| -> Result<[[f64; 2]; 2], LabError> {
        let reference: Vec<DVec2> = eight_bits::render(cube, reference, rounding)?;
        let against = |lookup| eight_bits::render(cube, lookup, rounding);
        Ok([
            eight_bits::difference(&against(square)?, &reference),
            eight_bits::difference(&against(rlut)?, &reference),
        ])
    };
    let mut others = [[[f64::INFINITY, f64::NEG_INFINITY]; 2]; 2];
    for &(voxels, scale) in OTHER_CUBES.iter().take(bench.choose(6, 2)) {
        let other = compare(
            &Cube {
                voxels,
                scale,
                ..cube
            },
            Rounding::Down,
        )?;
        for (range, value) in others.as_flattened_mut().iter_mut().zip(other.as_flattened()) {
            *range = [range[0].min(*value), range[1].max(*value)];
        }
    }
    Ok(Buffers {
        nearest: compare(&cube, Rounding::Nearest)?,
        down: compare(&cube, Rounding::Down)?,
        unrounded: compare(&cube, Rounding::None)?,
        others,
    })
}

type Compared = (&'static str, Vec<f64>, [f64; 2]);

fn findings(outcome: &mut Outcome, compared: &[Compared], buffers: &Buffers) {
    for (index, (name, found, published)) in compared.iter().enumerate() {
        let key = name.to_lowercase();
        let numbers = [mean(found), largest(found)];
        for (which, what) in ["mean", "largest"].into_iter().enumerate() {
            let [nearest, down, exact] =
                [buffers.nearest, buffers.down, buffers.unrounded].map(|all| all[index][which]);
            outcome.find(
                Finding::new(
                    "Section 5.1",
                    &format!("{key}-{what}"),
                    &format!("{what} difference of {name} from linear with 16 bits, phantom cube"),
                    numbers[which],
                    Expectation::relative(published[which], 0.25),
                )
                .unit("levels")
                .published(Published::Number(published[which]))
                .explained_by(
                    "the paper's buffers have 8 bits: rounding to the nearest after every splat multiplies the difference",
                    nearest / exact,
                    Expectation::AtLeast(1.5),
                )
                .explained_by(
                    "rounding down, as shifted integers do, multiplies it",
                    down / exact,
                    Expectation::AtLeast(1.5),
                ),
            );
        }
    }
    let [square, rlut] = compared else { return };
    outcome.find(
        Finding::new(
            "Section 5.1",
            "rlut-over-square",
            "mean difference of RLUT over that of square",
            mean(&rlut.1) / mean(&square.1),
            Expectation::relative(3.73 / 3.36, 0.1),
        )
        .published(Published::Number(3.73 / 3.36)),
    );
    buffer_findings(outcome, buffers);
}

/// The published numbers again, in buffers of 8 bits.
fn buffer_findings(outcome: &mut Outcome, buffers: &Buffers) {
    for (index, (name, _, published)) in METHODS.into_iter().enumerate() {
        for (which, what) in ["mean", "largest"].into_iter().enumerate() {
            outcome.find(
                Finding::new(
                    "Section 5.1",
                    &format!("buffers-{}-{what}", name.to_lowercase()),
                    &format!("{what} difference of {name} in buffers of 8 bits that round down, by the small splatter"),
                    buffers.down[index][which],
                    Expectation::relative(published[which], 0.25),
                )
                .unit("levels")
                .published(Published::Number(published[which]))
                .detail(format!(
                    "to the nearest {:.2}; down, cubes of other sizes, {:.2} to {:.2}",
                    buffers.nearest[index][which], buffers.others[index][which][0], buffers.others[index][which][1]
                )),
            );
        }
    }
}

fn numbers(compared: &[Compared], buffers: &Buffers) -> Table {
    let mut table = Table::new(
        "differences",
        "Section 5.1",
        "Differences from linear with 256 entries of 16 bits, 8-bit levels",
        &[
            "picture",
            "method",
            "mean",
            "largest",
            "published mean",
            "published largest",
        ],
    );
    for (name, found, published) in compared {
        table.row([
            "phantom cube".into(),
            (*name).into(),
            mean(found).into(),
            largest(found).into(),
            published[0].into(),
            published[1].into(),
        ]);
    }
    for (what, numbers) in [
        ("small splatter, 8 bits, nearest", &buffers.nearest),
        ("small splatter, 8 bits, down", &buffers.down),
        ("small splatter, no rounding", &buffers.unrounded),
    ] {
        for ((name, _, published), [mean, largest]) in compared.iter().zip(numbers) {
            table.row([
                what.into(),
                (*name).into(),
                (*mean).into(),
                (*largest).into(),
                published[0].into(),
                published[1].into(),
            ]);
        }
    }
    table
}

/// Share of touched pixels by their difference.
fn histogram(compared: &[Compared]) -> Plot {
    let most = compared.iter().map(|one| largest(&one.1)).fold(1.0, f64::max) as usize;
    let start = Plot::curves(
        "differences",
        "Section 5.1",
        "phantom cube: how many pixels differ by how much",
        Axis::new("difference (8-bit levels)"),
        Axis::new("pixels (share of those touched)"),
    );
    compared.iter().fold(start, |plot, (name, found, _)| {
        let share = |level: usize| {
            let count = found.iter().filter(|one| **one == level as f64).count();
            count as f64 / found.len().max(1) as f64
        };
        let curve = Curve::new(name, (0..=most).map(|level| [level as f64, share(level)])).dots();
        plot.curve(if *name == "RLUT" { curve.dashed() } else { curve })
    })
}
