// Cull: which planes of which tiles may hold something. One invocation per octant of a page sets the bits of the planes that
// its cells meet, in the tiles that its projection covers.

@group(0) @binding(3) var<storage, read_write> tile_sheets: array<atomic<u32>>;

// Pixels around an octant's projection: the neighbours that differences need, and a filter.
const AROUND: f32 = 4.0;
// Depth of a corner, in distances of planes, below which an octant covers the whole picture.
const AT_EYE: f32 = 1e-3;

// Invocations along x of a dispatch.
const ROW: u32 = 65536u;

@compute @workgroup_size(64)
fn cull(@builtin(global_invocation_id) id: vec3<u32>) {
    let counts = vec3<u32>(frame.pages);
    let index = id.y * ROW + id.x;
    let at = index / 8u;
    let octant = index % 8u;
    if at >= counts.x * counts.y * counts.z || ((pages[at] >> (OCTANTS_FROM + octant)) & 1u) == 0u {
        return;
    }
    let page = vec3<u32>(at % counts.x, at / counts.x % counts.y, at / (counts.x * counts.y));
    let half = u32(PAGE / 2);
    let first = vec3<f32>(page * u32(PAGE) + half * vec3(octant & 1u, (octant >> 1u) & 1u, octant >> 2u)) - f32(BEFORE);
    var nearest = 3e38;
    var farthest = -3e38;
    var low = vec2(3e38);
    var high = vec2(-3e38);
    var before_eye = false;
    for (var corner = 0u; corner < 8u; corner++) {
        let offset = vec3<f32>(vec3(corner & 1u, (corner >> 1u) & 1u, corner >> 2u)) * f32(half);
        let place = (frame.camera_from_lattice * vec4(first + offset, 1.0)).xyz;
        nearest = min(nearest, place.z);
        farthest = max(farthest, place.z);
        var pixel = place.xy / frame.plane_per_pixel;
        if frame.per_pixel > 0.0 {
            before_eye = before_eye || place.z < AT_EYE * frame.spacing;
            pixel = place.xy / (max(place.z, AT_EYE * frame.spacing) * frame.per_pixel);
        }
        low = min(low, pixel);
        high = max(high, pixel);
    }
    let sheet = vec2(nearest, farthest) / frame.spacing - frame.first_plane + vec2(-1e-3, 1e-3);
    let first_sheet = i32(max(ceil(sheet.x), 0.0));
    let last_sheet = i32(min(floor(sheet.y), f32(frame.planes - 1u)));
    if first_sheet > last_sheet {
        return;
    }
    let tile = vec2(f32(TILE_WIDTH), f32(TILE_HEIGHT));
    let most = vec2<i32>(frame.tiles) - 1;
    var first_tile = vec2<i32>(floor(clamp((low + frame.principal - AROUND) / tile, vec2(-1.0), vec2(1e6))));
    var last_tile = vec2<i32>(floor(clamp((high + frame.principal + AROUND) / tile, vec2(-1.0), vec2(1e6))));
    if before_eye {
        first_tile = vec2(0);
        last_tile = most;
    }
    first_tile = max(first_tile, vec2(0));
    last_tile = min(last_tile, most);
    for (var y = first_tile.y; y <= last_tile.y; y++) {
        for (var x = first_tile.x; x <= last_tile.x; x++) {
            let start = u32(y * (most.x + 1) + x) * frame.words;
            for (var word = first_sheet / 32; word <= last_sheet / 32; word++) {
                let first_bit = u32(max(first_sheet - 32 * word, 0));
                let last_bit = u32(min(last_sheet - 32 * word, 31));
                let bits = (0xffffffffu << first_bit) & (0xffffffffu >> (31u - last_bit));
                atomicOr(&tile_sheets[start + u32(word)], bits);
            }
        }
    }
}
