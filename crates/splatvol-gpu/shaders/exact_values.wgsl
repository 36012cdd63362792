// Exact values: one value of each ray, from sums with their gradients on two planes.

// Weight of missing samples in the middle between the planes, by a cubic along the ray.
fn missing_between(pixel: ptr<function, Pixel>) -> f32 {
    let ray = vec3((*pixel).offset * frame.per_pixel, 1.0);
    let bend = dot(ray, (*pixel).near.missing_slope - (*pixel).far.missing_slope) * frame.spacing * 0.125;
    return max(0.5 * ((*pixel).near.missing + (*pixel).far.missing) + bend, 0.0);
}

// Keeps what the ray needs of the interval between planes `near` and `near + 1`.
fn shade(pixel: ptr<function, Pixel>, near: u32) {
    if (*pixel).ink.transmittance < 0.0 || !any((*pixel).filled) {
        return;
    }
    let field = hermite(pixel);
    let offset = (*pixel).offset;
    let position = 0.5 * (position_on(near, offset) + position_on(near + 1u, offset));
    var middle = own_of(near, position, 0.5 * (sheets[near].low_pass + sheets[near + 1u].low_pass));
    if HAS_HOLES && (*pixel).near.missing + (*pixel).far.missing > 0.0 {
        let cell = floor(position);
        let share = share_at(Place(vec3<i32>(cell), position - cell));
        middle = own_without(middle, share, missing_between(pixel));
    }
    var coverage = vec3(1.0, 0.0, 0.0);
    if min(min(field.own.x, field.own.y), middle) < 0.99 {
        coverage = parabola_through(coverage_from(field.own.x), coverage_from(middle), coverage_from(field.own.y));
    }
    (*pixel).ink = kept((*pixel).ink, field.cubic, coverage, sheets[near].depth);
}
