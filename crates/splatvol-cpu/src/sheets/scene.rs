//! Scenes of several layers: their cached data, and the rendering of a frame.
//!
//! Every volume has its own levels of detail, coefficients, table and footprint; all pre-classified items are one
//! cloud. The planes are those of the volume with the thinnest sheets, so that a volume among points is sampled as
//! it is without them. A scene without volumes has the planes of the finest mesh or cloud.

use splatvol_core::bin::TileGrid;
use splatvol_core::chunk_memory::{ChunkMemory, PictureNeeds};
use splatvol_core::clock::Instant;
use splatvol_core::cloud_planes::own_spacing;
use splatvol_core::engine::{RenderStatistics, Task};
use splatvol_core::plan::{GridView, Sampling, on_common_planes};
use splatvol_core::splats::SplatCloud;
use splatvol_scene::{Camera, Clip, Frame, Gradient, RenderSettings, SceneError, SheetSettings};

use super::analytic::{Analytic, Sums};
use super::blocks::{self, picture_bytes};
use super::classified::ClassifiedBricks;
use super::cloud::layer::MeshLayer;
use super::cloud::plan::CloudPlan;
use super::compose::Compose;
use super::cut::{Cut, world_from_lattice};
use super::engine::SheetEngine;
use super::extremum::{Largest, Smallest};
use super::frame::GridPlan;
use super::frame::{analytic_field, shader};
use super::intensity::{Extreme, Mean, Reduction};
use super::layers::{Layer, Layers};
use super::levels::detail;
use super::operated::Operated;
use super::picture::{Picture, Values};
use super::ring::LANES;
use super::shaded::Shaded;
use super::tiles::{Single, TILE_EDGE};
use crate::meshes::MeshStore;
use crate::phong::Phong;
use crate::route::{MeshScene, VolumeScene};
use crate::run::Run;
use splatvol_core::level::{Detail, Level, Pyramid, Wanted, blend};

/// Contents of a scene, by layer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LayeredScene<'a> {
    pub volumes: &'a [VolumeScene<'a>],
    /// Post-classified meshes.
    pub meshes: &'a [MeshScene<'a>],
    /// Their samples, in the same order.
    pub mesh_clouds: &'a MeshStore,
    pub cloud: Option<&'a SplatCloud>,
    /// Clips of the cloud, world space.
    pub clips: &'a [Clip],
}

impl LayeredScene<'_> {
    /// Distance of planes in a scene without volumes: that of the finest cloud.
    fn spacing(&self, view: (&Camera, &RenderSettings<SheetSettings>)) -> Option<f64> {
        let clouds = self.mesh_clouds.clouds().chain(self.cloud);
        clouds.map(|cloud| own_spacing(cloud, view)).reduce(f64::min)
    }
}

/// Layers' data kept between frames.
#[derive(Debug, Default)]
pub(crate) struct LayerStore {
    plans: Vec<GridPlan>,
    meshes: Vec<MeshLayer>,
}

