//! Footprints of voxels integrated along rays: by ray, by tile, and the widest of a picture (see `integral`).

use glam::{DMat2, DVec2};
use splatvol_scene::{ImageSize, ScreenFromCamera};

use super::raster::{Raster, SheetShape};
use crate::footprint::FootprintShape;

/// Relative difference of variances up to which a footprint is a circle: far less than shows, far more than rounding.
pub(super) const NEARLY_ROUND: f64 = 1e-6;

/// Projected footprints of all rays of a picture.
#[derive(Debug, Clone, Copy)]
pub struct RayShapes {
    /// The kernel's.
    pub shape: FootprintShape,
    /// The projection.
    pub screen: ScreenFromCamera,
    /// Volume of a voxel, world length cubed.
    pub cell_volume: f64,
}

impl RayShapes {
    /// Ray through image coordinates, per depth.
    pub fn ray(&self, image: DVec2) -> DVec2 {
        if self.screen.perspective {
            (image - self.screen.centre) / self.screen.scale
        } else {
            DVec2::ZERO
        }
    }

    /// Covariance xx, xy, yy of footprints seen along a ray, world length squared.
    pub fn covariance(&self, ray: DVec2) -> [f64; 3] {
        let [xx, xy, yy] = self.shape.lateral_covariance;
        let drift = (ray - self.shape.lateral_slope) * self.shape.depth_sigma;
        [
            xx + drift.x * drift.x,
            xy + drift.x * drift.y,
            yy + drift.y * drift.y,
        ]
    }

    /// A shape as wide as the widest of a picture along x and along y, and its covariances from end to end.
    pub fn over(&self, size: ImageSize) -> (FootprintShape, [[f64; 3]; 9]) {
        let (width, height) = (f64::from(size.width()), f64::from(size.height()));
        let covariances = std::array::from_fn(|i| {
            let image = DVec2::new(width * (i % 3) as f64, height * (i / 3) as f64) * 0.5;
            self.covariance(self.ray(image))
        });
        let largest = |pick: usize| covariances.iter().fold(0.0, |most: f64, c| most.max(c[pick]));
        let bounding = FootprintShape {
            lateral_slope: DVec2::ZERO,
            lateral_covariance: [largest(0), 0.0, largest(2)],
            ..self.shape
        };
        (bounding, covariances)
    }

    /// Whether all footprints are round.
    pub fn is_round(&self) -> bool {
        let [xx, xy, yy] = self.covariance(DVec2::ZERO);
        !self.screen.perspective && xy.abs() < NEARLY_ROUND * xx && (xx - yy).abs() < NEARLY_ROUND * xx
    }

    /// The footprint of a depth around image coordinates, the middle of a tile.
    pub fn at(&self, raster: &Raster, image: DVec2, depth: f64) -> SheetShape {
        let lateral_covariance = self.covariance(self.ray(image));
        let [xx, xy, yy] = lateral_covariance;
        let area = DMat2::from_cols(DVec2::new(xx, xy), DVec2::new(xy, yy)).determinant();
        let shape = FootprintShape {
            lateral_covariance,
            ..self.shape
        };
        let peak = self.cell_volume / (2.0 * std::f64::consts::PI * area.sqrt());
        SheetShape::new(&shape, &self.screen, &Raster { peak, ..*raster }, depth)
    }
}
