//! Numbers of one kind, one for each element of a cloud, as whole *codes*.
//!
//! ```text
//! even:         value = first + step code                  places, opacities, values
//! symmetric:    value = step (code - middle)               directions, rotations, harmonics: zero stays zero
//! logarithmic:  the bits of value = first + step code      lengths: the bits of a positive float grow as its logarithm
//! whole:        value = first + code                       colours, numbers of points
//! bits:         the bits of value = code                   what is not rounded, or missing in part
//! ```
//!
//! Everything is exact arithmetic on integers, or a product and a sum in 64 bits, so what is unpacked is the same everywhere.

use serde::{Deserialize, Serialize};
use splatvol::SceneError;

use super::planes;

/// Octaves of lengths that are told apart, below the longest: a length below is taken for the least of them.
const OCTAVES: u32 = 20;
/// Bits of a float's fraction: what it grows by in an octave.
const OCTAVE: u32 = 1 << 23;

/// Bits of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Precision {
    /// Bits of a coordinate.
    pub places: u32,
    /// Bits of all else.
    pub rest: u32,
}

impl Precision {
    /// The numbers as they are.
    pub const OWN: Self = Self { places: 32, rest: 32 };
}

/// How numbers are packed: in planes of bytes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Bytes of a code; none where all numbers are the same.
    bytes: u8,
    /// Whether bytes are differences.
    delta: bool,
    /// What a code means.
    code: Code,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Code {
    Even { first: f64, step: f64 },
    Symmetric { middle: u32, step: f64 },
    Logarithmic { first: u32, step: f64 },
    Whole { first: u32 },
    Bits,
}

impl Column {
    /// Takes the codes of a column from the front of bytes.
    fn codes(&self, count: usize, bytes: &mut &[u8]) -> Result<Vec<u32>, SceneError> {
        let length = count.checked_mul(usize::from(self.bytes));
        let own = length
            .filter(|_| self.bytes <= 4)
            .and_then(|length| bytes.split_off(..length));
        let own = own.ok_or_else(|| planes::too_few("column", bytes.len()))?;
        let mut codes = vec![0u32; count];
        for (place, plane) in own.chunks_exact(count.max(1)).enumerate() {
            let plane = planes::read(plane, self.delta);
            codes
                .iter_mut()
                .zip(plane)
                .for_each(|(code, byte)| *code |= u32::from(byte) << (8 * place));
        }
        Ok(codes)
    }

    /// Takes numbers from the front of bytes.
    ///
    /// # Errors
    /// Too few bytes.
    pub fn numbers(&self, count: usize, bytes: &mut &[u8]) -> Result<Vec<f32>, SceneError> {
        let codes = self.codes(count, bytes)?;
        let value = |code: u32| match self.code {
            Code::Even { first, step } => (first + step * f64::from(code)) as f32,
            Code::Symmetric { middle, step } => (step * (f64::from(code) - f64::from(middle))) as f32,
            Code::Logarithmic { first, step } => {
                f32::from_bits(first.saturating_add((step * f64::from(code)).round() as u32))
            }
            Code::Whole { first } => first.wrapping_add(code) as f32,
            Code::Bits => f32::from_bits(code),
        };
        Ok(codes.into_iter().map(value).collect())
    }

    /// Takes whole numbers from the front of bytes.
    ///
    /// # Errors
    /// Too few bytes; a column of other numbers.
    pub fn whole(&self, count: usize, bytes: &mut &[u8]) -> Result<Vec<u32>, SceneError> {
        let Code::Whole { first } = self.code else {
            return Err(SceneError::invalid("column", self.code, "one of whole numbers"));
        };
        let codes = self.codes(count, bytes)?;
        Ok(codes.into_iter().map(|code| first.wrapping_add(code)).collect())
    }

    /// Takes vectors, whose components have columns of their own, from the front of bytes.
    ///
    /// # Errors
    /// Too few bytes.
    pub fn vectors<const N: usize>(
        columns: &[Self; N],
        count: usize,
        bytes: &mut &[u8],
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let mut vectors = vec![[0.0; N]; count];
        for (i, column) in columns.iter().enumerate() {
            let numbers = column.numbers(count, bytes)?;
            vectors
                .iter_mut()
                .zip(numbers)
                .for_each(|(vector, number)| vector[i] = number);
        }
        Ok(vectors)
    }
}

/// Packs columns one after the other.
#[derive(Debug, Default)]
pub(super) struct Packer {
    pub(super) bytes: Vec<u8>,
}

