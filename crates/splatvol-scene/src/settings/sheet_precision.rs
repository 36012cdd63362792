//! Number formats of sheets.

use serde::{Deserialize, Serialize};

/// Number format of a sheet's pixels (huang2000 section 5.1). With 8 and 16 bits the picture that sheets are composited into has 8
/// bits per channel, and what a splat or a sheet adds is cut to whole levels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SheetPrecision {
    /// 8 bits: the paper's for colours.
    U8,
    /// 16 bits: the paper's for values.
    U16,
    /// Single precision; so is the picture.
    #[default]
    F32,
}

impl SheetPrecision {
    /// Bits of a number; `None` for single precision.
    pub fn bits(self) -> Option<u32> {
        match self {
            Self::U8 => Some(8),
            Self::U16 => Some(16),
            Self::F32 => None,
        }
    }
}
