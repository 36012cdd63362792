//! Terrain: a table of heights, with a picture draped over it, as points.
//!
//! | file | what it gives |
//! |---|---|
//! | USGS DEM | heights, posts in metres of a map or in arc seconds, gaps |
//! | `GeoTIFF` | heights of any type, posts by pixel scale and tie point, `GDAL_NODATA` |
//! | table of text | one row of heights per line; the first row is the south |
//! | `.npy`, raw with its layout | heights; the first row is the north |
//!
//! World space has x to the east, y to the north, z up.

mod dem;
mod drape;
mod geotiff;
mod posts;
mod surface;
mod table;

use std::path::{Path, PathBuf};

use glam::DVec2;

use super::LoadedPoints;
use crate::error::Context;
use crate::source::Source;
use crate::volume::dicom;
use crate::{Description, IoError, RawLayout, ReadOptions, volume};

pub(super) use drape::picture;

/// Order of the rows in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowOrder {
    /// The first row is the northernmost, as in pictures.
    NorthFirst,
    /// The first row is the southernmost.
    SouthFirst,
}

/// Options for reading terrain.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightFieldOptions {
    /// Layout of a headerless file, of dims `[columns, rows, 1]`; its spacing is that of the posts.
    pub raw: Option<RawLayout>,
    /// World length between the file's columns and rows; replaces the file's.
    pub spacing: Option<[f64; 2]>,
    /// World length per unit of height; replaces the file's.
    pub height_scale: Option<f64>,
    /// Vertical exaggeration of heights: 1 is true to scale.
    pub exaggeration: f64,
    /// Order of rows, for files that do not record it.
    pub rows: Option<RowOrder>,
    /// Value that marks gaps, besides those that the file names and NaN.
    pub missing: Option<f64>,
    /// Posts to the east and to the north that heights are interpolated to, at least 2 each: a picture finer than the
    /// heights keeps its detail.
    pub posts: Option<[usize; 2]>,
    /// Picture of the same area, north at its top: PNG, JPEG or EXR.
    pub color_image: Option<PathBuf>,
    /// Turn warnings into errors.
    pub strict: bool,
    /// Most bytes that the points may take in memory.
    pub max_bytes: u64,
}

impl Default for HeightFieldOptions {
    fn default() -> Self {
        Self {
            raw: None,
            spacing: None,
            height_scale: None,
            exaggeration: 1.0,
            rows: None,
            missing: None,
            posts: None,
            color_image: None,
            strict: false,
            max_bytes: ReadOptions::default().max_bytes,
        }
    }
}

/// Relief, as share of the longer side, beyond which heights without a unit are scaled down.
const STEEPEST: f64 = 0.5;
/// Relief that they get.
const SCALED: f64 = 0.15;

/// A table with more columns than this is not a list of points.
const WIDE: usize = 16;

/// Whether a file is recognisably terrain: a USGS DEM, a georeferenced TIFF, a table of more columns than points have.
pub(crate) fn is_terrain(path: &Path, is_volume: bool) -> Result<bool, IoError> {
    let context = Context::new("height field", path);
    let mut source = Source::open(path)?;
    let mut start = vec![0; 4096];
    let length = source.fill(&mut start, &context)?;
    start.truncate(length);
    Ok(match start.as_slice() {
        start if dicom::says_dicm(start) => false,
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => geotiff::is_geotiff(path),
        _ => !is_volume && (dem::is_dem(&start) || is_wide_table(&start)),
    })
}

/// Whether the first line is numbers, very many.
fn is_wide_table(start: &[u8]) -> bool {
    let line = start.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let Ok(line) = str::from_utf8(line.trim_ascii_end()) else {
        return false;
    };
    let words: Vec<&str> = line
        .split(|c: char| c.is_whitespace() || ",;".contains(c))
        .filter(|word| !word.is_empty())
        .collect();
    // The last one may be cut off by the end of the examined bytes.
    words.len() > WIDE
        && words[..words.len() - 1]
            .iter()
            .all(|word| word.parse::<f64>().is_ok())
}

/// Heights on a grid of posts; row 0 is the south.
#[derive(Debug, Clone, PartialEq)]
struct HeightField {
    /// Posts to the east and to the north.
    dims: [usize; 2],
    /// Heights, west to east, then south to north; NaN in gaps.
    heights: Vec<f64>,
    /// World place of the south-western post.
    origin: DVec2,
    /// World lengths between posts, above zero.
    spacing: DVec2,
    /// World length per unit of height.
    height_scale: f64,
    /// Whether the file gives its size.
    measured: bool,
}

impl HeightField {
    /// Reverses the rows if the first is the north.
    fn south_first(&mut self, order: RowOrder) {
        if order == RowOrder::NorthFirst {
            let [width, height] = self.dims;
            for row in 0..height / 2 {
                let (low, high) = self.heights.split_at_mut((height - 1 - row) * width);
                low[row * width..(row + 1) * width].swap_with_slice(&mut high[..width]);
            }
        }
    }

    /// Smallest and largest height, if there are any.
    fn range(&self) -> Option<[f64; 2]> {
        let finite = self.heights.iter().copied().filter(|h| h.is_finite());
        finite.fold(None, |range, h| {
            Some(range.map_or([h, h], |[low, high]: [f64; 2]| [low.min(h), high.max(h)]))
        })
    }
}

