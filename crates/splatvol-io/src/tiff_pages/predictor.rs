//! Rows without the differences between neighbours (TIFF 6.0, section 14; technical note 3 for floats), and without the
//! packing of bits.

use super::PageHead;
use crate::IoError;
use crate::error::Context;
use crate::samples::Endian;

const NONE: u64 = 1;
const HORIZONTAL: u64 = 2;
const OF_FLOATS: u64 = 3;

/// Undoes the predictor of a row of `components` interleaved components, and makes its samples little-endian.
pub(super) fn undo(
    row: &mut [u8],
    head: &PageHead,
    components: usize,
    context: &Context<'_>,
) -> Result<(), IoError> {
    let size = (head.bits / 8) as usize;
    if head.predictor == OF_FLOATS && head.bits >= 16 {
        undo_floats(row, components, size);
        return Ok(());
    }
    if head.endian == Endian::Big && size > 1 {
        row.chunks_exact_mut(size).for_each(<[u8]>::reverse);
    }
    match head.predictor {
        NONE => Ok(()),
        HORIZONTAL if size > 0 => {
            undo_horizontal(row, components, size);
            Ok(())
        }
        other => Err(context.field(
            "Predictor",
            other,
            None,
            "1, or 2 or 3 for samples of whole bytes",
        )),
    }
}

/// Adds the pixel before to each pixel.
fn undo_horizontal(row: &mut [u8], components: usize, size: usize) {
    let before = components * size;
    for index in (before..row.len()).step_by(size) {
        let mut carry = 0;
        for byte in index..index + size {
            let sum = u16::from(row[byte]) + u16::from(row[byte - before]) + carry;
            row[byte] = sum as u8;
            carry = sum >> 8;
        }
    }
}

/// Adds the bytes before, and gathers the bytes of each sample: the highest of all samples come first.
fn undo_floats(row: &mut [u8], components: usize, size: usize) {
    for index in components..row.len() {
        row[index] = row[index].wrapping_add(row[index - components]);
    }
    let (shuffled, count) = (row.to_vec(), row.len() / size);
    for (index, byte) in row.iter_mut().enumerate() {
        *byte = shuffled[(size - 1 - index % size) * count + index / size];
    }
}

/// Samples of fewer than eight bits as bytes: `count` of them from the start of a row.
pub(super) fn unpacked(row: &[u8], bits: u64, count: usize) -> impl Iterator<Item = u8> {
    let bits = bits as usize;
    (0..count).map(move |index| {
        let at = index * bits;
        let byte = row[at / 8];
        (byte >> (8 - bits - at % 8)) & ((1 << bits) - 1)
    })
}
