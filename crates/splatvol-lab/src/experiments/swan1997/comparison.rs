//! One view of Fig. 7 with every filter: aliased energy, flicker, opacity, and the error against the mean of many
//! samples.
//!
//! *Aliased energy*: a picture takes samples, one per pixel, of a function of place, the sum of the footprints. A
//! raster of pixels cannot hold that function's frequencies above half a cycle per pixel, along rows or columns; they
//! turn up at other frequencies, as aliasing. Their power inside a window is measured on samples that lie closer: half
//! a pixel for all filters, an eighth for those that allow it. Its unit is the power of standard splatting, without the
//! mean.

use glam::DVec3;
use splatvol::{Filter, Frame, Image, ImageSize, Renderer};

use super::animation::{Flight, flicker};
use super::view::{Fine, METHODS, Method, View};
use super::window::Window;
use crate::{LabError, Workbench};

/// Measurements of the view with one filter.
pub(super) struct Measured {
    pub(super) method: &'static Method,
    pub(super) frame: Frame,
    /// Power above the Nyquist limit, by samples half a pixel apart.
    pub(super) above: f64,
    /// Power by bands of frequency.
    pub(super) bands: Vec<[f64; 2]>,
    pub(super) opacity: f64,
    /// Levels of 255.
    pub(super) flicker: f64,
    /// Upward displacement of the picture, pixels, and the remaining root mean square error, levels of 255.
    pub(super) displaced: [f64; 2],
    pub(super) faint: Faint,
}

/// Measurements of the same voxels, made so faint that they only add up.
pub(super) struct Faint {
    pub(super) above: f64,
    pub(super) opacity: f64,
    pub(super) flicker: f64,
}

/// All filters on a view.
pub(super) struct Comparison {
    pub(super) measured: Vec<Measured>,
    /// Mean of many samples in each pixel.
    pub(super) truth: Image,
    /// Samples per pixel and axis of the truth.
    pub(super) samples: u32,
    /// Power of standard splatting above the Nyquist limit, by that many samples, and of ewa.
    pub(super) finer_above: [f64; 2],
    /// Power of standard splatting: all of it, and that of shapes smaller than eight pixels.
    pub(super) power: [f64; 2],
    /// Flicker of means of several samples per pixel, levels of 255.
    pub(super) truth_flicker: f64,
}

/// Renders and measures. `step` is the camera's displacement from frame to frame of the animation.
pub(super) fn compare(
    bench: &Workbench<'_>,
    view: &View,
    window: &Window,
    step: DVec3,
) -> Result<Comparison, LabError> {
    let mut renderer = bench.renderer()?;
    let samples = bench.choose(8, 4);
    let flight = Flight {
        step,
        frames: bench.choose(8, 4),
        window,
    };
    let steps = METHODS.len() + 2;
    bench.step(0, steps, "many samples per pixel");
    let picture = view.sampled(&mut renderer, Filter::None, samples)?;
    let truth = mean_of(&picture, samples)?;
    let plain = Fine::of(&picture, samples);
    drop(picture);
    let picture = view.sampled(&mut renderer, METHODS[3].filter, samples)?;
    let ewa = Fine::of(&picture, samples).spectrum(window);
    drop(picture);
    bench.step(1, steps, "many samples per pixel, animated");
    let per_pixel = bench.choose(4, 2);
    let truth_flicker = flicker(view, &flight, |view| {
        mean_of(&view.sampled(&mut renderer, Filter::None, per_pixel)?, per_pixel)
    })?;
    let faint = view.faint()?;
    let mut measured = Vec::new();
    for (index, method) in METHODS.iter().enumerate() {
        bench.step(index + 2, steps, method.name);
        let frame = view.frame(&mut renderer, method.filter)?;
        let spectrum = view
            .at_half_pixels(&mut renderer, method.filter)?
            .spectrum(window);
        measured.push(Measured {
            method,
            above: spectrum.power_above(0.5),
            bands: spectrum.bands(0.05, 1.0),
            opacity: window.opacity(&frame.image),
            flicker: flicker(view, &flight, |view| {
                Ok(view.frame(&mut renderer, method.filter)?.image)
            })?,
            displaced: displacement(&plain, window, &frame.image),
            faint: measure_faint(&mut renderer, &faint, &flight, method.filter)?,
            frame,
        });
    }
    let plain = plain.spectrum(window);
    Ok(Comparison {
        measured,
        truth,
        samples,
        finer_above: [plain.power_above(0.5), ewa.power_above(0.5)],
        power: [0.0, 0.125].map(|limit| plain.power_above(limit)),
        truth_flicker,
    })
}

fn measure_faint(
    renderer: &mut Renderer,
    view: &View,
    flight: &Flight<'_>,
    filter: Filter,
) -> Result<Faint, LabError> {
    let spectrum = view.at_half_pixels(renderer, filter)?.spectrum(flight.window);
    Ok(Faint {
        above: spectrum.power_above(0.5),
        opacity: flight.window.opacity(&view.frame(renderer, filter)?.image),
        flicker: flicker(view, flight, |view| Ok(view.frame(renderer, filter)?.image))?,
    })
}

/// Upward displacement of a picture against the mean of finer samples, pixels, and the remaining root mean square
/// difference, levels of 255. Opaque splats extend over the material behind them, which on ground is higher up.
fn displacement(plain: &Fine, window: &Window, image: &Image) -> [f64; 2] {
    let light = window.luminance(image);
    let n = plain.per_pixel() as isize;
    let error = |shift: isize| {
        let truth = plain.means(window, shift);
        let sum: f64 = light.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum();
        255.0 * (sum / light.len().max(1) as f64).sqrt()
    };
    (-2 * n..=2 * n)
        .map(|shift| [shift as f64 / n as f64, error(shift)])
        .min_by(|a, b| a[1].total_cmp(&b[1]))
        .unwrap_or([0.0, f64::NAN])
}

/// The mean of the samples of each pixel.
fn mean_of(image: &Image, samples: u32) -> Result<Image, LabError> {
    let n = samples as usize;
    let size = image.size();
    let size = ImageSize::new(size.width() / samples, size.height() / samples)?;
    let mut sums = vec![[0.0_f32; 4]; size.pixel_count()];
    let width = size.width() as usize;
    for (index, pixel) in image.pixels.iter().enumerate() {
        let [x, y] = [index % (n * width) / n, index / (n * width) / n];
        let sum = &mut sums[y * width + x];
        *sum = std::array::from_fn(|c| sum[c] + pixel[c] / (n * n) as f32);
    }
    Ok(Image::from_pixels(size, sums)?)
}

impl Comparison {
    /// A number of the method with this key.
    pub(super) fn number(&self, key: &str, number: impl Fn(&Measured) -> f64) -> f64 {
        let of = self.measured.iter().find(|one| one.method.key == key);
        of.map_or(f64::NAN, number)
    }
}
