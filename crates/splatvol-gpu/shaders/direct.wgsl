// Direct: intervals are composited as they are shaded.

// The sum of depths, weighted by opacity.
@group(0) @binding(8) var<storage, read_write> depths: array<f32>;

// What a pixel has before these intervals.
fn ink_at(index: u32) -> Ink {
    let so_far = colors[index];
    return Ink(so_far.rgb, so_far.a, depths[index]);
}

fn show(pixel: ptr<function, Pixel>, near: u32) {
    shade(pixel, near);
}

fn finish(index: u32, ink: Ink) {
    colors[index] = vec4(ink.color, ink.transmittance);
    depths[index] = ink.depth_sum;
}
