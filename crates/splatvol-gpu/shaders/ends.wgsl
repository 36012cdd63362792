// Ends: sums with their gradients on the two planes of an interval, and the cubic Hermite polynomial between them
// (`splatvol_cpu::sheets::hermite`).

const LAG: u32 = 1u;
const LEAD: u32 = LAG;
// Shares below which values are those of the other plane.
const FADED: f32 = 0.15;
const LEAST_SHARE: f32 = 0.01;

// Sums on a plane; gradients in camera space, per world length.
struct End {
    sum: f32,
    // Share of the weights on the lattice, and of the low-passed kernel on the volume's own box.
    share: f32,
    own: f32,
    slope: vec3<f32>,
    share_slope: vec3<f32>,
    // Weight of missing samples, which the share lacks, and its gradient.
    missing: f32,
    missing_slope: vec3<f32>,
}

// A pixel on its way through the planes.
struct Pixel {
    near: End,
    far: End,
    // Whether the tile has something there.
    filled: vec2<bool>,
    // From the principal point, pixels.
    offset: vec2<f32>,
    ink: Ink,
}

fn fresh(offset: vec2<f32>, ink: Ink) -> Pixel {
    let nothing = End(0.0, 1.0, select(1.0, 0.0, frame.shows_background != 0u), vec3(0.0), vec3(0.0), 0.0, vec3(0.0));
    return Pixel(nothing, nothing, vec2(false), offset, ink);
}

// A low-pass that is narrow against the kernel takes whole pixels: their sums and slopes are exchanged in workgroup memory.
const REACH: u32 = 3u;
const JET_PITCH: u32 = TILE_WIDTH + 2u * REACH;
const JETS: u32 = JET_PITCH * (TILE_HEIGHT + 2u * REACH);

var<workgroup> jets: array<vec4<f32>, JETS>;
// The same, low-passed along x.
const ROWS: u32 = TILE_WIDTH * (TILE_HEIGHT + 2u * REACH);
var<workgroup> jet_rows: array<vec4<f32>, ROWS>;

fn is_on_pixels(sheet: u32) -> bool {
    return HAS_LOW_PASS && !HAS_HOLES && sheets[sheet].low_pass_pixels.x > 0.0;
}

fn exchange(sheet: u32, plane: u32, corner: vec2<u32>, thread: vec2<u32>, is_filled: bool) {
    if !HAS_LOW_PASS || HAS_HOLES {
        return;
    }
    // All pixels have taken what they need of the plane before.
    workgroupBarrier();
    if is_filled && is_on_pixels(sheet) {
        let first = vec2<f32>(corner) + 0.5 - f32(REACH) - frame.principal;
        for (var point = thread.x; point < JETS; point += 256u) {
            let jet = jet_at(place_on(sheet, first + vec2<f32>(vec2(point % JET_PITCH, point / JET_PITCH))), 0);
            jets[point] = vec4(jet.sum, jet.slope);
        }
    }
    workgroupBarrier();
    if is_filled && is_on_pixels(sheet) {
        let w = sheets[sheet].low_pass_pixels;
        for (var i = thread.x; i < ROWS; i += 256u) {
            jet_rows[i] = row_of_jets(i / TILE_WIDTH * JET_PITCH + i % TILE_WIDTH + REACH, w);
        }
    }
    workgroupBarrier();
}

// A row of pixels, weighted around the middle one.
fn row_of_jets(middle: u32, w: vec4<f32>) -> vec4<f32> {
    return w.x * jets[middle] + w.y * (jets[middle - 1u] + jets[middle + 1u])
        + w.z * (jets[middle - 2u] + jets[middle + 2u]) + w.w * (jets[middle - 3u] + jets[middle + 3u]);
}

// Two rows at the same distance.
fn rows_beside(middle: u32, distance: u32) -> vec4<f32> {
    return jet_rows[middle - distance * TILE_WIDTH] + jet_rows[middle + distance * TILE_WIDTH];
}

// Sum and slope of a pixel, whose place in the tile is that of `point`.
fn jet_of_pixels(sheet: u32, point: u32) -> vec4<f32> {
    let own = point % POINTS;
    let middle = (own / PITCH - 1u + REACH) * TILE_WIDTH + own % PITCH - 1u;
    let w = sheets[sheet].low_pass_pixels;
    return w.x * jet_rows[middle] + w.y * rows_beside(middle, 1u) + w.z * rows_beside(middle, 2u) + w.w * rows_beside(middle, 3u);
}

// Share on the volume's own box of the kernel with a low-pass of this deviation, pixels.
fn own_of(sheet: u32, position: vec3<f32>, low_pass: f32) -> f32 {
    let own = sheets[sheet];
    let variance = low_pass * low_pass * (own.step_x * own.step_x + own.step_y * own.step_y);
    let sigma = sqrt(frame.sigma * frame.sigma + variance);
    let corner = (position - frame.margin + 0.5) / sigma;
    let size = frame.samples / sigma;
    return share_of_axis(corner.x, size.x) * share_of_axis(corner.y, size.y) * share_of_axis(corner.z, size.z);
}

// The same less the missing samples' part.
fn own_without(own: f32, share: f32, missing: f32) -> f32 {
    return own * (1.0 - min(missing / max(max(share, missing), 1e-30), 1.0));
}

fn position_on(sheet: u32, offset: vec2<f32>) -> vec3<f32> {
    let place = place_on(sheet, offset);
    return vec3<f32>(place.cell) + place.within;
}

