//! zwicker2001: elliptical Gaussians under perspective, volumes and surfaces.
//!
//! | experiment | figures |
//! |---|---|
//! | `affine` | the local affine approximation of the perspective (Fig. 4) |
//! | `flattening` | volume kernels that become surface kernels (Fig. 5 and 6, eq. 23 and 24) |
//! | `filters` | shapes of the resampling filter (Fig. 7 and 8) |
//! | `zebra` | EWA beside Swan's filter (the plate that the paper numbers 8 again) |
//! | `surface` | volume kernels beside surface kernels (Fig. 9) |
//! | `objects` | surfaces within translucent volumes (Fig. 10) |

mod affine;
mod filters;
mod flattening;
mod objects;
mod pictures;
mod shapes;
mod splat;
mod surface;
mod times;
mod zebra;

use crate::{Experiment, FigureEntry, Paper};

/// The paper and its figures.
pub const PAPER: Paper = Paper {
    key: "zwicker2001",
    citation: "M. Zwicker, H. Pfister, J. van Baar, M. Gross: EWA Volume Splatting. IEEE Visualization 2001",
    figures: FIGURES,
};

const FIGURES: &[FigureEntry] = &[
    FigureEntry {
        number: "Fig. 1",
        shows: "The forward mapping pipeline: object, camera, ray and screen space",
        experiments: &[],
    },
    FigureEntry {
        number: "Fig. 2",
        shows: "Volume rendering, and what splatting makes of it",
        experiments: &[],
    },
    FigureEntry {
        number: "Fig. 3",
        shows: "From camera to ray space",
        experiments: &[],
    },
    FigureEntry {
        number: "Fig. 4",
        shows: "A kernel mapped from camera to ray space, by the local affine approximation and exactly",
        experiments: &["zwicker2001-affine"],
    },
    FigureEntry {
        number: "Fig. 5",
        shows: "A volume kernel that is flattened to a surface kernel",
        experiments: &["zwicker2001-flattening"],
    },
    FigureEntry {
        number: "Fig. 6",
        shows: "Rendering surface kernels: from the plane to the picture",
        experiments: &["zwicker2001-flattening"],
    },
    FigureEntry {
        number: "Fig. 7",
        shows: "Rasterising the resampling filter in a box around it",
        experiments: &["zwicker2001-filters"],
    },
    FigureEntry {
        number: "Fig. 8",
        shows: "Shapes of the EWA filter and of Swan's: minified, magnified, and both at once",
        experiments: &["zwicker2001-filters"],
    },
    FigureEntry {
        number: "Fig. 8 (plate)",
        shows: "EWA volume splatting and Swan et al.: textures of 1024 x 512 x 3 and 1024 x 256 x 3",
        experiments: &["zwicker2001-zebra"],
    },
    FigureEntry {
        number: "Fig. 9",
        shows: "EWA volume splatting and EWA surface splatting: a texture of 512 x 512 x 3",
        experiments: &["zwicker2001-surface"],
    },
    FigureEntry {
        number: "Fig. 10",
        shows: "Head, engine and foot, translucent, with flattened surfaces inside",
        experiments: &["zwicker2001-objects"],
    },
];

/// Its experiments.
pub const EXPERIMENTS: &[Experiment] = &[
    affine::EXPERIMENT,
    flattening::EXPERIMENT,
    filters::EXPERIMENT,
    zebra::EXPERIMENT,
    surface::EXPERIMENT,
    objects::EXPERIMENT,
];
