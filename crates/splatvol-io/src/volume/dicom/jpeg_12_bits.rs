//! The bits of a JPEG scan and its Huffman codes (ITU-T T.81, F.2.2).

/// Bits up to the next marker: a zero byte behind 0xff is none of them.
pub(super) struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    held: u32,
    count: u32,
}

impl<'a> Bits<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            held: 0,
            count: 0,
        }
    }

    fn bit(&mut self) -> Option<u32> {
        if self.count == 0 {
            let &byte = self.bytes.get(self.at)?;
            self.at += 1;
            if byte == 0xff {
                // Anything but a stuffed zero is a marker, where the scan ends.
                self.bytes.get(self.at).filter(|&&stuffed| stuffed == 0)?;
                self.at += 1;
            }
            (self.held, self.count) = (byte.into(), 8);
        }
        self.count -= 1;
        Some(self.held >> self.count & 1)
    }

    /// A number of `size` bits, of which the lower half are negative (figure F.12).
    pub(super) fn signed(&mut self, size: u8) -> Option<i32> {
        if size > 15 {
            return None;
        }
        let mut value = 0;
        for _ in 0..size {
            value = value << 1 | self.bit()? as i32;
        }
        let half = (1 << size) >> 1;
        Some(if value < half { value - 2 * half + 1 } else { value })
    }

    /// Drops the rest of a byte and takes the marker that follows (D0 to D7).
    pub(super) fn restart(&mut self) -> Option<()> {
        self.count = 0;
        let marker = self.bytes.get(self.at..self.at + 2)?;
        self.at += 2;
        (marker[0] == 0xff && (0xd0..=0xd7).contains(&marker[1])).then_some(())
    }
}

/// Huffman codes of one table, by their lengths.
pub(super) struct Huffman {
    /// For each length: the first code, their number, and the place of their values.
    lengths: [(u32, u32, usize); 16],
    values: Vec<u8>,
}

impl Huffman {
    /// Codes follow each other (annex C).
    pub(super) fn new(counts: &[u8; 16], values: &[u8]) -> Self {
        let (mut code, mut place) = (0, 0);
        let lengths = counts.map(|count| {
            let length = (code, u32::from(count), place);
            code = (code + u32::from(count)) << 1;
            place += usize::from(count);
            length
        });
        Self {
            lengths,
            values: values.to_vec(),
        }
    }

    pub(super) fn decode(&self, bits: &mut Bits<'_>) -> Option<u8> {
        let mut code = 0;
        for &(first, count, place) in &self.lengths {
            code = code << 1 | bits.bit()?;
            if let Some(offset) = code.checked_sub(first).filter(|&offset| offset < count) {
                return self.values.get(place + offset as usize).copied();
            }
        }
        None
    }
}
