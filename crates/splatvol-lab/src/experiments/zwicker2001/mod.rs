//! zwicker2001: elliptical Gaussians under perspective, volumes and surfaces.

use crate::{Experiment, FigureEntry, Paper};

/// The paper and its figures.
pub const PAPER: Paper = Paper {
    key: "zwicker2001",
    citation: "M. Zwicker, H. Pfister, J. van Baar, M. Gross: EWA Volume Splatting. IEEE Visualization 2001",
    figures: FIGURES,
};

const FIGURES: &[FigureEntry] = &[];

/// Its experiments.
pub const EXPERIMENTS: &[Experiment] = &[];
