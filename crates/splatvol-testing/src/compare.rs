//! Difference measures of two pictures.
//!
//! All four channels count, as premultiplied linear floats with peak 1: a wrong alpha is as wrong as a wrong colour.
//!
//! PSNR measures the size of the difference, not its pattern. Rounding noise is harmless; the same energy in tile
//! borders, rings or wood grain is a bug. So the difference picture has two figures of its own. Its
//! `autocorrelation` is that of neighbouring pixels (0 for white noise, towards 1 for anything smooth). Its
//! `coarse_share` is the share of its energy in the means of 8 x 8 blocks (1/64 for white noise, towards 1 for
//! large shapes).

use image_compare::Algorithm;
use image_compare::prelude::{GrayImage, RgbImage};
use serde::Serialize;
use splatvol_scene::Image;
use splatvol_scene::transfer_function::srgb_from_linear;

const BLOCK: usize = 8;

/// Figures of a comparison, with the difference picture they come from.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// Peak signal to noise ratio in dB, peak 1, over all four channels; infinite for equal pictures.
    pub psnr: f64,
    /// Largest absolute difference of any channel.
    pub max_error: f64,
    /// Position of the largest difference: column, row, channel.
    pub max_error_at: [usize; 3],
    /// Mean of actual - expected per channel RGBA.
    pub bias: [f64; 4],
    /// Correlation of the difference with itself one pixel aside (mean of both directions); 0 for equal pictures.
    pub autocorrelation: f64,
    /// Share of the difference's energy in the means of 8 x 8 blocks; 0 for equal pictures.
    pub coarse_share: f64,
    /// Structural similarity (8 x 8 windows, as `image-compare` computes it: covariances are sums, so that its C2 is
    /// 64 times weaker than usual) of the 8-bit sRGB pictures over black and of their alphas, the lowest of all.
    pub ssim: f64,
    /// Pixels with a channel that is not finite in either picture; they count as an error of 1.
    pub non_finite: usize,
    #[serde(skip)]
    width: usize,
    #[serde(skip)]
    difference: Vec<[f64; 4]>,
}

impl Comparison {
    /// Compares two pictures.
    ///
    /// # Panics
    /// If the pictures differ in size.
    pub fn of(actual: &Image, expected: &Image) -> Self {
        assert_eq!(
            actual.size(),
            expected.size(),
            "pictures of different sizes (actual, expected)"
        );
        let width = actual.size().width() as usize;
        let pairs = || actual.pixels.iter().zip(&expected.pixels);
        let finite = |pixel: &[f32; 4]| pixel.iter().all(|c| c.is_finite());
        let subtract = |(a, b): (&[f32; 4], &[f32; 4])| {
            if finite(a) && finite(b) {
                std::array::from_fn(|c| f64::from(a[c]) - f64::from(b[c]))
            } else {
                [1.0; 4]
            }
        };
        let difference: Vec<[f64; 4]> = pairs().map(subtract).collect();
        let count = difference.len() as f64;
        let energy: f64 = difference.iter().flatten().map(|d| d * d).sum();
        let (max_error, max_error_at) = largest(&difference, width);
        Self {
            psnr: -10.0 * (energy / (4.0 * count)).log10(),
            max_error,
            max_error_at,
            bias: std::array::from_fn(|c| difference.iter().map(|d| d[c]).sum::<f64>() / count),
            autocorrelation: autocorrelation(&difference, width),
            coarse_share: coarse_energy(&difference, width) / energy.max(f64::MIN_POSITIVE),
            ssim: structural_similarity(actual, expected),
            non_finite: pairs().filter(|(a, b)| !(finite(a) && finite(b))).count(),
            width,
            difference,
        }
    }

    /// Actual - expected per pixel, row-major.
    pub fn difference(&self) -> &[[f64; 4]] {
        &self.difference
    }

    /// Pixels per row of the difference.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels with a channel that is off by more than `tolerance`.
    pub fn count_above(&self, tolerance: f64) -> usize {
        let above = |pixel: &&[f64; 4]| pixel.iter().any(|d| d.abs() > tolerance);
        self.difference.iter().filter(above).count()
    }
}

fn largest(difference: &[[f64; 4]], width: usize) -> (f64, [usize; 3]) {
    let channels = difference.iter().flatten().map(|d| d.abs()).enumerate();
    let (index, error) = channels.fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best });
    (error, [index / 4 % width, index / 4 / width, index % 4])
}

/// Lag-one correlation, mean over both directions; the mean is not subtracted, for a bias is structure too.
fn autocorrelation(difference: &[[f64; 4]], width: usize) -> f64 {
    let along = |pairs: &mut dyn Iterator<Item = (&[f64; 4], &[f64; 4])>| {
        let (mut products, mut squares) = (0.0, 0.0);
        for (a, b) in pairs {
            for c in 0..4 {
                products += a[c] * b[c];
                squares += 0.5 * (a[c] * a[c] + b[c] * b[c]);
            }
        }
        if squares > 0.0 { products / squares } else { 0.0 }
    };
    let mut rows = difference.chunks(width).flat_map(|row| row.iter().zip(&row[1..]));
    let mut columns = difference.iter().zip(difference.iter().skip(width));
    0.5 * (along(&mut rows) + along(&mut columns))
}

/// Energy of the difference with every 8 x 8 block replaced by its mean.
fn coarse_energy(difference: &[[f64; 4]], width: usize) -> f64 {
    let mut energy = 0.0;
    for rows in difference.chunks(BLOCK * width) {
        for left in (0..width).step_by(BLOCK) {
            let right = (left + BLOCK).min(width);
            let block = || rows.chunks(width).flat_map(|row| &row[left..right]);
            let count = block().count() as f64;
            for c in 0..4 {
                let sum: f64 = block().map(|d| d[c]).sum();
                energy += sum * sum / count;
            }
        }
    }
    energy
}

