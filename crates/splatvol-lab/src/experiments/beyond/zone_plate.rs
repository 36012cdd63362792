//! A zone plate, `f(r) = (1 + cos(k r^2)) / 2`: a sheet of voxels whose rings have every frequency, from none in the
//! middle to one cycle per pixel at the rim. A picture of it shows the effect of a filter on each frequency.
//!
//! A wave of nu cycles per pixel is passed with the amplitude
//!
//! - no filter: `H(nu / m)`, H the kernel's response and m voxels per pixel; what passes beyond nu = 1/2 is an alias
//! - ewa: `H(nu / m) exp(-2 pi^2 sigma^2 nu^2)` (zwicker2001 section 4.5)
//! - swan: the kernel is enlarged by the factor by which voxels are smaller than pixels: `H(nu)` (swan1997
//!   section 4.3)
//! - coverage of n x n samples: `H(nu / m) D(nu_x) D(nu_y)`, `D(f) = sin(pi f) / (n sin(pi f / n))`
//!
//! Convolved with a Gaussian of variance s^2, a zone plate is one again, in closed form: with `k = 2 pi / P` for P
//! pixels and `d = 1 - 2 i k s^2`, the wave `cos(k rho^2)` becomes `Re(exp(i k rho^2 / d) / d)`. So the closed form of
//! every pixel is known exactly: kernel and filter are Gaussians, whose variances add up, and coverage is a mean of
//! samples.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rustfft::num_complex::Complex64;
use splatvol::{
    Alignment, Compositing, Coverage, Filter, FlatSettings, Grid, Kernel, LengthUnit, RenderSettings,
    Rescale, Samples, Scene, Volume,
};
use splatvol_testing::transfer::linear_extinction;

use super::scenes::{colors, grey, orthographic};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Mark, Outcome, Plate, Plot, Table, Workbench,
};

const FIGURE: &str = "Zone plate";
/// Voxels per pixel.
const MINIFICATION: usize = 6;
/// The papers' exp(-1.38 r^2), cut late.
const SIGMA: f64 = 0.602;
/// Optical depth of the plate: so thin that the opacity is proportional to the value.
const OPTICAL_DEPTH: f64 = 0.01;
/// Samples per pixel and axis.
const SAMPLES: u32 = 4;
const RINGS: usize = 20;

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "beyond-zone-plate",
    paper: "beyond",
    title: "Zone plate: what each filter keeps and what it lets alias, by frequency",
    figures: &[FIGURE],
    about: "The papers judge anti-aliasing by the eye, or on one texture. A zone plate has all frequencies: here a sheet \
            of voxels whose rings run from the middle's standstill to one cycle per pixel at the rim, six voxels per \
            pixel. A picture can hold half a cycle per pixel; everything in its outer half is aliased, and should be \
            even grey.\n\n\
            The amplitude of each ring in the picture, as a share of that in the data, is the filter's response. \
            It is compared with the closed form of each filter. The plate is faint, so that opacity and optical depth \
            are the same thing, and its Gaussian of sigma .602 is cut at 2.5 voxels.",
    run,
};

/// A way to render, and its response in theory.
struct Method {
    name: &'static str,
    key: &'static str,
    filter: Filter,
    coverage: Coverage,
    /// Remaining amplitude of the wave at a position, in a picture of this many pixels.
    wave: fn([f64; 2], f64) -> f64,
}

const METHODS: [Method; 5] = [
    Method::filtered("none", "none", Filter::None, |at, pixels| {
        wave(voxel_sigma(), at, pixels)
    }),
    Method::filtered("swan", "swan", Filter::Swan, |at, pixels| wave(SIGMA, at, pixels)),
    Method::filtered(
        "ewa, sigma .55",
        "ewa",
        Filter::Ewa { pixel_sigma: 0.55 },
        |at, pixels| wave(voxel_sigma().hypot(0.55), at, pixels),
    ),
    Method::filtered(
        "ewa, sigma 1",
        "ewa-paper",
        Filter::Ewa { pixel_sigma: 1.0 },
        |at, pixels| wave(voxel_sigma().hypot(1.0), at, pixels),
    ),
    Method {
        name: "coverage, 4 x 4",
        key: "coverage",
        filter: Filter::None,
        // Every pixel that differs from its neighbours at all.
        coverage: Coverage::Adaptive {
            samples: SAMPLES,
            contrast: 0.0,
        },
        wave: sampled,
    },
];

impl Method {
    const fn filtered(
        name: &'static str,
        key: &'static str,
        filter: Filter,
        wave: fn([f64; 2], f64) -> f64,
    ) -> Self {
        Self {
            name,
            key,
            filter,
            coverage: Coverage::Off,
            wave,
        }
    }