// Sums with their gradients per voxel, low-passed.
fn add_sums(end: ptr<function, End>, sheet: u32, offset: vec2<f32>, count: i32) {
    var all = 0.0;
    for (var i = 0; i < count * count; i++) {
        let point = low_pass_points(i, count);
        let place = place_on(sheet, offset + sheets[sheet].low_pass * point.xy);
        let sum = jet_at(place, 0);
        (*end).sum += point.z * sum.sum;
        (*end).slope += point.z * sum.slope;
        if HAS_HOLES {
            let missing = jet_at(place, 1);
            (*end).missing += point.z * missing.sum;
            (*end).missing_slope += point.z * missing.slope;
        }
        all += point.z;
    }
    let per_weight = 1.0 / max(all, 1e-30);
    (*end).sum *= per_weight;
    (*end).slope *= per_weight;
    if HAS_HOLES {
        (*end).missing *= per_weight;
        (*end).missing_slope *= per_weight;
    }
}

// Shares of the weights, likewise.
fn add_shares(end: ptr<function, End>, sheet: u32, offset: vec2<f32>, count: i32) {
    var all = 0.0;
    for (var i = 0; i < count * count; i++) {
        let point = low_pass_points(i, count);
        let share = share_jet(place_on(sheet, offset + sheets[sheet].low_pass * point.xy));
        (*end).share += point.z * share.sum;
        (*end).share_slope += point.z * share.slope;
        all += point.z;
    }
    (*end).share /= all;
    (*end).share_slope /= all;
}

// Whether all weights around a place lie on the lattice, also those around the points of a narrow low-pass.
fn is_far_inside(place: Place) -> bool {
    return all(place.cell >= vec3(6)) && all(place.cell <= frame.dims - 8);
}

// Takes a plane's sums at a pixel.
fn enter(pixel: ptr<function, Pixel>, sheet: u32, point: u32, is_filled: bool) {
    (*pixel).near = (*pixel).far;
    let offset = (*pixel).offset;
    var end = End(0.0, 0.0, own_of(sheet, position_on(sheet, offset), sheets[sheet].low_pass), vec3(0.0), vec3(0.0), 0.0, vec3(0.0));
    var count = 1;
    if HAS_LOW_PASS {
        count = i32(sheets[sheet].low_pass_points);
    }
    let on_pixels = is_on_pixels(sheet);
    // No passes rather than a branch: devices that run both sides of it would take all points.
    add_sums(&end, sheet, offset, select(0, count, is_filled && !on_pixels));
    if is_filled && on_pixels {
        let jet = jet_of_pixels(sheet, point);
        end.sum = jet.x;
        end.slope = jet.yzw;
    }
    add_shares(&end, sheet, offset, select(count, 1, on_pixels && is_far_inside(place_on(sheet, offset))));
    end.slope = frame.gradient_from_lattice * end.slope;
    end.share_slope = frame.gradient_from_lattice * end.share_slope;
    if HAS_HOLES {
        end.missing_slope = frame.gradient_from_lattice * end.missing_slope;
        end.own = own_without(end.own, end.share, end.missing);
        end.share = max(end.share - end.missing, 0.0);
        end.share_slope -= end.missing_slope;
    }
    (*pixel).far = end;
    (*pixel).filled = vec2((*pixel).filled.y, is_filled);
}

// The field between the planes along a ray.
struct Hermite {
    // Coefficients of the value over u in 0..1.
    cubic: vec4<f32>,
    shares: vec2<f32>,
    // Slopes of the shares along the ray, per interval.
    falls: vec2<f32>,
    own: vec2<f32>,
    // Gradients of S.
    near_slope: vec3<f32>,
    far_slope: vec3<f32>,
    // Motion along the ray per depth.
    ray: vec3<f32>,
}

// Value and slope per interval at one end, given the other end's, which replace them where the end has hardly any share.
fn value_and_slope(end: End, other: End, ray: vec3<f32>) -> vec2<f32> {
    let per_share = 1.0 / max(end.share, LEAST_SHARE);
    let value = end.sum * per_share;
    let slope = (dot(ray, end.slope) - value * dot(ray, end.share_slope)) * per_share * frame.spacing;
    let is_faded = end.share < min(FADED, other.share);
    let beside = other.sum / max(other.share, LEAST_SHARE);
    return vec2(select(value, beside, is_faded) + frame.background, select(slope, 0.0, is_faded));
}

fn hermite(pixel: ptr<function, Pixel>) -> Hermite {
    let near = (*pixel).near;
    let far = (*pixel).far;
    let ray = vec3((*pixel).offset * frame.per_pixel, 1.0);
    let start = value_and_slope(near, far, ray);
    let end = value_and_slope(far, near, ray);
    let rise = end.x - start.x;
    return Hermite(
        vec4(start.x, start.y, rise * 3.0 - start.y * 2.0 - end.y, start.y + end.y - rise * 2.0),
        vec2(near.share, far.share),
        vec2(dot(ray, near.share_slope), dot(ray, far.share_slope)) * frame.spacing,
        vec2(near.own, far.own),
        near.slope + near.share_slope * frame.background,
        far.slope + far.share_slope * frame.background,
        ray,
    );
}

fn cubic_at(cubic: vec4<f32>, u: f32) -> f32 {
    return ((cubic.w * u + cubic.z) * u + cubic.y) * u + cubic.x;
}

fn coverage_from(own: f32) -> f32 {
    return clamp((own - 0.5) / 0.98 + 0.5, 0.0, 1.0);
}

fn coverage_along(field: Hermite, u: f32) -> f32 {
    return coverage_from(mix(field.own.x, field.own.y, u));
}
