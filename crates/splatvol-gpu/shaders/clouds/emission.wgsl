// Emission: intervals between planes of extinction and emission of a cloud are composited;
// `splatvol_cpu::sheets::compose::composite_planes` with the means of lines.

// Planes from an interval's nearer one to the one with which it is shaded.
const LAG: u32 = 1u;
// Planes without material are all alike.
const LEAD: u32 = 0u;

// A pixel on its way through the planes.
struct Pixel {
    // On the last two planes.
    near: vec4<f32>,
    far: vec4<f32>,
    // From the principal point, pixels.
    offset: vec2<f32>,
    ink: Ink,
}

fn fresh(offset: vec2<f32>, ink: Ink) -> Pixel {
    return Pixel(vec4(0.0), vec4(0.0), offset, ink);
}

// Takes a plane's sums at a pixel.
fn enter(pixel: ptr<function, Pixel>, sheet: u32, point: u32, is_filled: bool) {
    (*pixel).near = (*pixel).far;
    (*pixel).far = vec4(0.0);
    if is_filled {
        (*pixel).far = sums_at_point(sheet, point_of((*pixel).offset));
    }
}

// Composites the interval between planes `near` and `near + 1`.
fn shade(pixel: ptr<function, Pixel>, near: u32) {
    let both = (*pixel).near + (*pixel).far;
    if (*pixel).ink.transmittance < frame.termination || both.x <= 0.0 {
        return;
    }
    let mean = 0.5 * both;
    let optical_depth = mean.x * ray_length((*pixel).offset) * frame.spacing;
    let through = exp2(max(-LOG2_E * optical_depth, LEAST_EXPONENT));
    let opacity = opacity_of(optical_depth, through);
    let share_of_far = (*pixel).far.x / both.x;
    let before = (*pixel).ink.transmittance;
    (*pixel).ink.color += before * opacity / mean.x * mean.yzw;
    (*pixel).ink.depth_sum += before * opacity * ((share_of_far * 0.5 + 0.25) * frame.spacing + sheets[near].depth);
    (*pixel).ink.transmittance = before * through;
}
