//! The profile of any radial kernel: [`RadialKernel`]'s line integrals in units of its standard deviation.
//!
//! With s the standard deviation, the kernel of unit variance is `s^3 h(s x)`, so `q(0) = s^2 int h dz`, and the
//! cut is the support over s. Parts between depths come from the cumulative
//! `C(u, t) = int_-inf^t h dz / int h(0) dz` on a lattice in `u = r^2` and in depth, with linear interpolation.
//! Rasterisers with tables (huang2000 section 3) use only the cut and peak from here.

use splatvol_scene::Kernel;

use super::profile::Profile;
use crate::radial::RadialKernel;

/// Cells of the lattice from the centre to the cut, in the squared distance.
const CELLS: usize = 256;
/// Cells of the lattice from the front of the kernel to its back.
const ROWS: usize = 128;

/// Footprints of a radial kernel.
#[derive(Debug, Clone)]
pub struct RadialProfile {
    cut: f32,
    peak: f32,
    sigma: f64,
    /// Cells per squared standard deviation, rows per standard deviation.
    density: [f32; 2],
    /// Row after row of `CELLS + 2` points, the last ones zero.
    cumulative: Vec<f32>,
}

impl RadialProfile {
    /// The profile of a kernel whose parameters are within their domain ([`Kernel::validate`]). Construction takes
    /// some 0.02 s.
    pub fn new(kernel: Kernel) -> Self {
        let radial = RadialKernel::new(kernel);
        let (sigma, support) = (radial.sigma(), radial.support());
        let centre = radial.line_integral(0.0);
        let cut = support / sigma;
        let point = |row: usize, cell: usize| {
            let rho2 = support * support * (cell as f64 / CELLS as f64).min(1.0);
            let depth = support * (2.0 * row as f64 / ROWS as f64 - 1.0);
            (radial.partial_line_integral(rho2, depth) / centre) as f32
        };
        let cumulative = (0..=ROWS)
            .flat_map(|row| (0..CELLS + 2).map(move |cell| (row, cell)))
            .map(|(row, cell)| point(row, cell))
            .collect();
        Self {
            cut: cut as f32,
            peak: (centre * sigma * sigma) as f32,
            sigma,
            density: [
                CELLS as f32 / (cut * cut) as f32,
                ROWS as f32 / (2.0 * cut) as f32,
            ],
            cumulative,
        }
    }

    /// Standard deviation of the kernel along an axis, voxels.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// The cell of a squared distance, and where in it; `None` beyond the cut.
    #[inline(always)]
    fn cell(&self, squared: f32) -> Option<(usize, f32)> {
        let position = squared * self.density[0];
        let cell = position as usize;
        (cell < CELLS).then_some((cell, position - cell as f32))
    }

    /// A row at a place between two of its points.
    #[inline(always)]
    fn row(&self, row: usize, (cell, fraction): (usize, f32)) -> f32 {
        let start = row * (CELLS + 2) + cell;
        match self.cumulative.get(start..start + 2) {
            Some(&[low, high]) => low + fraction * (high - low),
            _ => 0.0,
        }
    }

    /// Integral in front of a depth.
    #[inline(always)]
    fn below(&self, depth: f32, place: (usize, f32)) -> f32 {
        let position = (depth.clamp(-self.cut, self.cut) + self.cut) * self.density[1];
        let row = (position as usize).min(ROWS - 1);
        let (low, high) = (self.row(row, place), self.row(row + 1, place));
        low + (position - row as f32) * (high - low)
    }
}

impl Profile for RadialProfile {
    #[inline(always)]
    fn cut(&self) -> f32 {
        self.cut
    }

    #[inline(always)]
    fn peak(&self) -> f32 {
        self.peak
    }

    #[inline(always)]
    fn whole(&self, squared: f32) -> f32 {
        self.cell(squared).map_or(0.0, |place| self.row(ROWS, place))
    }

    #[inline(always)]
    fn between(&self, squared: f32, near: f32, far: f32) -> f32 {
        match self.cell(squared) {
            Some(place) => (self.below(far, place) - self.below(near, place)).max(0.0),
            None => 0.0,
        }
    }

    #[inline(always)]
    fn is_separable(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KERNELS: [Kernel; 4] = [
        Kernel::Gaussian {
            sigma: 0.602,
            radius: 2.0,
        },
        Kernel::CrawfisMax,
        Kernel::CubicBspline,
        Kernel::KAISER_BESSEL,
    ];

    /// All kernels but the Gaussian end smoothly; its footprint ends as a square root, which linear interpolation
    /// misses.
    #[test]
    fn profiles_are_the_kernels_line_integrals() {
        for kernel in KERNELS {
            let (profile, radial) = (RadialProfile::new(kernel), RadialKernel::new(kernel));
            let centre = radial.line_integral(0.0);
            let [mut whole, mut part] = [0.0_f64; 2];
            for i in 0..4000 {
                let share = f64::from(i) / 3999.0;
                let squared = share * f64::from(profile.cut()).powi(2);
                let rho2 = share * radial.support().powi(2);
                let exact = radial.line_integral(rho2) / centre;
                whole = whole.max((f64::from(profile.whole(squared as f32)) - exact).abs());
                let [near, far] = [f64::from(i % 37) / 20.0 - 1.1, f64::from(i % 53) / 25.0 - 1.0];
                let below = |depth: f64| radial.partial_line_integral(rho2, depth * radial.support());
                let exact = ((below(far) - below(near)) / centre).max(0.0);
                let cut = f64::from(profile.cut());
                let found = profile.between(squared as f32, (near * cut) as f32, (far * cut) as f32);
                part = part.max((f64::from(found) - exact).abs());
            }
            println!(
                "{}: whole within {whole:.1e}, parts within {part:.1e}",
                kernel.name()
            );
            let bound = if kernel.gaussian().is_some() { 1.2e-3 } else { 3e-4 };
            assert!(whole < bound && part < bound, "{kernel:?} {whole} {part}");
        }
    }

    #[test]
    fn the_disc_holds_all_mass() {
        for kernel in KERNELS {
            let profile = RadialProfile::new(kernel);
            let (cut, steps) = (f64::from(profile.cut()), 20_000);
            let mass: f64 = (0..steps)
                .map(|i| {
                    let r = cut * (f64::from(i) + 0.5) / f64::from(steps);
                    2.0 * std::f64::consts::PI * r * f64::from(profile.whole((r * r) as f32)) * cut
                        / f64::from(steps)
                })
                .sum();
            let mass = mass * f64::from(profile.peak());
            assert!((mass - 1.0).abs() < 2e-4, "{kernel:?}: {mass}");
            assert_eq!(profile.whole(1e9), 0.0);
            assert_eq!(profile.between(f32::NAN, -1.0, 1.0), 0.0);
        }
    }
}
