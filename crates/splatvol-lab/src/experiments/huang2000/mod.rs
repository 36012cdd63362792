//! huang2000: rasterisers, tables, occlusion, post-classification.

mod data;
mod differences;
mod lookups;
mod method;
mod post;
mod rates;
mod storage;
mod table1;
mod tables;

use crate::{Experiment, FigureEntry, Paper};

/// The paper and its figures.
pub const PAPER: Paper = Paper {
    key: "huang2000",
    citation: "J. Huang, K. Mueller, N. Shareef, R. Crawfis: FastSplats: Optimized Splatting on Rectilinear Grids. IEEE Visualization 2000",
    figures: FIGURES,
};

const FIGURES: &[FigureEntry] = &[
    FigureEntry {
        number: "Fig. 1",
        shows: "image-aligned sheets, drawn to explain them",
        experiments: &[],
    },
    FigureEntry {
        number: "Fig. 1 (plate)",
        shows: "brain and nerve with 1D FastSplats of 128 entries of 8 bits, brain with the 2D FastSplat",
        experiments: &["huang2000-preshaded"],
    },
    FigureEntry {
        number: "Fig. 2",
        shows: "brain and nerve with the 1D linear FastSplat, brain with the 2D FastSplat",
        experiments: &["huang2000-preshaded"],
    },
    FigureEntry {
        number: "Fig. 3",
        shows: "errors of point sampling and of quantisation against the table's size",
        experiments: &["huang2000-tables"],
    },
    FigureEntry {
        number: "Fig. 4",
        shows: "bound of the total error against the table's size",
        experiments: &["huang2000-tables"],
    },
    FigureEntry {
        number: "Table 1",
        shows: "rendering times of pre-classified splatting",
        experiments: &["huang2000-preshaded"],
    },
    FigureEntry {
        number: "Fig. 5",
        shows: "scan-conversion rates of four channels",
        experiments: &["huang2000-rates"],
    },
    FigureEntry {
        number: "Fig. 6",
        shows: "scan-conversion rates of one channel",
        experiments: &["huang2000-rates"],
    },
    FigureEntry {
        number: "Fig. 7",
        shows: "the tomato, semi-transparent",
        experiments: &["huang2000-preshaded"],
    },
    FigureEntry {
        number: "Fig. 8",
        shows: "post-classified brain, nerve, diesel injection and blood vessels",
        experiments: &["huang2000-post"],
    },
    FigureEntry {
        number: "Fig. 9",
        shows: "solid texture, bump map, and the phantom cube of the error analysis",
        experiments: &["huang2000-post", "huang2000-differences"],
    },
];

/// Its experiments.
pub const EXPERIMENTS: &[Experiment] = &[
    table1::EXPERIMENT,
    post::EXPERIMENT,
    tables::EXPERIMENT,
    differences::EXPERIMENT,
    rates::EXPERIMENT,
    storage::EXPERIMENT,
];
