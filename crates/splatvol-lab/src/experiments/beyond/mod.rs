//! What the papers' authors did not ask: reconstruction, popping, sheet thickness, absorption, kernel cut-off.

use crate::Experiment;

/// Our experiments.
pub const EXPERIMENTS: &[Experiment] = &[];
