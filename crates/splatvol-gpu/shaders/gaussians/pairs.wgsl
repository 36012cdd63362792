// Pairs: a splat and a tile that it may touch, in order of depth; `sort/lists` has what they have in common with others.

@group(0) @binding(1) var<storage, read> splats: array<Splat>;
// Splats by depth.
@group(0) @binding(2) var<storage, read> order: array<u32>;

// Tiles with lists from those of the published renderer: first, and past the last.
fn list_tiles(range: u32) -> vec2<u32> {
    return vec2(first_of(range) / LIST_TILE, (past_of(range) + LIST_TILE - 1u) / LIST_TILE);
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
            keys[place] = row * lists.columns + column;
            entries[place] = splat;
            place++;
        }
    }
}
