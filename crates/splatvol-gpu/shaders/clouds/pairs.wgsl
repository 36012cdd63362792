// Pairs: a splat, and a group of planes in a tile that it may reach, in order of index. Planes are a frame's own, counted
// from its first.

@group(0) @binding(2) var<storage, read> splats: array<Splat>;
// Bits per tile of the march, and plane.
@group(0) @binding(8) var<storage, read_write> tile_sheets: array<atomic<u32>>;

// Farthest pixel that is told from others.
const FAR: f32 = 1e6;

// The groups that a splat reaches: first, and past the last.
fn groups_of(splat: Splat) -> vec2<u32> {
    let ends = (splat.centre.z + vec2(-splat.reach, splat.reach)) / frame.spacing - frame.first_plane;
    let first = ceil(max(ends.x, 0.0));
    let last = floor(min(ends.y, f32(frame.planes - 1u)));
    if splat.reach < 0.0 || first > last {
        return vec2(0u);
    }
    return vec2(u32(first) / GROUP, u32(last) / GROUP + 1u);
}

// Tiles that a splat may reach on the planes of a group: first x and y, then past the last.
fn tiles_of(splat: Splat, group: u32) -> vec4<u32> {
    let near = sheets[group * GROUP].depth;
    let far = sheets[min(group * GROUP + GROUP - 1u, frame.planes - 1u)].depth;
    var low = vec2(FAR);
    var high = vec2(-FAR);
    for (var end = 0; end < 2; end++) {
        let from_centre = clamp(select(far, near, end == 0) - splat.centre.z, -splat.reach, splat.reach);
        let depth = clamp(splat.centre.z + from_centre, near, far);
        let pixel = select(frame.plane_per_pixel, frame.per_pixel * depth, frame.per_pixel > 0.0);
        let middle = (splat.centre.xy + splat.slope * from_centre) / pixel;
        // A pixel more on either side, and one by rounding.
        let half = splat.half_extent / pixel + 2.0;
        low = min(low, middle - half);
        high = max(high, middle + half);
    }
    let edge = f32(EDGE);
    let most = vec2<f32>(frame.size + 1u + EDGE) / edge;
    let first = clamp(floor((low + frame.principal + 1.0) / edge), vec2(0.0), floor(most));
    let last = clamp(floor((high + frame.principal + 1.0) / edge), vec2(-1.0), floor(most) - 1.0);
    return vec4(vec2<u32>(first), vec2<u32>(last + 1.0));
}

@compute @workgroup_size(256)
fn count_pairs(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let at = linear_index(id, groups);
    if at >= lists.splats {
        return;
    }
    let splat = splats[at];
    let reached = groups_of(splat);
    var count = 0u;
    for (var group = reached.x; group < reached.y; group++) {
        let tiles = tiles_of(splat, group);
        count += (max(tiles.z, tiles.x) - tiles.x) * (max(tiles.w, tiles.y) - tiles.y);
    }
    counts[at] = count;
}

@compute @workgroup_size(256)
fn emit_pairs(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let at = linear_index(id, groups);
    if at >= lists.splats {
        return;
    }
    let splat = splats[at];
    let reached = groups_of(splat);
    var place = counts[at];
    for (var group = reached.x; group < reached.y; group++) {
        let tiles = tiles_of(splat, group);
        for (var row = tiles.y; row < tiles.w; row++) {
            for (var column = tiles.x; column < tiles.z; column++) {
                keys[place] = (row * lists.columns + column) * lists.per_tile + group;
                entries[place] = at;
                place++;
            }
        }
    }
}

// Marks the planes of groups that hold something in the tiles of the march that meet them. One invocation per list.
@compute @workgroup_size(256)
fn mark(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let list = linear_index(id, groups);
    if list >= arrayLength(&ranges) || ranges[list].x == ranges[list].y {
        return;
    }
    let group = list % lists.per_tile;
    let tile = vec2(list / lists.per_tile % lists.columns, list / lists.per_tile / lists.columns);
    let march_tile = vec2(TILE_WIDTH, TILE_HEIGHT);
    let first = (max(tile * EDGE, vec2(1u)) - 1u) / march_tile;
    let last = min((tile * EDGE + EDGE - 2u) / march_tile, frame.tiles - 1u);
    let bits = ((1u << GROUP) - 1u) << (group % 4u * GROUP);
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            atomicOr(&tile_sheets[(y * frame.tiles.x + x) * frame.words + group / 4u], bits);
        }
    }
}
