//! Progressive rendering: a coarse picture at once, then finer ones.
//!
//! A pass renders the same view with every fourth, then every second, then every pixel. A coarser raster uses a coarser
//! level of detail, so the first pass costs about a sixteenth of the last. Levels keep the data's mean, so passes
//! differ in sharpness but not in brightness.

use splatvol_scene::{Camera, Frame, ImageSize, RenderSettings, Scene, SceneError};

use crate::Renderer;

/// Pixels per raster point of the passes.
const PASSES: [u32; 3] = [4, 2, 1];

/// Progress of a progressive picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pass {
    /// 0 for the first picture.
    pub index: usize,
    /// Whether this is the final picture, equal to that of [`Renderer::render`].
    pub is_last: bool,
}

impl Renderer {
    /// Renders a view in passes, each passed to `show` in full size; `show` returns `false` to end early.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn render_progressive(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
        mut show: impl FnMut(&Frame, Pass) -> bool,
    ) -> Result<(), SceneError> {
        settings.validate()?;
        for (index, &step) in PASSES.iter().enumerate() {
            let is_last = step == 1;
            let size = coarse_size(settings.size, step)?;
            let coarse = self.render(scene, camera, &RenderSettings { size, ..*settings })?;
            let pass = Pass { index, is_last };
            let go_on = if is_last {
                show(&coarse, pass)
            } else {
                show(&enlarge(&coarse, settings.size), pass)
            };
            if !go_on {
                break;
            }
        }
        Ok(())
    }
}

fn coarse_size(size: ImageSize, step: u32) -> Result<ImageSize, SceneError> {
    ImageSize::new(size.width().div_ceil(step), size.height().div_ceil(step))
}

/// Resamples a frame to another size of the same view: colours bilinear, depths from the nearest pixel.
fn enlarge(frame: &Frame, size: ImageSize) -> Frame {
    let [width, height] = [frame.image.size().width(), frame.image.size().height()].map(|n| n as usize);
    // The camera's scale is per picture height, about the middle.
    let scale = height as f32 / size.height() as f32;
    let place = |pixel: u32, of: u32, from: usize| {
        let at = (pixel as f32 + 0.5 - 0.5 * of as f32) * scale + 0.5 * from as f32 - 0.5;
        let at = at.clamp(0.0, from as f32 - 1.0);
        let low = (at as usize).min(from.saturating_sub(2));
        (low, at - low as f32)
    };
    let columns: Vec<_> = (0..size.width()).map(|x| place(x, size.width(), width)).collect();
    let mut large = Frame::empty(size);
    for y in 0..size.height() {
        let (y0, v) = place(y, size.height(), height);
        let rows = [y0, (y0 + 1).min(height - 1)].map(|y| y * width);
        for (x, &(x0, u)) in columns.iter().enumerate() {
            let x1 = (x0 + 1).min(width - 1);
            let mix = |a: f32, b: f32, c: f32, d: f32| (a + (b - a) * u) * (1.0 - v) + (c + (d - c) * u) * v;
            let [a, b, c, d] = [rows[0] + x0, rows[0] + x1, rows[1] + x0, rows[1] + x1];
            let target = y as usize * size.width() as usize + x;
            let (pixels, depths) = (&frame.image.pixels, &frame.optical_depth);
            large.image.pixels[target] =
                std::array::from_fn(|i| mix(pixels[a][i], pixels[b][i], pixels[c][i], pixels[d][i]));
            large.optical_depth[target] = mix(depths[a], depths[b], depths[c], depths[d]);
            let nearest = if v < 0.5 { [a, b] } else { [c, d] };
            large.depth[target] = frame.depth[nearest[usize::from(u >= 0.5)]];
        }
    }
    large
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_stays_a_ramp_at_its_place() {
        let small = ImageSize::new(16, 8).unwrap();
        let mut frame = Frame::empty(small);
        for (i, pixel) in frame.image.pixels.iter_mut().enumerate() {
            // Position from the middle, in picture heights.
            let x = ((i % 16) as f32 + 0.5 - 8.0) / 8.0;
            *pixel = [x, 0.25, 0.0, 1.0];
        }
        let size = ImageSize::new(62, 31).unwrap();
        let large = enlarge(&frame, size);
        for x in 6..56usize {
            let expected = (x as f32 + 0.5 - 31.0) / 31.0;
            let found = large.image.pixels[15 * 62 + x];
            assert!(
                (found[0] - expected).abs() < 1e-4 && found[3] == 1.0,
                "{x}: {found:?} {expected}"
            );
        }
    }
}
