//! Layer: a cloud among the layers of a picture: its planes, in a ring, and its intervals.

use std::ops::Range;
use std::sync::Arc;

use splatvol_core::engine::Task;
use splatvol_scene::SceneError;

use super::open::{EDGE, GROUP, Look, Opened, PartData};
use super::passes::{CloudMarch, CloudPasses};
use crate::device::GpuDevice;
use crate::gather::{Bands, GatheredLayer, Part};
use crate::layout::FrameData;
use crate::march::Canvas;
use crate::mode::CloudMode;
use crate::pass::{Pass, uniform};

/// Planes of a ring, `RING` in WGSL: those of a part's intervals, with one before and one behind, whatever groups they are in.
const RING: u32 = 32;

/// Bytes of a ring for so many rows of tiles; a part reads the points beside it.
pub(crate) fn ring_bytes([width, _]: [u32; 2], rows: u32) -> u64 {
    let pitch = u64::from((width + 2).next_multiple_of(EDGE));
    pitch * u64::from(EDGE * (rows + 1)) * u64::from(RING) * 16
}

/// A cloud, ready to be gathered among other layers, or to be shown alone by what rays keep of it.
pub(crate) struct CloudLayer<'a> {
    gpu: &'a GpuDevice,
    planes: &'a Pass,
    march: Arc<CloudMarch>,
    canvas: &'a Canvas,
    mode: CloudMode,
    opened: Opened,
    frame: wgpu::Buffer,
    table: wgpu::Buffer,
    effects: wgpu::Buffer,
    faces: wgpu::Buffer,
    ring: Option<Ring>,
}

/// Planes of a part of the picture.
struct Ring {
    planes: wgpu::Buffer,
    part: wgpu::Buffer,
    /// First row of tiles of the part, and the first group of planes that is not made yet.
    row: u32,
    next_group: u32,
}

impl<'a> CloudLayer<'a> {
    /// A cloud that was opened.
    ///
    /// # Errors
    /// Memory that the device refuses.
    pub(crate) fn new(
        gpu: &'a GpuDevice,
        (passes, march, canvas): (&'a CloudPasses, Arc<CloudMarch>, &'a Canvas),
        look: &Look<'_>,
        opened: Opened,
    ) -> Result<Self, SceneError> {
        let mode = look.mode();
        let pixels = opened.data.size.map(u64::from).iter().product::<u64>();
        gpu.scoped(|_| {
            let [_, effects] = look.effects();
            let effects = effects.map_or(&[][..], |effects| &effects.data);
            // Two vectors per pixel.
            let faces = match mode {
                CloudMode::FieldEffects => 32 * pixels,
                _ => 32,
            };
            Self {
                frame: uniform(gpu, &opened.data),
                table: gpu.buffer_of("table", look.table()),
                effects: gpu.buffer_of("effects", effects),
                faces: gpu.buffer("faces", faces, wgpu::BufferUsages::STORAGE),
                gpu,
                planes: passes.planes(mode),
                march,
                canvas,
                mode,
                opened,
                ring: None,
            }
        })
    }

    /// Bytes on the device, apart from its kernels.
    pub(crate) fn bytes(&self) -> usize {
        let ring = self.ring.as_ref().map_or(0, |ring| ring.planes.size() as usize);
        self.opened.bytes() + self.faces.size() as usize + ring
    }

