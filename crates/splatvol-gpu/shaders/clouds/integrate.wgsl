// Integrate: footprints of optical depth are added up, tile by tile, to what rays keep of volumes (`integrals`): a workgroup takes a
// tile through its list; a pixel per invocation.

struct Tiles {
    // Fall of the exponent, base 2, at which footprints end; their value there, which is taken off.
    end: f32,
    edge: f32,
    // Along x.
    columns: u32,
    unused: u32,
}

@group(0) @binding(1) var<storage, read> splats: array<Splat>;
@group(0) @binding(2) var<storage, read> entries: array<u32>;
@group(0) @binding(3) var<storage, read> ranges: array<vec2<u32>>;
@group(0) @binding(4) var<uniform> tiles: Tiles;
@group(0) @binding(7) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> depths: array<f32>;

@compute @workgroup_size(256)
fn integrate(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let list = ranges[tile.y * tiles.columns + tile.x];
    let part = lane / (PART.x * PART.y);
    let within = lane % (PART.x * PART.y);
    let corner = tile.xy * REFERENCE_TILE;
    let at = corner + corner_of(part) + vec2(within % PART.x, within / PART.x);
    let pixel = vec2<f32>(at) + 0.5;
    // Optical depth, and colour times that.
    var sums = vec4(0.0);
    var depth_sum = 0.0;
    for (var first = list.x; first < list.y; first += BATCH) {
        if lane < PARTS * WORDS {
            atomicStore(&marks[lane], 0u);
        }
        workgroupBarrier();
        if first + lane < list.y {
            bring(splats[entries[first + lane]], tiles.end, lane, corner);
        }
        workgroupBarrier();
        for (var word = 0u; word < WORDS; word++) {
            var bits = atomicLoad(&marks[part * WORDS + word]);
            while bits != 0u {
                let i = word * 32u + firstTrailingBit(bits);
                bits &= bits - 1u;
                let d = pixel - batch[i].centre;
                let exponent = (d.x * batch[i].conic_xx_xy.x + d.y * batch[i].conic_xx_xy.y) * d.x
                    + d.y * d.y * batch[i].conic_yy;
                if !(exponent > -tiles.end) {
                    continue;
                }
                let own = max(exp2_quick(min(exponent, 0.0)) - tiles.edge, 0.0) * batch[i].peak;
                sums += own * vec4(1.0, batch[i].red_green, batch[i].blue);
                depth_sum += own * batch[i].depth;
            }
        }
        workgroupBarrier();
    }
    if all(at < frame.size) {
        let index = at.y * frame.size.x + at.x;
        // Rays keep integrals over depth.
        let per_length = 1.0 / ray_length(pixel - frame.principal);
        colors[index] += sums.yzwx * per_length;
        depths[index] += depth_sum * per_length;
    }
}
