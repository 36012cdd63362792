// Bump mapping. Operands: centre and top; inverse of the extent, height; then the slopes of the picture.
fn bump_map(sample: SheetSample, appearance: ptr<function, Appearance>, at: u32) {
    let middle = operand(at);
    let scale = operand(at + 1u);
    let out = sample.position.xy - middle.xy;
    let squared = dot(out, out);
    let v = (middle.w - sample.position.z) * scale.x;
    if squared <= 0.0 || v < 0.0 || v > 1.0 {
        return;
    }
    let per = picture_at(at + 2u, vec2(0.5 - turns_of(out), v)).xy;
    let around = vec2(-out.y, out.x) * 0.15915494 / squared;
    let slope = scale.y * vec3(per.x * around, -per.y * scale.x);
    let normal = (*appearance).normal;
    let bent = normal - (slope - normal * dot(slope, normal));
    (*appearance).normal = select(normal, normalize(bent), dot(bent, bent) > 1e-30);
}
