// Values: one value of each ray, from sums on four planes.

const LAG: u32 = 2u;
const LEAD: u32 = LAG;
const FADED: f32 = 0.15;

// A pixel on its way through the planes.
struct Pixel {
    // On the last four planes.
    sums: vec4<f32>,
    // Weights of missing samples.
    missing: vec4<f32>,
    shares: vec4<f32>,
    coverage: vec4<f32>,
    filled: vec4<bool>,
    // From the principal point, pixels.
    offset: vec2<f32>,
    ink: Ink,
}

fn fresh(offset: vec2<f32>, ink: Ink) -> Pixel {
    return Pixel(vec4(0.0), vec4(0.0), vec4(1.0), vec4(1.0), vec4(false), offset, ink);
}

// Pixels need no neighbours.
fn exchange(sheet: u32, plane: u32, corner: vec2<u32>, thread: vec2<u32>, is_filled: bool) {}

// Takes a plane's value at a pixel.
fn enter(pixel: ptr<function, Pixel>, sheet: u32, point: u32, is_filled: bool) {
    let place = place_on(sheet, (*pixel).offset);
    var sums = vec4(0.0);
    if is_filled {
        sums = sums_on(sheet, (*pixel).offset);
    }
    (*pixel).sums = vec4((*pixel).sums.yzw, sums.x);
    (*pixel).missing = vec4((*pixel).missing.yzw, sums.y);
    (*pixel).shares = vec4((*pixel).shares.yzw, share_at(place));
    (*pixel).coverage = vec4((*pixel).coverage.yzw, coverage_at(place));
    (*pixel).filled = vec4<bool>((*pixel).filled.yzw, is_filled);
}

fn coverage_between(near: u32, offset: vec2<f32>) -> f32 {
    let a = place_on(near, offset);
    let b = place_on(near + 1u, offset);
    let middle = 0.5 * (vec3<f32>(a.cell + b.cell) + a.within + b.within);
    return coverage_of(middle, vec3(frame.sigma));
}

// Coverage at the near end, in the middle and at the far end, for the shares of the weight left on four planes.
fn covered_along(border: vec3<f32>, left: vec4<f32>) -> vec3<f32> {
    let middle = clamp((left.y + left.z) * (9.0 / 16.0) - (left.x + left.w) * (1.0 / 16.0), 0.0, 1.0);
    return vec3(covered_by(border.x, left.y), covered_by(border.y, middle), covered_by(border.z, left.z));
}

// Keeps what the ray needs of the interval between planes `near` and `near + 1`.
fn shade(pixel: ptr<function, Pixel>, near: u32) {
    let filled = (*pixel).filled;
    if (*pixel).ink.transmittance < 0.0 || !(filled.y || filled.z) {
        return;
    }
    let shares = (*pixel).shares;
    var values = sums_around(near, (*pixel).offset, (*pixel).sums) / max(shares, vec4(FADED));
    // Planes too far outside have no value: the slope is that of the interval.
    let straight = vec2(values.y * 2.0 - values.z, values.z * 2.0 - values.y);
    values.x = select(values.x, straight.x, shares.x < FADED && !is_eye(near));
    values.w = select(values.w, straight.y, shares.w < FADED);
    let covered = (*pixel).coverage.yz;
    var along = vec3(covered.x, coverage_between(near, (*pixel).offset), covered.y);
    if HAS_HOLES && any((*pixel).missing != vec4(0.0)) {
        let around = missing_around(near, (*pixel).offset, (*pixel).missing);
        let missing = select(around / shares, vec4(0.0), shares < vec4(FADED));
        values = values_beside(values, missing);
        along = covered_along(along, 1.0 - missing);
    }
    values += frame.background;
    let slopes = 0.5 * (values.zw - values.xy);
    var coverage = vec3(1.0, 0.0, 0.0);
    if min(min(along.x, along.y), along.z) < 1.0 {
        coverage = parabola_through(along.x, along.y, along.z);
    }
    (*pixel).ink = kept((*pixel).ink, cubic_through(values.yz, slopes), coverage, sheets[near].depth);
}
