//! The cloud: kernels in their own space.

use glam::{DAffine3, DMat3};

/// Kernels with centres, payloads and covariances, in *local* space (a grid's voxel indices).
#[derive(Debug, Clone)]
pub struct SplatCloud {
    /// Local space to world.
    pub world_from_local: DAffine3,
    /// Centres, local.
    pub positions: Vec<[f32; 3]>,
    /// Payload of each splat. Classified splats: extinction per world length and emission (extinction times linear
    /// rgb). Unclassified: normalised value, one, and two zeros.
    pub payloads: Vec<[f32; 4]>,
    /// Gradients of the normalised value per local unit; empty where they are not needed.
    pub gradients: Vec<[f32; 3]>,
    /// Covariances.
    pub shape: KernelShape,
    /// Covariances of ellipsoids, local: xx, xy, xz, yy, yz, zz; empty for other shapes.
    pub covariances: Vec<[f32; 6]>,
    /// Index of the first splat that carries an optical depth in place of an extinction. It is that of a ray
    /// through the centre in any direction: 3-D Gaussians have their peak's opacity in every view.
    pub peaks_from: usize,
    /// Integral of each kernel over space, world volume: a grid's cell.
    pub mass: f64,
    /// Geometric mean of the distance between neighbours, world length.
    pub spacing: f64,
    /// Neighbouring splats, contiguous.
    pub chunks: Vec<Chunk>,
}

/// Covariances of a cloud's kernels, local space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KernelShape {
    /// Spheres of one standard deviation.
    Sphere {
        /// Standard deviation, local units.
        sigma: f64,
    },
    /// Spheres flattened along the gradient (zwicker2001 section 5): `sigma^2 (I - (1 - 1 / flatness^2) n n^T)`.
    Flattened {
        /// Standard deviation across the gradient, local units.
        sigma: f64,
        /// Divisor of the standard deviation along the gradient.
        flatness: f64,
        /// Least gradient of the normalised value, per mean spacing, at which kernels are flattened.
        threshold: f64,
    },
    /// Ellipsoids, with a covariance for each splat.
    Ellipsoids {
        /// Largest standard deviation of any, local units.
        largest: f64,
    },
}

impl KernelShape {
    /// Largest standard deviation, local units.
    pub fn sigma(&self) -> f64 {
        match *self {
            Self::Sphere { sigma } | Self::Flattened { sigma, .. } | Self::Ellipsoids { largest: sigma } => {
                sigma
            }
        }
    }
}

/// Splats that lie close together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chunk {
    /// First splat.
    pub first: u32,
    /// One past the last.
    pub end: u32,
    /// Least coordinates of the centres, local.
    pub low: [f32; 3],
    /// Greatest coordinates.
    pub high: [f32; 3],
    /// Largest standard deviation of their kernels, local.
    pub sigma: f32,
}

impl Chunk {
    /// Chunk of splats at these places, the first with this index; `None` if there are none.
    pub fn of(positions: &[[f32; 3]], first: u32, sigma: f32) -> Option<Self> {
        let (&start, rest) = positions.split_first()?;
        let bound = |pick: fn(f32, f32) -> f32| {
            rest.iter()
                .fold(start, |at, p| std::array::from_fn(|a| pick(at[a], p[a])))
        };
        Some(Self {
            first,
            end: first + positions.len() as u32,
            low: bound(f32::min),
            high: bound(f32::max),
            sigma,
        })
    }

    /// Corners of the box of the centres, local.
    pub fn corners(&self) -> [[f32; 3]; 8] {
        std::array::from_fn(|corner| {
            std::array::from_fn(|axis| {
                if corner >> axis & 1 == 0 {
                    self.low[axis]
                } else {
                    self.high[axis]
                }
            })
        })
    }
}

impl SplatCloud {
    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.positions.capacity() * size_of::<[f32; 3]>()
            + self.payloads.capacity() * size_of::<[f32; 4]>()
            + self.gradients.capacity() * size_of::<[f32; 3]>()
            + self.covariances.capacity() * size_of::<[f32; 6]>()
            + self.chunks.capacity() * size_of::<Chunk>()
    }

    /// Number of splats.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether the cloud has no splats.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Rows of the matrix that maps gradients per local unit to gradients per world length, in a space rotated from
    /// the world by `rotation`.
    pub fn gradient_from_local(&self, rotation: DMat3) -> DMat3 {
        (rotation * self.world_from_local.matrix3).inverse().transpose()
    }
}
