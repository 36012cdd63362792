// Shade: material between two values, its light, and what a pixel has of it; `splatvol_cpu::sheets::shade_batch`, line by
// line, for one pixel.

// Per cell: K and M up to it, extinction, and the square roots of linear colour in 11, 11 and 10 bits
// (`splatvol_core::shade_table`).
@group(0) @binding(6) var<storage, read> table: array<vec4<f32>>;

const FIRST_VALUE: f32 = -0.25;
const PER_VALUE: f32 = 1024.0;
const LAST_POSITION: f32 = 2047.99;
// Rise of the value below which the integrals' difference would lose its digits.
const FLAT: f32 = 2e-3;
// Extinction along an interval below which its mean place would be rounding.
const NO_MATERIAL: f32 = 1e-20;
// Optical depth from which an interval is cut in halves.
const THICK: f32 = 0.02;
// Optical depth of an interval of the densest material from which thin intervals are cut, too.
const DENSE: f32 = 0.1;
const LOG2_E: f32 = 1.4426950;
const LEAST_EXPONENT: f32 = -100.0;
// Least squared gradient, in value ranges per voxel.
const LEAST_SQUARED: f32 = 1e-12;
// Beyond this, four planes are too few to soften the slope as much as the differences across the ray.
const SOFTEST: f32 = -0.1;

// K, M and the extinction of a value.
fn classify(value: f32) -> vec3<f32> {
    let position = clamp((value - FIRST_VALUE) * PER_VALUE, 0.0, LAST_POSITION);
    let cell = floor(position);
    let entry = table[u32(cell)];
    let own = (position - cell) * entry.z * (1.0 / PER_VALUE);
    let middle = (cell + position) * (0.5 / PER_VALUE) + FIRST_VALUE;
    return vec3(own + entry.x, own * middle + entry.y, entry.z);
}

// Linear colour of a value.
fn color_of(value: f32) -> vec3<f32> {
    let position = clamp((value - FIRST_VALUE) * PER_VALUE, 0.0, LAST_POSITION);
    let bits = bitcast<u32>(table[u32(position)].w);
    let root = vec3<f32>(vec3(bits >> 21u, bits >> 10u & 0x7ffu, bits & 0x3ffu)) / vec3(2047.0, 2047.0, 1023.0);
    return root * root;
}

// Material between two values, the value varying linearly.
struct Segment {
    extinction: f32,
    // Mean place, 0 to 1, and value there.
    place: f32,
    value: f32,
}

fn segment(ends: vec2<f32>, near: vec3<f32>, far: vec3<f32>) -> Segment {
    let rise = ends.y - ends.x;
    let is_flat = abs(rise) < FLAT;
    let per_rise = 1.0 / select(rise, 1.0, is_flat);
    let material = far.x - near.x;
    let moment = far.y - near.y;
    let extinction = select(material * per_rise, 0.5 * (near.z + far.z), is_flat);
    let none = abs(material) < NO_MATERIAL;
    let mean = moment / select(material, 1.0, none);
    let place = select(clamp((mean - ends.x) * per_rise, 0.0, 1.0), 0.5, is_flat || none);
    return Segment(max(extinction, 0.0), place, rise * place + ends.x);
}

// A pixel on its way through the planes: what it has, and its last four planes.
struct Pixel {
    // Sums on the planes, from the farthest back to the last; the interval is between the second and the third.
    sums: vec4<f32>,
    // Shares of the weights that lie on the lattice, and coverage, on the same planes.
    shares: vec4<f32>,
    coverage: vec4<f32>,
    // Differences across on the second, the third and the last plane, per world length.
    across_before: vec2<f32>,
    across: vec2<f32>,
    across_last: vec2<f32>,
    // Slopes of the ray per depth.
    ray: vec2<f32>,
    color: vec3<f32>,
    transmittance: f32,
    depth_sum: f32,
}

// Slope per interval, at u between the second and the third of four values.
fn depth_slope(v: vec4<f32>, u: f32, sharpness: f32) -> f32 {
    let rise = v.z - v.y;
    let near = v.x - v.y - v.y + v.z;
    let far = v.y - v.z - v.z + v.w;
    let from_middle = u - 0.5;
    return (far - near) * (from_middle * from_middle * 0.5 - sharpness) + (from_middle * (near + far) * 0.5 + rise);
}

