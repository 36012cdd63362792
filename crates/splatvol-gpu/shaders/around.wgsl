// Around: sums on the four planes around an interval, also where it begins at the eye.

// Sums on the planes around an interval; before the eye, those of the cubic with the sums at the eye and on the two planes
// in front of it, and the slope at the eye.
fn sums_around(near: u32, offset: vec2<f32>, sums: vec4<f32>) -> vec4<f32> {
    if !is_eye(near) {
        return sums;
    }
    return before_eye(near, offset, sums, jet_at(place_on(near, vec2(0.0)), 0).slope);
}

// The same for weights of missing samples.
fn missing_around(near: u32, offset: vec2<f32>, missing: vec4<f32>) -> vec4<f32> {
    if !HAS_HOLES || !is_eye(near) {
        return missing;
    }
    return before_eye(near, offset, missing, jet_at(place_on(near, vec2(0.0)), 1).slope);
}

// `slope`: at the eye, per voxel.
fn before_eye(near: u32, offset: vec2<f32>, sums: vec4<f32>, slope: vec3<f32>) -> vec4<f32> {
    let gradient = frame.gradient_from_lattice * slope;
    let along = frame.spacing * dot(gradient, vec3(offset * frame.per_pixel, 1.0));
    return vec4(3.0 * (sums.z - along) - 0.5 * (3.0 * sums.y + sums.w), sums.yzw);
}

// Slope at the eye of the sum over all coefficients, the missing ones being zero; per voxel.
fn slope_at(place: Place) -> vec3<f32> {
    var slope = jet_at(place, 0).slope;
    if HAS_HOLES {
        slope -= frame.background * jet_at(place, 1).slope;
    }
    return slope;
}
