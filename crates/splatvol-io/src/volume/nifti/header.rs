//! The binary header of NIfTI-1 (348 bytes) and NIfTI-2 (540 bytes), in either byte order.
//!
//! Both hold the same fields at other places and in other widths; [`Places`] is the only difference below.

use std::path::Path;

use crate::IoError;
use crate::error::Context;
use crate::samples::Endian;
use crate::source::Source;

/// Length of the longer header.
const LONGEST: usize = 540;

/// Byte offsets of the fields of a version.
#[derive(Debug)]
pub(super) struct Places {
    pub(super) length: usize,
    magic: usize,
    pub(super) dim: usize,
    pub(super) datatype: usize,
    pub(super) bitpix: usize,
    pub(super) pixdim: usize,
    pub(super) vox_offset: usize,
    pub(super) scl_slope: usize,
    pub(super) scl_inter: usize,
    xyzt_units: usize,
    qform_code: usize,
    sform_code: usize,
    pub(super) quatern: usize,
    pub(super) qoffset: usize,
    pub(super) srow: usize,
}

const NIFTI_1: Places = Places {
    length: 348,
    magic: 344,
    dim: 40,
    datatype: 70,
    bitpix: 72,
    pixdim: 76,
    vox_offset: 108,
    scl_slope: 112,
    scl_inter: 116,
    xyzt_units: 123,
    qform_code: 252,
    sform_code: 254,
    quatern: 256,
    qoffset: 268,
    srow: 280,
};

const NIFTI_2: Places = Places {
    length: 540,
    magic: 4,
    dim: 16,
    datatype: 12,
    bitpix: 14,
    pixdim: 104,
    vox_offset: 168,
    scl_slope: 176,
    scl_inter: 184,
    xyzt_units: 500,
    qform_code: 344,
    sform_code: 348,
    quatern: 352,
    qoffset: 376,
    srow: 400,
};

/// A decoded header; nothing but `vox_offset`, magic number and size is checked yet.
#[derive(Debug)]
pub(super) struct Header {
    /// 0 for Analyze 7.5.
    pub(super) version: u8,
    pub(super) endian: Endian,
    /// True for `.nii`, false for a `.hdr`/`.img` pair.
    pub(super) single: bool,
    pub(super) places: &'static Places,
    pub(super) dim: [i64; 8],
    pub(super) datatype: i16,
    pub(super) bitpix: i16,
    pub(super) pixdim: [f64; 8],
    /// Start of the samples in their file.
    pub(super) vox_offset: u64,
    pub(super) scl_slope: f64,
    pub(super) scl_inter: f64,
    pub(super) xyzt_units: i32,
    pub(super) qform_code: i32,
    pub(super) sform_code: i32,
    pub(super) quatern: [f64; 3],
    pub(super) qoffset: [f64; 3],
    pub(super) srow: [f64; 12],
}

impl Header {
    /// Reads the header; `source` is left right behind it.
    pub(super) fn read(source: &mut Source<'_>, context: &Context<'_>) -> Result<Self, IoError> {
        let mut bytes = [0; LONGEST];
        let found = source.fill(&mut bytes[..NIFTI_1.length], context)?;
        let [a, b, c, d, ..] = bytes;
        let size = [a, b, c, d];
        let (version, places, endian) = match (i32::from_le_bytes(size), i32::from_be_bytes(size)) {
            _ if found < 4 => return Err(context.truncated("header", 348, found as u64)),
            (348, _) => (1, &NIFTI_1, Endian::Little),
            (_, 348) => (1, &NIFTI_1, Endian::Big),
            (540, _) => (2, &NIFTI_2, Endian::Little),
            (_, 540) => (2, &NIFTI_2, Endian::Big),
            (little, _) => {
                return Err(context.field("sizeof_hdr", little, 0, "348 or 540, in either byte order"));
            }
        };
        let found = found + source.fill(&mut bytes[NIFTI_1.length..places.length], context)?;
        if found < places.length {
            return Err(context.truncated("header", places.length as u64, found as u64));
        }
        let fields = Fields {
            bytes: &bytes,
            endian,
            wide: version == 2,
        };
        fields.header(version, places, context)
    }

    /// Position of element `index` of the float array that starts at `place`.
    pub(super) fn float_place(&self, place: usize, index: usize) -> u64 {
        (place + index * if self.version == 2 { 8 } else { 4 }) as u64
    }
}

/// True for the name of a header that has its data in another file.
fn is_pair(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("hdr"))
}

/// The raw fields: sizes are 16 bits wide in NIfTI-1 and 64 in NIfTI-2, floats 32 and 64, codes 16 and 32.
struct Fields<'a> {
    bytes: &'a [u8; LONGEST],
    endian: Endian,
    wide: bool,
}

