//! Demanding that pictures agree: one builder of tolerances, one assertion.
//!
//! ```
//! use splatvol_scene::{Image, ImageSize};
//! use splatvol_testing::{Tolerance, assert_images};
//!
//! let expected = Image::filled(ImageSize::new(8, 8).unwrap(), [0.2, 0.2, 0.2, 0.5]);
//! let actual = expected.clone();
//! assert_images("doc-example", &actual, &expected, Tolerance::psnr(45.0).max_error(0.02).bias(1e-3));
//! ```

use std::path::{Path, PathBuf};

use serde::Serialize;
use splatvol_scene::transfer_function::srgb_from_linear;
use splatvol_scene::{Image, ImageSize};

use crate::{Comparison, picture};

/// Limits on a comparison. A minimum PSNR is always required; the others apply if set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tolerance {
    psnr: f64,
    max_error: Option<f64>,
    bias: Option<f64>,
    ssim: Option<f64>,
    autocorrelation: Option<f64>,
    coarse_share: Option<f64>,
    /// At most this many pixels off by more than this.
    outliers: Option<(usize, f64)>,
}

impl Tolerance {
    /// At least this PSNR in dB (peak 1, all four channels, linear premultiplied).
    pub fn psnr(decibels: f64) -> Self {
        Self {
            psnr: decibels,
            max_error: None,
            bias: None,
            ssim: None,
            autocorrelation: None,
            coarse_share: None,
            outliers: None,
        }
    }

    /// Equal to the last bit (except for the sign of zero).
    pub fn exact() -> Self {
        Self::psnr(f64::INFINITY)
    }

    /// No channel of any pixel off by more than this.
    #[must_use]
    pub fn max_error(mut self, error: f64) -> Self {
        self.max_error = Some(error);
        self
    }

    /// No channel's mean off by more than this.
    #[must_use]
    pub fn bias(mut self, bias: f64) -> Self {
        self.bias = Some(bias);
        self
    }

    /// At least this structural similarity (8-bit sRGB).
    #[must_use]
    pub fn ssim(mut self, similarity: f64) -> Self {
        self.ssim = Some(similarity);
        self
    }

    /// A difference whose neighbours correlate by no more than this (white noise: 0).
    #[must_use]
    pub fn autocorrelation(mut self, correlation: f64) -> Self {
        self.autocorrelation = Some(correlation);
        self
    }

    /// A difference with no more than this share of its energy in means of 8 x 8 blocks (white noise: 1/64).
    #[must_use]
    pub fn coarse_share(mut self, share: f64) -> Self {
        self.coarse_share = Some(share);
        self
    }

    /// At most `pixels` pixels off by more than `error`.
    #[must_use]
    pub fn outliers(mut self, pixels: usize, error: f64) -> Self {
        self.outliers = Some((pixels, error));
        self
    }

    /// Violated limits, in words; empty if the comparison passes.
    pub fn violations(&self, found: &Comparison) -> Vec<String> {
        let mut violations = Vec::new();
        let mut demand = |holds: bool, text: String| {
            if !holds {
                violations.push(text);
            }
        };
        demand(
            found.non_finite == 0,
            format!("{} pixels are not finite", found.non_finite),
        );
        demand(
            found.psnr >= self.psnr,
            format!("PSNR {:.2} dB, wanted {:.2}", found.psnr, self.psnr),
        );
        let bias = found.bias.into_iter().map(f64::abs).fold(0.0, f64::max);
        let at_most = [
            ("largest error", found.max_error, self.max_error),
            ("bias", bias, self.bias),
            ("autocorrelation", found.autocorrelation, self.autocorrelation),
            ("coarse share", found.coarse_share, self.coarse_share),
        ];
        for (name, value, limit) in at_most {
            if let Some(limit) = limit {
                demand(value <= limit, format!("{name} {value:.3e}, allowed {limit:.3e}"));
            }
        }
        if let Some(limit) = self.ssim {
            demand(
                found.ssim >= limit,
                format!("SSIM {:.5}, wanted {limit:.5}", found.ssim),
            );
        }
        if let Some((pixels, error)) = self.outliers {
            let count = found.count_above(error);
            demand(
                count <= pixels,
                format!("{count} pixels off by more than {error}, allowed {pixels}"),
            );
        }
        violations
    }
}

/// Demands that `actual` agrees with `expected`.
///
/// On failure `target/test-output/NAME.png` shows expected | difference | actual (colours above, alphas below; the
/// difference is signed around grey and amplified as stated) and `NAME.json` holds the figures.
///
/// # Panics
/// If the tolerance is violated, or the pictures differ in size.
#[track_caller]
pub fn assert_images(name: &str, actual: &Image, expected: &Image, tolerance: Tolerance) {
    if let Err(report) = check_images(&output_folder(), name, (actual, expected), &tolerance) {
        panic!("{report}");
    }
}

