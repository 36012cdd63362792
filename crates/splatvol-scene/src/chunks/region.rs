//! Regions put together from chunks.

use super::{ChunkBuffer, ChunkContent, ChunkFault, ChunkSource, SourceError};
use crate::{Samples, VoxelBox};

/// Copies the samples that two boxes share, from one to the other. False where the types differ; nothing is copied then.
pub fn copy_box(from: &Samples, of: VoxelBox, into: &mut Samples, to: VoxelBox) -> bool {
    macro_rules! pairs {
        ($($variant:ident)*) => {
            match (from, into) {
                $((Samples::$variant(from), Samples::$variant(into)) => {
                    copy_rows(from, of, into.to_mut(), to);
                    true
                })*
                _ => false,
            }
        };
    }
    pairs!(U8 I8 U16 I16 U32 I32 F32 F64)
}

/// First sample and one past the last, along each axis, that two boxes share.
fn shared(a: VoxelBox, b: VoxelBox) -> [[usize; 2]; 3] {
    std::array::from_fn(|axis| {
        let end = |of: VoxelBox| of.first[axis] + of.size[axis];
        let first = a.first[axis].max(b.first[axis]);
        [first, end(a).min(end(b)).max(first)]
    })
}

fn copy_rows<T: Copy>(from: &[T], of: VoxelBox, into: &mut [T], to: VoxelBox) {
    let [[x, x_end], [y, y_end], [z, z_end]] = shared(of, to);
    if x == x_end {
        return;
    }
    for z in z..z_end {
        for y in y..y_end {
            let row = &of.row(from, [y, z])[x - of.first[0]..x_end - of.first[0]];
            let start = ((z - to.first[2]) * to.size[1] + y - to.first[1]) * to.size[0] + x - to.first[0];
            into[start..start + row.len()].copy_from_slice(row);
        }
    }
}

/// Reads a region chunk by chunk: what [`ChunkSource::read_region`] does where a source knows no better.
///
/// # Errors
/// Those of [`ChunkSource::read`], and chunks of another type than their level's.
pub fn read_by_chunks<S: ChunkSource + ?Sized>(
    source: &S,
    level: usize,
    region: VoxelBox,
    into: &mut Samples,
    buffer: &mut ChunkBuffer,
) -> Result<(), SourceError> {
    let layout = &source.levels()[level];
    into.refill(layout.element, region.len(), layout.fill);
    for chunk in layout.chunks_of(region) {
        let of = layout.region(chunk);
        if let ChunkContent::Constant(value) = source.read(level, chunk, buffer)? {
            if value.to_bits() == layout.fill.to_bits() {
                continue;
            }
            buffer.samples.refill(layout.element, of.len(), value);
        }
        if !copy_box(&buffer.samples, of, into, region) {
            return Err(of_another_type(source, level, chunk, &buffer.samples));
        }
    }
    Ok(())
}

fn of_another_type<S: ChunkSource + ?Sized>(
    source: &S,
    level: usize,
    chunk: [usize; 3],
    found: &Samples,
) -> SourceError {
    let promised = source.levels()[level].element.name();
    SourceError::Refused(Box::new(ChunkFault {
        level,
        chunk,
        key: source.identity().name,
        codec: None,
        offset: 0,
        reason: format!("samples of type {}; the level has {promised}", found.type_name()),
    }))
}
