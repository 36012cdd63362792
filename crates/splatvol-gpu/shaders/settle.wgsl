// Settle: from what rays kept to colours, behind all planes. The mode has `settle_at`.

// Replaces what rays kept by their pixels.
@compute @workgroup_size(256)
fn settle(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let corner = vec2(group.x * TILE_WIDTH, group.y * TILE_HEIGHT);
    for (var half = 0u; half < 2u; half++) {
        let at = corner + vec2(thread % TILE_WIDTH, thread / TILE_WIDTH + half * TILE_HEIGHT / 2u);
        if all(at < frame.size) {
            settle_at(at);
        }
    }
}
