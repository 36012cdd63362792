// What operators are given, and what they change.

// Material that a pixel's ray meets between two planes; see `splatvol_scene::SheetSample`.
struct SheetSample {
    value: f32,
    gradient: vec3<f32>,
    position: vec3<f32>,
    view: vec3<f32>,
    depth: f32,
}

// Appearance of material; see `splatvol_scene::Appearance`.
struct Appearance {
    color: vec3<f32>,
    extinction: f32,
    normal: vec3<f32>,
    surfaceness: f32,
    reflection: vec3<f32>,
    reflectance: f32,
}
