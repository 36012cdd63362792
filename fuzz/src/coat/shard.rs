//! Shards of Zarr: an index of places and lengths at the end, and its sum behind it.

use super::Change;
use crate::random::Random;

/// Most chunks of a shard.
const MOST: usize = 64;

pub(super) fn damage(bytes: &[u8], random: &mut Random, change: &mut Change<'_>) -> Option<Vec<u8>> {
    let (body, sum) = bytes.split_last_chunk::<4>()?;
    let sum = u32::from_le_bytes(*sum);
    let index = (1..=MOST)
        .filter_map(|count| body.len().checked_sub(16 * count))
        .find(|&start| crc32c(&body[start..]) == sum)?;
    let (mut chunks, mut index) = (body[..index].to_vec(), body[index..].to_vec());
    if random.below(2) == 0 {
        change(&mut index, random);
    } else {
        change(&mut chunks, random);
    }
    let sum = crc32c(&index);
    Some([&chunks[..], &index, &sum.to_le_bytes()].concat())
}

/// CRC-32C (Castagnoli), bit by bit.
pub(crate) fn crc32c(bytes: &[u8]) -> u32 {
    let step = |sum: u32, _| (sum >> 1) ^ (0x82f6_3b78 & (sum & 1).wrapping_neg());
    !bytes
        .iter()
        .fold(u32::MAX, |sum, &byte| (0..8).fold(sum ^ u32::from(byte), step))
}
