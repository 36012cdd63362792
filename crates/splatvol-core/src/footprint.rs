//! The one footprint type: a Gaussian in camera space, factorised by depth.
//!
//! Whatever is splatted is a Gaussian kernel with centre u and covariance V' in camera space. We keep it as
//!
//! `N3(x; u, V') = N1(z; u_z, s_z^2) N2((x, y); (u_x, u_y) + slope (z - u_z), L)`
//!
//! with `s_z^2 = V'_zz`, `slope = V'_xyz / V'_zz` and `L = V'_xy - slope slope^T V'_zz`, because sheets have constant
//! depth, and on a plane of constant depth a perspective camera is a similarity of scale `s = f / z`. So a sheet
//! cuts the footprint in a **2-D Gaussian that is exact in both projections** ([`Slice`]), where zwicker2001
//! section 4.4 and design section 5 linearise the perspective map at the splat's centre: no Jacobian, no error
//! that grows with the field angle, and all voxels of a grid share one conic per sheet. The low-pass of
//! `pixel_sigma` pixels adds to the screen covariance, as in zwicker2001 eq. 22.
//!
//! * [`PlaneSlicer`]: the kernel *sampled* on a sheet's plane (post-classification).
//! * [`SlabSlicer`]: the kernel *integrated* over a sheet's depth: the part of the kernel inside the slab keeps its
//!   mass, mean and covariance (exactly, in orthographic views), the covariance along the ray being projected
//!   with `t = s (slope - (x, y) / z)`, the lateral drift of the footprint per depth as the pixel's ray sees it.
//!   Over the whole depth range this is the pre-integrated EWA footprint (zwicker2001 eq. 21-22); where slope and
//!   field angle vanish, FastSplats' sections (huang2000 section 2).

use glam::{DMat3, DVec2};
use splatvol_scene::ScreenFromCamera;

use crate::bin::TileRect;
use crate::normal::{self, SlabTable};

/// What footprints of one grid have in common: all but the centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootprintShape {
    /// Standard deviation in depth, world length.
    pub depth_sigma: f64,
    /// Drift of the centre (x, y) per depth.
    pub lateral_slope: DVec2,
    /// Covariance xx, xy, yy of x and y at a given depth, world length squared.
    pub lateral_covariance: [f64; 3],
    /// Integral of the kernel over space, world volume.
    pub mass: f64,
    /// Cut-off, standard deviations.
    pub cut: f64,
}

impl FootprintShape {
    /// Factorises a camera-space covariance.
    pub fn new(covariance: DMat3, mass: f64, cut: f64) -> Self {
        let depth_variance = covariance.z_axis.z;
        let slope = covariance.z_axis.truncate() / depth_variance;
        // A rotated sphere is a sphere but for rounding; exact zeros let rasterizers separate x from y.
        let scale = (covariance.x_axis.x + covariance.y_axis.y + depth_variance) * 1e-9;
        let clean = |value: f64, threshold: f64| if value.abs() < threshold { 0.0 } else { value };
        let slope = slope.map(|s| clean(s, scale / depth_variance));
        let drift = slope * slope * depth_variance;
        Self {
            depth_sigma: depth_variance.sqrt(),
            lateral_slope: slope,
            lateral_covariance: [
                covariance.x_axis.x - drift.x,
                clean(covariance.x_axis.y - slope.x * slope.y * depth_variance, scale),
                covariance.y_axis.y - drift.y,
            ],
            mass,
            cut,
        }
    }

    /// How far the kernel reaches in depth, world length.
    pub fn depth_reach(&self) -> f64 {
        self.cut * self.depth_sigma
    }

    /// How far the kernel reaches in x and y at any depth it has, world length, without the low-pass.
    pub fn lateral_reach(&self) -> DVec2 {
        let [xx, _, yy] = self.lateral_covariance;
        self.cut * (DVec2::new(xx, yy).max(DVec2::ZERO)).map(f64::sqrt)
            + self.lateral_slope.abs() * self.depth_reach()
    }
}

/// A footprint on a sheet: a 2-D Gaussian in pixels,
/// `weight exp(-d^T Q d / 2)` for `|d| <= half_extent`, d the pixel's offset from `centre`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slice {
    /// Centre, pixels.
    pub centre: [f32; 2],
    /// Conic Q: xx, xy, yy, 1 / pixels squared.
    pub conic: [f32; 3],
    /// Half widths of the box around the cut ellipse, pixels.
    pub half_extent: [f32; 2],
    /// Value at the centre: a kernel value on planes, a line integral per depth in slabs (world length).
    pub weight: f32,
    /// Camera depth of the plane, or mean depth of the kernel's part in the slab.
    pub depth: f32,
}

