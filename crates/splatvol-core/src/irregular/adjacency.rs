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
        let own = cells.points(cell).iter();
        let mut found: Vec<u32> = own
            .flat_map(|&point| cells_of_points.of(point as usize))
            .copied()
            .collect();
        found.sort_unstable();
        let runs = found.chunk_by(|a, b| a == b);
        runs.filter(|run| run.len() >= 3 && run[0] as usize != cell)
            .map(|run| run[0])
            .collect()
    };
    Lists::from_lists(&(0..cells.len()).into_par_iter().map(list).collect::<Vec<_>>())
}

/// What a breadth-first walk has seen, kept between walks of one thread.
#[derive(Debug, Clone, Default)]
pub(super) struct Walk {
    seen: Vec<u32>,
    stamp: u32,
    /// Found so far, the start first.
    pub(super) found: Vec<u32>,
}

impl Walk {
    pub(super) fn new(count: usize) -> Self {
        Self {
            seen: vec![0; count],
            stamp: 0,
            found: Vec::new(),
        }
    }

    /// All that is connected to `start` by what `reaches` says is near.
    pub(super) fn run(&mut self, start: usize, lists: &Lists, reaches: impl Fn(usize) -> bool) {
        self.stamp += 1;
        self.found.clear();
        self.found.push(start as u32);
        self.seen[start] = self.stamp;
        let mut next = 0;
        while let Some(&index) = self.found.get(next) {
            next += 1;
            for &other in lists.of(index as usize) {
                let place = other as usize;
                if self.seen[place] != self.stamp {
                    self.seen[place] = self.stamp;
                    if reaches(place) {
                        self.found.push(other);
                    }
                }
            }
        }
    }
}
