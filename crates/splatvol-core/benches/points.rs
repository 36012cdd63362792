//! Radii and normals of bare points: neighbours, sizes, orientation.
//!
//! ```text
//! cargo bench -p splatvol-core --bench points
//! ```
//!
//! Points lie at random on a sphere.

use divan::Bencher;
use divan::counter::ItemsCount;
use splatvol_core::points::{Neighborhoods, Orientation};
use splatvol_testing::Random;

const NEIGHBORS: usize = 8;
const COUNTS: [usize; 2] = [100_000, 1_000_000];

fn main() {
    divan::main();
}

fn sphere(count: usize) -> Vec<[f32; 3]> {
    let mut random = Random::new(10);
    (0..count)
        .map(|_| random.direction().as_vec3().to_array())
        .collect()
}

#[divan::bench(args = COUNTS, sample_count = 3)]
fn neighbors(bencher: Bencher<'_, '_>, count: usize) {
    let points = sphere(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench(|| Neighborhoods::new(&points, NEIGHBORS));
}

#[divan::bench(args = COUNTS, sample_count = 3)]
fn radii(bencher: Bencher<'_, '_>, count: usize) {
    let neighborhoods = Neighborhoods::new(&sphere(count), NEIGHBORS);
    bencher
        .counter(ItemsCount::new(count))
        .bench(|| neighborhoods.radii());
}

#[divan::bench(args = COUNTS, sample_count = 3)]
fn normals(bencher: Bencher<'_, '_>, count: usize) {
    let neighborhoods = Neighborhoods::new(&sphere(count), NEIGHBORS);
    bencher
        .counter(ItemsCount::new(count))
        .bench(|| neighborhoods.normals(Orientation::Outward));
}
