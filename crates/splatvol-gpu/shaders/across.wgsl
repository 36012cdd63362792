// Across: values of a plane are exchanged in workgroup memory, for differences across the ray.

// Two planes in turn.
var<workgroup> values: array<f32, 2u * POINTS>;

fn exchange(sheet: u32, plane: u32, corner: vec2<u32>, thread: u32, is_filled: bool) {
    if is_filled {
        let middle = vec2<f32>(corner) - 0.5 - frame.principal;
        for (var point = thread; point < POINTS; point += 256u) {
            let offset = middle + vec2<f32>(vec2(point % PITCH, point / PITCH));
            values[plane + point] = sum_on(sheet, offset);
        }
    }
    workgroupBarrier();
}

// Differences across at a point, per world length.
fn across_on(sheet: u32, place: Place, point: u32) -> vec2<f32> {
    if is_eye(sheet) {
        return (frame.gradient_from_lattice * jet_at(place).slope).xy;
    }
    let across = vec2(values[point + 1u] - values[point - 1u], values[point + PITCH] - values[point - PITCH]);
    return 0.5 * sheets[sheet].scale * across;
}