/// Reads terrain as points: one per post and more on steep faces, with normals, radii, and colours of the picture.
///
/// # Errors
/// See [`IoError`]; heights that are all missing, or so large beside the posts' distance that faces would need more
/// than a hundred points per post.
pub fn read_height_field(
    path: impl AsRef<Path>,
    options: &HeightFieldOptions,
) -> Result<LoadedPoints, IoError> {
    let path = path.as_ref();
    let context = &Context::new("height field", path);
    check_options(options, context)?;
    let (mut field, mut description) = read(path, options, context)?;
    for height in &mut field.heights {
        if !height.is_finite() || options.missing == Some(*height) {
            *height = f64::NAN;
        }
    }
    let Some(range) = field.range() else {
        return Err(context.field("heights", "none", None, "at least one that is not missing"));
    };
    if let Some([x, y]) = options.spacing {
        field.origin *= DVec2::new(x, y) / field.spacing;
        field.spacing = DVec2::new(x, y);
    }
    if let Some(dims) = options.posts {
        field = field.interpolated(dims, options.max_bytes, context)?;
    }
    scale_heights(&mut field, range, options, &mut description);
    let missing = field.heights.iter().filter(|h| h.is_nan()).count();
    let [width, height] = field.dims;
    description.stored_type = format!(
        "{}; {width} x {height} posts, heights {} to {}, {missing} missing",
        description.stored_type, range[0], range[1]
    );
    let colors = match &options.color_image {
        None => Vec::new(),
        Some(picture) => {
            description.files.push(picture.clone());
            drape::colors(picture, field.dims)?
        }
    };
    let points = surface::points(&field, &colors, options.max_bytes, context)?;
    let loaded = LoadedPoints {
        points,
        description,
        viewpoint: None,
    };
    loaded.checked(options.strict, path)
}

fn check_options(options: &HeightFieldOptions, context: &Context<'_>) -> Result<(), IoError> {
    let lengths = options
        .spacing
        .into_iter()
        .flatten()
        .chain(options.height_scale)
        .chain([options.exaggeration]);
    match lengths
        .into_iter()
        .find(|length| !(length.is_finite() && *length > 0.0))
    {
        Some(length) => Err(context.field("spacing or scale", length, None, "finite and above zero")),
        None => Ok(()),
    }
}

/// Heights in the unit of the posts' distances, exaggerated.
fn scale_heights(
    field: &mut HeightField,
    [low, high]: [f64; 2],
    options: &HeightFieldOptions,
    description: &mut Description,
) {
    let [width, height] = field.dims;
    let side = (field.spacing * DVec2::new(width as f64, height as f64)).max_element();
    match options.height_scale {
        Some(scale) => field.height_scale = scale,
        None if !field.measured && (high - low) * field.height_scale > STEEPEST * side => {
            field.height_scale = SCALED * side / (high - low);
            description.warnings.push(format!(
                "no unit of height: heights are multiplied by {:.3e}, for a relief of {SCALED} of the longer side",
                field.height_scale
            ));
        }
        None => {}
    }
    field.height_scale *= options.exaggeration;
}

fn read(
    path: &Path,
    options: &HeightFieldOptions,
    context: &Context<'_>,
) -> Result<(HeightField, Description), IoError> {
    if options.raw.is_some() {
        return grid(path, options, context);
    }
    let mut source = Source::open(path)?;
    let mut start = vec![0; 1024];
    let length = source.fill(&mut start, context)?;
    start.truncate(length);
    match start.as_slice() {
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => geotiff::read(path),
        _ if start.starts_with(b"\x93NUMPY") => grid(path, options, context),
        _ if dem::is_dem(&start) => dem::read(path),
        _ if start
            .iter()
            .all(|byte| !byte.is_ascii_control() || byte.is_ascii_whitespace()) =>
        {
            table::read(path, options.rows.unwrap_or(RowOrder::SouthFirst))
        }
        _ => {
            Err(context
                .unsupported("neither USGS DEM, GeoTIFF, .npy nor a table of text; raw needs its layout"))
        }
    }
}

/// Raw samples, or a `.npy` of two axes: rows, columns.
fn grid(
    path: &Path,
    options: &HeightFieldOptions,
    context: &Context<'_>,
) -> Result<(HeightField, Description), IoError> {
    let read_options = ReadOptions {
        raw: options.raw.clone(),
        max_bytes: options.max_bytes,
        ..ReadOptions::default()
    };
    let loaded = match &options.raw {
        Some(_) => volume::raw::read(path, &read_options)?,
        None => volume::npy::read(path, &read_options)?,
    };
    let [width, height, depth] = loaded.volume.grid().dims();
    if depth != 1 {
        return Err(context.field(
            "dims",
            format!("{width} x {height} x {depth}"),
            None,
            "columns, rows and 1",
        ));
    }
    let count = width * height;
    let spacing = loaded.volume.grid().spacing().truncate();
    let mut field = HeightField {
        dims: [width, height],
        heights: (0..count).map(|index| loaded.volume.value(index)).collect(),
        origin: DVec2::ZERO,
        spacing,
        height_scale: 1.0,
        measured: false,
    };
    field.south_first(options.rows.unwrap_or(RowOrder::NorthFirst));
    Ok((field, loaded.description))
}
