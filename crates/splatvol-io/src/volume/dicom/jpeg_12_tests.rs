//! Images coded by an encoder of the tests: codes of one length, steps of one.

use std::path::Path;

use super::*;

/// Bits of a scan, with zeros behind 0xff.
#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    held: u32,
    count: u32,
}

impl Writer {
    fn put(&mut self, value: u32, count: u32) {
        for place in (0..count).rev() {
            self.held = self.held << 1 | value >> place & 1;
            self.count += 1;
            if self.count == 8 {
                self.bytes.push(self.held as u8);
                if self.held as u8 == 0xff {
                    self.bytes.push(0);
                }
                (self.held, self.count) = (0, 0);
            }
        }
    }

    /// Ones fill the last byte.
    fn fill(&mut self) {
        while self.count > 0 {
            self.put(1, 1);
        }
    }

    /// A code, and the bits of a number of its size.
    fn number(&mut self, zeros: u32, value: i32, code_bits: u32) {
        let size = 32 - value.unsigned_abs().leading_zeros();
        self.put(zeros << 4 | size, code_bits);
        let raw = if value < 0 { value + (1 << size) - 1 } else { value };
        self.put(raw as u32, size);
    }
}

fn segment_of(marker: u8, body: &[u8]) -> Vec<u8> {
    let length = (body.len() as u16 + 2).to_be_bytes();
    [&[0xff, marker][..], &length, body].concat()
}

/// Rounded coefficients by the definition (A.3.3), in their order.
fn coefficients(block: [f64; 64]) -> [i32; 64] {
    use std::f64::consts::{FRAC_1_SQRT_2, PI};
    ZIGZAG.map(|place| {
        let (u, v) = (place % 8, place / 8);
        let scale = |k: usize| if k == 0 { FRAC_1_SQRT_2 } else { 1.0 };
        let wave = |x: usize, k: usize| ((2 * x + 1) as f64 * k as f64 * PI / 16.0).cos();
        let sum: f64 = (0..64).map(|i| block[i] * wave(i % 8, u) * wave(i / 8, v)).sum();
        (0.25 * scale(u) * scale(v) * sum).round() as i32
    })
}

fn encode(samples: &[u16], [columns, rows]: [usize; 2], restart: usize) -> Vec<u8> {
    let mut scan = Writer::default();
    let (across, down) = (columns.div_ceil(8), rows.div_ceil(8));
    let mut previous = 0;
    for block in 0..across * down {
        if restart > 0 && block > 0 && block % restart == 0 {
            scan.fill();
            scan.bytes
                .extend([0xff, 0xd0 + ((block / restart - 1) % 8) as u8]);
            previous = 0;
        }
        let sample = |i: usize| {
            let x = (block % across * 8 + i % 8).min(columns - 1);
            let y = (block / across * 8 + i / 8).min(rows - 1);
            f64::from(samples[y * columns + x]) - 2048.0
        };
        let [first, others @ ..] = coefficients(std::array::from_fn(sample));
        scan.number(0, first - previous, 5);
        previous = first;
        let mut zeros = 0;
        for value in others {
            if value == 0 {
                zeros += 1;
                continue;
            }
            (0..zeros / 16).for_each(|_| scan.put(0xf0, 9));
            scan.number(zeros % 16, value, 9);
            zeros = 0;
        }
        if zeros > 0 {
            scan.put(0, 9);
        }
    }
    scan.fill();
    let counts = |length: usize, count: u8| {
        let mut counts = [0; 16];
        counts[length - 1] = count;
        counts
    };
    // All codes have 5 or 9 bits. Counts are bytes, so that the last code of 9 bits is not there.
    let differences = [&[0][..], &counts(5, 16), &(0..16).collect::<Vec<u8>>()].concat();
    let values = [&[0x10][..], &counts(9, 255), &(0..255).collect::<Vec<u8>>()].concat();
    let [c, r] = [columns, rows].map(|length| (length as u16).to_be_bytes());
    let frame = [12, r[0], r[1], c[0], c[1], 1, 1, 0x11, 0];
    [
        vec![0xff, 0xd8],
        segment_of(0xdb, &[&[0x10][..], &[0, 1].repeat(64)].concat()),
        segment_of(0xc4, &[differences, values].concat()),
        segment_of(0xdd, &(restart as u16).to_be_bytes()),
        segment_of(0xc1, &frame),
        segment_of(0xda, &[1, 1, 0, 0, 63, 0]),
        scan.bytes,
        vec![0xff, 0xd9],
    ]
    .concat()
}

/// Waves that reach both ends of the range.
fn waves([columns, rows]: [usize; 2]) -> Vec<u16> {
    let wave = |i: usize| {
        let (x, y) = ((i % columns) as f64, (i / columns) as f64);
        (2047.5 + 2047.5 * (x / 3.0).sin() * (y / 4.0).cos()).round() as u16
    };
    (0..columns * rows).map(wave).collect()
}

#[test]
fn samples_come_back_within_rounding() {
    let context = Context::new("DICOM", Path::new("a"));
    for (size, restart) in [([16, 8], 0), ([21, 19], 0), ([37, 33], 2), ([1, 1], 0)] {
        let samples = waves(size);
        let coded = encode(&samples, size, restart);
        assert!(is_12_bit(&coded));
        let decoded = decode(&coded, size, &context).unwrap();
        let errors = decoded.iter().zip(&samples).map(|(&a, &b)| a.abs_diff(b));
        assert!(
            decoded.len() == samples.len() && errors.max().unwrap() <= 1,
            "{size:?}"
        );
    }
}

#[test]
fn cut_and_changed_streams_are_answered() {
    let context = Context::new("DICOM", Path::new("a"));
    let size = [21, 19];
    let coded = encode(&waves(size), size, 3);
    assert!(decode(&coded, [19, 21], &context).is_err());
    for length in 0..coded.len() - 4 {
        assert!(decode(&coded[..length], size, &context).is_err(), "{length}");
    }
    for place in 0..coded.len() {
        for value in [0, 0x7f, 0xff] {
            let mut changed = coded.clone();
            changed[place] = value;
            if let Ok(samples) = decode(&changed, size, &context) {
                assert!(samples.len() == 21 * 19 && samples.iter().all(|&sample| sample < 4096));
            }
        }
    }
}