impl Fields<'_> {
    fn header(&self, version: u8, places: &'static Places, context: &Context<'_>) -> Result<Header, IoError> {
        if !self.wide && is_pair(context.path) && self.bytes[places.magic..places.magic + 4] == [0; 4] {
            return self.analyze(places, context);
        }
        let single = self.magic(version, places, context)?;
        self.fields(version, single, places, context)
    }

    /// Analyze 7.5, from which NIfTI-1 took the places of sizes, types and steps. Where NIfTI has its transforms, it has a
    /// history; lengths are millimetres; a scale is SPM's.
    fn analyze(&self, places: &'static Places, context: &Context<'_>) -> Result<Header, IoError> {
        Ok(Header {
            xyzt_units: 2,
            qform_code: 0,
            sform_code: 0,
            ..self.fields(0, false, places, context)?
        })
    }

    fn fields(
        &self,
        version: u8,
        single: bool,
        places: &'static Places,
        context: &Context<'_>,
    ) -> Result<Header, IoError> {
        Ok(Header {
            version,
            endian: self.endian,
            single,
            places,
            dim: std::array::from_fn(|i| self.size(places.dim, i)),
            datatype: i16::from_ne_bytes(self.array(places.datatype)),
            bitpix: i16::from_ne_bytes(self.array(places.bitpix)),
            pixdim: self.floats(places.pixdim),
            vox_offset: self.vox_offset(single, places, context)?,
            scl_slope: self.float(places.scl_slope, 0),
            scl_inter: self.float(places.scl_inter, 0),
            xyzt_units: if self.wide {
                i32::from_ne_bytes(self.array(places.xyzt_units))
            } else {
                i32::from(self.bytes[places.xyzt_units])
            },
            qform_code: self.code(places.qform_code),
            sform_code: self.code(places.sform_code),
            quatern: self.floats(places.quatern),
            qoffset: self.floats(places.qoffset),
            srow: self.floats(places.srow),
        })
    }

    /// True where the data are in the same file.
    fn magic(&self, version: u8, places: &Places, context: &Context<'_>) -> Result<bool, IoError> {
        let magic = &self.bytes[places.magic..places.magic + if self.wide { 8 } else { 4 }];
        match (version, magic) {
            (1, b"n+1\0") | (2, b"n+2\0\r\n\x1a\n") => Ok(true),
            (1, b"ni1\0") | (2, b"ni2\0\r\n\x1a\n") => Ok(false),
            (1, b"\0\0\0\0") => {
                Err(context.unsupported("no NIfTI magic number; Analyze 7.5 has a header (.hdr) of its own"))
            }
            _ => {
                let shown = String::from_utf8_lossy(magic);
                let expected = format!("\"n+{version}\" or \"ni{version}\"");
                Err(context.field("magic", shown, places.magic as u64, expected))
            }
        }
    }

    /// 0 stands for "right behind the header".
    fn vox_offset(&self, single: bool, places: &Places, context: &Context<'_>) -> Result<u64, IoError> {
        let offset = if self.wide {
            i64::from_ne_bytes(self.array(places.vox_offset)) as f64
        } else {
            self.float(places.vox_offset, 0)
        };
        let first = if single { places.length as u64 + 4 } else { 0 };
        if offset == 0.0 {
            return Ok(first);
        }
        let whole = offset.fract() == 0.0 && offset >= first as f64 && offset < i64::MAX as f64;
        if !whole {
            let expected = format!("a whole number of bytes, {first} or more");
            return Err(context.field("vox_offset", offset, places.vox_offset as u64, expected));
        }
        Ok(offset as u64)
    }

    /// `N` bytes in native order.
    fn array<const N: usize>(&self, place: usize) -> [u8; N] {
        let mut array: [u8; N] = std::array::from_fn(|i| self.bytes[place + i]);
        if self.endian != Endian::NATIVE {
            array.reverse();
        }
        array
    }

    fn size(&self, place: usize, index: usize) -> i64 {
        if self.wide {
            i64::from_ne_bytes(self.array(place + 8 * index))
        } else {
            i64::from(i16::from_ne_bytes(self.array(place + 2 * index)))
        }
    }

    fn code(&self, place: usize) -> i32 {
        if self.wide {
            i32::from_ne_bytes(self.array(place))
        } else {
            i32::from(i16::from_ne_bytes(self.array(place)))
        }
    }

    fn float(&self, place: usize, index: usize) -> f64 {
        if self.wide {
            f64::from_ne_bytes(self.array(place + 8 * index))
        } else {
            f64::from(f32::from_ne_bytes(self.array(place + 4 * index)))
        }
    }

    fn floats<const N: usize>(&self, place: usize) -> [f64; N] {
        std::array::from_fn(|i| self.float(place, i))
    }
}
