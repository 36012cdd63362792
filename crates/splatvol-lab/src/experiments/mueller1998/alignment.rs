//! Table 1 of mueller1998: a kernel in perspective space, five ways, and its integrals along the rays.
//!
//! Coordinates are the paper's: `z` along the viewing axis from the eye, `y` across it, in voxels; a ray is named by
//! where it meets the plane `z = z_k`, on which pixels are as far apart as voxels, so `y_p` counts pixels. The kernel
//! is `h(a, b) = exp(-1.38 (a^2 + b^2))`, cut at 2: the paper's "standard deviation of 1.38" is this factor, because
//! its bounds would not hold with that deviation. `s(z) = min(1, z_k / z)` undoes the stretch,
//! `dy = y_p z / z_k - y_v`, `dz = z - z_v`:
//!
//! | row | argument of `h` | factor | integral |
//! |---|---|---|---|
//! | 1, trapezoid | `s(z) dy, dz` | `s(z)` | along the ray |
//! | 2, box | `s(z_v) dy, dz` | `s(z_v)` | along the ray |
//! | 3, ideal ray-perpendicular | `s(z_v) (dy z_v - dz y_v) / r, (dz z_v + dy y_v) / r` | `s(z_v)` | along the ray |
//! | 4, practical ray-perpendicular | `s(z_v) r (z_v y_p - y_v z_k) / (z_v z_k + y_p y_v), dz` | `s(z_v)` | parallel |
//! | 5, grid-aligned | `s(z_v) (y_p z_v / z_k - y_v), dz` | `s(z_v)` | parallel |
//!
//! with `r = sqrt(y_v^2 + z_v^2)`. Corrections: row 3 is printed with `(x_v, y_v)` for `(y_v, z_v)` everywhere outside
//! `dy` and with squares of both in the sums; row 4 with a minus in the denominator, and with `x_v^2 + y_v^2` under the
//! root where it should have the sum of `y_v^2` and `z_v^2`. Integrals are in arc length, `sqrt(1 + (y_p / z_k)^2) dz`,
//! which the paper leaves open: in `dz` its bound of two levels off the axis near `z_k` would not hold, because row 4
//! would err by 40 there.

/// Factor of the exponent, as the paper's 1.38 must be read.
pub(super) const STEEPNESS: f64 = 1.38;

/// Cut-off of the kernel, voxels.
pub(super) const RADIUS: f64 = 2.0;

/// Standard deviation of the kernel, voxels.
pub(super) fn sigma() -> f64 {
    (0.5 / STEEPNESS).sqrt()
}

/// Choice of the integrals that make up a footprint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Row {
    /// Row 1: right.
    Trapezoid,
    /// Row 2: stretched by the factor that the centre needs.
    Box,
    /// Row 3.
    RayIdeal,
    /// Row 4.
    Ray,
    /// Row 5.
    Grid,
    /// Row 3 with the squares that are printed, all else corrected.
    SquaredRayIdeal,
    /// Row 3 without the squares, with `z_v` only in place of `x_v`, which does not exist in the plane of the axis and
    /// the voxel.
    SwappedRayIdeal,
    /// Row 4 with the minus that is printed.
    PrintedRay,
}

impl Row {
    /// The table's.
    pub(super) const TABLE: [Self; 5] = [Self::Trapezoid, Self::Box, Self::RayIdeal, Self::Ray, Self::Grid];

    /// Whether a footprint's table was integrated along parallel lines.
    fn parallel(self) -> bool {
        matches!(self, Self::Ray | Self::Grid | Self::PrintedRay)
    }
}

/// The kernel of a voxel, seen from the eye.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kernel {
    /// Across the axis, voxels.
    pub(super) y: f64,
    /// Along the axis, voxels.
    pub(super) z: f64,
    /// Depth where pixels are as far apart as voxels.
    pub(super) z_k: f64,
    /// Cut-off, voxels.
    pub(super) radius: f64,
    /// Factor of its exponent, per squared voxel.
    pub(super) steepness: f64,
}

impl Kernel {
    /// The paper's kernel.
    pub(super) fn new([y, z]: [f64; 2], z_k: f64) -> Self {
        Self {
            y,
            z,
            z_k,
            radius: RADIUS,
            steepness: STEEPNESS,
        }
    }

