// Environment mapping. Operands: share; then the picture.
fn environment_map(sample: SheetSample, appearance: ptr<function, Appearance>, at: u32) {
    let normal = (*appearance).normal;
    let direction = 2.0 * dot(normal, sample.view) * normal - sample.view;
    let place = vec2(0.5 + turns_of(direction.xy), acos(clamp(direction.z, -1.0, 1.0)) * 0.31830989);
    (*appearance).reflection = picture_at(at + 1u, place).xyz;
    (*appearance).reflectance = operand(at).x * (*appearance).surfaceness;
}
