//! Which voxels of a brick a reconstruction needs: those near visible cells, by shifts of whole slices.
//!
//! Voxel x touches cells x - 1 and x; the kernel's outer half reaches one cell further on both sides. A slice of 8 x 8
//! cells is one word, so that a step along x or y is a shift of it with what the neighbour hands over.

use crate::brick::BRICK;

use super::cells::CellBits;

/// Voxels within one cell of a visible one, and within two: bit `8 y + x` of word z.
#[derive(Debug, Clone, Copy)]
pub(super) struct Needs {
    pub near: CellBits,
    pub far: CellBits,
}

/// First column, and first two; last column.
const FIRST: u64 = 0x0101_0101_0101_0101;
const FIRST_TWO: u64 = 0x0303_0303_0303_0303;

/// Slices of cells that a brick's voxels need: two before it to one behind.
const SLICES: usize = BRICK + 3;

impl Needs {
    /// From the visible cells of 3 x 3 x 3 bricks, x fastest; `None` stands for a brick without any.
    pub(super) fn around(bricks: &[Option<&CellBits>; 27]) -> Option<Self> {
        if bricks.iter().all(Option::is_none) {
            return None;
        }
        let (mut near, mut far) = ([0u64; SLICES], [0u64; SLICES]);
        for slice in 0..SLICES {
            // Slice -2 of the middle brick is slice 6 of the one before.
            let (layer, z) = ((slice + BRICK - 2) / BRICK, (slice + BRICK - 2) % BRICK);
            let row = |y: usize| {
                let word = |x: usize| bricks[(layer * 3 + y) * 3 + x].map_or(0, |cells| cells[z]);
                along_x([word(0), word(1), word(2)])
            };
            let ((_, before), (middle_near, middle), (_, behind)) = (row(0), row(1), row(2));
            let (before_near, _) = row(0);
            near[slice] = middle_near | middle_near << 8 | before_near >> 56;
            far[slice] = middle
                | middle << 8
                | middle << 16
                | middle >> 8
                | before >> 56
                | before >> 48
                | behind << 56;
        }
        let needs = Self {
            near: std::array::from_fn(|z| near[z + 1] | near[z + 2]),
            far: std::array::from_fn(|z| far[z] | far[z + 1] | far[z + 2] | far[z + 3]),
        };
        needs.far.iter().any(|&bits| bits != 0).then_some(needs)
    }
}

/// Voxels of eight rows near a visible cell of theirs, and far, from the words of three bricks along x.
#[inline(always)]
fn along_x([before, own, behind]: [u64; 3]) -> (u64, u64) {
    let near = own | (own << 1 & !FIRST) | (before >> 7 & FIRST);
    let two = (own << 2 & !FIRST_TWO) | (before >> 6 & FIRST_TWO);
    let next = (own >> 1 & !(FIRST << 7)) | (behind << 7 & FIRST << 7);
    (near, near | two | next)
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol_testing::random::Random;

    #[test]
    fn shifts_find_what_counting_finds() {
        let mut random = Random::new(5);
        for round in 0..40 {
            let bricks: Vec<CellBits> = (0..27)
                .map(|_| std::array::from_fn(|_| (0..3 + round % 5).fold(!0, |bits, _| bits & random.bits())))
                .collect();
            let seen = |p: [isize; 3]| {
                let brick = p.map(|c| (c + 8) as usize / 8);
                let [x, y, z] = p.map(|c| (c + 8) as usize % 8);
                bricks[(brick[2] * 3 + brick[1]) * 3 + brick[0]][z] >> (8 * y + x) & 1 != 0
            };
            let any = |[x, y, z]: [isize; 3], below: isize, above: isize| {
                (-below..=above)
                    .any(|k| (-below..=above).any(|j| (-below..=above).any(|i| seen([x + i, y + j, z + k]))))
            };
            let needs = Needs::around(&std::array::from_fn(|i| Some(&bricks[i]))).unwrap();
            for i in 0..512isize {
                let p = [i % 8, i / 8 % 8, i / 64];
                let bit = |bits: &CellBits| bits[p[2] as usize] >> (8 * p[1] + p[0]) & 1 != 0;
                assert_eq!(bit(&needs.near), any(p, 1, 0), "{p:?}");
                assert_eq!(bit(&needs.far), any(p, 2, 1), "{p:?}");
            }
        }
        assert!(Needs::around(&[None; 27]).is_none());
    }
}