/// A view of every volume, on the planes of the one whose sheets are thinnest.
fn views(
    levels: &[&Level],
    volumes: &[VolumeScene<'_>],
    (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
) -> Vec<GridView> {
    let grids: Vec<_> = levels
        .iter()
        .zip(volumes)
        .map(|(level, volume)| {
            let settings = volume.settings(settings);
            let sampling = match Wanted::of(&settings) {
                Wanted::Classified => Sampling::Planes,
                _ => Sampling::Field,
            };
            (level.field.source().grid(), settings, sampling)
        })
        .collect();
    on_common_planes(&grids, camera)
}

/// Levels of a scene's volumes, the views of them, and what is cut from them.
type OfVolumes<'a> = (&'a [&'a Level], &'a [GridView], &'a [Cut]);

fn cuts(levels: &[&Level], volumes: &[VolumeScene<'_>], views: &[GridView]) -> Vec<Cut> {
    let volumes = volumes.iter().zip(views).zip(levels);
    volumes
        .map(|((volume, view), level)| {
            let grid = level.field.source().grid();
            Cut::new(
                &volume.effects.clips,
                world_from_lattice(grid.world_from_voxel(), view.margin()),
            )
        })
        .collect()
}

fn classified_bricks<'a>(
    (levels, views, cuts): OfVolumes<'a>,
    volumes: &[VolumeScene<'_>],
    settings: &RenderSettings<SheetSettings>,
) -> Vec<ClassifiedBricks<'a>> {
    levels
        .iter()
        .zip(cuts)
        .zip(volumes.iter().zip(views))
        .map(|((level, cut), (volume, view))| {
            let spacing = volume.volume.finest_grid().mean_spacing();
            let phong = settings.lighting.as_ref().map(|l| Phong::new(l, spacing));
            ClassifiedBricks::new(level)
                .cut(cut)
                .lit(phong, view.camera_from_voxel(), volume.labels)
        })
        .collect()
}

/// Memory of layers, kept between frames.
struct Kept<'a> {
    plans: &'a mut [GridPlan],
    meshes: &'a mut [MeshLayer],
    cloud_plan: &'a mut CloudPlan,
}

impl<'a> Kept<'a> {
    /// The layers of a scene.
    fn layers(
        self,
        (scene, (levels, views, _), bricks): (&LayeredScene<'a>, OfVolumes<'a>, &'a [ClassifiedBricks<'a>]),
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        tiles: TileGrid,
    ) -> Vec<Layer<'a>> {
        let edge = tiles.edge;
        let mut layers = Vec::with_capacity(scene.volumes.len() + 1);
        for (at, (plan, view)) in self.plans.iter_mut().zip(views).enumerate() {
            let (volume, level) = (&scene.volumes[at], levels[at]);
            layers.push(if Wanted::of(&volume.settings(settings)) == Wanted::Classified {
                let sheets = plan.update(view, &bricks[at], settings, edge);
                Layer::Compose(
                    sheets,
                    Compose {
                        bricks: bricks[at].clone(),
                    },
                )
            } else {
                let sheets = plan.update(view, &level.field, settings, edge);
                let spacing = volume.volume.finest_grid().mean_spacing();
                let shader = shader(view, (&level.field, &level.table), (settings, spacing));
                if settings.method.gradient == Gradient::Analytic {
                    let field = analytic_field(view, &level.field, (shader, Sums::Moments));
                    layers.push(Layer::Analytic(
                        sheets,
                        Analytic::new(field, &level.classification),
                    ));
                    continue;
                }
                let mode = Shaded {
                    store: &level.field,
                    shader,
                    operated: Operated::new(
                        &volume.effects,
                        spacing,
                        (camera, level.field.source().value_range()),
                    ),
                };
                Layer::Shaded(sheets, mode)
            });
        }
        let spacing = views
            .first()
            .map(GridView::spacing)
            .or_else(|| scene.spacing((camera, settings)));
        for ((kept, mesh), cloud) in self
            .meshes
            .iter_mut()
            .zip(scene.meshes)
            .zip(scene.mesh_clouds.clouds())
        {
            layers.push(kept.layer((cloud, mesh), (camera, settings), tiles, spacing));
        }
        if let Some(cloud) = scene.cloud {
            layers.push(
                self.cloud_plan
                    .layer((cloud, scene.clips), (camera, settings), tiles, spacing),
            );
        }
        layers
    }
}

impl SheetEngine {
    /// Renders a scene of several layers. `start`: start time of the frame.
    ///
    /// # Errors
    /// A cancelled picture, or samples that cannot be read.
    pub(crate) fn render_layers(
        &mut self,
        run: Run<'_>,
        scene: &LayeredScene<'_>,
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        (frame, start): (&mut Frame, Instant),
    ) -> Result<RenderStatistics, SceneError> {
        let mut statistics = RenderStatistics {
            threads: run.pool.current_num_threads(),
            engine: "sheets",
            simd: run.instructions.name(),
            ..RenderStatistics::default()
        };
        statistics.seconds.classify = start.elapsed().as_secs_f64();
        run.pool.install(|| {
            let LayerStore { plans, meshes } = &mut self.layers;
            plans.resize_with(scene.volumes.len(), GridPlan::default);
            meshes.resize_with(scene.meshes.len(), MeshLayer::default);
            let details: Vec<Detail> = scene
                .volumes
                .iter()
                .map(|own| detail(&own.volume, (camera, &own.settings(settings))))
                .collect();
            let mut levels: Vec<usize> = details.iter().map(|detail| detail.level).collect();
            let view = (camera, settings);
            // A pass for the picture, and one for every coarser level that is blended in.
            let passes = 1 + details.iter().filter(|detail| detail.coarser > 0.0).count();
            let share = |pass: usize, done: f64| (run.task.progress)((pass as f64 + done) / passes as f64);
            let first = |done: f64| share(0, done);
            let task = Task {
                progress: &first,
                ..run.task
            };
            self.layers_once(
                Run { task, ..run },
                (scene, &levels),
                view,
                frame,
                &mut statistics,
            )?;
            let mut pass = 0;
            for (at, detail) in details.iter().enumerate() {
                if detail.coarser > 0.0 {
                    pass += 1;
                    let next = |done: f64| share(pass, done);
                    let run = Run {
                        task: run.task.unseen(&next),
                        ..run
                    };
                    levels[at] += 1;
                    let mut coarser = self.coarser.take().unwrap_or_else(|| frame.clone());
                    if coarser.image.size() != frame.image.size() {
                        coarser = frame.clone();
                    }
                    self.layers_once(run, (scene, &levels), view, &mut coarser, &mut statistics)?;
                    blend(frame, &coarser, detail.coarser);
                    self.coarser = Some(coarser);
                    levels[at] -= 1;
                }
            }
            Ok(())
        })?;
        statistics.seconds.total = start.elapsed().as_secs_f64();
        Ok(statistics)
    }

