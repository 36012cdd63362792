//! The bits of JPEG-LS, and its limited Golomb codes (T.87, A.1, A.5.3).

/// The bits of a scan: after a byte 0xff, the next has seven (A.1).
pub(super) struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    held: u64,
    count: u32,
    after_ff: bool,
}

impl<'a> Bits<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            held: 0,
            count: 0,
            after_ff: false,
        }
    }

    /// The place of the first byte of which nothing was taken.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    pub(super) fn bit(&mut self) -> Option<u32> {
        self.bits(1)
    }

    /// Up to 32 bits.
    pub(super) fn bits(&mut self, count: u32) -> Option<u32> {
        while self.count < count {
            let &byte = self.bytes.get(self.at)?;
            if self.after_ff && byte >= 0x80 {
                return None;
            }
            let width = if self.after_ff { 7 } else { 8 };
            self.held = self.held << width | u64::from(byte);
            self.count += width;
            self.after_ff = byte == 0xff;
            self.at += 1;
        }
        self.count -= count;
        let value = self.held >> self.count;
        self.held &= (1 << self.count) - 1;
        Some(value as u32)
    }

    /// A code of at most `limit` bits in steps of 2^k (A.5.3); `width` bits hold any error.
    pub(super) fn golomb(&mut self, k: u32, limit: u32, width: u32) -> Option<i32> {
        let escape = limit.checked_sub(width + 1)?;
        let mut zeros = 0;
        while self.bit()? == 0 {
            zeros += 1;
            if zeros > escape {
                return None;
            }
        }
        let value = match zeros < escape {
            true => zeros << k | self.bits(k)?,
            false => self.bits(width)?.checked_add(1)?,
        };
        // An error is less than the range, and is doubled to remove its sign.
        i32::try_from(value).ok().filter(|&value| value <= 2 << width)
    }
}