/// Screen covariance to conic, box and the factor `1 / (2 pi sqrt|V|)`.
fn conic_of([xx, xy, yy]: [f64; 3], cut: f64) -> ([f64; 3], [f64; 2], f64) {
    let determinant = (xx * yy - xy * xy).max(f64::MIN_POSITIVE);
    let conic = [yy / determinant, -xy / determinant, xx / determinant];
    let half_extent = [cut * xx.sqrt(), cut * yy.sqrt()];
    (
        conic,
        half_extent,
        1.0 / (2.0 * std::f64::consts::PI * determinant.sqrt()),
    )
}

/// Slices footprints by one plane of constant depth.
#[derive(Debug, Clone, Copy)]
pub struct PlaneSlicer {
    depth: f32,
    reach: f32,
    scale: f32,
    slope: [f32; 2],
    principal: [f32; 2],
    conic: [f32; 3],
    half_extent: [f32; 2],
    peak: f32,
    inverse_variance: f32,
}

impl PlaneSlicer {
    /// Slicer for the plane at camera depth `depth` (positive in perspective).
    pub fn new(shape: &FootprintShape, screen: &ScreenFromCamera, pixel_sigma: f64, depth: f64) -> Self {
        let scale = screen.scale_at(depth);
        let [xx, xy, yy] = shape.lateral_covariance.map(|v| v * scale * scale);
        let low_pass = pixel_sigma * pixel_sigma;
        let (conic, half_extent, density) = conic_of([xx + low_pass, xy, yy + low_pass], shape.cut);
        let depth_density = normal::density(0.0) / shape.depth_sigma;
        Self {
            depth: depth as f32,
            reach: shape.depth_reach() as f32,
            scale: scale as f32,
            slope: shape.lateral_slope.as_vec2().to_array(),
            principal: screen.centre.as_vec2().to_array(),
            conic: conic.map(|q| q as f32),
            half_extent: half_extent.map(|r| r as f32),
            peak: (shape.mass * depth_density * density * scale * scale) as f32,
            inverse_variance: (shape.depth_sigma.powi(-2)) as f32,
        }
    }

    /// Depth from a splat's centre to the plane.
    #[inline]
    pub fn offset(&self, centre_depth: f32) -> f32 {
        self.depth - centre_depth
    }

    /// Whether a splat reaches a plane at this offset.
    #[inline]
    pub fn reaches(&self, offset: f32) -> bool {
        offset.abs() <= self.reach
    }

    /// Whether a plane at this offset, and all behind it, lies beyond what a splat reaches.
    #[inline]
    pub fn is_past(&self, offset: f32) -> bool {
        offset > self.reach
    }

    /// Whether the slice of a footprint centred at camera `[x, y]` can cover pixel centres of a rectangle.
    #[inline]
    pub fn touches(&self, centre: [f32; 2], offset: f32, rect: &TileRect) -> bool {
        let [cx, cy] = self.centre(centre, offset);
        let [rx, ry] = self.half_extent;
        (cx + rx >= rect.x0 as f32)
            & (cx - rx <= rect.x1 as f32)
            & (cy + ry >= rect.y0 as f32)
            & (cy - ry <= rect.y1 as f32)
    }

    #[inline]
    fn centre(&self, [x, y]: [f32; 2], offset: f32) -> [f32; 2] {
        [
            self.scale * (x + self.slope[0] * offset) + self.principal[0],
            self.scale * (y + self.slope[1] * offset) + self.principal[1],
        ]
    }

    /// The slice of a footprint centred at camera `[x, y]`, `offset` in front of the plane.
    #[inline]
    pub fn slice(&self, centre: [f32; 2], offset: f32) -> Slice {
        Slice {
            centre: self.centre(centre, offset),
            conic: self.conic,
            half_extent: self.half_extent,
            weight: self.peak * libm::expf(-0.5 * self.inverse_variance * offset * offset),
            depth: self.depth,
        }
    }

    /// `d ln N1 / dz` at `offset`: what multiplies a slice's weight to give its derivative in depth at fixed (x, y),
    /// apart from the drift by `lateral_slope`.
    #[inline]
    pub fn depth_derivative(&self, offset: f32) -> f32 {
        -self.inverse_variance * offset
    }

    /// Camera depth of the plane.
    pub fn depth(&self) -> f32 {
        self.depth
    }

    /// Pixels per world length on the plane.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Drift of the centre (x, y) per depth.
    pub fn lateral_slope(&self) -> [f32; 2] {
        self.slope
    }
}

