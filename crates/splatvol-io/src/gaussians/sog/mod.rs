//! `.sog` (`PlayCanvas`, "Spatially Ordered Gaussians"), versions 1 and 2.
//!
//! `meta.json` and lossless WebP pictures, in a zip or in a folder; pixel i, row by row, belongs to Gaussian i.
//!
//! ```text
//! means    log = min + (max - min) (low + 256 high) / 65535,   x = sign(log) (exp |log| - 1)
//! quats    alpha - 252 says which of w x y z is left out, the others are (2 byte / 255 - 1) / sqrt(2)
//! scales   logarithms: a codebook (version 2), or bounds of each channel (version 1)
//! sh0      degree 0: a codebook, or bounds; alpha is the opacity (version 2), or bounds of its logit (version 1)
//! shN      two bytes of a label, then a row of 64 centroids, whose bytes stand for numbers as those of scales do
//! ```
//!
//! Attributes follow the frame and the conventions of the trained `.ply`.

mod files;
mod meta;

use std::path::Path;

use super::LoadedGaussians;
use super::collect::{Collector, Splat, check_plausible, sigmoid, with_largest};
use super::frame::{self, RDF};
use super::harmonics::harmonics_count;
use crate::error::Context;
use crate::{IoError, ReadOptions};
use files::{Files, Picture};
pub(super) use files::{is_archive, is_folder_or_meta};
use meta::{Harmonics, Meta, Numbers};

/// Centroids in a row of their picture.
const CENTROIDS_PER_ROW: usize = 64;

/// Reads a `.sog`, its folder, or its `meta.json`.
///
/// # Errors
/// A `meta.json` that is not one, missing or corrupt pictures, pictures smaller than the count.
pub(super) fn read(path: &Path, options: &ReadOptions) -> Result<LoadedGaussians, IoError> {
    let context = &Context::new("SOG", path).following(options);
    let mut files = Files::open(path, context)?;
    let document = crate::json::parse(&files.read("meta.json", context)?, context)?;
    let meta = Meta::parse(&document, context)?;
    check_plausible(meta.count as u64, files.bytes(context), context)?;
    let pictures = Pictures::read(&meta, &mut files, context)?;
    let palette = Palette::read(&meta, &mut files, context)?;
    let degree = palette.as_ref().map_or(0, |palette| palette.degree);
    let mut collector = Collector::new(meta.count as u64, degree, options, context)?;
    collector.description.format = format!("SOG {}", meta.version);
    collector.description.stored_type = format!("{}, lossless WebP", files.kind());
    collector.description.orientation = frame::describe(RDF);
    collector.antialiased = meta.antialiased;
    for name in files.paths() {
        collector.add_file(name);
    }
    let mut harmonics = vec![[0.0; 3]; harmonics_count(degree)];
    let mut not_labelled = 0;
    for index in 0..meta.count {
        harmonics.fill([0.0; 3]);
        let splat = pictures.splat(index, &meta);
        harmonics[0] = pictures.color(index, &meta);
        if let Some(palette) = &palette {
            not_labelled += u64::from(!palette.look_up(index, &mut harmonics[1..]));
        }
        collector.push(&splat, &harmonics);
    }
    if not_labelled > 0 {
        collector.warn(format!(
            "{not_labelled} of {} Gaussians have a label beyond the centroids, and only harmonics of degree 0",
            meta.count
        ));
    }
    collector.finish(frame::world_from_local(RDF), context)
}

/// The pictures that every file has.
struct Pictures {
    means: [Picture; 2],
    quats: Picture,
    scales: Picture,
    colors: Picture,
}

impl Pictures {
    fn read(meta: &Meta, files: &mut Files, context: &Context<'_>) -> Result<Self, IoError> {
        let mut picture = |name: &str| files.picture(name, meta.count, context);
        Ok(Self {
            means: [picture(&meta.means.files[0])?, picture(&meta.means.files[1])?],
            quats: picture(&meta.quats)?,
            scales: picture(&meta.scales.file)?,
            colors: picture(&meta.colors.file)?,
        })
    }

