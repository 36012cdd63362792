//! Findings of Fig. 8 and 9.

use super::{Operated, View8};
use crate::{Expectation, Finding, Outcome, Published};

pub(super) fn fig8_findings(outcome: &mut Outcome, views: &[View8]) {
    let mut order: Vec<&View8> = views.iter().collect();
    order.sort_by(|a, b| a.published.total_cmp(&b.published));
    let names: Vec<&str> = order.iter().map(|view| view.name).collect();
    let measured: Vec<(&str, f64)> = views.iter().map(|view| (view.name, view.post)).collect();
    let slices = |name: &str| {
        let view = views.iter().find(|view| view.name == name);
        view.map_or(f64::NAN, |view| view.slices[0])
    };
    let per_section = |name: &str| {
        let view = views.iter().find(|view| view.name == name);
        view.map_or(f64::NAN, |view| view.post / view.slices[0])
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
        )
        .explained_by(
            "in perspective kernels lean over their footprints, whose sections are worked out pixel by pixel: time per section, vessels \
             over brain",
            per_section("vessels") / per_section("brain"),
            Expectation::AtLeast(1.2),
        ),
    );
    ratio_findings(outcome, views);
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

/// Each volume over the brain.
fn ratio_findings(outcome: &mut Outcome, views: &[View8]) {
    let Some((brain, others)) = views.split_first() else {
        return;
    };
    for (letter, view) in ['b', 'c', 'd'].into_iter().zip(others) {
        let published = view.published / brain.published;
        let measured = view.post / brain.post;
        let sections = view.slices[0] / brain.slices[0];
        let off = |ratio: f64| match measured > published {
            true => Expectation::AtLeast(1.25 * ratio),
            false => Expectation::AtMost(0.8 * ratio),
        };
        outcome.find(
            Finding::new(
                &format!("Fig. 8 ({letter})"),
                &format!("{}-over-brain", view.name),
                &format!(
                    "seconds of the {} over those of the brain, post-classified",
                    view.name
                ),
                measured,
                Expectation::relative(published, 0.25),
            )
            .published(Published::Number(published))
            .timed()
            .explained_by(
                "our look-alikes are other data: sections drawn, over the brain's",
                sections,
                off(published),
            )
            .explained_by(
                "a section of it takes another time: seconds per section, over the brain's",
                measured / sections,
                off(1.0),
            ),
        );
    }
}

pub(super) fn fig9_findings(outcome: &mut Outcome, operated: &Operated) {
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
            .timed()
            .explained_by(
                "the default engine leaves its fastest code for any operator; beyond one that does nothing it takes",
                (measured - operated.idle) / operated.fastsplats,
                Expectation::AtMost((published - PLAIN) / PLAIN),
            ),
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
