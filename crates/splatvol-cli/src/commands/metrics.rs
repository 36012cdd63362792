//! Measures of difference.
//!
//! PSNR is `20 log10(255 / rmse)` over the three 8-bit sRGB channels of both pictures over black. SSIM (Wang et al.
//! 2004) is the mean over windows of 8 x 8 pixels, of the worst channel.

use serde::Serialize;
use splatvol::transfer_function::srgb_from_linear;
use splatvol::{Image, SceneError, Volume};

use super::ssim::structural_similarity;

/// Differences of two pictures of one size.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct PictureDifference {
    /// Decibel; absent for pictures that are equal in 8 bits.
    psnr: Option<f64>,
    /// 1 for equal pictures.
    ssim: f64,
    /// Largest difference of any of the four channels, premultiplied linear light.
    max_error: f64,
    /// Root mean square of the same.
    rms_error: f64,
    /// Share of the pixels with any difference in 8 bits.
    differing_pixels: f64,
}

impl PictureDifference {
    /// Of two pictures of one size.
    pub(crate) fn new(a: &Image, b: &Image) -> Self {
        let (mut max_error, mut squares) = (0.0f64, 0.0);
        for (a, b) in a.pixels.iter().zip(&b.pixels) {
            for (a, b) in a.iter().zip(b) {
                let error = if a == b { 0.0 } else { f64::from((a - b).abs()) };
                max_error = max_error.max(error);
                squares += error * error;
            }
        }
        let (codes_a, codes_b) = (codes(a), codes(b));
        let pairs = codes_a.as_flattened().iter().zip(codes_b.as_flattened());
        let sum: f64 = pairs.map(|(&a, &b)| f64::from(a.abs_diff(b)).powi(2)).sum();
        let rmse = (sum / codes_a.as_flattened().len() as f64).sqrt();
        let differing = codes_a.iter().zip(&codes_b).filter(|(a, b)| a != b).count();
        Self {
            psnr: (rmse > 0.0).then(|| 20.0 * (255.0 / rmse).log10()),
            ssim: structural_similarity(&codes_a, &codes_b, a.size().width() as usize),
            max_error,
            rms_error: (squares / (4.0 * a.pixels.len() as f64)).sqrt(),
            differing_pixels: differing as f64 / codes_a.len() as f64,
        }
    }

    /// Decibel; `None` for pictures that are equal in 8 bits.
    pub(crate) fn psnr(&self) -> Option<f64> {
        self.psnr
    }

    pub(crate) fn text(&self) -> String {
        let psnr = self.psnr.map_or_else(
            || "infinite (equal in 8 bits)".to_owned(),
            |psnr| format!("{psnr:.2} dB"),
        );
        format!(
            "PSNR              {psnr}\nSSIM              {:.6}\nmaximum error     {:.6}\nRMS error         {:.6}\ndiffering pixels  {:.4} %",
            self.ssim,
            self.max_error,
            self.rms_error,
            100.0 * self.differing_pixels
        )
    }
}

/// 8-bit sRGB over black.
pub(crate) fn codes(image: &Image) -> Vec<[u8; 3]> {
    let encode = |c: f32| (255.0 * srgb_from_linear(f64::from(c.clamp(0.0, 1.0)))).round() as u8;
    let pixels = image.pixels.iter();
    pixels.map(|&[r, g, b, _]| [r, g, b].map(encode)).collect()
}

/// Absolute differences of colour (linear light), opaque, scaled so that the largest is white.
pub(crate) fn difference_picture(a: &Image, b: &Image) -> Result<Image, SceneError> {
    let mut pixels: Vec<[f32; 4]> = a
        .pixels
        .iter()
        .zip(&b.pixels)
        .map(|(a, b)| {
            // Pixels that differ only in alpha show as grey.
            let alpha = (a[3] - b[3]).abs();
            let channel = |c: usize| (a[c] - b[c]).abs().max(alpha);
            [channel(0), channel(1), channel(2), 1.0]
        })
        .collect();
    let largest = pixels
        .iter()
        .flat_map(|p| &p[..3])
        .fold(0.0f32, |most, &c| most.max(c));
    if largest > 0.0 {
        for pixel in &mut pixels {
            for channel in &mut pixel[..3] {
                *channel /= largest;
            }
        }
    }
    Image::from_pixels(a.size(), pixels)
}

/// Differences of two volumes of the same dims.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct VolumeDifference {
    /// Largest difference of real values.
    max_error: f64,
    /// Root mean square of the differences.
    rms_error: f64,
    /// Samples that differ.
    differing_samples: usize,
    /// Samples that are missing in only one of the volumes.
    missing_in_one: usize,
    /// Largest difference of the maps from voxel to world, over the grid's corners.
    max_displacement: f64,
}

impl VolumeDifference {
    pub(crate) fn new(a: &Volume, b: &Volume) -> Self {
        let (mut max_error, mut squares, mut both) = (0.0f64, 0.0, 0usize);
        let (mut differing_samples, mut missing_in_one) = (0, 0);
        for (a, b) in (0..a.samples().len()).map(|i| (a.value(i), b.value(i))) {
            match (a.is_finite(), b.is_finite()) {
                (true, true) => {
                    both += 1;
                    differing_samples += usize::from(a != b);
                    max_error = max_error.max((a - b).abs());
                    squares += (a - b).powi(2);
                }
                (false, false) => {}
                _ => missing_in_one += 1,
            }
        }
        let corners = a.grid().corners().into_iter().zip(b.grid().corners());
        Self {
            max_error,
            rms_error: (squares / both.max(1) as f64).sqrt(),
            differing_samples: differing_samples + missing_in_one,
            missing_in_one,
            max_displacement: corners.map(|(a, b)| a.distance(b)).fold(0.0, f64::max),
        }
    }

    pub(crate) fn text(&self) -> String {
        format!(
            "maximum error      {}\nRMS error          {}\ndiffering samples  {}\nmissing in one     {}\ndisplacement       {}",
            self.max_error,
            self.rms_error,
            self.differing_samples,
            self.missing_in_one,
            self.max_displacement
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol::ImageSize;

    fn flat(value: f32) -> Image {
        Image::filled(ImageSize::new(16, 16).unwrap(), [value, value, value, 1.0])
    }

    #[test]
    fn equal_pictures_have_no_difference() {
        let difference = PictureDifference::new(&flat(0.3), &flat(0.3));
        assert_eq!(difference.psnr, None);
        assert_eq!(
            [difference.ssim, difference.max_error, difference.differing_pixels],
            [1.0, 0.0, 0.0]
        );
    }

    #[test]
    fn black_and_white_are_as_far_apart_as_can_be() {
        let difference = PictureDifference::new(&flat(0.0), &flat(1.0));
        assert!(difference.psnr.unwrap().abs() < 1e-12);
        assert!(difference.ssim < 0.01);
        assert_eq!([difference.max_error, difference.differing_pixels], [1.0, 1.0]);
        assert!((difference.rms_error - 0.75f64.sqrt()).abs() < 1e-12);
        assert_eq!(difference_picture(&flat(0.0), &flat(0.5)).unwrap(), flat(1.0));
    }
}
