//! Memory of arrays, as samples that are not copied.
//!
//! An array's owner may write to it later, from Python or from C, whatever its flags say. Rust's slices promise that nobody does,
//! so the package asks its users for what numpy's own bindings ask: not to write to an array while a picture of it is made.
//! Samples are plain numbers, of which every bit pattern is valid; a torn one is a wrong sample, and nothing else.

use std::slice;

use pyo3::buffer::{Element, PyBuffer};
use pyo3::prelude::*;
use splatvol::{Samples, Storage};

use crate::error::refused;

/// Memory of an array in C order, and the array that it belongs to.
struct Borrowed<T: Element>(PyBuffer<T>);

impl<T: Element> AsRef<[T]> for Borrowed<T> {
    #[expect(unsafe_code, reason = "memory of another language's array is read as a slice")]
    fn as_ref(&self) -> &[T] {
        let first = self.0.buf_ptr().cast::<T>().cast_const();
        if self.0.item_count() == 0 {
            return &[];
        }
        // SAFETY: `borrow` has checked that the buffer is contiguous, has items of the type `T` and aligned addresses. The
        // view keeps its memory alive as long as `self`. That nobody writes to it meanwhile is the package's documented
        // contract, as of the module's head.
        unsafe { slice::from_raw_parts(first, self.0.item_count()) }
    }
}

/// The memory of an array of this type in C order.
fn borrow<T: Element + Send + Sync + 'static>(array: &Bound<'_, PyAny>) -> PyResult<Storage<T>> {
    let buffer = PyBuffer::<T>::get(array)?;
    if !buffer.is_c_contiguous() || !buffer.buf_ptr().cast::<T>().is_aligned() {
        return Err(refused(
            "array",
            "the array is not contiguous in C order and aligned",
        ));
    }
    Ok(Storage::shared(std::sync::Arc::new(Borrowed(buffer))))
}

/// Samples of an array in C order, of a type that numpy calls so: `uint8`, `float32`...
pub(crate) fn samples(array: &Bound<'_, PyAny>, type_name: &str) -> PyResult<Samples> {
    Ok(match type_name {
        "uint8" => Samples::U8(borrow(array)?),
        "int8" => Samples::I8(borrow(array)?),
        "uint16" => Samples::U16(borrow(array)?),
        "int16" => Samples::I16(borrow(array)?),
        "uint32" => Samples::U32(borrow(array)?),
        "int32" => Samples::I32(borrow(array)?),
        "float32" => Samples::F32(borrow(array)?),
        "float64" => Samples::F64(borrow(array)?),
        other => {
            let message = format!("dtype {other} is not allowed (8 to 32 bits, whole or not, or float64)");
            return Err(refused("dtype", message));
        }
    })
}

/// Rows of `N` numbers, copied.
pub(crate) fn rows<T: Element + Default, const N: usize>(array: &Bound<'_, PyAny>) -> PyResult<Vec<[T; N]>> {
    let numbers = PyBuffer::<T>::get(array)?.to_vec(array.py())?;
    let (rows, rest) = numbers.as_chunks::<N>();
    match rest {
        [] => Ok(rows.to_vec()),
        _ => Err(refused("array", format!("the array has no rows of {N} numbers"))),
    }
}

/// Numbers, copied.
pub(crate) fn numbers<T: Element>(array: &Bound<'_, PyAny>) -> PyResult<Vec<T>> {
    PyBuffer::<T>::get(array)?.to_vec(array.py())
}
