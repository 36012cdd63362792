//! Layers: the volumes of a scene on common planes, each with its own level, kernel, table and effects.

use std::sync::{Arc, Weak};
use std::time::Instant;

use glam::DAffine3;
use splatvol_core::engine::{RenderStatistics, Shot, Task};
use splatvol_core::level::{Detail, Level, Wanted};
use splatvol_core::plan::{GridView, Sampling, on_common_planes};
use splatvol_core::prepared::{PreparedVolumes, SPARE};
use splatvol_scene::{
    Camera, Frame, Gradient, RenderSettings, SceneError, SheetKernel, SheetSettings, SingleVolume,
    TransferFunction, Volume,
};

use crate::atlas::Atlas;
use crate::device::GpuDevice;
use crate::effects::Effects;
use crate::gather::Gather;
use crate::layout::Picture;
use crate::march::{Canvas, March};
use crate::mode::Mode;
use crate::pass::Pass;
use crate::pipelines::{Classify, Marches, Pipelines, Variant};
use crate::voxels::{KeptSamples, Voxels};

/// A volume where it lies, and its look.
#[derive(Debug)]
pub(crate) struct Shown<'a> {
    volume: Arc<Volume>,
    transfer_function: &'a TransferFunction,
    unit_distance: f64,
    labels: bool,
    settings: RenderSettings<SheetSettings>,
    effects: Effects,
}

impl Shown<'_> {
    fn key(&self, level: usize) -> Key {
        Key {
            level,
            volume: Arc::downgrade(&self.volume),
            transfer_function: self.transfer_function.clone(),
            unit_distance: self.unit_distance,
            kernel: self.settings.method.kernel,
            prefilter: self.settings.method.prefilter,
            wanted: Wanted::of(&self.settings),
        }
    }

    /// Voxels along an axis that the kernel meets.
    fn taps(&self) -> i32 {
        if self.settings.method.kernel.radius > 2.0 {
            6
        } else {
            4
        }
    }

    fn mode(&self) -> Mode {
        Mode::of(Wanted::of(&self.settings), &self.settings.method, &self.effects)
    }

    /// Its level of detail. Labels are lit by their own shapes, analytic gradients show the field as it is: both have none.
    pub(crate) fn detail(&self, camera: &Camera) -> Detail {
        let method = &self.settings.method;
        if self.labels || (!self.mode().splats_classes() && method.gradient == Gradient::Analytic) {
            return Detail::FINEST;
        }
        Detail::new(&self.volume, camera, (self.settings.size, method.level_bias))
    }
}

/// Volumes kept on the host and on the device.
#[derive(Debug)]
pub(crate) struct LayerStore {
    prepared: PreparedVolumes,
    /// Volumes that were moved to their places.
    placed: Vec<Placed>,
    resident: Vec<Resident>,
    samples: KeptSamples,
}

