//! huang2000: rasterisers, tables, occlusion, post-classification.

use crate::{Experiment, FigureEntry, Paper};

/// The paper and its figures.
pub const PAPER: Paper = Paper {
    key: "huang2000",
    citation: "J. Huang, K. Mueller, N. Shareef, R. Crawfis: FastSplats: Optimized Splatting on Rectilinear Grids. IEEE Visualization 2000",
    figures: FIGURES,
};

const FIGURES: &[FigureEntry] = &[];

/// Its experiments.
pub const EXPERIMENTS: &[Experiment] = &[];
