// Low-pass: sums on a plane, convolved with a Gaussian across it.

// Quadrature for the low-pass across a plane: a point's place along an axis, standard deviations, and its weight. Three and
// five points are those of Gauss and Hermite; more lie at equal distances.
fn low_pass_point(i: i32, count: i32) -> vec2<f32> {
    let from_middle = i - count / 2;
    let side = f32(sign(from_middle));
    if count == 3 {
        return vec2(side * 1.7320508, select(1.0, 0.25, from_middle != 0));
    }
    if count == 5 {
        let is_outer = abs(from_middle) == 2;
        let weight = select(0.22207592, 0.01125741, is_outer);
        return vec2(side * select(1.3556262, 2.8569700, is_outer), select(0.53333333, weight, from_middle != 0));
    }
    let place = select(3.0 * f32(from_middle) / f32(count / 2), 0.0, count == 1);
    return vec2(place, exp2(-0.72134752 * place * place));
}

// A point of the same along both axes, of `count` squared: its place, and its weight.
fn low_pass_points(i: i32, count: i32) -> vec3<f32> {
    let across = low_pass_point(i % count, count);
    let down = low_pass_point(i / count, count);
    return vec3(across.x, down.x, across.y * down.y);
}

// Whether a plane has a low-pass.
override HAS_LOW_PASS: bool = true;

// Sums over all weights at an offset in pixels from the principal point, low-passed across the plane.
fn sums_on(sheet: u32, offset: vec2<f32>) -> vec4<f32> {
    if !HAS_LOW_PASS {
        return sums_at(place_on(sheet, offset));
    }
    let count = i32(sheets[sheet].low_pass_points);
    var sums = vec4(0.0);
    var all = 0.0;
    for (var i = 0; i < count * count; i++) {
        let point = low_pass_points(i, count);
        sums += point.z * sums_at(place_on(sheet, offset + sheets[sheet].low_pass * point.xy));
        all += point.z;
    }
    return sums / all;
}
