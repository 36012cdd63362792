//! Background of splats, and display colours over it to linear light.

use rayon::prelude::*;
use splatvol_scene::Frame;
use splatvol_scene::transfer_function::{linear_from_srgb, srgb_from_linear};

/// What splats are composited over: display colour, straight, and opacity.
pub(super) struct Background {
    color: [f64; 3],
    alpha: f64,
}

impl Background {
    pub(super) fn new(linear: [f32; 4]) -> Self {
        let [r, g, b, alpha] = linear.map(|value| splatvol_core::cloud_view::sane(f64::from(value)));
        Self {
            color: [r, g, b].map(srgb_from_linear),
            alpha: alpha.min(1.0),
        }
    }

    /// Premultiplied display colours with transmittances, and sums of depths, to linear light, as
    /// `splatvol_cpu::splats::blend::Published`.
    pub(super) fn resolve(&self, frame: &mut Frame, (colors, depth_sums): (&[[f32; 4]], &[f32])) {
        let targets = frame
            .image
            .pixels
            .par_iter_mut()
            .zip(frame.depth.par_iter_mut().zip(&mut frame.optical_depth));
        let found = colors.par_iter().zip(depth_sums);
        targets.zip(found).for_each(
            |((pixel, (depth, optical_depth)), (&[r, g, b, through], &depth_sum))| {
                let covered = 1.0 - f64::from(through);
                let behind = f64::from(through) * self.alpha;
                let alpha = covered + behind;
                let channel = |own: f32, under: f64| {
                    let encoded = (f64::from(own) + behind * under) / alpha;
                    (linear_from_srgb(encoded) * alpha) as f32
                };
                let [under_r, under_g, under_b] = self.color;
                *pixel = match alpha > 0.0 {
                    true => [
                        channel(r, under_r),
                        channel(g, under_g),
                        channel(b, under_b),
                        alpha as f32,
                    ],
                    false => [0.0; 4],
                };
                (*depth, *optical_depth) = match covered > 0.0 {
                    true => (
                        (f64::from(depth_sum) / covered) as f32,
                        -libm::log(f64::from(through)) as f32,
                    ),
                    false => (f32::INFINITY, 0.0),
                };
            },
        );
    }
}
