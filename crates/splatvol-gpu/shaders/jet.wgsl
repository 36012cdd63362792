// Jet: S over the sum of all weights H, with its gradient `(grad S - (S / H) grad H) / H`, per voxel along the voxel axes.
// Gradients come from the same texels as sums, with the kernels' derivatives for weights.

struct Jet {
    sum: f32,
    slope: vec3<f32>,
}

// Derivatives by the place of weights along an axis.
fn slopes_of(t: f32, w: Weights) -> Weights {
    let per_voxel = 1.0 / (frame.sigma * frame.sigma);
    let at = t * per_voxel;
    var d = Weights(0.0, -(at + per_voxel) * w.b, -at * w.c, (per_voxel - at) * w.d, (2.0 * per_voxel - at) * w.e, 0.0, 0.0);
    if TAPS == 6 {
        d.a = -(at + 2.0 * per_voxel) * w.a;
        d.f = (3.0 * per_voxel - at) * w.f;
    }
    d.sum = d.a + d.b + d.c + d.d + d.e + d.f;
    return d;
}

// Two rows of two texels around a corner of texels: weighted along x, then by the weights' derivatives.
fn two_rows_jet(corner: vec2<f32>, layer: i32, weight: vec2<f32>, slope: vec2<f32>) -> vec4<f32> {
    let four = textureGather(0, atlas, nearest, corner * frame.per_texel, layer);
    return vec4(dot(weight, four.wz), dot(weight, four.xy), dot(slope, four.wz), dot(slope, four.xy));
}

fn rows_jet(corner: vec2<f32>, layer: i32, x: Weights, dx: Weights) -> vec4<f32> {
    if TAPS == 6 {
        return two_rows_jet(corner, layer, vec2(x.a, x.b), vec2(dx.a, dx.b))
            + two_rows_jet(corner + vec2(2.0, 0.0), layer, vec2(x.c, x.d), vec2(dx.c, dx.d))
            + two_rows_jet(corner + vec2(4.0, 0.0), layer, vec2(x.e, x.f), vec2(dx.e, dx.f));
    }
    return two_rows_jet(corner, layer, vec2(x.b, x.c), vec2(dx.b, dx.c))
        + two_rows_jet(corner + vec2(2.0, 0.0), layer, vec2(x.d, x.e), vec2(dx.d, dx.e));
}

// Sum of two rows, its slope along x, and its slope along y.
fn add_rows(rows: vec4<f32>, weight: vec2<f32>, slope: vec2<f32>) -> vec3<f32> {
    return vec3(dot(rows.xy, weight), dot(rows.zw, weight), dot(rows.xy, slope));
}

struct LateralWeights {
    x: Weights,
    dx: Weights,
    y: Weights,
    dy: Weights,
}

fn slice_jet(corner: vec2<f32>, layer: i32, w: LateralWeights) -> vec3<f32> {
    if TAPS == 6 {
        return add_rows(rows_jet(corner, layer, w.x, w.dx), vec2(w.y.a, w.y.b), vec2(w.dy.a, w.dy.b))
            + add_rows(rows_jet(corner + vec2(0.0, 2.0), layer, w.x, w.dx), vec2(w.y.c, w.y.d), vec2(w.dy.c, w.dy.d))
            + add_rows(rows_jet(corner + vec2(0.0, 4.0), layer, w.x, w.dx), vec2(w.y.e, w.y.f), vec2(w.dy.e, w.dy.f));
    }
    return add_rows(rows_jet(corner, layer, w.x, w.dx), vec2(w.y.b, w.y.c), vec2(w.dy.b, w.dy.c))
        + add_rows(rows_jet(corner + vec2(0.0, 2.0), layer, w.x, w.dx), vec2(w.y.d, w.y.e), vec2(w.dy.d, w.dy.e));
}

// A slice with its weight and the weight's derivative: sum, and slopes along x, y and z.
fn layer_jet(slice: vec3<f32>, weight: f32, slope: f32) -> vec4<f32> {
    return vec4(weight * slice, slope * slice.x);
}

// `channel`: of the atlas.
fn jet_at(place: Place, channel: i32) -> Jet {
    let slot = slot_of(place.cell);
    if !slot.exists {
        return Jet(0.0, vec3(0.0));
    }
    let x = weights(place.within.x);
    let y = weights(place.within.y);
    let z = weights(place.within.z);
    let lateral = LateralWeights(x, slopes_of(place.within.x, x), y, slopes_of(place.within.y, y));
    let dz = slopes_of(place.within.z, z);
    let corner = slot.corner;
    let layer = slot.layer + channel * i32(frame.channel_layers);
    var sums = vec4(0.0);
    if TAPS == 6 {
        sums = layer_jet(slice_jet(corner, layer, lateral), z.a, dz.a)
            + layer_jet(slice_jet(corner, layer + 1, lateral), z.b, dz.b)
            + layer_jet(slice_jet(corner, layer + 2, lateral), z.c, dz.c)
            + layer_jet(slice_jet(corner, layer + 3, lateral), z.d, dz.d)
            + layer_jet(slice_jet(corner, layer + 4, lateral), z.e, dz.e)
            + layer_jet(slice_jet(corner, layer + 5, lateral), z.f, dz.f);
    } else {
        sums = layer_jet(slice_jet(corner, layer, lateral), z.b, dz.b)
            + layer_jet(slice_jet(corner, layer + 1, lateral), z.c, dz.c)
            + layer_jet(slice_jet(corner, layer + 2, lateral), z.d, dz.d)
            + layer_jet(slice_jet(corner, layer + 3, lateral), z.e, dz.e);
    }
    sums /= x.sum * y.sum * z.sum;
    let all_slopes = vec3(lateral.dx.sum / x.sum, lateral.dy.sum / y.sum, dz.sum / z.sum);
    return Jet(sums.x, sums.yzw - sums.x * all_slopes);
}

// Share of the weights along an axis that lies on the lattice, and its derivative.
fn share_of(t: f32, cell: i32, count: i32) -> vec2<f32> {
    let w = weights(t);
    let d = slopes_of(t, w);
    let share = sum_inside(w, cell, count) / w.sum;
    return vec2(share, (sum_inside(d, cell, count) - share * d.sum) / w.sum);
}

// Share of the weights that lies on the lattice, with its gradient.
fn share_jet(place: Place) -> Jet {
    if all(place.cell >= vec3(2)) && all(place.cell <= frame.dims - 4) {
        return Jet(1.0, vec3(0.0));
    }
    let x = share_of(place.within.x, place.cell.x, frame.dims.x);
    let y = share_of(place.within.y, place.cell.y, frame.dims.y);
    let z = share_of(place.within.z, place.cell.z, frame.dims.z);
    return Jet(x.x * y.x * z.x, vec3(x.y * y.x * z.x, x.x * y.y * z.x, x.x * y.x * z.y));
}
