//! Fig. 7 (e) and (f): microtubules, all of them beyond k.

use glam::DVec3;
use splatvol::{
    Camera, ImageSize, OpacityPoint, Projection, RenderSettings, Samples, Scene, TransferFunction, Volume,
};
use splatvol_samples::Sample;

use super::comparison::compare;
use super::verdicts::{Claims, report};
use super::view::{METHODS, View};
use super::window::Window;
use crate::{Expectation, Experiment, Finding, LabError, Outcome, Published, Workbench};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "swan1997-microtubules",
    paper: "swan1997",
    title: "Microtubules, all of them beyond k",
    figures: &["Fig. 7"],
    about: "The paper shows a confocal study of microtubules, 420 x 468 x 62 voxels, 103 thousand of them splats, in 270 x 270 \
pixels. All of it is seen, at much the same distance, and all of it lies beyond k; without anti-aliasing it is jagged, and \
shimmers when animated.\n\n\
The data are not published: ours are the built-in sample of that size, smoothed by means of 3 x 3 x 3 voxels. As in the \
paper, voxels above a threshold are splats; the threshold is the one that leaves closest to 103 thousand of them. The camera sees all of the volume from above \
and in front, in perspective.\n\n\
Filters, aliased energy and flicker as in swan1997-checker, over the whole picture; the camera flies sideways by a sixth of \
a voxel per frame.",
    run,
};

/// Splats of the paper's figure.
const SPLATS: f64 = 103_000.0;

const CLAIMS: Claims = Claims {
    figures: ["Fig. 7 (e)", "Fig. 7 (f)"],
    plain: "jagged artifacts",
    least: 0.05,
    smoothed: "smoothed out",
    animated: Some("shimmering disappears"),
};

/// The least value of voxels that are splats, and the number of these.
fn threshold(volume: &Volume) -> (f64, f64) {
    let [low, high] = volume.value_range();
    // One bin per stored value.
    let bins = (high - low) as usize + 1;
    let histogram = volume.histogram(bins);
    let mut above = 0.0;
    let mut best = (high, 0.0);
    for (bin, &count) in histogram.iter().enumerate().rev() {
        above += count as f64;
        if f64::abs(above - SPLATS) < f64::abs(best.1 - SPLATS) {
            best = (low + bin as f64, above);
        }
    }
    best
}

/// Means of 3 x 3 x 3 samples: without their grain, so that a threshold leaves the tubes whole.
fn smoothed(volume: &Volume) -> Result<Volume, LabError> {
    let dims = volume.grid().dims();
    let mut values: Vec<f32> = (0..volume.grid().sample_count())
        .map(|index| volume.value(index) as f32)
        .collect();
    let mut step = 1;
    for count in dims {
        let at = |index: usize| index / step % count;
        values = (0..values.len())
            .map(|index| {
                let before = if at(index) > 0 { index - step } else { index };
                let after = if at(index) + 1 < count {
                    index + step
                } else {
                    index
                };
                (values[before] + values[index] + values[after]) / 3.0
            })
            .collect();
        step *= count;
    }
    let bytes = values.iter().map(|value| value.round() as u8).collect();
    let grid = volume.grid().clone();
    Ok(Volume::new(
        grid,
        Samples::U8(bytes),
        volume.rescale(),
        volume.unit(),
    )?)
}

/// The sample's colours and opacities, and nothing below the threshold.
fn scene() -> Result<(Scene, f64), LabError> {
    let volume = smoothed(&Sample::Microtubules.generate(None)?)?;
    let (threshold, splats) = threshold(&volume);
    let look = Sample::Microtubules.default_transfer_function()?;
    let opacities = vec![
        OpacityPoint::new(threshold - 0.75, 0.0),
        OpacityPoint::new(threshold - 0.25, look.opacity(threshold)),
        OpacityPoint::new(255.0, look.opacity(255.0)),
    ];
    let look = TransferFunction::new(look.colors().to_vec(), opacities, look.unit_distance)?;
    Ok((Scene::new(volume, look), splats))
}

/// Least and greatest visible depth; splats appear at sizes in inverse proportion to it.
fn depths(view: &View) -> Result<[f64; 2], LabError> {
    let camera_from_world = view.camera.camera_from_world();
    let depths = view.scene.single_volume()?.volume.grid().corners().map(|corner| {
        let point = camera_from_world.transform_point3(corner);
        point.z
    });
    Ok([
        depths.into_iter().fold(f64::INFINITY, f64::min),
        depths.into_iter().fold(0.0, f64::max),
    ])
}

/// Corners of the volume outside the picture.
fn unseen(view: &View) -> Result<f64, LabError> {
    let screen = view.camera.screen_from_camera(view.size);
    let camera_from_world = view.camera.camera_from_world();
    let [width, height] = <[u32; 2]>::from(view.size).map(f64::from);
    let outside = |corner: &DVec3| {
        let pixel = screen.project(camera_from_world.transform_point3(*corner));
        !(0.0..width).contains(&pixel.x) || !(0.0..height).contains(&pixel.y)
    };
    let corners = view.scene.single_volume()?.volume.grid().corners();
    Ok(corners.iter().filter(|corner| outside(corner)).count() as f64)
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let (scene, splats) = scene()?;
    let size = ImageSize::new(270, 270)?;
    let target = scene.bounds()?.centre();
    let away = 1000.0 * DVec3::new(0.03, -0.55, 0.8).normalize();
    let projection = Projection::Perspective { fov_degrees: 30.0 };
    let view = View {
        scene,
        camera: Camera::new(target + away, target, DVec3::Z, projection)?,
        size,
        lighting: RenderSettings::swan1997().lighting,
    };
    let mut outcome = Outcome::default();
    outcome.find(
        Finding::new(
            "Fig. 7 (e)",
            "splats",
            "splats",
            splats,
            Expectation::relative(SPLATS, 0.05),
        )
        .published(Published::Number(SPLATS)),
    );
    outcome.find(
        Finding::new(
            "Fig. 7 (e)",
            "unseen",
            "corners of the volume outside the picture",
            unseen(&view)?,
            Expectation::AtMost(0.0),
        )
        .published(Published::Claim("the entire dataset is visible".to_owned())),
    );
    let [nearest, farthest] = depths(&view)?;
    outcome.find(
        Finding::new(
            "Fig. 7 (e)",
            "nearest",
            "distance of the volume's nearest corner, in distances k",
            nearest / view.k()?,
            Expectation::AtLeast(1.0),
        )
        .published(Published::Claim("all splats are drawn beyond k".to_owned()))
        .detail(format!("farthest {:.2}", farthest / view.k()?)),
    );
    outcome.find(
        Finding::new(
            "Fig. 7 (e)",
            "range-of-sizes",
            "largest against smallest size of splats on screen, standard splatting",
            farthest / nearest,
            Expectation::AtMost(2.0),
        )
        .published(Published::Claim(
            "the range of splat sizes is much smaller".to_owned(),
        )),
    );
    let plain = view.frame(&mut bench.renderer()?, METHODS[0].filter)?;
    let sideways = DVec3::X / 6.0;
    let comparison = compare(bench, &view, &Window::whole(&plain.image), sideways)?;
    report(&mut outcome, &comparison, &view, &CLAIMS)?;
    Ok(outcome)
}
