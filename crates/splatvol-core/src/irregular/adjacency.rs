//! Neighbours in an unstructured mesh, as lists in one vector.

use rayon::prelude::*;
use splatvol_scene::Cells;

/// Lists of indices.
#[derive(Debug, Clone, Default)]
pub(super) struct Lists {
    offsets: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    pub(super) fn of(&self, index: usize) -> &[u32] {
        &self.items[self.offsets[index] as usize..self.offsets[index + 1] as usize]
    }

    fn from_lists(lists: &[Vec<u32>]) -> Self {
        let mut joined = Self {
            offsets: vec![0],
            items: Vec::with_capacity(lists.iter().map(Vec::len).sum()),
        };
        for list in lists {
            joined.items.extend_from_slice(list);
            joined.offsets.push(joined.items.len() as u32);
        }
        joined
    }
}

/// The cells of each point.
pub(super) fn cells_of_points(cells: &Cells, points: usize) -> Lists {
    let mut offsets = vec![0u32; points + 1];
    for cell in 0..cells.len() {
        for &point in cells.points(cell) {
            offsets[point as usize + 1] += 1;
        }
    }
    for point in 0..points {
        offsets[point + 1] += offsets[point];
    }
    let mut next = offsets.clone();
    let mut items = vec![0; offsets[points] as usize];
    for cell in 0..cells.len() {
        for &point in cells.points(cell) {
            items[next[point as usize] as usize] = cell as u32;
            next[point as usize] += 1;
        }
    }
    Lists { offsets, items }
}

/// The points that share a cell with each point.
pub(super) fn of_points(cells: &Cells, cells_of_points: &Lists, points: usize) -> Lists {
    let list = |point: usize| {
        let own = cells_of_points.of(point).iter();
        let mut found: Vec<u32> = own
            .flat_map(|&cell| cells.points(cell as usize))
            .copied()
            .collect();
        found.sort_unstable();
        found.dedup();
        found.retain(|&other| other as usize != point);
        found
    };
    Lists::from_lists(&(0..points).into_par_iter().map(list).collect::<Vec<_>>())
}

/// The cells that share at least three points with each cell: a face.
pub(super) fn of_cells(cells: &Cells, cells_of_points: &Lists) -> Lists {
    let list = |cell: usize| {
        let (scanned, passed_over) = scanned(cells, cells_of_points, cell);
        let mut found = candidates(cells_of_points, &scanned);
        found.sort_unstable();
        let is_beside = |run: &&[u32]| {
            let other = run[0] as usize;
            let shares = |point: &&u32| cells.points(other).contains(point);
            other != cell && run.len() + passed_over.iter().filter(shares).count() >= 3
        };
        let runs = found.chunk_by(|a, b| a == b);
        runs.filter(is_beside).map(|run| run[0]).collect()
    };
    Lists::from_lists(&(0..cells.len()).into_par_iter().map(list).collect::<Vec<_>>())
}

/// The points of a cell, each once, in two lists: those whose cells are searched for a common face, and the two
/// left out. Of three shared points at least one is in the first list. The two left out belong to the most cells,
/// so that the search stays short where many cells meet in a point or around an edge, as at a pole.
fn scanned(cells: &Cells, cells_of_points: &Lists, cell: usize) -> (Vec<u32>, Vec<u32>) {
    let mut points = distinct_points(cells, cell);
    points.sort_by_key(|&point| cells_of_points.of(point as usize).len());
    let passed_over = points.split_off(points.len().saturating_sub(2));
    (points, passed_over)
}

/// The cells of some points; a cell with several of the points occurs several times.
fn candidates(cells_of_points: &Lists, points: &[u32]) -> Vec<u32> {
    let mut found = Vec::new();
    for &point in points {
        // A cell that has a point twice is in its list twice, one after the other.
        let own = cells_of_points.of(point as usize).chunk_by(|a, b| a == b);
        found.extend(own.map(|run| run[0]));
    }
    found
}

/// The points of a cell, once each: collapsed cells have some of them several times.
fn distinct_points(cells: &Cells, cell: usize) -> Vec<u32> {
    let mut points = cells.points(cell).to_vec();
    points.sort_unstable();
    points.dedup();
    points
}

/// Number of faces of a cell. It is smaller than its kind's for a collapsed cell: a hexahedron collapsed to a
/// wedge, a pyramid or a tetrahedron.
pub(super) fn face_count(cells: &Cells, cell: usize) -> usize {
    let corners = cells.kind(cell).linear().point_count();
    let mut own = cells.points(cell)[..corners].to_vec();
    own.sort_unstable();
    own.dedup();
    match own.len() {
        0..=4 => 4,
        5 | 6 => 5,
        _ => 6,
    }
}

#[cfg(test)]
mod tests {
    use splatvol_scene::CellKind;

    use super::*;

    /// Tetrahedra around a common edge, whose ends are points 0 and 1.
    fn around_an_edge(count: u32) -> Cells {
        let mut cells = Cells::default();
        for n in 0..count {
            cells
                .push(CellKind::Tetra, &[0, 1, 2 + n, 2 + (n + 1) % count])
                .unwrap();
        }
        cells
    }

    #[test]
    fn cells_around_an_edge_take_no_longer_than_others() {
        let work = |count: u32| {
            let cells = around_an_edge(count);
            let lists = cells_of_points(&cells, 2 + count as usize);
            let own = |cell| candidates(&lists, &scanned(&cells, &lists, cell).0).len();
            (0..cells.len()).map(own).sum::<usize>()
        };
        assert_eq!(work(4000), 100 * work(40));
        let cells = around_an_edge(50);
        let found = of_cells(&cells, &cells_of_points(&cells, 52));
        for cell in 0..50u32 {
            let mut expected = [(cell + 49) % 50, (cell + 1) % 50];
            expected.sort_unstable();
            assert_eq!(found.of(cell as usize), expected);
        }
    }

    /// Two hexahedra that have a face in common, the second collapsed to a wedge, and a tetrahedron on one of its
    /// triangles.
    #[test]
    fn collapsed_cells_have_the_faces_of_what_they_are_collapsed_to() {
        let mut cells = Cells::default();
        cells
            .push(CellKind::Hexahedron, &[0, 1, 2, 3, 4, 5, 6, 7])
            .unwrap();
        cells
            .push(CellKind::Hexahedron, &[1, 8, 8, 2, 5, 9, 9, 6])
            .unwrap();
        cells.push(CellKind::Tetra, &[1, 8, 2, 10]).unwrap();
        // Along an edge of the first alone.
        cells.push(CellKind::Tetra, &[0, 3, 11, 12]).unwrap();
        let found = of_cells(&cells, &cells_of_points(&cells, 13));
        let faces: Vec<&[u32]> = (0..4).map(|cell| found.of(cell)).collect();
        assert_eq!(faces, [&[1u32][..], &[0, 2], &[1], &[]]);
        let counts = [0, 1, 2, 3].map(|cell| face_count(&cells, cell));
        assert_eq!(counts, [6, 5, 4, 4]);
    }
}
