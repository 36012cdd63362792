//! Flat cells of unstructured grids, as polygons.

use crate::IoError;
use crate::error::Context;
use crate::mesh::assemble::StoredCells;

use super::Lists;

/// How a flat cell lists its corners. Cells of higher degree list the corners first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outline {
    /// So many corners in turn.
    First(usize),
    /// All points are corners.
    All,
    /// The first half are corners.
    Half,
    /// Four corners by rows.
    Pixel,
    /// Every corner after the second makes a triangle with the two before it.
    Strip,
}

impl Outline {
    /// That of a VTK type; `None` for what is no surface.
    fn of(code: u8) -> Option<Self> {
        Some(match code {
            5 | 22 | 34 | 69 | 76 => Self::First(3),
            9 | 23 | 28 | 30 | 70 | 77 => Self::First(4),
            7 => Self::All,
            36 => Self::Half,
            8 => Self::Pixel,
            6 => Self::Strip,
            _ => return None,
        })
    }

    /// The polygons of a cell.
    fn polygons(self, list: &[u64], mut add: impl FnMut(&[u64])) {
        match (self, list) {
            (Self::First(count), _) => add(list.get(..count).unwrap_or(list)),
            (Self::All, _) => add(list),
            (Self::Half, _) => add(&list[..list.len() / 2]),
            (Self::Pixel, &[a, b, c, d, ..]) => add(&[a, b, d, c]),
            (Self::Pixel, _) => add(list),
            (Self::Strip, _) => {
                for (index, corners) in list.windows(3).enumerate() {
                    let [a, b, c] = [corners[0], corners[1], corners[2]];
                    add(&if index % 2 == 0 { [a, b, c] } else { [b, a, c] });
                }
            }
        }
    }
}

/// True for cells of points and lines, and for empty ones.
fn is_thin(code: u8) -> bool {
    matches!(code, 0..=4 | 21 | 35 | 68 | 75)
}

/// True where cells of these types are a surface, and nothing else but points and lines.
pub(crate) fn are_surface(types: &[u8]) -> bool {
    let is_flat = |code: &u8| Outline::of(*code).is_some();
    types.iter().any(is_flat) && types.iter().all(|code| is_flat(code) || is_thin(*code))
}

/// Adds the polygons of a piece whose points, so many, begin at `first`. The cell of every polygon, and the number of cells
/// that are none.
pub(crate) fn add(
    stored: &StoredCells,
    (first, points): (usize, usize),
    to: &mut Lists,
    context: &Context<'_>,
) -> Result<(Vec<usize>, u64), IoError> {
    let (mut ends, mut corners, mut cells) = (Vec::new(), Vec::new(), Vec::new());
    let (mut begin, mut thin) = (0, 0);
    for (cell, (&code, &end)) in stored.types.iter().zip(&stored.ends).enumerate() {
        let list = usize::try_from(end)
            .ok()
            .and_then(|end| stored.connectivity.get(begin..end));
        let list = list.ok_or_else(|| {
            let expected = format!("{begin} to {}", stored.connectivity.len());
            context.field(format!("offset of cell {cell}"), end, None, expected)
        })?;
        begin = end as usize;
        let Some(outline) = Outline::of(code) else {
            thin += 1;
            continue;
        };
        outline.polygons(list, |polygon| {
            corners.extend_from_slice(polygon);
            ends.push(corners.len() as u64);
            cells.push(cell);
        });
    }
    to.add((&ends, &corners), (first, points), context)?;
    Ok((cells, thin))
}
