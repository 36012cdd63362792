// Pairs: a splat and a tile that it may touch, in order of depth; `sort/lists` has what they have in common with others.

@group(0) @binding(1) var<storage, read> splats: array<Splat>;
// Splats by depth.
@group(0) @binding(2) var<storage, read> order: array<u32>;

// How many tiles of the published renderer a splat may touch.
fn tiles_of(splat: u32) -> u32 {
    let columns = splats[splat].columns;
    let rows = splats[splat].rows;
    return (past_of(columns) - first_of(columns)) * (past_of(rows) - first_of(rows));
}

@compute @workgroup_size(256)
fn count_tiles(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let at = linear_index(id, groups);
    if at >= lists.splats {
        return;
    }
    counts[at] = tiles_of(order[at]);
}

@compute @workgroup_size(256)
fn emit(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let at = linear_index(id, groups);
    if at >= lists.splats {
        return;
    }
    let splat = order[at];
    let columns = splats[splat].columns;
    let rows = splats[splat].rows;
    var place = counts[at];
    for (var row = first_of(rows); row < past_of(rows); row++) {
        for (var column = first_of(columns); column < past_of(columns); column++) {
            keys[place] = row * lists.columns + column;
            entries[place] = splat;
            place++;
        }
    }
}
