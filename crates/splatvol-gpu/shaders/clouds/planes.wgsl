// Planes: a workgroup makes the sums on a group's planes in a tile, splat by splat of its list; a pixel per invocation. Sums
// are kept in a ring of planes, from which pixels are shaded.

@group(0) @binding(2) var<storage, read> splats: array<Splat>;
@group(0) @binding(3) var<storage, read> entries: array<u32>;
@group(0) @binding(4) var<storage, read> ranges: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> ring: array<Sums>;

override DEPTH_EDGE: f32;

const BATCH: u32 = 32u;

var<workgroup> batch: array<Splat, BATCH>;
// Footprint of each splat on each plane: its centre and a pixel's size, world length; its weight.
var<workgroup> footprints: array<vec4<f32>, BATCH * GROUP>;

fn footprint_on(splat: Splat, sheet: u32) -> vec4<f32> {
    if sheet >= frame.planes {
        return vec4(0.0);
    }
    let from_centre = sheets[sheet].depth - splat.centre.z;
    let profile = exp2(max(from_centre * from_centre * splat.depth_exponent, -126.0)) - DEPTH_EDGE;
    return vec4(splat.centre.xy + splat.slope * from_centre, 1.0 / sheets[sheet].scale, max(profile, 0.0));
}

// Weight of a splat at an offset in pixels from the principal point.
fn weight_at(splat: Splat, footprint: vec4<f32>, offset: vec2<f32>) -> f32 {
    let d = offset * footprint.z - footprint.xy;
    // Footprints end with whole blocks of two pixels on the CPU: a pixel on either side in the mean.
    if footprint.w <= 0.0 || any(abs(d) > splat.half_extent + footprint.z) {
        return 0.0;
    }
    let exponent = (d.x * splat.exponent.x + d.y * splat.exponent.y) * d.x + d.y * d.y * splat.exponent.z;
    return footprint.w * exp2(max(exponent, -126.0));
}

fn keep_plane(sheet: u32, at: vec2<u32>, sums: Sums) {
    ring[sheet % RING * part.points + (at.y - part.first_row * EDGE) * part.pitch + at.x] = sums;
}

@compute @workgroup_size(16, 16)
fn make_planes(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile = vec2(workgroup.x, part.first_row + workgroup.y);
    let group = part.first_group + workgroup.z;
    let list = ranges[(tile.y * part.columns + tile.x) * part.groups + group];
    let at = tile * EDGE + local.xy;
    let offset = vec2<f32>(at) - 0.5 - frame.principal;
    let first = group * GROUP;
    var s0 = Sums(); var s1 = Sums(); var s2 = Sums(); var s3 = Sums();
    var s4 = Sums(); var s5 = Sums(); var s6 = Sums(); var s7 = Sums();
    for (var pair = list.x; pair < list.y; pair += BATCH) {
        let count = min(BATCH, list.y - pair);
        let own = lane / GROUP;
        workgroupBarrier();
        if own < count {
            let splat = splats[entries[pair + own]];
            footprints[lane] = footprint_on(splat, first + lane % GROUP);
            if lane % GROUP == 0u {
                batch[own] = splat;
            }
        }
        workgroupBarrier();
        for (var i = 0u; i < count; i++) {
            let splat = batch[i];
            let sums = sums_of(splat.payload);
            let on = i * GROUP;
            s0 += weight_at(splat, footprints[on], offset) * sums;
            s1 += weight_at(splat, footprints[on + 1u], offset) * sums;
            s2 += weight_at(splat, footprints[on + 2u], offset) * sums;
            s3 += weight_at(splat, footprints[on + 3u], offset) * sums;
            s4 += weight_at(splat, footprints[on + 4u], offset) * sums;
            s5 += weight_at(splat, footprints[on + 5u], offset) * sums;
            s6 += weight_at(splat, footprints[on + 6u], offset) * sums;
            s7 += weight_at(splat, footprints[on + 7u], offset) * sums;
        }
    }
    keep_plane(first, at, s0);
    keep_plane(first + 1u, at, s1);
    keep_plane(first + 2u, at, s2);
    keep_plane(first + 3u, at, s3);
    keep_plane(first + 4u, at, s4);
    keep_plane(first + 5u, at, s5);
    keep_plane(first + 6u, at, s6);
    keep_plane(first + 7u, at, s7);
}
