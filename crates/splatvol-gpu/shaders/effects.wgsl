// Effects: planes shaded where clips leave them, or where isosurfaces are crossed, with operators; `splatvol_cpu::sheets::{operated,
// pixel, crossing}`, line by line.

// A pixel's cut face that it looks at: normal, camera space, and share of the lit material that lies on it; transmittance
// from the face on, and the interval in which it was last seen.
@group(0) @binding(10) var<storage, read_write> faces: array<vec4<f32>>;

struct Face {
    normal: vec3<f32>,
    share: f32,
    through: f32,
    interval: f32,
}

// Material that a ray meets, camera space: normalised value and its gradient, place, and direction of the ray.
struct Seen {
    value: f32,
    gradient: vec3<f32>,
    place: vec3<f32>,
    ray: vec3<f32>,
}

// A pixel between two planes.
struct Between {
    // Sums over shares, with the background, on four planes; `v + u (b + u (c + u d))` between the middle ones.
    values: vec4<f32>,
    // Values whose slope along the ray light uses.
    whole: vec4<f32>,
    cubic: vec4<f32>,
    coverage: vec2<f32>,
    sharpness: f32,
    ray: RaySegment,
    // World length of the ray's part.
    length: f32,
    from_eye: bool,
}

fn cubic_at(c: vec4<f32>, u: f32) -> f32 {
    return ((c.w * u + c.z) * u + c.y) * u + c.x;
}

fn value_at(own: Between, u: f32) -> f32 {
    return select(cubic_at(own.cubic, u), own.values.z, u >= 1.0);
}

fn place_at_depth(offset: vec2<f32>, depth: f32) -> vec3<f32> {
    let pixel = select(frame.plane_per_pixel, frame.per_pixel * depth, frame.per_pixel > 0.0);
    return vec3(offset * pixel, depth);
}

// Composites a colour with a transmittance behind a pixel.
fn ink_with(ink: Ink, color: vec3<f32>, through: f32, depth: f32) -> Ink {
    let share = ink.transmittance * (1.0 - through);
    return Ink(ink.color + color * share, ink.transmittance * through, ink.depth_sum + depth * share);
}

// The appearance of material of this colour and extinction; a face turns its normal. Without light, surfaces matter only to
// mirrors.
fn appearance_of(seen: Seen, material: vec4<f32>, face: Face) -> Appearance {
    let length = length(seen.gradient);
    var normal = select(-normalize(seen.ray), -seen.gradient / max(length, 1e-30), length > 1e-30);
    var surface = select(1.0, surfaceness(length), frame.lit != 0u);
    let weight = face.share * min(8.0 * face.through, 1.0);
    if weight > 0.0 {
        let mixed = mix(select(normal, -normal, dot(normal, face.normal) < 0.0), face.normal, weight);
        normal = select(face.normal, normalize(mixed), dot(mixed, mixed) > 1e-30);
        surface += (1.0 - surface) * weight;
    }
    return Appearance(material.rgb, material.a, normal, surface, vec3(0.0), 0.0);
}

// Its lit colour.
fn lit(own: Appearance) -> vec3<f32> {
    var color = own.color;
    if frame.lit != 0u {
        let light = phong_on(own.normal, own.surfaceness);
        color = color * light.x + light.y;
    }
    return color + (own.reflection - color) * own.reflectance;
}

// Material at a place of an interval.
fn seen_at(pixel: ptr<function, Pixel>, own: Between, u: f32, value: f32) -> Seen {
    let ray = vec3((*pixel).offset * frame.per_pixel, 1.0);
    return Seen(value, gradient_at(pixel, own.whole, u, own.sharpness), own.ray.start + own.ray.step * u, ray);
}