impl Packer {
    /// Numbers between their extremes, in equal steps.
    pub(super) fn even(&mut self, values: impl Iterator<Item = f32> + Clone, bits: u32) -> Column {
        if bits == Precision::OWN.rest {
            return self.bits(values);
        }
        let [low, high] = extremes(values.clone().map(f64::from));
        let most = f64::from(most(bits));
        let step = (high - low) / most;
        let code = |value: f32| match step > 0.0 {
            true => ((f64::from(value) - low) / step).round().min(most) as u32,
            false => 0,
        };
        self.push(values.map(code).collect(), Code::Even { first: low, step })
    }

    /// Numbers of both signs, in equal steps, of which zero is one.
    pub(super) fn symmetric(&mut self, values: impl Iterator<Item = f32> + Clone, bits: u32) -> Column {
        if bits == Precision::OWN.rest {
            return self.bits(values);
        }
        let reach = values
            .clone()
            .fold(0.0, |most, value| f64::from(value.abs()).max(most));
        let middle = most(bits) / 2;
        let step = reach / f64::from(middle);
        let code = |value: f32| match step > 0.0 {
            true => ((f64::from(value) / step).round() + f64::from(middle)) as u32,
            false => middle,
        };
        self.push(values.map(code).collect(), Code::Symmetric { middle, step })
    }

    /// Lengths, none below zero, in equal ratios.
    pub(super) fn logarithmic(&mut self, values: impl Iterator<Item = f32> + Clone, bits: u32) -> Column {
        if bits == Precision::OWN.rest {
            return self.bits(values);
        }
        let order = values.clone().map(|value| f64::from(value.to_bits()));
        let [low, high] = extremes(order);
        let low = low.max(high - f64::from(OCTAVES * OCTAVE)).max(0.0);
        let step = (high - low) / f64::from(most(bits));
        let code = |value: f32| match step > 0.0 {
            true => ((f64::from(value.to_bits()) - low).max(0.0) / step).round() as u32,
            false => 0,
        };
        let first = low as u32;
        self.push(values.map(code).collect(), Code::Logarithmic { first, step })
    }

    /// Whole numbers.
    pub(super) fn whole(&mut self, values: impl Iterator<Item = u32> + Clone) -> Column {
        let first = values.clone().min().unwrap_or_default();
        self.push(values.map(|value| value - first).collect(), Code::Whole { first })
    }

    /// Numbers as they are.
    pub(super) fn bits(&mut self, values: impl Iterator<Item = f32>) -> Column {
        self.push(values.map(f32::to_bits).collect(), Code::Bits)
    }

    /// Vectors, a column for each component.
    pub(super) fn vectors<const N: usize>(
        &mut self,
        vectors: &[[f32; N]],
        mut pack: impl FnMut(&mut Self, Component<'_, N>) -> Column,
    ) -> [Column; N] {
        std::array::from_fn(|index| {
            pack(
                self,
                Component {
                    vectors,
                    index,
                    next: 0,
                },
            )
        })
    }

    fn push(&mut self, codes: Vec<u32>, code: Code) -> Column {
        let largest = codes.iter().max().copied().unwrap_or_default();
        let bytes = 4 - largest.leading_zeros() as u8 / 8;
        let planes = |delta| {
            let mut planes = Vec::with_capacity(codes.len() * usize::from(bytes));
            for place in 0..bytes {
                let plane = codes.iter().map(|code| code.to_le_bytes()[usize::from(place)]);
                planes::push(&mut planes, plane, delta);
            }
            planes
        };
        let [plain, difference] = [false, true].map(planes);
        let delta = entropy(&difference) < entropy(&plain);
        self.bytes.extend(if delta { difference } else { plain });
        Column { bytes, delta, code }
    }
}

/// One component of vectors.
#[derive(Debug, Clone)]
pub(super) struct Component<'a, const N: usize> {
    vectors: &'a [[f32; N]],
    index: usize,
    next: usize,
}

impl<const N: usize> Iterator for Component<'_, N> {
    type Item = f32;

    fn next(&mut self) -> Option<f32> {
        let vector = self.vectors.get(self.next)?;
        self.next += 1;
        Some(vector[self.index])
    }
}

/// The largest code of so many bits.
fn most(bits: u32) -> u32 {
    u32::MAX >> (32 - bits)
}

fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

