//! Numbers about pictures.

use splatvol::Image;
use splatvol_testing::Comparison;

/// Relative luminance of each pixel, rows from the top: linear light, Rec. 709 weights, over black.
pub(crate) fn luminance(image: &Image) -> Vec<f64> {
    let weigh = |pixel: &[f32; 4]| {
        let [r, g, b, _] = pixel.map(f64::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    image.pixels.iter().map(weigh).collect()
}

/// Peak signal-to-noise ratio of two pictures over all four channels, decibels; infinite if they are equal.
pub(crate) fn psnr(actual: &Image, expected: &Image) -> f64 {
    Comparison::of(actual, expected).psnr
}
