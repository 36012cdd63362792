//! The mean of frames: the exposure of an open shutter while the camera or the scene moves.
//!
//! A pixel's colour is `C = 1/n sum C_i`, its alpha likewise (linear light, premultiplied), so energy is kept and
//! occlusion is right at every instant: this is motion blur by sub-frames, the reference for analytic ones. The depth
//! is the mean weighted by the alpha that light comes from, the transmittance `exp(-tau) = 1/n sum exp(-tau_i)`.
//!
//! Sums are f64 in the order of the frames, so the result does not depend on threads, and the mean of equal pictures
//! is that picture.

use crate::{Frame, ImageSize, SceneError};

/// The sum of a pixel.
#[derive(Debug, Clone, Copy)]
struct Sum {
    color: [f64; 4],
    /// Depth times alpha.
    depth: f64,
    /// Transmittances over `exp(-least)`: optical depths of thousands leave no transmittance that f64 could hold.
    transmittance: f64,
    /// Least optical depth so far.
    least: f64,
}

impl Sum {
    const EMPTY: Self = Self {
        color: [0.0; 4],
        depth: 0.0,
        transmittance: 0.0,
        least: f64::INFINITY,
    };

    fn add(&mut self, pixel: [f32; 4], depth: f32, optical_depth: f32) {
        for (sum, value) in self.color.iter_mut().zip(pixel) {
            *sum += f64::from(value);
        }
        // Infinite where nothing is seen.
        if depth.is_finite() {
            self.depth += f64::from(depth) * f64::from(pixel[3]);
        }
        let optical_depth = f64::from(optical_depth);
        if optical_depth < self.least {
            self.transmittance = self.transmittance * libm::exp(optical_depth - self.least) + 1.0;
            self.least = optical_depth;
        } else if optical_depth == self.least {
            self.transmittance += 1.0;
        } else {
            self.transmittance += libm::exp(self.least - optical_depth);
        }
    }
}

/// Frames added up.
#[derive(Debug, Clone)]
pub struct Exposure {
    size: ImageSize,
    sums: Vec<Sum>,
    frames: u32,
}

impl Exposure {
    /// An exposure of nothing yet.
    pub fn new(size: ImageSize) -> Self {
        Self {
            size,
            sums: vec![Sum::EMPTY; size.pixel_count()],
            frames: 0,
        }
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// A frame of another size.
    pub fn add(&mut self, frame: &Frame) -> Result<(), SceneError> {
        if frame.image.size() != self.size {
            return Err(SceneError::invalid(
                "frame size",
                frame.image.size(),
                "the size of the exposure",
            ));
        }
        let planes = frame.depth.iter().zip(&frame.optical_depth);
        for ((sum, &pixel), (&depth, &optical_depth)) in
            self.sums.iter_mut().zip(&frame.image.pixels).zip(planes)
        {
            sum.add(pixel, depth, optical_depth);
        }
        self.frames += 1;
        Ok(())
    }

    /// Puts the mean of the frames added since the last time into `frame`, and begins anew.
    ///
    /// # Errors
    /// No frame was added.
    pub fn take(&mut self, frame: &mut Frame) -> Result<(), SceneError> {
        if self.frames == 0 {
            return Err(SceneError::invalid("frames of an exposure", 0, "at least 1"));
        }
        if frame.image.size() != self.size {
            *frame = Frame::empty(self.size);
        }
        let count = f64::from(self.frames);
        let pixels = &mut frame.image.pixels;
        let planes = frame.depth.iter_mut().zip(&mut frame.optical_depth);
        for ((sum, pixel), (depth, optical_depth)) in self.sums.iter_mut().zip(pixels).zip(planes) {
            *pixel = sum.color.map(|value| (value / count) as f32);
            *depth = if sum.color[3] > 0.0 {
                (sum.depth / sum.color[3]) as f32
            } else {
                f32::INFINITY
            };
            *optical_depth = (sum.least - libm::log(sum.transmittance / count)) as f32;
            *sum = Sum::EMPTY;
        }
        self.frames = 0;
        Ok(())
    }

    /// The mean of some frames.
    ///
    /// # Errors
    /// No frames, or frames of different sizes.
    pub fn mean<'a>(frames: impl IntoIterator<Item = &'a Frame>) -> Result<Frame, SceneError> {
        let mut frames = frames.into_iter().peekable();
        let size = frames
            .peek()
            .map_or_else(ImageSize::default, |frame| frame.image.size());
        let (mut exposure, mut mean) = (Self::new(size), Frame::empty(size));
        for frame in frames {
            exposure.add(frame)?;
        }
        exposure.take(&mut mean)?;
        Ok(mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Image;

    fn frame(pixel: [f32; 4], depth: f32, optical_depth: f32) -> Frame {
        let size = ImageSize::new(1, 1).unwrap();
        Frame {
            image: Image::filled(size, pixel),
            depth: vec![depth],
            optical_depth: vec![optical_depth],
        }
    }

    #[test]
    fn equal_frames_come_back_bit_for_bit() {
        let one = frame([0.1, 0.2, 0.3, 0.7], 12.3, 1.234_567);
        for count in [1, 3, 16, 255] {
            let mean = Exposure::mean(std::iter::repeat_n(&one, count)).unwrap();
            assert_eq!(mean.image, one.image, "{count}");
            assert_eq!(mean.depth, one.depth, "{count}");
            assert_eq!(mean.optical_depth, one.optical_depth, "{count}");
        }
        let nothing = Frame::empty(one.image.size());
        assert_eq!(Exposure::mean([&nothing, &nothing]).unwrap(), nothing);
    }

    #[test]
    fn light_is_averaged_and_depth_is_where_it_comes_from() {
        let near = frame([0.5, 0.0, 0.0, 0.5], 10.0, 2.0_f32.ln());
        let far = frame([0.0, 0.9, 0.0, 1.0], 40.0, 30.0);
        let mean = Exposure::mean([&near, &far, &Frame::empty(near.image.size())]).unwrap();
        let [r, g, b, a] = mean.image.pixel(0, 0).map(f64::from);
        assert!((r - 0.5 / 3.0).abs() < 1e-7 && (g - 0.3).abs() < 1e-7 && b == 0.0);
        assert!((a - 0.5).abs() < 1e-7);
        assert!((f64::from(mean.depth[0]) - (0.5 * 10.0 + 40.0) / 1.5).abs() < 1e-5);
        let transmittance = (0.5 + (-30.0_f64).exp() + 1.0) / 3.0;
        assert!((f64::from(mean.optical_depth[0]) + transmittance.ln()).abs() < 1e-6);
    }

    #[test]
    fn optical_depths_beyond_the_exponential_stay_finite() {
        let deep = |tau| frame([0.0, 0.0, 0.0, 1.0], 1.0, tau);
        for frames in [[deep(2000.0), deep(3000.0)], [deep(3000.0), deep(2000.0)]] {
            let mean = Exposure::mean(&frames).unwrap();
            assert!((mean.optical_depth[0] - (2000.0 + 2.0_f32.ln())).abs() < 1e-3);
        }
    }

    #[test]
    fn nothing_and_other_sizes_are_refused() {
        let size = |side| ImageSize::new(side, side).unwrap();
        let mut exposure = Exposure::new(size(2));
        assert!(exposure.take(&mut Frame::empty(size(2))).is_err());
        let error = exposure.add(&Frame::empty(size(3))).unwrap_err();
        assert!(error.to_string().starts_with("frame size"), "{error}");
    }
}
