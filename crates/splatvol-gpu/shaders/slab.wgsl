// Slab: homogeneous material between two planes.

// World length of a pixel's ray per depth.
fn ray_length(offset: vec2<f32>) -> f32 {
    let slope = offset * frame.per_pixel;
    return sqrt(dot(slope, slope) + 1.0);
}

// Opacity of an optical depth; thin material would lose its digits in the difference to one.
fn opacity_of(optical_depth: f32, through: f32) -> f32 {
    let series = optical_depth * (1.0 - optical_depth * (0.5 - optical_depth / 6.0));
    return select(1.0 - through, series, optical_depth < 0.02);
}
