//! Kernels of meshes: even ones, and those whose cells jump in size, which are resampled.
//!
//! ```text
//! cargo bench -p splatvol-core --bench meshes
//! ```

use divan::Bencher;
use divan::counter::ItemsCount;
use glam::DAffine3;
use splatvol_core::irregular::kernels;
use splatvol_scene::{Association, Mesh, MeshField, Topology};

const SIGMA: f64 = 0.74;
/// Samples along each axis.
const SIDES: [usize; 2] = [16, 32];

fn main() {
    divan::main();
}

/// A rectilinear grid whose spacing is `wide` in the upper half of x and y, 1 elsewhere.
fn mesh(side: usize, wide: f32) -> Mesh {
    let half = side / 2;
    let along = |i: usize| i.min(half) as f32 + wide * i.saturating_sub(half) as f32;
    let place = |n: usize| {
        let [i, j, k] = [n % side, n / side % side, n / (side * side)];
        [along(i), along(j), k as f32]
    };
    let count = side * side * side;
    let positions: Vec<[f32; 3]> = (0..count).map(place).collect();
    let field = MeshField {
        name: "f".to_owned(),
        association: Association::Point,
        values: positions.iter().map(|p| p[0]).collect(),
    };
    let topology = Topology::Structured(vec![[side; 3]]);
    Mesh::new(positions, topology, vec![], field, DAffine3::IDENTITY).expect("the mesh is whole")
}

fn bench(bencher: Bencher<'_, '_>, side: usize, wide: f32) {
    let mesh = mesh(side, wide);
    bencher
        .counter(ItemsCount::new(side * side * side))
        .bench(|| kernels(&mesh, SIGMA));
}

#[divan::bench(args = SIDES, sample_count = 5)]
fn even(bencher: Bencher<'_, '_>, side: usize) {
    bench(bencher, side, 1.0);
}

#[divan::bench(args = SIDES, sample_count = 3)]
fn jump(bencher: Bencher<'_, '_>, side: usize) {
    bench(bencher, side, 8.0);
}
