//! JPEG-LS, lossless and near-lossless (ITU-T T.87, ISO/IEC 14495-1).
//!
//! A sample is predicted by the median of left, above and their gradient (A.4), corrected by what earlier samples with
//! like surroundings have taught, and the error is coded by Golomb's limited codes (A.5.3). Where all gradients
//! vanish, runs are coded (A.7). No suitable crate exists in Rust: those found bring C++ or a whole toolkit. Not read:
//! mapping tables, components of different sizes, and colours that are transformed by an extension.

use super::jpeg_ls_header::{Interleave, Segments};
use super::jpeg_ls_scan::Scan;
use crate::IoError;
use crate::error::Context;

/// The samples of an image of this size (columns, rows, components), pixel by pixel.
pub(super) fn decode(coded: &[u8], size: [usize; 3], context: &Context<'_>) -> Result<Vec<u16>, IoError> {
    let [columns, rows, components] = size;
    let mut segments = Segments::new(coded, size, context);
    let mut samples = vec![0; columns * rows * components];
    let mut left = components;
    while left > 0 {
        let header = segments.next_scan()?;
        let count = header.components.len();
        if count > left {
            let expected = format!("{left} more");
            return Err(context.field("components of a JPEG-LS scan", count, None, expected));
        }
        left -= count;
        let groups = match header.interleave {
            Interleave::None | Interleave::Line => [count, 1],
            Interleave::Sample => [1, count],
        };
        let mut scan = Scan::new(&coded[segments.at..], columns, groups, header.parameters);
        for (row, pixels) in samples.chunks_exact_mut(columns * components).enumerate() {
            if scan.line().is_none() {
                return Err(context.truncated("JPEG-LS rows", rows as u64, row as u64));
            }
            for (line, &component) in scan.lines().zip(&header.components) {
                let targets = pixels.iter_mut().skip(component).step_by(components);
                targets
                    .zip(line)
                    .for_each(|(target, &sample)| *target = sample as u16);
            }
        }
        segments.at += scan.position();
        skip_padding(&mut segments.at, coded);
    }
    Ok(samples)
}

/// Goes on to the next marker. A scan whose last byte is 0xff has another byte behind it (A.1).
fn skip_padding(at: &mut usize, coded: &[u8]) {
    let marker = |pair: &[u8]| pair[0] == 0xff && pair[1] >= 0x80;
    let rest = coded.get(*at..).unwrap_or_default();
    *at += rest.windows(2).position(marker).unwrap_or(rest.len());
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const START: [u8; 2] = [0xff, 0xd8];
    /// The scan of T.87's example (annex H.3), and its samples.
    const SCAN: [u8; 31] = [
        0xc0, 0x00, 0x00, 0x6c, 0x80, 0x20, 0x8e, 0x01, 0xc0, 0x00, 0x00, 0x57, 0x40, 0x00, 0x00, 0x6e, 0xe6,
        0x00, 0x00, 0x01, 0xbc, 0x18, 0x00, 0x00, 0x05, 0xd8, 0x00, 0x00, 0x91, 0x60, 0xff,
    ];
    const SAMPLES: [u16; 16] = [
        0, 0, 90, 74, 68, 50, 43, 205, 64, 145, 145, 145, 100, 145, 145, 145,
    ];

    /// The frame of 4 x 4 pixels of so many components.
    fn frame(components: u8) -> Vec<u8> {
        let mut frame = vec![0xff, 0xf7, 0, 8 + 3 * components, 8, 0, 4, 0, 4, components];
        (1..=components).for_each(|name| frame.extend([name, 0x11, 0]));
        frame
    }

    /// The header of a scan of components, by their names.
    fn scan(names: &[u8], interleave: u8) -> Vec<u8> {
        let count = names.len() as u8;
        let mut scan = vec![0xff, 0xda, 0, 6 + 2 * count, count];
        names.iter().for_each(|name| scan.extend([*name, 0]));
        scan.extend([0, interleave, 0]);
        scan
    }

    fn read(coded: &[u8], size: [usize; 3]) -> Result<Vec<u16>, IoError> {
        decode(coded, size, &Context::new("DICOM", Path::new("a")))
    }

    #[test]
    fn the_example_of_the_standard_decodes() {
        let coded = [&START, &frame(1)[..], &scan(&[1], 0), &SCAN, &[0xd9]].concat();
        assert_eq!(read(&coded, [4, 4, 1]).unwrap(), SAMPLES);
        assert!(read(&coded, [4, 5, 1]).is_err());
        for length in 0..coded.len() - 3 {
            assert!(read(&coded[..length], [4, 4, 1]).is_err(), "{length}");
        }
    }

    #[test]
    fn scans_of_one_component_each_become_pixels() {
        let mut coded = [&START[..], &frame(3)].concat();
        // In any order; the last byte of the example is the first of the next marker.
        for name in [2, 3, 1] {
            coded.extend(&scan(&[name], 0));
            coded.extend(&SCAN[..30]);
        }
        coded.extend([0xff, 0xd9]);
        let pixels = read(&coded, [4, 4, 3]).unwrap();
        assert!(
            pixels
                .chunks(3)
                .zip(SAMPLES)
                .all(|(pixel, sample)| pixel == [sample; 3])
        );
        let missing = &coded[..coded.len() - 40];
        assert!(read(missing, [4, 4, 3]).is_err());
    }

    #[test]
    fn interleaved_scans_are_read_whole_or_refused() {
        // Ones: runs of the samples left of the first column, 0. A stuffed bit follows each 0xff.
        let runs = [0xff, 0x7f].repeat(16);
        for interleave in [1, 2] {
            let start = [&START[..], &frame(3), &scan(&[1, 2, 3], interleave)].concat();
            let coded = [&start[..], &runs].concat();
            assert_eq!(read(&coded, [4, 4, 3]).unwrap(), [0; 48]);
            for seed in 0..200u32 {
                let noise =
                    (0..60u32).map(|i| (seed.wrapping_mul(2654435761) ^ i.wrapping_mul(40503)) >> 9 & 0x7f);
                let coded = [&start[..], &noise.map(|byte| byte as u8).collect::<Vec<_>>()].concat();
                if let Ok(samples) = read(&coded, [4, 4, 3]) {
                    assert!(samples.iter().all(|&sample| sample <= 255), "{seed}");
                }
            }
        }
        let coded = [&START[..], &frame(3), &scan(&[1, 2, 3], 0), &runs].concat();
        let error = read(&coded, [4, 4, 3]).unwrap_err().to_string();
        assert!(error.contains("JPEG-LS interleave"), "{error}");
    }
}
