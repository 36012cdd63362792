// Composite: a workgroup takes a tile of the published renderer through its list, front to back; a pixel per invocation.
// Splats are brought to workgroup memory, those that miss the tile left out.

struct Picture {
    size: vec2<u32>,
    // Tiles with lists along x.
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
const ENDED: u32 = 0xffffffffu;

var<workgroup> batch: array<Splat, BATCH>;
// Of each of these: row of its centre, and rows around it in which it is not below what is drawn.
var<workgroup> rows: array<vec2<f32>, BATCH>;
// A bit for each splat of a batch, set for those that reach the tile.
var<workgroup> kept: array<atomic<u32>, WORDS>;
var<workgroup> open_pixels: atomic<u32>;
// How many splats are kept; ENDED if no pixel is open.
var<workgroup> kept_count: u32;

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

fn meets(range: u32, tile: u32) -> bool {
    return tile >= first_of(range) && tile < past_of(range);
}

// Rows from a splat's centre beyond which its exponent is below -LOG2_255 in every column, rounded up. Along its ridge the
// exponent is `peak + (yy - xy^2 / 4 xx) dy^2`.
fn rows_of(splat: Splat) -> f32 {
    let fall = splat.conic_xx_xy.y * splat.conic_xx_xy.y / (4.0 * splat.conic_xx_xy.x) - splat.conic_yy;
    let squared = (splat.peak + LOG2_255) / fall;
    // Neither a flat ridge nor one that rounding turned upwards ends.
    return select(3e38, sqrt(max(squared, 0.0)) * 1.001 + 0.01, fall > 0.0);
}

// Splats of the batch that are kept and come before a lane's.
fn kept_before(lane: u32) -> u32 {
    var count = 0u;
    for (var word = 0u; word < lane / 32u; word++) {
        count += countOneBits(atomicLoad(&kept[word]));
    }
    if lane % 32u != 0u {
        count += countOneBits(atomicLoad(&kept[lane / 32u]) & ((1u << (lane % 32u)) - 1u));
    }
    return count;
}

@compute @workgroup_size(16, 16)
fn composite(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let list = ranges[(tile.y / LIST_TILE) * picture.columns + tile.x / LIST_TILE];
    let at = tile.xy * REFERENCE_TILE + local.xy;
    let is_inside = all(at < picture.size);
    let pixel = vec2<f32>(at) + 0.5;
    var color = vec3(0.0);
    var through = 1.0;
    var depth_sum = 0.0;
    var is_open = is_inside;
    for (var first = list.x; first < list.y; first += BATCH) {
        if lane < WORDS {
            atomicStore(&kept[lane], 0u);
        }
        if lane == 0u {
            atomicStore(&open_pixels, 0u);
        }
        workgroupBarrier();
        if is_open {
            atomicOr(&open_pixels, 1u);
        }
        var entry = 0u;
        var is_kept = false;
        if first + lane < list.y {
            entry = entries[first + lane];
            is_kept = meets(splats[entry].columns, tile.x) && meets(splats[entry].rows, tile.y);
        }
        if is_kept {
            atomicOr(&kept[lane / 32u], 1u << (lane % 32u));
        }
        workgroupBarrier();
        if is_kept {
            let place = kept_before(lane);
            batch[place] = splats[entry];
            rows[place] = vec2(splats[entry].centre.y, rows_of(splats[entry]));
        }
        if lane == 0u {
            kept_count = select(ENDED, kept_before(BATCH), atomicLoad(&open_pixels) != 0u);
        }
        let count = workgroupUniformLoad(&kept_count);
        if count == ENDED {
            break;
        }
        if is_open {
            for (var i = 0u; i < count; i++) {
                if abs(pixel.y - rows[i].x) > rows[i].y {
                    continue;
                }
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