/// Bits that bytes take if each is coded by itself: what is smaller compresses better.
fn entropy(bytes: &[u8]) -> f64 {
    let mut counts = [0u32; 256];
    bytes.iter().for_each(|byte| counts[usize::from(*byte)] += 1);
    let all = bytes.len() as f64;
    let bits = |count: u32| -f64::from(count) * libm::log2(f64::from(count) / all);
    counts.into_iter().filter(|count| *count > 0).map(bits).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waves(count: usize) -> Vec<f32> {
        (0..count).map(|i| (i as f32 * 0.37).sin() * 5.0).collect()
    }

    fn round_trip(values: &[f32], pack: impl Fn(&mut Packer, &[f32]) -> Column) -> (Vec<f32>, usize) {
        let mut packer = Packer::default();
        let column = pack(&mut packer, values);
        let column = serde_json::from_str::<Column>(&serde_json::to_string(&column).unwrap()).unwrap();
        let mut rest = &packer.bytes[..];
        let numbers = column.numbers(values.len(), &mut rest).unwrap();
        assert!(rest.is_empty());
        (numbers, packer.bytes.len())
    }

    #[test]
    fn even_and_symmetric_codes_err_by_half_a_step_and_keep_zero() {
        let mut values = waves(500);
        values[7] = 0.0;
        for bits in [8, 12, 16, 24] {
            let step = 10.0 / f64::from(most(bits));
            let worst = |numbers: &[f32]| {
                let errors = numbers.iter().zip(&values).map(|(a, b)| f64::from((a - b).abs()));
                errors.fold(0.0, f64::max)
            };
            let (even, bytes) = round_trip(&values, |packer, v| packer.even(v.iter().copied(), bits));
            assert!(worst(&even) < 0.51 * step + 5e-7, "{bits}: {}", worst(&even));
            assert_eq!(bytes, 500 * bits.div_ceil(8) as usize);
            let (symmetric, _) = round_trip(&values, |packer, v| packer.symmetric(v.iter().copied(), bits));
            assert!(worst(&symmetric) < 0.52 * step + 5e-7, "{bits}");
            assert_eq!(symmetric[7], 0.0);
        }
    }

    #[test]
    fn lengths_err_by_a_ratio() {
        let values: Vec<f32> = (0..400).map(|i| 1e-4 * 1.03f32.powi(i)).collect();
        let (lengths, bytes) = round_trip(&values, |packer, v| packer.logarithmic(v.iter().copied(), 8));
        let ratio = |(a, b): (&f32, &f32)| (a / b - 1.0).abs();
        let worst = lengths.iter().zip(&values).map(ratio).fold(0.0, f32::max);
        // 17.1 octaves in 255 steps.
        assert!(worst < 0.04 && bytes == 400, "{worst}");
        let (flat, _) = round_trip(&[0.0, 3.0, 1.0], |packer, v| {
            packer.logarithmic(v.iter().copied(), 16)
        });
        assert!(
            flat[0] > 0.0 && flat[0] < 1e-5 && (flat[1] - 3.0).abs() < 1e-3,
            "{flat:?}"
        );
    }

    #[test]
    fn what_is_the_same_everywhere_takes_no_bytes_and_bits_stay() {
        for value in [0.0, -2.5, 1e30] {
            let (numbers, bytes) = round_trip(&[value; 9], |packer, v| packer.even(v.iter().copied(), 12));
            assert_eq!((numbers, bytes), (vec![value; 9], 0));
        }
        let (numbers, bytes) = round_trip(&[0.5; 9], |packer, v| packer.logarithmic(v.iter().copied(), 8));
        assert_eq!((numbers, bytes), (vec![0.5; 9], 0));
        let odd = [f32::NAN, 1.5, f32::MIN_POSITIVE, -0.0];
        let (numbers, _) = round_trip(&odd, |packer, v| packer.bits(v.iter().copied()));
        assert!(numbers.iter().zip(odd).all(|(a, b)| a.to_bits() == b.to_bits()));
    }

    #[test]
    fn numbers_that_keep_all_bits_stay_what_they_are() {
        let values = waves(50);
        let own = Precision::OWN.rest;
        let all = [
            round_trip(&values, |packer, v| packer.even(v.iter().copied(), own)),
            round_trip(&values, |packer, v| packer.symmetric(v.iter().copied(), own)),
            round_trip(&values, |packer, v| packer.logarithmic(v.iter().copied(), own)),
        ];
        assert!(all.iter().all(|(numbers, _)| *numbers == values));
    }

    #[test]
    fn whole_numbers_are_whole_and_others_are_refused() {
        let values = [70_000u32, 4_000_000_000, 65_536];
        let mut packer = Packer::default();
        let column = packer.whole(values.into_iter());
        assert_eq!(column.whole(3, &mut &packer.bytes[..]).unwrap(), values);
        assert!(column.whole(4, &mut &packer.bytes[..]).is_err());
        assert!(column.numbers(usize::MAX, &mut &packer.bytes[..]).is_err());
        let even = packer.even([0.0, 1.0].into_iter(), 8);
        assert!(even.whole(2, &mut &[0, 1][..]).is_err());
    }
}
