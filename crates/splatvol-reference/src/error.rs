//! The one error type of this crate.

use splatvol_scene::SceneError;

/// Why the reference cannot render a frame.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReferenceError {
    /// The render settings are outside their domain.
    #[error(transparent)]
    Settings(#[from] SceneError),
    /// The prefilter has no solution: no coefficients reproduce the samples.
    #[error(
        "the kernel (sigma {sigma}, radius {radius}) cannot be inverted on an axis of {count} samples: \
         the prefilter has no solution"
    )]
    SingularKernel {
        /// Standard deviation, voxels.
        sigma: f64,
        /// Cut-off, voxels.
        radius: f64,
        /// Samples along the axis.
        count: usize,
    },
    /// A kernel that the reference does not integrate.
    #[error("kernel: the reference renders gaussian kernels only, not {name}")]
    Kernel {
        /// The kernel's name.
        name: &'static str,
    },
}
