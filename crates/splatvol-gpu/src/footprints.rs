//! Footprints: ellipses on the screen, whatever they are of, and the lists of the tiles that they touch.
//!
//! Whole footprints are composited as published (`gaussians`) or added up (`clouds::integral`); a tile's list has them in the
//! order that they were given.

use splatvol_core::cloud_view::{CloudView, REFERENCE_TILE};
use splatvol_scene::{ImageSize, SceneError};

use bytemuck::{Pod, Zeroable};

use crate::device::GpuDevice;
use crate::pass::{Pass, groups, numbers, uniform};
use crate::sort::{LISTS, ListsData, Pairs, Sorter};

pub(crate) const SPLAT: &str = include_str!("../shaders/footprints/splat.wgsl");
pub(crate) const VIEW: &str = include_str!("../shaders/footprints/view.wgsl");
pub(crate) const BATCH: &str = include_str!("../shaders/footprints/batch.wgsl");
const PAIRS: &str = include_str!("../shaders/footprints/pairs.wgsl");

/// Bytes of a footprint: `Splat` in WGSL.
pub(crate) const FOOTPRINT_BYTES: u64 = 48;

/// The text of the passes that make lists.
pub(crate) fn pairs_shader() -> String {
    [SPLAT, LISTS, PAIRS].join("\n")
}

/// A cloud before a camera: `View` in WGSL.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ViewData {
    pub eye: [f32; 3],
    pub near: f32,
    pub eye_rest: [f32; 3],
    pub scale: f32,
    pub to_x: [f32; 3],
    pub low_pass: f32,
    pub to_y: [f32; 3],
    pub is_perspective: u32,
    pub to_z: [f32; 3],
    pub degree: u32,
    pub direction: [f32; 3],
    pub is_antialiased: u32,
    pub centre: [f32; 2],
    pub tangent_limit: [f32; 2],
    pub reference_tiles: [f32; 2],
    pub count: u32,
    pub before: u32,
    pub first_key: u32,
    pub unseen_key: u32,
    pub unused: [u32; 2],
}

impl ViewData {
    /// A view; what is of Gaussians or of a page is left open.
    pub(crate) fn new(view: &CloudView) -> Self {
        let [to_x, to_y, to_z] = view.camera_from_local;
        Self {
            eye: view.eye[0],
            near: view.near,
            eye_rest: view.eye[1],
            scale: view.scale,
            to_x,
            to_y,
            is_perspective: u32::from(view.perspective),
            to_z,
            direction: view.direction.unwrap_or_default(),
            centre: view.centre,
            tangent_limit: view.tangent_limit,
            reference_tiles: view.reference_tiles.map(|n| n as f32),
            unseen_key: u32::MAX,
            ..Self::zeroed()
        }
    }
}

/// Footprints of a picture, and their order.
pub(crate) struct Footprints {
    pub projected: wgpu::Buffer,
    pub order: Pairs,
    pub size: ImageSize,
}

impl Footprints {
    /// Room for so many.
    pub(crate) fn new(gpu: &GpuDevice, count: u32, size: ImageSize) -> Self {
        let bytes = u64::from(count.max(1)) * FOOTPRINT_BYTES;
        Self {
            projected: gpu.buffer("footprints", bytes, wgpu::BufferUsages::STORAGE),
            order: Pairs::new(gpu, count),
            size,
        }
    }

    /// Tiles along x.
    pub(crate) fn columns(&self) -> u32 {
        self.size.width().div_ceil(REFERENCE_TILE)
    }