    /// Width of the kernel relative to its stretched self at a depth.
    fn unstretch(&self, z: f64) -> f64 {
        (self.z_k / z).min(1.0)
    }

    /// Intersection of the ray through the centre with the plane.
    pub(super) fn centre(&self) -> f64 {
        self.y * self.z_k / self.z
    }

    /// Largest half width of the footprint, pixels.
    pub(super) fn reach(&self) -> f64 {
        let slope = self.y / self.z;
        1.1 * self.radius * (1.0 + slope * slope) * (self.z_k / self.z).max(1.0)
    }

    /// The argument of `h`, and the factor before it.
    fn argument(&self, row: Row, y_p: f64, z: f64) -> ([f64; 2], f64) {
        let (y_v, z_v, z_k) = (self.y, self.z, self.z_k);
        let (dy, dz) = (y_p * z / z_k - y_v, z - z_v);
        let r = y_v.hypot(z_v);
        let s = self.unstretch(if row == Row::Trapezoid { z } else { z_v });
        let [across, along] = match row {
            Row::Trapezoid | Row::Box => [dy, dz],
            Row::RayIdeal => [(dy * z_v - dz * y_v) / r, (dz * z_v + dy * y_v) / r],
            Row::SquaredRayIdeal => [
                (dy * z_v * z_v - dz * y_v * y_v) / r,
                (dz * z_v * z_v + dy * y_v * y_v) / r,
            ],
            Row::SwappedRayIdeal => [(dy * y_v - dz * z_v) / r, (dz * y_v + dy * z_v) / r],
            Row::Ray => [r * (z_v * y_p - y_v * z_k) / (z_v * z_k + y_p * y_v), dz],
            Row::PrintedRay => [r * (z_v * y_p - y_v * z_k) / (z_v * z_k - y_p * y_v), dz],
            Row::Grid => [y_p * z_v / z_k - y_v, dz],
        };
        ([s * across, along], s)
    }

    /// Squared distance from the centre in the unstretched kernel.
    fn squared(&self, row: Row, y_p: f64, z: f64) -> f64 {
        let ([across, along], _) = self.argument(row, y_p, z);
        across * across + along * along
    }

    /// The kernel in perspective space, share of its height.
    pub(super) fn density(&self, row: Row, y_p: f64, z: f64) -> f64 {
        let (_, factor) = self.argument(row, y_p, z);
        let squared = self.squared(row, y_p, z);
        match squared < self.radius.powi(2) {
            true => factor * (-self.steepness * squared).exp(),
            false => 0.0,
        }
    }

    /// The integral that the footprint of a row has for a ray.
    pub(super) fn integral(&self, row: Row, y_p: f64) -> f64 {
        let squared = |z: f64| self.squared(row, y_p, z);
        let beyond = 4.0 * self.radius;
        let middle = least([self.z - beyond, self.z + beyond], squared);
        let cut = self.radius.powi(2);
        if squared(middle) >= cut {
            return 0.0;
        }
        let inside = |z: f64| squared(z) < cut;
        let ends = [self.z - 2.0 * beyond, self.z + 2.0 * beyond].map(|far| edge(middle, far, inside));
        let arc = match row.parallel() {
            true => 1.0,
            false => (y_p / self.z_k).hypot(1.0),
        };
        arc * simpson(ends, |z| {
            let (_, factor) = self.argument(row, y_p, z);
            factor * (-self.steepness * squared(z)).exp()
        })
    }

    /// Rays evenly over the footprint.
    pub(super) fn rays(&self, count: usize) -> impl Iterator<Item = f64> + use<> {
        let (centre, reach) = (self.centre(), self.reach());
        (0..count).map(move |i| centre + reach * (2.0 * i as f64 / (count - 1) as f64 - 1.0))
    }

    /// The errors of a row against row 1 over the footprint.
    pub(super) fn errors(&self, row: Row, rays: usize) -> Errors {
        let mut errors = Errors::default();
        for y_p in self.rays(rays) {
            let right = self.integral(Row::Trapezoid, y_p);
            errors.largest = errors.largest.max((self.integral(row, y_p) - right).abs());
            errors.peak = errors.peak.max(right);
        }
        errors
    }
}

