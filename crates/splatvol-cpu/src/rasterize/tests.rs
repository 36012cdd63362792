//! Every rasteriser against direct evaluation in f64, at every SIMD level of the machine.

use super::lattice::Lattice;
use super::{Footprint, Scratch, Sheet, Splats, ellipse, splat};
use crate::kernels::levels;

const SIZE: [usize; 2] = [61, 47];

/// Numbers from 0 to 1 (PCG, O'Neill 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let word = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        word.rotate_right((self.0 >> 59) as u32) as f32 / u32::MAX as f32
    }
}

/// Splats within and around a sheet.
struct Cloud<const CHANNELS: usize> {
    x: Vec<f32>,
    y: Vec<f32>,
    weights: Vec<[f32; CHANNELS]>,
}

impl<const CHANNELS: usize> Cloud<CHANNELS> {
    fn new(count: usize, size: [usize; 2], seed: u64) -> Self {
        let mut random = Random(seed);
        let mut along = |length: usize| (random.next() * 1.6 - 0.3) * length as f32;
        let (x, y) = (0..count).map(|_| (along(size[0]), along(size[1]))).unzip();
        let mut weight = [0.0; CHANNELS];
        let weights = (0..count)
            .map(|_| {
                weight.fill_with(|| random.next() - 0.25);
                weight
            })
            .collect();
        Self { x, y, weights }
    }

    fn splats(&self) -> Splats<'_, CHANNELS> {
        Splats {
            x: &self.x,
            y: &self.y,
            weights: &self.weights,
        }
    }

    /// What a pixel should hold; `cut`: within the footprint's box only.
    fn exact(&self, footprint: &Footprint, [x, y]: [usize; 2], cut: bool) -> [f64; CHANNELS] {
        let [xx, xy, yy] = footprint.conic.map(f64::from);
        let [rx, ry] = footprint.reach;
        let mut sum = [0.0; CHANNELS];
        for ((&cx, &cy), weights) in self.x.iter().zip(&self.y).zip(&self.weights) {
            let inside = (x as f32 + 0.5 - cx).abs() <= rx && (y as f32 + 0.5 - cy).abs() <= ry;
            if cut && !inside {
                continue;
            }
            let (dx, dy) = (x as f64 + 0.5 - f64::from(cx), y as f64 + 0.5 - f64::from(cy));
            let value = (-0.5 * (xx * dx * dx + 2.0 * xy * dx * dy + yy * dy * dy)).exp();
            for (sum, weight) in sum.iter_mut().zip(weights) {
                *sum += f64::from(*weight) * value;
            }
        }
        sum
    }

    fn worst(&self, sheet: &Sheet<CHANNELS>, footprint: &Footprint, cut: bool) -> f64 {
        let [width, height] = sheet.size();
        let mut worst = 0.0f64;
        for y in 0..height {
            for x in 0..width {
                let exact = self.exact(footprint, [x, y], cut);
                let found = sheet.pixel(x, y).unwrap();
                for (exact, found) in exact.into_iter().zip(found) {
                    worst = worst.max((exact - f64::from(found)).abs());
                }
            }
        }
        worst
    }
}

fn agrees<const CHANNELS: usize>(footprint: &Footprint, tolerance: f64) {
    let cloud = Cloud::<CHANNELS>::new(37, SIZE, 5);
    for (name, level) in levels() {
        let mut sheet = Sheet::new(SIZE);
        splat(
            level,
            &mut sheet,
            footprint,
            &cloud.splats(),
            &mut Scratch::default(),
        );
        let worst = cloud.worst(&sheet, footprint, true);
        assert!(
            worst < tolerance,
            "{name}, {CHANNELS} channels, {footprint:?}: {worst}"
        );
    }
}

/// Off half integers: a pixel on the box's very edge may fall to either side.
const RADII: [f32; 7] = [0.3, 1.13, 2.03, 4.03, 8.03, 16.03, 70.3];

#[test]
fn round_footprints_agree_with_direct_evaluation() {
    for radius in RADII {
        let footprint = Footprint::round(radius / 3.4, radius);
        agrees::<1>(&footprint, 3e-5);
        agrees::<4>(&footprint, 3e-5);
    }
}

#[test]
fn ellipses_agree_with_direct_evaluation() {
    for radius in RADII {
        let sigma = (radius / 3.4).powi(2);
        for [x, both, y] in [
            [1.0, 0.4, 0.6],
            [0.5, -0.5, 1.0],
            [1.0, 1e-3, 1.0],
            [1.0, 0.93, 0.9],
        ] {
            let footprint = Footprint::of_covariance([x * sigma, both * sigma, y * sigma], 3.4);
            agrees::<1>(&footprint, 2e-4);
            agrees::<4>(&footprint, 2e-4);
        }
    }
}

