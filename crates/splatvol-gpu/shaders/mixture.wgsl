// Mixture: gathered intervals are composited, front to back. One invocation per pixel of a part of the picture.

@group(0) @binding(7) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> gathered: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read_write> depths: array<f32>;

// Invocations along x of a dispatch.
const ROW: u32 = 32768u * 64u;

@compute @workgroup_size(64)
fn mixture(@builtin(global_invocation_id) id: vec3<u32>) {
    let own = id.y * ROW + id.x;
    let index = frame.first_tile_row * TILE_HEIGHT * frame.size.x + own;
    if own >= frame.band_pixels || index >= frame.size.x * frame.size.y {
        return;
    }
    var color = colors[index];
    var depth_sum = depths[index];
    for (var interval = 0u; interval < frame.gathered_intervals; interval++) {
        let at = 2u * (interval * frame.band_pixels + own);
        let opacity = gathered[at + 1u].x;
        if opacity > 0.0 && color.a >= frame.termination {
            let material = gathered[at];
            depth_sum += color.a * opacity * gathered[at + 1u].y;
            color = vec4(color.rgb + color.a * material.rgb, color.a * material.a);
        }
    }
    colors[index] = color;
    depths[index] = depth_sum;
}
