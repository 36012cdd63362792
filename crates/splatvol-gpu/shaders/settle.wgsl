// Settle: from what rays kept to colours, behind all planes. The mode has `settle_at`.

// Replaces what rays kept by their pixels.
@compute @workgroup_size(256)
fn settle(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = vec2(group.x * TILE_WIDTH, group.y * TILE_HEIGHT) + vec2(thread % TILE_WIDTH, thread / TILE_WIDTH);
    if all(at < frame.size) {
        settle_at(at);
    }
}
