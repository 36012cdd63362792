//! Records that vendors add to SPZ: `u32` type, `u32` length, payload.

use super::super::fields::Fields;
use super::super::frame::Frame;
use super::packed::Packed;
use crate::IoError;

/// Range of the harmonics (Adobe): two bytes of precision, two floats.
const HARMONICS_RANGE: u32 = 0xADBE_0001;
/// Limits of an orbiting camera (Adobe), which a reader can ignore.
const ORBIT: u32 = 0xADBE_0002;
/// Frame (Adobe): a number.
const FRAME: u32 = 0xADBE_0003;

/// The published numbers of frames, from 1.
const FRAMES: [Frame; 16] = [
    "LDB", "RDB", "LUB", "RUB", "LDF", "RDF", "LUF", "RUF", "LBD", "RBD", "LBU", "RBU", "LFD", "RFD", "LFU",
    "RFU",
];

/// Applies the extension records.
pub(super) fn apply(records: &Fields<'_>, packed: &mut Packed) -> Result<(), IoError> {
    let mut at = 0;
    while at < records.bytes.len() as u64 {
        let kind = records.u32(at)?;
        let length = u64::from(records.u32(at + 4)?);
        let payload = &Fields {
            bytes: records.slice(at + 8, length)?,
            ..*records
        };
        match kind {
            FRAME => {
                let number = payload.u32(0)?;
                packed.frame = frame(number).ok_or_else(|| {
                    let expected = "a coordinate system of 0 to 16";
                    payload
                        .context
                        .field("extension 0xADBE0003", number, None, expected)
                })?;
            }
            HARMONICS_RANGE => {
                let (min, max) = (payload.f32(2)?, payload.f32(6)?);
                if (min, max) != (-1.0, 1.0) {
                    packed.harmonics_range = Some([min, max]);
                }
            }
            ORBIT => {}
            other => packed
                .warnings
                .push(format!("extension {other:#010x} of {length} bytes is ignored")),
        }
        at += 8 + length;
    }
    Ok(())
}

fn frame(number: u32) -> Option<Frame> {
    match number {
        0 => Some(super::super::frame::RUB),
        _ => FRAMES.get(number as usize - 1).copied(),
    }
}
