//! Division of levels into chunks, and types of samples.

use crate::{Grid, Rescale, Samples, Storage, VoxelBox};

/// Makes [`ElementType`] and what depends on the type alone.
macro_rules! element_types {
    ($($variant:ident $type:ty;)*) => {
        /// Type of a sample in memory.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum ElementType {
            $(
                #[doc = concat!("`", stringify!($type), "`.")]
                $variant,
            )*
        }

        impl ElementType {
            /// Every type.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Bytes of a sample.
            pub fn size(self) -> usize {
                match self { $(Self::$variant => size_of::<$type>(),)* }
            }

            /// `u8`, `i16`, `f32`...
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => stringify!($type),)* }
            }

            /// True for numbers with fractions.
            pub fn is_float(self) -> bool {
                matches!(self, Self::F32 | Self::F64)
            }

            /// `count` samples of one value, which must be one of the type.
            pub fn filled(self, count: usize, value: f64) -> Samples {
                match self {
                    $(Self::$variant => Samples::$variant(Storage::from(vec![value as $type; count])),)*
                }
            }
        }

        impl Samples {
            /// Type of the samples.
            pub fn element_type(&self) -> ElementType {
                match self { $(Self::$variant(_) => ElementType::$variant,)* }
            }

            /// Makes this `count` samples of a type and one value. Memory of the same type is used again.
            pub fn refill(&mut self, element: ElementType, count: usize, value: f64) {
                match (self, element) {
                    $((Self::$variant(samples), ElementType::$variant) => {
                        let samples = samples.to_mut();
                        samples.clear();
                        samples.resize(count, value as $type);
                    })*
                    (samples, element) => *samples = element.filled(count, value),
                }
            }
        }
    };
}

element_types! {
    U8 u8;
    I8 i8;
    U16 u16;
    I16 i16;
    U32 u32;
    I32 i32;
    F32 f32;
    F64 f64;
}

/// A level of detail and its division into chunks.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelLayout {
    /// Grid of the samples.
    pub grid: Grid,
    /// Samples of a chunk along x, y, z; chunks at the far ends may have fewer.
    pub chunk: [usize; 3],
    /// Type of the samples.
    pub element: ElementType,
    /// Conversion of stored samples to real values.
    pub rescale: Rescale,
    /// Stored value of samples that no chunk holds.
    pub fill: f64,
}

impl LevelLayout {
    /// Chunks along x, y, z.
    pub fn counts(&self) -> [usize; 3] {
        let dims = self.grid.dims();
        std::array::from_fn(|axis| dims[axis].div_ceil(self.chunk[axis]))
    }

    /// The samples of a chunk.
    pub fn region(&self, chunk: [usize; 3]) -> VoxelBox {
        let first: [usize; 3] = std::array::from_fn(|axis| chunk[axis] * self.chunk[axis]);
        let dims = self.grid.dims();
        VoxelBox {
            first,
            size: std::array::from_fn(|axis| self.chunk[axis].min(dims[axis].saturating_sub(first[axis]))),
        }
    }

    /// The chunks that hold samples of a region, x fastest.
    pub fn chunks_of(&self, region: VoxelBox) -> impl Iterator<Item = [usize; 3]> + use<> {
        let place = |sample: usize, axis: usize| sample / self.chunk[axis];
        let first: [usize; 3] = std::array::from_fn(|axis| place(region.first[axis], axis));
        let count: [usize; 3] = std::array::from_fn(|axis| match region.size[axis] {
            0 => 0,
            size => place(region.first[axis] + size - 1, axis) + 1 - first[axis],
        });
        (0..count.iter().product()).map(move |index| {
            let at = [
                index % count[0],
                index / count[0] % count[1],
                index / (count[0] * count[1]),
            ];
            std::array::from_fn(|axis| first[axis] + at[axis])
        })
    }

    /// Bytes of the samples in memory.
    pub fn bytes(&self) -> u64 {
        let size = self.element.size() as u64;
        self.grid
            .dims()
            .iter()
            .fold(size, |bytes, &dim| bytes.saturating_mul(dim as u64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn chunks_cover_a_level_once() {
        let layout = LevelLayout {
            grid: Grid::centred([7, 4, 1], DVec3::ONE).unwrap(),
            chunk: [3, 2, 5],
            element: ElementType::U16,
            rescale: Rescale::default(),
            fill: 0.0,
        };
        assert_eq!(layout.counts(), [3, 2, 1]);
        let chunks: Vec<_> = layout.chunks_of(VoxelBox::whole(&layout.grid)).collect();
        assert_eq!(chunks.len(), 6);
        let samples: usize = chunks.iter().map(|&chunk| layout.region(chunk).len()).sum();
        assert_eq!((samples, layout.bytes()), (28, 56));
        let part = VoxelBox {
            first: [2, 2, 0],
            size: [2, 1, 1],
        };
        assert_eq!(layout.chunks_of(part).collect::<Vec<_>>(), [[0, 1, 0], [1, 1, 0]]);
        assert_eq!(layout.region([2, 1, 0]).size, [1, 2, 1]);
    }

    #[test]
    fn every_type_fills_and_refills() {
        let mut samples = ElementType::F64.filled(3, 2.5);
        for &element in ElementType::ALL {
            samples.refill(element, 4, 7.0);
            assert_eq!((samples.element_type(), samples.len()), (element, 4));
            assert_eq!(samples.type_name(), element.name());
            assert_eq!(samples, element.filled(4, 7.0));
        }
    }
}