/// Errors of a footprint's integrals.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Errors {
    /// Largest error, kernel heights times voxels.
    pub(super) largest: f64,
    /// Largest right integral, likewise.
    pub(super) peak: f64,
}

impl Errors {
    /// In levels of a footprint table of eight bits.
    pub(super) fn levels(self) -> f64 {
        256.0 * self.largest / self.peak
    }
}

/// Position of the minimum of a function with one minimum: golden section.
fn least([mut low, mut high]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    for _ in 0..48 {
        let part = GOLDEN * (high - low);
        match f(high - part) < f(low + part) {
            true => high = low + part,
            false => low = high - part,
        }
    }
    0.5 * (low + high)
}

/// Position, on the way to `far`, beyond which a test that holds at `within` fails: bisection.
fn edge(mut within: f64, mut far: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..48 {
        let middle = 0.5 * (within + far);
        match holds(middle) {
            true => within = middle,
            false => far = middle,
        }
    }
    within
}

/// Integral of a smooth function: Simpson's rule.
fn simpson([low, high]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    const PAIRS: usize = 24;
    let step = (high - low) / (2 * PAIRS) as f64;
    let weight = |i: usize| match i {
        0 => 1.0,
        i if i == 2 * PAIRS => 1.0,
        i if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let sum: f64 = (0..=2 * PAIRS)
        .map(|i| weight(i) * f(low + i as f64 * step))
        .sum();
    sum * step / 3.0
}

/// The paper's volume: 512 voxels a side, in a picture of 512 pixels within 30 degrees of the axis, a fifth of it
/// before `z_k`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting {
    /// Voxels and pixels.
    pub(super) side: f64,
    /// Depth where pixels are as far apart as voxels.
    pub(super) z_k: f64,
}

impl Setting {
    /// A volume of this many voxels in as many pixels.
    pub(super) fn new(side: f64) -> Self {
        let z_k = 0.5 * side / 30_f64.to_radians().tan();
        Self { side, z_k }
    }

    /// The kernel this far across the axis and behind `z_k`.
    pub(super) fn kernel(&self, across: f64, behind: f64) -> Kernel {
        Kernel::new([across, self.z_k + behind], self.z_k)
    }

    /// Ends of the volume before and behind `z_k`.
    pub(super) fn depths(&self) -> [f64; 2] {
        [-0.2 * self.side, 0.8 * self.side]
    }

    /// Half its side.
    pub(super) fn edge(&self) -> f64 {
        0.5 * self.side
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On the axis, before `z_k`, all rows are the Gaussian's own integral.
    #[test]
    fn integrals_are_those_of_a_gaussian() {
        let setting = Setting::new(512.0);
        let kernel = setting.kernel(0.0, -50.0);
        let whole = (std::f64::consts::TAU).sqrt() * sigma();
        for row in Row::TABLE {
            let found = kernel.integral(row, 0.0);
            // What lies beyond the cut is less than a thousandth.
            assert!((0.999 * whole..whole).contains(&found), "{row:?}: {found}");
        }
    }

    /// Row 2 in closed form: a Gaussian on a line, through a stretched kernel far off the axis.
    #[test]
    fn integrals_far_off_the_axis() {
        let setting = Setting::new(512.0);
        let kernel = Kernel {
            radius: 4.0,
            ..setting.kernel(256.0, 200.0)
        };
        let s = setting.z_k / kernel.z;
        for y_p in kernel.rays(15) {
            // The squared distance is `a z^2 + ..`: completed, its least value and curvature give the integral.
            let t = y_p / setting.z_k;
            let a = (s * t).powi(2) + 1.0;
            let b = -(s * s * t * kernel.y + kernel.z);
            let c = (s * kernel.y).powi(2) + kernel.z.powi(2);
            let least = c - b * b / a;
            let expected = s
                * t.hypot(1.0)
                * (std::f64::consts::PI / (STEEPNESS * a)).sqrt()
                * (-STEEPNESS * least).exp();
            let found = kernel.integral(Row::Box, y_p);
            assert!((found - expected).abs() < 1e-6, "{y_p}: {found} {expected}");
        }
    }
}
