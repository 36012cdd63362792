//! Headers, compression and the table of streams.

use ruzstd::decoding::StreamingDecoder;

use super::super::collect::check_plausible;
use super::super::detect::SPZ_MAGIC;
use super::super::fields::Fields;
use super::super::frame::RUB;
use super::extensions;
use super::packed::{Packed, sizes};
use crate::error::Context;
use crate::source::{Codec, Source};
use crate::{IoError, ReadOptions};

/// Bytes of the header up to version 3, and of the fields that version 4 has in common with it.
const HEADER: u64 = 16;
/// Bytes of the header of version 4.
const HEADER_4: u64 = 32;
/// Highest degree of harmonics that the format has; 4 is read but not kept.
const MAX_DEGREE: u8 = 4;
const ANTIALIASED: u8 = 1;
const HAS_EXTENSIONS: u8 = 2;
/// Most extensions that are read.
const MAX_EXTENSIONS: u64 = 1 << 20;
/// A zstd block of 4 bytes decodes to 128 KiB at most.
const ZSTD_RATIO: u64 = 1 << 15;
/// Largest memory of a zstd stream, unless its contents are larger.
const ZSTD_WINDOW: u64 = 8 << 20;

/// The arrays of a file that starts with gzip or with the header itself.
pub(super) fn read(
    mut source: Source<'_>,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Packed, IoError> {
    let length = source.at_most();
    let gzip = source.peek(context)?.starts_with(&[0x1f, 0x8b]);
    if gzip {
        source = source.inflate(Codec::Gzip);
    }
    let bytes = source.read_bytes("header", HEADER, context)?;
    let header = Fields {
        bytes: &bytes,
        what: "header",
        context,
    };
    let mut packed = parse_header(&header, options)?;
    packed.coding = match (gzip, packed.version) {
        (true, _) => "gzip",
        (false, 4) => "zstd",
        (false, _) => "not compressed",
    };
    check_plausible(packed.count, length, context)?;
    let has_extensions = header.u8(14)? & HAS_EXTENSIONS != 0;
    if packed.version == 4 && !gzip {
        read_streams(&mut source, has_extensions, header.u8(15)?, &mut packed, context)?;
    } else {
        read_arrays(&mut source, has_extensions, &mut packed, context)?;
    }
    Ok(packed)
}

fn parse_header(header: &Fields<'_>, options: &ReadOptions) -> Result<Packed, IoError> {
    let context = header.context;
    let magic = header.slice(0, 4)?;
    if magic != SPZ_MAGIC {
        let found = String::from_utf8_lossy(magic).into_owned();
        return Err(context.field("magic", found, 0, "NGSP"));
    }
    let version = header.u32(4)?;
    if !(1..=4).contains(&version) {
        return Err(context.field("version", version, 4, "1 to 4"));
    }
    let degree = header.u8(12)?;
    if degree > MAX_DEGREE {
        return Err(context.field("shDegree", degree, 12, "0 to 4"));
    }
    let fractional_bits = header.u8(13)?;
    if fractional_bits > 24 {
        return Err(context.field("fractionalBits", fractional_bits, 13, "0 to 24"));
    }
    let (count, degree) = (u64::from(header.u32(8)?), u32::from(degree));
    let bytes = count.saturating_mul(sizes(version, degree).iter().sum());
    if bytes > options.max_bytes {
        return Err(context.limit(bytes, options.max_bytes));
    }
    Ok(Packed {
        version,
        count,
        degree,
        fractional_bits,
        antialiased: header.u8(14)? & ANTIALIASED != 0,
        coding: "",
        frame: RUB,
        harmonics_range: None,
        arrays: Default::default(),
        warnings: Vec::new(),
    })
}

