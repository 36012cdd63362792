//! Pipelines: shaders, composed of parts, and the layouts of their bindings.

use crate::device::GpuDevice;
use crate::error::GpuError;

pub(crate) const FRAME: &str = include_str!("../shaders/frame.wgsl");
const CULL: &str = include_str!("../shaders/cull.wgsl");
pub(crate) const FIELD: &str = include_str!("../shaders/field.wgsl");
pub(crate) const SHADE: &str = include_str!("../shaders/shade.wgsl");
const MARCH: &str = include_str!("../shaders/march.wgsl");

/// The text of `cull`.
pub(crate) fn cull_shader() -> String {
    [FRAME, CULL].join("\n")
}

/// The text of `march`.
pub(crate) fn march_shader() -> String {
    [FRAME, FIELD, SHADE, MARCH].join("\n")
}

/// Passes, compiled.
#[derive(Debug)]
pub(crate) struct Pipelines {
    pub cull: wgpu::ComputePipeline,
    pub cull_layout: wgpu::BindGroupLayout,
    /// For four voxels along an axis, and for six.
    pub march: [wgpu::ComputePipeline; 2],
    pub march_layout: wgpu::BindGroupLayout,
    pub nearest: wgpu::Sampler,
}

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    }
}

fn buffer(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

const UNIFORM: wgpu::BufferBindingType = wgpu::BufferBindingType::Uniform;
const READ: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: true };
const WRITE: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: false };

impl Pipelines {
    /// Compiles all passes.
    ///
    /// # Errors
    /// A driver that refuses a shader.
    pub(crate) fn new(gpu: &GpuDevice) -> Result<Self, GpuError> {
        gpu.scoped(Self::compile).map_err(|error| GpuError::Shader {
            adapter: gpu.name.clone(),
            reason: error.to_string(),
        })
    }

    fn compile(gpu: &GpuDevice) -> Self {
        let device = &gpu.device;
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let cull_layout = layout(
            "cull",
            &[
                entry(0, buffer(UNIFORM)),
                entry(2, buffer(READ)),
                entry(3, buffer(WRITE)),
            ],
        );
        let atlas = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let march_layout = layout(
            "march",
            &[
                entry(0, buffer(UNIFORM)),
                entry(1, buffer(READ)),
                entry(2, buffer(READ)),
                entry(3, buffer(READ)),
                entry(4, atlas),
                entry(
                    5,
                    wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering),
                ),
                entry(6, buffer(READ)),
                entry(7, buffer(WRITE)),
                entry(8, buffer(WRITE)),
            ],
        );
        let march = [4.0, 6.0].map(|taps| {
            pipeline(
                device,
                ("march", &march_shader()),
                &march_layout,
                &[("TAPS", taps)],
            )
        });
        Self {
            cull: pipeline(device, ("cull", &cull_shader()), &cull_layout, &[]),
            cull_layout,
            march,
            march_layout,
            nearest: device.create_sampler(&wgpu::SamplerDescriptor::default()),
        }
    }
}

/// The pass of an entry point.
pub(crate) fn pipeline(
    device: &wgpu::Device,
    (name, text): (&str, &str),
    bindings: &wgpu::BindGroupLayout,
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &[Some(bindings)],
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(name),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(name),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants,
            zero_initialize_workgroup_memory: true,
        },
        cache: None,
    })
}
