// Field: `S = sum_k c_k h(x - k)` on a plane, in gather form (docs/numerics.md, "The field"). h is a product of Gaussians
// cut at `radius` along the voxel axes: TAPS values along each of them. Coefficients are those of needed voxels, less
// the background; others are zero.

@group(0) @binding(4) var atlas: texture_2d_array<f32>;
@group(0) @binding(5) var nearest: sampler;

// Voxels along an axis that a kernel meets: 4 or 6.
override TAPS: i32 = 4;
// Whether the kernel ends nearer than the outermost of them can be.
override IS_CUT: bool = true;

// A point of the lattice: the cell it is in, and its place there, 0 to 1.
struct Place {
    cell: vec3<i32>,
    within: vec3<f32>,
}

// Lattice place of a pixel's ray on a plane; `offset` in pixels from the principal point.
fn place_on(sheet: u32, offset: vec2<f32>) -> Place {
    let own = sheets[sheet];
    let from_cell = own.rest + offset.x * own.step_x + offset.y * own.step_y;
    let whole = floor(from_cell);
    return Place(own.cell + vec3<i32>(whole), from_cell - whole);
}

// Weights of the six voxels around a place along one axis, from two before its cell to three behind, relative to that of the
// cell's own voxel: all that is made of them are ratios. With four taps the outer ones are zero.
struct Weights {
    a: f32, b: f32, c: f32, d: f32, e: f32, f: f32,
    sum: f32,
}

// `h(t - k) / h(t) = exp(k t / sigma^2) exp(-k^2 / 2 sigma^2)`.
fn weights(t: f32) -> Weights {
    let ahead = exp2(frame.falls.x * t);
    let back = 1.0 / ahead;
    var w = Weights(0.0, frame.falls.y * back, 1.0, frame.falls.y * ahead, frame.falls.z * (ahead * ahead), 0.0, 0.0);
    if TAPS == 6 {
        w.a = frame.falls.z * (back * back);
        w.f = frame.falls.w * (ahead * ahead * ahead);
    }
    if IS_CUT {
        w.a = select(0.0, w.a, t + 2.0 <= frame.radius);
        w.b = select(0.0, w.b, t + 1.0 <= frame.radius);
        w.c = select(0.0, w.c, t <= frame.radius);
        w.d = select(0.0, w.d, 1.0 - t <= frame.radius);
        w.e = select(0.0, w.e, 2.0 - t <= frame.radius);
        w.f = select(0.0, w.f, 3.0 - t <= frame.radius);
    }
    w.sum = w.a + w.b + w.c + w.d + w.e + w.f;
    return w;
}

// Sum of the weights that lie on the lattice.
fn sum_inside(w: Weights, cell: i32, count: i32) -> f32 {
    let is_inside = (vec3(cell - 2, cell - 1, cell) >= vec3(0)) & (vec3(cell - 2, cell - 1, cell) < vec3(count));
    let is_behind = (vec3(cell + 1, cell + 2, cell + 3) >= vec3(0)) & (vec3(cell + 1, cell + 2, cell + 3) < vec3(count));
    let before = select(vec3(0.0), vec3(w.a, w.b, w.c), is_inside);
    let behind = select(vec3(0.0), vec3(w.d, w.e, w.f), is_behind);
    return dot(before + behind, vec3(1.0));
}

// Two rows of two texels around a corner of texels, weighted along x.
fn two_rows(corner: vec2<f32>, layer: i32, before: f32, behind: f32) -> vec2<f32> {
    let four = textureGather(0, atlas, nearest, corner * frame.per_texel, layer);
    return vec2(before * four.w + behind * four.z, before * four.x + behind * four.y);
}

// Two rows of a slice of a slot.
fn rows(corner: vec2<f32>, layer: i32, x: Weights) -> vec2<f32> {
    if TAPS == 6 {
        return two_rows(corner, layer, x.a, x.b)
            + two_rows(corner + vec2(2.0, 0.0), layer, x.c, x.d)
            + two_rows(corner + vec2(4.0, 0.0), layer, x.e, x.f);
    }
    return two_rows(corner, layer, x.b, x.c) + two_rows(corner + vec2(2.0, 0.0), layer, x.d, x.e);
}

