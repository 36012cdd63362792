// Table: the material between two values, the value varying linearly (`splatvol_core::shade_table`).

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
    let root = vec3<f32>(vec3(bits >> 21u, (bits >> 10u) & 0x7ffu, bits & 0x3ffu)) / vec3(2047.0, 2047.0, 1023.0);
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
