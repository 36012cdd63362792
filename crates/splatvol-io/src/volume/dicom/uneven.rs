//! Slices at uneven distances, resampled to even ones.
//!
//! Values between slices are those of a cubic through both with the slopes of Fritsch and Butland (1984): it has no crease at
//! a slice where the distance changes, and nowhere leaves the range of the two values.

use splatvol_scene::{Samples, with_samples};

use crate::IoError;
use crate::error::Context;

/// Most slices for each one of the file.
const MOST: usize = 8;
/// Steps that differ by less than this share are listed as one.
const ALIKE: f64 = 0.02;
/// Different steps that a warning lists.
const SHOWN: usize = 6;

/// Places of slices in even steps from the first.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Uneven {
    /// Rising, from 0 to `count - 1`.
    places: Vec<f64>,
    /// Even slices.
    pub(super) count: usize,
}

impl Uneven {
    /// Even slices for those at these rising heights: as close as the closest two are, if that does not make too many.
    pub(super) fn new(heights: &[f64]) -> Self {
        let gaps = || heights.windows(2).map(|pair| pair[1] - pair[0]);
        let least = gaps().fold(f64::INFINITY, f64::min);
        let span: f64 = gaps().sum();
        let steps = (span / least).round();
        let most = (MOST * heights.len()) as f64;
        let count = if steps < most {
            steps as usize
        } else {
            most as usize
        };
        let scale = count as f64 / span;
        Self {
            places: heights
                .iter()
                .map(|height| (height - heights[0]) * scale)
                .collect(),
            count: count + 1,
        }
    }

    /// What a reader of the picture should know.
    pub(super) fn describe(&self, heights: &[f64]) -> String {
        let mut steps: Vec<f64> = heights.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps.dedup_by(|next, kept| (*next - *kept).abs() <= ALIKE * kept.abs());
        let more = if steps.len() > SHOWN { " and others" } else { "" };
        let listed: Vec<String> = steps
            .iter()
            .take(SHOWN)
            .map(|step| format!("{step:.4}"))
            .collect();
        let span = heights.last().unwrap_or(&0.0) - heights[0];
        format!(
            "slices are not evenly spaced (steps of {}{more}): {} are resampled to {} that lie {:.4} apart",
            listed.join(", "),
            heights.len(),
            self.count,
            span / (self.count - 1).max(1) as f64
        )
    }

    /// Even slices of `plane` samples each.
    pub(super) fn resample(
        &self,
        samples: &Samples,
        plane: usize,
        context: &Context<'_>,
    ) -> Result<Samples, IoError> {
        let mut even: Vec<f32> = Vec::new();
        let total = plane.saturating_mul(self.count);
        even.try_reserve_exact(total)
            .map_err(|_| context.limit(total as u64 * 4, total as u64))?;
        with_samples!(samples, data => {
            for slice in 0..self.count {
                let rows = self.around(slice).map(|index| &data[index * plane..(index + 1) * plane]);
                self.add_slice(slice, rows, &mut even);
            }
        });
        Ok(Samples::F32(even.into()))
    }

    /// The slices between which an even one lies, and those beside them.
    pub(super) fn around(&self, slice: usize) -> [usize; 4] {
        let last = self.places.len() - 1;
        let upper = self
            .places
            .partition_point(|place| *place <= slice as f64)
            .clamp(1, last);
        [upper.saturating_sub(2), upper - 1, upper, (upper + 1).min(last)]
    }

    /// An even slice of `plane` samples, from the four [`Self::around`] it one after the other.
    pub(super) fn resample_one(&self, slice: usize, around: &Samples, plane: usize) -> Samples {
        let mut even: Vec<f32> = Vec::with_capacity(plane);
        with_samples!(around, data => {
            let rows = [0, 1, 2, 3].map(|index| &data[index * plane..(index + 1) * plane]);
            self.add_slice(slice, rows, &mut even);
        });
        Samples::F32(even.into())
    }

    fn add_slice<T: Copy + Into<f64>>(&self, slice: usize, rows: [&[T]; 4], even: &mut Vec<f32>) {
        let places = self.around(slice).map(|index| self.places[index]);
        let at = slice as f64;
        let values = rows[0].iter().zip(rows[1]).zip(rows[2].iter().zip(rows[3]));
        even.extend(
            values.map(|((&a, &b), (&c, &d))| cubic(places, [a, b, c, d].map(Into::into), at) as f32),
        );
    }
}

/// The value at `x` between the second and third place. Equal outer places stand for ends.
fn cubic(places: [f64; 4], values: [f64; 4], x: f64) -> f64 {
    let width = |i: usize| places[i + 1] - places[i];
    let slope = |i: usize| (values[i + 1] - values[i]) / width(i);
    let h = width(1);
    let inner = slope(1);
    let at = |i: usize| {
        let (before, after) = (width(i - 1), width(i));
        if before <= 0.0 || after <= 0.0 {
            return inner;
        }
        let (low, high) = (slope(i - 1), slope(i));
        if low * high <= 0.0 {
            return 0.0;
        }
        let (w1, w2) = (2.0 * after + before, after + 2.0 * before);
        (w1 + w2) / (w1 / low + w2 / high)
    };
    let t = ((x - places[1]) / h).clamp(0.0, 1.0);
    let (start, end) = (at(1) * h, at(2) * h);
    let rise = values[2] - values[1];
    values[1] + t * (start + t * (3.0 * rise - 2.0 * start - end + t * (start + end - 2.0 * rise)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn resampled(heights: &[f64], values: &[i16]) -> (Uneven, Vec<f32>) {
        let uneven = Uneven::new(heights);
        let context = Context::new("DICOM", Path::new("a"));
        let samples = Samples::I16(values.to_vec().into());
        let Samples::F32(even) = uneven.resample(&samples, 1, &context).unwrap() else {
            panic!("not real numbers");
        };
        (uneven, even.to_vec())
    }

    #[test]
    fn a_ramp_stays_a_ramp_wherever_slices_lie() {
        let heights = [0.0, 1.0, 2.0, 6.0, 13.0];
        let (uneven, even) = resampled(&heights, &[0, 10, 20, 60, 130]);
        assert_eq!(uneven.count, 14);
        for (index, value) in even.iter().enumerate() {
            assert!((value - 10.0 * index as f32).abs() < 1e-4, "{even:?}");
        }
        let text = uneven.describe(&heights);
        assert!(
            text.contains("steps of 1.0000, 4.0000, 7.0000") && text.contains("14 that lie 1.0000"),
            "{text}"
        );
    }

    #[test]
    fn slopes_do_not_jump_at_slices_and_values_stay_in_range() {
        let curve = |x: f64| (1000.0 * (x * 0.25).sin()) as i16;
        let heights = [0.0, 0.25, 0.5, 0.75, 1.0, 5.0, 9.0];
        let values: Vec<i16> = heights.iter().map(|x| curve(*x)).collect();
        let (uneven, even) = resampled(&heights, &values);
        assert_eq!(uneven.count, 37);
        let bends = even.windows(3).map(|v| (v[0] - 2.0 * v[1] + v[2]).abs());
        // Straight lines between the slices bend by 54 at the sixth.
        assert!(bends.fold(0.0, f32::max) < 12.0, "{even:?}");
        assert!(even.iter().all(|v| (0.0..=1000.0).contains(v)), "{even:?}");
    }

    #[test]
    fn two_slices_that_nearly_touch_do_not_make_millions() {
        let uneven = Uneven::new(&[0.0, 1e-6, 1.0, 2.0]);
        assert_eq!(uneven.count, 33);
    }
}
