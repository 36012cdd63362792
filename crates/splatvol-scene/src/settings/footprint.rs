//! Shape, rasterisation and occlusion culling of footprints: the differences between the papers' methods.

use serde::{Deserialize, Serialize};

use crate::SceneError;

/// Choice of the integrals of a kernel that make up its footprint.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Alignment {
    /// On sheets of constant depth, where a perspective view only scales: exact there (docs/numerics.md). Whole
    /// footprints are affine.
    #[default]
    Sheet,
    /// Along rays parallel to the one through the kernel's centre, with the perspective map linearised there
    /// (zwicker2001 section 4.4).
    Affine,
    /// Along each pixel's own ray, in closed form.
    Exact,
    /// Along the viewing axis: the footprint lies parallel to the picture (mueller1998 table 1, row 5).
    Grid,
    /// Along rays parallel to the one through the kernel's centre, with the footprint across that ray and seen in
    /// true perspective (mueller1998 table 1, row 4).
    Ray,
    /// Along each pixel's own ray; the swan filter stretches across the ray through the centre (mueller1998 table
    /// 1, row 3). The same as exact for any other filter.
    RayIdeal,
    /// As [`Alignment::Ray`] before the depth `z_s`, as [`Alignment::Grid`] behind it, where rays are nearly parallel to the
    /// axis and stretched kernels should not be turned away from it (mueller1998 section 4.2).
    Switch {
        /// Distance of `z_s` behind the depth `z_k` from which voxels are less than a pixel apart, mean voxel spacings.
        behind: f64,
    },
    /// Affine wherever that is good enough, exact otherwise: footprint by footprint.
    Auto {
        /// Largest error of a footprint that is good enough, share of its peak.
        budget: f64,
    },
}

impl Alignment {
    /// A footprint may err by one level of eight bits.
    pub const AUTO: Self = Self::Auto { budget: 1.0 / 256.0 };

    /// `z_s = z_k + 70`: what mueller1998 found for 512 voxels and pixels along each axis and half an angle of 30 degrees.
    pub const SWITCH: Self = Self::Switch { behind: 70.0 };
}

/// Rasterisation of footprints.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rasterizer {
    /// The fastest for the footprint, evaluated without tables where the kernel is a Gaussian.
    #[default]
    Auto,
    /// A square root per pixel, into a table that is even in the distance (huang2000 section 3.1.1). Any ellipse.
    #[serde(rename = "linear-1d")]
    Linear1d,
    /// The squared distance by two additions per pixel, into a table that is even in it (section 3.1.2). Circles.
    #[serde(rename = "square-1d")]
    Square1d,
    /// As [`Rasterizer::Square1d`], for any ellipse (section 3.1.3).
    #[serde(rename = "ellipse-1d")]
    Ellipse1d,
    /// Centres snapped to a grid within the pixel, squared distances added up from one-dimensional tables (section
    /// 3.3). Circles, and ellipses along the pixels' axes.
    Rlut {
        /// Cells of that grid per pixel and axis, 1 to 128.
        subpixels: u32,
    },
    /// Footprints drawn beforehand for each integer radius and each cell of a grid within the pixel, copied from there
    /// (section 3.2). Circles.
    #[serde(rename = "blit-2d")]
    Blit2d {
        /// Cells of that grid per pixel and axis, 1 to 8.
        subpixels: u32,
    },
    /// As [`Rasterizer::Blit2d`] for small footprints, as [`Rasterizer::Square1d`] for others (section 7, future work).
    /// Circles.
    Hybrid {
        /// Cells of the grid within the pixel, per axis, 1 to 8.
        subpixels: u32,
        /// Largest radius of a small footprint, pixels, 1 to 64.
        radius: u32,
    },
}

impl Rasterizer {
    /// Name, as settings spell it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Linear1d => "linear-1d",
            Self::Square1d => "square-1d",
            Self::Ellipse1d => "ellipse-1d",
            Self::Rlut { .. } => "rlut",
            Self::Blit2d { .. } => "blit-2d",
            Self::Hybrid { .. } => "hybrid",
        }
    }

    /// Whether footprints come from a [`crate::TableLayout`].
    pub fn has_table(self) -> bool {
        self != Self::Auto
    }

    /// Whether it draws circles only, or ellipses along the pixels' axes at most.
    pub fn draws_circles(self) -> bool {
        match self {
            Self::Square1d | Self::Rlut { .. } | Self::Blit2d { .. } | Self::Hybrid { .. } => true,
            Self::Auto | Self::Linear1d | Self::Ellipse1d => false,
        }
    }

    pub(super) fn validate(self) -> Result<(), SceneError> {
        if let Self::Hybrid { radius, .. } = self
            && !(1..=64).contains(&radius)
        {
            return Err(SceneError::invalid("blit radius", radius, "1 to 64 pixels"));
        }
        let (subpixels, most, expected) = match self {
            Self::Rlut { subpixels } => (subpixels, 128, "1 to 128 cells per pixel with rlut"),
            Self::Blit2d { subpixels } => (subpixels, 8, "1 to 8 cells per pixel with blit-2d"),
            Self::Hybrid { subpixels, .. } => (subpixels, 8, "1 to 8 cells per pixel with hybrid"),
            _ => return Ok(()),
        };
        if (1..=most).contains(&subpixels) {
            Ok(())
        } else {
            Err(SceneError::invalid("subpixels", subpixels, expected))
        }
    }
}

/// Culling of hidden footprints.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Occlusion {
    /// A count of unfinished pixels per block of 8 x 8.
    #[default]
    Auto,
    /// No culling, and no pixel is ever finished.
    None,
    /// A summed-area table of finished pixels over the whole picture, queried for every brick and every splat
    /// (huang2000 section 4.1).
    Sat,
    /// A convolution of the finished pixels of the whole picture with a box as large as a splat, queried at a splat's centre:
    /// what huang2000 section 4.1 replaces, for comparison. Bricks and splats larger than the box are not hidden.
    Box,
}

impl Occlusion {
    /// Whether the finished pixels are those of the whole picture, rather than of a tile.
    pub fn is_of_whole_picture(self) -> bool {
        matches!(self, Self::Sat | Self::Box)
    }
}

/// Whether the kernels reconstruct a volume or surfaces.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reconstruction {
    /// A volume: kernels as the grid defines them.
    #[default]
    Volume,
    /// Surfaces: every kernel is flattened along the gradient (zwicker2001 section 5).
    Surface {
        /// Divisor of the standard deviation along the gradient, 1 or more; infinite for a surface kernel.
        flatness: f64,
    },
    /// Surfaces inside a volume: kernels are flattened where there is a surface (zwicker2001 figure 10).
    Mixed {
        /// Divisor of the standard deviation along the gradient on surfaces.
        flatness: f64,
        /// Least gradient of a voxel that belongs to a surface, value ranges per mean voxel spacing.
        gradient: f64,
    },
}

impl Reconstruction {
    pub(super) fn validate(self) -> Result<(), SceneError> {
        match self {
            Self::Surface { flatness } | Self::Mixed { flatness, .. } if !(1.0..=1e6).contains(&flatness) => {
                Err(SceneError::invalid("flatness", flatness, "1 to 1000000"))
            }
            Self::Mixed { gradient, .. } if !(0.0..=1e3).contains(&gradient) => Err(SceneError::invalid(
                "surface gradient",
                gradient,
                "0 to 1000 value ranges per voxel",
            )),
            _ => Ok(()),
        }
    }
}
