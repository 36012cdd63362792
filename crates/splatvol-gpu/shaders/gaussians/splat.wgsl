// A Gaussian on the screen, as `splatvol_cpu::splats::project` has it.

struct Splat {
    // Pixels.
    centre: vec2<f32>,
    // Exponent to base 2: conic . (dx^2, dx dy, dy^2) + peak.
    conic_xx_xy: vec2<f32>,
    conic_yy: f32,
    peak: f32,
    // Display colour.
    red_green: vec2<f32>,
    blue: f32,
    // Camera depth.
    depth: f32,
    // First and past-the-last column, and row, of the published renderer's tiles, in 16 bits each.
    columns: u32,
    rows: u32,
}

// Pixels along an edge of the published renderer's tiles, each of which has a list.
override REFERENCE_TILE: u32 = 16u;
// log2(255).
override LOG2_255: f32;

fn first_of(range: u32) -> u32 {
    return range & 0xffffu;
}

fn past_of(range: u32) -> u32 {
    return range >> 16u;
}
