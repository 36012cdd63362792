// Clear: an empty picture.

@group(0) @binding(0) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> depths: array<f32>;

@compute @workgroup_size(256)
fn clear(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 256u + id.x;
    if index < arrayLength(&colors) {
        colors[index] = vec4(0.0, 0.0, 0.0, 1.0);
        depths[index] = 0.0;
    }
}
