//! Checksums of pictures: one that any change of an 8-bit code changes, and one that only visible changes change.
//!
//! Both are of the picture that `splatvol render` writes: 8-bit sRGB over the default background. SIMD levels differ
//! by about 1e-5 in linear light, which changes single codes. The means of 8 x 8 cells tolerate that; they are
//! recorded and compared.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Context;
use serde::Serialize;
use sha2::{Digest, Sha256};
use splatvol::Image;

use crate::commands::metrics;
use crate::failure::{During, Failure, Step};
use crate::output::Target;
use splatvol_document::keys::CHARCOAL;
use splatvol_document::resolve::laid_over;

/// Cells along each side.
const CELLS: u32 = 8;
/// Largest difference of a cell's mean that counts as equal, in shares of full sRGB.
const TOLERANCE: f64 = 1e-3;
/// Recorded digits, as a factor: a tenth of the tolerance.
const DIGITS: f64 = 1e4;

/// Record of the fixed scenes; see [`Expected::write`].
const EXPECTED: &str = include_str!("expected.json");

/// A picture in short.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Checksum {
    /// SHA-256 of the 8-bit RGB codes, row by row, hexadecimal.
    pub(super) sha256: String,
    /// Means of the cells' sRGB in 0..1, row by row: red, green, blue of each.
    pub(super) fingerprint: Vec<f64>,
}

impl Checksum {
    /// The checksum of a picture without background.
    pub(super) fn new(image: &Image) -> Self {
        let codes = metrics::codes(&laid_over(image, CHARCOAL));
        let [width, height] = [image.size().width(), image.size().height()];
        // Cells of pictures with fewer pixels than cells overlap.
        let range = |cell: u32, side: u32| {
            let edge = |i: u32| (u64::from(i) * u64::from(side) / u64::from(CELLS)) as u32;
            edge(cell)..edge(cell + 1).max(edge(cell) + 1)
        };
        let mut fingerprint = Vec::with_capacity(3 * (CELLS * CELLS) as usize);
        for row in 0..CELLS {
            for column in 0..CELLS {
                let mut sums = [0u64; 3];
                let (xs, ys) = (range(column, width), range(row, height));
                let pixels = u64::from(xs.end - xs.start) * u64::from(ys.end - ys.start);
                for y in ys {
                    for x in xs.clone() {
                        let code = codes[(y * width + x) as usize];
                        sums = std::array::from_fn(|c| sums[c] + u64::from(code[c]));
                    }
                }
                let mean = |sum: u64| sum as f64 / (255 * pixels) as f64;
                fingerprint.extend(sums.map(|sum| (mean(sum) * DIGITS).round() / DIGITS));
            }
        }
        let hash = Sha256::digest(codes.as_flattened());
        Self {
            sha256: hash.iter().map(|byte| format!("{byte:02x}")).collect(),
            fingerprint,
        }
    }
}

/// How a picture compares with its record.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "verdict", rename_all = "kebab-case")]
pub(super) enum Check {
    /// Within the tolerance.
    Agrees {
        /// Largest difference of a cell's mean, sRGB in 0..1.
        difference: f64,
    },
    /// Visibly different.
    Differs {
        /// Largest difference of a cell's mean, sRGB in 0..1.
        difference: f64,
        /// The cell, column and row from the upper left.
        cell: [usize; 2],
    },
    /// A fixed case without a record.
    Unrecorded,
    /// Nothing is expected of this picture.
    Unchecked,
}

/// Fingerprints by name of the case.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Expected(BTreeMap<String, Vec<f64>>);

impl Expected {
    /// The record in a file, or the one that this program was built with.
    pub(super) fn recorded(file: Option<&Path>) -> Result<Self, Failure> {
        let Some(path) = file else {
            let cases = serde_json::from_str(EXPECTED).context("the recorded pictures of the fixed scenes");
            return cases.map(Self).during(Step::Render);
        };
        let read = || -> anyhow::Result<_> { Ok(serde_json::from_str(&std::fs::read_to_string(path)?)?) };
        read()
            .with_context(|| format!("cannot read recorded pictures from {}", path.display()))
            .map(Self)
            .during(Step::Input)
    }

