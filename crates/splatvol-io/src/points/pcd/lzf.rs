//! LZF (Marc Lehmann's `LibLZF`), which compresses the data of PCD files.
//!
//! A byte `c < 32` is followed by `c + 1` literal bytes. Else its upper three bits are a length (7: one more byte adds
//! to it), 2 less than the true one, and its lower five with the next byte a distance, 1 less than the true one. This
//! decoder is our own: it is shorter than the checks that another's would need against hostile lengths.

use crate::IoError;
use crate::error::Context;

/// Three bytes may decode to 264.
const RATIO: usize = 88;

/// The data behind a PCD header: compressed and decompressed length, then the stream.
pub(super) fn data(bytes: &[u8], declared: usize, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    let Some((lengths, stream)) = bytes.split_at_checked(8) else {
        return Err(context.truncated("lengths of the data", 8, bytes.len() as u64));
    };
    let length = |at: usize| {
        u32::from_le_bytes([lengths[at], lengths[at + 1], lengths[at + 2], lengths[at + 3]]) as usize
    };
    let (compressed, decompressed) = (length(0), length(4));
    if decompressed != declared {
        let expected = format!("{declared}, as the header's fields and points take");
        return Err(context.field("decompressed size", decompressed, None, expected));
    }
    let stream = stream
        .get(..compressed)
        .ok_or_else(|| context.truncated("compressed data", compressed as u64, stream.len() as u64))?;
    let at_most = compressed.saturating_mul(RATIO);
    if decompressed > at_most {
        return Err(context.too_small("decompressed data", decompressed as u64, at_most as u64));
    }
    match inflate(stream, decompressed) {
        Some(data) if data.len() == decompressed => Ok(data),
        _ => Err(context.field(
            "compressed data",
            "corrupt",
            None,
            format!("an LZF stream of {decompressed} bytes"),
        )),
    }
}

fn inflate(stream: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(length);
    let mut stream = stream.iter().copied();
    while let Some(control) = stream.next() {
        let control = usize::from(control);
        if control < 32 {
            let before = bytes.len();
            bytes.extend(stream.by_ref().take(control + 1));
            if bytes.len() != before + control + 1 {
                return None;
            }
        } else {
            let mut run = control >> 5;
            if run == 7 {
                run += usize::from(stream.next()?);
            }
            let distance = ((control & 31) << 8 | usize::from(stream.next()?)) + 1;
            let start = bytes.len().checked_sub(distance)?;
            // A run may reach into what it writes.
            for at in start..start + run + 2 {
                bytes.push(bytes[at]);
            }
        }
        if bytes.len() > length {
            return None;
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_and_runs_make_the_bytes() {
        // "abcabcabcabc!": three literals, a run of 9 at distance 3 (7 in two bytes), a literal.
        let stream = [2, b'a', b'b', b'c', 0b1110_0000, 0, 2, 0, b'!'];
        assert_eq!(inflate(&stream, 13).unwrap(), b"abcabcabcabc!");
        // The same with a short length: 2 + 3.
        assert_eq!(inflate(&[0, b'x', 0b0110_0000, 0], 6).unwrap(), b"xxxxxx");
        for bad in [
            &[2, b'a'][..],
            &[32, 0],
            &[0, b'a', 0b1110_0000],
            &[0, b'a', 0b1110_0000, 255, 0],
        ] {
            assert_eq!(inflate(bad, 6), None, "{bad:?}");
        }
    }
}
