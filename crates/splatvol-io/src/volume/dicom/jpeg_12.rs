//! JPEG of 12 bits: sequential, coded by Huffman, one component (ITU-T T.81, process 4; in DICOM `.4.51`).
//!
//! No crate in Rust decodes it: `jpeg-decoder` and `zune-jpeg` know cosines of 8 bits only. The cosine transform is taken
//! from its definition (A.3.3), so that samples are those of any decoder within rounding.

use super::jpeg_12_bits::{Bits, Huffman};
use crate::IoError;
use crate::error::Context;

/// Places of the coefficients, in the order in which they are coded (figure A.6).
const ZIGZAG: [usize; 64] = [
    0, 1, 8, 16, 9, 2, 3, 10, 17, 24, 32, 25, 18, 11, 4, 5, 12, 19, 26, 33, 40, 48, 41, 34, 27, 20, 13, 6, 7,
    14, 21, 28, 35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23, 30, 37, 44, 51, 58, 59, 52, 45, 38, 31, 39,
    46, 53, 60, 61, 54, 47, 55, 62, 63,
];
const BITS: u8 = 12;

/// Whether the frame is one for [`decode`].
pub(super) fn is_12_bit(coded: &[u8]) -> bool {
    let mut at = 2;
    while let Some((marker, body)) = segment(coded, &mut at) {
        match marker {
            0xc1 => return body.first() == Some(&BITS),
            0xc0 | 0xc2..=0xc3 | 0xda => return false,
            _ => {}
        }
    }
    false
}

/// The samples of an image of this size (columns, rows).
pub(super) fn decode(coded: &[u8], size: [usize; 2], context: &Context<'_>) -> Result<Vec<u16>, IoError> {
    let mut tables = Tables::default();
    let mut at = 2;
    let cut = || context.truncated("JPEG", coded.len() as u64 + 1, coded.len() as u64);
    while let Some((marker, body)) = segment(coded, &mut at) {
        let legible = match marker {
            0xdb => tables.quantisers(body),
            0xc4 => tables.codes(body),
            0xdd => tables.restarts(body),
            0xc1 => tables.frame(body, size, context)?,
            0xda => {
                let scan = tables
                    .scan(body, coded.get(at..).unwrap_or_default())
                    .ok_or_else(cut)?;
                return scan.samples(size).ok_or_else(cut);
            }
            _ => Some(()),
        };
        legible.ok_or_else(cut)?;
    }
    Err(cut())
}

/// The marker and contents of a segment; `at` moves behind it.
fn segment<'a>(coded: &'a [u8], at: &mut usize) -> Option<(u8, &'a [u8])> {
    // Fill bytes may precede a marker (B.1.1.2).
    while coded.get(*at..*at + 2)? == [0xff, 0xff] {
        *at += 1;
    }
    let &[0xff, marker, high, low] = coded.get(*at..*at + 4)? else {
        return None;
    };
    let length = usize::from(u16::from_be_bytes([high, low]));
    let body = coded.get(*at + 4..*at + 2 + length)?;
    *at += 2 + length;
    Some((marker, body))
}

/// What segments before the scan define.
#[derive(Default)]
struct Tables {
    quantisers: [Option<[f32; 64]>; 4],
    /// Codes of differences, and of the other coefficients.
    codes: [[Option<Huffman>; 4]; 2],
    /// Blocks between restarts; 0 for none.
    restart: usize,
    /// The component's quantiser.
    quantiser: Option<usize>,
}

impl Tables {
    fn quantisers(&mut self, mut body: &[u8]) -> Option<()> {
        while let Some((&head, rest)) = body.split_first() {
            let width = if head >> 4 == 0 { 1 } else { 2 };
            let (steps, after) = rest.split_at_checked(64 * width)?;
            let mut table = [0.0; 64];
            for (step, place) in steps.chunks_exact(width).zip(ZIGZAG) {
                table[place] = step.iter().fold(0.0, |sum, &byte| sum * 256.0 + f32::from(byte));
            }
            *self.quantisers.get_mut(usize::from(head & 15))? = Some(table);
            body = after;
        }
        Some(())
    }

    fn codes(&mut self, mut body: &[u8]) -> Option<()> {
        while let Some((&head, rest)) = body.split_first() {
            let (counts, rest) = rest.split_first_chunk::<16>()?;
            let total = counts.iter().map(|&count| usize::from(count)).sum();
            let (values, after) = rest.split_at_checked(total)?;
            let class = self.codes.get_mut(usize::from(head >> 4))?;
            *class.get_mut(usize::from(head & 15))? = Some(Huffman::new(counts, values));
            body = after;
        }
        Some(())
    }

    fn restarts(&mut self, body: &[u8]) -> Option<()> {
        let &[high, low] = body.first_chunk()?;
        self.restart = usize::from(u16::from_be_bytes([high, low]));
        Some(())
    }

