//! Kernels of meshes: a Gaussian per sample whose covariance follows the cells around it.
//!
//! On a regular grid the kernel of a voxel has covariance `sigma^2 I` in voxels. A mesh has cells instead of
//! voxels; the cells around a sample define the distance to its neighbours: `V = sigma^2 J J^T` with J the
//! derivative of space by the index (zwicker2001 section 3: the kernel is warped by the local affine map). Without
//! indices, the second moments of the sample's region replace J: those of a voxel are `I / 12`, so
//! `V = 12 sigma^2 M`. The mass of a kernel is the volume of that region, so that a constant field stays constant:
//! `sum_i m_i N(x; p_i, V_i) = 1` inside.
//!
//! Wherever the map is affine, that is exact up to the regular grid's own ripple. Where cells change size, the sum
//! has an error of the square of their change per kernel width, which varies slowly; sweeps of
//! `m_i <- m_i / sum_j m_j N(p_i; p_j, V_j)` remove it (`normalise`). Where cells differ from neighbour to
//! neighbour, as tetrahedra do, covariances are first averaged over neighbours and widened (`unstructured`). Where
//! they jump, a sample is replaced by kernels of pieces of its region (`resample`).
//!
//! Measured (tests), largest of 400 places away from the border: 0.2 % on spacing that grows by up to 1.15 per
//! cell, 0.7 % at 1.3, 0.01 % sheared, 0.2 % curvilinear; cells of a lattice whose points are moved by up to 0.15
//! and 0.25 of it: tetrahedra 1.3 and 1.9 % (points), 1.3 and 2.4 % (cells), hexahedra 0.9 and 1.5 %, 1.6 and 2.5
//! %.
//!
//! Resampled, with values on points, and in brackets with one kernel per sample: spacing that jumps from 1 to 8
//! along two axes 0.9 % (49), layers that double from 1:50 on 0.9 % (25; cells 1.2, 23), shear of 70 degrees that
//! sets in at once 0.4 % (0.4), that turns over at each layer 1.2 % (3.9); tetrahedra whose spacing jumps from 1 to
//! 8 0.6 % (6.6; cells 0.4, 35), hexahedra 0.9 % (7.3).
//!
//! Structured points moved at random have the largest errors: moved by up to 0.05, 0.1 and 0.25 of their spacing,
//! 4, 8 and 6 % (22 % with one kernel per sample). Unlike those of unstructured cells, their covariances are not
//! averaged over neighbours.
//!
//! Beyond the border structured grids are continued, so that samples there keep the mass of a whole cell, like
//! voxels; points on the border of unstructured cells have only the part inside.

mod adjacency;
mod blocks;
mod corners;
mod gradation;
mod gradient;
mod lattice_kernels;
mod lattice_regions;
mod moments;
mod normalise;
mod packets;
mod pieces;
mod prefilter;
mod reference_cell;
mod resample;
mod structured;

mod tree;
mod unstructured;
mod whitening;

#[cfg(test)]
mod tests;

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use splatvol_scene::{Mesh, Topology};

pub use resample::{MOST_PER_SAMPLE, Resampling};

/// Kernels of a mesh, in its local space. All fields are of one length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshKernels {
    /// Centres.
    pub positions: Vec<[f32; 3]>,
    /// Covariances: xx, xy, xz, yy, yz, zz.
    pub covariances: Vec<[f32; 6]>,
    /// Integral of each kernel over local volume.
    pub masses: Vec<f32>,
    /// Values; all finite.
    pub values: Vec<f32>,
    /// Gradients of the value per local unit.
    pub gradients: Vec<[f32; 3]>,
    /// Report of the resampling where samples were too few.
    pub resampling: Resampling,
}

/// The kernels of a mesh, with standard deviation `sigma` in units of its cells (a regular grid's voxels). Missing
/// or blanked samples have none, and neither have samples whose cells have no volume. The result is the same for
/// any number of threads.
pub fn kernels(mesh: &Mesh, sigma: f64) -> MeshKernels {
    let (samples, resampling) = match mesh.topology() {
        Topology::Structured(blocks) => blocks::samples(mesh, blocks, sigma),
        Topology::Unstructured(cells) => unstructured::samples(mesh, cells, sigma),
    };
    MeshKernels::of(&samples, resampling)
}

/// A sample with its kernel, before its visibility is known.
#[derive(Debug, Clone, Copy)]
struct Sample {
    position: DVec3,
    covariance: DMat3,
    mass: f64,
    gradient: DVec3,
    value: f32,
    /// False where the sample is blanked or its cells are flat.
    valid: bool,
}

impl Sample {
    /// The value that the gradient leads to, within a range.
    fn value_at(&self, place: DVec3, [low, high]: [f32; 2]) -> f64 {
        let value = f64::from(self.value) + self.gradient.dot(place - self.position);
        value.max(f64::from(low)).min(f64::from(high))
    }
}

impl MeshKernels {
    fn of(samples: &[Sample], resampling: Resampling) -> Self {
        let seen: Vec<&Sample> = samples
            .iter()
            .filter(|sample| sample.valid && sample.value.is_finite() && sample.mass > 0.0)
            .collect();
        Self {
            positions: seen.par_iter().map(|s| s.position.as_vec3().to_array()).collect(),
            covariances: seen.par_iter().map(|s| symmetric(&s.covariance)).collect(),
            masses: seen.par_iter().map(|s| s.mass as f32).collect(),
            values: seen.par_iter().map(|s| s.value).collect(),
            gradients: seen.par_iter().map(|s| s.gradient.as_vec3().to_array()).collect(),
            resampling,
        }
    }

    /// Number of kernels.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// True where there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }
}

fn symmetric(m: &DMat3) -> [f32; 6] {
    [
        m.x_axis.x, m.y_axis.x, m.z_axis.x, m.y_axis.y, m.z_axis.y, m.z_axis.z,
    ]
    .map(|v| v as f32)
}

fn position(mesh: &Mesh, point: usize) -> DVec3 {
    DVec3::from_array(mesh.positions()[point].map(f64::from))
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
