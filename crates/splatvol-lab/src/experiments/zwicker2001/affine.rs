//! Fig. 4: the error of the local affine approximation of the perspective.
//!
//! The exact line integral of a sphere of standard deviation sigma along the ray d is `exp(-r^2 / 2 sigma^2)` times
//! that through its centre u. Here r is the distance of the ray from u: `r = |u x d| / |d|`. To first order the affine
//! footprint differs from it by `max 2 rho^3 |q'| tan(angle) sigma / |u|`, which is `(3/e)^1.5 tan(angle) sigma / |u|`
//! for a Gaussian.

use glam::{DMat3, DVec2, DVec3};
use splatvol::{
    Alignment, Camera, Classification, Compositing, Filter, FlatSettings, ImageSize, Projection,
    RenderSettings, Scene,
};
use splatvol_core::splats::GaussianProfile;
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::Comparison;

use super::splat::Splat;
use crate::{
    Axis, Cell, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, Published, Table,
    Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "zwicker2001-affine",
    paper: "zwicker2001",
    title: "The local affine approximation",
    figures: &["Fig. 4"],
    about: "The paper draws a kernel in camera and in ray space, once mapped by the local affine approximation (eq. \
            17) and once exactly. It says that the approximation is exact for the ray through the centre, that \
            errors grow with the divergence of rays, and that they do not lead to visual artifacts in general.\n\n\
            We take a sphere of standard deviation sigma at the distance |u| and at an angle to the viewing axis, \
            and draw its footprint with the engine's affine projection. We compare it with the closed form of the \
            line integral along each pixel's own ray, in 64 bits. The error is the largest difference, as a share of the \
            peak. The divergence of rays within a kernel is sigma / |u|.\n\n\
            The paper gives no numbers. Its claim about artifacts is tested on the built-in head, with affine and \
            with exact footprints, otherwise equal: from where all of it is seen with 30 degrees, and with 90.",
    run,
};

/// sigma / |u|.
const DIVERGENCES: [f64; 4] = [0.003, 0.01, 0.03, 0.1];
/// A level of eight bits.
const LEVEL: f64 = 1.0 / 255.0;

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut outcome = Outcome::default();
    bench.step(0, 3, "footprints");
    errors(&mut outcome, bench.choose(5, 15))?;
    bench.step(1, 3, "pictures");
    pictures(bench, &mut outcome)?;
    outcome.plots.push(shapes());
    Ok(outcome)
}

/// Largest error of the affine footprint, and that at its centre, shares of the peak.
fn error(degrees: f64, divergence: f64) -> Result<[f64; 2], LabError> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let centre = DVec3::new(sin, 0.0, cos);
    let splat = Splat::sphere(centre, DMat3::from_diagonal(DVec3::splat(divergence)));
    let profile = GaussianProfile::new(5.0);
    let footprint = splat.footprint(Filter::None, Alignment::Affine, &profile)?;
    // Through the centre of a Gaussian of unit mass per cell.
    let peak = divergence / std::f64::consts::TAU;
    let exact = |pixel: [f32; 2]| {
        let ray = Splat::ray(DVec2::from_array(pixel.map(f64::from)));
        let distance = centre.cross(ray).length() / ray.length();
        (-0.5 * (distance / divergence).powi(2)).exp()
    };
    let found = |pixel| f64::from(footprint.integral(&profile, None, pixel)) / peak;
    let [x0, y0, x1, y1] = footprint.bounds;
    const STEPS: u16 = 121;
    let at = |low: f32, high: f32, i: u16| low + (high - low) * f32::from(i) / f32::from(STEPS - 1);
    let largest = (0..STEPS * STEPS)
        .map(|i| [at(x0, x1, i % STEPS), at(y0, y1, i / STEPS)])
        .map(|pixel| (found(pixel) - exact(pixel)).abs())
        .fold(0.0, f64::max);
    let centre = footprint.centre;
    Ok([largest, (found(centre) - exact(centre)).abs()])
}

