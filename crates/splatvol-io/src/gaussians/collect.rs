//! Common code of all Gaussian readers: collects Gaussians one by one, counts their defects, and builds the scene part.

use std::path::PathBuf;

use glam::DAffine3;
use splatvol_scene::{GaussianAttributes, Gaussians};

use super::harmonics::harmonics_count;
use super::{GaussiansDescription, LoadedGaussians};
use crate::error::Context;
use crate::{IoError, ReadOptions};

/// A Gaussian without its harmonics.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Splat {
    pub(crate) mean: [f64; 3],
    /// Standard deviations, not their logarithms.
    pub(crate) scale: [f64; 3],
    /// x y z w, of any length.
    pub(crate) rotation: [f64; 4],
    /// 0 to 1.
    pub(crate) opacity: f64,
}

/// Opacity of a logit.
pub(crate) fn sigmoid(logit: f64) -> f64 {
    1.0 / (1.0 + (-logit).exp())
}

/// Harmonics of degree 0 that show a colour, 0..1, from all sides.
pub(crate) fn harmonics_of_color(color: [f64; 3]) -> [f32; 3] {
    color.map(|c| ((c - 0.5) / super::harmonics::DEGREE_0) as f32)
}

/// The quaternion (in the file's order) whose component `largest` is left out of the file.
pub(crate) fn with_largest(largest: usize, others: [f64; 3]) -> [f64; 4] {
    let rest: f64 = others.iter().map(|c| c * c).sum();
    let mut others = others.into_iter();
    std::array::from_fn(|i| {
        if i == largest {
            (1.0 - rest).max(0.0).sqrt()
        } else {
            others.next().unwrap_or(0.0)
        }
    })
}

/// Gaussians on their way from a file.
pub(crate) struct Collector {
    attributes: GaussianAttributes,
    degree: u32,
    seen: u64,
    not_finite: u64,
    not_turned: u64,
    /// Describes the file; readers add to it.
    pub(crate) description: GaussiansDescription,
    pub(crate) antialiased: bool,
}

/// Gaussians that need no justification by bytes.
const FREE: u64 = 100_000;
/// Gaussians that a compressed byte may stand for. Real ones take 10 bytes and more.
const PER_BYTE: u64 = 4;

/// Refuses more Gaussians than compressed files of so many bytes can hold, unless all are alike.
pub(crate) fn check_plausible(count: u64, bytes: u64, context: &Context<'_>) -> Result<(), IoError> {
    let most = FREE.saturating_add(bytes.saturating_mul(PER_BYTE));
    match count <= most {
        true => Ok(()),
        false => {
            let expected = format!("at most {most} in {bytes} bytes");
            Err(context.field("number of Gaussians", count, None, expected))
        }
    }
}

impl Collector {
    /// A collector for `count` Gaussians with harmonics of degree 3 at most, if the options allow that many.
    pub(crate) fn new(
        count: u64,
        degree: u32,
        options: &ReadOptions,
        context: &Context<'_>,
    ) -> Result<Self, IoError> {
        let bytes = 44 + 12 * harmonics_count(degree) as u64;
        let expected = count.saturating_mul(bytes);
        if expected > options.max_bytes {
            return Err(context.limit(expected, options.max_bytes));
        }
        if count == 0 {
            return Err(context.field("number of Gaussians", 0, None, "at least one"));
        }
        Ok(Self {
            attributes: GaussianAttributes::default(),
            degree,
            seen: 0,
            not_finite: 0,
            not_turned: 0,
            description: GaussiansDescription {
                files: vec![context.path.to_owned()],
                ..GaussiansDescription::default()
            },
            antialiased: false,
        })
    }

    /// Degree of the harmonics that are kept.
    pub(crate) fn degree(&self) -> u32 {
        self.degree
    }