    /// Tiles along y.
    pub(crate) fn rows(&self) -> u32 {
        self.size.height().div_ceil(REFERENCE_TILE)
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> usize {
        self.order.bytes() + self.projected.size() as usize
    }
}

/// How many footprints there are.
///
/// # Errors
/// More than the device has room for. `what`: they are of.
pub(crate) fn room_for(gpu: &GpuDevice, count: usize, what: &str) -> Result<u32, SceneError> {
    let most = gpu.device.limits().max_storage_buffer_binding_size / FOOTPRINT_BYTES;
    u32::try_from(count)
        .ok()
        .filter(|&count| u64::from(count) <= most)
        .ok_or_else(|| {
            gpu.failed(&format_args!(
                "{count} {what} are more than the {most} that its largest buffer holds"
            ))
        })
}

/// Lists of the tiles.
pub(crate) struct TileLists {
    pub pairs: Pairs,
    pub ranges: wgpu::Buffer,
}

/// The passes that make lists.
#[derive(Debug)]
pub(crate) struct ListPasses {
    count_tiles: Pass,
    emit: Pass,
    find_ranges: Pass,
    pub sorter: Sorter,
}

impl ListPasses {
    /// Compiles the passes.
    pub(crate) fn new(gpu: &GpuDevice) -> Self {
        let text = pairs_shader();
        let pass = |entry| Pass::new(gpu, (entry, &text), &[]);
        Self {
            count_tiles: pass("count_tiles"),
            emit: pass("emit"),
            find_ranges: pass("find_ranges"),
            sorter: Sorter::new(gpu),
        }
    }

    /// Makes the lists of tiles.
    ///
    /// # Errors
    /// More pairs than the device has room for, or a device that fails. `what`: footprints are of.
    pub(crate) async fn list(
        &self,
        gpu: &GpuDevice,
        footprints: &Footprints,
        what: &str,
    ) -> Result<TileLists, SceneError> {
        let count = footprints.order.count;
        let mut sizes = ListsData {
            splats: count,
            pairs: 0,
            columns: footprints.columns(),
            per_tile: 1,
        };
        let counts = gpu.scoped(|gpu| {
            let counts = numbers(gpu, "pairs per splat", count + 1);
            let mut commands = gpu.commands();
            let data = uniform(gpu, &sizes);
            let bound = [
                (7, &data),
                (1, &footprints.projected),
                (2, &footprints.order.values),
                (3, &counts),
            ];
            self.count_tiles
                .run(gpu, &mut commands, &bound, groups(count, 256));
            self.sorter.scanner.run(gpu, &mut commands, (&counts, count + 1));
            gpu.queue.submit([commands.finish()]);
            counts
        })?;
        sizes.pairs = gpu.number(&counts, count).await?;
        let largest = gpu.device.limits().max_storage_buffer_binding_size;
        if 4 * u64::from(sizes.pairs) > largest {
            return Err(gpu.failed(&format_args!(
                "{} pairs of {what} and a tile are more than its largest buffer holds",
                sizes.pairs
            )));
        }
        gpu.scoped(|gpu| self.fill(gpu, (footprints, &counts), sizes))
    }

    /// Fills the lists of tiles in.
    fn fill(
        &self,
        gpu: &GpuDevice,
        (footprints, counts): (&Footprints, &wgpu::Buffer),
        sizes: ListsData,
    ) -> TileLists {
        let tiles = sizes.columns * footprints.rows();
        let mut pairs = Pairs::new(gpu, sizes.pairs);
        let ranges = numbers(gpu, "ranges of tiles", 2 * tiles);
        let data = uniform(gpu, &sizes);
        let mut commands = gpu.commands();
        let bound = [
            (7, &data),
            (1, &footprints.projected),
            (2, &footprints.order.values),
            (3, counts),
            (4, &pairs.keys),
            (5, &pairs.values),
        ];
        self.emit
            .run(gpu, &mut commands, &bound, groups(sizes.splats, 256));
        let bits = u32::BITS - tiles.saturating_sub(1).leading_zeros();
        self.sorter.run(gpu, &mut commands, (&mut pairs, bits));
        let bound = [(7, &data), (4, &pairs.keys), (6, &ranges)];
        self.find_ranges
            .run(gpu, &mut commands, &bound, groups(sizes.pairs, 256));
        gpu.queue.submit([commands.finish()]);
        TileLists { pairs, ranges }
    }
}
