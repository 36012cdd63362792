//! The part of a mesh that can be seen: the cells whose values have some opacity, and the border that their samples'
//! kernels blur.

use glam::DVec3;
use splatvol_scene::{Association, Mesh, Topology, TransferFunction};

/// Maximum number of examined cells.
const MOST_CELLS: usize = 100_000;
/// Least opacity per unit distance at which a value can be seen.
const SEEN: f64 = 0.01;
/// Distance of a cell's visible border from its middle, relative to that of its points: kernels fade over about a cell
/// beyond the faces.
const BORDER: f64 = 3.0;

/// World positions around the visible cells; none if nothing can be seen.
pub(crate) fn visible_cells(mesh: &Mesh, transfer_function: &TransferFunction) -> Vec<DVec3> {
    let mut places = Vec::new();
    let stride = mesh.cell_count().div_ceil(MOST_CELLS).max(1);
    for_each_cell(mesh, |cell, points| {
        if cell % stride == 0 && !is_blanked(mesh, points) && is_seen(mesh, transfer_function, cell, points) {
            let world = |&point: &usize| {
                let local = mesh.positions()[point].map(f64::from);
                mesh.world_from_local().transform_point3(local.into())
            };
            let middle = points.iter().map(world).sum::<DVec3>() / points.len() as f64;
            places.extend(
                points
                    .iter()
                    .map(|point| middle + BORDER * (world(point) - middle)),
            );
        }
    });
    places
}

/// Calls with each cell's index and points.
fn for_each_cell(mesh: &Mesh, mut call: impl FnMut(usize, &[usize])) {
    match mesh.topology() {
        Topology::Unstructured(cells) => {
            let mut points = Vec::new();
            for cell in 0..cells.len() {
                points.clear();
                points.extend(cells.points(cell).iter().map(|&point| point as usize));
                call(cell, &points);
            }
        }
        Topology::Structured(blocks) => {
            let (mut cell, mut first) = (0, 0);
            for &[nx, ny, nz] in blocks {
                let steps = [1, nx, nx * ny];
                for (k, j, i) in indices([nx - 1, ny - 1, nz - 1]) {
                    let base = first + i + nx * (j + ny * k);
                    let corner =
                        |n: usize| base + (0..3).map(|axis| (n >> axis & 1) * steps[axis]).sum::<usize>();
                    call(cell, &std::array::from_fn::<usize, 8, _>(corner));
                    cell += 1;
                }
                first += nx * ny * nz;
            }
        }
    }
}

/// All indices of a block, slices outermost.
fn indices([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i))))
}

fn is_blanked(mesh: &Mesh, points: &[usize]) -> bool {
    points
        .iter()
        .any(|&point| mesh.blanked().get(point) == Some(&true))
}

/// Whether some value of a cell has opacity.
fn is_seen(mesh: &Mesh, transfer_function: &TransferFunction, cell: usize, points: &[usize]) -> bool {
    let field = mesh.field();
    let value = |at: usize| f64::from(field.values[at]);
    let [low, high] = match field.association {
        Association::Cell => [value(cell); 2],
        Association::Point => points
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &point| {
                [low.min(value(point)), high.max(value(point))]
            }),
    };
    let between = transfer_function.opacities().iter();
    let between = between.filter(|point| (low..=high).contains(&point.value));
    low <= high
        && [low, high]
            .map(|end| transfer_function.opacity(end))
            .into_iter()
            .chain(between.map(|point| point.opacity))
            .any(|opacity| opacity > SEEN)
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;
    use splatvol_scene::{CellKind, Cells, ColorPoint, MeshField, OpacityPoint};

    use super::*;

    /// Opaque from 1 on.
    fn step() -> TransferFunction {
        TransferFunction::new(
            vec![ColorPoint::new(0.0, [1.0; 3])],
            vec![OpacityPoint::new(0.9, 0.0), OpacityPoint::new(1.0, 1.0)],
            None,
        )
        .unwrap()
    }

    fn field(association: Association, values: Vec<f32>) -> MeshField {
        MeshField {
            name: "values".to_owned(),
            association,
            values,
        }
    }

    fn extent(places: &[DVec3]) -> [f64; 2] {
        let along = || places.iter().map(|place| place.x);
        [
            along().fold(f64::INFINITY, f64::min),
            along().fold(f64::NEG_INFINITY, f64::max),
        ]
    }

    #[test]
    fn visible_cells_of_a_block_are_shown_with_their_border() {
        let positions: Vec<_> = indices([4, 2, 2])
            .map(|(k, j, i)| [i as f32, j as f32, k as f32])
            .collect();
        let values = vec![0.0, 1.0, 0.0];
        let mesh = |values| {
            Mesh::new(
                positions.clone(),
                Topology::Structured(vec![[4, 2, 2]]),
                Vec::new(),
                field(Association::Cell, values),
                DAffine3::IDENTITY,
            )
            .unwrap()
        };
        assert_eq!(extent(&visible_cells(&mesh(values), &step())), [0.0, 3.0]);
        assert_eq!(extent(&visible_cells(&mesh(vec![1.0; 3]), &step())), [-1.0, 4.0]);
        assert!(visible_cells(&mesh(vec![0.0; 3]), &step()).is_empty());
    }

    #[test]
    fn cells_that_list_their_points_are_seen_by_any_of_them() {
        let mut cells = Cells::default();
        cells.push(CellKind::Tetra, &[0, 1, 2, 3]).unwrap();
        cells.push(CellKind::Tetra, &[0, 2, 1, 4]).unwrap();
        let positions = vec![
            [0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [4.0, 0.0, 0.0],
            [-4.0, 0.0, 0.0],
        ];
        let mesh = Mesh::new(
            positions,
            Topology::Unstructured(cells),
            Vec::new(),
            field(Association::Point, vec![0.0, 0.0, 0.0, 1.0, 0.0]),
            DAffine3::IDENTITY,
        )
        .unwrap();
        assert_eq!(extent(&visible_cells(&mesh, &step())), [-2.0, 10.0]);
    }
}