    /// Makes pixels of what its rays keep, on an empty canvas.
    ///
    /// # Errors
    /// A stopped picture, or a device that fails.
    pub(crate) fn show(&mut self, task: Task<'_>) -> Result<(), SceneError> {
        let (gpu, canvas) = (self.gpu, self.canvas);
        let data = self.opened.data;
        let bands = Bands::new(gpu, &data, true);
        let [colors, depths] = canvas.targets();
        let all = (data.tiles[1], self.intervals());
        gpu.scoped(|_| {
            bands.each((gpu, depths), all, task, |part| {
                self.gather(part)?;
                Ok(gpu.queue.submit([]))
            })
        })??;
        let march = Arc::clone(&self.march);
        let Some(settle) = &march.settle else {
            return Ok(());
        };
        gpu.scoped(|_| {
            gpu.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&data));
            let bound = [(0, &self.frame), (6, &self.table), (7, colors), (8, depths)];
            let mut commands = gpu.commands();
            settle.run(gpu, &mut commands, &bound, data.tiles);
            gpu.queue.submit([commands.finish()]);
        })
    }

    /// Makes the planes from one on to another, both included, that a part lacks.
    fn make_planes(&mut self, [from, to]: [u32; 2], rows: &Range<u32>, bands: &Bands) {
        let Self {
            gpu,
            planes,
            opened,
            frame,
            ..
        } = self;
        let tiles = opened.tiles;
        let ring = self.ring.get_or_insert_with(|| Ring {
            planes: gpu.buffer(
                "ring of planes",
                ring_bytes(opened.data.size, bands.rows),
                wgpu::BufferUsages::STORAGE,
            ),
            part: gpu.buffer(
                "part",
                size_of::<PartData>() as u64,
                wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            ),
            row: rows.start,
            next_group: 0,
        });
        if ring.row != rows.start {
            (ring.row, ring.next_group) = (rows.start, 0);
        }
        let last = (to / GROUP).min(tiles.groups - 1);
        let first = ring.next_group.max(from / GROUP);
        let pitch = tiles.columns * EDGE;
        let data = PartData {
            columns: tiles.columns,
            groups: tiles.groups,
            first_row: rows.start,
            first_group: first,
            pitch,
            points: pitch * EDGE * (bands.rows + 1),
            unused: [0; 2],
        };
        gpu.queue.write_buffer(&ring.part, 0, bytemuck::bytes_of(&data));
        if first > last {
            return;
        }
        ring.next_group = last + 1;
        // Points beside the part's pixels are in the next row of tiles.
        let rows = (rows.end + 1).min(tiles.rows) - rows.start;
        let mut commands = gpu.commands();
        let bound = [
            (0, &*frame),
            (1, &opened.sheets),
            (2, &opened.splats),
            (3, &opened.entries),
            (4, &opened.ranges),
            (5, &ring.planes),
            (11, &ring.part),
        ]
        .map(|(binding, buffer)| (binding, buffer.as_entire_binding()));
        let dispatched = [tiles.columns, rows, last + 1 - first];
        planes.dispatch(gpu, &mut commands, &bound, dispatched);
        gpu.queue.submit([commands.finish()]);
    }
}

impl GatheredLayer for CloudLayer<'_> {
    fn intervals(&self) -> Range<i64> {
        let first = self.opened.first_plane;
        first..first + i64::from(self.opened.data.to_interval)
    }

    fn gather(&mut self, part: &Part<'_>) -> Result<(), SceneError> {
        let first_plane = self.opened.first_plane;
        let Some(data) = part.of(&self.opened.data, first_plane, self.intervals()) else {
            return Ok(());
        };
        let planes = [data.from_interval.saturating_sub(1), data.to_interval + 1];
        self.make_planes(planes, &part.rows, part.bands);
        let Some(ring) = &self.ring else {
            return Ok(());
        };
        let gpu = self.gpu;
        gpu.queue
            .write_buffer(&self.frame, 0, bytemuck::bytes_of::<FrameData>(&data));
        let [colors, _] = self.canvas.targets();
        let common = [
            (0, &self.frame),
            (1, &self.opened.sheets),
            (2, &ring.planes),
            (3, &self.opened.tile_sheets),
            (7, colors),
            (8, part.second),
            (11, &ring.part),
        ];
        let of_values = [(6, &self.table), (9, &self.effects), (10, &self.faces)];
        let used = match self.mode {
            CloudMode::Colors | CloudMode::Values(_) => 0,
            CloudMode::Field => 1,
            CloudMode::FieldEffects => 3,
        };
        let bound = [&common[..], &of_values[..used]].concat();
        let mut commands = gpu.commands();
        let dispatched = [data.tiles[0], part.rows.end - part.rows.start];
        self.march.march.run(gpu, &mut commands, &bound, dispatched);
        gpu.queue.submit([commands.finish()]);
        Ok(())
    }
}