#[test]
fn narrow_oblique_ellipses_are_evaluated_directly() {
    let narrow = Footprint::of_covariance([9.0, 8.97, 9.0], 3.4);
    assert!(!ellipse::is_tame(&narrow));
    assert!(ellipse::is_tame(&Footprint::of_covariance([9.0, 5.0, 9.0], 3.4)));
    agrees::<1>(&narrow, 3e-5);
    agrees::<4>(&narrow, 3e-5);
}

#[test]
fn weird_splats_leave_other_pixels_alone() {
    let footprint = Footprint::round(1.0, 3.4);
    let places = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, 1e9];
    for (name, level) in levels() {
        for oblique in [0.0, 0.2] {
            let mut footprint = footprint;
            footprint.conic[1] = oblique;
            let mut sheet = Sheet::<1>::new(SIZE);
            let weights = [[1.0]; 6];
            for (x, y) in [(&places, &[20.0; 6]), (&[20.0; 6], &places)] {
                let splats = Splats {
                    x,
                    y,
                    weights: &weights,
                };
                splat(level, &mut sheet, &footprint, &splats, &mut Scratch::default());
            }
            let all = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
            let touched = all.filter(|&(x, y)| sheet.pixel(x, y) != Some([0.0])).count();
            assert_eq!(touched, 0, "{name}");
        }
    }
}

#[test]
fn nothing_is_denormal() {
    for (name, level) in levels() {
        for radius in [1.0, 4.0, 16.0] {
            for both in [0.0, 0.5, 0.99] {
                let sigma: f32 = radius / 6.0;
                let footprint =
                    Footprint::of_covariance([sigma * sigma, both * sigma * sigma, sigma * sigma], 6.0);
                let mut sheet = Sheet::<1>::new(SIZE);
                let splats = Splats {
                    x: &[30.2],
                    y: &[20.1],
                    weights: &[[1.0]],
                };
                splat(level, &mut sheet, &footprint, &splats, &mut Scratch::default());
                for y in 0..SIZE[1] {
                    for x in 0..SIZE[0] {
                        let [value] = sheet.pixel(x, y).unwrap();
                        assert!(
                            !value.is_subnormal() && value.is_finite(),
                            "{name} {x} {y}: {value}"
                        );
                    }
                }
            }
        }
    }
}

fn lattice_agrees<const CHANNELS: usize>(covariance: [f32; 3], exponent: u32) -> f64 {
    let size = [150, 131];
    let footprint = Footprint::of_covariance(covariance, 4.5);
    assert_eq!(
        Lattice::<CHANNELS>::coarsest(&footprint),
        exponent,
        "{covariance:?}"
    );
    let cloud = Cloud::<CHANNELS>::new(8, size, 11);
    let mut worst = 0.0f64;
    for (_, level) in levels() {
        let mut sheet = Sheet::new(size);
        let mut lattice = Lattice::new(size, exponent);
        assert!(lattice.splat(level, &footprint, &cloud.splats(), &mut Scratch::default()));
        lattice.resolve(level, &mut sheet);
        worst = worst.max(cloud.worst(&sheet, &footprint, false));
    }
    worst
}

#[test]
fn the_lattice_agrees_with_direct_evaluation() {
    // Worst pixel of eight splats of peaks to 3/4; the least favourable sigma, two cells, comes first.
    for (covariance, exponent, tolerance) in [
        ([16.0, 0.0, 16.0], 1, 1e-3),
        ([64.0, 0.0, 64.0], 2, 1e-3),
        ([257.0, 0.0, 257.0], 3, 1e-3),
        ([355.0, 0.0, 355.0], 3, 5e-4),
        ([355.0, 120.0, 290.0], 2, 5e-4),
    ] {
        let worst = lattice_agrees::<1>(covariance, exponent).max(lattice_agrees::<4>(covariance, exponent));
        println!("{covariance:?}, cells of {} pixels: {worst:.1e}", 1 << exponent);
        assert!(worst < tolerance, "{covariance:?}: {worst}");
    }
}

#[test]
fn a_narrow_footprint_is_refused_by_the_lattice() {
    let mut lattice = Lattice::<1>::new(SIZE, 3);
    let splats = Splats {
        x: &[10.0],
        y: &[10.0],
        weights: &[[1.0]],
    };
    let narrow = Footprint::round(4.0, 12.0);
    assert!(!lattice.splat(levels()[0].1, &narrow, &splats, &mut Scratch::default()));
}
