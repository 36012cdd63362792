// Transfer functions of value and gradient magnitude.

// Weight of a region along an axis: centre, half width, and its fading.
fn side_weight(at: f32, side: vec3<f32>) -> f32 {
    let t = clamp((side.y - abs(at - side.x)) * side.z, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// Operands: count of regions; then of each the side of values and its extinction, the side of gradients, the colour.
fn regions_of_values(sample: SheetSample, appearance: ptr<function, Appearance>, at: u32) {
    let magnitude = length(sample.gradient);
    var color = vec3(0.0);
    var sum = 0.0;
    for (var i = 0u; i < u32(operand(at).x); i++) {
        let own = at + 1u + 3u * i;
        let values = operand(own);
        let weight = values.w * side_weight(sample.value, values.xyz) * side_weight(magnitude, operand(own + 1u).xyz);
        color += operand(own + 2u).xyz * weight;
        sum += weight;
    }
    (*appearance).color = color / max(sum, 1e-37);
    (*appearance).extinction = sum;
}

// Operands: ranges of values and of gradients; least transmittance of a unit distance, and the inverse of that distance;
// then the picture.
fn picture_of_values(sample: SheetSample, appearance: ptr<function, Appearance>, at: u32) {
    let ranges = operand(at);
    let unit = operand(at + 1u);
    let place = (vec2(sample.value, length(sample.gradient)) - ranges.xz) / (ranges.yw - ranges.xz);
    (*appearance).color = vec3(0.0);
    (*appearance).extinction = 0.0;
    if all(place >= vec2(0.0)) && all(place <= vec2(1.0)) {
        let pixel = picture_at(at + 2u, vec2(place.x, 1.0 - place.y));
        (*appearance).color = pixel.xyz / max(pixel.w, 1e-37);
        (*appearance).extinction = -log(max(1.0 - pixel.w, unit.x)) * unit.y;
    }
}
