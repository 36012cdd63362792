//! Open: a cloud's splats in camera space, and the lists of tiles and groups of planes that they reach.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use splatvol_core::cloud_planes::{CloudBounds, nearest, widened};
use splatvol_core::plan::{Rays, low_pass};
use splatvol_core::shade_table::ShadeTable;
use splatvol_core::sheets::Planes;
use splatvol_core::splats::SplatCloud;
use splatvol_scene::{Camera, RenderSettings, SceneError, SheetSettings};

use super::passes::CloudPasses;
use super::store::{Kernels, Ready};
use crate::device::GpuDevice;
use crate::effects::Effects;
use crate::layout::{FrameData, SheetData, columns, gradients};
use crate::mode::{CloudMode, Kept};
use crate::pass::{groups, numbers, uniform};
use crate::sort::{ListsData, Pairs};

/// Planes of a group: `GROUP` in WGSL.
pub(super) const GROUP: u32 = 8;
/// Pixels along an edge of a tile that has lists: `EDGE` in WGSL.
pub(super) const EDGE: u32 = 16;
/// Bytes of a splat: `Splat` in WGSL.
pub(crate) const SPLAT_BYTES: u64 = 64;

/// A page of a cloud: `Cloud` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct CloudData {
    pub low_pass: f32,
    pub is_matched: u32,
    pub nearest: f32,
    pub widening: f32,
    pub mass: f32,
    pub peaks_from: u32,
    pub count: u32,
    pub before: u32,
}

/// A part of the picture: `Part` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct PartData {
    pub columns: u32,
    pub groups: u32,
    pub first_row: u32,
    pub first_group: u32,
    pub pitch: u32,
    pub points: u32,
    pub unused: [u32; 2],
}

/// How a cloud is shown.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Look<'a> {
    /// Classified already; splats whose centres are clipped are left out.
    Colors { clips: &'a Effects },
    /// Values, which are classified now.
    Field {
        table: &'a ShadeTable,
        effects: &'a Effects,
    },
    /// Values, of which each ray shows one.
    Values {
        table: &'a ShadeTable,
        values: &'a ValueLook,
    },
}

/// Colours of values that are shown by themselves.
#[derive(Debug)]
pub(crate) struct ValueLook {
    pub kept: Kept,
    /// The transfer function at equally spaced values.
    pub nodes: Vec<[f32; 4]>,
    /// World length over which a value's opacity is taken.
    pub unit_distance: f32,
}

impl Look<'_> {
    pub(crate) fn mode(&self) -> CloudMode {
        match self {
            Self::Colors { .. } => CloudMode::Colors,
            Self::Values { values, .. } => CloudMode::Values(values.kept),
            Self::Field { effects, .. } if effects.is_none() => CloudMode::Field,
            Self::Field { .. } => CloudMode::FieldEffects,
        }
    }

    /// The text of its operators.
    pub(crate) fn operators(&self) -> Arc<str> {
        match self.effects() {
            [_, Some(effects)] => Arc::clone(&effects.operators),
            _ => Arc::default(),
        }
    }

    /// The transfer function as its shaders look it up.
    pub(crate) fn table(&self) -> &[[f32; 4]] {
        match self {
            Self::Colors { .. } => &[],
            Self::Field { table, .. } => table.cells(),
            Self::Values { values, .. } => &values.nodes,
        }
    }

    /// Clips that leave splats out, and clips and isosurfaces of intervals.
    pub(super) fn effects(&self) -> [Option<&Effects>; 2] {
        match self {
            Self::Colors { clips } => [Some(clips), None],
            Self::Field { effects, .. } => [None, Some(effects)],
            Self::Values { .. } => [None; 2],
        }
    }
}

/// A cloud in a camera's view, on the device.
#[derive(Debug)]
pub(crate) struct Opened {
    pub data: FrameData,
    pub first_plane: i64,
    pub sheets: wgpu::Buffer,
    pub splats: wgpu::Buffer,
    pub entries: wgpu::Buffer,
    pub ranges: wgpu::Buffer,
    pub tile_sheets: wgpu::Buffer,
    pub tiles: Tiles,
}

/// Tiles that have lists.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tiles {
    pub columns: u32,
    pub rows: u32,
    pub groups: u32,
}

impl Tiles {
    /// Pictures have a border of a pixel.
    fn new([width, height]: [u32; 2], planes: u32) -> Self {
        Self {
            columns: (width + 2).div_ceil(EDGE),
            rows: (height + 2).div_ceil(EDGE),
            groups: planes.div_ceil(GROUP),
        }
    }

