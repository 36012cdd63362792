//! Teaches: an animation: a camera that goes round, frames that are written as they come, memory that is reused.
//!
//! `cargo run --release --example 05_turntable [spin.gif]`, or `spin.png` for an animated PNG with all colours.

use std::fs::File;
use std::io::BufWriter;

use splatvol::io::image::png::Depth;
use splatvol::io::{AnimationSettings, ApngWriter, GifWriter};
use splatvol::samples::{Sample, SampleSize};
use splatvol::{
    Camera, CameraPath, EngineConfig, Frame, Image, ImageSize, Projection, RenderSettings, Renderer, Scene,
    View,
};

/// Frames of one round.
const FRAMES: u32 = 24;
/// White, opaque.
const BACKGROUND: [f32; 4] = [1.0; 4];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = std::env::args().nth(1).unwrap_or_else(|| "spin.gif".to_owned());

    let sample = Sample::Tomato;
    let volume = sample.generate(Some(SampleSize::Longest(64)))?;
    let scene = Scene::new(volume, sample.default_transfer_function()?);
    let settings = RenderSettings::fast().with_size(ImageSize::new(200, 200)?);
    let aspect = settings.size.aspect();
    let start = Camera::framing(&scene.bounds()?, View::Front, Projection::default(), aspect)?;
    let path = CameraPath::turntable(start, 360.0)?;

    let mut renderer = Renderer::new(EngineConfig::default())?;
    let mut frame = Frame::empty(settings.size);
    let mut writer = Writer::new(&output, settings.size)?;
    for index in 0..FRAMES {
        // A closed path: the camera of time 1 is that of time 0, which the first frame has.
        let camera = path.camera(f64::from(index) / f64::from(FRAMES))?;
        renderer.render_into(&scene, &camera, &settings, &mut frame)?;
        writer.write(&frame.image.over(BACKGROUND))?;
    }
    writer.finish()?;
    println!("wrote {output}");
    Ok(())
}

/// A file in one of the formats for animations.
enum Writer {
    Gif(GifWriter<BufWriter<File>>),
    Apng(ApngWriter<BufWriter<File>>),
}

impl Writer {
    fn new(path: &str, size: ImageSize) -> Result<Self, Box<dyn std::error::Error>> {
        let settings = AnimationSettings {
            size,
            frames: FRAMES,
            fps: 12.0,
            alpha: false,
            depth: Depth::Eight,
        };
        let file = BufWriter::new(File::create(path)?);
        Ok(if path.ends_with(".png") {
            Self::Apng(ApngWriter::new(file, settings, &[])?)
        } else {
            Self::Gif(GifWriter::new(file, settings)?)
        })
    }

    fn write(&mut self, image: &Image) -> Result<(), splatvol::io::IoError> {
        match self {
            Self::Gif(writer) => writer.write(image),
            Self::Apng(writer) => writer.write(image),
        }
    }

    fn finish(self) -> Result<(), splatvol::io::IoError> {
        match self {
            Self::Gif(writer) => writer.finish(),
            Self::Apng(writer) => writer.finish(),
        }
    }
}
