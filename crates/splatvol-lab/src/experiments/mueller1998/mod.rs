//! mueller1998: errors of footprint alignment, anti-aliasing, motion blur.

use crate::{Experiment, FigureEntry, Paper};

mod aliasing;
mod alignment;
mod capsule;
mod depths;
mod figure10;
mod figure9;
mod footprints;
mod scenes;
mod slices;
mod spin;
mod table1;
mod views;

/// The paper and its figures.
pub const PAPER: Paper = Paper {
    key: "mueller1998",
    citation: "K. Mueller, T. Möller, J. E. Swan II, R. Crawfis, N. Shareef, R. Yagel: Splatting Errors and Antialiasing. IEEE Transactions on Visualization and Computer Graphics 4(2), 1998",
    figures: FIGURES,
};

const fn figure(
    number: &'static str,
    shows: &'static str,
    experiments: &'static [&'static str],
) -> FigureEntry {
    FigureEntry {
        number,
        shows,
        experiments,
    }
}

const FIGURES: &[FigureEntry] = &[
    figure(
        "Fig. 1",
        "the volume's raster and the rays, in eye space and in perspective space (a drawing)",
        &[],
    ),
    figure(
        "Fig. 2",
        "standard and anti-aliased splatting, in both spaces (a drawing)",
        &[],
    ),
    figure("Fig. 3", "how splats beyond z_k are scaled (a drawing)", &[]),
    figure("Fig. 4", "the sampling rate of the rays (a drawing)", &[]),
    figure(
        "Fig. 5",
        "a checkered tunnel, plain and anti-aliased",
        &["mueller1998-tunnel"],
    ),
    figure(
        "Fig. 6",
        "a landscape, plain and anti-aliased",
        &["mueller1998-terrain", "mueller1998-volcano"],
    ),
    figure(
        "Fig. 7",
        "the stretch as a trapezoid and as a box (a drawing)",
        &[],
    ),
    figure(
        "Fig. 8",
        "stretched kernels and how their footprints lie (a drawing)",
        &[],
    ),
    figure(
        "Table 1",
        "kernels in perspective space, five ways",
        &["mueller1998-table1"],
    ),
    figure(
        "Fig. 9",
        "kernels in perspective space and errors of their ray integrals",
        &["mueller1998-kernels"],
    ),
    figure("Fig. 10", "errors over the whole volume", &["mueller1998-errors"]),
    figure(
        "Fig. 11",
        "a splat and a motion-blurred splat",
        &["mueller1998-capsule"],
    ),
    figure("Fig. 12", "a nerve cell that spins", &["mueller1998-nerve"]),
    figure(
        "Fig. 13",
        "a landscape that spins",
        &["mueller1998-spinning-terrain", "mueller1998-spinning-volcano"],
    ),
    figure(
        "Fig. 14",
        "a column of that landscape over time",
        &["mueller1998-space-time", "mueller1998-space-time-volcano"],
    ),
];

/// Its experiments.
pub const EXPERIMENTS: &[Experiment] = &[
    aliasing::TUNNEL,
    aliasing::TERRAIN,
    aliasing::VOLCANO,
    table1::EXPERIMENT,
    figure9::EXPERIMENT,
    figure10::EXPERIMENT,
    capsule::EXPERIMENT,
    spin::NERVE,
    spin::TERRAIN,
    spin::VOLCANO,
    slices::TERRAIN,
    slices::VOLCANO,
];
