//! PLY, the Stanford polygon format (Greg Turk 1994, "The PLY Polygon File Format"): the container of points and of
//! 3-D Gaussians.
//!
//! Elements and properties come in any number, order and type, in text or in binary of either byte order. [`Reader`]
//! hands the wanted columns to a closure row by row, in `f64`, which holds every PLY type exactly; nothing else is
//! kept, so memory depends only on what the caller keeps. Lists that nobody asks for are skipped. Before an element is read, its count is
//! checked against the bytes that are left.

mod header;
mod reader;

pub(crate) use header::{Element, Encoding, Header, Scalar};
pub(crate) use reader::{Reader, Table};
