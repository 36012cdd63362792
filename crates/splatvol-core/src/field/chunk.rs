//! Chunks: coefficients of a part of the lattice, stored as bricks in 16 bits.
//!
//! The interpolating coefficients of docs/numerics.md are the solution of banded systems along the axes
//! ([`AxisSolver`]). An error in one row falls geometrically along the axis (by 0.27 per voxel for sigma 0.605,
//! radius 2). So a part of the lattice with a halo of some ten points on each side has the solution of the whole
//! lattice, up to [`CUT_SHARE`]. At the lattice's own faces the part's system is the whole's, border included.

use splatvol_scene::VoxelBox;

use crate::brick::BRICK;
use crate::kernel::GaussianKernel;
use crate::prefilter::{AxisSolver, BLOCK, transpose};
use crate::visibility::{BRICK_VOXELS, TOLERANCE};

use super::cells::{CellBits, pack};
use super::lattice::{Block, Lattice, StoredSample};
use super::needs::Needs;

/// Bricks of a chunk along x, y, z: the unit of solving, which fits a core's own cache together with its halo.
pub(super) const CHUNK: [usize; 3] = [8, 4, 4];
/// Lattice points of a chunk along x, y, z.
const SPAN: [usize; 3] = [CHUNK[0] * BRICK, CHUNK[1] * BRICK, CHUNK[2] * BRICK];
/// Bound on the error inside the chunk from an error of 1 at the edge of the halo.
const CUT_SHARE: f64 = 1e-6;
/// Marks the absence of a coefficient: the sample is missing, or the point lies outside the lattice.
const MISSING: u16 = u16::MAX;
/// Largest stored coefficient.
const STEPS: f32 = 65_534.0;

/// Words of a packed brick: offset, scale, whether samples are missing, an unused one; needed voxels; values.
pub const PACKED: usize = 4 + 2 * BRICK + BRICK_VOXELS / 2;

/// Coefficients of a brick, `offset + scale * stored`: half a step, 1/131068 of their range in the brick, from the
/// solution.
#[derive(Debug, Clone)]
pub(super) struct StoredBrick {
    values: [u16; BRICK_VOXELS],
    offset: f32,
    scale: f32,
    has_gaps: bool,
}

impl StoredBrick {
    /// Quantises coefficients, NaN where there are none.
    #[inline(always)]
    fn new(values: &[f32; BRICK_VOXELS]) -> Self {
        let (mut low, mut high) = ([f32::INFINITY; BRICK], [f32::NEG_INFINITY; BRICK]);
        let mut has_gaps = false;
        for row in values.chunks_exact(BRICK) {
            for x in 0..BRICK {
                // Comparisons with NaN are false.
                low[x] = if row[x] < low[x] { row[x] } else { low[x] };
                high[x] = if row[x] > high[x] { row[x] } else { high[x] };
                has_gaps |= row[x].is_nan();
            }
        }
        let low = low.into_iter().fold(f32::INFINITY, f32::min);
        let high = high.into_iter().fold(f32::NEG_INFINITY, f32::max);
        let (offset, width) = if low <= high {
            (low, high - low)
        } else {
            (0.0, 0.0)
        };
        let steps = if width > 0.0 { STEPS / width } else { 0.0 };
        let mut stored = [MISSING; BRICK_VOXELS];
        for (stored, value) in stored.iter_mut().zip(values) {
            let step = ((value - offset) * steps + 0.5).min(STEPS) as i32;
            *stored = if value.is_nan() { MISSING } else { step as u16 };
        }
        Self {
            values: stored,
            offset,
            scale: width / STEPS,
            has_gaps,
        }
    }

    /// Reads a value of every cache line.
    #[inline(always)]
    pub(super) fn touch(&self) {
        for line in self.values.as_chunks::<32>().0 {
            std::hint::black_box(line[0]);
        }
    }

    /// Coefficients less the background where the mask has a bit, infinite where they are missing; else NaN.
    #[inline(always)]
    pub(super) fn decode(&self, mask: &CellBits, background: f32, out: &mut [f32; BRICK_VOXELS]) {
        let (scale, offset) = (self.scale, self.offset - background);
        let rows = out.as_chunks_mut::<BRICK>().0.iter_mut();
        for (i, (out, stored)) in rows.zip(self.values.as_chunks::<BRICK>().0).enumerate() {
            let bits = (mask[i / BRICK] >> (BRICK * (i % BRICK))) as u8;
            for x in 0..BRICK {
                let value = f32::from(stored[x]) * scale + offset;
                out[x] = if bits & 1 << x != 0 { value } else { f32::NAN };
            }
        }
        if self.has_gaps {
            for (out, stored) in out.iter_mut().zip(&self.values) {
                let missing = *stored == MISSING && !out.is_nan();
                *out = if missing { f32::INFINITY } else { *out };
            }
        }
    }

