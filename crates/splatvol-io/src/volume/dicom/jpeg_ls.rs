//! JPEG-LS, lossless and near-lossless, for images of one component (ITU-T T.87, ISO/IEC 14495-1).
//!
//! A sample is predicted by the median of left, above and their gradient (A.4), corrected by what earlier samples with
//! like surroundings have taught, and the error is coded by Golomb's limited codes (A.5.3). Where all gradients
//! vanish, runs are coded (A.7). No suitable crate exists in Rust: those found bring C++ or a whole toolkit. Not read:
//! mapping tables, several components.

use super::jpeg_ls_context::{Parameters, Statistics};
use crate::IoError;
use crate::error::Context;

/// Lengths of runs, as powers of two (A.2.1).
const RUN_POWERS: [u32; 32] = [
    0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13, 14, 15,
];

/// The samples of an image of this size (columns, rows).
pub(super) fn decode(coded: &[u8], size: [usize; 2], context: &Context<'_>) -> Result<Vec<u16>, IoError> {
    let (parameters, at) = header(coded, size, context)?;
    let mut scan = Scan::new(&coded[at..], size[0], parameters);
    let mut samples = Vec::with_capacity(size[0] * size[1]);
    for row in 0..size[1] {
        if scan.line().is_none() {
            return Err(context.truncated("JPEG-LS rows", size[1] as u64, row as u64));
        }
        samples.extend(scan.current[1..=size[0]].iter().map(|&sample| sample as u16));
        scan.next_line();
    }
    Ok(samples)
}

/// Reads the segments before the scan (C.2); returns the position of its first byte.
fn header(coded: &[u8], size: [usize; 2], context: &Context<'_>) -> Result<(Parameters, usize), IoError> {
    let cut = || context.truncated("JPEG-LS header", coded.len() as u64 + 1, coded.len() as u64);
    let short = |bytes: &[u8], at: usize| -> Result<i32, IoError> {
        let pair = bytes.get(at..at + 2).ok_or_else(cut)?;
        Ok(i32::from(u16::from_be_bytes([pair[0], pair[1]])))
    };
    let mut at = 2;
    let mut max_value = None;
    let mut presets = [0; 5];
    loop {
        let marker = short(coded, at)?;
        let length = short(coded, at + 2)? as usize;
        let body = coded.get(at + 4..at + 2 + length.max(2)).ok_or_else(cut)?;
        at += 2 + length.max(2);
        match marker {
            // The frame: precision, rows, columns, components.
            0xfff7 => {
                let precision = body.first().copied().unwrap_or(0);
                let found = [short(body, 3)? as usize, short(body, 1)? as usize];
                let components = body.get(5).copied().unwrap_or(0);
                if !(2..=16).contains(&precision) || components != 1 {
                    let what = format!("JPEG-LS of {precision} bits and {components} components");
                    return Err(context.unsupported(what));
                }
                if found != size {
                    let shown = format!("{} x {}", found[0], found[1]);
                    let expected = format!("{} x {}, as the header has it", size[0], size[1]);
                    return Err(context.field("size of the compressed image", shown, None, expected));
                }
                max_value = Some((1 << precision) - 1);
            }
            // Presets: largest value, three thresholds, reset; 0 leaves the default.
            0xfff8 if body.first() == Some(&1) => {
                for (i, preset) in presets.iter_mut().enumerate() {
                    *preset = short(body, 1 + 2 * i)?;
                }
            }
            0xffda => {
                let near = i32::from(body.get(3).copied().unwrap_or(0));
                let largest = max_value.ok_or_else(cut)?;
                return Ok((parameters(largest, presets, near, context)?, at));
            }
            0xfff8 | 0xffdd => return Err(context.unsupported("JPEG-LS with tables or restarts")),
            marker if marker >= 0xff00 => {}
            marker => {
                let shown = format!("{marker:#x}");
                return Err(context.field("JPEG-LS marker", shown, None, "a marker (0xff..)"));
            }
        }
    }
}

