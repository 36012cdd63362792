//! Numbers as planes of bytes: first the lowest byte of each, then the next. Neighbours are alike, so with `delta` each byte of a
//! plane is less the byte before it, modulo 256: most are small then.

use splatvol::SceneError;

/// Adds a plane to bytes.
pub(super) fn push(bytes: &mut Vec<u8>, plane: impl Iterator<Item = u8>, delta: bool) {
    let mut before = 0u8;
    bytes.extend(plane.map(|byte| {
        let said = if delta { byte.wrapping_sub(before) } else { byte };
        before = byte;
        said
    }));
}

/// The bytes of a plane.
pub(super) fn read(plane: &[u8], delta: bool) -> Vec<u8> {
    if !delta {
        return plane.to_vec();
    }
    let sums = plane.iter().scan(0u8, |sum, &byte| {
        *sum = sum.wrapping_add(byte);
        Some(*sum)
    });
    sums.collect()
}

pub(super) fn too_few(field: &'static str, bytes: usize) -> SceneError {
    SceneError::invalid(field, bytes, "as many bytes as the header asks for")
}
