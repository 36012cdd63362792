//! Marschner and Lobb's test signal (Visualization '94), 41 samples per axis: how far the field of each kernel is from
//! it, with and without the interpolating prefilter, in f64; and how far the surface that the engine draws is.
//!
//! The surface of the value 1/2 has the closed form `z = 2/pi asin(alpha cos(2 pi f cos(pi r / 2)))`, alpha = 1/4, f =
//! 6.

mod fields;
mod surfaces;

use glam::DVec3;
use splatvol::Kernel;
use splatvol_core::radial::RadialKernel;
use splatvol_testing::fields::MarschnerLobb;
use splatvol_testing::{Field, sample};

use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plot, PlotKind, Table, Workbench,
};
use fields::{Errors, Interpolant, Trilinear, interpolant, measure, points, world};

const FIGURE: &str = "Marschner-Lobb";
const SIDE: usize = 41;
/// World length of a voxel: the signal fills [-1, 1]^3.
const SPACING: f64 = 2.0 / (SIDE as f64 - 1.0);

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "beyond-marschner-lobb",
    paper: "beyond",
    title: "Marschner-Lobb: error of each kernel, with and without the prefilter",
    figures: &[FIGURE],
    about: "The signal of Marschner and Lobb (1994) is sampled on 41 x 41 x 41 voxels, where its rings are close to the \
            Nyquist frequency. The field that each kernel makes of the samples is compared, in f64 and at seeded random \
            points of the whole box, with the signal itself: value, and direction of the gradient. The signal-to-error ratio \
            is the signal's range over the root mean square error, in decibels. Trilinear interpolation is what a ray \
            caster would do.\n\n\
            The papers splat samples as they are, which blurs. With the interpolating prefilter the kernels' weights are \
            solved once so that the field passes through the samples. Gaussians are the product kernels of the engine, \
            evaluated by the reference; the others are functions of the distance.\n\n\
            The engine then draws the surface of the value 1/2 from above. Its height has a closed form, so the error of \
            the depth that the engine returns is known at every pixel.",
    run,
};

/// Kernels and their names.
const KERNELS: [(&str, Kernel); 7] = [
    ("gaussian .602/2", gaussian(0.602, 2.0)),
    ("gaussian .64/2", gaussian(0.64, 2.0)),
    ("gaussian .7/3.5", gaussian(0.7, 3.5)),
    ("gaussian .74/3", gaussian(0.74, 3.0)),
    ("crawfis-max", Kernel::CrawfisMax),
    ("cubic-bspline", Kernel::CubicBspline),
    ("kaiser-bessel", Kernel::KAISER_BESSEL),
];

const fn gaussian(sigma: f64, radius: f64) -> Kernel {
    Kernel::Gaussian { sigma, radius }
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let volume = sample(&MarschnerLobb::default(), &MarschnerLobb::grid(SIDE));
    let points = points(bench.choose(100_000, 20_000));
    let mut outcome = Outcome::default();
    let mut errors = vec![("trilinear".to_owned(), measure(&Trilinear::new(&volume), &points))];
    let mut fields: Vec<(String, Box<dyn Interpolant>)> = Vec::new();
    for (index, (name, kernel)) in KERNELS.iter().enumerate() {
        bench.step(index, KERNELS.len() + 2, name);
        for prefilter in [false, true] {
            let label = labelled(name, prefilter);
            let field = interpolant(&volume, *kernel, prefilter)?;
            errors.push((label.clone(), measure(field.as_ref(), &points)));
            fields.push((label, field));
        }
    }
    outcome.plots.push(bars(&errors));
    outcome.plots.push(profile(&fields));
    outcome.tables.push(table(&errors));
    field_findings(&mut outcome, &errors);
    bench.step(KERNELS.len(), KERNELS.len() + 2, "surfaces");
    surfaces::surfaces(bench, &volume, &mut outcome)?;
    Ok(outcome)
}

fn labelled(name: &str, prefilter: bool) -> String {
    match prefilter {
        true => format!("{name}, prefiltered"),
        false => name.to_owned(),
    }
}