    fn settings(&self, pixels: u32) -> Result<RenderSettings, LabError> {
        let kernel = Kernel::Gaussian {
            sigma: SIGMA,
            radius: 2.5,
        };
        Ok(RenderSettings::try_from(FlatSettings {
            compositing: Compositing::AxisSheets,
            alignment: Alignment::Affine,
            filter: self.filter,
            coverage: self.coverage,
            ..colors(pixels, kernel)?.into()
        })?)
    }
}

/// Standard deviation of the kernel, pixels.
fn voxel_sigma() -> f64 {
    SIGMA / MINIFICATION as f64
}

/// The wave convolved with a Gaussian of a standard deviation in pixels.
fn wave(sigma: f64, [x, y]: [f64; 2], pixels: f64) -> f64 {
    let k = TAU / pixels;
    let d = Complex64::new(1.0, -2.0 * k * sigma * sigma);
    ((Complex64::i() * k * (x * x + y * y) / d).exp() / d).re
}

/// The mean of samples at the middles of a pixel's cells.
fn sampled([x, y]: [f64; 2], pixels: f64) -> f64 {
    let n = f64::from(SAMPLES);
    let offset = |i: u32| (f64::from(i) + 0.5) / n - 0.5;
    let places = (0..SAMPLES * SAMPLES).map(|i| [x + offset(i % SAMPLES), y + offset(i / SAMPLES)]);
    places.map(|at| wave(voxel_sigma(), at, pixels)).sum::<f64>() / (n * n)
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let pixels = bench.choose(160, 80);
    let scene = plate(pixels as usize * MINIFICATION)?;
    let camera = orthographic(DVec3::Z, DVec3::Y, (pixels as usize * MINIFICATION) as f64)?;
    let mut renderer = bench.renderer()?;
    let mut outcome = Outcome::default();
    let mut shown = Plate::new(
        "pictures",
        FIGURE,
        "Rings get finer outwards; the circle of half a cycle per pixel lies half-way to the rim. Beyond it, all rings are \
         aliases",
    );
    let mut responses = Vec::new();
    for (index, method) in METHODS.iter().enumerate() {
        bench.step(index, METHODS.len(), method.name);
        let frame = renderer.render(&scene, &camera, &method.settings(pixels)?)?;
        let values: Vec<f64> = frame
            .optical_depth
            .iter()
            .map(|depth| f64::from(*depth) / OPTICAL_DEPTH)
            .collect();
        let rings = Rings::of(&values, pixels as usize, method.wave);
        findings(&mut outcome, method, &rings);
        shown = shown.panel(method.name, grey(values, pixels)?);
        responses.push((method, rings));
    }
    outcome.plates.push(shown);
    outcome.plots.push(plot(&responses));
    outcome.tables.push(table(&responses));
    Ok(outcome)
}

/// The plate, `side` voxels across.
fn plate(side: usize) -> Result<Scene, LabError> {
    let middle = 0.5 * (side as f64 - 1.0);
    // k r / pi cycles per voxel at r: one per pixel at the rim.
    let k = PI / (MINIFICATION as f64 * 0.5 * side as f64);
    let value = |index: usize| {
        let [x, y] = [index % side, index / side].map(|i| i as f64 - middle);
        (0.5 + 0.5 * (k * (x * x + y * y)).cos()) as f32
    };
    let samples = Samples::F32((0..side * side).map(value).collect());
    let grid = Grid::centred([side, side, 1], DVec3::ONE)?;
    let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown)?;
    Ok(Scene::new(
        volume,
        linear_extinction([0.0, 1.0], OPTICAL_DEPTH, [1.0; 3]),
    ))
}

/// Power per ring of equal frequency, 1 being that of the data, and that of the closed form at the same pixels.
struct Rings {
    power: [f64; RINGS],
    theory: [f64; RINGS],
    count: [usize; RINGS],
}

impl Rings {
    fn of(values: &[f64], side: usize, wave: fn([f64; 2], f64) -> f64) -> Self {
        let mut rings = Self {
            power: [0.0; RINGS],
            theory: [0.0; RINGS],
            count: [0; RINGS],
        };
        let pixels = side as f64;
        for (index, value) in values.iter().enumerate() {
            let [x, y] = [index % side, index / side].map(|i| i as f64 + 0.5 - 0.5 * pixels);
            let ring = (2.0 * x.hypot(y) / pixels * RINGS as f64) as usize;
            if ring < RINGS {
                let wave = wave([x, y], pixels);
                // The data's amplitude is 1/2: the mean of its square, 1/8.
                rings.power[ring] += 8.0 * (value - 0.5).powi(2);
                rings.theory[ring] += 2.0 * wave * wave;
                rings.count[ring] += 1;
            }
        }
        for ring in 0..RINGS {
            let count = rings.count[ring].max(1) as f64;
            rings.power[ring] /= count;
            rings.theory[ring] /= count;
        }
        rings
    }