    /// The frame: precision, rows, columns, and its only component.
    fn frame(&mut self, body: &[u8], size: [usize; 2], context: &Context<'_>) -> Result<Option<()>, IoError> {
        let Some(&[bits, r1, r0, c1, c0, components, _, _, quantiser]) = body.first_chunk() else {
            return Ok(None);
        };
        if bits != BITS || components != 1 {
            return Err(context.unsupported(format!("JPEG of {bits} bits and {components} components")));
        }
        let found = [[c1, c0], [r1, r0]].map(|pair| usize::from(u16::from_be_bytes(pair)));
        if found != size {
            let shown = format!("{} x {}", found[0], found[1]);
            let expected = format!("{} x {}, as the header has it", size[0], size[1]);
            return Err(context.field("size of the compressed image", shown, None, expected));
        }
        self.quantiser = Some(usize::from(quantiser));
        Ok(Some(()))
    }

    fn scan<'a>(&'a self, body: &[u8], bytes: &'a [u8]) -> Option<Scan<'a>> {
        let &[1, _, tables] = body.first_chunk()? else {
            return None;
        };
        let table = |class: usize, number: u8| self.codes[class].get(usize::from(number))?.as_ref();
        Some(Scan {
            bits: Bits::new(bytes),
            quantiser: self.quantisers.get(self.quantiser?)?.as_ref()?,
            differences: table(0, tables >> 4)?,
            others: table(1, tables & 15)?,
            restart: self.restart,
            previous: 0,
        })
    }
}

/// A scan while it is decoded.
struct Scan<'a> {
    bits: Bits<'a>,
    quantiser: &'a [f32; 64],
    differences: &'a Huffman,
    others: &'a Huffman,
    restart: usize,
    /// The first coefficient of the block before.
    previous: i32,
}

impl Scan<'_> {
    fn samples(mut self, [columns, rows]: [usize; 2]) -> Option<Vec<u16>> {
        let cosines = cosines();
        let mut samples = vec![0; columns * rows];
        let across = columns.div_ceil(8);
        for block in 0..across * rows.div_ceil(8) {
            if self.restart > 0 && block > 0 && block % self.restart == 0 {
                self.bits.restart()?;
                self.previous = 0;
            }
            let values = transformed(&self.block()?, &cosines);
            let (left, top) = (block % across * 8, block / across * 8);
            let lines = samples.chunks_exact_mut(columns).skip(top);
            for (line, values) in lines.zip(values.chunks_exact(8)) {
                let targets = line[left..].iter_mut();
                targets
                    .zip(values)
                    .for_each(|(target, &value)| *target = sample(value));
            }
        }
        Some(samples)
    }

    /// The coefficients of a block (F.2.2), multiplied by their steps.
    fn block(&mut self) -> Option<[f32; 64]> {
        let mut block = [0.0; 64];
        let size = self.differences.decode(&mut self.bits)?;
        self.previous = self.previous.checked_add(self.bits.signed(size)?)?;
        block[0] = self.previous as f32 * self.quantiser[0];
        let mut at = 1;
        while at < 64 {
            let code = self.others.decode(&mut self.bits)?;
            let (zeros, size) = (usize::from(code >> 4), code & 15);
            match (zeros, size) {
                // Sixteen zeros, or nothing more.
                (15, 0) => at += 16,
                (_, 0) => break,
                _ => {
                    at += zeros;
                    let &place = ZIGZAG.get(at)?;
                    block[place] = self.bits.signed(size)? as f32 * self.quantiser[place];
                    at += 1;
                }
            }
        }
        Some(block)
    }
}

/// A sample, which was centred on 0 (A.3.1).
fn sample(value: f32) -> u16 {
    let middle = f32::from(1u16 << (BITS - 1));
    (value.round() + middle).clamp(0.0, 2.0 * middle - 1.0) as u16
}

/// `C(u) / 2 cos((2 x + 1) u pi / 16)` for each x and u (A.3.3).
fn cosines() -> [[f32; 8]; 8] {
    /// Cosines of multiples of pi / 16.
    const QUARTER: [f32; 9] = [
        1.0,
        0.980_785_3,
        0.923_879_5,
        0.831_469_6,
        std::f32::consts::FRAC_1_SQRT_2,
        0.555_570_24,
        0.382_683_43,
        0.195_090_32,
        0.0,
    ];
    let cosine = |turn: usize| match turn % 32 {
        turn @ 0..=8 => QUARTER[turn],
        turn @ 9..=16 => -QUARTER[16 - turn],
        turn @ 17..=24 => -QUARTER[turn - 16],
        turn => QUARTER[32 - turn],
    };
    std::array::from_fn(|x| {
        std::array::from_fn(|u| match u {
            0 => 0.5 * QUARTER[4],
            u => 0.5 * cosine((2 * x + 1) * u),
        })
    })
}

/// The inverse cosine transform of a block, along rows and then along columns.
fn transformed(block: &[f32; 64], cosines: &[[f32; 8]; 8]) -> [f32; 64] {
    let along = |from: &dyn Fn(usize) -> f32, x: usize| (0..8).map(|u| cosines[x][u] * from(u)).sum::<f32>();
    let rows: [f32; 64] = std::array::from_fn(|i| along(&|u| block[i / 8 * 8 + u], i % 8));
    std::array::from_fn(|i| along(&|v| rows[v * 8 + i % 8], i / 8))
}

#[cfg(test)]
#[path = "jpeg_12_tests.rs"]
mod tests;