    fn splat(&self, index: usize, meta: &Meta) -> Splat {
        let [low, high] = [self.means[0].pixel(index), self.means[1].pixel(index)];
        let mean = std::array::from_fn(|axis| {
            let unit = f64::from(u16::from_le_bytes([low[axis], high[axis]])) / 65535.0;
            let logarithm = meta.means.min[axis] + (meta.means.max[axis] - meta.means.min[axis]) * unit;
            logarithm.abs().exp_m1().copysign(logarithm)
        });
        let scale = self.scales.pixel(index);
        let alpha = self.colors.pixel(index)[3];
        Splat {
            mean,
            scale: std::array::from_fn(|axis| meta.scales.numbers.at(axis, scale[axis]).exp()),
            rotation: rotation(self.quats.pixel(index)),
            opacity: match meta.colors.numbers {
                Numbers::Codebook(_) => f64::from(alpha) / 255.0,
                Numbers::Bounds { .. } => sigmoid(meta.colors.numbers.at(3, alpha)),
            },
        }
    }

    fn color(&self, index: usize, meta: &Meta) -> [f32; 3] {
        let color = self.colors.pixel(index);
        std::array::from_fn(|c| meta.colors.numbers.at(c, color[c]) as f32)
    }
}

/// Quaternion x y z w; zeros if the tag names no omitted component.
fn rotation([a, b, c, tag]: [u8; 4]) -> [f64; 4] {
    if tag < 252 {
        return [0.0; 4];
    }
    let part = |byte| (f64::from(byte) / 255.0 * 2.0 - 1.0) * std::f64::consts::FRAC_1_SQRT_2;
    let [w, x, y, z] = with_largest(usize::from(tag - 252), [part(a), part(b), part(c)]);
    [x, y, z, w]
}

/// Harmonics above degree 0, shared by Gaussians with the same label.
struct Palette<'a> {
    labels: Picture,
    centroids: Picture,
    harmonics: &'a Harmonics,
    degree: u32,
    count: usize,
}

impl<'a> Palette<'a> {
    fn read(meta: &'a Meta, files: &mut Files, context: &Context<'_>) -> Result<Option<Self>, IoError> {
        let Some(harmonics) = &meta.harmonics else {
            return Ok(None);
        };
        let labels = files.picture(&harmonics.labels, meta.count, context)?;
        let centroids = files.picture(&harmonics.centroids, 1, context)?;
        let degree = (1..=3).find(|degree| {
            centroids.width() == CENTROIDS_PER_ROW * (harmonics_count(*degree) - 1)
                && harmonics.bands.is_none_or(|bands| bands == *degree)
        });
        let degree = degree.ok_or_else(|| {
            let expected = "192, 512 or 960 (64 centroids of degree 1, 2 or 3), as shN.bands says";
            context.field("width of the centroids", centroids.width(), None, expected)
        })?;
        let there = CENTROIDS_PER_ROW * centroids.height();
        Ok(Some(Self {
            count: harmonics.count.map_or(there, |count| count.min(there)),
            labels,
            centroids,
            harmonics,
            degree,
        }))
    }

    /// Fills in the harmonics of a Gaussian; false where its label names none.
    fn look_up(&self, index: usize, harmonics: &mut [[f32; 3]]) -> bool {
        let [low, high, ..] = self.labels.pixel(index);
        let label = usize::from(u16::from_le_bytes([low, high]));
        if label >= self.count {
            return false;
        }
        // Rows of centroids follow each other without gaps: label and coefficient count pixels from the first.
        let start = label * harmonics.len();
        for (k, triple) in harmonics.iter_mut().enumerate() {
            let pixel = self.centroids.pixel(start + k);
            *triple = std::array::from_fn(|c| self.harmonics.numbers.at(0, pixel[c]) as f32);
        }
        true
    }
}