    /// Frequency of a ring's middle, cycles per pixel.
    fn frequency(ring: usize) -> f64 {
        (ring as f64 + 0.5) / RINGS as f64
    }

    /// Mean of `of` over the rings of these frequencies, weighted by their pixels.
    fn mean(&self, frequencies: std::ops::Range<f64>, of: impl Fn(usize) -> f64) -> f64 {
        let rings = (0..RINGS).filter(|&ring| frequencies.contains(&Self::frequency(ring)));
        let [sum, count] = rings.fold([0.0; 2], |[sum, count], ring| {
            let n = self.count[ring] as f64;
            [sum + n * of(ring), count + n]
        });
        sum / count
    }
}

fn findings(outcome: &mut Outcome, method: &Method, rings: &Rings) {
    // The innermost rings have no whole wave; the outermost one is the border of the data.
    for (what, frequencies, words) in [
        ("kept", 0.2..0.5, "power kept from .2 to .5 cycles per pixel"),
        (
            "aliased",
            0.5..0.95,
            "power aliased from .5 to .95 cycles per pixel",
        ),
    ] {
        let measured = rings.mean(frequencies.clone(), |ring| rings.power[ring]);
        let theory = rings.mean(frequencies, |ring| rings.theory[ring]);
        let expected = Expectation::Near {
            value: theory,
            within: 0.05 * theory + 1e-5,
        };
        let quantity = format!("{}: {words}, of the data's, against the closed form", method.name);
        outcome.find(Finding::new(
            FIGURE,
            &format!("{}-{what}", method.key),
            &quantity,
            measured,
            expected,
        ));
    }
}

fn table(responses: &[(&Method, Rings)]) -> Table {
    let columns = [
        "filter",
        "frequency (cycles/pixel)",
        "power (of the data's)",
        "closed form",
    ];
    let mut table = Table::new("rings", FIGURE, "Power per ring", &columns).hidden();
    for (method, rings) in responses {
        for ring in 0..RINGS {
            let frequency = Rings::frequency(ring);
            table.row([
                method.name.into(),
                frequency.into(),
                rings.power[ring].into(),
                rings.theory[ring].into(),
            ]);
        }
    }
    table
}

fn plot(responses: &[(&Method, Rings)]) -> Plot {
    let plot = Plot::curves(
        "response",
        FIGURE,
        "Amplitude in the picture by frequency in the data",
        Axis::new("frequency of the data (cycles per pixel)").range(0.0, 1.0),
        Axis::new("amplitude (of the data's)").range(0.0, 1.2),
    )
    .mark(Mark::Vertical {
        at: 0.5,
        label: "all beyond is aliased".to_owned(),
    });
    let plot = responses.iter().fold(plot, |plot, (method, rings)| {
        let points = (3..RINGS - 1).map(|ring| [Rings::frequency(ring), rings.power[ring].sqrt()]);
        plot.curve(Curve::new(method.name, points).dots())
    });
    let variance = voxel_sigma().powi(2) + 0.55 * 0.55;
    let ewa = |nu: f64| [nu, (-2.0 * PI * PI * variance * nu * nu).exp()];
    plot.curve(
        Curve::new(
            "ewa .55, closed form",
            (0..=100).map(|i| ewa(f64::from(i) / 100.0)),
        )
        .dashed(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blurred_zone_plate_is_the_convolution() {
        let (sigma, pixels, at) = (0.7, 40.0, [5.3, -8.1]);
        let step = 0.05;
        let offsets = || (-100..=100).map(|i| f64::from(i) * step);
        let weight = |d: f64| (-0.5 * (d / sigma).powi(2)).exp() * step / (sigma * TAU.sqrt());
        let sum: f64 = offsets()
            .flat_map(|dx| offsets().map(move |dy| [dx, dy]))
            .map(|[dx, dy]| {
                let square = (at[0] - dx).powi(2) + (at[1] - dy).powi(2);
                weight(dx) * weight(dy) * (TAU / pixels * square).cos()
            })
            .sum();
        assert!((wave(sigma, at, pixels) - sum).abs() < 1e-9, "{sum}");
    }
}
