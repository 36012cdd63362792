//! Layers: the volumes of a scene on common planes, each with its own level, kernel, table and effects; and its clouds. Levels of
//! one volume lie behind each other ([`segments`]). A picture begins with what its levels need ([`ready`]), which is brought to the
//! device ([`resident`]).

mod ready;
mod resident;
mod segments;

use std::sync::{Arc, Weak};

use glam::DAffine3;
use splatvol_core::clock::Instant;
use splatvol_core::engine::{RenderStatistics, Shot, Task};
use splatvol_core::level::Level;
use splatvol_core::plan::{GridView, Rays};
use splatvol_core::prepared::{PreparedVolumes, SPARE};
use splatvol_scene::{Camera, Frame, RenderSettings, SceneError, SheetSettings, Volume};

use crate::atlas::Assembler;
use crate::check::Drawn;
use crate::clouds::{
    CloudLayer, CloudMarch, CloudPasses, CloudStore, Integral, IntegralPasses, Look, OfMesh, Opened,
};
use crate::device::GpuDevice;
use crate::direct::Direct;
use crate::effects::Effects;
use crate::gather::{Gather, planes_of};
use crate::layout::{FrameData, Picture};
use crate::march::{Canvas, March};
use crate::pass::Pass;
use crate::pipelines::{Classify, Marches, Pipelines, Variant};
use crate::shown::{Placed, Shown, ShownMesh};
use ready::Ready;
use resident::{OnDevice, Resident};

/// Volumes kept on the host and on the device.
#[derive(Debug)]
pub(crate) struct LayerStore {
    prepared: PreparedVolumes,
    /// Volumes that were moved to their places.
    placed: Vec<Moved>,
    on_device: OnDevice,
    clouds: CloudStore,
    /// Bytes of the last picture's clouds on the device, apart from their kernels.
    cloud_bytes: usize,
}

impl Default for LayerStore {
    fn default() -> Self {
        Self {
            prepared: PreparedVolumes::with_spare(SPARE),
            placed: Vec::new(),
            on_device: OnDevice::default(),
            clouds: CloudStore::default(),
            cloud_bytes: 0,
        }
    }
}

#[derive(Debug)]
struct Moved {
    of: Weak<Volume>,
    at: DAffine3,
    volume: Arc<Volume>,
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
    /// The volumes and meshes of a shot where they lie, and the rest.
    ///
    /// # Errors
    /// A place that cannot be inverted.
    pub(crate) fn place<'a>(&mut self, shot: &Shot<'a>, drawn: Drawn<'a>) -> Result<Placed<'a>, SceneError> {
        let Drawn {
            volumes,
            meshes,
            rest,
            sheets,
        } = drawn;
        let mut before = std::mem::take(&mut self.placed);
        let mut shown = Vec::with_capacity(volumes.len());
        for single in &volumes {
            let at = single.item.world_from_item;
            let is_it = |known: &Moved| {
                std::ptr::addr_eq(known.of.as_ptr(), Arc::as_ptr(single.volume)) && known.at == at
            };
            let placed = match before.iter().position(is_it) {
                Some(known) => before.swap_remove(known),
                None => Moved {
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
                effects: Effects::new(
                    (shot.scene, single.item, single.isosurfaces),
                    shot.camera,
                    of_values,
                ),
                volume,
            });
        }
        let own = shot.settings.with(sheets);
        let mesh = |drawn| ShownMesh::new(drawn, shot, &own);
        Ok(Placed {
            shown,
            meshes: meshes.iter().map(mesh).collect(),
            rest,
            clips: Effects::clips(shot.scene, shot.camera),
            sheets: own,
        })
    }

