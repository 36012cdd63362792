//! Look-alikes of the paper's data, which are not public, in its sizes; with `--quick` a quarter as long.

use glam::DVec3;
use splatvol::{
    Camera, ColorPoint, Grid, OpacityPoint, Projection, Samples, Scene, TransferFunction, View, Volume,
};
use splatvol_samples::{Sample, SampleSize};

use crate::{LabError, Workbench};

/// Edges of a volume of the paper, or a quarter of them.
fn dims(bench: &Workbench<'_>, full: [usize; 3]) -> [usize; 3] {
    bench.choose(full, full.map(|n| n / 4))
}

fn curves(colors: &[(f64, [f64; 3])], opacities: &[(f64, f64)]) -> Result<TransferFunction, LabError> {
    Ok(TransferFunction::new(
        colors.iter().map(|&(v, rgb)| ColorPoint::new(v, rgb)).collect(),
        opacities.iter().map(|&(v, a)| OpacityPoint::new(v, a)).collect(),
        None,
    )?)
}

/// These samples on cubic voxels of edge 1.
fn on_cubes(volume: &Volume) -> Result<Volume, LabError> {
    let grid = Grid::centred(volume.grid().dims(), DVec3::ONE)?;
    Ok(Volume::new(
        grid,
        volume.samples().clone(),
        volume.rescale(),
        volume.unit(),
    )?)
}

/// In place of the UNC brain, 256 x 256 x 145 cubes: the uppermost 145 of 256 slices of the sample `head`; opaque.
pub(super) fn brain(bench: &Workbench<'_>) -> Result<Scene, LabError> {
    let [edge, _, slices] = dims(bench, [256, 256, 145]);
    let head = Sample::Head.generate(Some(SampleSize::Dims([edge; 3])))?;
    let Samples::I16(values) = head.samples() else {
        return Err(LabError::Measurement("the head has no 16-bit samples".to_owned()));
    };
    let below = edge * edge * (edge - slices);
    let grid = Grid::centred([edge, edge, slices], DVec3::ONE)?;
    let samples = Samples::I16(values[below..].to_vec().into());
    let volume = Volume::new(grid, samples, head.rescale(), head.unit())?;
    let skin = curves(
        &[
            (-500.0, [0.86, 0.62, 0.50]),
            (60.0, [0.93, 0.72, 0.58]),
            (400.0, [0.97, 0.92, 0.82]),
        ],
        &[(-500.0, 0.0), (-250.0, 0.95)],
    )?;
    Ok(Scene::new(volume, skin))
}

/// In place of the OSU nerve, 512 x 512 x 76 voxels of 1:1:5: the sample `nerve`, opaque.
pub(super) fn nerve(bench: &Workbench<'_>) -> Result<Scene, LabError> {
    let size = SampleSize::Dims(dims(bench, [512, 512, 76]));
    let volume = Sample::Nerve.generate(Some(size))?;
    let opaque = curves(
        &[
            (60.0, [0.75, 0.35, 0.15]),
            (150.0, [0.95, 0.65, 0.25]),
            (235.0, [1.0, 0.92, 0.70]),
        ],
        &[(70.0, 0.0), (110.0, 0.95)],
    )?;
    Ok(Scene::new(volume, opaque))
}

/// The nerve's samples as cubes, whose footprints are circles from everywhere.
pub(super) fn nerve_of_cubes(nerve: &Scene) -> Result<Scene, LabError> {
    let nerve = nerve.single_volume()?;
    let volume = on_cubes(nerve.volume)?;
    Ok(Scene::new(volume, nerve.transfer_function.clone()))
}

/// In place of the Berkeley tomato, 256 x 256 x 256: the sample `tomato`, all opacities a fifth of its own.
pub(super) fn tomato(bench: &Workbench<'_>) -> Result<Scene, LabError> {
    let size = SampleSize::Dims(dims(bench, [256; 3]));
    let volume = Sample::Tomato.generate(Some(size))?;
    let own = Sample::Tomato.default_transfer_function()?;
    let faint = own
        .opacities()
        .iter()
        .map(|point| OpacityPoint::new(point.value, 0.2 * point.opacity));
    let faint = TransferFunction::new(own.colors().to_vec(), faint.collect(), None)?;
    Ok(Scene::new(volume, faint))
}

/// In place of the diesel injection, 64 x 64 x 64: a cone of spray with a dense core, semi-transparent.
pub(super) fn injection(bench: &Workbench<'_>) -> Result<Scene, LabError> {
    let edge = dims(bench, [64; 3])[0];
    let unit = |index: usize| (index as f64 + 0.5) / edge as f64;
    let value = |x: f64, y: f64, z: f64| {
        // From the nozzle at z = 0.1 down to z = 0.85; twelve lobes around the axis.
        let (dx, dy, along) = (x - 0.5, y - 0.5, z - 0.1);
        if !(0.0..0.75).contains(&along) {
            return 0.0;
        }
        let lobes = 1.0 + 0.15 * (12.0 * dy.atan2(dx)).cos();
        let width = (0.03 + 0.32 * along) * lobes;
        let across = dx.hypot(dy) / width;
        255.0 * (-2.0 * across * across).exp() * (1.0 - along / 0.75).sqrt()
    };
    let values = (0..edge * edge * edge).map(|index| {
        let [x, y, z] = [index % edge, index / edge % edge, index / (edge * edge)].map(unit);
        value(x, y, z) as u8
    });
    let samples = Samples::U8(values.collect());
    let grid = Grid::centred([edge; 3], DVec3::ONE)?;
    let volume = Volume::new(grid, samples, Default::default(), Default::default())?;
    let spray = curves(
        &[
            (10.0, [0.2, 0.4, 0.9]),
            (90.0, [0.9, 0.8, 0.3]),
            (220.0, [0.95, 0.3, 0.1]),
        ],
        &[(8.0, 0.0), (60.0, 0.05), (160.0, 0.2), (255.0, 0.5)],
    )?;
    Ok(Scene::new(volume, spray))
}

/// In place of the segmented vessels, 256 x 256 x 256: the branches of the sample `nerve` grown into a cube, opaque.
pub(super) fn vessels(bench: &Workbench<'_>) -> Result<Scene, LabError> {
    let size = SampleSize::Dims(dims(bench, [256; 3]));
    let volume = on_cubes(&Sample::Nerve.generate(Some(size))?)?;
    let red = curves(
        &[(60.0, [0.55, 0.08, 0.06]), (235.0, [0.95, 0.35, 0.25])],
        &[(100.0, 0.0), (140.0, 0.95)],
    )?;
    Ok(Scene::new(volume, red))
}

/// A square orthographic view of all of a scene.
pub(super) fn orthographic(scene: &Scene, view: View) -> Result<Camera, LabError> {
    let projection = Projection::Orthographic { height: 1.0 };
    framing(scene, view, projection)
}

/// A square perspective view of all of a scene.
pub(super) fn perspective(scene: &Scene, view: View) -> Result<Camera, LabError> {
    let projection = Projection::Perspective { fov_degrees: 30.0 };
    framing(scene, view, projection)
}

fn framing(scene: &Scene, view: View, projection: Projection) -> Result<Camera, LabError> {
    let bounds = scene.bounds()?;
    Ok(Camera::framing(&bounds, view, projection, 1.0)?)
}