    /// Compares the picture of a fixed case with its record.
    pub(super) fn check(&self, case: &str, found: &Checksum) -> Check {
        let Some(expected) = self.0.get(case).filter(|e| e.len() == found.fingerprint.len()) else {
            return Check::Unrecorded;
        };
        let pairs = expected.iter().zip(&found.fingerprint);
        let differences = pairs.map(|(expected, found)| (expected - found).abs());
        let largest = differences.enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
        match largest {
            Some((index, difference)) if difference > TOLERANCE => Check::Differs {
                difference,
                cell: [index / 3 % CELLS as usize, index / 3 / CELLS as usize],
            },
            largest => Check::Agrees {
                difference: largest.map_or(0.0, |(_, difference)| difference),
            },
        }
    }

    /// Records a picture, in place of an older one.
    pub(super) fn record(&mut self, case: &str, found: &Checksum) {
        self.0.insert(case.to_owned(), found.fingerprint.clone());
    }

    /// Names of the recorded cases.
    #[cfg(test)]
    pub(super) fn names(&self) -> Vec<&str> {
        self.0.keys().map(String::as_str).collect()
    }

    /// Removes cases that no longer exist.
    pub(super) fn retain(&mut self, known: impl Fn(&str) -> bool) {
        self.0.retain(|case, _| known(case));
    }

    /// Writes the file that [`Expected::recorded`] is built from, a line per case.
    pub(super) fn write(&self, path: &Path) -> Result<(), Failure> {
        let lines = self.0.iter().map(|(case, fingerprint)| {
            let means: Vec<String> = fingerprint.iter().map(f64::to_string).collect();
            format!("\"{case}\": [{}]", means.join(","))
        });
        let text = format!("{{\n{}\n}}\n", lines.collect::<Vec<_>>().join(",\n"));
        Target::File(path.to_owned()).write(text.as_bytes(), true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol::ImageSize;

    fn expected(checksum: &Checksum) -> Expected {
        Expected(BTreeMap::from([("a".to_owned(), checksum.fingerprint.clone())]))
    }

    fn half_white(width: u32, height: u32) -> Image {
        let mut image = Image::filled(ImageSize::new(width, height).unwrap(), [0.0, 0.0, 0.0, 1.0]);
        let half = image.pixels.len() / 2;
        image.pixels[half..].fill([1.0; 4]);
        image
    }

    #[test]
    fn cells_are_means_of_the_picture_over_the_background() {
        let checksum = Checksum::new(&half_white(40, 32));
        assert_eq!(checksum.fingerprint.len(), 192);
        assert!(checksum.fingerprint[..96].iter().all(|&mean| mean == 0.0));
        assert!(checksum.fingerprint[96..].iter().all(|&mean| mean == 1.0));
        let clear = Image::filled(ImageSize::new(3, 5).unwrap(), [0.0; 4]);
        let background = CHARCOAL.map(|c| (255.0 * c).round() / 255.0);
        for cell in Checksum::new(&clear).fingerprint.chunks_exact(3) {
            assert!(
                cell.iter()
                    .zip(background)
                    .all(|(a, b)| (a - b).abs() <= 0.5 / DIGITS)
            );
        }
    }

    #[test]
    fn rounding_is_borne_and_a_spot_is_found() {
        let image = half_white(64, 64);
        let before = Checksum::new(&image);
        let mut one_code = image.clone();
        one_code.pixels[0] = [0.0, 0.001, 0.0, 1.0];
        let found = Checksum::new(&one_code);
        assert_ne!(found.sha256, before.sha256);
        assert!(matches!(
            expected(&before).check("a", &found),
            Check::Agrees { .. }
        ));
        let mut spot = image;
        spot.pixels[5 * 64 + 20] = [0.5, 0.5, 0.5, 1.0];
        let Check::Differs { difference, cell } = expected(&before).check("a", &Checksum::new(&spot)) else {
            panic!("the spot is not seen");
        };
        assert_eq!(cell, [2, 0]);
        assert!((difference - 0.735 / 64.0).abs() < 1e-3, "{difference}");
        assert_eq!(expected(&before).check("b", &before), Check::Unrecorded);
    }

    #[test]
    fn what_is_written_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("expected.json");
        let mut recorded = expected(&Checksum::new(&half_white(9, 9)));
        recorded.record("b", &Checksum::new(&half_white(16, 16)));
        recorded
            .write(&path)
            .map_err(|failure| format!("{failure:?}"))
            .unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(Expected(serde_json::from_str(&text).unwrap()), recorded);
        assert_eq!(text.lines().count(), 4);
        recorded.retain(|case| case == "b");
        assert_eq!(recorded.0.len(), 1);
    }
}
