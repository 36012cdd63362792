//! The engine's picture of the surface of the value 1/2, whose height has a closed form:
//! `sin(pi z / 2) = alpha cos(2 pi f cos(pi r / 2))`.
//!
//! The surface is a transfer function that turns opaque within 1/200 of the range; light comes from a little behind the
//! surface, by nearly the same length everywhere, so the error is the standard deviation.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;
use splatvol::{
    Camera, Filter, FlatSettings, Image, ImageSize, Kernel, Projection, RenderSettings, Renderer, Scene,
    TransferFunction, Volume,
};
use splatvol_testing::fields::MarschnerLobb;
use splatvol_testing::sample;

use super::super::scenes::shown;
use super::{FIGURE, SIDE, SPACING, gaussian};
use crate::{Expectation, Finding, LabError, Outcome, Plate, Table, Workbench};

/// Kernels that the engine draws surfaces with.
const DRAWN: [(&str, Kernel, bool); 4] = [
    ("gaussian .602/2", gaussian(0.602, 2.0), false),
    ("gaussian .602/2, prefiltered", gaussian(0.602, 2.0), true),
    ("gaussian .74/3", gaussian(0.74, 3.0), false),
    ("gaussian .74/3, prefiltered", gaussian(0.74, 3.0), true),
];

fn settings(pixels: u32, kernel: Kernel, prefilter: bool) -> Result<RenderSettings, LabError> {
    Ok(RenderSettings::try_from(FlatSettings {
        size: ImageSize::new(pixels, pixels)?,
        filter: Filter::None,
        kernel,
        prefilter,
        sheet_thickness: 0.25,
        ..RenderSettings::best().into()
    })?)
}

/// Draws surfaces and compares their depth.
pub(super) fn surfaces(
    bench: &Workbench<'_>,
    volume: &Volume,
    outcome: &mut Outcome,
) -> Result<(), LabError> {
    let mut renderer = bench.renderer()?;
    let scene = surface(volume.clone())?;
    let pixels = bench.choose(192, 96);
    let columns = ["kernel", "error of the depth (voxels, standard deviation)"];
    let mut table = Table::new(
        "surfaces",
        FIGURE,
        "The engine's surface of the value 1/2",
        &columns,
    );
    // Enough samples to show the signal itself.
    let samples = bench.choose(3, 2) * (SIDE - 1) + 1;
    let exact = format!("{samples} samples per axis");
    let mut plate = Plate::new(
        "surfaces",
        FIGURE,
        &format!("The surface of the value 1/2, lit, by the engine; left, from {exact}, as it should be"),
    );
    let fine = surface(sample(&MarschnerLobb::default(), &MarschnerLobb::grid(samples)))?;
    let size = bench.choose(240, 96);
    let [small, large] = [size, pixels].map(|pixels| settings(pixels, gaussian(0.74, 3.0), true));
    let floor = depth_error(&mut renderer, &fine, &large?)?;
    table.row([exact.as_str().into(), floor.into()]);
    plate = plate.panel(&exact, picture(&mut renderer, &fine, &small?)?);
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
        .detail(format!("{:.3} and {:.3} voxels", errors[0], errors[3])),
    );
    outcome.tables.push(table);
    outcome.plates.push(plate);
    Ok(())
}

fn surface(volume: Volume) -> Result<Scene, LabError> {
    let look = TransferFunction::isosurface(0.5, 0.005, [0.85, 0.8, 0.7])?;
    Ok(Scene::new(volume, look))
}

fn picture(renderer: &mut Renderer, scene: &Scene, settings: &RenderSettings) -> Result<Image, LabError> {
    let projection = Projection::Orthographic { height: 2.1 };
    let camera = Camera::new(DVec3::new(0.0, -5.0, 5.5), DVec3::ZERO, DVec3::Z, projection)?;
    Ok(shown(&renderer.render(scene, &camera, settings)?.image))
}

/// Standard deviation of the depth's error where the box is at least four voxels away from its sides, voxels.
fn depth_error(renderer: &mut Renderer, scene: &Scene, settings: &RenderSettings) -> Result<f64, LabError> {
    const HEIGHT: f64 = 1.6;
    const FAR: f64 = 5.0;
    let projection = Projection::Orthographic { height: HEIGHT };
    let camera = Camera::new(DVec3::new(0.0, 0.0, FAR), DVec3::ZERO, DVec3::Y, projection)?;
    let frame = renderer.render(scene, &camera, settings)?;
    let side = settings.size.width() as usize;
    let errors = frame.depth.iter().enumerate().map(|(index, depth)| {
        let [x, y] = [index % side, index / side].map(|i| ((i as f64 + 0.5) / side as f64 - 0.5) * HEIGHT);
        (FAR - f64::from(*depth) - height(x.hypot(y))) / SPACING
    });
    let errors: Vec<f64> = errors.collect();
    let mean = |of: &dyn Fn(f64) -> f64| errors.iter().map(|&e| of(e)).sum::<f64>() / errors.len() as f64;
    let offset = mean(&|e| e);
    match offset.is_finite() {
        true => Ok(mean(&|e| (e - offset).powi(2)).sqrt()),
        false => Err(LabError::Measurement("a pixel shows no surface".to_owned())),
    }
}

/// Height of the isosurface 1/2: `sin(pi z / 2) = alpha rho(r)`.
fn height(r: f64) -> f64 {
    let MarschnerLobb { frequency, alpha } = MarschnerLobb::default();
    let rho = (TAU * frequency * (FRAC_PI_2 * r).cos()).cos();
    (alpha * rho).asin() / FRAC_PI_2
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol_testing::Field;

    #[test]
    fn the_surface_lies_where_the_signal_is_one_half() {
        let signal = MarschnerLobb::default();
        for r in [0.0, 0.1, 0.33, 0.7, 0.95] {
            let at = DVec3::new(0.6 * r, 0.8 * r, height(r));
            assert!((signal.value(at) - 0.5).abs() < 1e-12, "{r}");
        }
    }
}
