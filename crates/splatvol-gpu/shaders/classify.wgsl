// Classify: extinction and lit emission of the voxels of slots, from samples; `splatvol_cpu::sheets::classified`.

// Page of each slot.
@group(0) @binding(3) var<storage, read> resident: array<u32>;
// Normalised samples of a level; missing ones are MISSING.
@group(0) @binding(4) var samples: texture_3d<f32>;
// Classes of its voxels, where they are not those of its samples.
@group(0) @binding(5) var means: texture_3d<f32>;
// Surfaces of labels where classes are means: differences per voxel, and the share of the voxel.
@group(0) @binding(8) var surfaces: texture_3d<f32>;
@group(0) @binding(7) var classes: texture_storage_2d_array<r32float, write>;

override TAPS: i32 = 4;
// Whether classes are those of `means`.
override FROM_MEANS: bool = false;
// Whether values are labels: light falls on the shape of each.
override LABELS: bool = false;

const MISSING: f32 = -1e30;
// Slots along x of a dispatch.
const SLOTS_ACROSS: u32 = 32768u;

// Extinction and emission of a value.
fn class_of(value: f32) -> vec4<f32> {
    let position = node_position(value);
    let cell = u32(position);
    let a = nodes[2u * cell + 1u];
    let b = nodes[2u * cell + 3u];
    return mix(vec4(a.x, a.x * a.yzw), vec4(b.x, b.x * b.yzw), position - floor(position));
}

// A sample beside another: beyond the volume the nearest one, in place of a missing one its own; of labels the share of its
// own kind.
fn beside(at: vec3<i32>, own: f32) -> f32 {
    let inside = clamp(at, vec3(0), vec3<i32>(frame.samples) - 1);
    let value = textureLoad(samples, inside, 0).x;
    if LABELS {
        return select(0.0, 1.0, value == own);
    }
    return select(value, own, value == MISSING);
}

fn difference(at: vec3<i32>, axis: vec3<i32>, own: f32) -> f32 {
    let position = dot(at, axis);
    let last = dot(vec3<i32>(frame.samples), axis) - 1;
    let per_voxel = select(0.5, 1.0, position == 0 || position == last);
    return per_voxel * (beside(at + axis, own) - beside(at - axis, own));
}

// Differences per voxel, and the share of the voxel on which light falls.
fn surface_at(at: vec3<i32>, own: f32) -> vec4<f32> {
    if FROM_MEANS && LABELS {
        return textureLoad(surfaces, at, 0);
    }
    return vec4(
        difference(at, vec3(1, 0, 0), own),
        difference(at, vec3(0, 1, 0), own),
        difference(at, vec3(0, 0, 1), own),
        1.0,
    );
}

fn classify_at(at: vec3<i32>, value: f32) -> vec4<f32> {
    var material = vec4(0.0);
    if FROM_MEANS {
        material = textureLoad(means, at, 0);
    } else if value >= frame.hull.x && value <= frame.hull.y {
        material = class_of(value);
    }
    let position = vec3<f32>(at) + frame.margin;
    if material.x <= 0.0 || !is_kept((frame.camera_from_lattice * vec4(position, 1.0)).xyz) {
        return vec4(0.0);
    }
    if frame.lit != 0u {
        let surface = surface_at(at, value);
        let full = phong(frame.gradient_from_lattice * surface.xyz);
        let light = mix(vec2(1.0, 0.0), full, surface.w);
        material = vec4(material.x, material.yzw * light.x + light.y * material.x);
    }
    return material;
}

@compute @workgroup_size(64)
fn classify(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let edge = PAGE + TAPS - 1;
    let texel = i32(group.y * 64u + thread);
    let slot = group.z * SLOTS_ACROSS + group.x;
    if texel >= edge * edge * edge || slot >= arrayLength(&resident) {
        return;
    }
    let local = vec3(texel % edge, texel / edge % edge, texel / (edge * edge));
    let index = i32(resident[slot]);
    let page = vec3(index % frame.pages.x, index / frame.pages.x % frame.pages.y, index / (frame.pages.x * frame.pages.y));
    let point = page * PAGE - BEFORE - (TAPS / 2 - 1) + local;
    let at = point - vec3<i32>(frame.margin);
    var material = vec4(0.0);
    if all(at >= vec3(0)) && all(at < vec3<i32>(frame.samples)) {
        let value = textureLoad(samples, at, 0).x;
        if FROM_MEANS || value != MISSING {
            material = classify_at(at, value);
        }
    }
    let corner = vec2<i32>(vec2(slot % frame.slots.x, slot / frame.slots.x % frame.slots.y)) * edge;
    let layer = i32(slot / (frame.slots.x * frame.slots.y)) * edge;
    let layers = i32(frame.channel_layers);
    for (var channel = 0; channel < 4; channel++) {
        textureStore(classes, corner + local.xy, layer + local.z + channel * layers, vec4(material[channel], 0.0, 0.0, 0.0));
    }
}
