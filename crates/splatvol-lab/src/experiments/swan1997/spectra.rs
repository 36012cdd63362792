//! Fig. 5: spectra before and beyond the distance k.
//!
//! Samples at the rate rho have the spectrum of the signal, F, repeated at all multiples of rho; splatting multiplies
//! it by the kernel's frequency response H, the filter of section 4.3 by `H(f d / k)`; the picture samples the result
//! at `phi = rho k / d` (eq. 11), which folds everything above `phi / 2` back.

use glam::DVec3;
use splatvol::{
    Camera, Compositing, Filter, FlatSettings, ImageSize, Kernel, Projection, RenderSettings, Renderer, Scene,
};
use splatvol_core::radial::RadialKernel;

use super::waves::{PERIOD, amplitudes, repeated, scene, spectrum};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Mark, Outcome, Plot, Published, Table, Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "swan1997-spectra",
    paper: "swan1997",
    title: "Spectra before and beyond k",
    figures: &["Fig. 5"],
    about: "The paper draws three spectra in one dimension: before k the pixels' rate holds all of the signal; beyond k, with \
standard splatting, spectra overlap, and the kernel lets frequencies above the Nyquist limit pass; with the filter the kernel \
shrinks in frequency, which *eliminates almost all of the postaliasing and most of the prealiasing, at the expense of blurring*.\n\n\
We draw them from pictures. A sheet of voxels holds a signal along x of 51 waves of random phase, up to .4 cycles per voxel, so \
that eq. 1 holds; it is splatted as an X-ray, which is a sum, with the paper's cubic spline. Seen in parallel, d / k is the size of \
a pixel in voxels: 1/2 for (a), 2 for (b) and (c). Pictures shifted by eighths of a pixel give the spectrum of what the pixels sample, \
line by line over exactly one period.\n\n\
*Prealiasing* is the power of the signal's own spectrum above phi / 2, *postaliasing* that of its repetitions, wherever the kernel \
lets them pass. The paper draws the repetitions at multiples of phi; in splatting they lie at multiples of the voxels' rate, \
and multiples of phi are where the pixels fold them. The plots leave out the mean and its repetitions.",
    run,
};

/// Pictures shifted against each other.
const SHIFTS: usize = 8;

/// A panel of the figure.
struct Panel {
    key: &'static str,
    figure: &'static str,
    caption: &'static str,
    filter: Filter,
    /// d / k, a pixel in voxels.
    distance: f64,
    /// Amplitude by frequency, in cycles per period; 1 is the mean's.
    measured: Vec<f64>,
}

/// Power of a picture's parts, in that of the mean.
struct Parts {
    signal: f64,
    pre: f64,
    post: f64,
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let amplitudes = amplitudes();
    let scene = scene(&amplitudes)?;
    let mut renderer = bench.renderer()?;
    let mut panels = [
        panel("a", "Fig. 5 (a)", "before k: d = k / 2", Filter::None, 0.5),
        panel(
            "b",
            "Fig. 5 (b)",
            "beyond k: d = 2 k, standard splatting",
            Filter::None,
            2.0,
        ),
        panel(
            "c",
            "Fig. 5 (c)",
            "beyond k: d = 2 k, anti-aliased",
            Filter::Swan,
            2.0,
        ),
    ];
    for (index, panel) in panels.iter_mut().enumerate() {
        bench.step(index, 3, panel.caption);
        panel.measured = spectrum(&sampled(&mut renderer, &scene, panel)?);
    }
    let mut outcome = Outcome::default();
    find(&mut outcome, &panels);
    outcome.find(agreement(&panels, &amplitudes));
    outcome.tables.push(table(&panels, &amplitudes));
    outcome
        .plots
        .extend(panels.iter().map(|panel| plot(panel, &amplitudes)));
    Ok(outcome)
}

fn panel(
    key: &'static str,
    figure: &'static str,
    caption: &'static str,
    filter: Filter,
    distance: f64,
) -> Panel {
    Panel {
        key,
        figure,
        caption,
        filter,
        distance,
        measured: Vec::new(),
    }
}

/// The middle period as pixels see it, with [`SHIFTS`] samples per pixel.
fn sampled(renderer: &mut Renderer, scene: &Scene, panel: &Panel) -> Result<Vec<f64>, LabError> {
    let columns = (PERIOD as f64 / panel.distance) as usize;
    let size = ImageSize::new(columns as u32, 1)?;
    let settings = RenderSettings::try_from(FlatSettings {
        size,
        filter: panel.filter,
        compositing: Compositing::Xray,
        lighting: None,
        ..RenderSettings::swan1997().into()
    })?;
    let projection = Projection::Orthographic {
        height: panel.distance,
    };
    let mut values = vec![0.0; columns * SHIFTS];
    for shift in 0..SHIFTS {
        let aside = shift as f64 / SHIFTS as f64 * panel.distance;
        let target = DVec3::new(aside, 0.0, 0.0);
        let camera = Camera::new(target + 50.0 * DVec3::Z, target, DVec3::Y, projection)?;
        let frame = renderer.render(scene, &camera, &settings)?;
        for (column, &tau) in frame.optical_depth.iter().enumerate() {
            values[column * SHIFTS + shift] = tau.into();
        }
    }
    Ok(values)
}

/// H at a line.
fn response(kernel: &RadialKernel, panel: &Panel, line: usize) -> f64 {
    let widening = match panel.filter {
        Filter::Swan => panel.distance.max(1.0),
        _ => 1.0,
    };
    kernel.response(widening * line as f64 / PERIOD as f64).abs()
}

