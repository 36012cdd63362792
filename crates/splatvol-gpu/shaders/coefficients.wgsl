// Coefficients: sums of a field.

// `S` over the sum of all weights.
fn sum_at(place: Place) -> f32 {
    let slot = slot_of(place.cell);
    if !slot.exists {
        return 0.0;
    }
    let x = weights(place.within.x);
    let y = weights(place.within.y);
    let z = weights(place.within.z);
    return sum_of_slot(slot, 0, x, y, z) / (x.sum * y.sum * z.sum);
}

fn sums_at(place: Place) -> vec4<f32> {
    return vec4(sum_at(place), 0.0, 0.0, 0.0);
}

// `S` over the sum of all weights, low-passed.
fn sum_on(sheet: u32, offset: vec2<f32>) -> f32 {
    return sums_on(sheet, offset).x;
}
