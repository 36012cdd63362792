//! Kernels of meshes: structured ones whose cells are alike, those that are resampled, collapsed and blanked cells,
//! tetrahedra.

#![expect(
    clippy::expect_used,
    reason = "a benchmark that cannot run should say so and stop"
)]

use divan::Bencher;
use divan::counter::ItemsCount;
use glam::DAffine3;
use splatvol_core::irregular::kernels;
use splatvol_scene::{Association, CellKind, Cells, Mesh, MeshField, Topology};
use splatvol_testing::Random;

const SIGMA: f64 = 0.74;
/// Samples along each axis.
const SIDES: [usize; 2] = [16, 32];

fn main() {
    divan::main();
}

/// Index to indices, the first fastest.
fn indices(n: usize, dims: [usize; 3]) -> [usize; 3] {
    [n % dims[0], n / dims[0] % dims[1], n / (dims[0] * dims[1])]
}

/// A mesh with a value that varies over some of its cells.
fn mesh(positions: Vec<[f32; 3]>, topology: Topology, blanked: Vec<bool>) -> Mesh {
    let field = MeshField {
        name: "f".to_owned(),
        association: Association::Point,
        values: positions.iter().map(|p| p[0].sin() + 0.2 * p[2]).collect(),
    };
    Mesh::new(positions, topology, blanked, field, DAffine3::IDENTITY).expect("the mesh is whole")
}

/// A rectilinear grid with these spacings along an axis.
fn rectilinear(dims: [usize; 3], spacings: impl Fn(usize, usize) -> f32) -> Mesh {
    let lines: [Vec<f32>; 3] = std::array::from_fn(|axis| {
        let step = |at: &mut f32, n: usize| {
            *at += if n > 0 { spacings(axis, n - 1) } else { 0.0 };
            Some(*at)
        };
        (0..dims[axis]).scan(0.0, step).collect()
    });
    let place = |n: usize| {
        let [i, j, k] = indices(n, dims);
        [lines[0][i], lines[1][j], lines[2][k]]
    };
    let positions = (0..dims.iter().product()).map(place).collect();
    mesh(positions, Topology::Structured(vec![dims]), vec![])
}

/// Spacing that is `wide` in the upper half of x and y, 1 elsewhere.
fn halves(side: usize, wide: f32) -> Mesh {
    rectilinear(
        [side; 3],
        |axis, n| {
            if axis < 2 && n >= side / 2 { wide } else { 1.0 }
        },
    )
}

/// A room of 11,424 points: spacing that changes now and then, by up to eight times.
fn room() -> Mesh {
    const SPACINGS: [f32; 7] = [1.0, 1.0, 0.2, 0.4, 0.4, 0.7, 1.6];
    rectilinear([28, 24, 17], |axis, n| {
        SPACINGS[(n / 3 + 2 * axis) % SPACINGS.len()]
    })
}

/// Flow around a post, 109,744 points: a polar grid that ends where it begins, with a collapsed axis. Its layers
/// grow from the post's wall and from the floor, and it is blanked within the post.
fn post() -> Mesh {
    const DIMS: [usize; 3] = [38, 76, 38];
    const WALL: usize = 10;
    let grown = |n: usize, ratio: f32| (ratio.powi(n as i32) - 1.0) / (ratio - 1.0);
    let radius = |i: usize| match i {
        0..WALL => 1.0 - grown(WALL - i, 1.35) / grown(WALL, 1.35),
        _ => 1.0 + 9.0 * grown(i - WALL, 1.18) / grown(DIMS[0] - 1 - WALL, 1.18),
    };
    let place = |n: usize| {
        let [i, j, k] = indices(n, DIMS);
        let angle = std::f32::consts::TAU * j as f32 / (DIMS[1] - 1) as f32;
        let height = 6.0 * grown(k, 1.15) / grown(DIMS[2] - 1, 1.15);
        [radius(i) * angle.cos(), radius(i) * angle.sin(), height]
    };
    let is_blanked = |n: usize| {
        let [i, _, k] = indices(n, DIMS);
        (2..WALL).contains(&i) && k < 20
    };
    let count = DIMS.iter().product();
    mesh(
        (0..count).map(place).collect(),
        Topology::Structured(vec![DIMS]),
        (0..count).map(is_blanked).collect(),
    )
}

/// 355,914 tetrahedra between lattice points moved at random; in the upper half of x they are `wide` times as long.
fn tetrahedra(wide: f32) -> Mesh {
    const SIDE: usize = 40;
    const PATHS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let mut random = Random::new(5);
    let half = (SIDE / 2) as f32;
    let mut place = |n: usize| {
        let [x, y, z] = indices(n, [SIDE; 3]).map(|i| i as f32 + 0.25 * (2.0 * random.unit() as f32 - 1.0));
        [if x < half { x } else { half + wide * (x - half) }, y, z]
    };
    let positions = (0..SIDE * SIDE * SIDE).map(&mut place).collect();
    let strides = [1, SIDE, SIDE * SIDE];
    let mut cells = Cells::default();
    for cell in 0..(SIDE - 1usize).pow(3) {
        let [i, j, k] = indices(cell, [SIDE - 1; 3]);
        for path in PATHS {
            let mut corners = [i + SIDE * (j + SIDE * k); 4];
            for step in 0..3 {
                corners[step + 1] = corners[step] + strides[path[step]];
            }
            cells
                .push(CellKind::Tetra, &corners.map(|c| c as u32))
                .expect("four points");
        }
    }
    mesh(positions, Topology::Unstructured(cells), vec![])
}

fn bench(bencher: Bencher<'_, '_>, mesh: &Mesh) {
    bencher
        .counter(ItemsCount::new(mesh.positions().len()))
        .bench(|| kernels(mesh, SIGMA));
}

#[divan::bench(args = SIDES, sample_count = 5)]
fn even(bencher: Bencher<'_, '_>, side: usize) {
    bench(bencher, &halves(side, 1.0));
}

#[divan::bench(args = SIDES, sample_count = 3)]
fn jump(bencher: Bencher<'_, '_>, side: usize) {
    bench(bencher, &halves(side, 8.0));
}

#[divan::bench(sample_count = 3)]
fn uneven_room(bencher: Bencher<'_, '_>) {
    bench(bencher, &room());
}

#[divan::bench(sample_count = 3)]
fn collapsed_and_blanked_post(bencher: Bencher<'_, '_>) {
    bench(bencher, &post());
}

#[divan::bench(args = [1.0, 8.0], sample_count = 3)]
fn tetrahedra_jump(bencher: Bencher<'_, '_>, wide: f32) {
    bench(bencher, &tetrahedra(wide));
}
