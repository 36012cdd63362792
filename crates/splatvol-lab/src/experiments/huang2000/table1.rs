//! Rendering times of pre-classified splatting: Table 1, with the pictures of Fig. 2 and 7.

use splatvol::{
    Camera, FootprintTable, Frame, ImageSize, Occlusion, Rasterizer, RenderSettings, Scene, TablePrecision,
    View,
};

use super::data;
use super::lookups::Lookups;
use super::method::{FASTSPLATS, RLUT, Subject, TWO_D, fastsplats, picture_size, seconds};
use crate::measure::psnr;
use crate::{
    Axis, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, PlotKind, Published, Table,
    Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "huang2000-preshaded",
    paper: "huang2000",
    title: "pre-classified rendering times of the four FastSplats, with and without occlusion",
    figures: &["Table 1", "Fig. 2", "Fig. 7", "Section 7"],
    about: "The paper renders three volumes at 512 x 512 with four rasterisers on a 300 MHz R12000: a Gaussian of radius 2, 128 \
sections, tables of 128 entries of 8 bits, sheets a voxel apart, hidden bricks and voxels left out. Its data are not public.

We render generated look-alikes of the same sizes, with the program's preset of that name, by one thread. *Brain*: the upper 145 of 256 \
slices of the sample head, 256 x 256 x 145 cubes, opaque. *Nerve*: the sample nerve, 512 x 512 x 76 voxels of 1:1:5, opaque, seen along \
z. *Tomato*: the sample tomato, 256 x 256 x 256, at a fifth of its opacity. Seconds are medians of interleaved rounds, the volume being \
classified before.

Voxels of 1:1:5 leave ellipses: the square FastSplat is that of section 3.1.3 there. The program's 2D FastSplat draws footprints of \
cubes only. So the nerve is rendered a second time with its samples as cubes, by all four.

Seconds of a machine of today say nothing about the paper's. Orders and ratios do.",
    run,
};

/// A volume of the table.
struct Case {
    name: &'static str,
    scene: Scene,
    camera: Camera,
    methods: Vec<(&'static str, Rasterizer)>,
    /// Published seconds: 2D, linear, square, RLUT.
    published: [f64; 4],
    rows: Vec<Row>,
}

/// What a method took.
struct Row {
    method: &'static str,
    seconds: f64,
    /// Without occlusion.
    open: f64,
    /// Share of `seconds` in which footprints become pixels.
    splat: f64,
    splats: u64,
    slices: u64,
    hidden_share: f64,
}

impl Case {
    fn row(&self, method: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.method == method)
    }

    fn published(&self, method: &str) -> f64 {
        let index = FASTSPLATS.iter().position(|one| one.0 == method);
        index.map_or(f64::NAN, |index| self.published[index])
    }

    /// Measured and published seconds of a method over those of another; none where a method is missing.
    fn ratio(&self, method: &str, to: &str) -> Option<[f64; 2]> {
        let measured = self.row(method)?.seconds / self.row(to)?.seconds;
        Some([measured, self.published(method) / self.published(to)])
    }
}