// Material of a part of an interval.
fn material(pixel: ptr<function, Pixel>, face: ptr<function, Face>, own: Between, range: Range, near: u32) {
    let width = (range.end - range.start) / f32(PIECES);
    var from_u = range.start;
    var from_value = value_at(own, from_u);
    var point = classify(from_value);
    if range.has_face {
        let extinction = point.z * mix(own.coverage.x, own.coverage.y, from_u);
        *face = Face(range.face, 1.0 - exp2(-4.0 * LOG2_E * extinction * frame.voxel), 1.0, f32(near));
    } else if f32(near) > (*face).interval + 1.0 {
        (*face).share = 0.0;
    }
    (*face).interval = f32(near);
    for (var i = 1; i <= PIECES; i++) {
        let to_u = range.start + width * f32(i);
        let to_value = value_at(own, to_u);
        let next = classify(to_value);
        let piece = segment(vec2(from_value, to_value), point, next);
        let extinction = piece.extinction * mix(own.coverage.x, own.coverage.y, 0.5 * (from_u + to_u));
        let optical_depth = extinction * own.length * width;
        let through = exp2(max(-LOG2_E * optical_depth, LEAST_EXPONENT));
        var place = piece.place;
        if (*face).share > 0.0 || own.from_eye {
            // Material from the cut, or the eye, on fills the piece.
            place *= 2.0 * visible_place(min(optical_depth, 80.0), through);
        }
        let u = mix(from_u, to_u, place);
        let value = mix(from_value, to_value, place);
        from_u = to_u;
        from_value = to_value;
        point = next;
        if extinction <= 0.0 {
            (*face).share = 0.0;
            continue;
        }
        let seen = seen_at(pixel, own, u, value);
        var shown = appearance_of(seen, vec4(color_of(value), extinction), *face);
        operate(seen, &shown);
        if !(shown.extinction > 0.0) {
            continue;
        }
        let left = exp2(max(-LOG2_E * shown.extinction * own.length * width, LEAST_EXPONENT));
        (*pixel).ink = ink_with((*pixel).ink, lit(shown), left, seen.place.z);
        (*face).through *= left;
    }
}

// Places of the cubic's extrema within 0..1, ascending; 1 stands for none.
fn extrema(c: vec4<f32>) -> vec2<f32> {
    let square = c.z * c.z - 3.0 * c.y * c.w;
    if square <= 0.0 {
        return vec2(1.0);
    }
    // Without cancellation: one root by the sum of like signs, the other by their product.
    let sum = -(c.z + select(sqrt(square), -sqrt(square), c.z < 0.0));
    let first = select(sum / (3.0 * select(c.w, 1.0, c.w == 0.0)), 1.0, c.w == 0.0);
    let second = select(c.y / select(sum, 1.0, sum == 0.0), 1.0, sum == 0.0);
    let a = select(1.0, first, first > 0.0 && first < 1.0);
    let b = select(1.0, second, second > 0.0 && second < 1.0);
    return vec2(min(a, b), max(a, b));
}

// Place where a monotonic part of the cubic takes a value, to 2^-24.
fn bisect(c: vec4<f32>, value: f32, part: vec2<f32>, rising: bool) -> f32 {
    var low = part.x;
    var high = part.y;
    for (var i = 0; i < 24; i++) {
        let middle = 0.5 * (low + high);
        if (cubic_at(c, middle) >= value) == rising {
            high = middle;
        } else {
            low = middle;
        }
    }
    return 0.5 * (low + high);
}

// The first crossing of an isosurface behind another one: place, and number of the surface; 2 where there is none.
fn next_crossing(own: Between, behind: vec2<f32>) -> vec2<f32> {
    var found = vec2(2.0, 0.0);
    let turns = extrema(own.cubic);
    for (var i = 0u; i < frame.isosurfaces; i++) {
        let value = effects[frame.first_isosurface + 2u * i].x;
        for (var part = 0; part < 3; part++) {
            let low = select(select(turns.y, turns.x, part == 1), 0.0, part == 0);
            let high = select(select(turns.y, turns.x, part == 0), 1.0, part == 2);
            let starts_above = value_at_end(own, low) >= value;
            let rising = value_at_end(own, high) >= value;
            if low < high && starts_above != rising {
                let u = bisect(own.cubic, value, vec2(low, high), rising);
                let is_behind = u > behind.x || (u == behind.x && f32(i) > behind.y);
                if is_behind && u < found.x {
                    found = vec2(u, f32(i));
                }
            }
        }
    }
    return found;
}