fn parameters(
    largest: i32,
    presets: [i32; 5],
    near: i32,
    context: &Context<'_>,
) -> Result<Parameters, IoError> {
    let max_value = if presets[0] == 0 { largest } else { presets[0] };
    let mut parameters = Parameters::new(max_value, near);
    for (threshold, &preset) in parameters.thresholds.iter_mut().zip(&presets[1..4]) {
        if preset != 0 {
            *threshold = preset;
        }
    }
    if presets[4] != 0 {
        parameters.reset = presets[4];
    }
    if max_value > largest || near > 255.min(max_value / 2) || parameters.reset < 3 {
        let shown = format!("{max_value}, {near}, {}", parameters.reset);
        return Err(context.field(
            "JPEG-LS MAXVAL, NEAR, RESET",
            shown,
            None,
            "values that T.87 allows",
        ));
    }
    Ok(parameters)
}

/// The bits of a scan: after a byte 0xff, the next has seven (A.1).
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    held: u64,
    count: u32,
    after_ff: bool,
}

impl Bits<'_> {
    fn bit(&mut self) -> Option<u32> {
        self.bits(1)
    }

    /// Up to 32 bits.
    fn bits(&mut self, count: u32) -> Option<u32> {
        while self.count < count {
            let &byte = self.bytes.get(self.at)?;
            if self.after_ff && byte >= 0x80 {
                return None;
            }
            let width = if self.after_ff { 7 } else { 8 };
            self.held = self.held << width | u64::from(byte);
            self.count += width;
            self.after_ff = byte == 0xff;
            self.at += 1;
        }
        self.count -= count;
        let value = self.held >> self.count;
        self.held &= (1 << self.count) - 1;
        Some(value as u32)
    }

    /// A code of at most `limit` bits in steps of 2^k (A.5.3); `width` bits hold any error.
    fn golomb(&mut self, k: u32, limit: u32, width: u32) -> Option<i32> {
        let escape = limit.checked_sub(width + 1)?;
        let mut zeros = 0;
        while self.bit()? == 0 {
            zeros += 1;
            if zeros > escape {
                return None;
            }
        }
        let value = match zeros < escape {
            true => zeros << k | self.bits(k)?,
            false => self.bits(width)?.checked_add(1)?,
        };
        // An error is less than the range, and is doubled to remove its sign.
        i32::try_from(value).ok().filter(|&value| value <= 2 << width)
    }
}

/// A scan while it is decoded. Lines have one sample more on either side.
struct Scan<'a> {
    bits: Bits<'a>,
    parameters: Parameters,
    contexts: Vec<Statistics>,
    /// Bits of an error, and the longest code.
    width: u32,
    limit: u32,
    run_index: usize,
    columns: usize,
    previous: Vec<i32>,
    current: Vec<i32>,
}

impl<'a> Scan<'a> {
    fn new(bytes: &'a [u8], columns: usize, parameters: Parameters) -> Self {
        let range = parameters.range();
        let bits_of = |value: i32| 32 - (value.max(2) - 1).leading_zeros();
        let sample_bits = bits_of(parameters.max_value + 1).max(2);
        Self {
            bits: Bits {
                bytes,
                at: 0,
                held: 0,
                count: 0,
                after_ff: false,
            },
            contexts: vec![Statistics::new(range); 367],
            width: bits_of(range),
            limit: 2 * (sample_bits + sample_bits.max(8)),
            parameters,
            run_index: 0,
            columns,
            previous: vec![0; columns + 2],
            current: vec![0; columns + 2],
        }
    }

    /// The line above becomes the one that was decoded (A.2.1: left of a line is the sample above its first one).
    fn next_line(&mut self) {
        std::mem::swap(&mut self.previous, &mut self.current);
    }

    fn line(&mut self) -> Option<()> {
        self.current[0] = self.previous[1];
        self.previous[self.columns + 1] = self.previous[self.columns];
        let mut x = 1;
        while x <= self.columns {
            let left = self.current[x - 1];
            let [above_left, above, above_right] = [x - 1, x, x + 1].map(|x| self.previous[x]);
            let gradients = [above_right - above, above - above_left, above_left - left];
            let [first, second, third] = gradients.map(|gradient| self.parameters.quantised(gradient));
            if [first, second, third] == [0; 3] {
                x = self.run(x)?;
            } else {
                let surrounding = 81 * first + 9 * second + third;
                self.current[x] = self.regular(surrounding, [left, above, above_left])?;
                x += 1;
            }
        }
        Some(())
    }

