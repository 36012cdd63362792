//! March: the passes of a picture, and its pixels back from the device.

use rayon::prelude::*;
use splatvol_core::engine::Task;
use splatvol_scene::{Frame, SceneError};

use crate::atlas::{Assembler, Atlas};
use crate::device::GpuDevice;
use crate::layout::{FrameData, Picture, SheetData};
use crate::mode::Mode;
use crate::pager::Pager;
use crate::pass::{Pass, groups};
use crate::pipelines::{Marches, Pipelines};
use crate::voxels::Voxels;

/// Intervals that a dispatch takes at least: each begins with planes of the one before.
const LEAST_INTERVALS: u64 = 8;

/// Buffers of pictures of one size.
#[derive(Debug)]
pub(crate) struct Canvas {
    pixels: u64,
    colors: wgpu::Buffer,
    depths: wgpu::Buffer,
    /// Colours, then depths, for the host.
    host: wgpu::Buffer,
}

/// Bytes of a pixel's colour and transmittance, and of its depth.
const COLOR: u64 = 16;
const DEPTH: u64 = 4;

impl Canvas {
    /// # Errors
    /// Memory that the device refuses.
    pub(crate) fn new(gpu: &GpuDevice, pixels: u64) -> Result<Self, SceneError> {
        use wgpu::BufferUsages as Usage;
        let on_device = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        gpu.scoped(|gpu| Self {
            pixels,
            colors: gpu.buffer("colors", pixels * COLOR, on_device),
            depths: gpu.buffer("depths", pixels * DEPTH, on_device),
            host: gpu.buffer(
                "picture",
                pixels * (COLOR + DEPTH),
                Usage::MAP_READ | Usage::COPY_DST,
            ),
        })
    }

    /// Whether it is for pictures of so many pixels.
    pub(crate) fn is_of(&self, pixels: u64) -> bool {
        self.pixels == pixels
    }

    /// Empties the picture.
    ///
    /// # Errors
    /// A device that fails.
    pub(crate) fn clear(&self, gpu: &GpuDevice, pass: &Pass) -> Result<(), SceneError> {
        gpu.scoped(|gpu| {
            let mut commands = gpu.commands();
            let bound = [(0, &self.colors), (1, &self.depths)];
            pass.run(gpu, &mut commands, &bound, groups(self.pixels as u32, 256));
            gpu.queue.submit([commands.finish()]);
        })
    }

    /// Brings the picture to a frame, over a background of this opacity whose light it has already.
    ///
    /// # Errors
    /// A device that fails.
    pub(crate) async fn resolve(
        &self,
        gpu: &GpuDevice,
        frame: &mut Frame,
        background: f32,
    ) -> Result<(), SceneError> {
        self.read(gpu, |colors, depths| {
            resolve((frame, background), (colors, depths));
        })
        .await
    }

    /// Brings colours with transmittances, and sums of depths, to the host.
    ///
    /// # Errors
    /// A device that fails.
    pub(crate) async fn read(
        &self,
        gpu: &GpuDevice,
        take: impl FnOnce(&[[f32; 4]], &[f32]),
    ) -> Result<(), SceneError> {
        let colors = self.pixels * COLOR;
        let mut commands = gpu.commands();
        commands.copy_buffer_to_buffer(&self.colors, 0, &self.host, 0, colors);
        commands.copy_buffer_to_buffer(&self.depths, 0, &self.host, colors, self.pixels * DEPTH);
        gpu.queue.submit([commands.finish()]);
        gpu.map(&self.host, |bytes| {
            let (colors, depths) = bytes.split_at(colors as usize);
            take(bytemuck::cast_slice(colors), bytemuck::cast_slice(depths));
        })
        .await
    }

    /// Buffers of colours and depths.
    pub(crate) fn targets(&self) -> [&wgpu::Buffer; 2] {
        [&self.colors, &self.depths]
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> usize {
        (2 * self.pixels * (COLOR + DEPTH)) as usize
    }
}

/// Everything that a picture is made with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct March<'a> {
    pub gpu: &'a GpuDevice,
    pub pipelines: &'a Pipelines,
    pub marches: &'a Marches,
    pub mode: Mode,
    pub atlas: &'a Atlas,
    pub canvas: &'a Canvas,
    pub picture: Picture<'a>,
    /// Voxels that are classified before they are splatted, and the pass for it.
    pub voxels: Option<(&'a Voxels, &'a Pass)>,
    /// The share of its extinction in interval 0, and its change to the next: one and none, unless two levels fade.
    pub share: [f32; 2],
    /// Whether it is the last whose integrals are added up on the canvas, which become pixels then.
    pub settles: bool,
}

