//! Direct: what rays show of layers one after the other: material of one volume, one of its values or of a mesh's, or integrals
//! of any layers.

use splatvol_core::engine::Task;
use splatvol_scene::{Frame, SceneError};

use crate::clouds::{CloudLayer, Integral};
use crate::device::GpuDevice;
use crate::march::{Canvas, March};
use crate::pass::Pass;

/// Layers of one picture. What rays keep becomes pixels behind the last of them.
pub(crate) struct Direct<'a> {
    pub gpu: &'a GpuDevice,
    pub canvas: &'a Canvas,
    pub volumes: &'a [March<'a>],
    /// A mesh whose values are shown, alone.
    pub mesh: Option<CloudLayer<'a>>,
    /// Everything beside volumes whose integrals are shown.
    pub integral: Option<Integral<'a>>,
    pub clear: &'a Pass,
}

impl Direct<'_> {
    /// Renders into a frame. Returns the bytes on the device that its clouds took.
    ///
    /// # Errors
    /// A stopped picture, or a device that fails.
    pub(crate) async fn render(self, task: Task<'_>, frame: &mut Frame) -> Result<usize, SceneError> {
        self.canvas.clear(self.gpu, self.clear)?;
        let volumes = self.volumes.len();
        let count = volumes + usize::from(self.mesh.is_some()) + usize::from(self.integral.is_some());
        let share = |at: usize, done: f64| (task.progress)((at as f64 + done) / count as f64);
        for (at, march) in self.volumes.iter().enumerate() {
            let progress = |done| share(at, done);
            let settles = at + 1 == count;
            let part = Task {
                progress: &progress,
                ..task
            };
            March { settles, ..*march }.add(part)?;
        }
        let progress = |done| share(volumes, done);
        let part = Task {
            progress: &progress,
            ..task
        };
        let mut bytes = 0;
        if let Some(mut mesh) = self.mesh {
            mesh.show(part)?;
            bytes += mesh.bytes();
        }
        if let Some(integral) = self.integral {
            bytes += integral.show(part).await?;
        }
        self.canvas.resolve(self.gpu, frame, 0.0).await?;
        Ok(bytes)
    }
}
