//! Post-classified splatting: section 6.2, Fig. 8, and per-pixel operators, Fig. 9 (a) and (b).

mod findings;
mod show;

use splatvol::{
    Appearance, BumpMap, Camera, Classification, Extraction, FlatSettings, Image, ImageSize, PixelOperator,
    Rasterizer, RenderSettings, Scene, SheetSample, SolidTexture, Stuff, View,
};

use super::data;
use super::method::{Subject, fastsplats, picture_size, rounds, seconds};
use crate::{Experiment, LabError, Outcome, Workbench};
use findings::{fig8_findings, fig9_findings};
use show::{bars, fig8_numbers, fig9_numbers, plates};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "huang2000-post",
    paper: "huang2000",
    title: "Post-classified rendering times, solid texture and bump map",
    figures: &["Section 6.2", "Fig. 8", "Fig. 9"],
    about: "Post-classified sheets hold data, which is classified and lit pixel by pixel. The paper times four volumes by the square \
FastSplat, then the brain with a marble texture computed per pixel and with a bump map of the word *splat*.

We render look-alikes of the stated sizes (the data are not public), by the square FastSplat and one thread, at 512 x 512. *Brain* and *nerve* as in \
Table 1, the nerve oblique, so that its footprints are turned ellipses. *Injection*: a generated cone of spray, 64 x 64 x 64, in perspective. \
*Vessels*: branches of the sample nerve grown into 256 x 256 x 256 cubes, in perspective. Only voxels in the range of interest are splatted, on sheets a \
mean voxel spacing apart.

The program's FastSplats have no operators. Textures and bumps are made by its default engine, on sheets a voxel apart. It splats many times faster, \
so the same work per pixel is a larger share of a frame. We measure that too.",
    run,
};

/// A view of Fig. 8.
struct View8 {
    name: &'static str,
    scene: Scene,
    camera: Camera,
    rasterizer: Rasterizer,
    /// Published seconds.
    published: f64,
    /// Measured ones.
    post: f64,
    pre: f64,
    /// Sections drawn: post-classified, pre-classified.
    slices: [f64; 2],
}

impl View8 {
    /// Settings of the square method. Data are splatted only in the range of interest, as in section 1: visible voxels,
    /// and the voxels from a tenth of the range of values up that surround them.
    fn settings(&self, size: ImageSize, classification: Classification) -> Result<RenderSettings, LabError> {
        let single = self.scene.single_volume()?;
        let [low, high] = single.volume.value_range();
        let opacities = single.transfer_function.opacities();
        let visible = opacities.iter().map(|point| point.value).fold(high, f64::min);
        let from = visible.min(low + 0.1 * (high - low));
        let data = classification == Classification::Post;
        Ok(RenderSettings::try_from(FlatSettings {
            classification,
            extraction: data.then_some(Extraction {
                density: Some([from, high]),
                gradient: 0.0,
            }),
            ..fastsplats(size, self.rasterizer)
        })?)
    }
}

fn views(bench: &Workbench<'_>) -> Result<Vec<View8>, LabError> {
    let view = |name, scene: Scene, perspective: bool, published| -> Result<View8, LabError> {
        let camera = match perspective {
            true => data::perspective(&scene, View::Iso)?,
            false => data::orthographic(&scene, View::Iso)?,
        };
        Ok(View8 {
            name,
            scene,
            camera,
            rasterizer: Rasterizer::Square1d,
            published,
            post: f64::NAN,
            pre: f64::NAN,
            slices: [f64::NAN; 2],
        })
    };
    Ok(vec![
        view("brain", data::brain(bench)?, false, 6.60)?,
        View8 {
            rasterizer: Rasterizer::Ellipse1d,
            ..view("nerve", data::nerve(bench)?, false, 10.87)?
        },
        view("injection", data::injection(bench)?, true, 3.33)?,
        view("vessels", data::vessels(bench)?, true, 4.18)?,
    ])
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    bench.step(0, 5, "volumes");
    let mut views = views(bench)?;
    bench.step(1, 5, "post-classified and pre-classified");
    measure(bench, &mut views)?;
    let mut outcome = Outcome::default();
    fig8_findings(&mut outcome, &views);
    bench.step(3, 5, "operators");
    let operated = operators(bench, &views[0])?;
    fig9_findings(&mut outcome, &operated);
    bench.step(4, 5, "pictures");
    outcome.plates = plates(bench, &views)?;
    outcome.tables = vec![fig8_numbers(&views), fig9_numbers(&operated)];
    outcome.plots.push(bars(&views));
    Ok(outcome)
}

