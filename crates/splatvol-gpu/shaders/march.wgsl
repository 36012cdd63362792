// March: a workgroup takes a tile through all planes, front to back, until its pixels are finished. A thread has two
// pixels. The mode says what a pixel keeps of planes: `Pixel`, `fresh`, `exchange`, `enter`, `shade`, and `LAG`, the planes
// from an interval's nearer one to the one with which it is shaded. `direct` or `gather` says where shaded intervals go.

@group(0) @binding(3) var<storage, read> tile_sheets: array<u32>;
// Linear premultiplied colour and transmittance.
@group(0) @binding(7) var<storage, read_write> colors: array<vec4<f32>>;

var<workgroup> open_pixels: atomic<u32>;
var<workgroup> any_open: u32;

// Planes after which pixels are counted.
const PATIENCE: u32 = 4u;

fn has_material(tile: u32, sheet: u32) -> bool {
    return sheet < frame.planes && ((tile_sheets[tile * frame.words + sheet / 32u] >> (sheet % 32u)) & 1u) != 0u;
}

// The first plane from this one on that may hold something.
fn next_with_material(tile: u32, sheet: u32) -> u32 {
    var word = sheet / 32u;
    var bits = tile_sheets[tile * frame.words + word] & (0xffffffffu << (sheet % 32u));
    while bits == 0u {
        word += 1u;
        if word >= frame.words {
            return frame.planes + 2u;
        }
        bits = tile_sheets[tile * frame.words + word];
    }
    return word * 32u + firstTrailingBit(bits);
}

fn begin(at: vec2<u32>) -> Pixel {
    return fresh(vec2<f32>(at) + 0.5 - frame.principal, ink_at(at.y * frame.size.x + at.x));
}

// Keeps whether a thread's pixels are open; returns whether any of the tile is.
fn any_is_open(thread: u32, points: vec2<u32>, left: vec2<f32>) -> bool {
    let open = left >= vec2(frame.termination);
    is_open[points.x] = u32(open.x);
    is_open[points.y] = u32(open.y);
    if any(open) {
        atomicOr(&open_pixels, 1u);
    }
    workgroupBarrier();
    if thread == 0u {
        any_open = atomicExchange(&open_pixels, 0u);
    }
    return workgroupUniformLoad(&any_open) != 0u;
}

@compute @workgroup_size(256)
fn march(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let row = frame.first_tile_row + group.y;
    let tile = row * frame.tiles.x + group.x;
    let corner = vec2(group.x * TILE_WIDTH, row * TILE_HEIGHT);
    let own = vec2(thread % TILE_WIDTH, thread / TILE_WIDTH);
    let first_at = corner + own;
    let second_at = first_at + vec2(0u, TILE_HEIGHT / 2u);
    let first_point = (own.y + 1u) * PITCH + own.x + 1u;
    let second_point = first_point + TILE_HEIGHT / 2u * PITCH;
    let first_exists = all(first_at < frame.size);
    let second_exists = all(second_at < frame.size);
    var first = begin(min(first_at, frame.size - 1u));
    var second = begin(min(second_at, frame.size - 1u));
    if !first_exists {
        first.ink.transmittance = -1.0;
    }
    if !second_exists {
        second.ink.transmittance = -1.0;
    }

    let points = vec2(first_point, second_point);
    if !any_is_open(thread, points, vec2(first.ink.transmittance, second.ink.transmittance)) {
        return;
    }
    let last = frame.to_interval + LAG - 1u;
    var sheet = frame.from_interval - min(frame.from_interval, LAG - 1u);
    var idle = 4u;
    var steps = 0u;
    loop {
        if idle >= 4u {
            sheet = next_with_material(tile, min(sheet, frame.planes - 1u));
            idle = 0u;
        }
        if sheet > last {
            break;
        }
        let is_filled = has_material(tile, sheet);
        let plane = (steps & 1u) * POINTS;
        exchange(sheet, plane, corner, thread, is_filled);
        enter(&first, sheet, plane + first_point, is_filled);
        enter(&second, sheet, plane + second_point, is_filled);
        if sheet >= frame.from_interval + LAG && sheet - LAG < frame.to_interval {
            show(&first, sheet - LAG);
            show(&second, sheet - LAG);
        }
        if steps % PATIENCE == PATIENCE - 1u {
            let left = vec2(first.ink.transmittance, second.ink.transmittance);
            if !any_is_open(thread, points, left) {
                break;
            }
        }
        idle = select(idle + 1u, 0u, is_filled);
        steps += 1u;
        sheet += 1u;
    }
    if first_exists {
        finish(first_at.y * frame.size.x + first_at.x, first.ink);
    }
    if second_exists {
        finish(second_at.y * frame.size.x + second_at.x, second.ink);
    }
}
