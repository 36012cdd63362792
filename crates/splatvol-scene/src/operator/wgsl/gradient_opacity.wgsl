// Gradient opacity. Operands: count of points, then each point's gradient and factor.
fn gradient_opacity(sample: SheetSample, appearance: ptr<function, Appearance>, at: u32) {
    let magnitude = length(sample.gradient);
    let count = u32(operand(at).x);
    var next = 0u;
    while next < count && operand(at + 1u + next).x <= magnitude {
        next++;
    }
    let after = operand(at + 1u + min(next, count - 1u)).xy;
    let before = operand(at + max(next, 1u)).xy;
    let width = after.x - before.x;
    let share = select(0.0, (magnitude - before.x) / max(width, 1e-37), width > 0.0);
    (*appearance).extinction *= before.y + (after.y - before.y) * share;
}
