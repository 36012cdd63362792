//! Parts of pictures: made by any process from a recipe, and put together by one.

use std::path::Path;

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use splatvol::{ImageSize, TileRect};
use splatvol_document::Document;
use splatvol_io::{Assembly, Part, PartKey, PartOrigin, PictureBlock, state_of_files};

use crate::engines::Turn;
use crate::error::{Raise, refused};
use crate::frame::Frame;
use crate::picture::{Picture, draw};
use crate::work::{self, Stop};

/// What errors call a part that is no file.
const NAME: &str = "part";

/// The recipe of a picture's parts, JSON: nothing is left open, and paths lead to files from any folder.
#[pyfunction]
pub(crate) fn recipe_of(picture: &Picture) -> PyResult<String> {
    let document = picture.picture.document.clone().absolute();
    document.to_json(false).map_err(Raise::raised)
}

/// The files that a recipe names; samples have none.
#[pyfunction]
pub(crate) fn paths_of(recipe: &str) -> PyResult<Vec<String>> {
    let document = Document::from_json(recipe, "recipe".as_ref()).map_err(Raise::raised)?;
    Ok(document.paths().into_iter().map(str::to_owned).collect())
}

/// The keys of the blocks of so many pixels along an edge that make up a picture.
#[pyfunction]
pub(crate) fn blocks_of(size: (u32, u32), edge: u32) -> PyResult<Vec<String>> {
    let size = ImageSize::new(size.0, size.1).map_err(Raise::raised)?;
    let blocks = PictureBlock::all(size, edge);
    Ok(blocks.iter().map(PictureBlock::to_string).collect())
}

/// Makes the part of a key: `X,Y,WIDTHxHEIGHT` or `I/N`.
#[pyfunction]
#[pyo3(signature = (picture, key, stop = None, progress = None))]
pub(crate) fn part_of<'py>(
    py: Python<'py>,
    picture: &Picture,
    key: &str,
    stop: Option<&Stop>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyBytes>> {
    let picture = &picture.picture;
    let size = picture.settings.size;
    let parsed: PartKey = key
        .parse()
        .map_err(|error| refused("key", format!("key: {error}")))?;
    let block = parsed.block(size).ok_or_else(|| {
        let [width, height] = <[u32; 2]>::from(size);
        refused(
            "key",
            format!("key: a picture of {width}x{height} has no block {key}"),
        )
    })?;
    let recipe = picture.document.to_json(false).map_err(Raise::raised)?;
    let files = state_of_files(&picture.files).map_err(Raise::raised)?;
    let _turn = Turn::wait_for(py, &picture.scene)?;
    let bytes = work::run(py, (stop, progress.as_ref()), |watch| {
        let [x0, y0] = [block.x, block.y].map(|first| first as usize);
        let rectangle = TileRect {
            x0,
            y0,
            x1: x0 + block.width as usize,
            y1: y0 + block.height as usize,
        };
        let (frame, statistics) = draw(picture, Some(rectangle), watch)?;
        let origin = PartOrigin {
            recipe,
            files,
            simd: statistics.simd,
            holes: statistics.chunks.holes,
        };
        let part = Part::new(&frame, (size, block), origin).map_err(Raise::raised)?;
        part.to_bytes().map_err(Raise::raised)
    })?;
    Ok(PyBytes::new(py, &bytes))
}

/// Puts parts together: the picture, its document, and its lost chunks.
#[pyfunction]
pub(crate) fn assembled(py: Python<'_>, parts: Vec<Vec<u8>>) -> PyResult<(Frame, String, u64)> {
    py.detach(|| {
        let path = Path::new(NAME);
        let mut assembly: Option<Assembly> = None;
        for bytes in &parts {
            assembly = Some(Assembly::joined(assembly, bytes, path).map_err(Raise::raised)?);
        }
        let assembly = assembly.ok_or_else(|| refused("parts", "parts: at least one is needed"))?;
        let recipe = assembly.recipe().to_owned();
        let document = Document::from_json(&recipe, "recipe".as_ref()).map_err(Raise::raised)?;
        let background = document
            .background
            .and_then(splatvol_document::keys::Background::color);
        let holes = assembly.holes();
        let frame = assembly.finish().map_err(Raise::raised)?;
        Ok((Frame::new(frame, background), recipe, holes))
    })
}
