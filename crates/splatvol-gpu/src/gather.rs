//! Gather: several layers on common planes. Their material in an interval is gathered, then composited together.
//!
//! The picture is made in bands of rows of tiles, some intervals at a time, so that what is gathered has room.

use std::ops::Range;

use splatvol_core::engine::Task;
use splatvol_scene::{Frame, SceneError};

use crate::clouds::{CloudLayer, ring_bytes};
use crate::device::GpuDevice;
use crate::layout::{FrameData, TILE};
use crate::march::{Bound, Canvas, March};
use crate::pager::Pager;
use crate::pass::{Pass, groups};

/// Intervals that are gathered together.
const TOGETHER: u32 = 16;
/// Bytes of a pixel's gathered interval.
const MATERIAL: u64 = 32;
/// Most bytes for gathered intervals, and for the planes of a cloud: every device of WebGPU's default limits binds them.
const ROOM: u64 = 128 << 20;

/// Layers of one picture; their planes are multiples of the same distance.
pub(crate) struct Gather<'a> {
    pub gpu: &'a GpuDevice,
    pub canvas: &'a Canvas,
    /// The picture, apart from its layers.
    pub data: FrameData,
    pub volumes: &'a [March<'a>],
    pub clouds: Vec<CloudLayer<'a>>,
    pub mixture: &'a Pass,
    pub clear: &'a Pass,
}

/// A layer whose intervals are gathered.
pub(crate) trait GatheredLayer {
    /// Its intervals, as numbers of planes among those of all layers.
    fn intervals(&self) -> Range<i64>;

    /// Adds its material in a part of the picture.
    ///
    /// # Errors
    /// A device that fails.
    fn gather(&mut self, part: &Part<'_>) -> Result<(), SceneError>;
}

/// Some intervals of some rows of tiles.
pub(crate) struct Part<'a> {
    pub bands: &'a Bands,
    pub rows: Range<u32>,
    /// Among those of all layers.
    pub intervals: Range<i64>,
    /// Beside colours: gathered intervals, or depths of what rays keep.
    pub second: &'a wgpu::Buffer,
}

impl Part<'_> {
    /// A layer's data for the part; `None` where it has none of the intervals.
    pub(crate) fn of(&self, data: &FrameData, first_plane: i64, own: Range<i64>) -> Option<FrameData> {
        let (start, end) = (
            own.start.max(self.intervals.start),
            own.end.min(self.intervals.end),
        );
        (start < end).then(|| FrameData {
            from_interval: (start - first_plane) as u32,
            to_interval: (end - first_plane) as u32,
            first_tile_row: self.rows.start,
            gather_offset: (first_plane - self.intervals.start) as i32,
            band_pixels: self.bands.pixels() as u32,
            ..*data
        })
    }
}

/// A volume's data, and its buffers.
struct Begun<'a> {
    march: &'a March<'a>,
    data: FrameData,
    bound: Bound,
    /// Number of its first plane among those of all layers.
    first_plane: i64,
    pager: Option<Pager<'a>>,
}

/// Rows of tiles that are made together, and their intervals.
pub(crate) struct Bands {
    pub rows: u32,
    intervals: u32,
    pixels_of_row: u64,
}

impl Bands {
    pub(crate) fn new(gpu: &GpuDevice, data: &FrameData, has_clouds: bool) -> Self {
        let pixels_of_row = u64::from(data.size[0]) * u64::from(TILE[1]);
        let room = ROOM.min(gpu.device.limits().max_storage_buffer_binding_size);
        let intervals = (room / MATERIAL / pixels_of_row).clamp(1, u64::from(TOGETHER)) as u32;
        let samples_of_row = pixels_of_row * u64::from(intervals);
        let mut rows = (room / MATERIAL).min(gpu.samples_per_dispatch) / samples_of_row;
        if has_clouds {
            let row = ring_bytes(data.size, 1) - ring_bytes(data.size, 0);
            rows = rows.min((room / row).saturating_sub(1));
        }
        Self {
            rows: (rows as u32).clamp(1, data.tiles[1]),
            intervals,
            pixels_of_row,
        }
    }

    fn pixels(&self) -> u64 {
        self.pixels_of_row * u64::from(self.rows)
    }

    /// Makes so many rows of tiles and these intervals part by part; waits for each part but the last two, so that a stopped
    /// picture ends soon.
    ///
    /// # Errors
    /// A stopped picture, or a device that fails.
    pub(crate) fn each(
        &self,
        (gpu, second): (&GpuDevice, &wgpu::Buffer),
        (rows, planes): (u32, Range<i64>),
        task: Task<'_>,
        mut make: impl FnMut(&Part<'_>) -> Result<wgpu::SubmissionIndex, SceneError>,
    ) -> Result<(), SceneError> {
        let mut before = None;
        for row in (0..rows).step_by(self.rows as usize) {
            for start in planes.clone().step_by(self.intervals as usize) {
                task.go_on()?;
                let part = Part {
                    bands: self,
                    rows: row..(row + self.rows).min(rows),
                    intervals: start..(start + i64::from(self.intervals)).min(planes.end),
                    second,
                };
                if let Some(before) = before.replace(make(&part)?) {
                    gpu.wait(Some(before))?;
                    let done = (start - planes.start) as f64 / (planes.end - planes.start) as f64;
                    let of_rows = f64::from(self.rows.min(rows - row)) * done;
                    task.report((f64::from(row) + of_rows) / f64::from(rows));
                }
            }
        }
        Ok(())
    }
}

impl Gather<'_> {
    /// Renders into a frame. Returns the bytes on the device that its clouds took.
    ///
    /// # Errors
    /// A stopped picture, or a device that fails.
    pub(crate) async fn render(mut self, task: Task<'_>, frame: &mut Frame) -> Result<usize, SceneError> {
        let gpu = self.gpu;
        self.canvas.clear(gpu, self.clear)?;
        self.add(task)?;
        self.canvas.resolve(gpu, frame, 0.0).await?;
        Ok(self.clouds.iter().map(CloudLayer::bytes).sum())
    }

