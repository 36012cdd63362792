//! What a browser needs to draw a picture's drafts itself: the engine for browsers, a document, and data that are made to fit.

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use splatvol_document::HeldContent;
use splatvol_page::{Bits, PageContent, PageError};

use crate::error::Raise;
use crate::picture::Picture;
use crate::work;

/// The engine, a WebAssembly module in gzip; `None` where the package was built without it.
#[pyfunction]
pub(crate) fn browser_engine(py: Python<'_>) -> Option<Bound<'_, PyBytes>> {
    let engine = splatvol_page::engine().ok()?;
    Some(PyBytes::new(py, engine))
}

/// A sentence where the engine was built of other sources than the package.
#[pyfunction]
pub(crate) fn browser_notice() -> Option<&'static str> {
    splatvol_page::outdated()
}

/// Bindings and module of the GPU engine for browsers, in gzip; `None` where the package was built without it.
#[pyfunction]
pub(crate) fn browser_gpu_engine(py: Python<'_>) -> Option<(Bound<'_, PyBytes>, Bound<'_, PyBytes>)> {
    let engine = splatvol_page::webgpu()?;
    Some((PyBytes::new(py, engine.bindings), PyBytes::new(py, engine.module)))
}

/// The script that asks instances of the engine for pictures.
#[pyfunction]
pub(crate) fn browser_script() -> &'static str {
    splatvol_page::ENGINE_SCRIPT
}

/// A document, JSON; what its bytes are, JSON; the packed data, gzip; and the lengths to which opacities refer, where items have any.
type Parts<'py> = (String, String, Bound<'py, PyBytes>, Vec<Option<f64>>);

/// What a browser draws of a picture, with at most so many bytes of data; `None` for what it cannot draw: volumes beyond memory, files of
/// effects, motion, and data that do not fit.
#[pyfunction]
pub(crate) fn browser_parts<'py>(
    py: Python<'py>,
    picture: &Bound<'py, Picture>,
    most: u64,
) -> PyResult<Option<Parts<'py>>> {
    let picture = &picture.get().picture;
    let Some(content) = PageContent::of(picture).ok() else {
        return Ok(None);
    };
    let in_chunks =
        |data: &HeldContent| matches!(data, HeldContent::Volume(volume) if volume.chunks().is_some());
    if content.data().any(in_chunks) {
        return Ok(None);
    }
    let fitted = match work::run(py, (None, None), |_| Ok(content.fit(&Bits::ROUNDED, most)))? {
        Err(PageError::TooLarge { .. }) => return Ok(None),
        fitted => fitted.map_err(Raise::raised)?,
    };
    let document = content.document(fitted.level, |_| "data".to_owned());
    let document = document.to_json(false).map_err(Raise::raised)?;
    let data = serde_json::to_string(&fitted.data).map_err(Raise::raised)?;
    let bytes = PyBytes::new(py, &fitted.bytes);
    Ok(Some((document, data, bytes, content.distances().to_vec())))
}
