//! Marschner and Lobb's test signal (Visualization '94), 41 samples per axis: how far the field of each kernel is from it,
//! with and without the interpolating prefilter, in f64; and how far the surface that the engine draws is.
//!
//! The surface of the value 1/2 has the closed form `z = 2/pi asin(alpha cos(2 pi f cos(pi r / 2)))`, alpha = 1/4, f = 6.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;
use rayon::prelude::*;
use splatvol::{
    Camera, Filter, Image, ImageSize, Isosurface, Kernel, Projection, RenderSettings, Renderer, Scene, Volume,
};
use splatvol_core::radial::RadialKernel;
use splatvol_reference::Reconstruction;
use splatvol_testing::fields::MarschnerLobb;
use splatvol_testing::{Field, Random, sample};

use super::radial_field::RadialField;
use super::scenes::shown;
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, PlotKind, Published,
    Table, Workbench,
};

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
            points of the whole box, with the signal itself: value, and direction of the gradient. Trilinear \
            interpolation is what a ray caster would do.\n\n\
            The papers splat samples as they are, which blurs. With the interpolating prefilter the kernels' weights are \
            solved once so that the field passes through the samples. Gaussians are the product kernels of the engine, \
            evaluated by the reference; the others are functions of the distance.\n\n\
            The engine then draws the surface of the value 1/2 from above. Its height has a closed form, so the error of \
            the depth that the engine returns is known at every pixel.",
    run,
};

/// A kernel and what it is called.
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
    surfaces(bench, &volume, &mut outcome)?;
    Ok(outcome)
}

fn labelled(name: &str, prefilter: bool) -> String {
    match prefilter {
        true => format!("{name}, prefiltered"),
        false => name.to_owned(),
    }
}

/// A field over the samples; x in voxels.
trait Interpolant: Sync {
    fn value(&self, x: DVec3) -> f64;
    /// Its gradient, up to a positive factor.
    fn gradient(&self, x: DVec3) -> DVec3;
}

impl Interpolant for RadialField {
    fn value(&self, x: DVec3) -> f64 {
        RadialField::value(self, x)
    }

    fn gradient(&self, x: DVec3) -> DVec3 {
        RadialField::gradient(self, x)
    }
}

impl Interpolant for Reconstruction {
    fn value(&self, x: DVec3) -> f64 {
        Reconstruction::value(self, x)
    }

    fn gradient(&self, x: DVec3) -> DVec3 {
        self.sums(x).grad_s
    }
}

struct Trilinear(Vec<f64>);

impl Trilinear {
    fn new(volume: &Volume) -> Self {
        Self((0..SIDE.pow(3)).map(|index| volume.value(index)).collect())
    }
}

impl Interpolant for Trilinear {
    fn value(&self, x: DVec3) -> f64 {
        let cell = x.floor().clamp(DVec3::ZERO, DVec3::splat(SIDE as f64 - 2.0));
        let t = x - cell;
        let [i, j, k] = cell.to_array().map(|c| c as usize);
        let corner = |corner: usize| {
            let [a, b, c] = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight = |far: usize, t: f64| if far == 1 { t } else { 1.0 - t };
            let weights = weight(a, t.x) * weight(b, t.y) * weight(c, t.z);
            weights * self.0[((k + c) * SIDE + j + b) * SIDE + i + a]
        };
        (0..8).map(corner).sum()
    }

    /// Central differences over two voxels, as ray casters take them.
    fn gradient(&self, x: DVec3) -> DVec3 {
        let slope = |axis: DVec3| self.value(x + axis) - self.value(x - axis);
        DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
    }
}

/// The field of a kernel: Gaussians as the reference has them, others as functions of the distance.
fn interpolant(volume: &Volume, kernel: Kernel, prefilter: bool) -> Result<Box<dyn Interpolant>, LabError> {
    if kernel.gaussian().is_some() {
        let field = Reconstruction::new(volume, &kernel, prefilter);
        return Ok(Box::new(
            field.map_err(|error| LabError::Reference(error.to_string()))?,
        ));
    }
    let samples = Trilinear::new(volume).0;
    let kernel = RadialKernel::new(kernel);
    Ok(Box::new(RadialField::new(kernel, &samples, SIDE, prefilter)?))
}

