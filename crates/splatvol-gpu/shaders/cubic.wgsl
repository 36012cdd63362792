// Cubic: the value between two planes, and what a ray keeps of it; `splatvol_cpu::sheets::{cubic, intensity}`, line by line,
// for one pixel.

// What is kept: 0 the largest value, 1 the smallest, 2 the mean.
override KEEPS: u32 = 0u;

fn at_place(cubic: vec4<f32>, u: f32) -> f32 {
    return ((cubic.w * u + cubic.z) * u + cubic.y) * u + cubic.x;
}

// The cubic through two values with these slopes.
fn cubic_through(ends: vec2<f32>, slopes: vec2<f32>) -> vec4<f32> {
    let rise = ends.y - ends.x;
    return vec4(ends.x, slopes.x, rise * 3.0 - slopes.x * 2.0 - slopes.y, slopes.x + slopes.y - rise * 2.0);
}

// Place of the local maximum; -1 where there is none.
fn summit(cubic: vec4<f32>) -> f32 {
    let square = cubic.z * cubic.z - cubic.y * cubic.w * 3.0;
    if square <= 0.0 {
        return -1.0;
    }
    let root = sqrt(square);
    // Two forms of the same: neither takes a difference of alike numbers.
    let above = select(cubic.y, cubic.z + root, cubic.z > 0.0);
    let below = select(root - cubic.z, -3.0 * cubic.w, cubic.z > 0.0);
    if abs(below) < 1e-30 {
        return -1.0;
    }
    return above / below;
}

fn parabola_at(parabola: vec3<f32>, u: f32) -> f32 {
    return (parabola.z * u + parabola.y) * u + parabola.x;
}

// Coverage through values at both ends and in the middle.
fn parabola_through(start: f32, middle: f32, end: f32) -> vec3<f32> {
    let bend = (start + end) * 2.0 - middle * 4.0;
    return vec3(start, end - start - bend, bend);
}

// Places at which coverage is a half; -1 where there are none.
fn half_covered(parabola: vec3<f32>) -> vec2<f32> {
    let above = parabola.x - 0.5;
    let square = parabola.y * parabola.y - parabola.z * above * 4.0;
    if square < 0.0 {
        return vec2(-1.0);
    }
    let root = sqrt(square);
    let sum = (parabola.y + select(root, -root, parabola.y < 0.0)) * -0.5;
    let is_line = abs(parabola.z) < 1e-30;
    let is_level = abs(sum) < 1e-30;
    return vec2(
        select(sum / select(parabola.z, 1.0, is_line), -1.0, is_line),
        select(above / select(sum, 1.0, is_level), -1.0, is_level),
    );
}

// The largest value where coverage is a half or more, and where; a value of -1 where coverage is less everywhere.
fn largest_covered(cubic: vec4<f32>, coverage: vec3<f32>) -> vec2<f32> {
    let crossings = half_covered(coverage);
    var best = vec2(-1.0, 0.0);
    for (var i = 0; i < 5; i++) {
        var u = f32(i);
        if i == 2 {
            u = summit(cubic);
        } else if i > 2 {
            u = select(crossings.x, crossings.y, i == 4);
        }
        let value = at_place(cubic, u);
        let is_covered = i > 2 || parabola_at(coverage, u) >= 0.5;
        if u >= 0.0 && u <= 1.0 && is_covered && value > best.x {
            best = vec2(value, u);
        }
    }
    return best;
}

// Merges a value's rank: values are above 0 and below 2.
fn extreme(ink: Ink, values: vec4<f32>, coverage: vec3<f32>, depth: f32) -> Ink {
    var ranks = values;
    var least = max(frame.hull.x, 0.0);
    if KEEPS == 1u {
        ranks = vec4(2.0 - values.x, -values.yzw);
        least = max(2.0 - frame.hull.y, 0.0);
    }
    let found = largest_covered(ranks, coverage);
    if found.x > max(ink.color.x, least) {
        return Ink(vec3(found.x, 0.0, 0.0), ink.transmittance, found.y * frame.spacing + depth);
    }
    return ink;
}

fn most_covered(p: vec3<f32>) -> f32 {
    let ends = max(p.x, p.x + p.y + p.z);
    if p.z >= 0.0 {
        return ends;
    }
    let u = p.y / (-2.0 * p.z);
    return select(ends, parabola_at(p, u), u > 0.0 && u < 1.0);
}

// Adds integrals of coverage, and of value and place times coverage.
fn mean(ink: Ink, c: vec4<f32>, p: vec3<f32>, depth: f32) -> Ink {
    let plain = dot(c, vec4(1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0));
    let once = dot(c, vec4(1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0));
    let twice = dot(c, vec4(1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0, 1.0 / 6.0));
    let covered = dot(p, vec3(1.0, 1.0 / 2.0, 1.0 / 3.0));
    let place = dot(p, vec3(1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0));
    let sums = ink.color.xy + vec2(dot(p, vec3(plain, once, twice)), covered);
    let most = max(ink.color.z, most_covered(p));
    return Ink(vec3(sums, most), ink.transmittance, ink.depth_sum + place * frame.spacing + covered * depth);
}

// What a ray keeps, with an interval.
fn kept(ink: Ink, values: vec4<f32>, coverage: vec3<f32>, depth: f32) -> Ink {
    if KEEPS == 2u {
        return mean(ink, values, coverage, depth);
    }
    return extreme(ink, values, coverage, depth);
}

// Value that is shown, and its depth; depth 0 where there is none.
fn settled(ink: Ink) -> vec2<f32> {
    if KEEPS == 2u {
        if ink.color.z < 0.5 {
            return vec2(0.0);
        }
        return vec2(ink.color.x, ink.depth_sum) / ink.color.y;
    }
    return vec2(select(ink.color.x, 2.0 - ink.color.x, KEEPS == 1u), ink.depth_sum);
}

// Extinction and linear colour of a value.
fn look_of(value: f32) -> vec4<f32> {
    let position = node_position(value);
    let cell = u32(position);
    let share = position - floor(position);
    let a = nodes[2u * cell + 1u];
    let b = nodes[2u * cell + 3u];
    let extinction = mix(a.x, b.x, share);
    let emission = mix(a.x * a.yzw, b.x * b.yzw, share);
    return vec4(extinction, emission / select(extinction, 1.0, extinction <= 0.0));
}

// Replaces what a ray kept by its colour, with the opacity of the unit distance.
fn settle_at(at: vec2<u32>) {
    let index = at.y * frame.size.x + at.x;
    let found = settled(Ink(colors[index].rgb, 1.0, depths[index]));
    var color = vec4(0.0, 0.0, 0.0, 1.0);
    if found.y > 0.0 {
        let look = look_of(found.x);
        let through = exp2(-LOG2_E * look.x * frame.unit_distance);
        color = vec4(look.yzw * (1.0 - through), through);
    }
    colors[index] = color;
    depths[index] = found.y * (1.0 - color.a);
}