// A slice of a slot, weighted along x and y.
fn slice(corner: vec2<f32>, layer: i32, x: Weights, y: Weights) -> f32 {
    if TAPS == 6 {
        return dot(rows(corner, layer, x), vec2(y.a, y.b))
            + dot(rows(corner + vec2(0.0, 2.0), layer, x), vec2(y.c, y.d))
            + dot(rows(corner + vec2(0.0, 4.0), layer, x), vec2(y.e, y.f));
    }
    return dot(rows(corner, layer, x), vec2(y.b, y.c)) + dot(rows(corner + vec2(0.0, 2.0), layer, x), vec2(y.d, y.e));
}

// The share of the weights that lies on the lattice.
fn share_at(place: Place) -> f32 {
    if all(place.cell >= vec3(2)) && all(place.cell <= frame.dims - 4) {
        return 1.0;
    }
    let x = weights(place.within.x);
    let y = weights(place.within.y);
    let z = weights(place.within.z);
    return sum_inside(x, place.cell.x, frame.dims.x) / x.sum * sum_inside(y, place.cell.y, frame.dims.y) / y.sum
        * sum_inside(z, place.cell.z, frame.dims.z) / z.sum;
}

// The slot of a page: corner of texels and layer of a cell's first voxel.
struct Slot {
    corner: vec2<f32>,
    layer: i32,
    exists: bool,
}

fn slot_of(cell: vec3<i32>) -> Slot {
    let at = cell + BEFORE;
    let page = at >> vec3(PAGE_BITS);
    if any(page < vec3(0)) || any(page >= frame.pages) {
        return Slot(vec2(0.0), 0, false);
    }
    let entry = pages[(page.z * frame.pages.y + page.y) * frame.pages.x + page.x];
    let edge = PAGE + TAPS - 1;
    let slot = vec2<i32>(vec2(entry & SLOT_MASK, (entry >> SLOT_BITS) & SLOT_MASK));
    let stack = i32((entry >> (2u * SLOT_BITS)) & STACK_MASK);
    let local = at & vec3(PAGE - 1);
    let octant = vec3<u32>(local) / u32(PAGE / 2);
    let is_needed = ((entry >> (OCTANTS_FROM + octant.x + 2u * octant.y + 4u * octant.z)) & 1u) != 0u;
    return Slot(vec2<f32>(slot * edge + local.xy + 1), stack * edge + local.z, is_needed);
}

// A channel of the texels around a place, weighted.
fn sum_of_slot(slot: Slot, channel: i32, x: Weights, y: Weights, z: Weights) -> f32 {
    let corner = slot.corner;
    let layer = slot.layer + channel * i32(frame.channel_layers);
    if TAPS == 6 {
        return z.a * slice(corner, layer, x, y) + z.b * slice(corner, layer + 1, x, y)
            + z.c * slice(corner, layer + 2, x, y) + z.d * slice(corner, layer + 3, x, y)
            + z.e * slice(corner, layer + 4, x, y) + z.f * slice(corner, layer + 5, x, y);
    }
    return z.b * slice(corner, layer, x, y) + z.c * slice(corner, layer + 1, x, y)
        + z.d * slice(corner, layer + 2, x, y) + z.e * slice(corner, layer + 3, x, y);
}

// Coverage at the faces of the volume (docs/numerics.md, `q`), as `splatvol_core::border`.
fn cumulative(x: f32) -> f32 {
    let t = clamp(x, -5.0, 5.0);
    return 1.0 / (1.0 + exp2((t * t * -0.1018 - 2.3048) * t));
}

// Standard deviations from a face beyond which nothing is lost.
const FAR: f32 = 3.4;

fn share_of_axis(corner: f32, size: f32) -> f32 {
    let near = min(corner, size - corner);
    if near >= FAR {
        return 1.0;
    }
    var share = cumulative(near);
    if size < 2.0 * FAR {
        share *= cumulative(size - near);
    }
    return share;
}

// `sigma`: of the kernel along the voxel axes, voxels.
fn coverage_of(place: vec3<f32>, sigma: vec3<f32>) -> f32 {
    let from_corner = place - frame.margin + 0.5;
    // Most places are far from all faces: there every share is one.
    if all(min(from_corner, frame.samples - from_corner) >= FAR * sigma) {
        return 1.0;
    }
    let corner = from_corner / sigma;
    let size = frame.samples / sigma;
    let share = share_of_axis(corner.x, size.x) * share_of_axis(corner.y, size.y) * share_of_axis(corner.z, size.z);
    return clamp((share - 0.5) / 0.98 + 0.5, 0.0, 1.0);
}

fn coverage_at(place: Place) -> f32 {
    return coverage_of(vec3<f32>(place.cell) + place.within, vec3(frame.sigma));
}
