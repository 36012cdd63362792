//! Extents: width of a frame's footprints at each depth, and the rasters that hold them.
//!
//! A raster with a point every 2^n pixels, splined to pixels (`upsample`), holds footprints with a standard
//! deviation between [`Widths::narrowest`] and [`Widths::widest`] points. In perspective footprints grow as 1 / z
//! towards the camera: a frame whose nearest and farthest footprints fit these limits has one raster, others have
//! zones (`zones`).

use glam::DVec2;
use splatvol_scene::{Filter, Gradient, ImageSize, RenderSettings, ScreenFromCamera, SheetSettings};

use super::blocks::{BELOW_CUT, Room, TRIMMED};
use super::raster::{Raster, SheetShape};

/// Limits of the standard deviation of footprints, raster points, and their cut.
#[derive(Debug, Clone, Copy)]
pub(super) struct Widths {
    /// The narrowest that a spline reproduces.
    narrowest: f64,
    /// The narrowest where there are several zones: close to the eye raster points lie many pixels apart, and
    /// lighting shows the ripple of gradients between them.
    narrowest_in_zones: f64,
    /// The narrowest beyond which a coarser raster costs less.
    comfortable: f64,
    /// The widest that the largest blocks hold.
    widest: f64,
    /// Cut of footprints, once a low-pass or a spline has changed their width.
    pub cut: f64,
    /// Whether footprints are always cut there: they have any size rather than a narrower cut.
    pub is_exact: bool,
}

impl Widths {
    const SPLINED: Self = Self {
        narrowest: 0.8,
        narrowest_in_zones: 1.0,
        comfortable: 2.3,
        widest: 4.6,
        cut: 3.4,
        is_exact: false,
    };
    /// Analytic gradients: accurate to the last digits, with a wider cut, since a part left out on one side only
    /// tilts gradients.
    const EXACT: Self = Self {
        narrowest: 1.2,
        narrowest_in_zones: 1.2,
        comfortable: 3.6,
        widest: 3.6,
        cut: 4.4,
        is_exact: true,
    };

    /// Classified voxels with analytic gradients. Their sums are not divided by a sum of weights with the same
    /// errors of spline and cut: sheets converge to 1e-6 of full light, where the widths above leave 5e-6.
    const EXACT_COLORS: Self = Self {
        narrowest: 1.7,
        narrowest_in_zones: 1.7,
        comfortable: 3.4,
        widest: 3.4,
        cut: 4.6,
        is_exact: true,
    };

    pub(super) fn of(settings: &RenderSettings<SheetSettings>) -> Self {
        match settings.method.gradient {
            Gradient::Analytic if settings.method.splats_colors() => Self::EXACT_COLORS,
            Gradient::Analytic => Self::EXACT,
            Gradient::Differences => Self::SPLINED,
        }
    }
}

/// Octaves by which rounding makes widths differ.
const ROUNDING: f64 = 1e-6;
/// Octaves of the coarsest raster of a frame that has only one.
const MOST_OCTAVES: f64 = 6.0;
/// Tangent of the angle between ray and axis up to which blocks hold a voxel's footprints on all its sheets.
pub(super) const STEEP: f64 = 0.75;
/// Tangent up to which larger blocks do so.
const TOO_STEEP: f64 = 1.25;
/// Reaches of a voxel within which its sheets differ much in scale.
pub(super) const NEAR: f64 = 4.0;
/// Standard deviations of a footprint by which those of a voxel's farthest sheets, which weigh little, may lie beside the others.
const SPARED: f64 = 2.5;
/// The same for displacements by the kernel's slope, which all voxels have alike.
const SPARED_BY_SLOPE: f64 = 0.8;
/// Width below which footprints without a low-pass fall between raster points.
const LEAST_UNFILTERED: f64 = 0.4;

