//! Levels: sheets and pixels of 8 or 16 bits.
//!
//! huang2000 section 5.1 adds opacities and colours up in 8 bits per channel and values in 16, and composites both into a
//! picture of 8 bits per channel (figures 8, 9). Each number that is added is cut to whole levels, as by shifting integers, and
//! a sum stays at the highest level. That is our reading: the paper does not say how it rounds. Extinctions have no highest
//! level, so splats add their opacity over a voxel's length.

use splatvol_core::splats::Profile;
use splatvol_scene::{Classification, SheetPrecision, SplatCompositing};

use super::order::Order;
use super::plan::Plan;

/// Levels of numbers from 0 on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Levels {
    per_unit: f32,
    highest: u32,
}

impl Levels {
    /// Of a pixel's colours and opacity.
    pub(crate) const PICTURE: Self = Self {
        per_unit: 255.0,
        highest: 255,
    };

    /// So many bits for numbers up to `most`.
    fn new(bits: u32, most: f32) -> Self {
        let highest = (1 << bits) - 1;
        Self {
            per_unit: highest as f32 / most,
            highest,
        }
    }

    /// A sum after a number is added, cut to whole levels. What is below zero, or no number, adds nothing.
    #[inline(always)]
    pub(crate) fn add(self, sum: f32, number: f32) -> f32 {
        // The sum is a level up to rounding.
        let level = (sum * self.per_unit + 0.5) as u32;
        let more = (number * self.per_unit) as u32;
        level.saturating_add(more).min(self.highest) as f32 / self.per_unit
    }
}

impl<P: Profile> Plan<'_, P> {
    /// Levels of sheets: of colours and opacities up to 1, of values up to 1 along a ray's way through a sheet. `None`
    /// where they have single precision.
    pub(crate) fn sheet_levels(&self) -> Option<Levels> {
        let method = &self.settings.method;
        let bits = method.sheet_precision.bits()?;
        let of_values = method.compositing == SplatCompositing::ImageSheets(Classification::Post);
        let Order::Sheets { sheets, .. } = &self.order else {
            return Some(Levels::new(bits, 1.0));
        };
        if !of_values {
            return Some(Levels::new(bits, 1.0));
        }
        let [near, far] = sheets.slab(0).map(|depth| depth as f32);
        let size = self.settings.size;
        let [right, bottom] = [size.width(), size.height()].map(|count| count as usize - 1);
        let longest = [[0, 0], [right, 0], [0, bottom], [right, bottom]]
            .map(|pixel| self.projection.path_per_depth(self.ray(pixel), near))
            .into_iter()
            .fold(1.0, f32::max);
        Some(Levels::new(bits, (far - near) * longest))
    }

    /// Whether sheets hold opacities over a voxel, which have a highest level, in place of extinctions.
    #[inline(always)]
    pub(crate) fn holds_opacities(&self) -> bool {
        self.settings.method.sheet_precision != SheetPrecision::F32 && self.shading.is_none()
    }

    /// Levels of the picture; `None` where it has single precision.
    pub(crate) fn picture_levels(&self) -> Option<Levels> {
        (self.settings.method.sheet_precision != SheetPrecision::F32).then_some(Levels::PICTURE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_cut_to_levels_and_sums_stay_at_the_highest() {
        let levels = Levels::new(8, 2.0);
        let unit = 2.0 / 255.0;
        for (sum, number, level) in [
            (0.0, -1.0, 0.0),
            (0.0, f32::NAN, 0.0),
            (0.0, 0.99 * unit, 0.0),
            (7.0, 1.01, 8.0),
            (100.0, 50.9, 150.0),
            (200.0, 54.9, 254.0),
            (200.0, 56.0, 255.0),
            (255.0, f32::INFINITY, 255.0),
        ] {
            let number = if number.is_finite() && number >= 1.0 {
                number * unit
            } else {
                number
            };
            let found = levels.add(sum * unit, number);
            assert!((found - level * unit).abs() < 1e-6, "{sum} {number}: {found}");
        }
        let mut sum = 0.0;
        for _ in 0..300 {
            sum = Levels::PICTURE.add(sum, 1.5 / 255.0);
        }
        assert_eq!(sum, 1.0);
    }
}
