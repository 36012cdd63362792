// Gradient noise; see `gradient_noise` in Rust.

fn noise_hash(point: vec3<i32>, seed: u32) -> u32 {
    let x = u32(point.x) * 0x9e3779b1u;
    let y = u32(point.y) * 0x85ebca77u;
    let z = u32(point.z) * 0xc2b2ae3du;
    var h = seed ^ x ^ ((y << 11u) | (y >> 21u)) ^ ((z << 21u) | (z >> 11u));
    h = (h ^ (h >> 16u)) * 0x85ebca6bu;
    h = (h ^ (h >> 13u)) * 0xc2b2ae35u;
    return h ^ (h >> 16u);
}

// The twelve directions to the edges of a cube, four of them twice.
fn noise_slope(hash: u32, p: vec3<f32>) -> f32 {
    let h = hash & 15u;
    let u = select(p.y, p.x, h < 8u);
    let v = select(select(p.z, p.x, h == 12u || h == 14u), p.y, h < 4u);
    return select(-u, u, (h & 1u) == 0u) + select(-v, v, (h & 2u) == 0u);
}

fn noise_row(cell: vec3<i32>, seed: u32, t: vec3<f32>, fade: f32, beside: vec2<i32>) -> f32 {
    let first = vec3(0, beside);
    let second = vec3(1, beside);
    let a = noise_slope(noise_hash(cell + first, seed), t - vec3<f32>(first));
    let b = noise_slope(noise_hash(cell + second, seed), t - vec3<f32>(second));
    return a + (b - a) * fade;
}

fn gradient_noise(at: vec3<f32>, seed: u32) -> f32 {
    let p = clamp(at, vec3(-4e6), vec3(4e6));
    let cell = vec3<i32>(floor(p));
    let t = p - floor(p);
    let fade = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let near = mix(
        noise_row(cell, seed, t, fade.x, vec2(0, 0)),
        noise_row(cell, seed, t, fade.x, vec2(1, 0)),
        fade.y,
    );
    let far = mix(
        noise_row(cell, seed, t, fade.x, vec2(0, 1)),
        noise_row(cell, seed, t, fade.x, vec2(1, 1)),
        fade.y,
    );
    return mix(near, far, fade.z);
}

// Sum of octaves, each twice as fine and half as strong as the one before; of their amounts, if folded.
fn noise_octaves(at: vec3<f32>, count: u32, is_folded: bool) -> f32 {
    var p = at;
    var sum = 0.0;
    var strength = 1.0;
    for (var seed = 0u; seed < count; seed++) {
        let noise = gradient_noise(p, seed);
        sum += strength * select(noise, abs(noise), is_folded);
        strength *= 0.5;
        p *= 2.0;
    }
    return sum;
}
