// Analytic: intervals between planes are classified, lit by the field's own gradients and composited, in up to eight
// pieces; `splatvol_cpu::sheets::{analytic, fine_table}`, line by line, for one pixel.

// Rise, in cells, below which the mean of both ends is used.
const FLAT: f32 = 2.0;
// Optical depth below which the front's advantage is a series: the difference would cancel.
const THIN: f32 = 0.3;
// Spreads of five samples of a cubic by which it may leave their range.
const OVERSHOOT: f32 = 0.125;
const MOST_PIECES: f32 = 8.0;

// A value's classification.
struct Point {
    // Cells.
    position: f32,
    // Of extinction, and of emission.
    integrals: vec4<f32>,
    extinction: f32,
    color: vec3<f32>,
}

fn classify(value: f32) -> Point {
    let position = node_position(value);
    let cell = u32(position);
    let share = position - floor(position);
    let integrals = mix(nodes[2u * cell], nodes[2u * cell + 2u], share);
    let own = mix(nodes[2u * cell + 1u], nodes[2u * cell + 3u], share);
    return Point(position, integrals, own.x, own.yzw);
}

// Material between two values, the value varying linearly.
struct Segment {
    extinction: f32,
    // Mean place, 0 to 1.
    place: f32,
    color: vec3<f32>,
    // Half of the colour at the first value less that at the second.
    half_step: vec3<f32>,
}

// Centroid of the material between two ends, for an extinction that varies linearly; if that is zero at one end, only the
// part from where it begins counts.
fn centroid(a: f32, b: f32, mean: f32) -> f32 {
    let a_none = a <= 0.0;
    let b_none = b <= 0.0;
    if a_none && b_none {
        return 0.5;
    }
    let edge = min(2.0 * mean / (a + b), 1.0) / 3.0;
    return select(select((a + 2.0 * b) / (3.0 * (a + b)), edge, b_none), 1.0 - edge, a_none);
}

fn segment(a: Point, b: Point) -> Segment {
    let rise = b.position - a.position;
    let is_flat = abs(rise) < FLAT;
    let per_rise = NODES_PER_VALUE / select(rise, 1.0, is_flat);
    let ends = vec4(a.extinction + b.extinction, a.extinction * a.color + b.extinction * b.color);
    let means = max(select((b.integrals - a.integrals) * per_rise, 0.5 * ends, vec4(is_flat)), vec4(0.0));
    let extinction = means.x;
    let color = means.yzw / select(extinction, 1.0, extinction <= 0.0);
    return Segment(extinction, centroid(a.extinction, b.extinction, extinction), color, 0.5 * (a.color - b.color));
}

// Extra weight of the front over the back, since the front is attenuated less.
fn advantage(tau: f32, through: f32, opacity: f32) -> f32 {
    if tau < THIN {
        return tau * tau / 6.0 * (1.0 - tau * (0.5 - tau * 0.15));
    }
    return 1.0 + through - opacity * 2.0 / tau;
}

// Opacity without the rounding of one less its complement.
fn opacity_of(tau: f32, through: f32) -> f32 {
    if tau < 0.05 {
        return tau * (1.0 - tau * (0.5 - tau * (1.0 / 6.0 - tau / 24.0)));
    }
    return 1.0 - through;
}

// Gradient of S, camera space, per world length.
fn gradient_along(field: Hermite, u: f32) -> vec3<f32> {
    let c = field.cubic;
    let slope = (c.w * u * 3.0 + c.z * 2.0) * u + c.y;
    let along = (slope * mix(field.shares.x, field.shares.y, u) + cubic_at(c, u) * mix(field.falls.x, field.falls.y, u))
        / frame.spacing;
    let linear = mix(field.near_slope, field.far_slope, u);
    let missing = (along - dot(field.ray, linear)) / dot(field.ray, field.ray);
    return missing * field.ray + linear;
}

// Composites the interval between planes `near` and `near + 1`.
fn shade(pixel: ptr<function, Pixel>, near: u32) {
    let is_untouched = (*pixel).near.sum == 0.0 && (*pixel).far.sum == 0.0;
    if (*pixel).ink.transmittance < frame.termination || (is_untouched && frame.shows_background == 0u) {
        return;
    }
    let field = hermite(pixel);
    if max(field.own.x, field.own.y) <= 0.01 {
        return;
    }
    let quarters = vec3(cubic_at(field.cubic, 0.25), cubic_at(field.cubic, 0.5), cubic_at(field.cubic, 0.75));
    let start_value = field.cubic.x;
    let end_value = cubic_at(field.cubic, 1.0);
    let low = min(min(min(start_value, end_value), quarters.x), min(quarters.y, quarters.z));
    let high = max(max(max(start_value, end_value), quarters.x), max(quarters.y, quarters.z));
    let slack = (high - low) * OVERSHOOT;
    if high + slack < frame.hull.x || low - slack > frame.hull.y {
        return;
    }
    let bend = max(
        max(abs(start_value - 2.0 * quarters.x + quarters.y), abs(quarters.x - 2.0 * quarters.y + quarters.z)),
        abs(quarters.y - 2.0 * quarters.z + end_value),
    );
    let length = sqrt(dot(field.ray, field.ray)) * frame.spacing;
    var front = classify(start_value);
    let whole = segment(front, classify(end_value)).extinction * length;
    let squared = max(bend * 8192.0, whole * 4.0);
    let count = clamp(ceil(sqrt(squared)), 1.0, MOST_PIECES);
    let share = 1.0 / count;
    var through = 1.0;
    for (var piece = 0.0; piece < count; piece += 1.0) {
        let start = share * piece;
        let back = classify(cubic_at(field.cubic, min(start + share, 1.0)));
        let material = segment(front, back);
        front = back;
        let tau = material.extinction * coverage_along(field, start + 0.5 * share) * length * share;
        if tau <= 0.0 {
            continue;
        }
        let u = material.place * share + start;
        let left = exp2(max(-LOG2_E * tau, LEAST_EXPONENT));
        let opacity = opacity_of(tau, left);
        var light = vec2(1.0, 0.0);
        if frame.lit != 0u {
            light = phong(gradient_along(field, u));
        }
        let visible = (*pixel).ink.transmittance * through * opacity;
        let in_front = (*pixel).ink.transmittance * through * advantage(tau, left, opacity) * light.x;
        (*pixel).ink.color += (material.color * light.x + light.y) * visible + material.half_step * in_front;
        (*pixel).ink.depth_sum += (u * frame.spacing + sheets[near].depth) * visible;
        through *= left;
    }
    (*pixel).ink.transmittance *= through;
}
