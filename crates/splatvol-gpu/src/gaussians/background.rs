//! Background that splats are composited over.

use splatvol_scene::transfer_function::srgb_from_linear;

/// Straight display colour and opacity of a background in linear light, straight too.
pub(super) fn displayed(linear: [f32; 4]) -> [f32; 4] {
    let [r, g, b, alpha] = linear.map(|value| splatvol_core::cloud_view::sane(f64::from(value)));
    let [r, g, b] = [r, g, b].map(srgb_from_linear);
    [r, g, b, alpha.min(1.0)].map(|value| value as f32)
}
