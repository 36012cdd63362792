//! JPEG by the crate `jpeg-decoder`.

use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};

use jpeg_decoder::Decoder;

use crate::IoError;
use crate::error::Context;

/// The pixels. The decoder is not written for hostile files; a panic in it is blamed on the file.
pub(crate) fn decode<R: Read>(decoder: &mut Decoder<R>, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    let corrupt = |error: Box<dyn std::error::Error + Send + Sync>| {
        context.read(std::io::Error::new(std::io::ErrorKind::InvalidData, error))
    };
    match catch_unwind(AssertUnwindSafe(|| decoder.decode())) {
        Ok(decoded) => decoded.map_err(|error| corrupt(error.into())),
        Err(_) => Err(corrupt("undecodable JPEG".into())),
    }
}
