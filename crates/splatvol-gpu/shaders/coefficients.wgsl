// Coefficients: sums of a field. The atlas' second channel, if samples are missing, has ones in their places.

// `S` and, of missing samples, `M = sum_k h(x - k)`, over the sum of all weights.
fn sums_at(place: Place) -> vec4<f32> {
    let slot = slot_of(place.cell);
    if !slot.exists {
        return vec4(0.0);
    }
    let x = weights(place.within.x);
    let y = weights(place.within.y);
    let z = weights(place.within.z);
    var sums = vec2(sum_of_slot(slot, 0, x, y, z), 0.0);
    if HAS_HOLES {
        sums.y = sum_of_slot(slot, 1, x, y, z);
    }
    return vec4(sums / (x.sum * y.sum * z.sum), 0.0, 0.0);
}
