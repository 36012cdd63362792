//! Plan of a frame: read-only data shared by its tiles.

use glam::DVec3;
use rayon::prelude::*;
use splatvol_core::bin::{ProjectedBrick, TileGrid, TileLists, TileRect};
use splatvol_core::brick::ActiveBrick;
use splatvol_core::classification::ClassificationTable;
use splatvol_core::clock::Instant;
use splatvol_core::splats::{CameraView, Profile, Projection, SplatCloud};
use splatvol_scene::{Camera, MotionBlur, RenderSettings, SplatCompositing, SplatSettings};

use super::cloud::splats_values;
use super::order::{Order, extent};
use super::raster::Tables;
use crate::phong::Phong;
use crate::route::VolumeScene;
use crate::splat_light::SplatLight;

/// Edge of a tile, pixels, unless the whole picture is one tile.
const TILE_EDGE: usize = 64;

/// A cloud to render.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drawn<'a> {
    pub cloud: &'a SplatCloud,
    /// Bricks of the cloud's volume.
    pub bricks: usize,
    /// The volume, for classification of sheets of values and for motion.
    pub scene: &'a VolumeScene<'a>,
}

/// Everything that tiles need.
#[derive(Debug)]
pub(crate) struct Plan<'a, P> {
    pub settings: &'a RenderSettings<SplatSettings>,
    pub cloud: &'a SplatCloud,
    pub projection: Projection<'a>,
    pub profile: &'a P,
    /// Lookup tables of the footprints, if any.
    pub tables: Option<&'a Tables>,
    pub order: Order,
    pub view: CameraView,
    /// Chunks per tile, by their first turn; a brick index of the lists is a chunk index here.
    pub lists: TileLists,
    pub tiles: TileGrid,
    /// Light on classified splats.
    pub light: Option<SplatLight>,
    /// Transfer function and lighting for sheets of values.
    pub shading: Option<(ClassificationTable, Option<Phong>)>,
    /// Width of the border of pixels that is splatted around a tile.
    pub apron: usize,
    pub bricks: usize,
    /// Time spent on this plan, seconds.
    pub seconds: f64,
}

impl<'a, P: Profile> Plan<'a, P> {
    /// Projects and bins a cloud's chunks.
    pub(crate) fn new(
        Drawn { cloud, bricks, scene }: Drawn<'a>,
        (camera, settings): (&Camera, &'a RenderSettings<SplatSettings>),
        (profile, tables): (&'a P, Option<&'a Tables>),
    ) -> Self {
        let start = Instant::now();
        let camera_from_world = camera.camera_from_world();
        let view = CameraView {
            camera_from_world,
            screen: camera.screen_from_camera(settings.size),
            size: settings.size,
            near: 0.5 * settings.method.sheet_thickness * cloud.spacing,
        };
        let mut projection = Projection::new(
            cloud,
            &view,
            (settings.method.filter, settings.method.alignment),
            profile,
        )
        .with_stretch(settings.method.stretch);
        if let Some(motion) = scene.motion.filter(|_| settings.motion_blur.moves_footprints()) {
            let capsule = settings.motion_blur == MotionBlur::Capsule;
            projection = projection.moving(motion, scene.volume.grid().dims(), &view, capsule);
        }
        let reach = projection.depth_reach();
        let corners = corners(cloud)
            .map(|local| camera_from_world.transform_point3(cloud.world_from_local.transform_point3(local)));
        let order = Order::new(settings, cloud, &view, &corners, reach);
        let of_values = splats_values(settings);
        let apron = usize::from(of_values);
        let edge = if settings.method.occlusion.is_of_whole_picture() {
            settings.size.width().max(settings.size.height()) as usize
        } else {
            TILE_EDGE
        };
        let tiles = TileGrid::new(settings.size, edge);
        let margin = tables.map_or(0.0, Tables::margin);
        let chunk = |(index, chunk)| {
            let bounds = projection.bounds(chunk)?;
            let [x0, y0, x1, y1] = bounds.rect;
            let grown = apron as f32 + margin;
            Some(ProjectedBrick {
                active: ActiveBrick {
                    brick: index as u32,
                    blocks: u8::MAX,
                },
                front_sheet: order.first_turn(chunk, &bounds) as u32,
                rect: [x0 - grown, y0 - grown, x1 + grown, y1 + grown],
            })
        };
        let projected: Vec<_> = cloud.chunks.par_iter().enumerate().filter_map(chunk).collect();
        let lists = TileLists::new(projected, &tiles);
        let lighting = settings.lighting.as_ref();
        let lit = lighting.filter(|_| !of_values && settings.method.compositing != SplatCompositing::Xray);
        Self {
            settings,
            cloud,
            light: lit.map(|lighting| SplatLight::new(lighting, cloud, camera)),
            shading: of_values.then(|| {
                let table = ClassificationTable::new(
                    &scene.transfer_function,
                    scene.volume.value_range(),
                    scene.unit_distance(),
                );
                let phong = lighting.map(|lighting| Phong::new(lighting, cloud.spacing));
                (table, phong)
            }),
            projection,
            profile,
            tables,
            order,
            view,
            lists,
            tiles,
            apron,
            bricks,
            seconds: start.elapsed().as_secs_f64(),
        }
    }

    /// A tile's pixels with the border that is splatted around it.
    pub(crate) fn splatted(&self, rect: &TileRect) -> TileRect {
        let size = self.settings.size;
        TileRect {
            x0: rect.x0.saturating_sub(self.apron),
            y0: rect.y0.saturating_sub(self.apron),
            x1: (rect.x1 + self.apron).min(size.width() as usize),
            y1: (rect.y1 + self.apron).min(size.height() as usize),
        }
    }

    /// Motion of a pixel's ray in camera x and y per depth.
    #[inline(always)]
    pub(crate) fn ray(&self, [px, py]: [usize; 2]) -> [f32; 2] {
        let screen = &self.view.screen;
        if !screen.perspective {
            return [0.0; 2];
        }
        let along = |p: usize, c: f64| ((p as f64 + 0.5 - c) / screen.scale) as f32;
        [along(px, screen.centre.x), along(py, screen.centre.y)]
    }

    /// Payload of a splat, lit.
    #[inline(always)]
    pub(crate) fn payload(&self, splat: usize) -> [f32; 4] {
        let payload = self.cloud.payloads[splat];
        let lit = match &self.light {
            Some(light) => light.on(payload, self.cloud.gradients[splat]),
            None => payload,
        };
        match self.holds_opacities() {
            true => opacities(lit, self.cloud.spacing as f32),
            false => lit,
        }
    }
}

/// Opacity and opacity-weighted colours over a length, per length, of an extinction and its emission: they are at most 1 over
/// that length, where extinctions have no bound.
#[inline(always)]
fn opacities(payload: [f32; 4], length: f32) -> [f32; 4] {
    let optical_depth = payload[0] * length;
    let share = if optical_depth > 0.0 {
        -libm::expm1f(-optical_depth) / optical_depth
    } else {
        1.0
    };
    payload.map(|channel| channel * share)
}

fn corners(cloud: &SplatCloud) -> [DVec3; 8] {
    let (low, high) = extent(cloud);
    std::array::from_fn(|corner| {
        DVec3::from_array(std::array::from_fn(|axis| {
            f64::from(if corner >> axis & 1 == 0 {
                low[axis]
            } else {
                high[axis]
            })
        }))
    })
}
