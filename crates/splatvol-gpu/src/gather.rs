//! Gather: several layers on common planes. Their material in an interval is gathered, then composited together.
//!
//! The picture is made in bands of rows of tiles, some intervals at a time, so that what is gathered has room.

use std::ops::Range;

use splatvol_core::engine::Task;
use splatvol_scene::{Frame, SceneError};

use crate::device::GpuDevice;
use crate::layout::{FrameData, TILE};
use crate::march::{Bound, Canvas, March};
use crate::pager::Pager;
use crate::pass::{Pass, groups};

/// Intervals that are gathered together.
const TOGETHER: u32 = 16;
/// Bytes of a pixel's gathered interval.
const MATERIAL: u64 = 32;
/// Bytes for gathered intervals, which every device can bind.
const ROOM: u64 = 128 << 20;

/// Layers of one picture; their planes are multiples of the same distance.
pub(crate) struct Gather<'a> {
    pub gpu: &'a GpuDevice,
    pub canvas: &'a Canvas,
    pub layers: &'a [March<'a>],
    pub mixture: &'a Pass,
}

/// A layer's data, and its buffers.
struct Begun<'a> {
    march: &'a March<'a>,
    data: FrameData,
    bound: Bound,
    /// Number of its first plane among those of all layers.
    first_plane: i64,
    pager: Option<Pager<'a>>,
}

/// Rows of tiles that are made together, and their intervals.
struct Bands {
    rows: u32,
    intervals: u32,
    pixels_of_row: u64,
}

impl Bands {
    fn new(data: &FrameData, most_intervals: u32) -> Self {
        let pixels_of_row = u64::from(data.size[0]) * u64::from(TILE[1]);
        let intervals = (ROOM / MATERIAL / pixels_of_row).clamp(1, u64::from(most_intervals)) as u32;
        let rows = ROOM / MATERIAL / pixels_of_row / u64::from(intervals);
        Self {
            rows: (rows as u32).clamp(1, data.tiles[1]),
            intervals,
            pixels_of_row,
        }
    }

    fn pixels(&self) -> u64 {
        self.pixels_of_row * u64::from(self.rows)
    }
}

impl Gather<'_> {
    /// Renders into a frame.
    ///
    /// # Errors
    /// A stopped picture, or a device that fails.
    pub(crate) fn render(&self, task: Task<'_>, frame: &mut Frame) -> Result<(), SceneError> {
        self.gpu.scoped(|_| self.submit(task))??;
        self.canvas.resolve(self.gpu, frame)
    }

    fn submit(&self, task: Task<'_>) -> Result<(), SceneError> {
        let [first, ..] = self.layers else {
            return Ok(());
        };
        let bands = Bands::new(&first.data(), TOGETHER);
        let size = bands.pixels() * u64::from(bands.intervals) * MATERIAL;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let gathered = self.gpu.buffer("gathered", size, usage);
        self.canvas.clear(self.gpu);
        let mut begun: Vec<Begun<'_>> = self
            .layers
            .iter()
            .map(|march| Begun::new(march, &gathered))
            .collect();
        let Some(planes) = intervals_of(&begun) else {
            return Ok(());
        };
        let rows = first.data().tiles[1];
        let mut before = None;
        for row in (0..rows).step_by(bands.rows as usize) {
            for from in planes.clone().step_by(bands.intervals as usize) {
                task.go_on()?;
                let part = from..(from + i64::from(bands.intervals)).min(planes.end);
                let band = (&bands, row..(row + bands.rows).min(rows));
                let submitted = self.part(band, part, &mut begun, &gathered)?;
                if let Some(before) = before.replace(submitted) {
                    self.gpu.wait(Some(before))?;
                    let done = (from - planes.start) as f64 / (planes.end - planes.start) as f64;
                    let of_rows = f64::from(bands.rows.min(rows - row)) * done;
                    task.report((f64::from(row) + of_rows) / f64::from(rows));
                }
            }
        }
        Ok(())
    }

    /// Gathers some intervals of a band, and composites them.
    fn part(
        &self,
        (bands, rows): (&Bands, Range<u32>),
        intervals: Range<i64>,
        begun: &mut [Begun<'_>],
        gathered: &wgpu::Buffer,
    ) -> Result<wgpu::SubmissionIndex, SceneError> {
        let mut commands = self.gpu.commands();
        commands.clear_buffer(gathered, 0, None);
        self.gpu.queue.submit([commands.finish()]);
        for layer in &mut *begun {
            if let Some(data) = layer.part(bands, rows.start, &intervals) {
                layer.dispatch(&data, rows.end - rows.start)?;
            }
        }
        let whole = &begun[0];
        let data = FrameData {
            first_tile_row: rows.start,
            band_pixels: bands.pixels() as u32,
            gathered_intervals: (intervals.end - intervals.start) as u32,
            ..whole.data
        };
        let frame = &whole.bound.frame;
        self.gpu.queue.write_buffer(frame, 0, bytemuck::bytes_of(&data));
        let [colors, depths] = self.canvas.targets();
        let buffers = [(0, frame), (7, colors), (8, gathered), (9, depths)];
        let mut commands = self.gpu.commands();
        self.mixture.run(
            self.gpu,
            &mut commands,
            &buffers,
            groups(bands.pixels() as u32, 64),
        );
        Ok(self.gpu.queue.submit([commands.finish()]))
    }
}

impl<'a> Begun<'a> {
    fn new(march: &'a March<'a>, gathered: &wgpu::Buffer) -> Self {
        let data = march.data();
        Self {
            bound: march.begin(&data, gathered),
            first_plane: march.picture.first_plane(),
            pager: march.pager(),
            march,
            data,
        }
    }

    /// Gathers a part's intervals, in several dispatches if their pages have no room together.
    fn dispatch(&mut self, data: &FrameData, rows: u32) -> Result<(), SceneError> {
        let mut from = data.from_interval;
        while from < data.to_interval {
            let count = match &mut self.pager {
                Some(pager) => pager.load(from..data.to_interval)?,
                None => data.to_interval - from,
            };
            let part = FrameData {
                from_interval: from,
                to_interval: from + count,
                ..*data
            };
            self.march.dispatch((&part, rows), &self.bound, false);
            from += count;
        }
        Ok(())
    }

    /// Its intervals, as numbers of planes among those of all layers.
    fn intervals(&self) -> Range<i64> {
        let Range { start, end } = self.data.from_interval..self.data.to_interval;
        self.first_plane + i64::from(start)..self.first_plane + i64::from(end)
    }

    /// The data for a part of all layers' intervals; `None` where it has none of them.
    fn part(&self, bands: &Bands, first_row: u32, intervals: &Range<i64>) -> Option<FrameData> {
        let own = self.intervals();
        let (start, end) = (own.start.max(intervals.start), own.end.min(intervals.end));
        (start < end).then(|| FrameData {
            from_interval: (start - self.first_plane) as u32,
            to_interval: (end - self.first_plane) as u32,
            first_tile_row: first_row,
            gather_offset: (self.first_plane - intervals.start) as i32,
            band_pixels: bands.pixels() as u32,
            ..self.data
        })
    }
}

/// All layers' intervals.
fn intervals_of(begun: &[Begun<'_>]) -> Option<Range<i64>> {
    let own = begun.iter().map(Begun::intervals).filter(|own| !own.is_empty());
    own.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
}