    /// As [`Self::decode`], for [`super::FieldStore::pack`].
    pub(super) fn pack(&self, mask: &CellBits, background: f32, out: &mut [u32; PACKED]) {
        let header = [
            (self.offset - background).to_bits(),
            self.scale.to_bits(),
            u32::from(self.has_gaps),
            0,
        ];
        let bits = mask
            .iter()
            .flat_map(|&plane| [plane as u32, (plane >> 32) as u32]);
        let values = self.values.as_chunks::<2>().0.iter();
        let pairs = values.map(|&[low, high]| u32::from(low) | u32::from(high) << 16);
        let words = header.into_iter().chain(bits).chain(pairs);
        for (out, word) in out.iter_mut().zip(words) {
            *out = word;
        }
    }

    /// Voxels that a reconstruction needs: all near ones, and the far ones that differ from the background or are
    /// missing. `existing`: the voxels on the lattice.
    #[inline(always)]
    pub(super) fn mask(&self, needs: &Needs, background: f32, existing: &CellBits) -> CellBits {
        let (scale, offset) = (self.scale, self.offset - background);
        let mut mask = needs.near;
        if offset > TOLERANCE || offset + scale * STEPS < -TOLERANCE {
            mask = needs.far;
        } else if offset < -TOLERANCE || offset + scale * STEPS > TOLERANCE {
            for (z, slice) in self.values.as_chunks::<{ BRICK * BRICK }>().0.iter().enumerate() {
                let undecided = needs.far[z] & !needs.near[z];
                if undecided != 0 {
                    mask[z] |= undecided
                        & slice_bits(slice, |stored| {
                            (f32::from(stored) * scale + offset).abs() > TOLERANCE
                        });
                }
            }
        }
        if self.has_gaps {
            for (z, slice) in self.values.as_chunks().0.iter().enumerate() {
                let gaps = slice_bits(slice, |stored| stored == MISSING);
                mask[z] = (mask[z] & !gaps) | (needs.far[z] & gaps & existing[z]);
            }
        }
        mask
    }
}

/// A bit for each of the 8 x 8 values, set where `holds` is true.
#[inline(always)]
fn slice_bits(slice: &[u16; BRICK * BRICK], holds: impl Fn(u16) -> bool) -> u64 {
    let mut bits = 0;
    for (y, row) in slice.as_chunks::<BRICK>().0.iter().enumerate() {
        bits |= pack(row.map(|stored| u8::from(holds(stored)))) << (BRICK * y);
    }
    bits
}

/// Solves the lattice part by part.
#[derive(Debug, Clone)]
pub(super) struct ChunkSolver {
    /// Solvers along the axes; `None` where samples are their own coefficients.
    axes: Option<[AxisSolver; 3]>,
    halo: [usize; 3],
}

/// Memory of one thread.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    plane: Vec<f32>,
    lines: Vec<f32>,
    slab: Vec<f32>,
}

/// A chunk's points along an axis: the solved ones, and those with the halo.
#[derive(Debug, Clone, Copy)]
struct Extent {
    from: usize,
    to: usize,
    outer_from: usize,
    outer_to: usize,
}

impl Extent {
    fn len(&self) -> usize {
        self.to - self.from
    }

    fn outer(&self) -> usize {
        self.outer_to - self.outer_from
    }

    fn skip(&self) -> usize {
        self.from - self.outer_from
    }
}

impl ChunkSolver {
    /// Solver for coefficients that interpolate the samples.
    pub(super) fn new(kernel: &GaussianKernel, lattice: &Lattice) -> Self {
        let axes = lattice.dims.map(|count| AxisSolver::new(kernel, count));
        Self {
            halo: std::array::from_fn(|a| axes[a].halo(CUT_SHARE)),
            axes: Some(axes),
        }
    }

    /// Solver whose coefficients are the samples themselves.
    pub(super) fn of_samples() -> Self {
        Self {
            axes: None,
            halo: [0; 3],
        }
    }

    /// Whether coefficients interpolate the samples.
    pub(super) fn interpolates(&self) -> bool {
        self.axes.is_some()
    }

    fn extents(&self, lattice: &Lattice, first: [usize; 3]) -> [Extent; 3] {
        std::array::from_fn(|a| {
            let to = (first[a] + SPAN[a]).min(lattice.dims[a]);
            Extent {
                from: first[a],
                to,
                outer_from: first[a].saturating_sub(self.halo[a]),
                outer_to: (to + self.halo[a]).min(lattice.dims[a]),
            }
        })
    }

    /// The samples from which the chunk that begins at lattice point `first` is solved.
    pub(super) fn region(&self, lattice: &Lattice, first: [usize; 3]) -> VoxelBox {
        let extents = self.extents(lattice, first);
        lattice.region(extents.map(|e| e.outer_from), extents.map(|e| e.outer_to))
    }