/// Footprints of all depths, and the displacement between those of one voxel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extents {
    pub screen: ScreenFromCamera,
    /// Least and largest variance of footprints, world length squared.
    pub variances: [f64; 2],
    /// Low-pass variance, pixels squared, and whether footprints are only widened to it.
    pub low_pass: (f64, bool),
    pub widths: Widths,
    /// Peak of the kernel at its centre, without low-pass.
    pub peak: f64,
    /// Tangent of the widest angle between a pixel's ray and the axis.
    pub steepest: f64,
    /// Voxels are integrated along rays: a sheet is the slab before its plane.
    pub along_rays: bool,
    /// Reach of a voxel in depth, world length.
    pub reach: f64,
    /// Displacement of a voxel's footprints on its nearest and farthest sheets from the middle of all, by the kernel's slope,
    /// world length along x and y.
    pub shear: [f64; 2],
    /// Whether footprints are circles that lie behind each other.
    pub is_round: bool,
    /// Distance in depth of these sheets from the middle of all, world length.
    pub between: f64,
}

/// Low-pass of a filter: variance, pixels squared, and whether footprints are only widened to it.
pub fn low_pass(filter: Filter) -> (f64, bool) {
    match filter {
        // Footprints that are scaled belong to another engine.
        Filter::None | Filter::Swan | Filter::SwanAlpha => (0.0, false),
        Filter::Ewa { pixel_sigma } => (pixel_sigma * pixel_sigma, false),
        Filter::Matched { pixel_sigma } => (pixel_sigma * pixel_sigma, true),
    }
}

/// Least and largest variance of covariances xx, xy, yy.
pub(super) fn variances(covariances: &[[f64; 3]]) -> [f64; 2] {
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    for [xx, xy, yy] in covariances {
        let (mean, difference) = (0.5 * (xx + yy), (0.25 * (xx - yy).powi(2) + xy * xy).sqrt());
        (least, most) = (least.min(mean - difference), most.max(mean + difference));
    }
    [least, most]
}

/// Tangent of the widest angle between a pixel's ray and the axis.
pub(super) fn steepest(screen: &ScreenFromCamera, size: ImageSize) -> f64 {
    if !screen.perspective {
        return 0.0;
    }
    let size = DVec2::new(f64::from(size.width()), f64::from(size.height()));
    screen.centre.max(size - screen.centre).length() / screen.scale
}

impl Extents {
    /// Room for footprints, relative to their own: along a ray of slope t a round kernel is `sqrt(1 + t^2)` times
    /// as wide.
    fn room(&self) -> f64 {
        let steep = (1.0 + STEEP * STEEP).sqrt();
        if self.along_rays || self.steepest <= STEEP || self.is_too_steep() {
            1.0
        } else {
            (1.0 + self.steepest * self.steepest).sqrt() / steep
        }
    }

    /// Whether footprints of a voxel's sheets lie too far apart for one square of blocks.
    pub(super) fn is_too_steep(&self) -> bool {
        !self.along_rays && self.steepest > TOO_STEEP
    }

    /// Room for the footprints of a voxel's sheets: half the distance between footprints on neighbouring sheets for rays
    /// that are not steep, the kernel's slope, and a factor.
    pub(super) fn room_of_footprints(&self, spacing: f64) -> Room {
        let of_rays = match self.room_of_deep_voxels() {
            Some(room) => room,
            None if self.along_rays => 0.5 * self.steepest * spacing,
            None => 0.5 * self.steepest.min(STEEP) * spacing,
        };
        Room {
            around: self.shear_to_hold().map(|shear| (of_rays + shear) as f32),
            factor: self.room() as f32,
        }
    }

    /// Room for the distance of footprints on a voxel's sheets along rays, world length, where that is more than footprints
    /// can spare: where voxels are much deeper than wide.
    fn room_of_deep_voxels(&self) -> Option<f64> {
        let apart = self.steepest.min(STEEP) * self.between;
        let spared = SPARED * self.variances[0].sqrt();
        (apart > spared).then_some(apart)
    }

