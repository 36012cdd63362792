// Composite: a workgroup takes a tile of the published renderer through its list, front to back; a pixel per invocation.

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

// log2(255).
override LOG2_255: f32;
override MOST_ALPHA: f32;
override LEAST_TRANSMITTANCE: f32;

var<workgroup> open_pixels: atomic<u32>;
var<workgroup> is_ended: u32;

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
            let splat = splats[entries[first + lane]];
            bring(splat, splat.peak + LOG2_255, lane, corner);
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
