// Whole: no sample is missing.

const HAS_HOLES: bool = false;

fn keep_missing(point: u32, missing: f32) {}

fn missing_at(point: u32) -> f32 {
    return 0.0;
}
