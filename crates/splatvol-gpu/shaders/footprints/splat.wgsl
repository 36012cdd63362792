// Splat: a footprint on the screen, whatever it is of, as `splatvol_cpu::splats::project` has it.

struct Splat {
    // Pixels.
    centre: vec2<f32>,
    // Exponent to base 2: conic . (dx^2, dx dy, dy^2). In the middle: a logarithm to base 2 of the opacity, or an optical depth.
    conic_xx_xy: vec2<f32>,
    conic_yy: f32,
    peak: f32,
    // Display colour, or linear light.
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

fn first_of(range: u32) -> u32 {
    return range & 0xffffu;
}

fn past_of(range: u32) -> u32 {
    return range >> 16u;
}
