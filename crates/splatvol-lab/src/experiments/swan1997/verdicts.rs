//! The paper's claims about Fig. 7 against the measurements.

use super::comparison::{Comparison, Measured};
use super::shown;
use super::view::View;
use crate::{Expectation, Finding, LabError, Outcome, Published};

/// The paper's claims about a view, with their place in the paper.
pub(super) struct Claims {
    /// The figures without and with anti-aliasing.
    pub(super) figures: [&'static str; 2],
    /// Claim about the picture without it.
    pub(super) plain: &'static str,
    /// The least share above the Nyquist limit that these words mean.
    pub(super) least: f64,
    /// Claim about the picture with it.
    pub(super) smoothed: &'static str,
    /// Claim about both in motion; `None` if the paper does not say.
    pub(super) animated: Option<&'static str>,
}

/// Remaining share of aliasing and flicker in a smoothed picture.
const LEFT: Expectation = Expectation::AtMost(0.1);
const ADD_UP: &str = "opaque splats hide each other, and a low-passed opacity is no low-passed picture: of the same voxels made \
                      faint, which only add up, this share is left";

/// Findings, table, plot and plate.
///
/// # Errors
/// A scene of anything but a volume.
pub(super) fn report(
    outcome: &mut Outcome,
    comparison: &Comparison,
    view: &View,
    claims: &Claims,
) -> Result<(), LabError> {
    aliasing(outcome, comparison, claims);
    flickering(outcome, comparison, claims);
    opacity(outcome, comparison, claims);
    let figure = claims.figures[0]
        .rsplit_once(' ')
        .map_or("", |(figure, _)| figure);
    outcome.tables.push(shown::table(comparison, figure));
    outcome.plots.push(shown::plot(comparison, figure));
    outcome.plates.push(shown::plate(comparison, figure, view.k()?));
    Ok(())
}

/// A finding with the paper's claim, if there is one.
fn claimed(finding: Finding, words: Option<&str>) -> Finding {
    match words {
        Some(words) => finding.published(Published::Claim(words.to_owned())),
        None => finding,
    }
}

fn aliasing(outcome: &mut Outcome, comparison: &Comparison, claims: &Claims) {
    let [above, _] = comparison.finer_above;
    let [power, small] = comparison.power;
    let finding = Finding::new(
        claims.figures[0],
        "aliased-plain",
        "energy above the pixels' Nyquist limit beyond k, share of the picture's, standard splatting",
        above / power,
        Expectation::AtLeast(claims.least),
    )
    .explained_by(
        "most of the energy is in shapes larger than eight pixels; of the others' this share is above the limit",
        above / small,
        Expectation::AtLeast(claims.least),
    );
    outcome.find(claimed(finding, Some(claims.plain)));
    for (key, name, words) in [
        ("swan", "swan", Some(claims.smoothed)),
        (
            "swan-alpha",
            "swan by alpha, as section 5 has it",
            Some(claims.smoothed),
        ),
        ("ewa", "ewa", None),
    ] {
        let ratio = |of: fn(&Measured) -> f64| comparison.number(key, of) / comparison.number("plain", of);
        let share = |key: &str| 100.0 * comparison.number(key, |one| one.above) / power;
        let finding = Finding::new(
            claims.figures[1],
            &format!("aliased-{key}"),
            &format!("energy above the Nyquist limit beyond k, {name} against standard splatting"),
            ratio(|one| one.above),
            LEFT,
        )
        .detail(format!("{:.3} % against {:.1} %", share(key), share("plain")))
        .explained_by(ADD_UP, ratio(|one| one.faint.above), LEFT);
        outcome.find(claimed(finding, words));
    }
}

fn flickering(outcome: &mut Outcome, comparison: &Comparison, claims: &Claims) {
    let ratio =
        |of: fn(&Measured) -> f64| (comparison.number("swan", of) / comparison.number("plain", of)).powi(2);
    let levels = |key: &str| comparison.number(key, |one| one.flicker);
    let finding = Finding::new(
        claims.figures[1],
        "flicker-swan",
        "energy of pixels that jump from frame to frame, swan against standard splatting",
        ratio(|one| one.flicker),
        LEFT,
    )
    .detail(format!(
        "{:.2} against {:.2} levels; means of many samples {:.2}",
        levels("swan"),
        levels("plain"),
        comparison.truth_flicker
    ))
    .explained_by(
        "what glides by jumps a little, too: means of many samples, with next to no aliasing, have this share",
        (comparison.truth_flicker / levels("plain")).powi(2),
        Expectation::AtLeast(0.1),
    )
    .explained_by(
        "the filter leaves much, even of the same voxels made faint, which only add up: this share",
        ratio(|one| one.faint.flicker),
        Expectation::AtLeast(0.1),
    );
    outcome.find(claimed(finding, claims.animated));
}

fn opacity(outcome: &mut Outcome, comparison: &Comparison, claims: &Claims) {
    let same = Expectation::relative(1.0, 0.05);
    for (key, name) in [("swan", "swan"), ("swan-alpha", "swan by alpha")] {
        let ratio = |of: fn(&Measured) -> f64| comparison.number(key, of) / comparison.number("plain", of);
        let finding = Finding::new(
            claims.figures[1],
            &format!("opacity-{key}"),
            &format!("mean opacity beyond k, {name} against standard splatting"),
            ratio(|one| one.opacity),
            same,
        )
        .explained_by(
            "the same extinction hides more where it is spread out; of the same voxels made faint, whose opacity \
             is their extinction, this share is kept",
            ratio(|one| one.faint.opacity),
            same,
        );
        let claim = "the energy is the same as if the splats had not been scaled (section 4.3)";
        outcome.find(claimed(finding, Some(claim)));
    }
}
