// Kernel: one of a cloud, in its own space.

struct Kernel {
    // Centre, local; covariance: xx, xy, xz, yy, yz, zz; gradient of the normalised value.
    x: f32, y: f32, z: f32, xx: f32,
    xy: f32, xz: f32, yy: f32, yz: f32,
    zz: f32, gradient_x: f32, gradient_y: f32, gradient_z: f32,
}
