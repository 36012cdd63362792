//! The edge of a Gaussian kernel that is cut.

use serde::{Deserialize, Serialize};

/// What becomes of the edge where a Gaussian's footprint is cut.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum KernelEdge {
    /// Its height is subtracted, so that the footprint ends without a step, and what remains is scaled to the whole
    /// kernel's mass. Cut at two standard deviations it is .738 of them wide.
    #[default]
    Smooth,
    /// It stays: `exp(-r^2 / 2)` where r is less than the cut, nothing beyond (zwicker2001 section 6, `r^2 < c`). Cut at two
    /// standard deviations it is .829 of them wide and has .865 of the mass.
    Raw,
}
