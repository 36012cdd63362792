//! Regular grids: dimensions and the affine map `world_from_voxel`.
//!
//! `world = origin + direction * (spacing .* voxel)`; the columns of `direction * spacing` may be oblique (gantry
//! tilt) as long as they span space. A sample stands for the cell of half a voxel around it, so that a grid of n
//! samples is n spacings wide: its box runs from voxel -0.5 to n - 0.5.

use glam::{DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::SceneError;

/// Spacings whose cubes, and the inverses of these, can be computed with.
const SPACINGS: std::ops::RangeInclusive<f64> = 1e-30..=1e30;
/// Least volume of a cell relative to one with the same edges at right angles: below, its axes lie in a plane.
const LEAST_SKEW: f64 = 1e-3;

/// The unit of world lengths. Only a label: nothing is converted by it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LengthUnit {
    /// The file does not say.
    #[default]
    Unknown,
    /// Metre.
    Metre,
    /// Millimetre.
    Millimetre,
    /// Micrometre.
    Micrometre,
    /// Nanometre.
    Nanometre,
}

impl LengthUnit {
    /// The usual symbol; empty where the unit is unknown.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Unknown => "",
            Self::Metre => "m",
            Self::Millimetre => "mm",
            Self::Micrometre => "um",
            Self::Nanometre => "nm",
        }
    }
}

/// An axis-aligned box in world space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Smallest corner, world.
    pub min: DVec3,
    /// Largest corner, world.
    pub max: DVec3,
}

impl Bounds {
    /// Centre, world.
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Length of the diagonal, world.
    pub fn diagonal(&self) -> f64 {
        (self.max - self.min).length()
    }

    /// The eight corners, x fastest.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
            DVec3::new(
                pick(0, self.min.x, self.max.x),
                pick(1, self.min.y, self.max.y),
                pick(2, self.min.z, self.max.z),
            )
        })
    }
}

/// A regular grid in world space.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    dims: [usize; 3],
    world_from_voxel: DAffine3,
}

impl Grid {
    /// Largest extent per axis; beyond it indices would leave the engines' 16 bits.
    pub const MAX_DIM: usize = 65_535;

    /// Grid from dims (x y z), origin (centre of voxel 0, world), spacing (world per voxel) and direction
    /// (columns: world directions of the voxel axes, usually orthonormal).
    ///
    /// # Errors
    /// Dimensions of 0 or above [`Grid::MAX_DIM`], a spacing that is not positive and finite, or a direction
    /// that is singular or not finite.
    pub fn new(
        dims: [usize; 3],
        origin: impl Into<DVec3>,
        spacing: impl Into<DVec3>,
        direction: DMat3,
    ) -> Result<Self, SceneError> {
        let spacing = spacing.into();
        if !(spacing.is_finite() && spacing.min_element() > 0.0) {
            return Err(SceneError::invalid(
                "spacing",
                spacing.to_array(),
                "positive and finite",
            ));
        }
        Self::from_affine(
            dims,
            DAffine3::from_mat3_translation(direction * DMat3::from_diagonal(spacing), origin.into()),
        )
    }

    /// Grid along the world's axes, its centre at the world's origin.
    ///
    /// # Errors
    /// Same as [`Grid::new`].
    pub fn centred(dims: [usize; 3], spacing: impl Into<DVec3>) -> Result<Self, SceneError> {
        let spacing = spacing.into();
        let last = DVec3::from_array(dims.map(|n| n as f64 - 1.0));
        Self::new(dims, -0.5 * last * spacing, spacing, DMat3::IDENTITY)
    }

