// Holes: samples are missing, and have no weight (docs/numerics.md); `splatvol_cpu::sheets::holes`.

const HAS_HOLES: bool = true;

// Weights of missing samples, beside `values`.
var<workgroup> missing: array<f32, 2u * POINTS>;

fn keep_missing(point: u32, weight: f32) {
    missing[point] = weight;
}

fn missing_at(point: u32) -> f32 {
    return missing[point];
}