fn measure(bench: &Workbench<'_>, views: &mut [View8]) -> Result<(), LabError> {
    let size = picture_size(bench)?;
    let mut subjects = Vec::new();
    for view in views.iter() {
        for classification in [Classification::Post, Classification::Pre] {
            let settings = view.settings(size, classification)?;
            subjects.push(Subject::new(&view.scene, &view.camera, settings)?);
        }
    }
    let seconds = seconds(&mut subjects, rounds(bench))?;
    let slices: Vec<f64> = subjects
        .iter()
        .map(|one| one.statistics().slices as f64)
        .collect();
    drop(subjects);
    for (index, view) in views.iter_mut().enumerate() {
        [view.post, view.pre] = [seconds[2 * index], seconds[2 * index + 1]];
        view.slices = [slices[2 * index], slices[2 * index + 1]];
    }
    Ok(())
}

/// Seconds of the brain by the default engine, plain and with operators, and by FastSplats.
struct Operated {
    plain: f64,
    solid: f64,
    bump: f64,
    /// Seconds with an operator that does nothing.
    idle: f64,
    fastsplats: f64,
}

/// An operator that does nothing, to measure the overhead of operators.
#[derive(Debug)]
struct Idle;

impl PixelOperator for Idle {
    fn apply(&self, _: &SheetSample, _: &mut Appearance) {}
}

/// The default engine on sheets a voxel apart.
fn default_engine(size: ImageSize) -> RenderSettings {
    RenderSettings {
        size,
        ..RenderSettings::fast()
    }
}

/// The brain of marble, and with the word around it.
fn operated(brain: &Scene) -> Result<[Scene; 2], LabError> {
    let bounds = brain.bounds()?;
    let marble = SolidTexture::new(Stuff::Marble, &bounds, 0.06)?;
    let bump = BumpMap::new(&word()?, &bounds, 0.006)?;
    Ok([
        brain.clone().with_operator(marble),
        brain.clone().with_operator(bump),
    ])
}

fn operators(bench: &Workbench<'_>, brain: &View8) -> Result<Operated, LabError> {
    let size = picture_size(bench)?;
    let [solid, bump] = operated(&brain.scene)?;
    let engine = default_engine(size);
    let by_table = brain.settings(size, Classification::Post)?;
    let idle = brain.scene.clone().with_operator(Idle);
    let mut subjects = [
        Subject::new(&brain.scene, &brain.camera, engine)?,
        Subject::new(&solid, &brain.camera, engine)?,
        Subject::new(&bump, &brain.camera, engine)?,
        Subject::new(&idle, &brain.camera, engine)?,
        Subject::new(&brain.scene, &brain.camera, by_table)?,
    ];
    match seconds(&mut subjects, rounds(bench))?[..] {
        [plain, solid, bump, idle, fastsplats] => Ok(Operated {
            plain,
            solid,
            bump,
            idle,
            fastsplats,
        }),
        _ => Err(LabError::Measurement("not five times".to_owned())),
    }
}

/// A picture of the word: white on black, letters of 5 x 7 squares, three times around the volume.
fn word() -> Result<Image, LabError> {
    const LETTERS: [[u8; 7]; 5] = [
        [0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110],
        [0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000],
        [0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111],
        [0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],
        [0b11111, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100],
    ];
    const SQUARE: usize = 6;
    const PERIOD: usize = 32;
    let (width, height) = (3 * PERIOD * SQUARE, 21 * SQUARE);
    let lit = |index: usize| {
        // Half a period on, so that one of the words faces the viewer.
        let (column, row) = (
            (index % width / SQUARE + PERIOD / 2) % PERIOD,
            index / width / SQUARE,
        );
        let letter = LETTERS.get(column / 6);
        let line = row.checked_sub(7).and_then(|line| letter?.get(line));
        let bit = 4_usize.checked_sub(column % 6);
        line.zip(bit).is_some_and(|(line, bit)| line >> bit & 1 == 1)
    };
    let pixel = |index| {
        if lit(index) {
            [1.0; 4]
        } else {
            [0.0, 0.0, 0.0, 1.0]
        }
    };
    let size = ImageSize::new(width as u32, height as u32)?;
    Ok(Image::from_pixels(
        size,
        (0..width * height).map(pixel).collect(),
    )?)
}