/// Arrays one after the other, and extensions behind them.
fn read_arrays(
    source: &mut Source<'_>,
    has_extensions: bool,
    packed: &mut Packed,
    context: &Context<'_>,
) -> Result<(), IoError> {
    let sizes = sizes(packed.version, packed.degree).map(|size| size * packed.count);
    source.check_declared("arrays", sizes.iter().sum(), context)?;
    for (array, size) in packed.arrays.iter_mut().zip(sizes) {
        *array = source.read_bytes("arrays", size, context)?;
    }
    let mut rest = vec![0; MAX_EXTENSIONS as usize];
    let length = source.fill(&mut rest, context)?;
    rest.truncate(length);
    if has_extensions {
        let records = Fields {
            bytes: &rest,
            what: "extensions",
            context,
        };
        extensions::apply(&records, packed)?;
    } else if length > 0 {
        let warning = format!("{length} or more bytes follow the last array");
        packed.warnings.push(warning);
    }
    Ok(())
}

/// Version 4: after the first 16 bytes of the header.
fn read_streams(
    source: &mut Source<'_>,
    has_extensions: bool,
    stream_count: u8,
    packed: &mut Packed,
    context: &Context<'_>,
) -> Result<(), IoError> {
    let header = source.read_bytes("header", HEADER_4 - HEADER, context)?;
    let header = Fields {
        bytes: &header,
        what: "header",
        context,
    };
    let table_offset = u64::from(header.u32(0)?);
    if table_offset < HEADER_4 || table_offset - HEADER_4 > MAX_EXTENSIONS {
        let expected = format!("{HEADER_4} or up to {MAX_EXTENSIONS} bytes more");
        return Err(context.field("tocByteOffset", table_offset, 16, expected));
    }
    let records = source.read_bytes("extensions", table_offset - HEADER_4, context)?;
    if has_extensions {
        let records = Fields {
            bytes: &records,
            what: "extensions",
            context,
        };
        extensions::apply(&records, packed)?;
    }
    let sizes = sizes(4, packed.degree).map(|size| size * packed.count);
    let expected = if packed.degree == 0 { 5 } else { 6 };
    if stream_count != expected {
        let expected = format!("{expected}, for harmonics of degree {}", packed.degree);
        return Err(context.field("numStreams", stream_count, 15, expected));
    }
    let table = source.read_bytes("table of streams", 16 * u64::from(stream_count), context)?;
    let table = Fields {
        bytes: &table,
        what: "table of streams",
        context,
    };
    for index in 0..u64::from(stream_count) {
        let (compressed, length) = (table.u64(16 * index)?, table.u64(16 * index + 8)?);
        let size = sizes[index as usize];
        if length != size {
            let at = table_offset + 16 * index + 8;
            let expected = format!("{size}, for {} Gaussians", packed.count);
            return Err(context.field("uncompressedSize", length, at, expected));
        }
        packed.arrays[index as usize] = decompress(source, compressed, size, context)?;
    }
    match source.at_most() {
        0 => {}
        excess => packed
            .warnings
            .push(format!("{excess} bytes follow the last stream")),
    }
    Ok(())
}

/// One zstd stream.
fn decompress(
    source: &mut Source<'_>,
    compressed: u64,
    length: u64,
    context: &Context<'_>,
) -> Result<Vec<u8>, IoError> {
    let bytes = source.read_bytes("streams", compressed, context)?;
    let corrupt = |error| context.read(std::io::Error::new(std::io::ErrorKind::InvalidData, error));
    let decoder = StreamingDecoder::new_with_max_window_size(bytes.as_slice(), length.max(ZSTD_WINDOW))
        .map_err(corrupt)?;
    let at_most = compressed.saturating_mul(ZSTD_RATIO);
    let mut source = Source::bounded(decoder, at_most);
    let array = source.read_bytes("streams", length, context)?;
    match source.rest(context)? {
        crate::source::Rest::Nothing => Ok(array),
        crate::source::Rest::Excess => {
            Err(context.field("stream", "longer", None, format!("{length} bytes")))
        }
    }
}