fn errors(outcome: &mut Outcome, step: usize) -> Result<(), LabError> {
    let mut table = Table::new(
        "errors",
        "Fig. 4",
        "Largest error of the affine footprint",
        &[
            "angle to the axis (degrees)",
            "sigma / distance",
            "error (share of the peak)",
            "at the centre",
        ],
    )
    .hidden();
    let mut plot = Plot::curves(
        "error",
        "Fig. 4",
        "Error of the affine footprint against the field angle",
        Axis::new("angle to the viewing axis (degrees)").range(0.0, 60.0),
        Axis::logarithmic("largest error (share of the peak)").range(1e-6, 1.0),
    );
    let (mut centre, mut falls) = (0.0f64, 0usize);
    for divergence in DIVERGENCES {
        let mut points: Vec<[f64; 2]> = Vec::new();
        for degrees in (0..=60).step_by(step) {
            let [largest, at_centre] = error(degrees as f64, divergence)?;
            centre = centre.max(at_centre);
            falls += usize::from(points.last().is_some_and(|last| largest < last[1]));
            points.push([degrees as f64, largest]);
            table.row([
                degrees.into(),
                divergence.into(),
                largest.into(),
                at_centre.into(),
            ]);
        }
        plot = plot.curve(Curve::new(&format!("sigma / distance {divergence}"), points).dots());
    }
    outcome.plots.push(plot);
    outcome.tables.push(table);
    let claim = |words: &str| Published::Claim(words.to_owned());
    outcome.find(
        Finding::new(
            "Fig. 4",
            "error-at-centre",
            "error along the ray through the centre, share of the peak, largest of all",
            centre,
            Expectation::AtMost(1e-4),
        )
        .published(claim("exact only for the ray through the centre")),
    );
    outcome.find(
        Finding::new(
            "Fig. 4",
            "falls-with-angle",
            "steps of the field angle at which the error falls",
            falls as f64,
            Expectation::AtMost(0.0),
        )
        .published(claim("errors grow with increasing ray divergence")),
    );
    laws(outcome)
}

/// Growth of the errors, against the first order.
fn laws(outcome: &mut Outcome) -> Result<(), LabError> {
    let [narrow, wide] = [error(30.0, 0.003)?[0], error(30.0, 0.03)?[0]];
    outcome.find(
        Finding::new(
            "Fig. 4",
            "order-of-divergence",
            "order of the error in sigma / distance, 30 degrees off the axis",
            (wide / narrow).log10(),
            Expectation::Near {
                value: 1.0,
                within: 0.1,
            },
        )
        .published(Published::Claim(
            "errors grow with increasing ray divergence".to_owned(),
        )),
    );
    let first_order = (3.0 / std::f64::consts::E).powf(1.5) * 45f64.to_radians().tan() * 0.003;
    outcome.find(Finding::new(
        "Fig. 4",
        "first-order",
        "error 45 degrees off the axis over that of the first order, sigma / distance .003",
        error(45.0, 0.003)?[0] / first_order,
        Expectation::relative(1.0, 0.05),
    ));
    // 256 voxels across, framed by 30 degrees: the corner of the picture, on the near face of the data.
    let distance = 128.0 / 15f64.to_radians().tan();
    let corner = 2f64.sqrt() * 15f64.to_radians().tan();
    outcome.find(
        Finding::new(
            "Fig. 4",
            "error-in-levels",
            "error in the corner of a view of 256 voxels with 30 degrees, kernels of one voxel",
            error(corner.atan().to_degrees(), corner.atan().cos() / distance)?[0] / LEVEL,
            Expectation::AtMost(1.0),
        )
        .unit("levels of 8 bits")
        .published(Published::Claim(
            "no visual artifacts in general, the fan of rays having a small opening angle".to_owned(),
        )),
    );
    Ok(())
}

