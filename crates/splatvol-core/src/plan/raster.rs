//! Footprint on each sheet of a frame.
//!
//! On a sheet the kernel is `peak exp(-d^T Q d / 2) g(dz)`, d the pixel's offset from the footprint's centre there,
//! which is where the sheet cuts the line through the voxel along the kernel's conjugate axis: exact in
//! perspective.

use splatvol_scene::ScreenFromCamera;

use crate::footprint::FootprintShape;

/// One sheet's footprint.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub struct SheetShape {
    /// Camera depth.
    pub depth: f32,
    /// Raster points per world length.
    pub scale: f32,
    /// `Q log2(e) / 2`: xx, 2 xy, yy; per raster point squared.
    pub exponent: [f32; 3],
    /// Value at the centre.
    pub peak: f32,
    /// Variance of the low-pass, world length squared.
    pub low_pass: f32,
}

/// Lateral shape of the kernel, and its rasterisation.
#[derive(Debug, Clone, Copy)]
pub struct Raster {
    /// Pixels from one raster point to the next.
    pub step: usize,
    /// Low-pass variance added to footprints, pixels squared; with `matched`, footprints are widened only up to it.
    pub low_pass: f64,
    /// Whether footprints are only widened to the low-pass.
    pub matched: bool,
    /// Peak of the kernel at its centre, without low-pass.
    pub peak: f64,
}

impl Raster {
    /// A raster point per pixel, without a low-pass.
    pub const PIXELS: Self = Self {
        step: 1,
        low_pass: 0.0,
        matched: false,
        peak: 1.0,
    };
}

/// Variance that a cubic spline adds, raster points squared.
const SPLINE_VARIANCE: f64 = 1.0 / 3.0;
/// Least variance that footprints of a coarse raster have with the spline; narrower ones, the thin sides of long
/// voxels, are widened to it.
const LEAST_VARIANCE: f64 = 0.5;

impl SheetShape {
    /// The footprint of a kernel on a sheet at a depth, world length.
    pub fn new(shape: &FootprintShape, screen: &ScreenFromCamera, raster: &Raster, depth: f64) -> Self {
        let step = raster.step as f64;
        let scale = screen.scale_at(depth) / step;
        let [xx, xy, yy] = shape.lateral_covariance.map(|v| v * scale * scale);
        let area = (xx * yy - xy * xy).max(0.0);
        let wanted = raster.low_pass / (step * step);
        let add = if raster.matched {
            (wanted - xx.min(yy)).max(0.0)
        } else {
            wanted
        };
        let (mut xx, mut yy) = (xx + add, yy + add);
        if raster.step > 1 {
            let narrowest = 0.5 * (xx + yy - libm::hypot(xx - yy, 2.0 * xy));
            let lacking = (LEAST_VARIANCE - narrowest).max(0.0) - SPLINE_VARIANCE;
            (xx, yy) = (xx + lacking, yy + lacking);
        }
        let determinant = xx * yy - xy * xy;
        let half = 0.5 * std::f64::consts::LOG2_E / determinant;
        Self {
            depth: depth as f32,
            scale: scale as f32,
            exponent: [yy * half, -2.0 * xy * half, xx * half].map(|e| e as f32),
            peak: (raster.peak * (area / determinant).sqrt()) as f32,
            low_pass: (add / (scale * scale)) as f32,
        }
    }

    /// Half widths of the box around the ellipse at `cut` standard deviations, raster points.
    pub fn half_extent(&self, cut: f32) -> [f32; 2] {
        half_extent(self.exponent, cut)
    }
}

/// Half widths of the box around an ellipse with these exponents, given as [`SheetShape::exponent`], at `cut`
/// standard deviations.
pub fn half_extent(exponent: [f32; 3], cut: f32) -> [f32; 2] {
    let [xx, xy, yy] = exponent.map(|e| e * 2.0 * std::f32::consts::LN_2);
    let xy = 0.5 * xy;
    let determinant = xx * yy - xy * xy;
    [(yy / determinant).sqrt() * cut, (xx / determinant).sqrt() * cut]
}
