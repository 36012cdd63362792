//! Shuffles of Blosc: bytes or bits of equal rank side by side, which compress better than the samples themselves.

/// Byte j of element i is at `j n + i`; bytes behind the last element are as they were.
pub(super) fn unshuffle(bytes: &[u8], size: usize, into: &mut [u8]) {
    match size {
        2 => join::<2>(bytes, into),
        4 => join::<4>(bytes, into),
        8 => join::<8>(bytes, into),
        size => {
            let count = bytes.len() / size;
            for (element, to) in into.chunks_exact_mut(size).enumerate() {
                for (byte, to) in to.iter_mut().enumerate() {
                    *to = bytes[byte * count + element];
                }
            }
            into[count * size..].copy_from_slice(&bytes[count * size..]);
        }
    }
}

fn join<const N: usize>(bytes: &[u8], into: &mut [u8]) {
    let count = bytes.len() / N;
    let planes: [&[u8]; N] = std::array::from_fn(|byte| &bytes[byte * count..(byte + 1) * count]);
    for (element, to) in into.chunks_exact_mut(N).enumerate() {
        let joined: [u8; N] = std::array::from_fn(|byte| planes[byte][element]);
        to.copy_from_slice(&joined);
    }
    into[count * N..].copy_from_slice(&bytes[count * N..]);
}

/// Elements whose bits are shuffled: all where they are a multiple of eight, otherwise none, as in the library.
fn whole_rows(length: usize, size: usize) -> usize {
    let count = length / size;
    if count.is_multiple_of(8) { count / 8 } else { 0 }
}

/// The bits of eight bytes transposed: bit e of byte b becomes bit b of byte e (Hacker's Delight, 7-3).
fn transpose(bits: u64) -> u64 {
    let swap = |bits: u64, shift: u32, mask: u64| {
        let moved = (bits ^ bits >> shift) & mask;
        bits ^ moved ^ moved << shift
    };
    let bits = swap(bits, 7, 0x00aa_00aa_00aa_00aa);
    let bits = swap(bits, 14, 0x0000_cccc_0000_cccc);
    swap(bits, 28, 0x0000_0000_f0f0_f0f0)
}

/// Bit b of byte j of element i is bit `i mod 8` of byte `(8 j + b) n / 8 + i / 8`.
pub(super) fn unshuffle_bits(bytes: &[u8], size: usize, into: &mut [u8]) {
    let row = whole_rows(bytes.len(), size);
    for byte in 0..size {
        let rows = &bytes[8 * byte * row..8 * (byte + 1) * row];
        let planes: [&[u8]; 8] = std::array::from_fn(|bit| &rows[bit * row..(bit + 1) * row]);
        for (place, to) in into.chunks_exact_mut(8 * size).take(row).enumerate() {
            let gathered: [u8; 8] = std::array::from_fn(|bit| planes[bit][place]);
            let elements = transpose(u64::from_le_bytes(gathered)).to_le_bytes();
            for (element, value) in elements.into_iter().enumerate() {
                to[element * size + byte] = value;
            }
        }
    }
    into[row * 8 * size..].copy_from_slice(&bytes[row * 8 * size..]);
}

/// The reverse of [`unshuffle_bits`].
pub(super) fn shuffle_bits(bytes: &[u8], size: usize, into: &mut [u8]) {
    let row = whole_rows(bytes.len(), size);
    for byte in 0..size {
        let rows = &mut into[8 * byte * row..8 * (byte + 1) * row];
        for (place, from) in bytes.chunks_exact(8 * size).take(row).enumerate() {
            let elements: [u8; 8] = std::array::from_fn(|element| from[element * size + byte]);
            let bits = transpose(u64::from_le_bytes(elements)).to_le_bytes();
            for (bit, value) in bits.into_iter().enumerate() {
                rows[bit * row + place] = value;
            }
        }
    }
    into[row * 8 * size..].copy_from_slice(&bytes[row * 8 * size..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(length: usize) -> Vec<u8> {
        (0..length).map(|i| (i * 37 % 251) as u8 ^ 11).collect()
    }

    #[test]
    fn bits_come_back_to_their_elements() {
        for size in [1, 2, 3, 4, 8] {
            let plain = plain(16 * size);
            let mut shuffled = vec![0; plain.len()];
            for (i, byte) in plain.iter().enumerate() {
                let (element, of_element) = (i / size, i % size);
                for bit in 0..8 {
                    shuffled[(8 * of_element + bit) * 2 + element / 8] |= (byte >> bit & 1) << (element % 8);
                }
            }
            let mut found = vec![0; plain.len()];
            unshuffle_bits(&shuffled, size, &mut found);
            assert_eq!(found, plain, "{size}");
            shuffle_bits(&plain, size, &mut found);
            assert_eq!(found, shuffled, "{size}");
        }
    }

    #[test]
    fn odd_lengths_stay_and_bytes_come_back() {
        for size in [2, 3, 4, 8] {
            let plain = plain(13 * size + 1);
            let mut found = vec![0; plain.len()];
            shuffle_bits(&plain, size, &mut found);
            assert_eq!(found, plain);
            unshuffle_bits(&plain, size, &mut found);
            assert_eq!(found, plain);
            let mut shuffled = plain.clone();
            for element in 0..13 {
                for byte in 0..size {
                    shuffled[byte * 13 + element] = plain[element * size + byte];
                }
            }
            unshuffle(&shuffled, size, &mut found);
            assert_eq!(found, plain, "{size}");
        }
    }
}
