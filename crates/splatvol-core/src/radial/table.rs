//! Footprint tables for FastSplats: huang2000 section 3.1 (one line of the footprint, with even steps of the
//! distance or its square), section 2.1 (kernels cut in 128 sections), section 5 (8 or 16 bits, sizes).
//!
//! Row s holds the footprint of the kernel in front of the depth `-1 + 2 (s + 1) / sections` (in support radii):
//! `C[s][i] = int_-inf^z h dz`. A sheet takes the difference of two rows, so a table serves sheets of any
//! thickness, and the shares of neighbouring sheets add up to the whole footprint exactly (in 8 and 16 bits).
//! Entries are points, not means, and the nearest is taken, as in the paper.

use splatvol_scene::{Kernel, SceneError};

use super::RadialKernel;
use super::section::{AnySection, Entry, Section};

/// Entries of the largest table.
pub(super) const MOST_ENTRIES: usize = 1024;

/// Number format of a table's entries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// Levels of 1/255 of the footprint's centre.
    #[default]
    U8,
    /// Levels of 1/65535 of the footprint's centre.
    U16,
    /// Single precision.
    F32,
}

/// Spacing of a table's entries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spacing {
    /// Evenly in the distance: a square root per look-up, smallest error.
    Linear,
    /// Evenly in the squared distance, which rasterisers step without multiplying.
    #[default]
    Squared,
}

/// Size and layout of a table. The default is the paper's: 128 entries of 8 bits by squared distance, 128 sections.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableSettings {
    /// Entries from the centre to the support, 32 to 1024.
    pub entries: usize,
    /// Number format of entries.
    pub precision: Precision,
    /// Spacing of the entries.
    pub spacing: Spacing,
    /// Rows, 1 to 128; a single row puts the whole footprint where its centre is.
    pub sections: usize,
}

impl Default for TableSettings {
    fn default() -> Self {
        Self {
            entries: 128,
            precision: Precision::default(),
            spacing: Spacing::default(),
            sections: 128,
        }
    }
}

impl TableSettings {
    fn validate(&self) -> Result<(), SceneError> {
        let refused = |field, value: usize, expected| {
            Err(SceneError::InvalidField {
                field,
                value: value.to_string(),
                expected,
            })
        };
        if !(32..=MOST_ENTRIES).contains(&self.entries) {
            return refused("footprint table entries", self.entries, "32 to 1024");
        }
        if !(1..=128).contains(&self.sections) {
            return refused("footprint table sections", self.sections, "1 to 128");
        }
        Ok(())
    }
}

/// The footprint of a kernel and its sections.
#[derive(Debug, Clone, PartialEq)]
pub struct FootprintTable {
    settings: TableSettings,
    rows: Rows,
    /// Value of an entry's unit, per square voxel.
    unit: f32,
}

/// Row after row.
#[derive(Debug, Clone, PartialEq)]
enum Rows {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

impl FootprintTable {
    /// Samples a kernel. It takes some 0.01 s (0.1 s for 1024 entries of a Kaiser-Bessel kernel).
    ///
    /// # Errors
    /// Kernel or settings outside their domain, by name.
    pub fn new(kernel: Kernel, settings: TableSettings) -> Result<Self, SceneError> {
        kernel.validate()?;
        settings.validate()?;
        let kernel = RadialKernel::new(kernel);
        let peak = kernel.line_integral(0.0);
        let shares = shares(&kernel, peak, &settings);
        let (rows, full) = match settings.precision {
            Precision::U8 => (Rows::U8(entries(&shares)), u8::FULL),
            Precision::U16 => (Rows::U16(entries(&shares)), u16::FULL),
            Precision::F32 => (Rows::F32(entries(&shares)), f32::FULL),
        };
        Ok(Self {
            settings,
            rows,
            unit: peak as f32 / full,
        })
    }

    /// Size and layout.
    pub fn settings(&self) -> TableSettings {
        self.settings
    }

    /// Memory of the entries.
    pub fn bytes(&self) -> usize {
        match &self.rows {
            Rows::U8(rows) => rows.len(),
            Rows::U16(rows) => 2 * rows.len(),
            Rows::F32(rows) => 4 * rows.len(),
        }
    }

    /// The whole footprint at a squared distance in support radii, per square voxel.
    #[inline(always)]
    pub fn value(&self, rho2: f32) -> f32 {
        self.between(rho2, -1.0, 1.0)
    }

    /// Footprint of the part between two depths, in support radii from the kernel's centre. Depths are rounded to
    /// the nearest row. Rasterisers make a [`FootprintTable::section`] once and look that up.
    #[inline(always)]
    pub fn between(&self, rho2: f32, front: f32, back: f32) -> f32 {
        self.section(front, back).at(rho2)
    }

    /// The part of the kernel between two depths, in support radii from its centre. Empty where `back < front`.
    #[inline(always)]
    pub fn section(&self, front: f32, back: f32) -> AnySection<'_> {
        let front = self.row(front);
        let back = self.row(back).max(front);
        match &self.rows {
            Rows::U8(rows) => AnySection::U8(self.slices(rows, front, back)),
            Rows::U16(rows) => AnySection::U16(self.slices(rows, front, back)),
            Rows::F32(rows) => AnySection::F32(self.slices(rows, front, back)),
        }
    }

    /// Number of rows in front of a depth: 0 (nothing of the kernel) to `sections` (all of it).
    #[inline(always)]
    fn row(&self, depth: f32) -> usize {
        let sections = self.settings.sections as f32;
        (0.5 * (depth + 1.0) * sections + 0.5).min(sections) as usize
    }

    #[inline(always)]
    fn slices<'a, E: Entry>(&self, rows: &'a [E], front: usize, back: usize) -> Section<'a, E> {
        Section {
            front: self.slice(rows, front),
            back: self.slice(rows, back),
            last: (self.settings.entries - 1) as f32,
            unit: self.unit,
            spacing: self.settings.spacing,
            depths: [front, back],
        }
    }

    #[inline(always)]
    fn slice<'a, E: Entry>(&self, rows: &'a [E], row: usize) -> &'a [E] {
        let count = self.settings.entries;
        let zeros = &E::ZEROS[..count.min(MOST_ENTRIES)];
        match row.checked_sub(1) {
            None => zeros,
            Some(before) => rows.get(before * count..row * count).unwrap_or(zeros),
        }
    }
}

/// Cumulative footprints, row after row, as shares of the whole footprint's centre.
fn shares(kernel: &RadialKernel, peak: f64, settings: &TableSettings) -> Vec<f64> {
    let last = (settings.entries - 1) as f64;
    let support = kernel.support();
    let squares: Vec<f64> = (0..settings.entries)
        .map(|i| i as f64 / last)
        .map(|position| match settings.spacing {
            Spacing::Linear => (position * support).powi(2),
            Spacing::Squared => position * support * support,
        })
        .collect();
    (1..=settings.sections)
        .map(|row| (2.0 * row as f64 / settings.sections as f64 - 1.0) * support)
        .flat_map(|depth| squares.iter().map(move |&rho2| (rho2, depth)))
        .map(|(rho2, depth)| kernel.partial_line_integral(rho2, depth) / peak)
        .collect()
}

fn entries<E: Entry>(shares: &[f64]) -> Vec<E> {
    shares.iter().map(|&share| E::nearest(share)).collect()
}
