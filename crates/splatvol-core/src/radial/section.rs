//! A section of a footprint table, for rasterisers: the part of a footprint between two depths, by squared
//! distance.

use super::table::MOST_ENTRIES;
use super::table::Spacing;

/// A number that tables hold.
pub trait Entry: Copy + Default + PartialEq + Send + Sync + 'static {
    /// The value of a whole footprint's centre.
    const FULL: f32;
    /// The row in front of the first section: zeros.
    const ZEROS: &'static [Self];
    /// The entry nearest to a share of the footprint's centre, 0 to 1.
    fn nearest(share: f64) -> Self;
    /// The entry as a number.
    fn number(self) -> f32;
    /// This entry minus another, as a number.
    #[inline(always)]
    fn less(self, other: Self) -> f32 {
        self.number() - other.number()
    }
}

impl Entry for u8 {
    const FULL: f32 = 255.0;
    const ZEROS: &'static [Self] = &[0; MOST_ENTRIES];

    fn nearest(share: f64) -> Self {
        (255.0 * share).round() as Self
    }

    #[inline(always)]
    fn number(self) -> f32 {
        f32::from(self)
    }

    #[inline(always)]
    fn less(self, other: Self) -> f32 {
        (i32::from(self) - i32::from(other)) as f32
    }
}

impl Entry for u16 {
    const FULL: f32 = 65535.0;
    const ZEROS: &'static [Self] = &[0; MOST_ENTRIES];

    fn nearest(share: f64) -> Self {
        (65535.0 * share).round() as Self
    }

    #[inline(always)]
    fn number(self) -> f32 {
        f32::from(self)
    }

    #[inline(always)]
    fn less(self, other: Self) -> f32 {
        (i32::from(self) - i32::from(other)) as f32
    }
}

impl Entry for f32 {
    const FULL: f32 = 1.0;
    const ZEROS: &'static [Self] = &[0.0; MOST_ENTRIES];

    fn nearest(share: f64) -> Self {
        share as Self
    }

    #[inline(always)]
    fn number(self) -> f32 {
        self
    }
}

/// The part of a kernel between two depths: the difference of two rows of a table. A rasteriser makes one per splat
/// and sheet, and looks it up per pixel.
#[derive(Debug, Clone, Copy)]
pub struct Section<'a, E> {
    pub(super) front: &'a [E],
    pub(super) back: &'a [E],
    /// The last entry's index.
    pub(super) last: f32,
    /// Value of an entry's unit.
    pub(super) unit: f32,
    pub(super) spacing: Spacing,
    /// Numbers of the rows that its depths fall on.
    pub(super) depths: [usize; 2],
}

impl<E: Entry> Section<'_, E> {
    /// The section's value at a squared distance in support radii, per square voxel; 0 beyond 1.
    #[inline(always)]
    pub fn at(&self, rho2: f32) -> f32 {
        match self.spacing {
            Spacing::Linear => self.at_position(rho2.sqrt()),
            Spacing::Squared => self.at_position(rho2),
        }
    }

    /// As [`Self::at`], at the table's own coordinate: the distance for linear spacing, its square for squared
    /// spacing. For loops that step this coordinate themselves.
    #[inline(always)]
    pub fn at_position(&self, position: f32) -> f32 {
        // Conversion saturates: positions beyond the last entry, which is zero, take that one; NaN takes the first.
        let index = (position * self.last + 0.5).min(self.last) as usize;
        match (self.back.get(index), self.front.get(index)) {
            (Some(back), Some(front)) => back.less(*front) * self.unit,
            _ => 0.0,
        }
    }

    /// Entries of the front row and of the back row, in equal number. For loops that step an index themselves, from
    /// 0 at the centre to the last entry at the support.
    #[inline(always)]
    pub fn rows(&self) -> [&[E]; 2] {
        [self.front, self.back]
    }

    /// Rows in front of each of its depths: 0 (nothing of the kernel) to the number of the table's sections (all of it).
    #[inline(always)]
    pub fn depths(&self) -> [usize; 2] {
        self.depths
    }

    /// Value of an entry's unit, per square voxel.
    #[inline(always)]
    pub fn unit(&self) -> f32 {
        self.unit
    }

    /// Whether both depths fall on the same row: the section is empty.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        std::ptr::eq(self.front, self.back)
    }
}

/// A section of a table whose precision was chosen at run time. Match once per splat, and look up within the arm.
#[derive(Debug, Clone, Copy)]
pub enum AnySection<'a> {
    /// 8 bits.
    U8(Section<'a, u8>),
    /// 16 bits.
    U16(Section<'a, u16>),
    /// Single precision.
    F32(Section<'a, f32>),
}

impl AnySection<'_> {
    /// The section's value at a squared distance in support radii, per square voxel.
    #[inline(always)]
    pub fn at(&self, rho2: f32) -> f32 {
        match self {
            Self::U8(section) => section.at(rho2),
            Self::U16(section) => section.at(rho2),
            Self::F32(section) => section.at(rho2),
        }
    }
}