    /// Grid from dims (x y z) and the whole map from voxel to world.
    ///
    /// # Errors
    /// Same as [`Grid::new`].
    pub fn from_affine(dims: [usize; 3], world_from_voxel: DAffine3) -> Result<Self, SceneError> {
        if dims.iter().any(|&n| n == 0 || n > Self::MAX_DIM) {
            return Err(SceneError::invalid("dims", dims, "each from 1 to 65535"));
        }
        // In a browser addresses have 32 bits.
        let count = dims.iter().try_fold(1usize, |product, &n| product.checked_mul(n));
        if count.is_none() {
            return Err(SceneError::invalid(
                "dims",
                dims,
                "no more samples than there are addresses",
            ));
        }
        let columns = world_from_voxel.matrix3;
        if !world_from_voxel.translation.is_finite() {
            return Err(SceneError::invalid(
                "origin",
                world_from_voxel.translation.to_array(),
                "finite numbers",
            ));
        }
        let lengths = [columns.x_axis, columns.y_axis, columns.z_axis].map(DVec3::length);
        if lengths.iter().any(|l| !SPACINGS.contains(l)) {
            return Err(SceneError::invalid("spacing", lengths, "positive and finite"));
        }
        // Relative volume of the cell: 1 for orthogonal axes, 0 for axes in one plane.
        let skew = columns.determinant().abs() / (lengths[0] * lengths[1] * lengths[2]);
        if skew < LEAST_SKEW || skew.is_nan() {
            return Err(SceneError::invalid(
                "direction",
                columns.to_cols_array(),
                "three axes that span space",
            ));
        }
        Ok(Self {
            dims,
            world_from_voxel,
        })
    }

    /// Samples along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Number of samples.
    pub fn sample_count(&self) -> usize {
        self.dims.iter().product()
    }

    /// Map from continuous voxel index to world.
    pub fn world_from_voxel(&self) -> DAffine3 {
        self.world_from_voxel
    }

    /// World position of voxel (0, 0, 0)'s centre.
    pub fn origin(&self) -> DVec3 {
        self.world_from_voxel.translation
    }

    /// World distance between neighbours along each voxel axis.
    pub fn spacing(&self) -> DVec3 {
        let m = self.world_from_voxel.matrix3;
        DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length())
    }

    /// Unit world directions of the voxel axes, as columns.
    pub fn direction(&self) -> DMat3 {
        let m = self.world_from_voxel.matrix3;
        DMat3::from_cols(m.x_axis.normalize(), m.y_axis.normalize(), m.z_axis.normalize())
    }

    /// Geometric mean of the spacing: the side of the cube of one cell's volume, world.
    pub fn mean_spacing(&self) -> f64 {
        libm::cbrt(self.cell_volume())
    }

    /// World volume of one cell.
    pub fn cell_volume(&self) -> f64 {
        self.world_from_voxel.matrix3.determinant().abs()
    }

    /// Corners of the grid's box (voxel -0.5 to n - 0.5) in world space, x fastest.
    pub fn corners(&self) -> [DVec3; 8] {
        let high = DVec3::from_array(self.dims.map(|n| n as f64 - 0.5));
        Bounds {
            min: DVec3::splat(-0.5),
            max: high,
        }
        .corners()
        .map(|voxel| self.world_from_voxel.transform_point3(voxel))
    }

    /// World bounds of the grid's box.
    pub fn bounds(&self) -> Bounds {
        let corners = self.corners();
        Bounds {
            min: corners.into_iter().reduce(DVec3::min).unwrap_or_default(),
            max: corners.into_iter().reduce(DVec3::max).unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn box_is_half_a_voxel_wider_than_the_centres() {
        let grid = Grid::new([4, 2, 1], DVec3::ZERO, DVec3::new(1.0, 2.0, 5.0), DMat3::IDENTITY).unwrap();
        assert_eq!(grid.bounds().min, DVec3::new(-0.5, -1.0, -2.5));
        assert_eq!(grid.bounds().max, DVec3::new(3.5, 3.0, 2.5));
        assert!((grid.mean_spacing() - 10f64.cbrt()).abs() < 1e-12);
    }

    #[test]
    fn bad_fields_are_named() {
        let new = |dims, spacing| {
            Grid::new(dims, DVec3::ZERO, spacing, DMat3::IDENTITY)
                .unwrap_err()
                .to_string()
        };
        assert!(new([0, 1, 1], DVec3::ONE).starts_with("dims: [0, 1, 1]"));
        assert!(new([1, 1, 1], DVec3::new(1.0, f64::NAN, 1.0)).starts_with("spacing: [1.0, NaN, 1.0]"));
        let flat = DMat3::from_cols(DVec3::X, DVec3::X, DVec3::Z);
        let error = Grid::new([2, 2, 2], DVec3::ZERO, DVec3::ONE, flat).unwrap_err();
        assert!(error.to_string().starts_with("direction"));
    }
}