fn cases(bench: &Workbench<'_>) -> Result<Vec<Case>, LabError> {
    let case = |name, scene: Scene, view, published| -> Result<Case, LabError> {
        let camera = data::orthographic(&scene, view)?;
        Ok(Case {
            name,
            camera,
            methods: FASTSPLATS.to_vec(),
            published,
            rows: Vec::new(),
            scene,
        })
    };
    let nerve_seconds = [6.02, 10.06, 6.36, 7.52];
    let nerve = data::nerve(bench)?;
    let cubes = data::nerve_of_cubes(&nerve)?;
    let oblong = Case {
        methods: vec![
            ("linear", Rasterizer::Linear1d),
            ("square", Rasterizer::Ellipse1d),
            ("RLUT", RLUT),
        ],
        ..case("nerve", nerve, View::Top, nerve_seconds)?
    };
    Ok(vec![
        case("brain", data::brain(bench)?, View::Iso, [3.51, 7.11, 4.33, 4.41])?,
        oblong,
        case("nerve-cubes", cubes, View::Top, nerve_seconds)?,
        case(
            "tomato",
            data::tomato(bench)?,
            View::Iso,
            [16.66, 60.00, 25.23, 27.00],
        )?,
    ])
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    bench.step(0, 10, "volumes");
    let mut cases = cases(bench)?;
    let count = 2 * cases.len() + 1;
    for (index, case) in cases.iter_mut().enumerate() {
        bench.step(2 * index + 1, count + 1, case.name);
        measure(bench, case)?;
    }
    bench.step(count, count + 1, "pictures");
    let mut outcome = Outcome::default();
    let lookups = Lookups::measure();
    for case in &cases {
        time_findings(&mut outcome, case, &lookups);
    }
    across_findings(&mut outcome, &cases);
    pictures(bench, &mut outcome, &cases)?;
    outcome.tables.push(numbers(&cases));
    outcome.plots = bars(&cases);
    Ok(outcome)
}

fn measure(bench: &Workbench<'_>, case: &mut Case) -> Result<(), LabError> {
    let size = picture_size(bench)?;
    let subjects = |occlusion| -> Result<Vec<Subject<'_>>, LabError> {
        let settings = |rasterizer| RenderSettings {
            occlusion,
            ..fastsplats(size, rasterizer)
        };
        case.methods
            .iter()
            .map(|&(_, rasterizer)| Subject::new(&case.scene, &case.camera, settings(rasterizer)))
            .collect()
    };
    let mut hiding = subjects(Occlusion::Sat)?;
    let hidden = seconds(&mut hiding, 3)?;
    let mut showing = subjects(Occlusion::None)?;
    let open = seconds(&mut showing, 1)?;
    let rows: Vec<Row> = case
        .methods
        .iter()
        .enumerate()
        .map(|(index, &(method, _))| {
            let statistics = hiding[index].statistics();
            Row {
                method,
                seconds: hidden[index],
                open: open[index],
                splat: statistics.seconds.splat / statistics.seconds.total,
                splats: statistics.voxels + statistics.hidden_voxels,
                slices: statistics.slices,
                hidden_share: statistics.hidden_share,
            }
        })
        .collect();
    case.rows = rows;
    Ok(())
}

/// Orders and ratios within a volume. Seconds that differ by less than a fiftieth count as equal: so do the paper's own of the
/// brain by the square and the RLUT FastSplat.
fn time_findings(outcome: &mut Outcome, case: &Case, lookups: &Lookups) {
    let figure = format!("Table 1, {}", case.name);
    let mut order: Vec<&str> = case.methods.iter().map(|one| one.0).collect();
    order.sort_by(|a, b| case.published(a).total_cmp(&case.published(b)));
    let measured: Vec<(&str, f64)> = case.rows.iter().map(|row| (row.method, row.seconds)).collect();
    let key = |what: &str| format!("{}-{what}", case.name);
    let splat = case.row("square").map_or(f64::NAN, |row| row.splat);
    let most = measured.iter().map(|one| one.1).fold(0.0, f64::max);
    let least = measured.iter().map(|one| one.1).fold(f64::INFINITY, f64::min);
    outcome.find(
        Finding::order(
            &figure,
            &key("order"),
            "seconds: pairs of methods in another order",
            &order,
            &measured,
            0.02,
        )
        .timed()
        .explained_by(
            "the method is a small part of a frame today: all are within this factor of each other",
            most / least,
            Expectation::AtMost(1.5),
        ),
    );
    // What finding entries alone takes, over what square takes for it.
    let alone = |method: &str| match method {
        "linear" => lookups.linear / lookups.square,
        "RLUT" => lookups.rlut / lookups.square,
        _ => lookups.copied / lookups.square,
    };
    for method in ["linear", "RLUT", "2D"] {
        let Some([measured, published]) = case.ratio(method, "square") else {
            continue;
        };
        let nearer = match published > 1.0 {
            true => Expectation::AtMost(0.85 * published),
            false => Expectation::AtLeast(1.15 * published),
        };
        outcome.find(
            Finding::new(
                &figure,
                &key(&format!("{}-over-square", method.to_lowercase())),
                &format!("seconds of {method} over those of square"),
                measured,
                Expectation::relative(published, 0.15),
            )
            .published(Published::Number(published))
            .timed()
            .explained_by(
                "part of a frame is the same for all methods: footprints become pixels in this share of it",
                splat,
                Expectation::AtMost(0.75),
            )
            .explained_by(
                "methods differ otherwise on this processor: finding a pixel's entry, alone, takes this many times what it takes square",
                alone(method),
                nearer,
            ),
        );
    }
}

