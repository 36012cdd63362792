// Exact values: one value of each ray, from sums with their gradients on two planes.

// Keeps what the ray needs of the interval between planes `near` and `near + 1`.
fn shade(pixel: ptr<function, Pixel>, near: u32) {
    if (*pixel).ink.transmittance < 0.0 || !any((*pixel).filled) {
        return;
    }
    let field = hermite(pixel);
    let offset = (*pixel).offset;
    let position = 0.5 * (position_on(near, offset) + position_on(near + 1u, offset));
    let middle = own_of(near, position, 0.5 * (sheets[near].low_pass + sheets[near + 1u].low_pass));
    var coverage = vec3(1.0, 0.0, 0.0);
    if min(min(field.own.x, field.own.y), middle) < 0.99 {
        coverage = parabola_through(coverage_from(field.own.x), coverage_from(middle), coverage_from(field.own.y));
    }
    (*pixel).ink = kept((*pixel).ink, field.cubic, coverage, sheets[near].depth);
}
