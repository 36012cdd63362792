//! Numbers of accessors (glTF 2.0, section 5.1).

use serde_json::Value;

use super::document::Document;
use crate::IoError;

/// Type of a component.
#[derive(Clone, Copy)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    /// Of indices only.
    U32,
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
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The largest value of a normalised component (section 3.6.2.2: `max(c / 127, -1)` and alike).
    fn one(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32767.0,
            Self::U16 => 65535.0,
            Self::U32 => f64::from(u32::MAX),
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
    let code = document.whole(accessor, "componentType")?;
    let component = code
        .and_then(Component::from_code)
        .ok_or_else(|| wrong("componentType", "5120 to 5123 or 5126"))?;
    let normalized = accessor.get("normalized").and_then(|value| value.as_bool()) == Some(true);
    let count = document
        .whole(accessor, "count")?
        .ok_or_else(|| wrong("count", "a count"))?;
    let view = document.whole(accessor, "bufferView")?;
    let sparse = accessor.get("sparse");
    let kind = (component, normalized);
    let mut vectors = match (view, sparse) {
        (Some(view), _) => {
            let stride = Stride {
                view,
                offset: document.whole(accessor, "byteOffset")?.unwrap_or(0),
                tight: false,
            };
            vectors(document, &stride, count, kind)?
        }
        // All that the sparse part does not replace is zero.
        (None, Some(_)) if count <= document.bytes() as u64 => vec![[0.0; N]; count as usize],
        (None, Some(_)) => return Err(wrong("count", "no more elements than the document has bytes")),
        (None, None) => return Err(wrong("bufferView", "a buffer view")),
    };
    if let Some(sparse) = sparse {
        replace(document, sparse, kind, &mut vectors)?;
    }
    Ok(vectors)
}

/// Where vectors begin, and whether they follow each other.
struct Stride {
    view: u64,
    offset: u64,
    /// True where the view's own stride does not count.
    tight: bool,
}

/// Vectors of a buffer view.
fn vectors<const N: usize>(
    document: &Document<'_>,
    place: &Stride,
    count: u64,
    (component, normalized): (Component, bool),
) -> Result<Vec<[f64; N]>, IoError> {
    let (fields, stride) = document.view(place.view)?;
    let offset = place.offset;
    let size = component.size() * N as u64;
    let stride = stride.filter(|_| !place.tight).unwrap_or(size);
    if stride < size {
        let name = format!("bufferViews[{}].byteStride", place.view);
        let expected = format!("at least the {size} bytes of a vector");
        return Err(document.context.field(name, stride, None, expected));
    }
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
            Component::U32 => f64::from(fields.u32(at)?),
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

/// Puts the elements of a sparse part in their places (glTF 2.0, section 5.2).
fn replace<const N: usize>(
    document: &Document<'_>,
    sparse: &Value,
    kind: (Component, bool),
    vectors: &mut [[f64; N]],
) -> Result<(), IoError> {
    let context = document.context;
    let wrong = |key: &str, expected: &str| context.field(format!("sparse.{key}"), sparse, None, expected);
    let count = document
        .whole(sparse, "count")?
        .ok_or_else(|| wrong("count", "a count"))?;
    let part = |key: &str| {
        let part = sparse.get(key).ok_or_else(|| wrong(key, "indices and values"))?;
        let view = document.whole(part, "bufferView")?;
        let place = Stride {
            view: view.ok_or_else(|| wrong(key, "a buffer view"))?,
            offset: document.whole(part, "byteOffset")?.unwrap_or(0),
            tight: true,
        };
        Ok::<_, IoError>((place, document.whole(part, "componentType")?))
    };
    let (place, values) = (part("indices")?, part("values")?.0);
    let component = match place.1 {
        Some(5125) => Some(Component::U32),
        Some(code @ (5121 | 5123)) => Component::from_code(code),
        _ => None,
    };
    let component = component.ok_or_else(|| wrong("indices.componentType", "5121, 5123 or 5125"))?;
    let indices = self::vectors::<1>(document, &place.0, count, (component, false))?;
    let values = self::vectors::<N>(document, &values, count, kind)?;
    let length = vectors.len();
    for ([index], value) in indices.into_iter().zip(values) {
        let target = vectors.get_mut(index as usize);
        *target.ok_or_else(|| context.field("sparse.indices", index, None, format!("below {length}")))? =
            value;
    }
    Ok(())
}
