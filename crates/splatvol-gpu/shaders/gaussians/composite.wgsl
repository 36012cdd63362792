// Composite: a workgroup takes a tile of the published renderer through its list, front to back; a pixel per invocation.
// Splats are brought to workgroup memory, those that miss the tile left out.

struct Picture {
    size: vec2<u32>,
    // Tiles with lists along x.
    columns: u32,
    unused: u32,
}

@group(0) @binding(0) var<uniform> picture: Picture;
@group(0) @binding(1) var<storage, read> splats: array<Splat>;
@group(0) @binding(2) var<storage, read> entries: array<u32>;
@group(0) @binding(3) var<storage, read> ranges: array<vec2<u32>>;
// Display colour, premultiplied, and transmittance; the sum of depths, weighted by opacity.
@group(0) @binding(4) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> depths: array<f32>;

override MOST_ALPHA: f32;
override LEAST_TRANSMITTANCE: f32;

const BATCH: u32 = 256u;

var<workgroup> batch: array<Splat, BATCH>;
// Splats of a batch that reach the tile, up to each.
var<workgroup> kept: array<u32, BATCH>;
var<workgroup> open_pixels: atomic<u32>;
var<workgroup> any_open: u32;

// 2^x, for x from -126 to 126: `splatvol_core::exponential`, the short polynomial.
fn exp2_quick(x: f32) -> f32 {
    let n = round(x);
    let r = x - n;
    let p = (((9.582853e-3 * r + 5.5906425e-2) * r + 2.402410e-1) * r + 6.931242e-1) * r + 1.0;
    return p * bitcast<f32>(u32(i32(n) + 127) << 23u);
}

fn meets(range: u32, tile: u32) -> bool {
    return tile >= first_of(range) && tile < past_of(range);
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
        if lane == 0u {
            atomicStore(&open_pixels, 0u);
        }
        workgroupBarrier();
        if is_open {
            atomicAdd(&open_pixels, 1u);
        }
        workgroupBarrier();
        if lane == 0u {
            any_open = atomicLoad(&open_pixels);
        }
        if workgroupUniformLoad(&any_open) == 0u {
            break;
        }
        var splat: Splat;
        var is_kept = false;
        if first + lane < list.y {
            splat = splats[entries[first + lane]];
            is_kept = meets(splat.columns, tile.x) && meets(splat.rows, tile.y);
        }
        kept[lane] = select(0u, 1u, is_kept);
        workgroupBarrier();
        for (var step = 1u; step < BATCH; step <<= 1u) {
            var before = 0u;
            if lane >= step {
                before = kept[lane - step];
            }
            workgroupBarrier();
            kept[lane] += before;
            workgroupBarrier();
        }
        if is_kept {
            batch[kept[lane] - 1u] = splat;
        }
        let count = workgroupUniformLoad(&kept[BATCH - 1u]);
        if is_open {
            for (var i = 0u; i < count; i++) {
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
        colors[index] = vec4(color, through);
        depths[index] = depth_sum;
    }
}
