// Rays: one value of each ray through a mesh, of its field on four planes; `splatvol_cpu::sheets::cloud::values`.

const LAG: u32 = 2u;
// Planes without material are all alike.
const LEAD: u32 = 0u;

// A pixel on its way through the planes.
struct Pixel {
    // Means and weights on the last four planes.
    means: vec4<f32>,
    left: vec4<f32>,
    // From the principal point, pixels.
    offset: vec2<f32>,
    ink: Ink,
}

fn fresh(offset: vec2<f32>, ink: Ink) -> Pixel {
    return Pixel(vec4(0.0), vec4(0.0), offset, ink);
}

// Takes a plane's value at a pixel, and its weight, at most one.
fn enter(pixel: ptr<function, Pixel>, sheet: u32, point: u32, is_filled: bool) {
    var sums = vec2(0.0);
    if is_filled {
        sums = sums_at_point(sheet, point_of((*pixel).offset));
    }
    (*pixel).means = vec4((*pixel).means.yzw, value_of(sums));
    (*pixel).left = vec4((*pixel).left.yzw, min(sums.x, 1.0));
}

// Keeps what the ray needs of the interval between planes `near` and `near + 1`: coverage is the weight.
fn shade(pixel: ptr<function, Pixel>, near: u32) {
    let left = (*pixel).left;
    if (*pixel).ink.transmittance < 0.0 || (left.y <= 0.0 && left.z <= 0.0) {
        return;
    }
    let values = continued((*pixel).means, left);
    let middle = clamp((left.y + left.z) * (9.0 / 16.0) - (left.x + left.w) * (1.0 / 16.0), 0.0, 1.0);
    let coverage = parabola_through(left.y, middle, left.z);
    let slopes = 0.5 * (values.zw - values.xy);
    (*pixel).ink = kept((*pixel).ink, cubic_through(values.yz, slopes), coverage, sheets[near].depth);
}