/// Slices footprints by slabs between two depths.
#[derive(Debug, Clone)]
pub struct SlabSlicer {
    screen: ScreenFromCamera,
    slope: [f32; 2],
    covariance: [f32; 3],
    depth_sigma: f32,
    low_pass: f32,
    cut: f32,
    mass: f32,
    table: SlabTable,
}

impl SlabSlicer {
    /// Slicer for all slabs of a frame.
    pub fn new(shape: &FootprintShape, screen: &ScreenFromCamera, pixel_sigma: f64) -> Self {
        // What the cut takes away in x and y is given back, so that slabs share out all of the kernel's mass.
        let mass = shape.mass / normal::mass_within(shape.cut).powi(2);
        Self {
            screen: *screen,
            slope: shape.lateral_slope.as_vec2().to_array(),
            covariance: shape.lateral_covariance.map(|v| v as f32),
            depth_sigma: shape.depth_sigma as f32,
            low_pass: (pixel_sigma * pixel_sigma) as f32,
            cut: shape.cut as f32,
            mass: mass as f32,
            table: SlabTable::new(shape.cut),
        }
    }

    /// Whether a slab holds some of what a splat at `centre_depth` reaches.
    #[inline]
    pub fn reaches(&self, centre_depth: f32, [near, far]: [f32; 2]) -> bool {
        let reach = self.cut * self.depth_sigma;
        (near - centre_depth < reach) & (far - centre_depth > -reach)
    }

    /// True where a slab that ends at `far` holds the last of what a splat at `centre_depth` reaches.
    #[inline]
    pub fn is_past(&self, centre_depth: f32, far: f32) -> bool {
        far - centre_depth >= self.cut * self.depth_sigma
    }

