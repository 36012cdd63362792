//! A sheet: the sums of footprints per pixel of a tile.

use std::sync::atomic::AtomicBool;

use super::levels::Levels;
use crate::room::grow_with;

/// Pixels of C channels, and which of them were touched.
#[derive(Debug, Default)]
pub(crate) struct Sheet<const C: usize> {
    values: Vec<[f32; C]>,
    width: usize,
    /// Touched: x0, y0, x1, y1, ends excluded.
    touched: [usize; 4],
    /// Of the first channels, and how many they are; `None` for single precision.
    levels: Option<(Levels, usize)>,
}

const UNTOUCHED: [usize; 4] = [usize::MAX, usize::MAX, 0, 0];

impl<const C: usize> Sheet<C> {
    /// Resets to an empty sheet of this size, whose first channels have levels; `None` if the picture is cancelled meanwhile.
    pub(crate) fn reset(
        &mut self,
        [width, height]: [usize; 2],
        levels: Option<(Levels, usize)>,
        stop: &AtomicBool,
    ) -> Option<()> {
        self.values.clear();
        self.levels = levels;
        self.width = width;
        self.touched = UNTOUCHED;
        grow_with(&mut self.values, width * height, || [0.0; C], stop)
    }

    /// Zeroes all touched pixels.
    pub(crate) fn clear(&mut self) {
        let [x0, y0, x1, y1] = self.touched;
        for y in y0..y1 {
            self.values[y * self.width + x0..y * self.width + x1].fill([0.0; C]);
        }
        self.touched = UNTOUCHED;
    }

    /// Marks pixels from x0, y0 to x1, y1 (excluded) as possibly touched.
    #[inline(always)]
    pub(crate) fn touch(&mut self, [x0, y0, x1, y1]: [usize; 4]) {
        let t = &mut self.touched;
        *t = [t[0].min(x0), t[1].min(y0), t[2].max(x1), t[3].max(y1)];
    }

    /// Touched pixels: x0, y0, x1, y1, ends excluded; empty where x0 >= x1.
    pub(crate) fn touched(&self) -> [usize; 4] {
        self.touched
    }

    /// True where nothing was splatted.
    pub(crate) fn is_empty(&self) -> bool {
        self.touched[0] >= self.touched[2]
    }

    /// A pixel.
    #[inline(always)]
    pub(crate) fn pixel(&self, x: usize, y: usize) -> &[f32; C] {
        &self.values[y * self.width + x]
    }

    /// Adds a payload to a row of pixels by their weights.
    #[inline(always)]
    pub(crate) fn add_row(&mut self, (x, y): (usize, usize), weights: &[f32], payload: &[f32; C]) {
        let start = y * self.width + x;
        if let Some((levels, channels)) = self.levels {
            for (pixel, weight) in self.values[start..start + weights.len()].iter_mut().zip(weights) {
                for (index, (sum, channel)) in pixel.iter_mut().zip(payload).enumerate() {
                    *sum = match index < channels {
                        true => levels.add(*sum, weight * channel),
                        false => *sum + weight * channel,
                    };
                }
            }
            return;
        }
        for (pixel, weight) in self.values[start..start + weights.len()].iter_mut().zip(weights) {
            for (sum, channel) in pixel.iter_mut().zip(payload) {
                *sum += weight * channel;
            }
        }
    }
}
