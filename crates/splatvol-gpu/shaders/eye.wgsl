// Eye: the plane at the eye of a camera within the volume, where all rays begin at one point, as `splatvol_cpu::sheets::eye`.

override FROM_EYE: bool = false;

fn is_eye(sheet: u32) -> bool {
    return FROM_EYE && sheets[sheet].scale == 0.0;
}

// Sums on the planes around an interval; before the eye, those of the cubic with the sums at the eye and on the two planes
// in front of it, and the slope at the eye.
fn sums_around(near: u32, offset: vec2<f32>, sums: vec4<f32>) -> vec4<f32> {
    if !is_eye(near) {
        return sums;
    }
    let gradient = frame.gradient_from_lattice * jet_at(place_on(near, vec2(0.0))).slope;
    let slope = frame.spacing * dot(gradient, vec3(offset * frame.per_pixel, 1.0));
    return vec4(3.0 * (sums.z - slope) - 0.5 * (3.0 * sums.y + sums.w), sums.yzw);
}
