// Operators: what they are given, in the world's axes and the data's units, and their numbers. The list of an item's operators,
// which is made for it, is `apply_operators`.
//
// Behind the isosurfaces `effects` has three rows from camera to world; the value at 0 and the difference from there to 1; the
// place of each operator's numbers; and these.

// A number of an operator.
fn operand(at: u32) -> vec4<f32> {
    return effects[at];
}

// Applies the operators to an appearance in camera space.
fn operate(seen: Seen, appearance: ptr<function, Appearance>) {
    let base = frame.first_isosurface + 2u * frame.isosurfaces;
    let place = transpose(mat3x4(effects[base], effects[base + 1u], effects[base + 2u]));
    let world_from_camera = mat3x3(place[0], place[1], place[2]);
    let units = effects[base + 3u];
    let sample = SheetSample(
        units.x + seen.value * units.y,
        world_from_camera * (seen.gradient * units.y),
        world_from_camera * seen.place + place[3],
        world_from_camera * -normalize(seen.ray),
        seen.place.z,
    );
    (*appearance).normal = world_from_camera * (*appearance).normal;
    apply_operators(sample, appearance, base);
    (*appearance).normal = transpose(world_from_camera) * (*appearance).normal;
}