fn structural_similarity(actual: &Image, expected: &Image) -> f64 {
    let (width, height) = (actual.size().width(), actual.size().height());
    let level = |value: f32| (255.0 * f64::from(value).clamp(0.0, 1.0)).round() as u8;
    let encoded = |value: f32| level(srgb_from_linear(f64::from(value).clamp(0.0, 1.0)) as f32);
    let color = |image: &Image| {
        let data = image
            .pixels
            .iter()
            .flat_map(|[r, g, b, _]| [r, g, b].map(|&c| encoded(c)));
        RgbImage::from_raw(width, height, data.collect())
    };
    let alpha = |image: &Image| {
        GrayImage::from_raw(
            width,
            height,
            image.pixels.iter().map(|pixel| level(pixel[3])).collect(),
        )
    };
    let parts = color(actual)
        .zip(color(expected))
        .zip(alpha(actual).zip(alpha(expected)));
    let ((color, expected_color), (alpha, expected_alpha)) = parts.expect("one value per pixel and channel");
    let method = Algorithm::MSSIMSimple;
    let color = image_compare::rgb_similarity_structure(&method, &color, &expected_color);
    let alpha = image_compare::gray_similarity_structure(&method, &alpha, &expected_alpha);
    let score = |result: Result<image_compare::Similarity, _>| result.expect("equal sizes").score;
    score(color).min(score(alpha))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use splatvol_scene::ImageSize;

    const SIZE: [u32; 2] = [64, 48];

    fn picture(pixel: impl FnMut(usize) -> [f32; 4]) -> Image {
        let size = ImageSize::try_from(SIZE).unwrap();
        Image::from_pixels(size, (0..size.pixel_count()).map(pixel).collect()).unwrap()
    }

    fn wave(index: usize) -> [f32; 4] {
        let (x, y) = (index % 64, index / 64);
        let value = 0.5 + 0.4 * (0.3 * x as f32).sin() * (0.2 * y as f32).cos();
        [value * 0.5, value * 0.7, value, 0.9 * value]
    }

    #[test]
    fn equal_pictures_have_no_difference() {
        let same = Comparison::of(&picture(wave), &picture(wave));
        assert_eq!(
            (same.psnr, same.max_error, same.count_above(0.0)),
            (f64::INFINITY, 0.0, 0)
        );
        assert_eq!(
            (same.autocorrelation, same.coarse_share, same.bias),
            (0.0, 0.0, [0.0; 4])
        );
        assert!(same.ssim > 0.999_999);
    }

    #[test]
    fn figures_are_those_of_a_known_difference() {
        let brighter = picture(|i| wave(i).map(|c| c + 0.01));
        let bias = Comparison::of(&brighter, &picture(wave));
        assert!((bias.psnr - 40.0).abs() < 1e-3 && (bias.bias[3] - 0.01).abs() < 1e-6);
        assert!(bias.autocorrelation > 0.999 && bias.coarse_share > 0.999);
        let mut spike = picture(wave);
        spike.pixels[64 * 7 + 5][2] += 0.5;
        let spike = Comparison::of(&spike, &picture(wave));
        assert_eq!((spike.max_error_at, spike.count_above(0.1)), ([5, 7, 2], 1));
        assert!((spike.max_error - 0.5).abs() < 1e-6 && spike.autocorrelation == 0.0);
    }

    #[test]
    fn noise_has_no_structure_and_a_shift_has() {
        let mut random = Random::new(9);
        let noisy = picture(|i| wave(i).map(|c| c + 0.01 * (random.unit() as f32 - 0.5)));
        let noise = Comparison::of(&noisy, &picture(wave));
        assert!(noise.autocorrelation.abs() < 0.05, "{}", noise.autocorrelation);
        assert!(noise.coarse_share < 0.03, "{}", noise.coarse_share);
        let shifted = Comparison::of(&picture(|i| wave(i + 1)), &picture(wave));
        assert!(shifted.autocorrelation > 0.9 && shifted.coarse_share > 0.5 && shifted.ssim < 0.99);
    }

    #[test]
    fn a_wrong_alpha_alone_is_seen_by_every_figure() {
        let fainter = picture(|i| [wave(i)[0], wave(i)[1], wave(i)[2], 0.5 * wave(i)[3]]);
        let found = Comparison::of(&fainter, &picture(wave));
        assert!(
            found.psnr < 20.0 && found.max_error > 0.3 && found.ssim < 0.95,
            "{found:?}"
        );
        assert_eq!(found.bias[..3], [0.0; 3]);
    }

    #[test]
    fn values_that_are_not_finite_are_errors() {
        let mut broken = picture(wave);
        broken.pixels[3][1] = f32::NAN;
        for (a, b) in [
            (&broken, &picture(wave)),
            (&picture(wave), &broken),
            (&broken, &broken),
        ] {
            let found = Comparison::of(a, b);
            assert_eq!((found.non_finite, found.max_error), (1, 1.0));
        }
    }

    #[test]
    fn small_pictures_can_be_compared() {
        for side in [1, 3, 9] {
            let image = Image::filled(ImageSize::new(side, side).unwrap(), [0.1, 0.2, 0.3, 0.4]);
            assert_eq!(Comparison::of(&image, &image).max_error, 0.0);
        }
    }
}
