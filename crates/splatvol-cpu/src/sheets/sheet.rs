//! What a footprint is on each sheet of a frame, and what splatting needs of the four that it meets.
//!
//! On a sheet the kernel is `peak exp(-d^T Q d / 2) g(dz)`, d the pixel's offset from the footprint's centre there, which
//! is where the sheet cuts the line through the voxel along the kernel's conjugate axis: exact in perspective.

use splatvol_core::footprint::FootprintShape;
use splatvol_scene::ScreenFromCamera;

use super::ring::LANES;

/// One sheet's footprint.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SheetShape {
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

/// Lateral shape of the kernel and how it is rasterised.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Raster {
    /// Pixels from one raster point to the next.
    pub step: usize,
    /// Low-pass variance that is added to footprints, pixels squared; with `matched`, what they lack to it.
    pub low_pass: f64,
    pub matched: bool,
    /// Peak of the kernel at its centre, without low-pass.
    pub peak: f64,
}

impl Raster {
    /// A raster point per pixel, without a low-pass.
    pub(crate) const PIXELS: Self = Self {
        step: 1,
        low_pass: 0.0,
        matched: false,
        peak: 1.0,
    };
}

/// Variance that a cubic spline adds, raster points squared.
const SPLINE_VARIANCE: f64 = 1.0 / 3.0;
/// Least variance that footprints of a coarse raster have with the spline; narrower ones, the thin sides of long voxels, are
/// widened to it.
const LEAST_VARIANCE: f64 = 0.5;

impl SheetShape {
    pub(crate) fn new(
        shape: &FootprintShape,
        screen: &ScreenFromCamera,
        raster: &Raster,
        depth: f64,
    ) -> Self {
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
    pub(crate) fn half_extent(&self, cut: f32) -> [f32; 2] {
        half_extent(self.exponent, cut)
    }
}

/// Half widths of the box around an ellipse with these exponents, given as [`SheetShape::exponent`], at `cut` standard deviations.
pub(crate) fn half_extent(exponent: [f32; 3], cut: f32) -> [f32; 2] {
    let [xx, xy, yy] = exponent.map(|e| e * 2.0 * std::f32::consts::LN_2);
    let xy = 0.5 * xy;
    let determinant = xx * yy - xy * xy;
    [(yy / determinant).sqrt() * cut, (xx / determinant).sqrt() * cut]
}

/// A vector of sixteen numbers in memory.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub(crate) struct Lanes16(pub [f32; 16]);

impl Lanes16 {
    /// Sheet `i % 4` in lane i.
    fn of_sheets(value: impl Fn(usize) -> f32) -> Self {
        Self(std::array::from_fn(|lane| value(lane % LANES)))
    }
}

/// The four sheets of a group while the voxels of one slab are splatted.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GroupShape {
    pub depth: Lanes16,
    pub scale: Lanes16,
    /// Negative exponents: `log2` of the footprint is `xx dx^2 + xy dx dy + yy dy^2`.
    pub xx: Lanes16,
    pub xy: Lanes16,
    pub yy: Lanes16,
    pub peak: Lanes16,
}

impl GroupShape {
    /// One sheet in all lanes.
    pub(crate) fn same(sheet: &SheetShape) -> Self {
        let lanes = |value: f32| Lanes16([value; 16]);
        Self {
            depth: lanes(sheet.depth),
            scale: lanes(sheet.scale),
            xx: lanes(-sheet.exponent[0]),
            xy: lanes(-sheet.exponent[1]),
            yy: lanes(-sheet.exponent[2]),
            peak: lanes(sheet.peak),
        }
    }

    /// The group's sheets among `first..first + 4 groups`: lane l holds the one whose index is l, modulo the ring.
    pub(crate) fn new(sheets: &[SheetShape], first: isize, group: usize, groups: usize) -> Self {
        let open = (groups * LANES) as isize;
        let at = |lane: usize| {
            let slot = (group * LANES + lane) as isize;
            let index = first + (slot - first).rem_euclid(open);
            let valid = index >= 0 && (index as usize) < sheets.len();
            let nearest = (index.max(0) as usize).min(sheets.len() - 1);
            (sheets[nearest], valid)
        };
        let four: [_; LANES] = std::array::from_fn(at);
        let of = |pick: fn(&SheetShape) -> f32| Lanes16::of_sheets(|l| pick(&four[l].0));
        Self {
            depth: of(|s| s.depth),
            scale: of(|s| s.scale),
            xx: of(|s| -s.exponent[0]),
            xy: of(|s| -s.exponent[1]),
            yy: of(|s| -s.exponent[2]),
            peak: Lanes16::of_sheets(|l| if four[l].1 { four[l].0.peak } else { 0.0 }),
        }
    }
}
