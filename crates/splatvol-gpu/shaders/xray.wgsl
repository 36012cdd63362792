// X-ray: planes of extinction and emission are added up along rays; `splatvol_cpu::sheets::integral` has the same integrals
// voxel by voxel.

const LAG: u32 = 2u;
// Planes without material are all alike.
const LEAD: u32 = 0u;

// Adds the interval between planes `near` and `near + 1`. Kernels' sums over planes are their integrals, to rounding; at the
// eye, where they begin, the rule for a line is. Extinction is kept above a transmittance of one.
fn shade(pixel: ptr<function, Pixel>, near: u32) {
    let mean = 0.5 * ((*pixel).near + (*pixel).far) * frame.spacing;
    if (*pixel).ink.transmittance < 0.0 || mean.x <= 0.0 {
        return;
    }
    let place = ((*pixel).near.x / 6.0 + (*pixel).far.x / 3.0) * frame.spacing * frame.spacing;
    (*pixel).ink.color += mean.yzw;
    (*pixel).ink.transmittance += mean.x;
    (*pixel).ink.depth_sum += mean.x * sheets[near].depth + place;
}

// A ray's integrals become the pixel of a homogeneous slab.
fn settle_at(at: vec2<u32>) {
    let index = at.y * frame.size.x + at.x;
    let kept = colors[index];
    let extinction = kept.a - 1.0;
    if extinction <= 0.0 {
        colors[index] = vec4(0.0, 0.0, 0.0, 1.0);
        depths[index] = 0.0;
        return;
    }
    let optical_depth = extinction * ray_length(vec2<f32>(at) + 0.5 - frame.principal);
    let through = exp2(max(-LOG2_E * optical_depth, LEAST_EXPONENT));
    let opacity = opacity_of(optical_depth, through);
    colors[index] = vec4(kept.rgb / extinction * opacity, through);
    depths[index] *= opacity / extinction;
}
