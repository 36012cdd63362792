//! Findings of Fig. 3 and 4.

use splatvol::Kernel;
use splatvol::radial::{Precision, Spacing};

use super::{
    KERNEL, LEVELS, Pixel, Row, SHEET, SPACINGS, errors, largest_halfway, mean_error_rounding_down, pixels,
    sampling_bound, table,
};
use crate::{Expectation, Finding, LabError, Outcome, Published};

/// The row of 256 entries, the size discussed in the paper.
pub(super) fn of_256(rows: &[Row]) -> Result<&Row, LabError> {
    rows.iter()
        .find(|row| row.entries == 256)
        .ok_or_else(|| LabError::Measurement("no table of 256 entries".to_owned()))
}

pub(super) fn quantisation_findings(outcome: &mut Outcome, rows: &[Row]) {
    let largest = |precision: usize| {
        let all = rows.iter().map(|row| row.quantisation[precision]);
        all.fold(0.0, f64::max)
    };
    for (index, (bits, published)) in [(8, 1.95e-3), (16, 7.63e-6)].into_iter().enumerate() {
        outcome.find(
            Finding::new(
                "Fig. 3",
                &format!("quantisation-{bits}-bits"),
                &format!("largest error of entries of {bits} bits, share of the footprint's centre"),
                largest(index),
                Expectation::relative(published, 0.05),
            )
            .published(Published::Number(published)),
        );
    }
    for (index, (name, _)) in SPACINGS.into_iter().enumerate() {
        let falls = rows
            .windows(2)
            .take(3)
            .map(|pair| pair[1].sampling[index] / pair[0].sampling[index]);
        outcome.find(
            Finding::new(
                "Fig. 3",
                &format!("sampling-{name}-falls"),
                &format!("error of point sampling by {name} distance: largest ratio from one size to twice it, up to 256"),
                falls.fold(0.0, f64::max),
                Expectation::AtMost(0.6),
            )
            .published(Published::Claim("decreases sharply as the table size increases".to_owned())),
        );
    }
}

pub(super) fn bound_findings(outcome: &mut Outcome, rows: &[Row]) -> Result<(), LabError> {
    let row = of_256(rows)?;
    let wide = Kernel::Gaussian {
        sigma: 0.85,
        radius: 2.0,
    };
    let half_level = LEVELS * row.quantisation[0];
    for (index, (name, spacing)) in SPACINGS.into_iter().enumerate() {
        outcome.find(
            Finding::new(
                "Fig. 3",
                &format!("sampling-{name}-256"),
                &format!("error of point sampling by {name} distance, 256 entries, over that of 8 bits"),
                row.sampling[index] / row.quantisation[0],
                Expectation::Between(0.1, 10.0),
            )
            .published(Published::Claim("the same order of magnitude".to_owned())),
        );
        let of_wide = LEVELS * sampling_bound(wide, (256, spacing), 2.0)? + half_level;
        let of_sheet = LEVELS * sampling_bound(KERNEL, (256, spacing), SHEET)? + half_level;
        outcome.find(
            Finding::new(
                "Fig. 4",
                &format!("bound-{name}-256"),
                &format!("bound of the total error by {name} distance, 256 entries of 8 bits"),
                row.bound(index, 0),
                Expectation::AtMost(2.0),
            )
            .unit("levels")
            .published(Published::Claim("less than 2".to_owned()))
            .explained_by(
                "the Gaussian's width is not given: one of sigma 0.85 stays below 2",
                of_wide,
                Expectation::AtMost(2.0),
            )
            .explained_by(
                "a sheet a voxel thick takes a part of the kernel only, whose bound with ours is near 2",
                of_sheet,
                Expectation::AtMost(2.2),
            ),
        );
    }
    let difference = |precision: usize| row.bound(0, precision) - row.bound(1, precision);
    let narrow = |kernel| -> Result<f64, LabError> {
        let bound = |spacing| sampling_bound(kernel, (256, spacing), 2.0);
        Ok(LEVELS * (bound(Spacing::Squared)? - bound(Spacing::Linear)?))
    };
    let sheet = |spacing| sampling_bound(KERNEL, (256, spacing), SHEET);
    outcome.find(
        Finding::new(
            "Fig. 4",
            "bound-difference-256",
            "bound by squared distance less the bound by distance, 256 entries",
            difference(0),
            Expectation::Near {
                value: 1.0,
                within: 0.5,
            },
        )
        .unit("levels")
        .published(Published::Claim("about 1".to_owned()))
        .explained_by(
            "a Gaussian of sigma 0.85 has a difference of this",
            narrow(wide)?,
            Expectation::Between(0.5, 1.5),
        )
        .explained_by(
            "what a sheet a voxel thick takes of ours differs by this",
            LEVELS * (sheet(Spacing::Squared)? - sheet(Spacing::Linear)?),
            Expectation::Between(0.5, 1.5),
        ),
    );
    outcome.find(
        Finding::new(
            "Fig. 4",
            "bound-gain-of-16-bits",
            "bound of 8 bits less the bound of 16, by squared distance, 256 entries",
            row.bound(0, 0) - row.bound(0, 1),
            Expectation::relative(0.5, 0.1),
        )
        .unit("levels")
        .published(Published::Number(0.5)),
    );
    Ok(())
}

pub(super) fn mean_findings(outcome: &mut Outcome, rows: &[Row], whole: &[Pixel]) -> Result<(), LabError> {
    let row = of_256(rows)?;
    let table = table(KERNEL, 256, Spacing::Squared, Precision::U8)?;
    let [of_sheets, _] = errors(&table, &pixels(whole.len(), true));
    outcome.find(
        Finding::new(
            "Section 5.1",
            "mean-error-256",
            "mean error of a pixel's value, 256 entries of 8 bits by squared distance",
            row.mean[0],
            Expectation::relative(0.56, 0.15),
        )
        .unit("levels")
        .published(Published::Number(0.56))
        .detail(format!("of sheets a voxel thick: {of_sheets:.3}"))
        .explained_by(
            "tables that round distances and entries down instead of to the nearest err by this",
            mean_error_rounding_down(256, whole),
            Expectation::relative(0.56, 0.15),
        ),
    );
    outcome.find(Finding::new(
        "Fig. 4",
        "bound-is-a-bound",
        "largest measured error over its bound, 8 bits, all sizes and both spacings",
        rows.iter()
            .flat_map(|row| [0, 1].map(|spacing| row.largest[spacing] / row.bound(spacing, 0)))
            .fold(0.0, f64::max),
        Expectation::AtMost(1.0),
    )
    .explained_by(
        "half the difference of neighbours is no strict bound where a footprint is curved: halfway between two entries it is farther from \
one of them, by this factor for 32 entries by squared distance",
        largest_halfway(32) / (LEVELS * rows[0].sampling[0]),
        Expectation::AtLeast(1.0),
    ));
    Ok(())
}
