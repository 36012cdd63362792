// Means: values of a mesh on planes, `v = S / W`.

// Least weight used as a divisor.
const LEAST_WEIGHT: f32 = 1e-6;
// Share of the weight below which a plane takes values continued from the others.
const FADED: f32 = 0.15;

fn value_of(sums: vec2<f32>) -> f32 {
    return sums.y / max(sums.x, LEAST_WEIGHT);
}

// Means on four planes, given the share of the weight that each has; one with hardly any takes values continued from the
// others.
fn continued(means: vec4<f32>, left: vec4<f32>) -> vec4<f32> {
    let near = select(means.y, means.z, left.y < min(FADED, left.z));
    let far = select(means.z, means.y, left.z < min(FADED, left.y));
    return vec4(
        select(means.x, near * 2.0 - far, left.x < FADED),
        near,
        far,
        select(means.w, far * 2.0 - near, left.w < FADED),
    );
}