fn parts(panel: &Panel) -> Parts {
    let mut parts = Parts {
        signal: 0.0,
        pre: 0.0,
        post: 0.0,
    };
    let nyquist = 0.5 / panel.distance * PERIOD as f64;
    for (line, amplitude) in panel.measured.iter().enumerate().skip(1) {
        let power = 0.5 * amplitude * amplitude;
        let part = match line {
            _ if 2 * line > PERIOD => &mut parts.post,
            _ if line as f64 > nyquist => &mut parts.pre,
            _ => &mut parts.signal,
        };
        *part += power;
    }
    parts
}

fn find(outcome: &mut Outcome, panels: &[Panel; 3]) {
    let [a, b, c] = [&panels[0], &panels[1], &panels[2]].map(parts);
    let all = |parts: &Parts| parts.signal + parts.pre + parts.post;
    outcome.find(
        Finding::new(
            "Fig. 5 (a)",
            "pre-before-k",
            "prealiasing before k, share of the power",
            a.pre / all(&a),
            Expectation::AtMost(1e-6),
        )
        .published(Published::Claim("none: the spectra do not overlap".to_owned())),
    );
    outcome.find(
        Finding::new(
            "Fig. 5 (a)",
            "post-before-k",
            "postaliasing before k, share of the power",
            a.post / all(&a),
            Expectation::Between(1e-6, 0.1),
        )
        .published(Published::Claim(
            "some: a realizable filter picks up some energy beyond the Nyquist limit".to_owned(),
        )),
    );
    outcome.find(
        Finding::new(
            "Fig. 5 (b)",
            "pre-standard",
            "prealiasing beyond k, standard splatting, share of the power",
            b.pre / all(&b),
            Expectation::AtLeast(0.05),
        )
        .published(Published::Claim(
            "spectra overlap, resulting in prealiasing".to_owned(),
        )),
    );
    outcome.find(
        Finding::new(
            "Fig. 5 (c)",
            "post-eliminated",
            "share of the postaliasing that the filter eliminates",
            1.0 - c.post / b.post,
            Expectation::AtLeast(0.95),
        )
        .published(Published::Claim("almost all".to_owned())),
    );
    outcome.find(
        Finding::new(
            "Fig. 5 (c)",
            "pre-eliminated",
            "share of the prealiasing that the filter eliminates",
            1.0 - c.pre / b.pre,
            Expectation::AtLeast(0.5),
        )
        .published(Published::Claim("most".to_owned())),
    );
    outcome.find(
        Finding::new(
            "Fig. 5 (c)",
            "blurring",
            "power of the signal below the Nyquist limit, with the filter against without",
            c.signal / b.signal,
            Expectation::AtMost(0.95),
        )
        .published(Published::Claim("at the expense of blurring".to_owned())),
    );
}

/// Pictures against the spectra computed from the kernel in f64.
fn agreement(panels: &[Panel; 3], amplitudes: &[f64]) -> Finding {
    let kernel = RadialKernel::new(Kernel::CrawfisMax);
    let mut most = 0.0_f64;
    for panel in panels {
        for (line, measured) in panel.measured.iter().enumerate().skip(1) {
            let expected = repeated(amplitudes, line) * response(&kernel, panel, line);
            most = most.max((measured - expected).abs());
        }
    }
    Finding::new(
        "Fig. 5",
        "agreement",
        "largest difference of a line from the kernel's frequency response times the samples' spectrum, in the mean",
        most,
        Expectation::AtMost(0.001),
    )
}

fn table(panels: &[Panel; 3], amplitudes: &[f64]) -> Table {
    let kernel = RadialKernel::new(Kernel::CrawfisMax);
    let mut table = Table::new(
        "lines",
        "Fig. 5",
        "Amplitudes by frequency, in that of the mean",
        &[
            "panel",
            "frequency (cycles per voxel)",
            "samples",
            "kernel",
            "picture",
        ],
    )
    .hidden();
    for panel in panels {
        for (line, &measured) in panel.measured.iter().enumerate().skip(1) {
            table.row([
                panel.key.into(),
                (line as f64 / PERIOD as f64).into(),
                repeated(amplitudes, line).into(),
                response(&kernel, panel, line).into(),
                measured.into(),
            ]);
        }
    }
    table
}

fn plot(panel: &Panel, amplitudes: &[f64]) -> Plot {
    const END: f64 = 1.6;
    let kernel = RadialKernel::new(Kernel::CrawfisMax);
    let frequency = |line: usize| line as f64 / PERIOD as f64;
    let strongest = amplitudes.iter().copied().fold(0.0, f64::max);
    let lines = || (1..panel.measured.len()).filter(|&line| frequency(line) <= END);
    // Without the mean and its repetitions, lines much stronger than their neighbours.
    let waves = || lines().filter(|line| line % PERIOD > 0);
    let nyquist = 0.5 / panel.distance;
    let ideal = [[0.0, 1.0], [nyquist, 1.0], [nyquist, 0.0], [END, 0.0]];
    Plot::curves(
        &format!("spectra-{}", panel.key),
        panel.figure,
        panel.caption,
        Axis::new("frequency (cycles per voxel)").range(0.0, END),
        Axis::new("amplitude").range(0.0, 1.05),
    )
    .curve(Curve::new(
        "picture",
        waves().map(|line| [frequency(line), panel.measured[line] / strongest]),
    ))
    .curve(
        Curve::new(
            "samples: primary and alias spectra",
            waves().map(|line| [frequency(line), repeated(amplitudes, line) / strongest]),
        )
        .dashed(),
    )
    .curve(Curve::new(
        "splatting kernel",
        lines().map(|line| [frequency(line), response(&kernel, panel, line)]),
    ))
    .curve(Curve::new("ideal filter", ideal).dashed())
    .mark(Mark::Vertical {
        at: nyquist,
        label: "phi / 2".to_owned(),
    })
}
