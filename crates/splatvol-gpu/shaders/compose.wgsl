// Compose: intervals between planes of extinction and emission are composited; `splatvol_cpu::sheets::compose`.

// Composites the interval between planes `near` and `near + 1`: the mean of the cubics through all four planes.
fn shade(pixel: ptr<function, Pixel>, near: u32) {
    let inner = (*pixel).near + (*pixel).far;
    // Before the eye there is no plane.
    let outer = (*pixel).after + select((*pixel).before, inner - (*pixel).after, is_eye(near));
    let mean = max(inner * (13.0 / 24.0) - outer * (1.0 / 24.0), vec4(0.0));
    if (*pixel).ink.transmittance < frame.termination || mean.x <= 0.0 {
        return;
    }
    let optical_depth = mean.x * ray_length((*pixel).offset) * frame.spacing;
    let through = exp2(max(-LOG2_E * optical_depth, LEAST_EXPONENT));
    let opacity = opacity_of(optical_depth, through);
    let share_of_far = select(0.5, (*pixel).far.x / inner.x, inner.x > 0.0);
    let before = (*pixel).ink.transmittance;
    (*pixel).ink.color += before * opacity / mean.x * mean.yzw;
    (*pixel).ink.depth_sum += before * opacity * ((share_of_far * 0.5 + 0.25) * frame.spacing + sheets[near].depth);
    (*pixel).ink.transmittance = before * through;
}
