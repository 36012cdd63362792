//! Fill values of arrays.

use serde_json::Value;

use crate::error::Context;
use crate::samples::Endian;
use crate::{IoError, SampleType};

/// The value of samples that no chunk holds, as metadata state it.
pub(super) struct FillValue<'a> {
    stated: Option<&'a Value>,
    context: &'a Context<'a>,
}

impl<'a> FillValue<'a> {
    /// Of an array's metadata.
    pub(super) fn new(metadata: &'a Value, context: &'a Context<'a>) -> Self {
        Self {
            stated: metadata.get("fill_value"),
            context,
        }
    }

    /// The bytes of a sample that no chunk holds: a number, `NaN`, `Infinity`, or the sample's bits in hexadecimal
    /// digits (Zarr 3 core, "Fill value").
    pub(super) fn bytes(
        &self,
        sample_type: SampleType,
        half: bool,
        endian: Endian,
    ) -> Result<Vec<u8>, IoError> {
        let stated = self.stated;
        let bad = || {
            let shown = stated.map(Value::to_string).unwrap_or_default();
            let expected = "a number that fits the samples' type";
            self.context.field("fill_value", shown, None, expected)
        };
        let value = match stated {
            None | Some(Value::Null) => 0.0,
            Some(Value::Bool(value)) => f64::from(u8::from(*value)),
            Some(Value::Number(number)) => match whole(number, sample_type).filter(|_| !half) {
                Some(bits) => return Ok(ordered(bits.to_le_bytes()[..sample_type.size()].to_vec(), endian)),
                None => number.as_f64().ok_or_else(bad)?,
            },
            Some(Value::String(text)) => match text.as_str() {
                "NaN" => f64::NAN,
                "Infinity" => f64::INFINITY,
                "-Infinity" => f64::NEG_INFINITY,
                text => {
                    let digits = text.strip_prefix("0x").ok_or_else(bad)?;
                    let bits = u64::from_str_radix(digits, 16).map_err(|_| bad())?;
                    if digits.len() != 2 * sample_type.size() {
                        return Err(bad());
                    }
                    return Ok(ordered(bits.to_le_bytes()[..sample_type.size()].to_vec(), endian));
                }
            },
            Some(_) => return Err(bad()),
        };
        let bytes = match sample_type {
            _ if half => half::f16::from_f64(value).to_le_bytes().to_vec(),
            SampleType::F32 => (value as f32).to_le_bytes().to_vec(),
            SampleType::F64 => value.to_le_bytes().to_vec(),
            // A whole number in decimal point form, such as 0.0.
            integer => {
                let bits = (value.fract() == 0.0 && value.abs() < EXACT).then_some(value as i64);
                let number = serde_json::Number::from(bits.ok_or_else(bad)?);
                let bits = whole(&number, integer).ok_or_else(bad)?;
                bits.to_le_bytes()[..integer.size()].to_vec()
            }
        };
        Ok(ordered(bytes, endian))
    }
}

/// Whole numbers below this are exact in 64-bit reals.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// The bits of a whole number that fits an integer type; `None` for other numbers and types.
fn whole(number: &serde_json::Number, sample_type: SampleType) -> Option<u64> {
    let bits = 8 * sample_type.size() as u32;
    match sample_type {
        SampleType::U8 | SampleType::U16 | SampleType::U32 | SampleType::U64 => {
            number.as_u64().filter(|&n| bits == 64 || n >> bits == 0)
        }
        SampleType::I8 | SampleType::I16 | SampleType::I32 | SampleType::I64 => {
            let most = i64::MAX >> (64 - bits);
            number
                .as_i64()
                .filter(|n| (-most - 1..=most).contains(n))
                .map(|n| n as u64)
        }
        _ => None,
    }
}

fn ordered(mut little_endian: Vec<u8>, endian: Endian) -> Vec<u8> {
    if endian == Endian::Big {
        little_endian.reverse();
    }
    little_endian
}
