//! Filling a volume slice by slice, in parallel and without temporaries.

use rayon::prelude::*;

/// Samples (x fastest) whose slices `fill(z, slice)` writes; every slice is written by one thread only, so that the
/// result does not depend on their number.
pub(crate) fn slices<T>(dims: [usize; 3], fill: impl Fn(usize, &mut [T]) + Sync) -> Vec<T>
where
    T: Copy + Default + Send,
{
    let mut samples = vec![T::default(); dims.iter().product()];
    samples
        .par_chunks_mut(dims[0] * dims[1])
        .enumerate()
        .for_each(|(z, slice)| fill(z, slice));
    samples
}

/// Samples of a function of the voxel index.
pub(crate) fn voxels<T>(dims: [usize; 3], value: impl Fn([usize; 3]) -> T + Sync) -> Vec<T>
where
    T: Copy + Default + Send,
{
    slices(dims, |z, slice| {
        for (y, row) in slice.chunks_exact_mut(dims[0]).enumerate() {
            for (x, sample) in row.iter_mut().enumerate() {
                *sample = value([x, y, z]);
            }
        }
    })
}

/// Position of a voxel centre in [-1, 1]: `n` voxels with the first and the last on the ends.
pub(crate) fn unit_position(index: usize, n: usize) -> f64 {
    if n < 2 {
        return 0.0;
    }
    2.0 * index as f64 / (n as f64 - 1.0) - 1.0
}