/// What sets volumes apart.
fn across_findings(outcome: &mut Outcome, cases: &[Case]) {
    let of = |name: &str| cases.iter().find(|case| case.name == name);
    let square = |name: &str| of(name).and_then(|case| case.row("square"));
    let seconds = |name: &str| square(name).map_or(f64::NAN, |row| row.seconds);
    let names = ["brain", "nerve", "tomato"];
    outcome.find(
        Finding::order(
            "Table 1",
            "volumes-order",
            "seconds by the square FastSplat: pairs of volumes in another order",
            &names,
            &names.map(|name| (name, seconds(name))),
            0.02,
        )
        .timed(),
    );
    let drawn = |name: &str| square(name).map_or(f64::NAN, |row| row.slices as f64);
    outcome.find(
        Finding::new(
            "Table 1",
            "tomato-over-brain",
            "seconds of the tomato over those of the brain, square",
            seconds("tomato") / seconds("brain"),
            Expectation::relative(25.23 / 4.33, 0.3),
        )
        .published(Published::Number(25.23 / 4.33))
        .timed()
        .explained_by(
            "our tomato is another than theirs, and so is our brain: sections drawn, tomato over brain",
            drawn("tomato") / drawn("brain"),
            Expectation::AtLeast(8.0),
        ),
    );
    if let Some(brain) = square("brain") {
        outcome.find(
            Finding::new(
                "Section 7",
                "occlusion",
                "seconds of the opaque brain without occlusion over those with it, square",
                brain.open / brain.seconds,
                Expectation::Between(3.0, 8.0),
            )
            .published(Published::Number(5.0))
            .timed()
            .detail(format!(
                "{:.1} % of the voxels are hidden",
                100.0 * brain.hidden_share
            )),
        );
        outcome.find(Finding::new(
            "Table 1, brain",
            "brain-hidden",
            "share of the opaque brain's visible voxels that occlusion leaves out",
            brain.hidden_share,
            Expectation::AtLeast(0.5),
        ));
    }
    if let Some(tomato) = square("tomato") {
        outcome.find(Finding::new(
            "Table 1, tomato",
            "tomato-hidden",
            "share of the faint tomato's voxels that occlusion leaves out",
            tomato.hidden_share,
            Expectation::AtMost(0.05),
        ));
    }
}

