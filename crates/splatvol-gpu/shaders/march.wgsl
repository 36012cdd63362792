// March: a workgroup takes a tile through all planes, front to back, until its pixels are finished. A thread has a pixel: the
// registers of two would leave room for fewer workgroups. The mode says what a pixel keeps of planes: `Pixel`, `fresh`,
// `exchange`, `enter`, `shade`; `LAG`, the planes from an interval's nearer one to the one with which it is shaded; and `LEAD`,
// the planes before one with material that a pixel must have seen. `direct` or `gather` says where shaded intervals go.

@group(0) @binding(3) var<storage, read> tile_sheets: array<u32>;
// Linear premultiplied colour and transmittance.
@group(0) @binding(7) var<storage, read_write> colors: array<vec4<f32>>;

var<workgroup> open_pixels: atomic<u32>;
var<workgroup> any_open: u32;

// Planes after which pixels are counted.
const PATIENCE: u32 = 4u;

// A bit for each of 32 planes that may hold something.
fn planes_with_material(tile: u32, word: u32) -> u32 {
    return tile_sheets[tile * frame.words + min(word, frame.words - 1u)];
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

// Keeps whether a thread's pixel is open; returns whether any of the tile is.
fn any_is_open(thread: u32, point: u32, left: f32) -> bool {
    let open = left >= frame.termination;
    is_open[point] = u32(open);
    if open {
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
    let at = corner + own;
    let point = (own.y + 1u) * PITCH + own.x + 1u;
    let exists = all(at < frame.size);
    var pixel = begin(min(at, frame.size - 1u));
    if !exists {
        pixel.ink.transmittance = -1.0;
    }
    if !any_is_open(thread, point, pixel.ink.transmittance) {
        return;
    }
    let last = frame.to_interval + LAG - 1u;
    var sheet = frame.from_interval - min(frame.from_interval, LAG - 1u);
    var wanted = wanted_points(thread);
    var idle = 4u;
    var steps = 0u;
    var word = frame.words;
    var bits = 0u;
    loop {
        if idle >= 4u {
            let next = next_with_material(tile, min(sheet, frame.planes - 1u));
            sheet = max(max(next, LEAD) - LEAD, sheet);
            idle = 0u;
        }
        if sheet > last {
            break;
        }
        if sheet / 32u != word {
            word = sheet / 32u;
            bits = planes_with_material(tile, word);
        }
        let is_filled = sheet < frame.planes && ((bits >> (sheet % 32u)) & 1u) != 0u;
        let plane = (steps & 1u) * POINTS;
        exchange(sheet, plane, corner, vec2(thread, wanted), is_filled);
        enter(&pixel, sheet, plane + point, is_filled);
        if sheet >= frame.from_interval + LAG && sheet - LAG < frame.to_interval {
            show(&pixel, sheet - LAG);
        }
        if steps % PATIENCE == PATIENCE - 1u {
            if !any_is_open(thread, point, pixel.ink.transmittance) {
                break;
            }
            wanted = wanted_points(thread);
        }
        idle = select(idle + 1u, 0u, is_filled);
        steps += 1u;
        sheet += 1u;
    }
    if exists {
        finish(at.y * frame.size.x + at.x, pixel.ink);
    }
}