    fn lists(&self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows) * u64::from(self.groups)
    }
}

/// A cloud's planes, and their data.
struct View {
    data: FrameData,
    planes: Planes,
    sheets: Vec<SheetData>,
    /// Depth of the nearest plane that has a scale.
    nearest: f64,
}

impl View {
    fn new(
        cloud: &SplatCloud,
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        spacing: f64,
        look: &Look<'_>,
    ) -> Self {
        let screen = camera.screen_from_camera(settings.size);
        let planes = CloudBounds::new(cloud, (camera, settings)).planes(cloud, settings, Some(spacing));
        let least = nearest(&planes, &screen);
        let sheet = |plane: usize| {
            let depth = planes.plane(plane).max(least);
            SheetData {
                depth: depth as f32,
                scale: screen.scale_at(depth) as f32,
                ..SheetData::zeroed()
            }
        };
        let count = planes.count as u32 + 1;
        let camera_from_local = camera.camera_from_world() * cloud.world_from_local;
        let shown = match look {
            Look::Colors { .. } => FrameData {
                lit: u32::from(settings.lighting.is_some() && !cloud.gradients.is_empty()),
                ..FrameData::zeroed()
            },
            Look::Values { table, values } => FrameData {
                hull: table.hull,
                unit_distance: values.unit_distance,
                ..FrameData::zeroed()
            },
            Look::Field { table, .. } => FrameData {
                lit: u32::from(settings.lighting.is_some()),
                hull: table.hull,
                densest: table.densest,
                ..FrameData::zeroed()
            },
        };
        let data = FrameData {
            planes: count,
            words: count.div_ceil(u32::BITS),
            spacing: planes.spacing as f32,
            voxel: cloud.spacing as f32,
            to_interval: count - 1,
            first_plane: planes.first as f32,
            camera_from_lattice: columns(&camera_from_local),
            gradient_from_lattice: gradients(&camera_from_local),
            hull: shown.hull,
            densest: shown.densest,
            unit_distance: shown.unit_distance,
            lit: shown.lit,
            ..FrameData::seen(settings, &Rays::new(&screen))
        };
        Self {
            data,
            planes,
            sheets: (0..=planes.count).map(sheet).collect(),
            nearest: planes.plane(usize::from(planes.first == 0)),
        }
    }
}

