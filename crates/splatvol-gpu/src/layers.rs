//! Layers: the volumes of a scene on common planes, each with its own level, kernel, table and effects.

use std::sync::{Arc, Weak};
use std::time::Instant;

use glam::DAffine3;
use splatvol_core::engine::{RenderStatistics, Shot, Task};
use splatvol_core::level::{Level, Wanted};
use splatvol_core::plan::{GridView, Sampling, on_common_planes};
use splatvol_core::prepared::{PreparedVolumes, SPARE};
use splatvol_scene::{Camera, Frame, SceneError, SheetSettings, SingleVolume, Volume};

use crate::atlas::Atlas;
use crate::device::GpuDevice;
use crate::effects::Effects;
use crate::gather::Gather;
use crate::layout::Picture;
use crate::march::{Canvas, March};
use crate::pass::Pass;
use crate::pipelines::{Classify, Marches, Pipelines, Variant};
use crate::shown::{Key, Shown};
use crate::voxels::{KeptSamples, Voxels};

/// Volumes kept on the host and on the device.
#[derive(Debug)]
pub(crate) struct LayerStore {
    prepared: PreparedVolumes,
    /// Volumes that were moved to their places.
    placed: Vec<Placed>,
    on_device: OnDevice,
}

/// Volumes kept on the device.
#[derive(Debug, Default)]
struct OnDevice {
    resident: Vec<Resident>,
    samples: KeptSamples,
}

impl Default for LayerStore {
    fn default() -> Self {
        Self {
            prepared: PreparedVolumes::with_spare(SPARE),
            placed: Vec::new(),
            on_device: OnDevice::default(),
        }
    }
}

#[derive(Debug)]
struct Placed {
    of: Weak<Volume>,
    at: DAffine3,
    volume: Arc<Volume>,
}

/// Voxels on the device, and what they are of.
#[derive(Debug)]
struct Resident {
    of: Key,
    atlas: Atlas,
    voxels: Option<Voxels>,
}

/// Where pictures are made.
pub(crate) struct Surface<'a> {
    pub gpu: &'a GpuDevice,
    pub pipelines: &'a mut Pipelines,
    pub canvas: &'a Canvas,
}

/// A layer's compiled passes.
struct Passes {
    marches: Marches,
    classify: Option<Arc<Pass>>,
}

