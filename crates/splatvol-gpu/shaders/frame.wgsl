// View-dependent and sample-independent data of a frame, and its planes. The layout is `frame::FrameData`'s.

struct Frame {
    // Pixels, and tiles of TILE_WIDTH by TILE_HEIGHT.
    size: vec2<u32>,
    tiles: vec2<u32>,
    // Rays: `(x + 1/2 - principal) * per_pixel` per depth; where they are parallel, pixels of `plane_per_pixel`.
    principal: vec2<f32>,
    per_pixel: f32,
    plane_per_pixel: f32,
    // Lattice points, and planes.
    dims: vec3<i32>,
    planes: u32,
    // Pages, and 32-bit words of a tile's planes.
    pages: vec3<i32>,
    words: u32,
    // Lattice points beyond the samples, and samples.
    margin: vec3<f32>,
    sigma: f32,
    samples: vec3<f32>,
    radius: f32,
    // Slots of the atlas along x and y; one over its size in texels.
    slots: vec2<u32>,
    per_texel: vec2<f32>,
    // Distance of planes, world length; background, normalised; transmittance of a finished pixel.
    spacing: f32,
    background: f32,
    termination: f32,
    densest: f32,
    hull: vec2<f32>,
    shows_background: u32,
    lit: u32,
    towards_light: vec3<f32>,
    ambient: f32,
    half_way: vec3<f32>,
    diffuse: f32,
    specular: f32,
    power: f32,
    floor_squared: f32,
    // Mean distance of voxels, world length: gradients per world length to gradients per voxel.
    voxel: f32,
    // Intervals of this dispatch.
    from_interval: u32,
    to_interval: u32,
    // Camera depth of plane 0 over the spacing.
    first_plane: f32,
    // World length over which the opacity of a value that is shown by itself is taken.
    unit_distance: f32,
    // Camera space from the lattice, by columns.
    camera_from_lattice: mat4x4<f32>,
    // Clips, isosurfaces, and the place of the first of these in `effects`.
    bodies: u32,
    isosurfaces: u32,
    first_isosurface: u32,
    // Layers of the atlas that a channel has.
    channel_layers: u32,
    // First row of tiles of a part of the picture; where intervals of layers are gathered, what is added to their numbers,
    // the part's pixels, and its intervals.
    first_tile_row: u32,
    gather_offset: i32,
    band_pixels: u32,
    gathered_intervals: u32,
    // Gradients: per world length in camera space, from per voxel.
    gradient_from_lattice: mat3x3<f32>,
    // Of the kernel: `log2(e) / sigma^2`, and its values at distances of 1, 2 and 3 voxels.
    falls: vec4<f32>,
    // Middle of the lattice; distances from it within which all weights lie on the lattice, and coverage is one.
    middle: vec3<f32>,
    // Share of the extinction that is shown in interval 0, where two levels lie side by side, and its change to the next.
    share: f32,
    interior: vec3<f32>,
    share_step: f32,
}

struct Sheet {
    // Lattice position of the principal point: whole voxels, and the rest.
    cell: vec3<i32>,
    depth: f32,
    rest: vec3<f32>,
    // Pixels per world length; 0 at the eye and behind it.
    scale: f32,
    // Lattice steps to the next pixel.
    step_x: vec3<f32>,
    // Standard deviation of the low-pass, pixels.
    low_pass: f32,
    step_y: vec3<f32>,
    // Points of its quadrature along x and along y.
    low_pass_points: u32,
    // Weights of the pixels at distances of 0, 1, 2 and 3 that do the same; zero where the kernel is too narrow for that.
    low_pass_pixels: vec4<f32>,
}

const TILE_WIDTH: u32 = 16u;
const TILE_HEIGHT: u32 = 16u;

// Pages of 16^3 cells. Lattice coordinates are counted from four cells before the first, so that taps before it are in
// a page.
const PAGE: i32 = 16;
const PAGE_BITS: u32 = 4u;
const BEFORE: i32 = 4;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> sheets: array<Sheet>;
// Slot of a page: in bits from the lowest on its column, its row and its stack, then a bit for each octant of 8^3 cells whose
// sums a needed voxel is in; zero where the page needs none.
const SLOT_BITS: u32 = 9u;
const SLOT_MASK: u32 = 0x1ffu;
const STACK_MASK: u32 = 0x1fu;
const OCTANTS_FROM: u32 = 23u;
@group(0) @binding(2) var<storage, read> pages: array<u32>;

// A tile's points, with those of the neighbours of its pixels.
const PITCH: u32 = TILE_WIDTH + 2u;
const POINTS: u32 = PITCH * (TILE_HEIGHT + 2u);

// What a pixel has so far.
struct Ink {
    color: vec3<f32>,
    transmittance: f32,
    depth_sum: f32,
}
