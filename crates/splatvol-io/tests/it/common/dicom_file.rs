//! Writes DICOM files for tests, element by element.
#![allow(dead_code, unreachable_pub, reason = "every test file uses its own part")]

/// A file under construction: elements in ascending order.
#[derive(Debug, Clone)]
pub struct DicomFile {
    pub syntax: &'static str,
    elements: Vec<(u32, [u8; 2], Vec<u8>)>,
}

pub const EXPLICIT: &str = "1.2.840.10008.1.2.1";
pub const IMPLICIT: &str = "1.2.840.10008.1.2";
pub const BIG: &str = "1.2.840.10008.1.2.2";

/// The tag of the pixels.
const PIXELS: u32 = 0x7fe0_0010;

impl DicomFile {
    /// A slice of 3 x 2 words at a height, of 16 bits each.
    pub fn slice(syntax: &'static str, position: [f64; 3], number: i32, samples: &[u16; 6]) -> Self {
        let mut file = Self {
            syntax,
            elements: Vec::new(),
        };
        file.text(0x0020_000e, b"UI", "1.2.3");
        file.text(0x0020_0011, b"IS", "7");
        file.text(0x0008_103e, b"LO", "test");
        file.text(0x0020_0013, b"IS", &number.to_string());
        file.text(0x0020_0032, b"DS", &position.map(|x| x.to_string()).join("\\"));
        file.text(0x0020_0037, b"DS", "1\\0\\0\\0\\1\\0");
        file.text(0x0028_0030, b"DS", "0.5\\0.25");
        file.text(0x0028_0004, b"CS", "MONOCHROME2");
        for (tag, value) in [
            (0x0028_0002, 1),
            (0x0028_0010, 2),
            (0x0028_0011, 3),
            (0x0028_0100, 16),
            (0x0028_0101, 12),
            (0x0028_0102, 11),
            (0x0028_0103, 0),
        ] {
            file.short(tag, value);
        }
        file.pixels(samples);
        file
    }

    /// A slice of so many columns and rows of `bits` stored bits, in whole bytes. Its pixels are still those of a small slice.
    pub fn picture(syntax: &'static str, [columns, rows]: [u16; 2], bits: u16) -> Self {
        let mut file = Self::slice(syntax, [0.0; 3], 1, &[0; 6]);
        for (tag, value) in [
            (0x0028_0010, rows),
            (0x0028_0011, columns),
            (0x0028_0100, bits.next_multiple_of(8)),
            (0x0028_0101, bits),
            (0x0028_0102, bits - 1),
        ] {
            file.short(tag, value);
        }
        file
    }

    pub fn set(&mut self, tag: u32, representation: &[u8; 2], mut value: Vec<u8>) {
        if value.len() % 2 == 1 {
            value.push(b' ');
        }
        self.elements.retain(|element| element.0 != tag);
        self.elements.push((tag, *representation, value));
        self.elements.sort_by_key(|element| element.0);
    }

    pub fn text(&mut self, tag: u32, representation: &[u8; 2], value: &str) {
        self.set(tag, representation, value.as_bytes().to_vec());
    }

    pub fn short(&mut self, tag: u32, value: u16) {
        self.set(tag, b"US", self.word(value).to_vec());
    }

    pub fn pixels(&mut self, samples: &[u16]) {
        let bytes = samples.iter().flat_map(|&sample| self.word(sample)).collect();
        self.set(PIXELS, b"OW", bytes);
    }

    fn word(&self, value: u16) -> [u8; 2] {
        if self.syntax == BIG {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        }
    }

    /// The elements alone.
    pub fn dataset(&self) -> Vec<u8> {
        let elements = self.elements.iter();
        elements
            .flat_map(|(tag, representation, value)| element(self.syntax, *tag, representation, value))
            .collect()
    }

    pub fn bytes(&self) -> Vec<u8> {
        self.with_body(&self.dataset())
    }

    /// The file with these fragments for pixels, after an empty table of offsets (PS3.5, annex A.4).
    pub fn encapsulated(&self, fragments: &[Vec<u8>]) -> Vec<u8> {
        let mut file = self.clone();
        file.set(PIXELS, b"OB", Vec::new());
        let mut body = file.dataset();
        // The pixels are last, and their length is unknown.
        let length = body.len() - 4;
        body[length..].copy_from_slice(&[0xff; 4]);
        let even = |fragment: &Vec<u8>| {
            let mut fragment = fragment.clone();
            fragment.resize(fragment.len().next_multiple_of(2), 0);
            fragment
        };
        body.extend(items(&[Vec::new()]));
        body.extend(items(&fragments.iter().map(even).collect::<Vec<_>>()));
        body.extend([0xfe, 0xff, 0xdd, 0xe0, 0, 0, 0, 0]);
        self.with_body(&body)
    }

    /// Preamble and file meta information before `body`.
    pub fn with_body(&self, body: &[u8]) -> Vec<u8> {
        let mut uid = self.syntax.as_bytes().to_vec();
        if uid.len() % 2 == 1 {
            uid.push(0);
        }
        [
            &[0; 128],
            &b"DICM"[..],
            &element(EXPLICIT, 0x0002_0010, b"UI", &uid),
            body,
        ]
        .concat()
    }
}

/// One element in a transfer syntax.
pub fn element(syntax: &str, tag: u32, representation: &[u8; 2], value: &[u8]) -> Vec<u8> {
    let big = syntax == BIG;
    let short = |value: u16| {
        if big {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        }
    };
    let long = |value: u32| {
        if big {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        }
    };
    let mut bytes = [short((tag >> 16) as u16), short(tag as u16)].concat();
    if syntax == IMPLICIT {
        bytes.extend(long(value.len() as u32));
    } else if matches!(representation, b"OW" | b"OB" | b"SQ" | b"UN") {
        bytes.extend(representation);
        bytes.extend([0, 0]);
        bytes.extend(long(value.len() as u32));
    } else {
        bytes.extend(representation);
        bytes.extend(short(value.len() as u16));
    }
    bytes.extend(value);
    bytes
}

/// A sequence's value: items of explicit little-endian elements.
pub fn items(items: &[Vec<u8>]) -> Vec<u8> {
    let item = |item: &Vec<u8>| {
        [
            &[0xfe, 0xff, 0x00, 0xe0],
            &(item.len() as u32).to_le_bytes()[..],
            item,
        ]
        .concat()
    };
    items.iter().flat_map(item).collect()
}
