// Project: a cloud's kernels to footprints of optical depth, one per invocation; docs/numerics.md and
// `splatvol_cpu::splats::{project, kernels}`. Those that are not seen touch no tile.

// A Gaussian that ends without a step, its integral kept.
struct Profile {
    // Fall of the exponent, base 2, at which it ends; its value there, which is taken off.
    end: f32,
    edge: f32,
    // Height of one of mass one over that of a whole Gaussian.
    height: f32,
    // Variance of the low-pass, pixels squared, and of the least one; where it is matched, footprints are widened only up to it.
    low_pass: f32,
    least_variance: f32,
    is_matched: u32,
    // Kernels from here on carry optical depths, those before it masses.
    peaks_from: u32,
    unused: u32,
}

@group(0) @binding(1) var<uniform> profile: Profile;
@group(0) @binding(2) var<storage, read> kernels: array<Kernel>;
@group(0) @binding(3) var<storage, read> payloads: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> splats: array<Splat>;
@group(0) @binding(5) var<storage, read_write> places: array<u32>;

const TAU: f32 = 6.2831853;
const LOG2_E: f32 = 1.442695041;
// Larger optical depths through the middle count as this one.
const DEEPEST: f32 = 1e9;

// Variance to add to a covariance xx, xy, yy of this determinant.
fn added(covariance: vec3<f32>, determinant: f32) -> f32 {
    if profile.is_matched == 0u {
        return profile.low_pass;
    }
    // The smaller eigenvalue as determinant over the larger one, without cancellation.
    let half = (covariance.x - covariance.z) * 0.5;
    let larger = (covariance.x + covariance.z) * 0.5 + sqrt(half * half + covariance.y * covariance.y);
    return max(profile.low_pass - determinant / max(larger, SMALLEST), profile.least_variance);
}

fn footprint(own: Kernel, payload: vec4<f32>, at: u32) -> Splat {
    let nothing = Splat(vec2(0.0), vec2(0.0), 0.0, 0.0, vec2(0.0), 0.0, 0.0, 0u, 0u);
    let seen = seen_at(vec3(own.x, own.y, own.z));
    if !(seen.depth > view.near) {
        return nothing;
    }
    let local = mat3x3(own.xx, own.xy, own.xz, own.xy, own.yy, own.yz, own.xz, own.yz, own.zz);
    let adjugate = mat3x3(
        own.yy * own.zz - own.yz * own.yz, own.xz * own.yz - own.xy * own.zz, own.xy * own.yz - own.xz * own.yy,
        own.xz * own.yz - own.xy * own.zz, own.xx * own.zz - own.xz * own.xz, own.xy * own.xz - own.xx * own.yz,
        own.xy * own.yz - own.xz * own.yy, own.xy * own.xz - own.xx * own.yz, own.xx * own.yy - own.xy * own.xy,
    );
    let normal = cross(seen.row_x, seen.row_y);
    let sharp = max(dot(normal, adjugate * normal), 0.0);
    let bare = vec3(
        dot(seen.row_x, local * seen.row_x),
        dot(seen.row_x, local * seen.row_y),
        dot(seen.row_y, local * seen.row_y),
    );
    let wider = added(bare, sharp);
    let det = sharp + (bare.x + bare.z) * wider + wider * wider;
    let xx = bare.x + wider;
    let yy = bare.z + wider;
    var peak = payload.x * sqrt(sharp / max(det, SMALLEST));
    if at < profile.peaks_from {
        let path = sqrt(dot(seen.tangent, seen.tangent) + 1.0);
        peak = payload.x * path * seen.scale * seen.scale / sqrt(max(det, SMALLEST)) * (profile.height / TAU);
    }
    if !(det > 0.0 && det < LARGEST && peak > 0.0) {
        return nothing;
    }
    let reach = sqrt(profile.end * (2.0 / LOG2_E) * vec2(xx, yy));
    let columns = range_of(seen.centre.x - 0.5, LARGEST, reach.x, view.reference_tiles.x);
    let rows = range_of(seen.centre.y - 0.5, LARGEST, reach.y, view.reference_tiles.y);
    if !(columns.x < columns.y && rows.x < rows.y) {
        return nothing;
    }
    let per_det = -0.5 * LOG2_E / det;
    let color = max(payload.yzw / payload.x, vec3(0.0));
    return Splat(
        seen.centre,
        vec2(yy, bare.y * -2.0) * per_det,
        xx * per_det,
        min(peak, DEEPEST) / (1.0 - profile.edge),
        color.rg,
        color.b,
        seen.depth,
        u32(columns.x) | (u32(columns.y) << 16u),
        u32(rows.x) | (u32(rows.y) << 16u),
    );
}

@compute @workgroup_size(256)
fn project_kernels(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 256u + id.x;
    if index >= view.count {
        return;
    }
    let at = view.before + index;
    places[at] = at;
    splats[at] = footprint(kernels[index], payloads[index], at);
}