    /// The slice of a footprint centred at camera `[x, y, z]` by the slab between two depths; its weight is the
    /// integral of the kernel over depth. `None` where nothing of the kernel lies inside.
    #[inline]
    pub fn slice(&self, [x, y, z]: [f32; 3], [near, far]: [f32; 2]) -> Option<Slice> {
        let slab = self
            .table
            .between((near - z) / self.depth_sigma, (far - z) / self.depth_sigma)?;
        let shift = slab.mean * self.depth_sigma;
        let variance = slab.variance * self.depth_sigma * self.depth_sigma;
        let depth = z + shift;
        let (x, y) = (x + self.slope[0] * shift, y + self.slope[1] * shift);
        let (scale, drift) = if self.screen.perspective {
            if depth <= 0.0 {
                return None;
            }
            (
                self.screen.scale as f32 / depth,
                [self.slope[0] - x / depth, self.slope[1] - y / depth],
            )
        } else {
            (self.screen.scale as f32, self.slope)
        };
        let area = scale * scale;
        let covariance = [
            area * (self.covariance[0] + drift[0] * drift[0] * variance) + self.low_pass,
            area * (self.covariance[1] + drift[0] * drift[1] * variance),
            area * (self.covariance[2] + drift[1] * drift[1] * variance) + self.low_pass,
        ];
        let (conic, half_extent, density) = conic_of(covariance.map(f64::from), f64::from(self.cut));
        Some(Slice {
            centre: [
                scale * x + self.screen.centre.x as f32,
                scale * y + self.screen.centre.y as f32,
            ],
            conic: conic.map(|q| q as f32),
            half_extent: half_extent.map(|r| r as f32),
            weight: self.mass * slab.mass * density as f32 * area,
            depth,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn shape() -> FootprintShape {
        let m = DMat3::from_cols(
            DVec3::new(0.9, 0.2, -0.1),
            DVec3::new(-0.3, 1.4, 0.25),
            DVec3::new(0.1, -0.4, 2.2),
        );
        FootprintShape::new(m * m.transpose() * 0.49, 1.0, 4.3)
    }

    fn covariance(shape: &FootprintShape) -> DMat3 {
        let (t, z) = (shape.lateral_slope, shape.depth_sigma.powi(2));
        let [xx, xy, yy] = shape.lateral_covariance;
        DMat3::from_cols(
            DVec3::new(xx + t.x * t.x * z, xy + t.x * t.y * z, t.x * z),
            DVec3::new(xy + t.x * t.y * z, yy + t.y * t.y * z, t.y * z),
            DVec3::new(t.x * z, t.y * z, z),
        )
    }

    fn screens() -> [ScreenFromCamera; 2] {
        [true, false].map(|perspective| ScreenFromCamera {
            perspective,
            scale: if perspective { 300.0 } else { 9.0 },
            centre: DVec2::new(50.0, 40.0),
        })
    }

    fn at(slice: &Slice, pixel: DVec2) -> f64 {
        let d = pixel - DVec2::new(f64::from(slice.centre[0]), f64::from(slice.centre[1]));
        let [xx, xy, yy] = slice.conic.map(f64::from);
        f64::from(slice.weight) * (-0.5 * (xx * d.x * d.x + 2.0 * xy * d.x * d.y + yy * d.y * d.y)).exp()
    }

    /// The kernel itself, straight from its 3-D density.
    fn kernel(shape: &FootprintShape, offset: DVec3) -> f64 {
        let v = covariance(shape);
        let norm = shape.mass / ((2.0 * std::f64::consts::PI).powi(3) * v.determinant()).sqrt();
        norm * (-0.5 * offset.dot(v.inverse() * offset)).exp()
    }

    #[test]
    fn plane_slices_are_the_kernel_exactly_in_both_projections() {
        let shape = shape();
        let centre = DVec3::new(9.0, -7.0, 20.0);
        for screen in screens() {
            for depth in [18.7, 20.0, 22.9] {
                let slicer = PlaneSlicer::new(&shape, &screen, 0.0, depth);
                let offset = slicer.offset(centre.z as f32);
                assert!(slicer.reaches(offset));
                let slice = slicer.slice([centre.x as f32, centre.y as f32], offset);
                for i in 0..25 {
                    let shift = DVec2::new(f64::from(i % 5) - 2.0, f64::from(i / 5) - 2.0);
                    let point = DVec3::new(centre.x + 0.6 * shift.x, centre.y + 0.8 * shift.y, depth);
                    let expected = kernel(&shape, point - centre);
                    let found = at(&slice, screen.project(point));
                    assert!(
                        (found - expected).abs() < 2e-5 * kernel(&shape, DVec3::ZERO),
                        "{found} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn thin_slabs_converge_to_the_line_integral_of_the_kernel() {
        let shape = shape();
        let centre = DVec3::new(2.0, -3.0, 60.0);
        for screen in screens() {
            let slicer = SlabSlicer::new(&shape, &screen, 0.0);
            let pixel = screen.project(centre + DVec3::new(0.5, -0.6, 0.0));
            let (origin, ray) = screen.ray(pixel);
            let (near, far) = (centre.z - 12.0, centre.z + 12.0);
            let steps = 4000;
            let dz = (far - near) / f64::from(steps);
            let along =
                |i: i32| kernel(&shape, origin + ray * (near + (f64::from(i) + 0.5) * dz) - centre) * dz;
            let expected: f64 = (0..steps).map(along).sum();
            let total = |count: i32| -> f64 {
                let width = (far - near) / f64::from(count);
                (0..count)
                    .filter_map(|i| {
                        let z0 = near + f64::from(i) * width;
                        slicer.slice(centre.as_vec3().to_array(), [z0 as f32, (z0 + width) as f32])
                    })
                    .map(|slice| at(&slice, pixel))
                    .sum()
            };
            // One slab is the affine EWA footprint; thin slabs follow the ray.
            assert!(
                (total(1) / expected - 1.0).abs() < 0.02,
                "{} {expected}",
                total(1)
            );
            assert!(
                (total(96) / expected - 1.0).abs() < 2e-3,
                "{} {expected}",
                total(96)
            );
        }
    }

    #[test]
    fn slabs_keep_the_mass_under_any_division_and_low_pass() {
        let shape = shape();
        let screen = screens()[1];
        for pixel_sigma in [0.0, 0.5, 2.0] {
            let slicer = SlabSlicer::new(&shape, &screen, pixel_sigma);
            for width in [0.3, 1.0, 50.0] {
                let mut sum = 0.0;
                for i in -40..40 {
                    let near = 60.0 + width * i as f32;
                    let Some(slice) = slicer.slice([0.2, 0.1, 60.3], [near, near + width]) else {
                        continue;
                    };
                    let reach = slice.half_extent[0].max(slice.half_extent[1]).ceil() as i32;
                    for y in -reach..=reach {
                        for x in -reach..=reach {
                            let pixel = DVec2::new(
                                (f64::from(slice.centre[0]) + f64::from(x)).floor() + 0.5,
                                (f64::from(slice.centre[1]) + f64::from(y)).floor() + 0.5,
                            );
                            sum += at(&slice, pixel);
                        }
                    }
                }
                let mass = sum / screen.scale.powi(2);
                assert!((mass - 1.0).abs() < 3e-4, "{pixel_sigma} {width}: {mass}");
            }
        }
    }
}
