//! The camera of a scene.

use clap::ValueEnum;
use splatvol::View;
use splatvol_document::{CameraKeys, Lens};
use splatvol_io::SceneCamera;

use crate::args::ViewName;
use crate::failure::Failure;

/// The keys of a scene's camera.
pub(super) fn keys(camera: &SceneCamera) -> Result<CameraKeys, Failure> {
    let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
    let triples = [camera.position, camera.target, camera.up];
    let numbers = [
        camera.fov,
        camera.orthographic,
        camera.azimuth,
        camera.elevation,
        camera.zoom,
    ];
    if !triples.iter().flatten().all(|triple| finite(triple))
        || !numbers.iter().flatten().all(|n| n.is_finite())
    {
        return Err(Failure::usage("camera: numbers have to be finite"));
    }
    let view = camera.view.as_deref().map(|name| {
        ViewName::from_str(name, false).map_err(|_| {
            let names = "front, back, left, right, top, bottom, iso";
            Failure::usage(format!("camera.view = {name:?}: expected one of {names}"))
        })
    });
    let both = |a: bool, b: bool, what| match a && b {
        true => Err(Failure::usage(format!("camera: {what} exclude each other"))),
        false => Ok(()),
    };
    both(
        camera.view.is_some(),
        camera.position.is_some(),
        "view and position",
    )?;
    both(
        camera.fov.is_some(),
        camera.orthographic.is_some(),
        "fov and orthographic",
    )?;
    Ok(CameraKeys {
        view: view.transpose()?.map(View::from),
        fit: None,
        position: camera.position,
        target: camera.target,
        up: camera.up,
        lens: match (camera.fov, camera.orthographic) {
            (Some(degrees), _) => Some(Lens::FieldOfView(degrees)),
            (None, height) => height.map(|height| Lens::Parallel(Some(height))),
        },
        azimuth: camera.azimuth,
        elevation: camera.elevation,
        zoom: camera.zoom,
    })
}
