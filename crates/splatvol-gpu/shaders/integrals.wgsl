// Integrals: what rays keep of extinction and emission, the former above a transmittance of one, and pixels of it.

// A ray's integrals become the pixel of a homogeneous slab, with its optical depth, negative, in place of its transmittance:
// that of dense material is no number.
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
    colors[index] = vec4(kept.rgb / extinction * opacity, -optical_depth);
    depths[index] *= opacity / extinction;
}
