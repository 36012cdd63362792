//! Tables of footprints, for the rasterisers that look them up (huang2000 sections 2 and 5).

use serde::{Deserialize, Serialize};

use crate::SceneError;

/// Size of the table of a kernel's footprint and of its sections. The default is the paper's: 128 entries of 8
/// bits, 128 sections.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct TableLayout {
    /// Entries from the footprint's centre to its edge, 32 to 1024.
    pub entries: u32,
    /// Number format of an entry.
    pub precision: TablePrecision,
    /// Parts that the kernel is cut into along depth, 1 to 128; with 1 a voxel lies on one sheet only.
    pub sections: u32,
}

/// Number format of the entries of a table.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TablePrecision {
    /// 8 bits.
    #[default]
    U8,
    /// 16 bits.
    U16,
    /// Single precision.
    F32,
}

impl Default for TableLayout {
    fn default() -> Self {
        Self {
            entries: 128,
            precision: TablePrecision::default(),
            sections: 128,
        }
    }
}

impl TableLayout {
    /// Checks every field's domain.
    ///
    /// # Errors
    /// The first field outside its domain, by name.
    pub fn validate(&self) -> Result<(), SceneError> {
        if !(32..=1024).contains(&self.entries) {
            return Err(SceneError::invalid("table entries", self.entries, "32 to 1024"));
        }
        if !(1..=128).contains(&self.sections) {
            return Err(SceneError::invalid("table sections", self.sections, "1 to 128"));
        }
        Ok(())
    }
}
