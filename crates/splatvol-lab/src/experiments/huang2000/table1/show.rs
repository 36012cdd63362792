//! Pictures of Fig. 2 and 7, rows and bars of Table 1.

use splatvol::{FlatSettings, Frame, Rasterizer, RenderSettings, TableLayout, TablePrecision};

use super::Case;
use crate::experiments::huang2000::lookups::Lookups;
use crate::experiments::huang2000::method::{FASTSPLATS, RLUT, Subject, TWO_D, fastsplats, picture_size};
use crate::measure::psnr;
use crate::{
    Axis, Expectation, Finding, LabError, Outcome, Plate, Plot, PlotKind, Published, Table, Workbench,
};

/// Fig. 2 and 7, and the differences between the pictures.
pub(super) fn pictures(bench: &Workbench<'_>, outcome: &mut Outcome, cases: &[Case]) -> Result<(), LabError> {
    let size = picture_size(bench)?;
    let render = |case: &Case, rasterizer, entries| -> Result<Frame, LabError> {
        let settings = RenderSettings::try_from(FlatSettings {
            table: TableLayout {
                entries,
                ..TableLayout::default()
            },
            ..fastsplats(size, rasterizer)
        })?;
        Subject::new(&case.scene, &case.camera, settings)?.render()
    };
    let [brain, nerve, _, tomato] = cases else {
        return Err(LabError::Measurement("not four volumes".to_owned()));
    };
    let fine = RenderSettings::try_from(FlatSettings {
        table: TableLayout {
            entries: 256,
            precision: TablePrecision::U16,
            ..TableLayout::default()
        },
        ..fastsplats(size, Rasterizer::Linear1d)
    })?;
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
            "where failure begins is our guess; 2D is the worst by far all the same, so many dB below square",
            quality(&square) - quality(&two_d),
            Expectation::AtLeast(10.0),
        ),
    );
    let linear = render(brain, Rasterizer::Linear1d, 256)?.image;
    let coarse_nerve = render(nerve, Rasterizer::Ellipse1d, 128)?.image;
    outcome.plates.push(
        Plate::new(
            "plate",
            "Fig. 1 (plate)",
            "(a) brain and (b) nerve, 1D square with 128 entries of 8 bits; (c) brain, 2D with 2 x 2 positions within the pixel",
        )
        .panel("(a) brain, square", square)
        .panel("(b) nerve, square", coarse_nerve)
        .panel("(c) brain, 2D", two_d.clone()),
    );
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

pub(super) fn numbers(cases: &[Case]) -> Table {
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

/// The methods' own part.
pub(super) fn alone(lookups: &Lookups) -> Table {
    let mut table = Table::new(
        "lookups",
        "Table 1",
        "Finding the entries of a footprint's pixels, and nothing else",
        &["method", "nanoseconds per pixel"],
    );
    for (method, nanoseconds) in [
        ("2D", lookups.copied),
        ("linear", lookups.linear),
        ("square", lookups.square),
        ("RLUT", lookups.rlut),
    ] {
        table.row([method.into(), nanoseconds.into()]);
    }
    table
}

/// Seconds relative to the square method: the paper's, and ours.
pub(super) fn bars(cases: &[Case]) -> Vec<Plot> {
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
