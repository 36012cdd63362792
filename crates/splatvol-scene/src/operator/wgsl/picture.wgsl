// A picture, bilinear; the origin at the top left, 0 to 1 to the other sides. Operands: columns, rows, whether it wraps
// around from side to side; then pixels, row by row.
fn picture_at(at: u32, place: vec2<f32>) -> vec4<f32> {
    let head = operand(at);
    let wraps = head.z != 0.0;
    let corner = place * head.xy - 0.5;
    let inside = clamp(corner, vec2(0.0), head.xy - 1.0);
    let offset = vec2(select(inside.x, corner.x, wraps), inside.y);
    let first = vec2<i32>(floor(offset));
    let share = offset - floor(offset);
    let size = vec2<i32>(head.xy);
    let left = (first.x % size.x + size.x) % size.x;
    let right = select(min(left + 1, size.x - 1), (left + 1) % size.x, wraps);
    let top = at + 1u + u32(first.y * size.x);
    let bottom = at + 1u + u32(min(first.y + 1, size.y - 1) * size.x);
    let above = mix(operand(top + u32(left)), operand(top + u32(right)), share.x);
    let below = mix(operand(bottom + u32(left)), operand(bottom + u32(right)), share.x);
    return mix(above, below, share.y);
}

// Full turns from +y towards +x; 0 on the axis.
fn turns_of(direction: vec2<f32>) -> f32 {
    let is_axis = all(direction == vec2(0.0));
    return atan2(direction.x, select(direction.y, 1.0, is_axis)) * 0.15915494;
}
