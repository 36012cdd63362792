//! Stretching of kernels smaller than pixels by Swan's filter.

use serde::{Deserialize, Serialize};

/// The shape of a kernel beyond the distance from which the swan filter stretches it (mueller1998 section 4.1,
/// figure 7).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stretch {
    /// A uniform stretch by the factor that its centre needs (table 1, row 2): footprints keep a closed form.
    #[default]
    Box,
    /// At each depth by what that depth needs, as a trapezoid (table 1, row 1): integrated numerically.
    Trapezoid,
}
