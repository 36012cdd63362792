//! Pictures by FastSplats against a precise one: the phantom cube of section 5.1 and Fig. 9 (c).

use glam::DVec3;
use splatvol::{
    Camera, ColorPoint, FlatSettings, Grid, Image, ImageSize, OpacityPoint, Rasterizer, RenderSettings,
    Samples, Scene, SheetPrecision, TableLayout, TablePrecision, TransferFunction, View, Volume,
};

use super::data;
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
512 x 512. Sheets and picture have 8 bits per channel, as the paper's for classified data (`--sheet-precision u8`, which cuts what is added to whole levels). \
The same in single precision, where only the tables err, and on cubes of other sizes stands beside it.",
    run,
};

/// The methods compared, with the published mean and largest differences.
const METHODS: [(&str, Rasterizer, [f64; 2]); 2] = [
    ("square", Rasterizer::Square1d, [3.36, 14.0]),
    ("RLUT", Rasterizer::Rlut { subpixels: 10 }, [3.73, 17.0]),
];

/// A grey cube in the middle of a volume, voxels along their edges.
fn phantom([cube, edge]: [usize; 2]) -> Result<Scene, LabError> {
    let first = (edge - cube) / 2;
    let inside = |at: usize| (first..first + cube).contains(&at);
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

/// A cube in a picture of so many pixels.
struct Phantom {
    scene: Scene,
    camera: Camera,
    size: ImageSize,
}

impl Phantom {
    fn new(voxels: [usize; 2], edge: u32) -> Result<Self, LabError> {
        let scene = phantom(voxels)?;
        Ok(Self {
            camera: data::orthographic(&scene, View::Iso)?,
            scene,
            size: ImageSize::new(edge, edge)?,
        })
    }

    fn image(&self, settings: FlatSettings) -> Result<Image, LabError> {
        let settings = RenderSettings::try_from(settings)?;
        Ok(Subject::new(&self.scene, &self.camera, settings)?.render()?.image)
    }

    /// Differences of the methods from the linear one with 256 entries of 16 bits, on sheets of one precision.
    fn compared(&self, sheet_precision: SheetPrecision) -> Result<Vec<Vec<f64>>, LabError> {
        let base = FlatSettings {
            sheet_precision,
            ..fastsplats(self.size, Rasterizer::Linear1d)
        };
        let reference = self.image(FlatSettings {
            table: TableLayout {
                entries: 256,
                precision: TablePrecision::U16,
                ..TableLayout::default()
            },
            ..base
        })?;
        let of = |(_, rasterizer, _): &(&str, Rasterizer, [f64; 2])| {
            let image = self.image(FlatSettings {
                rasterizer: *rasterizer,
                ..base
            })?;
            Ok(differences(&image, &reference))
        };
        METHODS.iter().map(of).collect()
    }
}

/// Voxels along the edges of the other cubes.
const OTHER_CUBES: [usize; 4] = [16, 24, 32, 52];

/// Differences by method.
struct Compared {
    few: Vec<Vec<f64>>,
    single: Vec<Vec<f64>>,
    /// On sheets of 8 bits, cube by cube.
    others: Vec<Vec<Vec<f64>>>,
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    bench.step(0, 3, "phantom cube");
    let (voxels, pixels) = (bench.choose(64, 32), bench.choose(512, 256));
    let cube = Phantom::new([voxels * 5 / 8, voxels], pixels)?;
    let (few, single) = (
        cube.compared(SheetPrecision::U8)?,
        cube.compared(SheetPrecision::F32)?,
    );
    bench.step(1, 3, "cubes of other sizes");
    let other =
        |edge: &usize| Phantom::new([edge * voxels / 64, voxels], pixels)?.compared(SheetPrecision::U8);
    let others = OTHER_CUBES.iter().take(bench.choose(4, 1)).map(other);
    let compared = Compared {
        few,
        single,
        others: others.collect::<Result<_, _>>()?,
    };
    let mut outcome = Outcome::default();
    findings(&mut outcome, &compared);
    outcome.tables.push(numbers(&compared));
    outcome.plots.push(histogram(&compared.few));
    bench.step(2, 3, "picture");
    let square = FlatSettings {
        sheet_precision: SheetPrecision::U8,
        ..fastsplats(cube.size, Rasterizer::Square1d)
    };
    let plate = Plate::new("cube", "Fig. 9 (c)", "the phantom cube, by the square FastSplat");
    outcome
        .plates
        .push(plate.panel("(c) phantom cube", cube.image(square)?));
    Ok(outcome)
}

fn findings(outcome: &mut Outcome, compared: &Compared) {
    let numbers = |found: &[f64]| [mean(found), largest(found)];
    for (index, (name, _, published)) in METHODS.into_iter().enumerate() {
        let (few, single) = (numbers(&compared.few[index]), numbers(&compared.single[index]));
        for (which, what) in ["mean", "largest"].into_iter().enumerate() {
            let others = compared.others.iter().map(|cube| numbers(&cube[index])[which]);
            let [least, most] = others.fold([few[which]; 2], |[a, b], other| [a.min(other), b.max(other)]);
            outcome.find(
                Finding::new(
                    "Section 5.1",
                    &format!("{}-{what}", name.to_lowercase()),
                    &format!(
                        "{what} difference of {name} from linear with 16 bits, phantom cube, sheets of 8 bits"
                    ),
                    few[which],
                    Expectation::relative(published[which], 0.25),
                )
                .unit("levels")
                .published(Published::Number(published[which]))
                .detail(format!(
                    "sheets of single precision {:.2}; cubes of other sizes {least:.2} to {most:.2}",
                    single[which]
                )),
            );
        }
    }
    let [square, rlut] = &compared.few[..] else { return };
    outcome.find(
        Finding::new(
            "Section 5.1",
            "rlut-over-square",
            "mean difference of RLUT over that of square",
            mean(rlut) / mean(square),
            Expectation::relative(3.73 / 3.36, 0.1),
        )
        .published(Published::Number(3.73 / 3.36)),
    );
}

fn numbers(compared: &Compared) -> Table {
    let mut table = Table::new(
        "differences",
        "Section 5.1",
        "Differences from linear with 256 entries of 16 bits, 8-bit levels",
        &[
            "sheets",
            "method",
            "mean",
            "largest",
            "published mean",
            "published largest",
        ],
    );
    for (what, all) in [("8 bits", &compared.few), ("single precision", &compared.single)] {
        for ((name, _, published), found) in METHODS.into_iter().zip(all) {
            table.row([
                what.into(),
                name.into(),
                mean(found).into(),
                largest(found).into(),
                published[0].into(),
                published[1].into(),
            ]);
        }
    }
    table
}

/// Share of touched pixels by their difference.
fn histogram(compared: &[Vec<f64>]) -> Plot {
    let most = compared.iter().map(|one| largest(one)).fold(1.0, f64::max) as usize;
    let start = Plot::curves(
        "differences",
        "Section 5.1",
        "phantom cube, sheets of 8 bits: how many pixels differ by how much",
        Axis::new("difference (8-bit levels)"),
        Axis::new("pixels (share of those touched)"),
    );
    METHODS
        .into_iter()
        .zip(compared)
        .fold(start, |plot, ((name, _, _), found)| {
            let share = |level: usize| {
                let count = found.iter().filter(|one| **one == level as f64).count();
                count as f64 / found.len().max(1) as f64
            };
            let curve = Curve::new(name, (0..=most).map(|level| [level as f64, share(level)])).dots();
            plot.curve(if name == "RLUT" { curve.dashed() } else { curve })
        })
}
