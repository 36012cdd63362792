//! swan1997: anti-aliased splatting of orthographic and perspective views.

use crate::{Experiment, FigureEntry, Paper};

/// The paper and its figures.
pub const PAPER: Paper = Paper {
    key: "swan1997",
    citation: "J. E. Swan II, K. Mueller, T. Möller, N. Shareef, R. Crawfis, R. Yagel: An Anti-Aliasing Technique for Splatting. IEEE Visualization 1997",
    figures: FIGURES,
};

const FIGURES: &[FigureEntry] = &[];

/// Its experiments.
pub const EXPERIMENTS: &[Experiment] = &[];
