// Across: values of a plane are exchanged in workgroup memory, for differences across the ray. `thread`: its number, and a bit
// for each of its points that a pixel takes.

// Two planes in turn.
var<workgroup> values: array<f32, 2u * POINTS>;

fn exchange(sheet: u32, plane: u32, corner: vec2<u32>, thread: vec2<u32>, is_filled: bool) {
    if is_filled {
        let middle = vec2<f32>(corner) - 0.5 - frame.principal;
        for (var i = 0u; thread.x + i * 256u < POINTS; i++) {
            if ((thread.y >> i) & 1u) == 0u {
                continue;
            }
            let point = thread.x + i * 256u;
            let offset = middle + vec2<f32>(vec2(point % PITCH, point / PITCH));
            let sums = sums_on(sheet, offset);
            values[plane + point] = sums.x;
            keep_missing(plane + point, sums.y);
        }
    }
    workgroupBarrier();
}

// The sum over all coefficients, the missing ones being zero; light uses its gradient.
fn whole_at(point: u32) -> f32 {
    return values[point] - frame.background * missing_at(point);
}

// Differences across at a point, per world length.
fn across_on(sheet: u32, offset: vec2<f32>, point: u32) -> vec2<f32> {
    if is_eye(sheet) {
        return (frame.gradient_from_lattice * slope_at(place_on(sheet, offset))).xy;
    }
    let across = vec2(whole_at(point + 1u) - whole_at(point - 1u), whole_at(point + PITCH) - whole_at(point - PITCH));
    return 0.5 * sheets[sheet].scale * across;
}
