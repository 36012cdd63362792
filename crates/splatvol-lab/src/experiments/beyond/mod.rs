//! Questions beyond the papers: reconstruction, aliasing by frequency, popping, sheet thickness, absorption, kernel
//! cut-off.
//!
//! | experiment | question |
//! |---|---|
//! | `marschner_lobb` | how far the field of each kernel is from the signal that was sampled |
//! | `zone_plate` | which frequencies each filter keeps, and which come back as others |
//! | `popping` | what jumps when the camera passes 45 degrees |
//! | `sheets` | how far composited footprints are from the integral, by the sheets' thickness |
//! | `absorption` | what `1 - x` in place of `exp(-x)` changes |
//! | `cut_off` | lost mass and ripple of a truncated kernel |
//!
//! `radial_field` reconstructs with kernels of the distance, `scenes` has what several of them render.

mod absorption;
mod cut_off;
mod marschner_lobb;
mod popping;
mod radial_field;
mod scenes;
mod sheets;
mod zone_plate;

use crate::Experiment;

/// Our experiments.
pub const EXPERIMENTS: &[Experiment] = &[
    marschner_lobb::EXPERIMENT,
    zone_plate::EXPERIMENT,
    popping::EXPERIMENT,
    sheets::EXPERIMENT,
    absorption::EXPERIMENT,
    cut_off::EXPERIMENT,
];