/// Output folder of failing tests: `target/test-output` of the workspace.
pub fn output_folder() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target"),
        PathBuf::from,
    );
    target.join("test-output")
}

/// The check behind [`assert_images`], for an (actual, expected) pair; the error is the text to panic with.
pub(crate) fn check_images(
    folder: &Path,
    name: &str,
    (actual, expected): (&Image, &Image),
    tolerance: &Tolerance,
) -> Result<(), String> {
    if actual.size() != expected.size() {
        return Err(format!(
            "{name}: size {:?}, expected {:?}",
            actual.size(),
            expected.size()
        ));
    }
    let found = Comparison::of(actual, expected);
    let violations = tolerance.violations(&found);
    if violations.is_empty() {
        return Ok(());
    }
    let path = folder.join(format!("{}.png", file_name(name)));
    let amplification = amplification(&found);
    let written = write_triptych(&path, (actual, expected), &found, amplification)
        .and_then(|()| write_figures(&path.with_extension("json"), &found, tolerance, amplification));
    let picture = match written {
        Ok(()) => format!(
            "{} (difference x {amplification}, expected | difference | actual)",
            path.display()
        ),
        Err(error) => format!("{} could not be written: {error}", path.display()),
    };
    Err(format!(
        "{name}: {}\n  PSNR {:.2} dB, largest error {:.3e} at {:?} (x, y, channel), bias {}, SSIM {:.5}, \
         autocorrelation {:.3}, coarse share {:.3}\n  {picture}",
        violations.join("; "),
        found.psnr,
        found.max_error,
        found.max_error_at,
        found.bias.map(|bias| format!("{bias:.2e}")).join(" "),
        found.ssim,
        found.autocorrelation,
        found.coarse_share,
    ))
}

/// A test's name as a file name.
pub(crate) fn file_name(name: &str) -> String {
    let safe = |c: char| {
        if c.is_alphanumeric() || "-_.".contains(c) {
            c
        } else {
            '-'
        }
    };
    name.chars().map(safe).collect()
}

/// Power of two by which the difference fits the range -1..1 best.
fn amplification(found: &Comparison) -> f64 {
    let exponent = -found.max_error.max(1e-9).log2();
    exponent.floor().clamp(0.0, 20.0).exp2()
}

fn write_figures(
    path: &Path,
    found: &Comparison,
    tolerance: &Tolerance,
    amplification: f64,
) -> std::io::Result<()> {
    let figures = serde_json::json!({
        "found": found,
        "tolerance": tolerance,
        "difference_amplification": amplification,
    });
    std::fs::write(path, serde_json::to_string_pretty(&figures)?)
}