/// Buffers of one picture, bound to its passes.
pub(crate) struct Bound {
    pub frame: wgpu::Buffer,
    cull: wgpu::BindGroup,
    pub march: wgpu::BindGroup,
    table: wgpu::Buffer,
    effects: wgpu::Buffer,
}

impl March<'_> {
    /// Adds what it shows behind what the canvas has.
    ///
    /// # Errors
    /// A stopped picture, or a device that fails.
    pub(crate) fn add(&self, task: Task<'_>) -> Result<(), SceneError> {
        self.gpu.scoped(|_| self.submit(&self.data(), task))?
    }

    /// The frame's data, with the places of the volume's pages.
    pub(crate) fn data(&self) -> FrameData {
        let layout = &self.atlas.layout;
        let frame = self.picture.frame();
        FrameData {
            pages: layout.pages,
            slots: [layout.slots[0], layout.slots[1]],
            per_texel: layout.size().map(|n| 1.0 / n as f32),
            channel_layers: layout.channel_layers(),
            hull: self.mode.hull(self.picture.level),
            // Rays through a body add its own light up.
            lit: if self.mode == Mode::Xray { 0 } else { frame.lit },
            share: self.share[0],
            share_step: self.share[1],
            ..frame
        }
    }

    /// Submits all passes; waits for each part but the last two, so that a stopped picture ends soon.
    fn submit(&self, data: &FrameData, task: Task<'_>) -> Result<(), SceneError> {
        let [_, depths] = self.canvas.targets();
        let bound = self.begin(data, depths);
        let intervals = data.from_interval..data.to_interval;
        let most = self.intervals_together(self.canvas.pixels);
        let mut pager = self.pager(task);
        let mut before = None;
        let mut from = intervals.start;
        while from < intervals.end {
            task.go_on()?;
            let mut step = most.min(intervals.end - from);
            if let Some(pager) = &mut pager {
                step = pager.load(from..from + step)?;
            }
            let part = FrameData {
                from_interval: from,
                to_interval: from + step,
                ..*data
            };
            from += step;
            let is_last = self.settles && part.to_interval == intervals.end;
            let submitted = self.dispatch((&part, data.tiles[1]), &bound, is_last);
            if let Some(before) = before.replace(submitted) {
                self.gpu.wait(Some(before))?;
                task.report(f64::from(from - intervals.start) / intervals.len() as f64);
            }
        }
        Ok(())
    }

    /// The pager, if the volume's pages have not all room on the device.
    pub(crate) fn pager<'m>(&'m self, task: Task<'m>) -> Option<Pager<'m>> {
        let assembler = Assembler {
            gpu: self.gpu,
            pass: &self.pipelines.assemble,
            task: task.unseen(&|_| {}),
        };
        Pager::new(assembler, self.atlas, &self.picture)
    }

    /// Intervals of a dispatch, for so many pixels.
    pub(crate) fn intervals_together(&self, pixels: u64) -> u32 {
        let points = self.picture.most_low_pass_points();
        let samples = pixels.max(1) * u64::from(points * points);
        (self.gpu.samples_per_dispatch / samples).clamp(LEAST_INTERVALS, u64::from(u32::MAX)) as u32
    }

    /// Buffers of a picture. `second`: beside colours, depths or gathered intervals.
    pub(crate) fn bind(
        &self,
        data: &FrameData,
        (sheets, table): (&[SheetData], &[[f32; 4]]),
        second: &wgpu::Buffer,
    ) -> Bound {
        use wgpu::BufferUsages as Usage;
        let Self {
            gpu,
            pipelines,
            atlas,
            canvas,
            ..
        } = self;
        let frame = gpu.buffer(
            "frame",
            size_of::<FrameData>() as u64,
            Usage::UNIFORM | Usage::COPY_DST,
        );
        let sheets = gpu.buffer_of("sheets", sheets);
        let words = u64::from(data.tiles[0]) * u64::from(data.tiles[1]) * u64::from(data.words);
        let tile_sheets = gpu.buffer("tile sheets", 4 * words.max(1), Usage::STORAGE);
        let table = gpu.buffer_of("table", table);
        let effects = gpu.buffer_of("effects", &self.picture.effects.data);
        // Two vectors per pixel.
        let faces = match self.mode {
            Mode::Effects => 32 * canvas.pixels,
            _ => 32,
        };
        let faces = gpu.buffer("faces", faces, Usage::STORAGE);
        let whole = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let cull = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("cull"),
            layout: &pipelines.cull_layout,
            entries: &[
                whole(0, frame.as_entire_binding()),
                whole(2, atlas.pages.as_entire_binding()),
                whole(3, tile_sheets.as_entire_binding()),
            ],
        });
        let march = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("march"),
            layout: &pipelines.march_layout,
            entries: &[
                whole(0, frame.as_entire_binding()),
                whole(1, sheets.as_entire_binding()),
                whole(2, atlas.pages.as_entire_binding()),
                whole(3, tile_sheets.as_entire_binding()),
                whole(4, wgpu::BindingResource::TextureView(&atlas.view)),
                whole(5, wgpu::BindingResource::Sampler(&pipelines.nearest)),
                whole(6, table.as_entire_binding()),
                whole(7, canvas.colors.as_entire_binding()),
                whole(8, second.as_entire_binding()),
                whole(9, effects.as_entire_binding()),
                whole(10, faces.as_entire_binding()),
            ],
        });
        Bound {
            frame,
            cull,
            march,
            table,
            effects,
        }
    }

    /// Classifies voxels, and finds the planes of tiles. `second`: as for [`Self::bind`].
    pub(crate) fn begin(&self, data: &FrameData, second: &wgpu::Buffer) -> Bound {
        let Self { gpu, .. } = self;
        let look = self.mode.look(self.picture.level);
        let bound = self.bind(data, (&self.picture.sheets(), &look), second);
        gpu.queue.write_buffer(&bound.frame, 0, bytemuck::bytes_of(data));
        if self.atlas.is_paged() {
            self.atlas.set_needed(gpu);
        }
        let mut commands = gpu.commands();
        if let Some((voxels, pass)) = self.voxels {
            let shared = [&bound.frame, &bound.table, &bound.effects];
            voxels.classify(gpu, pass, &mut commands, shared);
        }
        {
            let mut pass = gpu.pass(&mut commands, "cull");
            pass.set_pipeline(&self.pipelines.cull);
            pass.set_bind_group(0, &bound.cull, &[]);
            let pages: u32 = data.pages.iter().map(|&n| n as u32).product();
            // An invocation per octant.
            let groups = (8 * pages).div_ceil(64);
            // At most 65,535 groups along an axis.
            let across = groups.min(CULL_ROW);
            pass.dispatch_workgroups(across, groups.div_ceil(CULL_ROW), 1);
        }
        gpu.queue.submit([commands.finish()]);
        bound
    }

    /// Marches some intervals of so many rows of tiles.
    pub(crate) fn dispatch(
        &self,
        (part, rows): (&FrameData, u32),
        bound: &Bound,
        is_last: bool,
    ) -> wgpu::SubmissionIndex {
        let gpu = self.gpu;
        gpu.queue.write_buffer(&bound.frame, 0, bytemuck::bytes_of(part));
        let mut commands = gpu.commands();
        {
            let mut pass = gpu.pass(&mut commands, "march");
            pass.set_bind_group(0, &bound.march, &[]);
            pass.set_pipeline(&self.marches.march);
            pass.dispatch_workgroups(part.tiles[0], rows, 1);
            if let Some(settle) = self.marches.settle.as_ref().filter(|_| is_last) {
                pass.set_pipeline(settle);
                pass.dispatch_workgroups(part.tiles[0], rows, 1);
            }
        }
        gpu.queue.submit([commands.finish()])
    }
}

