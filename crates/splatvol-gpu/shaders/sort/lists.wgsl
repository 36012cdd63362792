// Lists: pairs of a list and an entry, sorted by list; where each list begins and ends.

struct Lists {
    // Entries that have pairs, pairs, tiles with lists along x, and lists per tile.
    splats: u32,
    pairs: u32,
    columns: u32,
    per_tile: u32,
}

@group(0) @binding(7) var<uniform> lists: Lists;
// Pairs of an entry; then of all those before it.
@group(0) @binding(3) var<storage, read_write> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> entries: array<u32>;
// First and past-the-last pair of a list.
@group(0) @binding(6) var<storage, read_write> ranges: array<vec2<u32>>;

fn linear_index(id: vec3<u32>, groups: vec3<u32>) -> u32 {
    return id.y * groups.x * 256u + id.x;
}

@compute @workgroup_size(256)
fn find_ranges(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let at = linear_index(id, groups);
    if at >= lists.pairs {
        return;
    }
    let list = keys[at];
    if at == 0u || keys[at - 1u] != list {
        ranges[list].x = at;
    }
    if at + 1u == lists.pairs || keys[at + 1u] != list {
        ranges[list].y = at + 1u;
    }
}
