//! The Python package `splatvol`: its part in Rust, the module `splatvol._core`.
//!
//! Python's part names things as Python's users do, and writes what they ask for as a document. Here the document is resolved
//! and rendered, as the command does it, so that both make the same bytes. Nothing else passes the border: documents as JSON,
//! arrays as memory that is shared ([`array`]), pictures as one buffer.
//!
//! | module | holds |
//! |---|---|
//! | [`data`] | data in memory: arrays, or files that were read |
//! | [`array`] | memory of arrays, as samples |
//! | [`picture`] | a document with its data, resolved, and how it is rendered |
//! | [`chunks`] | volumes that are read in chunks |
//! | [`frame`] | the picture: codes, floats, files |
//! | [`browser`] | what browsers need to draw drafts themselves |
//! | [`part`] | parts of pictures, by many processes |
//! | [`animation`] | frames of animations, and files of many frames |
//! | [`work`] | work without the interpreter's lock, that can be interrupted |
//! | [`engines`] | threads and renderers of the process |
//! | [`error`] | Rust's errors as the package's exceptions |

mod animation;
mod array;
mod browser;
mod chunks;
mod data;
mod engines;
mod error;
mod frame;
mod lazy;
mod part;
mod picture;
mod work;

use std::ffi::OsString;

use pyo3::prelude::*;
use splatvol::ColorMap;

/// Compiled part of the package `splatvol`.
#[pymodule]
mod _core {
    use super::*;

    #[pymodule_export]
    use super::animation::{Animation, Movie};
    #[pymodule_export]
    use super::browser::{browser_engine, browser_gpu_engine, browser_notice, browser_parts, browser_script};
    #[pymodule_export]
    use super::data::Data;
    #[pymodule_export]
    use super::engines::{set_threads, threads};
    #[pymodule_export]
    use super::frame::{Frame, read_picture};
    #[pymodule_export]
    use super::part::{assembled, blocks_of, part_of, paths_of, recipe_of};
    #[pymodule_export]
    use super::picture::{
        Picture, document_over, document_text, read_document, read_like, read_record, read_transfer_function,
        refusal, write_transfer_function,
    };
    #[pymodule_export]
    use super::work::Stop;

    /// Version of the package.
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "Python's name")]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    /// Runs the command `splatvol`, and returns its exit code. The first argument is the program's name.
    #[pyfunction]
    fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
        py.detach(|| splatvol_cli::run(arguments))
    }

    /// The JSON schema of documents.
    #[pyfunction]
    fn schema() -> String {
        splatvol_document::schema().as_value().to_string()
    }

    /// Names of the colour maps.
    #[pyfunction]
    fn colormaps() -> Vec<&'static str> {
        ColorMap::names().collect()
    }

    /// Colours of a map at so many places, sRGB; `None` where no map has the name.
    #[pyfunction]
    fn colormap(name: &str, count: usize) -> Option<Vec<[f64; 3]>> {
        let map = ColorMap::from_name(name).ok()?;
        let points = map.points([0.0, 1.0], count);
        Some(points.into_iter().map(|point| point.rgb).collect())
    }

    /// Names and texts of the built-in samples.
    #[pyfunction]
    fn samples() -> Vec<(&'static str, &'static str)> {
        let all = splatvol::samples::Sample::ALL;
        all.iter()
            .map(|sample| (sample.name(), sample.description()))
            .collect()
    }
}
