// Splat: a kernel of a cloud in camera space, ready for the planes (`splatvol_core::cloud_planes` has the formulas).

struct Splat {
    centre: vec3<f32>,
    // In depth, world length.
    reach: f32,
    // Drift of its centre on planes per depth.
    slope: vec2<f32>,
    // Half widths of the box around its section, world length.
    half_extent: vec2<f32>,
    // Negative exponents to base 2, per world length squared: xx, xy (twice), yy.
    exponent: vec3<f32>,
    // Negative exponent to base 2 in depth, per world length squared.
    depth_exponent: f32,
    // Extinction and emission, or weight and value times that, at its centre.
    payload: vec4<f32>,
}

// Planes of a group: they are made together.
const GROUP: u32 = 8u;
// Pixels along an edge of a tile that has lists, one per group; tiles begin a pixel before the picture, since differences
// across need the neighbours of its pixels.
const EDGE: u32 = 16u;
