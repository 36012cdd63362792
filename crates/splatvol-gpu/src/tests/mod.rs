//! Shaders against their Rust twins, and against the f64 reference: WGSL functions run over arrays of random input.
#![allow(clippy::unwrap_used, reason = "tests")]

mod field;
mod layout;
mod operators;
mod robust;
mod shade;
mod sort;
mod tint;

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use splatvol_core::engine::{Control, Task};
use splatvol_core::level::{VolumeLook, Wanted};
use splatvol_core::plan::{GridView, Sampling};
use splatvol_core::prepared::PreparedVolumes;
use splatvol_scene::{
    Camera, Grid, ImageSize, Projection, RenderSettings, SheetSettings, TransferFunction, Volume,
};
use splatvol_testing::fields::Noise;
use splatvol_testing::sample;

use crate::atlas::{Assembler, Atlas};
use crate::device::{GpuConfig, GpuDevice};
use crate::effects::Effects;
use crate::error::GpuError;
use crate::layout::{Picture, SheetData};
use crate::march::{Canvas, March};
use crate::mode::Mode;
use crate::pipelines::{Pipelines, Variant, pipeline};

/// The device of the tests; without one the calling test is skipped.
fn device() -> Option<GpuDevice> {
    match pollster::block_on(GpuDevice::open(&GpuConfig::default())) {
        Ok(gpu) => Some(gpu),
        Err(error @ GpuError::NoAdapter { .. }) => {
            splatvol_recorded::skip(&error.to_string());
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// The data of a buffer.
fn read<T: Pod>(gpu: &GpuDevice, buffer: &wgpu::Buffer, count: usize) -> Vec<T> {
    use wgpu::BufferUsages as Usage;
    if count == 0 {
        return Vec::new();
    }
    let bytes = (size_of::<T>() * count) as u64;
    let host = gpu.buffer("host", bytes, Usage::MAP_READ | Usage::COPY_DST);
    let mut commands = gpu.commands();
    commands.copy_buffer_to_buffer(buffer, 0, &host, 0, bytes);
    gpu.queue.submit([commands.finish()]);
    pollster::block_on(gpu.map(&host, |bytes| bytemuck::cast_slice(bytes).to_vec())).unwrap()
}

/// A random volume with a transfer function that shows all of it.
struct Subject {
    volume: Arc<Volume>,
    transfer_function: TransferFunction,
    settings: RenderSettings<SheetSettings>,
    mode: Mode,
}

impl Subject {
    fn new(settings: RenderSettings, dims: [usize; 3]) -> Self {
        let grid = Grid::centred(dims, DVec3::new(1.0, 1.25, 0.8)).unwrap();
        let sheets = *settings.method.sheets().unwrap();
        Self {
            volume: Arc::new(sample(&Noise::new(18, 24, DVec3::splat(1.3)), &grid)),
            transfer_function: splatvol_testing::transfer::constant_extinction(0.3, [0.9, 0.5, 0.2]),
            settings: RenderSettings {
                size: ImageSize::new(16, 16).unwrap(),
                ..settings
            }
            .with(sheets),
            mode: Mode::Material,
        }
    }

    /// Runs an entry point `probe` once per input; it finds them in `sheets`, and writes `colors`.
    fn run(&self, gpu: &GpuDevice, entry: &str, inputs: &[SheetData]) -> (Vec<[f32; 4]>, Facts) {
        let mut prepared = PreparedVolumes::default();
        let [pyramid] = prepared.of_scene([&self.volume].into_iter(), &self.settings) else {
            unreachable!("one volume")
        };
        let look = VolumeLook {
            transfer_function: &self.transfer_function,
            unit_distance: 1.0,
            labels: false,
        };
        let stop = std::sync::atomic::AtomicBool::new(false);
        let level = pyramid.classify(0, look, Wanted::Visible, &stop).unwrap();
        let camera = Camera::new(
            DVec3::new(0.0, -300.0, 40.0),
            DVec3::ZERO,
            DVec3::Z,
            Projection::Perspective { fov_degrees: 20.0 },
        )
        .unwrap();
        let grid = level.field.source().grid();
        let view = GridView::new(grid, (&camera, &self.settings), Sampling::Field, None);
        let taps = if self.settings.method.kernel.radius > 2.0 {
            6
        } else {
            4
        };
        let mut pipelines = Pipelines::new(gpu).unwrap();
        let assembler = Assembler {
            gpu,
            pass: &pipelines.assemble,
            task: Task::new(&Control::default(), &|_| {}),
        };
        let atlas = Atlas::new(assembler, &level.field, taps).unwrap();
        let canvas = Canvas::new(gpu, inputs.len() as u64).unwrap();
        let variant = Variant {
            mode: self.mode,
            operators: "".into(),
            taps,
            is_cut: true,
            has_low_pass: true,
            from_eye: false,
            has_holes: false,
            gathers: false,
        };
        let marches = pipelines.marches(gpu, variant).unwrap();
        let march = March {
            gpu,
            pipelines: &pipelines,
            marches: &marches,
            mode: self.mode,
            atlas: &atlas,
            canvas: &canvas,
            picture: Picture {
                view: &view,
                level,
                settings: &self.settings,
                voxel: 1.0,
                unit_distance: 1.0,
                effects: &Effects::default(),
            },
            voxels: None,
            share: [1.0, 0.0],
            settles: true,
        };
        let library = self.mode.library(false);
        let text = [
            &library,
            "@group(0) @binding(7) var<storage, read_write> colors: array<vec4<f32>>;",
            entry,
        ]
        .join("\n");
        let bound = march.bind(
            &march.data(),
            (inputs, &self.mode.look(level)),
            canvas.targets()[1],
        );
        gpu.queue
            .write_buffer(&bound.frame, 0, bytemuck::bytes_of(&march.data()));
        let probe = gpu
            .scoped(|gpu| {
                let mut constants = self.mode.constants(false);
                constants.push(("TAPS", f64::from(taps)));
                pipeline(&gpu.device, ("probe", &text), &pipelines.march_layout, &constants)
            })
            .unwrap();
        let mut commands = gpu.commands();
        {
            let mut pass = commands.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&probe);
            pass.set_bind_group(0, &bound.march, &[]);
            pass.dispatch_workgroups(inputs.len() as u32, 1, 1);
        }
        gpu.queue.submit([commands.finish()]);
        let mut found = Vec::new();
        pollster::block_on(canvas.read(gpu, |colors, _| found.extend_from_slice(colors))).unwrap();
        let facts = Facts {
            background: level.field.background(),
            table: level.table.clone(),
            spacing: view.spacing() as f32,
        };
        (found, facts)
    }
}

/// What tests need of a level.
struct Facts {
    background: f32,
    table: splatvol_core::shade_table::ShadeTable,
    spacing: f32,
}

/// An input of a probe: a vector and a number, in the fields `rest` and `low_pass`, and another vector in `step_x`.
fn input(rest: [f32; 3], step_x: [f32; 3], low_pass: f32) -> SheetData {
    SheetData {
        rest,
        step_x,
        low_pass,
        low_pass_points: 1,
        ..SheetData::zeroed()
    }
}
