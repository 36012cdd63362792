//! swan1997: anti-aliased splatting of orthographic and perspective views.
//!
//! | module | figure |
//! |---|---|
//! | `splat_size` | 2, 3, 4: size and energy of one splat by distance, and the grid of rays |
//! | `spectra` | 5: spectra before and beyond k |
//! | `sampling_rate` | 6: the factor that the distance k neglects off the axis |
//! | `checker`, `terrain`, `microtubules` | 7: the pictures, by means of `view`, `window`, `animation`, `comparison`, `verdicts`, `shown` |

mod animation;
mod checker;
mod comparison;
mod microtubules;
mod sampling_rate;
mod shown;
mod single;
mod spectra;
mod splat_size;
mod terrain;
mod verdicts;
mod view;
mod waves;
mod window;

use crate::{Experiment, FigureEntry, Paper};

/// The paper and its figures.
pub const PAPER: Paper = Paper {
    key: "swan1997",
    citation: "J. E. Swan II, K. Mueller, T. Möller, N. Shareef, R. Crawfis, R. Yagel: An Anti-Aliasing Technique for Splatting. IEEE Visualization 1997",
    figures: FIGURES,
};

const FIGURES: &[FigureEntry] = &[
    FigureEntry {
        number: "Fig. 1",
        shows: "drawing: the grid of rays through the volume, in eye space and in perspective space",
        experiments: &[],
    },
    FigureEntry {
        number: "Fig. 2",
        shows: "drawing: a splat beyond k and its energy (eq. 4 to 8)",
        experiments: &["swan1997-splat-size"],
    },
    FigureEntry {
        number: "Fig. 3",
        shows: "drawing: sizes of splats by distance, standard and anti-aliased",
        experiments: &["swan1997-splat-size"],
    },
    FigureEntry {
        number: "Fig. 4",
        shows: "drawing: the sampling frequency of the rays by distance (eq. 9 to 11)",
        experiments: &["swan1997-splat-size"],
    },
    FigureEntry {
        number: "Fig. 5",
        shows: "spectra before k, and beyond it with and without anti-aliasing",
        experiments: &["swan1997-spectra"],
    },
    FigureEntry {
        number: "Fig. 6",
        shows: "drawing: the sampling rate off the axis",
        experiments: &["swan1997-sampling-rate"],
    },
    FigureEntry {
        number: "Fig. 7",
        shows: "checkerboard, terrain and microtubules, without and with anti-aliasing",
        experiments: &[
            "swan1997-checker",
            "swan1997-terrain",
            "swan1997-volcano",
            "swan1997-microtubules",
        ],
    },
];

/// Its experiments.
pub const EXPERIMENTS: &[Experiment] = &[
    splat_size::EXPERIMENT,
    spectra::EXPERIMENT,
    sampling_rate::EXPERIMENT,
    checker::EXPERIMENT,
    terrain::GENERATED,
    terrain::VOLCANO,
    microtubules::EXPERIMENT,
];
