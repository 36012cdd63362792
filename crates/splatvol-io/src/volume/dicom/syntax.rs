//! Transfer syntaxes (PS3.5, annex A; their names and UIDs in PS3.6, annex A).

use super::element::Coding;
use crate::samples::Endian;

/// Coding of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Syntax {
    pub(super) name: String,
    pub(super) pixels: Pixels,
    explicit: bool,
    big: bool,
    /// True if everything behind the file meta information is deflated.
    pub(super) deflated: bool,
    /// True if elements lack the representations that the file promises.
    pub(super) contradicted: bool,
}

/// Coding of the pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pixels {
    Native,
    Rle,
    Jpeg,
    JpegLs,
    Jpeg2000,
    /// Not read.
    Unknown,
}

impl Syntax {
    /// Uncompressed, little-endian.
    pub(super) fn plain(explicit: bool) -> Self {
        Self {
            name: if explicit { "explicit" } else { "implicit" }.to_owned(),
            pixels: Pixels::Native,
            explicit,
            big: false,
            deflated: false,
            contradicted: false,
        }
    }

    /// The same for a data set that begins with `start`: some writers leave out the representations that they promise.
    pub(super) fn of_elements(mut self, start: &[u8]) -> Self {
        let letters = |pair: &[u8]| pair.iter().all(u8::is_ascii_uppercase);
        let silent = start.get(4..6).is_some_and(|pair| !letters(pair));
        if silent && self.explicit && !self.big && !self.deflated {
            (self.explicit, self.contradicted) = (false, true);
        }
        self
    }

    pub(super) fn from_uid(uid: &str) -> Self {
        let explicit = Self::plain(true);
        let coded = |name: &str, pixels| Self {
            name: name.to_owned(),
            pixels,
            ..Self::plain(true)
        };
        let Some(number) = uid.strip_prefix("1.2.840.10008.1.2") else {
            return coded(&format!("transfer syntax {uid}"), Pixels::Unknown);
        };
        match number {
            "" => Self::plain(false),
            ".1" => explicit,
            ".1.99" => Self {
                name: "deflated".to_owned(),
                deflated: true,
                ..explicit
            },
            ".2" => Self {
                name: "explicit, big-endian".to_owned(),
                big: true,
                ..explicit
            },
            ".5" => coded("RLE", Pixels::Rle),
            ".4.50" => coded("JPEG baseline", Pixels::Jpeg),
            ".4.51" => coded("JPEG extended", Pixels::Jpeg),
            ".4.57" | ".4.70" => coded("JPEG lossless", Pixels::Jpeg),
            ".4.80" => coded("JPEG-LS lossless", Pixels::JpegLs),
            ".4.81" => coded("JPEG-LS near-lossless", Pixels::JpegLs),
            ".4.90" => coded("JPEG 2000 lossless", Pixels::Jpeg2000),
            ".4.91" => coded("JPEG 2000", Pixels::Jpeg2000),
            other => {
                let name = match other {
                    ".4.92" | ".4.93" => "JPEG 2000 multi-component",
                    ".4.94" | ".4.95" => "JPIP",
                    ".4.100" | ".4.101" => "MPEG-2",
                    ".4.102" | ".4.103" | ".4.104" | ".4.105" | ".4.106" => "MPEG-4",
                    ".4.107" | ".4.108" => "HEVC",
                    ".4.110" | ".4.111" | ".4.112" => "JPEG XL",
                    ".4.201" | ".4.202" | ".4.203" => "high-throughput JPEG 2000",
                    ".6.1" | ".6.2" => "a retired one",
                    _ => "an unknown one",
                };
                coded(&format!("{name}, transfer syntax {uid}"), Pixels::Unknown)
            }
        }
    }

    pub(super) fn coding(&self) -> Coding {
        Coding {
            explicit: self.explicit,
            endian: self.endian(),
        }
    }

    pub(super) fn endian(&self) -> Endian {
        if self.big { Endian::Big } else { Endian::Little }
    }
}
