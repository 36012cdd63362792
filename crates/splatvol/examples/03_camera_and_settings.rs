//! Teaches: the same volume with other settings and from other cameras: presets, X-ray, maxima, and a method of the
//! papers.
//!
//! `cargo run --release --example 03_camera_and_settings [methods.png]` puts six pictures into one.

use splatvol::samples::{Sample, SampleSize};
use splatvol::{
    Camera, EngineConfig, Frame, Image, ImageSize, Item, Lighting, Projection, RenderSettings, Renderer,
    Scene, Shows, TransferFunction, View, io,
};

/// Pixels along the side of each picture.
const SIDE: u32 = 240;
/// Pictures in a row.
const COLUMNS: usize = 3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "methods.png".to_owned());
    let size = ImageSize::new(SIDE, SIDE)?;
    let head = std::sync::Arc::new(Sample::Head.generate(Some(SampleSize::Longest(80)))?);

    // Material, in the colours that suit its values; for values along rays, a ramp from black to white.
    let material = Scene::from(Item::automatic(head.clone()));
    let faint = Scene::new(head.clone(), TransferFunction::gray_ramp([-200.0, 1500.0], 0.06)?);
    let bright = Scene::new(head.clone(), TransferFunction::gray_ramp([-200.0, 1500.0], 1.0)?);
    // Means are low: most of a ray is air, which has -1000 HU.
    let dim = Scene::new(head, TransferFunction::gray_ramp([-1000.0, 200.0], 1.0)?);

    // Named views show all of the scene. Parallel projections have a height instead of an angle, which framing chooses;
    // a camera of one's own takes three points, as arrays or as vectors of `splatvol::glam`.
    let bounds = material.bounds()?;
    let framed = |view, projection| Camera::framing(&bounds, view, projection, size.aspect());
    let front = framed(View::Front, Projection::default())?;
    let left = framed(View::Left, Projection::Orthographic { height: 1.0 })?;
    let centre = bounds.centre();
    let wide = Projection::Perspective { fov_degrees: 70.0 };
    let close = Camera::new(
        centre + bounds.diagonal() * front.up() * 0.3 + 0.38 * (front.position() - centre),
        centre,
        [0.0, 0.0, 1.0],
        wide,
    )?;

    // Settings start from a preset; `with_*` changes what differs.
    let balanced = RenderSettings::balanced().with_size(size);
    let from_the_side = Lighting {
        direction: [-1.0, -0.4, -0.6],
        ..Lighting::default()
    };
    let pictures = [
        (&material, front, balanced),
        (&material, close, balanced.with_lighting(from_the_side)),
        (&material, front, RenderSettings::ewa2001().with_size(size)),
        (&faint, left, balanced.with_shows(Shows::Xray)),
        (&bright, left, balanced.with_shows(Shows::Mip)),
        (&dim, front, balanced.with_shows(Shows::Mean)),
    ];

    // One renderer for all: it keeps what it derives from a volume for the next picture.
    let mut renderer = Renderer::new(EngineConfig::default())?;
    let mut frames = Vec::new();
    for (scene, camera, settings) in &pictures {
        frames.push(renderer.render(scene, camera, settings)?);
    }
    io::write_frame(&output, &side_by_side(&frames)?, &[])?;
    println!("wrote {output}");
    Ok(())
}

/// Frames of one size in rows, over dark grey.
fn side_by_side(frames: &[Frame]) -> Result<Frame, splatvol::SceneError> {
    let side = SIDE as usize;
    let rows = frames.len().div_ceil(COLUMNS);
    let size = ImageSize::new(SIDE * COLUMNS as u32, SIDE * rows as u32)?;
    let mut all = Image::filled(size, [0.01, 0.01, 0.01, 1.0]);
    for (index, frame) in frames.iter().enumerate() {
        let picture = frame.image.over([0.01, 0.01, 0.01, 1.0]);
        let (left, top) = (index % COLUMNS * side, index / COLUMNS * side);
        for (y, row) in picture.pixels.chunks_exact(side).enumerate() {
            let start = (top + y) * side * COLUMNS + left;
            all.pixels[start..start + side].copy_from_slice(row);
        }
    }
    let mut frame = Frame::empty(size);
    frame.image = all;
    Ok(frame)
}
