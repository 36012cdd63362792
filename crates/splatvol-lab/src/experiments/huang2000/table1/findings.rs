//! Findings of Table 1: orders and ratios of seconds.

use super::Case;
use crate::experiments::huang2000::lookups::Lookups;
use crate::{Expectation, Finding, Outcome, Published};

/// Orders and ratios within a volume. Seconds that differ by less than a fiftieth count as equal, as do the paper's own
/// for the brain by the square and the RLUT method.
pub(super) fn time_findings(outcome: &mut Outcome, case: &Case, lookups: &Lookups) {
    let figure = format!("Table 1, {}", case.name);
    let mut order: Vec<&str> = case.methods.iter().map(|one| one.0).collect();
    order.sort_by(|a, b| case.published(a).total_cmp(&case.published(b)));
    let measured: Vec<(&str, f64)> = case.rows.iter().map(|row| (row.method, row.seconds)).collect();
    let key = |what: &str| format!("{}-{what}", case.name);
    // Cost of finding entries alone, nanoseconds per pixel.
    let alone = |method: &str| match method {
        "linear" => lookups.linear,
        "RLUT" => lookups.rlut,
        "2D" => lookups.copied,
        _ => lookups.square,
    };
    // Seconds relative to square's, if methods differ only in that cost and in the number of sections that
    // they draw.
    let predicted = |method: &str| match (case.row(method), case.row("square")) {
        (Some(own), Some(square)) => {
            let more = 1e-9 * (alone(method) - alone("square")) * own.pixels;
            own.slices as f64 / square.slices as f64 + more / square.seconds
        }
        _ => f64::NAN,
    };
    let spread = |of: &dyn Fn(&str) -> f64| {
        let all = case.methods.iter().map(|one| of(one.0));
        all.clone().fold(0.0, f64::max) / all.fold(f64::INFINITY, f64::min)
    };
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
            "methods differ in how they find a pixel's entry and in how many sections they draw; that sets, on this processor, the slowest and the fastest \
             apart by this factor, less than half of the published",
            spread(&predicted),
            Expectation::AtMost(1.0 + 0.5 * (spread(&|method| case.published(method)) - 1.0)),
        ),
    );
    for method in ["linear", "RLUT", "2D"] {
        let Some([measured, published]) = case.ratio(method, "square") else {
            continue;
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
                "methods differ in how they find a pixel's entry and in how many sections they draw; that predicts, on this processor, a ratio within 15 % of the measured",
                predicted(method),
                Expectation::relative(measured, 0.15),
            ),
        );
    }
}

/// The methods without the rest of a frame.
pub(super) fn lookup_finding(outcome: &mut Outcome, lookups: &Lookups) {
    let measured = [
        ("2D", lookups.copied),
        ("square", lookups.square),
        ("RLUT", lookups.rlut),
        ("linear", lookups.linear),
    ];
    outcome.find(
        Finding::order(
            "Table 1",
            "lookups-order",
            "nanoseconds to find a pixel's entry, alone: pairs of methods in another order",
            &["2D", "square", "RLUT", "linear"],
            &measured,
            0.02,
        )
        .timed(),
    );
}

/// Findings that compare the volumes.
pub(super) fn across_findings(outcome: &mut Outcome, cases: &[Case]) {
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
                "seconds of the opaque brain without occlusion over those with it, square (the paper's factor is that of graphics boards)",
                brain.open / brain.seconds,
                Expectation::Between(3.0, 8.0),
            )
            .published(Published::Number(5.0))
            .timed()
            .detail(format!(
                "{:.1} % of the voxels are hidden",
                100.0 * brain.hidden_share
            ))
            .explained_by(
                "our brain is solid below its skin and hides more: sections drawn without occlusion over those with it",
                brain.open_slices as f64 / brain.slices as f64,
                Expectation::AtLeast(8.0),
            ),
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
