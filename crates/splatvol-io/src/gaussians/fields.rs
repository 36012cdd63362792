//! Little-endian numbers at offsets of a byte string, checked against its length.

use crate::IoError;
use crate::error::Context;

/// Bytes with their name in errors.
#[derive(Clone, Copy)]
pub(super) struct Fields<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) what: &'static str,
    pub(super) context: &'a Context<'a>,
}

impl<'a> Fields<'a> {
    /// `length` bytes from `offset` on.
    pub(super) fn slice(&self, offset: u64, length: u64) -> Result<&'a [u8], IoError> {
        let end = offset.saturating_add(length);
        let range = usize::try_from(offset).ok().zip(usize::try_from(end).ok());
        range
            .and_then(|(start, end)| self.bytes.get(start..end))
            .ok_or_else(|| self.context.truncated(self.what, end, self.bytes.len() as u64))
    }

    fn array<const N: usize>(&self, offset: u64) -> Result<[u8; N], IoError> {
        let mut array = [0; N];
        array.copy_from_slice(self.slice(offset, N as u64)?);
        Ok(array)
    }

    pub(super) fn u8(&self, offset: u64) -> Result<u8, IoError> {
        Ok(u8::from_le_bytes(self.array(offset)?))
    }

    pub(super) fn u16(&self, offset: u64) -> Result<u16, IoError> {
        Ok(u16::from_le_bytes(self.array(offset)?))
    }

    pub(super) fn u32(&self, offset: u64) -> Result<u32, IoError> {
        Ok(u32::from_le_bytes(self.array(offset)?))
    }

    pub(super) fn u64(&self, offset: u64) -> Result<u64, IoError> {
        Ok(u64::from_le_bytes(self.array(offset)?))
    }

    pub(super) fn f32(&self, offset: u64) -> Result<f32, IoError> {
        Ok(f32::from_le_bytes(self.array(offset)?))
    }
}
