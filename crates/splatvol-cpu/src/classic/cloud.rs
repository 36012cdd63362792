//! Extract: the cloud of a scene, rebuilt when the volume, the transfer function or the kind of splats has changed.

use std::sync::Arc;

use splatvol_core::brick::BrickGrid;
use splatvol_core::classification::ClassificationTable;
use splatvol_core::coefficients::{Coefficients, Use};
use splatvol_core::kernel::GaussianKernel;
use splatvol_core::splats::{self, Extract, Interest, KernelShape, SplatCloud};
use splatvol_scene::{
    Classification, Extraction, RenderSettings, SplatCompositing, SplatSettings, TransferFunction, Volume,
};

use crate::prepare::Patience;
use crate::route::VolumeScene;
use crate::run::Run;

/// Cache key of a cloud, without the volume.
#[derive(Debug, Clone, PartialEq)]
struct Key {
    transfer_function: TransferFunction,
    /// World length to which its opacities refer.
    unit_distance: f64,
    /// Reach of a voxel where values are splatted, voxels.
    value_reach: Option<f64>,
    shape: KernelShape,
    gradients: bool,
    extraction: Option<Extraction>,
}

/// A volume's samples, normalised, in bricks.
#[derive(Debug)]
struct Samples {
    volume: Arc<Volume>,
    values: Coefficients,
    bricks: BrickGrid,
}

impl Samples {
    fn of(volume: Arc<Volume>) -> Self {
        let (values, bricks) = Coefficients::new(&volume, Use::Samples);
        Self {
            volume,
            values,
            bricks,
        }
    }
}

/// A volume's samples, and the cloud last made from them.
#[derive(Debug, Default)]
pub(crate) struct CloudStore {
    samples: Option<Arc<Samples>>,
    cloud: Option<(Key, SplatCloud)>,
}

/// Whether values are splatted, for sheets to classify.
pub(crate) fn splats_values(settings: &RenderSettings<SplatSettings>) -> bool {
    settings.method.compositing == SplatCompositing::ImageSheets(Classification::Post)
}

impl CloudStore {
    /// Memory of samples and of the cloud, bytes.
    pub(crate) fn bytes(&self) -> [usize; 2] {
        let samples = |samples: &Arc<Samples>| samples.values.values.capacity() * size_of::<f32>();
        [
            self.samples.as_ref().map_or(0, samples),
            self.cloud.as_ref().map_or(0, |(_, cloud)| cloud.bytes()),
        ]
    }

    /// The cloud of a scene, and its volume's bricks; `None` if the picture is cancelled while they are being made.
    pub(crate) fn cloud(
        &mut self,
        run: Run<'_>,
        scene: &VolumeScene<'_>,
        settings: &RenderSettings<SplatSettings>,
        shape: KernelShape,
    ) -> Option<(&SplatCloud, usize)> {
        let volume = &scene.volume;
        let of = |kept: &Arc<Samples>| Arc::ptr_eq(&kept.volume, volume);
        if !self.samples.as_ref().is_some_and(of) {
            self.cloud = None;
            let volume = Arc::clone(volume);
            let samples = run.pool.prepare(run.task.stop, |_| Some(Samples::of(volume)))?;
            self.samples = Some(Arc::new(samples));
        }
        let samples = self.samples.as_ref()?;
        let of_values = splats_values(settings);
        let key = Key {
            transfer_function: scene.transfer_function.as_ref().clone(),
            unit_distance: scene.unit_distance(),
            value_reach: of_values.then(|| value_reach(settings)),
            shape,
            gradients: (!of_values && settings.lighting.is_some())
                || matches!(shape, KernelShape::Flattened { .. }),
            extraction: settings.method.extraction,
        };
        if self.cloud.as_ref().is_some_and(|(kept, _)| *kept != key) {
            self.cloud = None;
        }
        if self.cloud.is_none() {
            let samples = Arc::clone(samples);
            let made = move |_: &Patience| {
                let cloud = key.extract(&samples);
                Some((key, cloud))
            };
            self.cloud = Some(run.pool.prepare(run.task.stop, made)?);
        }
        let (_, cloud) = self.cloud.as_ref()?;
        Some((cloud, samples.bricks.len()))
    }
}

/// Reach of a voxel where values are splatted, voxels: one sheet spacing more on either side, for differences between
/// sheets.
fn value_reach(settings: &RenderSettings<SplatSettings>) -> f64 {
    GaussianKernel::new(settings.method.kernel).radius + 2.0 * settings.method.sheet_thickness.max(1.0) + 2.0
}

impl Key {
    /// The cloud of a volume's samples.
    fn extract(&self, samples: &Samples) -> SplatCloud {
        let volume = &samples.volume;
        let table =
            ClassificationTable::new(&self.transfer_function, volume.value_range(), self.unit_distance);
        let from = Extract {
            grid: volume.grid(),
            samples: &samples.values,
            bricks: &samples.bricks,
            table: &table,
            shape: self.shape,
            gradients: self.gradients,
            interest: self
                .extraction
                .as_ref()
                .map(|extraction| Interest::new(extraction, volume)),
        };
        match self.value_reach {
            Some(reach) => splats::unclassified(&from, [reach; 3]),
            None => splats::classified(&from),
        }
    }
}
