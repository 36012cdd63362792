//! Post-classified splatting: section 6.2, Fig. 8, and per-pixel operators, Fig. 9 (a) and (b).

use splatvol::{
    BumpMap, Camera, Classification, Extraction, Image, ImageSize, Rasterizer, RenderSettings, Scene,
    SolidTexture, Stuff, View,
};

use super::data;
use super::method::{Subject, fastsplats, picture_size, seconds};
use crate::{
    Axis, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, PlotKind, Published, Table,
    Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "huang2000-post",
    paper: "huang2000",
    title: "post-classified rendering times, solid texture and bump map",
    figures: &["Section 6.2", "Fig. 8", "Fig. 9"],
    about: "Post-classified sheets hold data, which is classified and lit pixel by pixel. The paper times four volumes by the square \
FastSplat, then the brain with a marble texture computed per pixel and with a bump map of the word *splat*.

We render look-alikes of the stated sizes (the data are not public), by the square FastSplat and one thread, at 512 x 512. *Brain* and *nerve* as in \
Table 1, the nerve oblique, so that its footprints are turned ellipses. *Injection*: a generated cone of spray, 64 x 64 x 64, in perspective. \
*Vessels*: branches of the sample nerve grown into 256 x 256 x 256 cubes, in perspective. Only voxels in the range of interest are splatted.

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
    /// By the square FastSplat. Of data only the range of interest is splatted, as in section 1: what is visible, and voxels from a
    /// tenth of the range of values up, which surround it.
    fn settings(&self, size: ImageSize, classification: Classification) -> RenderSettings {
        let [low, high] = self.scene.volume.value_range();
        let opacities = self.scene.transfer_function.opacities();
        let visible = opacities.iter().map(|point| point.value).fold(high, f64::min);
        let from = visible.min(low + 0.1 * (high - low));
        let data = classification == Classification::Post;
        RenderSettings {
            classification,
            extraction: data.then_some(Extraction {
                density: Some([from, high]),
                gradient: 0.0,
            }),
            ..fastsplats(size, self.rasterizer)
        }
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
            let settings = view.settings(size, classification);
            subjects.push(Subject::new(&view.scene, &view.camera, settings)?);
        }
    }
    let seconds = seconds(&mut subjects, 3)?;
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

fn fig8_findings(outcome: &mut Outcome, views: &[View8]) {
    let mut order: Vec<&View8> = views.iter().collect();
    order.sort_by(|a, b| a.published.total_cmp(&b.published));
    let names: Vec<&str> = order.iter().map(|view| view.name).collect();
    let measured: Vec<(&str, f64)> = views.iter().map(|view| (view.name, view.post)).collect();
    let slices = |name: &str| {
        let view = views.iter().find(|view| view.name == name);
        view.map_or(f64::NAN, |view| view.slices[0])
    };
    outcome.find(
        Finding::order(
            "Fig. 8",
            "order",
            "seconds, post-classified: pairs of volumes in another order",
            &names,
            &measured,
            0.02,
        )
        .timed()
        .explained_by(
            "our look-alikes are other data: sections drawn, vessels over brain",
            slices("vessels") / slices("brain"),
            Expectation::AtLeast(1.0),
        ),
    );
    // Table 1 has the pre-classified times of two.
    for (name, figure, pre) in [("brain", "Fig. 8 (a)", 4.33), ("nerve", "Fig. 8 (b)", 6.36)] {
        let Some(view) = views.iter().find(|view| view.name == name) else {
            continue;
        };
        let published = view.published / pre;
        outcome.find(
            Finding::new(
                figure,
                &format!("{name}-post-over-pre"),
                &format!("seconds of the {name}, post-classified over pre-classified"),
                view.post / view.pre,
                Expectation::relative(published, 0.25),
            )
            .published(Published::Number(published))
            .timed()
            .explained_by(
                "data have no opacity until their sheet is finished, so less is hidden: sections drawn, post-classified over pre-classified",
                view.slices[0] / view.slices[1],
                Expectation::AtLeast(1.5),
            ),
        );
    }
}

/// Seconds of the brain by the default engine, plain and with operators, and by FastSplats.
struct Operated {
    plain: f64,
    solid: f64,
    bump: f64,
    fastsplats: f64,
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
    let bounds = brain.volume.grid().bounds();
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
    let by_table = brain.settings(size, Classification::Post);
    let mut subjects = [
        Subject::new(&brain.scene, &brain.camera, engine)?,
        Subject::new(&solid, &brain.camera, engine)?,
        Subject::new(&bump, &brain.camera, engine)?,
        Subject::new(&brain.scene, &brain.camera, by_table)?,
    ];
    match seconds(&mut subjects, bench.choose(5, 3))?[..] {
        [plain, solid, bump, fastsplats] => Ok(Operated {
            plain,
            solid,
            bump,
            fastsplats,
        }),
        _ => Err(LabError::Measurement("not four times".to_owned())),
    }
}