    /// Solves for the chunk that begins at lattice point `first`.
    pub(super) fn solve<T: StoredSample>(
        &self,
        lattice: &Lattice,
        data: &Block<'_, T>,
        first: [usize; 3],
        scratch: &mut Scratch,
    ) -> Solved {
        let [x, y, z] = self.extents(lattice, first);
        let (width, plane) = (x.outer(), x.len() * y.len());
        let Scratch {
            plane: slice,
            lines,
            slab,
        } = scratch;
        slice.resize(width * y.outer(), 0.0);
        lines.resize(width * BLOCK, 0.0);
        slab.resize(plane * z.outer(), 0.0);
        for (at, out) in (z.outer_from..z.outer_to).zip(slab.chunks_exact_mut(plane)) {
            let slice = &mut slice[..width * y.outer()];
            let lines = &mut lines[..width * BLOCK];
            let Some(axes) = &self.axes else {
                vectorized!(lattice.simd, load(lattice, data, [x, y], at, out));
                continue;
            };
            vectorized!(lattice.simd, load(lattice, data, [x, y], at, slice));
            vectorized!(lattice.simd, solve_slice(axes, (slice, lines), [x, y], out));
        }
        if let Some([_, _, along_z]) = &self.axes {
            let slab = &mut slab[..plane * z.outer()];
            vectorized!(lattice.simd, along_z.solve_rows(slab, z.outer_from, plane, plane));
        }
        Solved {
            size: [x, y, z].map(|e| e.len()),
            skip: z.skip() * plane,
        }
    }
}

/// Solves a slice with its halo along y and x, and leaves the chunk's own points in `out`. `lines`: memory.
#[inline(always)]
fn solve_slice(
    [along_x, along_y, _]: &[AxisSolver; 3],
    (slice, lines): (&mut [f32], &mut [f32]),
    [x, y]: [Extent; 2],
    out: &mut [f32],
) {
    let width = x.outer();
    along_y.solve_rows(slice, y.outer_from, width, width);
    let rows = &slice[y.skip() * width..][..y.len() * width];
    transpose(rows, lines, width, y.len());
    along_x.solve_rows(lines, x.outer_from, BLOCK, y.len());
    transpose_columns(&lines[x.skip() * BLOCK..], out, x.len());
}

/// Position of a chunk's coefficients in the scratch memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solved {
    size: [usize; 3],
    skip: usize,
}

impl Solved {
    /// The brick at a place of the chunk.
    pub(super) fn brick<T: StoredSample>(
        &self,
        scratch: &Scratch,
        lattice: &Lattice,
        data: &Block<'_, T>,
        ([x, y, z], first): ([usize; 3], [usize; 3]),
    ) -> StoredBrick {
        let mut values = [f32::NAN; BRICK_VOXELS];
        let [nx, ny, nz] = self.size;
        let width = BRICK.min(nx - x);
        for dz in 0..BRICK.min(nz - z) {
            for dy in 0..BRICK.min(ny - y) {
                let start = self.skip + ((z + dz) * ny + y + dy) * nx + x;
                let out = &mut values[(dz * BRICK + dy) * BRICK..][..BRICK];
                out[..width].copy_from_slice(&scratch.slab[start..start + width]);
                if lattice.any_missing {
                    let row = lattice.row(data, [first[1] + y + dy, first[2] + z + dz]);
                    let mut samples = [data.any(); BRICK];
                    lattice.points(row, first[0] + x, &mut samples[..width]);
                    for (value, sample) in out[..width].iter_mut().zip(samples) {
                        if !lattice.normalised(sample).is_finite() {
                            *value = f32::NAN;
                        }
                    }
                }
            }
        }
        vectorized!(lattice.simd, StoredBrick::new(&values))
    }
}

/// Normalised values of a slice of a chunk.
#[inline(always)]
fn load<T: StoredSample>(
    lattice: &Lattice,
    data: &Block<'_, T>,
    [x, y]: [Extent; 2],
    z: usize,
    slice: &mut [f32],
) {
    for (y, out) in (y.outer_from..y.outer_to).zip(slice.chunks_exact_mut(x.outer())) {
        lattice.fill(data, (x.outer_from, [y, z]), out);
    }
}

/// Transposes columns of [`BLOCK`] lines back to rows, as many as `rows` holds.
#[inline(always)]
fn transpose_columns(lines: &[f32], rows: &mut [f32], width: usize) {
    for (line, row) in rows.chunks_exact_mut(width).enumerate() {
        for (x, value) in row.iter_mut().enumerate() {
            *value = lines[x * BLOCK + line];
        }
    }
}