fn field_findings(outcome: &mut Outcome, errors: &[(String, Errors)]) {
    let of = |name: &str| {
        errors
            .iter()
            .find(|(label, _)| label == name)
            .map(|(_, errors)| errors)
    };
    let psnr = |name: &str| of(name).map_or(f64::NAN, |errors| errors.psnr);
    let angle = |name: &str| of(name).map_or(f64::NAN, |errors| errors.angle);
    let decibels = |key: &str, name: &str, quantity: &str, expected: Expectation| {
        Finding::new(FIGURE, key, quantity, psnr(name), expected).unit("dB")
    };
    let best = "gaussian .74/3, prefiltered";
    outcome.find(decibels(
        "best",
        best,
        "signal-to-error ratio of the default kernel with the prefilter (documented: 35.5 dB or better)",
        Expectation::AtLeast(35.5),
    ));
    outcome.find(
        decibels(
            "plain-papers",
            "gaussian .602/2",
            "signal-to-error ratio of the papers' exp(-1.38 r^2) without prefilter, to be below that of trilinear interpolation",
            Expectation::AtMost(psnr("trilinear")),
        )
        .detail(format!("trilinear {:.1} dB", psnr("trilinear"))),
    );
    outcome.find(decibels(
        "trilinear",
        "trilinear",
        "signal-to-error ratio of trilinear interpolation (known: 29.0 dB)",
        Expectation::Near {
            value: 29.0,
            within: 0.5,
        },
    ));
    let gains = KERNELS.map(|(name, _)| (name, psnr(&labelled(name, true)) - psnr(name)));
    let least = (0..gains.len()).fold(0, |least, i| if gains[i].1 < gains[least].1 { i } else { least });
    let words = gains.map(|(name, gain)| format!("{name} {gain:.1}")).join(", ");
    outcome.find(
        Finding::new(
            FIGURE,
            "least-gain",
            "signal-to-error ratio with the prefilter less that without, the kernel that gains least",
            gains[least].1,
            Expectation::AtLeast(3.0),
        )
        .unit("dB")
        .detail(words)
        .explained_by(
            "of all kernels it passes most of the Nyquist frequency already, this many times what the next one does",
            sharpness(least),
            Expectation::AtLeast(1.0),
        ),
    );
    outcome.find(
        Finding::new(
            FIGURE,
            "angle",
            "mean angle between the default kernel's gradient and the signal's, against trilinear's central differences",
            angle(best) / angle("trilinear"),
            Expectation::AtMost(0.75),
        )
        .detail(format!("{:.1} and {:.1} degrees", angle(best), angle("trilinear"))),
    );
}

/// Response of a kernel at the voxels' Nyquist frequency, divided by the largest of the others.
fn sharpness(index: usize) -> f64 {
    let responses = KERNELS.map(|(_, kernel)| RadialKernel::new(kernel).response(0.5));
    let others = responses.iter().enumerate().filter(|(other, _)| *other != index);
    responses[index] / others.fold(0.0, |most, (_, response)| response.max(most))
}

fn table(errors: &[(String, Errors)]) -> Table {
    let columns = [
        "kernel",
        "signal-to-error ratio (dB)",
        "largest error (of the range)",
        "gradient off by (degrees)",
    ];
    let mut table = Table::new("kernels", FIGURE, "Errors of the field, whole box", &columns);
    for (name, errors) in errors {
        table.row([
            name.as_str().into(),
            errors.psnr.into(),
            errors.largest.into(),
            errors.angle.into(),
        ]);
    }
    table
}

/// A kernel's name as it fits under a bar.
fn short(name: &str) -> String {
    let name = name.replace("gaussian", "G").replace("cubic-", "");
    name.trim_end_matches("-max")
        .trim_end_matches("-bessel")
        .to_owned()
}

fn bars(errors: &[(String, Errors)]) -> Plot {
    let psnr = |label: &str| {
        errors
            .iter()
            .find(|(name, _)| name == label)
            .map_or(0.0, |(_, e)| e.psnr)
    };
    let groups = KERNELS.map(|(name, _)| {
        let bars = vec![psnr(name), psnr(&labelled(name, true)), psnr("trilinear")];
        (short(name), bars)
    });
    let bars = ["as sampled", "prefiltered", "trilinear, for scale"];
    let kind = PlotKind::Bars {
        bars: bars.map(str::to_owned).to_vec(),
        groups: groups.to_vec(),
    };
    let axes = [
        Axis::new("kernel (G: Gaussian, sigma/radius in voxels)"),
        Axis::new("signal-to-error ratio of the field (dB)"),
    ];
    Plot::new("kernels", FIGURE, "Higher is closer to the signal", axes, kind)
}

/// The signal and some fields along a line that crosses the rings.
fn profile(fields: &[(String, Box<dyn Interpolant>)]) -> Plot {
    let signal = MarschnerLobb::default();
    let middle = 0.5 * (SIDE as f64 - 1.0);
    let along = || (0..=400).map(|i| 0.3 + 0.8 * f64::from(i) / 400.0);
    let voxel = |x: f64| DVec3::new(middle + x / SPACING, middle + 0.5, middle + 0.5);
    let plot = Plot::curves(
        "profile",
        FIGURE,
        "Across the rings, half a voxel off the samples' planes",
        Axis::new("distance from the axis (1 is the box's face)"),
        Axis::new("value (of the range)"),
    );
    let exact = along()
        .filter(|x| *x <= 1.0)
        .map(|x| [x, signal.value(world(voxel(x)))]);
    let chosen = ["gaussian .602/2", "crawfis-max", "gaussian .74/3, prefiltered"];
    let curves = fields.iter().filter(|(name, _)| chosen.contains(&name.as_str()));
    curves.fold(
        plot.curve(Curve::new("signal", exact).dashed()),
        |plot, (name, field)| {
            let points = along().filter(|x| *x <= 1.0).map(|x| [x, field.value(voxel(x))]);
            plot.curve(Curve::new(name, points))
        },
    )
}
