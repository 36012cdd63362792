//! Ground to look at from above: columns of splats in the colours of a photograph, generated or real (swan1997 and
//! mueller1998 have 512 x 512 x 103 voxels of it, which are not published).

mod columns;
mod volcano;

use splatvol::Scene;
use splatvol_samples::{Sample, SampleSize};

pub(super) use columns::Columns;

use crate::{LabError, Workbench};

/// Source of the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ground {
    /// The built-in sample `terrain`: height and photograph are drawn from noise.
    Generated,
    /// Measured heights of a volcano and its surroundings under a photograph from a satellite.
    Volcano,
}

impl Ground {
    /// Columns along x and y, z up, to be seen towards y; a palette as transfer function.
    ///
    /// # Errors
    /// The bench has no data of the volcano, or they cannot be read.
    pub(super) fn scene(self, bench: &Workbench<'_>, dims: [usize; 3]) -> Result<Scene, LabError> {
        match self {
            Self::Generated => {
                let volume = Sample::Terrain.generate(Some(SampleSize::Dims(dims)))?;
                Ok(Scene::new(volume, Sample::Terrain.default_transfer_function()?))
            }
            Self::Volcano => volcano::scene(bench, dims),
        }
    }
}