/// Fig. 2 and 7, and what the pictures differ by.
fn pictures(bench: &Workbench<'_>, outcome: &mut Outcome, cases: &[Case]) -> Result<(), LabError> {
    let edge = bench.choose(300, 128);
    let size = ImageSize::new(edge, edge)?;
    let render = |case: &Case, rasterizer, entries| -> Result<Frame, LabError> {
        let settings = RenderSettings {
            table: FootprintTable {
                entries,
                ..FootprintTable::default()
            },
            ..fastsplats(size, rasterizer)
        };
        Subject::new(&case.scene, &case.camera, settings)?.render()
    };
    let [brain, nerve, _, tomato] = cases else {
        return Err(LabError::Measurement("not four volumes".to_owned()));
    };
    let fine = RenderSettings {
        table: FootprintTable {
            entries: 256,
            precision: TablePrecision::U16,
            ..FootprintTable::default()
        },
        ..fastsplats(size, Rasterizer::Linear1d)
    };
    let fine = Subject::new(&brain.scene, &brain.camera, fine)?.render()?.image;
    let of_brain = |rasterizer| Ok::<_, LabError>(render(brain, rasterizer, 128)?.image);
    let quality = |image: &_| psnr(image, &fine);
    let two_d = of_brain(TWO_D)?;
    let square = of_brain(Rasterizer::Square1d)?;
    for (key, image) in [("square", &square), ("rlut", &of_brain(RLUT)?)] {
        outcome.find(
            Finding::new(
                "Fig. 2 (a)",
                &format!("quality-{key}"),
                &format!("PSNR of the brain, {key} of 128 entries of 8 bits, to linear of 256 of 16 bits"),
                quality(image),
                Expectation::AtLeast(40.0),
            )
            .unit("dB")
            .published(Published::Claim("visually indistinguishable".to_owned())),
        );
    }
    outcome.find(
        Finding::new(
            "Fig. 2 (c)",
            "quality-2d",
            "PSNR of the brain, 2D with 2 x 2 positions, to linear of 256 entries of 16 bits",
            quality(&two_d),
            Expectation::AtMost(34.0),
        )
        .unit("dB")
        .published(Published::Claim("fails on image quality".to_owned()))
        .explained_by(
            "ours keeps the mass of splats whose radius is rounded; it is still so many dB below square",
            quality(&square) - quality(&two_d),
            Expectation::AtLeast(10.0),
        ),
    );
    let linear = render(brain, Rasterizer::Linear1d, 256)?.image;
    let nerve = render(nerve, Rasterizer::Linear1d, 256)?.image;
    outcome.plates.push(
        Plate::new(
            "opaque",
            "Fig. 2",
            "(a) brain and (b) nerve, 1D linear with 256 entries; (c) brain, 2D with 2 x 2 positions within the pixel",
        )
        .panel("(a) brain, linear", linear)
        .panel("(b) nerve, linear", nerve)
        .panel("(c) brain, 2D", two_d),
    );
    let tomato = render(tomato, Rasterizer::Square1d, 128)?.image;
    let plate = Plate::new("tomato", "Fig. 7", "the tomato, semi-transparent");
    outcome.plates.push(plate.panel("tomato, square", tomato));
    Ok(())
}

fn numbers(cases: &[Case]) -> Table {
    let mut table = Table::new(
        "seconds",
        "Table 1",
        "Pre-classified rendering times, and the published ones",
        &[
            "volume",
            "method",
            "published (s)",
            "measured (s)",
            "without occlusion (s)",
            "voxels to be seen",
            "hidden (share)",
            "sections drawn",
            "footprints to pixels (share of the time)",
        ],
    );
    for case in cases {
        for row in &case.rows {
            table.row([
                case.name.into(),
                row.method.into(),
                case.published(row.method).into(),
                row.seconds.into(),
                row.open.into(),
                (row.splats as f64).into(),
                row.hidden_share.into(),
                (row.slices as f64).into(),
                row.splat.into(),
            ]);
        }
    }
    table
}

/// Seconds relative to the square FastSplat: the paper's, and ours.
fn bars(cases: &[Case]) -> Vec<Plot> {
    let plot = |index: usize, name: &str, caption: &str| {
        let relative = |case: &Case| {
            FASTSPLATS.map(|(method, _)| case.ratio(method, "square").map_or(0.0, |ratios| ratios[index]))
        };
        let group = |case: &Case| (case.name.to_owned(), relative(case).to_vec());
        Plot::new(
            name,
            "Table 1",
            caption,
            [
                Axis::new("volume"),
                Axis::new("seconds over those of square").range(0.0, 2.5),
            ],
            PlotKind::Bars {
                bars: FASTSPLATS.iter().map(|one| one.0.to_owned()).collect(),
                groups: cases.iter().map(group).collect(),
            },
        )
    };
    vec![
        plot(
            1,
            "relative-published",
            "seconds relative to the square FastSplat, as published",
        ),
        plot(
            0,
            "relative",
            "seconds relative to the square FastSplat, measured",
        ),
    ]
}