impl Opened {
    /// Opens a cloud on planes of this distance, world length.
    ///
    /// # Errors
    /// More splats, or more pairs of a splat and a list, than the device has room for; or a device that fails.
    pub(crate) async fn new(
        (gpu, passes): (&GpuDevice, &CloudPasses),
        (cloud, kernels): Ready<'_>,
        look: &Look<'_>,
        (view, spacing): ((&Camera, &RenderSettings<SheetSettings>), f64),
    ) -> Result<Self, SceneError> {
        let seen = View::new(cloud, view, spacing, look);
        let tiles = Tiles::new(seen.data.size, seen.data.planes);
        let room = gpu.device.limits().max_storage_buffer_binding_size;
        let fits = |count: u64, bytes: u64, what: &str| match count.checked_mul(bytes) {
            Some(all) if all <= room && count <= u64::from(u32::MAX) => Ok(count as u32),
            _ => Err(gpu.failed(&format_args!(
                "{count} {what} are more than its largest buffer holds"
            ))),
        };
        let count = fits(cloud.len() as u64, SPLAT_BYTES, "splats of a cloud")?;
        let lists = fits(tiles.lists(), 8, "lists of splats")?;
        let frame = gpu.scoped(|gpu| uniform(gpu, &seen.data))?;
        let (sheets, splats) = gpu.scoped(|gpu| {
            let sheets = gpu.buffer_of("sheets", &seen.sheets);
            let splats = open((gpu, passes), (cloud, kernels), (&seen, look), view.1);
            (sheets, splats)
        })?;
        let mut sizes = ListsData {
            splats: count,
            pairs: 0,
            columns: tiles.columns,
            per_tile: tiles.groups,
        };
        let counts = gpu.scoped(|gpu| {
            let counts = numbers(gpu, "pairs per splat", count + 1);
            let data = uniform(gpu, &sizes);
            let mut commands = gpu.commands();
            let bound = [(0, &frame), (1, &sheets), (2, &splats), (3, &counts), (7, &data)];
            let dispatched = groups(count, 256);
            passes.count_pairs.run(gpu, &mut commands, &bound, dispatched);
            let scanned = (&counts, count + 1);
            passes.sorter.scanner.run(gpu, &mut commands, scanned);
            gpu.queue.submit([commands.finish()]);
            counts
        })?;
        sizes.pairs = gpu.number(&counts, count).await?;
        fits(u64::from(sizes.pairs), 4, "pairs of a splat and a tile")?;
        gpu.scoped(|gpu| {
            let data = uniform(gpu, &sizes);
            let mut pairs = Pairs::new(gpu, sizes.pairs);
            let ranges = numbers(gpu, "ranges of lists", 2 * lists);
            let words = seen.data.tiles[0] * seen.data.tiles[1] * seen.data.words;
            let tile_sheets = numbers(gpu, "tile sheets", words);
            let mut commands = gpu.commands();
            let bound = [
                (0, &frame),
                (1, &sheets),
                (2, &splats),
                (3, &counts),
                (4, &pairs.keys),
                (5, &pairs.values),
                (7, &data),
            ];
            passes
                .emit_pairs
                .run(gpu, &mut commands, &bound, groups(count, 256));
            let bits = u32::BITS - lists.saturating_sub(1).leading_zeros();
            passes.sorter.run(gpu, &mut commands, (&mut pairs, bits));
            let bound = [(4, &pairs.keys), (6, &ranges), (7, &data)];
            let dispatched = groups(sizes.pairs, 256);
            passes.find_ranges.run(gpu, &mut commands, &bound, dispatched);
            let bound = [(0, &frame), (6, &ranges), (7, &data), (8, &tile_sheets)];
            passes.mark.run(gpu, &mut commands, &bound, groups(lists, 256));
            gpu.queue.submit([commands.finish()]);
            Self {
                data: of_intervals(seen.data, look),
                first_plane: seen.planes.first,
                sheets,
                splats,
                entries: pairs.values,
                ranges,
                tile_sheets,
                tiles,
            }
        })
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> usize {
        let buffers = [
            &self.sheets,
            &self.splats,
            &self.entries,
            &self.ranges,
            &self.tile_sheets,
        ];
        buffers.iter().map(|buffer| buffer.size() as usize).sum()
    }
}

/// The frame's data for intervals: clips of kernels have been applied, those of values are still to be.
fn of_intervals(data: FrameData, look: &Look<'_>) -> FrameData {
    match look.effects()[1] {
        None => data,
        Some(effects) => FrameData {
            bodies: effects.bodies,
            isosurfaces: effects.isosurfaces,
            first_isosurface: effects.first_isosurface,
            ..data
        },
    }
}

/// Opens the kernels of a cloud.
fn open(
    (gpu, passes): (&GpuDevice, &CloudPasses),
    (cloud, kernels): (&SplatCloud, &Kernels),
    (seen, look): (&View, &Look<'_>),
    settings: &RenderSettings<SheetSettings>,
) -> wgpu::Buffer {
    let size = SPLAT_BYTES * (cloud.len() as u64).max(1);
    let splats = gpu.buffer("splats", size, wgpu::BufferUsages::STORAGE);
    let clips = look.effects()[0];
    let data = FrameData {
        bodies: clips.map_or(0, |clips| clips.bodies),
        // Values are lit where they are shown.
        lit: if clips.is_some() { seen.data.lit } else { 0 },
        ..seen.data
    };
    let frame = uniform(gpu, &data);
    let clips = gpu.buffer_of("clips", clips.map_or(&[][..], |clips| &clips.data));
    let (variance, is_matched) = low_pass(settings.method.filter.into());
    let mut commands = gpu.commands();
    let mut before = 0;
    for page in &kernels.pages {
        let own = uniform(
            gpu,
            &CloudData {
                low_pass: variance as f32,
                is_matched: u32::from(is_matched),
                nearest: seen.nearest as f32,
                widening: widened(0.0, seen.planes.spacing) as f32,
                mass: cloud.mass as f32,
                peaks_from: cloud.peaks_from as u32,
                count: page.count,
                before,
            },
        );
        let bound = [
            (0, &frame),
            (3, &own),
            (4, &page.kernels),
            (5, &page.payloads),
            (6, &splats),
            (9, &clips),
        ];
        passes
            .open
            .run(gpu, &mut commands, &bound, groups(page.count, 256));
        before += page.count;
    }
    gpu.queue.submit([commands.finish()]);
    splats
}