    /// The displacement by the kernel's slope for which blocks need room.
    fn shear_to_hold(&self) -> [f64; 2] {
        let spared = SPARED_BY_SLOPE * self.variances[0].sqrt();
        self.shear.map(|shear| (shear - spared).max(0.0))
    }

    /// Room for long voxels alone.
    pub(super) fn room_of_long_voxels(&self) -> Room {
        let of_rays = self.room_of_deep_voxels().unwrap_or(0.0);
        Room {
            around: self.shear_to_hold().map(|shear| (of_rays + shear) as f32),
            factor: 1.0,
        }
    }

    /// Whether footprints are so long that a raster for their length is too coarse for their width.
    pub(super) fn are_elongated(&self) -> bool {
        let [least, most] = self.variances;
        let Widths {
            comfortable,
            narrowest_in_zones,
            ..
        } = self.widths;
        !self.along_rays && (most / least).sqrt() > comfortable / narrowest_in_zones
    }

    /// Whether footprints of a voxel's sheets lie beside each other, so that blocks must hold them whole.
    pub(super) fn are_long(&self) -> bool {
        self.shear_to_hold().iter().any(|&shear| shear > 0.0) || self.room_of_deep_voxels().is_some()
    }

    /// Displacement of footprints' centres within a voxel's sheets along a ray of a slope, world length.
    pub(super) fn drift(&self, slope: f64) -> f32 {
        if self.along_rays {
            0.0
        } else {
            // Ellipses count from the middle of the sheets.
            let reach = if self.is_round { self.reach } else { self.between };
            (slope * reach) as f32
        }
    }

    /// The displacement for voxels whose footprints, of so many blocks on a sheet of this scale, just reach the
    /// picture from outside.
    pub(super) fn drift_of_footprints(&self, sheet: &SheetShape, blocks: f32) -> f32 {
        let outside = std::f64::consts::SQRT_2 * f64::from((blocks + 2.0) / sheet.scale);
        let slope = match self.screen.perspective {
            true => self.steepest + outside / f64::from(sheet.depth),
            false => 0.0,
        };
        self.drift(slope)
    }

    /// Standard deviation of footprints of a variance at a depth, pixels.
    fn width(&self, variance: f64, depth: f64) -> f64 {
        let scale = self.screen.scale_at(depth);
        let variance = variance * scale * scale;
        let (low_pass, matched) = self.low_pass;
        let filtered = if matched {
            variance.max(low_pass)
        } else {
            variance + low_pass
        };
        filtered.sqrt()
    }

    /// Standard deviation of the narrowest footprints at a depth, pixels.
    pub(super) fn narrowest(&self, depth: f64) -> f64 {
        self.width(self.variances[0], depth)
    }

    /// Octaves of the finest raster that holds the footprints of a depth, and of the comfortable one.
    pub(super) fn finest_and_comfortable(&self, depth: f64) -> [f64; 2] {
        let widest = self.width(self.variances[1], depth) * self.room();
        let Widths {
            comfortable,
            widest: most,
            ..
        } = self.widths;
        [most, comfortable].map(|most| libm::log2(widest / most).ceil().max(0.0))
    }

    /// Octaves of the coarsest raster that reproduces the footprints of a depth.
    pub(super) fn coarsest(&self, depth: f64) -> f64 {
        let points = self.narrowest(depth) / self.widths.narrowest_in_zones;
        libm::log2(points).floor().max(0.0)
    }

    /// Narrowest footprints that a raster of so many octaves reproduces, pixels.
    pub(super) fn least(&self, octaves: f64) -> f64 {
        self.widths.narrowest_in_zones * libm::exp2(octaves)
    }

    /// Whether the sheets of a voxel at a depth differ much in scale.
    pub(super) fn is_near(&self, depth: f64) -> bool {
        self.screen.perspective && !self.along_rays && depth < NEAR * self.reach
    }

    pub(super) fn raster(&self, octaves: f64) -> Raster {
        let (low_pass, matched) = self.low_pass;
        Raster {
            step: libm::exp2(octaves) as usize,
            low_pass,
            matched,
            peak: self.peak,
        }
    }

