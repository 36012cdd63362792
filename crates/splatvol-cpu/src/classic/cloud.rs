//! Extract: the cloud of a scene, made again where the volume, the transfer function or what splats are has changed.

use std::sync::Arc;

use splatvol_core::brick::BrickGrid;
use splatvol_core::classification::ClassificationTable;
use splatvol_core::coefficients::{Coefficients, Use};
use splatvol_core::kernel::GaussianKernel;
use splatvol_core::splats::{self, Extract, Interest, KernelShape, SplatCloud};
use splatvol_scene::{Classification, Compositing, Extraction, RenderSettings, TransferFunction, Volume};

use crate::route::VolumeScene;

/// What a cloud depends on, besides the volume.
#[derive(Debug, Clone, PartialEq)]
struct Key {
    transfer_function: TransferFunction,
    data: bool,
    shape: KernelShape,
    gradients: bool,
    extraction: Option<Extraction>,
}

/// A volume's samples, and the cloud last made from them.
#[derive(Debug, Default)]
pub(crate) struct CloudStore {
    samples: Option<(Arc<Volume>, Coefficients, BrickGrid)>,
    cloud: Option<(Key, SplatCloud)>,
}

/// Whether data is splatted, for sheets to classify.
pub(crate) fn splats_data(settings: &RenderSettings) -> bool {
    settings.compositing == Compositing::ImageSheets && settings.classification == Classification::Post
}

impl CloudStore {
    /// The cloud of a scene, and the bricks that its volume has.
    pub(crate) fn cloud(
        &mut self,
        scene: &VolumeScene<'_>,
        settings: &RenderSettings,
        shape: KernelShape,
    ) -> (&SplatCloud, usize) {
        let volume = &scene.volume;
        if self
            .samples
            .as_ref()
            .is_none_or(|(kept, ..)| !Arc::ptr_eq(kept, volume))
        {
            self.cloud = None;
            let (samples, bricks) = Coefficients::new(volume, Use::Samples);
            self.samples = Some((Arc::clone(volume), samples, bricks));
        }
        let data = splats_data(settings);
        let key = Key {
            transfer_function: scene.transfer_function.as_ref().clone(),
            data,
            shape,
            gradients: (!data && settings.lighting.is_some())
                || matches!(shape, KernelShape::Flattened { .. }),
            extraction: settings.extraction,
        };
        if self.cloud.as_ref().is_some_and(|(kept, _)| *kept != key) {
            self.cloud = None;
        }
        let samples = &self.samples;
        let (_, cloud) = self.cloud.get_or_insert_with(|| {
            let cloud = samples
                .as_ref()
                .map(|(volume, samples, bricks)| extract(scene, (volume, samples, bricks), &key, settings));
            (key, cloud.expect("samples were read above"))
        });
        let bricks = samples.as_ref().map_or(0, |(_, _, bricks)| bricks.len());
        (cloud, bricks)
    }
}

fn extract(
    scene: &VolumeScene<'_>,
    (volume, samples, bricks): (&Volume, &Coefficients, &BrickGrid),
    key: &Key,
    settings: &RenderSettings,
) -> SplatCloud {
    let table = ClassificationTable::new(
        &scene.transfer_function,
        volume.value_range(),
        scene.unit_distance(),
    );
    let from = Extract {
        grid: volume.grid(),
        samples,
        bricks,
        table: &table,
        shape: key.shape,
        gradients: key.gradients,
        interest: key
            .extraction
            .as_ref()
            .map(|extraction| Interest::new(extraction, volume)),
    };
    if key.data {
        let radius = GaussianKernel::new(settings.kernel).radius;
        // A sheet's spacing more, on either side, for its differences.
        let reach = radius + 2.0 * settings.sheet_thickness.max(1.0) + 2.0;
        splats::data(&from, [reach; 3])
    } else {
        splats::classified(&from)
    }
}