    /// Renders every volume at one of its levels, and the cloud.
    fn layers_once(
        &mut self,
        run: Run<'_>,
        (scene, levels): (&LayeredScene<'_>, &[usize]),
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        frame: &mut Frame,
        statistics: &mut RenderStatistics,
    ) -> Result<(), SceneError> {
        let prepared = Instant::now();
        let wanted = Wanted::of(settings);
        let edge = run.tile_edge.unwrap_or(TILE_EDGE);
        let tiles = TileGrid::new(settings.size, edge);
        let view = (camera, settings);
        match wanted {
            Wanted::Largest => {
                return self.values::<Extreme<Largest>>(run, scene, (view, tiles), (frame, statistics));
            }
            Wanted::Smallest => {
                return self.values::<Extreme<Smallest>>(run, scene, (view, tiles), (frame, statistics));
            }
            Wanted::All => return self.values::<Mean>(run, scene, (view, tiles), (frame, statistics)),
            Wanted::Visible | Wanted::Classified => {}
        }
        let Self {
            prepared: kept,
            layers: LayerStore { plans, meshes },
            cloud: cloud_plan,
            memory,
            ..
        } = self;
        let pyramids = kept.of_scene(scene.volumes.iter().map(|own| &own.volume), settings);
        let mut memories: Vec<Option<ChunkMemory>> = Vec::new();
        let threads = run.pool.current_num_threads();
        let needs = PictureNeeds {
            bytes: picture_bytes(&run.task.held(settings.size), threads, edge),
            threads,
            volumes: scene.volumes.len(),
            levels: 1,
        };
        for ((pyramid, volume), &level) in pyramids.iter_mut().zip(scene.volumes).zip(levels) {
            let wanted = Wanted::of(&volume.settings(settings));
            let of = (&*volume.volume, level..level + 1);
            memories.push(ChunkMemory::of_picture(of, pyramid, needs, wanted)?);
        }
        let mut classified: Vec<&mut Level> = Vec::with_capacity(levels.len());
        for ((pyramid, volume), &level) in pyramids.iter_mut().zip(scene.volumes).zip(levels) {
            let look = volume.look();
            let wanted = Wanted::of(&volume.settings(settings));
            classified.push(pyramid.classify(level, look, wanted, run.task.stop)?);
        }
        let all: Vec<&Level> = classified.iter().map(|level| &**level).collect();
        for level in &all {
            level.count_work(statistics);
        }
        let views = views(&all, scene.volumes, (camera, settings));
        let own: Vec<(&ChunkMemory, &Level)> = memories
            .iter()
            .zip(&all)
            .filter_map(|(memory, level)| Some((memory.as_ref()?, *level)))
            .collect();
        let blocks = blocks::of_picture(&own, settings.size, &run, edge)?;
        statistics.seconds.classify += prepared.elapsed().as_secs_f64();
        for (at, &block) in blocks.iter().enumerate() {
            let planned = Instant::now();
            for (level, view) in classified.iter_mut().zip(&views) {
                blocks::restrict(level, view, block);
            }
            let share = |done: f64| (run.task.progress)((at as f64 + done) / blocks.len() as f64);
            let task = Task {
                progress: &share,
                ..run.task
            };
            let all: Vec<&Level> = classified.iter().map(|level| &**level).collect();
            let cuts = cuts(&all, scene.volumes, &views);
            let kept = Kept {
                plans: &mut *plans,
                meshes: &mut *meshes,
                cloud_plan: &mut *cloud_plan,
            };
            let of_volumes = (&all[..], &views[..], &cuts[..]);
            let bricks = classified_bricks(of_volumes, scene.volumes, settings);
            let layers = kept.layers((scene, of_volumes, &bricks), view, tiles);
            statistics.seconds.bin += planned.elapsed().as_secs_f64();
            if !layers.is_empty() {
                let run = Run { task, block, ..run };
                let layers = Layers(layers);
                memory.render(run, &Picture::Layers(&layers), LANES as u64, frame, statistics);
            }
            run.task.go_on()?;
        }
        for (memory, level) in memories.iter().zip(&classified) {
            if let Some(memory) = memory {
                memory.count(&[level], statistics);
            }
        }
        let failure = classified.iter().find_map(|level| level.field.failure());
        if let Some(error) = failure {
            pyramids.iter_mut().for_each(Pyramid::forget_failed);
            return Err(error);
        }
        Ok(())
    }

    /// Renders one value of each ray of the scene's mesh.
    fn values<K: Reduction>(
        &mut self,
        run: Run<'_>,
        scene: &LayeredScene<'_>,
        (view, tiles): ((&Camera, &RenderSettings<SheetSettings>), TileGrid),
        (frame, statistics): (&mut Frame, &mut RenderStatistics),
    ) -> Result<(), SceneError> {
        let start = Instant::now();
        let meshes = self.layers.meshes.iter_mut().zip(scene.meshes);
        for ((kept, mesh), cloud) in meshes.zip(scene.mesh_clouds.clouds()) {
            let Some((plan, mode)) = kept.values::<K>((cloud, mesh), view, tiles) else {
                continue;
            };
            statistics.seconds.bin += start.elapsed().as_secs_f64();
            let picture = K::picture(Values::OfMesh(Single::new(&plan, &mode)));
            self.memory.render(run, &picture, LANES as u64, frame, statistics);
        }
        Ok(())
    }
}