fn value_at_end(own: Between, u: f32) -> f32 {
    return select(value_at(own, u), own.values.y, u <= 0.0);
}

// The isosurfaces that a pixel's ray crosses.
fn cross_surfaces(pixel: ptr<function, Pixel>, own: Between) {
    var crossing = next_crossing(own, vec2(-1.0));
    // A cubic takes a value three times at most.
    for (var i = 0u; i < 3u * frame.isosurfaces && crossing.x < 2.0; i++) {
        let u = crossing.x;
        let is_covered = mix(own.coverage.x, own.coverage.y, u) >= 0.5;
        if is_covered && (*pixel).ink.transmittance >= frame.termination && is_left(own.ray, u) {
            let at = frame.first_isosurface + 2u * u32(crossing.y);
            let seen = seen_at(pixel, own, u, effects[at].x);
            let no_face = Face(vec3(0.0, 0.0, 1.0), 0.0, 1.0, 0.0);
            var shown = appearance_of(seen, vec4(effects[at + 1u].rgb, effects[at].y), no_face);
            operate(seen, &shown);
            if shown.extinction > 0.0 {
                let optical_depth = shown.extinction * frame.voxel;
                let through = select(0.0, exp2(-LOG2_E * optical_depth), optical_depth < 100.0);
                (*pixel).ink = ink_with((*pixel).ink, lit(shown), through, seen.place.z);
            }
        }
        crossing = next_crossing(own, crossing);
    }
}

fn show_parts(pixel: ptr<function, Pixel>, own: Between, near: u32) {
    let at = vec2<u32>((*pixel).offset + frame.principal);
    let index = 2u * (at.y * frame.size.x + at.x);
    var face = Face(faces[index].xyz, faces[index].w, faces[index + 1u].x, faces[index + 1u].y);
    var range = next_range(own.ray, 0.0);
    // Each body divides the interval once.
    for (var i = 0u; i <= frame.bodies && range.start < range.end; i++) {
        material(pixel, &face, own, range, near);
        if range.end >= 1.0 {
            break;
        }
        range = next_range(own.ray, range.end);
    }
    faces[index] = vec4(face.normal, face.share);
    faces[index + 1u] = vec4(face.through, face.interval, 0.0, 0.0);
}

// Shades the interval between planes `near` and `near + 1`.
fn shade(pixel: ptr<function, Pixel>, near: u32) {
    let found = around(pixel, near);
    let is_invisible = (found.is_untouched && frame.shows_background == 0u) || all(found.coverage <= vec2(0.0));
    if (*pixel).ink.transmittance < frame.termination || is_invisible {
        return;
    }
    let values = found.values;
    let coverage = found.coverage;
    let rise = values.z - values.y;
    let slopes = 0.5 * (values.zw - values.xy);
    let cubic = vec4(values.y, slopes.x, rise * 3.0 - slopes.x * 2.0 - slopes.y, slopes.x + slopes.y - rise * 2.0);
    let bends = vec2(values.y + slopes.x / 3.0, values.z - slopes.y / 3.0);
    let low = min(min(values.y, values.z), min(bends.x, bends.y));
    let high = max(max(values.y, values.z), max(bends.x, bends.y));
    if high < frame.hull.x || low > frame.hull.y {
        return;
    }
    let offset = (*pixel).offset;
    let start = place_at_depth(offset, sheets[near].depth);
    let ray = RaySegment(start, place_at_depth(offset, sheets[near + 1u].depth) - start);
    let slope = offset * frame.per_pixel;
    let length = sqrt(dot(slope, slope) + 1.0) * frame.spacing;
    let own = Between(values, found.whole, cubic, coverage, sharpness_of(near), ray, length, is_eye(near));
    if frame.isosurfaces > 0u {
        cross_surfaces(pixel, own);
    } else {
        show_parts(pixel, own, near);
    }
}