    /// Renders every volume at one of its levels, and the clouds.
    ///
    /// # Errors
    /// A stopped picture, samples that cannot be read, or a device that fails.
    pub(crate) async fn render(
        &mut self,
        (shot, placed): (&Shot<'_>, &Placed<'_>),
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
        let (camera, shown) = (shot.camera, &placed.shown[..]);
        let Self {
            prepared,
            on_device,
            clouds,
            cloud_bytes,
            ..
        } = self;
        let ready = Ready::new(prepared, (camera, shown, levels), task)?;
        ready.count(shown, statistics);
        let all: Vec<&Shown<'_>> = shown.iter().collect();
        let reading = ready.reading_share();
        let bring = |done: f64| (task.progress)(reading * done);
        let draw = |done: f64| (task.progress)(reading + (1.0 - reading) * done);
        let assembler = Assembler {
            gpu,
            pass: &pipelines.assemble,
            task: task.unseen(&bring),
        };
        let at = on_device.reside(assembler, (&all, levels), &ready.levels)?;
        let meshes: Vec<OfMesh<'_>> = placed.meshes.iter().map(ShownMesh::cloud).collect();
        let view = (camera, shot.settings, &placed.sheets);
        clouds.update(gpu, (&placed.rest, &meshes), view, task)?;
        let task = Task {
            progress: &draw,
            ..task
        };
        let brought = Instant::now();
        statistics.seconds.classify += (brought - start).as_secs_f64();
        let layers: Vec<Layer<'_>> = (0..shown.len())
            .map(|i| Layer {
                shown: &shown[i],
                level: ready.levels[i],
                view: &ready.views[i],
                resident: &on_device.resident[at[i]],
            })
            .collect();
        let gathers = placed.gathers();
        let passes: Vec<Passes> = layers
            .iter()
            .map(|layer| layer.passes(gpu, pipelines, gathers))
            .collect::<Result<_, _>>()?;
        let looks = placed.looks();
        let of_clouds = CloudPipelines::new((gpu, pipelines), placed, &looks)?;
        let mixture = match gathers {
            false => None,
            true => Some(pipelines.mixture(gpu)?),
        };
        let shared = (gpu, &*pipelines, canvas);
        let marches: Vec<March<'_>> = layers
            .iter()
            .zip(&passes)
            .map(|(layer, passes)| layer.march(shared, passes))
            .collect();
        let spacing = ready.views.first().map(GridView::spacing);
        let spacing = spacing.or_else(|| clouds.spacing((camera, &placed.sheets)));
        let view = ((camera, &placed.sheets), spacing.unwrap_or(1.0));
        let drawn = of_clouds
            .open((gpu, canvas), (clouds, &looks), view, task)
            .await?;
        statistics.sheets += planes_of(&marches, &drawn);
        statistics.seconds.bin += brought.elapsed().as_secs_f64();
        *cloud_bytes = match &mixture {
            None => {
                let passes = of_clouds.integral.as_deref();
                let integral = passes.zip(clouds.rest()).map(|(passes, cloud)| Integral {
                    gpu,
                    passes,
                    canvas,
                    cloud,
                    camera,
                    settings: shot.settings,
                    sheets: &placed.sheets,
                });
                let direct = Direct {
                    gpu,
                    canvas,
                    volumes: &marches,
                    mesh: drawn.into_iter().next(),
                    integral,
                    clear: &pipelines.clear,
                };
                direct.render(task, frame).await?
            }
            Some(mixture) => {
                let rays = Rays::new(&camera.screen_from_camera(shot.settings.size));
                let gather = Gather {
                    gpu,
                    canvas,
                    data: FrameData::seen(&placed.sheets, &rays),
                    volumes: &marches,
                    clouds: drawn,
                    mixture,
                    clear: &pipelines.clear,
                };
                gather.render(task, frame).await?
            }
        };
        statistics.seconds.tiles += brought.elapsed().as_secs_f64();
        ready.finish(statistics)
    }

    /// Forgets the levels whose samples could not be read.
    pub(crate) fn forget_failed(&mut self) {
        self.prepared.forget_failed();
    }

    /// Bytes of the clouds of the current scene, on the host.
    pub(crate) fn cloud_bytes(&self) -> usize {
        self.clouds.bytes()[0]
    }

    /// Bytes of the volumes of the current scene, and of others, on the host.
    pub(crate) fn host_bytes(&self) -> [usize; 2] {
        self.prepared.bytes()
    }

    /// Bytes on the device.
    pub(crate) fn device_bytes(&self) -> usize {
        self.on_device.bytes() as usize + self.clouds.bytes()[1] + self.cloud_bytes
    }
}

/// What is compiled for the clouds of a picture.
struct CloudPipelines {
    /// For X-rays.
    integral: Option<Arc<IntegralPasses>>,
    /// On planes, with a march for each look.
    planes: Option<Arc<CloudPasses>>,
    marches: Vec<Arc<CloudMarch>>,
}

impl CloudPipelines {
    /// Compiles what is lacking.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    fn new(
        (gpu, pipelines): (&GpuDevice, &mut Pipelines),
        placed: &Placed<'_>,
        looks: &[Look<'_>],
    ) -> Result<Self, SceneError> {
        Ok(Self {
            integral: match placed.integrates_clouds() {
                true => Some(pipelines.integral(gpu)?),
                false => None,
            },
            planes: match looks.is_empty() {
                true => None,
                false => Some(pipelines.clouds(gpu)?),
            },
            marches: looks
                .iter()
                .map(|look| pipelines.cloud_march(gpu, (look.mode(), &look.operators())))
                .collect::<Result<_, _>>()?,
        })
    }

    /// Opens the clouds of a scene on planes of this distance, world length.
    async fn open<'a>(
        &'a self,
        (gpu, canvas): (&'a GpuDevice, &'a Canvas),
        (clouds, looks): (&CloudStore, &[Look<'_>]),
        view: ((&Camera, &RenderSettings<SheetSettings>), f64),
        task: Task<'_>,
    ) -> Result<Vec<CloudLayer<'a>>, SceneError> {
        let Some(passes) = self.planes.as_deref() else {
            return Ok(Vec::new());
        };
        let all = clouds.meshes().chain(clouds.rest());
        let mut layers = Vec::new();
        for ((look, march), cloud) in looks.iter().zip(&self.marches).zip(all) {
            task.go_on()?;
            let opened = Opened::new((gpu, passes), cloud, look, view).await?;
            layers.push(CloudLayer::new(
                gpu,
                (passes, Arc::clone(march), canvas),
                look,
                opened,
            )?);
        }
        Ok(layers)
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
            operators: Arc::clone(&self.shown.effects.operators),
            taps: self.shown.taps(),
            is_cut: self.shown.is_cut(),
            has_low_pass: self.picture().most_low_pass_points() > 1,
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

    fn picture(&self) -> Picture<'_> {
        Picture {
            view: self.view,
            level: self.level,
            settings: &self.shown.settings,
            voxel: self.shown.volume.grid().mean_spacing(),
            unit_distance: self.shown.unit_distance,
            effects: &self.shown.effects,
        }
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
            picture: self.picture(),
            voxels: voxels.as_ref().zip(passes.classify.as_deref()),
            share: [1.0, 0.0],
            settles: true,
        }
    }
}
