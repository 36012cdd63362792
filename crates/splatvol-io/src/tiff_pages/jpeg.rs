//! Strips and tiles of JPEG (TIFF technical note 2): streams that may lack the tables, which are stored once.

use jpeg_decoder::{ColorTransform, Decoder};

use crate::IoError;
use crate::error::Context;

/// Marks at the start and the end of a stream.
const START: [u8; 2] = [0xff, 0xd8];
const END: [u8; 2] = [0xff, 0xd9];
/// Colours in luminance and chrominance (`PhotometricInterpretation`), and red, green, blue.
const YCBCR: u64 = 6;
const RGB: u64 = 2;

/// The form that a stream must have.
#[derive(Debug, Clone, Copy)]
pub(super) struct Form {
    /// Columns and rows.
    pub(super) size: [usize; 2],
    pub(super) components: usize,
    /// `PhotometricInterpretation`.
    pub(super) photometric: u64,
}

/// Interleaved samples of a byte.
pub(super) fn decode(
    coded: &[u8],
    tables: &[u8],
    form: Form,
    context: &Context<'_>,
) -> Result<Vec<u8>, IoError> {
    let corrupt = |error: jpeg_decoder::Error| {
        context.read(std::io::Error::new(std::io::ErrorKind::InvalidData, error))
    };
    let tables = tables.strip_suffix(&END).unwrap_or(tables);
    let stream = match tables.is_empty() {
        true => coded.to_vec(),
        false => [tables, coded.strip_prefix(&START).unwrap_or(coded)].concat(),
    };
    let mut decoder = Decoder::new(&*stream);
    match (form.photometric, form.components) {
        (YCBCR, 3) => decoder.set_color_transform(ColorTransform::YCbCr),
        (RGB, 3) => decoder.set_color_transform(ColorTransform::RGB),
        _ => {}
    }
    decoder.read_info().map_err(corrupt)?;
    let info = decoder.info().ok_or_else(|| context.truncated("JPEG", 1, 0))?;
    let (columns, rows) = (usize::from(info.width), usize::from(info.height));
    let (components, [wide, high]) = (info.pixel_format.pixel_bytes(), form.size);
    if (columns, components) != (wide, form.components)
        || rows < high
        || rows > high.saturating_add(high) + 64
    {
        let found = format!("{columns} x {rows}, {components} bytes per pixel");
        let expected = format!("{wide} x {high}, {} samples of a byte", form.components);
        return Err(context.field("form of a strip or tile of JPEG", found, None, expected));
    }
    let mut bytes = crate::jpeg::decode(&mut decoder, context)?;
    bytes.truncate(wide * high * components);
    Ok(bytes)
}
