//! The value of a pixel on a sheet of sections.

use serde::{Deserialize, Serialize};

/// The value that post-classification takes from a sheet of sections, from `S = sum v_k w_k` and `W = sum w_k`, with v the
/// values above the volume's least one, w the lengths of the sections' line integrals and l the length of the ray's way through
/// the sheet.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SheetValues {
    /// `S / W`, over the way W: data end at their faces, however few kernels reach there.
    #[default]
    Mean,
    /// `S / l`, over the way l, as huang2000 adds up densities: what has no splat has the least value, and data fade at their
    /// faces.
    Sum,
}
