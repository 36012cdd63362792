// Assemble: coefficients of bricks of 8^3 voxels, as `FieldStore::pack` writes them, to slots of pages: the voxels that are
// needed, less the background; others are zero. A channel more has ones where needed samples are missing.

struct Assembly {
    // Pages to assemble, and texels of a slot along each axis.
    pages: u32,
    edge: u32,
    // Channels, and layers of each.
    channels: u32,
    channel_layers: u32,
}

@group(0) @binding(0) var<uniform> assembly: Assembly;
// Per brick: offset, scale, whether samples are missing, and a number that is not used; bits of the needed voxels, by
// planes and rows; values of 16 bits, two in each number.
@group(0) @binding(1) var<storage, read> bricks: array<u32>;
// Per page: its slot's first column, row and layer; its first lattice point; the number of each brick around, by planes and
// rows of four.
@group(0) @binding(2) var<storage, read> pages: array<u32>;
@group(0) @binding(3) var atlas: texture_storage_2d_array<r32float, write>;

const BITS_FROM: u32 = 4u;
const VALUES_FROM: u32 = 20u;
const PACKED: u32 = 276u;
const NUMBERS_FROM: u32 = 6u;
const OF_PAGE: u32 = 70u;
const NO_BRICK: u32 = 0xffffffffu;
const MISSING: u32 = 0xffffu;
// Pages along x of a dispatch.
const PAGES_ACROSS: u32 = 32768u;

// Coefficient and, where the sample is missing, one.
fn coefficient_of(brick: u32, voxel: vec3<u32>) -> vec2<f32> {
    let first = brick * PACKED;
    let bits = bricks[first + BITS_FROM + 2u * voxel.z + voxel.y / 4u];
    if ((bits >> (8u * (voxel.y % 4u) + voxel.x)) & 1u) == 0u {
        return vec2(0.0);
    }
    let index = 64u * voxel.z + 8u * voxel.y + voxel.x;
    let value = (bricks[first + VALUES_FROM + index / 2u] >> (16u * (index % 2u))) & 0xffffu;
    if value == MISSING && bricks[first + 2u] != 0u {
        return vec2(0.0, 1.0);
    }
    return vec2(f32(value) * bitcast<f32>(bricks[first + 1u]) + bitcast<f32>(bricks[first]), 0.0);
}

@compute @workgroup_size(64)
fn assemble(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let edge = assembly.edge;
    let texel = group.y * 64u + thread;
    let page = group.z * PAGES_ACROSS + group.x;
    if texel >= edge * edge * edge || page >= assembly.pages {
        return;
    }
    let own = page * OF_PAGE;
    let slot = vec3(pages[own], pages[own + 1u], pages[own + 2u]);
    let first = bitcast<vec3<i32>>(vec3(pages[own + 3u], pages[own + 4u], pages[own + 5u]));
    let local = vec3(texel % edge, texel / edge % edge, texel / (edge * edge));
    let point = first + vec3<i32>(local);
    let around = vec3<u32>((point >> vec3(3u)) - (first >> vec3(3u)));
    let brick = pages[own + NUMBERS_FROM + 16u * around.z + 4u * around.y + around.x];
    var sums = vec2(0.0);
    if brick != NO_BRICK {
        sums = coefficient_of(brick, vec3<u32>(point & vec3(7)));
    }
    let at = vec2<i32>(slot.xy + local.xy);
    for (var channel = 0u; channel < assembly.channels; channel++) {
        let layer = i32(slot.z + local.z + channel * assembly.channel_layers);
        textureStore(atlas, at, layer, vec4(select(sums.x, sums.y, channel == 1u), 0.0, 0.0, 0.0));
    }
}
