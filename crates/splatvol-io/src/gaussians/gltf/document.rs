//! The JSON of a glTF file and its buffers.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use super::super::fields::Fields;
use crate::error::Context;
use crate::source::{companion, read_file};
use crate::{IoError, ReadOptions, json};

/// Bytes before the first chunk of a `.glb`, and of a chunk before its data.
const HEADER: u64 = 12;
const CHUNK_HEADER: u64 = 8;
const JSON_CHUNK: u32 = 0x4E4F_534A;
const BINARY_CHUNK: u32 = 0x004E_4942;
/// Most buffers that are read.
const MAX_BUFFERS: usize = 256;

/// JSON and, in a `.glb`, the binary chunk.
pub(super) fn parse(path: &Path, context: &Context<'_>) -> Result<(Value, Option<Vec<u8>>), IoError> {
    let bytes = read_file(path, context)?;
    if !bytes.starts_with(b"glTF") {
        return Ok((json::parse(&bytes, context)?, None));
    }
    let fields = Fields {
        bytes: &bytes,
        what: "chunks",
        context,
    };
    let version = fields.u32(4)?;
    if version != 2 {
        return Err(context.field("version", version, 4, "2"));
    }
    let (kind, length) = (fields.u32(HEADER + 4)?, u64::from(fields.u32(HEADER)?));
    if kind != JSON_CHUNK {
        return Err(context.field(
            "type of the first chunk",
            format!("{kind:#x}"),
            HEADER + 4,
            "JSON",
        ));
    }
    let start = HEADER + CHUNK_HEADER;
    let document = json::parse(fields.slice(start, length)?, context)?;
    let at = start + length;
    if at + CHUNK_HEADER > bytes.len() as u64 || fields.u32(at + 4)? != BINARY_CHUNK {
        return Ok((document, None));
    }
    let binary = fields.slice(at + CHUNK_HEADER, u64::from(fields.u32(at)?))?;
    Ok((document, Some(binary.to_vec())))
}

/// A document with all its buffers.
pub(super) struct Document<'a> {
    pub(super) json: Value,
    buffers: Vec<Vec<u8>>,
    /// Files that hold buffers.
    pub(super) files: Vec<PathBuf>,
    pub(super) context: &'a Context<'a>,
}

/// Buffers that may name the same file, on average: each holds its bytes.
const MOST_REPEATED: usize = 4;

impl<'a> Document<'a> {
    pub(super) fn open(
        path: &Path,
        options: &ReadOptions,
        context: &'a Context<'a>,
    ) -> Result<Self, IoError> {
        let (json, mut binary) = parse(path, context)?;
        let listed = json.get("buffers").and_then(Value::as_array);
        let listed = listed.map_or(&[][..], Vec::as_slice);
        if listed.len() > MAX_BUFFERS {
            let expected = format!("at most {MAX_BUFFERS}");
            return Err(context.field("buffers", listed.len(), None, expected));
        }
        let mut buffers = Vec::with_capacity(listed.len());
        let mut files = Vec::new();
        let mut total = 0;
        for (index, buffer) in listed.iter().enumerate() {
            let bytes = match (buffer.get("uri").and_then(Value::as_str), &mut binary) {
                (Some(uri), _) => read_uri(uri, &mut files, context)?,
                (None, binary) if index == 0 => binary.take().unwrap_or_default(),
                (None, _) => Vec::new(),
            };
            total += bytes.len() as u64;
            if total > options.max_bytes {
                return Err(context.limit(total, options.max_bytes));
            }
            let distinct: BTreeSet<&PathBuf> = files.iter().collect();
            if files.len() > MOST_REPEATED * distinct.len().max(1) {
                let found = format!("{} buffers of {} files", files.len(), distinct.len());
                return Err(context.field("buffers", found, None, "a file of its own for each"));
            }
            buffers.push(bytes);
        }
        Ok(Self {
            json,
            buffers,
            files,
            context,
        })
    }

    /// Bytes in all buffers.
    pub(super) fn bytes(&self) -> usize {
        self.buffers.iter().map(Vec::len).sum()
    }

    /// An element of one of the arrays of the document.
    pub(super) fn object(&self, array: &str, index: u64) -> Result<&Value, IoError> {
        let found = self.json.get(array).and_then(|array| array.get(index as usize));
        found.ok_or_else(|| {
            let name = format!("{array}[{index}]");
            self.context.field(name, "(absent)", None, "an object")
        })
    }

    /// The bytes of a buffer view, and its stride.
    pub(super) fn view(&self, index: u64) -> Result<(Fields<'_>, Option<u64>), IoError> {
        let view = self.object("bufferViews", index)?;
        let buffer = self.whole(view, "buffer")?.unwrap_or(0);
        let bytes = self.buffers.get(buffer as usize).ok_or_else(|| {
            let name = format!("bufferViews[{index}].buffer");
            self.context.field(name, buffer, None, "a buffer of the document")
        })?;
        let fields = Fields {
            bytes,
            what: "buffer",
            context: self.context,
        };
        let offset = self.whole(view, "byteOffset")?.unwrap_or(0);
        let length = self.whole(view, "byteLength")?.unwrap_or(0);
        let part = Fields {
            bytes: fields.slice(offset, length)?,
            what: "buffer view",
            ..fields
        };
        Ok((part, self.whole(view, "byteStride")?))
    }

    /// A whole number of an object, if it is there.
    pub(super) fn whole(&self, object: &Value, key: &str) -> Result<Option<u64>, IoError> {
        let Some(value) = object.get(key) else {
            return Ok(None);
        };
        let number = value.as_u64();
        let number = number.ok_or_else(|| self.context.field(key, value, None, "a whole number"));
        number.map(Some)
    }
}

fn read_uri(uri: &str, files: &mut Vec<PathBuf>, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
        return encoded
            .and_then(|encoded| STANDARD.decode(encoded).ok())
            .ok_or_else(|| context.field("uri", uri, None, "data in base64"));
    }
    let path = companion(uri, "uri", None, context)?;
    let bytes = read_file(&path, context)?;
    files.push(path);
    Ok(bytes)
}
