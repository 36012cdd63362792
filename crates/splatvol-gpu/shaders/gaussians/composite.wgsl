// Composite: a workgroup takes a tile of the published renderer through its list, front to back; a pixel per invocation.
// Splats are brought to workgroup memory. Each part of the tile has a bit for those that may show there, so that its pixels
// see no other: most splats are smaller than a tile.

struct Picture {
    size: vec2<u32>,
    // Tiles along x.
    columns: u32,
    unused: u32,
    // Background: straight display colour and opacity.
    background: vec4<f32>,
}

@group(0) @binding(0) var<uniform> picture: Picture;
@group(0) @binding(1) var<storage, read> splats: array<Splat>;
@group(0) @binding(2) var<storage, read> entries: array<u32>;
@group(0) @binding(3) var<storage, read> ranges: array<vec2<u32>>;
// Linear premultiplied colour, with the background's part, and transmittance; the sum of depths, weighted by opacity.
@group(0) @binding(4) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> depths: array<f32>;

override MOST_ALPHA: f32;
override LEAST_TRANSMITTANCE: f32;

const BATCH: u32 = 256u;
const WORDS: u32 = BATCH / 32u;
// Parts of a tile, 8 by 4 pixels: as many as devices run together at least.
const PART: vec2<u32> = vec2(8u, 4u);
const PARTS: u32 = 8u;

var<workgroup> batch: array<Splat, BATCH>;
// For each part of the tile, a bit for each splat of a batch that may show there.
var<workgroup> marks: array<atomic<u32>, PARTS * WORDS>;
var<workgroup> open_pixels: atomic<u32>;
var<workgroup> is_ended: u32;

// 2^x, for x from -126 to 126: `splatvol_core::exponential`, the short polynomial.
fn exp2_quick(x: f32) -> f32 {
    let n = round(x);
    let r = x - n;
    let p = (((9.582853e-3 * r + 5.5906425e-2) * r + 2.402410e-1) * r + 6.931242e-1) * r + 1.0;
    return p * bitcast<f32>(u32(i32(n) + 127) << 23u);
}

fn linear_from_srgb(encoded: vec3<f32>) -> vec3<f32> {
    let curve = pow((max(encoded, vec3(0.0)) + 0.055) / 1.055, vec3(2.4));
    return select(curve, encoded / 12.92, encoded <= vec3(0.04045));
}

// Linear light of display colours over the background, premultiplied; as `splatvol_cpu::splats::blend::Published`.
fn shown(color: vec3<f32>, through: f32) -> vec3<f32> {
    let behind = through * picture.background.a;
    let alpha = 1.0 - through + behind;
    if alpha <= 0.0 {
        return vec3(0.0);
    }
    return linear_from_srgb((color + behind * picture.background.rgb) / alpha) * alpha;
}

// Distances along x and y from a splat's centre beyond which its exponent is below -LOG2_255, rounded up. Along its ridge
// the exponent is `peak + (yy - xy^2 / 4 xx) dy^2`.
fn reach_of(splat: Splat) -> vec2<f32> {
    let conic = vec2(splat.conic_xx_xy.x, splat.conic_yy);
    let mixed = 0.25 * splat.conic_xx_xy.y * splat.conic_xx_xy.y;
    let fall = mixed / conic.yx - conic;
    let squared = (splat.peak + LOG2_255) / fall;
    return select(vec2(3e38), sqrt(max(squared, vec2(0.0))) * 1.001 + 0.01, fall > vec2(0.0));
}

// The place of a part in its tile, pixels.
fn corner_of(part: u32) -> vec2<u32> {
    return vec2(part % 2u, part / 2u) * PART;
}

// Brings a splat to a place of the batch, and marks the parts of the tile in which it may show.
fn bring(entry: u32, place: u32, tile_corner: vec2<u32>) {
    let splat = splats[entry];
    batch[place] = splat;
    let reach = reach_of(splat);
    // In pixels from the middle of the tile's first one.
    let centre = splat.centre - vec2<f32>(tile_corner) - 0.5;
    for (var part = 0u; part < PARTS; part++) {
        let first = vec2<f32>(corner_of(part));
        let last = first + vec2<f32>(PART - 1u);
        if all(centre - reach <= last) && all(centre + reach >= first) {
            atomicOr(&marks[part * WORDS + place / 32u], 1u << (place % 32u));
        }
    }
}

@compute @workgroup_size(256)
fn composite(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let list = ranges[tile.y * picture.columns + tile.x];
    let part = lane / (PART.x * PART.y);
    let within = lane % (PART.x * PART.y);
    let corner = tile.xy * REFERENCE_TILE;
    let at = corner + corner_of(part) + vec2(within % PART.x, within / PART.x);
    let is_inside = all(at < picture.size);
    let pixel = vec2<f32>(at) + 0.5;
    var color = vec3(0.0);
    var through = 1.0;
    var depth_sum = 0.0;
    var is_open = is_inside;
    for (var first = list.x; first < list.y; first += BATCH) {
        if lane < PARTS * WORDS {
            atomicStore(&marks[lane], 0u);
        }
        if lane == 0u {
            atomicStore(&open_pixels, 0u);
        }
        workgroupBarrier();
        if is_open {
            atomicOr(&open_pixels, 1u);
        }
        if first + lane < list.y {
            bring(entries[first + lane], lane, corner);
        }
        workgroupBarrier();
        if lane == 0u {
            is_ended = u32(atomicLoad(&open_pixels) == 0u);
        }
        if workgroupUniformLoad(&is_ended) != 0u {
            break;
        }
        for (var word = 0u; word < WORDS && is_open; word++) {
            var bits = atomicLoad(&marks[part * WORDS + word]);
            while bits != 0u {
                let i = word * 32u + firstTrailingBit(bits);
                bits &= bits - 1u;
                let d = pixel - batch[i].centre;
                let exponent = (d.x * batch[i].conic_xx_xy.x + d.y * batch[i].conic_xx_xy.y) * d.x
                    + (d.y * d.y * batch[i].conic_yy + batch[i].peak);
                if !(exponent >= -LOG2_255) {
                    continue;
                }
                let alpha = min(exp2_quick(exponent), MOST_ALPHA);
                let next = through * (1.0 - alpha);
                if next < LEAST_TRANSMITTANCE {
                    is_open = false;
                    break;
                }
                let share = through * alpha;
                color += share * vec3(batch[i].red_green, batch[i].blue);
                depth_sum += share * batch[i].depth;
                through = next;
            }
        }
        workgroupBarrier();
    }
    if is_inside {
        let index = at.y * picture.size.x + at.x;
        colors[index] = vec4(shown(color, through), through);
        depths[index] = depth_sum;
    }
}
