// Beside: values on four planes beside missing samples; `splatvol_cpu::sheets::holes::beside_of`.

// Coverage where no weight is left is this far below zero.
const BELOW: f32 = 0.01 / 0.98;

// Means of four planes, given sums over shares and the missing weights over shares. A plane with hardly any weight takes
// values continued from the others.
fn values_beside(sums: vec4<f32>, missing: vec4<f32>) -> vec4<f32> {
    let left = 1.0 - missing;
    let means = sums / max(left, vec4(0.01));
    let near = select(means.y, means.z, left.y < min(0.15, left.z));
    let far = select(means.z, means.y, left.z < min(0.15, left.y));
    return vec4(
        select(means.x, near * 2.0 - far, left.x < 0.15),
        near,
        far,
        select(means.w, far * 2.0 - near, left.w < 0.15),
    );
}

// Coverage for the share of the weight that is left, given that for the whole.
fn covered_by(border: f32, left: f32) -> f32 {
    return max(border * left - (1.0 - left) * BELOW, 0.0);
}
