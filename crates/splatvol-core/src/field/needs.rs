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
    #[inline(always)]
    pub(super) fn around(bricks: &[Option<&CellBits>; 27]) -> Option<Self> {
        // Whole columns of slices at a time, so that the loops below run in vectors.
        let mut words = [[[0u64; SLICES]; 3]; 3];
        for (i, cells) in bricks.iter().enumerate() {
            let Some(cells) = cells else { continue };
            let column = &mut words[i / 3 % 3][i % 3];
            match i / 9 {
                0 => column[..2].copy_from_slice(&cells[BRICK - 2..]),
                1 => column[2..BRICK + 2].copy_from_slice(&cells[..]),
                _ => column[BRICK + 2] = cells[0],
            }
        }
        let (mut near, mut far) = ([0u64; SLICES], [0u64; SLICES]);
        for slice in 0..SLICES {
            let row = |y: usize| along_x([words[y][0][slice], words[y][1][slice], words[y][2][slice]]);
            let ((near_before, before), (own_near, own), (_, behind)) = (row(0), row(1), row(2));
            near[slice] = own_near | own_near << 8 | near_before >> 56;
            let own = own | own << 8 | own << 16 | own >> 8;
            far[slice] = own | before >> 56 | before >> 48 | behind << 56;
        }
        let mut needs = Self {
            near: [0; BRICK],
            far: [0; BRICK],
        };
        let mut any = 0;
        for z in 0..BRICK {
            needs.near[z] = near[z + 1] | near[z + 2];
            needs.far[z] = far[z] | far[z + 1] | far[z + 2] | far[z + 3];
            any |= needs.far[z];
        }
        (any != 0).then_some(needs)
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
