// Pairs: a splat and a tile that it may touch, in order of depth; and where each tile's list begins and ends.

struct Lists {
    // Splats, pairs, and tiles with lists along x.
    splats: u32,
    pairs: u32,
    columns: u32,
    unused: u32,
}

@group(0) @binding(0) var<uniform> lists: Lists;
@group(0) @binding(1) var<storage, read> splats: array<Splat>;
// Splats by depth.
@group(0) @binding(2) var<storage, read> order: array<u32>;
// Pairs of a splat; then of all those before it.
@group(0) @binding(3) var<storage, read_write> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> tiles: array<u32>;
@group(0) @binding(5) var<storage, read_write> entries: array<u32>;
// First and past-the-last pair of a tile.
@group(0) @binding(6) var<storage, read_write> ranges: array<vec2<u32>>;

// Tiles with lists from those of the published renderer: first, and past the last.
fn list_tiles(range: u32) -> vec2<u32> {
    return vec2(first_of(range) / LIST_TILE, (past_of(range) + LIST_TILE - 1u) / LIST_TILE);
}

fn linear_index(id: vec3<u32>, groups: vec3<u32>) -> u32 {
    return id.y * groups.x * 256u + id.x;
}

@compute @workgroup_size(256)
fn count_tiles(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let at = linear_index(id, groups);
    if at >= lists.splats {
        return;
    }
    let splat = order[at];
    let columns = list_tiles(splats[splat].columns);
    let rows = list_tiles(splats[splat].rows);
    counts[at] = (columns.y - columns.x) * (rows.y - rows.x);
}

@compute @workgroup_size(256)
fn emit(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let at = linear_index(id, groups);
    if at >= lists.splats {
        return;
    }
    let splat = order[at];
    let columns = list_tiles(splats[splat].columns);
    let rows = list_tiles(splats[splat].rows);
    var place = counts[at];
    for (var row = rows.x; row < rows.y; row++) {
        for (var column = columns.x; column < columns.y; column++) {
            tiles[place] = row * lists.columns + column;
            entries[place] = splat;
            place++;
        }
    }
}

@compute @workgroup_size(256)
fn find_ranges(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let at = linear_index(id, groups);
    if at >= lists.pairs {
        return;
    }
    let tile = tiles[at];
    if at == 0u || tiles[at - 1u] != tile {
        ranges[tile].x = at;
    }
    if at + 1u == lists.pairs || tiles[at + 1u] != tile {
        ranges[tile].y = at + 1u;
    }
}