fn fig9_findings(outcome: &mut Outcome, operated: &Operated) {
    const PLAIN: f64 = 7.25;
    for (figure, key, what, measured, published) in [
        ("Fig. 9 (a)", "solid", "marble", operated.solid, 9.41),
        ("Fig. 9 (b)", "bump", "a bump map", operated.bump, 7.99),
    ] {
        let more = (measured - operated.plain) / operated.fastsplats;
        outcome.find(
            Finding::new(
                figure,
                &format!("{key}-over-plain"),
                &format!("seconds of the brain with {what} over those without, default engine"),
                measured / operated.plain,
                Expectation::relative(published / PLAIN, 0.1),
            )
            .published(Published::Number(published / PLAIN))
            .timed()
            .explained_by(
                "the engine that has operators takes a smaller part of FastSplats' time for all else",
                operated.plain / operated.fastsplats,
                Expectation::AtMost(0.5),
            ),
        );
        outcome.find(
            Finding::new(
                figure,
                &format!("{key}-cost"),
                &format!("what {what} takes over a post-classified frame by FastSplats"),
                more,
                Expectation::AtMost((published - PLAIN) / PLAIN),
            )
            .published(Published::Number((published - PLAIN) / PLAIN))
            .timed(),
        );
    }
    outcome.find(
        Finding::new(
            "Section 6.2",
            "default-engine",
            "seconds of the post-classified brain by the square FastSplat over those by the default engine",
            operated.fastsplats / operated.plain,
            Expectation::AtLeast(5.0),
        )
        .timed(),
    );
}

/// A picture of the word: white on black, letters of 5 x 7 squares, twice around the volume.
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
    let (width, height) = (2 * PERIOD * SQUARE, 21 * SQUARE);
    let lit = |index: usize| {
        let (column, row) = (index % width / SQUARE % PERIOD, index / width / SQUARE);
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

fn plates(bench: &Workbench<'_>, views: &[View8]) -> Result<Vec<Plate>, LabError> {
    let edge = bench.choose(256, 128);
    let size = ImageSize::new(edge, edge)?;
    let mut fig8 = Plate::new("volumes", "Fig. 8", "post-classified, by the square FastSplat");
    for (letter, view) in ['a', 'b', 'c', 'd'].into_iter().zip(views) {
        let settings = view.settings(size, Classification::Post);
        let frame = Subject::new(&view.scene, &view.camera, settings)?.render()?;
        fig8 = fig8.panel(&format!("({letter}) {}", view.name), frame.image);
    }
    let brain = &views[0];
    let [solid, bump] = operated(&brain.scene)?;
    let mut fig9 = Plate::new(
        "operators",
        "Fig. 9",
        "operators on sheet pixels, by the default engine",
    );
    for (label, scene) in [
        ("(a) marble", &solid),
        ("(b) bump map", &bump),
        ("without", &brain.scene),
    ] {
        let frame = Subject::new(scene, &brain.camera, default_engine(size))?.render()?;
        fig9 = fig9.panel(label, frame.image);
    }
    Ok(vec![fig8, fig9])
}

fn fig8_numbers(views: &[View8]) -> Table {
    let mut table = Table::new(
        "volumes",
        "Fig. 8",
        "Post-classified rendering times by the square FastSplat",
        &[
            "volume",
            "published (s)",
            "measured (s)",
            "pre-classified, measured (s)",
            "sections drawn",
            "sections drawn, pre-classified",
        ],
    );
    for view in views {
        table.row([
            view.name.into(),
            view.published.into(),
            view.post.into(),
            view.pre.into(),
            view.slices[0].into(),
            view.slices[1].into(),
        ]);
    }
    table
}

fn fig9_numbers(operated: &Operated) -> Table {
    let mut table = Table::new(
        "operators",
        "Fig. 9",
        "The post-classified brain with operators",
        &["picture", "published (s)", "measured, default engine (s)"],
    );
    table.row(["without".into(), 7.25.into(), operated.plain.into()]);
    table.row(["marble".into(), 9.41.into(), operated.solid.into()]);
    table.row(["bump map".into(), 7.99.into(), operated.bump.into()]);
    table
}

fn bars(views: &[View8]) -> Plot {
    let brain = &views[0];
    let group = |view: &View8| {
        let ratios = vec![view.published / brain.published, view.post / brain.post];
        (view.name.to_owned(), ratios)
    };
    Plot::new(
        "volumes-relative",
        "Fig. 8",
        "post-classified seconds relative to the brain's",
        [Axis::new("volume"), Axis::new("seconds over those of the brain")],
        PlotKind::Bars {
            bars: vec!["paper".to_owned(), "here".to_owned()],
            groups: views.iter().map(group).collect(),
        },
    )
}
