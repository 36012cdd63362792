// X-ray: planes of extinction and emission are added up along rays; `splatvol_cpu::sheets::integral` has the same integrals
// voxel by voxel.

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