    /// Adds a Gaussian and its harmonics, which are cut or filled up with zeros to the collected degree. A Gaussian
    /// with numbers that are not finite is left out; one without a rotation is not rotated. Both are counted.
    pub(crate) fn push(&mut self, splat: &Splat, harmonics: &[[f32; 3]]) {
        self.seen += 1;
        let mean = splat.mean.map(|c| c as f32);
        let scale = splat.scale.map(|c| c as f32);
        let opacity = splat.opacity as f32;
        let mut rotation = splat.rotation.map(|c| c as f32);
        let mut numbers = mean
            .iter()
            .chain(&scale)
            .chain(&rotation)
            .chain(harmonics.as_flattened());
        if !numbers.all(|c| c.is_finite()) || !opacity.is_finite() {
            self.not_finite += 1;
            return;
        }
        if rotation.iter().all(|c| *c == 0.0) {
            self.not_turned += 1;
            rotation = [0.0, 0.0, 0.0, 1.0];
        }
        self.attributes.means.push(mean);
        self.attributes.scales.push(scale);
        self.attributes.rotations.push(rotation);
        self.attributes.opacities.push(opacity);
        let kept = harmonics_count(self.degree);
        let zeros = std::iter::repeat([0.0; 3]);
        let filled = harmonics.iter().copied().chain(zeros).take(kept);
        self.attributes.harmonics.extend(filled);
    }

    /// Number of Gaussians that are kept.
    pub(crate) fn len(&self) -> usize {
        self.attributes.means.len()
    }

    /// Adds Gaussians with harmonics of at most this degree, and their warnings.
    pub(crate) fn append(&mut self, other: Self) {
        self.seen += other.seen;
        self.not_finite += other.not_finite;
        self.not_turned += other.not_turned;
        let (to, mut from) = (&mut self.attributes, other.attributes);
        to.means.append(&mut from.means);
        to.scales.append(&mut from.scales);
        to.rotations.append(&mut from.rotations);
        to.opacities.append(&mut from.opacities);
        let (kept, had) = (harmonics_count(self.degree), harmonics_count(other.degree));
        for harmonics in from.harmonics.chunks_exact(had) {
            to.harmonics.extend_from_slice(harmonics);
            to.harmonics.resize(to.harmonics.len() + kept - had, [0.0; 3]);
        }
        self.antialiased |= other.antialiased;
        for tag in other.description.tags {
            if !self.description.tags.contains(&tag) {
                self.description.tags.push(tag);
            }
        }
        self.description.warnings.extend(other.description.warnings);
    }

    /// Attributes collected so far.
    pub(crate) fn attributes(&self) -> &GaussianAttributes {
        &self.attributes
    }

    /// Attributes collected so far, for modification.
    pub(crate) fn attributes_mut(&mut self) -> &mut GaussianAttributes {
        &mut self.attributes
    }

    /// Warns of something odd.
    pub(crate) fn warn(&mut self, warning: impl Into<String>) {
        self.description.warnings.push(warning.into());
    }

    /// Adds a file that belongs to the format.
    pub(crate) fn add_file(&mut self, path: PathBuf) {
        if !self.description.files.contains(&path) {
            self.description.files.push(path);
        }
    }

    /// The scene part.
    pub(crate) fn finish(
        mut self,
        world_from_local: DAffine3,
        context: &Context<'_>,
    ) -> Result<LoadedGaussians, IoError> {
        let seen = self.seen;
        if self.not_finite == seen {
            return Err(context.field("Gaussians", seen, None, "one with finite numbers only"));
        }
        if self.not_finite > 0 {
            self.warn(format!(
                "{} of {seen} Gaussians have numbers that are not finite and are left out",
                self.not_finite
            ));
        }
        if self.not_turned > 0 {
            self.warn(format!(
                "{} of {seen} Gaussians have a rotation of zeros and are not rotated",
                self.not_turned
            ));
        }
        if self.antialiased {
            self.description.tags.push("antialiased".to_owned());
        }
        let gaussians = Gaussians::new(self.attributes, self.degree, world_from_local)
            .map_err(|error| context.scene(error))?
            .with_antialiasing(self.antialiased);
        self.description.count = gaussians.len();
        self.description.degree = self.degree;
        Ok(LoadedGaussians {
            gaussians,
            description: self.description,
        })
    }
}
