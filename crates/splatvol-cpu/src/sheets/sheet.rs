//! Shapes of the four sheets that a voxel meets, for splatting.

use splatvol_core::plan::SheetShape;

use super::ring::LANES;

/// A vector of sixteen numbers in memory.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub(crate) struct Lanes16(pub [f32; 16]);

impl Lanes16 {
    /// Sheet `i % 4` in lane i.
    fn of_sheets(value: impl Fn(usize) -> f32) -> Self {
        Self(std::array::from_fn(|lane| value(lane % LANES)))
    }
}

/// The four sheets of a group while the voxels of one slab are splatted.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GroupShape {
    pub depth: Lanes16,
    pub scale: Lanes16,
    /// Negative exponents: `log2` of the footprint is `xx dx^2 + xy dx dy + yy dy^2`.
    pub xx: Lanes16,
    pub xy: Lanes16,
    pub yy: Lanes16,
    pub peak: Lanes16,
}

impl GroupShape {
    /// One sheet in all lanes.
    pub(crate) fn same(sheet: &SheetShape) -> Self {
        let lanes = |value: f32| Lanes16([value; 16]);
        Self {
            depth: lanes(sheet.depth),
            scale: lanes(sheet.scale),
            xx: lanes(-sheet.exponent[0]),
            xy: lanes(-sheet.exponent[1]),
            yy: lanes(-sheet.exponent[2]),
            peak: lanes(sheet.peak),
        }
    }

    /// The group's sheets among `first..first + 4 groups`: lane l holds the one whose index is l, modulo the ring.
    pub(crate) fn new(sheets: &[SheetShape], first: isize, group: usize, groups: usize) -> Self {
        let open = (groups * LANES) as isize;
        let at = |lane: usize| {
            let slot = (group * LANES + lane) as isize;
            let index = first + (slot - first).rem_euclid(open);
            let valid = index >= 0 && (index as usize) < sheets.len();
            let nearest = (index.max(0) as usize).min(sheets.len() - 1);
            (sheets[nearest], valid)
        };
        let four: [_; LANES] = std::array::from_fn(at);
        let of = |pick: fn(&SheetShape) -> f32| Lanes16::of_sheets(|l| pick(&four[l].0));
        Self {
            depth: of(|s| s.depth),
            scale: of(|s| s.scale),
            xx: of(|s| -s.exponent[0]),
            xy: of(|s| -s.exponent[1]),
            yy: of(|s| -s.exponent[2]),
            peak: Lanes16::of_sheets(|l| if four[l].1 { four[l].0.peak } else { 0.0 }),
        }
    }
}
