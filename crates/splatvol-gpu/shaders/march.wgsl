// March: a workgroup takes a tile through all planes, front to back, until its pixels are finished. Values of a plane are
// exchanged in workgroup memory, for differences across. A thread has two pixels.

@group(0) @binding(3) var<storage, read> tile_sheets: array<u32>;
// Linear premultiplied colour and transmittance; the sum of depths, weighted by opacity.
@group(0) @binding(7) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> depths: array<f32>;

// Values of a plane, with those of the neighbours of the tile's pixels; two planes in turn.
const PITCH: u32 = TILE_WIDTH + 2u;
const POINTS: u32 = PITCH * (TILE_HEIGHT + 2u);
var<workgroup> values: array<f32, 2u * POINTS>;
var<workgroup> open_pixels: atomic<u32>;
var<workgroup> any_open: u32;

// Planes after which pixels are counted.
const PATIENCE: u32 = 4u;

fn has_material(tile: u32, sheet: u32) -> bool {
    return sheet < frame.planes && (tile_sheets[tile * frame.words + sheet / 32u] >> (sheet % 32u) & 1u) != 0u;
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
    let index = at.y * frame.size.x + at.x;
    let so_far = colors[index];
    let ray = (vec2<f32>(at) + 0.5 - frame.principal) * frame.per_pixel;
    return Pixel(vec4(0.0), vec4(1.0), vec4(1.0), vec2(0.0), vec2(0.0), vec2(0.0), ray, so_far.rgb, so_far.a, depths[index]);
}

fn finish(at: vec2<u32>, pixel: ptr<function, Pixel>) {
    let index = at.y * frame.size.x + at.x;
    colors[index] = vec4((*pixel).color, (*pixel).transmittance);
    depths[index] = (*pixel).depth_sum;
}

// Takes a plane's value and differences at a pixel.
fn enter(pixel: ptr<function, Pixel>, sheet: u32, at: vec2<u32>, point: u32, is_filled: bool) {
    var sum = 0.0;
    var share = 1.0;
    // Outside of the volume there is no background either.
    var coverage = select(1.0, 0.0, frame.shows_background != 0u);
    var across = vec2(0.0);
    if is_filled {
        sum = values[point];
        let place = place_on(sheet, vec2<f32>(at) + 0.5 - frame.principal);
        share = share_at(place);
        coverage = coverage_at(place);
        across = vec2(values[point + 1u] - values[point - 1u], values[point + PITCH] - values[point - PITCH]);
        across *= 0.5 * sheets[sheet].scale;
    }
    (*pixel).sums = vec4((*pixel).sums.yzw, sum);
    (*pixel).shares = vec4((*pixel).shares.yzw, share);
    (*pixel).coverage = vec4((*pixel).coverage.yzw, coverage);
    (*pixel).across_before = (*pixel).across;
    (*pixel).across = (*pixel).across_last;
    (*pixel).across_last = across;
}

@compute @workgroup_size(256)
fn march(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let tile = group.y * frame.tiles.x + group.x;
    let corner = vec2(group.x * TILE_WIDTH, group.y * TILE_HEIGHT);
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
        first.transmittance = -1.0;
    }
    if !second_exists {
        second.transmittance = -1.0;
    }

    // An interval is shaded with the plane behind it, and the one after that.
    let last = frame.to_interval + 1u;
    var sheet = frame.from_interval - min(frame.from_interval, 1u);
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
        if is_filled {
            let middle = vec2<f32>(corner) - 0.5 - frame.principal;
            for (var point = thread; point < POINTS; point += 256u) {
                let offset = middle + vec2<f32>(vec2(point % PITCH, point / PITCH));
                values[plane + point] = sum_on(sheet, offset);
            }
        }
        workgroupBarrier();
        enter(&first, sheet, first_at, plane + first_point, is_filled);
        enter(&second, sheet, second_at, plane + second_point, is_filled);
        if sheet >= frame.from_interval + 2u && sheet - 2u < frame.to_interval {
            shade(&first, sheet - 2u);
            shade(&second, sheet - 2u);
        }
        if steps % PATIENCE == PATIENCE - 1u {
            if max(first.transmittance, second.transmittance) >= frame.termination {
                atomicOr(&open_pixels, 1u);
            }
            workgroupBarrier();
            if thread == 0u {
                any_open = atomicExchange(&open_pixels, 0u);
            }
            if workgroupUniformLoad(&any_open) == 0u {
                break;
            }
        }
        idle = select(idle + 1u, 0u, is_filled);
        steps += 1u;
        sheet += 1u;
    }
    if first_exists {
        finish(first_at, &first);
    }
    if second_exists {
        finish(second_at, &second);
    }
}
