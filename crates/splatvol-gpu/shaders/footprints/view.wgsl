// View: a cloud before a camera, and places in it; `splatvol_core::cloud_view` and `splatvol_cpu::splats::project`.

struct View {
    // The eye, local, as a rounded value and the remainder.
    eye: vec3<f32>,
    near: f32,
    eye_rest: vec3<f32>,
    scale: f32,
    // Rows of the linear part of camera from local.
    to_x: vec3<f32>,
    low_pass: f32,
    to_y: vec3<f32>,
    is_perspective: u32,
    to_z: vec3<f32>,
    degree: u32,
    // The view direction, local, that all pixels share where rays are parallel.
    direction: vec3<f32>,
    is_antialiased: u32,
    centre: vec2<f32>,
    tangent_limit: vec2<f32>,
    reference_tiles: vec2<f32>,
    // Gaussians of this page, and how many are before them.
    count: u32,
    before: u32,
    // Bits of the smallest depth that there may be, and the key of what is not seen: larger than any other.
    first_key: u32,
    unseen_key: u32,
    unused: vec2<u32>,
}

@group(0) @binding(0) var<uniform> view: View;

const LARGEST: f32 = 3.4028234e38;
const SMALLEST: f32 = 1.1754944e-38;
// Pixels by which the ellipse may be larger than computed.
const ROUNDING: f32 = 0.01;

// A place as the camera sees it.
struct Seen {
    // From the eye, local; camera depth.
    offset: vec3<f32>,
    depth: f32,
    // Pixels; per world length.
    centre: vec2<f32>,
    scale: f32,
    // Slopes of the ray, within the limits.
    tangent: vec2<f32>,
    // Rows of J M, from local to pixels.
    row_x: vec3<f32>,
    row_y: vec3<f32>,
}

fn seen_at(place: vec3<f32>) -> Seen {
    let offset = place - view.eye - view.eye_rest;
    let depth = dot(view.to_z, offset);
    let inverse = select(1.0, 1.0 / max(depth, SMALLEST), view.is_perspective != 0u);
    let scale = inverse * view.scale;
    let across = vec2(dot(view.to_x, offset), dot(view.to_y, offset));
    let tangent = clamp(across * inverse, -view.tangent_limit, view.tangent_limit);
    return Seen(
        offset,
        depth,
        across * scale + view.centre,
        scale,
        tangent,
        (view.to_x - tangent.x * view.to_z) * scale,
        (view.to_y - tangent.y * view.to_z) * scale,
    );
}

// Reference tiles that both the square around a splat and its ellipse meet, along one axis.
fn range_of(place: f32, half_square: f32, reach: f32, past: f32) -> vec2<f32> {
    let edge = f32(REFERENCE_TILE);
    let low = floor((place - min(half_square, reach + ROUNDING)) / edge);
    let square = (place + half_square + (edge - 1.0)) / edge;
    let own = (place + reach + (edge + ROUNDING)) / edge;
    return clamp(vec2(low, floor(min(square, own))), vec2(0.0), vec2(past));
}