fn write_triptych(
    path: &Path,
    (actual, expected): (&Image, &Image),
    found: &Comparison,
    amplification: f64,
) -> std::io::Result<()> {
    const GAP: usize = 4;
    let (width, height) = (found.width(), found.difference().len() / found.width());
    let (full_width, full_height) = (3 * width + 2 * GAP, 2 * height + GAP);
    let size = ImageSize::new(full_width as u32, full_height as u32)
        .map_err(|error| std::io::Error::new(std::io::ErrorKind::InvalidInput, error.to_string()))?;
    let level = |value: f64| (255.0 * value.clamp(0.0, 1.0)).round() as u8;
    let shown = |value: f32| level(srgb_from_linear(f64::from(value).clamp(0.0, 1.0)));
    let signed = |value: f64| level(0.5 + 0.5 * amplification * value);
    let mut data = vec![255u8; 3 * size.pixel_count()];
    let mut put = |panel: usize, row: usize, index: usize, rgb: [u8; 3]| {
        let x = panel * (width + GAP) + index % width;
        let y = row * (height + GAP) + index / width;
        let at = 3 * (y * full_width + x);
        data[at..at + 3].copy_from_slice(&rgb);
    };
    for (index, difference) in found.difference().iter().enumerate() {
        for (panel, image) in [(0, expected), (2, actual)] {
            let [r, g, b, alpha] = image.pixels[index];
            put(panel, 0, index, [r, g, b].map(shown));
            put(panel, 1, index, [level(f64::from(alpha)); 3]);
        }
        let [r, g, b, alpha] = *difference;
        put(1, 0, index, [r, g, b].map(signed));
        put(1, 1, index, [signed(alpha); 3]);
    }
    picture::write_rgb8(path, size, &data)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(offset: f32, alpha: f32) -> Image {
        let size = ImageSize::new(40, 30).unwrap();
        let pixel = |index: usize| {
            let (x, y) = ((index % 40) as f32 - 20.0 - offset, (index / 40) as f32 - 15.0);
            let inside = (11.0 - (x * x + y * y).sqrt()).clamp(0.0, 1.0);
            [0.8 * inside, 0.4 * inside, 0.1 * inside, alpha * inside]
        };
        Image::from_pixels(size, (0..size.pixel_count()).map(pixel).collect()).unwrap()
    }

    fn check(actual: &Image, tolerance: Tolerance) -> (tempfile::TempDir, Result<(), String>) {
        let folder = tempfile::tempdir().unwrap();
        let result = check_images(
            folder.path(),
            "a test/of discs",
            (actual, &disc(0.0, 0.9)),
            &tolerance,
        );
        (folder, result)
    }

    #[test]
    fn equal_pictures_pass_and_leave_nothing() {
        let (folder, result) = check(&disc(0.0, 0.9), Tolerance::exact().max_error(0.0).bias(0.0));
        assert_eq!(result, Ok(()));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_wrong_alpha_alone_fails() {
        let (_folder, result) = check(&disc(0.0, 0.8), Tolerance::psnr(40.0));
        assert!(result.unwrap_err().contains("wanted 40.00"));
    }

    #[test]
    fn a_shifted_picture_fails() {
        let (_folder, result) = check(&disc(1.0, 0.9), Tolerance::psnr(30.0));
        assert!(result.is_err());
        // Even where the demanded PSNR is low: each of the other figures refuses it.
        let loose = Tolerance::psnr(5.0);
        for tolerance in [
            loose.max_error(0.3),
            loose.ssim(0.99),
            loose.autocorrelation(0.3),
            loose.outliers(10, 0.3),
        ] {
            assert!(check(&disc(1.0, 0.9), tolerance).1.is_err(), "{tolerance:?}");
        }
        assert!(check(&disc(1.0, 0.9), loose).1.is_ok());
    }

    #[test]
    fn a_bias_fails() {
        let brighter = Image::from_pixels(
            disc(0.0, 0.9).size(),
            disc(0.0, 0.9)
                .pixels
                .iter()
                .map(|p| p.map(|c| c + 0.002))
                .collect(),
        );
        let brighter = brighter.unwrap();
        assert!(check(&brighter, Tolerance::psnr(50.0)).1.is_ok());
        assert!(check(&brighter, Tolerance::psnr(50.0).bias(1e-3)).1.is_err());
        assert!(
            check(&brighter, Tolerance::psnr(50.0).coarse_share(0.5))
                .1
                .is_err()
        );
    }

    #[test]
    fn values_that_are_not_finite_fail_any_tolerance() {
        let mut broken = disc(0.0, 0.9);
        broken.pixels[0][0] = f32::NAN;
        assert!(
            check(&broken, Tolerance::psnr(0.0))
                .1
                .unwrap_err()
                .contains("not finite")
        );
    }

    #[test]
    fn a_failure_leaves_a_triptych_and_its_figures() {
        let (folder, result) = check(&disc(0.25, 0.9), Tolerance::psnr(60.0));
        let path = folder.path().join("a-test-of-discs.png");
        assert!(result.unwrap_err().contains(&path.display().to_string()));
        let reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
        let mut reader = reader.read_info().unwrap();
        assert_eq!(reader.info().size(), (3 * 40 + 8, 2 * 30 + 4));
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        // The middle of the disc: orange, no difference (grey), orange.
        let at = |x: usize, y: usize| &data[3 * (y * 128 + x)..][..3];
        assert_eq!(at(20, 15), at(88 + 20, 15));
        assert_eq!(
            (at(44 + 20, 15), at(44 + 20, 34 + 15)),
            (&[128; 3][..], &[128; 3][..])
        );
        let figures = std::fs::read_to_string(path.with_extension("json")).unwrap();
        let figures: serde_json::Value = serde_json::from_str(&figures).unwrap();
        assert!(figures["found"]["psnr"].as_f64().unwrap() < 60.0);
        assert!(figures["difference_amplification"].as_f64().unwrap() >= 1.0);
    }

    #[test]
    #[should_panic(expected = "size")]
    fn pictures_of_different_sizes_panic() {
        let small = Image::filled(ImageSize::new(2, 2).unwrap(), [0.0; 4]);
        assert_images("sizes", &small, &disc(0.0, 0.9), Tolerance::psnr(10.0));
    }
}
