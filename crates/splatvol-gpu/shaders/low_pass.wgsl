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

// Sums over all weights at an offset in pixels from the principal point, low-passed across the plane.
fn sums_on(sheet: u32, offset: vec2<f32>) -> vec4<f32> {
    let count = i32(sheets[sheet].low_pass_points);
    var sums = vec4(0.0);
    var all = 0.0;
    for (var y = 0; y < count; y++) {
        let down = low_pass_point(y, count);
        for (var x = 0; x < count; x++) {
            let across = low_pass_point(x, count);
            let weight = across.y * down.y;
            sums += weight * sums_at(place_on(sheet, offset + sheets[sheet].low_pass * vec2(across.x, down.x)));
            all += weight;
        }
    }
    return sums / all;
}