    /// Adds what they show behind what the canvas has.
    ///
    /// # Errors
    /// A stopped picture, or a device that fails.
    pub(crate) fn add(&mut self, task: Task<'_>) -> Result<(), SceneError> {
        let gpu = self.gpu;
        gpu.scoped(|_| self.submit(task))?
    }

    fn submit(&mut self, task: Task<'_>) -> Result<(), SceneError> {
        let bands = Bands::new(self.gpu, &self.data, !self.clouds.is_empty());
        let size = bands.pixels() * u64::from(bands.intervals) * MATERIAL;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let gathered = self.gpu.buffer("gathered", size, usage);
        let pixels = self.mixed_data();
        let mut volumes: Vec<Begun<'_>> = self
            .volumes
            .iter()
            .map(|march| Begun::new(march, &gathered, task))
            .collect();
        let clouds = self
            .clouds
            .iter_mut()
            .map(|cloud| cloud as &mut dyn GatheredLayer);
        let mut layers: Vec<&mut dyn GatheredLayer> = volumes
            .iter_mut()
            .map(|volume| volume as &mut dyn GatheredLayer)
            .chain(clouds)
            .collect();
        let Some(planes) = intervals_of(&layers) else {
            return Ok(());
        };
        let mixed = Mixed {
            gpu: self.gpu,
            canvas: self.canvas,
            pass: self.mixture,
            frame: pixels,
            data: self.data,
        };
        let all = (self.data.tiles[1], planes);
        bands.each((self.gpu, &gathered), all, task, |part| {
            mixed.part(part, &mut layers)
        })
    }

    /// A buffer for the data of parts that are composited.
    fn mixed_data(&self) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        self.gpu.buffer("frame", size_of::<FrameData>() as u64, usage)
    }
}

/// Composites what is gathered.
struct Mixed<'a> {
    gpu: &'a GpuDevice,
    canvas: &'a Canvas,
    pass: &'a Pass,
    frame: wgpu::Buffer,
    data: FrameData,
}

impl Mixed<'_> {
    /// Gathers a part, and composites it.
    fn part(
        &self,
        part: &Part<'_>,
        layers: &mut [&mut dyn GatheredLayer],
    ) -> Result<wgpu::SubmissionIndex, SceneError> {
        let gpu = self.gpu;
        let mut commands = gpu.commands();
        commands.clear_buffer(part.second, 0, None);
        gpu.queue.submit([commands.finish()]);
        for layer in layers {
            layer.gather(part)?;
        }
        let data = FrameData {
            first_tile_row: part.rows.start,
            band_pixels: part.bands.pixels() as u32,
            gathered_intervals: (part.intervals.end - part.intervals.start) as u32,
            ..self.data
        };
        gpu.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&data));
        let [colors, depths] = self.canvas.targets();
        let buffers = [(0, &self.frame), (7, colors), (8, part.second), (9, depths)];
        let mut commands = gpu.commands();
        let dispatched = groups(part.bands.pixels() as u32, 64);
        self.pass.run(gpu, &mut commands, &buffers, dispatched);
        Ok(gpu.queue.submit([commands.finish()]))
    }
}

impl<'a> Begun<'a> {
    fn new(march: &'a March<'a>, gathered: &wgpu::Buffer, task: Task<'a>) -> Self {
        let data = march.data();
        Self {
            bound: march.begin(&data, gathered),
            first_plane: march.picture.first_plane(),
            pager: march.pager(task),
            march,
            data,
        }
    }

    /// Gathers a part's intervals, in several dispatches if their pages have no room together.
    fn dispatch(&mut self, data: &FrameData, rows: u32) -> Result<(), SceneError> {
        let mut start = data.from_interval;
        while start < data.to_interval {
            let count = match &mut self.pager {
                Some(pager) => pager.load(start..data.to_interval)?,
                None => data.to_interval - start,
            };
            let part = FrameData {
                from_interval: start,
                to_interval: start + count,
                ..*data
            };
            self.march.dispatch((&part, rows), &self.bound, false);
            start += count;
        }
        Ok(())
    }
}

impl GatheredLayer for Begun<'_> {
    fn intervals(&self) -> Range<i64> {
        let Range { start, end } = self.data.from_interval..self.data.to_interval;
        self.first_plane + i64::from(start)..self.first_plane + i64::from(end)
    }

    fn gather(&mut self, part: &Part<'_>) -> Result<(), SceneError> {
        match part.of(&self.data, self.first_plane, self.intervals()) {
            Some(data) => self.dispatch(&data, part.rows.end - part.rows.start),
            None => Ok(()),
        }
    }
}

/// Intervals of all layers, from front to back.
pub(crate) fn planes_of(volumes: &[March<'_>], clouds: &[CloudLayer<'_>]) -> usize {
    let volumes = volumes.iter().map(|march| {
        let planes = march.picture.view.planes();
        planes.first..planes.first + planes.count as i64
    });
    let all = volumes.chain(clouds.iter().map(GatheredLayer::intervals));
    let all = all.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end));
    all.map_or(0, |all| (all.end - all.start).max(0) as usize)
}

/// All layers' intervals.
fn intervals_of(layers: &[&mut dyn GatheredLayer]) -> Option<Range<i64>> {
    let own = layers
        .iter()
        .map(|layer| layer.intervals())
        .filter(|own| !own.is_empty());
    own.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
}