impl Default for LayerStore {
    fn default() -> Self {
        Self {
            prepared: PreparedVolumes::with_spare(SPARE),
            placed: Vec::new(),
            resident: Vec::new(),
            samples: KeptSamples::default(),
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

/// What a volume's needed voxels depend on.
#[derive(Debug, Clone)]
struct Key {
    level: usize,
    volume: Weak<Volume>,
    transfer_function: TransferFunction,
    unit_distance: f64,
    kernel: SheetKernel,
    prefilter: bool,
    wanted: Wanted,
}

impl Key {
    /// Whether another is of the same but for the level.
    fn is_like(&self, other: &Self) -> bool {
        Weak::ptr_eq(&self.volume, &other.volume)
            && self.transfer_function == other.transfer_function
            && self.unit_distance == other.unit_distance
            && self.kernel == other.kernel
            && self.prefilter == other.prefilter
            && self.wanted == other.wanted
    }
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
            prepared,
            resident,
            samples,
            ..
        } = self;
        let volumes = shown.iter().map(|own| &own.volume);
        // Labels have no coefficients, whatever their settings.
        let main = shown.iter().find(|own| !own.labels).unwrap_or(&shown[0]);
        let pyramids = prepared.of_scene(volumes, &main.settings);
        let mut classified: Vec<&Level> = Vec::with_capacity(shown.len());
        for ((pyramid, own), &level) in pyramids.iter_mut().zip(shown).zip(levels) {
            let look = (own.transfer_function, own.unit_distance);
            let wanted = Wanted::of(&own.settings);
            let level = pyramid.classify(level, look, wanted, task.stop)?;
            level.count_work(statistics);
            classified.push(level);
        }
        let grids: Vec<_> = shown
            .iter()
            .zip(&classified)
            .map(|(own, level)| {
                let sampling = if own.mode().splats_classes() {
                    Sampling::Planes
                } else {
                    Sampling::Field
                };
                (level.field.source().grid(), own.settings, sampling)
            })
            .collect();
        let views = on_common_planes(&grids, camera);
        let keys: Vec<Key> = shown
            .iter()
            .zip(levels)
            .map(|(own, &level)| own.key(level))
            .collect();
        resident.retain(|known| keys.iter().any(|key| key.is_like(&known.of)));
        samples.retain(shown.iter().map(|own| &own.volume));
        let mut at = Vec::with_capacity(shown.len());
        for ((own, key), level) in shown.iter().zip(keys).zip(&classified) {
            let is_it = |known: &Resident| known.of.level == key.level && key.is_like(&known.of);
            at.push(match resident.iter().position(is_it) {
                Some(known) => known,
                None => {
                    resident.push(bring((gpu, samples), own, (key, level))?);
                    resident.len() - 1
                }
            });
            statistics.active_bricks += if own.mode().splats_classes() {
                level.visible.len()
            } else {
                level.field.len()
            };
        }
        let ready = Instant::now();
        statistics.seconds.classify += (ready - start).as_secs_f64();
        statistics.sheets += views[0].planes().count;
        let gathers = shown.len() > 1;
        let passes: Vec<Passes> = shown
            .iter()
            .zip(&at)
            .zip(views.iter().zip(&classified))
            .map(|((own, &at), (view, level))| {
                let voxels = resident[at].voxels.as_ref();
                own.passes((gpu, &mut *pipelines), (view, level, voxels), gathers)
            })
            .collect::<Result<_, _>>()?;
        let mixture = if gathers {
            Some(pipelines.mixture(gpu)?)
        } else {
            None
        };
        let pipelines = &*pipelines;
        let marches: Vec<March<'_>> = (0..shown.len())
            .map(|i| {
                let own = &shown[i];
                let Resident { atlas, voxels, .. } = &resident[at[i]];
                March {
                    gpu,
                    pipelines,
                    marches: &passes[i].marches,
                    mode: own.mode(),
                    atlas,
                    canvas,
                    picture: Picture {
                        view: &views[i],
                        level: classified[i],
                        settings: &own.settings,
                        voxel: own.volume.grid().mean_spacing(),
                        unit_distance: own.unit_distance,
                        effects: &own.effects,
                    },
                    voxels: voxels.as_ref().zip(passes[i].classify.as_deref()),
                }
            })
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
        let atlases = self.resident.iter().map(|own| own.atlas.layout.bytes());
        (atlases.sum::<u64>() + self.samples.bytes()) as usize
    }
}

impl Shown<'_> {
    fn passes(
        &self,
        (gpu, pipelines): (&GpuDevice, &mut Pipelines),
        (view, level, voxels): (&GridView, &Level, Option<&Voxels>),
        gathers: bool,
    ) -> Result<Passes, SceneError> {
        let mode = self.mode();
        let variant = Variant {
            mode,
            taps: self.taps(),
            from_eye: view.holds_eye(),
            has_holes: !mode.splats_classes() && level.field.any_missing(),
            gathers,
        };
        let classify = |voxels: &Voxels| Classify {
            taps: self.taps(),
            from_means: voxels.has_means(),
            labels: self.labels,
        };
        Ok(Passes {
            marches: pipelines.marches(gpu, variant)?,
            classify: match voxels {
                Some(voxels) => Some(pipelines.classify(gpu, classify(voxels))?),
                None => None,
            },
        })
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
