//! Teaches: a volume becomes a PNG in ten lines.
//!
//! `cargo run --release --example 01_volume_to_png [head.png] [SCAN]`, where SCAN is any file or folder that splatvol
//! reads; without it a built-in sample is rendered.

use splatvol::samples::{Sample, SampleSize};
use splatvol::{Camera, EngineConfig, Item, Projection, RenderSettings, Renderer, Scene, View, io};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let output = args.next().unwrap_or_else(|| "head.png".to_owned());

    // The ten lines. Colours and opacities are chosen from the values.
    let item = match args.next() {
        Some(scan) => io::read_item(scan)?,
        None => Item::automatic(Sample::Head.generate(Some(SampleSize::Longest(128)))?),
    };
    let scene = Scene::from(item);
    let settings = RenderSettings::default();
    let aspect = settings.size.aspect();
    let camera = Camera::framing(&scene.bounds()?, View::Front, Projection::default(), aspect)?;
    let frame = Renderer::new(EngineConfig::default())?.render(&scene, &camera, &settings)?;
    io::write_frame(&output, &frame, &[])?;

    println!("wrote {output}");
    Ok(())
}
