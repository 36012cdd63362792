//! Numbers of accessors (glTF 2.0, section 5.1).

use super::document::Document;
use crate::IoError;

/// Type of a component.
#[derive(Clone, Copy)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    F32,
}

impl Component {
    fn from_code(code: u64) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::F32 => 4,
        }
    }

    /// The largest value of a normalised component (section 3.6.2.2: `max(c / 127, -1)` and alike).
    fn one(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32767.0,
            Self::U16 => 65535.0,
            Self::F32 => 1.0,
        }
    }
}

/// Vectors of `N` components; scalars have one.
pub(super) fn read<const N: usize>(
    document: &Document<'_>,
    index: u64,
    name: &str,
) -> Result<Vec<[f64; N]>, IoError> {
    let context = document.context;
    let accessor = document.object("accessors", index)?;
    let wrong = |key: &str, expected: &str| {
        let value = accessor
            .get(key)
            .map_or_else(|| "(absent)".to_owned(), ToString::to_string);
        context.field(
            format!("accessors[{index}].{key} of {name}"),
            value,
            None,
            expected,
        )
    };
    let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
    if accessor.get("type").and_then(|value| value.as_str()) != Some(kind) {
        return Err(wrong("type", kind));
    }
    if accessor.get("sparse").is_some() {
        return Err(wrong("sparse", "no sparse accessor"));
    }
    let code = document.whole(accessor, "componentType")?;
    let component = code
        .and_then(Component::from_code)
        .ok_or_else(|| wrong("componentType", "5120 to 5123 or 5126"))?;
    let normalized = accessor.get("normalized").and_then(|value| value.as_bool()) == Some(true);
    let count = document
        .whole(accessor, "count")?
        .ok_or_else(|| wrong("count", "a count"))?;
    let view = document.whole(accessor, "bufferView")?;
    let (fields, stride) = document.view(view.ok_or_else(|| wrong("bufferView", "a buffer view"))?)?;
    let size = component.size() * N as u64;
    let stride = stride.unwrap_or(size);
    if stride < size {
        return Err(wrong(
            "type",
            "vectors no longer than the byteStride of their view",
        ));
    }
    let offset = document.whole(accessor, "byteOffset")?.unwrap_or(0);
    let length = count
        .saturating_sub(1)
        .saturating_mul(stride)
        .saturating_add(size);
    if count > 0 {
        fields.slice(offset, length)?;
    }
    let number = |at: u64| {
        let value = match component {
            Component::I8 => f64::from(fields.u8(at)? as i8),
            Component::U8 => f64::from(fields.u8(at)?),
            Component::I16 => f64::from(fields.u16(at)? as i16),
            Component::U16 => f64::from(fields.u16(at)?),
            Component::F32 => f64::from(fields.f32(at)?),
        };
        Ok::<_, IoError>(if normalized {
            (value / component.one()).max(-1.0)
        } else {
            value
        })
    };
    let mut vectors = Vec::with_capacity(count as usize);
    for element in 0..count {
        let mut vector = [0.0; N];
        for (i, value) in (0..).zip(&mut vector) {
            *value = number(offset + element * stride + i * component.size())?;
        }
        vectors.push(vector);
    }
    Ok(vectors)
}
