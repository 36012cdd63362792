//! DICOM files of one frame in each compression that is read, other than run lengths.
#![allow(unreachable_pub, dead_code, reason = "a module of tests, used in part")]

use super::codecs;
use super::dicom_file::DicomFile;

/// A compressed frame.
pub struct Coded {
    pub name: &'static str,
    pub syntax: &'static str,
    /// Columns, rows.
    pub size: [u16; 2],
    pub bits: u16,
    /// The photometric interpretation: grey values, or colours.
    pub photometric: &'static str,
    pub stream: &'static str,
    /// The most that a sample of a good decoder is off from what was compressed.
    pub error: u16,
}

const GREY: &str = "MONOCHROME2";

/// Words that come back as they were, of 8 x 6 pixels.
const WORDS: Coded = Coded {
    name: "",
    syntax: "",
    size: [8, 6],
    bits: 16,
    photometric: GREY,
    stream: "",
    error: 0,
};

/// Grey values.
pub const FRAMES: [Coded; 6] = [
    Coded {
        name: "JPEG, baseline",
        syntax: "1.2.840.10008.1.2.4.50",
        bits: 8,
        stream: codecs::JPEG,
        error: 2,
        ..WORDS
    },
    Coded {
        name: "JPEG, extended",
        syntax: "1.2.840.10008.1.2.4.51",
        bits: 12,
        stream: codecs::JPEG_12,
        error: 4,
        ..WORDS
    },
    Coded {
        name: "JPEG, lossless",
        syntax: "1.2.840.10008.1.2.4.70",
        stream: codecs::JPEG_LOSSLESS,
        ..WORDS
    },
    Coded {
        name: "JPEG-LS",
        syntax: "1.2.840.10008.1.2.4.80",
        stream: codecs::JPEG_LS,
        ..WORDS
    },
    Coded {
        name: "JPEG 2000, reversible",
        syntax: "1.2.840.10008.1.2.4.90",
        size: [32; 2],
        stream: codecs::JPEG_2000,
        ..WORDS
    },
    Coded {
        name: "JPEG 2000, irreversible",
        syntax: "1.2.840.10008.1.2.4.91",
        size: [32; 2],
        stream: codecs::JPEG_2000_LOSSY,
        error: 8,
        ..WORDS
    },
];

/// Colours by JPEG: chrominances of half the size cost fourteen levels.
const COLORED: Coded = Coded {
    syntax: "1.2.840.10008.1.2.4.50",
    bits: 8,
    stream: codecs::JPEG_COLORS,
    error: 15,
    ..WORDS
};

/// Red, green and blue.
pub const COLORS: [Coded; 3] = [
    Coded {
        name: "colours by JPEG-LS",
        syntax: "1.2.840.10008.1.2.4.80",
        bits: 8,
        photometric: "RGB",
        stream: codecs::JPEG_LS_COLORS,
        ..WORDS
    },
    Coded {
        name: "colours by JPEG",
        photometric: "YBR_FULL_422",
        ..COLORED
    },
    // As some writers call what a decoder makes of it.
    Coded {
        name: "colours by JPEG, as RGB",
        photometric: "RGB",
        ..COLORED
    },
];

impl Coded {
    /// The file.
    pub fn file(&self) -> Vec<u8> {
        let mut file = DicomFile::picture(self.syntax, self.size, self.bits);
        if self.photometric != GREY {
            file.short(0x0028_0002, 3);
            file.short(0x0028_0006, 0);
            file.text(0x0028_0004, b"CS", self.photometric);
        }
        file.encapsulated(&[codecs::stream(self.stream)])
    }

    /// What was compressed, of a channel of colours; grey values have one.
    pub fn samples(&self, channel: usize) -> Vec<u16> {
        let sample = |x: u16, y: u16| match (self.bits, channel) {
            (8, 0) => 10 * x + 7 * y,
            (8, 1) => 35 + 10 * x - 7 * y,
            (8, _) => 70 + 7 * y - 10 * x,
            _ => 100 * x + 37 * y + (x * x * y) % 11,
        };
        let [columns, rows] = self.size;
        let places = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
        places.map(|(x, y)| sample(x, y)).collect()
    }
}
