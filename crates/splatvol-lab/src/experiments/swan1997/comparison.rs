//! One view of Fig. 7 with every filter: aliased energy, flicker, opacity, and the error against the mean of many samples.
//!
//! *Aliased energy*: a picture takes samples, one per pixel, of a function of place, the sum of the footprints. What that
//! function has at frequencies above half a cycle per pixel, along rows or columns, a raster of pixels cannot hold; it turns
//! up at other frequencies, as aliasing. Its share of the function's power (without the mean) inside a window is measured on
//! samples that lie closer: half a pixel for all filters, an eighth for those that allow it.

use glam::DVec3;
use splatvol::{Filter, Frame, Image, ImageSize};

use super::animation::{flicker, flight};
use super::view::{Fine, METHODS, Method, View};
use super::window::{Window, over_white, with_line_at};
use crate::{
    Axis, Cell, Curve, Expectation, Finding, LabError, Mark, Outcome, Plate, Plot, Published, Table,
    Workbench,
};

/// What the paper says of a view, and where.
pub(super) struct Claims {
    /// The figures without and with anti-aliasing.
    pub(super) figures: [&'static str; 2],
    /// Of the picture without it.
    pub(super) plain: &'static str,
    /// The least share above the Nyquist limit that these words mean.
    pub(super) least: f64,
    /// Of the picture with it.
    pub(super) smoothed: &'static str,
    /// Of both in motion; nothing if the paper does not say.
    pub(super) animated: Option<&'static str>,
}

/// What one filter does to the view.
struct Measured {
    method: &'static Method,
    frame: Frame,
    /// Share of the power above the Nyquist limit, by samples half a pixel apart.
    above: f64,
    bands: Vec<[f64; 2]>,
    opacity: f64,
    flicker: f64,
    error: f64,
}

/// All filters on a view.
pub(super) struct Comparison {
    measured: Vec<Measured>,
    /// Mean of many samples in each pixel.
    truth: Image,
    /// Samples per pixel and axis of the truth.
    samples: u32,
    /// Of standard splatting, by that many samples.
    plain_above: f64,
    /// Of ewa, by that many samples.
    ewa_above: f64,
}

/// Renders and measures. `flown` is the camera's way from frame to frame of the animation.
pub(super) fn compare(
    bench: &Workbench<'_>,
    view: &View,
    window: &Window,
    flown: DVec3,
) -> Result<Comparison, LabError> {
    let mut renderer = bench.renderer()?;
    let samples = bench.choose(8, 4);
    let cameras = flight(&view.camera, flown, bench.choose(8, 4))?;
    let steps = METHODS.len() + 2;
    bench.step(0, steps, "many samples per pixel");
    let plain = view.sampled(&mut renderer, Filter::None, samples)?;
    let truth = mean_of(&plain, samples)?;
    let plain_above = Fine::of(&plain, samples).spectrum(window).above_nyquist();
    drop(plain);
    bench.step(1, steps, "many samples per pixel, ewa");
    let ewa = view.sampled(&mut renderer, METHODS[3].filter, samples)?;
    let ewa_above = Fine::of(&ewa, samples).spectrum(window).above_nyquist();
    drop(ewa);
    let mut measured = Vec::new();
    for (index, method) in METHODS.iter().enumerate() {
        bench.step(index + 2, steps, method.name);
        let frame = view.frame(&mut renderer, method.filter)?;
        let spectrum = view
            .at_half_pixels(&mut renderer, method.filter)?
            .spectrum(window);
        measured.push(Measured {
            method,
            above: spectrum.above_nyquist(),
            bands: spectrum.bands(0.05, 1.0),
            opacity: window.opacity(&frame.image),
            flicker: flicker(&mut renderer, view, method.filter, (&cameras, window))?,
            error: error(window, &frame.image, &truth),
            frame,
        });
    }
    Ok(Comparison {
        measured,
        truth,
        samples,
        plain_above,
        ewa_above,
    })
}

/// Root mean square difference of luminances in a window, levels of 255.
fn error(window: &Window, image: &Image, truth: &Image) -> f64 {
    let [image, truth] = [image, truth].map(|image| window.luminance(image));
    let sum: f64 = image.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum();
    255.0 * (sum / image.len().max(1) as f64).sqrt()
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
    fn of(&self, key: &str) -> Option<&Measured> {
        self.measured.iter().find(|one| one.method.key == key)
    }

    fn number(&self, key: &str, number: impl Fn(&Measured) -> f64) -> f64 {
        self.of(key).map_or(f64::NAN, number)
    }

    /// The picture of a filter.
    pub(super) fn frame(&self, key: &str) -> Option<&Frame> {
        self.of(key).map(|one| &one.frame)
    }

    /// Findings, table, plot and plate.
    pub(super) fn report(&self, outcome: &mut Outcome, view: &View, claims: &Claims) {
        self.aliasing(outcome, claims);
        self.flickering(outcome, claims);
        self.opacity(outcome, claims);
        let figure = claims.figures[0]
            .rsplit_once(' ')
            .map_or("", |(figure, _)| figure);
        outcome.tables.push(self.table(figure));
        outcome.plots.push(self.plot(figure));
        outcome.plates.push(self.plate(figure, view.k()));
    }

    fn aliasing(&self, outcome: &mut Outcome, claims: &Claims) {
        let share = |key: &str| self.number(key, |one| one.above);
        let plain = share("plain");
        let quantity =
            "share of the picture's power above the pixels' Nyquist limit beyond k, standard splatting";
        outcome.find(
            Finding::new(
                claims.figures[0],
                "aliased-plain",
                quantity,
                self.plain_above,
                Expectation::AtLeast(claims.least),
            )
            .published(Published::Claim(claims.plain.to_owned())),
        );
        for (key, name, claimed) in [
            ("swan", "swan", true),
            ("swan-alpha", "swan by alpha, as section 5 has it", true),
            ("ewa", "ewa", false),
        ] {
            let quantity =
                format!("power above the Nyquist limit beyond k, {name} against standard splatting");
            let finding = Finding::new(
                claims.figures[1],
                &format!("aliased-{key}"),
                &quantity,
                share(key) / plain,
                Expectation::AtMost(0.1),
            )
            .detail(format!(
                "{:.3} % of its power against {:.1} %",
                100.0 * share(key),
                100.0 * plain
            ));
            outcome.find(match claimed {
                true => finding.published(Published::Claim(claims.smoothed.to_owned())),
                false => finding,
            });
        }
    }

    fn flickering(&self, outcome: &mut Outcome, claims: &Claims) {
        let levels = |key: &str| self.number(key, |one| one.flicker);
        let finding = Finding::new(
            claims.figures[1],
            "flicker-swan",
            "energy of pixels that jump from frame to frame, swan against standard splatting",
            (levels("swan") / levels("plain")).powi(2),
            Expectation::AtMost(0.1),
        )
        .detail(format!(
            "{:.2} against {:.2} levels of 255",
            levels("swan"),
            levels("plain")
        ));
        outcome.find(match claims.animated {
            Some(words) => finding.published(Published::Claim(words.to_owned())),
            None => finding,
        });
    }

    fn opacity(&self, outcome: &mut Outcome, claims: &Claims) {
        let opacity = |key: &str| self.number(key, |one| one.opacity);
        let [plain, swan, alpha] = ["plain", "swan", "swan-alpha"].map(opacity);
        let claim = "the energy is the same as if the splats had not been scaled (section 4.3)";
        for (key, name, measured) in [("swan", "swan", swan), ("swan-alpha", "swan by alpha", alpha)] {
            let finding = Finding::new(
                claims.figures[1],
                &format!("opacity-{key}"),
                &format!("mean opacity beyond k, {name} against standard splatting"),
                measured / plain,
                Expectation::relative(1.0, 0.05),
            )
            .published(Published::Claim(claim.to_owned()));
            outcome.find(match key {
                "swan" => finding,
                _ => finding.explained_by(
                    "opacities add up to less than extinctions do; lowered extinction instead keeps this share of \
                     the opacity",
                    swan / plain,
                    Expectation::relative(1.0, 0.05),
                ),
            });
        }
    }

    fn table(&self, figure: &str) -> Table {
        let samples = self.samples * self.samples;
        let mut table = Table::new(
            "filters",
            figure,
            "Standard splatting, the paper's filter and ewa, beyond k",
            &[
                "filter",
                "above Nyquist, 4 samples per pixel (%)",
                &format!("above Nyquist, {samples} samples per pixel (%)"),
                "flicker (levels)",
                &format!("error against the mean of {samples} samples (levels)"),
                "mean opacity",
            ],
        );
        for one in &self.measured {
            let finer: Cell = match one.method.key {
                "plain" => (100.0 * self.plain_above).into(),
                "ewa" => (100.0 * self.ewa_above).into(),
                _ => "–".into(),
            };
            table.row([
                one.method.name.into(),
                (100.0 * one.above).into(),
                finer,
                one.flicker.into(),
                one.error.into(),
                one.opacity.into(),
            ]);
        }
        table
    }

    fn plot(&self, figure: &str) -> Plot {
        let plot = Plot::curves(
            "spectrum",
            figure,
            "power of the pictures beyond k by frequency; right of the line pixels cannot hold it",
            Axis::new("frequency along rows or columns, the larger (cycles per pixel)").range(0.0, 1.0),
            Axis::logarithmic("share of the power, per .05 cycles"),
        )
        .mark(Mark::Vertical {
            at: 0.5,
            label: "Nyquist limit".to_owned(),
        });
        self.measured.iter().fold(plot, |plot, one| {
            let points = one.bands.iter().map(|&[x, y]| [x, y.max(1e-8)]);
            plot.curve(Curve::new(one.method.name, points).dots())
        })
    }

    fn plate(&self, figure: &str, k: f64) -> Plate {
        let samples = self.samples * self.samples;
        let caption = "Without anti-aliasing, the black line at k; with it; and what it should be";
        let plate = self
            .measured
            .iter()
            .fold(Plate::new("pictures", figure, caption), |plate, one| {
                let image = match one.method.key {
                    "plain" => with_line_at(&one.frame, k),
                    _ => over_white(&one.frame.image),
                };
                plate.panel(one.method.name, image)
            });
        plate.panel(
            &format!("mean of {samples} samples per pixel"),
            over_white(&self.truth),
        )
    }
}
