//! Voxels of a brick that a reconstruction needs: those near visible cells, found by shifts of whole slices.
//!
//! Voxel x touches cells x - 1 and x; a kernel of radius 2 reaches one cell further on both sides, a wide one two.
//! A slice of 8 x 8 cells is one word, so a step along x or y is a shift of the word, with the neighbouring brick's
//! bits shifted in.

use crate::brick::BRICK;

use super::cells::CellBits;

/// Voxels within one cell of a visible one, and within the kernel's radius: bit `8 y + x` of word z.
#[derive(Debug, Clone, Copy)]
pub(super) struct Needs {
    pub near: CellBits,
    pub far: CellBits,
}

/// Columns of a slice: its first, first two and first three.
const FIRST: [u64; 3] = [
    0x0101_0101_0101_0101,
    0x0303_0303_0303_0303,
    0x0707_0707_0707_0707,
];

/// Slices of cells that a brick's voxels need: from three before it to two behind it.
const SLICES: usize = BRICK + 5;

impl Needs {
    /// From the visible cells of 3 x 3 x 3 bricks, x fastest; `None` is a brick without any. `WIDE`: the kernel
    /// reaches three voxels, not two.
    #[inline(always)]
    pub(super) fn around<const WIDE: bool>(bricks: &[Option<&CellBits>; 27]) -> Option<Self> {
        // Whole columns of slices at a time, so that the loops below run in vectors.
        let mut words = [[[0u64; SLICES]; 3]; 3];
        for (i, cells) in bricks.iter().enumerate() {
            let Some(cells) = cells else { continue };
            let column = &mut words[i / 3 % 3][i % 3];
            match i / 9 {
                0 => column[..3].copy_from_slice(&cells[BRICK - 3..]),
                1 => column[3..BRICK + 3].copy_from_slice(&cells[..]),
                _ => column[BRICK + 3..].copy_from_slice(&cells[..2]),
            }
        }
        let (mut near, mut far) = ([0u64; SLICES], [0u64; SLICES]);
        for slice in 0..SLICES {
            let row =
                |y: usize| along_x::<WIDE>([words[y][0][slice], words[y][1][slice], words[y][2][slice]]);
            let ((near_before, before), (own_near, own), (_, behind)) = (row(0), row(1), row(2));
            near[slice] = own_near | own_near << 8 | near_before >> 56;
            far[slice] = own | own << 8 | own << 16 | own >> 8 | before >> 56 | before >> 48 | behind << 56;
            if WIDE {
                far[slice] |= own << 24 | own >> 16 | before >> 40 | behind << 48;
            }
        }
        let mut needs = Self {
            near: [0; BRICK],
            far: [0; BRICK],
        };
        let mut any = 0;
        for z in 0..BRICK {
            needs.near[z] = near[z + 2] | near[z + 3];
            needs.far[z] = far[z + 1] | far[z + 2] | far[z + 3] | far[z + 4];
            if WIDE {
                needs.far[z] |= far[z] | far[z + 5];
            }
            any |= needs.far[z];
        }
        (any != 0).then_some(needs)
    }
}

/// Voxels of eight rows near a visible cell of theirs, and far, from the words of three bricks along x.
#[inline(always)]
fn along_x<const WIDE: bool>([before, own, behind]: [u64; 3]) -> (u64, u64) {
    // Cells so many voxels before each, and behind it.
    let later = |n: usize| (own << n & !FIRST[n - 1]) | (before >> (8 - n) & FIRST[n - 1]);
    let sooner = |n: usize| {
        let last = FIRST[n - 1] << (8 - n);
        (own >> n & !last) | (behind << (8 - n) & last)
    };
    let near = own | later(1);
    let far = near | later(2) | sooner(1);
    (near, if WIDE { far | later(3) | sooner(2) } else { far })
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
            let around = std::array::from_fn(|i| Some(&bricks[i]));
            let needs = Needs::around::<false>(&around).unwrap();
            let wide = Needs::around::<true>(&around).unwrap();
            for i in 0..512isize {
                let p = [i % 8, i / 8 % 8, i / 64];
                let bit = |bits: &CellBits| bits[p[2] as usize] >> (8 * p[1] + p[0]) & 1 != 0;
                assert_eq!(bit(&needs.near), any(p, 1, 0), "{p:?}");
                assert_eq!(bit(&needs.far), any(p, 2, 1), "{p:?}");
                assert_eq!(bit(&wide.near), any(p, 1, 0), "{p:?}");
                assert_eq!(bit(&wide.far), any(p, 3, 2), "{p:?}");
            }
        }
        assert!(Needs::around::<true>(&[None; 27]).is_none());
    }
}
