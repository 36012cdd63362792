// Planes: a pixel's sums on four planes, with differences across; gradients between them (`splatvol_cpu::sheets::shade`).

// Beyond this, four planes are too few to soften the slope as much as the differences across the ray.
const SOFTEST: f32 = -0.1;
// A pixel on its way through the planes: what it has, and its last four planes.
struct Pixel {
    // Sums on the planes, from the farthest back to the last; the interval is between the second and the third.
    sums: vec4<f32>,
    // Weights of missing samples, likewise.
    missing: vec4<f32>,
    // What a field says of the same planes, two bits each, the last plane's the lowest.
    marks: u32,
    // Differences across on the second, the third and the last plane, per world length.
    across_before: vec2<f32>,
    across: vec2<f32>,
    across_last: vec2<f32>,
    // From the principal point, pixels.
    offset: vec2<f32>,
    ink: Ink,
}

const LAG: u32 = 2u;
// Planes without material are all alike.
const LEAD: u32 = 0u;

fn fresh(offset: vec2<f32>, ink: Ink) -> Pixel {
    return Pixel(vec4(0.0), vec4(0.0), 0u, vec2(0.0), vec2(0.0), vec2(0.0), offset, ink);
}

// Slope per interval, at u between the second and the third of four values.
fn depth_slope(v: vec4<f32>, u: f32, sharpness: f32) -> f32 {
    let rise = v.z - v.y;
    let near = v.x - v.y - v.y + v.z;
    let far = v.y - v.z - v.z + v.w;
    let from_middle = u - 0.5;
    return (far - near) * (from_middle * from_middle * 0.5 - sharpness) + (from_middle * (near + far) * 0.5 + rise);
}

// At the eye, where no pixels are apart, slopes are as sharp as they get.
fn sharpness_of(near: u32) -> f32 {
    let scale = sheets[near].scale;
    let width = select(2.0 / (scale * frame.spacing), 0.0, scale == 0.0);
    return max((1.0 - width * width) / 24.0, SOFTEST);
}

fn gradient_at(pixel: ptr<function, Pixel>, values: vec4<f32>, place: f32, sharpness: f32) -> vec3<f32> {
    let across = mix((*pixel).across_before, (*pixel).across, place);
    let slope = depth_slope(values, place, sharpness);
    return vec3(across, slope / frame.spacing - dot((*pixel).offset * frame.per_pixel, across));
}

// A pixel's values on four planes.
struct Around {
    values: vec4<f32>,
    // Values whose slope along the ray light uses: beside missing samples those of all coefficients, the missing ones zero.
    whole: vec4<f32>,
    // On the middle planes.
    coverage: vec2<f32>,
    // Whether nothing was splatted onto the middle planes.
    is_untouched: bool,
}