impl LayerStore {
    /// The volumes of a shot where they lie.
    ///
    /// # Errors
    /// A place that cannot be inverted.
    pub(crate) fn place<'a>(
        &mut self,
        shot: &Shot<'a>,
        volumes: &[SingleVolume<'a>],
        sheets: SheetSettings,
    ) -> Result<Vec<Shown<'a>>, SceneError> {
        let mut before = std::mem::take(&mut self.placed);
        let mut shown = Vec::with_capacity(volumes.len());
        for single in volumes {
            let at = single.item.world_from_item;
            let is_it = |known: &Placed| {
                std::ptr::addr_eq(known.of.as_ptr(), Arc::as_ptr(single.volume)) && known.at == at
            };
            let placed = match before.iter().position(is_it) {
                Some(known) => before.swap_remove(known),
                None => Placed {
                    of: Arc::downgrade(single.volume),
                    at,
                    volume: single.placed()?,
                },
            };
            let volume = Arc::clone(&placed.volume);
            self.placed.push(placed);
            let of_values = (volume.value_range(), volume.grid().mean_spacing());
            shown.push(Shown {
                transfer_function: single.transfer_function,
                unit_distance: single.unit_distance(),
                labels: single.labels,
                settings: shot.settings.with(sheets.of_labels(single.labels)),
                effects: Effects::new((shot.scene, single), shot.camera, of_values),
                volume,
            });
        }
        Ok(shown)
    }

    /// Renders every volume at one of its levels; at least one.
    ///
    /// # Errors
    /// A stopped picture, samples that cannot be read, or a device that fails.
    pub(crate) fn render(
        &mut self,
        (camera, shown): (&Camera, &[Shown<'_>]),
        levels: &[usize],
        (surface, frame, task): (Surface<'_>, &mut Frame, Task<'_>),
        statistics: &mut RenderStatistics,
    ) -> Result<(), SceneError> {
        let start = Instant::now();
        let Surface {
            gpu,
            pipelines,
            canvas,
        } = surface;
        let Self {
            prepared, on_device, ..
        } = self;
        let classified = classify(prepared, (shown, levels), task, statistics)?;
        let views = views(camera, shown, &classified);
        let at = on_device.reside(gpu, (shown, levels), &classified)?;
        let ready = Instant::now();
        statistics.seconds.classify += (ready - start).as_secs_f64();
        statistics.sheets += views[0].planes().count;
        let layers: Vec<Layer<'_>> = (0..shown.len())
            .map(|i| Layer {
                shown: &shown[i],
                level: classified[i],
                view: &views[i],
                resident: &on_device.resident[at[i]],
            })
            .collect();
        let passes: Vec<Passes> = layers
            .iter()
            .map(|layer| layer.passes(gpu, pipelines, shown.len() > 1))
            .collect::<Result<_, _>>()?;
        let mixture = match shown {
            [_] => None,
            _ => Some(pipelines.mixture(gpu)?),
        };
        let shared = (gpu, &*pipelines, canvas);
        let marches: Vec<March<'_>> = layers
            .iter()
            .zip(&passes)
            .map(|(layer, passes)| layer.march(shared, passes))
            .collect();
        match mixture {
            Some(mixture) => Gather {
                gpu,
                canvas,
                layers: &marches,
                mixture: &mixture,
            }
            .render(task, frame)?,
            None => marches[0].render(task, frame)?,
        }
        statistics.seconds.tiles += ready.elapsed().as_secs_f64();
        Ok(())
    }

    /// Bytes of the volumes of the current scene, and of others, on the host.
    pub(crate) fn host_bytes(&self) -> [usize; 2] {
        self.prepared.bytes()
    }

    /// Bytes on the device.
    pub(crate) fn device_bytes(&self) -> usize {
        let OnDevice { resident, samples } = &self.on_device;
        let atlases = resident.iter().map(|own| own.atlas.layout.bytes());
        (atlases.sum::<u64>() + samples.bytes()) as usize
    }
}

/// Levels of the volumes with what their looks need.
fn classify<'p>(
    prepared: &'p mut PreparedVolumes,
    (shown, levels): (&[Shown<'_>], &[usize]),
    task: Task<'_>,
    statistics: &mut RenderStatistics,
) -> Result<Vec<&'p Level>, SceneError> {
    // Labels have no coefficients, whatever their settings.
    let main = shown.iter().find(|own| !own.labels).unwrap_or(&shown[0]);
    let pyramids = prepared.of_scene(shown.iter().map(|own| &own.volume), &main.settings);
    let mut classified: Vec<&Level> = Vec::with_capacity(shown.len());
    for ((pyramid, own), &level) in pyramids.iter_mut().zip(shown).zip(levels) {
        let look = (own.transfer_function, own.unit_distance);
        let level = pyramid.classify(level, look, Wanted::of(&own.settings), task.stop)?;
        level.count_work(statistics);
        statistics.active_bricks += if own.mode().splats_classes() {
            level.visible.len()
        } else {
            level.field.len()
        };
        classified.push(level);
    }
    Ok(classified)
}

/// Views of the levels, on common planes.
fn views(camera: &Camera, shown: &[Shown<'_>], classified: &[&Level]) -> Vec<GridView> {
    let grids: Vec<_> = shown
        .iter()
        .zip(classified)
        .map(|(own, level)| {
            let sampling = if own.mode().splats_classes() {
                Sampling::Planes
            } else {
                Sampling::Field
            };
            (level.field.source().grid(), own.settings, sampling)
        })
        .collect();
    on_common_planes(&grids, camera)
}

impl OnDevice {
    /// Brings what is not there yet, and forgets what none of these volumes needs; returns each one's place in `resident`.
    fn reside(
        &mut self,
        gpu: &GpuDevice,
        (shown, levels): (&[Shown<'_>], &[usize]),
        classified: &[&Level],
    ) -> Result<Vec<usize>, SceneError> {
        let keys: Vec<Key> = shown
            .iter()
            .zip(levels)
            .map(|(own, &level)| own.key(level))
            .collect();
        let Self { resident, samples } = self;
        resident.retain(|known| keys.iter().any(|key| key.is_like(&known.of)));
        samples.retain(shown.iter().map(|own| &own.volume));
        let mut at = Vec::with_capacity(shown.len());
        for ((own, key), level) in shown.iter().zip(keys).zip(classified) {
            let is_it = |known: &Resident| known.of.level == key.level && key.is_like(&known.of);
            at.push(match resident.iter().position(is_it) {
                Some(known) => known,
                None => {
                    resident.push(bring((gpu, samples), own, (key, level))?);
                    resident.len() - 1
                }
            });
        }
        Ok(at)
    }
}

/// A volume at one of its levels, on the device, from a camera.
struct Layer<'a> {
    shown: &'a Shown<'a>,
    level: &'a Level,
    view: &'a GridView,
    resident: &'a Resident,
}

impl Layer<'_> {
    /// Its compiled passes. `gathers`: there are other layers.
    fn passes(
        &self,
        gpu: &GpuDevice,
        pipelines: &mut Pipelines,
        gathers: bool,
    ) -> Result<Passes, SceneError> {
        let mode = self.shown.mode();
        let variant = Variant {
            mode,
            taps: self.shown.taps(),
            from_eye: self.view.holds_eye(),
            has_holes: !mode.splats_classes() && self.level.field.any_missing(),
            gathers,
        };
        let marches = pipelines.marches(gpu, variant)?;
        let classify = match &self.resident.voxels {
            None => None,
            Some(voxels) => Some(pipelines.classify(
                gpu,
                Classify {
                    taps: self.shown.taps(),
                    from_means: voxels.has_means(),
                    labels: self.shown.labels,
                },
            )?),
        };
        Ok(Passes { marches, classify })
    }

    fn march<'m>(
        &'m self,
        (gpu, pipelines, canvas): (&'m GpuDevice, &'m Pipelines, &'m Canvas),
        passes: &'m Passes,
    ) -> March<'m> {
        let Resident { atlas, voxels, .. } = self.resident;
        March {
            gpu,
            pipelines,
            marches: &passes.marches,
            mode: self.shown.mode(),
            atlas,
            canvas,
            picture: Picture {
                view: self.view,
                level: self.level,
                settings: &self.shown.settings,
                voxel: self.shown.volume.grid().mean_spacing(),
                unit_distance: self.shown.unit_distance,
                effects: &self.shown.effects,
            },
            voxels: voxels.as_ref().zip(passes.classify.as_deref()),
        }
    }
}

/// Brings the needed voxels of a level to the device.
fn bring(
    (gpu, samples): (&GpuDevice, &mut KeptSamples),
    own: &Shown<'_>,
    (key, level): (Key, &Level),
) -> Result<Resident, SceneError> {
    let (atlas, voxels) = if own.mode().splats_classes() {
        let samples = samples.of(gpu, &key.volume, (key.level, &level.field))?;
        let (atlas, voxels) = Voxels::new(gpu, level, &samples, own.taps())?;
        (atlas, Some(voxels))
    } else {
        (Atlas::new(gpu, &level.field, own.taps())?, None)
    };
    Ok(Resident {
        of: key,
        atlas,
        voxels,
    })
}
