//! Pictures, rows and bars of Fig. 8 and 9.

use splatvol::Classification;

use super::{Operated, View8, default_engine, operated};
use crate::experiments::huang2000::method::{Subject, picture_size};
use crate::{Axis, LabError, Plate, Plot, PlotKind, Table, Workbench};

pub(super) fn plates(bench: &Workbench<'_>, views: &[View8]) -> Result<Vec<Plate>, LabError> {
    let size = picture_size(bench)?;
    let mut fig8 = Plate::new("volumes", "Fig. 8", "post-classified, by the square FastSplat");
    for (letter, view) in ['a', 'b', 'c', 'd'].into_iter().zip(views) {
        let settings = view.settings(size, Classification::Post)?;
        let frame = Subject::new(&view.scene, &view.camera, settings)?.render()?;
        fig8 = fig8.panel(&format!("({letter}) {}", view.name), frame.image);
    }
    let brain = &views[0];
    let [solid, bump] = operated(&brain.scene)?;
    let mut fig9 = Plate::new(
        "operators",
        "Fig. 9",
        "operators on sheet pixels, by the default engine; our brain is the upper part of a head with its skin",
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

pub(super) fn fig8_numbers(views: &[View8]) -> Table {
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

pub(super) fn fig9_numbers(operated: &Operated) -> Table {
    let mut table = Table::new(
        "operators",
        "Fig. 9",
        "The post-classified brain with operators",
        &["picture", "published (s)", "measured, default engine (s)"],
    );
    table.row(["without".into(), 7.25.into(), operated.plain.into()]);
    table.row(["marble".into(), 9.41.into(), operated.solid.into()]);
    table.row(["bump map".into(), 7.99.into(), operated.bump.into()]);
    table.row([
        "an operator that does nothing".into(),
        "–".into(),
        operated.idle.into(),
    ]);
    table
}

pub(super) fn bars(views: &[View8]) -> Plot {
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
