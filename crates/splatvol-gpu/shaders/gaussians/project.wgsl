// Project: Gaussians to ellipses on the screen, one per invocation; docs/numerics.md and `splatvol_cpu::splats::project`.
// Those that are not seen get the largest key.

// Centre and opacity; rotation as a quaternion; scales.
@group(0) @binding(1) var<storage, read> means: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> rotations: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> scales: array<vec4<f32>>;
// Coefficients of harmonics, (degree + 1)^2 times three per Gaussian, and zeros up to a whole vector: the first vector of
// all Gaussians, then the second, so that neighbours read what lies beside each other.
@group(0) @binding(4) var<storage, read> harmonics: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> splats: array<Splat>;
@group(0) @binding(6) var<storage, read_write> keys: array<u32>;
@group(0) @binding(7) var<storage, read_write> places: array<u32>;

// log2(255).
override LOG2_255: f32;
override LEAST_ALPHA: f32;
override UNSEEN_ALPHA: f32;
override LEAST_SPREAD: f32;
override LEAST_RATIO: f32;

const LOG2_E: f32 = 1.442695041;
const BRIGHTEST: f32 = 1e4;

// Rows of A = J M R S.
struct Axes {
    a: vec3<f32>,
    b: vec3<f32>,
}

fn screen_axes(row_x: vec3<f32>, row_y: vec3<f32>, rotation: vec4<f32>, scale: vec3<f32>) -> Axes {
    let q = rotation;
    let q2 = q.xyz + q.xyz;
    let squares = q.xyz * q2;
    let xy = q.x * q2.y;
    let xz = q.x * q2.z;
    let yz = q.y * q2.z;
    let w = q.w * q2;
    let axes = array<vec3<f32>, 3>(
        vec3(1.0 - (squares.y + squares.z), xy + w.z, xz - w.y),
        vec3(xy - w.z, 1.0 - (squares.x + squares.z), yz + w.x),
        vec3(xz + w.y, yz - w.x, 1.0 - (squares.x + squares.y)),
    );
    return Axes(
        vec3(dot(row_x, axes[0]), dot(row_x, axes[1]), dot(row_x, axes[2])) * scale,
        vec3(dot(row_y, axes[0]), dot(row_y, axes[1]), dot(row_y, axes[2])) * scale,
    );
}

// Four coefficients after each other.
struct Four {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    d: vec3<f32>,
}

fn vector_of(index: u32, n: u32) -> vec4<f32> {
    return harmonics[n * view.count + index];
}

fn four_from(index: u32, first: u32) -> Four {
    let x = vector_of(index, first);
    let y = vector_of(index, first + 1u);
    let z = vector_of(index, first + 2u);
    return Four(x.xyz, vec3(x.w, y.xy), vec3(y.zw, z.x), z.yzw);
}

// Display colour from a direction: `splatvol_scene::harmonics`.
fn color_of(index: u32, d: vec3<f32>) -> vec3<f32> {
    let degree = view.degree;
    var sum = 0.5 + 0.2820948 * vector_of(index, 0u).xyz;
    let x = d.x;
    let y = d.y;
    let z = d.z;
    let xx = x * x;
    let yy = y * y;
    let zz = z * z;
    if degree >= 1u {
        const C: f32 = 0.48860252;
        let k = four_from(index, 0u);
        sum += -C * y * k.b + C * z * k.c - C * x * k.d;
    }
    if degree >= 2u {
        const C: f32 = 1.0925485;
        let k = four_from(index, 3u);
        sum += C * x * y * k.a - C * y * z * k.b + 0.31539157 * (2.0 * zz - xx - yy) * k.c - C * x * z * k.d
            + 0.54627424 * (xx - yy) * vector_of(index, 6u).xyz;
    }
    if degree >= 3u {
        let ring = 4.0 * zz - xx - yy;
        let k = four_from(index, 6u);
        let l = four_from(index, 9u);
        sum += -0.5900436 * y * (3.0 * xx - yy) * k.b + 2.8906114 * x * y * z * k.c - 0.4570458 * y * ring * k.d
            + 0.37317634 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy) * l.a - 0.4570458 * x * ring * l.b
            + 1.4453057 * z * (xx - yy) * l.c - 0.5900436 * x * (xx - 3.0 * yy) * l.d;
    }
    // What is not above 0 is 0, whatever it is.
    return select(vec3(0.0), min(sum, vec3(BRIGHTEST)), sum > vec3(0.0));
}

fn leave_out(at: u32) {
    keys[at] = view.unseen_key;
    splats[at].columns = 0u;
    splats[at].rows = 0u;
}

@compute @workgroup_size(256)
fn project(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 256u + id.x;
    if index >= view.count {
        return;
    }
    let at = view.before + index;
    places[at] = at;
    let mean = means[index];
    let seen = seen_at(mean.xyz);
    if !(seen.depth > view.near) {
        leave_out(at);
        return;
    }
    let axes = screen_axes(seen.row_x, seen.row_y, rotations[index], scales[index].xyz);
    let across = cross(axes.a, axes.b);
    let sharp = dot(across, across);
    let added = view.low_pass;
    let bare = vec3(dot(axes.a, axes.a), dot(axes.a, axes.b), dot(axes.b, axes.b));
    let det = sharp + (bare.x + bare.z) * added + added * added;
    let xx = bare.x + added;
    let xy = bare.y;
    let yy = bare.z + added;
    var opacity = mean.w;
    if view.is_antialiased != 0u {
        opacity *= sqrt(max(sharp / det, LEAST_RATIO));
    }
    if !(det > 0.0 && det < LARGEST && opacity >= LEAST_ALPHA) {
        leave_out(at);
        return;
    }
    let peak = log2(max(opacity, UNSEEN_ALPHA));
    let radius2 = max((peak + LOG2_255) * (2.0 / LOG2_E), 0.0);
    let reach = sqrt(radius2 * vec2(xx, yy));
    let half = (xx - yy) * 0.5;
    let spread = sqrt(max(half * half + xy * xy, LEAST_SPREAD));
    let half_square = ceil(sqrt((xx + yy) * 0.5 + spread) * 3.0);
    let columns = range_of(seen.centre.x - 0.5, half_square, reach.x, view.reference_tiles.x);
    let rows = range_of(seen.centre.y - 0.5, half_square, reach.y, view.reference_tiles.y);
    if !(columns.x < columns.y && rows.x < rows.y) {
        leave_out(at);
        return;
    }
    let per_det = -0.5 * LOG2_E / det;
    var direction = view.direction;
    if view.is_perspective != 0u {
        direction = seen.offset / max(length(seen.offset), SMALLEST);
    }
    let color = color_of(index, direction);
    splats[at] = Splat(
        seen.centre,
        vec2(yy, xy * -2.0) * per_det,
        xx * per_det,
        peak,
        color.rg,
        color.b,
        seen.depth,
        u32(columns.x) | (u32(columns.y) << 16u),
        u32(rows.x) | (u32(rows.y) << 16u),
    );
    keys[at] = min(max(bitcast<u32>(seen.depth), view.first_key) - view.first_key, view.unseen_key - 1u);
}
