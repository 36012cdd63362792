//! Animations, decoded again.

use splatvol_io::image::png::Depth;
use splatvol_io::{AnimationSettings, ApngWriter, GifWriter};
use splatvol_scene::{Image, ImageSize};

fn settings(frames: u32, fps: f64) -> AnimationSettings {
    AnimationSettings {
        size: ImageSize::new(64, 32).expect("it is there and whole"),
        frames,
        fps,
        alpha: false,
        depth: Depth::Eight,
    }
}

/// A picture of `colors` different colours on a background that fills half of it.
fn picture(colors: usize) -> Image {
    let size = settings(1, 1.0).size;
    let pixel = |i: usize| match i % 2 {
        0 => [0.02, 0.02, 0.03, 1.0],
        _ => {
            let share = (i / 2 % colors) as f32 / colors as f32;
            [share, 1.0 - share, 0.5 * share * share, 1.0]
        }
    };
    Image::from_pixels(size, (0..size.pixel_count()).map(pixel).collect()).expect("it is there and whole")
}

fn decode(bytes: &[u8]) -> Vec<(u16, Vec<u8>)> {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(bytes).expect("it is there and whole");
    let mut frames = Vec::new();
    while let Some(frame) = decoder.read_next_frame().expect("it is there and whole") {
        frames.push((frame.delay, frame.buffer.to_vec()));
    }
    frames
}

#[test]
fn few_colours_are_kept_and_many_are_close() {
    for (colors, tolerance) in [(1, 0), (100, 0), (1024, 24)] {
        let image = picture(colors);
        let mut bytes = Vec::new();
        let mut writer = GifWriter::new(&mut bytes, settings(1, 10.0)).unwrap();
        writer.write(&image).unwrap();
        writer.finish().unwrap();
        let frames = decode(&bytes);
        let expected = splatvol_io::image::png::srgb8(&image).concat();
        let most = frames[0]
            .1
            .iter()
            .zip(&expected)
            .map(|(a, b)| a.abs_diff(*b))
            .max();
        assert!(most <= Some(tolerance), "{colors} colours: off by {most:?}");
        assert_eq!(frames[0].1[..4], expected[..4], "the background");
    }
}

#[test]
fn rounded_times_of_frames_add_up() {
    for fps in [30.0, 24.0, 49.9, 7.0] {
        let mut bytes = Vec::new();
        let mut writer = GifWriter::new(&mut bytes, settings(60, fps)).unwrap();
        for _ in 0..60 {
            writer.write(&picture(2)).unwrap();
        }
        writer.finish().unwrap();
        let total: u32 = decode(&bytes).iter().map(|(delay, _)| u32::from(*delay)).sum();
        assert_eq!(f64::from(total), (6000.0 / fps).round(), "{fps}");
    }
}

#[test]
fn what_was_not_announced_is_refused() {
    let other = Image::filled(ImageSize::new(3, 3).unwrap(), [0.0; 4]);
    let mut gif = GifWriter::new(Vec::new(), settings(1, 10.0)).unwrap();
    assert!(gif.write(&other).unwrap_err().to_string().contains("3x3"));
    gif.write(&picture(3)).unwrap();
    assert!(
        gif.write(&picture(3))
            .unwrap_err()
            .to_string()
            .contains("more than 1")
    );
    gif.finish().unwrap();
    let mut apng = ApngWriter::new(Vec::new(), settings(2, 10.0), &[]).unwrap();
    assert!(apng.write(&other).is_err());
    apng.write(&picture(3)).unwrap();
    assert!(apng.finish().unwrap_err().to_string().contains("1 frames of 2"));
    for (frames, fps) in [(0, 10.0), (1, 0.0), (1, f64::NAN), (1, 1e9)] {
        assert!(GifWriter::new(Vec::new(), settings(frames, fps)).is_err());
        assert!(ApngWriter::new(Vec::new(), settings(frames, fps), &[]).is_err());
    }
}