    /// A sample from its neighbours (A.4 to A.6).
    fn regular(&mut self, surrounding: i32, [left, above, above_left]: [i32; 3]) -> Option<i32> {
        let sign = surrounding.signum();
        let context = &mut self.contexts[surrounding.unsigned_abs() as usize];
        let (low, high) = (left.min(above), left.max(above));
        let median = (left + above - above_left).clamp(low, high);
        let predicted = (median + sign * context.correction).clamp(0, self.parameters.max_value);
        let k = context.golomb(context.sizes);
        let mapped = self.bits.golomb(k, self.limit, self.width)?;
        let mut error = if mapped & 1 == 0 {
            mapped >> 1
        } else {
            -(mapped >> 1) - 1
        };
        if self.parameters.near == 0 && k == 0 && 2 * context.bias <= -context.count {
            error = -error - 1;
        }
        context.learn(error, &self.parameters);
        Some(self.restored(predicted, sign * error))
    }

    /// Prediction and error to a sample, modulo the range (A.4.5, A.8).
    fn restored(&self, predicted: i32, error: i32) -> i32 {
        let Parameters { max_value, near, .. } = self.parameters;
        let step = 2 * near + 1;
        let modulus = self.parameters.range() * step;
        let mut sample = predicted + error * step;
        if sample < -near {
            sample += modulus;
        } else if sample > max_value + near {
            sample -= modulus;
        }
        sample.clamp(0, max_value)
    }

    /// Decodes a run from `x` on, and the sample that ends it; returns the next x (A.7).
    fn run(&mut self, mut x: usize) -> Option<usize> {
        let left = self.current[x - 1];
        loop {
            let length = 1usize << RUN_POWERS[self.run_index];
            let rest = self.columns + 1 - x;
            if self.bits.bit()? == 1 {
                let taken = length.min(rest);
                self.current[x..x + taken].fill(left);
                x += taken;
                if taken == length {
                    self.run_index = (self.run_index + 1).min(31);
                }
                if x > self.columns {
                    return Some(x);
                }
            } else {
                let taken = self.bits.bits(RUN_POWERS[self.run_index])? as usize;
                if taken >= rest {
                    return None;
                }
                self.current[x..x + taken].fill(left);
                x += taken;
                self.current[x] = self.run_end(left, self.previous[x])?;
                self.run_index = self.run_index.saturating_sub(1);
                return Some(x + 1);
            }
        }
    }

    /// The sample that differs (A.7.2).
    fn run_end(&mut self, left: i32, above: i32) -> Option<i32> {
        let kind = i32::from((left - above).abs() <= self.parameters.near);
        let context = &mut self.contexts[365 + kind as usize];
        let total = context.sizes + if kind == 1 { context.count >> 1 } else { 0 };
        let k = context.golomb(total);
        let limit = self.limit - RUN_POWERS[self.run_index] - 1;
        let mapped = self.bits.golomb(k, limit, self.width)?;
        let doubled = mapped + kind;
        let turned = k != 0 || 2 * context.negative >= context.count;
        let size = (doubled + 1) >> 1;
        let error = if (doubled & 1 == 1) == turned { -size } else { size };
        context.learn_end(error, mapped, kind, self.parameters.reset);
        if kind == 1 {
            return Some(self.restored(left, error));
        }
        let sign = if left > above { -1 } else { 1 };
        Some(self.restored(above, sign * error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// The example of T.87, annex H.3.
    #[test]
    fn the_example_of_the_standard_decodes() {
        let coded = [
            0xff, 0xd8, 0xff, 0xf7, 0x00, 0x0b, 0x08, 0x00, 0x04, 0x00, 0x04, 0x01, 0x01, 0x11, 0x00, 0xff,
            0xda, 0x00, 0x08, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0xc0, 0x00, 0x00, 0x6c, 0x80, 0x20, 0x8e,
            0x01, 0xc0, 0x00, 0x00, 0x57, 0x40, 0x00, 0x00, 0x6e, 0xe6, 0x00, 0x00, 0x01, 0xbc, 0x18, 0x00,
            0x00, 0x05, 0xd8, 0x00, 0x00, 0x91, 0x60, 0xff, 0xd9,
        ];
        let context = Context::new("DICOM", Path::new("a"));
        let samples = decode(&coded, [4, 4], &context).unwrap();
        let expected = [
            0, 0, 90, 74, 68, 50, 43, 205, 64, 145, 145, 145, 100, 145, 145, 145,
        ];
        assert_eq!(samples, expected);
        assert!(decode(&coded, [4, 5], &context).is_err());
        for length in 0..coded.len() - 3 {
            assert!(decode(&coded[..length], [4, 4], &context).is_err(), "{length}");
        }
    }
}
