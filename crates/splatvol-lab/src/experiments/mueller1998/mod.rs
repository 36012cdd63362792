//! mueller1998: errors of footprint alignment, anti-aliasing, motion blur.

use crate::{Experiment, FigureEntry, Paper};

/// The paper and its figures.
pub const PAPER: Paper = Paper {
    key: "mueller1998",
    citation: "K. Mueller, T. Möller, J. E. Swan II, R. Crawfis, N. Shareef, R. Yagel: Splatting Errors and Antialiasing. IEEE Transactions on Visualization and Computer Graphics 4(2), 1998",
    figures: FIGURES,
};

const FIGURES: &[FigureEntry] = &[];

/// Its experiments.
pub const EXPERIMENTS: &[Experiment] = &[];