/// The head with affine and exact footprints.
fn pictures(bench: &Workbench<'_>, outcome: &mut Outcome) -> Result<(), LabError> {
    let (side, pixels) = bench.choose((256, 320), (48, 64));
    let sample = Sample::Head;
    let volume = sample.generate(Some(SampleSize::Longest(side)))?;
    let bounds = volume.grid().bounds();
    let scene = Scene::new(volume, sample.default_transfer_function()?);
    let mut table = Table::new(
        "pictures",
        "Fig. 4",
        "The head with affine and with exact footprints",
        &[
            "field of view (degrees)",
            "largest difference (levels of 8 bits)",
            "PSNR (dB)",
        ],
    );
    let mut plate = Plate::new(
        "head",
        "Fig. 4",
        "The head with affine and with exact footprints, 90 degrees",
    );
    let mut renderer = bench.renderer()?;
    for (key, fov_degrees) in [("levels-30-degrees", 30.0), ("levels-90-degrees", 90.0)] {
        let projection = Projection::Perspective { fov_degrees };
        let camera = Camera::framing(&bounds, splatvol::View::Iso, projection, 1.0)?;
        let mut of = |alignment| -> Result<splatvol::Image, LabError> {
            let settings = RenderSettings::try_from(FlatSettings {
                size: ImageSize::new(pixels, pixels)?,
                compositing: Compositing::AxisSheets,
                classification: Classification::Pre,
                filter: Filter::Ewa { pixel_sigma: 0.55 },
                alignment,
                ..RenderSettings::best().into()
            })?;
            Ok(renderer.render(&scene, &camera, &settings)?.image)
        };
        let [affine, exact] = [of(Alignment::Affine)?, of(Alignment::Exact)?];
        let comparison = Comparison::of(&affine, &exact);
        let levels = comparison.max_error / LEVEL;
        let nearest = bounds
            .corners()
            .map(|corner| (corner - camera.position()).length());
        let sigma = 0.74 * bounds.diagonal() / (3f64.sqrt() * side as f64);
        let divergence = sigma / nearest.into_iter().fold(f64::INFINITY, f64::min);
        let row: [Cell; 3] = [fov_degrees.into(), levels.into(), comparison.psnr.into()];
        table.row(row);
        outcome.find(
            Finding::new(
                "Fig. 4",
                key,
                &format!(
                    "largest difference of the head's picture from exact footprints, {fov_degrees} degrees"
                ),
                levels,
                Expectation::AtMost(2.0),
            )
            .unit("levels of 8 bits")
            .detail(format!("PSNR {:.1} dB", comparison.psnr))
            .published(Published::Claim("no visual artifacts in general".to_owned()))
            .explained_by(
                "voxels are coarse here: sigma over the distance of the nearest one",
                divergence,
                Expectation::AtLeast(0.03),
            ),
        );
        if fov_degrees > 60.0 {
            plate = plate.panel("affine", affine).panel("exact", exact);
        }
    }
    outcome.tables.push(table);
    outcome.plates.push(plate);
    Ok(())
}

/// The figure itself: a circle in camera space, mapped to ray space both ways (eq. 15 and 17).
fn shapes() -> Plot {
    let centre = [0.8, 1.0];
    let radius = 0.45;
    let map = |[u0, u2]: [f64; 2]| [u0 / u2, f64::hypot(u0, u2)];
    let [x0, x2] = map(centre);
    let affine = |[u0, u2]: [f64; 2]| {
        let ([d0, d2], [c0, c2]) = ([u0 - centre[0], u2 - centre[1]], centre);
        [x0 + d0 / c2 - c0 * d2 / (c2 * c2), x2 + (c0 * d0 + c2 * d2) / x2]
    };
    let circle: Vec<[f64; 2]> = (0..=90)
        .map(|i| (f64::from(i) * 4.0).to_radians().sin_cos())
        .map(|(sin, cos)| [centre[0] + radius * cos, centre[1] + radius * sin])
        .collect();
    Plot::curves(
        "ray-space",
        "Fig. 4",
        "A kernel's outline in ray space, exaggerated as in the paper: radius .45 at (.8, 1)",
        Axis::new("x0 = u0 / u2"),
        Axis::new("x2: distance from the eye"),
    )
    .curve(Curve::new("exact mapping", circle.iter().map(|&u| map(u))))
    .curve(Curve::new("local affine mapping", circle.iter().map(|&u| affine(u))).dashed())
    .curve(Curve::new("centre", [[x0, x2]]).dots())
}