/// Seeded points of the box, in voxels.
fn points(count: usize) -> Vec<DVec3> {
    let mut random = Random::new(41);
    let last = DVec3::splat(SIDE as f64 - 1.0);
    (0..count).map(|_| random.point(DVec3::ZERO, last)).collect()
}

fn world(x: DVec3) -> DVec3 {
    x * SPACING - 1.0
}

/// Errors of a field; values relative to the signal's range, which is 1.
struct Errors {
    /// Decibels of the root mean square.
    psnr: f64,
    largest: f64,
    /// Mean angle between gradients, degrees.
    angle: f64,
}

fn measure(field: &dyn Interpolant, points: &[DVec3]) -> Errors {
    let signal = MarschnerLobb::default();
    let each: Vec<[f64; 2]> = points
        .par_iter()
        .map(|&x| {
            let error = field.value(x) - signal.value(world(x));
            let angle = field.gradient(x).angle_between(signal.gradient(world(x)));
            [error, angle.to_degrees()]
        })
        .collect();
    let count = points.len() as f64;
    let squares: f64 = each.iter().map(|[error, _]| error * error).sum();
    Errors {
        psnr: -10.0 * (squares / count).log10(),
        largest: each.iter().fold(0.0, |most, [error, _]| error.abs().max(most)),
        angle: each.iter().map(|[_, angle]| angle).sum::<f64>() / count,
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
        "error of the default kernel with the prefilter (documented: 36 dB or better)",
        Expectation::AtLeast(36.0),
    ));
    outcome.find(
        decibels(
            "plain-papers",
            "gaussian .602/2",
            "error of the papers' exp(-1.38 r^2) without prefilter, to be below trilinear interpolation",
            Expectation::AtMost(psnr("trilinear")),
        )
        .detail(format!("trilinear {:.1} dB", psnr("trilinear"))),
    );
    outcome.find(decibels(
        "trilinear",
        "trilinear",
        "error of trilinear interpolation (known: 29.0 dB)",
        Expectation::Near {
            value: 29.0,
            within: 0.5,
        },
    ));
    let gains = KERNELS.map(|(name, _)| (name, psnr(&labelled(name, true)) - psnr(name)));
    let least = gains
        .iter()
        .fold(f64::INFINITY, |least, (_, gain)| least.min(*gain));
    let words = gains.map(|(name, gain)| format!("{name} {gain:.1}")).join(", ");
    outcome.find(
        Finding::new(
            FIGURE,
            "least-gain",
            "what the prefilter gains, the kernel that gains least",
            least,
            Expectation::AtLeast(3.0),
        )
        .unit("dB")
        .detail(words),
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

fn table(errors: &[(String, Errors)]) -> Table {
    let columns = [
        "kernel",
        "error (dB)",
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

fn bars(errors: &[(String, Errors)]) -> Plot {
    let psnr = |label: &str| {
        errors
            .iter()
            .find(|(name, _)| name == label)
            .map_or(0.0, |(_, e)| e.psnr)
    };
    let groups = KERNELS.map(|(name, _)| {
        let bars = vec![psnr(name), psnr(&labelled(name, true)), psnr("trilinear")];
        (name.to_owned(), bars)
    });
    let bars = ["as sampled", "prefiltered", "trilinear, for scale"];
    let kind = PlotKind::Bars {
        bars: bars.map(str::to_owned).to_vec(),
        groups: groups.to_vec(),
    };
    let axes = [
        Axis::new("kernel (sigma/radius, voxels)"),
        Axis::new("error of the field (dB)"),
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

/// Kernels that the engine draws surfaces with.
const DRAWN: [(&str, Kernel, bool); 4] = [
    ("gaussian .602/2", gaussian(0.602, 2.0), false),
    ("gaussian .602/2, prefiltered", gaussian(0.602, 2.0), true),
    ("gaussian .74/3", gaussian(0.74, 3.0), false),
    ("gaussian .74/3, prefiltered", gaussian(0.74, 3.0), true),
];

fn settings(pixels: u32, kernel: Kernel, prefilter: bool) -> Result<RenderSettings, LabError> {
    Ok(RenderSettings {
        size: ImageSize::new(pixels, pixels)?,
        filter: Filter::None,
        kernel,
        prefilter,
        ..RenderSettings::best()
    })
}

fn surfaces(bench: &Workbench<'_>, volume: &Volume, outcome: &mut Outcome) -> Result<(), LabError> {
    let mut renderer = bench.renderer()?;
    let scene = surface(volume.clone())?;
    let pixels = bench.choose(256, 128);
    let columns = ["kernel", "error of the depth (voxels, rms)"];
    let mut table = Table::new(
        "surfaces",
        FIGURE,
        "The engine's surface of the value 1/2",
        &columns,
    );
    let mut plate = Plate::new(
        "surfaces",
        FIGURE,
        "The surface of the value 1/2, lit, by the engine; left, from 161 samples per axis, as it should be",
    );
    let fine = sample(
        &MarschnerLobb::default(),
        &MarschnerLobb::grid(4 * (SIDE - 1) + 1),
    );
    let size = bench.choose(240, 120);
    let exact = picture(
        &mut renderer,
        &surface(fine)?,
        &settings(size, gaussian(0.74, 3.0), true)?,
    )?;
    plate = plate.panel("161 samples per axis", exact);
    let mut errors = Vec::new();
    for (name, kernel, prefilter) in DRAWN {
        let error = depth_error(&mut renderer, &scene, &settings(pixels, kernel, prefilter)?)?;
        table.row([name.into(), error.into()]);
        errors.push(error);
        plate = plate.panel(
            name,
            picture(&mut renderer, &scene, &settings(size, kernel, prefilter)?)?,
        );
    }
    outcome.find(
        Finding::new(
            FIGURE,
            "depth",
            "error of the surface's depth in the engine's picture: papers' kernel as sampled over default with prefilter",
            errors[0] / errors[3],
            Expectation::AtLeast(2.0),
        )
        .published(Published::Nothing)
        .detail(format!("{:.3} and {:.3} voxels, rms", errors[0], errors[3])),
    );
    outcome.tables.push(table);
    outcome.plates.push(plate);
    Ok(())
}

fn surface(volume: Volume) -> Result<Scene, LabError> {
    let surface = Isosurface {
        value: 0.5,
        rgb: [0.85, 0.8, 0.7],
        opacity: 1.0,
    };
    Ok(Scene::of_isosurfaces(volume, &[surface])?)
}

fn picture(renderer: &mut Renderer, scene: &Scene, settings: &RenderSettings) -> Result<Image, LabError> {
    let projection = Projection::Orthographic { height: 2.1 };
    let camera = Camera::new(DVec3::new(0.0, -5.0, 5.5), DVec3::ZERO, DVec3::Z, projection)?;
    Ok(shown(&renderer.render(scene, &camera, settings)?.image))
}

/// Root mean square of the depth's error where the box is at least four voxels away from its sides, voxels.
fn depth_error(renderer: &mut Renderer, scene: &Scene, settings: &RenderSettings) -> Result<f64, LabError> {
    const HEIGHT: f64 = 1.6;
    const FAR: f64 = 5.0;
    let projection = Projection::Orthographic { height: HEIGHT };
    let camera = Camera::new(DVec3::new(0.0, 0.0, FAR), DVec3::ZERO, DVec3::Y, projection)?;
    let frame = renderer.render(scene, &camera, settings)?;
    let side = settings.size.width() as usize;
    let errors = frame.depth.iter().enumerate().map(|(index, depth)| {
        let [x, y] = [index % side, index / side].map(|i| ((i as f64 + 0.5) / side as f64 - 0.5) * HEIGHT);
        FAR - f64::from(*depth) - height(x.hypot(y))
    });
    let squares: Vec<f64> = errors.map(|error| (error / SPACING).powi(2)).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    match mean.is_finite() {
        true => Ok(mean.sqrt()),
        false => Err(LabError::Measurement("a pixel shows no surface".to_owned())),
    }
}

/// Where the signal is 1/2: `sin(pi z / 2) = alpha rho(r)`.
fn height(r: f64) -> f64 {
    let MarschnerLobb { frequency, alpha } = MarschnerLobb::default();
    let rho = (TAU * frequency * (FRAC_PI_2 * r).cos()).cos();
    (alpha * rho).asin() / FRAC_PI_2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_surface_lies_where_the_signal_is_one_half() {
        let signal = MarschnerLobb::default();
        for r in [0.0, 0.1, 0.33, 0.7, 0.95] {
            let at = DVec3::new(0.6 * r, 0.8 * r, height(r));
            assert!((signal.value(at) - 0.5).abs() < 1e-12, "{r}");
        }
    }
}