    /// One raster for footprints between two depths, if there is one: as coarse as the far end allows, but not
    /// coarser than the near end needs, which keeps footprints small.
    pub(super) fn one_raster(&self, [near, far]: [f64; 2]) -> Option<Raster> {
        let widest = self.width(self.variances[1], near) * self.room();
        let narrowest = self.narrowest(far);
        // Between two rasters, rounding must not choose: pictures of a turning camera would flicker.
        let octaves_to = |most: f64| (libm::log2(widest / most) - ROUNDING).ceil();
        let (finest, wanted) = (
            octaves_to(self.widths.widest),
            octaves_to(Widths::SPLINED.comfortable),
        );
        let coarsest = (libm::log2(narrowest / self.widths.narrowest) + ROUNDING).floor();
        let octaves = wanted.max(finest).min(coarsest).clamp(0.0, MOST_OCTAVES);
        if octaves < finest {
            return None;
        }
        let unfiltered = self.low_pass.0 == 0.0;
        (!unfiltered || narrowest >= LEAST_UNFILTERED * libm::exp2(octaves)).then(|| self.raster(octaves))
    }
}

/// Exponents to base 2 that floats hold, with room for a weight.
const LARGEST_EXPONENT: f32 = 126.0;

/// Whether the powers of round footprints, counted from their first block, fit f32. `drift`: displacement of
/// centres within a voxel's sheets, world length.
pub(super) fn round_powers_fit(shape: &SheetShape, blocks: f32, drift: f32) -> bool {
    let steepest = shape.exponent[0].max(shape.exponent[2]);
    // Centres lie up to half a point behind the middle.
    let offset = blocks + 0.5 + drift * shape.scale;
    2.0 * steepest * offset * offset.max(2.0 * blocks - 1.0) < LARGEST_EXPONENT
}

/// What the powers of ellipses depend on beside their shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ellipses {
    /// Displacement of centres within a voxel's sheets by rays, and by the kernel's slope along x and y, world length.
    pub drift: f32,
    pub shear: [f64; 2],
    /// Cut of footprints, standard deviations.
    pub cut: f32,
    /// Whether they are turned by the ray, each tile's by its own.
    pub along_rays: bool,
}

impl Ellipses {
    /// Whether the powers, counted from the middle block, fit f32 for all ellipses between the nearest, of so many blocks, and the
    /// narrowest of a frame; those of long and thin ones on a fine raster may not.
    pub(super) fn powers_fit(&self, [near, narrowest]: [&SheetShape; 2], blocks: f32) -> bool {
        let offset = 1.0 + self.drift * near.scale;
        let [xx, xy, yy] = narrowest.exponent.map(f32::abs);
        if self.along_rays {
            let steepest = 0.5 * (xx + yy + libm::hypotf(xx - yy, xy));
            let offset = std::f32::consts::SQRT_2 * offset;
            return 2.0 * steepest * offset * blocks < LARGEST_EXPONENT;
        }
        let reach = (self.cut * self.cut + 2.0 * BELOW_CUT * std::f32::consts::LN_2).sqrt();
        let half = near.half_extent(reach);
        let shifts = self.shear.map(|shear| shear as f32 * near.scale);
        // Raster points from the origin to the blocks that are needed.
        let [columns, rows]: [f32; 2] = std::array::from_fn(|axis| match blocks < TRIMMED as f32 {
            true => blocks + 1.0,
            false => (half[axis] + shifts[axis] + offset + 3.0).min(blocks + 1.0),
        });
        let [across, down] = [xx, yy].map(|own| (2.0 * own + xy) * offset);
        let apart = across * (shifts[0] + 0.5) + down * (shifts[1] + 0.5);
        let fits = |exponent: f32| exponent < LARGEST_EXPONENT;
        fits(across * columns) && fits(down * rows + apart) && fits(apart + (xx + xy + yy) * offset * offset)
    }
}
