//! `.ply` as the published training program writes it (Kerbl 2023, `scene/gaussian_model.py`, `save_ply`).
//!
//! One `vertex` per Gaussian: `x y z`, `f_dc_0..2` (degree 0), `f_rest_*` (the other harmonics: all of red, then green,
//! then blue), `opacity` (its logit), `scale_0..2` (logarithms), `rot_0..3` (quaternion w x y z, of any length). The
//! order of the properties is free and others are ignored, with three exceptions: no `scale_2` means flat Gaussians
//! (Huang 2024, "2D Gaussian Splatting"); `filter_3D` is the low-pass of Yu 2024, "Mip-Splatting", section 5.1, which
//! is applied here,
//!
//! ```text
//! s' = sqrt(s^2 + f^2),   opacity' = opacity sqrt(prod s^2 / prod s'^2)
//! ```
//!
//! and comments that call the render mode `mip` or the training antialiased set the tag.

use std::path::Path;

use super::LoadedGaussians;
use super::collect::{Collector, Splat, sigmoid};
use super::frame::{self, RDF};
use super::harmonics::harmonics_count;
use crate::error::Context;
use crate::ply::{Element, Header, Reader};
use crate::source::Source;
use crate::{IoError, ReadOptions};

/// Required properties of every Gaussian, in the order in which rows are requested.
const REQUIRED: [&str; 13] = [
    "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "rot_0", "rot_1", "rot_2",
    "rot_3",
];

/// True where the vertices are Gaussians, complete or not.
pub(super) fn is_trained(header: &Header) -> bool {
    let telling = ["f_dc_0", "opacity", "scale_0", "rot_0"];
    header
        .element("vertex")
        .is_some_and(|vertex| telling.iter().filter(|name| vertex.has(name)).count() >= 3)
}

/// Optional columns present, and their places in the row.
struct Layout {
    columns: Vec<String>,
    scale_2: Option<usize>,
    filter: Option<usize>,
    /// Harmonics per colour beyond degree 0 that the file has.
    rest: usize,
    rest_start: usize,
}

impl Layout {
    fn new(vertex: &Element, context: &Context<'_>) -> Result<Self, IoError> {
        let mut columns: Vec<String> = REQUIRED.map(str::to_owned).to_vec();
        let mut optional = |name: &str| {
            vertex.has(name).then(|| {
                columns.push(name.to_owned());
                columns.len() - 1
            })
        };
        let scale_2 = optional("scale_2");
        let filter = optional("filter_3D");
        let rest_start = columns.len();
        let rest = (0..).take_while(|i| vertex.has(&format!("f_rest_{i}"))).count();
        if ![0, 9, 24, 45, 72].contains(&rest) {
            let expected = "0, 9, 24, 45 or 72 properties (degrees 0 to 4)";
            return Err(context.field("f_rest_*", rest, None, expected));
        }
        columns.extend((0..rest).map(|i| format!("f_rest_{i}")));
        Ok(Self {
            columns,
            scale_2,
            filter,
            rest: rest / 3,
            rest_start,
        })
    }

    /// The Gaussian of a row.
    fn splat(&self, row: &[f64]) -> Splat {
        let mut scale = [
            row[7].exp(),
            row[8].exp(),
            self.scale_2.map_or(0.0, |i| row[i].exp()),
        ];
        let mut opacity = sigmoid(row[6]);
        if let Some(filter) = self.filter {
            let widened = scale.map(|s| s.hypot(row[filter]));
            let ratio = |(s, w): (f64, f64)| if w > 0.0 { s / w } else { 1.0 };
            opacity *= scale.into_iter().zip(widened).map(ratio).product::<f64>();
            scale = widened;
        }
        Splat {
            mean: [row[0], row[1], row[2]],
            scale,
            rotation: [row[10], row[11], row[12], row[9]],
            opacity,
        }
    }

    /// Its harmonics, from planes of colours to triples.
    fn harmonics(&self, row: &[f64], harmonics: &mut Vec<[f32; 3]>) {
        harmonics.clear();
        harmonics.push([row[3] as f32, row[4] as f32, row[5] as f32]);
        let rest = &row[self.rest_start..];
        let triple = |k| std::array::from_fn(|color| rest[color * self.rest + k] as f32);
        harmonics.extend((0..self.rest).map(triple));
    }
}

/// Reads a trained `.ply`.
///
/// # Errors
/// Missing properties, a wrong number of harmonics, rows cut short, no Gaussian with finite numbers.
pub(super) fn read(path: &Path, options: &ReadOptions) -> Result<LoadedGaussians, IoError> {
    let context = &Context::new("PLY (3-D Gaussians)", path);
    let mut reader = Reader::new(Source::open(path)?, *context)?;
    let header = reader.header().clone();
    let Some(vertex) = header.element("vertex") else {
        return Err(context.field("element", "(absent)", None, "an element \"vertex\""));
    };
    let layout = Layout::new(vertex, context)?;
    let degree = (layout.rest + 1).isqrt() as u32 - 1;
    let mut collector = Collector::new(vertex.count, degree.min(3), options, context)?;
    describe(&mut collector, &header, vertex, &layout);
    if degree > 3 {
        collector.warn("harmonics of degree 4 are left out");
    }
    let columns: Vec<&str> = layout.columns.iter().map(String::as_str).collect();
    let mut harmonics = Vec::with_capacity(harmonics_count(degree));
    reader.rows("vertex", &columns, |_, row| {
        layout.harmonics(row, &mut harmonics);
        collector.push(&layout.splat(row), &harmonics);
        Ok(())
    })?;
    match reader.excess()? {
        0 => {}
        excess => collector.warn(format!("{excess} bytes follow the last element")),
    }
    collector.finish(frame::world_from_local(RDF), context)
}

fn describe(collector: &mut Collector, header: &Header, vertex: &Element, layout: &Layout) {
    let description = &mut collector.description;
    description.format = "PLY (3-D Gaussians)".to_owned();
    description.stored_type = format!(
        "{}, {} properties",
        header.encoding.name(),
        vertex.properties.len()
    );
    description.orientation = frame::describe(RDF);
    if layout.scale_2.is_none() {
        description.tags.push("flat".to_owned());
    }
    let says = |comment: &String| {
        let words = comment.to_ascii_lowercase();
        words.contains("antialias") || (words.contains("rendermode") && words.contains("mip"))
    };
    collector.antialiased = layout.filter.is_some() || header.comments.iter().any(says);
    if layout.filter.is_some() {
        collector.description.tags.push("mip".to_owned());
    }
}
