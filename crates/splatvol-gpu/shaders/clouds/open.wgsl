// Open: a cloud's kernels to camera space; `splatvol_cpu::sheets::cloud::open`, in single precision. One invocation per
// kernel of a page.

struct Cloud {
    // Low-pass variance, pixels squared; where it is matched, footprints are widened only up to it.
    low_pass: f32,
    is_matched: u32,
    // Depth of the nearest plane, for the low-pass of splats in front of it.
    nearest: f32,
    // Variance by which planes widen splats in depth.
    widening: f32,
    // Integral of each kernel over space, world volume, but for those from `peaks_from` on, which carry optical depths.
    mass: f32,
    peaks_from: u32,
    // Kernels of the page, and before it.
    count: u32,
    before: u32,
}

@group(0) @binding(3) var<uniform> cloud: Cloud;
@group(0) @binding(4) var<storage, read> kernels: array<Kernel>;
@group(0) @binding(5) var<storage, read> payloads: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> splats: array<Splat>;

override LEAST_WIDTH: f32;
override DEPTH_INTEGRAL: f32;
override DEPTH_CUT: f32;
override CUT: f32;

const TAU: f32 = 6.2831853;

// World length of a pixel at a depth.
fn pixel_at(depth: f32) -> f32 {
    return select(frame.plane_per_pixel, frame.per_pixel * max(depth, cloud.nearest), frame.per_pixel > 0.0);
}

// What a section is widened by, world length squared.
fn added(section: vec3<f32>, depth: f32) -> f32 {
    let pixel = pixel_at(depth);
    let wanted = cloud.low_pass * pixel * pixel;
    let half_difference = 0.5 * (section.x - section.z);
    let least = 0.5 * (section.x + section.z) - sqrt(half_difference * half_difference + section.y * section.y);
    let missing = select(wanted, max(wanted - least, 0.0), cloud.is_matched != 0u);
    return missing + LEAST_WIDTH * pixel * LEAST_WIDTH * pixel;
}

// The integral of a kernel whose line integral through its centre is one.
fn mass_of_peak(centre: vec3<f32>, v: mat3x3<f32>) -> f32 {
    let along = select(vec2(0.0), centre.xy / max(centre.z, cloud.nearest), frame.per_pixel > 0.0);
    let xx = v[0].x - 2.0 * along.x * v[2].x + along.x * along.x * v[2].z;
    let xy = v[0].y - along.x * v[2].y - along.y * v[2].x + along.x * along.y * v[2].z;
    let yy = v[1].y - 2.0 * along.y * v[2].y + along.y * along.y * v[2].z;
    return TAU * sqrt(max(xx * yy - xy * xy, 0.0)) / sqrt(1.0 + dot(along, along));
}

fn opened(own: Kernel, at: u32, payload: vec4<f32>) -> Splat {
    let nothing = Splat(vec3(0.0), -1.0, vec2(0.0), vec2(0.0), vec3(0.0), 0.0, vec4(0.0));
    let centre = (frame.camera_from_lattice * vec4(own.x, own.y, own.z, 1.0)).xyz;
    if !is_kept(centre) {
        return nothing;
    }
    let m = mat3x3(frame.camera_from_lattice[0].xyz, frame.camera_from_lattice[1].xyz, frame.camera_from_lattice[2].xyz);
    let local = mat3x3(own.xx, own.xy, own.xz, own.xy, own.yy, own.yz, own.xz, own.yz, own.zz);
    let v = m * local * transpose(m);
    let variance = v[2].z + cloud.widening;
    let slope = v[2].xy / variance;
    let section = vec3(
        max(v[0].x - slope.x * slope.x * variance, 0.0),
        v[0].y - slope.x * slope.y * variance,
        max(v[1].y - slope.y * slope.y * variance, 0.0),
    );
    let wider = added(section, centre.z);
    let area = max(section.x * section.z - section.y * section.y, 0.0);
    let determinant = area + wider * (section.x + section.z + wider);
    var mass = cloud.mass;
    if at >= cloud.peaks_from {
        mass = mass_of_peak(centre, v);
    }
    let density = mass / (TAU * sqrt(determinant) * sqrt(variance) * DEPTH_INTEGRAL);
    var material = payload;
    if frame.lit != 0u {
        let light = phong(frame.gradient_from_lattice * vec3(own.gradient_x, own.gradient_y, own.gradient_z));
        material = vec4(material.x, material.yzw * light.x + light.y * material.x);
    }
    material *= density;
    // False where anything is not a number.
    if !(material.x > 0.0 && determinant > 0.0 && variance > 0.0) {
        return nothing;
    }
    let half = 0.5 * LOG2_E / determinant;
    let xx = section.x + wider;
    let yy = section.z + wider;
    return Splat(
        centre,
        DEPTH_CUT * sqrt(variance),
        slope,
        CUT * sqrt(vec2(xx, yy)),
        vec3(-yy * half, 2.0 * section.y * half, -xx * half),
        -0.5 * LOG2_E / variance,
        material,
    );
}

@compute @workgroup_size(256)
fn open(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let own = id.y * groups.x * 256u + id.x;
    if own >= cloud.count {
        return;
    }
    let at = cloud.before + own;
    splats[at] = opened(kernels[own], at, payloads[own]);
}
