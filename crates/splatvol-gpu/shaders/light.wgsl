// Light on a gradient, as `splatvol_cpu::phong` has it.

const LOG2_E: f32 = 1.4426950;
const LEAST_EXPONENT: f32 = -100.0;
// Least squared gradient, in value ranges per voxel.
const LEAST_SQUARED: f32 = 1e-12;

// Diffuse and specular factor of a gradient, camera space, per world length.
fn phong(gradient: vec3<f32>) -> vec2<f32> {
    let squared = max(dot(gradient, gradient) * frame.voxel * frame.voxel, LEAST_SQUARED);
    let surface = squared / (squared + frame.floor_squared);
    let inverse = frame.voxel / sqrt(squared);
    let facing = min(abs(dot(gradient, frame.towards_light)) * inverse, 1.0);
    let diffuse = (surface * (facing - 1.0) + 1.0) * frame.diffuse + frame.ambient;
    if frame.specular == 0.0 {
        return vec2(diffuse, 0.0);
    }
    let shining = min(abs(dot(gradient, frame.half_way)) * inverse, 1.0);
    let gloss = exp2(max(log2(max(shining, 1e-30)) * frame.power, LEAST_EXPONENT));
    return vec2(diffuse, gloss * surface * frame.specular);
}

// Mean place of the visible light of material that fills a segment of this optical depth t and transmittance:
// `1 / t - 1 / (e^t - 1)`.
fn visible_place(optical_depth: f32, through: f32) -> f32 {
    if optical_depth < 0.1 {
        return 0.5 - optical_depth / 12.0;
    }
    return 1.0 / optical_depth - through / (1.0 - through);
}

// Share of a surface, 0 to 1, of a gradient of this length, per world length.
fn surfaceness(length: f32) -> f32 {
    let squared = length * length * frame.voxel * frame.voxel;
    return squared / max(squared + frame.floor_squared, LEAST_SQUARED);
}

// Diffuse and specular factor of a surface with this normal, camera space.
fn phong_on(normal: vec3<f32>, surface: f32) -> vec2<f32> {
    let facing = min(abs(dot(normal, frame.towards_light)), 1.0);
    let shining = min(abs(dot(normal, frame.half_way)), 1.0);
    let gloss = exp2(max(log2(max(shining, 1e-30)) * frame.power, LEAST_EXPONENT));
    return vec2((surface * (facing - 1.0) + 1.0) * frame.diffuse + frame.ambient, gloss * surface * frame.specular);
}
