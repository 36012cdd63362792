//! Fig. 7 (a) and (b): a checkered sheet that recedes into the distance.

use glam::DVec3;
use splatvol::{Camera, ImageSize, Projection, Scene};
use splatvol_samples::Sample;

use super::comparison::{Comparison, compare};
use super::verdicts::{Claims, report};
use super::view::{METHODS, View};
use super::window::Window;
use crate::{Expectation, Experiment, Finding, LabError, Outcome, Published, Workbench};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "swan1997-checker",
    paper: "swan1997",
    title: "A checkered sheet that recedes into the distance",
    figures: &["Fig. 7"],
    about: "The paper shows a volume of 498 x 398 x 1 voxels, alternate squares of 10 x 10 red or white, in 270 x 157 pixels, \
without and with its filter; a black line marks the distance k, beyond which voxels lie less than a pixel apart.\n\n\
The sheet is generated as described. The paper does not give its camera: ours is 45 voxels above the sheet and looks down by \
25 degrees, with a view cone of 30 degrees to either side, as in section 4.6. All filters draw the paper's splats one by one \
(cubic spline of Crawfis and Max, across the ray through the voxel). *swan* lowers the extinction of splats that it scales, \
*swan by alpha* their opacity, as section 5 says; *ewa* is the filter of zwicker2001 with a standard deviation of .55 pixels.\n\n\
*Aliased energy* is the power above half a cycle per pixel, along rows or columns, which a raster of pixels cannot hold. It is \
that of the function of place which the picture samples: footprints of the very same size, sampled more closely; the mean is \
taken off, and a Hann window applied. Half pixels are reached by pictures one pixel wider and higher, whose axis moves by half a \
pixel. Standard splatting and ewa can be sampled 8 x 8 times per pixel, too. The window holds the rows beyond k whose middle half \
is on the sheet. As splats are opaque and hide each other, the same is measured once more with a thousandth of the \
extinction, where they only add up, as the paper's derivation has it.\n\n\
*Flicker* is the root mean square of the second difference in time of the luminance, for a camera that flies forward by half \
a voxel per frame. *Up the picture* is how far the texture stands too high, opaque splats reaching over what lies behind them.",
    run,
};

const CLAIMS: Claims = Claims {
    figures: ["Fig. 7 (a)", "Fig. 7 (b)"],
    plain: "strong aliasing",
    least: 0.1,
    smoothed: "smoothed out",
    animated: None,
};

/// The sheet under a camera above its near edge.
fn view() -> Result<View, LabError> {
    let volume = Sample::CheckerSheet.generate(None)?;
    let near = volume.grid().bounds().min.y;
    let scene = Scene::new(volume, Sample::CheckerSheet.default_transfer_function()?);
    let (sin, cos) = 25_f64.to_radians().sin_cos();
    let position = DVec3::new(0.0, near - 20.0, 45.0);
    let projection = Projection::Perspective { fov_degrees: 60.0 };
    Ok(View {
        scene,
        camera: Camera::new(
            position,
            position + DVec3::new(0.0, cos, -sin),
            DVec3::Z,
            projection,
        )?,
        size: ImageSize::new(270, 157)?,
        lighting: None,
    })
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let view = view()?;
    let mut renderer = bench.renderer()?;
    let plain = view.frame(&mut renderer, METHODS[0].filter)?;
    let k = view.k()?;
    let beyond = Window::at_depths(&plain, |depth| depth >= k)?.inside(1);
    // Splats just beyond k reach two pixels over the line.
    let before = Window::at_depths(&plain, |depth| depth < k)?.inside(3);
    let mut outcome = Outcome::default();
    let splats = view.scene.single_volume()?.volume.grid().sample_count() as f64;
    outcome.find(
        Finding::new(
            "Fig. 7 (a)",
            "splats",
            "splats",
            splats,
            Expectation::relative(198_000.0, 0.005),
        )
        .published(Published::Number(198_000.0)),
    );
    let comparison = compare(bench, &view, &beyond, 0.5 * DVec3::Y)?;
    outcome.find(changed_before_k(&comparison, &before));
    let fine = view.at_half_pixels(&mut renderer, METHODS[0].filter)?;
    // Of each window's own energy: squares are larger before k.
    let [near, far] = [&before, &beyond].map(|window| {
        let spectrum = fine.spectrum(window);
        spectrum.power_above(0.5) / spectrum.power_above(0.0)
    });
    outcome.find(
        Finding::new(
            "Fig. 7 (a)",
            "aliased-before-k",
            "share of the energy above the Nyquist limit before k against that beyond, standard splatting",
            near / far,
            Expectation::AtMost(0.1),
        )
        .published(Published::Claim("none before k (section 4.2)".to_owned()))
        .detail(format!("{:.3} % against {:.1} %", 100.0 * near, 100.0 * far)),
    );
    report(&mut outcome, &comparison, &view, &CLAIMS)?;
    Ok(outcome)
}

/// Case 1 of section 4.2: nothing is filtered before k.
fn changed_before_k(comparison: &Comparison, before: &Window) -> Finding {
    let of = |key: &str| comparison.measured.iter().find(|one| one.method.key == key);
    let light = |key: &str| {
        of(key)
            .map(|one| before.luminance(&one.frame.image))
            .unwrap_or_default()
    };
    let (plain, swan) = (light("plain"), light("swan"));
    let most = plain
        .iter()
        .zip(&swan)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    Finding::new(
        "Fig. 7 (b)",
        "changed-before-k",
        "largest difference that swan makes before k",
        255.0 * most,
        Expectation::AtMost(0.5),
    )
    .unit("levels")
    .published(Published::Claim("splats keep their size before k".to_owned()))
}