// Diffuse and specular factor of a gradient, camera space, per world length.
fn phong(gradient: vec3<f32>) -> vec2<f32> {
    let squared = max(dot(gradient, gradient) * frame.voxel * frame.voxel, LEAST_SQUARED);
    let surface = squared / (squared + frame.floor_squared);
    let inverse = frame.voxel / sqrt(squared);
    let facing = min(abs(dot(gradient, frame.towards_light)) * inverse, 1.0);
    let diffuse = (surface * (facing - 1.0) + 1.0) * frame.diffuse + frame.ambient;
    if frame.specular == 0.0 {
        return vec2(diffuse, 0.0);
    }
    let shining = min(abs(dot(gradient, frame.half_way)) * inverse, 1.0);
    let gloss = exp2(max(log2(max(shining, 1e-30)) * frame.power, LEAST_EXPONENT));
    return vec2(diffuse, gloss * surface * frame.specular);
}

fn gradient_at(pixel: ptr<function, Pixel>, values: vec4<f32>, place: f32, sharpness: f32) -> vec3<f32> {
    let across = mix((*pixel).across_before, (*pixel).across, place);
    let slope = depth_slope(values, place, sharpness);
    return vec3(across, slope / frame.spacing - dot((*pixel).ray, across));
}

// Composites the interval between planes `near` and `near + 1`.
fn shade(pixel: ptr<function, Pixel>, near: u32) {
    let sums = (*pixel).sums;
    let untouched = sums.y == 0.0 && sums.z == 0.0;
    if (*pixel).transmittance < frame.termination || (untouched && frame.shows_background == 0u) {
        return;
    }
    let per_share = 1.0 / max((*pixel).shares.yyzz, vec4(0.15));
    let values = sums * per_share + frame.background;
    let ends = values.yz;
    let low = min(ends.x, ends.y);
    let high = max(ends.x, ends.y);
    let middle = 0.5 * (ends.x + ends.y) + 0.0625 * ((ends.y - values.x) - (values.w - ends.x));
    if max(high, middle) < frame.hull.x || min(low, middle) > frame.hull.y {
        return;
    }
    let covered_near = (*pixel).coverage.y;
    let covered_far = (*pixel).coverage.z;
    let covered = 0.5 * (covered_near + covered_far);
    let length = sqrt(dot((*pixel).ray, (*pixel).ray) + 1.0) * frame.spacing;
    let near_class = classify(ends.x);
    let far_class = classify(ends.y);
    let whole = segment(ends, near_class, far_class);
    let optical_depth = whole.extinction * covered * length;
    let bulges = middle > high || middle < low;
    let middle_matters = bulges && (frame.densest * frame.spacing > DENSE || optical_depth == 0.0);
    var opacities = vec2(0.0);
    var places = vec2(whole.place);
    var shown = vec2(whole.value);
    var through = exp2(-LOG2_E * optical_depth);
    opacities.x = 1.0 - through;
    if optical_depth > THICK || middle_matters {
        let middle_class = classify(middle);
        let front = segment(vec2(ends.x, middle), near_class, middle_class);
        let back = segment(vec2(middle, ends.y), middle_class, far_class);
        let half_length = -0.5 * LOG2_E * length;
        let through_front = exp2(max(front.extinction * 0.5 * (covered_near + covered) * half_length, LEAST_EXPONENT));
        let through_back = exp2(max(back.extinction * 0.5 * (covered + covered_far) * half_length, LEAST_EXPONENT));
        through = through_front * through_back;
        opacities = vec2(1.0 - through_front, through_front * (1.0 - through_back));
        places = vec2(front.place * 0.5, back.place * 0.5 + 0.5);
        shown = vec2(front.value, back.value);
    }
    let opacity = 1.0 - through;
    if opacity <= 0.0 {
        return;
    }
    var color = color_of(shown.x) * opacities.x;
    var behind = 0.0;
    if opacities.y > 0.0 {
        color += color_of(shown.y) * opacities.y;
        behind = opacities.y / (opacities.x + opacities.y);
    }
    let place = mix(places.x, places.y, behind);
    if frame.lit != 0u {
        let width = 2.0 / (sheets[near].scale * frame.spacing);
        let sharpness = max((1.0 - width * width) / 24.0, SOFTEST);
        var light = phong(gradient_at(pixel, values, places.x, sharpness));
        if opacities.y > 0.0 {
            light = mix(light, phong(gradient_at(pixel, values, places.y, sharpness)), behind);
        }
        color = color * light.x + light.y * opacity;
    }
    let before = (*pixel).transmittance;
    (*pixel).color += before * color;
    (*pixel).depth_sum += before * opacity * (place * frame.spacing + sheets[near].depth);
    (*pixel).transmittance = before * through;
}