/// Pixels of transmittance, or less than nothing: of negative optical depth, and of depth sums to those of a frame, as
/// `splatvol_cpu`'s resolve.
fn resolve((frame, background): (&mut Frame, f32), (colors, depth_sums): (&[[f32; 4]], &[f32])) {
    let rest = frame.depth.par_iter_mut().zip(&mut frame.optical_depth);
    let targets = frame.image.pixels.par_iter_mut().zip(rest);
    let found = colors.par_iter().zip(depth_sums);
    targets.zip(found).with_min_len(PIXELS_TOGETHER).for_each(
        |((pixel, (depth, optical_depth)), (&[r, g, b, kept], &depth_sum))| {
            let (through, tau) = if kept < 0.0 {
                (kept.exp(), -kept)
            } else {
                (kept, -kept.max(f32::MIN_POSITIVE).ln())
            };
            let covered = 1.0 - through;
            *pixel = [r, g, b, covered + through * background];
            (*depth, *optical_depth) = if covered > 0.0 {
                (depth_sum / covered, tau)
            } else {
                (f32::INFINITY, 0.0)
            };
        },
    );
}

/// Pixels that a thread resolves together at least.
const PIXELS_TOGETHER: usize = 16_384;

/// Groups of the pass `cull` along x, of 64 invocations each: `ROW` in its shader.
const CULL_ROW: u32 = 1024;
