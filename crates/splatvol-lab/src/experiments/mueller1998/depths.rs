//! Parts of pictures before and beyond a depth, and the differences of pictures there.

use splatvol::{Frame, Image};

use crate::measure::luminance;

/// RMS difference of two pictures inside a mask, both low-passed by a pixel.
pub(super) fn difference(one: &Image, other: &Image, mask: &[bool]) -> f64 {
    rms(&smooth(one), &smooth(other), mask)
}

/// Luminance, low-passed by a pixel.
pub(super) fn smooth(image: &Image) -> Vec<f64> {
    low_passed(&luminance(image), image.size().width() as usize)
}

/// RMS difference inside a mask.
pub(super) fn rms(a: &[f64], b: &[f64], mask: &[bool]) -> f64 {
    let squares = a.iter().zip(b).zip(mask).filter(|(_, here)| **here);
    let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), ((a, b), _)| {
        (sum + (a - b).powi(2), count + 1.0)
    });
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Convolved with a Gaussian of one pixel; the border repeats.
fn low_passed(values: &[f64], width: usize) -> Vec<f64> {
    const REACH: isize = 4;
    let height = values.len() / width;
    let weights: Vec<f64> = (-REACH..=REACH).map(|i| (-0.5 * (i * i) as f64).exp()).collect();
    let total: f64 = weights.iter().sum();
    let along = |values: &[f64], [dx, dy]: [isize; 2]| -> Vec<f64> {
        let at = |index: usize| {
            let (x, y) = ((index % width) as isize, (index / width) as isize);
            let taps = (-REACH..=REACH).zip(&weights).map(|(i, weight)| {
                let x = (x + i * dx).clamp(0, width as isize - 1) as usize;
                let y = (y + i * dy).clamp(0, height as isize - 1) as usize;
                weight * values[y * width + x]
            });
            taps.sum::<f64>() / total
        };
        (0..values.len()).map(at).collect()
    };
    along(&along(values, [1, 0]), [0, 1])
}

/// Blackens the pixels where the depth passes `z_k`.
pub(super) fn line(image: &mut Image, depth: &[f32], z_k: f64) {
    let width = image.size().width() as usize;
    let beyond = |index: usize| depth.get(index).is_some_and(|&z| f64::from(z) > z_k);
    for index in 0..depth.len() {
        let right = (index + 1) % width != 0 && beyond(index) != beyond(index + 1);
        let below = index + width < depth.len() && beyond(index) != beyond(index + width);
        if right || below {
            image.pixels[index] = [0.0, 0.0, 0.0, 1.0];
        }
    }
}

/// Pixels nearer than `z_k`, and farther from all others than the low-pass reaches.
pub(super) fn nearer(frame: &Frame, beyond: &[bool]) -> Vec<bool> {
    const REACH: usize = 6;
    let width = frame.image.size().width() as usize;
    let height = beyond.len() / width;
    let near = |index: usize| frame.depth[index].is_finite() && !beyond[index];
    (0..beyond.len())
        .map(|index| {
            let (x, y) = (index % width, index / width);
            let rows = y.saturating_sub(REACH)..(y + REACH + 1).min(height);
            rows.into_iter().all(|y| {
                let columns = x.saturating_sub(REACH)..(x + REACH + 1).min(width);
                columns.into_iter().all(|x| near(y * width + x))
            })
        })
        .collect()
}
